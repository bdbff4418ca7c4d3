"""The scene file of what was made: as one would write it by hand, with the comments of the file that was opened."""

import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import tomlkit

from governor_mechanism.live.quantities import find_quantities
from governor_mechanism.scenes.changed_document import find_item, format_scene_toml


def write_scene(source: str, document: Mapping[str, Any]) -> str:
    """Return the text of the opened file with the changed values alone changed, or a text without comments where that is not possible."""
    with suppress(OSError, ValueError):
        text = Path(source).read_text(encoding="utf-8")
        changed = _change_text(text, document)
        if tomllib.loads(changed) == document:
            return changed
    return format_scene_toml(document)


def _change_text(text: str, document: Mapping[str, Any]) -> str:
    """Return a text of TOML with the quantities of a document."""
    written = tomlkit.parse(text)
    before = find_quantities(written.unwrap(), 1.0)
    for key, quantity in find_quantities(document, 1.0).items():
        if key in before and quantity.value != before[key].value:
            owner: Any = written
            *tables, last = key.split(".")
            for name in tables:
                owner = owner[_place_in(owner, name)]
            owner[_place_in(owner, last)] = quantity.write(quantity.value)
    return tomlkit.dumps(written)


def _place_in(owner: Any, name: str) -> str | int:
    """Return the key of a table, or the index in a list."""
    return name if isinstance(owner, Mapping) else find_item(owner, name, "")

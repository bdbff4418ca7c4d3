"""The option `--set`: a scene with other values at some of its keys, checked like a file.

Heavy imports are made when a command needs them.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

import governor_mechanism as gm

if TYPE_CHECKING:
    from governor_mechanism.model.scene import Scene

Changes = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help='Another value of a key of the scene, as "dimensions.arm=320 mm"; nothing after = leaves the key out. Repeatable.',
    ),
]


def load_changed(
    scene: str,
    changes: Sequence[str] | None,  # texts "KEY=VALUE" with dotted keys; an empty value leaves the key out
    **values: Any,
) -> Scene:
    """Load a scene and put other values at some of its keys.

    Further arguments are values at keys that have options of their own, with "__" for the dot, as `run__duration`; None for no change.

    Result: the scene. It keeps the name of its file. Raises MechanismError if a text is no assignment, a key
    is given twice, or the changed scene has mistakes.
    """
    assigned = parse_changes(changes or ())
    assigned |= {name.replace("__", "."): value for name, value in values.items() if value is not None}
    loaded = gm.load(scene)
    return dataclasses.replace(loaded.replace(assigned), source=loaded.source) if assigned else loaded


def parse_changes(
    # texts "KEY=VALUE". A value is written as in a scene file; text needs no quotation marks
    changes: Sequence[str],
) -> dict[str, Any]:
    """Return the values of assignments by key.

    Result: values by dotted key; None for an empty one. Raises MechanismError if a text is no assignment, or
    a key is given twice.
    """
    from governor_mechanism.errors import MechanismError

    values: dict[str, Any] = {}
    for change in changes:
        key, equals, text = (word.strip() for word in change.partition("="))
        if not equals or not all(key.split(".")):
            raise MechanismError(f'--set {change!r} is not understood; write KEY=VALUE, as in --set "dimensions.arm=320 mm"')
        if key in values:
            raise MechanismError(f"--set {key} is given twice; give it once")
        values[key] = parse_value(text) if text else None
    return values


def parse_value(text: str) -> Any:
    """Return a value as a scene file has it, or the text itself where that is no value of TOML, as 320mm.

    Result: number, text, true or false, list or table.
    """
    try:
        document: Mapping[str, Any] = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # text without quotation marks
        return text
    return document["value"] if len(document) == 1 else text

"""A scene document as the text of a scene file."""

import json
from collections.abc import Mapping
from typing import Any


def format_scene_toml(document: Mapping[str, Any], comment: str) -> str:
    """Return the document of a scene as the text of a TOML file that begins with a comment.

    Parameters
    ----------
    document
        The document of a scene.
    comment
        The first line.

    Returns
    -------
    str
        The text.
    """
    scalars = {key: value for key, value in document.items() if not isinstance(value, Mapping)}
    lines = [f"# {comment}", *(f"{key} = {_format_toml(value)}" for key, value in scalars.items())]
    for name, table in document.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *(f"{key} = {_format_toml(value)}" for key, value in table.items())]
    return "\n".join(lines) + "\n"


def _format_toml(value: Any) -> str:
    """Return a value as TOML, which writes all but tables as JSON does."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{key} = {_format_toml(item)}" for key, item in value.items()) + " }"
    return json.dumps(value, ensure_ascii=False)

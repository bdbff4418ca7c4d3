"""Data beside a module, in a TOML file of its name: scenes, changes of them, and numbers."""

import tomllib
from pathlib import Path
from typing import Any


def read_data(module: str) -> dict[str, Any]:
    """Return the tables and values beside a module, which gives its `__file__`."""
    return tomllib.loads(Path(module).with_suffix(".toml").read_text(encoding="utf-8"))

"""Printed and recomputed numbers, from one TOML file beside this module for each source; its arrays become tuples."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

from data_files import read_data


def read_value(value: Any) -> Any:
    """Return a value of a TOML file, with tuples for arrays and numbers for keys of digits."""
    if isinstance(value, dict):
        return {int(key) if key.isdigit() else key: read_value(entry) for key, entry in value.items()}
    return tuple(map(read_value, value)) if isinstance(value, list) else value


def read_numbers(name: str) -> Any:
    """Return the tables and values of a file as attributes."""
    return SimpleNamespace(**read_value(read_data(str(Path(__file__).with_name(name)))))


flywheel, hartung, marks, mechanisms, zehnder = map(read_numbers, ("flywheel", "hartung", "marks", "mechanisms", "zehnder"))
EQUILIBRIUM_TABLES = {table["title"]: table for table in vars(zehnder).values() if "title" in table}
"""The tables of pendulum governors by their titles."""

"""Values as JSON knows them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any


def plain_value(value: object) -> Any:
    """Return a value in the types of JSON.

    Parameters
    ----------
    value
        A number, text, path, array or dataclass, or a mapping or sequence of these.

    Returns
    -------
    Any
        Mappings and dataclasses as dicts, sequences as lists, complex numbers as pairs; None for NaN and infinities, which JSON lacks.
    """
    if hasattr(value, "tolist"):  # an array, or a number of NumPy
        value = value.tolist()
    if isinstance(value, complex):
        value = (value.real, value.imag)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, Mapping):
        return {key: plain_value(one) for key, one in value.items()}
    if is_dataclass(value):
        return {field.name: plain_value(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [plain_value(one) for one in value]
    return value


def format_json(value: object) -> str:
    """Return a value as JSON text, indented.

    Parameters
    ----------
    value
        A value that `plain_value` accepts.

    Returns
    -------
    str
        The text.
    """
    return json.dumps(plain_value(value), indent=2, allow_nan=False)

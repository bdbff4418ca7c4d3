"""Short `repr` of results: what an interactive session shows, without the numbers of long arrays."""

from collections.abc import Collection, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, Final

MAX_REPR_LENGTH: Final = 300
"""Largest length of a short text, characters: about three lines of a terminal."""

MAX_SHOWN_ITEMS: Final = 4
"""Largest number of items of a list, an array or a table that are shown one by one."""


def short_repr(value: object) -> str:
    """Return the name of a dataclass and its fields as short text; `__repr__ = short_repr` makes it the representation of a class."""
    start, texts = f"{type(value).__name__}(", list[str]()
    shown = [field.name for field in fields(value) if field.repr]  # type: ignore[arg-type]  # any dataclass
    remaining = MAX_REPR_LENGTH - len(start) - len(", ...)")
    for name in shown:
        text = f"{name}={summarise(getattr(value, name))}"
        if len(text) + 2 > remaining:
            return f"{start}{', '.join([*texts, '...'])})"
        remaining -= len(text) + 2
        texts.append(text)
    return f"{start}{', '.join(texts)})"


def summarise(value: Any) -> str:
    """Return a value of a result as short text."""
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, str):
        return repr(value if len(value) <= 60 else f"{value[:57]}...")
    if is_dataclass(value) and not isinstance(value, type):
        return f"{type(value).__name__}(...)"
    if hasattr(value, "shape"):
        return _summarise_array(value)
    if isinstance(value, Mapping):
        return _summarise_mapping(value)
    if isinstance(value, Collection):
        opening, closing = ("[", "]") if isinstance(value, list) else ("(", ")")
        has_few = len(value) <= MAX_SHOWN_ITEMS
        return f"{opening}{', '.join(map(summarise, value))}{closing}" if has_few else f"<{len(value)} items>"
    return "..." if len(text := repr(value)) > 60 or " at 0x" in text else text


def _summarise_array(array: Any) -> str:
    """Return the items of a short array, or the shape and the range of a long one."""
    if array.ndim <= 1 and array.size <= MAX_SHOWN_ITEMS:
        return f"[{', '.join(f'{item:.6g}' if array.dtype.kind == 'f' else str(item) for item in array.ravel().tolist())}]"
    size = "x".join(map(str, array.shape))
    return f"<{size}: {array.min():.6g} to {array.max():.6g}>" if array.dtype.kind in "if" and array.size else f"<{size} {array.dtype}>"


def _summarise_mapping(table: Mapping[Any, Any]) -> str:
    """Return the names of a mapping, with their values if they are numbers."""
    names = list(table)[:MAX_SHOWN_ITEMS]
    texts = [f"{name}: {table[name]:.6g}" if isinstance(table[name], float) else str(name) for name in names]
    return f"{{{', '.join([*texts, '...'] if len(table) > len(names) else texts)}}}"

"""Descriptions of arguments and results for the caller of kernels; caller.c says what the letters mean."""

from typing import Any

from numba import types

NUMBERS = {types.float64: "d", types.int64: "q", types.boolean: "b", types.none: "n"}


class UnknownTypeError(TypeError):
    """A type that the caller of kernels does not know."""


def argument_format(kind: Any) -> tuple[str, int]:
    """Return the description of an argument, and its number of slots."""
    if kind in NUMBERS:
        return NUMBERS[kind], 1
    if isinstance(kind, types.IntEnumMember) and kind.dtype == types.int64:
        return "q", 1
    if isinstance(kind, types.Array):
        return f"a{kind.ndim}{kind.layout}{_entry_format(kind.dtype)}", 5 + 2 * kind.ndim
    if isinstance(kind, types.Record):
        return f"r{kind.size};", 1
    if isinstance(kind, types.BaseTuple):
        parts = [argument_format(entry) for entry in kind]
        return f"({''.join(text for text, _ in parts)})", sum(n for _, n in parts)
    raise UnknownTypeError(f"an argument of type {kind}")


def _entry_format(kind: Any) -> str:
    if isinstance(kind, types.Record):
        return f"r{kind.size};"
    if kind == types.complex128:
        return "c"
    if kind in (types.float64, types.int64, types.boolean):
        return NUMBERS[kind]
    raise UnknownTypeError(f"an array of {kind}")


def result_format(kind: Any) -> tuple[str, list[type]]:
    """Return the description of a result, and the classes of its enums and named tuples."""
    if kind in NUMBERS:
        return NUMBERS[kind], []
    if isinstance(kind, types.IntEnumMember) and kind.dtype == types.int64:
        return "Eq", [kind.instance_class]
    if isinstance(kind, types.Array) and kind.layout == "C" and not isinstance(kind.dtype, types.Record):
        return f"a{kind.ndim}C{_entry_format(kind.dtype)}", []
    if isinstance(kind, types.BaseTuple) and not any(isinstance(entry, types.BaseTuple) for entry in kind):
        parts = [result_format(entry) for entry in kind]
        is_named = hasattr(kind, "instance_class")
        classes = [kind.instance_class] if is_named else []
        text = f"{'T' if is_named else ''}({len(parts)};{''.join(text for text, _ in parts)}"
        return text, classes + [one for _, inner in parts for one in inner]
    raise UnknownTypeError(f"a result of type {kind}")

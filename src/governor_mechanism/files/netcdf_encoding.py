"""The classic netCDF format with 64-bit offsets, as far as a run needs it: arrays of fixed size. scipy and xarray read it."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

MAGIC: Final = b"CDF\x02"

DIMENSIONS, VARIABLES, ATTRIBUTES = 10, 11, 12
"""Tags of lists."""

TYPES: Final = {"S1": (2, ">S1"), "i1": (1, ">i1"), "i2": (3, ">i2"), "i4": (4, ">i4"), "f4": (5, ">f4"), "f8": (6, ">f8")}
"""Numbers of the types, and types of numpy that are written, by kind and size of a value."""

MAX_STATED_SIZE: Final = 2**32 - 1
"""Largest size of a variable that its header can state, bytes; readers compute it anyway."""


class Variable(Protocol):
    """An array with its name, its dimensions and its attributes."""

    @property
    def name(self) -> str:
        """Name of ASCII letters."""

    @property
    def dimensions(self) -> tuple[str, ...]:
        """Names of its dimensions."""

    @property
    def values(self) -> NDArray[Any]:
        """Numbers, or letters as bytes."""

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Texts, or arrays of numbers, by name."""


def encode_netcdf(attributes: Mapping[str, Any], variables: Sequence[Variable]) -> bytes:
    """Return a file.

    Parameters
    ----------
    attributes
        Texts, or arrays of numbers, by name.
    variables
        Arrays of one of the types of the format; none has a dimension of size 0.

    Returns
    -------
    bytes
        Content of the file.
    """
    sizes: dict[str, int] = {}
    for variable in variables:
        sizes |= zip(variable.dimensions, variable.values.shape, strict=True)
    positions = {name: position for position, name in enumerate(sizes)}
    start = MAGIC + _number(0)  # no records: every dimension has a fixed size
    start += _list(DIMENSIONS, [_name(name) + _number(size) for name, size in sizes.items()]) + _encode_attributes(attributes)
    heads, contents = [], []
    for variable in variables:
        type_number, content = _encode_values(variable.values)
        dimensions = b"".join(_number(positions[name]) for name in variable.dimensions)
        head = _name(variable.name) + _number(len(variable.dimensions)) + dimensions + _encode_attributes(variable.attributes)
        heads.append(head + _number(type_number) + _number(min(len(content), MAX_STATED_SIZE)))
        contents.append(content)
    offsets = _find_offsets(len(start + _list(VARIABLES, heads)) + 8 * len(heads), map(len, contents))
    placed = [head + offset.to_bytes(8, "big") for head, offset in zip(heads, offsets, strict=True)]
    return b"".join([start, _list(VARIABLES, placed), *contents])


def _find_offsets(first: int, sizes: Iterable[int]) -> list[int]:
    """Return the offsets of contents that follow each other."""
    offsets = [first]
    for size in sizes:
        offsets.append(offsets[-1] + size)
    return offsets[:-1]


def _encode_attributes(attributes: Mapping[str, Any]) -> bytes:
    entries = []
    for name, value in attributes.items():
        values = np.frombuffer(value.encode(), dtype="S1") if isinstance(value, str) else np.atleast_1d(value)
        type_number, content = _encode_values(values)
        entries.append(_name(name) + _number(type_number) + _number(values.size) + content)
    return _list(ATTRIBUTES, entries)


def _encode_values(values: NDArray[Any]) -> tuple[int, bytes]:
    """Return the number of the type of an array, and its values."""
    number, kind = TYPES[values.dtype.str[1:]]
    return number, _pad(np.ascontiguousarray(values, dtype=kind).tobytes())


def _list(tag: int, entries: Sequence[bytes]) -> bytes:
    return b"".join([_number(tag if entries else 0), _number(len(entries)), *entries])


def _name(name: str) -> bytes:
    return _number(len(name)) + _pad(name.encode("ascii"))


def _number(value: int) -> bytes:
    return value.to_bytes(4, "big")


def _pad(content: bytes) -> bytes:
    """Return content that ends at a multiple of 4 bytes."""
    return content + bytes(-len(content) % 4)

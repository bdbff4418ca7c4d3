"""Named arrays with attributes as the bytes of a netCDF-3 file: scipy, which reads them, takes longer to import than a run takes."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_START: Final = b"CDF\x02"
"""Start of a file whose arrays may lie more than 2 GB behind it."""

_DIMENSIONS, _VARIABLES, _ATTRIBUTES = 10, 11, 12
"""Marks of the lists of a file."""

_TYPES: Final = {"b": (1, ">i1"), "S": (2, "S1"), "i": (4, ">i4"), "d": (6, ">f8")}
"""Number of a type in the file, and how it is written, by the type of numpy."""

_MAX_SIZE: Final = 2**32 - 1
"""What stands for the size of a larger array."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunVariable:
    """An array of a run."""

    name: str  # name of ASCII letters, digits and underscores
    dimensions: tuple[str, ...]  # names of the dimensions; none for a number
    values: NDArray[Any]  # numbers in SI, or texts
    attributes: Mapping[str, Any] = field(default_factory=dict)  # unit, long name, and links to other variables


def encode_netcdf(attributes: Mapping[str, str | NDArray[Any]], variables: Sequence[RunVariable]) -> bytes:
    """Return the bytes of a file of the classic netCDF format with 64-bit offsets.

    Parameters
    ----------
    attributes
        Attributes of the file: texts, or arrays of one dimension.
    variables
        Its arrays: of letters ("S1"), of integers of 8 or 32 bits, or of double precision.

    References
    ----------
    The NetCDF Classic Format Specification, Unidata, appendix B of the NetCDF Users Guide.
    """
    sizes: dict[str, int] = {}
    for variable in variables:
        sizes |= dict(zip(variable.dimensions, variable.values.shape, strict=True))
    dimensions = [_text(name) + _integer(size) for name, size in sizes.items()]
    before = _START + _integer(0) + _list(_DIMENSIONS, dimensions) + _encode_attributes(attributes)
    heads, arrays = [], []
    for variable in variables:
        number, content = _encode_values(variable.values)
        places = b"".join(_integer([*sizes].index(name)) for name in variable.dimensions)
        size = min(len(content), _MAX_SIZE).to_bytes(4, "big")
        start = _text(variable.name) + _integer(len(variable.dimensions)) + places
        heads.append(start + _encode_attributes(variable.attributes) + _integer(number) + size)
        arrays.append(content)
    offset_size = 8
    begin = len(before) + len(_list(_VARIABLES, heads)) + offset_size * len(heads)
    for k, content in enumerate(arrays):
        heads[k] += begin.to_bytes(offset_size, "big")
        begin += len(content)
    return b"".join([before, _list(_VARIABLES, heads), *arrays])


def _encode_attributes(attributes: Mapping[str, Any]) -> bytes:
    """Return a list of attributes."""
    entries = []
    for name, value in attributes.items():
        letters = np.frombuffer(value.encode(), dtype="S1") if isinstance(value, str) else value
        number, content = _encode_values(letters)
        entries.append(_text(name) + _integer(number) + _integer(letters.size) + content)
    return _list(_ATTRIBUTES, entries)


def _encode_values(values: NDArray[Any]) -> tuple[int, bytes]:
    """Return the number of the type of an array, and its values in whole words."""
    number, kind = _TYPES[values.dtype.char]
    return number, _fill_words(values.astype(kind).tobytes())


def _list(mark: int, entries: Sequence[bytes]) -> bytes:
    """Return a list with its mark and length; one without entries has no mark."""
    return b"".join([_integer(mark if entries else 0), _integer(len(entries)), *entries])


def _text(name: str) -> bytes:
    return _integer(len(name.encode())) + _fill_words(name.encode())


def _integer(value: int) -> bytes:
    return value.to_bytes(4, "big")


def _fill_words(content: bytes) -> bytes:
    """Return bytes, filled with zeros up to a whole number of words of four."""
    return content.ljust(4 * math.ceil(len(content) / 4), b"\0")

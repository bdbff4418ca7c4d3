"""Files of the classic netCDF format, written here because to import `scipy.io` takes longer than a run.

References
----------
Unidata, The NetCDF Classic Format Specification, with the offsets of 64 bits of its version 2.
"""

import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

TEXT_ENCODING: Final = "utf-8"

_MAGIC: Final = b"CDF\x02"

_N_RECORDS: Final = 0
"""No dimension can grow."""

_DIMENSIONS = 10
_VARIABLES = 11
_ATTRIBUTES = 12
"""Tags of the lists of a header."""

_TYPES: Final = {"b": 1, "S": 2, "i": 4, "d": 6}
"""Codes of the types of values by the letters of numpy."""

_FILL: Final = {"b": b"\x81", "S": b"\0", "i": b"\0", "d": b"\0"}
"""What fills the last four bytes of a variable, by the same letters."""

_LARGEST_SIZE: Final = 2**32 - 1
"""What stands for the size of a variable of 4 GB or more."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RunVariable:
    """An array of a run."""

    name: str  # name of ASCII letters, digits and underscores
    dimensions: tuple[str, ...]  # names of the dimensions; none for a number
    values: NDArray[Any]  # numbers in SI, or texts
    attributes: Mapping[str, Any] = field(default_factory=dict)  # unit, long name, and links to other variables


def encode_classic_netcdf(
    attributes: Mapping[str, str | NDArray[Any]],  # of the file
    variables: Iterable[RunVariable],  # of numbers or letters
) -> bytes:
    """Return attributes and arrays as a file; the arrays of the longest first dimension come first."""
    written = list(variables)
    dimensions = {name: size for one in written for name, size in zip(one.dimensions, one.values.shape, strict=True)}
    written.sort(key=lambda one: one.values.shape, reverse=True)
    contents = [_encode_values(one.values, _FILL[one.values.dtype.char]) for one in written]
    numbers = {name: number for number, name in enumerate(dimensions)}
    heads = [_variable_head(one, numbers, len(content)) for one, content in zip(written, contents, strict=True)]
    start = b"".join(
        (
            _MAGIC,
            struct.pack(">i", _N_RECORDS),
            _tagged(_DIMENSIONS, [_encode_name(name) + struct.pack(">i", size) for name, size in dimensions.items()]),
            _encode_attributes(attributes),
            struct.pack(">ii", _VARIABLES, len(written)),
        )
    )
    offset = len(start) + sum(len(head) + struct.calcsize(">q") for head in heads)
    parts = [start]
    for head, content in zip(heads, contents, strict=True):
        parts += [head, struct.pack(">q", offset)]
        offset += len(content)
    return b"".join((*parts, *contents))


def _variable_head(variable: RunVariable, numbers: Mapping[str, int], size: int) -> bytes:
    """Return what describes a variable, without the offset of its values."""
    dimensions = [numbers[name] for name in variable.dimensions]
    return b"".join(
        (
            _encode_name(variable.name),
            struct.pack(f">{1 + len(dimensions)}i", len(dimensions), *dimensions),
            _encode_attributes(variable.attributes),
            struct.pack(">iI", _TYPES[variable.values.dtype.char], min(size, _LARGEST_SIZE)),
        )
    )


def _encode_attributes(attributes: Mapping[str, str | NDArray[Any]]) -> bytes:
    return _tagged(_ATTRIBUTES, [_encode_name(name) + _encode_attribute(value) for name, value in attributes.items()])


def _encode_attribute(value: str | NDArray[Any]) -> bytes:
    """Return type, length and values of an attribute."""
    if isinstance(value, str):
        text = value.encode(TEXT_ENCODING)
        return struct.pack(">ii", _TYPES["S"], len(text)) + _filled(text)
    return struct.pack(">ii", _TYPES[value.dtype.char], value.size) + _encode_values(value)


def _encode_name(name: str) -> bytes:
    text = name.encode(TEXT_ENCODING)
    return struct.pack(">i", len(text)) + _filled(text)


def _encode_values(values: NDArray[Any], fill: bytes = b"\0") -> bytes:
    """Return values in the byte order of the format, the last of them first filled to four bytes."""
    return _filled(np.asarray(values, dtype=values.dtype.newbyteorder(">")).tobytes(), fill)


def _filled(content: bytes, fill: bytes = b"\0") -> bytes:
    return content + fill * (-len(content) % 4)


def _tagged(tag: int, items: list[bytes]) -> bytes:
    """Return a list of a header; an empty one has no tag."""
    return struct.pack(">ii", tag if items else 0, len(items)) + b"".join(items)

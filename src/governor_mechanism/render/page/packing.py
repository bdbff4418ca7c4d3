"""Numbers over time as short text: rounded to a quantum, then differences of neighbours, or of these, in few bits each.

A page decodes them with `decodeIntegers` in `script/decoding.js`.
"""

from base64 import b64encode
from typing import Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.types import FloatArray

Packed = int | str
"""Numbers of one channel in quanta: one integer if all are equal, else text."""

FORMATS: Final[dict[str, tuple[int, int]]] = {"a": (1, 7), "b": (2, 7), "c": (1, 3), "d": (2, 3)}
"""How often differences are taken, and bits in a group, by the first letter of a text."""

_MAX_QUANTA = 2**40
"""Largest magnitude (quanta) that is packed: a page computes with doubles, which hold integers up to 2^53."""


def pack_numbers(
    values: FloatArray,  # values; shape (n,)
    quantum: float,  # largest rounding error times two, in the unit of the values; positive
) -> Packed:
    """Return values as integers or text.

    Each value is rounded to the nearest multiple of the quantum. Of the integers, the first and then the differences of neighbours are
    written, or the same of these. Then 0, -1, 1, -2, 2, ... become 0, 1, 2, 3, 4, ...; each of these takes groups of 7 or 3 bits, the
    lowest first, with one more bit above, which tells that another group follows. A byte holds one group of 7 bits, or two of 3 bits, the
    first in its lower half; a half that is left over is 8. The bytes are written in base 64 after a letter of FORMATS, the one of the
    shortest text.

    Result: the integer that all values are rounded to, or text.
    """
    quanta = np.rint(np.clip(np.asarray(values, dtype=float) / quantum, -_MAX_QUANTA, _MAX_QUANTA)).astype(np.int64)
    if not quanta.size or (quanta == quanta[0]).all():
        return int(quanta[0]) if quanta.size else 0
    return min((_write_text(quanta, letter) for letter in FORMATS), key=len)


def _write_text(integers: NDArray[np.int64], letter: str) -> str:
    """Return integers in a format."""
    order, n_bits = FORMATS[letter]
    for _ in range(order):
        integers = np.diff(integers, prepend=0)
    codes = np.where(integers < 0, -2 * integers - 1, 2 * integers)
    groups = _split_into_groups(codes.tolist(), n_bits)
    if n_bits == 3:
        groups = [low | high << 4 for low, high in zip(groups[::2], [*groups[1::2], 8], strict=False)]
    return letter + b64encode(bytes(groups)).decode("ascii")


def _split_into_groups(codes: list[int], n_bits: int) -> list[int]:
    """Return integers of at least 0 as groups of bits, the lowest first, with a bit above that tells that another group follows."""
    groups = []
    follows = 1 << n_bits
    for code in codes:
        while code >= follows:
            groups.append(code % follows | follows)
            code >>= n_bits
        groups.append(code)
    return groups

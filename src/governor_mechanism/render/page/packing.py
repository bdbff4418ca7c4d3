"""Numbers over time as short text: rounded to a quantum, then differences of neighbours as base-128 numbers in base 64.

A page decodes them with `decodeNumbers` in `script/decoding.js`.
"""

from base64 import b64encode

import numpy as np

from governor_mechanism.types import FloatArray

Packed = int | str
"""Numbers of one channel in quanta: one integer if all are equal, else text."""

_MAX_QUANTA = 2**40
"""Largest magnitude (quanta) that is packed: a page computes with doubles, which hold integers up to 2^53."""


def pack_numbers(values: FloatArray, quantum: float) -> Packed:
    """Return values as integers or text.

    Each value is rounded to the nearest multiple of the quantum. Of the integers, the first and then the differences of neighbours are
    written; 0, -1, 1, -2, 2, ... become 0, 1, 2, 3, 4, ...; each of these takes groups of 7 bits, the lowest first, one in a byte, whose
    highest bit tells that another group follows; the bytes are written in base 64.

    Parameters
    ----------
    values
        Values; shape (n,).
    quantum
        Largest rounding error times two, in the unit of the values; positive.

    Returns
    -------
    int or str
        The integer that all values are rounded to, or text.
    """
    quanta = np.rint(np.clip(np.asarray(values, dtype=float) / quantum, -_MAX_QUANTA, _MAX_QUANTA)).astype(np.int64)
    if not quanta.size or (quanta == quanta[0]).all():
        return int(quanta[0]) if quanta.size else 0
    differences = np.diff(quanta, prepend=0)
    codes = np.where(differences < 0, -2 * differences - 1, 2 * differences)
    return b64encode(_write_groups(codes.tolist())).decode("ascii")


def _write_groups(codes: list[int]) -> bytes:
    """Return integers of at least 0 as groups of 7 bits."""
    content = bytearray()
    for code in codes:
        while code > 0x7F:
            content.append(code & 0x7F | 0x80)
            code >>= 7
        content.append(code)
    return bytes(content)

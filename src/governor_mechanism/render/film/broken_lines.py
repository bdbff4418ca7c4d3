"""Lines that pass boxes: where they are within them, and the pieces that are outside, as a draughtsman breaks a line at a word."""

import numpy as np

from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

Piece = tuple[Vec2, Vec2]
"""Both ends of a piece of a line, m."""
_MIN_STEP = 1e-12
"""Smallest extent (m) of a line along an axis: a shorter one is divided by this."""


def shares_within(starts: FloatArray, ends: FloatArray, boxes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shares of lines from starts (..., 2) to ends (..., 2) at which they enter and leave boxes (..., 4).

    A line passes its box if it enters it before it leaves it.
    """
    enters = np.zeros(np.broadcast_shapes(starts.shape[:-1], ends.shape[:-1], boxes.shape[:-1]))
    leaves = np.ones_like(enters)
    for axis in (0, 1):
        start, step = starts[..., axis], ends[..., axis] - starts[..., axis]
        step = np.where(np.abs(step) < _MIN_STEP, _MIN_STEP, step)
        first, second = ((boxes[..., 2 * axis + k] - start) / step for k in (0, 1))
        enters, leaves = np.maximum(enters, np.minimum(first, second)), np.minimum(leaves, np.maximum(first, second))
    return enters, leaves


def break_lines(start: Vec2, ends: FloatArray, boxes: FloatArray) -> list[tuple[Piece, ...]]:
    """Return the pieces of lines from a start to ends (f, 2) m outside of boxes (n, 4) m: equally many for each, some of them empty."""
    enters, leaves = shares_within(np.array(start), ends[:, None], boxes[None])
    is_passed = (enters < leaves).any(axis=0)
    enters, leaves = enters[:, is_passed], leaves[:, is_passed]
    return [_break_line(start, (x, y), gaps) for (x, y), gaps in zip(ends.tolist(), np.stack([enters, leaves], axis=-1), strict=True)]


def _break_line(start: Vec2, end: Vec2, gaps: FloatArray) -> tuple[Piece, ...]:
    """Return the pieces of a line without gaps (n, 2), whose ends are shares of the line; a gap that ends before it begins is none."""

    def point(share: float) -> Vec2:
        return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])

    pieces, reached = [], 0.0
    for enters, leaves in sorted(gaps.tolist()):
        if enters < leaves and leaves > reached:
            pieces.append((point(reached), point(max(enters, reached))))
            reached = leaves
    pieces.append((point(reached), end))
    return (*pieces, *[(end, end)] * (len(gaps) + 1 - len(pieces)))

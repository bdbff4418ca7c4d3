"""What is watched in a motion that sticks, strikes and goes slack: must not rise above nought; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.mechanics.contact.tolerances import STANDING
from governor_mechanism.mechanics.dynamics.lowering import ROUNDING
from governor_mechanism.mechanics.reduction.equation_of_motion import FLOWS, HELD, Line, drawn, gauge_at, resisting
from governor_mechanism.mechanics.reduction.lowering import FORCE, SECOND
from governor_mechanism.mechanics.reduction.table import piece_of
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray

QUIET = -1.0
"""The mark of what is not watched."""


@kernel
def marks_of(line: Line) -> int:
    """How many marks there are: of each keeper its rate, its high and its low stop; of each spring where it goes slack;
    the force that draws up, and down, against what holds."""
    return int(3 * line.keepers.shape[0] + line.springs.shape[0] + 2)


@kernel
def sided(line: Line, k: int, value: float, within: float) -> int:
    """At which of its stops, within so many of its sizes, a keeper is: 1 the high one, -1 the low one, 0 neither."""
    near = within * line.keepers[k, 5]
    if value >= line.keepers[k, 3] - near:
        return 1
    return -1 if value <= line.keepers[k, 2] + near else 0


@kernel
def blocked(line: Line, near: int, t: float) -> tuple[bool, bool]:
    """Whether stops keep the coordinate from rising, and from falling."""
    up = down = False
    for k in range(line.keepers.shape[0]):
        value, slope = gauge_at(line, near, t, line.keepers[k, 0])
        way = sided(line, k, value, STANDING) * slope
        up, down = up or way > 0.0, down or way < 0.0
    return up, down


@kernel
def marked(
    line: Line, q: float, v: float, since: float, near: int,
    marks: FloatArray,
) -> int:  # fmt: skip
    """Fill marks at a state; the piece it is on, or -1 where none is."""
    piece, t, side = piece_of(line.edges, line.beside, line.ring, q, near)
    if side >= 0:
        return -1
    marks[:] = QUIET
    keepers, springs = line.keepers.shape[0], line.springs.shape[0]
    if line.mode[HELD] != 0:
        flows = np.empty((1, FLOWS))
        force = drawn(line, piece, t, since, flows)
        resistance = resisting(line, piece, t, since)
        up, down = blocked(line, piece, t)
        if not up:
            marks[3 * keepers + springs] = force - resistance
        if not down:
            marks[3 * keepers + springs + 1] = -force - resistance
        return piece
    for k in range(keepers):
        value, slope = gauge_at(line, piece, t, line.keepers[k, 0])
        if line.mode[1 + k] != 0:
            marks[3 * k] = -line.mode[1 + k] * slope * v
        if line.keepers[k, 3] < math.inf:
            marks[3 * k + 1] = value - line.keepers[k, 3]
        if line.keepers[k, 2] > -math.inf:
            marks[3 * k + 2] = line.keepers[k, 2] - value
    for i in range(springs):
        off = gauge_at(line, piece, t, line.springs[i, 0])[0] - line.springs[i, 2]
        marks[3 * keepers + i] = -off if line.mode[1 + keepers + i] != 0 else off
    return piece


@kernel
def tiny_of(line: Line, tiny: FloatArray) -> None:
    """Fill what is rounding in each mark."""
    keepers, springs = line.keepers.shape[0], line.springs.shape[0]
    for k in range(keepers):
        size = ROUNDING * line.keepers[k, 5]
        tiny[3 * k], tiny[3 * k + 1], tiny[3 * k + 2] = size / line.numbers[SECOND], size, size
    for i in range(springs):
        tiny[3 * keepers + i] = ROUNDING * line.springs[i, 3]
    tiny[3 * keepers + springs] = tiny[3 * keepers + springs + 1] = ROUNDING * line.numbers[FORCE]

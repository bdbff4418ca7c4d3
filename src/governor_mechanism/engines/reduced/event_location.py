"""When within a step something watched rises above nought: looked for between its ends, found by shorter steps.

Compiled. What lies within a step is known to order 5 from its ends alone; where something crosses is found by steps
that end there, which are as exact as any other.
"""

from __future__ import annotations

import numpy as np

from governor_mechanism.engines.reduced.event_functions import marked
from governor_mechanism.integrators.event_location import summit
from governor_mechanism.integrators.reduced_dop853 import Stages, stepped
from governor_mechanism.mechanics.dynamics.output_forces import PARTS
from governor_mechanism.mechanics.reduction.equation_of_motion import Line
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import BoolArray, FloatArray, IntArray

HALVINGS = 40
"""So often is a time sought at which something that begins at nought is below it."""

JUST_ABOVE = 1e-300
"""A mark that counts as above nought."""

NUDGED = 1e-3
"""Of a bracket: a chord that meets nought nearer to an end is taken this far off it, so that the end comes nearer."""

NARROWED = 100
"""So many shorter steps find a crossing to rounding."""


@kernel
def crossing(
    line: Line,
    since: float,
    h: float,
    q: float,
    v: float,
    ahead: float,
    rate: float,
    near: int,
    stages: Stages,
    spare: Stages,
    marks: FloatArray,
    tiny: FloatArray,
    counts: IntArray,
) -> tuple[bool, float]:
    """Whether a mark rises above nought in a step, and after which part of it; marks[-1] are then those there.

    marks (PARTS, n) are known at the step's beginning. Something that begins at nought, as a body that has just left a
    stop, must have been below it first, unless it rises at once.
    """
    last = PARTS.size - 1
    for j in range(1, last):
        there, moving = _between(q, v, stages.bends[0], ahead, rate, stages.bends[12], h, PARTS[j])
        marked(line, there, moving, since + PARTS[j] * h, near, marks[j])
    marked(line, ahead, rate, since + h, near, marks[last])
    high, found = 2.0, np.empty(tiny.size)
    low = 0.0
    for i in range(tiny.size):
        armed = marks[0, i] < -tiny[i]
        for j in range(1, last + 1):
            if marks[j, i] > (0.0 if armed else tiny[i]):
                if PARTS[j] < high:
                    low, high = PARTS[j - 1], PARTS[j]
                break
            armed = armed or marks[j, i] < -tiny[i]
            if j == last or not armed:
                continue
            part, height = summit(PARTS[j], PARTS[1], marks[j - 1, i], marks[j, i], marks[j + 1, i])
            below_first = part > PARTS[j] or marks[j - 1, i] < -tiny[i]
            if height > 0.0 and part < high and below_first:
                _tried(line, since, part * h, q, v, near, stages, spare, found, counts)
                if found[i] > 0.0:
                    low, high = (PARTS[j - 1] if part <= PARTS[j] else PARTS[j]), part
                    break
    if high > 1.0:
        return False, 1.0
    _tried(line, since, high * h, q, v, near, stages, spare, found, counts)
    if not np.any(found > 0.0):
        if not np.any(marks[last] > tiny):
            return False, 1.0
        low, high, found[:] = high, 1.0, marks[last]
    return True, _narrowed(line, since, h, q, v, near, stages, spare, marks, tiny, counts,
                           low, high, found)  # fmt: skip


@kernel
def _narrowed(
    line: Line,
    since: float,
    h: float,
    q: float,
    v: float,
    near: int,
    stages: Stages,
    spare: Stages,
    marks: FloatArray,
    tiny: FloatArray,
    counts: IntArray,
    low: float,
    high: float,
    found: FloatArray,
) -> float:
    """The part of the step at which the first of the marks that are above nought at `high` rises above it.

    found are the marks there; marks[-1] becomes those just above nought.
    """
    last = PARTS.size - 1
    marks[last], rising = found, found > 0.0
    if low > 0.0:
        _tried(line, since, low * h, q, v, near, stages, spare, found, counts)
    else:
        found[:] = marks[0]
    part = high
    begun = _highest(found, rising)
    for halving in range(HALVINGS):
        if begun < 0.0 and not _unsure(found, rising, marks[0], tiny, halving > 0 or low > 0.0):
            break
        part *= 0.5  # it begins at nought, or above by rounding: it must have been below it in between
        _tried(line, since, part * h, q, v, near, stages, spare, found, counts)
        begun, low = _highest(found, rising), part
        if begun > 0.0:
            high, marks[last] = part, found
    else:
        for i in range(found.size):  # it rises at once
            marks[last, i] = max(found[i], JUST_ABOVE) if rising[i] else found[i]
        return part
    for i in range(found.size):
        if rising[i] and marks[last, i] > 0.0:  # else it rises later than what was found before it
            high = _root(line, since, h, q, v, near, stages, spare, marks[last], counts, i, low, high, found)
    return high


@kernel
def _root(
    line: Line, since: float, h: float, q: float, v: float, near: int, stages: Stages, spare: Stages, above: FloatArray,
    counts: IntArray, which: int, low: float, high: float, found: FloatArray,
) -> float:  # fmt: skip
    """The part just after which a mark rises above nought, from below it at `low`; above are the marks at `high`, and
    become those there."""
    _tried(line, since, low * h, q, v, near, stages, spare, found, counts)
    at_low, at_high, halve = min(found[which], -JUST_ABOVE), above[which], False
    for _ in range(NARROWED):
        width = high - low
        middle = 0.5 * (low + high) if halve else (low * at_high - high * at_low) / (at_high - at_low)
        middle = min(max(middle, low + NUDGED * width), high - NUDGED * width)
        if not low < middle < high or width <= 4e-16 * (high + abs(since / h)):
            break
        _tried(line, since, middle * h, q, v, near, stages, spare, found, counts)
        if found[which] > 0.0:
            high, at_high, above[:] = middle, found[which], found
        else:
            low, at_low = middle, min(found[which], -JUST_ABOVE)
        halve = high - low > 0.5 * width  # a chord that left most of the bracket is followed by a halving
    return high


@kernel
def _highest(found: FloatArray, rising: BoolArray) -> float:
    value = -np.inf
    for i in range(found.size):
        if rising[i]:
            value = max(value, found[i])
    return value


@kernel
def _unsure(found: FloatArray, rising: BoolArray, begin: FloatArray, tiny: FloatArray, later: bool) -> bool:
    """Whether a mark that rises in the step, and begins at nought but for rounding, has not been seen below that."""
    unsure = False
    for i in range(found.size):
        if rising[i] and begin[i] >= -tiny[i]:
            unsure = unsure or not later or found[i] >= min(begin[i], 0.0)
    return unsure


@kernel
def _tried(
    line: Line, since: float, h: float, q: float, v: float,
    near: int, stages: Stages, spare: Stages, found: FloatArray, counts: IntArray,
) -> None:  # fmt: skip
    """Fill found with the marks after a step from where another one begins; quiet where no piece is laid."""
    spare.rates[0], spare.bends[0] = stages.rates[0], stages.bends[0]
    spare.flows[0] = stages.flows[0]
    ahead, rate, piece, side = stepped(line, since, h, q, v, near, spare)
    counts[2] += 12
    found[:] = -1.0
    if side < 0:
        marked(line, ahead, rate, since + h, piece, found)


@kernel
def _between(
    q: float, v: float, bend: float, ahead: float, rate: float, bend_ahead: float, h: float, p: float
) -> tuple[float, float]:
    """Coordinate and rate within a step, by the polynomial of order 5 through both its ends."""
    speed, curve = h * v, h * h * bend
    way, faster, more = ahead - q - speed - 0.5 * curve, h * rate - speed - curve, h * h * bend_ahead - curve
    c3, c4, c5 = 10 * way - 4 * faster + 0.5 * more, -15 * way + 7 * faster - more, 6 * way - 3 * faster + 0.5 * more
    there = q + p * (speed + p * (0.5 * curve + p * (c3 + p * (c4 + p * c5))))
    return there, (speed + p * (curve + p * (3 * c3 + p * (4 * c4 + p * 5 * c5)))) / h

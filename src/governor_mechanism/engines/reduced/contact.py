"""What happens when something watched rises above nought: what strikes, sticks, slips, goes slack; compiled.

The rules are those of `switching`, for one coordinate: whatever holds, holds everything.
"""

from __future__ import annotations

import numpy as np

from governor_mechanism.engines.reduced.event_functions import blocked, sided
from governor_mechanism.mechanics.contact import tolerances as bouncing
from governor_mechanism.mechanics.contact.tolerances import SMALLEST_BOUNCE, STANDING, STILL, TOUCHING
from governor_mechanism.mechanics.reduction.equation_of_motion import (
    FLOWS,
    HELD,
    Line,
    drawn,
    gauge_at,
    pulled,
    resisting,
)
from governor_mechanism.mechanics.reduction.lowering import FORCE, SECOND, UNIT
from governor_mechanism.mechanics.reduction.node_evaluation import EASE
from governor_mechanism.mechanics.reduction.table import piece_of
from governor_mechanism.numerics.chebyshev import powers
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, IntArray

bounces_left = kernel(bouncing.bounces_left)

DOUBT = 1e-9
"""Of the scale of forces: what holding may be wrong by."""

STRIKES, STICKS, SLIPS, RESTS, LEAVES, SLACKENS, PULLS = range(7)
"""Kinds of events: (time, kind, keeper or spring)."""


@kernel
def tell(events: FloatArray, told: IntArray, time: float, kind: int, whom: int) -> None:
    """Note an event, while there is room."""
    if told[0] < events.shape[0]:
        events[told[0], 0], events[told[0], 1], events[told[0], 2] = time, kind, whom
    told[0] += 1


@kernel
def go_on(
    line: Line, time: float, since: float, near: int, fired: FloatArray,
    state: FloatArray, events: FloatArray, told: IntArray,
) -> None:  # fmt: skip
    """Change mode and state (coordinate, rate, flows) as what has fired (marks,) asks; all of it nought at a start."""
    piece, t, _ = piece_of(line.edges, line.beside, line.ring, state[0], near)
    keepers, springs = line.keepers.shape[0], line.springs.shape[0]
    was_held, rest_at = line.mode[HELD] != 0, np.full(keepers, time)
    _tighten(line, piece, t, state, time, events, told)
    line.mode[HELD] = 0
    _strike(line, piece, t, time, since, state, rest_at, events, told)
    force = 3 * keepers + springs
    let_go = was_held and (fired[force] > 0.0 or fired[force + 1] > 0.0)
    if abs(state[1]) <= STILL * line.numbers[UNIT] / line.numbers[SECOND]:
        way = _way_on(line, piece, t, since, let_go)
        line.mode[HELD] = 1 if way == 0 else 0
        state[1] = 0.0 if way == 0 else state[1]
        _slide(line, piece, t, float(way), fired, False)
    else:
        _slide(line, piece, t, state[1], fired, True)
    _compare(line, piece, t, was_held, line.mode[HELD] != 0, rest_at, events, told)


@kernel
def _tighten(
    line: Line, piece: int, t: float, state: FloatArray, time: float, events: FloatArray,
    told: IntArray,
) -> None:  # fmt: skip
    """One-sided springs that begin to pull, or go slack."""
    keepers = line.keepers.shape[0]
    for i in range(line.springs.shape[0]):
        value, slope = gauge_at(line, piece, t, line.springs[i, 0])
        off = value - line.springs[i, 2]
        at_it = abs(off) < TOUCHING * line.springs[i, 3]
        taut = slope * state[1] > 0.0 if at_it else off > 0.0
        if taut != (line.mode[1 + keepers + i] != 0):
            line.mode[1 + keepers + i] = 1 if taut else 0
            tell(events, told, time, PULLS if taut else SLACKENS, i)


@kernel
def _strike(
    line: Line, piece: int, t: float, time: float, since: float,
    state: FloatArray, rest_at: FloatArray, events: FloatArray, told: IntArray,
) -> None:  # fmt: skip
    """Throw back what runs into a stop; bounces that rise no more are over, and rest_at tells when."""
    struck, restitution = False, 1.0
    for k in range(line.keepers.shape[0]):
        value, slope = gauge_at(line, piece, t, line.keepers[k, 0])
        if sided(line, k, value, TOUCHING) * slope * state[1] > STILL * line.keepers[k, 5] / line.numbers[SECOND]:
            struck, restitution = True, min(restitution, line.keepers[k, 4])
            tell(events, told, time, STRIKES, k)
    if not struck:
        return
    before, flows = state[1], np.empty((1, FLOWS))
    state[1] = -restitution * before
    _oppose(line, piece, t, state[1])
    onward = pulled(line, piece, t, state[1], since, True, flows, 0)
    _oppose(line, piece, t, before)
    returning = pulled(line, piece, t, state[1], since, True, flows, 0)
    over = False
    for k in range(line.keepers.shape[0]):
        value, slope = gauge_at(line, piece, t, line.keepers[k, 0])
        side = sided(line, k, value, TOUCHING)
        away, back = -side * slope * state[1], side * slope * onward
        small = away * away < 2.0 * back * SMALLEST_BOUNCE * line.keepers[k, 5]
        if restitution < 1.0 and back > 0.0 and away > 0.0 and small:
            rest_at[k] = time + bounces_left(away, back, side * slope * returning, restitution)
            over = True
    if over:
        state[1] = 0.0
    lost = 0.5 * (before * before - state[1] * state[1]) / powers(line.table, piece, EASE, t)
    state[2] += lost
    state[3] += lost


@kernel
def _way_on(line: Line, piece: int, t: float, since: float, let_go: bool) -> int:
    """Which way the coordinate goes from rest: 1 up, -1 down, 0 none."""
    flows, tolerance = np.empty((1, FLOWS)), DOUBT * line.numbers[FORCE]
    force = drawn(line, piece, t, since, flows)
    resistance = resisting(line, piece, t, since)
    up, down = blocked(line, piece, t)
    holds = up or down
    for k in range(line.keepers.shape[0]):
        holds = holds or line.keepers[k, 1] >= 0
    kept_down = up or force <= resistance + tolerance
    kept_up = down or -force <= resistance + tolerance
    if holds and kept_down and kept_up and not let_go:
        return 0
    if force > 0.0:
        return 0 if up else 1
    return 0 if down else -1


@kernel
def _oppose(line: Line, piece: int, t: float, way: float) -> None:
    """Let friction oppose each reading as the coordinate goes that way."""
    for k in range(line.keepers.shape[0]):
        if line.keepers[k, 1] >= 0 and way != 0.0:
            slope = gauge_at(line, piece, t, line.keepers[k, 0])[1]
            line.mode[1 + k] = 1 if slope * way > 0.0 else -1


@kernel
def _slide(line: Line, piece: int, t: float, way: float, fired: FloatArray, turned: bool) -> None:
    """Which way friction opposes each reading; turned: one whose rate has passed nought goes the other way."""
    for k in range(line.keepers.shape[0]):
        before = line.mode[1 + k]
        line.mode[1 + k] = 0
        if line.keepers[k, 1] >= 0 and way != 0.0:
            slope = gauge_at(line, piece, t, line.keepers[k, 0])[1]
            line.mode[1 + k] = 1 if slope * way > 0.0 else -1
            if turned and fired[3 * k] > 0.0 and before != 0:
                line.mode[1 + k] = -before


@kernel
def _compare(
    line: Line, piece: int, t: float, was: bool, held: bool, rest_at: FloatArray, events: FloatArray,
    told: IntArray,
) -> None:  # fmt: skip
    """Tell what has begun or ceased to stand still: all that can hold."""
    for k in range(line.keepers.shape[0] if was != held else 0):
        value = gauge_at(line, piece, t, line.keepers[k, 0])[0]
        at_stop = sided(line, k, value, STANDING) != 0
        if at_stop:
            tell(events, told, rest_at[k], RESTS if held else LEAVES, k)
        elif line.keepers[k, 1] >= 0:
            tell(events, told, rest_at[k], STICKS if held else SLIPS, k)

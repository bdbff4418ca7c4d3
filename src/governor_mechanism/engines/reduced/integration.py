"""One coordinate taken through a stretch of time, by steps of DOP853, through all that happens on the way; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.engines.reduced.contact import go_on
from governor_mechanism.engines.reduced.event_functions import marked, marks_of, tiny_of
from governor_mechanism.engines.reduced.event_location import crossing
from governor_mechanism.integrators.projected_dop853 import CALM_STEPS, STABLE, STIFF_STEPS
from governor_mechanism.integrators.reduced_dop853 import (
    Stages,
    decay_of,
    error_of,
    gained,
    opened,
    plain_error,
    stepped,
    within,
)
from governor_mechanism.mechanics.dynamics.output_forces import PARTS
from governor_mechanism.mechanics.reduction.equation_of_motion import FLOWS, HELD, Line, accelerated
from governor_mechanism.mechanics.reduction.lowering import ENERGY, PLAIN, SECOND, UNEVEN, UNIT
from governor_mechanism.mechanics.reduction.table import piece_of
from governor_mechanism.numerics.jit import compiled
from governor_mechanism.types import FloatArray, IntArray

DONE, STALLED, EXHAUSTED, BELOW, ABOVE, STIFF = range(6)
"""How it ended: at the end; with steps or events that lead nowhere; with too many steps; where no piece is laid; where
it gets stiff."""

MOST_AT_ONCE = 40
"""So many things that happen at one time have no end."""

SAME_TIME = 1e-12
"""Of a time scale: what happens closer together happens at once."""

AFTER = 0.1
"""Of the longest step: how long the first one after an event is at most."""

STILL_LONGER = 8.0
"""So many times the longest step while nothing moves and forces change as programs do, not as an uneven spindle's."""

FARTHEST = 3.0
"""Of the coordinate's unit: a step that leads so far and beyond what is laid is tried shorter first."""

STEPS, REJECTED, EVALUATIONS, MOVING = range(4)
"""What is counted: MOVING are evaluations of what is not held."""


@compiled
def advance(
    line: Line,
    span: tuple[float, float],
    times: FloatArray,
    state: FloatArray,
    limits: tuple[float, float, float, int],
    stages: Stages,
    found: FloatArray,
    modes: IntArray,
    events: FloatArray,
    told: IntArray,
    counts: IntArray,
) -> tuple[int, float, int, float]:
    """Take `state` (coordinate, rate, flows) in place from span[0] to span[1] (s); fill found and modes at the times.

    limits: the error of one step, relative to the coordinate's unit and to that per time scale; first and longest step
    (s); most steps. The line's cubics are of the time since span[0]. told: how many events there are, how many of the
    last at one time. Returns how it ended, the last step (s), how many times were reached, the time (s) of state.
    """
    start, end = span
    tolerance, step, longest, most = limits
    now, reached, near = start, 0, 0
    rates, bends, flows, dense = stages.rates, stages.bends, stages.flows, stages.dense
    mode, plain, before_end, energy = line.mode, line.numbers[PLAIN] != 0.0, stages.last, line.numbers[ENERGY]
    unit, second, stiff, calm = line.numbers[UNIT], line.numbers[SECOND], 0, 0
    watching = line.keepers.shape[0] + line.springs.shape[0] > 0
    marks, tiny = np.full((PARTS.size, marks_of(line)), -1.0), np.empty(marks_of(line))
    tiny_of(line, tiny)
    spare = Stages(np.zeros(16), np.zeros(16), np.zeros((16, FLOWS)), np.zeros((2 + FLOWS, 7)), np.zeros(1))
    near, t, side = piece_of(line.edges, line.beside, line.ring, state[0], near)
    if side >= 0:
        return BELOW + side, step, reached, now
    bend = accelerated(line, near, t, state[1], 0.0, stages.flows, 0)
    if watching:
        marked(line, state[0], state[1], 0.0, near, marks[0])
    stages.rates[0], stages.bends[0] = state[1], bend
    while now < end:
        if counts[STEPS] + counts[REJECTED] >= most:
            return EXHAUSTED, step, reached, now
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return STALLED, step, reached, now
        patient = mode[HELD] != 0 and line.numbers[UNEVEN] == 0.0
        step = min(step, longest * (STILL_LONGER if patient else 1.0))
        last = now + step >= end
        h = end - now if last else step
        since, q, v = now - start, state[0], state[1]
        ahead, rate, piece, side = stepped(line, since, h, q, v, near, stages)
        counts[EVALUATIONS] += 12
        counts[MOVING] += 12 if mode[HELD] == 0 else 0
        if side >= 0 and abs(ahead - q) > FARTHEST * unit:  # before the step is known to be any good
            counts[REJECTED] += 1
            step = 0.25 * h
            continue
        if side >= 0:
            return BELOW + side, step, reached, now
        if plain:
            error = plain_error(rates, bends, unit, second, h)
        else:
            error = error_of(flows, rates, bends, unit, second, energy, h)
        error /= tolerance
        if not error <= 1.0:
            counts[REJECTED] += 1
            step = h * (max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1)
            continue
        counts[STEPS] += 1
        decay = 0.0
        if not plain:
            decay = decay_of(rates, bends, before_end, ahead, rate)
        crossed, later = False, end if last else now + h
        if watching:
            crossed, part = crossing(line, since, h, q, v, ahead, rate, near, stages, spare,
                                     marks, tiny, counts)  # fmt: skip
            if crossed:
                later = now + part * h if part < 1.0 else later
                h *= part
                ahead, rate, piece, side = stepped(line, since, h, q, v, near, stages)
        if reached < times.size and times[reached] <= later and h > 0.0:
            side = opened(line, since, h, q, v, ahead, rate, near, stages)
            counts[EVALUATIONS] += 3
            if side >= 0:
                return BELOW + side, step, reached, now
            while reached < times.size and times[reached] <= later:
                moment = (times[reached] - now) / h
                found[reached, 0], found[reached, 1] = (q + within(dense, 0, moment), v + within(dense, 1, moment))
                for c in range(0 if plain else FLOWS):
                    found[reached, 2 + c] = state[2 + c] + within(dense, 2 + c, moment)
                for c in range(mode.size if watching else 0):
                    modes[reached, c] = mode[c]
                reached += 1
        if not plain:
            for c in range(FLOWS):
                state[2 + c] += h * gained(flows[:, c])
                flows[0, c] = flows[12, c]
        state[0], state[1] = ahead, rate
        rates[0], bends[0] = rates[12], bends[12]
        near = piece
        if crossed:
            told[1] = told[1] + 1 if later - now <= SAME_TIME * second else 0
            if told[1] >= MOST_AT_ONCE:
                return STALLED, step, reached, now
            now = later
            go_on(line, now, now - start, near, marks[PARTS.size - 1], state, events, told)
            near, t, side = piece_of(line.edges, line.beside, line.ring, state[0], near)
            bend = accelerated(line, near, t, state[1], now - start, stages.flows, 0)
            rates[0], bends[0] = state[1], bend
            marked(line, state[0], state[1], now - start, near, marks[0])
            step = min(step, AFTER * longest)
            continue
        now = later
        if watching:
            marks[0] = marks[PARTS.size - 1]
        growth = min(6.0, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
        step = max(step, h * growth) if last else h * growth
        at_limit = not plain and mode[HELD] == 0 and h * decay > STABLE
        stiff, calm = (stiff + 1, 0) if at_limit else (stiff, calm + 1)
        if calm >= CALM_STEPS:
            stiff = 0
        if stiff >= STIFF_STEPS and now < end:
            return STIFF, step, reached, now
    return DONE, step, reached, now


@compiled
def resume(line: Line, time: float, state: FloatArray, events: FloatArray, told: IntArray) -> None:
    """Choose the mode at a start, and after a program's jump or kink; state is on a laid piece."""
    go_on(line, time, 0.0, 0, np.full(marks_of(line), -1.0), state, events, told)

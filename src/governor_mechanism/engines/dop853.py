"""DOP853 with error control for a mechanism's state, projected onto its joints at every accepted step; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.engines.dop853_tableau import (
    DENSE_NODES,
    DENSE_STAGES,
    DENSE_WEIGHTS,
    ERROR_3,
    ERROR_5,
    NODES,
    STAGES,
    WEIGHTS,
)
from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.motion import project, slope
from governor_mechanism.equations.points import Array, Whole
from governor_mechanism.equations.system import System, Workspace

DONE, STALLED, EXHAUSTED = 0, 1, 2
"""How an integration ends: at its end; with a step too short to matter; with too many steps."""

COUNTS = 4
"""Length of the counts: steps, rejected steps, evaluations, evaluations with joints that depend on each other."""


@compiled
def integrate(
    system: System,
    room: Workspace,
    speed: Array,
    span: tuple[float, float],
    times: Array,
    state: Array,
    scale: Array,
    tolerance: float,
    step: float,
    closed: float,
    most: int,
    found: Array,
    counts: Whole,
) -> tuple[int, float, int]:
    """Take `state` in place from span[0] to span[1] (s), and fill `found` at the `times` (n,) in between.

    tolerance is the error of one step, relative to `scale`. speed (4,) is the spindle's, a cubic of the time since
    span[0]. Returns how it ended, the last length of a step, and how many of the times were reached.
    """
    start, end = span
    slopes, trial, ahead = np.zeros((16, state.size)), np.empty(state.size), np.empty(state.size)
    dense = np.empty((7, state.size))
    _slope(system, room, speed, 0.0, state, slopes[0], counts)
    now, reached = start, 0
    while now < end:
        if counts[0] + counts[1] >= most:
            return EXHAUSTED, step, reached
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return STALLED, step, reached
        last = now + step >= end
        h = end - now if last else step
        for stage in range(1, 12):
            _combine(state, slopes, STAGES[stage], stage, h, trial)
            _slope(system, room, speed, now - start + NODES[stage] * h, trial, slopes[stage], counts)
        _combine(state, slopes, WEIGHTS, 12, h, ahead)
        _slope(system, room, speed, now - start + h, ahead, slopes[12], counts)
        error = _error(slopes, scale, h) / tolerance
        if not error <= 1.0:
            counts[1] += 1
            step = h * (max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1)
            continue
        counts[0] += 1
        after = end if last else now + h
        if reached < times.size and times[reached] <= after:
            for extra in range(3):
                _combine(state, slopes, DENSE_STAGES[extra], 13 + extra, h, trial)
                _slope(system, room, speed, now - start + DENSE_NODES[extra] * h, trial, slopes[13 + extra], counts)
            _prepare(state, ahead, slopes, h, dense)
            while reached < times.size and times[reached] <= after:
                _interpolate(state, dense, (times[reached] - now) / h, found[reached])
                _close(system, room, found[reached], closed)
                reached += 1
        state[:] = ahead
        now = after
        _close(system, room, state, closed)
        _slope(system, room, speed, now - start, state, slopes[0], counts)
        step = h * min(6.0, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
    return DONE, step, reached


@compiled
def _slope(
    system: System, room: Workspace, speed: Array, since: float, state: Array, result: Array, counts: Whole
) -> None:
    independent = slope(system, room, speed, since, state, result)
    counts[2] += 1
    if not independent:
        counts[3] += 1


@compiled
def _close(system: System, room: Workspace, state: Array, closed: float) -> None:
    count = system.mass.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    project(system, room, poses, velocities, closed)


@compiled
def _combine(state: Array, slopes: Array, weights: Array, stages: int, h: float, result: Array) -> None:
    for i in range(state.size):
        total = 0.0
        for k in range(stages):
            total += weights[k] * slopes[k, i]
        result[i] = state[i] + h * total


@compiled
def _error(slopes: Array, scale: Array, h: float) -> float:
    """The error of one step, as Hairer combines those of order 5 and 3."""
    fifth = third = 0.0
    for i in range(scale.size):
        five = three = 0.0
        for k in range(13):
            five += ERROR_5[k] * slopes[k, i]
            three += ERROR_3[k] * slopes[k, i]
        fifth += (five / scale[i]) ** 2
        third += (three / scale[i]) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * scale.size)


@compiled
def _prepare(state: Array, ahead: Array, slopes: Array, h: float, dense: Array) -> None:
    for i in range(state.size):
        change = ahead[i] - state[i]
        dense[0, i] = change
        dense[1, i] = h * slopes[0, i] - change
        dense[2, i] = 2.0 * change - h * (slopes[12, i] + slopes[0, i])
        for r in range(4):
            total = 0.0
            for k in range(16):
                total += DENSE_WEIGHTS[r, k] * slopes[k, i]
            dense[3 + r, i] = h * total


@compiled
def _interpolate(state: Array, dense: Array, part: float, result: Array) -> None:
    for i in range(state.size):
        total = 0.0
        for r in range(6, -1, -1):
            total = (total + dense[r, i]) * (part if r % 2 == 0 else 1.0 - part)
        result[i] = state[i] + total

"""DOP853 with error control for a mechanism's state, projected onto its joints at every accepted step; compiled."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.integrators.event_location import crossing, observed
from governor_mechanism.integrators.tableau import (
    DENSE_NODES,
    DENSE_STAGES,
    DENSE_WEIGHTS,
    ERROR_3,
    ERROR_5,
    NODES,
    STAGES,
    WEIGHTS,
)
from governor_mechanism.mechanics.dynamics.constraint_solver import along, give_back, solve
from governor_mechanism.mechanics.dynamics.equations_of_motion import close_joints, slope
from governor_mechanism.mechanics.dynamics.lowering import System, Workspace
from governor_mechanism.mechanics.dynamics.output_forces import PARTS
from governor_mechanism.numerics.jit import compiled, kernel
from governor_mechanism.types import FloatArray, IntArray

DONE, STALLED, EXHAUSTED, STIFF, CROSSED = 0, 1, 2, 3, 4
"""How an integration ends: at its end; with a step too short to matter; with too many steps; where it gets stiff; where
something watched rose above nought."""

SLOW_STEPS, SLOW = 2000, 1e-6
"""So many steps that together get no farther than this fraction of the way get nowhere."""

STABLE = 6.1
"""Step times largest rate of decay (Hairer's estimate) up to which the method is stable."""

NEARLY, WITHIN = 1e-3, 1e-6
"""Independence of the rows (see `schur.solve`) below which stages are closed first, and at which no stage is taken.

Off its joints by d, a mechanism an angle e away from a change point has accelerations wrong by d / e^3. So the motion
is stepped across it: a step begins so far before it that it falls into the widest gap between stages, and one with a
stage within is tried at another length.
"""

GAP = 0.466
"""The middle of the widest gap between stages, as a fraction of the step."""

AIMED = 0.1
"""Independence of the rows below which steps are aimed."""

FINER = 1e-3
"""So much tighter are joints closed near a change point: what they leave open counts there e times more."""

TRIES = 60
"""So many other lengths are tried."""

STIFF_STEPS, CALM_STEPS = 15, 6
"""So many steps at the limit of stability make a motion stiff, unless so many others come in between."""

STIFF_LEFT, STIFF_EACH = 300, 0.5
"""Fewer explicit steps than this, and for each number of the state so many more, are not worth implicit ones."""

COUNTS = 4
"""Length of the counts: steps, rejected steps, evaluations, evaluations with joints that depend on each other."""


@compiled
def integrate(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    span: tuple[float, float],
    times: FloatArray,
    state: FloatArray,
    scale: FloatArray,
    tolerance: float,
    step: float,
    longest: float,
    closed: float,
    most: int,
    found: FloatArray,
    counts: IntArray,
    crossed: FloatArray,
) -> tuple[int, float, int, float]:
    """Take `state` in place from span[0] to span[1] (s), and fill `found` at the `times` (n,) in between.

    tolerance is the error of one step, relative to `scale`; longest (s) bounds the step. cubics (programs, 4) are of
    the time since span[0]. Returns how it ended, the last length of a step, how many of the times were reached, and the
    time (s) that state is at. Where something watched crosses nought within a step, state is as before that step, and
    crossed (2,) holds the times (s) between which it does.
    """
    start, end = span
    slopes, trial, ahead = np.zeros((16, state.size)), np.empty(state.size), np.empty(state.size)
    last_stage = np.empty(state.size)
    dense = np.empty((7, state.size))
    watched = _slope(system, room, cubics, 0.0, state, slopes[0], counts, closed) > 0.0  # else joints are redundant
    now, reached, stiff, calm, tries = start, 0, 0, 0, 0
    near = far = 1.0
    marked, marked_steps = start, counts[0]
    watching = system.watch.size > 0
    marks = np.empty((PARTS.size, system.watch.size))
    before, slopes_before = np.empty(state.size), np.empty(state.size)
    if watching:
        observed(system, room, cubics, 0.0, state, marks[0])
    while now < end:
        if counts[0] + counts[1] >= most:
            return EXHAUSTED, step, reached, now
        if step < 1e-13 * (end - start) or not math.isfinite(step):
            return STALLED, step, reached, now
        if counts[0] - marked_steps >= SLOW_STEPS:
            if now - marked < SLOW * (end - start):
                return STALLED, step, reached, now
            marked, marked_steps = now, counts[0]
        step = min(step, longest)
        last = now + step >= end
        h = end - now if last else step
        apart = near
        for stage in range(1, 12):
            _combine(state, slopes, STAGES[stage], stage, h, trial)
            since = now - start + NODES[stage] * h
            apart = min(apart, _slope(system, room, cubics, since, trial, slopes[stage], counts, closed))
        last_stage[:] = trial
        _combine(state, slopes, WEIGHTS, 12, h, ahead)
        apart = min(apart, _slope(system, room, cubics, now - start + h, ahead, slopes[12], counts, closed))
        if watched and apart < WITHIN and tries < TRIES:
            tries += 1
            counts[1] += 1
            step = h * (0.83 if tries % 8 else 3.1)  # shorter and shorter, then longer again
            continue
        error = _error(system, room, slopes, scale, h, watched and apart < NEARLY) / tolerance
        if not error <= 1.0:
            counts[1] += 1
            step = h * (max(0.2, 0.9 * error**-0.125) if math.isfinite(error) else 0.1)
            continue
        counts[0] += 1
        tries = 0
        after = end if last else now + h
        earlier, reached_before = now, reached
        if reached < times.size and times[reached] <= after:
            for extra in range(3):
                _combine(state, slopes, DENSE_STAGES[extra], 13 + extra, h, trial)
                _slope(
                    system,
                    room,
                    cubics,
                    now - start + DENSE_NODES[extra] * h,
                    trial,
                    slopes[13 + extra],
                    counts,
                    closed,
                )
            _prepare(state, ahead, slopes, h, dense)
            while reached < times.size and times[reached] <= after:
                _interpolate(state, dense, (times[reached] - now) / h, found[reached])
                _close(system, room, cubics, times[reached] - start, found[reached], closed)
                reached += 1
        at_limit = h * _decay(slopes, ahead, last_stage, scale) > STABLE
        if watching:
            before[:], slopes_before[:] = state, slopes[0]
        state[:] = ahead
        now = after
        _close(system, room, cubics, now - start, state, closed if apart > NEARLY else FINER * closed)
        far, near = near, _slope(system, room, cubics, now - start, state, slopes[0], counts, closed)
        if watching:
            observed(system, room, cubics, now - start, state, marks[PARTS.size - 1])
            low, high = crossing(
                system,
                room,
                cubics,
                earlier - start,
                h,
                before,
                slopes_before,
                state,
                slopes[0],
                trial,
                last_stage,
                marks,
                counts,
            )
            if high <= 1.0:
                crossed[0], crossed[1] = earlier + low * h, earlier + high * h if high < 1.0 else now
                state[:] = before
                return CROSSED, h, reached_before, earlier
            marks[0] = marks[PARTS.size - 1]
        growth = min(6.0, max(0.3, 0.9 * max(error, 1e-30) ** -0.125))
        step = max(step, h * growth) if last else h * growth  # a last step may be cut to next to nothing
        stiff, calm = (stiff + 1, 0) if at_limit else (stiff, calm + 1)
        if calm >= CALM_STEPS:
            stiff = 0
        if watched and near < min(far, AIMED):
            step = _aimed(math.sqrt(near), math.sqrt(far), h, step)
        if stiff >= STIFF_STEPS and not watching and end - now > (STIFF_LEFT + STIFF_EACH * state.size) * h:
            return STIFF, step, reached, now
    return DONE, step, reached, now


@kernel
def _aimed(near: float, far: float, h: float, step: float) -> float:
    """The next step so that a change point lies in the gap between stages; near, far: angles from it, h apart."""
    away = near * h / (far - near)
    start = away - GAP * step
    if start > step:  # two steps or more away
        return step
    if start > 0.0:  # stop where the step after this one crosses it in its gap
        return max(start, 0.02 * step)
    return away / GAP if away > 0.1 * step else step


@kernel
def _slope(
    system: System,
    room: Workspace,
    cubics: FloatArray,
    since: float,
    state: FloatArray,
    result: FloatArray,
    counts: IntArray,
    closed: float,
) -> float:
    """The slope at a state, with joints closed first near a change point; how independent their rows are."""
    apart = slope(system, room, cubics, since, state, result)
    counts[2] += 1
    if 0.0 < apart < NEARLY:
        near = state.copy()
        _close(system, room, cubics, since, near, FINER * closed)
        apart = slope(system, room, cubics, since, near, result)
        counts[2] += 1
    if apart == 0.0:
        counts[3] += 1
    return apart


@kernel
def _close(system: System, room: Workspace, cubics: FloatArray, since: float, state: FloatArray, closed: float) -> None:
    count = system.bodies.size
    poses, velocities = state[: 3 * count].reshape(count, 3), state[3 * count : 6 * count].reshape(count, 3)
    close_joints(system, room, cubics, since, poses, velocities, closed)


@kernel
def _combine(
    state: FloatArray, slopes: FloatArray, weights: FloatArray, stages: int, h: float, result: FloatArray
) -> None:
    for i in range(state.size):
        total = 0.0
        for k in range(stages):
            total += weights[k] * slopes[k, i]
        result[i] = state[i] + h * total


@kernel
def _error(system: System, room: Workspace, slopes: FloatArray, scale: FloatArray, h: float, near: bool) -> float:
    """The error of one step, as Hairer combines those of order 5 and 3.

    Near a change point what opens joints is taken out of it first: the projection after the step does the same.
    """
    five, three = np.empty(scale.size), np.empty(scale.size)
    for i in range(scale.size):
        five[i] = three[i] = 0.0
        for k in range(13):
            five[i] += ERROR_5[k] * slopes[k, i]
            three[i] += ERROR_3[k] * slopes[k, i]
    if near:
        _take_out(system, room, five)
        _take_out(system, room, three)
    fifth = third = 0.0
    for i in range(scale.size):
        fifth += (five[i] / scale[i]) ** 2
        third += (three[i] / scale[i]) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return h * fifth / math.sqrt((fifth + 0.01 * third) * scale.size)


@kernel
def _take_out(system: System, room: Workspace, error: FloatArray) -> None:
    """Leave of an error in poses and velocities what opens no joint, at the poses last evaluated."""
    count = system.bodies.size
    for part in range(2):
        change = error[3 * count * part : 3 * count * (part + 1)].reshape(count, 3)
        along(system.rows.ends, room.gradient, change, room.vector)
        solve(room.band, room.factor, room.vector)
        give_back(system.rows.ends, room.gradient, system.inverse_mass, room.vector, change)


@kernel
def _decay(slopes: FloatArray, ahead: FloatArray, last_stage: FloatArray, scale: FloatArray) -> float:
    """The fastest rate (1/s) at which neighbouring motions come together, as the last two stages tell it."""
    slope = apart = 0.0
    for i in range(scale.size):
        slope += ((slopes[12, i] - slopes[11, i]) / scale[i]) ** 2
        apart += ((ahead[i] - last_stage[i]) / scale[i]) ** 2
    return math.sqrt(slope / apart) if apart > 0.0 else 0.0


@kernel
def _prepare(state: FloatArray, ahead: FloatArray, slopes: FloatArray, h: float, dense: FloatArray) -> None:
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


@kernel
def _interpolate(state: FloatArray, dense: FloatArray, part: float, result: FloatArray) -> None:
    for i in range(state.size):
        total = 0.0
        for r in range(6, -1, -1):
            total = (total + dense[r, i]) * (part if r % 2 == 0 else 1.0 - part)
        result[i] = state[i] + total

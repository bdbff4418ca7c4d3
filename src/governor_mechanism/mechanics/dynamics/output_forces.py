"""Loads along readings, and what is watched in a motion that sticks, strikes or goes slack, compiled."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.kinematics.constraint_kernels import OPENING, Rows, evaluate
from governor_mechanism.numerics.jit import kernel
from governor_mechanism.types import FloatArray, RecordArray

PULL, BRAKE, RUB = range(3)
"""Kinds of loads. Numbers: (rate, value at which it pulls nothing); (linear, quadratic); (sign of the sliding)."""

ACT = np.dtype([("kind", "i8"), ("gauge", "i8"), ("a", "f8"), ("b", "f8"), ("program", "i8")])
"""One load along a gauge: its kind and numbers, and the program of a friction, or -1."""

VALUE, RATE, FORCE = range(3)
"""What is watched: a gauge's value, its rate, or the force of the row that holds it."""

WATCH = np.dtype(
    [("kind", "i8"), ("at", "i8"), ("sign", "f8"), ("level", "f8"), ("tiny", "f8"), ("program", "i8"), ("about", "i8")]
)
"""One watch: sign * what is watched - level - program, which must not rise above nought. `at`: the gauge, or the row
that holds it; tiny: less than this is rounding; about: whom it concerns, for Python."""

spring_force = kernel(forces.spring_force)
brake_force = kernel(forces.brake_force)


@kernel
def _now(cubics: FloatArray, program: int, since: float) -> float:
    if program < 0:
        return 0.0
    a, b, c, d = cubics[program, 0], cubics[program, 1], cubics[program, 2], cubics[program, 3]
    return float(((a * since + b) * since + c) * since + d)


@kernel
def gauge_rate(gauges: Rows, gradient: FloatArray, k: int, velocities: FloatArray) -> float:
    """How fast a gauge's value changes; its gradient was evaluated."""
    rate = 0.0
    for side in range(2):
        body = gauges.ends[k, side]
        if body >= 0:
            for c in range(3):
                rate += gradient[k, side, c] * velocities[body, c]
    return rate


@kernel
def add_acts(
    gauges: Rows,
    acts: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    cubics: FloatArray,
    since: float,
    line: FloatArray,
    gradient: FloatArray,
    result: FloatArray,
) -> float:
    """Add the generalised forces (bodies, 3) of all loads along gauges; the power (W) that brakes and friction take."""
    if acts.size == 0:
        return 0.0
    evaluate(gauges, poses, velocities, line, gradient)
    lost = 0.0
    for i in range(acts.size):
        act = acts[i]
        k = act.gauge
        if act.kind == PULL:
            force = -spring_force(act.a, act.b, line[k, OPENING])
        else:
            rate = gauge_rate(gauges, gradient, k, velocities)
            pull = brake_force(act.a, act.b, rate) if act.kind == BRAKE else act.a * _now(cubics, act.program, since)
            force = -pull
            lost -= force * rate
        for side in range(2):
            body = gauges.ends[k, side]
            if body >= 0:
                for c in range(3):
                    result[body, c] += force * gradient[k, side, c]
    return lost


@kernel
def observe(
    gauges: Rows,
    watch: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    cubics: FloatArray,
    since: float,
    holding: FloatArray,
    line: FloatArray,
    gradient: FloatArray,
    marks: FloatArray,
) -> None:
    """Fill marks (watches,) at a state; holding is the vector that `motion.accelerations` left there."""
    evaluate(gauges, poses, velocities, line, gradient)
    for i in range(watch.size):
        one = watch[i]
        if one.kind == VALUE:
            seen = line[one.at, OPENING]
        elif one.kind == RATE:
            seen = gauge_rate(gauges, gradient, one.at, velocities)
        else:
            seen = -holding[one.at]
        marks[i] = one.sign * seen - one.level - _now(cubics, one.program, since)


PARTS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Of a step: where it is looked whether something watched rose above nought on the way."""


@kernel
def between(
    state: FloatArray,
    slopes: FloatArray,
    ahead: FloatArray,
    slopes_ahead: FloatArray,
    count: int,
    h: float,
    part: float,
    result: FloatArray,
) -> None:
    """A state within a step, of order 5 from both its ends; `count` coordinates, their speeds, and other numbers."""
    p = part
    for i in range(2 * count, state.size):
        result[i] = state[i] + p * (ahead[i] - state[i])
    for i in range(count):
        speed, bend = h * state[count + i], h * h * slopes[count + i]
        way = ahead[i] - state[i] - speed - 0.5 * bend
        faster = h * ahead[count + i] - speed - bend
        more = h * h * slopes_ahead[count + i] - bend
        c3, c4, c5 = (
            10 * way - 4 * faster + 0.5 * more,
            -15 * way + 7 * faster - more,
            6 * way - 3 * faster + 0.5 * more,
        )
        result[i] = state[i] + p * (speed + p * (0.5 * bend + p * (c3 + p * (c4 + p * c5))))
        result[count + i] = (speed + p * (bend + p * (3 * c3 + p * (4 * c4 + p * 5 * c5)))) / h

"""Loads along readings, and what is watched in a motion that sticks, strikes or goes slack, compiled."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.dynamics import force_laws as forces
from governor_mechanism.mechanics.kinematics.constraint_kernels import RESIDUAL, ConstraintRows, evaluate_rows
from governor_mechanism.numerics.jit import jit_internal
from governor_mechanism.types import FloatArray, RecordArray

SPRING_FORCE, DASHPOT_FORCE, FRICTION_FORCE = range(3)
"""Kinds of loads. Numbers: (rate, value at which it pulls nothing); (linear, quadratic); (sign of the sliding)."""

OUTPUT_FORCE_DTYPE = np.dtype([("kind", "i8"), ("output_index", "i8"), ("a", "f8"), ("b", "f8"), ("input_index", "i8")])
"""One load along a gauge: its kind and numbers, and the program of a friction, or -1."""

VALUE_EVENT, RATE_EVENT, FORCE_EVENT = range(3)
"""What is watched: a gauge's value, its rate, or the force of the row that holds it."""

EVENT_FUNCTION_DTYPE = np.dtype(
    [
        ("kind", "i8"),
        ("source_index", "i8"),
        ("sign", "f8"),
        ("threshold", "f8"),
        ("tolerance", "f8"),
        ("input_index", "i8"),
        ("contact_index", "i8"),
    ]
)
"""One watch: sign * what is watched - level - program, which must not rise above nought. `at`: the gauge, or the row
that holds it; tiny: less than this is rounding; about: whom it concerns, for Python."""

spring_force_jit = jit_internal(forces.spring_force)
dashpot_force_jit = jit_internal(forces.dashpot_force)


@jit_internal
def _evaluate_input(input_cubics: FloatArray, input_index: int, local_time: float) -> float:
    if input_index < 0:
        return 0.0
    a, b, c, d = (input_cubics[input_index, 0], input_cubics[input_index, 1], input_cubics[input_index, 2], input_cubics[input_index, 3])
    return float(((a * local_time + b) * local_time + c) * local_time + d)


@jit_internal
def output_rate(output_rows: ConstraintRows, jacobian: FloatArray, k: int, velocities: FloatArray) -> float:
    """How fast a gauge's value changes; its gradient was evaluated."""
    rate = 0.0
    for side in range(2):
        body = output_rows.row_bodies[k, side]
        if body >= 0:
            for c in range(3):
                rate += jacobian[k, side, c] * velocities[body, c]
    return rate


@jit_internal
def add_output_forces(
    output_rows: ConstraintRows,
    output_forces: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    row_values: FloatArray,
    jacobian: FloatArray,
    result: FloatArray,
) -> float:
    """Add the generalised forces (bodies, 3) of all loads along gauges; the power (W) that brakes and friction take."""
    if output_forces.size == 0:
        return 0.0
    evaluate_rows(output_rows, poses, velocities, row_values, jacobian)
    dissipated_power = 0.0
    for i in range(output_forces.size):
        output_force = output_forces[i]
        k = output_force.output_index
        if output_force.kind == SPRING_FORCE:
            force = -spring_force_jit(output_force.a, output_force.b, row_values[k, RESIDUAL])
        else:
            rate = output_rate(output_rows, jacobian, k, velocities)
            resistance = (
                dashpot_force_jit(output_force.a, output_force.b, rate)
                if output_force.kind == DASHPOT_FORCE
                else output_force.a * _evaluate_input(input_cubics, output_force.input_index, local_time)
            )
            force = -resistance
            dissipated_power -= force * rate
        for side in range(2):
            body = output_rows.row_bodies[k, side]
            if body >= 0:
                for c in range(3):
                    result[body, c] += force * jacobian[k, side, c]
    return dissipated_power


@jit_internal
def evaluate_multibody_event_functions(
    output_rows: ConstraintRows,
    event_functions: RecordArray,
    poses: FloatArray,
    velocities: FloatArray,
    input_cubics: FloatArray,
    local_time: float,
    multipliers: FloatArray,
    row_values: FloatArray,
    jacobian: FloatArray,
    event_values: FloatArray,
) -> None:
    """Fill marks (watches,) at a state; holding is the vector that `motion.accelerations` left there."""
    evaluate_rows(output_rows, poses, velocities, row_values, jacobian)
    for i in range(event_functions.size):
        event_function = event_functions[i]
        if event_function.kind == VALUE_EVENT:
            value = row_values[event_function.source_index, RESIDUAL]
        elif event_function.kind == RATE_EVENT:
            value = output_rate(output_rows, jacobian, event_function.source_index, velocities)
        else:
            value = -multipliers[event_function.source_index]
        event_values[i] = (
            event_function.sign * value - event_function.threshold - _evaluate_input(input_cubics, event_function.input_index, local_time)
        )


EVENT_SAMPLE_FRACTIONS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
"""Of a step: where it is looked whether something watched rose above nought on the way."""


@jit_internal
def interpolate_quintic_hermite(
    state_start: FloatArray,
    derivative_start: FloatArray,
    state_end: FloatArray,
    derivative_end: FloatArray,
    n_coordinates: int,
    h: float,
    theta: float,
    result: FloatArray,
) -> None:
    """A state within a step, of order 5 from both its ends; `count` coordinates, their speeds, and other numbers."""
    p = theta
    for i in range(2 * n_coordinates, state_start.size):
        result[i] = state_start[i] + p * (state_end[i] - state_start[i])
    for i in range(n_coordinates):
        velocity_term, acceleration_term = (h * state_start[n_coordinates + i], h * h * derivative_start[n_coordinates + i])
        displacement = state_end[i] - state_start[i] - velocity_term - 0.5 * acceleration_term
        velocity_change = h * state_end[n_coordinates + i] - velocity_term - acceleration_term
        acceleration_change = h * h * derivative_end[n_coordinates + i] - acceleration_term
        c3, c4, c5 = (
            10 * displacement - 4 * velocity_change + 0.5 * acceleration_change,
            -15 * displacement + 7 * velocity_change - acceleration_change,
            6 * displacement - 3 * velocity_change + 0.5 * acceleration_change,
        )
        result[i] = state_start[i] + p * (velocity_term + p * (0.5 * acceleration_term + p * (c3 + p * (c4 + p * c5))))
        result[n_coordinates + i] = (velocity_term + p * (acceleration_term + p * (3 * c3 + p * (4 * c4 + p * 5 * c5)))) / h

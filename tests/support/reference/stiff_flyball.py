"""Problem A05 of the IFToMM library of computational benchmark problems in three coordinates.

The rods swing symmetrically by the angle `a` below the horizontal, the slider stands at the height `s`, and the shaft turns freely, so that
its angular momentum stays as it is. https://www.iftomm-multibody.org/benchmark, problem A05.
"""

import math

import numpy as np
from numba import njit
from scipy.integrate._ivp import dop853_coefficients

LENGTH, HINGE_OFFSET, HINGE_HEIGHT, GRAVITY = 1.0, 0.05, 1.0, 9.81
ROD_MASS, BALL_MASS, SLIDER_MASS = 0.3, 5.0, 3.0
STIFFNESS, DAMPING, FREE_LENGTH = 8e5, 4e4, 0.5
TRANSVERSE, AXIAL = 0.3 * (1 + 0.01**2) / 12, 0.3 * 0.01**2 / 6
"""Moments of inertia of a rod about its mass centre, kg m2: of a bar of 1 m with a square section of 10 mm."""
SHAFT_INERTIA, SLIDER_INERTIA = 5e-6, 0.005
START_ANGLE, START_HEIGHT, START_SPEED = np.deg2rad(30.0), 0.5, 2 * np.pi

MAX_STEP = 2.5e-4
"""Longest step, s: with twice as long ones the angles are 3e-13 off."""

SWING_INERTIA = 2 * (TRANSVERSE + ROD_MASS * LENGTH**2 / 4 + BALL_MASS * LENGTH**2)


@njit
def inertia(angle):
    """Return the moment of inertia about the shaft (kg m2) and its derivative by the angle."""
    c, s = np.cos(angle), np.sin(angle)
    rod, ball = HINGE_OFFSET + 0.5 * LENGTH * c, HINGE_OFFSET + LENGTH * c
    value = SHAFT_INERTIA + SLIDER_INERTIA + 2 * (TRANSVERSE * c**2 + AXIAL * s**2 + ROD_MASS * rod**2 + BALL_MASS * ball**2)
    derivative = 2 * (2 * (AXIAL - TRANSVERSE) * s * c - ROD_MASS * rod * LENGTH * s - 2 * BALL_MASS * ball * LENGTH * s)
    return value, derivative


@njit
def derivative(state):
    """Return the rates of angle, height and of their rates."""
    angle, height, angle_rate, height_rate = state[0], state[1], state[2], state[3]
    across, above = 0.5 * LENGTH * np.cos(angle), HINGE_HEIGHT - 0.5 * LENGTH * np.sin(angle) - height
    distance = np.hypot(across, above)
    by_angle = (-across * 0.5 * LENGTH * np.sin(angle) - above * 0.5 * LENGTH * np.cos(angle)) / distance
    by_height = -above / distance
    force = 2 * (STIFFNESS * (distance - FREE_LENGTH) + DAMPING * (by_angle * angle_rate + by_height * height_rate))
    value, slope = inertia(angle)
    speed = inertia(START_ANGLE)[0] * START_SPEED / value
    weight_moment = 2 * (0.5 * ROD_MASS + BALL_MASS) * LENGTH * GRAVITY * np.cos(angle)
    angle_acceleration = (0.5 * slope * speed**2 + weight_moment - force * by_angle) / SWING_INERTIA
    return np.array([angle_rate, height_rate, angle_acceleration, -GRAVITY - force * by_height / SLIDER_MASS])


@njit
def advance(state, duration, coefficients, weights):
    """Return the state after a duration, s, by equal steps of the method of Dormand and Prince of order 8."""
    n_steps = math.ceil(duration / MAX_STEP)
    h, rates = duration / n_steps, np.zeros((len(weights), len(state)))
    for _ in range(n_steps):
        for i in range(len(weights)):
            rates[i] = derivative(state + h * (coefficients[i] @ rates))
        state = state + h * (weights @ rates)
    return state


def solve(times):
    """Return the readings (name -> values) at times (n,) s from 0 s on, by explicit steps well below the limit of stability.

    With half the step the angles change by 1e-14, and scipy's solver with error control agrees to that.
    """
    coefficients, weights = (np.ascontiguousarray(one) for one in (dop853_coefficients.A[:12, :12], dop853_coefficients.B[:12]))
    states = [np.array([START_ANGLE, START_HEIGHT, 0.0, 0.0])]
    for duration in np.diff(times).tolist():
        states.append(advance(states[-1], duration, coefficients, weights))
    angle, height = np.array(states).T[:2]
    speed = inertia(START_ANGLE)[0] * START_SPEED / inertia(angle)[0]
    return {"slider_height": height, "rod_angle": -angle, "left_rod_angle": np.pi + angle, "spindle_speed": speed}

"""Problem A05 of the IFToMM library of computational benchmark problems in three coordinates, integrated by scipy.

The rods swing symmetrically by the angle `a` below the horizontal, the slider stands at the height `s`, and the shaft turns freely, so that
its angular momentum stays as it is. https://www.iftomm-multibody.org/benchmark, problem A05.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

LENGTH, HINGE_OFFSET, HINGE_HEIGHT, GRAVITY = 1.0, 0.05, 1.0, 9.81
ROD_MASS, BALL_MASS, SLIDER_MASS = 0.3, 5.0, 3.0
STIFFNESS, DAMPING, FREE_LENGTH = 8e5, 4e4, 0.5
TRANSVERSE, AXIAL = 0.3 * (1 + 0.01**2) / 12, 0.3 * 0.01**2 / 6
"""Moments of inertia of a rod about its mass centre, kg m2: of a bar of 1 m with a square section of 10 mm."""
SHAFT_INERTIA, SLIDER_INERTIA = 5e-6, 0.005
START_ANGLE, START_HEIGHT, START_SPEED = np.deg2rad(30.0), 0.5, 2 * np.pi

SWING_INERTIA = 2 * (TRANSVERSE + ROD_MASS * LENGTH**2 / 4 + BALL_MASS * LENGTH**2)


def inertia(angle):
    """Return the moment of inertia about the shaft (kg m2) and its derivative by the angle."""
    c, s = np.cos(angle), np.sin(angle)
    rod, ball = HINGE_OFFSET + 0.5 * LENGTH * c, HINGE_OFFSET + LENGTH * c
    value = SHAFT_INERTIA + SLIDER_INERTIA + 2 * (TRANSVERSE * c**2 + AXIAL * s**2 + ROD_MASS * rod**2 + BALL_MASS * ball**2)
    derivative = 2 * (2 * (AXIAL - TRANSVERSE) * s * c - ROD_MASS * rod * LENGTH * s - 2 * BALL_MASS * ball * LENGTH * s)
    return value, derivative


def derivative(time, state):
    """Return the rates of angle, height and of their rates."""
    angle, height, angle_rate, height_rate = state
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


def solve(times):
    """Return the readings (name -> values) at times (n,) s from 0 s on, by explicit steps at the limit of stability."""
    start = np.array([START_ANGLE, START_HEIGHT, 0.0, 0.0])
    solution = solve_ivp(derivative, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-13, atol=1e-14, max_step=5e-4)
    angle, height = solution.y[:2]
    speed = inertia(START_ANGLE)[0] * START_SPEED / inertia(angle)[0]
    return {"slider_height": height, "rod_angle": -angle, "left_rod_angle": np.pi + angle, "spindle_speed": speed}

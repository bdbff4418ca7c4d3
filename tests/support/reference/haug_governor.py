"""Haug's fly-ball governor with its speed control: a Lagrangian model in one coordinate, and numbers computed from it. SI units.

Source: the governor example of E. J. Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems (1989). Arms turn about the
top of the spindle, rods join their middles to the collar; both are massless. Two halves are equal, so that the arm angle theta from
the downward vertical is the one coordinate of the governor. With d(theta), the depth of the collar below the top:

    T = I theta'^2 / 2 + J omega^2 / 2      I = 2 (m L^2 + i) + M d'^2      J = J0 + 2 (m L^2 sin^2 theta + i)
    V = -2 m g L cos(theta) - M g d + k (d - d0)^2 / 2                     dashpot: -c d'^2 theta'
    I theta'' + I_theta theta'^2 / 2 + V_theta - J_theta omega^2 / 2 = -c d'^2 theta'
    J omega' + J_theta theta' omega = gain (0.05 m - y) + load(t)

The moment of inertia i of a ball is the same about every axis, so its kinetic energy of rotation is i (theta'^2 + omega^2) / 2.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from data_files import read_data

FloatArray = NDArray[np.float64]

TOP = 0.2
ARM, ROD, ROD_JOINT = 0.16, 0.10922, 0.08
BALL_MASS, BALL_INERTIA, COLLAR_MASS = 1.0, 0.1, 1.0
CONSTANT_INERTIA = 50.0 + 0.125
"""Spindle and collar about the spindle axis, kg m2."""
SPRING_RATE, FREE_LENGTH, DAMPING = 1000.0, 0.15, 30.0
GAIN, EQUILIBRIUM_HEIGHT = 7500.0, 0.05
"""Spindle torque in N m per metre of the collar below this height."""
LOAD, RAMP_START, RAMP_END = -25.0, 1.0, 2.0

PUBLISHED_EQUILIBRIUM_SPEEDS = {9.80: 11.017459, 9.81: 11.023079}
"""rad/s by gravity, to 8 digits."""

# Computed from the analytic derivatives with 40 digits, gravity 9.81 m/s2. The equilibrium stays where it is with another gain or damping.
EQUILIBRIUM_SPEEDS = {9.80: 11.0174591518004268, 9.81: 11.0230788711925389}
EIGENVALUES = (-0.133069225300007031 + 6.54079490981091078j, -0.687555147463590866)
"""1/s: one of the pair, and the real one."""
CRITICAL_GAIN = 10447.5728340793836
"""N: gain beyond which the pair is undamped, with DAMPING."""
CRITICAL_DAMPING = 21.5361025544672827
"""N s/m: damping below which the pair is undamped, with GAIN."""
CRITICAL_FREQUENCY = 6.55611854168137268
"""rad/s, of the undamped pair; the same at both limits."""

MOTION = read_data(__file__)["MOTION"]


def collar_depth(theta: FloatArray | complex) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the depth of the collar below the top and its first two derivatives by theta; real or complex."""
    sine, cosine = np.sin(theta), np.cos(theta)
    height = np.sqrt(ROD**2 - (ROD_JOINT * sine) ** 2)
    slope = -(ROD_JOINT**2) * sine * cosine / height
    curvature = -(ROD_JOINT**2 * (cosine**2 - sine**2) + slope**2) / height
    return ROD_JOINT * cosine + height, -ROD_JOINT * sine + slope, -ROD_JOINT * cosine + curvature


def load(time: float) -> float:
    """Return the load on the spindle, N m."""
    return LOAD * float(np.clip((time - RAMP_START) / (RAMP_END - RAMP_START), 0.0, 1.0))


def derivative(state: FloatArray, load_torque: float, gravity: float, gain: float = GAIN, damping: float = DAMPING) -> FloatArray:
    """Return the time derivative of theta, theta', omega and the spindle angle; real or complex."""
    theta, rate, omega = state[:3]
    depth, slope, curvature = collar_depth(theta)
    inertia = 2 * (BALL_MASS * ARM**2 + BALL_INERTIA) + COLLAR_MASS * slope**2
    spindle_inertia = CONSTANT_INERTIA + 2 * (BALL_MASS * (ARM * np.sin(theta)) ** 2 + BALL_INERTIA)
    spindle_slope = 2 * BALL_MASS * ARM**2 * np.sin(2 * theta)
    weight = 2 * BALL_MASS * gravity * ARM * np.sin(theta) - COLLAR_MASS * gravity * slope
    spring = SPRING_RATE * (depth - FREE_LENGTH) * slope
    moment = spindle_slope * omega**2 / 2 - weight - spring - damping * slope**2 * rate - COLLAR_MASS * slope * curvature * rate**2
    torque = gain * (EQUILIBRIUM_HEIGHT - (TOP - depth)) + load_torque
    return np.array([rate, moment / inertia, (torque - spindle_slope * rate * omega) / spindle_inertia, omega])


def equilibrium(gravity: float) -> FloatArray:
    """Return theta, theta' = 0 and omega of the equilibrium without load, where the spring is relaxed."""
    depth = TOP - EQUILIBRIUM_HEIGHT
    cosine = (depth**2 + ROD_JOINT**2 - ROD**2) / (2 * ROD_JOINT * depth)
    theta = np.arccos(cosine)
    slope = collar_depth(theta)[1]
    weight = 2 * BALL_MASS * gravity * ARM * np.sin(theta) - COLLAR_MASS * gravity * slope
    return np.array([theta, 0.0, np.sqrt(weight / (BALL_MASS * ARM**2 * np.sin(2 * theta)))])


def trajectory(
    times: FloatArray, gravity: float = 9.81, gain: float = GAIN, damping: float = DAMPING, tolerance: float = 1e-13
) -> dict[str, FloatArray]:
    """Return theta, omega, the spindle angle and the collar height y at increasing times, from the equilibrium at time 0.

    DOP853 with this relative tolerance (absolute a tenth of it) restarts at the kinks of the load.
    """
    state, pieces = np.append(equilibrium(gravity), 0.0), []
    kinks = [0.0, RAMP_START, RAMP_END, max(times[-1], RAMP_END) + 1e-9]
    for start, end in pairwise(kinks):
        precision = {"method": "DOP853", "rtol": tolerance, "atol": tolerance / 10, "dense_output": True}
        run = solve_ivp(lambda time, values: derivative(values, load(time), gravity, gain, damping), (start, end), state, **precision)
        state = run.y[:, -1]
        inside = times[(times >= start) & (times < end)]
        pieces += [run.sol(inside)] if inside.size else []
    theta, _, omega, spindle_angle = np.concatenate(pieces, axis=1)
    return {"theta": theta, "omega": omega, "spindle_angle": spindle_angle, "y": TOP - collar_depth(theta)[0]}

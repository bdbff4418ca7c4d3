"""Solutions of elementary motions, independent of the engines."""

import math
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from governor_mechanism.types import FloatArray

ODE_TOLERANCE = 1e-13
"""Relative tolerance of an integrated solution: near the rounding of double precision."""

Motion = tuple[FloatArray, FloatArray]
"""Values and rates (n,)."""


def linear_oscillation(times: FloatArray, start: float, rate: float, *, stiffness: float, damping: float = 0.0) -> Motion:
    """Return values and rates of x'' + damping x' + stiffness x = 0, for real or complex roots."""
    decay, discriminant = 0.5 * damping, complex(0.25 * damping**2 - stiffness)
    root = np.sqrt(discriminant)
    # The slow root as a quotient: as a difference it would cancel for strong damping.
    fast = -decay - root
    slow = stiffness / fast if fast else complex(-decay) + root
    if abs(fast - slow) == 0.0:
        grown = (start + (rate - fast * start) * times) * np.exp(fast * times)
        return grown.real, ((rate + fast * (rate - fast * start) * times) * np.exp(fast * times)).real
    slow_part = (rate - fast * start) / (slow - fast) * np.exp(slow * times)
    fast_part = (slow * start - rate) / (slow - fast) * np.exp(fast * times)
    return (slow_part + fast_part).real, (slow * slow_part + fast * fast_part).real


def pendulum_swing(times: FloatArray, amplitude: float, frequency: float) -> Motion:
    """Return angle from the vertical and rate of a pendulum released at an amplitude, rad; `frequency`, rad/s, is that of small swings."""
    modulus = math.sin(0.5 * amplitude)
    quarter = ellipk(modulus**2)
    # Whole periods are removed first: a large argument would lose digits inside the elliptic functions.
    phase = np.remainder(frequency * times, 4 * quarter) + quarter
    sine, cosine, _, _ = ellipj(phase, modulus**2)
    return 2 * np.arcsin(modulus * sine), 2 * frequency * modulus * cosine


def pendulum_period(amplitude: float, frequency: float) -> float:
    """Return the period, s, of such a swing."""
    return 4 * float(ellipk(math.sin(0.5 * amplitude) ** 2)) / frequency


def force_free_rotation(times: FloatArray, start: float, rate: float, inertia: Callable[[float], float]) -> Motion:
    """Return the angle and its rate of a crank without forces: inertia(angle) rate^2 is constant."""
    momentum = math.sqrt(inertia(start)) * rate

    def slope(time: float, angle: FloatArray) -> list[float]:
        return [momentum / math.sqrt(inertia(float(angle[0])))]

    found = integrate(slope, [start], times)[0]
    return found, np.array([slope(0.0, np.array([angle]))[0] for angle in found])


def integrate(slope: Callable[[float, FloatArray], list[float]], start: list[float], times: FloatArray) -> FloatArray:
    """Return the states (m, n) at times (n,) of an initial value problem that starts at time 0."""
    solved = solve_ivp(slope, (0.0, float(times[-1])), start, method="DOP853", t_eval=times, rtol=ODE_TOLERANCE, atol=1e-14)
    states: FloatArray = solved.y
    return states


def bouncing_fall(times: FloatArray, height: float, rate: float, restitution: float, gravity: float) -> Motion:
    """Return height and velocity of a weight above a stop at height 0."""
    values, rates = np.zeros_like(times), np.zeros_like(times)
    begin = 0.0
    while True:
        fall = (rate + math.sqrt(rate**2 + 2 * gravity * height)) / gravity
        inside = (times >= begin) & (times <= begin + fall)
        since = times[inside] - begin
        values[inside], rates[inside] = height + rate * since - 0.5 * gravity * since**2, rate - gravity * since
        begin, height, rate = begin + fall, 0.0, restitution * (gravity * fall - rate)
        if begin >= times[-1] or not rate > 1e-12:  # rests: what is left of the bounces is below rounding
            return values, rates


def rebounds_between_stops(times: FloatArray, gap: float, rate: float, restitution: float) -> Motion:
    """Return position and velocity between stops at 0 and `gap`, without forces, from the middle towards the upper one."""
    values, rates = np.zeros_like(times), np.zeros_like(times)
    begin, position = 0.0, 0.5 * gap
    while begin < times[-1]:
        travel = ((gap - position) if rate > 0 else -position) / rate
        inside = (times >= begin) & (times <= begin + travel)
        values[inside], rates[inside] = position + rate * (times[inside] - begin), rate
        begin, position, rate = begin + travel, gap if rate > 0 else 0.0, -restitution * rate
    return values, rates

"""Description of a hard case: a family of scenes over a hard parameter, and what may happen."""

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipj, ellipk

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.library import load_scene
from governor_mechanism.types import FloatArray

Document = dict[str, Any]
"""A scene as read from a scene file."""

Solution = Mapping[str, tuple[FloatArray, FloatArray]]
"""Values and rates (n,) of readings, SI."""


def default_engines(value: float) -> tuple[Engine, ...]:
    """Return every engine with its default settings; the value of the hard parameter does not matter."""
    return ReducedEngine(), MultibodyEngine(), ImpulseEngine()


@dataclass(frozen=True, kw_only=True)
class HardCase:
    """A family of scenes over a hard parameter."""

    name: str  # name on the command line, such as "dead-centre"
    title: str  # what is hard, as a line of text
    parameter: str  # the hard parameter with its unit, as a label
    values: tuple[float, ...]  # values of the hard parameter
    make_document: Callable[[float], Document]  # the scene at a value
    # the solution at a value and times (n,), s, independent of the engines; None: another engine is the
    # reference
    solve: Callable[[float, FloatArray], Solution] | None = None
    # outcomes, apart from the end of the duration, with which a run may end, and why
    named_ends: Mapping[Outcome, str] = field(default_factory=dict)
    refused_values: tuple[float, ...] = ()  # values at which the scene itself must be refused
    short_values: tuple[float, ...] = ()  # values of the short form of the study
    engines: Callable[[float], tuple[Engine, ...]] = default_engines  # the engines at a value


SAMPLES_PER_RUN = 100
"""Number of output intervals of a run."""

GRAVITY = 9.81
"""Gravity of all cases, m/s2."""


def run_table(duration: float) -> Document:
    """Return the table of a run of a duration, s."""
    return {"duration": duration, "output_interval": duration / SAMPLES_PER_RUN, "accuracy": 1e-6}


def slider_document(
    *,
    start: float,  # position at the start, m
    rate: float = 0.0,  # velocity at the start, m/s
    duration: float,  # duration, s
    effects: Mapping[str, Any],
    # speed, rad/s, of the spindle that the line turns with; None: the plane is fixed
    spindle_speed: float | None = None,
    vertical: bool = False,
) -> Document:
    """Return a weight of 1 kg on a straight line, with its position as the reading `position`."""
    turning = {} if spindle_speed is None else {"plane": "turning", "spindle": {"speed": spindle_speed}}
    return {
        "machine": "custom",
        "size": 1.0,
        "ground": {"O": [0.0, 0.0]},
        "body": [{"name": "weight", "mass": 1.0, "turns": False, "at": [0.0, start] if vertical else [start, 0.0]}],
        "joint": [{"type": "slider", "first": "ground.O", "second": "weight.origin", "angle": "90 deg" if vertical else 0.0}],
        "readings": {"position": {"y" if vertical else "x": "weight.origin"}},
        "effects": dict(effects),
        "start": {"position": start, "position_rate": rate},
        "run": run_table(duration),
        **turning,
    }


def rod(name: str, length: float, *, at: Sequence[float] = (0.0, 0.0), angle: float = 0.0, mass: float = 1.0) -> Document:
    """Return a uniform rod as a body, with its start at a point and its angle, rad."""
    return {"name": name, "mass": mass, "rod": {"length": length}, "at": list(at), "angle": angle}


def pin(first: str, second: str) -> Document:
    """Return a pin joint between two points."""
    return {"type": "pin", "first": first, "second": second}


def governor_document(
    *, ball_mass: float = 5.0, size: float = 1.0, spindle: Mapping[str, Any], start: Mapping[str, Any], duration: float
) -> Document:
    """Return a Porter governor with gravity and centrifugal load; `size` multiplies its lengths."""
    return {
        "machine": "pendulum_governor",
        "dimensions": {"arm": f"{0.3 * size!r} m", "offset": f"{0.04 * size!r} m", "ball_mass": ball_mass, "sleeve_mass": 20.0},
        "effects": {"gravity": GRAVITY, "centrifugal": True},
        "spindle": dict(spindle),
        "start": dict(start),
        "run": run_table(duration),
    }


def shipped_document(name: str, changes: Mapping[str, Any]) -> Document:
    """Return a shipped scene with changed values of its tables, by keys such as "effects.clearance"."""
    document: Document = copy.deepcopy(dict(load_scene(name).document))
    for key, value in changes.items():
        table, _, last = key.rpartition(".")
        document[table] = {**document[table], last: value}
    return document


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


def force_free_rotation(times: FloatArray, start: float, inertia: Callable[[float], float]) -> Motion:
    """Return the angle and its rate, 1 rad/s at first, of a crank without forces: inertia(angle) rate^2 is constant."""
    momentum = math.sqrt(inertia(start))

    def slope(time: float, angle: FloatArray) -> list[float]:
        return [momentum / math.sqrt(inertia(float(angle[0])))]

    found = integrate(slope, [start], times)[0]
    return found, np.array([slope(0.0, np.array([angle]))[0] for angle in found])


def integrate(slope: Callable[[float, FloatArray], list[float]], start: list[float], times: FloatArray) -> FloatArray:
    """Return the states (m, n) at times (n,) of an initial value problem that starts at time 0."""
    solved = solve_ivp(slope, (0.0, float(times[-1])), start, method="DOP853", t_eval=times, rtol=ODE_TOLERANCE, atol=1e-14)
    states: FloatArray = solved.y
    return states


def bouncing_fall(times: FloatArray, height: float, rate: float, restitution: float) -> Motion:
    """Return height and velocity of a weight above a stop at height 0."""
    values, rates = np.zeros_like(times), np.zeros_like(times)
    begin = 0.0
    while True:
        fall = (rate + math.sqrt(rate**2 + 2 * GRAVITY * height)) / GRAVITY
        inside = (times >= begin) & (times <= begin + fall)
        since = times[inside] - begin
        values[inside] = height + rate * since - 0.5 * GRAVITY * since**2
        rates[inside] = rate - GRAVITY * since
        begin = begin + fall
        height = 0.0
        rate = restitution * (GRAVITY * fall - rate)
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
        begin = begin + travel
        position = gap if rate > 0 else 0.0
        rate = -restitution * rate
    return values, rates

"""Linearisation of a scene about the steady state near its start."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Generic, TypeVar

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.part import FreeSpindle, Spindle
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.equilibria import Equilibrium, find_equilibria
from governor_mechanism.statics.equilibrium_speed import has_spindle_dependent_loads
from governor_mechanism.statics.first_order_system import FirstOrderSystem, Onset
from governor_mechanism.statics.linearisation import RATE_PREFIX, Linearisation
from governor_mechanism.statics.scene_dynamics import SceneDynamics
from governor_mechanism.statics.settled_state import NO_STEADY_STATE, settle
from governor_mechanism.statics.steady_state import SteadyState
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import parse_quantity
from governor_mechanism.units.short_repr import short_repr

TURNING_TOLERANCE = 1e-9
"""Rate of a reading, in its scale over the time scale, above which it turns steadily."""


def linearise_scene(
    scene: Scene,
    poses: FloatArray,  # assembled poses near the steady state; shape (bodies, 3)
    # their time derivatives, of which those of steadily turning shafts matter; shape (bodies, 3)
    velocities: FloatArray,
    # speed of the spindle, rad/s, or text with a unit; that of the scene if None
    spindle_speed: float | str | None = None,
) -> Linearisation:
    """Linearise a scene about the steady state near given poses.

    Inputs that vary with time have their last value.

    Result: linearised equations, eigenvalues and modes. Raises MechanismError if there is no steady state
    near the start, it is periodic, or it has no linear equations.
    """
    if spindle_speed is not None:
        speed, spindle = parse_quantity(spindle_speed, "angular_speed", "the spindle's speed"), scene.spindle
        given = replace(spindle, start_speed=speed) if isinstance(spindle, FreeSpindle) else Spindle(speeds=(speed,))
        scene = scene.with_changes(spindle=given)
    dynamics, state = settle(scene, poses, velocities)
    dynamics.move_reference(state.z)
    notes = dynamics.notes(state.z, state.rates)
    if dynamics.drop_quadratic_damping(state.z, state.rates):
        notes += ("quadratic damping has no effect on small motions about rest",)
    return _build_linearisation(dynamics, state, notes)


def linearise_from_start(
    scene: Scene,
    poses: FloatArray,  # initial poses; shape (bodies, 3)
    velocities: FloatArray,  # initial velocities; shape (bodies, 3)
    # speed of the spindle, rad/s, or text with a unit; the last of the scene if None
    spindle_speed: float | str | None = None,
) -> Linearisation:
    """Linearise a scene as `linearise_scene` does, about the equilibrium nearest to the start if it has one degree of freedom.

    Result: linearised equations, eigenvalues and modes.
    """
    if len(scene.parts) > 1:
        return linearise_scene(scene, poses, velocities, spindle_speed)
    speed = last_spindle_speed(scene) if spindle_speed is None else spindle_speed
    try:
        equilibria = find_equilibria(scene, speed)
    except MechanismError as error:  # there is none, or more degrees of freedom, or an unknown travel
        try:
            return linearise_scene(scene, poses, velocities, spindle_speed)
        except MechanismError as other_error:
            earlier_problems = error.problems if NO_STEADY_STATE in other_error.problems else ()
            raise MechanismError(*earlier_problems, *other_error.problems) from None
    start = float(evaluate_output_value(scene.part.mechanism, scene.part.mechanism.coordinate, poses))
    return linearise_scene(scene, poses_at(scene, min(equilibria, key=lambda one: abs(one.coordinate - start))), velocities, spindle_speed)


def poses_at(scene: Scene, equilibrium: Equilibrium) -> FloatArray:
    """Return the poses of all bodies of a scene at an equilibrium of its part, with the shaft of a free spindle.

    Result: poses, m and rad; shape (bodies, 3).
    """
    return np.concatenate([equilibrium.poses, np.zeros((len(scene.mechanism.bodies) - len(scene.part.mechanism.bodies), 3))])


def last_spindle_speed(scene: Scene) -> float | None:
    """Return the last given speed of the spindle, rad/s.

    Result: speed; None for a free spindle, or if the loads do not depend on it.
    """
    return scene.spindle.speeds[-1] if isinstance(scene.spindle, Spindle) and has_spindle_dependent_loads(scene) else None


def _build_linearisation(dynamics: SceneDynamics, state: SteadyState, notes: tuple[str, ...]) -> Linearisation:
    values, reading_rates = dynamics.readings(state.z), dynamics.reading_jacobian(state.z) @ state.rates
    readings, rates = {}, {}
    for name, value, rate in zip(dynamics.reading_names, values, reading_rates, strict=True):
        if abs(rate) * dynamics.time_scale > TURNING_TOLERANCE * dynamics.reading_scale(name):
            rates[name] = float(rate)
        else:
            readings[name] = float(value)
    rates |= {name: float(row @ state.rates) for name, row in dynamics.spindle_speed_rows().items()}
    positions = [dynamics.names[k] for k in state.positions]
    cyclic = [" + ".join(dynamics.names[k] for k in np.flatnonzero(direction)) for direction in state.cyclic.T]
    linearisation = Linearisation(
        **vars(state.first_order_system),
        readings=readings,
        rates=rates,
        state_names=(*positions, *(f"{RATE_PREFIX}{name}" for name in [*positions, *cyclic])),
        notes=notes,
        _dynamics=dynamics,
        _state=state,
    )
    if not np.all(np.isfinite(linearisation.matrix)):
        raise MechanismError("the steady state is a singular configuration, about which the mechanism cannot move freely")
    return linearisation


RELATIVE_TOLERANCE = 1e-12
"""Tolerance of the value at the limit, relative to the ends of its range."""


Linearised = TypeVar("Linearised", bound=FirstOrderSystem)


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityLimit(Result, Generic[Linearised]):
    """Limit of stability along one key of a scene.

    Attributes
    ----------
    key
        Key of the scene.
    unit
        Its SI unit.
    value
        Value at the limit, SI.
    frequency
        Frequency of the oscillation that begins there, rad/s; 0 if the motion diverges without oscillation.
    stable_below
        Whether the steady state is stable for smaller values.
    onset
        Whether the oscillations begin softly or hard.
    linearisation
        Linearised equations at the limit.
    """

    key: str
    unit: str
    value: float
    frequency: float
    stable_below: bool
    onset: Onset
    linearisation: Linearised

    __repr__ = short_repr


def find_stability_limit(
    linearise_at: Callable[[float], Linearised],
    low: float,  # one end of the range, SI
    high: float,  # the other end, SI
    *,
    key: str,
    unit: str,  # its SI unit
) -> StabilityLimit[Linearised]:
    """Return the limit of stability between two values of a parameter.

    Raises MechanismError if the scene is not stable at one end and unstable at the other, or has no steady
    state at a value.
    """
    from scipy.optimize import brentq  # slow to import

    linearise_at = cache(linearise_at)

    def growth_rate(value: float) -> float:
        """Return the largest real part, also if it is within its error."""
        try:
            linearisation = linearise_at(value)
        except MechanismError as error:
            raise MechanismError(*(f"{key} = {value:.6g} {unit}".strip() + f": {problem}" for problem in error.problems)) from error
        return linearisation.critical_real_part

    ends = {value: linearise_at(value) for value in (low, high)}
    rates = [end.growth_rate for end in ends.values()]
    if not rates[0] * rates[1] < 0.0:
        states = " and ".join(
            f"{end.stability} at {value:.6g} {unit}".strip() + f" (largest real part {end.growth_rate:.6g} 1/s)"
            for value, end in ends.items()
        )
        raise MechanismError(
            f"no limit of stability lies between the ends of {key}: it is {states}; give ends that are stable and unstable"
        )
    value = float(brentq(growth_rate, low, high, xtol=RELATIVE_TOLERANCE * max(abs(low), abs(high)), rtol=RELATIVE_TOLERANCE))
    linearisation = linearise_at(value)
    return StabilityLimit(
        key=key,
        unit=unit,
        value=value,
        frequency=linearisation.critical_frequency,
        stable_below=(rates[0] < 0.0) == (low < high),
        onset=linearisation.onset,
        linearisation=linearisation,
    )

"""At what speed a mechanism rests at a place: where one holds it at all, where it jumps, and what a caller may ask."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import output_springs_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import TURNING_PLANE, Scene
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, equilibrium_speed_slope_numerator
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_value, parse_quantity

REMOVABLE_SINGULARITY_TOLERANCE = 1e-8
"""rad, or machine sizes: so near a place where loads and spindle both let go, the curve is its limit there."""

ZERO_FORCE_RATIO = 1e-8
"""Of what the loads' force is beside it: so little of it is none."""

FOLD_MERGE_TOLERANCE = 2e-5
"""rad, or machine sizes: so near a place where loads and spindle both let go a fold is at it: rounding's cube root."""

PERIOD_END_TOLERANCE = 1e-7
"""rad, or machine sizes: what lies so near an end of a motion that comes round lies at it."""

MAX_ZERO_RUN = 2
"""So many values on which nothing rises or falls may be a fold; more are a stretch of it."""

MAX_RESISTANCE = 1e12
"""N, or N m: harder resists nothing; beyond it lies a slip of units."""


def has_equilibrium_speed(scene: Scene) -> bool:
    """Whether there are both, loads and a spindle's turning that could balance them."""
    return bool(has_spindle_dependent_loads(scene) and (scene.gravity or scene.part.mechanism.force_elements or output_springs_of(scene)))


def has_spindle_dependent_loads(scene: Scene) -> bool:
    """Whether a spindle's turning loads the mechanism."""
    return bool(scene.has_centrifugal and scene.part.plane == TURNING_PLANE)


def require_equilibrium_speed(scene: Scene) -> None:
    """Refuse a scene whose loads a spindle's speed cannot balance."""
    if not has_equilibrium_speed(scene):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity), and a "
            "plane that turns with the spindle; list them in the scene"
        )


def equilibrium_speed_squared(coefficients: PathCoefficients, coordinate_scale: float, extra_force: FloatArray | float = 0.0) -> FloatArray:
    """The square (n,) of the equilibrium speed under `more` force along the coordinate; -1 where turning does nothing.

    Where the loads let go together with the spindle, the limit: there it rests at every speed. unit is what a rad, or a
    machine size, of the coordinate is in SI.
    """
    load_force, spindle_gradient = (coefficients.potential_derivative + extra_force, coefficients.spindle_inertia_derivative)
    is_removable = (
        np.abs(load_force) <= REMOVABLE_SINGULARITY_TOLERANCE * coordinate_scale * np.abs(coefficients.potential_second_derivative)
    ) & (
        np.abs(spindle_gradient)
        <= REMOVABLE_SINGULARITY_TOLERANCE * coordinate_scale * np.abs(coefficients.spindle_inertia_second_derivative)
    )
    load_force, spindle_gradient = (
        np.where(is_removable, coefficients.potential_second_derivative, load_force),
        np.where(is_removable, coefficients.spindle_inertia_second_derivative, spindle_gradient),
    )
    return np.where(spindle_gradient != 0.0, 2 * load_force / np.where(spindle_gradient != 0.0, spindle_gradient, 1.0), -1.0)


def find_folds(reduction: SingleDofReduction, coefficients: PathCoefficients) -> tuple[tuple[float, float], ...]:
    """Coordinates and speeds where the equilibrium speed turns back: where V'' J' - V' J'' changes its sign."""
    speed_slope, speed_slope_scale = equilibrium_speed_slope_numerator(coefficients)
    has_speed = equilibrium_speed_squared(coefficients, reduction.coordinate_scale) > 0.0
    removable_points = [place for place, met in _find_spindle_gradient_zeros(reduction, coefficients) if met]
    folds = []
    for low, high in _sign_changes(np.where(np.abs(speed_slope) <= ASTATIC_TOLERANCE * speed_slope_scale, 0.0, speed_slope)):
        if not has_speed[low : high + 1].all():
            continue
        value = _find_root(
            lambda value: equilibrium_speed_slope_numerator(reduction.evaluate([value]))[0],
            coefficients.coordinate[low],
            coefficients.coordinate[high],
        )
        value = next((place for place in removable_points if abs(place - value) < FOLD_MERGE_TOLERANCE * reduction.coordinate_scale), value)
        local_coefficients = reduction.evaluate([value])
        speed_squared = float(equilibrium_speed_squared(local_coefficients, reduction.coordinate_scale)[0])
        if speed_squared > 0.0 and not _is_touching_pole(coefficients, local_coefficients, low, high, reduction.coordinate_scale):
            folds.append((value, float(np.sqrt(speed_squared))))
    return tuple(folds[k] for k in _without_periodic_duplicates(reduction, [value for value, _ in folds]))


def find_poles(reduction: SingleDofReduction, coefficients: PathCoefficients) -> tuple[float, ...]:
    """Coordinates where J' changes its sign while the loads pull: toward them the equilibrium speed grows without end."""
    poles = [place for place, met in _find_spindle_gradient_zeros(reduction, coefficients) if not met]
    return tuple(poles[k] for k in _without_periodic_duplicates(reduction, poles))


def _find_spindle_gradient_zeros(reduction: SingleDofReduction, coefficients: PathCoefficients) -> Iterator[tuple[float, bool]]:
    """Coordinates where J' changes its sign, and whether the loads let go there too."""
    for low, high in _sign_changes(coefficients.spindle_inertia_derivative):
        zero = _find_root(
            lambda value: reduction.evaluate([value]).spindle_inertia_derivative,
            coefficients.coordinate[low],
            coefficients.coordinate[high],
        )
        neighbouring_force = max(abs(coefficients.potential_derivative[low]), abs(coefficients.potential_derivative[high]))
        yield (zero, bool(abs(reduction.evaluate([zero]).potential_derivative[0]) <= ZERO_FORCE_RATIO * neighbouring_force))


def _is_touching_pole(
    coefficients: PathCoefficients, local_coefficients: PathCoefficients, low: int, high: int, coordinate_scale: float
) -> bool:
    """Whether J' only touches zero between two values while the loads pull: the curve goes up to no end and back."""
    neighbouring_gradient = max(abs(coefficients.spindle_inertia_derivative[low]), abs(coefficients.spindle_inertia_derivative[high]))
    has_load_force = abs(local_coefficients.potential_derivative[0]) > REMOVABLE_SINGULARITY_TOLERANCE * coordinate_scale * abs(
        local_coefficients.potential_second_derivative[0]
    )
    return bool(abs(local_coefficients.spindle_inertia_derivative[0]) <= ZERO_FORCE_RATIO * neighbouring_gradient and has_load_force)


def _sign_changes(values: FloatArray) -> Iterator[tuple[int, int]]:
    """Indices of neighbours of opposite sign, or of those around a zero or two."""
    significant = np.flatnonzero(values)
    for low, high in zip(significant[:-1].tolist(), significant[1:].tolist(), strict=True):
        if values[low] * values[high] < 0.0 and high - low - 1 <= MAX_ZERO_RUN:
            yield low, high


def _find_root(function: Callable[[float], FloatArray], low: float, high: float) -> float:
    return float(brentq(lambda at: float(function(at)[0]), low, high, xtol=1e-14, rtol=1e-14))


def _without_periodic_duplicates(reduction: SingleDofReduction, candidates: Sequence[float]) -> list[int]:
    """Which places lie in the travel; of a motion that comes round, what lies at both its ends once."""
    travel, tolerance = reduction.range_of_motion, PERIOD_END_TOLERANCE * reduction.coordinate_scale
    in_travel = [k for k, place in enumerate(candidates) if travel.low - tolerance < place < travel.high + tolerance]
    return [k for k in in_travel if not (travel.period and _is_near_any(candidates[k] + travel.period, candidates, tolerance))]


def _is_near_any(value: float, candidates: Sequence[float], tolerance: float) -> bool:
    return any(abs(value - other) < tolerance for other in candidates)


def validate_coordinate_values(reduction: SingleDofReduction, values: object) -> FloatArray:
    """Values (n,) of the leading coordinate as numbers in its travel. Raises MechanismError for anything else."""
    mechanism, travel = reduction.mechanism, reduction.range_of_motion
    try:
        given = np.asarray(values)
    except ValueError:  # rows of different lengths
        given = np.array([], dtype=object)
    coordinate_values = np.atleast_1d(given).astype(np.float64) if given.dtype.kind in "iuf" else np.array([np.nan])
    if coordinate_values.ndim != 1 or not coordinate_values.size or not np.all(np.isfinite(coordinate_values)):
        raise MechanismError(f"values of {mechanism.coordinate!r} must be a list of finite numbers in SI; got {format_value(values)}")
    unwrapped_values = travel.unwrap_values(coordinate_values)
    outside = unwrapped_values[~travel.contains(unwrapped_values)]
    if outside.size:
        low, high = (format_coordinate(reduction.scene, end) for end in travel.ends)
        location = f"{format_coordinate(reduction.scene, float(outside[0]))} ({outside[0]:.6g})"
        reason = travel.low_message if outside[0] <= travel.ends[0] else travel.high_message
        raise MechanismError(
            f"{mechanism.coordinate} = {location} lies outside the travel, {low} to {high} ({travel.ends[0]:.6g} to "
            f"{travel.ends[1]:.6g}): {reason}"
        )
    return unwrapped_values


def validate_resistance(mechanism: Mechanism, resistance: object, against: object) -> tuple[float, str]:
    """A resistance (N, or N m) at a reading, as a number and the reading's name. Raises MechanismError for others."""
    names = [reading.name for reading in mechanism.readings]
    if not isinstance(against, str):
        raise MechanismError(f"`against` must be the name of a reading; got {format_value(against)}; readings are {names}")
    is_angle = mechanism.reading(against).quantity == "angle"
    number = parse_quantity(resistance, "torque" if is_angle else "force", "the resistance")
    if number < 0:
        raise MechanismError(f"the resistance must not be negative; got {number:g}")
    if number > MAX_RESISTANCE:
        raise MechanismError(f"the resistance must be at most {MAX_RESISTANCE:g}; got {number:g}")
    return number, against


def format_coordinate(scene: Scene, value: float) -> str:
    """A value (SI) of the leading coordinate in everyday units."""
    mechanism = scene.part.mechanism
    return format_quantity(value, "rad" if mechanism.reading(mechanism.coordinate).quantity == "angle" else "m")


def evaluate_readings(mechanism: Mechanism, coefficients: PathCoefficients) -> dict[str, FloatArray]:
    """All readings (n,) SI; the leading coordinate counted on over turns, as the travel counts it."""
    readings = {one.name: evaluate_output_value(mechanism, one.name, coefficients.poses) for one in mechanism.readings}
    return readings | {mechanism.coordinate: coefficients.coordinate} if mechanism.coordinate in readings else readings

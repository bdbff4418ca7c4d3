"""Square of the equilibrium speed at a position, its folds and poles, and validation of arguments."""

from collections.abc import Callable, Iterator

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.contacts import output_forces_of
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, equilibrium_speed_slope_numerator
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.quantities import convert_texts, format_quantity, format_value, parse_quantity

REMOVABLE_SINGULARITY_TOLERANCE = 1e-8
"""Distance from a common zero of V' and J', relative to the scale of the coordinate, within which the limit V'' / J'' is used."""

ZERO_FORCE_RATIO = 1e-8
"""Force relative to neighbouring values below which it counts as zero."""

FOLD_MERGE_TOLERANCE = 2e-5
"""Distance of a fold from a common zero of V' and J', relative to the coordinate scale, within which they coincide.

It is the cube root of rounding.
"""

PERIOD_END_TOLERANCE = 1e-7
"""Distance from an end of a periodic travel, relative to the scale of the coordinate, within which a value is at the end."""

MAX_ZERO_RUN = 2
"""Largest number of successive zeros that can be a sign change; a longer run is a constant stretch."""

MAX_RESISTANCE = 1e12
"""Largest resistance, N or N m; a larger value is a mistake of units."""


def has_equilibrium_speed(scene: Scene) -> bool:
    """Return whether a scene has both loads and a spindle-dependent load that can balance them.

    Result: whether an equilibrium speed can exist.
    """
    has_springs = any(not effect.dissipates for effect in output_forces_of(scene))
    return has_spindle_dependent_loads(scene) and bool(scene.gravity or scene.part.mechanism.force_elements or has_springs)


def has_spindle_dependent_loads(scene: Scene) -> bool:
    """Return whether the loads of a scene depend on the spindle speed.

    Result: whether the plane turns and the centrifugal load is active.
    """
    return bool(scene.has_centrifugal and scene.part.plane == TURNING_PLANE)


def require_equilibrium_speed(scene: Scene) -> None:
    """Raise an error unless a spindle speed can balance the loads.

    Raises MechanismError if it cannot.
    """
    if not has_equilibrium_speed(scene):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity), and a "
            "plane that turns with the spindle; list them in the scene"
        )


def equilibrium_speed_squared(coefficients: PathCoefficients, coordinate_scale: float, extra_force: FloatArray | float = 0.0) -> FloatArray:
    """Return the squared equilibrium speed 2 (V' + extra_force) / J' (n,), rad2/s2; -1 where J' is zero.

    Where V' and J' vanish together, the result is the limit 2 V'' / J''. coordinate_scale is the scale of the coordinate in SI.
    """
    values = np.array([coefficients.potential_derivative + extra_force, coefficients.spindle_inertia_derivative])
    derivatives = np.array([coefficients.potential_second_derivative, coefficients.spindle_inertia_second_derivative])
    is_removable = np.all(np.abs(values) <= REMOVABLE_SINGULARITY_TOLERANCE * coordinate_scale * np.abs(derivatives), axis=0)
    force, gradient = np.where(is_removable, derivatives, values)
    speed_squared: FloatArray = np.divide(2 * force, gradient, out=np.full_like(gradient, -1.0), where=gradient != 0.0)
    return speed_squared


def evaluate_stability(coefficients: PathCoefficients, speed_squared: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the stiffness (n,) at squared spindle speeds (n,), rad2/s2, and where it is zero within rounding (astatic)."""
    load_stiffness, centrifugal_stiffness = coefficients.stiffness_terms(speed_squared)
    stiffness: FloatArray = load_stiffness + centrifugal_stiffness
    return stiffness, np.abs(stiffness) <= ASTATIC_TOLERANCE * (np.abs(load_stiffness) + np.abs(centrifugal_stiffness))


def find_folds(reduction: SingleDofReduction, coefficients: PathCoefficients) -> tuple[tuple[float, float], ...]:
    """Return coordinates and speeds at which the equilibrium speed has an extremum: V'' J' - V' J'' changes its sign."""
    speed_slope, speed_slope_scale = equilibrium_speed_slope_numerator(coefficients)
    has_speed = equilibrium_speed_squared(coefficients, reduction.coordinate_scale) > 0.0
    removable_points = [place for place, met in _find_spindle_gradient_zeros(reduction, coefficients) if met]
    folds = []
    for low, high in _sign_changes(np.where(np.abs(speed_slope) <= ASTATIC_TOLERANCE * speed_slope_scale, 0.0, speed_slope)):
        if not has_speed[low : high + 1].all():
            continue
        value = _find_root_between(reduction, coefficients, (low, high), lambda local: equilibrium_speed_slope_numerator(local)[0])
        value = next((place for place in removable_points if abs(place - value) < FOLD_MERGE_TOLERANCE * reduction.coordinate_scale), value)
        local_coefficients = reduction.evaluate([value])
        speed_squared = float(equilibrium_speed_squared(local_coefficients, reduction.coordinate_scale)[0])
        if speed_squared > 0.0 and not _is_touching_pole(coefficients, local_coefficients, low, high, reduction.coordinate_scale):
            folds.append((value, float(np.sqrt(speed_squared))))
    tolerance = PERIOD_END_TOLERANCE * reduction.coordinate_scale
    return tuple(folds[k] for k in reduction.range_of_motion.find_distinct([(value, value) for value, _ in folds], tolerance))


def find_poles(reduction: SingleDofReduction, coefficients: PathCoefficients) -> tuple[float, ...]:
    """Return coordinates at which J' changes its sign while V' is not zero: the equilibrium speed tends to infinity there."""
    poles = [place for place, met in _find_spindle_gradient_zeros(reduction, coefficients) if not met]
    tolerance = PERIOD_END_TOLERANCE * reduction.coordinate_scale
    return tuple(poles[k] for k in reduction.range_of_motion.find_distinct([(pole, pole) for pole in poles], tolerance))


def _find_spindle_gradient_zeros(reduction: SingleDofReduction, coefficients: PathCoefficients) -> Iterator[tuple[float, bool]]:
    """Return coordinates at which J' changes its sign, and whether V' vanishes there too."""
    for low, high in _sign_changes(coefficients.spindle_inertia_derivative):
        zero = _find_root_between(reduction, coefficients, (low, high), lambda local: local.spindle_inertia_derivative)
        neighbouring_force = max(abs(coefficients.potential_derivative[low]), abs(coefficients.potential_derivative[high]))
        yield (zero, bool(abs(reduction.evaluate([zero]).potential_derivative[0]) <= ZERO_FORCE_RATIO * neighbouring_force))


def _find_root_between(
    reduction: SingleDofReduction, coefficients: PathCoefficients, ends: tuple[int, int], quantity: Callable[[PathCoefficients], FloatArray]
) -> float:
    """Return the coordinate at which a quantity vanishes between two grid values."""
    low, high = coefficients.coordinate[list(ends)]
    return find_root(lambda value: float(quantity(reduction.evaluate([value]))[0]), low, high)


def _is_touching_pole(
    coefficients: PathCoefficients, local_coefficients: PathCoefficients, low: int, high: int, coordinate_scale: float
) -> bool:
    """Return whether J' only touches zero in an interval while V' is not zero: a pole without a sign change."""
    neighbouring_gradient = max(abs(coefficients.spindle_inertia_derivative[low]), abs(coefficients.spindle_inertia_derivative[high]))
    has_load_force = abs(local_coefficients.potential_derivative[0]) > REMOVABLE_SINGULARITY_TOLERANCE * coordinate_scale * abs(
        local_coefficients.potential_second_derivative[0]
    )
    return bool(abs(local_coefficients.spindle_inertia_derivative[0]) <= ZERO_FORCE_RATIO * neighbouring_gradient and has_load_force)


def _sign_changes(values: FloatArray) -> Iterator[tuple[int, int]]:
    """Return index pairs of neighbours of opposite sign, also around one or two zeros."""
    significant = np.flatnonzero(values)
    for low, high in zip(significant[:-1].tolist(), significant[1:].tolist(), strict=True):
        if values[low] * values[high] < 0.0 and high - low - 1 <= MAX_ZERO_RUN:
            yield low, high


def validate_coordinate_values(reduction: SingleDofReduction, values: object) -> FloatArray:
    """Return values (n,) of the leading coordinate within its travel. Raise MechanismError for anything else."""
    mechanism, travel = reduction.mechanism, reduction.range_of_motion
    numbers = convert_texts(values, mechanism.reading(mechanism.coordinate).quantity, mechanism.coordinate)
    try:
        given = np.asarray(numbers)
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
    """Return a resistance (N or N m) as a number, and the name of its reading. Raise MechanismError for anything else."""
    names = [reading.name for reading in mechanism.readings]
    if not isinstance(against, str):
        raise MechanismError(f"`against` must be the name of a reading; got {format_value(against)}; readings are {names}")
    number = parse_quantity(resistance, "torque" if mechanism.reading(against).quantity == "angle" else "force", "the resistance")
    if number < 0:
        raise MechanismError(f"the resistance must not be negative; got {number:g}")
    if number > MAX_RESISTANCE:
        raise MechanismError(f"the resistance must be at most {MAX_RESISTANCE:g}; got {number:g}")
    return number, against


def format_coordinate(scene: Scene, value: float) -> str:
    """Return a value of the leading coordinate as text with a customary unit."""
    mechanism = scene.part.mechanism
    return format_quantity(value, READING_UNITS[mechanism.reading(mechanism.coordinate).quantity])


def evaluate_readings(mechanism: Mechanism, coefficients: PathCoefficients) -> dict[str, FloatArray]:
    """Return all readings (n,), SI; the leading coordinate is continuous over full turns like the travel."""
    readings = {one.name: evaluate_output_value(mechanism, one.name, coefficients.poses) for one in mechanism.readings}
    return readings | {mechanism.coordinate: coefficients.coordinate} if mechanism.coordinate in readings else readings

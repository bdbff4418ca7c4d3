"""Square of the equilibrium speed at a position, its folds and poles, and validation of arguments."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, output_forces_of
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, equilibrium_speed_slope_numerator, sample_range_of_motion
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.quantities import convert_texts, format_quantity, format_value, parse_quantity
from governor_mechanism.units.text_table import short_repr

REMOVABLE_SINGULARITY_TOLERANCE = 1e-8
"""Distance from a common zero of V' and J', relative to the scale of the coordinate, within which the limit V'' / J'' is used."""

ZERO_FORCE_RATIO = 1e-8
"""Force relative to neighbouring values below which it counts as zero."""

# It is the cube root of rounding.
FOLD_MERGE_TOLERANCE = 2e-5
"""Distance of a fold from a common zero of V' and J', relative to the coordinate scale, within which they coincide."""

PERIOD_END_TOLERANCE = 1e-7
"""Distance from an end of a periodic travel, relative to the scale of the coordinate, within which a value is at the end."""

MAX_ZERO_RUN = 2
"""Largest number of successive zeros that can be a sign change; a longer run is a constant stretch."""

MAX_RESISTANCE = 1e12
"""Largest resistance, N or N m; a larger value is a mistake of units."""


def has_equilibrium_speed(scene: Scene) -> bool:
    """Return whether a scene has both loads and a spindle-dependent load that can balance them."""
    has_springs = any(not effect.dissipates for effect in output_forces_of(scene))
    return has_spindle_dependent_loads(scene) and bool(scene.gravity or scene.part.mechanism.force_elements or has_springs)


def has_spindle_dependent_loads(scene: Scene) -> bool:
    """Return whether the loads of a scene depend on the spindle speed: the plane turns and the centrifugal load is active."""
    return bool(scene.has_centrifugal and scene.part.plane == TURNING_PLANE)


def require_equilibrium_speed(scene: Scene) -> None:
    """Raise an error unless a spindle speed can balance the loads."""
    if not has_equilibrium_speed(scene):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity), and a "
            "plane that turns with the spindle; list them in the scene"
        )


def equilibrium_speed_squared(coefficients: PathCoefficients, coordinate_scale: float, extra_force: FloatArray | float = 0.0) -> FloatArray:
    """Return the squared equilibrium speed 2 (V' + extra_force) / J' (n,), rad2/s2; -1 where J' is zero."""
    # Where V' and J' vanish together, the result is the limit 2 V'' / J''. coordinate_scale is the
    # scale of the coordinate in SI.
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


# The travel is sampled up to 1e-5 of its length before a dead centre (`range_of_motion.RANGE_END_MARGIN`); a
# value written with four digits for the end of the travel must not be refused.
END_TOLERANCE = 1e-4
"""Distance of a given value beyond the end of the travel, in travels of the reading, within which it is that end."""

# No governor works up to it, since its equilibrium speed there is zero or unbounded. The ratio is some
# hundred times what the margin before a dead centre leaves.
DEAD_CENTRE_RATIO = 1e-3
"""Load or centrifugal effect at an end of the travel, over its median, below which that end is a dead centre."""


@dataclass(frozen=True, kw_only=True, eq=False)
class WorkingRange(Recorded):
    """Both ends of the working range, inner end (smaller ball radius) first; arrays of shape (2,)."""

    limited_by: str  # 'values' if the range was given, 'stops' if it is that of the scene's stops, or 'travel'
    coordinate: FloatArray  # leading coordinate, SI
    radius: FloatArray  # distance of the ball from the spindle axis, m
    sleeve: FloatArray  # reading of the sleeve, SI
    force: FloatArray  # controlling force of one ball, N
    speed: FloatArray  # equilibrium speed, rad/s
    # speed below which the governor begins to fall against the resistance, rad/s; the equilibrium speed
    # without resistance
    falling_speed: FloatArray
    # speed above which it begins to rise against the resistance, rad/s; the equilibrium speed without
    # resistance
    rising_speed: FloatArray
    # whether the equilibria between the ends are stable. If not, the range of speed says nothing about the
    # sensitiveness.
    stable: bool
    # work that the governor does from the inner to the outer end, J: the area under the controlling-force
    # curve, for all balls
    work_capacity: float

    __repr__ = short_repr

    derived = ("lift", "range_of_speed", "mean_speed", "sensitiveness", "range_of_speed_with_resistance")

    @property
    def lift(self) -> float:
        """Travel of the sleeve, m or rad."""
        return float(abs(self.sleeve[1] - self.sleeve[0]))

    @property
    def range_of_speed(self) -> float:
        """Equilibrium speed at the outer end minus that at the inner end, rad/s; negative for an unstable governor."""
        return float(self.speed[1] - self.speed[0])

    @property
    def mean_speed(self) -> float:
        """Mean of the equilibrium speeds at both ends, rad/s."""
        return float(0.5 * (self.speed[0] + self.speed[1]))

    @property
    def sensitiveness(self) -> float:
        """Range of speed over mean speed (Ungleichförmigkeitsgrad), 0 for an isochronous governor; some textbooks take the inverse."""
        return self.range_of_speed / self.mean_speed

    @property
    def range_of_speed_with_resistance(self) -> float:
        """Rising speed at the outer end minus falling speed at the inner end, rad/s: a full travel and back."""
        return float(self.rising_speed[1] - self.falling_speed[0])


def locate_working_range(
    reduction: SingleDofReduction,
    # two values of one reading by its name, numbers in SI or text with a unit; None for the stops of the
    # scene, or for the whole travel
    between: Mapping[str, Sequence[float | str]] | None,
) -> tuple[str, tuple[float, float]] | None:
    """Return what limits the working range, and the coordinates of its ends in ascending order."""
    if between is not None:
        name, values = _validate_values(reduction, between)
        low, high = sorted(_locate_value(reduction, name, value) for value in values)
        if low == high:
            raise MechanismError(f"the working range needs two different values of {name!r}; got {format_value(list(values))}")
        return "values", (low, high)
    has_stops, low, high = _find_stops(reduction)
    if not low < high or not _can_work_at(reduction, low) or not _can_work_at(reduction, high):
        return None
    return "stops" if has_stops else "travel", (low, high)


def _validate_values(reduction: SingleDofReduction, between: object) -> tuple[str, tuple[float, float]]:
    names = [reading.name for reading in reduction.mechanism.readings]
    cure = 'write for example between={"sleeve_lift": ("20 mm", "60 mm")}'
    if not isinstance(between, Mapping) or len(between) != 1:
        raise MechanismError(f"between must be two values of one reading; got {format_value(between)}; {cure}; readings are {names}")
    ((name, values),) = between.items()
    if isinstance(values, str) or not isinstance(values, Sequence | np.ndarray) or len(values) != 2:
        raise MechanismError(f"between must give two values of {format_value(name)}; got {format_value(values)}; {cure}")
    quantity = reduction.mechanism.reading(name).quantity
    first, second = (parse_quantity(_plain_number(value), quantity, f"the end of the working range in {name!r}") for value in values)
    return name, (first, second)


def _plain_number(value: object) -> object:
    """Return a number of NumPy as one of Python."""
    return value.item() if isinstance(value, np.generic) else value


def _locate_value(reduction: SingleDofReduction, name: str, value: float) -> float:
    """Return the one coordinate at which a reading has a value. Raise MechanismError if there is none or are several."""
    found, (lowest, highest) = _crossings(reduction, name, value)
    if len(found) == 1:
        return found[0]
    unit = READING_UNITS[reduction.mechanism.reading(name).quantity]
    text, low, high = (format_quantity(number, unit) for number in (value, lowest, highest))
    if not found:
        raise MechanismError(f"{name} = {text} lies outside the travel, in which {name} goes from {low} to {high}")
    raise MechanismError(
        f"{name} = {text} is reached at {len(found)} positions of the travel; give the working range in values of "
        f"{reduction.mechanism.coordinate!r}"
    )


def _crossings(reduction: SingleDofReduction, name: str, value: float) -> tuple[list[float], tuple[float, float]]:
    """Return the coordinates at which a reading passes a value, and the extremes of the reading over the travel."""
    travel, mechanism = reduction.range_of_motion, reduction.mechanism
    grid = sample_range_of_motion(reduction).sorted_coefficients
    grid = grid.select(np.flatnonzero((travel.low <= grid.coordinate) & (grid.coordinate <= travel.high)))

    def excess(coordinate: float) -> float:
        if name == mechanism.coordinate:  # continuous over full turns, as the reading of its line is not
            return coordinate - value
        return float(evaluate_output_value(mechanism, name, reduction.evaluate([coordinate]).poses)[0]) - value

    values = grid.coordinate if name == mechanism.coordinate else evaluate_output_value(mechanism, name, grid.poses)
    extremes = float(values.min()), float(values.max())
    signs = np.sign(values - value)
    found = grid.coordinate[signs == 0.0].tolist()
    found += [find_root(excess, *map(float, grid.coordinate[k : k + 2])) for k in np.flatnonzero(signs[:-1] * signs[1:] < 0.0)]
    if not found:
        margin = END_TOLERANCE * (extremes[1] - extremes[0])
        found = [float(grid.coordinate[index]) for index in (0, -1) if abs(values[index] - value) <= margin]
    return found, extremes


def _find_stops(reduction: SingleDofReduction) -> tuple[bool, float, float]:
    """Return whether stops end the travel, and the ends of the coordinate between them."""
    travel, has_stops = reduction.range_of_motion, False
    low, high = travel.low, travel.high
    for contact in contacts_of(reduction.scene):
        for limit, is_lower in ((contact.low, True), (contact.high, False)):
            for position in _crossings(reduction, contact.output_name, limit)[0] if math.isfinite(limit) else ():
                has_stops = True
                is_rising = reduction.output_derivative(reduction.evaluate([position]), contact.output_name)[0] > 0.0
                if is_rising == is_lower:
                    low = max(low, position)
                else:
                    high = min(high, position)
    return has_stops, low, high


def _can_work_at(reduction: SingleDofReduction, value: float) -> bool:
    """Return whether a coordinate has an equilibrium speed and is no dead centre."""
    grid = sample_range_of_motion(reduction).coefficients
    along = reduction.evaluate([value])
    pairs = ((along.potential_derivative, grid.potential_derivative), (along.spindle_inertia_derivative, grid.spindle_inertia_derivative))
    is_dead_centre = any(abs(float(here[0])) < DEAD_CENTRE_RATIO * float(np.median(np.abs(everywhere))) for here, everywhere in pairs)
    return not is_dead_centre and bool(equilibrium_speed_squared(along, reduction.coordinate_scale)[0] > 0.0)

"""Working range of a governor: the part of its travel between two positions of the sleeve, and its sensitiveness there."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.statics.adaptive_grid import sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import equilibrium_speed_squared
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity, format_value, parse_quantity
from governor_mechanism.units.short_repr import short_repr

END_TOLERANCE = 1e-4
"""Distance of a given value beyond the end of the travel, in travels of the reading, within which it is that end.

The travel is sampled up to 1e-5 of its length before a dead centre (`range_of_motion.RANGE_END_MARGIN`); a value written with four digits
for the end of the travel must not be refused.
"""

DEAD_CENTRE_RATIO = 1e-3
"""Load or centrifugal effect at an end of the travel, over its median, below which that end is a dead centre.

No governor works up to it, since its equilibrium speed there is zero or unbounded. The ratio is some hundred times what the margin
before a dead centre leaves.
"""


@dataclass(frozen=True, kw_only=True, eq=False)
class WorkingRange(Recorded):
    """Both ends of the working range, inner end (smaller ball radius) first; arrays of shape (2,).

    Attributes
    ----------
    limited_by
        'values' if the range was given, 'stops' if it is that of the scene's stops, or 'travel'.
    coordinate
        Leading coordinate, SI.
    radius
        Distance of the ball from the spindle axis, m.
    sleeve
        Reading of the sleeve, SI.
    force
        Controlling force of one ball, N.
    speed
        Equilibrium speed, rad/s.
    falling_speed
        Speed below which the governor begins to fall against the resistance, rad/s; the equilibrium speed without resistance.
    rising_speed
        Speed above which it begins to rise against the resistance, rad/s; the equilibrium speed without resistance.
    stable
        Whether the equilibria between the ends are stable. If not, the range of speed says nothing about the sensitiveness.
    work_capacity
        Work that the governor does from the inner to the outer end, J: the area under the controlling-force curve, for all balls.
    """

    limited_by: str
    coordinate: FloatArray
    radius: FloatArray
    sleeve: FloatArray
    force: FloatArray
    speed: FloatArray
    falling_speed: FloatArray
    rising_speed: FloatArray
    stable: bool
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
        """Range of speed over mean speed (German Ungleichförmigkeitsgrad); small for a sensitive governor, 0 for an isochronous one.

        Some textbooks call the inverse, mean speed over range of speed, sensitiveness.
        """
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
    """Return what limits the working range, and the coordinates of its ends in ascending order.

    Result: 'values', 'stops' or 'travel' with the ends; None if nothing is given and an end of the travel has
    no equilibrium speed or is a dead centre. Raises MechanismError if the values are wrong, outside the
    travel, or reached at several positions.
    """
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
    grid, along = sample_range_of_motion(reduction).coefficients, reduction.evaluate([value])
    pairs = ((along.potential_derivative, grid.potential_derivative), (along.spindle_inertia_derivative, grid.spindle_inertia_derivative))
    is_dead_centre = any(abs(float(here[0])) < DEAD_CENTRE_RATIO * float(np.median(np.abs(everywhere))) for here, everywhere in pairs)
    return not is_dead_centre and bool(equilibrium_speed_squared(along, reduction.coordinate_scale)[0] > 0.0)

"""Equilibrium speed over the travel of a mechanism with one degree of freedom: its speed curve.

With the coordinate q, potential V, moment of inertia J about the spindle and reduced inertia I, the equilibrium condition is
V' = J' w^2 / 2. The stiffness is K = V'' - J'' w^2 / 2 = J' d(w^2)/dq / 2. The squared frequency of small oscillations is K / I; a free
spindle of inertia J0 adds w^2 J'^2 / ((J0 + J) I). A resistance W along a reading s keeps equilibrium for w^2 between
2 (V' - W |s'|) / J' and 2 (V' + W |s'|) / J'.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Column, Result, item_column, name_values
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics import equilibrium_speed
from governor_mechanism.statics.adaptive_grid import sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import equilibrium_speed_squared, evaluate_stability
from governor_mechanism.types import FloatArray, QuantityValues
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import short_repr

MAX_CURVE_POINTS = 1_000_000
"""Largest number of points of a speed curve; it bounds memory and time."""

ZERO_SPEED_TOLERANCE = 1e-10
"""Distance from a zero of V', relative to the scale of the coordinate, within which the equilibrium speed counts as zero."""


@dataclass(frozen=True, kw_only=True, eq=False)
class InsensitivityBand(Result):
    """Spindle speeds between which a resistance along a reading keeps the mechanism in equilibrium; shape (n,).

    Attributes
    ----------
    resistance
        Resistance, N or N m.
    against
        Name of the reading.
    falling_speed
        Speed below which the mechanism begins to fall, rad/s; 0 if the resistance holds it even without rotation.
    rising_speed
        Speed above which it begins to rise, rad/s; infinite if rotation has no effect and the resistance holds it at every speed. Both
        speeds are 0 if no speed holds it.
    insensitivity
        Difference of the speeds over the equilibrium speed without resistance; infinite where that is zero or does not exist.
    """

    resistance: float
    against: str
    falling_speed: FloatArray
    rising_speed: FloatArray
    insensitivity: FloatArray

    __repr__ = short_repr
    columns = (Column("falling_speed", unit="rad/s"), Column("rising_speed", unit="rad/s"), Column("insensitivity", unit="1"))


@dataclass(frozen=True, kw_only=True, eq=False)
class SpeedCurve(Result):
    """Equilibrium speed over the travel; arrays of shape (n,).

    Attributes
    ----------
    coordinate_name
        Name of the leading coordinate.
    coordinate
        Its values, SI.
    readings
        Readings by name, SI.
    speed
        Equilibrium speed, rad/s; 0 where none exists.
    has_equilibrium
        Whether an equilibrium speed exists.
    stiffness
        Stiffness K, N m/rad or N/m.
    frequency_squared
        Squared frequency of small oscillations at constant speed without damping, 1/s2; negative where they diverge.
    free_frequency_squared
        The same with a free spindle.
    stable
        Whether the equilibrium is stable.
    astatic
        Whether the equilibrium is neutral.
    folds
        Coordinates and speeds at which the curve turns back (saddle-node folds). The governor jumps there.
    poles
        Coordinates at which J' vanishes. Beyond them no equilibrium speed exists.
    low_end_message, high_end_message
        Sentences on what happens at the ends of the travel.
    insensitivity_band
        Band under a given resistance, or None.
    scene
        The scene.
    """

    coordinate_name: str
    coordinate: FloatArray
    readings: Mapping[str, FloatArray]
    speed: FloatArray
    has_equilibrium: NDArray[np.bool_]
    stiffness: FloatArray
    frequency_squared: FloatArray
    free_frequency_squared: FloatArray
    stable: NDArray[np.bool_]
    astatic: NDArray[np.bool_]
    folds: tuple[tuple[float, float], ...]
    poles: tuple[float, ...]
    low_end_message: str
    high_end_message: str
    insensitivity_band: InsensitivityBand | None = None
    scene: Scene = field(repr=False)

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", name_values("reading", self.readings))

    figure = "render.figures.controlling_force.speed_curve_figure"
    attributes = ("folds", "poles")

    @property
    def index(self) -> str:
        """Name of the leading coordinate."""
        return self.coordinate_name

    @property
    def columns(self) -> tuple[Column, ...]:
        """Coordinate, readings, the quantities of the curve, and those of the insensitivity band if it has one."""
        readings = [item_column(name, "readings", name) for name in self.readings]
        band = [] if self.insensitivity_band is None else [Column(name, value=f"insensitivity_band.{name}") for name in BAND_SPEEDS]
        return Column(self.coordinate_name, value="coordinate"), *readings, *map(Column, CURVE_QUANTITIES), *band

    def plot(self, equilibria: Sequence[Result] = ()) -> Figure:
        """Draw the speed over the travel, with jumps and the insensitivity band.

        Parameters
        ----------
        equilibria
            Equilibria to mark, as from `gm.equilibria`.

        Returns
        -------
        Figure
            The figure.
        """
        return self._draw(equilibria)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: travel, speeds, folds and poles."""
        from governor_mechanism.notebook.result_table import speed_curve_html

        return speed_curve_html(self)


CURVE_QUANTITIES = ("speed", "has_equilibrium", "stiffness", "frequency_squared", "free_frequency_squared", "stable", "astatic")
BAND_SPEEDS = ("falling_speed", "rising_speed", "insensitivity")
"""Quantities along a speed curve and along an insensitivity band, which tables have."""


def equilibrium_speed_at(
    scene: Scene,
    values: Sequence[float] | FloatArray,  # values of the leading coordinate, SI; shape (n,)
) -> FloatArray:
    """Return the equilibrium speeds (n,), rad/s, at given positions."""
    equilibrium_speed.require_equilibrium_speed(scene)
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate(equilibrium_speed.validate_coordinate_values(reduction, values))
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    for k in np.flatnonzero(~(speed_squared > 0.0)):
        raise MechanismError(_no_equilibrium_speed_message(reduction, coefficients, int(k)))
    return np.sqrt(speed_squared)


def compute_speed_curve(
    scene: Scene,
    points: int = 500,
    *,
    # resistance, N or N m, or text with a unit, for the insensitivity band; None for no band
    resistance: float | str | None = None,
    against: str = "sleeve_lift",
) -> SpeedCurve:
    """Return the speed curve over the whole travel with its stability, folds and poles.

    Folds and poles are located on an adaptive grid (`statics.adaptive_grid`), whatever the number of points.

    Raises MechanismError if no spindle speed can balance the loads, the mechanism does not have one degree of
    freedom, or an argument is wrong.
    """
    equilibrium_speed.require_equilibrium_speed(scene)
    if not isinstance(points, Integral) or isinstance(points, bool) or not 2 <= points <= MAX_CURVE_POINTS:
        raise MechanismError(f"a speed curve needs 2 to {MAX_CURVE_POINTS:,} points; got {format_value(points)}")
    reduction = SingleDofReduction(scene)
    band_arguments = None if resistance is None else equilibrium_speed.validate_resistance(reduction.mechanism, resistance, against)
    travel = reduction.range_of_motion
    coefficients = reduction.evaluate(np.linspace(travel.low, travel.high, int(points)))
    refined_coefficients = sample_range_of_motion(reduction).sorted_coefficients
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    has_equilibrium = speed_squared > 0.0
    speed_squared = np.where(has_equilibrium, speed_squared, 0.0)
    stiffness, astatic = evaluate_stability(coefficients, speed_squared)
    astatic &= has_equilibrium
    frequency_squared = stiffness / coefficients.inertia
    inertia_product = (reduction.free_spindle_inertia + coefficients.spindle_inertia) * coefficients.inertia
    free_spindle_term = np.zeros_like(speed_squared)
    is_defined = inertia_product > 0.0
    np.divide(speed_squared * coefficients.spindle_inertia_derivative**2, inertia_product, out=free_spindle_term, where=is_defined)
    return SpeedCurve(
        scene=scene,
        coordinate_name=reduction.mechanism.coordinate,
        coordinate=coefficients.coordinate,
        readings=equilibrium_speed.evaluate_readings(reduction.mechanism, coefficients),
        speed=np.sqrt(speed_squared),
        has_equilibrium=has_equilibrium,
        stiffness=stiffness,
        frequency_squared=frequency_squared,
        free_frequency_squared=frequency_squared + free_spindle_term,
        stable=has_equilibrium & (stiffness > 0.0) & ~astatic,
        astatic=astatic,
        folds=equilibrium_speed.find_folds(reduction, refined_coefficients),
        poles=equilibrium_speed.find_poles(reduction, refined_coefficients),
        low_end_message=travel.low_message,
        high_end_message=travel.high_message,
        insensitivity_band=_insensitivity_band(reduction, coefficients, *band_arguments) if band_arguments else None,
    )


def compute_insensitivity_band(
    scene: Scene,
    values: QuantityValues,  # values of the leading coordinate, SI; shape (n,)
    resistance: float | str,  # resistance along the reading, N or N m, or text with a unit; at least 0
    against: str = "sleeve_lift",
) -> InsensitivityBand:
    """Return the insensitivity band at given positions."""
    equilibrium_speed.require_equilibrium_speed(scene)
    reduction = SingleDofReduction(scene)
    resistance_and_reading = equilibrium_speed.validate_resistance(reduction.mechanism, resistance, against)
    coefficients = reduction.evaluate(equilibrium_speed.validate_coordinate_values(reduction, values))
    zero_force = ZERO_SPEED_TOLERANCE * reduction.coordinate_scale * np.abs(coefficients.potential_second_derivative)
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    has_speed = (speed_squared >= 0.0) | (np.abs(coefficients.potential_derivative) <= zero_force)
    for k in np.flatnonzero((coefficients.spindle_inertia_derivative == 0.0) | ~has_speed):
        raise MechanismError(_no_equilibrium_speed_message(reduction, coefficients, int(k)))
    return _insensitivity_band(reduction, coefficients, *resistance_and_reading)


def _insensitivity_band(
    reduction: SingleDofReduction, coefficients: PathCoefficients, resistance: float, against: str
) -> InsensitivityBand:
    resistance_force = resistance * np.abs(reduction.output_derivative(coefficients, against))
    forces = np.array([-resistance_force, np.zeros_like(resistance_force), resistance_force])
    squared_speeds = [equilibrium_speed_squared(coefficients, reduction.coordinate_scale, force) for force in forces]
    low_speed, frictionless_speed, high_speed = np.sqrt(np.maximum(squared_speeds, 0.0))
    is_spindle_decoupled = (coefficients.spindle_inertia_derivative == 0.0) & (resistance_force > 0.0)
    decoupled_speed = np.where(np.abs(coefficients.potential_derivative) <= resistance_force, np.inf, 0.0)
    falling_speed = np.where(is_spindle_decoupled, 0.0, np.minimum(low_speed, high_speed))
    rising_speed = np.where(is_spindle_decoupled, decoupled_speed, np.maximum(low_speed, high_speed))
    insensitivity = np.full_like(frictionless_speed, np.inf)
    has_speed = frictionless_speed > 0
    np.divide(rising_speed - falling_speed, frictionless_speed, out=insensitivity, where=has_speed)
    return InsensitivityBand(
        resistance=resistance, against=against, falling_speed=falling_speed, rising_speed=rising_speed, insensitivity=insensitivity
    )


def _no_equilibrium_speed_message(reduction: SingleDofReduction, coefficients: PathCoefficients, index: int) -> str:
    """Return a sentence on why no equilibrium speed exists at a position."""
    scene, value = reduction.scene, float(coefficients.coordinate[index])
    position = f"{reduction.mechanism.coordinate} = {equilibrium_speed.format_coordinate(scene, value)}"
    if coefficients.spindle_inertia_derivative[index] == 0.0:
        if equilibrium_speed_squared(coefficients, reduction.coordinate_scale)[index] >= 0.0:
            return f"the mechanism is in equilibrium at {position} at every spindle speed: no load or centrifugal force moves it"
        return f"no spindle speed balances the mechanism at {position}: the centrifugal forces have no effect there, and the loads act"
    poles = sorted(
        equilibrium_speed.find_poles(reduction, sample_range_of_motion(reduction).sorted_coefficients), key=lambda pole: abs(pole - value)
    )
    pole_clause = "".join(
        f", beyond the pole of the speed curve at {equilibrium_speed.format_coordinate(scene, pole)}" for pole in poles[:1]
    )
    return f"no spindle speed balances the mechanism at {position}{pole_clause}: the loads do not oppose the centrifugal forces"

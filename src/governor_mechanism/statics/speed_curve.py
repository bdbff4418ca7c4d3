"""The speed at which a mechanism of mobility one rests, over its travel: its characteristic.

Along the coordinate q, with potential V, moment of inertia J about the spindle and inertia I: rest where
V' = J' w^2 / 2; stiffness K = V'' - J'' w^2 / 2 = J' d(w^2)/dq / 2; small oscillations K / I, of a free spindle
w^2 J'^2 / ((J0 + J) I) more. A resistance W at a reading s holds it where w^2 lies within 2 (V' -+ W |s'|) / J'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import (
    equilibrium_speed_squared,
    evaluate_readings,
    find_folds,
    find_poles,
    format_coordinate,
    require_equilibrium_speed,
    validate_coordinate_values,
    validate_resistance,
)
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value

ZERO_SPEED_TOLERANCE = 1e-10
"""rad, or machine sizes: so near a place where the loads let go the equilibrium speed is zero, and not none."""


@dataclass(frozen=True, kw_only=True)
class InsensitivityBand:
    """Between which speeds (n,) rad/s a resistance (N, or N m) at the reading `against` holds the mechanism.

    Below falling_speed it begins to fall, above rising_speed to rise; falling_speed is 0 where it is held even on a
    spindle that stands, rising_speed infinite where turning has no grip and it is held at every speed, both are 0 where
    it is held at none. insensitivity is their difference over the equilibrium speed without resistance, infinite where none
    but 0 is one.
    """

    resistance: float
    against: str
    falling_speed: FloatArray
    rising_speed: FloatArray
    insensitivity: FloatArray


@dataclass(frozen=True, kw_only=True)
class SpeedCurve:
    """The speed at which a mechanism rests, over its travel, (n,) arrays.

    Where no speed holds it, `held` is False and speed 0. stiffness K in N m/rad, or N/m; frequency_squared and
    free_frequency_squared (1/s2) at a kept speed and with the spindle left to itself, negative where it grows away.
    `stable` where it returns, `astatic` where it neither returns nor leaves. folds are the coordinates and speeds at
    which the curve turns back: the governor jumps there. poles are the coordinates at which the spindle's turning
    loses its grip, and beyond which no speed holds it.
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


def equilibrium_speed_at(scene: Scene, values: Sequence[float] | FloatArray) -> FloatArray:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Where loads and turning both let go, and it rests at every speed, that of its neighbourhood. Raises MechanismError
    for values outside the travel, and where no speed holds it.
    """
    require_equilibrium_speed(scene)
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate(validate_coordinate_values(reduction, values))
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    for k in np.flatnonzero(~(speed_squared > 0.0)):
        raise MechanismError(_no_equilibrium_speed_message(reduction, coefficients, int(k)))
    return np.sqrt(speed_squared)


def compute_speed_curve(
    scene: Scene, points: int = 500, *, resistance: float | str | None = None, against: str = "sleeve_lift"
) -> SpeedCurve:
    """The speed curve over the whole travel, its stability, folds and poles; with a resistance its insensitivity band too.

    Folds and poles are looked for where forces and stiffness ask for it, whatever the points (`equations.scanning`).
    resistance (N, or N m) acts at the reading `against`. Raises MechanismError as `Reduction` and `find_travel` do.
    """
    require_equilibrium_speed(scene)
    if not isinstance(points, Integral) or isinstance(points, bool) or points < 2:
        raise MechanismError(f"a speed curve needs 2 points or more; got {format_value(points)}")
    reduction = SingleDofReduction(scene)
    resistance_and_reading = None if resistance is None else validate_resistance(reduction.mechanism, resistance, against)
    travel = reduction.range_of_motion
    coefficients, refined_coefficients = (
        reduction.evaluate(np.linspace(travel.low, travel.high, int(points))),
        sample_range_of_motion(reduction).sorted_coefficients,
    )
    speed_squared = equilibrium_speed_squared(coefficients, reduction.coordinate_scale)
    has_equilibrium = speed_squared > 0.0
    speed_squared = np.where(has_equilibrium, speed_squared, 0.0)
    stiffness = coefficients.potential_second_derivative - 0.5 * speed_squared * coefficients.spindle_inertia_second_derivative
    stiffness_magnitude = np.abs(coefficients.potential_second_derivative) + np.abs(
        0.5 * speed_squared * coefficients.spindle_inertia_second_derivative
    )
    astatic = has_equilibrium & (np.abs(stiffness) <= ASTATIC_TOLERANCE * stiffness_magnitude)
    frequency_squared = stiffness / coefficients.inertia
    inertia_product = (reduction.free_spindle_inertia + coefficients.spindle_inertia) * coefficients.inertia
    free_spindle_term = np.divide(
        speed_squared * coefficients.spindle_inertia_derivative**2,
        inertia_product,
        out=np.zeros_like(speed_squared),
        where=inertia_product > 0.0,
    )
    return SpeedCurve(
        coordinate_name=reduction.mechanism.coordinate,
        coordinate=coefficients.coordinate,
        readings=evaluate_readings(reduction.mechanism, coefficients),
        speed=np.sqrt(speed_squared),
        has_equilibrium=has_equilibrium,
        stiffness=stiffness,
        frequency_squared=frequency_squared,
        free_frequency_squared=frequency_squared + free_spindle_term,
        stable=has_equilibrium & (stiffness > 0.0) & ~astatic,
        astatic=astatic,
        folds=find_folds(reduction, refined_coefficients),
        poles=find_poles(reduction, refined_coefficients),
        low_end_message=travel.low_message,
        high_end_message=travel.high_message,
        insensitivity_band=None
        if resistance_and_reading is None
        else _insensitivity_band(reduction, coefficients, *resistance_and_reading),
    )


def compute_insensitivity_band(
    scene: Scene, values: Sequence[float] | FloatArray, resistance: float | str, against: str = "sleeve_lift"
) -> InsensitivityBand:
    """The insensitivity band under a resistance (N, or N m) at a reading, at values (n,) of the leading coordinate.

    Raises MechanismError for a resistance that is negative or no number, for values outside the travel, and where
    without resistance no speed holds the mechanism, or turning has no grip on it.
    """
    require_equilibrium_speed(scene)
    reduction = SingleDofReduction(scene)
    resistance_and_reading = validate_resistance(reduction.mechanism, resistance, against)
    coefficients = reduction.evaluate(validate_coordinate_values(reduction, values))
    is_zero_speed = np.abs(coefficients.potential_derivative) <= ZERO_SPEED_TOLERANCE * reduction.coordinate_scale * np.abs(
        coefficients.potential_second_derivative
    )
    is_undefined = (coefficients.spindle_inertia_derivative == 0.0) | ~(
        (equilibrium_speed_squared(coefficients, reduction.coordinate_scale) >= 0.0) | is_zero_speed
    )
    for k in np.flatnonzero(is_undefined):
        raise MechanismError(_no_equilibrium_speed_message(reduction, coefficients, int(k)))
    return _insensitivity_band(reduction, coefficients, *resistance_and_reading)


def _insensitivity_band(
    reduction: SingleDofReduction, coefficients: PathCoefficients, resistance: float, against: str
) -> InsensitivityBand:
    resistance_force = resistance * np.abs(reduction.output_derivative(coefficients, against))
    squared_speeds = [equilibrium_speed_squared(coefficients, reduction.coordinate_scale, sign * resistance_force) for sign in (-1.0, 1.0)]
    falling_speed, rising_speed = (
        np.sqrt(np.maximum(square, 0.0)) for square in (np.minimum(*squared_speeds), np.maximum(*squared_speeds))
    )
    is_spindle_decoupled = (coefficients.spindle_inertia_derivative == 0.0) & (resistance_force > 0.0)
    falling_speed = np.where(is_spindle_decoupled, 0.0, falling_speed)
    rising_speed = np.where(
        is_spindle_decoupled, np.where(np.abs(coefficients.potential_derivative) <= resistance_force, np.inf, 0.0), rising_speed
    )
    frictionless_speed = np.sqrt(np.maximum(equilibrium_speed_squared(coefficients, reduction.coordinate_scale), 0.0))
    return InsensitivityBand(
        resistance=resistance,
        against=against,
        falling_speed=falling_speed,
        rising_speed=rising_speed,
        insensitivity=np.divide(
            rising_speed - falling_speed, frictionless_speed, out=np.full_like(frictionless_speed, np.inf), where=frictionless_speed > 0
        ),
    )


def _no_equilibrium_speed_message(reduction: SingleDofReduction, coefficients: PathCoefficients, index: int) -> str:
    """That no speed holds the mechanism at a value of its coordinate, and why, or beyond which pole of its curve."""
    scene, value = reduction.scene, float(coefficients.coordinate[index])
    position = f"{reduction.mechanism.coordinate} = {format_coordinate(scene, value)}"
    if (
        coefficients.spindle_inertia_derivative[index] == 0.0
        and equilibrium_speed_squared(coefficients, reduction.coordinate_scale)[index] >= 0.0
    ):
        return f"the mechanism rests at {position} at every spindle speed: neither the loads nor turning move it there"
    if coefficients.spindle_inertia_derivative[index] == 0.0:
        return f"no spindle speed holds the mechanism at {position}: turning has no grip on it there, and the loads pull"
    poles = sorted(find_poles(reduction, sample_range_of_motion(reduction).sorted_coefficients), key=lambda pole: abs(pole - value))
    pole_clause = "".join(f", beyond the pole of its curve at {format_coordinate(scene, pole)}" for pole in poles[:1])
    return f"no spindle speed holds the mechanism at {position}{pole_clause}: the loads do not oppose"

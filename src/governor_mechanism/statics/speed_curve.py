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
from governor_mechanism.mechanics.reduction.lagrangian import Along, Reduction
from governor_mechanism.model.scene import Scene
from governor_mechanism.statics.adaptive_grid import NEUTRAL, scan
from governor_mechanism.statics.equilibrium_speed import (
    asked_resistance,
    asked_values,
    folds_of,
    poles_of,
    readings_at,
    require_turning,
    spoken_coordinate,
    square_of_rest,
)
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import shown

STANDING = 1e-10
"""rad, or machine sizes: so near a place where the loads let go the speed of rest is zero, and not none."""


@dataclass(frozen=True, kw_only=True)
class StandingBand:
    """Between which speeds (n,) rad/s a resistance (N, or N m) at the reading `against` holds the mechanism.

    Below falling_speed it begins to fall, above rising_speed to rise; falling_speed is 0 where it is held even on a
    spindle that stands, rising_speed infinite where turning has no grip and it is held at every speed, both are 0 where
    it is held at none. insensitivity is their difference over the speed of rest without resistance, infinite where none
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

    name: str
    coordinate: FloatArray
    readings: Mapping[str, FloatArray]
    speed: FloatArray
    held: NDArray[np.bool_]
    stiffness: FloatArray
    frequency_squared: FloatArray
    free_frequency_squared: FloatArray
    stable: NDArray[np.bool_]
    astatic: NDArray[np.bool_]
    folds: tuple[tuple[float, float], ...]
    poles: tuple[float, ...]
    low_end: str
    high_end: str
    band: StandingBand | None = None


def equilibrium_speed(scene: Scene, values: Sequence[float] | FloatArray) -> FloatArray:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Where loads and turning both let go, and it rests at every speed, that of its neighbourhood. Raises MechanismError
    for values outside the travel, and where no speed holds it.
    """
    require_turning(scene)
    reduction = Reduction(scene)
    along = reduction.at(asked_values(reduction, values))
    square = square_of_rest(along, reduction.unit)
    for k in np.flatnonzero(~(square > 0.0)):
        raise MechanismError(_not_held(reduction, along, int(k)))
    return np.sqrt(square)


def speed_curve(
    scene: Scene, points: int = 500, *, resistance: float | str | None = None, against: str = "sleeve_lift"
) -> SpeedCurve:
    """The speed curve over the whole travel, its stability, folds and poles; with a resistance its standing band too.

    Folds and poles are looked for where forces and stiffness ask for it, whatever the points (`equations.scanning`).
    resistance (N, or N m) acts at the reading `against`. Raises MechanismError as `Reduction` and `find_travel` do.
    """
    require_turning(scene)
    if not isinstance(points, Integral) or isinstance(points, bool) or points < 2:
        raise MechanismError(f"a speed curve needs 2 points or more; got {shown(points)}")
    reduction = Reduction(scene)
    held_by = None if resistance is None else asked_resistance(reduction.mechanism, resistance, against)
    travel = reduction.travel
    along, dense = reduction.at(np.linspace(travel.low, travel.high, int(points))), scan(reduction).ordered
    square = square_of_rest(along, reduction.unit)
    held = square > 0.0
    square = np.where(held, square, 0.0)
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
    parts = np.abs(along.potential_bend) + np.abs(0.5 * square * along.spindle_bend)
    astatic = held & (np.abs(stiffness) <= NEUTRAL * parts)
    frequency = stiffness / along.inertia
    whole = (reduction.rest_inertia + along.spindle) * along.inertia
    more = np.divide(square * along.spindle_slope**2, whole, out=np.zeros_like(square), where=whole > 0.0)
    return SpeedCurve(
        name=reduction.mechanism.coordinate,
        coordinate=along.coordinate,
        readings=readings_at(reduction.mechanism, along),
        speed=np.sqrt(square),
        held=held,
        stiffness=stiffness,
        frequency_squared=frequency,
        free_frequency_squared=frequency + more,
        stable=held & (stiffness > 0.0) & ~astatic,
        astatic=astatic,
        folds=folds_of(reduction, dense),
        poles=poles_of(reduction, dense),
        low_end=travel.below,
        high_end=travel.above,
        band=None if held_by is None else _band(reduction, along, *held_by),
    )


def standing_band(
    scene: Scene, values: Sequence[float] | FloatArray, resistance: float | str, against: str = "sleeve_lift"
) -> StandingBand:
    """The standing band under a resistance (N, or N m) at a reading, at values (n,) of the leading coordinate.

    Raises MechanismError for a resistance that is negative or no number, for values outside the travel, and where
    without resistance no speed holds the mechanism, or turning has no grip on it.
    """
    require_turning(scene)
    reduction = Reduction(scene)
    held_by = asked_resistance(reduction.mechanism, resistance, against)
    along = reduction.at(asked_values(reduction, values))
    stands = np.abs(along.potential_slope) <= STANDING * reduction.unit * np.abs(along.potential_bend)
    wrong = (along.spindle_slope == 0.0) | ~((square_of_rest(along, reduction.unit) >= 0.0) | stands)
    for k in np.flatnonzero(wrong):
        raise MechanismError(_not_held(reduction, along, int(k)))
    return _band(reduction, along, *held_by)


def _band(reduction: Reduction, along: Along, resistance: float, against: str) -> StandingBand:
    hold = resistance * np.abs(reduction.slopes(along, against))
    squares = [square_of_rest(along, reduction.unit, sign * hold) for sign in (-1.0, 1.0)]
    slow, fast = (np.sqrt(np.maximum(square, 0.0)) for square in (np.minimum(*squares), np.maximum(*squares)))
    loose = (along.spindle_slope == 0.0) & (hold > 0.0)
    slow = np.where(loose, 0.0, slow)
    fast = np.where(loose, np.where(np.abs(along.potential_slope) <= hold, np.inf, 0.0), fast)
    rest = np.sqrt(np.maximum(square_of_rest(along, reduction.unit), 0.0))
    return StandingBand(
        resistance=resistance,
        against=against,
        falling_speed=slow,
        rising_speed=fast,
        insensitivity=np.divide(fast - slow, rest, out=np.full_like(rest, np.inf), where=rest > 0),
    )


def _not_held(reduction: Reduction, along: Along, k: int) -> str:
    """That no speed holds the mechanism at a value of its coordinate, and why, or beyond which pole of its curve."""
    scene, value = reduction.scene, float(along.coordinate[k])
    at = f"{reduction.mechanism.coordinate} = {spoken_coordinate(scene, value)}"
    if along.spindle_slope[k] == 0.0 and square_of_rest(along, reduction.unit)[k] >= 0.0:
        return f"the mechanism rests at {at} at every spindle speed: neither the loads nor turning move it there"
    if along.spindle_slope[k] == 0.0:
        return f"no spindle speed holds the mechanism at {at}: turning has no grip on it there, and the loads pull"
    poles = sorted(poles_of(reduction, scan(reduction).ordered), key=lambda pole: abs(pole - value))
    beyond = "".join(f", beyond the pole of its curve at {spoken_coordinate(scene, pole)}" for pole in poles[:1])
    return f"no spindle speed holds the mechanism at {at}{beyond}: the loads do not oppose"

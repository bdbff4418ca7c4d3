"""The speed at which a mechanism of mobility one rests, over its travel: its characteristic.

Along the coordinate q, with potential V, moment of inertia J about the spindle and inertia I: rest where
V' = J' w^2 / 2; stiffness K = V'' - J'' w^2 / 2 = J' d(w^2)/dq / 2; small oscillations K / I, of a free spindle
w^2 J'^2 / ((J0 + J) I) more. A resistance W at a reading s holds it where w^2 lies within 2 (V' -+ W |s'|) / J'.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import reading_value
from governor_mechanism.equations.reduction import Along, Reduction
from governor_mechanism.equations.travel import Travel, find_travel
from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.scene import TURNING, Scene
from governor_mechanism.units import spoken

NEUTRAL = 1e-11
"""A stiffness, or a force, below this fraction of its parts is rounding and dimensions of twelve digits: astatic."""


@dataclass(frozen=True, kw_only=True)
class StandingBand:
    """Between which speeds (n,) rad/s a resistance (N, or N m) at the reading `against` holds the mechanism.

    Below falling_speed it begins to fall, above rising_speed to rise; falling_speed is 0 where it is held even on a
    spindle that stands. insensitivity is their difference over the speed of rest without resistance.
    """

    resistance: float
    against: str
    falling_speed: Array
    rising_speed: Array
    insensitivity: Array


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
    coordinate: Array
    readings: Mapping[str, Array]
    speed: Array
    held: NDArray[np.bool_]
    stiffness: Array
    frequency_squared: Array
    free_frequency_squared: Array
    stable: NDArray[np.bool_]
    astatic: NDArray[np.bool_]
    folds: tuple[tuple[float, float], ...]
    poles: tuple[float, ...]
    low_end: str
    high_end: str
    band: StandingBand | None = None


def travel_of(scene: Scene) -> Travel:
    """The travel of a scene's mechanism, as `equations.travel.find_travel`."""
    return find_travel(scene.part.mechanism, turning=scene.part.plane == TURNING)


def equilibrium_speed(scene: Scene, values: Array) -> Array:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Raises MechanismError where no speed holds it, or where it cannot be assembled.
    """
    require_turning(scene)
    along = Reduction(scene).at(values)
    square = square_of_rest(along)
    wrong = np.flatnonzero(~(square > 0.0))
    if wrong.size:
        raise MechanismError(_not_held(scene, float(along.coordinate[wrong[0]])))
    return np.sqrt(square)


def speed_curve(
    scene: Scene, points: int = 500, *, resistance: float | None = None, against: str = "sleeve_lift"
) -> SpeedCurve:
    """The speed curve over the whole travel, its stability, folds and poles; with a resistance its standing band too.

    resistance (N, or N m) acts at the reading `against`. Raises MechanismError as `Reduction` and `find_travel` do.
    """
    require_turning(scene)
    if not isinstance(points, int) or points < 2:
        raise MechanismError(f"a speed curve needs 2 points or more; got {points!r}")
    reduction = Reduction(scene)
    mechanism = reduction.mechanism
    travel = travel_of(scene)
    below, above = travel.below, travel.above
    along = reduction.sweep(np.linspace(travel.low, travel.high, points))
    kept, sentence = within_limits(mechanism, along.poses)
    if sentence:
        low_cut, high_cut = kept.start > 0, kept.stop < points
        below, above = sentence if low_cut else below, sentence if high_cut else above
        low, high = float(along.coordinate[kept.start]), float(along.coordinate[kept.stop - 1])
        along = reduction.sweep(np.linspace(low, high, points))
    square = square_of_rest(along)
    held = square > 0.0
    square = np.where(held, square, 0.0)
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
    astatic = held & (np.abs(stiffness) <= NEUTRAL * _stiffness_parts(along, square))
    frequency = stiffness / along.inertia
    more = square * along.spindle_slope**2 / ((reduction.rest_inertia + along.spindle) * along.inertia)
    return SpeedCurve(
        name=mechanism.coordinate,
        coordinate=along.coordinate,
        readings={one.name: reading_value(mechanism, one.name, along.poses) for one in mechanism.readings},
        speed=np.sqrt(square),
        held=held,
        stiffness=stiffness,
        frequency_squared=frequency,
        free_frequency_squared=frequency + more,
        stable=held & (stiffness > 0.0) & ~astatic,
        astatic=astatic,
        folds=tuple(_folds(reduction, along, held)),
        poles=tuple(_poles(reduction, along)),
        low_end=below,
        high_end=above,
        band=None if resistance is None else _band(reduction, along, resistance, against),
    )


def standing_band(
    scene: Scene, values: Sequence[float] | Array, resistance: float, against: str = "sleeve_lift"
) -> StandingBand:
    """The standing band under a resistance (N, or N m) at a reading, at values (n,) of the leading coordinate.

    Raises MechanismError for a resistance that is negative or no number, and as `equilibrium_speed` does.
    """
    require_turning(scene)
    reduction = Reduction(scene)
    return _band(reduction, reduction.at(values), resistance, against)


def _band(reduction: Reduction, along: Along, resistance: float, against: str) -> StandingBand:
    require_finite(resistance, "N", "the resistance")
    if resistance < 0:
        raise MechanismError(f"the resistance must not be negative; got {resistance:g}")
    hold = resistance * np.abs(reduction.slopes(along, against))
    squares = [square_of_rest(along, sign * hold) for sign in (-1.0, 1.0)]
    slow, fast = (np.sqrt(np.maximum(square, 0.0)) for square in (np.minimum(*squares), np.maximum(*squares)))
    rest = np.sqrt(np.maximum(square_of_rest(along), 0.0))
    return StandingBand(
        resistance=resistance,
        against=against,
        falling_speed=slow,
        rising_speed=fast,
        insensitivity=np.divide(fast - slow, rest, out=np.full_like(rest, np.inf), where=rest > 0),
    )


def within_limits(mechanism: Mechanism, poses: Array) -> tuple[slice, str]:
    """The longest run of poses (n, bodies, 3) within all limits, and what happens beyond it ('' if nothing does)."""
    inside, sentence = np.ones(len(poses), dtype=np.bool_), ""
    for limit in mechanism.limits:
        value = reading_value(mechanism, limit.reading, poses)
        for outside, words in ((value <= limit.low, limit.below), (value >= limit.high, limit.above)):
            sentence = words if outside.any() else sentence
            inside &= ~outside
    edges = np.flatnonzero(np.diff(np.concatenate([[0], inside.astype(int), [0]])))
    runs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True)) or [(0, 0)]
    return slice(*max(runs, key=lambda run: run[1] - run[0])), sentence


def balances(scene: Scene) -> bool:
    """Whether there are both, loads and a spindle's turning that could balance them."""
    return bool(scene.centrifugal and (scene.gravity or scene.part.mechanism.loads))


def require_turning(scene: Scene) -> None:
    """Refuse a scene whose loads a spindle's speed cannot balance."""
    if not balances(scene):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity); "
            "list them in the scene"
        )


def square_of_rest(along: Along, more: Array | float = 0.0) -> Array:
    """The square (n,) of the speed of rest under `more` force along the coordinate; -1 where turning does nothing."""
    slope = along.spindle_slope
    return np.where(slope != 0.0, 2 * (along.potential_slope + more) / np.where(slope != 0.0, slope, 1.0), -1.0)


def _folds(reduction: Reduction, along: Along, held: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Coordinates and speeds where the stiffness at rest changes its sign: K = J' d(w^2)/dq / 2."""

    def stiffness(value: float, near: Array) -> float:
        here = reduction.at([value], near)
        return float((here.potential_bend - 0.5 * square_of_rest(here) * here.spindle_bend)[0])

    at_rest = along.potential_bend - 0.5 * square_of_rest(along) * along.spindle_bend
    scale = _stiffness_parts(along, square_of_rest(along))
    found = []
    for k in np.flatnonzero(held[:-1] & held[1:] & (at_rest[:-1] * at_rest[1:] < 0)).tolist():
        if max(abs(at_rest[k]), abs(at_rest[k + 1])) < NEUTRAL * scale[k]:
            continue  # rounding about an astatic mechanism's nought
        ends = along.coordinate[k], along.coordinate[k + 1]
        value = float(brentq(stiffness, *ends, args=(along.poses[k],), xtol=1e-14, rtol=1e-14))
        found.append((value, float(np.sqrt(square_of_rest(reduction.at([value], along.poses[k]))[0]))))
    return found


def _stiffness_parts(along: Along, square: Array) -> Array:
    """The sum (n,) of the parts of the stiffness without their signs."""
    parts: Array = np.abs(along.potential_bend) + np.abs(0.5 * square * along.spindle_bend)
    return parts


def _poles(reduction: Reduction, along: Along) -> list[float]:
    """Coordinates where J' changes its sign while the loads pull: toward them the speed of rest grows without end."""
    found = []
    for k in np.flatnonzero(along.spindle_slope[:-1] * along.spindle_slope[1:] < 0).tolist():
        near, ends = along.poses[k], (along.coordinate[k], along.coordinate[k + 1])

        def slope(value: float, near: Array = near) -> float:
            return float(reduction.at([value], near).spindle_slope[0])

        found.append(float(brentq(slope, *ends, xtol=1e-14, rtol=1e-14)))
    return found


def _not_held(scene: Scene, value: float) -> str:
    """That no speed holds the mechanism at a value of its coordinate, and beyond which pole of its curve."""
    try:
        poles = sorted(speed_curve(scene).poles, key=lambda pole: abs(pole - value))
    except MechanismError:
        poles = []
    beyond = "".join(f", beyond the pole of its curve at {spoken_coordinate(scene, pole)}" for pole in poles[:1])
    at = f"{scene.part.mechanism.coordinate} = {spoken_coordinate(scene, value)}"
    return f"no spindle speed holds the mechanism at {at}{beyond}: the loads do not oppose"


def spoken_coordinate(scene: Scene, value: float) -> str:
    """A value (SI) of the leading coordinate in everyday units."""
    mechanism = scene.part.mechanism
    return spoken(value, "rad" if mechanism.reading(mechanism.coordinate).quantity == "angle" else "m")

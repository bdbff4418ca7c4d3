"""Where a mechanism of mobility one rests: the speed curve over its travel, and every equilibrium at a speed.

Along the coordinate q, with potential V, moment of inertia J about the spindle and inertia I: rest where
V' = J' w^2 / 2; stiffness K = V'' - J'' w^2 / 2; small oscillations K / I, of a free spindle (J0 + J)^-1 w^2 J'^2 / I
more.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import reading_value
from governor_mechanism.equations.reduction import Along, Reduction
from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.scene import Scene

SCAN = 400
"""Points of the travel between which equilibria are looked for, by value and slope: even a pair between two is seen."""

EDGE = 1e-6
"""Fraction of the travel left out at each end, where the linkage stands at a dead centre."""

FLAT = 1e-9
"""A force below this fraction of its parts everywhere makes rest a continuum: the governor is astatic."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A position of rest at a speed: value of the leading coordinate, all readings (SI), and how it holds.

    stiffness K (N m/rad, or N/m); frequency (rad/s) of small oscillations at that speed where it is stable, growth_rate
    (1/s) of a disturbance where it is not, the other one 0; poses (bodies, 3).
    """

    coordinate: float
    readings: Mapping[str, float]
    stiffness: float
    frequency: float
    growth_rate: float
    stable: bool
    poses: Array


@dataclass(frozen=True, kw_only=True)
class SpeedCurve:
    """The speed at which a mechanism rests, over its travel, (n,) arrays.

    Where no speed holds it, `held` is False and speed 0. stiffness K as in Equilibrium; frequency_squared and
    free_frequency_squared (1/s2) at a kept speed and with the spindle left to itself, negative where it grows away.
    folds are the coordinates and speeds at which the curve turns back: the governor jumps there.
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
    folds: tuple[tuple[float, float], ...]
    low_end: str
    high_end: str


def equilibrium_speed(scene: Scene, values: Array) -> Array:
    """Spindle speed (rad/s) at which the mechanism rests at each value (n,) of its leading coordinate.

    Raises MechanismError where no speed holds it, or where it cannot be assembled.
    """
    _require_turning(scene)
    along = Reduction(scene).at(values)
    square = _square(along)
    wrong = np.flatnonzero(~(square > 0.0))
    if wrong.size:
        at = f"{scene.part.mechanism.coordinate} = {along.coordinate[wrong[0]]:.6g}"
        raise MechanismError(f"no spindle speed holds the mechanism at {at}: the loads do not oppose")
    return np.sqrt(square)


def speed_curve(scene: Scene, points: int = 500) -> SpeedCurve:
    """The speed curve over the whole travel, its stability and its folds. Raises MechanismError as `Reduction` does."""
    _require_turning(scene)
    if points < 2:
        raise MechanismError(f"a speed curve needs 2 points or more; got {points!r}")
    reduction = Reduction(scene)
    mechanism = reduction.mechanism
    low, high = travel(mechanism)
    below, above = _ends(mechanism)
    along = reduction.sweep(np.linspace(low, high, points))
    kept, sentence = _within(mechanism, along.poses)
    if sentence:
        low_cut, high_cut = kept.start > 0, kept.stop < points
        below, above = sentence if low_cut else below, sentence if high_cut else above
        low, high = float(along.coordinate[kept.start]), float(along.coordinate[kept.stop - 1])
        along = reduction.sweep(np.linspace(low, high, points))
    square = _square(along)
    held = square > 0.0
    square = np.where(held, square, 0.0)
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
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
        stable=held & (stiffness > 0.0),
        folds=tuple(_folds(reduction, along, held)),
        low_end=below,
        high_end=above,
    )


def find_equilibria(scene: Scene, spindle_speed: float) -> tuple[Equilibrium, ...]:
    """All positions of rest at a spindle speed (rad/s) over the travel, in ascending order of the coordinate.

    Raises MechanismError for a mechanism that rests everywhere (astatic), or whose travel is not known.
    """
    if not isinstance(spindle_speed, int | float):
        raise MechanismError(f"the spindle's speed must be a number (rad/s); got {spindle_speed!r}")
    require_finite(spindle_speed, "rad/s", "the spindle's speed")
    reduction = Reduction(scene)
    low, high = travel(reduction.mechanism)
    square = spindle_speed**2
    along = reduction.sweep(np.linspace(low, high, SCAN + 1))
    force = along.potential_slope - 0.5 * square * along.spindle_slope
    parts = np.abs(along.potential_slope) + 0.5 * square * np.abs(along.spindle_slope)
    if np.all(np.abs(force) <= FLAT * parts):
        raise MechanismError(
            f"at {spindle_speed:.6g} rad/s the mechanism rests everywhere in its travel, {low:.6g} to {high:.6g} of "
            f"{reduction.mechanism.coordinate}: it is astatic"
        )
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
    found: list[Equilibrium] = []
    for index in range(SCAN):
        for root in _roots(along.coordinate, force, stiffness, index):
            rest = _polished(reduction, along, root, index, square)
            if (
                rest is not None
                and not _within(reduction.mechanism, rest.poses[np.newaxis])[1]
                and not (found and abs(rest.coordinate - found[-1].coordinate) < 1e-10)
            ):
                found.append(rest)
    return tuple(found)


def standing_band(scene: Scene, values: Array, resistance: float, reading: str) -> tuple[Array, Array, Array]:
    """Between which speeds a resistance (N, or N m) at a reading holds the mechanism at values (n,) of its coordinate.

    Returns the speeds (rad/s) at which it begins to fall and to rise, and the insensitivity, their difference over the
    speed of rest without resistance. Raises MechanismError where it is held at any speed however low.
    """
    _require_turning(scene)
    reduction = Reduction(scene)
    along = reduction.at(values)
    slope = np.abs(reduction.slopes(along, reading))
    falling, rising = (
        2 * (along.potential_slope + sign * resistance * slope) / along.spindle_slope for sign in (-1.0, 1.0)
    )
    if np.any(falling < 0):
        at = float(along.coordinate[int(np.argmax(falling < 0))])
        raise MechanismError(
            f"a resistance of {resistance:g} holds the mechanism at {scene.part.mechanism.coordinate} = {at:.6g} "
            "even on a spindle that stands"
        )
    slow, fast = np.sqrt(falling), np.sqrt(rising)
    return slow, fast, (fast - slow) / np.sqrt(_square(along))


def travel(mechanism: Mechanism) -> tuple[float, float]:
    """The range of the leading coordinate, a hair inside its limits."""
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate:
            hair = EDGE * (limit.high - limit.low)
            return limit.low + hair, limit.high - hair
    raise MechanismError(
        f"the travel of {mechanism.coordinate!r} is not known; give a start value instead of 'equilibrium'"
    )


def _within(mechanism: Mechanism, poses: Array) -> tuple[slice, str]:
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


def _ends(mechanism: Mechanism) -> tuple[str, str]:
    limit = next(limit for limit in mechanism.limits if limit.reading == mechanism.coordinate)
    return limit.below, limit.above


def _require_turning(scene: Scene) -> None:
    if not (scene.centrifugal and (scene.gravity or scene.part.mechanism.loads)):
        raise MechanismError(
            "an equilibrium speed needs both effects, gravity and centrifugal (or a spring instead of gravity); "
            "list them in the scene"
        )


def _square(along: Along) -> Array:
    """The square (n,) of the speed of rest; -1 where the spindle's turning does nothing."""
    slope = along.spindle_slope
    return np.where(slope != 0.0, 2 * along.potential_slope / np.where(slope != 0.0, slope, 1.0), -1.0)


def _roots(values: Array, force: Array, slope: Array, k: int) -> list[float]:
    """Where the cubic through force and slope at both ends of interval k vanishes."""
    h = values[k + 1] - values[k]
    a, b, c, d = force[k], h * slope[k], force[k + 1], h * slope[k + 1]
    roots = np.roots([2 * a + b - 2 * c + d, -3 * a - 2 * b + 3 * c - d, b, a])
    parts = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-6 and 0.0 <= root.real < 1.0)
    return [float(values[k] + part * h) for part in parts]


def _polished(reduction: Reduction, along: Along, root: float, index: int, square: float) -> Equilibrium | None:
    """The equilibrium that Newton's iteration finds from a guess; None where there is none after all."""
    near, width = along.poses[index], float(along.coordinate[1] - along.coordinate[0])
    value = root
    for _ in range(20):
        here = reduction.at([value], near)
        force = float(here.potential_slope[0] - 0.5 * square * here.spindle_slope[0])
        stiffness = float(here.potential_bend[0] - 0.5 * square * here.spindle_bend[0])
        step = force / stiffness if stiffness else math.inf
        if abs(step) > width:
            return None
        value -= step
        if abs(step) < 1e-14 * max(1.0, abs(value)):
            break
    here = reduction.at([value], near)
    stiffness = float(here.potential_bend[0] - 0.5 * square * here.spindle_bend[0])
    rate = stiffness / float(here.inertia[0])
    mechanism = reduction.mechanism
    return Equilibrium(
        coordinate=float(here.coordinate[0]),
        readings={one.name: float(reading_value(mechanism, one.name, here.poses[0])) for one in mechanism.readings},
        stiffness=stiffness,
        frequency=math.sqrt(rate) if rate > 0 else 0.0,
        growth_rate=math.sqrt(-rate) if rate < 0 else 0.0,
        stable=stiffness > 0,
        poses=here.poses[0],
    )


def _folds(reduction: Reduction, along: Along, held: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Coordinates and speeds where the stiffness at rest changes its sign: K = J' d(w^2)/dq / 2."""

    def stiffness(value: float, near: Array) -> float:
        here = reduction.at([value], near)
        return float((here.potential_bend - 0.5 * _square(here) * here.spindle_bend)[0])

    at_rest = along.potential_bend - 0.5 * _square(along) * along.spindle_bend
    found = []
    for k in np.flatnonzero(held[:-1] & held[1:] & (at_rest[:-1] * at_rest[1:] < 0)).tolist():
        ends = along.coordinate[k], along.coordinate[k + 1]
        value = float(brentq(stiffness, *ends, args=(along.poses[k],), xtol=1e-14, rtol=1e-14))
        found.append((value, float(np.sqrt(_square(reduction.at([value], along.poses[k]))[0]))))
    return found

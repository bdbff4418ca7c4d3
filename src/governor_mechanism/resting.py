"""Where a mechanism of mobility one rests at a given spindle speed: every equilibrium, and how it holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.characteristic import (
    NEUTRAL,
    balances,
    speed_curve,
    spoken_coordinate,
    travel_of,
    within_limits,
)
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import reading_value
from governor_mechanism.equations.reduction import Along, Reduction
from governor_mechanism.errors import MechanismError, require_finite
from governor_mechanism.scene import Scene
from governor_mechanism.units import spoken

SCAN = 400
"""Parts of the travel in which equilibria are looked for, by value and slope: even a pair within one is seen."""

ROUNDING = 1e-14
"""Of the parts of a force: what assembly and arithmetic leave in it."""

EDGE = 1e-6
"""Of a part: a root at its edge must not fall between two."""

SAME = 1e-10
"""rad, and m: equilibria nearer than this are one."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A position of rest at a speed: value of the leading coordinate, all readings (SI), and how it holds.

    stiffness K (N m/rad, or N/m); frequency (rad/s) of small oscillations at that speed where it is stable, growth_rate
    (1/s) of a disturbance where it is not, the other one 0. sensitivity (rad or m) is how far it moves for a relative
    change of speed, w^2 J' / K: large where the governor is nearly astatic; uncertainty (rad or m) is how far rounding
    may have put it. extent is the range over which it rests: one value, or a continuum where it is astatic, with the
    coordinate in its middle, no stiffness, and `stable` False: it neither returns nor leaves. poses (bodies, 3).
    """

    coordinate: float
    extent: tuple[float, float]
    readings: Mapping[str, float]
    stiffness: float
    frequency: float
    growth_rate: float
    sensitivity: float
    uncertainty: float
    stable: bool
    poses: Array

    @property
    def astatic(self) -> bool:
        """Whether it rests over a whole range."""
        return self.extent[1] > self.extent[0]


def find_equilibria(scene: Scene, spindle_speed: float) -> tuple[Equilibrium, ...]:
    """All positions of rest at a spindle speed (rad/s) over the travel, in ascending order of the coordinate.

    Raises MechanismError where there is none, with the speeds at which there are, and where a travel is not known.
    """
    found = rests_at(scene, spindle_speed)
    if not found:
        raise MechanismError(_nowhere(scene, spindle_speed))
    return found


def rests_at(scene: Scene, spindle_speed: float) -> tuple[Equilibrium, ...]:
    """As `find_equilibria`, but nothing where there is none."""
    if not isinstance(spindle_speed, int | float):
        raise MechanismError(f"the spindle's speed must be a number (rad/s); got {spindle_speed!r}")
    require_finite(spindle_speed, "rad/s", "the spindle's speed")
    reduction = Reduction(scene)
    travel = travel_of(scene)
    square = spindle_speed**2
    along = reduction.sweep(np.linspace(travel.low, travel.high, SCAN + 1))
    force, parts = _force(along, square)
    flat = _flat_ranges(np.abs(force) <= NEUTRAL * parts)
    found = [_continuum(reduction, along, span, square) for span in flat]
    stiffness = along.potential_bend - 0.5 * square * along.spindle_bend
    for index in range(SCAN):
        if any(first - 1 <= index <= last for first, last in flat):
            continue
        for root in _roots(along.coordinate, force, stiffness, index):
            rest = _polished(reduction, along, root, index, square, float(np.max(parts[index : index + 2])))
            if rest is not None and not any(abs(rest.coordinate - other.coordinate) < SAME for other in found):
                found.append(rest)
    inside = [rest for rest in found if not within_limits(reduction.mechanism, rest.poses[np.newaxis])[1]]
    return tuple(sorted(inside, key=lambda rest: rest.coordinate))


def _force(along: Along, square: float) -> tuple[Array, Array]:
    """The force (n,) along the coordinate, and the sum of its parts without their signs."""
    pull, swing = along.potential_slope, 0.5 * square * along.spindle_slope
    return pull - swing, np.abs(pull) + np.abs(swing)


def _flat_ranges(flat: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of each run of three or more: a single one is an equilibrium that lies on the grid."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= 3]


def _continuum(reduction: Reduction, along: Along, span: tuple[int, int], square: float) -> Equilibrium:
    """The rest of an astatic mechanism, from one end of its range to the other."""
    middle = (span[0] + span[1]) // 2
    ends = float(along.coordinate[span[0]]), float(along.coordinate[span[1]])
    return _described(reduction, reduction.at([along.coordinate[middle]], along.poses[middle]), square, ends)


def _roots(values: Array, force: Array, slope: Array, k: int) -> list[float]:
    """Where the cubic through force and slope at both ends of interval k vanishes."""
    h = values[k + 1] - values[k]
    a, b, c, d = force[k], h * slope[k], force[k + 1], h * slope[k + 1]
    if min(a, c) > (abs(b) + abs(d)) or max(a, c) < -(abs(b) + abs(d)):
        return []  # farther from nought than its slopes could bring it
    roots = np.roots([2 * a + b - 2 * c + d, -3 * a - 2 * b + 3 * c - d, b, a])
    parts = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-6 and -EDGE <= root.real <= 1 + EDGE)
    return [float(values[k] + part * h) for part in parts]


def _polished(
    reduction: Reduction, along: Along, root: float, index: int, square: float, parts: float
) -> Equilibrium | None:
    """The equilibrium that Newton's iteration finds from a guess; None where there is none after all.

    parts are those of the force near by.
    """
    near, width = along.poses[index], float(along.coordinate[1] - along.coordinate[0])
    value = root
    for _ in range(20):
        here = reduction.at([value], near)
        force = float(_force(here, square)[0][0])
        stiffness = float(here.potential_bend[0] - 0.5 * square * here.spindle_bend[0])
        step = force / stiffness if stiffness else math.inf
        if abs(step) > width:
            return None
        value -= step
        if abs(step) < 1e-14 * max(1.0, abs(value)):
            break
    here = reduction.at([value], near)
    if abs(float(_force(here, square)[0][0])) > 1e3 * ROUNDING * parts:
        return None  # a near miss, beside a fold
    return _described(reduction, here, square, (value, value), parts)


def _described(
    reduction: Reduction, here: Along, square: float, extent: tuple[float, float], parts: float = 0.0
) -> Equilibrium:
    mechanism = reduction.mechanism
    astatic = extent[1] > extent[0]
    stiffness = 0.0 if astatic else float(here.potential_bend[0] - 0.5 * square * here.spindle_bend[0])
    rate = stiffness / float(here.inertia[0])
    grip = abs(square * float(here.spindle_slope[0]))
    return Equilibrium(
        coordinate=float(here.coordinate[0]),
        extent=extent,
        readings={one.name: float(reading_value(mechanism, one.name, here.poses[0])) for one in mechanism.readings},
        stiffness=stiffness,
        frequency=math.sqrt(rate) if rate > 0 else 0.0,
        growth_rate=math.sqrt(-rate) if rate < 0 else 0.0,
        sensitivity=grip / abs(stiffness) if stiffness else math.inf,
        uncertainty=ROUNDING * parts / abs(stiffness) if stiffness else 0.5 * (extent[1] - extent[0]),
        stable=stiffness > 0,
        poses=here.poses[0],
    )


def _nowhere(scene: Scene, speed: float) -> str:
    """That there is no rest at a speed, and at which speeds there is."""
    name, travel = scene.part.mechanism.coordinate, travel_of(scene)
    low, high = (spoken_coordinate(scene, end) for end in (travel.low, travel.high))
    sentence = f"at {_both(abs(speed))} the mechanism rests nowhere in its travel, {name} from {low} to {high}"
    return "; ".join([sentence, *_speeds_of_rest(scene)])


def _both(speed: float) -> str:
    return f"{spoken(speed, 'rad/s')} ({speed:.6g} rad/s)"


def _speeds_of_rest(scene: Scene) -> Iterator[str]:
    """The lowest and the highest speed at which the mechanism rests somewhere, and the poles of its curve."""
    if not balances(scene):
        return
    curve = speed_curve(scene)
    if not curve.held.any():
        yield "no spindle speed holds it anywhere: the loads do not oppose"
        return
    if curve.astatic.all():
        yield f"it is astatic, and rests at {_both(float(np.median(curve.speed)))} only, but there anywhere"
        return
    marks = [*zip(curve.coordinate[curve.held].tolist(), curve.speed[curve.held].tolist(), strict=True), *curve.folds]
    low, high = min(marks, key=lambda mark: mark[1]), max(marks, key=lambda mark: mark[1])
    at = [f"{_both(speed)} at {spoken_coordinate(scene, value)}" for value, speed in (low, high)]
    yield f"it rests at speeds from {at[0]} to {at[1]}"
    for pole in curve.poles:
        yield f"its curve has a pole at {spoken_coordinate(scene, pole)}, where turning loses its grip"

"""Where a mechanism of mobility one rests at a given spindle speed: every equilibrium, and how it holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram
from governor_mechanism.mechanics.reduction.lagrangian import Along, Reduction
from governor_mechanism.model.scene import FASTEST, Scene
from governor_mechanism.statics.adaptive_grid import NEUTRAL, Parts, Scan, Which, off, scan
from governor_mechanism.statics.equilibrium_speed import balances, readings_at, spoken_coordinate, turns
from governor_mechanism.statics.speed_curve import speed_curve
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import parse, spoken

ROUNDING = 1e-14
"""Of the parts of a force: what assembly and arithmetic leave in it."""

EDGE = 1e-6
"""Of the distance of two values: a root at one of them must not fall between two such distances."""

SAME = 1e-10
"""rad, or machine sizes: equilibria nearer than this are one."""

WIDE = 1e-3
"""Of the travel: a stretch without force that is shorter is one equilibrium."""

AGAIN = 4
"""So often the travel between two equilibria is halved where one of the other kind is missing between them."""

TRIES = 60
"""So many steps of Newton's iteration, or halvings where it leaves its bracket, are made for one equilibrium."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A position of rest at a speed: value of the leading coordinate, all readings (SI), and how it holds.

    stiffness K (N m/rad, or N/m); frequency (rad/s) of small oscillations at that speed where it is stable, growth_rate
    (1/s) of a disturbance where it is not, the other one 0. sensitivity (rad or m) is how far it moves for a relative
    change of speed, w^2 J' / K: large where the governor is nearly astatic; uncertainty (rad or m) is how far rounding
    may have put it. extent is the range over which it rests: one value, or a continuum where it is astatic, with the
    coordinate in its middle, no stiffness, and `stable` False: it neither returns nor leaves. The coordinate, and the
    reading of its name, count on over whole turns as the travel does. poses (bodies, 3).
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
    poses: FloatArray

    @property
    def astatic(self) -> bool:
        """Whether it rests over a whole range."""
        return self.extent[1] > self.extent[0]


def find_equilibria(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """All positions of rest at a spindle speed (rad/s; the scene's first if left out), in ascending order.

    They lie in the travel; of a motion that comes round, one at both its ends is found once, at the high one. Raises
    MechanismError where there is none, with the speeds at which there are, for a speed that loads nothing, and where a
    travel is not known.
    """
    found = rests_at(scene, spindle_speed)
    if not found:
        raise MechanismError(_nowhere(Reduction(scene), _asked_speed(scene, spindle_speed)))
    return found


def rests_at(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """As `find_equilibria`, but nothing where there is none."""
    reduction = Reduction(scene)
    speed = _asked_speed(scene, spindle_speed)
    square = speed**2 if turns(scene) else 0.0

    def bent(along: Along, parts: Parts) -> Which:
        force, size = _force(along, square)
        return off(along, parts, force, _stiffness(along, square), NEUTRAL * np.max(size[parts], axis=1))

    looked = scan(reduction).refined(bent)
    for _ in range(AGAIN):
        found = _found(reduction, looked, square)
        missed = _missed(looked, found, square)
        if not missed:
            break
        looked = looked.halved(missed).refined(bent)
    return tuple(_once(reduction, found))


def _asked_speed(scene: Scene, spindle_speed: object) -> float:
    if spindle_speed is None:
        return SpeedProgram(scene.spindle).start_speed
    speed = parse(spindle_speed, "angular_speed", "the spindle's speed")
    if abs(speed) > FASTEST:
        raise MechanismError(f"the spindle's speed must be at most {FASTEST:g} rad/s; got {speed:g} rad/s")
    if speed and not turns(scene):
        raise MechanismError(
            f"a spindle's speed of {_both(abs(speed))} is asked for, but nothing turns with it here: the scene has a "
            "fixed plane, or no effects.centrifugal; leave the speed out"
        )
    return speed


def _found(reduction: Reduction, looked: Scan, square: float) -> list[Equilibrium]:
    """Equilibria between the values of a scan, in ascending order."""
    along = looked.ordered
    force, parts = _force(along, square)
    flat = _flat_ranges(along.coordinate, np.abs(force) <= NEUTRAL * parts)
    found = [_continuum(reduction, along, span, square) for span in flat]
    for index, guess in _guesses(along.coordinate, force, _stiffness(along, square)):
        if any(first - 1 <= index <= last for first, last in flat):
            continue
        rest = _polished(reduction, along, square, index, guess)
        if rest is not None and not _known(found, rest.coordinate, SAME * reduction.unit):
            found.append(rest)
    return sorted(found, key=lambda rest: rest.coordinate)


def _known(found: list[Equilibrium], place: float, same: float) -> bool:
    return any(rest.extent[0] - same < place < rest.extent[1] + same for rest in found)


def _once(reduction: Reduction, found: list[Equilibrium]) -> list[Equilibrium]:
    """Those in the travel; of a motion that comes round, the one at both its ends once."""
    travel, same = reduction.travel, 10 * SAME * reduction.unit
    if not travel.period:
        return found
    inside = [rest for rest in found if travel.low - same < rest.coordinate < travel.high + same]
    return [rest for rest in inside if not _known(inside, rest.coordinate + travel.period, same)]


def _missed(looked: Scan, found: list[Equilibrium], square: float) -> list[tuple[float, float]]:
    """Ranges of the coordinate in which an equilibrium must be missing: stable and unstable ones take turns.

    Beside a stable one the force drives back to it; so it is told from its sign at the ends of the travel too.
    """
    along = looked.ordered
    force = _force(along.chosen(slice(0, 1)), square)[0][0], _force(along.chosen(slice(-1, None)), square)[0][0]
    marks = [
        (float(along.coordinate[0]), 0.0, float(force[0])),
        *((rest.coordinate, -rest.stiffness, rest.stiffness) for rest in found),
        (float(along.coordinate[-1]), float(force[1]), 0.0),
    ]
    return [(here[0], there[0]) for here, there in pairwise(marks) if here[2] * there[1] < 0.0]


def _force(along: Along, square: float) -> tuple[FloatArray, FloatArray]:
    """The force (n,) along the coordinate, and the sum of its parts without their signs."""
    pull, swing = along.potential_slope, 0.5 * square * along.spindle_slope
    return pull - swing, np.abs(pull) + np.abs(swing)


def _stiffness(along: Along, square: float) -> FloatArray:
    stiffness: FloatArray = along.potential_bend - 0.5 * square * along.spindle_bend
    return stiffness


def _flat_ranges(values: FloatArray, flat: Which) -> list[tuple[int, int]]:
    """First and last index of each wide run of three or more; else it is an equilibrium that lies on a value."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    runs = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= 3]
    return [(a, b) for a, b in runs if values[b] - values[a] > WIDE * (values[-1] - values[0])]


def _continuum(reduction: Reduction, along: Along, span: tuple[int, int], square: float) -> Equilibrium:
    """The rest of an astatic mechanism, from one end of its range to the other."""
    travel, middle = reduction.travel, (span[0] + span[1]) // 2
    ends = max(float(along.coordinate[span[0]]), travel.low), min(float(along.coordinate[span[1]]), travel.high)
    return _described(reduction, along.chosen(slice(middle, middle + 1)), square, ends)


def _guesses(values: FloatArray, force: FloatArray, slope: FloatArray) -> Iterator[tuple[int, float]]:
    """Where the cubics through force and slope at both ends of intervals vanish, with the interval's index."""
    h = np.diff(values)
    a, b, c, d = force[:-1], h * slope[:-1], force[1:], h * slope[1:]
    reach = np.abs(b) + np.abs(d)  # no farther could the slopes bring it toward nought
    for k in np.flatnonzero((np.minimum(a, c) <= reach) & (np.maximum(a, c) >= -reach)).tolist():
        cubic = [2 * a[k] + b[k] - 2 * c[k] + d[k], -3 * a[k] - 2 * b[k] + 3 * c[k] - d[k], b[k], a[k]]
        for root in np.roots(cubic):
            if abs(root.imag) < 1e-6 and -EDGE <= root.real <= 1 + EDGE:
                yield k, float(values[k] + root.real * h[k])


def _polished(reduction: Reduction, along: Along, square: float, index: int, guess: float) -> Equilibrium | None:
    """The equilibrium that Newton's iteration finds from a guess between two values; None where there is none.

    Where the force changes its sign between them, its steps are kept there by halving.
    """
    force, parts = _force(along.chosen(slice(index, index + 2)), square)
    low, high = float(along.coordinate[index]), float(along.coordinate[index + 1])
    bracketed, value, width = force[0] * force[1] < 0.0, guess, high - low
    for _ in range(TRIES):
        here = reduction.at([value])
        pull, stiffness = float(_force(here, square)[0][0]), float(_stiffness(here, square)[0])
        if bracketed:
            low, high = (value, high) if pull * force[0] > 0.0 else (low, value)
        step = pull / stiffness if stiffness else math.inf
        aim = value - step
        if bracketed and not low <= aim <= high:
            aim = 0.5 * (low + high)
        elif not bracketed and abs(step) > width:
            return None
        done, value = abs(aim - value) < ROUNDING * max(reduction.unit, abs(value)), aim
        if done:
            break
    here, most = reduction.at([value]), float(np.max(parts))
    if abs(float(_force(here, square)[0][0])) > 1e3 * ROUNDING * most:
        return None  # a near miss beside a fold, or a force that jumps
    return _described(reduction, here, square, (value, value), most)


def _described(
    reduction: Reduction, here: Along, square: float, extent: tuple[float, float], parts: float = 0.0
) -> Equilibrium:
    astatic = extent[1] > extent[0]
    stiffness = 0.0 if astatic else float(_stiffness(here, square)[0])
    rate = stiffness / float(here.inertia[0])
    grip = abs(square * float(here.spindle_slope[0]))
    return Equilibrium(
        coordinate=float(here.coordinate[0]),
        extent=extent,
        readings={name: float(values[0]) for name, values in readings_at(reduction.mechanism, here).items()},
        stiffness=stiffness,
        frequency=math.sqrt(rate) if rate > 0 else 0.0,
        growth_rate=math.sqrt(-rate) if rate < 0 else 0.0,
        sensitivity=grip / abs(stiffness) if stiffness else math.inf,
        uncertainty=ROUNDING * parts / abs(stiffness) if stiffness else 0.5 * (extent[1] - extent[0]),
        stable=stiffness > 0,
        poses=here.poses[0],
    )


def _nowhere(reduction: Reduction, speed: float) -> str:
    """That there is no rest at a speed, and at which speeds there is."""
    scene, travel = reduction.scene, reduction.travel
    low, high = (spoken_coordinate(scene, end) for end in (travel.low, travel.high))
    at = f"at {_both(abs(speed))} " if turns(scene) else ""
    sentence = f"{at}the mechanism rests nowhere in its travel, {reduction.mechanism.coordinate} from {low} to {high}"
    return "; ".join([sentence, *_speeds_of_rest(scene)])


def _both(speed: float) -> str:
    return f"{spoken(speed, 'rad/s')} ({speed:.6g} rad/s)"


def _speeds_of_rest(scene: Scene) -> Iterator[str]:
    """The lowest and the highest speed at which the mechanism rests somewhere, and the poles of its curve."""
    if not balances(scene):
        return
    curve = speed_curve(scene)
    if not curve.held.any():
        yield "no turning spindle holds it anywhere: the loads do not oppose"
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

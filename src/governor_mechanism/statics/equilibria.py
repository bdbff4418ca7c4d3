"""Where a mechanism of mobility one rests at a given spindle speed: every equilibrium, and how it holds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.scene import MAX_SPINDLE_SPEED, Scene
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, AdaptiveGrid, interpolation_error_exceeds, sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import (
    evaluate_readings,
    format_coordinate,
    has_equilibrium_speed,
    has_spindle_dependent_loads,
)
from governor_mechanism.statics.speed_curve import compute_speed_curve
from governor_mechanism.types import BoolArray, FloatArray, IntArray
from governor_mechanism.units.quantities import format_quantity, parse_quantity

FORCE_ROUNDING = 1e-14
"""Of the parts of a force: what assembly and arithmetic leave in it."""

ROOT_INTERVAL_MARGIN = 1e-6
"""Of the distance of two values: a root at one of them must not fall between two such distances."""

MIN_EQUILIBRIUM_SEPARATION = 1e-10
"""rad, or machine sizes: equilibria nearer than this are one."""

MIN_ASTATIC_RANGE_RATIO = 1e-3
"""Of the travel: a stretch without force that is shorter is one equilibrium."""

MAX_REFINEMENTS = 4
"""So often the travel between two equilibria is halved where one of the other kind is missing between them."""

MAX_EQUILIBRIUM_ITERATIONS = 60
"""So many steps of Newton's iteration, or halvings where it leaves its bracket, are made for one equilibrium."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A equilibrium position at a speed: value of the leading coordinate, all readings (SI), and how it holds.

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
    """All equilibrium positions at a spindle speed (rad/s; the scene's first if left out), in ascending order.

    They lie in the travel; of a motion that comes round, one at both its ends is found once, at the high one. Raises
    MechanismError where there is none, with the speeds at which there are, for a speed that loads nothing, and where a
    travel is not known.
    """
    equilibria = find_equilibria_or_empty(scene, spindle_speed)
    if not equilibria:
        raise MechanismError(_no_equilibrium_message(SingleDofReduction(scene), _requested_speed(scene, spindle_speed)))
    return equilibria


def find_equilibria_or_empty(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """As `find_equilibria`, but nothing where there is none."""
    reduction = SingleDofReduction(scene)
    speed = _requested_speed(scene, spindle_speed)
    speed_squared = speed**2 if has_spindle_dependent_loads(scene) else 0.0

    def needs_refinement(coefficients: PathCoefficients, parts: IntArray) -> BoolArray:
        force, force_scale = _generalised_force(coefficients, speed_squared)
        return interpolation_error_exceeds(
            coefficients, parts, force, _stiffness(coefficients, speed_squared), ASTATIC_TOLERANCE * np.max(force_scale[parts], axis=1)
        )

    grid = sample_range_of_motion(reduction).refine(needs_refinement)
    for _ in range(MAX_REFINEMENTS):
        equilibria = _find_in_grid(reduction, grid, speed_squared)
        missing_ranges = _find_missing_ranges(grid, equilibria, speed_squared)
        if not missing_ranges:
            break
        grid = grid.bisect_ranges(missing_ranges).refine(needs_refinement)
    return tuple(_without_periodic_duplicates(reduction, equilibria))


def _requested_speed(scene: Scene, spindle_speed: object) -> float:
    if spindle_speed is None:
        return SpindleSpeedFunction(scene.spindle).start_speed
    speed = parse_quantity(spindle_speed, "angular_speed", "the spindle's speed")
    if abs(speed) > MAX_SPINDLE_SPEED:
        raise MechanismError(f"the spindle's speed must be at most {MAX_SPINDLE_SPEED:g} rad/s; got {speed:g} rad/s")
    if speed and not has_spindle_dependent_loads(scene):
        raise MechanismError(
            f"a spindle's speed of {_format_speed(abs(speed))} is asked for, but nothing turns with it here: the scene has a "
            "fixed plane, or no effects.centrifugal; leave the speed out"
        )
    return speed


def _find_in_grid(reduction: SingleDofReduction, grid: AdaptiveGrid, speed_squared: float) -> list[Equilibrium]:
    """Equilibria between the values of a scan, in ascending order."""
    coefficients = grid.sorted_coefficients
    force, force_scale = _generalised_force(coefficients, speed_squared)
    zero_force_ranges = _zero_force_ranges(coefficients.coordinate, np.abs(force) <= ASTATIC_TOLERANCE * force_scale)
    equilibria = [_astatic_equilibrium(reduction, coefficients, span, speed_squared) for span in zero_force_ranges]
    for index, guess in _cubic_root_guesses(coefficients.coordinate, force, _stiffness(coefficients, speed_squared)):
        if any(first - 1 <= index <= last for first, last in zero_force_ranges):
            continue
        equilibrium = _refine_equilibrium(reduction, coefficients, speed_squared, index, guess)
        if equilibrium is not None and not _is_known(
            equilibria, equilibrium.coordinate, MIN_EQUILIBRIUM_SEPARATION * reduction.coordinate_scale
        ):
            equilibria.append(equilibrium)
    return sorted(equilibria, key=lambda equilibrium: equilibrium.coordinate)


def _is_known(equilibria: list[Equilibrium], value: float, tolerance: float) -> bool:
    return any(rest.extent[0] - tolerance < value < rest.extent[1] + tolerance for rest in equilibria)


def _without_periodic_duplicates(reduction: SingleDofReduction, equilibria: list[Equilibrium]) -> list[Equilibrium]:
    """Those in the travel; of a motion that comes round, the one at both its ends once."""
    travel, tolerance = reduction.range_of_motion, 10 * MIN_EQUILIBRIUM_SEPARATION * reduction.coordinate_scale
    if not travel.period:
        return equilibria
    in_travel = [rest for rest in equilibria if travel.low - tolerance < rest.coordinate < travel.high + tolerance]
    return [rest for rest in in_travel if not _is_known(in_travel, rest.coordinate + travel.period, tolerance)]


def _find_missing_ranges(grid: AdaptiveGrid, equilibria: list[Equilibrium], speed_squared: float) -> list[tuple[float, float]]:
    """Ranges of the coordinate in which an equilibrium must be missing: stable and unstable ones take turns.

    Beside a stable one the force drives back to it; so it is told from its sign at the ends of the travel too.
    """
    coefficients = grid.sorted_coefficients
    end_forces = (
        _generalised_force(coefficients.select(slice(0, 1)), speed_squared)[0][0],
        _generalised_force(coefficients.select(slice(-1, None)), speed_squared)[0][0],
    )
    force_signs = [
        (float(coefficients.coordinate[0]), 0.0, float(end_forces[0])),
        *((rest.coordinate, -rest.stiffness, rest.stiffness) for rest in equilibria),
        (float(coefficients.coordinate[-1]), float(end_forces[1]), 0.0),
    ]
    return [(here[0], there[0]) for here, there in pairwise(force_signs) if here[2] * there[1] < 0.0]


def _generalised_force(coefficients: PathCoefficients, speed_squared: float) -> tuple[FloatArray, FloatArray]:
    """The force (n,) along the coordinate, and the sum of its parts without their signs."""
    load_force, centrifugal_force = (coefficients.potential_derivative, 0.5 * speed_squared * coefficients.spindle_inertia_derivative)
    return load_force - centrifugal_force, np.abs(load_force) + np.abs(centrifugal_force)


def _stiffness(coefficients: PathCoefficients, speed_squared: float) -> FloatArray:
    stiffness: FloatArray = coefficients.potential_second_derivative - 0.5 * speed_squared * coefficients.spindle_inertia_second_derivative
    return stiffness


def _zero_force_ranges(values: FloatArray, is_zero_force: BoolArray) -> list[tuple[int, int]]:
    """First and last index of each wide run of three or more; else it is an equilibrium that lies on a value."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_zero_force.astype(int), [0]])))
    runs = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= 3]
    return [(a, b) for a, b in runs if values[b] - values[a] > MIN_ASTATIC_RANGE_RATIO * (values[-1] - values[0])]


def _astatic_equilibrium(
    reduction: SingleDofReduction, coefficients: PathCoefficients, index_range: tuple[int, int], speed_squared: float
) -> Equilibrium:
    """The rest of an astatic mechanism, from one end of its range to the other."""
    travel, middle = reduction.range_of_motion, (index_range[0] + index_range[1]) // 2
    extent = (
        max(float(coefficients.coordinate[index_range[0]]), travel.low),
        min(float(coefficients.coordinate[index_range[1]]), travel.high),
    )
    return _build_equilibrium(reduction, coefficients.select(slice(middle, middle + 1)), speed_squared, extent)


def _cubic_root_guesses(values: FloatArray, force: FloatArray, force_derivative: FloatArray) -> Iterator[tuple[int, float]]:
    """Where the cubics through force and slope at both ends of intervals vanish, with the interval's index."""
    h = np.diff(values)
    a, b, c, d = force[:-1], h * force_derivative[:-1], force[1:], h * force_derivative[1:]
    max_change = np.abs(b) + np.abs(d)  # no farther could the slopes bring it toward nought
    for k in np.flatnonzero((np.minimum(a, c) <= max_change) & (np.maximum(a, c) >= -max_change)).tolist():
        cubic = [2 * a[k] + b[k] - 2 * c[k] + d[k], -3 * a[k] - 2 * b[k] + 3 * c[k] - d[k], b[k], a[k]]
        for root in np.roots(cubic):
            if abs(root.imag) < 1e-6 and -ROOT_INTERVAL_MARGIN <= root.real <= 1 + ROOT_INTERVAL_MARGIN:
                yield k, float(values[k] + root.real * h[k])


def _refine_equilibrium(
    reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: float, index: int, guess: float
) -> Equilibrium | None:
    """The equilibrium that Newton's iteration finds from a guess between two values; None where there is none.

    Where the force changes its sign between them, its steps are kept there by halving.
    """
    force, force_scales = _generalised_force(coefficients.select(slice(index, index + 2)), speed_squared)
    low, high = float(coefficients.coordinate[index]), float(coefficients.coordinate[index + 1])
    is_bracketed, value, interval_width = force[0] * force[1] < 0.0, guess, high - low
    for _ in range(MAX_EQUILIBRIUM_ITERATIONS):
        local_coefficients = reduction.evaluate([value])
        local_force, stiffness = (
            float(_generalised_force(local_coefficients, speed_squared)[0][0]),
            float(_stiffness(local_coefficients, speed_squared)[0]),
        )
        if is_bracketed:
            low, high = (value, high) if local_force * force[0] > 0.0 else (low, value)
        step = local_force / stiffness if stiffness else math.inf
        next_value = value - step
        if is_bracketed and not low <= next_value <= high:
            next_value = 0.5 * (low + high)
        elif not is_bracketed and abs(step) > interval_width:
            return None
        is_converged, value = (abs(next_value - value) < FORCE_ROUNDING * max(reduction.coordinate_scale, abs(value)), next_value)
        if is_converged:
            break
    local_coefficients, max_force_scale = reduction.evaluate([value]), float(np.max(force_scales))
    if abs(float(_generalised_force(local_coefficients, speed_squared)[0][0])) > 1e3 * FORCE_ROUNDING * max_force_scale:
        return None  # a near miss beside a fold, or a force that jumps
    return _build_equilibrium(reduction, local_coefficients, speed_squared, (value, value), max_force_scale)


def _build_equilibrium(
    reduction: SingleDofReduction,
    coefficients: PathCoefficients,
    speed_squared: float,
    extent: tuple[float, float],
    force_scale: float = 0.0,
) -> Equilibrium:
    is_astatic = extent[1] > extent[0]
    stiffness = 0.0 if is_astatic else float(_stiffness(coefficients, speed_squared)[0])
    frequency_squared = stiffness / float(coefficients.inertia[0])
    force_per_relative_speed = abs(speed_squared * float(coefficients.spindle_inertia_derivative[0]))
    return Equilibrium(
        coordinate=float(coefficients.coordinate[0]),
        extent=extent,
        readings={name: float(values[0]) for name, values in evaluate_readings(reduction.mechanism, coefficients).items()},
        stiffness=stiffness,
        frequency=math.sqrt(frequency_squared) if frequency_squared > 0 else 0.0,
        growth_rate=math.sqrt(-frequency_squared) if frequency_squared < 0 else 0.0,
        sensitivity=force_per_relative_speed / abs(stiffness) if stiffness else math.inf,
        uncertainty=FORCE_ROUNDING * force_scale / abs(stiffness) if stiffness else 0.5 * (extent[1] - extent[0]),
        stable=stiffness > 0,
        poses=coefficients.poses[0],
    )


def _no_equilibrium_message(reduction: SingleDofReduction, speed: float) -> str:
    """That there is no rest at a speed, and at which speeds there is."""
    scene, travel = reduction.scene, reduction.range_of_motion
    low, high = (format_coordinate(scene, end) for end in (travel.low, travel.high))
    speed_clause = f"at {_format_speed(abs(speed))} " if has_spindle_dependent_loads(scene) else ""
    sentence = f"{speed_clause}the mechanism rests nowhere in its travel, {reduction.mechanism.coordinate} from {low} to {high}"
    return "; ".join([sentence, *_equilibrium_speed_sentences(scene)])


def _format_speed(speed: float) -> str:
    return f"{format_quantity(speed, 'rad/s')} ({speed:.6g} rad/s)"


def _equilibrium_speed_sentences(scene: Scene) -> Iterator[str]:
    """The lowest and the highest speed at which the mechanism rests somewhere, and the poles of its curve."""
    if not has_equilibrium_speed(scene):
        return
    curve = compute_speed_curve(scene)
    if not curve.has_equilibrium.any():
        yield "no turning spindle holds it anywhere: the loads do not oppose"
        return
    if curve.astatic.all():
        yield f"it is astatic, and rests at {_format_speed(float(np.median(curve.speed)))} only, but there anywhere"
        return
    curve_points = [
        *zip(curve.coordinate[curve.has_equilibrium].tolist(), curve.speed[curve.has_equilibrium].tolist(), strict=True),
        *curve.folds,
    ]
    low, high = min(curve_points, key=lambda mark: mark[1]), max(curve_points, key=lambda mark: mark[1])
    phrases = [f"{_format_speed(speed)} at {format_coordinate(scene, value)}" for value, speed in (low, high)]
    yield f"it rests at speeds from {phrases[0]} to {phrases[1]}"
    for pole in curve.poles:
        yield f"its curve has a pole at {format_coordinate(scene, pole)}, where turning loses its grip"

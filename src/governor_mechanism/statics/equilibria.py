"""Equilibria of a mechanism with one degree of freedom at a given spindle speed, and their stability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.model.part import MAX_SPINDLE_SPEED
from governor_mechanism.model.scene import Scene
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
"""Rounding error of the generalised force, relative to the magnitude of its terms."""

ROOT_INTERVAL_MARGIN = 1e-6
"""Margin at the ends of an interval, relative to its width, so that a root at a grid value belongs to an interval."""

MIN_EQUILIBRIUM_SEPARATION = 1e-10
"""Distance within which two equilibria are the same, relative to the scale of the coordinate."""

MIN_ASTATIC_RANGE_RATIO = 1e-3
"""Smallest range of neutral equilibrium, relative to the travel; a shorter one is a single equilibrium."""

MAX_REFINEMENTS = 4
"""Largest number of bisections of a range between two equilibria in which one of the other stability is missing."""

MAX_EQUILIBRIUM_ITERATIONS = 60
"""Largest number of Newton or bisection steps for one equilibrium."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """An equilibrium at a given spindle speed.

    Attributes
    ----------
    coordinate
        Value of the leading coordinate, SI, continuous over full turns like the travel; the middle of `extent` if astatic.
    extent
        Range of the coordinate: one value twice, or a range of neutral equilibrium.
    readings
        Readings by name, SI.
    stiffness
        Stiffness K, N m/rad or N/m; 0 if astatic.
    frequency
        Frequency of small oscillations without damping, rad/s; 0 if not stable.
    divergence_rate
        Divergence rate of a disturbance without damping, 1/s; 0 if not unstable.
    sensitivity
        Displacement per relative change of speed, w^2 J' / K, rad or m; large for a nearly astatic governor.
    uncertainty
        Error of the coordinate due to rounding, rad or m.
    stable
        Whether the equilibrium is stable; False if astatic.
    poses
        Poses; shape (bodies, 3).
    """

    coordinate: float
    extent: tuple[float, float]
    readings: Mapping[str, float]
    stiffness: float
    frequency: float
    divergence_rate: float
    sensitivity: float
    uncertainty: float
    stable: bool
    poses: FloatArray

    @property
    def astatic(self) -> bool:
        """Whether the equilibrium is a range."""
        return self.extent[1] > self.extent[0]


def has_damping(scene: Scene) -> bool:
    """Return whether a scene has dashpots or dampers, which frequencies and divergence rates of equilibria leave out.

    Parameters
    ----------
    scene
        Scene of one part.

    Returns
    -------
    bool
        Whether the linearised equations have other growth rates.
    """
    has_dampers = any(isinstance(element, Damper | TorsionDamper) for element in scene.mechanism.force_elements)
    return has_dampers or any(effect.dissipates for effect in output_forces_of(scene))


def find_equilibria(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """Return all equilibria at a spindle speed, in ascending order.

    An equilibrium at both ends of a periodic travel is returned once, at the high end.

    Parameters
    ----------
    scene
        Scene of one part with one degree of freedom.
    spindle_speed
        Spindle speed, rad/s, or text with a unit; the first speed of the scene if None.

    Returns
    -------
    tuple of Equilibrium
        At least one equilibrium.

    Raises
    ------
    MechanismError
        If there is none (the message gives the speeds for which there are some), if the speed has no effect, or if the travel is unknown.
    """
    equilibria = find_equilibria_or_empty(scene, spindle_speed)
    if not equilibria:
        raise MechanismError(_no_equilibrium_message(SingleDofReduction(scene), _requested_speed(scene, spindle_speed)))
    return equilibria


def find_equilibria_or_empty(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """Return all equilibria as `find_equilibria` does, or an empty tuple if there is none."""
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
            f"a spindle's speed of {_format_speed(abs(speed))} has no effect on the loads: the scene has a "
            "fixed plane, or no effects.centrifugal; leave the speed out"
        )
    return speed


def _find_in_grid(reduction: SingleDofReduction, grid: AdaptiveGrid, speed_squared: float) -> list[Equilibrium]:
    """Return the equilibria between the values of a grid, in ascending order."""
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
    return any(equilibrium.extent[0] - tolerance < value < equilibrium.extent[1] + tolerance for equilibrium in equilibria)


def _without_periodic_duplicates(reduction: SingleDofReduction, equilibria: list[Equilibrium]) -> list[Equilibrium]:
    """Return the equilibria within the travel; one at both ends of a periodic travel is returned once."""
    travel, tolerance = reduction.range_of_motion, 10 * MIN_EQUILIBRIUM_SEPARATION * reduction.coordinate_scale
    if not travel.period:
        return equilibria
    in_travel = [equilibrium for equilibrium in equilibria if travel.low - tolerance < equilibrium.coordinate < travel.high + tolerance]
    return [equilibrium for equilibrium in in_travel if not _is_known(in_travel, equilibrium.coordinate + travel.period, tolerance)]


def _find_missing_ranges(grid: AdaptiveGrid, equilibria: list[Equilibrium], speed_squared: float) -> list[tuple[float, float]]:
    """Return ranges of the coordinate in which an equilibrium is missing, since stable and unstable ones alternate.

    The force next to a stable equilibrium restores, so its sign at the ends of the travel counts as well.
    """
    coefficients = grid.sorted_coefficients
    end_forces = (
        _generalised_force(coefficients.select(slice(0, 1)), speed_squared)[0][0],
        _generalised_force(coefficients.select(slice(-1, None)), speed_squared)[0][0],
    )
    force_signs = [
        (float(coefficients.coordinate[0]), 0.0, float(end_forces[0])),
        *((equilibrium.coordinate, -equilibrium.stiffness, equilibrium.stiffness) for equilibrium in equilibria),
        (float(coefficients.coordinate[-1]), float(end_forces[1]), 0.0),
    ]
    return [(here[0], there[0]) for here, there in pairwise(force_signs) if here[2] * there[1] < 0.0]


def _generalised_force(coefficients: PathCoefficients, speed_squared: float) -> tuple[FloatArray, FloatArray]:
    """Return the generalised force (n,) and the sum of the magnitudes of its terms."""
    load_force, centrifugal_force = (coefficients.potential_derivative, 0.5 * speed_squared * coefficients.spindle_inertia_derivative)
    return load_force - centrifugal_force, np.abs(load_force) + np.abs(centrifugal_force)


def _stiffness(coefficients: PathCoefficients, speed_squared: float) -> FloatArray:
    """Return the stiffness K (n,)."""
    stiffness: FloatArray = coefficients.potential_second_derivative - 0.5 * speed_squared * coefficients.spindle_inertia_second_derivative
    return stiffness


def _zero_force_ranges(values: FloatArray, is_zero_force: BoolArray) -> list[tuple[int, int]]:
    """Return first and last index of each wide run of three or more; a narrow one is an equilibrium at a grid value."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], is_zero_force.astype(int), [0]])))
    runs = [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= 3]
    return [(a, b) for a, b in runs if values[b] - values[a] > MIN_ASTATIC_RANGE_RATIO * (values[-1] - values[0])]


def _astatic_equilibrium(
    reduction: SingleDofReduction, coefficients: PathCoefficients, index_range: tuple[int, int], speed_squared: float
) -> Equilibrium:
    """Return the neutral equilibrium over a range of grid indices."""
    travel, middle = reduction.range_of_motion, (index_range[0] + index_range[1]) // 2
    extent = (
        max(float(coefficients.coordinate[index_range[0]]), travel.low),
        min(float(coefficients.coordinate[index_range[1]]), travel.high),
    )
    return _build_equilibrium(reduction, coefficients.select(slice(middle, middle + 1)), speed_squared, extent)


def _cubic_root_guesses(values: FloatArray, force: FloatArray, force_derivative: FloatArray) -> Iterator[tuple[int, float]]:
    """Return roots of the cubic Hermite interpolants of the force, with the indices of their intervals."""
    h = np.diff(values)
    a, b, c, d = force[:-1], h * force_derivative[:-1], force[1:], h * force_derivative[1:]
    max_change = np.abs(b) + np.abs(d)  # largest change that the derivatives allow
    for k in np.flatnonzero((np.minimum(a, c) <= max_change) & (np.maximum(a, c) >= -max_change)).tolist():
        cubic = [2 * a[k] + b[k] - 2 * c[k] + d[k], -3 * a[k] - 2 * b[k] + 3 * c[k] - d[k], b[k], a[k]]
        for root in np.roots(cubic):
            if abs(root.imag) < 1e-6 and -ROOT_INTERVAL_MARGIN <= root.real <= 1 + ROOT_INTERVAL_MARGIN:
                yield k, float(values[k] + root.real * h[k])


def _refine_equilibrium(
    reduction: SingleDofReduction, coefficients: PathCoefficients, speed_squared: float, index: int, guess: float
) -> Equilibrium | None:
    """Return the equilibrium that Newton's method finds from a guess in an interval, or None.

    If the force changes sign in the interval, bisection safeguards the steps.
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
        return None  # no root near a fold, or a discontinuous force
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
        divergence_rate=math.sqrt(-frequency_squared) if frequency_squared < 0 else 0.0,
        sensitivity=force_per_relative_speed / abs(stiffness) if stiffness else math.inf,
        uncertainty=FORCE_ROUNDING * force_scale / abs(stiffness) if stiffness else 0.5 * (extent[1] - extent[0]),
        stable=stiffness > 0,
        poses=coefficients.poses[0],
    )


def _no_equilibrium_message(reduction: SingleDofReduction, speed: float) -> str:
    """Return a sentence that no equilibrium exists at a speed, and at which speeds there is one."""
    scene, travel = reduction.scene, reduction.range_of_motion
    low, high = (format_coordinate(scene, end) for end in (travel.low, travel.high))
    speed_clause = f"at {_format_speed(abs(speed))} " if has_spindle_dependent_loads(scene) else ""
    sentence = f"{speed_clause}the mechanism has no equilibrium in its travel, {reduction.mechanism.coordinate} from {low} to {high}"
    return "; ".join([sentence, *_equilibrium_speed_sentences(scene)])


def _format_speed(speed: float) -> str:
    return f"{format_quantity(speed, 'rad/s')} ({speed:.6g} rad/s)"


def _equilibrium_speed_sentences(scene: Scene) -> Iterator[str]:
    """Return the lowest and highest equilibrium speed and the poles of the curve, as sentences."""
    if not has_equilibrium_speed(scene):
        return
    curve = compute_speed_curve(scene)
    if not curve.has_equilibrium.any():
        yield "no spindle speed balances it anywhere: the loads do not oppose the centrifugal forces"
        return
    if curve.astatic.all():
        yield f"it is astatic, with equilibria at {_format_speed(float(np.median(curve.speed)))} only, but everywhere"
        return
    curve_points = [
        *zip(curve.coordinate[curve.has_equilibrium].tolist(), curve.speed[curve.has_equilibrium].tolist(), strict=True),
        *curve.folds,
    ]
    low, high = min(curve_points, key=lambda mark: mark[1]), max(curve_points, key=lambda mark: mark[1])
    phrases = [f"{_format_speed(speed)} at {format_coordinate(scene, value)}" for value, speed in (low, high)]
    yield f"it has equilibria at speeds from {phrases[0]} to {phrases[1]}"
    for pole in curve.poles:
        yield f"its speed curve has a pole at {format_coordinate(scene, pole)}, where the centrifugal forces have no effect"

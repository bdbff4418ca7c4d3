"""Equilibria at a given spindle speed, their stability, and where loads hold a mechanism on an outline."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of, output_forces_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.range_of_motion import find_runs
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction
from governor_mechanism.mechanics.reduction.lagrangian import PathCoefficients, SingleDofReduction
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.model.results.result import Result, name_values
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.statics.adaptive_grid import ASTATIC_TOLERANCE, interpolation_error_exceeds, sample_range_of_motion
from governor_mechanism.statics.equilibrium_speed import (
    evaluate_readings,
    format_coordinate,
    has_equilibrium_speed,
    has_spindle_dependent_loads,
)
from governor_mechanism.statics.speed_curve import compute_speed_curve
from governor_mechanism.types import BoolArray, FloatArray, IntArray
from governor_mechanism.units.quantities import format_quantity, parse_quantity
from governor_mechanism.units.text_table import short_repr

N_SEARCH_POSITIONS = 1001
"""Positions of the travel between which a contact closes or opens at most once."""

OVERLAP_TOLERANCE = 1e-9
"""Overlap that is rounding, relative to the size of the mechanism."""


@dataclass(frozen=True)
class Rest:
    """A position in which a contact bears the loads."""

    coefficients: PathCoefficients
    contact: str  # name of the contact
    push: float  # normal force, N


def is_free(reduction: SingleDofReduction, poses: FloatArray) -> BoolArray:
    """Return at which of poses (n, bodies, 3) no parts of contacts overlap."""
    least = -OVERLAP_TOLERANCE * reduction.mechanism.length_scale
    free = np.ones(len(poses), dtype=np.bool_)
    for gap in outline_gaps_of(reduction.scene):
        free &= evaluate_output_value(reduction.mechanism, gap.name, poses) >= least
    return free


def find_rests(reduction: SingleDofReduction, force: Callable[[PathCoefficients], FloatArray]) -> Iterator[Rest]:
    """Yield the positions in which a contact is closed and the generalised force (n,) of the loads presses it."""
    gaps = outline_gaps_of(reduction.scene)
    if not gaps:
        return
    travel = reduction.range_of_motion
    searched = reduction.evaluate(np.linspace(travel.low, travel.high, N_SEARCH_POSITIONS)[1:-1])
    for gap in gaps:
        values = evaluate_output_value(reduction.mechanism, gap.name, searched.poses)
        is_open = values > 0.0  # a gap may be exactly closed at a searched position
        for k in np.flatnonzero(is_open[:-1] != is_open[1:]).tolist():
            here = reduction.evaluate([_locate(reduction, gap, (float(searched.coordinate[k]), float(searched.coordinate[k + 1])))])
            push = -float(force(here)[0] / reduction.output_derivative(here, gap.name)[0])
            if push > 0.0 and is_free(reduction, here.poses)[0]:
                yield Rest(here, gap.contact, push)


def _locate(reduction: SingleDofReduction, gap: OutlineGap, bracket: tuple[float, float]) -> float:
    """Return the coordinate between two others at which a contact closes."""
    return find_root(lambda one: float(evaluate_output_value(reduction.mechanism, gap.name, reduction.evaluate([one]).poses)[0]), *bracket)


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Equilibrium(Result):
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
        Stiffness K, N m/rad or N/m; 0 if astatic, infinite where a contact bears the loads.
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
    contact
        Name of the contact that bears the loads; empty for an equilibrium without one.
    push
        Its normal force, N; 0 without one.
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
    contact: str = ""
    push: float = 0.0

    __repr__ = short_repr

    def __post_init__(self) -> None:
        object.__setattr__(self, "readings", name_values("reading", self.readings))

    @property
    def astatic(self) -> bool:
        """Whether the equilibrium is a range."""
        return self.extent[1] > self.extent[0]


def has_damping(scene: Scene) -> bool:
    """Return whether a scene has dashpots or dampers, which frequencies and divergence rates of equilibria leave out."""
    has_dampers = any(isinstance(element, Damper | TorsionDamper) for element in scene.mechanism.force_elements)
    return has_dampers or any(effect.dissipates for effect in output_forces_of(scene))


def find_equilibria(
    scene: Scene,
    # spindle speed, rad/s, or text with a unit; the first speed of the scene if None
    spindle_speed: float | str | None = None,
) -> tuple[Equilibrium, ...]:
    """Return all equilibria at a spindle speed, in ascending order.

    An equilibrium at both ends of a periodic travel is returned once, at the high end.

    Raises MechanismError if there is none (the message gives the speeds for which there are some), if the
    speed has no effect, or if the travel is unknown.
    """
    equilibria = find_equilibria_or_empty(scene, spindle_speed)
    if not equilibria:
        raise MechanismError(_no_equilibrium_message(SingleDofReduction(scene), _requested_speed(scene, spindle_speed)))
    return equilibria


def find_equilibria_or_empty(scene: Scene, spindle_speed: float | str | None = None) -> tuple[Equilibrium, ...]:
    """Return all equilibria as `find_equilibria` does, or an empty tuple if there is none."""
    reduction = SingleDofReduction(scene)
    speed = _requested_speed(scene, spindle_speed)
    search = _EquilibriumSearch(reduction, speed**2 if has_spindle_dependent_loads(scene) else 0.0)
    found = [one for one in search.find() if is_free(reduction, one.poses[np.newaxis])[0]] + search.find_rests()
    return tuple(sorted(found, key=lambda one: one.coordinate))


def _requested_speed(scene: Scene, spindle_speed: object) -> float:
    if spindle_speed is None:
        return SpindleSpeedFunction(scene.spindle).start_speed
    speed = parse_quantity(spindle_speed, "angular_speed", "the spindle's speed")
    if speed and not has_spindle_dependent_loads(scene):
        raise MechanismError(
            f"a spindle's speed of {_format_speed(abs(speed))} has no effect on the loads: the scene has a "
            "fixed plane, or no effects.centrifugal; leave the speed out"
        )
    return speed


@dataclass(frozen=True)
class _EquilibriumSearch:
    """Search for the equilibria of a mechanism at a squared spindle speed."""

    reduction: SingleDofReduction
    speed_squared: float

    def find(self) -> list[Equilibrium]:
        """Return all equilibria in ascending order."""
        reduction = self.reduction
        grid = sample_range_of_motion(reduction).refine(self._needs_refinement)
        travel = reduction.range_of_motion
        for _ in range(MAX_REFINEMENTS):
            equilibria = self._find_in_grid(grid.sorted_coefficients)
            missing_ranges = self._find_missing_ranges(grid.sorted_coefficients, equilibria)
            if not missing_ranges:
                break
            grid = grid.bisect_ranges(missing_ranges).refine(self._needs_refinement)
        if not travel.period:
            return equilibria
        tolerance = 10 * MIN_EQUILIBRIUM_SEPARATION * reduction.coordinate_scale
        return [equilibria[k] for k in travel.find_distinct([equilibrium.extent for equilibrium in equilibria], tolerance)]

    def find_rests(self) -> list[Equilibrium]:
        """Return the equilibria in which a contact bears the loads."""
        return [self._build_rest(rest) for rest in find_rests(self.reduction, lambda coefficients: -self._force(coefficients)[0])]

    def _build_rest(self, rest: Rest) -> Equilibrium:
        value = float(rest.coefficients.coordinate[0])
        return replace(
            self._build_equilibrium(rest.coefficients, (value, value)),
            stiffness=math.inf,
            frequency=0.0,
            divergence_rate=0.0,
            sensitivity=0.0,
            uncertainty=FORCE_ROUNDING * max(self.reduction.coordinate_scale, abs(value)),
            stable=True,
            contact=rest.contact,
            push=rest.push,
        )

    def _force(self, coefficients: PathCoefficients) -> tuple[FloatArray, FloatArray]:
        """Return the generalised force (n,) and the sum of the magnitudes of its terms."""
        terms = coefficients.force_terms(self.speed_squared)
        return terms[0] + terms[1], np.abs(terms[0]) + np.abs(terms[1])

    def _stiffness(self, coefficients: PathCoefficients) -> FloatArray:
        """Return the stiffness K (n,)."""
        first, second = coefficients.stiffness_terms(self.speed_squared)
        stiffness: FloatArray = first + second
        return stiffness

    def _needs_refinement(self, coefficients: PathCoefficients, parts: IntArray) -> BoolArray:
        force, force_scale = self._force(coefficients)
        floor = ASTATIC_TOLERANCE * np.max(force_scale[parts], axis=1)
        return interpolation_error_exceeds(coefficients, parts, force, self._stiffness(coefficients), floor)

    def _find_in_grid(self, coefficients: PathCoefficients) -> list[Equilibrium]:
        """Return the equilibria between the values of a grid, in ascending order."""
        force, force_scale = self._force(coefficients)
        zero_force_ranges = _zero_force_ranges(coefficients.coordinate, np.abs(force) <= ASTATIC_TOLERANCE * force_scale)
        equilibria = [self._astatic_equilibrium(coefficients, first, last) for first, last in zero_force_ranges]
        tolerance = MIN_EQUILIBRIUM_SEPARATION * self.reduction.coordinate_scale
        for index, guess in _cubic_root_guesses(coefficients.coordinate, force, self._stiffness(coefficients)):
            if any(first - 1 <= index <= last for first, last in zero_force_ranges):
                continue
            found = self._refine_equilibrium(coefficients.select(slice(index, index + 2)), guess)
            if found and not any(one.extent[0] - tolerance < found.coordinate < one.extent[1] + tolerance for one in equilibria):
                equilibria.append(found)
        return sorted(equilibria, key=lambda equilibrium: equilibrium.coordinate)

    def _find_missing_ranges(self, coefficients: PathCoefficients, equilibria: list[Equilibrium]) -> list[tuple[float, float]]:
        """Return ranges of the coordinate in which an equilibrium is missing, since stable and unstable ones alternate."""
        # The force next to a stable equilibrium restores, so its sign at the ends of the travel
        # counts as well.
        force = self._force(coefficients)[0].tolist()
        force_signs = [
            (float(coefficients.coordinate[0]), 0.0, force[0]),
            *((equilibrium.coordinate, -equilibrium.stiffness, equilibrium.stiffness) for equilibrium in equilibria),
            (float(coefficients.coordinate[-1]), force[-1], 0.0),
        ]
        return [(here[0], there[0]) for here, there in pairwise(force_signs) if here[2] * there[1] < 0.0]

    def _astatic_equilibrium(self, coefficients: PathCoefficients, first: int, last: int) -> Equilibrium:
        """Return the neutral equilibrium over a range of grid indices."""
        travel = self.reduction.range_of_motion
        middle = (first + last) // 2
        values = coefficients.coordinate
        extent = max(float(values[first]), travel.low), min(float(values[last]), travel.high)
        return self._build_equilibrium(coefficients.select(slice(middle, middle + 1)), extent)

    def _refine_equilibrium(self, ends: PathCoefficients, guess: float) -> Equilibrium | None:
        """Return the equilibrium that Newton's method, safeguarded by bisection, finds from a guess between two grid values, or None."""
        force, force_scales = self._force(ends)
        (low, high), value = ends.coordinate.tolist(), guess
        is_bracketed, interval_width = force[0] * force[1] < 0.0, high - low
        for _ in range(MAX_EQUILIBRIUM_ITERATIONS):
            local_coefficients = self.reduction.evaluate([value])
            local_force = float(self._force(local_coefficients)[0][0])
            stiffness = float(self._stiffness(local_coefficients)[0])
            if is_bracketed:
                low, high = (value, high) if local_force * force[0] > 0.0 else (low, value)
            step = local_force / stiffness if stiffness else math.inf
            next_value = value - step
            if is_bracketed and not low <= next_value <= high:
                next_value = 0.5 * (low + high)
            elif not is_bracketed and abs(step) > interval_width:
                return None
            change, value = abs(next_value - value), next_value
            if change < FORCE_ROUNDING * max(self.reduction.coordinate_scale, abs(value)):
                break
        local_coefficients = self.reduction.evaluate([value])
        max_force_scale = float(np.max(force_scales))
        if abs(float(self._force(local_coefficients)[0][0])) > 1e3 * FORCE_ROUNDING * max_force_scale:
            return None  # no root near a fold, or a discontinuous force
        return self._build_equilibrium(local_coefficients, (value, value), max_force_scale)

    def _build_equilibrium(self, coefficients: PathCoefficients, extent: tuple[float, float], force_scale: float = 0.0) -> Equilibrium:
        stiffness = 0.0 if extent[1] > extent[0] else float(self._stiffness(coefficients)[0])
        frequency_squared = stiffness / float(coefficients.inertia[0])
        force_per_relative_speed = abs(self.speed_squared * float(coefficients.spindle_inertia_derivative[0]))
        return Equilibrium(
            coordinate=float(coefficients.coordinate[0]),
            extent=extent,
            readings={name: float(values[0]) for name, values in evaluate_readings(self.reduction.mechanism, coefficients).items()},
            stiffness=stiffness,
            frequency=math.sqrt(max(0.0, frequency_squared)),
            divergence_rate=math.sqrt(max(0.0, -frequency_squared)),
            sensitivity=force_per_relative_speed / abs(stiffness) if stiffness else math.inf,
            uncertainty=FORCE_ROUNDING * force_scale / abs(stiffness) if stiffness else 0.5 * (extent[1] - extent[0]),
            stable=stiffness > 0,
            poses=coefficients.poses[0],
        )


def _zero_force_ranges(values: FloatArray, is_zero_force: BoolArray) -> list[tuple[int, int]]:
    """Return first and last index of each wide run of three or more; a narrow one is an equilibrium at a grid value."""
    min_range = MIN_ASTATIC_RANGE_RATIO * (values[-1] - values[0])
    return [(a, b) for a, b in find_runs(is_zero_force) if b - a >= 2 and values[b] - values[a] > min_range]


def _cubic_root_guesses(values: FloatArray, force: FloatArray, force_derivative: FloatArray) -> Iterator[tuple[int, float]]:
    """Return roots of the cubic Hermite interpolants of the force, with the indices of their intervals."""
    h = np.diff(values)
    a = force[:-1]
    b = h * force_derivative[:-1]
    c = force[1:]
    d = h * force_derivative[1:]
    max_change = np.abs(b) + np.abs(d)  # largest change that the derivatives allow
    for k in np.flatnonzero((np.minimum(a, c) <= max_change) & (np.maximum(a, c) >= -max_change)).tolist():
        cubic = [2 * a[k] + b[k] - 2 * c[k] + d[k], -3 * a[k] - 2 * b[k] + 3 * c[k] - d[k], b[k], a[k]]
        for root in np.roots(cubic):
            if abs(root.imag) < 1e-6 and -ROOT_INTERVAL_MARGIN <= root.real <= 1 + ROOT_INTERVAL_MARGIN:
                yield k, float(values[k] + root.real * h[k])


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
    low = min(curve_points, key=lambda mark: mark[1])
    high = max(curve_points, key=lambda mark: mark[1])
    phrases = [f"{_format_speed(speed)} at {format_coordinate(scene, value)}" for value, speed in (low, high)]
    yield f"it has equilibria at speeds from {phrases[0]} to {phrases[1]}"
    for pole in curve.poles:
        yield f"its speed curve has a pole at {format_coordinate(scene, pole)}, where the centrifugal forces have no effect"

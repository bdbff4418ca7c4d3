"""Dimensions of any mechanism with which one of its points draws a given path, by least squares from several starts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar, Final

import numpy as np

from governor_mechanism.errors import GovernorMechanismError, MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, solve_kinematics
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns, item_column
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.kinematics import default_values, find_drive
from governor_mechanism.studies.synthesis.tables import PointSource, parse_pair, read_points
from governor_mechanism.studies.unknowns import Unknown, parse_unknowns, scene_with, spread_places
from governor_mechanism.types import FloatArray, IntArray
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import format_quantity

N_POSITIONS: Final = 241
"""Number of positions of a cycle, between which the path is a cubic spline; its error is about 1e-8 of its size."""

SCREENED_PER_UNKNOWN: Final = 20
"""Number of random points per unknown among which further starts are chosen."""

MAX_STEPS: Final = 80
"""Largest number of steps from one start."""

DERIVATIVE_STEP: Final = 1e-6
"""Step of the differences, relative to the width of the bounds."""

SAME_SOLUTION: Final = 1e-3
"""Difference of values, relative to the width of the bounds, within which two solutions are one."""

BOUND_MARGIN: Final = 1e-6
"""Distance from a bound, relative to the width of the bounds, within which a value lies at it."""

CONVERGED: Final = "the search converged"
"""Outcome where a search ended at a minimum."""

NEWTON_STEPS: Final = 8
"""Steps from the nearest position to the nearest point of a path; each doubles the number of right digits."""


@dataclass(frozen=True, kw_only=True)
class DimensionTask:
    """What is sought: unknowns of a scene whose point draws a path while a reading drives it."""

    scene: Scene
    unknowns: tuple[Unknown, ...]
    point: str
    path: FloatArray  # shape (n, 2), m
    drive: str
    between: tuple[float, float] | None  # first and last value of the drive, SI; None for a turn or the whole travel
    n_starts: int
    seed: int

    @property
    def extent(self) -> float:
        """Extent of the path, m."""
        return float(np.max(np.ptp(self.path, axis=0)))


def read_dimension_task(
    scene: Scene,
    over: Mapping[str, Sequence[float | str]] | Sequence[str],
    point: str,
    path: PointSource,
    along: str | None,
    between: Sequence[float | str] | None,
    options: Mapping[str, Any],
) -> DimensionTask:
    """Return the task; raise MechanismError with all mistakes."""
    collector = ProblemCollector()
    unknowns = collector.attempt("", parse_unknowns, scene, over) or ()
    points = collector.attempt("", _read_path, path, len(unknowns))
    drive = along or collector.attempt("", find_drive, scene.part.mechanism) or ""
    ends: tuple[float, float] | None = None
    with collector.at(""):
        kind = "time" if drive == TIME_VARIABLE else scene.part.mechanism.reading(drive).quantity
        if between is not None:
            ends = parse_pair(between, kind, "between")
        elif drive != TIME_VARIABLE and (values := default_values(scene, drive)) is not None and math.isclose(np.ptp(values), math.tau):
            ends = float(values[0]), float(values[-1])  # a crank that turns fully goes on doing so
        names = list(solve_kinematics(scene, drive, default_values(scene, drive)[:1]).paths)
        if point not in names:
            raise MechanismError(
                f"point: there is no {point!r}; points that have paths are {', '.join(names)}.{did_you_mean(point, names)}"
            )
    collector.raise_if_failed()
    task: dict[str, Any] = {"unknowns": unknowns, "point": point, "path": points, "drive": drive, "between": ends, **options}
    return DimensionTask(scene=scene, **task)


def _read_path(source: PointSource, n_unknowns: int) -> FloatArray:
    """Return the points of a path (n, 2), m."""
    points, _ = read_points(source, {"x": "length", "y": "length"})
    if points is None or 2 * len(points) <= n_unknowns or len(points) < 2:
        found = 0 if points is None else len(points)
        raise MechanismError(f"path: {found} points do not determine {n_unknowns} unknowns; give more points, or fewer unknowns")
    if not np.ptp(points, axis=0).any():
        raise MechanismError("path: all points coincide; a path has an extent")
    return points


@dataclass(frozen=True, kw_only=True, eq=False)
class FoundDimensions(Recorded):
    """Values of the unknowns with which the point comes nearest to the path.

    Attributes
    ----------
    number
        Number, the best first.
    values
        Values by key, SI.
    distance
        Root mean square of the distances of the points from the path that is drawn, m.
    largest_distance
        Largest of them, m.
    at_bounds
        Keys of the values that lie at a bound.
    converged
        Whether the search ended at a minimum.
    curve
        Path that is drawn over the whole cycle, m; shape (n, 2).
    nearest
        Its points nearest to those of the given path, in their order, m; shape (n, 2).
    scene
        The scene with these values.
    """

    number: int
    values: Mapping[str, float]
    distance: float
    largest_distance: float
    at_bounds: tuple[str, ...]
    converged: bool
    curve: FloatArray = field(repr=False)
    nearest: FloatArray = field(repr=False)
    scene: Scene = field(repr=False)

    hidden = ("curve", "nearest", "scene")


@dataclass(frozen=True, kw_only=True, eq=False)
class DimensionSynthesis(Result):
    """Dimensions of a mechanism whose point draws a path.

    Attributes
    ----------
    title
        Title of the scene.
    point
        The point.
    path
        The given path, m; shape (n, 2).
    before
        Path that the scene itself draws, m; shape (n, 2).
    keys
        SI units of the unknowns by key.
    rows
        All different solutions, the best first.
    n_evaluations
        Number of scenes tried.
    n_starts
        Number of starts.
    seed
        Seed of the random starts.
    outcome
        How the search ended, in a sentence.
    """

    title: str
    point: str
    path: FloatArray
    before: FloatArray
    keys: Mapping[str, str]
    rows: tuple[FoundDimensions, ...]
    n_evaluations: int
    n_starts: int
    seed: int
    outcome: str

    hidden = ("before",)
    figure: ClassVar[str] = "render.figures.optimum.dimension_figure"
    data_files: ClassVar[tuple[str, ...]] = ("csv", "json")

    @property
    def ok(self) -> bool:
        """Whether a search ended at a minimum."""
        return any(row.converged for row in self.rows)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Number, distances, and the values by key."""
        values = [
            item_column(key, "values", key, heading=key, cell=partial(_format_value, key=key, unit=unit), unit=unit, side="r")
            for key, unit in self.keys.items()
        ]
        distances = [
            Column(name, heading, ".4g/mm", "m") for name, heading in (("distance", "distance, mm"), ("largest_distance", "largest, mm"))
        ]
        notes = Column("at_bounds", "", lambda row: f"at bounds: {', '.join(row.at_bounds)}" if row.at_bounds else "", in_table=False)
        return Column("number", "no.", "d"), *distances, *values, notes

    def __str__(self) -> str:
        ends = f"{self.n_evaluations} scenes tried from {self.n_starts} starts, seed {self.seed}"
        return f"{self.title}: path of {self.point}; {self.outcome}\n{format_columns(self.columns, self.rows)}\n{ends}"


def _format_value(row: FoundDimensions, key: str, unit: str) -> str:
    return format_quantity(row.values[key], unit)


class _PathDistance:
    """Distances of the given points from the path that a scene draws, as a function of the unknowns from 0 to 1 between their bounds."""

    def __init__(self, task: DimensionTask) -> None:
        self.task = task
        self.n_evaluations = 0
        self.best: tuple[float, FloatArray] | None = None
        self._low = np.array([one.low for one in task.unknowns])
        self._width = np.array([one.high for one in task.unknowns]) - self._low

    def scene_at(self, place: FloatArray) -> Scene:
        """Return the scene at a place."""
        return scene_with(self.task.scene, self.task.unknowns, self._low + self._width * place)

    def curve(self, scene: Scene) -> FloatArray:
        """Return the path that a scene draws in a cycle, m; shape (n, 2)."""
        drive, between = self.task.drive, self.task.between
        values = default_values(scene, drive) if between is None else np.linspace(*between, N_POSITIONS)
        return solve_kinematics(scene, drive, values).paths[self.task.point]

    def residuals(self, place: FloatArray) -> FloatArray:
        """Return the distances in x and y, relative to the extent of the path; the extent itself where there is no such mechanism."""
        self.n_evaluations += 1
        try:
            curve = self.curve(self.scene_at(place))
        except GovernorMechanismError:  # an impossible geometry lies outside
            return np.ones(2 * len(self.task.path))
        residuals: FloatArray = (find_nearest(curve, self.task.path) - self.task.path).ravel() / self.task.extent
        cost = float(np.sum(residuals**2))
        if self.best is None or cost < self.best[0]:
            self.best = cost, np.array(place)
        return residuals


def find_nearest(curve: FloatArray, points: FloatArray) -> FloatArray:
    """Return the points (n, 2) of a curve nearest to given ones that it passes in their order, either way, from anywhere if closed."""
    from scipy.interpolate import CubicSpline  # slow to import

    is_closed = bool(np.allclose(curve[0], curve[-1], rtol=0.0, atol=1e-9 * np.ptp(curve)))
    nodes = np.vstack([curve[:-1], curve[:1]]) if is_closed else curve
    spline = CubicSpline(np.arange(len(nodes)), nodes, bc_type="periodic" if is_closed else "not-a-knot")
    looped = np.vstack([nodes[:-1], nodes[:-1]]) if is_closed else nodes
    ways = [_match_in_order(looped, some) for some in (points, points[::-1])]
    indices = ways[0][0] if ways[0][1] <= ways[1][1] else ways[1][0][::-1]
    starts = (indices % (len(nodes) - 1) if is_closed else indices).astype(float)
    places = starts.copy()
    for _ in range(NEWTON_STEPS):
        gaps = spline(places) - points
        slopes = spline(places, 1)
        bends = spline(places, 2)
        squares, curvature = np.sum(slopes**2, axis=1), np.sum(gaps * bends, axis=1)
        # Where the curve bends away too strongly for Newton's method, the step of Gauss and Newton leads down, too.
        steps = np.sum(gaps * slopes, axis=1) / np.where(squares + curvature > 0.1 * squares, squares + curvature, squares)
        places = np.clip(places - steps, starts - 1.0, starts + 1.0)
        places = places if is_closed else np.clip(places, 0.0, len(nodes) - 1.0)
    nearest: FloatArray = spline(places)
    return nearest


def _match_in_order(nodes: FloatArray, points: FloatArray) -> tuple[IntArray, float]:
    """Return for each point the index of a node, never falling, with the least sum of squared distances, and that sum."""
    squares = np.sum((points[:, np.newaxis] - nodes) ** 2, axis=2)
    total, origins = squares[0], list[IntArray]()
    for row in squares[1:]:
        least = np.minimum.accumulate(total)
        origins.append(np.maximum.accumulate(np.where(total == least, np.arange(len(nodes)), 0)))
        total = least + row
    index = int(np.argmin(total))
    indices = [index]
    for origin in reversed(origins):
        indices.append(int(origin[indices[-1]]))
    return np.array(indices[::-1]), float(total[index])


def synthesise_dimensions(task: DimensionTask) -> DimensionSynthesis:
    """Return the dimensions with which the point comes nearest to the path, from several starts; after Ctrl-C those found so far."""
    from scipy.optimize import least_squares  # slow to import

    distance = _PathDistance(task)
    found = list[tuple[FloatArray, bool]]()
    outcome = CONVERGED
    try:
        for start in _choose_starts(distance):
            end = least_squares(
                distance.residuals,
                np.clip(start, 1e-9, 1.0 - 1e-9),
                bounds=(0.0, 1.0),
                diff_step=DERIVATIVE_STEP,
                x_scale=1.0,
                max_nfev=MAX_STEPS,
            )
            found.append((end.x, bool(end.status > 0)))
    except KeyboardInterrupt:
        if distance.best is None:
            raise
        found.append((distance.best[1], False))
        outcome = f"interrupted in start {len(found)} of {task.n_starts}; these are the best values so far"
    rows = _describe_all(distance, found)
    if not any(converged for _, converged in found) and outcome == CONVERGED:
        outcome = f"no convergence within {MAX_STEPS} steps; the values are the best so far"
    return DimensionSynthesis(
        title=task.scene.title,
        point=task.point,
        path=task.path,
        before=distance.curve(task.scene),
        keys={one.key: one.unit for one in task.unknowns},
        rows=rows,
        n_evaluations=distance.n_evaluations,
        n_starts=task.n_starts,
        seed=task.seed,
        outcome=outcome,
    )


def _choose_starts(distance: _PathDistance) -> list[FloatArray]:
    """Return the scene's own values, and the best of random points."""
    task = distance.task
    own = np.array([(one.start - one.low) / (one.high - one.low) for one in task.unknowns])
    if task.n_starts == 1:
        return [own]
    points = spread_places(len(own), task.n_starts - 1, task.seed, SCREENED_PER_UNKNOWN)
    costs = [float(np.sum(distance.residuals(point) ** 2)) for point in points]
    return [own, *(points[k] for k in np.argsort(costs)[: task.n_starts - 1])]


def _describe_all(distance: _PathDistance, found: Sequence[tuple[FloatArray, bool]]) -> tuple[FoundDimensions, ...]:
    """Return all different solutions, the best first."""
    ordered = sorted(found, key=lambda one: float(np.sum(distance.residuals(one[0]) ** 2)))
    kept = list[tuple[FloatArray, bool]]()
    for place, converged in ordered:
        is_possible = not np.all(distance.residuals(place) == 1.0)
        if is_possible and all(float(np.max(np.abs(place - other))) > SAME_SOLUTION for other, _ in kept):
            kept.append((place, converged))
    if not kept:
        raise MechanismError("no values between the bounds give a mechanism that moves through the cycle; choose other bounds")
    rows = [_describe(distance, *one) for one in kept]
    return tuple(replace(row, number=number) for number, row in enumerate(rows, start=1))


def _describe(distance: _PathDistance, place: FloatArray, converged: bool) -> FoundDimensions:
    task, scene = distance.task, distance.scene_at(place)
    curve = distance.curve(scene)
    nearest = find_nearest(curve, task.path)
    gaps = np.hypot(*(nearest - task.path).T)
    return FoundDimensions(
        number=1,
        values={one.key: one.low + (one.high - one.low) * float(x) for one, x in zip(task.unknowns, place, strict=True)},
        distance=float(np.sqrt(np.mean(gaps**2))),
        largest_distance=float(gaps.max()),
        at_bounds=tuple(one.key for one, x in zip(task.unknowns, place, strict=True) if min(x, 1.0 - x) < BOUND_MARGIN),
        converged=converged,
        curve=curve,
        nearest=nearest,
        scene=scene,
    )

"""Path of a coupler's point: four-bars through up to nine points, or along a curve of more, by searches from many random starts.

Each four-bar has two cognates that draw the same path (S. Roberts 1875, P. L. Chebyshev 1878): all three share three fixed pivots, the
foci of the curve, whose triangle is similar to that of the coupler.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Column
from governor_mechanism.studies.synthesis.linkage import DEFECTS, Candidate, FourBarLinkage, Synthesis, SynthesisedLinkage, check_all, judge
from governor_mechanism.studies.synthesis.path_equations import CurveEquations, DyadEquations, as_complex, curve_starts, minimise
from governor_mechanism.studies.synthesis.tables import parse_pivots, read_points, require_count
from governor_mechanism.types import BoolArray, ComplexArray, FloatArray, IntArray
from governor_mechanism.units.problems import FLAG, check_arguments, whole_number
from governor_mechanism.units.text_table import short_repr

COLUMNS: Final = {"x": "length", "y": "length"}
TIMING: Final = {"input_angle": "angle"}
KEYS: Final = ("fixed_pivots", "closed", "starts", "seed")

MAX_POINTS: Final = 1000
N_EXACT: Final = {(False, False): 9, (True, False): 5, (False, True): 5, (True, True): 3}
"""Number of points that determine a linkage: with chosen fixed pivots or not, with a timing of the input or not."""

N_STARTS: Final = {True: 2000, False: 10000}
"""Number of random starts for points that a linkage can pass exactly, and along a curve."""

N_STEPS: Final = 100
N_CURVE_STEPS: Final = 60
PASSES: Final = 1e-20
"""Sum of squared gaps, relative to the extent of the points, below which a linkage passes them; rounding leaves 1e-28."""

SAME_LINKAGE: Final = 1e-5
"""Difference of pivots, relative to the extent of the points or to themselves, within which two linkages are one."""

MAX_RATIO: Final = 1e3
"""Largest ratio of lengths, and of dimensions to the extent of the points, of linkages that the points determine."""

MAX_FREE_RATIO: Final = 5.0
MIN_SEPARATION: Final = 0.3
"""Largest ratio of dimensions to the extent of the points where these leave dimensions free, and along curves; and least distance, in
the same ratio, between linkages that count as different."""

N_ORDERED: Final = 16
"""Number of points of a curve whose order counts."""

N_RUN: Final = 8
"""Number of linkages that are run, the best by the signs of their angles."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PathTask:
    """Points of a path, shape (n,), m, and what is asked of a linkage that draws it."""

    points: ComplexArray
    timing: FloatArray | None  # angles of the input from the first point, rad
    pivots: tuple[complex, complex] | None
    closed: bool
    starts: int
    seed: int

    @property
    def n_exact(self) -> int:
        """Number of points that determine a linkage."""
        return N_EXACT[self.pivots is not None, self.timing is not None]

    @property
    def bound(self) -> float:
        """Largest dimension of a linkage, relative to the extent of the points."""
        return MAX_RATIO if len(self.points) == self.n_exact else MAX_FREE_RATIO

    @property
    def is_curve(self) -> bool:
        """Whether there are too many points to pass all."""
        return len(self.points) > self.n_exact

    @property
    def ordered(self) -> slice:
        """Points that must come in order: all, or some of a curve, whose neighbours may be nearer than the linkage comes to them."""
        return slice(None, None, max(len(self.points) // N_ORDERED, 1) if self.is_curve else 1)


@dataclass(frozen=True, kw_only=True, eq=False)
class PathSynthesis(Synthesis):
    """Four-bars whose coupler's point draws a path.

    Attributes
    ----------
    points
        Points of the path, m; shape (n, 2).
    not_run
        Other linkages that were found, with worse defects or transmission angles; `notes` count their defects.
    """

    points: FloatArray
    not_run: tuple[FourBarLinkage, ...]

    __repr__ = short_repr
    figure = "render.figures.synthesis.path_figure"
    columns = (*Synthesis.columns, Column("cognates", in_table=False))


def read_path_task(source: object, given: Mapping[str, Any]) -> PathTask:
    """Return the task of a file, or of arguments."""
    table, keys = read_points(source, COLUMNS, KEYS, TIMING)
    keys |= {name: value for name, value in given.items() if value is not None}
    if table is None:
        raise MechanismError("the file has no points; write points = [[x, y], ...]")
    pivots = parse_pivots("fixed_pivots", keys.pop("fixed_pivots")) if "fixed_pivots" in keys else None
    timing = table[:, 2] - table[0, 2] if table.shape[1] > 2 else None
    n_exact = N_EXACT[pivots is not None, timing is not None]
    most, hint = (MAX_POINTS, "") if timing is None else (n_exact, "; leave out the input angles, or some points")
    require_count(table[:, :2], range(2, most + 1), "the number of points", hint, is_path=True)
    if timing is not None and not (np.all(np.diff(timing) > 0.0) or np.all(np.diff(timing) < 0.0)):
        raise MechanismError("the input angles must rise from point to point, or fall")
    return _make_task(as_complex(table[:, :2])[:, 0], timing, pivots, **{"starts": N_STARTS[len(table) <= n_exact], **keys})


@check_arguments(closed=FLAG, starts=whole_number(1), seed=whole_number(0))
def _make_task(
    points: ComplexArray,
    timing: FloatArray | None,
    pivots: tuple[complex, complex] | None,
    closed: bool = False,
    starts: int = 1,
    seed: int = 0,
) -> PathTask:
    return PathTask(points=points, timing=timing, pivots=pivots, closed=closed, starts=starts, seed=seed)


@dataclass(frozen=True, kw_only=True, eq=False)
class Linkages:
    """Linkages: fixed pivots (n, 2), moving ones (n, points, 2), places of the point (n, points), and least squares (n,)."""

    fixed: ComplexArray
    moving: ComplexArray
    reached: ComplexArray
    cost: FloatArray

    def __getitem__(self, chosen: Any) -> Linkages:
        return Linkages(fixed=self.fixed[chosen], moving=self.moving[chosen], reached=self.reached[chosen], cost=self.cost[chosen])

    @property
    def lengths(self) -> FloatArray:
        """Lengths of ground, input, coupler and output; shape (n, 4)."""
        start, end = self.moving[:, 0].T
        first, second = self.fixed.T
        lengths: FloatArray = np.abs(np.stack([second - first, start - first, end - start, end - second], axis=1))
        return lengths

    @property
    def is_proper(self) -> BoolArray:
        """Whether no link is a point beside the others."""
        is_proper: BoolArray = self.lengths.min(axis=1) * MAX_RATIO > self.lengths.max(axis=1)
        return is_proper

    def joined(self, other: Linkages) -> Linkages:
        """Return these linkages and others."""
        names = ("fixed", "moving", "reached", "cost")
        return Linkages(**{name: np.concatenate([getattr(self, name), getattr(other, name)]) for name in names})

    def turned_round(self) -> Linkages:
        """Return the linkages with input and output exchanged."""
        return replace(self, fixed=self.fixed[:, ::-1], moving=self.moving[:, :, ::-1])

    def cognate(self) -> Linkages:
        """Return the cognates that share the first fixed pivot."""
        first, second = self.fixed.T
        start, end = self.moving[..., 0], self.moving[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = (self.reached[:, 0] - start[:, 0]) / (end[:, 0] - start[:, 0])
            other_start = first[:, None] + self.reached - start
            other_end = other_start + ratio[:, None] * (start - first[:, None])
        fixed = np.stack([first, first + ratio * (second - first)], axis=1)
        return replace(self, fixed=fixed, moving=np.stack([other_start, other_end], axis=-1))


def find_cognates(linkage: FourBarLinkage) -> tuple[FourBarLinkage, ...]:
    """Return both cognates of a linkage, one where its point is at a moving pivot."""
    one = Linkages(
        fixed=np.array([linkage.fixed]), moving=np.array([[linkage.moving]]), reached=np.array([[linkage.point]]), cost=np.zeros(1)
    )
    found = [_as_linkage(other.cognate(), 0) for other in (one, one.turned_round())]
    return tuple(cognate for cognate in found if cognate.can_be_built)


def _as_linkage(found: Linkages, number: int) -> FourBarLinkage:
    fixed, moving = found.fixed[number], found.moving[number, 0]
    ends = (complex(fixed[0]), complex(fixed[1])), (complex(moving[0]), complex(moving[1]))
    return FourBarLinkage(fixed=ends[0], moving=ends[1], point=complex(found.reached[number, 0]))


def synthesise_path(task: PathTask) -> PathSynthesis:
    """Return the four-bars that draw a path."""
    found = find_linkages(task)
    candidates: list[Candidate] = [
        (_as_linkage(found, k), np.column_stack([found.moving[k], found.reached[k]])) for k in range(min(len(found.cost), N_RUN))
    ]
    rows = _order(check_all(candidates, task.points), task)
    not_run = tuple(_as_linkage(found, k) for k in range(N_RUN, len(found.cost)))
    points = np.column_stack([task.points.real, task.points.imag])
    return PathSynthesis(rows=rows, notes=_notes(task, found, rows), points=points, not_run=not_run)


def find_linkages(task: PathTask) -> Linkages:
    """Return the linkages that are found, each with the cognate and the input that make it the best drive, in the order of their merit."""
    centre = complex(task.points.mean())
    scale = float(np.abs(task.points - centre).max())
    pivots = None if task.pivots is None else ((task.pivots[0] - centre) / scale, (task.pivots[1] - centre) / scale)
    scaled = replace(task, points=(task.points - centre) / scale, pivots=pivots)
    if task.is_curve:
        found = _fit_curve(scaled)
    else:
        found = _arrange(_pass_points(scaled), scaled)
        order = np.argsort(-_score(found, scaled))
        found = found[order if len(task.points) == task.n_exact else _select(found, order)]
        if task.timing is None and not np.any(judge(found.fixed, found.moving).defect == 0):
            near = _fit_curve(scaled)
            found = near[near.cost > PASSES].joined(found)
    return replace(found, **{name: centre + scale * getattr(found, name) for name in ("fixed", "moving", "reached")})


def _select(found: Linkages, order: IntArray) -> IntArray:
    """Return the numbers of the first linkages that differ."""
    places = np.concatenate([found.fixed, found.moving[:, 0]], axis=1)
    kept = list[int]()
    for k in order.tolist():
        if not any(np.abs(places[k] - places[other]).max() < MIN_SEPARATION for other in kept):
            kept.append(k)
        if len(kept) == N_RUN:
            break
    return np.array(kept, dtype=np.int64)


def _order(rows: tuple[SynthesisedLinkage, ...], task: PathTask) -> tuple[SynthesisedLinkage, ...]:
    """Return rows with their cognates, and with what a closed path asks; the nearest first."""
    judged = []
    for row in rows:
        check = row.check
        defects = list(check.defects)
        if task.is_curve and "order" in defects:
            fixed = np.array([row.linkage.fixed])
            moving = row.positions[None, task.ordered, :2]
            defects = [one for one in defects if one != "order" or DEFECTS[judge(fixed, moving).defect[0]] == "order"]
        if task.closed and not check.turns_fully:
            defects.append("no full turn")
        judged.append(replace(row, check=replace(check, defects=tuple(defects)), cognates=find_cognates(row.linkage)))
    rounding = SAME_LINKAGE**2 * np.ptp(np.abs(task.points - task.points[0]))
    judged.sort(key=lambda row: (len(row.check.defects), max(row.check.distance, rounding)))
    return tuple(replace(row, number=number) for number, row in enumerate(judged, start=1))


def _notes(task: PathTask, found: Linkages, rows: tuple[SynthesisedLinkage, ...]) -> tuple[str, ...]:
    kind = "nearest by least squares" if task.is_curve else "different"
    apart = "" if task.pivots else ", cognates apart"
    n_good = sum(not row.check.defects for row in rows)
    notes = [
        f"{len(task.points)} points; {task.n_exact} determine a linkage. "
        f"From {task.starts} random starts (seed {task.seed}), {kind}{apart}: {len(found.cost)}",
        f"{n_good} of the {len(rows)} that were run pass all points in their order",
    ]
    if not task.is_curve and (n_near := int(np.sum(found.cost > PASSES))):
        notes.append(f"no linkage without defects was found that passes all points exactly: {n_near} are the nearest by least squares")
    n_impossible = min(len(found.cost), N_RUN) - len(rows)
    if n_impossible:
        notes.append(f"{n_impossible} could not be run: too large, at a change point, or with the input at a dead position first")
    if len(found.cost) > N_RUN:
        counts = np.bincount(judge(found.fixed, found.moving).defect[N_RUN:], minlength=len(DEFECTS))
        named = ", ".join(f"{name} {count}" for name, count in zip(DEFECTS, counts, strict=True) if count)
        notes.append(f"{counts.sum()} others were not run; their gravest defects by the signs of angles: {named}")
    return tuple(notes)


def _random_starts(equations: DyadEquations, task: PathTask) -> tuple[FloatArray, FloatArray]:
    """Return random linkages at the first point, and the angles of their arms that are nearest to the other points."""
    generator = np.random.default_rng(task.seed)
    unknowns = np.zeros((task.starts, 10 if task.timing is None else 11))
    unknowns[:, :4] = generator.uniform(-1.5, 1.5, (task.starts, 4))
    unknowns[:, 4:8] = generator.normal(0.0, 1.2, (task.starts, 4))
    if task.pivots is not None:
        unknowns[:, :4] = [part for pivot in task.pivots for part in (pivot.real, pivot.imag)]
    pairs = as_complex(unknowns[:, :8])
    links = task.points[0] + pairs[:, 2:] - pairs[:, :2]
    unknowns[:, DyadEquations.LENGTHS] = np.abs(links)
    if task.timing is not None:
        unknowns[:, 10] = np.angle(links[:, 0])
    grid = np.linspace(-np.pi, np.pi, 24, endpoint=False)
    shape = (task.starts, len(task.points))
    gaps = [(equations(unknowns, np.full(shape, angle)).residual ** 2).sum(axis=1) for angle in grid]
    angles = grid[np.argmin(gaps, axis=0)]
    angles[:, 0] = 0.0
    return unknowns, angles


def _similar_starts(task: PathTask, *, is_closed: bool) -> tuple[FloatArray, FloatArray]:
    """Return random linkages whose paths have a shape like that of the points: from them those without defects are found."""
    unknowns, inputs = curve_starts(task.points, is_closed=is_closed, pivots=task.pivots, n_starts=2 * task.starts, seed=task.seed)
    can_move = np.isfinite(CurveEquations.places(unknowns, inputs)[1]).all(axis=1)
    unknowns = unknowns[can_move]
    start, end, direction = CurveEquations.places(unknowns, inputs[can_move])
    point = start[:, 0] + as_complex(unknowns[:, 4:6])[:, 0] * direction[:, 0]
    arms = [part for arm in (start[:, 0] - point, end[:, 0] - point) for part in (arm.real, arm.imag)]
    return np.column_stack([unknowns[:, :4], *arms, unknowns[:, 6], unknowns[:, 8]]), np.angle(direction / direction[:, :1])


def _search_dyads(task: PathTask) -> Linkages:
    """Return where searches from random starts end."""
    equations = DyadEquations(task.points, task.timing)
    starts = [_random_starts(equations, task)]
    if task.timing is None:
        starts += [_similar_starts(task, is_closed=is_closed) for is_closed in (False, True)]
    unknowns, angles = (np.concatenate(parts) for parts in zip(*starts, strict=True))
    free = np.arange(unknowns.shape[1])[0 if task.pivots is None else DyadEquations.PIVOTS.stop :]
    unknowns, angles, cost = minimise(equations, unknowns, angles, free, N_STEPS, task.bound)
    pairs = as_complex(unknowns[:, :8])
    moving = task.points[:, None] + pairs[:, None, 2:] * np.exp(1j * angles)[:, :, None]
    return Linkages(fixed=pairs[:, :2], moving=moving, reached=np.broadcast_to(task.points, angles.shape), cost=cost)


def _pass_points(task: PathTask) -> Linkages:
    """Return all different linkages through the points, of which there are many if they leave dimensions free."""
    found = _search_dyads(task)
    found = found[(found.cost < PASSES) & found.is_proper]
    return _distinct(found[np.argsort(found.cost, kind="stable")], task)  # of those that are the same, the one with the smallest gaps


def _fit_curve(task: PathTask) -> Linkages:
    """Return the different linkages that are nearest to the points by least squares, the nearest first."""
    unknowns, angles = curve_starts(task.points, is_closed=task.closed, pivots=task.pivots, n_starts=task.starts, seed=task.seed)
    free = np.arange(9)[0 if task.pivots is None else DyadEquations.PIVOTS.stop :]
    unknowns, angles, cost = minimise(CurveEquations(task.points), unknowns, angles, free, N_CURVE_STEPS, task.bound)
    start, end, direction = CurveEquations.places(unknowns, angles)
    reached = start + as_complex(unknowns[:, 4:6]) * direction
    found = Linkages(fixed=as_complex(unknowns[:, :4]), moving=np.stack([start, end], axis=-1), reached=reached, cost=cost)
    found = found[np.isfinite(cost)]
    found = _arrange(found[found.is_proper], task)
    return found[_select(found, np.argsort(found.cost))]


def _distinct(found: Linkages, task: PathTask) -> Linkages:
    """Return one linkage of all that are the same, or cognates; those with chosen pivots are compared by their moving ones."""
    if len(task.points) < task.n_exact:
        return found
    if task.pivots is None:
        first, second = found.fixed.T
        third = found.cognate().fixed[:, 1]
        keys = np.stack([first + second + third, first * second + second * third + third * first, first * second * third], axis=1)
    else:
        keys = found.moving[:, 0]
    kept = list[int]()
    for k, key in enumerate(keys):
        if not any(np.all(np.abs(key - keys[other]) < SAME_LINKAGE * (1.0 + np.abs(key))) for other in kept):
            kept.append(k)
    return found[np.array(kept, dtype=np.int64)]


def _arrange(found: Linkages, task: PathTask) -> Linkages:
    """Return of each linkage and its cognates the one that is best as a drive, with either link as input."""
    families = [found]
    if task.pivots is None and task.timing is None:
        families += [found.cognate(), found.turned_round().cognate()]
    options = families if task.timing is not None else [*families, *(one.turned_round() for one in families)]
    best = np.argmax([_score(one, task) for one in options], axis=0)
    rows = np.arange(len(best))
    fixed, moving = (np.array([getattr(one, name) for one in options])[best, rows] for name in ("fixed", "moving"))
    return replace(found, fixed=fixed, moving=moving)


def _score(found: Linkages, task: PathTask) -> FloatArray:
    """Return how good linkages are: built at all, without defects, with a full turn where one is wanted, with a good transmission."""
    with np.errstate(divide="ignore", invalid="ignore"):
        judgement = judge(found.fixed, found.moving[:, task.ordered])
    score = 4.0 * (judgement.defect == 0) + 2.0 * (judgement.turns_fully & task.closed) + judgement.transmission
    is_near = np.abs(found.fixed).max(axis=1) < 2.0 * task.bound
    return np.where(found.is_proper & is_near & np.isfinite(score), score, -1.0)

"""Search for the best values of unknowns under conditions: from several starts with gradients, or over all of the bounds."""

import math
from collections.abc import Iterable, Iterator, MutableMapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.studies.optimisation.question import Question, Values
from governor_mechanism.studies.sweep.workers import RowComputer, compute_all, compute_alone
from governor_mechanism.studies.unknowns import spread_places
from governor_mechanism.types import FloatArray

EXACT_STEP, RUN_STEP = 1e-6, 2e-3
"""Steps of the differences, relative to the width of the bounds: to one side where rounding is the only error, and to both sides with runs
that are accurate to 1e-8, whose errors and those of the differences are then equal."""

CONDITION_MARGIN: Final = 1e-6
"""Distance from a limit, relative to it, that a search keeps: so a new run meets the condition."""

EQUALITY_TOLERANCE: Final = 1e-5
"""Largest difference from the limit of an equality, relative to its scale."""

PENALTY: Final = 1e3
"""Objective and violation where there is no such mechanism, in scales of the objective and of the limits."""

MAX_STEPS: Final = 60
"""Largest number of steps from one start."""

OBJECTIVE_TOLERANCE: Final = 1e-9
"""Change of the objective in a step, relative to its scale, below which a search from a start ends."""

MAX_STEPS_REACHED: Final = 9
"""Status of SLSQP after its largest number of steps."""

FLAT_DISTANCE: Final = 0.02
"""Distance, in widths of the bounds, within which an objective that does not change is constant, or goes in steps."""

ROUNDING: Final = 1e-13
"""Change of an objective, relative to its scale, that is rounding."""

FLAT_CURE: Final = "begin elsewhere, or search globally"
"""What to do where an objective does not change."""

MAX_RESTARTS: Final = 6
RESTART_GAIN: Final = 1e-5
"""Largest number of further searches beside an impossible geometry, and the gain, in scales of the objective, that makes another one."""

SNAP_DISTANCE: Final = 1e-7
"""Distance from a bound, relative to the width of the bounds, within which a place is moved to it."""

POPULATION_PER_UNKNOWN, MAX_GENERATIONS = 8, 60
"""Members of the population of the global search for each unknown, and its largest number of generations."""


class Merit(NamedTuple):
    """How good a place is: less is better; what meets the conditions is better than what does not."""

    violation: float
    objective: float


class Scales:
    """The objective and the conditions of a question in numbers of about one."""

    def __init__(self, question: Question, first: Values) -> None:
        self.question = question
        self.objective = _scale_of(question.scale, _largest(first.numbers[0]), question.objective.scale)
        self.limits = [
            _scale_of(one.scale, one.limit, _largest(values), one.quantity.scale)
            for one, values in zip(question.conditions, first.numbers[1:], strict=True)
        ]

    def objectives(self, values: Values) -> FloatArray:
        """Return the objective to be minimised; of several values the largest counts."""
        if values.problem:
            return np.full(1, PENALTY)
        scaled: FloatArray = self.question.sign * values.numbers[0] / self.objective
        return scaled

    def margins(self, values: Values, *, equalities: bool) -> FloatArray:
        """Return the margins of the inequalities, less that which a search keeps, or the differences of the equalities."""
        chosen = [
            (one.margins(numbers) / scale) - (0.0 if equalities else CONDITION_MARGIN)
            for one, scale, numbers in zip(self.question.conditions, self.limits, values.numbers[1:], strict=True)
            if (one.relation == "=") == equalities
        ]
        return np.concatenate([np.empty(0), *chosen])

    def merit(self, values: Values) -> Merit:
        """Return how good values are."""
        if values.problem:
            return Merit(math.inf, math.inf)
        below = np.maximum(-CONDITION_MARGIN - self.margins(values, equalities=False), 0.0)
        beside = np.maximum(np.abs(self.margins(values, equalities=True)) - EQUALITY_TOLERANCE, 0.0)
        return Merit(float(below.sum() + beside.sum()), float(self.objectives(values).max()))


def _largest(values: FloatArray) -> float:
    return float(np.max(np.abs(values)))


def _scale_of(*candidates: float) -> float:
    """Return the first candidate that is not zero, or 1."""
    return next((abs(one) for one in candidates if one), 1.0)


Journal = MutableMapping[bytes, Values]
"""Values by the bytes of their places, those of an earlier search among them."""


class Search:
    """Places tried so far, with their values; the best of them is kept."""

    def __init__(self, question: Question, journal: Journal | None = None) -> None:
        self.question = question
        self.journal: Journal = {} if journal is None else journal
        self._known: dict[bytes, Values] = {}
        self.scales: Scales | None = None
        self.best: Values | None = None
        self.history: list[tuple[int, float]] = []  # number of places, and the best objective that meets the conditions, SI

    @property
    def n_evaluations(self) -> int:
        """Number of places tried."""
        return len(self._known)

    def at(self, place: FloatArray) -> Values:
        """Return the values at a place."""
        key = np.asarray(place, dtype=np.float64).tobytes()
        if key not in self._known:
            self._take(self.journal.get(key) or self.question.evaluate(place))
        return self._known[key]

    def at_all(self, places: Sequence[FloatArray], compute: RowComputer[Any]) -> list[Values]:
        """Return the values at places, computed here or elsewhere."""
        missing = [place for place in places if place.tobytes() not in self.journal]
        computed = compute_all(compute, partial(_evaluate, self.question, missing), len(missing))
        found = {one.place.tobytes(): one for one in computed}
        self.take_all(self.journal.get(place.tobytes()) or found[place.tobytes()] for place in places)  # in their order
        return [self._known[place.tobytes()] for place in places]

    @property
    def tried(self) -> list[Values]:
        """All places tried, with their values."""
        return list(self._known.values())

    def take_all(self, values: Iterable[Values]) -> None:
        """Keep values that were computed elsewhere."""
        for one in values:
            self._take(one)

    def _take(self, values: Values) -> None:
        """Keep values, also in the journal, and compare them with the best."""
        key = values.place.tobytes()
        if key in self._known:
            return
        self._known[key] = self.journal[key] = values
        if values.problem:
            return
        self.scales = self.scales or Scales(self.question, values)
        merit = self.scales.merit(values)
        if self.best is None or merit < self.scales.merit(self.best):
            self.best = values
            if not merit.violation:
                self.history.append((self.n_evaluations, self.question.sign * merit.objective * self.scales.objective))


def _evaluate(question: Question, places: Sequence[FloatArray], index: int) -> Values:
    return question.evaluate(places[index])


@dataclass(frozen=True)
class End:
    """Where and how a search ended."""

    values: Values
    converged: bool
    outcome: str


def search_locally(search: Search, n_starts: int, seed: int, compute: RowComputer[Any]) -> End:
    """Return the best minimum that is found from the scene's own values and from the best of random points."""
    question = search.question
    starts = [question.start]
    first = search.at(question.start)
    if n_starts > 1:
        points = spread_places(len(question.unknowns), n_starts - 1, seed)
        screened = search.at_all(list(points), compute)
        scales = _scales(search, first)
        starts += [one.place for one in sorted(screened, key=scales.merit)[: n_starts - 1] if not one.problem]
    scales = _scales(search, first)
    starts = [start for start in starts if not search.at(start).problem]
    if compute is compute_alone or len(starts) == 1:
        ends = [_descend_within(search, first, start) for start in starts]
    else:
        found = compute_all(compute, partial(_descend_elsewhere, question, first, starts), len(starts))
        ends = [end for end, _ in found]
        search.take_all(values for _, tried in found for values in tried)
    return min(ends, key=lambda end: scales.merit(end.values))


def _descend_within(search: Search, first: Values, start: FloatArray) -> End:
    """Return where a search from a start ends; what it tried is known to the whole search, also after Ctrl-C."""
    own = Search(search.question, search.journal)
    try:
        own.take_all([first])  # has the scales of all starts
        return descend(own, start)
    finally:
        search.take_all(own.tried)


def _descend_elsewhere(question: Question, first: Values, starts: Sequence[FloatArray], index: int) -> tuple[End, list[Values]]:
    """Return where a search from a start ends, and all places that it tried."""
    search = Search(question)
    end = _descend_within(search, first, starts[index])
    return end, search.tried


def _scales(search: Search, first: Values) -> Scales:
    if search.scales is None:
        raise MechanismError(f"the search cannot begin: {first.problem}; begin with other values, or with more starts")
    return search.scales


def descend(search: Search, start: FloatArray) -> End:
    """Return a minimum near a start, by sequential quadratic programming."""
    # Where a step was turned back by an impossible geometry, the search begins again as long as that
    # gains anything: such a geometry has no gradient along which a search could follow it.
    end, wall = _descend_once(search, start)
    for _ in range(MAX_RESTARTS):
        if not wall:
            return end
        before = end.values
        end, wall = _descend_once(search, before.place)
        if _gain(search, before, end.values) < RESTART_GAIN:
            break
    if not (wall and end.converged):
        return end
    cure = "a bound or a condition keeps a search away from them, and a global search may go on along them"
    return End(end.values, False, f"the search ended beside values that are impossible, {wall}; {cure}")


def _gain(search: Search, before: Values, after: Values) -> float:
    """Return by how much values are better than others, in scaled numbers."""
    scales = _scales(search, before)
    return sum(scales.merit(before)) - sum(scales.merit(after))


def _descend_once(search: Search, start: FloatArray) -> tuple[End, str]:
    """Return where sequential quadratic programming ends, and why the last step that was turned back is impossible, if one was."""
    # Where the objective has several values, a further unknown above all of them is minimised: the
    # largest has kinks where two are equal.
    from scipy.optimize import minimize  # slow to import

    problem = _SmoothProblem(search, len(start))
    first = problem.objectives(start)
    point = np.append(start, first.max()) if problem.has_bound else start
    bounds = [(0.0, 1.0)] * len(start) + [(None, None)] * problem.has_bound
    options = {"maxiter": MAX_STEPS, "ftol": OBJECTIVE_TOLERANCE}
    found = minimize(
        problem.value, point, jac=problem.slope, method="SLSQP", bounds=bounds, constraints=problem.constraints(), options=options
    )
    values = search.at(_inside(found.x[: len(start)]))
    scales, best = _scales(search, values), search.best or values
    if scales.merit(values).violation > 0.0 or found.status != 0:
        values = min(values, best, key=scales.merit)
    if scales.merit(values).violation > 0.0:
        return End(values, False, "no values were found that meet all conditions; these are the nearest"), problem.wall
    if problem.is_flat(values.place):
        return End(values, False, f"{search.question.objective.name} does not change with any of the values there; {FLAT_CURE}"), ""
    if found.status == MAX_STEPS_REACHED:
        return End(values, False, f"no convergence within {MAX_STEPS} steps; the values are the best so far"), ""
    outcome = "the search converged" if found.status == 0 else "the search ended where no step improves the objective"
    return End(values, True, outcome), problem.wall


def _inside(place: FloatArray) -> FloatArray:
    """Return a place between the bounds, exactly at a bound where it is near one: a length of 1e-20 m, and no other, would be refused."""
    inside: FloatArray = np.clip(place, 0.0, 1.0)
    inside[inside < SNAP_DISTANCE] = 0.0
    inside[inside > 1.0 - SNAP_DISTANCE] = 1.0
    return inside


class _SmoothProblem:
    """The question as SLSQP has it, in scaled numbers; where there is no mechanism, a penalty turns the search back."""

    def __init__(self, search: Search, n_unknowns: int) -> None:
        self._search, self._n = search, n_unknowns
        self._scales = _scales(search, Values(np.empty(0), (), "no values"))
        best = search.best
        self.has_bound = best is not None and len(best.numbers[0]) > 1
        self._sizes = [0, 0, 0] if best is None else [len(rows) for rows in self._rows(best)]
        self._jacobians: dict[bytes, list[FloatArray]] = {}
        self.wall = ""

    def _rows(self, values: Values) -> list[FloatArray]:
        """Return objectives, inequalities and equalities."""
        if values.problem:
            return [np.full(size, sign * PENALTY) for size, sign in zip(self._sizes, (1.0, -1.0, 1.0), strict=True)]
        margins = (self._scales.margins(values, equalities=is_equal) for is_equal in (False, True))
        return [self._scales.objectives(values), *margins]

    def objectives(self, place: FloatArray) -> FloatArray:
        """Return the objectives at a place."""
        return self._rows(self._at(place))[0]

    def _at(self, point: FloatArray) -> Values:
        values = self._search.at(_inside(point[: self._n]))
        self.wall = values.problem or self.wall
        return values

    def _jacobian(self, point: FloatArray) -> list[FloatArray]:
        """Return the derivatives of objectives, inequalities and equalities (values, unknowns) by differences within the bounds."""
        place = _inside(point[: self._n])
        key = place.tobytes()
        if key not in self._jacobians:
            self._jacobians[key] = [
                np.stack(rows, axis=-1) for rows in zip(*map(partial(self._slope_along, place), range(self._n)), strict=True)
            ]
        return self._jacobians[key]

    def _slope_along(self, place: FloatArray, k: int) -> list[FloatArray]:
        """Return the derivatives along an unknown; zero where no mechanism is beside the place."""
        is_exact = self._search.question.is_exact
        step = EXACT_STEP if is_exact else RUN_STEP
        offsets = [sign * step for sign in (-1.0, 1.0) if 0.0 <= place[k] + sign * step <= 1.0]
        shifts = sorted([0.0, *(offsets[:1] if is_exact else offsets)])
        ends = [(shift, self._search.at(place + shift * (np.arange(self._n) == k))) for shift in shifts]
        usable = [(offset, self._rows(values)) for offset, values in ends if not values.problem]
        if len(usable) < 2:
            return [np.zeros(size) for size in self._sizes]
        (before, first), (after, last) = usable[0], usable[-1]
        return [(end - begin) / (after - before) for begin, end in zip(first, last, strict=True)]

    def is_flat(self, place: FloatArray) -> bool:
        """Return whether no difference around a place changes the objective, which then is constant there, or goes in steps."""
        step = EXACT_STEP if self._search.question.is_exact else RUN_STEP
        if np.max(np.abs(self._jacobian(place)[0])) * step > ROUNDING:
            return False
        here = self._rows(self._search.at(place))[0]
        around = [np.clip(place + shift, 0.0, 1.0) for row in FLAT_DISTANCE * np.eye(self._n) for shift in (-row, row)]
        return all(np.max(np.abs(self._rows(self._search.at(one))[0] - here)) <= ROUNDING for one in around)

    def value(self, point: FloatArray) -> float:
        """Return the objective, or the unknown above all of its values."""
        return float(point[-1]) if self.has_bound else float(self.objectives(point).max())

    def slope(self, point: FloatArray) -> FloatArray:
        """Return the derivative of that."""
        slope: FloatArray = np.eye(len(point))[-1] if self.has_bound else self._jacobian(point)[0][0]
        return slope

    def constraints(self) -> list[dict[str, Any]]:
        """Return the inequalities and the equalities."""
        made = []
        if self._sizes[1] or self.has_bound:
            made.append({"type": "ineq", "fun": self._inequalities, "jac": self._inequality_slopes})
        if self._sizes[2]:
            made.append({"type": "eq", "fun": lambda point: self._rows(self._at(point))[2], "jac": lambda point: self._slopes(point, 2)})
        return made

    def _inequalities(self, point: FloatArray) -> FloatArray:
        objectives, margins, _ = self._rows(self._at(point))
        return np.concatenate([point[-1] - objectives, margins]) if self.has_bound else margins

    def _inequality_slopes(self, point: FloatArray) -> FloatArray:
        margins = self._slopes(point, 1)
        if not self.has_bound:
            return margins
        below = np.hstack([-self._jacobian(point)[0], np.ones((self._sizes[0], 1))])
        return np.vstack([below, margins])

    def _slopes(self, point: FloatArray, rows: int) -> FloatArray:
        """Return derivatives by all unknowns, of which the one above the objectives has no influence."""
        slopes = self._jacobian(point)[rows]
        return np.hstack([slopes, np.zeros((len(slopes), 1))]) if self.has_bound else slopes


def search_globally(search: Search, seed: int, compute: RowComputer[Values]) -> End:
    """Return the best values between all bounds, by differential evolution, and a search with gradients from the best."""
    from scipy.optimize import differential_evolution  # slow to import

    question = search.question
    search.at(question.start)

    def costs(_: object, places: Iterator[FloatArray]) -> list[float]:
        values = search.at_all([np.array(place) for place in places], compute)
        return [_cost(search.scales, one) for one in values]

    found = differential_evolution(
        float,  # is not called: all members of a generation are computed at once
        [(0.0, 1.0)] * len(question.unknowns),
        popsize=POPULATION_PER_UNKNOWN,
        maxiter=MAX_GENERATIONS,
        tol=1e-3,
        rng=seed,
        polish=False,
        x0=question.start,
        updating="deferred",
        workers=costs,
    )
    if search.best is None:
        raise MechanismError("no values between the bounds give a mechanism with these quantities; choose other bounds")
    end = descend(search, search.best.place)
    within = f"{found.nit} generations" if found.success else f"the {MAX_GENERATIONS} generations allowed"
    return End(end.values, end.converged, f"{end.outcome}, after a global search of {within}")


def _cost(scales: Scales | None, values: Values) -> float:
    """Return a cost by which what meets the conditions is better than what does not, and any mechanism than none."""
    if scales is None or values.problem:
        return 1.0 + PENALTY
    violation, objective = scales.merit(values)
    return 1.0 + min(violation, PENALTY) if violation else objective / (1.0 + abs(objective))

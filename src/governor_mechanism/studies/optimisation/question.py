"""What an optimisation asks: an objective and conditions, read from text or functions, and their values at a place between the bounds."""

import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from governor_mechanism.engines.selection import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError, did_you_mean
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.sweep.quantities import SCENE_RULES, RunQuantity, parse_quantities
from governor_mechanism.studies.sweep.rules import VALVE_RULES, MissingNumberError, RunNumbers, evaluate_valve_rule
from governor_mechanism.studies.sweep.workers import find_computer_problems
from governor_mechanism.studies.unknowns import Unknown, parse_unknowns, scene_with
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, number_or_text, read_quantity

SEARCH_ACCURACY: Final = 1e-8
"""Accuracy of the runs of a search: their differences are divided by small steps."""

CONDITION_EXAMPLE: Final = '"max sleeve_lift <= 120 mm"'
"""Example of a condition in messages."""

_CONDITION: Final = re.compile(r"(.+?)\s*(<=|>=|==?|<|>)\s*(.+)")

METHODS: Final = ("local", "global")
"""Methods of a search."""

_OBJECTIVES: Final = {1: '"max sleeve_lift"', 2: '["max sleeve_lift", "sensitiveness"]'}
"""Examples of objectives in messages, by their number."""

SCENE_PARAMETER: Final = "scene"
"""Name of the parameter of a function that needs no run."""

Objective = str | Callable[[Trajectory], float | FloatArray] | Callable[[Scene], float | FloatArray]
"""A quantity by its rule or its name, or a function of a run, or of a scene if its parameter is called `scene`."""


@dataclass(frozen=True, kw_only=True)
class Condition:
    """A condition on a quantity: all its values are at most, at least or exactly a limit, SI."""

    quantity: RunQuantity
    relation: str  # "<=", ">=" or "="
    limit: float
    scale: float = 0.0  # size of its quantity in the search, SI; 0 takes that of the limit

    def margins(self, values: FloatArray) -> FloatArray:
        """Return by how much values, SI, keep the limit; negative where they do not. For an equality, the difference."""
        return self.limit - values if self.relation == "<=" else values - self.limit


class Values(NamedTuple):
    """Values of the quantities of a question at a place; none, and the reason, where there is no such mechanism or number."""

    place: FloatArray  # unknowns between their bounds, from 0 to 1
    numbers: tuple[FloatArray, ...]  # values of each quantity, SI: of several, as in several gears, the worst counts
    problem: str = ""


@dataclass(frozen=True, kw_only=True)
class Question:
    """What is sought: unknowns of a scene, the objective, and the conditions; it can be pickled if its functions can be."""

    scene: Scene
    unknowns: tuple[Unknown, ...]
    objective: RunQuantity
    sign: float  # 1 if the objective is minimised, -1 if it is maximised
    conditions: tuple[Condition, ...]
    reported: tuple[RunQuantity, ...]  # further quantities, which the result states before and after
    others: tuple[tuple[RunQuantity, float], ...]  # further objectives of a trade-off, with their signs
    engine: str
    accuracy: float
    scale: float = 0.0  # size of the objective in the search, SI; 0 takes that of its first value

    @property
    def quantities(self) -> tuple[RunQuantity, ...]:
        """Quantities of the search: the objective, and one for each condition."""
        return self.objective, *(one.quantity for one in self.conditions)

    @property
    def start(self) -> FloatArray:
        """Place of the scene itself."""
        return np.array([(one.start - one.low) / (one.high - one.low) for one in self.unknowns])

    @property
    def is_exact(self) -> bool:
        """Whether no quantity needs a run, so that rounding is the only error."""
        return all(_is_of_scene(one) and one.function is None for one in self.quantities)

    def values_at(self, place: FloatArray) -> list[float]:
        """Return the values of the unknowns, SI."""
        return [one.low + (one.high - one.low) * float(x) for one, x in zip(self.unknowns, place, strict=True)]

    def scene_at(self, place: FloatArray) -> Scene:
        """Return the scene at a place; raise MechanismError if there is none."""
        return scene_with(self.scene, self.unknowns, self.values_at(place))

    def evaluate(self, place: FloatArray) -> Values:
        """Return the values of the quantities; an impossible geometry, or a run without a number, has a reason instead."""
        try:
            return Values(np.array(place), evaluate_quantities(self, self.scene_at(place), self.quantities))
        except GovernorMechanismError as error:
            return Values(np.array(place), (), "; ".join(getattr(error, "problems", (str(error),))))
        except MissingNumberError as error:
            return Values(np.array(place), (), str(error))


def _is_of_scene(quantity: RunQuantity) -> bool:
    """Return whether a quantity needs no run."""
    if quantity.function is None:
        return quantity.rule in SCENE_RULES or quantity.rule in VALVE_RULES
    with suppress(TypeError, ValueError):  # no signature is known
        return SCENE_PARAMETER in inspect.signature(quantity.function).parameters
    return False


def evaluate_quantities(question: Question, scene: Scene, quantities: Sequence[RunQuantity]) -> tuple[FloatArray, ...]:
    """Return the values of quantities of a scene, which is run if one of them needs it; equal ones are computed once."""
    numbers: RunNumbers | None = None
    if not all(map(_is_of_scene, quantities)):
        name = scene.run.engine if question.engine == "auto" else question.engine
        engine, reason = select_engine(name, scene, question.accuracy)
        run = engine.run(scene, accuracy=question.accuracy, certify=False, reason=reason)
        if not run.outcome.ok and run.outcome is not Outcome.ACCURACY_MISSED:
            raise MechanismError(run.message)
        numbers = RunNumbers(run)
    return tuple(_take(one, scene, numbers) for one in quantities)


def _take(quantity: RunQuantity, scene: Scene, numbers: RunNumbers | None) -> FloatArray:
    """Return the values of a quantity, one or several."""
    if quantity.rule in SCENE_RULES:
        values = SCENE_RULES[quantity.rule].take(scene)
    elif quantity.rule in VALVE_RULES:
        values = np.array([evaluate_valve_rule(quantity.rule, scene)])
    elif quantity.function is None:
        values = np.array([quantity.evaluate(numbers)]) if numbers else np.empty(0)
    else:
        given = scene if _is_of_scene(quantity) or numbers is None else numbers.run
        try:
            values = np.atleast_1d(np.asarray(quantity.function(given), dtype=np.float64)).ravel()
        except GovernorMechanismError:
            raise
        except Exception as error:  # a function of the caller raises any error
            raise MechanismError(f"quantity {quantity.name!r}: the function failed with {type(error).__name__}: {error}") from error
    if not values.size or not np.isfinite(values).all():
        raise MechanismError(f"quantity {quantity.name!r} is not a finite number: {values.tolist()}")
    return values


class QuestionReader:
    """Reader of objectives and conditions of a scene, with names of the caller for rules and functions."""

    def __init__(
        self,
        scene: Scene,
        *,
        engine: str,
        accuracy: float | None,
        workers: int,
        cluster: object,
        named: Mapping[str, Objective] | None,
        is_kept: bool = False,  # whether a file keeps what was computed, which needs the identity of functions
    ) -> None:
        self._scene = scene
        self._named = named or {}
        self._engine = engine
        self._accuracy = SEARCH_ACCURACY if accuracy is None else accuracy
        self._needs_names = workers != 1 or cluster is not None or is_kept
        self._problems = find_computer_problems(workers, cluster)
        if not 0.0 < self._accuracy < 1.0:
            self._problems.append(f"accuracy must lie between 0 and 1; found {format_value(accuracy)}")

    def read(
        self,
        over: Mapping[str, Sequence[float | str]] | Sequence[str],
        minimise: Sequence[Objective],
        maximise: Sequence[Objective],
        subject_to: Sequence[str],
        method: str,
        report: Sequence[Objective] = (),
        n_objectives: int = 1,
    ) -> Question:
        """Return the question; raise MechanismError with all mistakes."""
        collector = ProblemCollector()
        unknowns = collector.attempt("", parse_unknowns, self._scene, over) or ()
        collector.attempt("", select_engine, self._engine, self._scene)
        signs = [1.0] * len(minimise) + [-1.0] * len(maximise)
        objectives = [collector.attempt("", self._quantity, one) for one in (*minimise, *maximise)]
        conditions = [collector.attempt("", self._condition, one) for one in subject_to]
        reported = [collector.attempt("", self._quantity, one) for one in report]
        problems = [*self._problems, *collector.problems]
        if len(signs) != n_objectives:
            what = "one quantity" if n_objectives == 1 else "two quantities together"
            problems.append(f"minimise and maximise need {what}, as minimise={_OBJECTIVES[n_objectives]}; found {len(signs)}")
        if method not in METHODS:
            problems.append(f"method must be one of {', '.join(METHODS)}; found {format_value(method)}.{did_you_mean(method, METHODS)}")
        if problems:
            raise MechanismError(*dict.fromkeys(problems))
        known = [(one, sign) for one, sign in zip(objectives, signs, strict=True) if one is not None]
        return Question(
            scene=self._scene,
            unknowns=unknowns,
            objective=known[0][0],
            sign=known[0][1],
            conditions=tuple(one for one in conditions if one is not None),
            reported=tuple(one for one in reported if one is not None),
            others=tuple(known[1:]),
            engine=self._engine,
            accuracy=self._accuracy,
        )

    def _quantity(self, given: object) -> RunQuantity:
        """Return a quantity by a rule, a name of the caller, or a function."""
        name = str(given).strip() if isinstance(given, str) else getattr(given, "__name__", "function")
        rule = self._named.get(name, given) if isinstance(given, str) else given
        if not callable(rule):
            return parse_quantities(self._scene, {name: rule.strip() if isinstance(rule, str) else rule}, self._accuracy, certify=False)[0]
        if self._needs_names:
            return parse_quantities(self._scene, {name: rule}, self._accuracy, certify=False)[0]
        return RunQuantity(name=name, function=rule)

    def _condition(self, text: object) -> Condition:
        """Return the condition of a text such as "max sleeve_lift <= 120 mm"."""
        parts = _CONDITION.fullmatch(text.strip().replace("≤", "<=").replace("≥", ">=")) if isinstance(text, str) else None
        if parts is None:
            raise MechanismError(
                f"subject_to: {format_value(text)} is no condition; write a quantity, <=, >= or =, and a limit, as {CONDITION_EXAMPLE}"
            )
        name, relation, limit = parts.groups()
        if relation in "<>":
            raise MechanismError(f"subject_to: {format_value(text)} has {relation}; write {relation}=, which a search can meet exactly")
        quantity = self._quantity(name)
        return Condition(quantity=quantity, relation=relation[0] if relation == "==" else relation, limit=_read_limit(limit, quantity))


def _read_limit(text: str, quantity: RunQuantity) -> float:
    """Return the limit of a quantity, SI, from a bare number in SI or a number with a unit."""
    what, number = f"subject_to: the limit of {quantity.name}", number_or_text(text)
    if isinstance(number, float):
        return number
    # The unit of a function is not known.
    kinds = [kind for kind, one in QUANTITY_KINDS.items() if one.si_unit == quantity.unit and not quantity.function]
    problems = list[str]()
    for kind in QUANTITY_KINDS if quantity.function else kinds:
        try:
            return read_quantity(number, kind, what)
        except MechanismError as error:
            problems += error.problems
    raise MechanismError(problems[0] if kinds else f"{what} is a number; found {format_value(text)}")

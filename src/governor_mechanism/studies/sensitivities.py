"""Derivatives of readings and of numbers taken from a run by the keys of its scene, with their errors.

Central differences of certified runs at two steps, extrapolated. The error of a derivative has two parts: the errors of the runs divided by
the step, and the rest of the extrapolation.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any, ClassVar, Final

import numpy as np

from governor_mechanism.engines.selection import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.studies.sweep.quantities import RATE_PREFIX, RunQuantity, parse_quantities, split_rule
from governor_mechanism.studies.sweep.rules import STATISTICS, MissingNumberError, RunNumbers
from governor_mechanism.studies.sweep.workers import row_computer
from governor_mechanism.studies.unknowns import value_of_key, write_value
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import QUANTITY_KINDS

DEFAULT_ACCURACY: Final = 1e-10
"""Accuracy of the runs: their errors are divided by the step."""

STEP_RATIO: Final = 5e-4
"""Larger step of a key relative to its value. With runs accurate to 1e-10 both parts of the error are then about 1e-7."""

OFFSETS: Final = (-1.0, -0.5, 0.5, 1.0)
"""Where runs are made around the value of a key, in steps."""

NOISE_FACTOR: Final = 3.0
"""Sum of the absolute weights of the extrapolated difference: (8 (f(h/2) - f(-h/2)) - (f(h) - f(-h))) / 6 h."""

KINK_RATIO: Final = 0.375
"""Ratio of the second differences at half and whole step above which a value has a kink: a quarter if it is smooth, a half at a kink."""

EXTREMES: Final[Mapping[str, tuple[int, int]]] = {"min": (1, 0), "max": (0, 1), "span": (-1, 1)}
"""Numbers that are values at the time of the least and of the greatest one, with the weights of both."""

TURNING_EVENTS: Final = frozenset((EventKind.TURNING_POINT, EventKind.CHANGE_POINT, EventKind.CROSSING))
"""Events at which nothing acts."""


@dataclass(frozen=True, kw_only=True)
class Sensitivity(Recorded):
    """Derivative of a number taken from a run by a key of the scene."""

    of: str  # name of the number
    by: str  # the key
    value: float | None  # derivative, SI; None where it does not exist
    error: float | None  # error of the derivative, SI; None where it does not exist
    unit: str  # unit of the derivative, SI
    # relative change of the number by relative change of the key; None where it does not exist, or the number
    # is zero
    elasticity: float | None = None
    refusal: str = ""  # why there is no derivative; empty if there is one


def _text_of(row: Sensitivity) -> str:
    return row.refusal if row.value is None else f"{row.value:.7g} ± {row.error:.1g} {row.unit}"


@dataclass(frozen=True, kw_only=True, eq=False)
class Sensitivities(Result):
    """Derivatives of numbers by keys.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        A derivative for each number and key.
    times
        Reported times of the runs, s; shape (n,).
    histories
        Derivative of each reading that is asked for by its bare name, at all times, by reading and key, SI; shape (n,).
    accuracy
        Relative accuracy of the runs.
    n_runs
        Number of runs.
    """

    title: str
    rows: tuple[Sensitivity, ...]
    times: FloatArray
    histories: Mapping[tuple[str, str], FloatArray]
    accuracy: float
    n_runs: int

    hidden = ("histories", "times")
    data_files = ("csv", "json")
    drawn = ("elasticity",)
    columns: ClassVar[tuple[Column, ...]] = (
        Column("of", "number"),
        Column("by", "key"),
        Column("", "derivative", _text_of),
        Column("value"),
        Column("error"),
        Column("unit"),
        Column("elasticity", "relative", ".4g"),
        Column("refusal"),
    )

    @property
    def ok(self) -> bool:
        """Whether all derivatives exist."""
        return not any(row.refusal for row in self.rows)

    def at(self, of: str, by: str) -> Sensitivity:
        """Return the derivative of a number by a key; raise MechanismError if it was not asked for."""
        found = next((row for row in self.rows if (row.of, row.by) == (of, by)), None)
        if found is None:
            known = ", ".join(f"{row.of} by {row.by}" for row in self.rows)
            raise MechanismError(f"no derivative of {of!r} by {by!r}; there are {known}")
        return found

    def __str__(self) -> str:
        heading = f"{self.title}: derivatives from {self.n_runs} runs, each accurate to {self.accuracy:.0e}"
        return f"{heading}\n{format_columns(self.columns, self.rows)}"


@dataclass(frozen=True)
class _Sample:
    """What is kept of a run: numbers with their errors, or why there are none; readings and rates; contact events; why it ended."""

    index: int
    numbers: tuple[float | str, ...]
    errors: tuple[float, ...]
    series: Mapping[str, FloatArray]
    times: FloatArray
    events: tuple[str, ...]
    problem: str


@dataclass(frozen=True, kw_only=True)
class _Task:
    """All runs of a study, by index: the scene itself, then the four around the value of each key; it can be pickled."""

    document: Mapping[str, Any]
    quantities: tuple[RunQuantity, ...]
    histories: tuple[str, ...]
    keys: tuple[str, ...]
    values: tuple[float, ...]
    steps: tuple[float, ...]
    units: tuple[str, ...]
    engine: str
    accuracy: float

    @property
    def n_runs(self) -> int:
        """Number of runs."""
        return 1 + len(OFFSETS) * len(self.keys)

    def compute(self, index: int) -> _Sample:
        """Return what a run shows."""
        try:
            return self._take(index, self._run(index))
        except GovernorMechanismError as error:
            return _Sample(index, (), (), {}, np.empty(0), (), "; ".join(getattr(error, "problems", (str(error),))))

    def _run(self, index: int) -> Trajectory:
        changes = []
        if index:
            key, place = divmod(index - 1, len(OFFSETS))
            value = self.values[key] + OFFSETS[place] * self.steps[key]
            changes.append((self.keys[key], write_value(value, self.units[key])))
        scene = parse_scene_with(self.document, changes)
        engine, reason = select_engine(scene.run.engine if self.engine == "auto" else self.engine, scene, self.accuracy)
        return engine.run(scene, accuracy=self.accuracy, reason=reason)

    def _take(self, index: int, run: Trajectory) -> _Sample:
        shared, numbers = RunNumbers(run), list[float | str]()
        for quantity in self.quantities:
            try:
                numbers.append(quantity.evaluate(shared))
            except MissingNumberError as reason:
                numbers.append(str(reason))
        errors = tuple(_error_of(quantity, number, run) for quantity, number in zip(self.quantities, numbers, strict=True))
        events = run.events if has_contacts(run.scene) else ()
        kinds = tuple(f"{one.subject} {one.kind}" for one in events if one.kind not in TURNING_EVENTS)
        series = {name: run.readings[name] for name in self.histories}
        for statistic, is_rate, reading in map(split_rule, (one.rule for one in self.quantities)):
            if statistic in EXTREMES:
                series[_series_name(is_rate, reading)] = (run.rates if is_rate else run.readings)[reading]
        problem = "" if run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED else run.message
        return _Sample(index, tuple(numbers), errors, series, run.times, kinds, problem)


def _series_name(is_rate: bool, reading: str) -> str:
    """Return the name of a reading or of its rate."""
    return f"{RATE_PREFIX}{reading}" if is_rate else reading


def _error_of(quantity: RunQuantity, number: float | str, run: Trajectory) -> float:
    """Return the error of a number (SI) that follows from the certificate of its run."""
    if isinstance(number, str) or run.error_estimate is None:
        return math.inf
    statistic, is_rate, reading = split_rule(quantity.rule)
    own = run.reading_errors.get(_series_name(is_rate, reading))
    if own is None or STATISTICS[statistic].unit is not None:
        return 2.0 * run.error_estimate * max(abs(number), quantity.scale)
    return 2.0 * own  # both ends of a span have it


def find_sensitivities(
    scene: Scene,
    of: Sequence[str] | Mapping[str, Any],
    by: Sequence[str],
    *,
    engine: str,
    accuracy: float | None,
    workers: int,
    cluster: Any,
) -> Sensitivities:
    """Return the derivatives of numbers by keys of a scene."""
    task = _make_task(scene, of, by, engine, DEFAULT_ACCURACY if accuracy is None else accuracy)
    samples: dict[int, _Sample] = {}
    n_keys = len(task.keys)
    with row_computer(workers, cluster) as compute:
        for rows in compute(task.compute, range(task.n_runs)):
            samples |= {one.index: one for one in rows}
    base = samples[0]
    if base.problem:
        raise MechanismError(f"the run of the scene itself has no numbers to derive: {base.problem}")
    around = [
        [_at_same_extremes(task, base, samples[1 + len(OFFSETS) * k + place]) for place in range(len(OFFSETS))] for k in range(n_keys)
    ]
    pairs = product(range(len(task.quantities)), range(n_keys))
    rows = tuple(_derive(task, number, key, base, around[key]) for number, key in pairs)
    histories = {}
    for (name, k), row in zip(product([one.name for one in task.quantities], range(n_keys)), rows, strict=True):
        if name in task.histories and not row.refusal:
            values = [sample.series[name] for sample in around[k]]
            histories[name, task.keys[k]] = _extrapolate(values, task.steps[k])[0]
    return Sensitivities(title=scene.title, rows=rows, times=base.times, histories=histories, accuracy=task.accuracy, n_runs=task.n_runs)


def _at_same_extremes(task: _Task, base: _Sample, sample: _Sample) -> _Sample:
    """Return a sample whose extremes are the values at the reported times of the extremes of the scene itself."""
    # A reported time on which the least value falls changes in jumps, and the least value would have a
    # kink at each.
    numbers = list(sample.numbers)
    for k, quantity in enumerate(task.quantities if numbers and not sample.problem else ()):
        statistic, is_rate, reading = split_rule(quantity.rule)
        if statistic in EXTREMES:
            of_base, values = (one.series[_series_name(is_rate, reading)] for one in (base, sample))
            least, greatest = EXTREMES[statistic]
            numbers[k] = float(least * values[np.argmin(of_base)] + greatest * values[np.argmax(of_base)])
    return replace(sample, numbers=tuple(numbers))


def _make_task(scene: Scene, of: Sequence[str] | Mapping[str, Any], by: Sequence[str], engine: str, accuracy: float) -> _Task:
    """Return the runs that the derivatives need; raise MechanismError with all mistakes of the request."""
    problems, keys = list[str](), [by] if isinstance(by, str) else list(by)
    quantities: tuple[RunQuantity, ...] = ()
    try:
        quantities = parse_quantities(scene, [of] if isinstance(of, str) else of, accuracy, certify=True)
    except MechanismError as error:
        problems += error.problems
    values, units = list[float](), list[str]()
    for key in keys:
        try:
            value, kind = value_of_key(scene, key)
        except MechanismError as error:
            problems += error.problems
            continue
        values.append(value)
        units.append(QUANTITY_KINDS[kind].si_unit)
    problems += [f"by: {key} is given twice; give it once" for key in dict.fromkeys(keys) if keys.count(key) > 1]
    problems += [] if keys else ["by names no key; write by=['dimensions.arm']"]
    if problems:
        raise MechanismError(*problems)
    steps = tuple(STEP_RATIO * (abs(value) or _scale_of(scene, unit)) for value, unit in zip(values, units, strict=True))
    readings = {one.name for one in scene.mechanism.readings}
    names = tuple(one.name for one in quantities if one.rule == one.name and one.name in readings)
    return _Task(
        document=scene.document,
        quantities=quantities,
        histories=names,
        keys=tuple(keys),
        values=tuple(values),
        steps=steps,
        units=tuple(units),
        engine=engine,
        accuracy=accuracy,
    )


def _scale_of(scene: Scene, unit: str) -> float:
    """Return the scale of a key whose value is zero: the length scale of the mechanism, or 1 in SI."""
    return scene.mechanism.length_scale if unit == "m" else 1.0


def _derive(task: _Task, number: int, key: int, base: _Sample, around: Sequence[_Sample]) -> Sensitivity:
    """Return a derivative, or why there is none."""
    quantity, step = task.quantities[number], task.steps[key]
    make = partial(Sensitivity, of=quantity.name, by=task.keys[key], unit=_quotient(quantity.unit, task.units[key]))
    refusal = _find_refusal(task, number, key, base, around)
    if refusal:
        return make(value=None, error=None, refusal=refusal)
    values = [_number(sample, number) for sample in around]
    value, rest = _extrapolate([np.array(one) for one in values], step)
    noise = NOISE_FACTOR * max(sample.errors[number] for sample in around) / step
    here, scale = _number(base, number), task.values[key]
    elasticity = float(value) * scale / here if here and scale else None
    return make(value=float(value), error=float(rest) + noise, elasticity=elasticity)


def _number(sample: _Sample, number: int) -> float:
    """Return a number of a run that has it."""
    return float(sample.numbers[number])


def _extrapolate(values: Sequence[FloatArray], step: float) -> tuple[FloatArray, FloatArray]:
    """Return derivatives (...) of values at the four offsets, and what the extrapolation leaves of its error."""
    # Its error is of fourth order in the step: about the square of what it changes, relative to the
    # derivative.
    first, before, after, last = values
    whole, half = (last - first) / (2.0 * step), (after - before) / step
    change = (half - whole) / 3.0
    derivative = half + change
    with np.errstate(divide="ignore", invalid="ignore"):
        rest = np.where(change == 0.0, 0.0, np.minimum(np.abs(change), 4.0 * change**2 / np.abs(derivative)))
    return derivative, rest


def _find_refusal(task: _Task, number: int, key: int, base: _Sample, around: Sequence[_Sample]) -> str:
    """Return why a number has no derivative by a key at its value; empty if it has one."""
    name = task.quantities[number].name
    path = task.keys[key]
    step = task.steps[key]
    for sample, offset in zip(around, OFFSETS, strict=True):
        where = f"at {path} = {task.values[key] + offset * step:.9g} {task.units[key]}".rstrip()
        if sample.problem:
            return f"no derivative: {where} {sample.problem}"
        if isinstance(sample.numbers[number], str):
            return f"no derivative: {where} {sample.numbers[number]}"
        if sample.events != base.events:
            return f"no derivative: {where} the contacts are others: {_first_difference(base.events, sample.events)}"
    if isinstance(base.numbers[number], str):
        return f"no derivative: {base.numbers[number]}"
    first, before, after, last = (_number(sample, number) for sample in around)
    here = _number(base, number)
    error = max(sample.errors[number] for sample in (base, *around))
    at_half, at_whole = before - 2.0 * here + after, first - 2.0 * here + last
    if abs(at_half) > KINK_RATIO * abs(at_whole) and abs(at_half) > 20.0 * error:
        left, right = (here - before) / (0.5 * step), (after - here) / (0.5 * step)
        return f"no derivative: {name} has a kink there, with the slopes {left:.6g} and {right:.6g}"
    return ""


def _first_difference(expected: Sequence[str], found: Sequence[str]) -> str:
    """Return in words where two sequences of events part."""
    shared = next((k for k, pair in enumerate(zip(expected, found, strict=False)) if pair[0] != pair[1]), min(len(expected), len(found)))
    texts = [f"'{one[shared]}'" if shared < len(one) else "nothing" for one in (expected, found)]
    return f"event {shared + 1} is {texts[1]} instead of {texts[0]}"


def _quotient(unit: str, by: str) -> str:
    """Return the unit of a derivative."""
    if not by:
        return unit
    below = f"({by})" if " " in by or "/" in by else by
    return f"{unit or '1'}/{below}"

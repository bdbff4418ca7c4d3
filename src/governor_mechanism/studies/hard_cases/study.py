"""Runs the hard cases by every engine and judges each run.

A row passes if the true error is within the stated estimate, or if the run ends with an outcome that the case names, within bounded time.
The true error is measured against a solution that is independent of the engines, or else against another engine at a tight tolerance.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import GovernorMechanismError, MechanismError, did_you_mean
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.hard_cases import contact_cases, governor_cases, linkage_cases, weight_cases
from governor_mechanism.studies.hard_cases.case import HardCase
from governor_mechanism.studies.plain_runs import compare_motions, compare_runs
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import short_repr


class Verdict(Enum):
    """What a row of a hard case shows. Each value is a phrase for the user."""

    WITHIN_ESTIMATE = "within its estimate"
    NAMED_END = "named end"
    REFUSED = "refused"
    NO_DIGITS = "claims no digit"
    NOT_SUPPORTED = "not supported"
    NO_REFERENCE = "no reference"
    ERROR_EXCEEDS_ESTIMATE = "ERROR EXCEEDS ITS ESTIMATE"
    UNEXPECTED_END = "UNEXPECTED END"
    NOT_REFUSED = "NOT REFUSED"
    NOT_FINITE = "NOT FINITE"
    TOO_SLOW = "TOO SLOW"
    CRASHED = "CRASHED"

    @property
    def passed(self) -> bool:
        """Whether the row keeps the promise: true within the stated error, or a named end, in bounded time."""
        return self.value.islower()


@dataclass(frozen=True, kw_only=True)
class HardCaseRow:
    """One run of a hard case."""

    case: str  # name of the case
    value: float  # value of the hard parameter
    engine: str  # name of the engine
    verdict: Verdict  # what the run shows
    outcome: str = ""  # name of the outcome; empty without a run
    reference: str = ""  # what the error is measured against
    error: float | None = None  # largest true error of a reading or rate, in units of its scale; None without a reference
    estimate: float | None = None  # error estimate of the run; None if it has none
    reached: float = 0.0  # fraction of the duration that the run reached
    wall_time: float = 0.0  # time of the run, s
    message: str = ""  # cause of an end, refusal or failure


@dataclass(frozen=True, kw_only=True)
class HardCasesReport(Result):
    """Rows of all studied cases.

    Attributes
    ----------
    cases
        The studied cases.
    rows
        Their rows.
    """

    cases: tuple[HardCase, ...]
    rows: tuple[HardCaseRow, ...]

    __repr__ = short_repr

    figure = "render.figures.errors.hard_case_figure"
    data_files = ("csv", "json")
    figure_set = "render.figures.errors.hard_case_figures"
    record = ("ok", "cases=described_cases", "rows")
    columns = (
        Column("case"),
        Column("value"),
        Column("engine", "engine"),
        Column("error", "error", lambda row: _format_error(row.error), side="r"),
        Column("estimate", "estimate", lambda row: _format_error(row.estimate), side="r"),
        Column("reference", "against"),
        Column("outcome", "outcome"),
        Column("reached", "reached", lambda row: f"{row.reached:.0%}" if row.outcome else "", side="r"),
        Column("wall_time", "time", lambda row: f"{row.wall_time:.2g} s" if row.outcome else "", side="r"),
        Column("verdict", "verdict", value="verdict.value"),
        Column("message"),
        Column("passed", value="verdict.passed", in_table=False),
    )

    @property
    def described_cases(self) -> list[dict[str, str]]:
        """Name, title and hard parameter of each case."""
        return [{"name": case.name, "title": case.title, "parameter": case.parameter} for case in self.cases]

    @property
    def ok(self) -> bool:
        """Whether every row passed."""
        return all(row.verdict.passed for row in self.rows)

    def rows_of(self, case: HardCase) -> tuple[HardCaseRow, ...]:
        """Return the rows of a case."""
        return tuple(row for row in self.rows if row.case == case.name)

    def __str__(self) -> str:
        """Return a table per case, and what failed."""
        failed = [row for row in self.rows if not row.verdict.passed]
        summary = f"{len(self.rows)} rows, {len(failed)} failed" + (":" if failed else "")
        failures = [f"  {row.case} at {row.value:g}, {row.engine}: {row.verdict.value}; {row.message}" for row in failed]
        return "\n".join([*(text for case in self.cases for text in self._case_lines(case)), summary, *failures])

    def _case_lines(self, case: HardCase) -> Iterator[str]:
        yield f"{case.name}: {case.title}"
        yield format_columns((Column("", f"  {case.parameter}", "  {value:.12g}"), *self.columns), self.rows_of(case))
        ends = {name for row in self.rows_of(case) if row.verdict is Verdict.NAMED_END and (name := row.outcome)}
        yield from (f"  {outcome.name}: {why}" for outcome, why in case.named_ends.items() if outcome.name in ends)
        yield ""

    def plot(self, case: HardCase | None = None) -> Figure:
        """Draw the rows of a case, by default the first; `figures` has those of all.

        Parameters
        ----------
        case
            The case.

        Returns
        -------
        Figure
            The figure.
        """
        return self._draw(case or self.cases[0])


def _format_error(value: float | None) -> str:
    return "" if value is None or math.isnan(value) else f"{value:.1e}"


HARD_CASES: dict[str, HardCase] = {
    case.name: case for case in (*weight_cases.CASES, *contact_cases.CASES, *linkage_cases.CASES, *governor_cases.CASES)
}
"""The hard cases, in the order of the study."""


MAX_WALL_TIME = 20.0
"""Longest time of a run that passes, s."""

IMPULSE_ACCURACY = 1e-4
"""Accuracy requested from impulse, whose cost grows fast; the other engines take that of the scene."""

REFERENCE_TOLERANCE = 1e-13
"""Tolerance of a reference run: near the rounding of double precision."""

ROUNDING_ERROR = 1e-11
"""Relative error that is rounding, of runs, references and solutions: all add up thousands of terms in double precision."""

NO_DIGITS_ESTIMATE = 0.1
"""Estimate from which a run claims no correct digit; how large its error is, is then open."""

COMPLETE_OUTCOMES = (Outcome.DONE, Outcome.ACCURACY_MISSED)
"""Outcomes of runs that reached their end with an estimate."""


def run_hard_cases(
    names: Iterable[str] = (),
    *,
    short: bool = False,  # whether to run the few values of the short form only
    # called with the number of finished values and the number of all
    progress: Callable[[int, int], None] | None = None,
) -> HardCasesReport:
    """Run hard cases by every engine over their hard parameters, with a row for each case, value and engine."""
    cases = tuple(_find_case(name) for name in names) or tuple(HARD_CASES.values())
    if short:
        cases = tuple(replace(case, values=case.short_values) for case in cases)
    tasks = [(case, value) for case in cases for value in case.values]
    rows: list[HardCaseRow] = []
    for n_done, (case, value) in enumerate(tasks):
        if progress is not None:
            progress(n_done, len(tasks))
        rows += _HardScene(case, value).run_engines()
    if progress is not None:
        progress(len(tasks), len(tasks))
    return HardCasesReport(cases=cases, rows=tuple(rows))


def _find_case(name: str) -> HardCase:
    if name not in HARD_CASES:
        names = list(HARD_CASES)
        raise MechanismError(f"no hard case {format_value(name)}; the cases are {', '.join(names)}.{did_you_mean(name, names)}")
    return HARD_CASES[name]


class _HardScene:
    """The scene of a case at a value, its engines and references."""

    def __init__(self, case: HardCase, value: float) -> None:
        self.case, self.value = case, value
        self._references: dict[str, Trajectory | None] = {}

    def run_engines(self) -> list[HardCaseRow]:
        """Return a row for each engine; a single one if the scene is refused."""
        try:
            scene = parse_scene_document(self.case.make_document(self.value), self.case.name)
        except MechanismError as error:
            return [self._refused_row("every", str(error))]
        return [self._run(scene, engine) for engine in self.case.engines(self.value)]

    def _is_refusal_expected(self) -> bool:
        return any(self.value == one or (np.isnan(self.value) and np.isnan(one)) for one in self.case.refused_values)

    def _refused_row(self, engine: str, message: str) -> HardCaseRow:
        verdict = Verdict.REFUSED if self._is_refusal_expected() else Verdict.UNEXPECTED_END
        return HardCaseRow(case=self.case.name, value=self.value, engine=engine, verdict=verdict, message=message)

    def _run(self, scene: Scene, engine: Engine) -> HardCaseRow:
        if message := engine.refusal(scene):
            return HardCaseRow(case=self.case.name, value=self.value, engine=engine.name, verdict=Verdict.NOT_SUPPORTED, message=message)
        started = time.perf_counter()
        try:
            run = engine.run(scene, accuracy=IMPULSE_ACCURACY if isinstance(engine, ImpulseEngine) else None)
        except GovernorMechanismError as error:
            return self._refused_row(engine.name, str(error))
        except Exception as error:  # whatever it is, the user should not see it: it is what this study looks for
            message = f"{type(error).__name__}: {error}"
            return HardCaseRow(case=self.case.name, value=self.value, engine=engine.name, verdict=Verdict.CRASHED, message=message)
        wall_time = time.perf_counter() - started
        if wall_time > MAX_WALL_TIME:  # perhaps it compiled its kernels, or waited for other processes: the second run counts
            return self._judge(run, _time_again(engine, run))
        return self._judge(run, wall_time)

    def _judge(self, run: Trajectory, wall_time: float) -> HardCaseRow:
        reference, error = self._measure_error(run)
        return HardCaseRow(
            case=self.case.name,
            value=self.value,
            engine=run.cost.engine,
            verdict=self._find_verdict(run, error, wall_time),
            outcome=run.outcome.name,
            reference=reference,
            error=error,
            estimate=run.error_estimate,
            reached=float(run.times[-1]) / run.scene.run.duration if run.times.size else 0.0,
            wall_time=wall_time,
            message=run.message,
        )

    def _find_verdict(self, run: Trajectory, error: float | None, wall_time: float) -> Verdict:
        is_complete = run.outcome in COMPLETE_OUTCOMES
        if not all(np.all(np.isfinite(values)) for values in (*run.readings.values(), *run.rates.values(), run.energy.jacobi)):
            return Verdict.NOT_FINITE
        if self._is_refusal_expected():
            return Verdict.NOT_REFUSED
        if wall_time > MAX_WALL_TIME:
            return Verdict.TOO_SLOW
        if not is_complete and run.outcome not in self.case.named_ends:
            return Verdict.UNEXPECTED_END
        claims_digits = (run.error_estimate or 0.0) <= NO_DIGITS_ESTIMATE
        if claims_digits and error is not None and error > max(run.error_estimate or 0.0, ROUNDING_ERROR):
            return Verdict.ERROR_EXCEEDS_ESTIMATE
        if not is_complete:
            return Verdict.NAMED_END
        if not claims_digits:
            return Verdict.NO_DIGITS
        return Verdict.NO_REFERENCE if error is None else Verdict.WITHIN_ESTIMATE

    def _measure_error(self, run: Trajectory) -> tuple[str, float | None]:
        """Return what a run is compared with, and its largest error in units of the scales beyond the error of the reference."""
        if len(run.times) < 2:
            return "", None
        unit = time_scale(run.scene)
        if self.case.solve is not None:
            # Next to an event a sample may lie on either side of it, as the certificate allows too.
            time_tolerance = min(max(run.requested_accuracy, run.error_estimate or 0.0), NO_DIGITS_ESTIMATE) * unit
            is_near_event = compare_event_logs(run.events, run.events, run.times, time_tolerance)[1]
            is_near_event |= run.times <= time_tolerance  # the start may be an event too
            return "solution", _largest(compare_motions(run, self.case.solve(self.value, run.times), ~is_near_event))
        engines = [ReducedEngine(tolerance=REFERENCE_TOLERANCE), MultibodyEngine(tolerance=REFERENCE_TOLERANCE)]
        # The same engine at a tighter tolerance is the last resort: an error that does not depend on the tolerance stays unseen.
        for engine in sorted(engines, key=lambda engine: engine.name == run.cost.engine):
            reference = self._reference_run(run.scene, engine)
            if reference is not None and len(reference.times) >= len(run.times) - 1:
                errors, event_time_error = compare_runs(run, reference)
                error = max(_largest(errors), (event_time_error or 0.0) / unit)
                name = f"{engine.name} at {REFERENCE_TOLERANCE:g}" if engine.name == run.cost.engine else engine.name
                return name, max(error - (reference.error_estimate or 0.0), 0.0)
        return "", None

    def _reference_run(self, scene: Scene, engine: Engine) -> Trajectory | None:
        """Return the run of an engine at a tight tolerance; None if it cannot run the scene."""
        if engine.name not in self._references:
            try:
                run = None if engine.refusal(scene) else engine.run(scene)
            except GovernorMechanismError:
                run = None
            self._references[engine.name] = run
        return self._references[engine.name]


def _time_again(engine: Engine, run: Trajectory) -> float:
    """Return the time, s, of the same run once more."""
    started = time.perf_counter()
    engine.run(run.scene, accuracy=run.requested_accuracy)
    return time.perf_counter() - started


def _largest(errors: Mapping[str, float]) -> float:
    return max(errors.values(), default=0.0)

"""Results of the hard cases: one row per case, value and engine, with its verdict."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum

from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.studies.hard_cases.case import HardCase
from governor_mechanism.units.short_repr import short_repr


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
    """One run of a hard case.

    Attributes
    ----------
    case
        Name of the case.
    value
        Value of the hard parameter.
    engine
        Name of the engine.
    verdict
        What the run shows.
    outcome
        Name of the outcome; empty without a run.
    reference
        What the error is measured against.
    error
        Largest true error of a reading or rate, in units of its scale; None without a reference.
    estimate
        Error estimate of the run; None if it has none.
    reached
        Fraction of the duration that the run reached.
    wall_time
        Time of the run, s.
    message
        Cause of an end, refusal or failure.
    """

    case: str
    value: float
    engine: str
    verdict: Verdict
    outcome: str = ""
    reference: str = ""
    error: float | None = None
    estimate: float | None = None
    reached: float = 0.0
    wall_time: float = 0.0
    message: str = ""


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

    figure = "render.figures.hard_cases.hard_case_figure"
    figure_set = "render.figures.hard_cases.hard_case_figures"
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

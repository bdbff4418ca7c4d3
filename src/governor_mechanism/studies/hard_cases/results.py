"""Results of the hard cases: one row per case, value and engine, with its verdict."""

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass, fields
from enum import Enum
from pathlib import Path
from typing import Any

from governor_mechanism.files.plain_values import finite_or_none, plain_record, save_table
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.files.table import make_data_frame
from governor_mechanism.studies.hard_cases.case import HardCase
from governor_mechanism.types import DataFrame
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table


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

    def as_json(self) -> dict[str, Any]:
        """Return the row as plain values."""
        numbers = {name: finite_or_none(value) for name in ("value", "error", "estimate") if (value := getattr(self, name)) is not None}
        return plain_record(self, **{"verdict": self.verdict.value, "passed": self.verdict.passed, **numbers})


@dataclass(frozen=True, kw_only=True)
class HardCasesReport(PrintedResult):
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
        headers = ("  " + case.parameter, "engine", "error", "estimate", "against", "outcome", "reached", "time", "verdict")
        yield format_table(headers, map(_cells, self.rows_of(case)), "llrrllrrl")
        ends = {name for row in self.rows_of(case) if row.verdict is Verdict.NAMED_END and (name := row.outcome)}
        yield from (f"  {outcome.name}: {why}" for outcome, why in case.named_ends.items() if outcome.name in ends)
        yield ""

    def as_json(self) -> dict[str, Any]:
        """Return the report as plain values."""
        cases = [{"name": case.name, "title": case.title, "parameter": case.parameter} for case in self.cases]
        return {"ok": self.ok, "cases": cases, "rows": [row.as_json() for row in self.rows]}

    def save_csv(self, path: str | os.PathLike[str]) -> Path:
        """Write one row per run, and return the path."""
        columns = self._columns()
        return save_table(list(columns), zip(*columns.values(), strict=True), Path(path))

    def to_dataframe(self) -> DataFrame:
        """Return a table of pandas with a row for each run.

        Returns
        -------
        pandas.DataFrame
            The table.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        return make_data_frame(self._columns())

    def _columns(self) -> dict[str, list[Any]]:
        """Return the values of all rows by the names of their fields."""
        columns = {field.name: [getattr(row, field.name) for row in self.rows] for field in fields(HardCaseRow)}
        return columns | {"verdict": [row.verdict.value for row in self.rows]}


def _cells(row: HardCaseRow) -> tuple[str, ...]:
    def number(value: float | None) -> str:
        return "" if value is None or math.isnan(value) else f"{value:.1e}"

    reached, time = ("", "") if not row.outcome else (f"{row.reached:.0%}", f"{row.wall_time:.2g} s")
    return (
        f"  {row.value:.12g}",
        row.engine,
        number(row.error),
        number(row.estimate),
        row.reference,
        row.outcome,
        reached,
        time,
        row.verdict.value,
    )

"""The report of a check: what is compared, the result and the tolerance."""

import math
from dataclasses import dataclass
from typing import Any

from governor_mechanism.files.plain_values import finite_or_none
from governor_mechanism.files.printed_result import PrintedResult
from governor_mechanism.files.table import make_data_frame
from governor_mechanism.types import DataFrame
from governor_mechanism.units.short_repr import short_repr
from governor_mechanism.units.text_table import format_table

MAX_PRINTED_ROWS = 24
"""Printed rows; a longer report shows the rows with the largest deviations only."""


@dataclass(frozen=True)
class ComparisonRow:
    """One comparison in `unit`, a row of the report; `allowed` is an absolute tolerance in the same unit, and `reason` justifies it."""

    quantity: str
    simulated: float
    expected: float
    allowed: float
    unit: str
    reason: str

    @property
    def difference(self) -> float:
        """Difference simulated - expected, in `unit`."""
        return self.simulated - self.expected

    @property
    def passed(self) -> bool:
        """Whether the difference is within the tolerance; False for NaN."""
        return abs(self.difference) <= self.allowed

    @property
    def cells(self) -> tuple[str, ...]:
        """The comparison as cells of the printed table."""
        values = (f"{self.simulated:.12g}", f"{self.expected:.12g}", self.unit, f"{self.difference:+.1e}", f"{self.allowed:.1e}")
        return self.quantity, *values, "ok" if self.passed else "FAILED"


@dataclass(frozen=True, kw_only=True)
class CheckReport(PrintedResult):
    """Comparison of a simulation with closed forms or with a user's kernel.

    Attributes
    ----------
    title
        Title of the scene.
    against
        What the simulation is compared with: "closed form", or the name of the kernel.
    rows
        The comparisons.
    notes
        What is not checked, and why.
    """

    title: str
    against: str
    rows: tuple[ComparisonRow, ...]
    notes: tuple[str, ...] = ()

    __repr__ = short_repr

    @property
    def passed(self) -> bool:
        """Whether there are rows and every one passes."""
        return bool(self.rows) and all(row.passed for row in self.rows)

    def as_json(self) -> dict[str, Any]:
        """Return the report as plain values, with None for what is not finite."""
        measured, others = ("simulated", "expected", "difference"), ("allowed", "unit", "reason", "passed")
        rows = [
            {"quantity": row.quantity}
            | {name: finite_or_none(getattr(row, name)) for name in measured}
            | {name: getattr(row, name) for name in others}
            for row in self.rows
        ]
        return {"title": self.title, "against": self.against, "passed": self.passed, "rows": rows, "notes": self.notes}

    def to_dataframe(self) -> DataFrame:
        """Return the comparisons as a table of pandas.

        Returns
        -------
        pandas.DataFrame
            A row for each comparison.

        Raises
        ------
        MechanismError
            If pandas is not installed.
        """
        names = ("quantity", "simulated", "expected", "difference", "allowed", "unit", "reason", "passed")
        return make_data_frame({name: [getattr(row, name) for row in self.rows] for name in names})

    def __str__(self) -> str:
        """Return the report as a table with its notes and the verdict."""
        is_long = len(self.rows) > MAX_PRINTED_ROWS
        shown = sorted(self.rows, key=_difference_ratio, reverse=True)[:MAX_PRINTED_ROWS] if is_long else self.rows
        headers = ("quantity", "simulated", self.against, "unit", "difference", "allowed", "verdict")
        failed = sum(not row.passed for row in self.rows)
        verdict = f"all {len(self.rows)} agree" if not failed else f"{failed} of {len(self.rows)} do not agree"
        verdict += f" (the {MAX_PRINTED_ROWS} largest deviations shown)" if is_long else ""
        table = format_table(headers, [row.cells for row in shown], "lrrlrrl")
        return "\n".join([self.title, table, *(f"note: {note}" for note in self.notes), verdict])


def _difference_ratio(row: ComparisonRow) -> float:
    ratio = abs(row.difference) / row.allowed
    return math.inf if math.isnan(ratio) else ratio

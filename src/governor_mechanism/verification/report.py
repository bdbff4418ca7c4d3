"""The report of a check: what is compared, the result and the tolerance; as text, and as a JUnit file for continuous integration."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar
from xml.etree import ElementTree

from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.units.text_table import short_repr

MAX_PRINTED_ROWS = 25
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
    def verdict(self) -> str:
        """A word for the printed table."""
        return "ok" if self.passed else "FAILED"

    @property
    def failure(self) -> str:
        """What differs, in a sentence."""
        return f"{self.expected:.12g} against the simulated {self.simulated:.12g} {self.unit}, allowed {self.allowed:.1e}"


@dataclass(frozen=True, kw_only=True)
class CheckReport(Result):
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

    record: ClassVar[tuple[str, ...]] = ("title", "against", "passed", "rows", "notes")

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the comparisons."""
        return (
            Column("quantity", "quantity"),
            Column("simulated", "simulated", ".12g"),
            Column("expected", self.against, ".12g"),
            Column("unit", "unit"),
            Column("difference", "difference", "+.1e"),
            Column("allowed", "allowed", ".1e"),
            Column("reason"),
            Column("passed", "verdict", "{verdict}"),
            Column("difference / allowed", value=_difference_ratio, in_table=False, in_json=False),
        )

    drawn = ("difference / allowed",)

    @property
    def defects(self) -> tuple[str, ...]:
        """Sentences on what is wrong whatever the rows say."""
        return ()

    @property
    def passed(self) -> bool:
        """Whether there are rows and every one passes."""
        return bool(self.rows) and all(row.passed for row in self.rows)

    def __str__(self) -> str:
        """Return the report as a table with its notes and the verdict."""
        is_long = len(self.rows) > MAX_PRINTED_ROWS
        shown = sorted(self.rows, key=_difference_ratio, reverse=True)[:MAX_PRINTED_ROWS] if is_long else self.rows
        failed = sum(not row.passed for row in self.rows)
        verdict = f"all {len(self.rows)} agree" if not failed else f"{failed} of {len(self.rows)} do not agree"
        verdict += f" (the {MAX_PRINTED_ROWS} largest deviations shown)" if is_long else ""
        table = format_columns(self.columns, shown)
        return "\n".join([self.title, table, *(f"note: {note}" for note in self.notes), verdict])


def _difference_ratio(row: ComparisonRow) -> float:
    ratio = abs(row.difference) / row.allowed
    return math.inf if math.isnan(ratio) else ratio


def save_junit(report: CheckReport, path: Path) -> Path:
    """Write a check as a JUnit file, with a test case for each comparison; raise MechanismError if the file cannot be written."""
    defects = report.defects
    n_failed = sum(not row.passed for row in report.rows) + len(defects)
    counts = {"tests": str(len(report.rows) + len(defects)), "failures": str(n_failed), "errors": "0"}
    suite = ElementTree.Element("testsuite", {"name": f"governor-mechanism crosscheck: {_clean(report.title)}", **counts})
    class_name = f"crosscheck.{report.against.replace(' ', '_')}"
    for row in report.rows:
        case = ElementTree.SubElement(suite, "testcase", {"classname": class_name, "name": _clean(row.quantity)})
        if not row.passed:
            message = _clean(row.failure)
            ElementTree.SubElement(case, "failure", {"message": message}).text = message
    for number, defect in enumerate(defects, start=1):
        case = ElementTree.SubElement(suite, "testcase", {"classname": class_name, "name": f"defect {number}"})
        ElementTree.SubElement(case, "failure", {"message": _clean(defect)}).text = _clean(defect)
    if report.notes:
        ElementTree.SubElement(suite, "system-out").text = _clean("\n".join(report.notes))
    root = ElementTree.Element("testsuites", counts)
    root.append(suite)
    ElementTree.indent(root)
    with atomic_write(path) as temporary:
        ElementTree.ElementTree(root).write(temporary, encoding="utf-8", xml_declaration=True)
    return path


def _clean(text: str) -> str:
    """Return a text without the control characters that XML does not have."""
    return "".join(letter for letter in text if letter >= " " or letter in "\n\t")

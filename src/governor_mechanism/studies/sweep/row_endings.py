"""Ways in which rows of a sweep end other than at the end of their run with all numbers, in words and counted."""

import re
from collections import Counter
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.results.result import Recorded
from governor_mechanism.studies.sweep.rows import FAILED_ROW_OUTCOMES, OK_ROW_OUTCOMES, RESULT_ROW_OUTCOMES, SweepRows
from governor_mechanism.types import IntArray

MAX_CAUSES = 3
"""Largest number of causes of an outcome that are counted one by one; more are messages with numbers in them, and count as one ending."""

_TIME_PATTERN = re.compile(r",? at (?:about )?t = ")
"""What precedes the time in the message of a run that ends early; the cause stands before it."""


@dataclass(frozen=True, kw_only=True)
class RowEnding(Recorded):
    """A way in which some rows of a sweep end.

    Attributes
    ----------
    outcome
        Outcome of the rows.
    cause
        Cause that their messages have in common; empty if they differ.
    count
        Number of the rows.
    rows
        Their indices; shape (count,).
    """

    outcome: str
    cause: str
    count: int
    rows: IntArray

    hidden = ("rows",)

    @property
    def first_row(self) -> int:
        """Index of the first row."""
        return int(self.rows[0])

    @property
    def is_result(self) -> bool:
        """Whether the outcome is a result by itself, and no failure."""
        return self.outcome in RESULT_ROW_OUTCOMES

    @property
    def has_common_cause(self) -> bool:
        """Whether the messages of the rows have a cause in common."""
        return bool(self.cause)

    @property
    def words(self) -> str:
        """What the rows did, without its cause."""
        return {**RESULT_ROW_OUTCOMES, **FAILED_ROW_OUTCOMES}.get(self.outcome, f"ended early ({self.outcome.replace('_', ' ')})")

    @property
    def text(self) -> str:
        """What the rows did, and the cause."""
        subject, separator, cause = self.cause.partition(": ")
        if separator and self.outcome == "left_range":
            return f"reached the end of the range of {subject}: {cause}"
        return f"{self.words}: {self.cause}" if self.cause else self.words


def find_endings(
    rows: SweepRows,  # the rows of a sweep, all of which are computed
) -> tuple[RowEnding, ...]:
    """Return the endings of rows, in the order in which they occur first.

    Result: endings; none if every row ran to its end and has all its numbers.
    """
    found: list[RowEnding] = []
    outcomes = rows.outcomes
    for outcome in rows.first_rows:
        if outcome in OK_ROW_OUTCOMES:
            continue
        indices = np.flatnonzero(outcomes == outcome)
        causes = np.array([_cause_of(rows.message(index)) for index in indices.tolist()])
        counts = Counter(causes.tolist())
        groups = [(cause, causes == cause) for cause in counts] if len(counts) <= MAX_CAUSES else [("", np.full(len(causes), True))]
        for cause, has_cause in groups:
            own_rows = indices[has_cause]
            found.append(RowEnding(outcome=outcome, cause=cause, count=len(own_rows), rows=own_rows))
    return tuple(sorted(found, key=lambda ending: ending.first_row))


def _cause_of(message: str) -> str:
    """Return the cause in a message, without the time, which differs from row to row."""
    return _TIME_PATTERN.split(message, maxsplit=1)[0]

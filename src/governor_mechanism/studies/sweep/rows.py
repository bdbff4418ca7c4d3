"""Rows of a sweep: numbers, outcome and message of each run, kept in arrays."""

import math
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.files.writing import finite_or_none
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.types import BoolArray, FloatArray, IntArray

ROW_REFUSED, ROW_FAILED = "refused", "failed"
"""Outcomes in addition to those of runs: an invalid scene or a refused run, and an unexpected error."""

ROW_OK = "ok"
"""Outcome of a complete run without a certificate."""

ROW_NOT_SETTLED = "not_settled"
ROW_NO_OSCILLATION = "no_oscillation"
ROW_NO_VALUE = "no_value"
"""Outcomes of a complete run that lacks a requested number: a settled value, an amplitude or frequency, or another one."""

OK_ROW_OUTCOMES = ("done", ROW_OK)
"""Outcomes of a run that is complete and kept its accuracy, certified or not."""

RESULT_ROW_OUTCOMES: Mapping[str, str] = {
    "done": "ran to the end",
    ROW_OK: "ran to the end",
    "left_range": "reached the end of the mechanism's range",
    "shaft_stalled": "came to a stop: the shaft would turn back",
    "control_out_of_range": "moved a control beyond its range",
    ROW_NOT_SETTLED: "did not settle",
    ROW_NO_OSCILLATION: "made no whole oscillation",
    ROW_NO_VALUE: "lack a number",
}
"""Outcomes that are results of a row, in words; every other one is a failure."""

FAILED_ROW_OUTCOMES: Mapping[str, str] = {
    ROW_REFUSED: "could not be run",
    ROW_FAILED: "failed with an error of the program",
    "accuracy_missed": "missed the accuracy",
    "step_limit": "needed too many steps",
    "dead_centre": "reached a turning point of the engine's coordinate",
}
"""Failures in words; those of other outcomes are their names."""

_MISSING = -1
"""Code of the outcome of a row that is not computed yet."""


@dataclass(frozen=True, kw_only=True)
class SweepRow:
    """Numbers of one run (SI, NaN if missing), its outcome, and a message if it is not ok."""

    index: int
    numbers: tuple[float, ...]
    outcome: str
    message: str = ""

    @property
    def ok(self) -> bool:
        """Whether the run is complete and kept its accuracy."""
        return self.outcome in OK_ROW_OUTCOMES

    @property
    def numbers_or_none(self) -> list[float | None]:
        """The numbers, with None for one that is missing."""
        return [finite_or_none(number) for number in self.numbers]


class SweepRows(Sequence[SweepRow]):
    """The rows of a sweep by index, in any order, a byte and the memory of its numbers for each that is ok: there may be millions."""

    def __init__(
        self,
        n_rows: int,  # number of rows when all are computed
        n_quantities: int,  # number of numbers of a row
    ) -> None:
        # numbers of all rows, SI, NaN if missing; shape (rows, quantities)
        self.numbers: FloatArray = np.full((n_rows, n_quantities), math.nan)
        self._codes = np.full(n_rows, _MISSING, dtype=np.int8)
        self._outcomes: list[str] = []
        self._messages: dict[int, str] = {}

    def add(self, rows: Iterable[SweepRow]) -> None:
        """Add computed rows."""
        for row in rows:
            if row.outcome not in self._outcomes:
                self._outcomes.append(row.outcome)
            self.numbers[row.index], self._codes[row.index] = row.numbers, self._outcomes.index(row.outcome)
            if row.message:
                self._messages[row.index] = row.message

    def __len__(self) -> int:
        """Return the number of rows when all are computed."""
        return len(self._codes)

    @overload
    def __getitem__(self, index: int) -> SweepRow: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[SweepRow]: ...
    def __getitem__(self, index: int | slice) -> SweepRow | Sequence[SweepRow]:
        """Return a computed row, or several."""
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        k = range(len(self))[index]
        return SweepRow(index=k, numbers=tuple(self.numbers[k].tolist()), outcome=self._outcomes[self._codes[k]], message=self.message(k))

    def message(self, index: int) -> str:
        """Return the message of a row, which is computed; empty if it has none."""
        return self._messages.get(index, "")

    @property
    def is_computed(self) -> BoolArray:
        """Whether each row is computed; shape (rows,)."""
        is_computed: BoolArray = self._codes != _MISSING
        return is_computed

    @property
    def outcomes(self) -> NDArray[Any]:
        """Outcomes of all rows, which are computed; shape (rows,)."""
        return np.array(self._outcomes)[self._codes]

    @property
    def first_rows(self) -> dict[str, tuple[int, int]]:
        """By outcome, in the order in which outcomes occur, the index of its first row and the number of its rows."""
        codes, firsts, counts = np.unique(self._codes, return_index=True, return_counts=True)
        found = sorted(zip(firsts.tolist(), counts.tolist(), codes.tolist(), strict=True))
        return {self._outcomes[code]: (first, count) for first, count, code in found}


MAX_CAUSES = 3
"""Largest number of kinds of causes of an outcome that are counted one by one; more count as one ending."""
_NUMBER_PATTERN = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
"""A number; causes that differ in numbers alone are of one kind."""

_TIME_PATTERN = re.compile(r",? at (?:about )?t = ")
"""What precedes the time in the message of a run that ends early; the cause stands before it."""


@dataclass(frozen=True, kw_only=True)
class RowEnding(Recorded):
    """A way in which some rows of a sweep end."""

    outcome: str  # outcome of the rows
    cause: str  # cause that their messages have in common; empty if they differ
    count: int  # number of the rows
    rows: IntArray  # their indices; shape (count,)

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
    """Return the endings of rows, in the order in which they occur first; none if every row ran to its end and has all its numbers."""
    found: list[RowEnding] = []
    outcomes = rows.outcomes
    for outcome in rows.first_rows:
        if outcome in OK_ROW_OUTCOMES:
            continue
        indices = np.flatnonzero(outcomes == outcome)
        causes = np.array([_cause_of(rows.message(index)) for index in indices.tolist()])
        kinds = np.array([_NUMBER_PATTERN.sub("", cause) for cause in causes.tolist()])
        counts = Counter(kinds.tolist())
        groups = [kinds == kind for kind in counts] if len(counts) <= MAX_CAUSES else [np.full(len(causes), True)]
        for is_alike in groups:
            own_rows, own_causes = indices[is_alike], set(causes[is_alike].tolist())
            cause = own_causes.pop() if len(own_causes) == 1 else ""
            found.append(RowEnding(outcome=outcome, cause=cause, count=len(own_rows), rows=own_rows))
    return tuple(sorted(found, key=lambda ending: ending.first_row))


def _cause_of(message: str) -> str:
    """Return the cause in a message, without the time, which differs from row to row."""
    return _TIME_PATTERN.split(message, maxsplit=1)[0]

"""Numbers as a paper prints them, beside the recomputed ones, and the causes of what does not agree."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from governor_mechanism.model.results.result import Column


class Cause(StrEnum):
    """Why something printed is not right; `CAUSE_MEANINGS` defines each cause."""

    ERROR = "error"
    CONSEQUENCE = "consequence"
    MISPRINT = "misprint"
    SLIP = "slip"
    ROUNDING = "rounding"
    UNDECIDED = "undecided"


CAUSE_MEANINGS = {
    Cause.ERROR: "a wrong argument or calculation of the author that leads to another machine or to a false conclusion",
    Cause.CONSEQUENCE: "a number computed from an error, or a statement by the same wrong argument",
    Cause.MISPRINT: "a wrong digit or sign in the text as it was read; the lines around it show the right one",
    Cause.SLIP: "a small mistake of the author that changes no conclusion",
    Cause.ROUNDING: "a number that was cut off, or computed from rounded steps",
    Cause.UNDECIDED: "a typeface, index, exponent, factor or bracket that may be lost in the copy only",
}
"""What each cause is."""

CAUSE_NOUNS = {
    Cause.ERROR: "error",
    Cause.CONSEQUENCE: "consequence",
    Cause.MISPRINT: "misprint",
    Cause.SLIP: "small slip",
    Cause.ROUNDING: "rounding",
    Cause.UNDECIDED: "undecided place",
}
"""What an erratum of each cause is called; several have an s."""


@dataclass(frozen=True)
class PrintedNumber:
    """One number of a paper in `unit`, printed and recomputed; if it is not right, the cause, and a remark on it."""

    quantity: str
    unit: str
    printed: float
    recomputed: float
    cause: Cause | None = None
    remark: str = ""

    @property
    def mark(self) -> str:
        """Cause and remark; empty if the number is right."""
        return f"{self.cause.upper()}: {self.remark}" if self.cause else ""


PRINTED_COLUMNS = (
    Column("quantity", "quantity"),
    Column("unit", "unit"),
    Column("printed", "printed", ".6g"),
    Column("recomputed", "recomputed", ".7g"),
    Column("mark", ""),
)
"""Columns of a table of printed numbers."""


def select_deviations(numbers: Iterable[PrintedNumber]) -> tuple[PrintedNumber, ...]:
    """Return the numbers that do not agree with the recomputed ones, in their order."""
    return tuple(number for number in numbers if number.cause)

"""Solved problems of textbooks: governors, slider cranks, four-bar linkages, flywheels and valve events.

Each has its data in the units of the book, the printed answers, and these recomputed with the book's own assumptions to full precision.
`remark` says in one phrase why a printed answer is not the recomputed one to its last digit, or what the book's formula neglects;
`neglected` is then the largest relative difference of the exact mechanism from that formula. Gravity is 9.81 m/s2 throughout.

Most printed answers are from the companion notebooks of the FOSSEE project (Python-Textbook-Companions, commit d34b2ae) to B. K. Sarkar,
Theory of Machines; Th. Bevan, The Theory of Machines; R. S. Khurmi and J. K. Gupta, Theory of Machines. Those
marked `from_memory` are quoted from the books without a copy at hand.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

from data_files import read_data


@dataclass(frozen=True)
class Answer:
    """An answer as it is printed (empty if none is), recomputed, in a unit."""

    printed: str
    recomputed: float
    unit: str
    remark: str = ""
    neglected: float = 0.0

    @property
    def half_digit(self) -> float:
        """Half a unit of the last printed digit."""
        exponent = Decimal(self.printed).as_tuple().exponent
        assert isinstance(exponent, int)
        return 0.5 * 10.0**exponent


@dataclass(frozen=True)
class Problem:
    """A problem with its source, data and answers."""

    kind: str
    source: str
    data: Mapping[str, Any]
    answers: Mapping[str, Answer]
    from_memory: bool = False


def read_problem(table: dict[str, Any]) -> Problem:
    """Return a problem of the file beside this one."""
    answers = {name: Answer(**answer) for name, answer in table.pop("answers").items()}
    return Problem(**table, answers=answers)


PROBLEMS: Mapping[str, Problem] = {name: read_problem(table) for name, table in read_data(__file__).items()}

"""A simulated design: numbers that it wants, and what statics or the run of the simulated machine give."""

from dataclasses import dataclass
from typing import Any

from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.units.text_table import format_table

STATICS_TOLERANCE = 1e-8
"""Largest relative difference of a wanted number and the statics of the machine: statics are exact to about 1e-12, and the numbers of the
scene file have 15 digits; a lift, or a range of speed, of some per cent loses two."""


@dataclass(frozen=True, kw_only=True)
class ComparedNumber:
    """A number that the design wants, and what statics or the run of the simulated machine give; tolerance relative to `scale`."""

    quantity: str
    unit: str
    wanted: float
    found: float
    by: str
    tolerance: float
    scale: float

    @property
    def ok(self) -> bool:
        """Whether the simulated machine gives the wanted number."""
        return abs(self.found - self.wanted) <= self.tolerance * self.scale

    @property
    def cells(self) -> tuple[str, ...]:
        """The number as a row of a table."""
        verdict = "" if self.ok else "DIFFERS"
        difference = abs(self.found - self.wanted) / self.scale
        return f"{self.quantity}, {self.unit}", f"{self.wanted:.8g}", f"{self.found:.8g}", self.by, f"{difference:.1e}", verdict


def compare_statics(quantity: str, unit: str, wanted: float, found: float, by: str = "statics") -> ComparedNumber:
    """Return a number by statics beside the wanted one, with the tolerance of statics relative to the wanted number."""
    numbers = {"wanted": wanted, "found": found, "tolerance": STATICS_TOLERANCE, "scale": abs(wanted)}
    return ComparedNumber(quantity=quantity, unit=unit, by=by, **numbers)


@dataclass(frozen=True, kw_only=True, eq=False)
class SimulatedMachine:
    """What a designed machine does, and what was wanted.

    Attributes
    ----------
    numbers
        The numbers.
    run
        The run of its scene.
    """

    numbers: tuple[ComparedNumber, ...]
    run: Trajectory

    @property
    def ok(self) -> bool:
        """Whether all numbers are the wanted ones."""
        return all(number.ok for number in self.numbers)

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as plain values, without the run."""
        return plain_record(self, "run", numbers=[plain_record(number, ok=number.ok) for number in self.numbers], ok=self.ok)

    def __str__(self) -> str:
        """Return a table of the numbers."""
        return format_table(
            ("the simulated machine", "wanted", "found", "by", "difference", ""), [one.cells for one in self.numbers], "lrrlrl"
        )

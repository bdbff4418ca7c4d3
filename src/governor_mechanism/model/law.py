"""The law of a classic mechanism: what must hold over its whole travel, and which dimensions it depends on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from governor_mechanism.units.fields import entry

if TYPE_CHECKING:
    from governor_mechanism.units.expressions import Expression, Measured

FAMILIES: Final = ("straight-lines", "curves", "walkers", "drives", "gears", "governors", "valve-gears")
"""Families of classic mechanisms."""


@dataclass(frozen=True, kw_only=True)
class LawEquation:
    """Two expressions of readings and dimensions that are equal at every position.

    Attributes
    ----------
    value, equals
        The expressions.
    within
        Largest difference, SI.
    unit
        SI unit of the difference; empty for a plain number.
    """

    value: Expression
    equals: Expression
    within: float
    unit: str

    def __str__(self) -> str:
        return f"{self.value.text} = {self.equals.text}"


@dataclass(frozen=True, kw_only=True)
class Law:
    """What a scene of a classic mechanism proves, as the table [law] of its file states it.

    Attributes
    ----------
    statement
        The law in words.
    source
        Where the mechanism, its dimensions and the law are from.
    family
        One of FAMILIES; empty outside the catalogue.
    over
        Reading that drives the mechanism through its travel, or "time" for its drivers.
    between
        The travel: first and last value of that reading, SI.
    positions
        Number of positions at which the equations are checked.
    equations
        The equations.
    holds_under
        Dimensions under which the law still holds when they change.
    broken_by
        Dimensions whose change breaks it.
    dimensions
        The dimensions of the scene by name.
    """

    statement: str = entry("label", meaning="the law in words")
    source: str = entry("label", default="", meaning="where the mechanism, its dimensions and the law are from")
    family: str = entry("choice", words=FAMILIES, default="", meaning="family in the catalogue")
    over: str = entry("reading", meaning="the reading that drives the mechanism through its travel, or time for its drivers")
    between: tuple[float, float] = entry("travel", meaning='the travel, as ["-40 deg", "40 deg"]')
    positions: int = entry("count", default=181, meaning="number of positions at which the equations are checked, 2 to 10000")
    equations: tuple[LawEquation, ...] = entry(
        "equations", key="proves", meaning='the equations, as [{ value = "pen_x", equals = "2 * crank", within = "1e-12 m" }]'
    )
    holds_under: tuple[str, ...] = entry("names", default=(), meaning="dimensions that may change without breaking the law")
    broken_by: tuple[str, ...] = entry("names", default=(), meaning="dimensions whose change breaks the law")
    dimensions: Mapping[str, Measured] = field(default_factory=dict)

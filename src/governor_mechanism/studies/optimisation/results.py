"""Results of optimisations: values before and after, conditions with their margins, and the trade-off of two objectives."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns, item_column
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity


@dataclass(frozen=True, kw_only=True)
class OptimisedValue(Recorded):
    """Value of an unknown.

    Attributes
    ----------
    key
        Key of the scene.
    before, value
        Value of the scene, and the best one, SI.
    unit
        SI unit.
    low, high
        Bounds, SI.
    at_bound
        Whether the best value lies at one of them.
    """

    key: str
    before: float
    value: float
    unit: str
    low: float
    high: float
    at_bound: bool


def _format_bounds(row: OptimisedValue) -> str:
    low, high = (format_quantity(one, row.unit) for one in (row.low, row.high))
    return f"{low} to {high}{'; at a bound' if row.at_bound else ''}"


@dataclass(frozen=True, kw_only=True)
class OptimisedQuantity(Recorded):
    """A quantity before and after.

    Attributes
    ----------
    name
        The quantity.
    role
        "minimised", "maximised", "reported", or the condition that it meets, as "<= 0.1 mm".
    before, after
        Its values, SI: of several, as in several gears, the worst counts. None before, if the scene has none.
    unit
        SI unit; empty if it is not known.
    margin
        By how much the worst value keeps the limit of a condition, SI; negative if it does not. None without one.
    active
        Whether the limit determines the optimum.
    """

    name: str
    role: str
    before: tuple[float, ...] | None
    after: tuple[float, ...]
    unit: str
    margin: float | None = None
    active: bool = False


def _worst(row: OptimisedQuantity, values: tuple[float, ...] | None) -> str:
    if values is None:
        return "none"
    is_upper = row.role.startswith((">", "maximised"))
    return format_quantity(min(values) if is_upper else max(values), row.unit)


def _format_margin(row: OptimisedQuantity) -> str:
    if row.margin is None:
        return ""
    return f"{'at its limit' if row.active else 'margin'} {format_quantity(row.margin, row.unit, '.3g')}"


QUANTITY_COLUMNS = (
    Column("name", "quantity"),
    Column("role", ""),
    Column("before", "before", lambda row: _worst(row, row.before), side="r"),
    Column("after", "after", lambda row: _worst(row, row.after), side="r"),
    Column("", "", _format_margin),
)
"""Columns of the printed table of quantities."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Optimum(Result):
    """The best values of unknowns under conditions.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        The values.
    quantities
        The objective, the conditions and the reported quantities, before and after.
    before
        The scene as it was.
    scene
        The scene with the best values.
    history
        Number of scenes tried, and the best objective so far that meets the conditions, SI; shape (n, 2).
    n_evaluations
        Number of scenes tried.
    method
        "local" or "global".
    n_starts
        Number of starts.
    seed
        Seed of the random numbers.
    converged
        Whether the search ended at an optimum that meets all conditions.
    outcome
        How it ended, in a sentence.
    """

    title: str
    rows: tuple[OptimisedValue, ...]
    quantities: tuple[OptimisedQuantity, ...]
    before: Scene
    scene: Scene
    history: FloatArray
    n_evaluations: int
    method: str
    n_starts: int
    seed: int
    converged: bool
    outcome: str

    hidden = ("before", "scene", "history")
    columns: ClassVar[tuple[Column, ...]] = (
        Column("key", "key"),
        Column("before", "before", lambda row: format_quantity(row.before, row.unit), side="r"),
        Column("value", "after", lambda row: format_quantity(row.value, row.unit), side="r"),
        Column("", "bounds", _format_bounds),
        Column("unit"),
        Column("low"),
        Column("high"),
        Column("at_bound"),
    )
    index: ClassVar[str] = "key"
    figure: ClassVar[str] = "render.figures.optimum.optimum_figure"
    data_files: ClassVar[tuple[str, ...]] = ("csv", "json")

    @property
    def ok(self) -> bool:
        """Whether the search ended at an optimum that meets all conditions."""
        return self.converged

    @property
    def values(self) -> dict[str, float]:
        """The best values by key, SI."""
        return {row.key: row.value for row in self.rows}

    @property
    def objective(self) -> OptimisedQuantity:
        """The objective before and after."""
        return self.quantities[0]

    def __str__(self) -> str:
        tables = [format_columns(self.columns, self.rows), format_columns(QUANTITY_COLUMNS, self.quantities)]
        several = [f"{one.name}: {_join(one)}" for one in self.quantities if len(one.after) > 1]
        seeded = f", {self.n_starts} starts, seed {self.seed}" if self.n_starts > 1 else ""
        seeded = f", seed {self.seed}" if self.method == "global" else seeded
        return "\n".join([f"{self.title}: {self.outcome}", *tables, *several, f"{self.n_evaluations} scenes tried{seeded}"])


def _join(quantity: OptimisedQuantity) -> str:
    """Return several values after an optimisation in one unit."""
    return ", ".join(format_quantity(one, quantity.unit, ".4g") for one in quantity.after)


@dataclass(frozen=True, kw_only=True)
class TradeOffPoint:
    """The best of the first objective where the second is no worse than a limit.

    Attributes
    ----------
    first, second
        The objectives, SI.
    values
        Values of the unknowns by key, SI.
    converged
        Whether the search ended at an optimum that meets all conditions.
    outcome
        How it ended, in a sentence.
    """

    first: float
    second: float
    values: Mapping[str, float]
    converged: bool
    outcome: str


def _format_objective(row: TradeOffPoint, field: str, unit: str) -> str:
    return format_quantity(getattr(row, field), unit)


def _format_unknown(row: TradeOffPoint, key: str, unit: str) -> str:
    return format_quantity(row.values[key], unit)


@dataclass(frozen=True, kw_only=True, eq=False)
class TradeOff(Result):
    """What one objective costs in the other.

    Attributes
    ----------
    title
        Title of the scene.
    names
        Both objectives.
    units
        Their SI units.
    keys
        Keys of the unknowns, with their SI units.
    start
        Both objectives of the scene itself, SI.
    rows
        The points, from the best of the first objective to the best of the second.
    scenes
        The scene of each.
    seed
        Seed of the random numbers.
    """

    title: str
    names: tuple[str, str]
    units: tuple[str, str]
    keys: Mapping[str, str]
    start: tuple[float, float]
    rows: tuple[TradeOffPoint, ...]
    scenes: tuple[Scene, ...]
    seed: int

    hidden = ("scenes",)
    figure: ClassVar[str] = "render.figures.optimum.trade_off_figure"
    data_files: ClassVar[tuple[str, ...]] = ("csv", "json")

    @property
    def ok(self) -> bool:
        """Whether all points are optima that meet all conditions."""
        return all(row.converged for row in self.rows)

    @property
    def columns(self) -> tuple[Column, ...]:
        """Both objectives and the unknowns."""
        pairs = zip(("first", "second"), self.names, self.units, strict=True)
        objectives = [
            Column(name, name, partial(_format_objective, field=field, unit=unit), unit, field, "r") for field, name, unit in pairs
        ]
        values = [
            item_column(key, "values", key, heading=key, cell=partial(_format_unknown, key=key, unit=unit), unit=unit, side="r")
            for key, unit in self.keys.items()
        ]
        return (*objectives, *values, Column("outcome", "", lambda row: "" if row.converged else row.outcome))

    def __str__(self) -> str:
        return f"{self.title}: {self.names[0]} against {self.names[1]}\n{format_columns(self.columns, self.rows)}"

"""Result of a sweep: rows of numbers with their outcomes, as columns, as grids, and as text."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.studies.sweep.parameters import AxisGrid, SweepAxis
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.rows import RESULT_ROW_OUTCOMES, RowEnding, SweepRow, SweepRows, find_endings
from governor_mechanism.units.quantities import format_value
from governor_mechanism.units.text_table import short_repr

MAX_PRINTED_ROWS = 20
"""Maximum number of rows printed; a longer table is summarised by its extremes."""


@dataclass(frozen=True, kw_only=True)
class Sweep(AxisGrid, Result):
    """A scene run at every combination of the values of the axes.

    Attributes
    ----------
    title
        Title of the scene.
    source
        Path of the scene file.
    quantities
        Columns of the rows.
    accuracy
        Requested relative accuracy of the runs.
    rows
        One row per combination; rows[index] is a `SweepRow`. Numbers are SI; a run that ended early has only its duration.
    reason_of_choice
        Why these quantities characterise the motion; empty if the caller named them.
    """

    title: str
    source: str
    quantities: tuple[RunQuantity, ...]
    accuracy: float
    rows: SweepRows
    reason_of_choice: str = ""

    __repr__ = short_repr

    figure = "render.figures.sweep.sweep_figure"
    record = (
        *("title", "scene=scene_file", "axes", "quantities", "accuracy", "reason_of_choice"),
        *("rows", "outcomes", "endings", "notes"),
    )
    has_units_in_header = True

    @property
    def columns(self) -> tuple[Column, ...]:
        """The varied keys, the quantities, outcome and message; the text has an outcome only where rows ended in several ways."""
        outcome = "outcome" if self.endings else None
        keys = [self._axis_column(place, axis) for place, axis in enumerate(self.axes)]
        quantities = [self._quantity_column(place, quantity) for place, quantity in enumerate(self.quantities)]
        return (
            *keys,
            *quantities,
            Column("numbers", in_table=False),
            Column("outcome", outcome, lambda row: "" if row.ok else row.outcome.replace("_", " "), side="r"),
            Column("message"),
            Column("values", value=lambda row: self.values_at(row.index), in_table=False),
        )

    def _axis_column(self, place: int, axis: SweepAxis) -> Column:
        return _value_column(axis.key, axis, lambda row: self.values_at(row.index)[place])

    def _quantity_column(self, place: int, quantity: RunQuantity) -> Column:
        return _value_column(quantity.name, quantity, lambda row: row.numbers[place])

    @property
    def scene_file(self) -> str:
        """Name of the scene file."""
        return Path(self.source).name

    def values_of(self, column: Column) -> object:
        """Return the values of a column without a row in between, of which a sweep may have millions."""
        if column.key == "outcome":
            return self.rows.outcomes
        return [*map(self.rows.message, range(len(self.rows)))] if column.key == "message" else self.column(column.key)

    @property
    def units(self) -> dict[str, str]:
        """SI units of the axes and the quantities by name; empty if there is none."""
        return {axis.key: axis.unit for axis in self.axes} | {one.name: one.unit for one in self.quantities}

    @property
    def ok(self) -> bool:
        """Whether no row failed: each ran to its end, or ended in a way that is a result, as at the end of a mechanism's range."""
        return all(outcome in RESULT_ROW_OUTCOMES for outcome in self.rows.first_rows)

    @property
    def outcomes(self) -> dict[str, int]:
        """Number of rows per outcome, in the order in which the outcomes occur."""
        return {outcome: count for outcome, (_, count) in self.rows.first_rows.items()}

    def column(self, name: str) -> NDArray[Any]:
        """Return the values of a quantity or of a varied key.

        Parameters
        ----------
        name
            Name of a quantity or key of an axis.

        Returns
        -------
        NDArray
            SI, NaN if missing; shape (rows,).

        Raises
        ------
        MechanismError
            If the sweep has neither a quantity nor an axis of this name.
        """
        names = [*(one.name for one in self.quantities), *(axis.key for axis in self.axes)]
        if name not in names:
            found = repr(name) if isinstance(name, str) else format_value(name)
            raise MechanismError(f"the sweep has no {found}; it has {names}.{did_you_mean(name, names)}")
        position = names.index(name)
        if position < len(self.quantities):
            return self.rows.numbers[:, position].copy()
        axis_index = position - len(self.quantities)
        values = np.array(self.axes[axis_index].values)
        along_axis = values.reshape([-1 if k == axis_index else 1 for k in range(len(self.axes))])
        return np.broadcast_to(along_axis, self.shape).ravel()

    @cached_property
    def endings(self) -> tuple[RowEnding, ...]:
        """Ways in which rows ended other than at the end of their run with all numbers, by the first of their rows."""
        return find_endings(self.rows)

    def grid(self, name: str) -> NDArray[Any]:
        """Return the values of `column` in the shape of the axes: the first index counts the values of the first axis."""
        return self.column(name).reshape(self.shape)

    def values_at(self, index: int) -> tuple[float | str | bool, ...]:
        """Return the values of the keys in a row."""
        return tuple(axis.values[place] for axis, place in self.places(index))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Sentences on keys that change no quantity by more than the accuracy."""
        effect = f"changes {', '.join(one.name for one in self.quantities)} by less than the accuracy"
        return tuple(f"{axis.key} {effect}" for at, axis in enumerate(self.axes) if self._has_no_effect(at))

    def __str__(self) -> str:
        """Return a line per row, or for many rows the extremes of each quantity; then outcomes and notes."""
        shape_text = " x ".join(f"{len(axis.values)} of {axis.key}" for axis in self.axes)
        lines = [f"{self.title}: {len(self.rows):,} rows, {shape_text}"]
        if self.reason_of_choice:
            lines.append(f"quantities: {', '.join(one.name for one in self.quantities)} (chosen because {self.reason_of_choice})")
        lines += format_columns(self.columns, self.rows).splitlines() if len(self.rows) <= MAX_PRINTED_ROWS else self._format_extremes()
        lines += [self._describe_ending(ending) for ending in self.endings]
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _has_no_effect(self, axis_index: int) -> bool:
        """Return whether no quantity changes along an axis although there are values to compare."""
        has_comparison = False
        for quantity in self.quantities:
            values = np.moveaxis(self.grid(quantity.name), axis_index, 0).reshape(self.shape[axis_index], -1)
            values = values[:, np.isfinite(values).sum(axis=0) > 1]
            if not values.size:
                continue
            has_comparison = True
            threshold = self.accuracy * max(float(np.nanmax(np.abs(values))), quantity.scale)
            if np.any(np.nanmax(values, axis=0) - np.nanmin(values, axis=0) > threshold):
                return False
        return has_comparison

    def _format_extremes(self) -> Iterator[str]:
        for quantity in self.quantities:
            column = self.column(quantity.name)
            if not np.isfinite(column).any():
                yield f"{quantity.name}: no value in any row"
                continue
            descriptions = (
                f"{what} {_format_value(column[k], quantity)} at {', '.join(self._format_axis_values(self.rows[k]))}"
                for what, k in (("least", int(np.nanargmin(column))), ("greatest", int(np.nanargmax(column))))
            )
            yield f"{quantity.name}: {'; '.join(descriptions)}"

    def _describe_ending(self, ending: RowEnding) -> str:
        """Return a sentence on the rows that ended in a way."""
        is_whole = ending.count == len(self.rows)
        counted = f"all {ending.count:,} rows" if is_whole else f"{ending.count:,} of {len(self.rows):,} rows"
        if ending.has_common_cause:
            return f"{counted} {ending.text}"
        first = self.rows[ending.first_row]
        return f"{counted} {ending.words}; the first at {', '.join(self._format_axis_values(first))}: {first.message}"

    def _format_axis_values(self, row: SweepRow) -> list[str]:
        return list(map(_format_value, self.values_at(row.index), self.axes))


def _value_column(name: str, source: SweepAxis | RunQuantity, value_in: Callable[[SweepRow], float | str | bool]) -> Column:
    """Return the column of a key or quantity with its unit."""
    return Column(name, name, lambda row: _format_value(value_in(row), source), unit=source.unit, value=value_in, side="r", in_json=False)


def _format_value(value: float | str | bool, source: SweepAxis | RunQuantity) -> str:
    """Return a value with its unit; a missing number is a dash."""
    if not isinstance(value, float):
        return str(value)
    factor, unit = source.display_unit
    return f"{value * factor + 0.0:.6g} {unit}".strip() if math.isfinite(value) else "-"  # adding 0.0 turns -0 into 0

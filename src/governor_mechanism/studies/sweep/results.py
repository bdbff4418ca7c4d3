"""The result of a sweep: rows of numbers with their outcomes, as columns, as grids, and in words."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.studies.sweep.quantities import RunQuantity

ROW_REFUSED, ROW_FAILED = "refused", "failed"
"""Outcomes beside those of runs: of a scene that cannot be made or run, and of a row that met a fault."""

OK_ROW_OUTCOMES = ("done", "uncertified")

MAX_PRINTED_ROWS = 20
"""Rows: longer tables are told by their extremes."""


@dataclass(frozen=True, kw_only=True)
class SweepRow:
    """One run's numbers (SI, NaN where there is none), how it ended, and a sentence where that is not well."""

    index: int
    numbers: tuple[float, ...]
    outcome: str
    message: str = ""

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and missed nothing that was promised."""
        return self.outcome in OK_ROW_OUTCOMES


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A scene run at every combination of the axes' values; the rows stand in their order, the last axis fastest.

    Numbers are SI. Of runs that ended early there is none but their duration.
    """

    title: str
    source: str
    axes: tuple[SweepAxis, ...]
    quantities: tuple[RunQuantity, ...]
    accuracy: float
    rows: tuple[SweepRow, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """How many values each axis has."""
        return tuple(len(axis.values) for axis in self.axes)

    @property
    def units(self) -> dict[str, str]:
        """SI units of the axes and the quantities, by name; empty where there is none."""
        return {axis.key: axis.unit for axis in self.axes} | {one.name: one.unit for one in self.quantities}

    @property
    def ok(self) -> bool:
        """Whether every row is."""
        return all(row.ok for row in self.rows)

    @property
    def outcomes(self) -> dict[str, int]:
        """How many rows ended how, in the order in which they come."""
        return dict(Counter(row.outcome for row in self.rows))

    def column(self, name: str) -> NDArray[Any]:
        """The values (rows,) of a quantity (SI, NaN where there is none), or of a key that was varied.

        Raises MechanismError for another name.
        """
        names = [one.name for one in self.quantities]
        if name in names:
            position = names.index(name)
            return np.array([row.numbers[position] for row in self.rows])
        keys = [axis.key for axis in self.axes]
        if name not in keys:
            known_names = [*names, *keys]
            raise MechanismError(f"the sweep has no {name!r}; it has {known_names}.{did_you_mean(name, known_names)}")
        position = keys.index(name)
        values = self.axes[position].values
        return np.array([values[place] for place in np.indices(self.shape)[position].ravel()])

    def grid(self, name: str) -> NDArray[Any]:
        """The values of `column`, shaped as the axes: its first index counts the values of the first axis."""
        return self.column(name).reshape(self.shape)

    def values_at(self, index: int) -> tuple[float | str | bool, ...]:
        """The values of the keys in a row."""
        axis_indices = np.unravel_index(index, self.shape)
        return tuple(axis.values[int(place)] for axis, place in zip(self.axes, axis_indices, strict=True))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Sentences on keys that change no quantity by more than the accuracy."""
        return tuple(
            f"{axis.key} changes none of {', '.join(one.name for one in self.quantities)} by more than the accuracy"
            for at, axis in enumerate(self.axes)
            if self._has_no_effect(at)
        )

    def __str__(self) -> str:
        """A line for each row, or of many for each quantity its extremes; how the rows ended, and the notes."""
        shape_text = " x ".join(f"{len(axis.values)} of {axis.key}" for axis in self.axes)
        lines = [f"{self.title}: {len(self.rows):,} rows, {shape_text}"]
        lines += self._format_table() if len(self.rows) <= MAX_PRINTED_ROWS else self._format_extremes()
        if not self.ok:
            lines.append("outcomes: " + ", ".join(f"{count} {name}" for name, count in self.outcomes.items()))
            lines += self._format_failures()
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values; None where there is no number."""
        axes = [{"key": axis.key, "unit": axis.unit, "values": list(axis.values)} for axis in self.axes]
        rows = [
            {
                "values": list(self.values_at(row.index)),
                "numbers": [number if math.isfinite(number) else None for number in row.numbers],
                "outcome": row.outcome,
                "message": row.message,
            }
            for row in self.rows
        ]
        quantities = [{"name": one.name, "unit": one.unit} for one in self.quantities]
        header = {"title": self.title, "scene": self.source, "accuracy": self.accuracy, "axes": axes}
        return {**header, "quantities": quantities, "outcomes": self.outcomes, "notes": list(self.notes), "rows": rows}

    def _has_no_effect(self, axis_index: int) -> bool:
        """Whether nothing changes along an axis, and something could have."""
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

    def _format_table(self) -> list[str]:
        names = [*(axis.key for axis in self.axes), *(one.name for one in self.quantities), "outcome"]
        cells = [names, *([*self._format_axis_values(row), *self._format_numbers(row), row.outcome] for row in self.rows)]
        widths = [max(len(line[k]) for line in cells) for k in range(len(names))]
        return ["  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True)) for line in cells]

    def _format_extremes(self) -> Iterator[str]:
        for quantity in self.quantities:
            column = self.column(quantity.name)
            if not np.isfinite(column).any():
                yield f"{quantity.name}: no number in any row"
                continue
            extremes = (("least", int(np.nanargmin(column))), ("greatest", int(np.nanargmax(column))))
            descriptions = (
                f"{what} {_format_value(column[k], quantity)} at {', '.join(self._format_axis_values(self.rows[k]))}"
                for what, k in extremes
            )
            yield f"{quantity.name}: {'; '.join(descriptions)}"

    def _format_failures(self) -> Iterator[str]:
        """One sentence for each outcome that is not well."""
        reported_outcomes: set[str] = set()
        for row in self.rows:
            if not row.ok and row.outcome not in reported_outcomes:
                reported_outcomes.add(row.outcome)
                yield f"{row.outcome}, first at {', '.join(self._format_axis_values(row))}: {row.message}"

    def _format_axis_values(self, row: SweepRow) -> list[str]:
        values = zip(self.axes, self.values_at(row.index), strict=True)
        return [_format_value(v, axis) if isinstance(v, float) else str(v) for axis, v in values]

    def _format_numbers(self, row: SweepRow) -> list[str]:
        pairs = zip(self.quantities, row.numbers, strict=True)
        return [_format_value(v, one) if math.isfinite(v) else "-" for one, v in pairs]


def _format_value(value: float, source: SweepAxis | RunQuantity) -> str:
    factor, unit = source.display_unit
    return f"{value * factor + 0.0:.6g} {unit}".strip()  # adding zero: no minus before a zero

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
from governor_mechanism.studies.sweep.parameters import Axis
from governor_mechanism.studies.sweep.quantities import Quantity

REFUSED, FAILED = "refused", "failed"
"""Outcomes beside those of runs: of a scene that cannot be made or run, and of a row that met a fault."""

FINE = ("done", "uncertified")

TOLD_WHOLE = 20
"""Rows: longer tables are told by their extremes."""


@dataclass(frozen=True, kw_only=True)
class Row:
    """One run's numbers (SI, NaN where there is none), how it ended, and a sentence where that is not well."""

    index: int
    numbers: tuple[float, ...]
    outcome: str
    message: str = ""

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and missed nothing that was promised."""
        return self.outcome in FINE


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """A scene run at every combination of the axes' values; the rows stand in their order, the last axis fastest.

    Numbers are SI. Of runs that ended early there is none but their duration.
    """

    title: str
    source: str
    axes: tuple[Axis, ...]
    quantities: tuple[Quantity, ...]
    accuracy: float
    rows: tuple[Row, ...]

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
            at = names.index(name)
            return np.array([row.numbers[at] for row in self.rows])
        keys = [axis.key for axis in self.axes]
        if name not in keys:
            known = [*names, *keys]
            raise MechanismError(f"the sweep has no {name!r}; it has {known}.{did_you_mean(name, known)}")
        at = keys.index(name)
        values = self.axes[at].values
        return np.array([values[place] for place in np.indices(self.shape)[at].ravel()])

    def grid(self, name: str) -> NDArray[Any]:
        """The values of `column`, shaped as the axes: its first index counts the values of the first axis."""
        return self.column(name).reshape(self.shape)

    def values_at(self, index: int) -> tuple[float | str | bool, ...]:
        """The values of the keys in a row."""
        places = np.unravel_index(index, self.shape)
        return tuple(axis.values[int(place)] for axis, place in zip(self.axes, places, strict=True))

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """Sentences on keys that change no quantity by more than the accuracy."""
        return tuple(
            f"{axis.key} changes none of {', '.join(one.name for one in self.quantities)} by more than the accuracy"
            for at, axis in enumerate(self.axes)
            if self._idle(at)
        )

    def __str__(self) -> str:
        """A line for each row, or of many for each quantity its extremes; how the rows ended, and the notes."""
        sizes = " x ".join(f"{len(axis.values)} of {axis.key}" for axis in self.axes)
        lines = [f"{self.title}: {len(self.rows):,} rows, {sizes}"]
        lines += self._table() if len(self.rows) <= TOLD_WHOLE else self._extremes()
        if not self.ok:
            lines.append("outcomes: " + ", ".join(f"{count} {name}" for name, count in self.outcomes.items()))
            lines += self._reasons()
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
        told = {"title": self.title, "scene": self.source, "accuracy": self.accuracy, "axes": axes}
        return {**told, "quantities": quantities, "outcomes": self.outcomes, "notes": list(self.notes), "rows": rows}

    def _idle(self, at: int) -> bool:
        """Whether nothing changes along an axis, and something could have."""
        compared = False
        for one in self.quantities:
            lines = np.moveaxis(self.grid(one.name), at, 0).reshape(self.shape[at], -1)
            lines = lines[:, np.isfinite(lines).sum(axis=0) > 1]
            if not lines.size:
                continue
            compared = True
            least = self.accuracy * max(float(np.nanmax(np.abs(lines))), one.scale)
            if np.any(np.nanmax(lines, axis=0) - np.nanmin(lines, axis=0) > least):
                return False
        return compared

    def _table(self) -> list[str]:
        names = [*(axis.key for axis in self.axes), *(one.name for one in self.quantities), "outcome"]
        cells = [names, *([*self._where(row), *self._numbers(row), row.outcome] for row in self.rows)]
        widths = [max(len(line[k]) for line in cells) for k in range(len(names))]
        return ["  ".join(f"{cell:>{width}}" for cell, width in zip(line, widths, strict=True)) for line in cells]

    def _extremes(self) -> Iterator[str]:
        for one in self.quantities:
            column = self.column(one.name)
            if not np.isfinite(column).any():
                yield f"{one.name}: no number in any row"
                continue
            told = (("least", int(np.nanargmin(column))), ("greatest", int(np.nanargmax(column))))
            words = (f"{what} {_spoken(column[k], one)} at {', '.join(self._where(self.rows[k]))}" for what, k in told)
            yield f"{one.name}: {'; '.join(words)}"

    def _reasons(self) -> Iterator[str]:
        """One sentence for each outcome that is not well."""
        told: set[str] = set()
        for row in self.rows:
            if not row.ok and row.outcome not in told:
                told.add(row.outcome)
                yield f"{row.outcome}, first at {', '.join(self._where(row))}: {row.message}"

    def _where(self, row: Row) -> list[str]:
        values = zip(self.axes, self.values_at(row.index), strict=True)
        return [_spoken(v, axis) if isinstance(v, float) else str(v) for axis, v in values]

    def _numbers(self, row: Row) -> list[str]:
        told = zip(self.quantities, row.numbers, strict=True)
        return [_spoken(v, one) if math.isfinite(v) else "-" for one, v in told]


def _spoken(value: float, of: Axis | Quantity) -> str:
    factor, unit = of.everyday
    return f"{value * factor + 0.0:.6g} {unit}".strip()  # adding zero: no minus before a zero

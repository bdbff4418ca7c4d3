"""Result of a fit: values with standard errors and intervals, correlations, what the data do not determine, residuals."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from governor_mechanism.model.results.result import Column, Recorded, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.fitting.data import Measurement
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import DISPLAY_UNITS, format_quantity

CONFIDENCE = 0.95
"""Probability with which an interval holds the true value."""


@dataclass(frozen=True, kw_only=True)
class FittedValue(Recorded):
    """Value of an unknown that fits best.

    Attributes
    ----------
    key
        Key of the scene.
    value
        Value, SI.
    unit
        SI unit.
    standard_error
        Standard error, SI; None where the data do not determine the value.
    low, high
        Ends of the 95 % interval, SI; None where the data do not determine the value.
    bounds
        Bounds of the search, SI.
    at_bound
        Whether the value lies at one of them.
    by_profile
        Whether the interval is that of the profile of the likelihood, and not of the standard error.
    """

    key: str
    value: float
    unit: str
    standard_error: float | None
    low: float | None
    high: float | None
    bounds: tuple[float, float]
    at_bound: bool
    by_profile: bool = False


def _format_value(row: FittedValue) -> str:
    return _round(row, row.value)


def _format_error(row: FittedValue) -> str:
    return "not determined" if row.standard_error is None else f"± {_round(row, row.standard_error)}"


def _round(row: FittedValue, value: float) -> str:
    """Return a value with the digits that two digits of its standard error allow."""
    factor, unit = DISPLAY_UNITS.get(row.unit, (1.0, row.unit))
    if not row.standard_error:
        return format_quantity(value, row.unit)
    decimals = max(0, 1 - math.floor(math.log10(row.standard_error * factor)))
    return f"{value * factor:.{decimals}f} {unit}".rstrip()


def _format_interval(row: FittedValue) -> str:
    notes = ["at a bound"] * row.at_bound + ["profile"] * row.by_profile
    ends = [] if row.low is None or row.high is None else [f"{_round(row, row.low)} to {_round(row, row.high)}"]
    return "; ".join([*ends, *notes])


@dataclass(frozen=True, kw_only=True, eq=False)
class Fit(Result):
    """Values of unknowns that fit measured readings best.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        The values.
    correlation_matrix
        Correlations of the errors of the values; shape (unknowns, unknowns). Zero for those that the data do not determine.
    not_identifiable
        A sentence for each combination of unknowns that the data do not determine.
    measurements
        The data.
    noise
        Standard deviation of a measured value by reading, SI: as given, or estimated from the residuals.
    is_noise_given
        Whether the noise was given.
    residuals
        Measured less computed values by reading, SI, at the times that the run reaches; shape (n,).
    scene
        The scene with the fitted values.
    run
        Certified run of that scene, at the times of the data.
    n_runs
        Number of runs.
    n_starts
        Number of starts of the search.
    seed
        Seed of the random starts.
    converged
        Whether the search ended at a minimum.
    outcome
        How it ended, in a sentence.
    notes
        Further sentences.
    """

    title: str
    rows: tuple[FittedValue, ...]
    correlation_matrix: FloatArray
    not_identifiable: tuple[str, ...]
    measurements: tuple[Measurement, ...]
    noise: Mapping[str, float]
    is_noise_given: bool
    residuals: Mapping[str, FloatArray]
    scene: Scene
    run: Trajectory
    n_runs: int
    n_starts: int
    seed: int
    converged: bool
    outcome: str
    notes: tuple[str, ...] = ()

    hidden = ("measurements", "scene", "run", "residuals")
    columns: ClassVar[tuple[Column, ...]] = (
        Column("key", "key"),
        Column("value", "value", _format_value, side="r"),
        Column("standard_error", "standard error", _format_error, side="r"),
        Column("", "95 % interval", _format_interval),
        Column("unit"),
        Column("low"),
        Column("high"),
        Column("at_bound"),
    )
    index: ClassVar[str] = "key"
    figure: ClassVar[str] = "render.figures.optimum.fit_figure"
    data_files: ClassVar[tuple[str, ...]] = ("csv", "json")

    @property
    def ok(self) -> bool:
        """Whether the search converged."""
        return self.converged

    @property
    def values(self) -> dict[str, float]:
        """The values by key, SI."""
        return {row.key: row.value for row in self.rows}

    @property
    def standard_errors(self) -> dict[str, float | None]:
        """The standard errors by key, SI; None where the data do not determine the value."""
        return {row.key: row.standard_error for row in self.rows}

    @property
    def intervals(self) -> dict[str, tuple[float, float] | None]:
        """The 95 % intervals by key, SI; None where the data do not determine the value."""
        return {row.key: None if row.low is None or row.high is None else (row.low, row.high) for row in self.rows}

    @property
    def correlations(self) -> dict[tuple[str, str], float]:
        """The correlations of the errors by two keys."""
        keys = [row.key for row in self.rows]
        return {(one, other): float(self.correlation_matrix[i, k]) for i, one in enumerate(keys) for k, other in enumerate(keys) if i < k}

    def __str__(self) -> str:
        return "\n".join([f"{self.title}: {self.outcome}", format_columns(self.columns, self.rows), *self._closing_lines()])

    def _closing_lines(self) -> list[str]:
        """Return noise, strong correlations, what is not identifiable, and notes."""
        kind = "given" if self.is_noise_given else "estimated"
        units = {one.reading: one.unit for one in self.measurements}
        lines = [f"noise of {name}: {format_quantity(level, units[name])} ({kind})" for name, level in self.noise.items()]
        strong = {pair: value for pair, value in self.correlations.items() if abs(value) > 0.9}
        lines += [f"correlation of {one} and {other}: {value:.3f}" for (one, other), value in strong.items()]
        return [*lines, *self.not_identifiable, *self.notes, f"{self.n_runs} runs from {self.n_starts} starts, seed {self.seed}"]


def root_mean_square(values: Sequence[float] | FloatArray) -> float:
    """Return the root mean square of values."""
    return float(np.sqrt(np.mean(np.square(values))))

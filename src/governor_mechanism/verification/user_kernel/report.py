"""The report of a kernel: each comparison with the error of the simulation beside it, and the worst case with its inputs."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from governor_mechanism.model.results.result import Column, format_columns
from governor_mechanism.units.quantities import format_quantity
from governor_mechanism.verification.report import MAX_PRINTED_ROWS, CheckReport, ComparisonRow
from governor_mechanism.verification.user_kernel.function import format_number


@dataclass(frozen=True)
class KernelRow(ComparisonRow):
    """One comparison with a kernel, in `unit`; `expected` is the kernel's result, NaN where it gave none.

    Attributes
    ----------
    error_estimate
        Estimate of the simulation's own error; part of `allowed`.
    scale
        Value to which the tolerance is relative.
    inputs
        What varies from row to row, by name with its unit, SI.
    arguments
        With what the kernel was called, by its own names and in its own units.
    problem
        Why the kernel gave no number; empty if it did.
    """

    error_estimate: float = 0.0
    scale: float = 0.0
    inputs: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    arguments: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    problem: str = ""

    @property
    def relative_error(self) -> float:
        """(kernel - simulation) / scale; NaN where the kernel gave no number, infinite if only the scale is zero."""
        error = self.expected - self.simulated
        return error / self.scale if self.scale else math.copysign(math.inf, error) if error else 0.0

    @property
    def failure(self) -> str:
        """What differs, in a sentence."""
        return self.problem or f"{super().failure}; {format_percent(self.relative_error)}"

    @property
    def place(self) -> str:
        """The inputs in a phrase."""
        return ", ".join(f"{name} = {format_quantity(value, unit)}" for name, (value, unit) in self.inputs.items()) or "the scene as it is"


@dataclass(frozen=True, kw_only=True)
class KernelReport(CheckReport):
    """Comparison of a user's kernel with the simulation; `rows` are of type `KernelRow`.

    Attributes
    ----------
    rows
        The comparisons.
    quantity
        What is compared.
    unit
        Its unit in the rows.
    description
        What it is, in a phrase.
    tolerance
        Relative tolerance.
    defects
        Sentences on what the kernel must not do, whatever its results.
    is_vectorised
        Whether the kernel was called with arrays.
    """

    rows: tuple[KernelRow, ...]
    quantity: str
    unit: str
    description: str
    tolerance: float
    defects: tuple[str, ...] = ()
    is_vectorised: bool = False

    figure = "render.figures.errors.kernel_errors_figure"
    record = (
        *("title", "against", "quantity", "unit", "description", "tolerance", "passed", "is_vectorised"),
        *("largest_error_estimate", "units_of_arguments", "worst", "rows", "notes", "defects"),
    )

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the comparisons."""
        return (
            Column("quantity", "at", "{place}", in_json=False),
            Column("inputs", value=lambda row: {name: value for name, (value, _) in row.inputs.items()}, in_table=False),
            Column("simulated", "simulated", ".12g"),
            Column("error_estimate", "± error", ".1e"),
            Column("expected", self.against, ".12g"),
            Column("difference", "difference", lambda row: f"{0.0 - row.difference:+.1e}", side="r"),
            Column("relative_error", "relative", lambda row: format_percent(row.relative_error), side="r"),
            Column("allowed"),
            *(Column(name, in_json=False) for name in ("unit", "reason")),
            Column("arguments", value=lambda row: {name: value for name, (value, _) in row.arguments.items()}, in_table=False),
            Column("passed", "verdict", "{verdict}"),
            Column("problem"),
        )

    @property
    def units_of_arguments(self) -> dict[str, str]:
        """Unit of each argument of the kernel."""
        return {name: unit for name, (_, unit) in self.rows[0].arguments.items()}

    @property
    def passed(self) -> bool:
        """Whether there are rows, every one passes, and the kernel has no defect."""
        return super().passed and not self.defects

    @property
    def worst(self) -> KernelRow:
        """The row with the largest relative error; one without a number before all others."""
        return max(self.rows, key=lambda row: math.inf if math.isnan(row.relative_error) else abs(row.relative_error))

    @property
    def largest_error_estimate(self) -> float:
        """Largest estimate of the simulation's own error, relative to the scale of its row."""
        return max((row.error_estimate / row.scale for row in self.rows if row.scale), default=math.nan)

    def __str__(self) -> str:
        """Return the report as a table with the worst case, notes and the verdict."""
        is_long = len(self.rows) > MAX_PRINTED_ROWS
        failed_first = sorted(self.rows, key=lambda row: (not row.problem, -abs(row.relative_error)))
        shown = failed_first[:MAX_PRINTED_ROWS] if is_long else self.rows
        return "\n".join(
            [
                self.title,
                f"{self.quantity}, {self.unit or '1'}: {self.description}",
                self._describe_call(),
                format_columns(self.columns, shown),
                self.describe_worst(),
                *(f"note: {note}" for note in self.notes),
                *(f"defect: {defect}" for defect in self.defects),
                self._verdict() + (f" (the {MAX_PRINTED_ROWS} largest differences shown)" if is_long else ""),
            ]
        )

    def describe_worst(self, *, with_call: bool = True) -> str:
        """Return the worst case with its inputs in a sentence, and the arguments of the kernel if wanted."""
        row = self.worst
        if row.problem:
            return f"worst: {row.place}: {row.problem}"
        called = ", ".join(f"{name} = {format_number(value, unit)}" for name, (value, unit) in row.arguments.items())
        numbers = f"{row.expected:.12g} against {row.simulated:.12g} ± {row.error_estimate:.1e} {self.unit}".rstrip(" 1")
        sentence = f"worst: {format_percent(row.relative_error)} at {row.place}: {numbers}"
        return f"{sentence}, called with {called}" if called and with_call else sentence

    def _describe_call(self) -> str:
        arguments = ", ".join(f"{name} ({unit or '1'})" for name, unit in self.units_of_arguments.items())
        return f"{self.against}({arguments}) called with {'arrays' if self.is_vectorised else 'single numbers'}"

    def _verdict(self) -> str:
        n_failed = sum(not row.passed for row in self.rows)
        counted = f"{n_failed} of {len(self.rows)} do not agree" if n_failed else f"all {len(self.rows)} agree"
        verdict = f"{counted} within {self.tolerance:g} of the simulation, besides its own error"
        return f"{verdict}, but the kernel has a defect" if self.defects and not n_failed else verdict


def format_percent(ratio: float) -> str:
    """Return a ratio in percent with its sign."""
    percent = 100 * ratio
    return f"{percent:+.4g} %" if percent == 0 or abs(percent) >= 1e-3 else f"{percent:+.1e} %"

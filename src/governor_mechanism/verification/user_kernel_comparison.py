"""Comparison of the simulation with a user's kernel, the quantities that one may compute, and the report."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain
from types import SimpleNamespace
from typing import Any

import numpy as np

from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity
from governor_mechanism.verification.report import MAX_PRINTED_ROWS, CheckReport, ComparisonRow
from governor_mechanism.verification.user_kernel import (
    Kernel,
    KernelResults,
    SampleGroup,
    VariedKey,
    call_kernel,
    format_number,
    grid_groups,
    match_arguments,
    name_of_kernel,
    parse_inputs,
    random_groups,
)
from governor_mechanism.verification.user_kernel_quantities import (
    TIME,
    engine_quantities,
    position_quantities,
    run_quantities,
    static_quantities,
    valve_quantities,
)
from governor_mechanism.verification.user_kernel_simulation import Quantity, Series, Simulated, constant_units, constant_values, unit_factor


@dataclass(frozen=True)
class KernelRow(ComparisonRow):
    """One comparison with a kernel, in `unit`; `expected` is the kernel's result, NaN where it gave none."""

    error_estimate: float = 0.0  # estimate of the simulation's own error; part of `allowed`
    scale: float = 0.0  # value to which the tolerance is relative
    # what varies from row to row, by name with its unit, SI
    inputs: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    # with what the kernel was called, by its own names and in its own units
    arguments: Mapping[str, tuple[float, str]] = field(default_factory=dict)
    problem: str = ""  # why the kernel gave no number; empty if it did

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
    data_files = ("json",)
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
        failed_first = sorted(range(len(self.rows)), key=lambda i: (not self.rows[i].problem, -abs(self.rows[i].relative_error)))
        shown = [self.rows[i] for i in sorted(failed_first[:MAX_PRINTED_ROWS])]  # in the order of the inputs
        return "\n".join(
            [
                self.title,
                f"{self.quantity}, {self.unit or '1'}: {self.description}",
                self._describe_call(),
                format_columns(self.columns, shown),
                self.describe_worst(),
                *self._describe_ratio(),
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

    def _describe_ratio(self) -> list[str]:
        """Return a sentence on the ratio of kernel and simulation if they differ by one factor in all rows, or nothing."""
        ratios = np.array([row.expected / row.simulated for row in self.rows if row.simulated])
        if len(ratios) < max(2, len(self.rows)) or not np.ptp(ratios) <= self.tolerance * abs(ratios[0]) < abs(ratios[0] - 1.0):
            return []
        return [f"the kernel is {ratios[0]:.9g} times the simulation in every row: look for a constant factor"]

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


KERNEL_RELATIVE_TOLERANCE = 1e-6
"""Relative tolerance of a kernel: far above the error of the simulation (1e-11), far below that of a wrong formula."""

RUN_ACCURACY_RATIO = 0.1
"""Accuracy of a run over the tolerance of a kernel, so that the run's own error hardly widens it."""

MAX_REFUSALS = 3
"""Largest number of samples that cannot be simulated whose reasons are named."""


def kernel_quantities(
    scene: Scene,  # any scene. Quantities of statics are those of the part that turns with a spindle, alone
) -> Iterator[Quantity]:
    """Yield the quantities that a kernel may compute: at given positions, then of the whole scene, at last over time."""
    for quantity, _ in _quantities_with_scenes(scene):
        yield quantity


def _quantities_with_scenes(scene: Scene) -> Iterator[tuple[Quantity, Scene]]:
    """Yield the quantities with the scene that they are evaluated in: that of the rotating part alone, or the whole."""
    alone = _part_alone(scene)
    if alone is not None:
        for quantity in chain(static_quantities(alone), position_quantities(alone), valve_quantities(alone)):
            yield quantity, alone
    for quantity in chain(engine_quantities(scene), run_quantities(scene)):
        yield quantity, scene


def _part_alone(scene: Scene) -> Scene | None:
    """Return the scene of the only part, or of the part that turns with a spindle; None if no part has quantities of its own."""
    if len(scene.parts) == 1:
        return scene
    try:
        return rotating_part_alone(scene)
    except MechanismError:  # no part or several turn, or the part depends on others; the run of the whole scene is left
        return None


def check_kernel(
    scene: Scene,
    # function of numbers or arrays. Its parameters are matched by name: dimensions, `gravity`, the inputs and
    # arguments of the quantity
    kernel: Kernel,
    quantity: str,
    # values of the inputs of the quantity by name: SI, or text with units, also a range such as "15 deg:45
    # deg:25"
    over: Mapping[str, Any] | None = None,
    # tolerance relative to the simulated value; for readings, which may pass zero, relative to their scale
    allowed: float = KERNEL_RELATIVE_TOLERANCE,
    *,
    # our name by the kernel's name where they differ, with a unit if it is not SI, as {"alpha": "arm_angle in
    # deg"}
    names: Mapping[str, str] | None = None,
    unit: str | None = None,  # unit of the kernel's result; SI if None
    varied: Sequence[VariedKey] = (),
    # number of random samples between the limits of all inputs and keys; None for the grid of all values
    random: int | None = None,
    seed: int = 0,
) -> KernelReport:
    """Compare a function with the simulation; raise MechanismError if an argument is wrong, or there is no number anywhere."""
    if not allowed > 0:
        raise MechanismError(f"allowed is a relative tolerance above 0, such as 1e-6; got {allowed:g}")
    chosen, studied = _find_quantity(scene, quantity, over or {})
    factor = 1.0 if unit is None else unit_factor(unit, chosen.unit, "the kernel's result", is_frequency=chosen.is_frequency)
    if varied and not studied.document:
        raise MechanismError("keys vary only in a scene from a file or a dictionary, and not in a part alone; leave vary out")
    inputs = parse_inputs(chosen, over or {})
    groups = grid_groups(studied, inputs, varied) if random is None else random_groups(studied, inputs, varied, random, seed)
    samples, notes = _simulate_groups(groups, chosen, RUN_ACCURACY_RATIO * allowed)
    arguments = match_arguments(kernel, _available_arguments(chosen, samples), names or {})
    results = call_kernel(kernel, arguments, sum(len(result.values) for _, result in samples), is_history=TIME in chosen.inputs)
    rows = _make_rows(chosen, samples, results, arguments, allowed, factor, unit or chosen.unit)
    if len(results.problems) == len(rows):
        raise MechanismError(f"{name_of_kernel(kernel)} gave no number anywhere; at {rows[0].place}: {rows[0].problem}")
    n_coarse = sum(row.error_estimate > allowed * row.scale for row in rows)
    if n_coarse:
        notes.append(
            f"in {n_coarse} of {len(rows)} points the error of the simulation exceeds the tolerance of the kernel, and is allowed too"
        )
    return KernelReport(
        title=scene.title,
        against=name_of_kernel(kernel),
        rows=rows,
        notes=tuple(notes),
        quantity=chosen.name,
        unit=unit or chosen.unit,
        description=chosen.description,
        tolerance=allowed,
        defects=results.defects,
        is_vectorised=results.is_vectorised,
    )


def _find_quantity(scene: Scene, name: str, over: Mapping[str, Any]) -> tuple[Quantity, Scene]:
    """Return the quantity of a name with its scene, over time if times are given; raise MechanismError if there is none."""
    wanted = name.strip().replace(" ", "_").replace("-", "_")
    known = list[str]()
    found = list[tuple[Quantity, Scene]]()
    for one, studied in _quantities_with_scenes(scene):
        known.append(one.name)
        if one.name == wanted:
            found.append((one, studied))
            if (TIME in over) == (TIME in one.inputs):
                return one, studied
    if found:
        return found[0]
    listed = ", ".join(dict.fromkeys(known))
    raise MechanismError(f"unknown quantity {name!r}; available: {listed}.{did_you_mean(wanted, known)}")


def _simulate_groups(
    groups: Iterator[SampleGroup], quantity: Quantity, accuracy: float
) -> tuple[list[tuple[SampleGroup, Simulated]], list[str]]:
    """Return the groups with their results, and notes; a changed scene that cannot be simulated is noted and left out."""
    samples = list[tuple[SampleGroup, Simulated]]()
    notes = list[str]()
    refusals = list[str]()
    n_groups = 0
    for group in groups:
        n_groups += 1
        try:
            result = quantity.evaluate(group.scene, group.inputs, accuracy)
        except MechanismError as error:
            if not group.changes:
                raise
            changes = ", ".join(f"{key} = {column.values[0]:.6g} {column.unit}" for key, column in group.changes.items())
            refusals.append(f"{changes}: {error.problems[0]}")
            continue
        samples.append((group, result))
        notes += result.notes
    if not samples:
        raise MechanismError(*refusals[:MAX_REFUSALS])
    if refusals:
        notes.append(
            f"{len(refusals)} of {n_groups} scenes are left out, as they cannot be simulated; {'; '.join(refusals[:MAX_REFUSALS])}"
        )
    return samples, list(dict.fromkeys(notes))


def _available_arguments(quantity: Quantity, samples: Sequence[tuple[SampleGroup, Simulated]]) -> dict[str, Series]:
    """Return all that a kernel may take, of n values each: dimensions, gravity, inputs and arguments of the quantity."""
    tables = [_arguments_of_group(quantity, *sample) for sample in samples]
    shared = [name for name in tables[0] if all(name in table for table in tables)]
    return {name: Series(np.concatenate([table[name].values for table in tables]), tables[0][name].unit) for name in shared}


def _arguments_of_group(quantity: Quantity, group: SampleGroup, result: Simulated) -> dict[str, Series]:
    count = len(result.values)
    units = constant_units(group.scene)
    constants = {name: Series(np.full(count, value), units[name]) for name, value in constant_values(group.scene).items()}
    inputs = {name: Series(values[:count], quantity.inputs[name].unit) for name, values in group.inputs.items()}
    return {**constants, **inputs, **result.arguments}


def _make_rows(
    quantity: Quantity,
    samples: Sequence[tuple[SampleGroup, Simulated]],
    results: KernelResults,
    arguments: Mapping[str, Series],
    allowed: float,
    factor: float,
    unit: str,
) -> tuple[KernelRow, ...]:
    """Return the comparisons in the unit of the kernel."""
    simulated = np.concatenate([result.values for _, result in samples])
    errors = np.concatenate([result.errors for _, result in samples])
    scales = _scales(samples, float(np.max(np.abs(simulated))))
    places = list(chain.from_iterable(_places(quantity, group, len(result.values)) for group, result in samples))
    returned = factor * results.values
    if quantity.period:
        returned = simulated + np.array(
            [math.remainder(one, quantity.period) if math.isfinite(one) else one for one in returned - simulated]
        )
    called = list(arguments.items())
    return tuple(
        KernelRow(
            quantity=f"{quantity.name} at {_describe_place(place)}" if place else quantity.name,
            simulated=float(simulated[k]) / factor,
            expected=float(returned[k]) / factor,
            allowed=(allowed * float(scales[k]) + float(errors[k])) / factor,
            unit=unit,
            reason="the requested relative tolerance, and the error estimate of the simulation",
            error_estimate=float(errors[k]) / factor,
            scale=float(scales[k]) / factor,
            inputs=place,
            arguments={name: (float(column.values[k]), column.unit) for name, column in called},
            problem=results.problems.get(k, ""),
        )
        for k, place in enumerate(places)
    )


def _scales(samples: Sequence[tuple[SampleGroup, Simulated]], largest: float) -> FloatArray:
    """Return the values (n,) to which the tolerance is relative: the given ones, or the results, or the largest where they are zero."""
    columns = []
    for _, result in samples:
        magnitudes = np.abs(result.values) if result.scale is None else np.full(len(result.values), result.scale)
        columns.append(np.where(magnitudes > 0, magnitudes, largest))
    return np.concatenate(columns)


def _places(quantity: Quantity, group: SampleGroup, count: int) -> Iterator[dict[str, tuple[float, str]]]:
    """Yield the inputs and changes of each comparison with their units."""
    changes = {key: (float(column.values[0]), column.unit) for key, column in group.changes.items()}
    for k in range(count):
        inputs = {name: (float(values[k]), quantity.inputs[name].unit) for name, values in group.inputs.items()}
        yield inputs | changes


def _describe_place(place: Mapping[str, tuple[float, str]]) -> str:
    return ", ".join(f"{name} = {value:.6g}" for name, (value, _) in place.items())


_DERIVATIVES = SimpleNamespace(
    name="rate_of_READING, acceleration_of_READING",
    unit="",
    inputs=None,
    description="first and second time derivative of a reading, at a position and a rate (1 in SI unless given), or over time",
)
"""The row that stands for all derivatives of readings."""


def _is_derivative(quantity: Quantity) -> bool:
    return quantity.name.startswith(("rate_of_", "acceleration_of_"))


def _format_inputs(quantity: Quantity) -> str:
    if quantity.inputs is None:
        return ""
    names = [f"{name} ({one.unit})" if one.default is None else f"[{name} ({one.unit})]" for name, one in quantity.inputs.items()]
    return ", ".join(names) or "-"


@dataclass(frozen=True, kw_only=True)
class QuantityListing(Result):
    """The quantities of a scene, and the constants (with their units) that every kernel may take."""

    title: str
    quantities: tuple[Quantity, ...]
    constants: Mapping[str, str]

    record = ("title", "quantities=rows", "constants")
    columns = (
        Column("name", "quantity"),
        Column("unit", "unit"),
        Column("over", "over", _format_inputs, value=lambda one: {name: given.unit for name, given in one.inputs.items()}, in_table=False),
        Column("optional", value=lambda one: [n for n, given in one.inputs.items() if given.default is not None], in_table=False),
        Column("description", "what it is"),
        Column("arguments", in_table=False),
    )

    @property
    def rows(self) -> tuple[Quantity, ...]:
        """The quantities, which are the rows of tables."""
        return self.quantities

    def __str__(self) -> str:
        """Return a table of the quantities, with the arguments that a kernel may have below it."""
        rows: list[object] = [one for one in self.quantities if not _is_derivative(one)]
        if any(map(_is_derivative, self.quantities)):
            rows.append(_DERIVATIVES)
        table = format_columns(self.columns, rows)
        units = ", ".join(f"{name} ({unit or '1'})" for name, unit in self.constants.items())
        of_positions = [one for one in self.quantities if "time" not in one.inputs]
        others = sorted({name for one in of_positions for name in one.arguments} - self.constants.keys())
        lines = [
            f"arguments of every kernel, in SI: {units}; infinite where they are left out",
            *([] if "gravity" in self.constants else ["at a position those of the rotating part have no part in front of their names"]),
            "and what stands under `over`, optional in brackets",
            *([f"at a position also: {', '.join(others)}, besides the quantity itself"] if others else []),
            "over time also: all other readings of the run",
        ]
        return "\n".join([self.title, table, "", *lines])


def list_quantities(scene: Scene) -> QuantityListing:
    """Return the quantities of a scene that a kernel may compute; it prints as a table."""
    return QuantityListing(title=scene.title, quantities=tuple(kernel_quantities(scene)), constants=constant_units(scene))

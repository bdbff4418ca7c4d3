"""Where a kernel is compared: a grid of inputs and of changed scenes, or random ones."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from numbers import Integral, Real
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value, number_or_text, parse_quantity
from governor_mechanism.verification.user_kernel.simulated import Column, Input, Quantity
from governor_mechanism.verification.user_kernel.units import kind_of_unit

MAX_SAMPLES = 100_000
"""Largest number of comparisons; it bounds memory and time."""

RANGE_EXAMPLE = '"15 deg:45 deg:25" (first, last, number of values)'


@dataclass(frozen=True, kw_only=True)
class VariedKey:
    """A key of a scene and the numbers (SI, with their unit) that it takes; of random ones the first and the last are the limits."""

    key: str
    values: tuple[float, ...]
    unit: str


@dataclass(frozen=True, kw_only=True)
class SampleGroup:
    """A scene, what was changed in it by key, and the inputs (n,) at which it is evaluated, by name."""

    scene: Scene
    changes: Mapping[str, Column]
    inputs: Mapping[str, FloatArray]


def parse_inputs(quantity: Quantity, over: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return the values (n,) of each input in SI, as they are given; optional inputs that are not given are left out.

    Raises MechanismError for an unknown or missing input, or values that are not understood.
    """
    unknown = [name for name in over if name not in quantity.inputs]
    missing = [name for name, one in quantity.inputs.items() if one.default is None and name not in over]
    if unknown or missing:
        raise MechanismError(_wrong_inputs(quantity, unknown, missing))
    return {name: _parse_values(name, values, quantity.inputs[name]) for name, values in over.items()}


def _wrong_inputs(quantity: Quantity, unknown: Sequence[str], missing: Sequence[str]) -> str:
    required = [name for name, one in quantity.inputs.items() if one.default is None]
    optional = [name for name in quantity.inputs if name not in required]
    wanted = " and ".join(map(repr, required)) if required else "nothing"
    sentence = f"`over` must give values of {wanted} for {quantity.name}"
    sentence += f", and may give {' and '.join(map(repr, optional))}" if optional else ""
    if missing and not unknown:
        return f"{sentence}; {' and '.join(map(repr, missing))} is missing: crosscheck needs over={{{missing[0]!r}: [...]}}"
    return f"{sentence}; got {list(unknown)}.{did_you_mean(unknown[0], quantity.inputs)}"


def _parse_values(name: str, values: object, one: Input) -> FloatArray:
    """Return values (n,) in SI from numbers, texts with units, a range in text, or an array."""
    if isinstance(values, str):
        return _parse_text(name, values, one)
    if isinstance(values, Real) and not isinstance(values, bool):
        values = [values]
    if isinstance(values, np.ndarray):
        values = values.tolist() if values.ndim == 1 else None
    if not isinstance(values, Sequence) or not values or isinstance(values, bytes):
        raise MechanismError(f"values of {name!r} must be a list of finite numbers in SI, or text such as {RANGE_EXAMPLE}")
    return np.array([_parse_number(name, value, one) for value in values])


def _parse_text(name: str, text: str, one: Input) -> FloatArray:
    ends = [part.strip() for part in text.split(":")]
    if len(ends) == 1:
        return np.array([_parse_number(name, number_or_text(part), one) for part in text.split(",")])
    low, high = (_parse_number(name, number_or_text(part), one) for part in ends[:2])
    if len(ends) == 2:
        return np.array([low, high])
    if len(ends) != 3 or not ends[2].isdecimal() or not 1 <= int(ends[2]) <= MAX_SAMPLES:
        raise MechanismError(f"{name}={text} is not a range; write {RANGE_EXAMPLE} with at most {MAX_SAMPLES:,} values")
    return np.linspace(low, high, int(ends[2]))


def _parse_number(name: str, value: object, one: Input) -> float:
    if isinstance(value, Real) and not isinstance(value, bool):
        number = float(value)
        if np.isfinite(number):
            return number
    elif isinstance(value, str):
        return parse_quantity(value, kind_of_unit(one.unit), name)
    raise MechanismError(f"values of {name!r} must be a list of finite numbers in SI; got {format_value(value)}")


def grid_groups(scene: Scene, inputs: Mapping[str, FloatArray], varied: Sequence[VariedKey]) -> Iterator[SampleGroup]:
    """Yield a group for each combination of changed values, with all combinations of inputs."""
    n_samples = int(np.prod([len(values) for values in inputs.values()], dtype=float) * np.prod([len(one.values) for one in varied]))
    if n_samples > MAX_SAMPLES:
        raise MechanismError(f"{n_samples:,} comparisons are too many (at most {MAX_SAMPLES:,}); take fewer values")
    tables = np.meshgrid(*inputs.values(), indexing="ij") if inputs else []
    columns = {name: table.ravel() for name, table in zip(inputs, tables, strict=True)}
    for numbers in product(*(one.values for one in varied)):
        yield _make_group(scene, varied, numbers, columns)


def random_groups(
    scene: Scene, inputs: Mapping[str, FloatArray], varied: Sequence[VariedKey], count: int, seed: int
) -> Iterator[SampleGroup]:
    """Yield random samples, uniform between the smallest and the largest given value of each input and key.

    Each sample has its own scene if keys vary; else all inputs are in one group, in ascending order of the first.
    """
    if not isinstance(count, Integral) or isinstance(count, bool) or not 1 <= count <= MAX_SAMPLES:
        raise MechanismError(f"random must be a number of samples from 1 to {MAX_SAMPLES:,}; got {format_value(count)}")
    if not isinstance(seed, Integral) or isinstance(seed, bool) or seed < 0:
        raise MechanismError(f"seed must be a whole number of at least 0; got {format_value(seed)}")
    generator = np.random.default_rng(int(seed))
    columns = {name: generator.uniform(values.min(), values.max(), int(count)) for name, values in inputs.items()}
    if not varied:
        order = np.argsort(next(iter(columns.values()))) if columns else np.zeros(1, dtype=int)
        yield _make_group(scene, (), (), {name: column[order] for name, column in columns.items()})
        return
    numbers = np.column_stack([generator.uniform(min(one.values), max(one.values), int(count)) for one in varied])
    for index, row in enumerate(numbers.tolist()):
        yield _make_group(scene, varied, row, {name: column[index : index + 1] for name, column in columns.items()})


def _make_group(scene: Scene, varied: Sequence[VariedKey], numbers: Sequence[float], inputs: Mapping[str, FloatArray]) -> SampleGroup:
    changes = {one.key: Column(np.array([number]), one.unit) for one, number in zip(varied, numbers, strict=True)}
    changed = scene
    if varied:
        values = [(one.key, f"{number!r} {one.unit}" if one.unit else number) for one, number in zip(varied, numbers, strict=True)]
        changed = parse_scene_with(scene.document, values)
    return SampleGroup(scene=changed, changes=changes, inputs=inputs)

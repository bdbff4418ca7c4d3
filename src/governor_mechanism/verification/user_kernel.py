"""Calls of a user's kernel: arguments by name, arrays or single numbers, and what a kernel must not do."""

import importlib
import importlib.util
import inspect
import math
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from numbers import Integral, Real
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value, number_or_text, parse_quantity
from governor_mechanism.verification.user_kernel_simulation import Input, Quantity, Series, kind_of_unit, unit_factor

EXAMPLE = "mine.py:speed, or package.module:speed"


def load_kernel(name: str) -> Callable[..., Any]:
    """Return "FILE.py:FUNCTION" or "MODULE:FUNCTION"; MechanismError if it does not exist or cannot be executed."""
    # The file is executed. It may import what lies beside it.
    place, separator, function = name.rpartition(":")
    if not separator or not place.strip() or not function.strip():
        raise MechanismError(f"--kernel {name!r} is not understood; write {EXAMPLE}")
    module = _execute_file(Path(place)) if place.endswith(".py") else _import_module(place)
    found = getattr(module, function, None)
    functions = [key for key, value in vars(module).items() if callable(value) and not key.startswith("_")]
    if found is None:
        listed = ", ".join(functions) or "none"
        raise MechanismError(f"{place} has no function {function!r}; it has {listed}.{did_you_mean(function, functions)}")
    if not callable(found):
        raise MechanismError(f"{function!r} in {place} is no function; it is of type {type(found).__name__}")
    kernel: Callable[..., Any] = found
    return kernel


def _execute_file(path: Path) -> ModuleType:
    if not path.is_file():
        raise MechanismError(f"--kernel: there is no file {path}; write {EXAMPLE}")
    folder, module_name = str(path.resolve().parent), f"_kernel_{path.stem}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    if spec is None or spec.loader is None:
        raise MechanismError(f"--kernel: {path} is no Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module  # as dataclasses in it need
    sys.path.insert(0, folder)
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        raise MechanismError(f"--kernel: {path} cannot be executed: {_describe_failure(error)}") from error
    finally:
        sys.path.remove(folder)
    return module


def _import_module(name: str) -> ModuleType:
    sys.path.insert(0, "")
    try:
        return importlib.import_module(name)
    except (Exception, SystemExit) as error:
        raise MechanismError(
            f"--kernel: module {name!r} cannot be imported: {_describe_failure(error)}; for a file write {EXAMPLE}"
        ) from error
    finally:
        sys.path.remove("")


def _describe_failure(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


AGREEMENT = 1e-9
"""Relative difference of a result in an array and the same result alone below which it is rounding."""

Kernel = Callable[..., Any]


@dataclass(frozen=True, kw_only=True)
class KernelResults:
    """What a kernel returned at n points."""

    values: FloatArray  # results; NaN where there is none; shape (n,)
    problems: Mapping[int, str]  # sentences by the index of the point at which the kernel gave no real, finite number
    defects: tuple[str, ...]  # sentences on what the kernel must not do at all
    is_vectorised: bool  # whether it was called with arrays


def name_of_kernel(kernel: Kernel) -> str:
    """Return the name of a function, also of one with some arguments fixed."""
    inner = getattr(kernel, "func", kernel)
    return str(getattr(inner, "__name__", "kernel"))


def match_arguments(
    kernel: Kernel,
    available: Mapping[str, Series],  # what it may take, by our names, SI
    # our name by its name, with a unit if it is not SI, as {"alpha": "arm_angle in deg"}
    names: Mapping[str, str],
) -> dict[str, Series]:
    """Return the arguments of a kernel by its own names, in the units that it wants."""
    parameters = _parameters_of(kernel)
    for theirs in names:
        if theirs not in parameters:
            known = ", ".join(parameters) or "none"
            raise MechanismError(
                f"names gives {theirs!r}, which is no parameter of the kernel; it has {known}.{did_you_mean(theirs, parameters)}"
            )
    selected, problems = dict[str, Series](), list[str]()
    for name, parameter in parameters.items():
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD, parameter.POSITIONAL_ONLY):
            problems.append(f"the kernel's parameter {name!r} cannot be matched by name; use plain named parameters")
            continue
        ours, _, unit = (part.strip() for part in str(names.get(name, name)).partition(" in "))
        if ours in available:
            column = available[ours]
            factor = unit_factor(unit, column.unit, f"argument {name!r}") if unit else 1.0
            selected[name] = Series(column.values / factor, unit or column.unit)
        elif name in names or parameter.default is parameter.empty:
            known = ", ".join(sorted(available))
            remedy = "" if name in names else f'; another name is given by names={{"{name}": "..."}} or --map {name}=...'
            problems.append(f"the kernel has an unknown parameter {ours!r}; available: {known}{remedy}.{did_you_mean(ours, available)}")
    if problems:
        raise MechanismError(*problems)
    return selected


def _parameters_of(kernel: Kernel) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(kernel).parameters
    except (TypeError, ValueError):
        raise MechanismError(
            f"the parameters of {name_of_kernel(kernel)!r} cannot be read; wrap it in a function with named parameters"
        ) from None


def call_kernel(
    kernel: Kernel,
    arguments: Mapping[str, Series],
    count: int,
    *,
    # whether the points are times, so that a result may depend on those before; otherwise a result in an
    # array must be that of its point alone
    is_history: bool = False,
) -> KernelResults:
    """Call a kernel at all points, with arrays if it takes them, and return results and problems."""
    defects: list[str] = []
    values = _call_with_arrays(kernel, arguments, count, defects) if count > 1 else None
    if values is not None and not is_history:
        values = _confirm(kernel, arguments, values, defects)
    if values is None:
        outcomes = [_call_at(kernel, arguments, index) for index in range(count)]
        problems = {index: outcome for index, outcome in enumerate(outcomes) if isinstance(outcome, str)}
        numbers = np.array([math.nan if isinstance(outcome, str) else outcome for outcome in outcomes])
        return KernelResults(values=numbers, problems=problems, defects=tuple(defects), is_vectorised=False)
    wrong = np.flatnonzero(~np.isfinite(values)).tolist()
    problems = {index: _not_finite(float(values[index]), arguments, index) for index in wrong}
    return KernelResults(
        values=np.where(np.isfinite(values), values, math.nan), problems=problems, defects=tuple(defects), is_vectorised=True
    )


def _call_with_arrays(kernel: Kernel, arguments: Mapping[str, Series], count: int, defects: list[str]) -> FloatArray | None:
    """Return the results (n,) of one call; None if the kernel does not take arrays or does not return one number for each point."""
    given: dict[str, Any] = {
        name: column.values.copy()
        if np.any(column.values != column.values[0]) or name == next(iter(arguments))
        else float(column.values[0])
        for name, column in arguments.items()
    }
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            result = np.asarray(kernel(**given))
    except Exception:  # a kernel for single numbers raises anything; the calls with numbers tell what is really wrong
        result = np.empty(0)
    for name, value in given.items():
        if isinstance(value, np.ndarray) and not np.array_equal(value, arguments[name].values):
            first = int(np.argmax(value != arguments[name].values)) if value.shape == arguments[name].values.shape else 0
            defects.append(f"the kernel changes its argument {name!r} in place, called with {_format_call(arguments, first)} and others")
    if result.shape != (count,) or result.dtype.kind not in "iuf":
        return None
    return np.array(result, dtype=np.float64)


def _confirm(kernel: Kernel, arguments: Mapping[str, Series], values: FloatArray, defects: list[str]) -> FloatArray | None:
    """Return results (n,) of a call with arrays if the first and the last are those of a call with numbers; else None and a defect."""
    for index in (0, len(values) - 1):
        alone = _call_at(kernel, arguments, index)
        if isinstance(alone, str):
            continue  # it takes arrays only
        if not abs(alone - values[index]) <= AGREEMENT * max(abs(alone), abs(float(values[index]))):
            defects.append(
                f"the kernel returns {values[index]:.12g} in an array and {alone:.12g} alone for {_format_call(arguments, index)}; "
                "its results must not depend on one another"
            )
            return None
    return values


def _call_at(kernel: Kernel, arguments: Mapping[str, Series], index: int) -> float | str:
    """Return the kernel's number at a point, or a sentence on what it gave instead."""
    given = {name: float(column.values[index]) for name, column in arguments.items()}
    try:
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            returned = kernel(**given)
    except Exception as error:
        return f"the kernel raised {_describe(error)}, called with {_format_call(arguments, index)}"
    try:
        result = np.asarray(returned)
    except Exception:
        result = np.empty(0, dtype=object)
    if result.size != 1 or result.dtype.kind not in "iuf":
        shape = f", an array of shape {result.shape}" if result.ndim and result.dtype.kind in "iufc" else ""
        what = f"the complex number {result.item()}" if result.size == 1 and result.dtype.kind == "c" else format_value(returned)
        return f"the kernel must return one real number; it returned {what}{shape}, called with {_format_call(arguments, index)}"
    number = float(result.ravel()[0])
    return number if math.isfinite(number) else _not_finite(number, arguments, index)


def _not_finite(number: float, arguments: Mapping[str, Series], index: int) -> str:
    what = "NaN" if math.isnan(number) else f"{number}"
    return f"the kernel must return a finite number; it returned {what}, called with {_format_call(arguments, index)}"


def _describe(error: Exception) -> str:
    """Return an exception with the line of the kernel that raised it."""
    text = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if frame.filename != __file__]
    own = [frame for frame in frames if frame.filename == frames[0].filename]  # not in a library that it calls
    return f"{text} (line {own[-1].lineno} of {Path(own[-1].filename).name})" if own else text


def _format_call(arguments: Mapping[str, Series], index: int) -> str:
    """Return the arguments of a call in a phrase."""
    return ", ".join(f"{name} = {format_number(column.values[index], column.unit)}" for name, column in arguments.items()) or "no argument"


def format_number(value: float, unit: str) -> str:
    """Return a number with its unit; "1" is the unit of a bare number."""
    return f"{value:.12g}" if unit in ("", "1") else f"{value:.12g} {unit}"


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
    changes: Mapping[str, Series]
    inputs: Mapping[str, FloatArray]


def parse_inputs(quantity: Quantity, over: Mapping[str, Any]) -> dict[str, FloatArray]:
    """Return the values (n,) of each input in SI, as they are given; optional inputs that are not given are left out."""
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
        cure = f"crosscheck needs over={{{missing[0]!r}: [...]}} or --over {missing[0]}=first:last:count"
        return f"{sentence}; {' and '.join(map(repr, missing))} is missing: {cure}"
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
    """Yield random samples, uniform between the smallest and the largest given value of each input and key."""
    # Each sample has its own scene if keys vary; else all inputs are in one group, in ascending order
    # of the first.
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
    changes = {one.key: Series(np.array([number]), one.unit) for one, number in zip(varied, numbers, strict=True)}
    changed = scene
    if varied:
        values = [(one.key, f"{number!r} {one.unit}" if one.unit else number) for one, number in zip(varied, numbers, strict=True)]
        changed = parse_scene_with(scene.document, values)
    return SampleGroup(scene=changed, changes=changes, inputs=inputs)

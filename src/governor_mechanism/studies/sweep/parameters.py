"""Axes of a sweep: keys of a scene document with ranges or lists of values, and the scenes that have them.

Axes are requested as "key=first:last:count", "key=value,value,...", or a mapping of keys to values. Which kind of value a key takes is read
from the error of the parser of scene files for a sentinel value: its message names the kind, or the nearest right key.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.result import Recorded
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.changed_document import parse_scene_with, replace_document_value
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.scenes.quantities import UNITLESS_LIMITS, parse_si
from governor_mechanism.studies.sweep.quantities import find_display_unit
from governor_mechanism.units.expressions import read_any_quantity
from governor_mechanism.units.problems import ProblemCode, ProblemCollector
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value, number_or_text


def find_scene_value(
    document: Mapping[str, Any],
    key: str,  # dotted key; an item of a list is meant by its name or its number, counted from 1
    kind: str | None,  # kind of quantity; None if only words are allowed
) -> float | str | bool | None:
    """Return the value at a dotted key of a document."""
    value: Any = document
    for name in key.split("."):
        value = _find_item(value, name)
    if not isinstance(value, str | bool | int | float):
        return None
    if kind is None or isinstance(value, bool):
        return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
    try:
        return parse_si(value, kind, key)
    except MechanismError:  # a word that stands for a value, as "equilibrium"
        return value if isinstance(value, str) else None


def _find_item(table: Any, name: str) -> Any:
    """Return the value of a name in a table, or the item of a name or number in a list; None if there is none."""
    if isinstance(table, Mapping):
        return table.get(name)
    if not isinstance(table, list | tuple):
        return None
    if name.isdecimal() and 1 <= int(name) <= len(table):
        return table[int(name) - 1]
    return next((item for item in table if isinstance(item, Mapping) and item.get("name") == name), None)


MAX_SWEEP_ROWS = 10_000_000
"""Maximum number of rows of a sweep; a larger number suggests a slip."""

AXIS_EXAMPLE = "dimensions.arm=200mm:400mm:50, or dimensions.arm=200mm,300mm"
"""Example of two axes in messages."""

MAX_REPORTED_VALUES = 3
"""Maximum number of wrong values reported per key."""

MAX_COMPARED_VALUES = 20
"""Maximum number of values of a key that are compared to decide that the key has no effect."""

SENTINEL_VALUE = "?"
"""Value that no kind of quantity accepts."""

ANY_QUANTITY = " is no quantity; "
"""What the parser says of the sentinel value at a key that takes any kind of quantity, as a dimension of a mechanism of the user's own."""

ProblemFinder = Callable[[Any], list[str]]
"""Function that returns the parser's messages for a value at a key."""


@dataclass(frozen=True, kw_only=True)
class AxisRequest:
    """Requested values of one key; for a range `values` holds both ends and `range_count` the number of values."""

    key: str
    values: tuple[Any, ...]
    range_count: int | None = None


@dataclass(frozen=True, kw_only=True)
class SweepAxis(Recorded):
    """One key of a scene and its values."""

    key: str  # dotted key of the scene document
    kind: str  # kind of quantity (key of QUANTITY_KINDS); empty if only words are allowed
    values: tuple[float | str | bool, ...]  # numbers in SI, or words
    document_values: tuple[Any, ...]  # the same values as they are written into the document
    # value that the scene itself has, SI or a word; None if its document leaves the key out
    scene_value: float | str | bool | None = None

    record = ("key", "unit", "values")

    @property
    def unit(self) -> str:
        """SI unit; empty if there is none."""
        return QUANTITY_KINDS[self.kind].si_unit if self.kind else ""

    @property
    def display_unit(self) -> tuple[float, str]:
        """Factor from SI to the unit shown to users, and that unit."""
        return find_display_unit(self.unit, is_rate=self.kind in ("angular_rate", "speed"))

    @property
    def is_numeric(self) -> bool:
        """Whether all values are numbers."""
        return all(isinstance(value, float) for value in self.values)


@dataclass(frozen=True, kw_only=True)
class AxisGrid:
    """All combinations of the values of axes."""

    axes: tuple[SweepAxis, ...]  # keys and their values; the last axis varies fastest

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each axis."""
        return tuple(len(axis.values) for axis in self.axes)

    def places(self, index: int) -> list[tuple[SweepAxis, int]]:
        """Return the axes and the places of their values in a row."""
        places = []
        for axis in reversed(self.axes):
            index, place = divmod(index, len(axis.values))
            places.append((axis, place))
        return places[::-1]


def parse_axes(document: Mapping[str, Any], vary: Mapping[str, Any] | Sequence[str]) -> tuple[SweepAxis, ...]:
    """Return the axes of "key=first:last:count", "key=value,value", or a mapping of keys to lists of values."""
    collector, axes = ProblemCollector(), []
    requests = _parse_axis_requests(vary, collector)
    for request in requests:
        with collector.at("vary:"):
            axes.append(_parse_axis(document, request, [other for other in requests if other.key != request.key]))
    if collector.has_failed:
        raise MechanismError(*dict.fromkeys(collector.problems))
    return tuple(axes)


def _parse_axis_requests(vary: Mapping[str, Any] | Sequence[str], collector: ProblemCollector) -> list[AxisRequest]:
    """Return the requested axes, without those given twice; requests that are not understood are collected."""
    if isinstance(vary, str):
        vary = [vary]
    if not isinstance(vary, Mapping | Sequence) or not vary:
        raise MechanismError(f"vary: nothing to vary; name a key and its values, as in {AXIS_EXAMPLE}; found {format_value(vary)}")
    requests: list[AxisRequest] = []
    for request in vary.items() if isinstance(vary, Mapping) else vary:
        with collector.at("vary:"):
            requests.append(_parse_request(*request) if isinstance(vary, Mapping) else _parse_request_text(request))
    counts = Counter(one.key for one in requests)
    repeated = (f"vary: {key} is given {count} times; give all its values at once" for key, count in counts.items() if count > 1)
    collector.add(ProblemCode.DUPLICATE, *repeated)
    n_rows = math.prod(len(one.values) if one.range_count is None else one.range_count for one in requests)
    if n_rows > MAX_SWEEP_ROWS:
        text = f"vary: {n_rows:,} rows are too many (at most {MAX_SWEEP_ROWS:,}); take fewer values of a key"
        collector.add(ProblemCode.OUT_OF_RANGE, text)
    return [one for one in requests if counts[one.key] == 1]


def _parse_request_text(text: object) -> AxisRequest:
    key, separator, values = text.partition("=") if isinstance(text, str) else ("", "", "")
    if not separator or not values.strip():
        raise MechanismError(f"{format_value(text)} has no values; write {AXIS_EXAMPLE}")
    return _parse_request(key.strip(), values)


def _parse_request(key: Any, values: Any) -> AxisRequest:
    if not isinstance(key, str) or not all(part.strip() for part in key.split(".")):
        raise MechanismError(f"{format_value(key)} is not a key of a scene; a key is a table and a name, as in dimensions.arm")
    if isinstance(values, np.ndarray):
        values = values.tolist()
    if isinstance(values, str):
        if ":" in values or (".." in values and "/" not in values):  # 200mm..300mm is meant as a range, too
            return _parse_range(key, values)
        values = [_parse_plain_value(item.strip()) for item in values.split(",")]
    if not isinstance(values, list | tuple | range) or not len(values):
        raise MechanismError(f"{key} needs a list of values; found {format_value(values)}; write {AXIS_EXAMPLE}")
    plain_values = [value.item() if isinstance(value, np.generic) else value for value in values]
    invalid_values = [value for value in plain_values if not isinstance(value, str | int | float) or value == ""]
    if invalid_values:
        raise MechanismError(f"{key} takes a list of numbers and texts; found {format_value(invalid_values[0])}")
    return AxisRequest(key=key, values=tuple(plain_values))


def _parse_range(key: str, text: str) -> AxisRequest:
    parts = [part.strip() for part in text.split(":")]
    if len(parts) != 3 or not all(parts):
        raise MechanismError(f"{key}={text} is not a range; write first:last:count, as in {AXIS_EXAMPLE.partition(',')[0]}")
    if not parts[2].isdecimal() or int(parts[2]) < 1:
        raise MechanismError(f"{key}={text}: the count must be a whole number of at least 1; found {format_value(parts[2])}")
    count = int(parts[2])
    if count > MAX_SWEEP_ROWS:
        raise MechanismError(f"{key}={text}: {count:,} values are too many (at most {MAX_SWEEP_ROWS:,} rows)")
    if count == 1 and parts[0] != parts[1]:
        raise MechanismError(f"{key}={text}: one value cannot be both ends of a range; write {key}={parts[0]}")
    return AxisRequest(key=key, values=(_parse_plain_value(parts[0]), _parse_plain_value(parts[1])), range_count=count)


def _parse_plain_value(text: str) -> Any:
    """Return a number, true or false as such, and any other text unchanged."""
    if text in ("true", "false"):
        return text == "true"
    number = number_or_text(text)
    return number if isinstance(number, float) and math.isfinite(number) else text


def _parse_axis(document: Mapping[str, Any], request: AxisRequest, other_requests: Sequence[AxisRequest]) -> SweepAxis:
    """Return one axis; for its check all other axes have their first values, if these are valid."""
    for other in other_requests:
        with suppress(MechanismError):  # reported when that axis is checked
            document = replace_document_value(document, other.key, other.values[0])
    find_problems = _problem_finder(document, request.key)
    problems = find_problems(SENTINEL_VALUE)
    takes_any = any(ANY_QUANTITY in problem for problem in problems)
    kind = read_any_quantity(request.values[0], request.key)[1] if takes_any else _kind_named_in(problems)
    axis = _make_axis(request, kind, find_problems, writes_unit=takes_any)
    _refuse_repeated_values(axis, request)
    _refuse_ineffective_axis(document, axis, is_only_axis=not other_requests)
    return replace(axis, scene_value=find_scene_value(document, axis.key, kind))


def _problem_finder(document: Mapping[str, Any], key: str) -> ProblemFinder:
    """Return a function of a value that returns what the parser says of it at a key, and of nothing else."""
    existing_problems = set(_find_document_problems(document))

    def find_problems(value: Any) -> list[str]:
        problems = _find_document_problems(replace_document_value(document, key, value))
        return [problem for problem in problems if problem not in existing_problems]

    return find_problems


def _kind_named_in(problems: Sequence[str]) -> str | None:
    """Return the kind of quantity that messages of the parser ask for; None if they ask for words."""
    return next((name for name, kind in QUANTITY_KINDS.items() if any(f" is {kind.name}; " in line for line in problems)), None)


def find_kind(document: Mapping[str, Any], key: str) -> str:
    """Return the kind of quantity that a key takes; raise MechanismError, with what the parser says, if it takes none."""
    problems = _problem_finder(document, key)(SENTINEL_VALUE)
    if any(ANY_QUANTITY in problem for problem in problems):
        return read_any_quantity(find_scene_value(document, key, None), key)[1]
    kind = _kind_named_in(problems)
    if kind is None:
        raise MechanismError(*(problems or [f"{key} takes no quantity"]))
    return kind


def _make_axis(request: AxisRequest, kind: str | None, find_problems: ProblemFinder, *, writes_unit: bool) -> SweepAxis:
    """Return the axis of a key that takes quantities of a kind; `kind` is None if only words are allowed."""
    # A key that takes any kind of quantity needs a unit, without which a number is a plain one.
    if request.range_count is not None and kind is None:
        no_range_message = f"{request.key} takes no range; list its values, as in {request.key}=a,b"
        raise MechanismError(*(find_problems(request.values[0]) or [no_range_message]))
    values = _parse_values(request, kind, find_problems)
    if request.range_count is not None:
        (low, high), count = values, request.range_count
        values = [high if 0 < k == count - 1 else _round_grid_value(low + (high - low) * k / max(count - 1, 1)) for k in range(count)]
    suspicious_limit = -1.0 if writes_unit else UNITLESS_LIMITS.get(kind or "", math.inf)

    def to_document_value(value: Any) -> Any:
        """Return the value to write: a number above the limit for bare numbers gets its unit."""
        unit = QUANTITY_KINDS[kind].si_unit if kind and isinstance(value, float) and abs(value) > suspicious_limit else ""
        return f"{value!r} {unit}" if unit else value

    return SweepAxis(key=request.key, kind=kind or "", values=tuple(values), document_values=tuple(map(to_document_value, values)))


def _round_grid_value(value: float) -> float:
    """Return a value of a grid as a person would write it, 0.3 and not 0.30000000000000004, so that tables can be joined on it."""
    return float(f"{value:.15g}")


def _parse_values(request: AxisRequest, kind: str | None, find_problems: ProblemFinder) -> list[Any]:
    """Return the values in SI; a word that the key accepts ("equilibrium", false) stays a word."""
    values: list[Any] = []
    problems: list[str] = []
    for number, value in enumerate(request.values, start=1):
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        try:
            values.append(parse_si(value, kind, request.key) if kind else float(value) if is_number else value)
            problems += [] if kind else find_problems(value)
        except MechanismError as error:
            values.append(value)
            problems += error.problems if request.range_count is not None or find_problems(value) else ()
        if len(problems) >= MAX_REPORTED_VALUES and number < len(request.values):
            problems.append(f"{request.key} has more values; they are not checked")
            break
    if problems:
        raise MechanismError(*problems)
    return values


def _refuse_repeated_values(axis: SweepAxis, request: AxisRequest) -> None:
    if request.range_count is not None and len(axis.values) > 1 and axis.values[0] == axis.values[-1]:
        raise MechanismError(f"{axis.key} goes from {request.values[0]} to the same value; write {axis.key}={request.values[0]}")
    seen: set[Any] = set()
    for value, given in zip(axis.values, request.values, strict=False):
        if (type(value), value) in seen:
            raise MechanismError(f"{axis.key} takes the value {format_value(given)} twice; list it once")
        seen.add((type(value), value))


def _refuse_ineffective_axis(document: Mapping[str, Any], axis: SweepAxis, *, is_only_axis: bool) -> None:
    """Refuse a key whose values, at most MAX_COMPARED_VALUES, all give the same scene or, as the only axis, no valid one."""
    n_values = len(axis.document_values)
    indices = {round(k) for k in np.linspace(0, n_values - 1, min(n_values, MAX_COMPARED_VALUES))}
    compared_indices = sorted(indices, key=lambda k: (k != n_values - 1, k))
    scenes: list[Scene] = []
    refusal: MechanismError | None = None
    for k in compared_indices:
        try:
            scene = parse_scene_with(document, [(axis.key, axis.document_values[k])])
        except MechanismError as error:  # reported in its row, if there are others
            refusal = refusal or error
            continue
        scenes.append(replace(scene, title="", source="", document={}))
        if scenes[-1] != scenes[0]:
            return
    if not scenes and refusal is not None and is_only_axis and len(compared_indices) == n_values:
        raise MechanismError(*refusal.problems)
    if len(scenes) > 1:
        raise MechanismError(f"{axis.key} has no effect in this scene: all values give the same scene; leave it out")


def _find_document_problems(document: Mapping[str, Any]) -> Sequence[str]:
    collector = ProblemCollector()
    collector.attempt("", parse_scene_document, document)
    return collector.problems

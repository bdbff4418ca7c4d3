"""What a sweep varies: values of keys of a scene's document, as ranges or lists, and the scene that has them.

What may stand at a key the reader of scene files alone knows. So it is asked: by a value that no quantity is, to
which it answers with a sentence that names the kind, or the nearest right key.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import scene_from_document
from governor_mechanism.studies.sweep.grid_spec import Asked, asked_of
from governor_mechanism.studies.sweep.quantities import everyday
from governor_mechanism.units.quantities import KINDS, shown

TOLD = 3
"""So many wrong values of one key are told."""

COMPARED = 20
"""So many values of a key must all make the same scene for it to be taken to change nothing."""

NO_QUANTITY = "?"
"""What the reader takes for no quantity of any kind."""


Mistakes = Callable[[Any], list[str]]
"""What the reader says against a value at a key."""


@dataclass(frozen=True, kw_only=True)
class Axis:
    """One key and its values, numbers in SI or words; `written` is what stands for them in the document.

    kind is one of units.KINDS, empty where only words stand at the key.
    """

    key: str
    kind: str
    values: tuple[float | str | bool, ...]
    written: tuple[Any, ...]

    @property
    def unit(self) -> str:
        """SI, empty where there is none."""
        return KINDS[self.kind].si if self.kind else ""

    @property
    def everyday(self) -> tuple[float, str]:
        """How many of which unit make the SI unit, for people."""
        return everyday(self.unit, rate=self.kind in ("angular_rate", "speed"))

    @property
    def numeric(self) -> bool:
        """Whether all the values are numbers."""
        return all(isinstance(value, float) for value in self.values)


def with_value(document: Mapping[str, Any], key: str, value: Any) -> dict[str, Any]:
    """A copy of the document with a value at a dotted key; what does not change is shared with the original.

    An item of a list is meant by its name, or by its number from 1. Raises MechanismError for a key that leads through
    what is no table.
    """
    changed: dict[str, Any] = _with(document, key.split("."), value, "")
    return changed


def scene_with(document: Mapping[str, Any], values: Iterable[tuple[str, Any]]) -> Scene:
    """The scene of a document that has these values at these keys. Raises MechanismError as the reader does."""
    for key, value in values:
        document = with_value(document, key, value)
    return scene_from_document(document)


def axes_of(document: Mapping[str, Any], vary: Mapping[str, Any] | Sequence[str]) -> tuple[Axis, ...]:
    """The axes asked for: "key=first:last:count", "key=value,value", or a mapping of keys to lists of values.

    Raises MechanismError with a sentence for each key that does not exist or changes nothing, each range or list that
    is malformed, and each value of a wrong unit.
    """
    asked, problems = asked_of(vary)
    axes = []
    for one in asked:
        others = [(other.key, other.first) for other in asked if other.key != one.key]
        try:
            axes.append(_axis(_surroundings(document, others), one, alone=not others))
        except MechanismError as error:
            problems += [f"vary: {problem}" for problem in error.problems]
    if problems:
        raise MechanismError(*dict.fromkeys(problems))
    return tuple(axes)


def _with(table: Any, path: Sequence[str], value: Any, place: str) -> Any:
    if not path:
        return value
    name, *rest = path
    here = f"{place}.{name}" if place else name
    if isinstance(table, list | tuple):
        at = _item(table, name, place)
        return [_with(item, rest, value, here) if index == at else item for index, item in enumerate(table)]
    if isinstance(table, Mapping):
        # What is switched off is as good as not there, so a table may take its place.
        below = table.get(name, False)
        return {**table, name: _with({} if below is False and rest else below, rest, value, here)}
    raise MechanismError(
        f"{here} cannot be varied: {place} is {shown(table)} in this scene, and no table; vary {place}"
    )


def _item(items: Sequence[Any], name: str, place: str) -> int:
    if name.isdecimal() and 1 <= int(name) <= len(items):
        return int(name) - 1
    names = [str(item["name"]) for item in items if isinstance(item, Mapping) and "name" in item]
    if names.count(name) == 1:
        return next(k for k, item in enumerate(items) if isinstance(item, Mapping) and item.get("name") == name)
    known = f"named {', '.join(names)}, or " if names else ""
    raise MechanismError(
        f"{place} has no {shown(name)}; its items are {known}1 to {len(items)}{did_you_mean(name, names)}"
    )


def _surroundings(document: Mapping[str, Any], others: Iterable[tuple[str, Any]]) -> Mapping[str, Any]:
    """The document as it is where one axis is looked at: the others at their first values, if they can be."""
    for key, value in others:
        try:
            document = with_value(document, key, value)
        except MechanismError:  # told where that axis is looked at
            continue
    return document


def _axis(document: Mapping[str, Any], asked: Asked, *, alone: bool) -> Axis:
    told = set(_mistakes(document))

    def mistakes(value: Any) -> list[str]:
        return [problem for problem in _mistakes(with_value(document, asked.key, value)) if problem not in told]

    answer = mistakes(NO_QUANTITY)
    kind = next((name for name, kind in KINDS.items() if any(f" is {kind.name}; " in line for line in answer)), None)
    axis = _axis_of_kind(asked, kind, mistakes)
    _refuse_repeated(axis, asked)
    _refuse_idle(document, axis, alone=alone)
    return axis


def _axis_of_kind(asked: Asked, kind: str | None, mistakes: Mistakes) -> Axis:
    """The axis of a key whose values are of that kind; None where only words may stand there."""
    from governor_mechanism.scenes.quantities import BARE_LIMITS  # brings pydantic, which takes long to import

    if asked.ends is not None and kind is None:
        no_range = f"{asked.key} takes no range; list its values, as in {asked.key}=a,b"
        raise MechanismError(*(mistakes(asked.first) or [no_range]))
    values = _values(asked, kind, mistakes)
    if asked.ends is not None:
        low, high = (float(value) for value in values)
        values = list(_between(low, high, asked.ends))
    slip, _ = BARE_LIMITS.get(kind or "", (math.inf, math.inf))

    def written(value: Any) -> Any:
        """Beyond what a bare number is believed, a number with its unit."""
        return f"{value!r} {KINDS[kind].si}" if kind and isinstance(value, float) and abs(value) > slip else value

    return Axis(key=asked.key, kind=kind or "", values=tuple(values), written=tuple(map(written, values)))


def _values(asked: Asked, kind: str | None, mistakes: Mistakes) -> list[Any]:
    """The values given, in SI; a word stays as it is where the key takes it, as "equilibrium" or false."""
    from governor_mechanism.scenes.quantities import si

    values: list[Any] = []
    problems: list[str] = []
    for number, value in enumerate(asked.given, start=1):
        plain = isinstance(value, int | float) and not isinstance(value, bool)
        try:
            values.append(si(value, kind, asked.key) if kind else float(value) if plain else value)
            problems += [] if kind else mistakes(value)
        except MechanismError as error:
            values.append(value)
            problems += error.problems if asked.ends is not None or mistakes(value) else ()
        if len(problems) >= TOLD and number < len(asked.given):
            problems.append(f"{asked.key} has more values, which were not looked at after these")
            break
    if problems:
        raise MechanismError(*problems)
    return values


def _between(low: float, high: float, count: int) -> Iterable[float]:
    for k in range(count):
        yield high if k and k == count - 1 else low + (high - low) * k / max(count - 1, 1)


def _refuse_repeated(axis: Axis, asked: Asked) -> None:
    if asked.ends is not None and len(axis.values) > 1 and axis.values[0] == axis.values[-1]:
        raise MechanismError(
            f"{axis.key} goes from {asked.given[0]} to the same value; write {axis.key}={asked.given[0]}"
        )
    seen: set[Any] = set()
    for value, given in zip(axis.values, asked.given, strict=False):
        if (type(value), value) in seen:
            raise MechanismError(f"{axis.key} takes the value {shown(given)} twice; list it once")
        seen.add((type(value), value))


def _refuse_idle(document: Mapping[str, Any], axis: Axis, *, alone: bool) -> None:
    """Refuse a key whose values all make the same scene, or, where no other is varied, none at all.

    Of many values some are compared, the ends first.
    """
    count = len(axis.written)
    some = sorted(
        {round(k) for k in np.linspace(0, count - 1, min(count, COMPARED))}, key=lambda k: (k != count - 1, k)
    )
    found: list[Scene] = []
    refusal: MechanismError | None = None
    for k in some:
        try:
            made = scene_with(document, [(axis.key, axis.written[k])])
        except MechanismError as error:  # for its row to tell, if there are others
            refusal = refusal or error
            continue
        found.append(replace(made, title="", source="", document={}))
        if found[-1] != found[0]:
            return
    if not found and refusal is not None and alone and len(some) == count:
        raise MechanismError(*refusal.problems)
    if len(found) > 1:
        raise MechanismError(f"{axis.key} changes nothing in this scene: every value makes the same; leave it out")


def _mistakes(document: Mapping[str, Any]) -> tuple[str, ...]:
    try:
        scene_from_document(document)
    except MechanismError as error:
        return error.problems
    return ()

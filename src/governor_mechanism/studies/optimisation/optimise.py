"""Optimisation of a scene, and the trade-off of two objectives; values that were computed are kept on disk while it runs."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np

from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.studies.optimisation.question import Condition, Question, Values, evaluate_quantities
from governor_mechanism.studies.optimisation.results import OptimisedQuantity, OptimisedValue, Optimum, TradeOff, TradeOffPoint
from governor_mechanism.studies.optimisation.search import End, Journal, Search, search_globally, search_locally
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.rules import MissingNumberError
from governor_mechanism.studies.sweep.workers import RowComputer, find_versions
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_quantity

BOUND_MARGIN: Final = 1e-6
"""Distance from a bound, relative to the width of the bounds, within which a value lies at it."""

ACTIVE_MARGIN: Final = 1e-4
"""Margin of a condition, relative to its limit, within which the limit determines the optimum."""

LAST_SHARE: Final = 1e-4
"""How far the last limit of a trade-off is from the best of the second objective, relative to the range of the limits."""

INTERRUPTED: Final = "interrupted; these are the best values so far"
"""Outcome after Ctrl-C."""


class _FileJournal(dict[bytes, Values]):
    """Values by place, each also a line of a file; a search that was interrupted finds them there."""

    def __init__(self, path: Path, identity: str) -> None:
        heading = json.dumps({"optimisation": identity})
        super().__init__(_read_journal(path, heading))
        path.parent.mkdir(parents=True, exist_ok=True)
        self._stream: TextIO = path.open("w", encoding="utf-8", newline="\n")
        self._stream.write(f"{heading}\n")
        for values in self.values():
            self._write(values)

    def __setitem__(self, key: bytes, values: Values) -> None:
        if key not in self:
            self._write(values)
            super().__setitem__(key, values)

    def _write(self, values: Values) -> None:
        self._stream.write(json.dumps([values.place.tolist(), [one.tolist() for one in values.numbers], values.problem]) + "\n")
        self._stream.flush()

    def close(self) -> None:
        """Close the file."""
        self._stream.close()


def _read_journal(path: Path, heading: str) -> Iterator[tuple[bytes, Values]]:
    """Yield the whole lines of a journal of the same optimisation with their values; MechanismError for a file that is none."""
    if path.is_dir():
        raise MechanismError(f"out: {path} is a folder; give the name of a file")
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines() if path.exists() else []
    if lines and not lines[0].startswith('{"optimisation":'):
        raise MechanismError(f"out: {path} exists and is not the file of an optimisation; choose another name, or move the file")
    for line in lines[1:] if lines[:1] == [heading] else ():
        try:
            place, numbers, problem = json.loads(line)
        except ValueError:
            continue
        values = Values(np.array(place), tuple(np.array(one) for one in numbers), problem)
        yield values.place.tobytes(), values


@contextmanager
def open_journal(path: Path | None, question: Question) -> Iterator[Journal]:
    """Provide the journal of an optimisation: a file, if there is a path, which is deleted at the end unless Ctrl-C was pressed."""
    if path is None:
        yield {}
        return
    quantities = [one.identity for one in question.quantities]
    asked = (question.scene.document, question.unknowns, quantities, question.engine, question.accuracy, find_versions())
    journal = _FileJournal(path, hashlib.sha256(repr(asked).encode()).hexdigest())
    try:
        yield journal
    finally:
        journal.close()


def find_optimum(
    question: Question, method: str, n_starts: int, seed: int, compute: RowComputer[Any], journal_path: Path | None = None
) -> Optimum:
    """Return the best values; after Ctrl-C those so far."""
    with open_journal(journal_path, question) as journal:
        search = Search(question, journal)
        try:
            end = search_locally(search, n_starts, seed, compute) if method == "local" else search_globally(search, seed, compute)
        except KeyboardInterrupt:
            if search.best is None:
                raise
            end = End(search.best, converged=False, outcome=INTERRUPTED)
    if journal_path is not None and end.outcome != INTERRUPTED:
        journal_path.unlink()
    return _describe(search, end, method, n_starts, seed)


def _describe(search: Search, end: End, method: str, n_starts: int, seed: int) -> Optimum:
    """Return the result of a search."""
    question = search.question
    scene = question.scene_at(end.values.place)
    values = question.values_at(end.values.place)
    rows = [_make_value(question, k, value) for k, value in enumerate(values)]
    before = search.at(question.start)
    roles = ["minimised" if question.sign > 0 else "maximised", *map(_format_condition, question.conditions)]
    firsts: list[tuple[float, ...] | None] = [tuple(one.tolist()) for one in before.numbers] or [None] * len(roles)
    quantities = [
        OptimisedQuantity(name=one.name, role=role, before=first, after=tuple(last.tolist()), unit=one.unit)
        for one, role, first, last in zip(question.quantities, roles, firsts, end.values.numbers, strict=True)
    ]
    quantities[1:] = [
        _with_margin(row, one, last) for row, one, last in zip(quantities[1:], question.conditions, end.values.numbers[1:], strict=True)
    ]
    options: dict[str, Any] = {"n_evaluations": search.n_evaluations, "method": method, "n_starts": n_starts, "seed": seed}
    return Optimum(
        title=question.scene.title,
        rows=tuple(rows),
        quantities=(*quantities, *(_report(question, one, end) for one in question.reported)),
        before=question.scene,
        scene=scene,
        history=np.array(search.history).reshape(-1, 2),
        converged=end.converged,
        outcome=end.outcome,
        **options,
    )


def _make_value(question: Question, k: int, value: float) -> OptimisedValue:
    one = question.unknowns[k]
    at_bound = min(value - one.low, one.high - value) < BOUND_MARGIN * (one.high - one.low)
    return OptimisedValue(key=one.key, before=one.start, value=value, unit=one.unit, low=one.low, high=one.high, at_bound=at_bound)


def _format_condition(condition: Condition) -> str:
    return f"{condition.relation} {format_quantity(condition.limit, condition.quantity.unit)}"


def _with_margin(row: OptimisedQuantity, condition: Condition, values: FloatArray) -> OptimisedQuantity:
    """Return a row with the margin of its condition; an equality is always at its limit."""
    margins = condition.margins(values)
    worst = float(margins[np.argmax(np.abs(margins))] if condition.relation == "=" else margins.min())
    is_active = condition.relation == "=" or abs(worst) <= ACTIVE_MARGIN * (abs(condition.limit) or condition.quantity.scale or 1.0)
    return replace(row, margin=worst, active=is_active)


def _report(question: Question, quantity: RunQuantity, end: End) -> OptimisedQuantity:
    """Return a quantity that is only stated, before and after."""

    def take(place: FloatArray) -> tuple[float, ...] | None:
        try:
            return tuple(evaluate_quantities(question, question.scene_at(place), [quantity])[0].tolist())
        except (GovernorMechanismError, MissingNumberError):
            return None

    first, last = take(question.start), take(end.values.place)
    return OptimisedQuantity(name=quantity.name, role="reported", before=first, after=last or (), unit=quantity.unit)


def find_trade_off(question: Question, n_points: int, method: str, n_starts: int, seed: int, compute: RowComputer[Any]) -> TradeOff:
    """Return the best of the objective for limits of another one, from its value at the best of the first to its own best."""
    other, other_sign = question.others[0]

    def solve(asked: Question) -> Optimum:
        return find_optimum(asked, method, n_starts, seed, compute)

    first = solve(replace(question, reported=(other,)))
    last = solve(replace(question, objective=other, sign=other_sign, reported=(question.objective,)))
    if not first.quantities[-1].after:
        raise MechanismError(f"{other.name} has no value where {question.objective.name} is best; choose other bounds")
    worst = _worst(first.quantities[-1].after, other_sign)
    best = _worst(last.objective.after, other_sign)
    points = [(first, first.quantities[-1])]
    # At the best of an objective its own size may be nothing; what it loses up to the best of the other is a measure that holds throughout.
    range_of_first = abs(_worst(last.quantities[-1].after, question.sign) - _worst(first.objective.after, question.sign))
    scaled = replace(question, scale=range_of_first if np.isfinite(range_of_first) else 0.0)
    for limit in np.linspace(worst, best + LAST_SHARE * (worst - best), n_points)[1:].tolist():
        condition = Condition(quantity=other, relation="<=" if other_sign > 0 else ">=", limit=limit, scale=abs(worst - best))
        started = tuple(replace(one, start=row.value) for one, row in zip(question.unknowns, points[-1][0].rows, strict=True))
        found = solve(replace(scaled, unknowns=started, conditions=(condition, *question.conditions)))
        points.append((found, found.quantities[1]))
    before = _worst(first.objective.before, question.sign), _worst(first.quantities[-1].before, other_sign)
    return TradeOff(
        title=question.scene.title,
        names=(question.objective.name, other.name),
        units=(question.objective.unit, other.unit),
        keys={one.key: one.unit for one in question.unknowns},
        start=before,
        rows=tuple(_make_point(one, _worst(one.objective.after, question.sign), _worst(row.after, other_sign)) for one, row in points),
        scenes=tuple(one.scene for one, _ in points),
        seed=seed,
    )


def _worst(values: Sequence[float] | None, sign: float) -> float:
    """Return the worst of the values of an objective; NaN without any."""
    return sign * max((sign * one for one in values or ()), default=np.nan)


def _make_point(optimum: Optimum, first: float, second: float) -> TradeOffPoint:
    return TradeOffPoint(first=first, second=second, values=optimum.values, converged=optimum.converged, outcome=optimum.outcome)

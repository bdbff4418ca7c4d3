"""Proof of the law of a scene: its equations over the whole travel, and what a change of each dimension does to them."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, solve_kinematics
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.part import Law, LawEquation
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.hermite_curve import HermiteCurve
from governor_mechanism.scenes.changed_document import parse_scene_with
from governor_mechanism.types import FloatArray
from governor_mechanism.units.expressions import ARITHMETIC, PLAIN, Function, Measured, si_unit_of, unit_of_kind
from governor_mechanism.verification.report import CheckReport, ComparisonRow

CHANGE: Final = 0.01
"""Relative change of a dimension under which a law must hold or break."""

MIN_WAY_POSITIONS = 181
"""Least number of positions on a way as long as the travel, from the start to its first end."""

ROOT_TOLERANCE = 1e-12
"""Tolerance of the position of an extreme of a reading, relative to the interval between two positions."""


@dataclass(frozen=True)
class _ReadingValues(Measured):
    """A reading over the travel; functions of a reading need more than its values."""

    name: str = ""  # name of the reading


class _Travel:
    """Readings of a mechanism at the positions of its travel."""

    def __init__(self, scene: Scene, law: Law) -> None:
        self._law, self._positions = law, np.linspace(*law.between, law.positions)
        self._kinds = {reading.name: reading.quantity for reading in scene.part.mechanism.readings} | {TIME_VARIABLE: "time"}
        way = _way_from_start(scene, law)
        motion = solve_kinematics(scene, law.over, np.append(way, self._positions))
        columns = (motion.readings, motion.rates, motion.reading_accelerations)
        self._readings, self._rates, self._accelerations = ({name: one[len(way) :] for name, one in values.items()} for values in columns)

    def compare(self, equation: LawEquation) -> tuple[float, float]:
        """Return both sides of an equation where they differ most."""
        sides = [side.evaluate(self._look_up, self._functions) for side in (equation.value, equation.equals)]
        left, right = np.broadcast_arrays(*(np.asarray(side.value, dtype=np.float64) for side in sides))
        differences = np.abs(left - right)
        worst = int(np.argmax(np.where(np.isnan(differences), np.inf, differences)))
        return float(left.flat[worst]), float(right.flat[worst])

    def _look_up(self, name: str) -> Measured:
        if name in self._law.dimensions:
            return self._law.dimensions[name]
        if name == TIME_VARIABLE:
            return Measured(self._positions, unit_of_kind("time"))
        return _ReadingValues(self._readings[name], unit_of_kind(self._kinds[name]), name)

    @cached_property
    def _functions(self) -> Mapping[str, Function]:
        """The functions that an equation may have."""

        def over_travel(evaluate: str) -> Function:
            return Function(lambda reading: getattr(self, evaluate)(_require_reading(reading, evaluate)))

        names = ("spread", "lowest", "highest", "rate", "time_ratio")
        return {**ARITHMETIC, **{name: over_travel(f"_{name}") for name in names}}

    def _rate(self, reading: _ReadingValues) -> Measured:
        over = unit_of_kind(self._kinds[self._law.over])
        mass, length, time = (one - other for one, other in zip(reading.unit, over, strict=True))
        return Measured(self._rates[reading.name], (mass, length, time))

    def _lowest(self, reading: _ReadingValues) -> Measured:
        return Measured(float(np.min(self._extremes(reading)[1])), reading.unit)

    def _highest(self, reading: _ReadingValues) -> Measured:
        return Measured(float(np.max(self._extremes(reading)[1])), reading.unit)

    def _spread(self, reading: _ReadingValues) -> Measured:
        return Measured(float(np.ptp(self._extremes(reading)[1])), reading.unit)

    def _time_ratio(self, reading: _ReadingValues) -> Measured:
        """Return the longer way between the two extremes of a reading, relative to the shorter one, over a full turn."""
        places, values = self._extremes(reading)
        whole = abs(self._law.between[1] - self._law.between[0])
        way = abs(places[np.argmax(values)] - places[np.argmin(values)])
        return Measured(max(way, whole - way) / min(way, whole - way))

    def _extremes(self, reading: _ReadingValues) -> tuple[FloatArray, FloatArray]:
        """Return places and values of a reading at all positions, and at its extremes between them."""
        values, rates, accelerations = (one[reading.name] for one in (self._readings, self._rates, self._accelerations))
        starts = np.flatnonzero(rates[:-1] * rates[1:] < 0)
        curve = HermiteCurve(self._positions, values, rates, accelerations)
        ends = self._positions[starts], self._positions[starts + 1]
        tolerance = ROOT_TOLERANCE * abs(self._positions[1] - self._positions[0])
        places = curve.find_extremes(starts, 2, np.minimum(*ends), np.maximum(*ends), tolerance)
        return np.append(self._positions, places), np.append(values, curve.evaluate(starts, 2, places)[0])


def _way_from_start(scene: Scene, law: Law) -> FloatArray:
    """Return values of the driving reading from the start of the scene to the first end of the travel, as close as the positions."""
    if law.over == TIME_VARIABLE:
        return np.empty(0)
    mechanism, (low, high) = scene.part.mechanism, law.between
    start = float(evaluate_output_value(mechanism, law.over, initial_state(scene)[0]))
    n_steps = math.ceil(abs(low - start) / abs(high - low) * max(law.positions, MIN_WAY_POSITIONS))
    return np.linspace(start, low, n_steps, endpoint=False)


def _require_reading(argument: Measured, function: str) -> _ReadingValues:
    """Return the argument of a function of a reading; refuse an expression."""
    if not isinstance(argument, _ReadingValues):
        name = function.removeprefix("_")
        raise MechanismError(f"{name} in a law is of a reading, as {name}(pen_x), not of an expression; add it to [readings]")
    return argument


@dataclass(frozen=True)
class BrokenLaw(ComparisonRow):
    """What a changed dimension does to an equation that it must break."""

    @property
    def passed(self) -> bool:
        """Whether the difference exceeds the tolerance."""
        return abs(self.difference) > self.allowed

    @property
    def verdict(self) -> str:
        """Words for the printed table."""
        return "broken, as it must be" if self.passed else "FAILED: holds"


def check_law(scene: Scene) -> CheckReport:
    """Prove the law of a scene: its equations over the whole travel, and both lists of dimensions, each changed by 1 %.

    Result: a row for each equation where its sides differ most, and one for each dimension, of the equation with the largest difference
    relative to its tolerance. Raises MechanismError if the scene states no law, or if the mechanism does not reach a position.
    """
    law = scene.part.law
    if law is None:
        raise MechanismError(f"{scene.title} states no law; a table [law] in its file does")
    rows = [*_compare_all(scene, ComparisonRow, law.statement), *_compare_changed(scene, law)]
    return CheckReport(title=f"{scene.title}: {law.statement}", against="law", rows=tuple(rows))


def _compare_all(scene: Scene, row: type[ComparisonRow], reason: str, label: str = "") -> Iterator[ComparisonRow]:
    """Yield a row for each equation of the law of a scene."""
    law = scene.part.law
    if law is None:
        return
    travel = _Travel(scene, law)
    for equation in law.equations:
        value, expected = travel.compare(equation)
        yield row(f"{label}{equation}", value, expected, equation.within, equation.unit, reason)


def relative_law_differences(scene: Scene) -> FloatArray:
    """Return for each equation of the law of a scene the difference of its sides, relative to that which it allows; shape (n,)."""
    return np.array([abs(row.difference) / row.allowed for row in _compare_all(scene, ComparisonRow, "")])


def _compare_changed(scene: Scene, law: Law) -> Iterator[ComparisonRow]:
    """Yield a row for each dimension, changed alone: of the equation that suffers most."""
    for name in (*law.holds_under, *law.broken_by):
        is_kept = name in law.holds_under
        reason = "a dimension of law.holds_under" if is_kept else "a dimension of law.broken_by"
        rows = _compare_with(scene, name, law.dimensions[name], ComparisonRow if is_kept else BrokenLaw, reason)
        yield max(rows, key=lambda row: abs(row.difference) / row.allowed)


def _compare_with(scene: Scene, name: str, measured: Measured, row: type[ComparisonRow], reason: str) -> list[ComparisonRow]:
    """Return the rows of a scene with a longer dimension, or with a shorter one where the mechanism does not reach its travel then."""
    for change in (CHANGE, -CHANGE):
        number = float(measured.value) * (1 + change)
        try:
            changed = parse_scene_with(scene.document, [(f"dimensions.{name}", _written(number, measured))])
            return list(_compare_all(changed, row, reason, f"with {name} {change:+.0%}: "))
        except MechanismError:
            if change < 0:
                raise
    return []


def _written(number: float, measured: Measured) -> float | str:
    """Return a quantity as a scene file has it."""
    return number if measured.unit == PLAIN else f"{number!r} {si_unit_of(measured.unit)}"

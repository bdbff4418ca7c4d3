"""[dimensions] of a custom machine, named quantities with texts "= 2 * crank" that are evaluated with them, and its [law] of equations."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.part import Law, LawEquation, Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.effect_tables import resolve_reading_name
from governor_mechanism.scenes.quantities import (
    NUMBER_OR_TEXT,
    TEXT,
    VALUE_TYPES,
    Table,
    ValueType,
    check_label,
    list_of,
    pair_of,
    without_context,
)
from governor_mechanism.units.expressions import (
    ARITHMETIC,
    EvaluatedText,
    Expression,
    Function,
    Measured,
    Unit,
    format_unit,
    read_any_quantity,
    si_unit_of,
    unit_of_kind,
)
from governor_mechanism.units.fields import Declaration, declare
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake, parse_each, wrong_value
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_value

EXPRESSION_MARK: Final = "="
"""First character of a text that is an expression."""

_TEXT_KEYS: Final = ("title", "name", "law", "dimensions", "machine", "type")
"""Keys whose texts are no quantities, or are evaluated elsewhere."""


@dataclass(frozen=True)
class Dimension:
    """A named quantity of a scene file."""

    measured: Measured  # its value with its unit
    kind: str  # kind of quantity; "" if an expression with a unit of its own leaves it open

    @property
    def unit(self) -> str:
        """SI unit; empty for a plain number."""
        return QUANTITY_KINDS[self.kind].si_unit if self.kind else si_unit_of(self.measured.unit)


class _CircularDefinitionError(MechanismError):
    """A dimension is defined by itself."""


class DimensionTable:
    """The dimensions of a scene file, each evaluated when another one needs it."""

    def __init__(
        self,
        table: object,  # [dimensions] as it is written; anything else is reported with the top level
    ) -> None:
        self._written: Mapping[str, Any] = table if isinstance(table, Mapping) else {}
        self._values, self._pending = dict[str, Dimension](), list[str]()
        self.has_failed = False  # whether an expression outside the table could not be evaluated

    def read_all(self, collector: ProblemCollector) -> dict[str, Dimension]:
        """Return the dimensions without a mistake, by name; report every wrong one."""
        known = {}
        for name in self._written:
            with collector.at(f"dimensions.{name}"):
                known[name] = self._read(str(name))
        return known

    def _read(self, name: str) -> Dimension:
        """Return a dimension; raise MechanismError with its mistakes, or without any if they are those of another one."""
        if name not in self._values:
            if not name.isidentifier() or name == "pi" or name in ARITHMETIC:
                text = f"{KEY} is no name of a dimension; one consists of letters, digits and _, as crank, and is no function"
                raise mistake(ProblemCode.WRONG_TYPE, text)
            self._pending.append(name)
            try:
                self._values[name] = self._evaluate(self._written[name])
            finally:
                self._pending.pop()
        return self._values[name]

    def _evaluate(self, value: object) -> Dimension:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise wrong_value(value, 'must be a quantity, as "300 mm", or an expression, as "= 2 * crank"')
        if not is_expression(value):
            number, kind = read_any_quantity(value, KEY)
            return Dimension(Measured(number, unit_of_kind(kind)), kind)
        measured = self.evaluate(str(value))
        kinds = [kind for kind, one in QUANTITY_KINDS.items() if one.units and unit_of_kind(kind) == measured.unit]
        return Dimension(measured, "number" if not any(measured.unit) else kinds[0] if kinds else "")

    def evaluate(self, text: str) -> Measured:
        """Return the value of a text with the mark of an expression."""
        expression = Expression(text.strip().removeprefix(EXPRESSION_MARK))
        measured = expression.evaluate(self._look_up, ARITHMETIC)
        if not np.isfinite(measured.value):
            raise mistake(ProblemCode.OUT_OF_RANGE, f"{KEY} {format_value(text)} has no finite value with these dimensions")
        return measured

    def _look_up(self, name: str) -> Measured:
        if name not in self._written:
            known = f"dimensions are {', '.join(self._written)}" if self._written else "there is no table [dimensions]"
            text = f"{KEY} names the unknown dimension {format_value(name)}; {known}.{did_you_mean(name, self._written)}"
            raise mistake(ProblemCode.UNKNOWN_NAME, text)
        if name in self._pending:
            circle = " -> ".join([*self._pending[self._pending.index(name) :], name])
            text = f"{KEY} is defined by itself: {circle}; give one of them a value"
            raise _CircularDefinitionError(Problem(text, ProblemCode.INCONSISTENT))
        is_for_dimension = bool(self._pending)
        try:
            return self._read(name).measured
        except MechanismError as error:  # reported where the dimension stands
            if is_for_dimension and isinstance(error, _CircularDefinitionError):
                raise
            raise MechanismError from error


def is_expression(value: object) -> bool:
    """Return whether a value is the text of an expression."""
    return isinstance(value, str) and value.lstrip().startswith(EXPRESSION_MARK)


def evaluate_expressions(document: Mapping[str, Any], table: DimensionTable, collector: ProblemCollector) -> dict[str, Any]:
    """Return a document in which the texts of expressions know their values; report those that cannot be evaluated."""
    return {key: _evaluate_in(value, str(key), str(key), table, collector) for key, value in document.items()}


def _evaluate_in(value: Any, key: str, path: str, table: DimensionTable, collector: ProblemCollector) -> Any:
    """Return a value, or a copy of a table or list, with its expressions evaluated."""
    if key in _TEXT_KEYS:
        return value
    if isinstance(value, Mapping):
        start = f"{path} " if path.endswith(":") else f"{path}."
        return {name: _evaluate_in(item, str(name), f"{start}{name}", table, collector) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_evaluate_in(item, key, _item_path(path, item, number), table, collector) for number, item in enumerate(value, start=1)]
    if not is_expression(value):
        return value
    measured = collector.attempt(path, table.evaluate, value)
    table.has_failed |= measured is None
    return EvaluatedText(value, measured)


def _item_path(path: str, item: object, number: int) -> str:
    """Return the path of an item of a list: a table has its name, if it has one, and others their number."""
    if not isinstance(item, Mapping):
        return f"{path}.{number}"
    name = item.get("name")
    return f"{path} {format_value(name) if isinstance(name, str) else number}:"


def document_of_part(scene: Scene, part: Part) -> Mapping[str, Any]:
    """Return the tables of a part in the document of its scene; empty if the scene was composed of objects."""
    tables: Any = scene.document.get("part", {}).get(part.name, {}) if "part" in scene.document else scene.document
    return tables if isinstance(tables, Mapping) else {}


def dimensions_of(scene: Scene, part: Part) -> dict[str, Dimension]:
    """Return the dimensions of a part with a custom machine, by name."""
    return DimensionTable(document_of_part(scene, part).get("dimensions")).read_all(ProblemCollector())


MAX_POSITIONS = 10_000
"""Largest number of positions of a law."""


@dataclass(frozen=True)
class LawContext:
    """What a law refers to."""

    kinds: Mapping[str, str]  # kind of quantity by reading
    dimensions: Mapping[str, Dimension]  # dimensions by name
    table: DimensionTable  # the table from which they are

    def look_up(self, name: str) -> Measured:
        """Return a dimension, or a reading of which only the unit counts."""
        if name in self.dimensions:
            return self.dimensions[name].measured
        if name not in self.kinds:
            known = [*self.kinds, *self.dimensions]
            text = f"{format_value(name)} is neither a reading nor a dimension; these are {', '.join(known)}.{did_you_mean(name, known)}"
            raise mistake(ProblemCode.UNKNOWN_NAME, text)
        return Measured(1.0, unit_of_kind(self.kinds[name]))

    def measure(self, value: object) -> Measured:
        """Return a quantity of any kind, or the value of an expression of dimensions."""
        if is_expression(value):
            return self.table.evaluate(str(value))
        number, kind = read_any_quantity(value, KEY)
        return Measured(number, unit_of_kind(kind))


def _functions_of_units(over: Unit) -> dict[str, Function]:
    """Return the functions of a law as far as units are concerned; those of a reading are over the whole travel."""

    def rate(measured: Measured) -> Measured:
        mass, length, time = (one - other for one, other in zip(measured.unit, over, strict=True))
        return Measured(1.0, (mass, length, time))

    kept = Function(lambda measured: measured)
    plain = Function(lambda measured: Measured(1.0))
    return {**ARITHMETIC, "spread": kept, "lowest": kept, "highest": kept, "rate": Function(rate), "time_ratio": plain}


def _read_over(declared: Declaration, value: object, context: LawContext) -> str:
    return resolve_reading_name(check_label(value), context.kinds, f"{KEY} {format_value(value)}")


def _read_travel(declared: Declaration, value: object, context: LawContext) -> tuple[float, float]:
    """Return first and last value of the driving reading; their unit is checked with the equations."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise wrong_value(value, 'must be [first, last], as ["-40 deg", "40 deg"]')
    low, high = (float(one.value) for one in parse_each(context.measure, value))
    if low == high:
        raise wrong_value(value, "must have two different ends", code=ProblemCode.OUT_OF_RANGE)
    return low, high


def _read_count(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 2 <= value <= MAX_POSITIONS:
        raise wrong_value(value, f"must be a whole number from 2 to {MAX_POSITIONS}")
    return value


def _read_names(declared: Declaration, value: object, context: LawContext) -> tuple[str, ...]:
    """Return names of dimensions."""
    if not isinstance(value, list | tuple) or not all(isinstance(one, str) for one in value):
        raise wrong_value(value, 'must be a list of dimensions, as ["crank", "rod"]')
    for name in value:
        if name not in context.dimensions:
            known = ", ".join(context.dimensions) or "not given; add a table [dimensions]"
            text = (
                f"{KEY} names the unknown dimension {format_value(name)}; dimensions are {known}.{did_you_mean(name, context.dimensions)}"
            )
            raise mistake(ProblemCode.UNKNOWN_NAME, text)
    return tuple(value)


def _read_expression(declared: Declaration, value: object, context: LawContext) -> Expression:
    """Return an expression, of which the names are checked with its unit."""
    text = repr(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
    if not isinstance(text, str) or not text.strip():
        raise wrong_value(value, 'must be an expression, as "2 * crank"')
    return Expression(text.strip().removeprefix(EXPRESSION_MARK))


EQUATION: Final = Table(
    make=dict,
    fields={
        "value": declare("expression", meaning="an expression of readings and dimensions"),
        "equals": declare("expression", meaning="what it is equal to at every position"),
        "within": declare("tolerance", meaning='the largest difference, as "1e-12 m"'),
    },
    types={
        "expression": ValueType(_read_expression, NUMBER_OR_TEXT),
        "tolerance": ValueType(lambda declared, value, context: context.measure(value), NUMBER_OR_TEXT),
    },
    example='{ value = "pen_x", equals = "2 * crank", within = "1e-12 m" }',
)
"""One of `law.proves`; its context is a `LawContext`."""

LAW: Final = Table.of(
    Law,
    types={
        **VALUE_TYPES,
        "reading": ValueType(_read_over, TEXT),
        "travel": ValueType(_read_travel, pair_of(NUMBER_OR_TEXT)),
        "count": without_context(_read_count, {"type": "integer", "minimum": 2, "maximum": MAX_POSITIONS}),
        "names": ValueType(_read_names, list_of(TEXT)),
        "equations": ValueType(lambda declared, value, context: _read_equations(value, context), list_of(EQUATION.schema())),
    },
)
"""[law]; its context is a `LawContext`."""


def _read_equations(value: object, context: LawContext) -> tuple[dict[str, Any], ...]:
    """Return the equations as they are written, with expressions read and the tolerance measured."""
    if not isinstance(value, list | tuple) or not value:
        raise wrong_value(value, f"must be a list of equations, as [{EQUATION.example}]")
    paths = [f"{KEY}, equation {number}:" for number in range(1, len(value) + 1)]
    return tuple(parse_each(lambda one: EQUATION.read(one, context), value, paths=paths))


def parse_law(
    table: object,
    readings: Sequence[Reading] | None,  # readings of the mechanism, or None if not all are known
    dimensions: Mapping[str, Dimension],
    dimension_table: DimensionTable,
) -> Law:
    """Return the law of [law]; raise MechanismError with a `Problem` for each mistake."""
    if readings is None:  # a mistake elsewhere, without which more is known
        raise MechanismError
    kinds = {reading.name: reading.quantity for reading in readings} | {TIME_VARIABLE: "time"}
    context = LawContext(kinds, dimensions, dimension_table)
    given = LAW.read(table, context)
    collector = ProblemCollector()
    over = context.look_up(given["over"]).unit
    paths = [f"{KEY}.proves, equation {number}:" for number in range(1, len(given["equations"]) + 1)]
    with collector.at():
        given["equations"] = tuple(parse_each(lambda one: _make_equation(one, context, over), given["equations"], paths=paths))
    collector.problems += _find_uncovered_dimensions(given, dimensions)
    if collector.problems:
        raise MechanismError(*collector.problems)
    return Law(**given, dimensions={name: one.measured for name, one in dimensions.items()})


def _find_uncovered_dimensions(given: Mapping[str, Any], dimensions: Mapping[str, Dimension]) -> Iterator[Problem]:
    """Yield the problems of the two lists of dimensions: each dimension stands in one of them."""
    holds, breaks = given.get("holds_under", ()), given.get("broken_by", ())
    if not dimensions:
        text = f"{KEY} names no dimension; give the scene a table [dimensions], and list each in holds_under or in broken_by"
        yield Problem(text, ProblemCode.MISSING_KEY)
    missing = [name for name in dimensions if name not in (*holds, *breaks)]
    if missing:
        text = f"{KEY} does not say what a change of {', '.join(missing)} does; list each dimension in holds_under or in broken_by"
        yield Problem(text, ProblemCode.MISSING_KEY)
    if both := [name for name in holds if name in breaks]:
        text = f"{KEY} lists {', '.join(both)} in holds_under and in broken_by; a change leaves the law true, or breaks it"
        yield Problem(text, ProblemCode.CONFLICT)


def _make_equation(given: Mapping[str, Any], context: LawContext, over: Unit) -> LawEquation:
    """Return an equation whose two sides and tolerance have one unit."""
    functions = _functions_of_units(over)
    value, equals = (given[side].evaluate(context.look_up, functions) for side in ("value", "equals"))
    within = given["within"]
    if not value.unit == equals.unit == within.unit:
        sides = [f"{side} is {format_unit(one.unit)}" for side, one in (("value", value), ("equals", equals), ("within", within))]
        raise mistake(ProblemCode.WRONG_QUANTITY, f"{KEY} has sides of different units: {', '.join(sides)}")
    if not within.value > 0:
        raise mistake(ProblemCode.OUT_OF_RANGE, f"{KEY} within must be positive; it is the largest difference that counts as equal")
    return LawEquation(value=given["value"], equals=given["equals"], within=float(within.value), unit=si_unit_of(value.unit))

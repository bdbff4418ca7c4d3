"""[dimensions] of a custom machine: named quantities, and the texts "= 2 * crank" that are evaluated with them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.units.expressions import (
    ARITHMETIC,
    EvaluatedText,
    Expression,
    Measured,
    read_any_quantity,
    si_unit_of,
    unit_of_kind,
)
from governor_mechanism.units.problems import KEY, Problem, ProblemCode, ProblemCollector, mistake, wrong_value
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

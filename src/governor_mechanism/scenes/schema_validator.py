"""Validators of a scene file's values that say in JSON Schema what they accept. Slow to import: pydantic."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from pydantic import PlainValidator

from governor_mechanism.units.quantities import QUANTITY_KINDS

JsonSchema = Mapping[str, Any]
"""A JSON Schema of draft 7, which editors of TOML understand."""

NUMBER_PATTERN: Final = r"^\s*[-+\u2212]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?\s*\D"
"""Pattern of a number with a unit, for JSON Schema."""

TEXT: Final[JsonSchema] = {"type": "string", "minLength": 1}
TABLE: Final[JsonSchema] = {"type": "object"}
NUMBER_OR_TEXT: Final[JsonSchema] = {"type": ["number", "string"]}
POINT: Final[JsonSchema] = {"type": ["string", "array"], "description": 'a point, as "crank.end", or ["crank", "10 mm", 0]'}
MOTION: Final[JsonSchema] = {"type": ["array", "object"], "description": "a list of [time, value], or { start, rate, harmonics }"}
"""Schemas of simple values."""


@dataclass(frozen=True)
class SchemaValidator(PlainValidator):
    """A validator that says in JSON Schema what it accepts, roughly: it may refuse more.

    Attributes
    ----------
    json_schema
        The schema.
    """

    json_schema: JsonSchema = field(default_factory=dict, kw_only=True)


def quantity_schema(kind: str, sign: str = "any") -> dict[str, Any]:
    """Return the JSON Schema of a quantity.

    Parameters
    ----------
    kind
        Key of QUANTITY_KINDS.
    sign
        Key of SIGNS; it holds for bare numbers.

    Returns
    -------
    dict
        The schema: a number in SI, or text with a unit.
    """
    limit = {"positive": {"exclusiveMinimum": 0}, "not negative": {"minimum": 0}}.get(sign, {})
    return {"type": ["number", "string"], "pattern": NUMBER_PATTERN, **limit, "description": QUANTITY_KINDS[kind].hint}


def or_points(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a value, or of a list of [time, value]."""
    pair = {"type": "array", "items": [quantity_schema("time"), schema], "minItems": 2, "maxItems": 2}
    return {"anyOf": [schema, {"type": "array", "items": pair, "minItems": 1}]}


def or_load(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a load: a value, a list of [time, value], harmonics, a function of a reading, or a list of these."""
    function = {"type": "object", "anyOf": [{"required": ["reading"]}, {"required": ["harmonics"]}]}
    return {"anyOf": [schema, function, {"type": "array", "minItems": 1}]}


def pair_of(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a list of two values."""
    return {"type": "array", "items": schema, "minItems": 2, "maxItems": 2}


def list_of(schema: JsonSchema) -> dict[str, Any]:
    """Return the JSON Schema of a list."""
    return {"type": "array", "items": schema}

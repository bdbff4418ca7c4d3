"""JSON Schema of scene files, for editors that complete and check TOML.

The schema is made from the tables that the parser uses. It accepts every scene that the parser accepts; the parser refuses more, such as
a wrong unit or a reading that does not exist.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Final

from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.scenes.custom.contacts import CONTACT
from governor_mechanism.scenes.custom.dimensions import LAW
from governor_mechanism.scenes.custom.parser import CUSTOM_TOP_LEVEL
from governor_mechanism.scenes.custom.parts import BODY, FORCE_TABLES, JOINT_TABLES, LINK, READING_TABLES, VALVE
from governor_mechanism.scenes.effect_tables import CROSSING
from governor_mechanism.scenes.loads import COUPLING_TABLES, LOAD, LOAD_TYPES, or_load
from governor_mechanism.scenes.quantities import NUMBER_OR_TEXT, TEXT, JsonSchema, Table, list_of, pair_of, quantity_schema
from governor_mechanism.scenes.schema import CUSTOM_KEYS, FREE_SPINDLE, RUN, SPINDLE, dimensions_table
from governor_mechanism.units.fields import Declaration, fields_of

_COMMON_KEYS: Final = ("title", "run", "events")
"""Keys that stand once for all parts."""


def scene_schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 7) of scene files."""
    names = [*MACHINES, CUSTOM_MACHINE]
    definitions: dict[str, Any] = {f"dimensions_{name}": dimensions_table(MACHINES[name]).schema() for name in MACHINES}
    definitions |= {"effects": _effects_schema(), "spindle": _spindle_schema(), "start": _start_schema(), "run": RUN.schema()}
    definitions |= {"events": _tables_by_name(CROSSING.schema())}
    definitions |= {key: _custom_schema(key) for key in CUSTOM_KEYS}
    definitions["dimensions_custom"] = _tables_by_name(NUMBER_OR_TEXT)
    single = {"title", "run", "events"}
    definitions |= {f"scene_{name}": _part_schema(name, single) for name in names}
    definitions |= {f"part_{name}": _part_schema(name, ()) for name in names}
    definitions["part"] = {"type": "object", **_by_machine("part", names)}
    definitions["coupled_scene"] = _coupled_schema()
    has_parts = {"anyOf": [{"required": ["part"]}, {"required": ["coupling"]}]}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Scene of governor_mechanism",
        "type": "object",
        "properties": _completions(names),
        "if": has_parts,
        "then": {"$ref": "#/definitions/coupled_scene"},
        "else": _by_machine("scene", names),
        "definitions": definitions,
    }


def _completions(names: Iterable[str]) -> dict[str, Any]:
    """Return all keys of the top level, so that editors complete them before the machine is known."""
    dimensions = {"anyOf": [{"$ref": f"#/definitions/dimensions_{name}"} for name in names]}
    references = {key: {"$ref": f"#/definitions/{key}"} for key in ("effects", "spindle", "start", "run", "events", *CUSTOM_KEYS)}
    return {
        "title": dict(TEXT),
        "machine": {"enum": list(names), "description": "the machine; custom is a mechanism of one's own"},
        "dimensions": dimensions,
        **references,
        "part": {"description": "the parts of a scene of several, one table [part.NAME] for each"},
        "coupling": {"description": "what couples the parts, one table [coupling.NAME] for each"},
        "load": {"description": "the load on the shaft of an engine"},
    }


def _by_machine(kind: str, names: Iterable[str]) -> dict[str, Any]:
    """Return the schema that selects the tables by the machine."""
    cases = [
        {"if": {"properties": {"machine": {"const": name}}, "required": ["machine"]}, "then": {"$ref": f"#/definitions/{kind}_{name}"}}
        for name in names
    ]
    return {"properties": {"machine": {"enum": list(names)}}, "required": ["machine"], "allOf": cases}


def _part_schema(machine: str, common_keys: Iterable[str]) -> dict[str, Any]:
    """Return the schema of a part with a machine; as the only part, it has the keys that stand once."""
    keys = ["effects", "spindle", "start", *(key for key in _COMMON_KEYS if key in common_keys and key != "title")]
    own_keys, required = ([*CUSTOM_KEYS], ["machine", "body"]) if machine == CUSTOM_MACHINE else ([], ["machine", "dimensions"])
    properties: dict[str, Any] = {"machine": {"const": machine}}
    properties |= {"title": dict(TEXT)} if "title" in common_keys else {}
    properties |= {key: {"$ref": f"#/definitions/{key}"} for key in (*keys, *own_keys)}
    properties["dimensions"] = {"$ref": f"#/definitions/dimensions_{machine}"}
    if machine in MACHINES and not any(one.is_required for one in fields_of(MACHINES[machine]).values()):
        required = ["machine"]
    return {"type": "object", "properties": properties, "required": required, "additionalProperties": False}


def _coupled_schema() -> dict[str, Any]:
    """Return the schema of a scene of several parts."""
    properties = {
        "title": dict(TEXT),
        "run": {"$ref": "#/definitions/run"},
        "events": {"$ref": "#/definitions/events"},
        "load": LOAD.schema(),
        "part": _tables_by_name({"$ref": "#/definitions/part"}),
        "coupling": _tables_by_name(_by_type(COUPLING_TABLES)),
    }
    return {"type": "object", "properties": properties, "required": ["part"], "additionalProperties": False}


def _tables_by_name(schema: JsonSchema) -> dict[str, Any]:
    return {"type": "object", "additionalProperties": schema}


def _by_type(tables: Mapping[str, Table]) -> dict[str, Any]:
    """Return the schema of a table whose other keys depend on its type."""
    cases = []
    for name, table in tables.items():
        schema = table.schema()
        schema["properties"] |= {"type": {"const": name}}
        cases.append({"if": {"properties": {"type": {"const": name}}, "required": ["type"]}, "then": schema})
    return {"type": "object", "properties": {"type": {"enum": list(tables)}}, "required": ["type"], "allOf": cases}


def _custom_schema(key: str) -> dict[str, Any]:
    """Return the schema of a key of a custom machine."""
    lists: dict[str, JsonSchema] = {
        "body": BODY.schema(),
        "joint": _by_type(JOINT_TABLES),
        "link": LINK.schema(),
        "force": _by_type(FORCE_TABLES),
        "contact": CONTACT.schema(),
    }
    if key in lists:
        return list_of(lists[key])
    if key == "ground":
        return _tables_by_name({"type": "array", "minItems": 2, "maxItems": 2})
    if key == "readings":
        return _tables_by_name({"anyOf": [table.schema() for table in READING_TABLES.values()]})
    if key == "law":
        return LAW.schema()
    return VALVE.schema() if key == "valve" else CUSTOM_TOP_LEVEL.schema_of(CUSTOM_TOP_LEVEL.fields[key])


def _spindle_schema() -> dict[str, Any]:
    """Return the schema of [spindle], with a given speed or free; the parser refuses keys of both."""
    given, free = SPINDLE.schema(), FREE_SPINDLE.schema()
    return {"type": "object", "properties": given["properties"] | free["properties"], "additionalProperties": False}


def _start_schema() -> dict[str, Any]:
    """Return the schema of [start]; its keys are the readings of the mechanism and their rates."""
    return {"type": "object", "additionalProperties": dict(NUMBER_OR_TEXT), "description": "values and rates of readings at the start"}


def _effects_schema() -> dict[str, Any]:
    """Return the schema of [effects]."""
    properties = {effect.key: _effect_schema(effect) | {"description": _summary_of(effect)} for effect in EFFECTS}
    return {"type": "object", "properties": properties, "additionalProperties": False}


def _summary_of(effect: type[Effect]) -> str:
    return (effect.__doc__ or "").split("\n")[0]


def _effect_schema(effect: type[Effect]) -> dict[str, Any]:
    """Return the schema of an effect: false, or a table by reading for an effect along readings."""
    if not issubclass(effect, OutputEffect):
        return {"anyOf": [{"type": "boolean"}, *_value_schemas(effect)]}
    keys = fields_of(effect)
    common = {name: _key_schema(keys[name]) for name in effect.common_keys}
    by_reading = {"anyOf": [{"const": False}, *_value_schemas(effect)]}
    return {"anyOf": [{"const": False}, {"type": "object", "properties": common, "additionalProperties": by_reading, "minProperties": 1}]}


def _value_schemas(effect: type[Effect]) -> list[dict[str, Any]]:
    """Return the schemas of the values of an effect: one value or the two ends of a range, and the table of its keys."""
    keys = {name: key for name, key in fields_of(effect).items() if name not in effect.common_keys}
    schemas: list[dict[str, Any]] = []
    if len(effect.value_fields) == 1:
        schemas.append(_key_schema(keys[effect.value_fields[0]]))
    elif effect.value_fields:
        schemas.append(pair_of(NUMBER_OR_TEXT))
    derived = {
        name: quantity_schema(kind) | {"description": derivation.meanings[name]}
        for derivation in effect.derivations
        for name, kind in derivation.kinds.items()
    }
    properties = {name: _key_schema(key) for name, key in keys.items()} | derived
    if len(effect.value_fields) < len(properties):
        schemas.append({"type": "object", "properties": properties, "additionalProperties": False})
    return schemas


def _key_schema(declared: Declaration) -> dict[str, Any]:
    """Return the schema of a key of an effect."""
    if declared.form == "load":
        return or_load(_with_meaning(quantity_schema(declared.kind, declared.sign), declared)) | {"description": declared.meaning}
    return _with_meaning(LOAD_TYPES[declared.form].schema_of(declared), declared)


def _with_meaning(schema: Mapping[str, Any], declared: Declaration) -> dict[str, Any]:
    """Return a schema whose description begins with the meaning of the key."""
    texts = [text for text in (declared.meaning, schema.get("description", "")) if text]
    return {**schema, "description": "; ".join(texts)} if texts else dict(schema)

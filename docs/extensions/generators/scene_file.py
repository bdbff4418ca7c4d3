"""Reference of the scene file: every table and every key, from the models of the parser, which also make the JSON schema."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from functools import partial
from itertools import chain
from typing import Any

from generators.markdown import code, escape, sentence, table
from generators.values import describe_schema, describe_table, format_default, name_kind
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.machines.base import CHOICE_KIND, Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import FLAG_KIND, RESTITUTION_KIND, Effect, OutputEffect, SceneKey, scene_keys_of
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.scenes.custom import bodies, elements
from governor_mechanism.scenes.custom.parser import CustomSceneTable
from governor_mechanism.scenes.custom.readings import READING_TABLES
from governor_mechanism.scenes.custom.valve import ReverserTable, ValveTable
from governor_mechanism.scenes.events import CrossingTable
from governor_mechanism.scenes.harmonics import angle_harmonic_table, harmonic_table
from governor_mechanism.scenes.loads import COUPLING_TABLES, LoadTable, ReadingFunctionTable
from governor_mechanism.scenes.schema import CoupledSceneTable, FreeSpindleTable, RunTable, SceneTable, SpindleTable, dimensions_table_model
from governor_mechanism.scenes.schema_validator import SchemaValidator, quantity_schema
from governor_mechanism.scenes.table import SceneFileTable
from governor_mechanism.units.quantities import ACCEPTED_UNITS, QUANTITY_KINDS

HEADING = ("key", "values", "default", "meaning")


def scene_file_page() -> str:
    """Return the sections of the page."""
    sections = chain(
        _common_sections(), _dimension_sections(), _effect_sections(), _custom_sections(), _coupled_sections(), _kind_section()
    )
    return "\n".join(sections)


def keys_table(model: type[SceneFileTable], *, leave_out: tuple[str, ...] = ()) -> str:
    """Return the keys of a table of a scene file as a table."""
    return table(HEADING, describe_table(model, leave_out=leave_out))


def _section(heading: str, *paragraphs: str, level: int = 2) -> str:
    return "\n\n".join([f"{'#' * level} {heading}", *(one.strip() for one in paragraphs if one)]) + "\n"


def _common_sections() -> Iterator[str]:
    """Yield the top level and the tables that all scenes have."""
    machines = "The machine of `machine` decides which keys `[dimensions]` has; `custom` is a mechanism of bodies and joints of one's own."
    yield _section("Top level", machines, keys_table(SceneTable))
    yield _section("`[run]`", keys_table(RunTable))
    given = "With a given speed, which may change with time and fluctuate within a turn:"
    free = "A free spindle, whose speed follows from its torque:"
    yield _section(
        "`[spindle]`", "The spindle of a machine in a turning plane.", given, keys_table(SpindleTable), free, keys_table(FreeSpindleTable)
    )
    start = (
        "The keys are the [readings](readings.md) of the mechanism, and their rates: the rate of `arm_angle` is `arm_rate`. A value is "
        'a quantity, or `"equilibrium"`, which is the default where a machine can be in equilibrium. Rates are 0 by default.'
    )
    yield _section("`[start]`", start)
    yield _section("`[events.NAME]`", "A named crossing of a reading. Runs report it with its time.", keys_table(CrossingTable))
    load = (
        "A torque, a force or a friction is a quantity; a list of `[time, value]`, with straight lines between the points and a jump "
        "where a time is given twice; sines of the time, `{ harmonics = [{ amplitude, frequency, phase }] }`; a function of a reading, "
        "with the keys below; or a list of these, which is their sum. A function has one of `table`, `gain` and `harmonics`."
    )
    harmonic = "A harmonic of the time is amplitude × sin(2π × frequency × t + phase), in loads and in the motions of drives alike."
    yield _section(
        "Functions of time and of readings", load, keys_table(ReadingFunctionTable), harmonic, keys_table(harmonic_table("torque"))
    )
    angle_harmonic = "A harmonic of an angle is amplitude × sin(order × angle + phase)."
    yield _section("Harmonics of an angle", angle_harmonic, keys_table(angle_harmonic_table("torque")), level=3)


def _dimension_sections() -> Iterator[str]:
    """Yield the dimensions of every machine."""
    yield _section("`[dimensions]`", "A bare number is in SI; text has a unit. See the kinds of quantities at the end of this page.")
    for name, machine in MACHINES.items():
        plane = "The plane turns with the spindle." if machine.plane == TURNING_PLANE else "The plane is fixed."
        summary = (machine.__doc__ or "").split("\n\n")[0].replace("\n", " ")
        yield _section(code(name), f"{summary} {plane}", table(HEADING, _dimension_rows(machine)), level=3)


def _dimension_rows(machine: type[Machine]) -> Iterator[list[str]]:
    model = dimensions_table_model(machine).fields_by_key()
    for field in dataclasses.fields(machine):
        schema = next(item.json_schema for item in model[field.name].metadata if isinstance(item, SchemaValidator))
        kind = field.metadata["kind"]
        meaning = model[field.name].description or ""
        is_required = field.default is dataclasses.MISSING
        own = quantity_schema(kind) if kind in QUANTITY_KINDS else {}
        default = "required" if is_required else format_default(field.default, own)
        if kind == CHOICE_KIND:
            default = code(f'"{field.default}"')
        yield [code(field.name), describe_schema(schema), default, escape(meaning)]


def _effect_sections() -> Iterator[str]:
    """Yield the effects and their keys."""
    text = (
        "A scene simulates only the effects that it lists; `false` switches one off. An effect along a reading is a table by reading, as "
        "`spring.sleeve_lift`: a force along a length, a moment along an angle. What each engine can model is listed in "
        "[effects and engines](effects_and_engines.md)."
    )
    yield _section("`[effects]`", text)
    for effect in EFFECTS:
        summary = (effect.__doc__ or "").split("\n\nAttributes")[0].split("\n\n    Attributes")[0]
        paragraphs = " ".join(summary.split())
        keys = [*_effect_rows(effect)]
        usage = _effect_usage(effect)
        yield _section(code(effect.key), paragraphs, usage, table(HEADING, keys) if keys else "", level=3)


def _effect_usage(effect: type[Effect]) -> str:
    """Return how an effect is written."""
    if not scene_keys_of(effect):
        return f"Written as {code(f'{effect.key} = true')}."
    place = f"[effects.{effect.key}]" if not issubclass(effect, OutputEffect) else f"[effects.{effect.key}.READING]"
    short = f"{effect.key} = …" if not issubclass(effect, OutputEffect) else f"{effect.key}.READING = …"
    words = [f"its keys under {code(place)}"]
    if len(effect.value_fields) == 1:
        words = [f"one value, {code(short)}, which is {code(effect.value_fields[0])}"]
        words += [f"its keys under {code(place)}"] if len(scene_keys_of(effect)) > 1 or effect.derivations else []
        can_be_true = not issubclass(effect, OutputEffect) and not any(key.is_required for key in scene_keys_of(effect).values())
        words += [f"{code(f'{effect.key} = true')}, with the default"] if can_be_true else []
    elif effect.value_fields:
        words = [f"the two ends, {code(short)}, which are {' and '.join(map(code, effect.value_fields))}"]
    common = f" Once for all readings: {', '.join(map(code, effect.common_keys))}." if effect.common_keys else ""
    return f"Written as {' or as '.join(words)}.{common}"


def _effect_rows(effect: type[Effect]) -> Iterator[list[str]]:
    defaults = {one.name: one.default for one in dataclasses.fields(effect)}
    derived = {derivation.field for derivation in effect.derivations}
    for name, key in scene_keys_of(effect).items():
        default = "" if name in derived else "required" if key.is_required else format_default(defaults[name], _schema_of(key))
        yield [code(name), _values_of(key), default, escape(key.meaning or " ".join(key.kind.split("_")))]
    for derivation in effect.derivations:
        for name, kind in derivation.kinds.items():
            yield [code(name), f"{name_kind(kind)}, positive", "", escape(derivation.meanings[name])]


def _schema_of(key: SceneKey) -> Mapping[str, object]:
    return quantity_schema(key.kind) if key.kind in QUANTITY_KINDS else {}


def _values_of(key: SceneKey) -> str:
    if key.kind == FLAG_KIND:
        return f"{code('true')} or {code('false')}"
    if key.kind == RESTITUTION_KIND or key.kind not in QUANTITY_KINDS:
        return "number"
    kinds = dict.fromkeys([key.kind, key.angle_kind or key.kind])
    sign = "" if key.sign == "any" else f", {key.sign}"
    return f"{' or '.join(map(name_kind, kinds))}{sign}{', or a function' if key.is_program else ''}"


def _custom_sections() -> Iterator[str]:
    """Yield the tables of a custom machine."""
    text = (
        'A scene with `machine = "custom"` describes bodies, joints and forces. A point is text, `"crank.end"`, or a list, '
        '`["crank", "10 mm", 0]`, in the axes of its body. `ground` is the fixed body.'
    )
    common = tuple(SceneTable.fields_by_key())
    yield _section("A mechanism of one's own", text, keys_table(CustomSceneTable, leave_out=common))
    yield _section("`[[body]]`", keys_table(bodies.BodyTable), level=3)
    inner: dict[str, type[SceneFileTable]] = {"rod": bodies.RodTable, "disc": bodies.DiscTable, "plate": bodies.PlateTable}
    inner |= {"moments": bodies.MomentsTable, "point_masses": bodies.PointMassTable}
    for name, model in inner.items():
        yield _section(f"{code(name)} of a body", keys_table(model), level=4)
    named = f"Every joint has a {code('type')}, and may have a {code('name')}; by default it is named after its type and its bodies."
    yield _section("`[[joint]]`", named, level=3)
    yield from _sections_by_type(elements.JOINT_TABLES, "joint")
    yield _section("`[[link]]`", "A massless bar between two points.", keys_table(elements.LinkTable), level=3)
    yield _section("`[[force]]`", f"Every force has a {code('type')}, and may have a {code('name')}.", level=3)
    yield from _sections_by_type(elements.FORCE_TABLES, "force")
    rows = (
        [code(kind), sentence(model.__doc__ or ""), ", ".join(map(code, model.fields_by_key()))] for kind, model in READING_TABLES.items()
    )
    yield _section("`[readings]`", "Each reading is a table with the key of its kind.", table(("kind", "reading", "keys"), rows), level=3)
    yield _section("`[valve]`", "The slide valve that the mechanism moves.", keys_table(ValveTable), level=3)
    yield _section("`reverser` of a valve", keys_table(ReverserTable), level=4)


def _sections_by_type(models: Mapping[str, type[SceneFileTable]], kind: str) -> Iterator[str]:
    for name, model in models.items():
        if name:
            summary = _joint_summary(model)
            yield _section(f"{kind} {code(f'{name}')}", summary, keys_table(model, leave_out=("type", "name")), level=4)


def element_of(model: type[SceneFileTable]) -> Any:
    """Return what a table describes: a class, without the arguments that the table gives it."""
    element = getattr(model, "element", None)
    if isinstance(element, partial):
        element = element.args[0] if element.args else element.func
    return element


def _joint_summary(model: type[SceneFileTable]) -> str:
    """Return the first paragraph about what a table describes."""
    return " ".join((element_of(model).__doc__ or "").split("\n\n")[0].split())


JOINTS_BY_TYPE: dict[str, type[Joint]] = {name: element_of(model) for name, model in elements.JOINT_TABLES.items() if name}
"""Class of each joint by its type in a scene file."""


def _coupled_sections() -> Iterator[str]:
    """Yield the tables of a scene of several parts."""
    text = "A scene of several parts has one table `[part.NAME]` for each, with `machine` and the tables of that machine."
    yield _section("Several parts", text, keys_table(CoupledSceneTable))
    yield _section("`[load]`", "What resists the shaft of an engine.", keys_table(LoadTable), level=3)
    yield _section("`[coupling.NAME]`", f"What couples two parts; {code('type')} is one of the following.", level=3)
    for name, model in COUPLING_TABLES.items():
        summary = (model.__doc__ or "").split("\n\n")[0]
        yield _section(f"coupling {code(name)}", summary, keys_table(model, leave_out=("type",)), level=4)


def _kind_section() -> Iterable[str]:
    """Yield the kinds of quantities with their units."""
    rows = (
        [
            kind.name.partition(" ")[2],
            ", ".join(map(code, kind.units)) or "none",
            code(kind.si_unit) if kind.units else "",
            code(kind.example),
        ]
        for kind in QUANTITY_KINDS.values()
    )
    text = (
        "Text is a number with a unit: a customary one, or another of the same kind that is made of the units below, as `lbf/in`. "
        "Their full names are read too, and `/` and `per`, `^2` and `²`. Other units are refused, with the value in SI."
    )
    yield _section("Kinds of quantities", text, table(("quantity", "customary units", "bare number in", "example"), rows))
    accepted = ([kind, ", ".join(map(code, units))] for kind, units in ACCEPTED_UNITS.items())
    yield _section("Units", "Of these a unit may be made.", table(("of", "units"), accepted), level=3)

"""Reference of the scene file: every table and every key, from the models of the parser, which also make the JSON schema."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from itertools import chain

from generators.markdown import code, escape, sentence, table
from generators.splitting import Section, index_of, split_sections, write_pages
from generators.values import describe_schema, describe_table, format_default, name_kind
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.joints import JOINTS, Joint
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.scenes.custom import contacts, field_types, parts
from governor_mechanism.scenes.custom.dimensions import EQUATION, LAW
from governor_mechanism.scenes.custom.parser import ASSEMBLY, CUSTOM_TOP_LEVEL
from governor_mechanism.scenes.custom.parts import READING_TABLES, REVERSER, VALVE
from governor_mechanism.scenes.effect_tables import CROSSING
from governor_mechanism.scenes.loads import COUPLING_TABLES, LOAD, READING_FUNCTION, angle_harmonic_table, harmonic_table
from governor_mechanism.scenes.quantities import Table, quantity_schema
from governor_mechanism.scenes.schema import COUPLED_TOP_LEVEL, FREE_SPINDLE, RUN, SPINDLE, TOP_LEVEL, dimensions_table
from governor_mechanism.units.expressions import ARITHMETIC
from governor_mechanism.units.fields import Declaration, fields_of
from governor_mechanism.units.quantities import ACCEPTED_UNITS, QUANTITY_KINDS

HEADING = ("key", "values", "default", "meaning")


FOLDER, HOME = "scene_file", "reference/scene_file.md"
"""Folder of the pages of the tables, and the page that leads to them."""
OWN_MECHANISM = "A mechanism of one's own"


def scene_file_text() -> str:
    """Return all sections, of which each table's becomes a page."""
    sections = chain(
        _common_sections(), _dimension_sections(), _effect_sections(), _custom_sections(), _coupled_sections(), _kind_section()
    )
    return "\n".join(sections)


def scene_file_index() -> str:
    """Return the list of the pages, from the folder docs/reference."""
    return index_of(_sections(), FOLDER, "table")


def scene_file_pages() -> dict[str, str]:
    """Return the page of each table by its path, from the folder of generated pages."""
    return write_pages(_sections(), FOLDER, HOME)


def _sections() -> list[Section]:
    return [*split_sections(scene_file_text(), deeper=(OWN_MECHANISM,))]


def keys_table(own: Table, *, leave_out: tuple[str, ...] = ()) -> str:
    """Return the keys of a table of a scene file as a table."""
    return table(HEADING, describe_table(own, leave_out=leave_out))


def _section(heading: str, *paragraphs: str, level: int = 2) -> str:
    return "\n\n".join([f"{'#' * level} {heading}", *(one.strip() for one in paragraphs if one)]) + "\n"


def _common_sections() -> Iterator[str]:
    """Yield the top level and the tables that all scenes have."""
    machines = "The machine of `machine` decides which keys `[dimensions]` has; `custom` is a mechanism of bodies and joints of one's own."
    yield _section("Top level", machines, keys_table(TOP_LEVEL))
    yield _section("`[run]`", "How long and how accurately a scene runs, and what is recorded.", keys_table(RUN))
    given = "With a given speed, which may change with time and fluctuate within a turn:"
    free = "A free spindle, whose speed follows from its torque:"
    yield _section(
        "`[spindle]`", "The spindle of a machine in a turning plane.", given, keys_table(SPINDLE), free, keys_table(FREE_SPINDLE)
    )
    start = (
        "The keys are the [readings](readings.md) of the mechanism, and their rates: the rate of `arm_angle` is `arm_rate`. A value is "
        'a quantity, or `"equilibrium"`, which is the default where a machine can be in equilibrium. Rates are 0 by default.'
    )
    yield _section("`[start]`", start)
    yield _section("`[events.NAME]`", "A named crossing of a reading. Runs report it with its time.", keys_table(CROSSING))
    load = (
        "A torque, a force or a friction is a quantity; a list of `[time, value]`, with straight lines between the points and a jump "
        "where a time is given twice; sines of the time, `{ harmonics = [{ amplitude, frequency, phase }] }`; a function of a reading, "
        "with the keys below; or a list of these, which is their sum. A function has one of `table`, `gain` and `harmonics`."
    )
    harmonic = "A harmonic of the time is amplitude × sin(2π × frequency × t + phase), in loads and in the motions of drives alike."
    yield _section("Functions of time and of readings", load, keys_table(READING_FUNCTION), harmonic, keys_table(harmonic_table("torque")))
    angle_harmonic = "A harmonic of an angle is amplitude × sin(order × angle + phase)."
    yield _section("Harmonics of an angle", angle_harmonic, keys_table(angle_harmonic_table("torque")), level=3)


def _dimension_sections() -> Iterator[str]:
    """Yield the dimensions of every machine."""
    yield _section("`[dimensions]`", "A bare number is in SI; text has a unit. See the [kinds of quantities](#kinds-of-quantities).")
    for name, machine in MACHINES.items():
        plane = "The plane turns with the spindle." if machine.plane == TURNING_PLANE else "The plane is fixed."
        summary = (machine.__doc__ or "").split("\n\n")[0].replace("\n", " ")
        yield _section(code(name), f"{summary} {plane}", table(HEADING, _dimension_rows(machine)), level=3)


def _dimension_rows(machine: type[Machine]) -> Iterator[list[str]]:
    own = dimensions_table(machine)
    for name, declared in own.fields.items():
        schema = own.types[declared.form].schema_of(declared)
        default = "required" if declared.is_required else format_default(declared.default, _schema_of(declared))
        yield [code(name), describe_schema(schema), default, escape(declared.meaning)]


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
    if not fields_of(effect):
        return f"Written as {code(f'{effect.key} = true')}."
    place = f"[effects.{effect.key}]" if not issubclass(effect, OutputEffect) else f"[effects.{effect.key}.READING]"
    short = f"{effect.key} = …" if not issubclass(effect, OutputEffect) else f"{effect.key}.READING = …"
    words = [f"its keys under {code(place)}"]
    if len(effect.value_fields) == 1:
        words = [f"one value, {code(short)}, which is {code(effect.value_fields[0])}"]
        words += [f"its keys under {code(place)}"] if len(fields_of(effect)) > 1 or effect.derivations else []
        can_be_true = not issubclass(effect, OutputEffect) and not any(key.is_required for key in fields_of(effect).values())
        words += [f"{code(f'{effect.key} = true')}, with the default"] if can_be_true else []
    elif effect.value_fields:
        words = [f"the two ends, {code(short)}, which are {' and '.join(map(code, effect.value_fields))}"]
    common = f" Once for all readings: {', '.join(map(code, effect.common_keys))}." if effect.common_keys else ""
    return f"Written as {' or as '.join(words)}.{common}"


def _effect_rows(effect: type[Effect]) -> Iterator[list[str]]:
    derived = {derivation.field for derivation in effect.derivations}
    for name, declared in fields_of(effect).items():
        default = "required" if declared.is_required else format_default(declared.default, _schema_of(declared))
        default = "" if name in derived else default
        yield [code(name), _values_of(declared), default, escape(declared.meaning or " ".join(declared.kind.split("_")))]
    for derivation in effect.derivations:
        for name, kind in derivation.kinds.items():
            yield [code(name), f"{name_kind(kind)}, positive", "", escape(derivation.meanings[name])]


def _schema_of(declared: Declaration) -> Mapping[str, object]:
    return quantity_schema(declared.kind) if declared.kinds else {}


def _values_of(declared: Declaration) -> str:
    if declared.form == "flag":
        return f"{code('true')} or {code('false')}"
    if not declared.kinds:
        return "number"
    kinds = dict.fromkeys(declared.kinds)
    sign = "" if declared.sign == "any" else f", {declared.sign}"
    return f"{' or '.join(map(name_kind, kinds))}{sign}{', or a function' if declared.form == 'load' else ''}"


def _custom_sections() -> Iterator[str]:
    """Yield the tables of a custom machine."""
    text = (
        'A scene with `machine = "custom"` describes bodies, joints and forces. A point is text, `"crank.end"`, or a list, '
        '`["crank", "10 mm", 0]`, in the axes of its body. `ground` is the fixed body.'
    )
    common = tuple(TOP_LEVEL.fields)
    yield _section(OWN_MECHANISM, text, keys_table(CUSTOM_TOP_LEVEL, leave_out=common))
    yield _section("`[[body]]`", "A rigid body, by its shape or by its mass and inertia.", keys_table(parts.BODY), level=3)
    inner = {"rod": parts.ROD, "disc": parts.DISC, "plate": parts.PLATE}
    inner |= {"moments": parts.MOMENTS, "point_masses": parts.POINT_MASS}
    for name, model in inner.items():
        yield _section(f"{code(name)} of a body", keys_table(model), level=4)
    named = f"Every joint has a {code('type')}, and may have a {code('name')}; by default it is named after its type and its bodies."
    yield _section("`[[joint]]`", named, level=3)
    yield from _sections_by_type(parts.JOINT_TABLES, "joint")
    yield _section("`[[link]]`", "A massless bar between two points.", keys_table(parts.LINK), level=3)
    yield _section("`[[force]]`", f"Every force has a {code('type')}, and may have a {code('name')}.", level=3)
    yield from _sections_by_type(parts.FORCE_TABLES, "force")
    contact = "A roller of a body touches the outline of another one, and may leave it. The gap between them is the reading `NAME_gap`."
    yield _section("`[[contact]]`", contact, keys_table(contacts.CONTACT), level=3)
    yield _section("`outline` of a body with equal teeth or slots", keys_table(contacts.REPEATED_CORNERS), level=4)
    yield _section("`outline` of a body along a closed curve", keys_table(contacts.CURVE_OUTLINE), level=4)
    yield _section("`lifts` of a curve", keys_table(field_types.LIFT), level=4)
    rows = ([code(kind), sentence(own.summary), ", ".join(map(code, own.fields_by_key))] for kind, own in READING_TABLES.items())
    yield _section("`[readings]`", "Each reading is a table with the key of its kind.", table(("kind", "reading", "keys"), rows), level=3)
    dimensions = (
        'Quantities by name, as `crank = "100 mm"`; a bare number is a plain number. A text that begins with `=` is an expression of them, '
        'as `"= 2 * crank + 10 mm"`, here and wherever a part of the scene has a quantity. It has numbers, which may have a unit of one '
        f"word, names, `+ - * / ^`, brackets, `pi` and {', '.join(map(code, ARITHMETIC))}. Units must fit; angles count in radians."
    )
    yield _section("`[dimensions]` of one's own", dimensions, level=3)
    law = (
        "What the mechanism proves, with `governor-mechanism crosscheck`. An equation of `proves` holds at every position of the travel; "
        "its sides are expressions of readings and dimensions. Besides the functions above they have functions of a reading: `rate`, its "
        "derivative by the driving reading; `spread`, `lowest` and `highest` over the whole travel; and `time_ratio`, the longer way "
        "between its two extremes, relative to the shorter one, over a whole turn."
    )
    yield _section("`[law]`", law, keys_table(LAW), level=3)
    yield _section("an equation of a law", keys_table(EQUATION), level=4)
    choice = "Which way of closing the joints is taken, where others than the first given angles hold the mechanism:"
    yield _section("`assembly` as a table", choice, keys_table(ASSEMBLY), level=3)
    yield _section("`[valve]`", "The slide valve that the mechanism moves.", keys_table(VALVE), level=3)
    yield _section("`reverser` of a valve", keys_table(REVERSER), level=4)


def _sections_by_type(tables: Mapping[str, parts.ElementTable], kind: str) -> Iterator[str]:
    for name, own in tables.items():
        summary = " ".join((own.make.__doc__ or "").split("\n\n")[0].split())
        yield _section(f"{kind} {code(f'{name}')}", summary, keys_table(own, leave_out=("type", "name")), level=4)


JOINTS_BY_TYPE: dict[str, type[Joint]] = {joint.type_name: joint for joint in JOINTS if joint.type_name}
"""Class of each joint by its type in a scene file."""


def _coupled_sections() -> Iterator[str]:
    """Yield the tables of a scene of several parts."""
    text = "A scene of several parts has one table `[part.NAME]` for each, with `machine` and the tables of that machine."
    yield _section("Several parts", text, keys_table(COUPLED_TOP_LEVEL))
    yield _section("`[load]`", "What resists the shaft of an engine.", keys_table(LOAD), level=3)
    yield _section("`[coupling.NAME]`", f"What couples two parts; {code('type')} is one of the following.", level=3)
    for name, own in COUPLING_TABLES.items():
        yield _section(f"coupling {code(name)}", own.summary, keys_table(own, leave_out=("type",)), level=4)


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

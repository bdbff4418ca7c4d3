"""Scene files to begin with: what a machine needs, with values that run, and, commented out, what it may have."""

import math
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any, Final

from governor_mechanism.effects.holding import Clearance
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.part import EQUILIBRIUM, Part
from governor_mechanism.model.scene import ENGINE_CHOICES
from governor_mechanism.scenes.changed_document import format_toml_value
from governor_mechanism.scenes.effect_tables import SLEEVE_ALIAS, SLEEVE_LIFT_NAME, effect_example
from governor_mechanism.scenes.library import catalogue_scenes, models_folder
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.scenes.schema import rate_key
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS, format_quantity

CUSTOM_TEMPLATE = """\
title = "My four-bar linkage"
machine = "custom"
# plane = "turning"                        # the mechanism turns with a spindle; needs [spindle]. Otherwise the plane is fixed
# size = "300 mm"                          # length to which accuracy refers; by default it follows from the points

[ground]                                   # points of the fixed plane
shaft = [0, 0]
pivot = ["300 mm", 0]

[[body]]
name = "crank"
mass = "1 kg"
rod = { length = "100 mm" }                # points start, centre, end; also disc, plate, point = true, or inertia and centre
angle = "60 deg"                           # where it is at the start; with a guess it is assembled
# at = [0, 0]                              # the origin of the body at the start
# points = { pin = ["50 mm", 0] }          # points of one's own, in the axes of the body

[[body]]
name = "coupler"
mass = "2 kg"
rod = { length = "280 mm" }
at = ["50 mm", "86.6 mm"]
angle = "20 deg"

[[body]]
name = "rocker"
mass = "1.5 kg"
rod = { length = "200 mm" }
at = ["300 mm", 0]
angle = "85 deg"

[[joint]]                                  # pin, weld, prismatic, slider, arc, curve, gear, rack, driven_turn, driven_slide
type = "pin"
first = "ground.shaft"
second = "crank.start"

[[joint]]
type = "pin"
first = "crank.end"
second = "coupler.start"

[[joint]]
type = "pin"
first = "coupler.end"
second = "rocker.end"

[[joint]]
type = "pin"
first = "ground.pivot"
second = "rocker.start"

# [[joint]]                                # a motor in place of [start]
# type = "driven_turn"
# first = "ground"
# second = "crank"
# rate = "60 rpm"

# [[link]]                                 # a massless bar between two points
# first = "crank.end"
# second = "rocker.end"
# length = "280 mm"

[[force]]                                  # spring, damper, torsion_spring, torsion_damper, torque, force
type = "torsion_damper"
name = "bearing"
second = "rocker"
damping = "0.05 N m s/rad"

# [[force]]
# type = "spring"
# first = "ground.shaft"
# second = "rocker.end"
# stiffness = "2 N/mm"
# free_length = "250 mm"

[readings]                                 # what the results report; forces along readings are effects
crank_angle = { angle = "crank" }
rocker_angle = { angle = "rocker" }
end_height = { y = "coupler.end" }
# span = { distance = ["ground.shaft", "rocker.end"] }
# lean = { line = ["crank.end", "rocker.end"] }

[effects]                                  # only what is listed here is simulated
gravity = true
# dry_friction = { crank_angle = "0.1 N m" }
# dashpot = { crank_angle = "0.1 N m s/rad" }
# stops = { rocker_angle = ["60 deg", "120 deg"], restitution = 0.3 }

[start]
crank_angle = "60 deg"
# crank_rate = "10 rad/s"

[run]
duration = "3 s"
output_interval = "10 ms"                  # interval of the reported times
accuracy = 1e-6                            # largest error, relative to the scale of each reading
# engine = "auto"                          # one of auto, impulse, multibody, reduced

# [events]                                 # named moments at which a reading passes a value
# passed = { reading = "crank_angle", value = "0 deg", direction = "down" }
"""
"""Text of the scene file."""


GOVERNED_ENGINE: Final = "governed-engine"
"""Name of the template of an engine under its governor, two coupled parts."""

_EXAMPLES: Final = {
    "pendulum_governor": "porter",
    "parabolic_governor": "parabolic",
    "proell": "proell",
    "hartnell": "hartnell",
    "hartung": "hartung_dubois",
    "slide_valve": "slide_valve_30",
    "slider_crank": "slider_crank",
    "stephenson": "stephenson_arc_middle",
    "flywheel_engine": "air_engine",
    GOVERNED_ENGINE: "governed_engine",
}
"""Shipped scene from which a template takes its values."""

TEMPLATE_NAMES: Final = (*sorted([*_EXAMPLES, CUSTOM_MACHINE]),)
"""Names of the templates: the machines, and an engine under its governor."""

SCHEMA_LINE: Final = "#:schema ../scene.schema.json\n"
"""First line of the files of the catalogue, which is wrong in another folder."""

COMMENT_COLUMN: Final = 44
"""Column at which comments begin behind a value, if it is not longer."""

_EVENTS_COMMENT: Final = "named moments at which a reading passes a value"

_HEADER: Final = """\
# Run this file with: governor-mechanism run mine.toml
# Numbers are in SI; a text is a number with its unit, as "300 mm". A key behind # may be added.
# Editors complete and check scene files that name the schema, written by `governor-mechanism schema > scene.schema.json`:
# put `#:schema ./scene.schema.json` into the first line.
"""


def scene_template(machine: str) -> str:
    """Return a scene file to begin with, with comments; raise MechanismError if there is no machine of that name."""
    by_word = {name.replace("-", "_"): name for name in TEMPLATE_NAMES}
    name, classic = by_word.get(machine.replace("-", "_")), catalogue_scenes()
    if machine in classic:
        return _HEADER + classic[machine].read_text(encoding="utf-8").removeprefix(SCHEMA_LINE)
    if name is None:
        known = f"The machines are {', '.join(TEMPLATE_NAMES)}; `governor-mechanism catalogue` lists the classic mechanisms."
        raise MechanismError(f"no machine {machine!r}.{did_you_mean(machine, [*TEMPLATE_NAMES, *classic])} {known}")
    if name == CUSTOM_MACHINE:
        return _HEADER + CUSTOM_TEMPLATE
    document = tomllib.loads((models_folder() / f"{_EXAMPLES[name]}.toml").read_text(encoding="utf-8"))
    return _HEADER + "\n".join(_document_lines(document, f"My {name.replace('_', ' ').replace('-', ' ')}")) + "\n"


def _document_lines(document: Mapping[str, Any], title: str) -> Iterator[str]:
    """Yield the lines of a scene file with the values of a document."""
    scene = parse_scene_document(document)
    yield f"title = {format_toml_value(title)}"
    if "part" not in document:
        yield from _part_lines(document, scene.part, "")
    else:
        yield from _table_lines("load", document.get("load", {}))
        for part in scene.parts:
            yield f"\n[part.{part.name}]"
            yield from _part_lines(document["part"][part.name], part, f"part.{part.name}.")
        for name, table in document["coupling"].items():
            yield from _table_lines(f"coupling.{name}", table)
    yield from _run_lines(document.get("run", {}))
    reading = scene.mechanism.readings[0]
    if "events" in document:
        yield from _table_lines("events", document["events"], _EVENTS_COMMENT)
    else:
        value = QUANTITY_KINDS[reading.quantity].example
        yield "\n" + _with_comment("# [events]", _EVENTS_COMMENT)
        yield f'# passed = {{ reading = "{reading.name}", value = "{value}", direction = "up" }}'


def _part_lines(table: Mapping[str, Any], part: Part, prefix: str) -> Iterator[str]:
    """Yield the lines of one part: its machine, dimensions, effects, spindle and start."""
    machine_class = MACHINES[part.machine]
    yield f'machine = "{part.machine}"'
    yield f"\n[{prefix}dimensions]"
    yield from _dimension_lines(machine_class, table["dimensions"], part)
    yield "\n" + _with_comment(f"[{prefix}effects]", "only what is listed here is simulated")
    yield from _effect_lines(machine_class, table.get("effects", {}), part)
    yield from _spindle_lines(table.get("spindle", {}), part, prefix)
    yield from _start_lines(table.get("start", {}), part, prefix)


def _dimension_lines(machine_class: type[Machine], given: Mapping[str, Any], part: Part) -> Iterator[str]:
    """Yield the given dimensions, and commented out those that may be added, with the value that stands for them if there is one."""
    for name, declared in fields_of(machine_class).items():
        meaning = declared.kind_and_meaning
        if name in given:
            yield _line(name, given[name], meaning)
        elif declared.form == "choice":
            yield _line(f"# {name}", declared.words[0], f"{meaning}: {', '.join(declared.words)}")
        else:
            yield _line(f"# {name}", _shown_value(part.dimensions.get(name, math.inf), declared.kind), meaning)


def _shown_value(value: float, kind: str) -> float | str:
    """Return a value as a scene file has it, with a customary unit; an example in place of an infinite one, which is left out."""
    unit, example = QUANTITY_KINDS[kind].si_unit, QUANTITY_KINDS[kind].example
    if math.isinf(value):
        return example if unit else float(example)
    return format_quantity(value, unit) if unit else value


def _effect_lines(machine_class: type[Machine], given: Mapping[str, Any], part: Part) -> Iterator[str]:
    """Yield the given effects, and commented out those that the machine supports."""
    yield from (_line(key, value) for key, value in given.items())
    for effect in EFFECTS:
        supported = effect in machine_class.supported_effects or not (effect.changes_bodies_of or effect is Clearance)
        turns = part.turns or not effect.loads_turning_bodies
        if effect.key not in given and supported and turns:
            yield _with_comment(f"# {effect.key} = {_example_of(effect, part.mechanism)}", _summary_of(effect))


def _example_of(effect: type[Effect], mechanism: Mechanism) -> str:
    """Return a valid value of an effect, as TOML; one along readings acts on the sleeve or the leading coordinate."""
    if issubclass(effect, OutputEffect):
        names = [reading.name for reading in mechanism.readings]
        reading = mechanism.reading(SLEEVE_LIFT_NAME if SLEEVE_LIFT_NAME in names else mechanism.coordinate)
        name = SLEEVE_ALIAS if reading.name == SLEEVE_LIFT_NAME else reading.name
        return f"{{ {name} = {effect_example(effect, reading.quantity)} }}"
    declared = fields_of(effect).values()
    is_switch = bool(effect.value_fields) and not any(one.is_required for one in declared)
    return "true" if is_switch or not declared else effect_example(effect, "")


def _summary_of(effect: type[Effect]) -> str:
    """Return the first sentence of the docstring of an effect."""
    return (effect.__doc__ or "").split("\n")[0].split(". ")[0].rstrip(".")


def _spindle_lines(given: Mapping[str, Any], part: Part, prefix: str) -> Iterator[str]:
    """Yield the spindle, and commented out a free one in its place; nothing for a machine in a fixed plane."""
    if not part.turns or not given:
        return
    yield from _table_lines(f"{prefix}spindle", given)
    yield _with_comment('# speed = [[0, "120 rpm"], [5, "126 rpm"]]', "a program of [time, speed] in place of one speed")
    yield _with_comment('# inertia = "0.5 kg m^2"', "a free spindle in place of speed, with start_speed and torque")
    yield '# start_speed = "120 rpm"'
    yield '# torque = "0 N m"'


def _start_lines(given: Mapping[str, Any], part: Part, prefix: str) -> Iterator[str]:
    """Yield the start, and commented out the rate; nothing for a machine whose drive determines it."""
    if not given:
        return
    yield from _table_lines(f"{prefix}start", given)
    coordinate = part.mechanism.coordinate
    rate = rate_key(coordinate)
    if rate not in given:
        example = "0 rad/s" if part.mechanism.reading(coordinate).quantity == "angle" else "0 m/s"
        yield f'# {rate} = "{example}"'
    if part.turns and given.get(coordinate) != EQUILIBRIUM:
        yield _with_comment(f'# {coordinate} = "{EQUILIBRIUM}"', "in place of a value")


def _run_lines(given: Mapping[str, Any]) -> Iterator[str]:
    """Yield the settings of a run, and commented out the engine."""
    meanings = {"output_interval": "interval of the reported times", "accuracy": "largest error, relative to the scale of each reading"}
    yield "\n[run]"
    yield from (_line(key, value, meanings.get(key, "")) for key, value in given.items())
    if "engine" not in given:
        yield _with_comment('# engine = "auto"', f"one of {', '.join(ENGINE_CHOICES)}")


def _table_lines(heading: str, table: Mapping[str, Any], comment: str = "") -> Iterator[str]:
    if table:
        yield "\n" + _with_comment(f"[{heading}]", comment)
        yield from (_line(key, value) for key, value in table.items())


def _line(key: str, value: Any, comment: str = "") -> str:
    """Return a key with its value, and a comment."""
    return _with_comment(f"{key} = {format_toml_value(value)}", comment)


def _with_comment(text: str, comment: str) -> str:
    return f"{text.ljust(COMMENT_COLUMN - 2)}  # {comment}" if comment else text

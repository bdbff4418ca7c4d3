"""Scenes with a custom machine: bodies, joints, forces, readings, and which of the ways in which its joints close."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import Any, Final, NoReturn

import numpy as np

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.machines.custom import CUSTOM_MACHINE, MechanismSketch, SketchedBody
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints import GROUND, Joint
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.motion_readings import RUN_KINDS
from governor_mechanism.model.output_variables import Reading
from governor_mechanism.model.part import FIXED_PLANE, TURNING_PLANE, Law, Part, Start
from governor_mechanism.model.valve import Valve
from governor_mechanism.observables.closed_configurations import ClosedConfigurations, enumerate_configurations
from governor_mechanism.observables.constraint_blocks import hold_needed_angles, hold_values
from governor_mechanism.scenes.custom.contacts import CONTACT, find_name_conflicts
from governor_mechanism.scenes.custom.dimensions import Dimension, DimensionTable, parse_law
from governor_mechanism.scenes.custom.field_types import PointRegistry, is_moving, parse_moving_point, parse_named_points
from governor_mechanism.scenes.custom.parts import (
    BODY,
    FORCE_TABLES,
    JOINT_TABLES,
    LINK,
    READING_TABLES,
    UNTYPED_FORCE,
    UNTYPED_JOINT,
    find_reading_kind,
    make_default_readings,
    parse_valve,
)
from governor_mechanism.scenes.quantities import VALUE_TYPES, Table, ValueType, nearest_type, parse_name, without_context
from governor_mechanism.scenes.schema import COMMON_FIELDS, TOP_LEVEL_TYPES, parse_start, rate_key, unknown_top_level_key
from governor_mechanism.units.fields import declare, entry
from governor_mechanism.units.problems import ProblemCode, ProblemCollector, mistake, wrong_value
from governor_mechanism.units.quantities import format_quantity, format_value

HIGHEST: Final = "highest"
NEAREST: Final = "nearest"
"""Words that choose an assembly, beside its number."""

AS_WRITTEN_TOLERANCE: Final = 1e-9
"""Difference of the chosen poses from the written ones, length scales and rad, below which these are kept as they are."""

Take = int | str
"""Number of an assembly, from 1, or one of the words."""


def parse_take(value: object) -> Take:
    """Return the number of an assembly or a word; refuse anything else."""
    is_number = isinstance(value, int) and not isinstance(value, bool) and value > 0
    if not is_number and value not in (HIGHEST, NEAREST):
        hint = f'a number from 1, "{HIGHEST}", or "{NEAREST}" to the given positions and angles'
        raise wrong_value(value, f"must be {hint}", "; the command assemblies lists them")
    return value  # type: ignore[return-value]


_TAKE_SCHEMA: Final[dict[str, Any]] = {"anyOf": [{"type": "integer", "minimum": 1}, {"enum": [HIGHEST, NEAREST]}]}


@dataclass(frozen=True, kw_only=True)
class WrittenAssembly:
    """The choice of an assembly, and the bodies whose angles are given where neither drives nor start values determine the mechanism."""

    take: Take = entry("take", meaning='the number of the assembly, "highest" or "nearest"')
    at: tuple[str, ...] = entry(
        "names", default=(), meaning="the bodies whose angles hold a free mechanism; by default the first of the file"
    )


ASSEMBLY: Final = Table.of(
    WrittenAssembly, types={"take": without_context(parse_take, _TAKE_SCHEMA), "names": VALUE_TYPES["names"]}, example="{ take = 2 }"
)
"""The key `assembly` as a table."""


def _parse_assembly(value: object) -> WrittenAssembly:
    if isinstance(value, Mapping):
        written: WrittenAssembly = ASSEMBLY.build(value)
        return written
    return WrittenAssembly(take=parse_take(value))


ASSEMBLY_TYPE: Final[ValueType] = without_context(_parse_assembly, {"anyOf": [*_TAKE_SCHEMA["anyOf"], ASSEMBLY.schema()]})
"""How the key is written: a number, a word, or a table."""


def hold_given_values(
    mechanism: Mechanism,
    start: Start,
    given_angles: Mapping[str, float],  # angles that the file writes, by body, rad
    at: tuple[str, ...] = (),
) -> tuple[Mechanism, list[str]]:
    """Return a mechanism that is held where drives, start values and given angles determine it, and in words what holds it."""
    words = [name for name, value in start.values.items() if isinstance(value, str)]
    if words:
        raise MechanismError(f"the assemblies at start.{words[0]} = {start.values[words[0]]!r} are not listed; give a number")
    values = {name: float(value) for name, value in start.values.items()}
    names = [body.name for body in mechanism.bodies]
    if unknown := next((name for name in at if name not in names), ""):
        raise MechanismError(
            f"assembly.at names the unknown body {unknown!r}; bodies are {', '.join(names)}.{did_you_mean(unknown, names)}"
        )
    angles = {body.name: pose[2] for body, pose in zip(mechanism.bodies, mechanism.initial_guess, strict=True) if body.can_rotate}
    order = [name for name in at or given_angles if name in angles]
    held, bodies = hold_needed_angles(hold_values(mechanism, values), [(name, angles[name]) for name in order])
    return held, [
        *(f"{name} = {format_quantity(value, _unit_of(mechanism, name))}" for name, value in values.items()),
        *(f"{name} at {format_quantity(angles[name], 'rad')}" for name in bodies),
    ]


def _unit_of(mechanism: Mechanism, name: str) -> str:
    return "rad" if mechanism.reading(name).quantity == "angle" else "m"


def take_assembly(mechanism: Mechanism, written: WrittenAssembly, start: Start, given_angles: Mapping[str, float]) -> Mechanism:
    """Return a mechanism whose initial configuration is the chosen assembly, with a note if a word and no number chose one of several."""
    held, held_by = hold_given_values(mechanism, start, given_angles, written.at)
    solver = PositionSolver(held)
    configurations = enumerate_configurations(solver)
    count = len(configurations.poses)
    if not count:
        explain_no_assembly(solver)
    index = choose_configuration(configurations, written.take, solver.initial_guess)
    notes = (
        *mechanism.notes,
        *([_note(configurations, index, written.take, held_by)] if isinstance(written.take, str) and count > 1 else []),
    )
    poses = configurations.poses[index]
    if np.max(np.abs(poses - solver.initial_guess) / solver.pose_scales) < AS_WRITTEN_TOLERANCE:
        return replace(mechanism, notes=notes)
    return replace(mechanism, notes=notes, initial_guess=tuple((x, y, angle) for x, y, angle in poses.tolist()))


def find_nearest_number(
    document: Mapping[str, Any],
    part: Part,
    start: Start,
    poses: Any,  # poses (bodies, 3) to which the assembly is nearest, m and rad
) -> int:
    """Return the number of the assembly of a scene that is nearest to some poses."""
    written = document.get("assembly")
    at = tuple(written.get("at", ())) if isinstance(written, Mapping) else ()
    held, _ = hold_given_values(part.mechanism, start, written_angles(document, part.mechanism), at)
    return enumerate_configurations(PositionSolver(held)).find_nearest(np.array(poses)) + 1


def written_angles(document: Mapping[str, Any], mechanism: Mechanism) -> dict[str, float]:
    """Return the initial angles of the bodies whose tables write them, by name, rad."""
    written = {table.get("name") for table in document.get("body", ()) if isinstance(table, Mapping) and "angle" in table}
    return {body.name: pose[2] for body, pose in zip(mechanism.bodies, mechanism.initial_guess, strict=True) if body.name in written}


def explain_no_assembly(solver: PositionSolver) -> NoReturn:
    """Raise MechanismError with the joint that stays open."""
    solver.solve({})
    raise MechanismError("the joints close in no way at the start; change a length or a given value")


def choose_configuration(configurations: ClosedConfigurations, take: Take, guess: Any) -> int:
    """Return the index of an assembly; raise MechanismError for a number above theirs."""
    count = len(configurations.poses)
    if isinstance(take, str):
        return configurations.find_highest() if take == HIGHEST else configurations.find_nearest(guess)
    if take > count:
        ways = "one way" if count == 1 else f"{count} ways"
        found = "" if configurations.complete else " that were found"
        raise MechanismError(f"there is no assembly {take} of {count}: the joints close in {ways}{found} at the start; give 1 to {count}")
    return take - 1


def _note(configurations: ClosedConfigurations, index: int, take: str, held_by: list[str]) -> str:
    """Return the sentence about several assemblies, of which a word chose one."""
    count = len(configurations.poses)
    at_least = "" if configurations.complete else "at least "
    reason = "the highest" if take == HIGHEST else "the nearest to what is given"
    where = f" with {' and '.join(held_by)}" if held_by else ""
    return (
        f"the joints close in {at_least}{count} ways{where}: assembly {index + 1}, {reason}, is taken; "
        f"assembly = 1 to {count} chooses another, and the command assemblies draws them and says how far a motor turns in each"
    )


CUSTOM_PART_NAME = "mechanism"
"""Name of the only part."""


CUSTOM_TOP_LEVEL: Final = Table(
    make=dict,
    fields={
        **COMMON_FIELDS,
        "size": declare(
            "quantity",
            "length",
            built=True,
            default=0.0,
            meaning="the length to which accuracy and tolerances are relative; by default that of the bodies",
        ),
        "plane": declare(
            "choice",
            words=(FIXED_PLANE, TURNING_PLANE),
            default="",
            meaning="whether the plane turns with a spindle; turning by default if there is a [spindle]",
        ),
        "ground": declare("table", default=None, meaning='points of the ground by name, as O = [0, "100 mm"]'),
        "body": declare("tables", meaning="the moving parts, one table [[body]] for each"),
        "joint": declare("tables", default=None, meaning="the joints, one table [[joint]] for each"),
        "link": declare("tables", default=None, meaning="massless bars, one table [[link]] for each"),
        "force": declare("tables", default=None, meaning="springs, dampers, torques and forces, one table [[force]] for each"),
        "contact": declare("tables", default=None, meaning="rollers that touch outlines, one table [[contact]] for each"),
        "readings": declare("table", default=None, meaning="what is read off the mechanism, by name; by default angles of bodies"),
        "valve": declare("table", default=None, meaning="the slide valve that the mechanism moves, for its timing"),
        "assembly": declare(
            "assembly",
            default=None,
            meaning='which of the ways in which the joints close is taken: its number, "highest", or "nearest" to what is given; '
            "by default that to which the given positions and angles lead",
        ),
        "dimensions": declare("table", default=None, meaning='quantities by name, for texts such as "= 2 * crank" anywhere in the scene'),
        "law": declare("table", default=None, meaning="what the mechanism proves, as equations of readings and dimensions"),
    },
    types={**TOP_LEVEL_TYPES, "assembly": ASSEMBLY_TYPE},
    unknown_key=unknown_top_level_key,
)
"""The top level of a scene file with a custom machine."""


class CustomMachineParser:
    """Parser of one document; `top_level` is None if the keys above the tables have mistakes."""

    def __init__(
        self,
        document: Mapping[str, Any],  # with expressions that know their values
        top_level: Mapping[str, Any] | None,
        collector: ProblemCollector,
        dimensions: DimensionTable | None = None,
    ) -> None:
        self.document = document
        self.top_level = top_level
        self.collector = collector
        self.dimensions = dimensions or DimensionTable({})
        self.n_foreign_problems = len(collector.problems)
        plane = document.get("plane")
        plane = plane if plane in (FIXED_PLANE, TURNING_PLANE) else TURNING_PLANE if "spindle" in document else FIXED_PLANE
        self.registry = PointRegistry(plane)
        self.registry.used_names |= {name for key in ("joint", "link", "force") for name in self._names_under(key)}

    @property
    def has_problems(self) -> bool:
        """Whether a table of the machine has a mistake, or may be missing because its heading is misspelt."""
        n_own_problems = len(self.collector.problems) - self.n_foreign_problems
        return self.top_level is None or self.dimensions.has_failed or n_own_problems > 0

    def parse(self) -> tuple[Part | None, Start, tuple[Reading, ...] | None]:
        """Return the part, or None if there are mistakes, the start, and the readings, or None if not all are known."""
        sketch = self.parse_sketch()
        self._check_sketch(sketch)
        readings, are_all_known = self._parse_readings(list(sketch.bodies[: len(sketch.bodies) - len(self.registry.moving_points)]))
        conflicts = find_name_conflicts(sketch.gaps, [reading.name for reading in readings])
        self.collector.add(ProblemCode.DUPLICATE, *conflicts, key="contact")
        readings = [*readings, *sketch.gaps]
        start = self._parse_start(readings)
        length_scale = (self.top_level and self.top_level.get("size")) or sketch.length_scale
        if not length_scale and not self.has_problems:
            text = 'size is missing: the initial configuration has no length that could be the length scale; write size = "1 m"'
            self.collector.add(ProblemCode.MISSING_KEY, text, key="size")
        known_readings = tuple(readings) if readings and are_all_known else None
        valve = self._parse_valve(known_readings, sketch.joints)
        dimensions = self.dimensions.read_all(self.collector)
        law = self._parse_law(known_readings, dimensions)
        if self.has_problems:
            return None, start, known_readings
        part = self.collector.attempt("", self._build_part, sketch, readings, length_scale, valve, start)
        values = {name: float(one.measured.value) for name, one in dimensions.items()}
        return part and replace(part, dimensions=values, law=law), start, known_readings

    def _parse_law(self, readings: tuple[Reading, ...] | None, dimensions: Mapping[str, Dimension]) -> Law | None:
        """Return the law, if there is one; anything but a table is reported with the top level."""
        table = self.document.get("law")
        return (
            self.collector.attempt("law", parse_law, table, readings, dimensions, self.dimensions) if isinstance(table, Mapping) else None
        )

    def parse_sketch(self) -> MechanismSketch:
        """Return the bodies, joints and forces without mistakes of their own; what they make together is not checked."""
        drivers = self._parse_ground()
        bodies = self._parse_bodies()
        joints = [*self._parse_tables("joint", {"": UNTYPED_JOINT, **JOINT_TABLES})]
        joints += [*self._parse_tables("link", {"": LINK}), *drivers]
        # The drivers connect the moving points of the ground to it.
        all_bodies = [*bodies, *self.registry.moving_points.values()]
        forces = self._parse_tables("force", {"": UNTYPED_FORCE, **FORCE_TABLES})
        gaps = list(chain.from_iterable(self._parse_tables("contact", {"": CONTACT})))
        return MechanismSketch(bodies=all_bodies, joints=joints, force_elements=forces, ground=self.registry.ground, gaps=gaps)

    def _build_part(self, sketch: MechanismSketch, readings: list[Reading], length_scale: float, valve: Valve | None, start: Start) -> Part:
        mechanism = sketch.build(readings, _leading_coordinate(self.document.get("start"), readings), length_scale, valve)
        assembly = self.top_level.get("assembly") if self.top_level else None
        if assembly is not None:
            mechanism = take_assembly(mechanism, assembly, start, written_angles(self.document, mechanism))
        return Part(name=CUSTOM_PART_NAME, machine=CUSTOM_MACHINE, dimensions={}, mechanism=mechanism, plane=self.registry.plane)

    def _tables_under(self, key: str) -> list[Any]:
        """Return the tables under a heading; anything but a list is reported with the top level."""
        given = self.document.get(key, [])
        return list(given) if isinstance(given, list | tuple) else []

    def _names_under(self, key: str) -> set[str]:
        """Return the names as written in the tables under a heading."""
        names = (values.get("name") for values in self._tables_under(key) if isinstance(values, Mapping))
        return {name for name in names if isinstance(name, str)}

    def _parse_tables(self, key: str, tables: Mapping[str, Table]) -> list[Any]:
        """Return what the tables under a heading, with a table by type, describe, without those with mistakes."""
        elements = []
        for number, values in enumerate(self._tables_under(key), start=1):
            name = values.get("name") if isinstance(values, Mapping) else None
            with self.collector.at(f"{key} {format_value(name) if isinstance(name, str) and name else number}:"):
                elements.append(tables[nearest_type(values, tables)].build(values, self.registry))
        return elements

    def _parse_ground(self) -> list[Joint]:
        """Parse the points of the ground and return the drivers of those that move."""
        given = self.document.get("ground", {})
        n_problems = len(self.collector.problems)
        self.registry.invalid_bodies.add(GROUND)
        if not isinstance(given, Mapping):
            return []
        moving = {name: position for name, position in given.items() if is_moving(position)}
        resting = {name: position for name, position in given.items() if name not in moving}
        self.registry.ground |= self.collector.attempt(GROUND, parse_named_points, resting) or {}
        drivers = self.collector.parse_tables(GROUND, moving, self._parse_moving_point)
        if len(self.collector.problems) == n_problems and not self.dimensions.has_failed:
            self.registry.invalid_bodies.remove(GROUND)
        return list(chain.from_iterable(drivers))

    def _parse_moving_point(self, name: str, position: object) -> list[Joint]:
        """Parse a moving point of the ground and return its drivers."""
        parse_name(name, "the name of a point")
        self.registry.moving_points[name], drivers = parse_moving_point(f"{GROUND}.{name}", position)
        return drivers

    def _parse_bodies(self) -> list[SketchedBody]:
        if "body" in self.document and self.document["body"] in ([], ()):
            self.collector.add(ProblemCode.MISSING_KEY, "body is an empty list; a mechanism needs at least one [[body]]", key="body")
        bodies: list[SketchedBody] = self._parse_tables("body", {"": BODY})
        self.registry.bodies = {body.name: body for body in bodies}
        self.registry.invalid_bodies |= self._names_under("body") - set(self.registry.bodies)
        return bodies

    def _check_sketch(self, sketch: MechanismSketch) -> None:
        """Report names that occur twice, drivers in conflict, and bodies without connection to the ground."""
        groups = {"body": [body.name for body in sketch.bodies], "joint or link": [joint.name for joint in sketch.joints]}
        groups["force"] = [element.name for element in sketch.force_elements]
        for kind, counts in ((kind, Counter(group)) for kind, group in groups.items()):
            texts = [f"{kind} {name!r} is defined {count} times; names must differ" for name, count in counts.items() if count > 1]
            self.collector.add(ProblemCode.DUPLICATE, *texts, key=kind)
        for first, second in sketch.conflicting_drivers:
            text = f"joints {first.name!r} and {second.name!r} drive the same two bodies, {first.first.body!r} and {first.second.body!r}"
            self.collector.add(ProblemCode.CONFLICT, f"{text}; leave one of them out", key="joint")
        # A table with a mistake may be the one that connects a body.
        unconnected = [] if self.has_problems else sketch.unconnected_bodies
        if unconnected:
            noun = "body" if len(unconnected) == 1 else "bodies"
            names = ", ".join(map(repr, unconnected))
            text = f"nothing connects {noun} {names} to the ground: no chain of joints, links, springs or dampers"
            self.collector.add(ProblemCode.MISSING_KEY, f"{text}; add a [[joint]] or a [[link]]", key="body")

    def _parse_readings(self, bodies: list[SketchedBody]) -> tuple[list[Reading], bool]:
        """Return the readings, and whether there is one for each entry of the file."""
        table = self.document.get("readings")
        if not table or not isinstance(table, Mapping):
            return make_default_readings(bodies), len(bodies) == len(self._tables_under("body"))
        readings = self.collector.parse_tables("readings", table, self._parse_reading)
        return readings, len(readings) == len(table)

    def _parse_reading(self, key: object, values: object) -> Reading:
        name = str(key)
        if not name.isidentifier():
            raise mistake(ProblemCode.WRONG_TYPE, "the name of a reading consists of letters, digits and _, as crank_angle")
        kind = find_reading_kind(values)
        if not kind:
            of_motion = next((one for one in RUN_KINDS if isinstance(values, Mapping) and one in values), "")
            own_hint = f'; write {name} = {{ angle = "crank" }}'
            hint = f'; a {of_motion.replace("_", " ")} is named under [run], as readings = ["{of_motion}.NAME"]' if of_motion else own_hint
            raise wrong_value(values, f"must be a table with one of {', '.join(READING_TABLES)}", hint)
        reading: Reading = READING_TABLES[kind].build(values, self.registry, name=name)
        return reading

    def _parse_valve(self, readings: tuple[Reading, ...] | None, joints: Sequence[Joint]) -> Valve | None:
        """Return the valve, if there is one; a joint with a mistake may be the driver of its crank."""
        table = self.document.get("valve")
        if not isinstance(table, Mapping) or len(joints) < sum(len(self._tables_under(key)) for key in ("joint", "link")):
            return None
        return self.collector.attempt("valve", parse_valve, table, readings, joints)

    def _parse_start(self, readings: list[Reading]) -> Start:
        given = self.document.get("start", {})
        readings_table = self.document.get("readings")
        # A start may refer to a reading with a mistake.
        has_wrong_readings = isinstance(readings_table, Mapping) and len(readings) < len(readings_table)
        if not isinstance(given, Mapping) or not readings or has_wrong_readings:
            return Start()
        rates = assign_rate_keys(readings)
        return parse_start(given, {item.name: (item.quantity, rates[item.name]) for item in readings}, self.collector)


def assign_rate_keys(readings: Iterable[Reading]) -> dict[str, str]:
    """Return the key in [start] of the rate of each reading: the short one if it is unique."""
    names = [reading.name for reading in readings]
    counts = Counter([*map(rate_key, names), *names])
    return {name: rate_key(name) if counts[rate_key(name)] == 1 else f"{name}_rate" for name in names}


def _leading_coordinate(start: object, readings: list[Reading]) -> str:
    """Return the reading whose value or rate [start] gives first, or else the first one."""
    by_key = {key: name for name, key in assign_rate_keys(readings).items()} | {item.name: item.name for item in readings}
    keys = [key for key in start if key in by_key] if isinstance(start, Mapping) else []
    return by_key[keys[0]] if keys else readings[0].name

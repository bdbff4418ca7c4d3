"""Scene files to scenes. Every mistake of a file is found before any is told, each in one sentence."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, unsupported_effect_messages
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import EQUILIBRIUM, FreeSpindle, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.scenes.cross_validation import check_tables_together
from governor_mechanism.scenes.source import MAX_SCENE_FILE_SIZE, find_nearest_name, read_scene_text
from governor_mechanism.units.quantities import format_value

if TYPE_CHECKING:
    from governor_mechanism.model.mechanism import Mechanism
    from governor_mechanism.model.output_variables import Reading
    from governor_mechanism.scenes.effect_tables import ReadingQuantities
    from governor_mechanism.scenes.schema import SceneFileTable

__all__ = ["GOVERNOR_PART_NAME", "MAX_SCENE_FILE_SIZE", "find_nearest_name", "parse_scene_document", "read_scene_file"]

GOVERNOR_PART_NAME = "governor"
"""The name of the only part of a scene."""

_Result = TypeVar("_Result")


def read_scene_file(path: str | Path, *, known_names: Iterable[str] = ()) -> Scene:
    """The scene in a TOML file.

    `others` are names of scenes worth suggesting when there is no such file. Raises MechanismError with a sentence
    for each mistake in the file, or one saying why it cannot be read.
    """
    source = str(path)
    text = read_scene_text(Path(path), source, known_names)
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise MechanismError(f"{source}: tables or lists are nested too deeply for a scene") from error
    except ValueError as error:  # also what Python raises for a whole number of thousands of digits
        raise MechanismError(f'{source}: not valid TOML: {error}; text and quantities stand in quotes, as in arm = "300 mm"') from error
    if not document:
        raise MechanismError(f"{source}: the file is empty; a scene needs at least machine = ... and a table [dimensions]")
    return parse_scene_document(document, source)


def parse_scene_document(document: Mapping[str, Any], source: str = "") -> Scene:
    """The scene that a document describes, as read from TOML; `source` begins every message.

    Raises MechanismError whose `problems` are all the mistakes found.
    """
    from governor_mechanism.scenes import schema as models  # pydantic takes long to import

    collector = _ProblemCollector(source)
    if not isinstance(document, Mapping):
        raise MechanismError(collector.with_source(f"a scene is a table of keys; found {format_value(document)}"))
    tables = {name: dict(value) for name, value in document.items() if isinstance(value, Mapping)}
    machine_name = _find_intended_machine(document)
    top_level, part, effects, start = (_parse_custom_scene if machine_name == CUSTOM_MACHINE else _parse_dimensioned_scene)(
        collector, document, tables
    )
    spindle = _parse_spindle(collector, tables)
    run_values = collector.validate_table(models.RunTable, tables.get("run", {}), "run")
    run = collector.try_build("[run]", lambda: RunSettings(**run_values))
    if "spindle" in document:
        tables.setdefault("spindle", {})  # what is no table has been told
    collector.add(*check_tables_together(part, effects, spindle, start, tables))
    if collector.messages or part is None or run is None:
        raise MechanismError(*collector.messages)
    return Scene(
        title=top_level.get("title", Path(source).stem or part.machine),
        parts=(part,),
        effects=effects,
        spindle=spindle,
        start=start,
        run=run,
        source=source,
        document=_copy_document(document),
    )


class _ProblemCollector:
    """The mistakes found so far in one file."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.messages: list[str] = []

    def with_source(self, message: str) -> str:
        return f"{self.source}: {message}" if self.source else message

    def add(self, *messages: str) -> None:
        self.messages += [self.with_source(sentence) for sentence in messages]

    def validate_table(self, model: type[SceneFileTable], values: Mapping[str, Any], name: str) -> dict[str, Any]:
        """What a table means; empty, with the mistakes noted, where it is wrong."""
        from governor_mechanism.scenes.schema import validate_table

        parsed, problems = validate_table(model, values, name)
        self.add(*problems)
        return parsed

    def try_build(self, prefix: str, build: Callable[[], _Result]) -> _Result | None:
        """What `make` returns; None, with the mistakes noted, where it refuses."""
        try:
            return build()
        except MechanismError as error:
            self.add(*(f"{prefix} {problem}" for problem in error.problems))
        return None


def _parse_effects(collector: _ProblemCollector, tables: Mapping[str, dict[str, Any]], readings: ReadingQuantities) -> tuple[Effect, ...]:
    """The effects switched on, of a mechanism with these readings."""
    from governor_mechanism.scenes.effect_tables import parse_effects

    effects, problems = parse_effects(tables.get("effects", {}), readings)
    collector.add(*problems)
    return effects


def _parse_spindle(collector: _ProblemCollector, tables: Mapping[str, dict[str, Any]]) -> Spindle | FreeSpindle:
    """The speed given, or the spindle left to itself; still where the file has no spindle."""
    from governor_mechanism.scenes.schema import FreeSpindleTable, SpindleTable

    if "spindle" not in tables:
        return Spindle()
    given = tables["spindle"]
    free_keys = [key for key in FreeSpindleTable.model_fields if key in given]
    if free_keys and "speed" in given:
        collector.add(
            f"spindle.speed cannot stand beside {', '.join(free_keys)}: either the speed is given, "
            "or inertia, start_speed and torque of a spindle left to itself"
        )
        given = {key: value for key, value in given.items() if key not in free_keys}
    if not free_keys or "speed" in given:
        parsed = collector.validate_table(SpindleTable, given, "spindle")
        speed: Spindle = parsed.pop("speed", Spindle())
        return dataclasses.replace(speed, **parsed)
    fluctuation_keys = [key for key in ("speed_fluctuation", "cycles_per_turn") if key in given]
    if fluctuation_keys:
        collector.add(
            f"spindle.{fluctuation_keys[0]} cannot stand beside {', '.join(free_keys)}: how unevenly a spindle left to itself turns "
            "follows from its torque; leave it out, or give spindle.speed"
        )
        given = {key: value for key, value in given.items() if key not in fluctuation_keys}
    parsed = collector.validate_table(FreeSpindleTable, given, "spindle")
    return (collector.try_build("[spindle]", lambda: FreeSpindle(**parsed)) if parsed else None) or Spindle()


def _find_intended_machine(document: Mapping[str, Any]) -> str:
    """The machine named, or the nearest to a misspelt name, so that the rest of the file is checked all the same."""
    document_keys = [machine_key for machine_key in document if isinstance(machine_key, str)]
    machine_key = "machine" if "machine" in document else next(iter(difflib.get_close_matches("machine", document_keys, n=1)), "")
    name = document.get(machine_key)
    close_matches = difflib.get_close_matches(name, [*MACHINES, CUSTOM_MACHINE], n=1) if isinstance(name, str) else []
    return close_matches[0] if close_matches else CUSTOM_MACHINE if "body" in document and "dimensions" not in document else ""


_SceneContents = tuple[dict[str, Any], Part | None, tuple[Effect, ...], Start]
"""The keys above the tables, the part, the effects and the start."""


def _parse_custom_scene(collector: _ProblemCollector, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]) -> _SceneContents:
    """What a scene says that has a mechanism of the user's own."""
    from governor_mechanism.scenes.custom.parser import parse_custom_machine
    from governor_mechanism.scenes.custom.schema import CustomSceneTable

    top_level = collector.validate_table(CustomSceneTable, dict(document), "")
    custom = parse_custom_machine(document, top_level)
    collector.add(*custom.problems)
    effects = _parse_effects(collector, tables, _reading_quantities(custom.readings))
    collector.add(*(f"[effects] {problem}" for problem in unsupported_effect_messages(CUSTOM_MACHINE, effects)))
    return top_level, custom.part, effects, custom.start


def _parse_dimensioned_scene(
    collector: _ProblemCollector, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]
) -> _SceneContents:
    """What a scene says that has a machine which dimensions describe."""
    from governor_mechanism.scenes.schema import SceneTable

    top_level = collector.validate_table(SceneTable, dict(document), "")
    machine_class = MACHINES.get(_find_intended_machine(document))
    machine = _build_machine(collector, machine_class, tables, "dimensions" in document)
    base_mechanism = machine.mechanism() if machine else _build_placeholder_mechanism(machine_class) if machine_class else None
    # Play that is written wrong brings its reading all the same, or naming that would be told as a mistake too.
    has_clearance = machine_class is not None and not machine_class.effect_problems([Clearance(width=1.0)])
    has_clearance = has_clearance and tables.get("effects", {}).get("clearance", False) is not False
    extra_readings = ((CLEARANCE_READING, "length"),) if has_clearance else ()
    effects = _parse_effects(
        collector, tables, (*(_reading_quantities(base_mechanism.readings) or ()), *extra_readings) if base_mechanism else None
    )
    collector.add(*(f"[effects] {problem}" for problem in (machine_class.effect_problems(effects) if machine_class else ())))
    if machine_class is not None and machine_class.driver_dimensions:
        start = _parse_driven_start(collector, machine_class, document)
    else:
        start = _parse_start(collector, machine, base_mechanism, tables.get("start", {}), has_clearance)
    part = collector.try_build("[effects]", lambda: _build_part(machine, effects)) if machine else None
    return top_level, part, effects, start


def _reading_quantities(readings: Iterable[Reading] | None) -> ReadingQuantities:
    return None if readings is None else tuple((reading.name, reading.quantity) for reading in readings)


def _build_machine(
    collector: _ProblemCollector, machine_class: type[Machine] | None, tables: Mapping[str, dict[str, Any]], has_dimensions: bool
) -> Machine | None:
    """The machine of these dimensions; None where it cannot be made."""
    from governor_mechanism.scenes.quantities import join_names
    from governor_mechanism.scenes.schema import dimensions_table_model

    if not has_dimensions:
        requirement = (
            f"{machine_class.name} needs {join_names(_required_dimensions(machine_class))}" if machine_class else "every machine needs some"
        )
        collector.add(f"[dimensions] is missing; {requirement}")
    if machine_class is None or "dimensions" not in tables:
        return None
    n_messages_before = len(collector.messages)
    dimensions = collector.validate_table(dimensions_table_model(machine_class), tables["dimensions"], "dimensions")
    return None if len(collector.messages) > n_messages_before else collector.try_build("[dimensions]", lambda: machine_class(**dimensions))


def _build_part(machine: Machine, effects: tuple[Effect, ...]) -> Part | None:
    """The part of this machine; None where its effects are no such machine's, which has been told."""
    if machine.effect_problems(effects):
        return None
    return Part(
        name=GOVERNOR_PART_NAME,
        machine=machine.name,
        dimensions=machine.dimensions(),
        mechanism=machine.mechanism_with_effects(effects),
        plane=machine.plane,
    )


def _required_dimensions(machine_class: type[Machine]) -> list[str]:
    return [field.name for field in dataclasses.fields(machine_class) if field.default is dataclasses.MISSING]


def _parse_start(
    collector: _ProblemCollector,
    machine: Machine | None,
    base_mechanism: Mechanism | None,
    start_table: Mapping[str, Any],
    has_clearance: bool,
) -> Start:
    """Values and rates of the coordinate, and of a sleeve's play, which starts in its middle and at rest."""
    from governor_mechanism.scenes.schema import find_misspelt_equilibrium, rate_key, start_table_model

    if base_mechanism is None:
        collector.add(*find_misspelt_equilibrium(start_table))
        return Start(values={})
    coordinate = base_mechanism.coordinate
    rate_keys = {coordinate: rate_key(coordinate)} | ({CLEARANCE_READING: f"{CLEARANCE_READING}_rate"} if has_clearance else {})
    quantities = {coordinate: base_mechanism.reading(coordinate).quantity, CLEARANCE_READING: "length"}
    model = start_table_model(tuple((key, quantities[key], rate_keys[key]) for key in rate_keys))
    parsed = collector.validate_table(model, start_table, "start")
    values = {coordinate: parsed.get(coordinate, EQUILIBRIUM)} | (
        {CLEARANCE_READING: parsed.get(CLEARANCE_READING, 0.0)} if has_clearance else {}
    )
    if machine:
        collector.add(*(collector.try_build("[start]", lambda: machine.start_problems(values)) or ()))
    has_given_rates = any(key in parsed for key in rate_keys.values())
    default_rates = {CLEARANCE_READING: 0.0} if has_given_rates and has_clearance else {}
    return Start(values=values, rates=default_rates | {key: parsed[rate] for key, rate in rate_keys.items() if rate in parsed})


def _parse_driven_start(collector: _ProblemCollector, machine_class: type[Machine], document: Mapping[str, Any]) -> Start:
    """The start of a machine whose drive says how it stands and moves."""
    for table_name in ("start", "spindle"):
        if document.get(table_name):
            collector.add(
                f"[{table_name}] has nothing to say of machine {machine_class.name!r}, whose crank is driven: "
                f"how fast, and from where, are {' and '.join(machine_class.driver_dimensions)} in [dimensions]"
            )
    return Start(values={})


def _build_placeholder_mechanism(machine_class: type[Machine]) -> Mechanism | None:
    """Some mechanism of this kind, so that [start] can be checked while [dimensions] is still wrong."""
    try:
        return machine_class(**dict.fromkeys(_required_dimensions(machine_class), 1.0)).mechanism()
    except ValueError:
        return None


def _copy_document(value: Any) -> Any:
    """A copy that later changes of the caller's document do not reach."""
    if isinstance(value, Mapping):
        return {key: _copy_document(item) for key, item in value.items()}
    return [_copy_document(item) for item in value] if isinstance(value, list | tuple) else value

"""Scene files to scenes. Every mistake of a file is found before any is told, each in one sentence."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, foreign_effects
from governor_mechanism.machines.custom import CUSTOM
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import EQUILIBRIUM, FreeSpindle, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.scenes.cross_validation import against_each_other
from governor_mechanism.scenes.source import LARGEST_FILE, nearest_name, text_of
from governor_mechanism.units.quantities import shown

if TYPE_CHECKING:
    from governor_mechanism.model.mechanism import Mechanism, Reading
    from governor_mechanism.scenes.effect_tables import Readings
    from governor_mechanism.scenes.schema import Table

__all__ = ["LARGEST_FILE", "PART", "nearest_name", "read", "scene_from_document"]

PART = "governor"
"""The name of the only part of a scene."""

_Made = TypeVar("_Made")


def read(path: str | Path, *, others: Iterable[str] = ()) -> Scene:
    """The scene in a TOML file.

    `others` are names of scenes worth suggesting when there is no such file. Raises MechanismError with a sentence
    for each mistake in the file, or one saying why it cannot be read.
    """
    source = str(path)
    text = text_of(Path(path), source, others)
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise MechanismError(f"{source}: tables or lists are nested too deeply for a scene") from error
    except ValueError as error:  # also what Python raises for a whole number of thousands of digits
        raise MechanismError(
            f'{source}: not valid TOML: {error}; text and quantities stand in quotes, as in arm = "300 mm"'
        ) from error
    if not document:
        raise MechanismError(
            f"{source}: the file is empty; a scene needs at least machine = ... and a table [dimensions]"
        )
    return scene_from_document(document, source)


def scene_from_document(document: Mapping[str, Any], source: str = "") -> Scene:
    """The scene that a document describes, as read from TOML; `source` begins every message.

    Raises MechanismError whose `problems` are all the mistakes found.
    """
    from governor_mechanism.scenes import schema as models  # pydantic takes long to import

    found = _Findings(source)
    if not isinstance(document, Mapping):
        raise MechanismError(found.located(f"a scene is a table of keys; found {shown(document)}"))
    tables = {name: dict(value) for name, value in document.items() if isinstance(value, Mapping)}
    meant = _machine_meant(document)
    top, part, effects, start = (_own if meant == CUSTOM else _of_dimensions)(found, document, tables)
    spindle = _spindle(found, tables)
    settings = found.table(models.RunTable, tables.get("run", {}), "run")
    run = found.made("[run]", lambda: RunSettings(**settings))
    if "spindle" in document:
        tables.setdefault("spindle", {})  # what is no table has been told
    found.add(*against_each_other(part, effects, spindle, start, tables))
    if found.sentences or part is None or run is None:
        raise MechanismError(*found.sentences)
    return Scene(
        title=top.get("title", Path(source).stem or part.machine),
        parts=(part,),
        effects=effects,
        spindle=spindle,
        start=start,
        run=run,
        source=source,
        document=_plain(document),
    )


class _Findings:
    """The mistakes found so far in one file."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.sentences: list[str] = []

    def located(self, sentence: str) -> str:
        return f"{self.source}: {sentence}" if self.source else sentence

    def add(self, *sentences: str) -> None:
        self.sentences += [self.located(sentence) for sentence in sentences]

    def table(self, model: type[Table], values: Mapping[str, Any], name: str) -> dict[str, Any]:
        """What a table means; empty, with the mistakes noted, where it is wrong."""
        from governor_mechanism.scenes.schema import understood

        meaning, problems = understood(model, values, name)
        self.add(*problems)
        return meaning

    def made(self, where: str, make: Callable[[], _Made]) -> _Made | None:
        """What `make` returns; None, with the mistakes noted, where it refuses."""
        try:
            return make()
        except MechanismError as error:
            self.add(*(f"{where} {problem}" for problem in error.problems))
        return None


def _effects(found: _Findings, tables: Mapping[str, dict[str, Any]], readings: Readings) -> tuple[Effect, ...]:
    """The effects switched on, of a mechanism with these readings."""
    from governor_mechanism.scenes.effect_tables import effects_of

    effects, problems = effects_of(tables.get("effects", {}), readings)
    found.add(*problems)
    return effects


def _spindle(found: _Findings, tables: Mapping[str, dict[str, Any]]) -> Spindle | FreeSpindle:
    """The speed given, or the spindle left to itself; still where the file has no spindle."""
    from governor_mechanism.scenes.schema import FreeSpindleTable, SpindleTable

    if "spindle" not in tables:
        return Spindle()
    given = tables["spindle"]
    free = [key for key in FreeSpindleTable.model_fields if key in given]
    if free and "speed" in given:
        found.add(
            f"spindle.speed cannot stand beside {', '.join(free)}: either the speed is given, "
            "or inertia, start_speed and torque of a spindle left to itself"
        )
        given = {key: value for key, value in given.items() if key not in free}
    if not free or "speed" in given:
        meaning = found.table(SpindleTable, given, "spindle")
        speed: Spindle = meaning.pop("speed", Spindle())
        return dataclasses.replace(speed, **meaning)
    uneven = [key for key in ("unevenness", "waves") if key in given]
    if uneven:
        found.add(
            f"spindle.{uneven[0]} cannot stand beside {', '.join(free)}: how unevenly a spindle left to itself turns "
            "follows from its torque; leave it out, or give spindle.speed"
        )
        given = {key: value for key, value in given.items() if key not in uneven}
    meaning = found.table(FreeSpindleTable, given, "spindle")
    return (found.made("[spindle]", lambda: FreeSpindle(**meaning)) if meaning else None) or Spindle()


def _machine_meant(document: Mapping[str, Any]) -> str:
    """The machine named, or the nearest to a misspelt name, so that the rest of the file is checked all the same."""
    keys = [key for key in document if isinstance(key, str)]
    key = "machine" if "machine" in document else next(iter(difflib.get_close_matches("machine", keys, n=1)), "")
    name = document.get(key)
    near = difflib.get_close_matches(name, [*MACHINES, CUSTOM], n=1) if isinstance(name, str) else []
    return near[0] if near else CUSTOM if "body" in document and "dimensions" not in document else ""


Described = tuple[dict[str, Any], Part | None, tuple[Effect, ...], Start]
"""The keys above the tables, the part, the effects and the start."""


def _own(found: _Findings, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]) -> Described:
    """What a scene says that has a mechanism of the user's own."""
    from governor_mechanism.scenes.custom.parser import described
    from governor_mechanism.scenes.custom.schema import CustomSceneTable

    top = found.table(CustomSceneTable, dict(document), "")
    own = described(document, top)
    found.add(*own.problems)
    effects = _effects(found, tables, _names(own.readings))
    found.add(*(f"[effects] {problem}" for problem in foreign_effects(CUSTOM, effects)))
    return top, own.part, effects, own.start


def _of_dimensions(found: _Findings, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]) -> Described:
    """What a scene says that has a machine which dimensions describe."""
    from governor_mechanism.scenes.schema import SceneTable

    top = found.table(SceneTable, dict(document), "")
    kind = MACHINES.get(_machine_meant(document))
    machine = _machine(found, kind, tables, "dimensions" in document)
    bare = machine.mechanism() if machine else _stand_in(kind) if kind else None
    # Play that is written wrong brings its reading all the same, or naming that would be told as a mistake too.
    plays = kind is not None and not kind.effect_problems([Play(width=1.0)])
    plays = plays and tables.get("effects", {}).get("play", False) is not False
    more = ((PLAY, "length"),) if plays else ()
    effects = _effects(found, tables, (*(_names(bare.readings) or ()), *more) if bare else None)
    found.add(*(f"[effects] {problem}" for problem in (kind.effect_problems(effects) if kind else ())))
    if kind is not None and kind.driven:
        start = _driven(found, kind, document)
    else:
        start = _start(found, machine, bare, tables.get("start", {}), plays)
    part = found.made("[effects]", lambda: _part(machine, effects)) if machine else None
    return top, part, effects, start


def _names(readings: Iterable[Reading] | None) -> Readings:
    return None if readings is None else tuple((reading.name, reading.quantity) for reading in readings)


def _machine(
    found: _Findings, kind: type[Machine] | None, tables: Mapping[str, dict[str, Any]], given: bool
) -> Machine | None:
    """The machine of these dimensions; None where it cannot be made."""
    from governor_mechanism.scenes.quantities import listed
    from governor_mechanism.scenes.schema import dimensions_table

    if not given:
        needs = f"{kind.name} needs {listed(_required(kind))}" if kind else "every machine needs some"
        found.add(f"[dimensions] is missing; {needs}")
    if kind is None or "dimensions" not in tables:
        return None
    before = len(found.sentences)
    dimensions = found.table(dimensions_table(kind), tables["dimensions"], "dimensions")
    return None if len(found.sentences) > before else found.made("[dimensions]", lambda: kind(**dimensions))


def _part(machine: Machine, effects: tuple[Effect, ...]) -> Part | None:
    """The part of this machine; None where its effects are no such machine's, which has been told."""
    if machine.effect_problems(effects):
        return None
    return Part(
        name=PART,
        machine=machine.name,
        dimensions=machine.dimensions(),
        mechanism=machine.mechanism_with(effects),
        plane=machine.plane,
    )


def _required(kind: type[Machine]) -> list[str]:
    return [field.name for field in dataclasses.fields(kind) if field.default is dataclasses.MISSING]


def _start(
    found: _Findings, machine: Machine | None, bare: Mechanism | None, given: Mapping[str, Any], plays: bool
) -> Start:
    """Values and rates of the coordinate, and of a sleeve's play, which starts in its middle and at rest."""
    from governor_mechanism.scenes.schema import rate_key, start_table_of, start_word_problems

    if bare is None:
        found.add(*start_word_problems(given))
        return Start(values={})
    name = bare.coordinate
    rates = {name: rate_key(name)} | ({PLAY: f"{PLAY}_rate"} if plays else {})
    quantities = {name: bare.reading(name).quantity, PLAY: "length"}
    model = start_table_of(tuple((key, quantities[key], rates[key]) for key in rates))
    meaning = found.table(model, given, "start")
    values = {name: meaning.get(name, EQUILIBRIUM)} | ({PLAY: meaning.get(PLAY, 0.0)} if plays else {})
    if machine:
        found.add(*(found.made("[start]", lambda: machine.start_problems(values)) or ()))
    moving = any(key in meaning for key in rates.values())
    still = {PLAY: 0.0} if moving and plays else {}
    return Start(values=values, rates=still | {key: meaning[rate] for key, rate in rates.items() if rate in meaning})


def _driven(found: _Findings, kind: type[Machine], document: Mapping[str, Any]) -> Start:
    """The start of a machine whose drive says how it stands and moves."""
    for table in ("start", "spindle"):
        if document.get(table):
            found.add(
                f"[{table}] has nothing to say of machine {kind.name!r}, whose crank is driven: "
                f"how fast, and from where, are {' and '.join(kind.driven)} in [dimensions]"
            )
    return Start(values={})


def _stand_in(kind: type[Machine]) -> Mechanism | None:
    """Some mechanism of this kind, so that [start] can be checked while [dimensions] is still wrong."""
    try:
        return kind(**dict.fromkeys(_required(kind), 1.0)).mechanism()
    except ValueError:
        return None


def _plain(value: Any) -> Any:
    """A copy that later changes of the caller's document do not reach."""
    if isinstance(value, Mapping):
        return {key: _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list | tuple) else value

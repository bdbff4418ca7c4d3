"""Scene files to scenes. Every mistake of a file is found before any is told, each in one sentence."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from governor_mechanism.effects import Centrifugal, Effect
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines import MACHINES
from governor_mechanism.machines.custom import CUSTOM
from governor_mechanism.machines.dimensions import Machine
from governor_mechanism.scene import EQUILIBRIUM, TURNING, FreeSpindle, Part, RunSettings, Scene, Spindle, Start
from governor_mechanism.units import shown

if TYPE_CHECKING:
    from governor_mechanism.mechanism import Mechanism
    from governor_mechanism.reading_models import Table

LARGEST_FILE = 1_000_000
"""Bytes. A scene is a page of text; more is another kind of file."""

PART = "governor"
"""The name of the only part of a scene."""

_Made = TypeVar("_Made")


def read(path: str | Path, *, others: Iterable[str] = ()) -> Scene:
    """The scene in a TOML file.

    `others` are names of scenes worth suggesting when there is no such file. Raises MechanismError with a sentence
    for each mistake in the file, or one saying why it cannot be read.
    """
    source = str(path)
    text = _text(Path(path), source, others)
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
    from governor_mechanism import reading_models as models  # pydantic takes long to import

    found = _Findings(source)
    if not isinstance(document, Mapping):
        raise MechanismError(found.located(f"a scene is a table of keys; found {shown(document)}"))
    tables = {name: dict(value) for name, value in document.items() if isinstance(value, Mapping)}
    meant = _machine_meant(document)
    top, part, start = (_own if meant == CUSTOM else _of_dimensions)(found, document, tables)
    effects = _effects(found, tables, document)
    spindle = _spindle(found, tables)
    settings = found.table(models.RunTable, tables.get("run", {}), "run")
    run = found.made("[run]", lambda: RunSettings(**settings))
    found.add(*_idle(part, spindle, tables))
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
        from governor_mechanism.reading_models import understood

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


def _effects(found: _Findings, tables: Mapping[str, dict[str, Any]], document: Mapping[str, Any]) -> tuple[Effect, ...]:
    from governor_mechanism.reading_models import EffectsTable

    given = found.table(EffectsTable, tables.get("effects", {}), "effects")
    effects = tuple(effect for effect in given.values() if effect is not None)
    if "spindle" not in document and any(isinstance(effect, Centrifugal) for effect in effects):
        found.add('effects.centrifugal = true needs a spindle that turns; add [spindle] with a line speed = "120 rpm"')
    return effects


def _spindle(found: _Findings, tables: Mapping[str, dict[str, Any]]) -> Spindle | FreeSpindle:
    """The speed given, or the spindle left to itself; still where the file has no spindle."""
    from governor_mechanism.reading_models import FreeSpindleTable, SpindleTable

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
        speed: Spindle = found.table(SpindleTable, given, "spindle").get("speed", Spindle())
        return speed
    meaning = found.table(FreeSpindleTable, given, "spindle")
    return (found.made("[spindle]", lambda: FreeSpindle(**meaning)) if meaning else None) or Spindle()


def _idle(part: Part | None, spindle: Spindle | FreeSpindle, tables: Mapping[str, dict[str, Any]]) -> Iterable[str]:
    """A spindle and a mechanism that do not act upon each other as the file says."""
    turning = part is not None and part.plane == TURNING
    centrifugal = tables.get("effects", {}).get("centrifugal", False)
    if isinstance(spindle, FreeSpindle) and turning and centrifugal is False:
        yield (
            "effects.centrifugal = true is missing: a free spindle is slowed by what turns with it; "
            "add it, or give spindle.speed"
        )
    if isinstance(spindle, FreeSpindle) and part is not None and not turning:
        yield f'spindle.inertia: nothing turns with it in a fixed plane; write plane = "{TURNING}", or leave it out'
    if part is not None and not turning and centrifugal is True:
        yield f'effects.centrifugal = true needs a plane that turns; write plane = "{TURNING}", or leave it out'


def _machine_meant(document: Mapping[str, Any]) -> str:
    """The machine named, or the nearest to a misspelt name, so that the rest of the file is checked all the same."""
    keys = [key for key in document if isinstance(key, str)]
    key = "machine" if "machine" in document else next(iter(difflib.get_close_matches("machine", keys, n=1)), "")
    name = document.get(key)
    near = difflib.get_close_matches(name, [*MACHINES, CUSTOM], n=1) if isinstance(name, str) else []
    return near[0] if near else CUSTOM if "body" in document and "dimensions" not in document else ""


def _own(
    found: _Findings, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]
) -> tuple[dict[str, Any], Part | None, Start]:
    """The keys above the tables, the part and the start of a scene with a mechanism of the user's own."""
    from governor_mechanism.reading_custom import described
    from governor_mechanism.reading_custom_models import CustomSceneTable

    top = found.table(CustomSceneTable, dict(document), "")
    own = described(document, top)
    found.add(*own.problems)
    return top, own.part, own.start


def _of_dimensions(
    found: _Findings, document: Mapping[str, Any], tables: Mapping[str, dict[str, Any]]
) -> tuple[dict[str, Any], Part | None, Start]:
    """The keys above the tables, the part and the start of a scene with a machine that dimensions describe."""
    from governor_mechanism.reading_models import SceneTable

    top = found.table(SceneTable, dict(document), "")
    kind = MACHINES.get(_machine_meant(document))
    built = _built(found, kind, tables, "dimensions" in document)
    start = _start(found, kind, built, tables.get("start", {}))
    return top, _part(*built) if built else None, start


def _built(
    found: _Findings, kind: type[Machine] | None, tables: Mapping[str, dict[str, Any]], given: bool
) -> tuple[Machine, Mechanism] | None:
    """The machine of these dimensions, and its mechanism."""
    from governor_mechanism.reading_models import dimensions_table
    from governor_mechanism.reading_values import listed

    if not given:
        needs = f"{kind.name} needs {listed(_required(kind))}" if kind else "every machine needs some"
        found.add(f"[dimensions] is missing; {needs}")
    if kind is None or "dimensions" not in tables:
        return None
    before = len(found.sentences)
    dimensions = found.table(dimensions_table(kind), tables["dimensions"], "dimensions")
    if len(found.sentences) > before:
        return None

    def build() -> tuple[Machine, Mechanism]:
        machine = kind(**dimensions)
        return machine, machine.mechanism()

    return found.made("[dimensions]", build)


def _part(machine: Machine, mechanism: Mechanism) -> Part:
    return Part(
        name=PART, machine=machine.name, dimensions=machine.dimensions(), mechanism=mechanism, plane=machine.plane
    )


def _required(kind: type[Machine]) -> list[str]:
    return [field.name for field in dataclasses.fields(kind) if field.default is dataclasses.MISSING]


def _start(
    found: _Findings, kind: type[Machine] | None, built: tuple[Machine, Mechanism] | None, given: Mapping[str, Any]
) -> Start:
    from governor_mechanism.reading_models import rate_key, start_table, start_word_problems

    mechanism = built[1] if built else _stand_in(kind) if kind else None
    if mechanism is None:
        found.add(*start_word_problems(given))
        return Start(values={})
    name = mechanism.coordinate
    meaning = found.table(start_table(name, mechanism.reading(name).quantity), given, "start")
    values = {name: meaning.get(name, EQUILIBRIUM)}
    if built:
        machine = built[0]
        found.add(*(found.made("[start]", lambda: machine.start_problems(values)) or ()))
    rate = rate_key(name)
    return Start(values=values, rates={name: meaning[rate]} if rate in meaning else {})


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


def _text(path: Path, source: str, others: Iterable[str]) -> str:
    """The text of the file, or a MechanismError that says why there is none."""
    try:
        if path.is_dir():
            raise MechanismError(_folder(path, source))
        with path.open("rb") as stream:
            content = stream.read(LARGEST_FILE + 1)
    except MechanismError:
        raise
    except FileNotFoundError as error:
        raise MechanismError(_missing(path, source, others)) from error
    except PermissionError as error:
        raise MechanismError(f"{source}: no permission to read this file; change its rights or copy it") from error
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = error.strerror if isinstance(error, OSError) else error
        raise MechanismError(f"{source}: this file cannot be read ({reason})") from error
    if len(content) > LARGEST_FILE:
        raise MechanismError(f"{source}: this file is larger than {LARGEST_FILE:,} bytes; a scene is a page of text")
    try:
        return content.decode("utf-8-sig")  # some editors of Windows put a mark in front
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise MechanismError(f"{source}: line {line} is not UTF-8 text; save the file as UTF-8") from error


def nearest_name(word: str, names: Iterable[str]) -> str:
    """The scene name that `word` is a slip of, capitals aside; '' where none is near enough to be meant."""
    lowered = {name.lower(): name for name in names}
    near = difflib.get_close_matches(word.lower(), list(lowered), n=1, cutoff=0.75)
    return lowered[near[0]] if near else ""


def _folder(path: Path, source: str) -> str:
    scenes = sorted(file.name for file in path.glob("*.toml"))
    holds = f"it holds {', '.join(scenes)}" if scenes else "it holds no .toml files"
    return f"{source}: this is a folder, not a scene file; {holds}"


def _missing(path: Path, source: str, others: Iterable[str]) -> str:
    """The sentence about a file that is not there, with the nearest name among its neighbours and the others."""
    known = {name: name for name in others}
    known |= {neighbour.stem: str(neighbour) for neighbour in path.parent.glob("*.toml")}
    near = nearest_name(path.stem, known)
    folder = "" if path.parent.is_dir() else f" (there is no folder {str(path.parent)!r} either)"
    return f"{source}: no such file{folder}." + (f" Did you mean {known[near]!r}?" if near else "")

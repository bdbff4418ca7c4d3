"""One mechanism under the hand: its scene file, what was changed, and the run that answers."""

import tempfile
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from threading import Lock
from typing import Any, Final

import numpy as np

import governor_mechanism as gm
from governor_mechanism.engines.base import Engine, make_reported_times
from governor_mechanism.engines.certificate import ErrorControlledEngine
from governor_mechanism.engines.selection import select_engine
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.live.describing import (
    choose_pace,
    describe_bounded_outcome,
    describe_end,
    describe_outcome,
    describe_readings,
    list_frames,
    list_inspections,
    prepare_moment,
    show_whole_run,
)
from governor_mechanism.live.equilibria import EquilibriumPlot
from governor_mechanism.live.grips import find_grips, find_start, find_travel
from governor_mechanism.live.motion import Motion
from governor_mechanism.live.quantities import Quantity, choose, find_choices, find_quantities
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import BoundingBox
from governor_mechanism.render.page.page_data import collect_data, collect_pictures
from governor_mechanism.render.page.views import ShownRun, show_run
from governor_mechanism.render.page.writer import describe_accuracy, list_dimensions, list_effects, raise_exponents
from governor_mechanism.scenes.changed_document import document_of, find_item, format_scene_toml, replace_document_value
from governor_mechanism.scenes.library import models_folder
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value

SCENE_ENDING: Final = ".toml"
"""End of the name of a scene file."""

FORBIDDEN_LETTERS: Final = '/\\:\0<>|"?*'
"""Letters that lead out of a folder, or that names of files do not have on every system."""


class SceneFile:
    """The file, if any, that a scene was opened from: it is written only if nobody else has changed it, or if that is confirmed."""

    def __init__(self, source: str) -> None:
        path = Path(source) if source else None
        self.opened_text = _read_text(path) if path else None
        is_own = path is not None and self.opened_text is not None and not _is_shipped(path)
        self.folder = path.resolve().parent if path and is_own else Path.cwd()
        self.name = path.name if path and is_own else f"{Path(source).stem or 'scene'}{SCENE_ENDING}"
        self._known_text = self.opened_text if is_own else None

    def save(self, name: str, document: Mapping[str, Any], *, overwrites: bool) -> tuple[str, str]:
        """Write a document as a scene file beside the opened one; return what was written, or a question whether to overwrite it."""
        # Raises MechanismError if the name is no name of a scene file, or the file cannot be
        # written.
        path = self.folder / _check_name(name)
        if path.is_symlink():
            raise MechanismError(f"{path} is a link to another place; choose another name")
        found = _read_text(path)
        is_known = name == self.name and found is not None and found == self._known_text
        if path.exists() and not is_known and not overwrites:
            changed = "has changed on disk since it was read" if name == self.name and self._known_text is not None else "is already there"
            return "", f"{path} {changed}."
        text = write_scene(self.opened_text, document)
        try:
            with atomic_write(path) as temporary:
                temporary.write_text(text, encoding="utf-8")
        except OSError as error:
            raise MechanismError(f"cannot write {path}: {error.strerror or error}") from None
        self.name, self._known_text = name, text
        return f"Saved as {path}.", ""


def _check_name(name: str) -> str:
    """Return the name of a scene file; raise MechanismError for anything else, as a path."""
    has_forbidden = any(letter in FORBIDDEN_LETTERS or not letter.isprintable() for letter in name)
    if has_forbidden or name.startswith(".") or not name.endswith(SCENE_ENDING):
        raise MechanismError(f'the name of a scene file ends in {SCENE_ENDING} and is no path, as "mine.toml"; found {format_value(name)}')
    return name


def _is_shipped(path: Path) -> bool:
    """Return whether a file is one of those that come with the package."""
    return models_folder().resolve() in path.resolve().parents


def _read_text(path: Path) -> str | None:
    """Return the text of a file; None without one."""
    with suppress(OSError, ValueError):
        return path.read_text(encoding="utf-8")
    return None


def write_scene(
    text: str | None,  # the text of the opened file; None without one
    document: Mapping[str, Any],
) -> str:
    """Return the text of the opened file with the changed values alone changed, or a text without comments where that is not possible."""
    with suppress(ValueError, ImportError):  # tomlkit may be missing in a notebook
        changed = _change_text(text or "", document)
        if tomllib.loads(changed) == document:
            return changed
    return format_scene_toml(document)


def _change_text(text: str, document: Mapping[str, Any]) -> str:
    """Return a text of TOML with the quantities of a document."""
    import tomlkit  # with the extra

    written = tomlkit.parse(text)
    before = find_quantities(written.unwrap(), 1.0)
    for key, quantity in find_quantities(document, 1.0).items():
        if key in before and quantity.value != before[key].value:
            owner: Any = written
            *tables, last = key.split(".")
            for name in tables:
                owner = owner[_place_in(owner, name)]
            owner[_place_in(owner, last)] = quantity.write(quantity.value)
    return tomlkit.dumps(written)


def _place_in(owner: Any, name: str) -> str | int:
    """Return the key of a table, or the index in a list."""
    return name if isinstance(owner, Mapping) else find_item(owner, name, "")


def export_run(run: Trajectory, ending: str, theme: str) -> bytes:
    """Return a run as a film, a page, a table of its readings, or their figure."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"saved.{ending}"
        if ending == "csv":
            run.save_csv(path)
        elif ending in ("svg", "png"):
            run.plot().save(path, theme)
        else:
            run.film(path)
        return path.read_bytes()


MAX_UNDONE: Final = 500
"""Number of changes that can be undone."""

HELD_TIME: Final = 0.05
"""Time, s, that a run takes at most while a hand moves, as the last whole run lets one expect: it goes on to an earlier end instead."""

LEAST_HELD_STEPS: Final = 100
"""Least limit of the steps of a run while a hand holds something: a mechanism that locks would take all that its engine allows."""

MAX_MOTIONS: Final = 8
"""Largest number of tabs whose motions are kept."""


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """The answer to one state of the document."""

    document: Mapping[str, Any]  # the document; that of the run is an earlier one where there is a problem
    run: Trajectory  # the last possible run
    problem: str  # why the present values allow none; empty if they do
    number: int  # number of changes before it
    is_bounded: bool = False  # whether its steps were bounded, since a hand held something
    is_brief: bool = False  # whether the run ends earlier than that of the scene, since a hand moved


class Session:
    """The document of a scene with its changes; its methods may be called from several threads, and all listeners hear of a change."""

    # `shown` are keys of the quantities that the page offers, all if it is empty, with the ends of
    # their sliders in their units, or None for the usual ends.

    def __init__(self, scene: Scene, shown: Mapping[str, tuple[float, float] | None] | None = None) -> None:
        self.shown = dict(shown or {})
        self.file = SceneFile(scene.source)
        self.listeners: set[Callable[[], None]] = set()
        self._document: Mapping[str, Any] = document_of(scene, "open")
        self._first_document = self._document
        self._done: list[Mapping[str, Any]] = []
        self._undone: list[Mapping[str, Any]] = []
        self._is_dragging = False
        self._number = 0
        self._changing, self._solving = Lock(), Lock()
        run = gm.run(scene)
        if not len(run.times):
            raise MechanismError(run.message)
        self._last = Snapshot(document=self._document, run=run, problem="", number=0)
        self._complete = run  # the last run that came to the end of its scene
        self._equilibria = EquilibriumPlot(scene)
        self.shown_time = 0.0
        """Time, s, that the page shows which asked for the last change."""
        self._kept: dict[str, Any] = {}  # what stood in the document for earlier choices
        self._boxes: Sequence[BoundingBox] = ()
        self._motions: dict[str, Motion] = {}

    @property
    def document(self) -> Mapping[str, Any]:
        """The document with all changes."""
        return self._document

    @property
    def is_held(self) -> bool:
        """Whether a hand holds a slider or a point."""
        return self._is_dragging

    @property
    def run(self) -> Trajectory:
        """The last possible run."""
        return self._last.run

    def find_quantities(self) -> dict[str, Quantity]:
        """Return the quantities that may be changed, by key."""
        return find_quantities(self._document, self.run.scene.mechanism.length_scale)

    def _offer_quantities(self, document: Mapping[str, Any]) -> dict[str, Quantity]:
        """Return the quantities of a document by key that the page offers."""
        found = find_quantities(document, self.run.scene.mechanism.length_scale)
        for key, ends in self.shown.items():
            if ends is not None and key in found:
                found[key] = replace(found[key], low=ends[0], high=ends[1])
        return {key: found[key] for key in self.shown if key in found} or found

    def change(self, values: Mapping[str, float], *, is_last: bool = True) -> None:
        """Change quantities, in their units, those of one drag undone together; MechanismError for a key that is no quantity."""
        with self._changing:
            known, document = self.find_quantities(), self._document
            start = find_start(self.run)
            if start is not None and start[0].key in values:
                known.setdefault(start[0].key, start[0])
            for key, value in values.items():
                if key not in known:
                    raise MechanismError(f"{key!r} is no quantity of this scene")
                document = replace_document_value(document, key, known[key].write(value))
            if not self._is_dragging:
                self._done = [*self._done, self._document][-MAX_UNDONE:]
            self._is_dragging = not is_last
            self._undone.clear()
            self._take(document)

    def assemble(self, number: int) -> None:
        """Take another way in which the joints close; raise MechanismError if the scene is not one of a custom machine."""
        if self._document.get("machine") != CUSTOM_MACHINE:
            raise MechanismError("only a custom machine has assemblies to choose from")
        with self._changing:
            self._is_dragging = False
            self._done = [*self._done, self._document][-MAX_UNDONE:]
            self._undone.clear()
            written = self._document.get("assembly")
            taken = {**written, "take": number} if isinstance(written, Mapping) else number
            self._take({**self._document, "assembly": taken})

    def find_changes(self) -> dict[str, float]:
        """Return the quantities whose values are not those of the first document, by key."""
        before = find_quantities(self._first_document, 1.0)
        return {key: one.value for key, one in self.find_quantities().items() if key not in before or before[key].value != one.value}

    def choose(self, key: str, value: str | bool) -> None:
        """Choose a word or a switch, by which an effect comes back as it was; MechanismError for a wrong key or value."""
        with self._changing:
            document = choose(self.run, self._document, key, value, self._kept)
            self._done = [*self._done, self._document][-MAX_UNDONE:]
            self._is_dragging = False
            self._undone.clear()
            self._take(document)

    def undo(self) -> None:
        """Return to the document before the last change, if there is one."""
        self._move(self._done, self._undone)

    def redo(self) -> None:
        """Take back what was undone last, if anything was."""
        self._move(self._undone, self._done)

    def reset(self) -> None:
        """Return to the first document; this can be undone."""
        with self._changing:
            if self._document != self._first_document:
                self._done.append(self._document)
                self._undone.clear()
                self._take(self._first_document)

    def _move(self, origin: list[Mapping[str, Any]], target: list[Mapping[str, Any]]) -> None:
        with self._changing:
            self._is_dragging = False
            if origin:
                target.append(self._document)
                self._take(origin.pop())

    def _take(self, document: Mapping[str, Any]) -> None:
        self._document = document
        self._number += 1
        self.notify()

    def notify(self) -> None:
        """Let all listeners send the present state."""
        for listener in tuple(self.listeners):
            listener()

    def solve(self, *, is_brief: bool = False) -> Snapshot:
        """Return the run of the present document, or the last possible one with the reason."""
        # The steps of a run are bounded that is to be brief, or while a hand holds something. A
        # brief one whose whole run takes long goes to the shown time at most, or to where it would
        # take too long.
        with self._solving:
            document = self._document
            number = self._number
            is_bounded = self._is_dragging or is_brief
            last = self._last
            if last.number == number and (is_bounded or not last.is_bounded):
                return last
            if is_bounded and last.document == document:  # a hand lets go where it was
                return replace(last, number=number)
            run, problem, is_short = self._try_run(document, is_bounded=is_bounded, is_brief=is_brief)
            found = Snapshot(
                document=document,
                run=run or last.run,
                problem=problem,
                number=number,
                is_bounded=is_bounded and run is not None,
                is_brief=is_short and run is not None,
            )
            if not found.is_brief:
                self._last = found
            if not is_bounded and run is not None and run.times[-1] >= run.scene.run.duration:
                self._complete = run
            return found

    def _try_run(self, document: Mapping[str, Any], *, is_bounded: bool, is_brief: bool) -> tuple[Trajectory | None, str, bool]:
        """Return the run of a document, or None and why there is none to be shown; and whether it is shorter than the scene asks for."""
        is_short = False
        try:
            scene = gm.Scene.from_dict(document)
            times = make_reported_times(scene)
            end = self._held_end(times) if is_brief else len(times)
            is_short = end < len(times)
            run = gm.run(scene, engine=self._bounded_engine(scene) if is_bounded else "auto", times=times[:end] if is_short else None)
        except GovernorMechanismError as error:
            problems = error.problems if isinstance(error, MechanismError) else (str(error),)
        else:
            if len(run.times):
                return run, "", is_short
            problems = (run.message,)
        sentence = "; ".join(problems).rstrip(".")
        return None, f"{sentence[:1].upper()}{sentence[1:]}. The pictures show the last possible state.", is_short

    def _held_end(self, times: FloatArray) -> int:
        """Return how many of the reported times (n,) s of a scene a run reaches while a hand moves: all of them, if that is quick."""
        pace = self._complete.cost.wall_time / max(float(self._complete.times[-1]), float(times[-1]) / len(times))
        if pace * float(times[-1]) <= HELD_TIME:
            return len(times)
        end = min(self.shown_time, HELD_TIME / pace)
        return int(np.clip(np.searchsorted(times, end) + 1, min(2, len(times)), len(times)))

    def _bounded_engine(self, scene: Scene) -> Engine:
        """Return the engine of a scene, with hardly more steps than the last complete run took."""
        engine, _ = select_engine(scene.run.engine, scene)
        if not isinstance(engine, ErrorControlledEngine):
            return engine
        return replace(engine, max_steps=max(self._complete.cost.steps, LEAST_HELD_STEPS))

    def extend_motion(self, tab: str, time: float, duration: float, *, is_new: bool) -> dict[str, Any]:
        """Return the motion of one tab from a time (s) on, for a duration (s); a new one begins in the run, MechanismError without one."""
        snapshot = self.solve(is_brief=not is_new)
        with self._changing:
            if is_new or tab not in self._motions:
                others = [pair for pair in self._motions.items() if pair[0] != tab][1 - MAX_MOTIONS :]
                self._motions = dict([*others, (tab, Motion(snapshot.run, self._boxes))])
            motion = self._motions[tab]
        return motion.extend(snapshot.run.scene, time, duration) | {"problem": snapshot.problem}

    def find_travel(self) -> dict[str, Any]:
        """Return where the motion may start, as the page draws it; None where nothing can be pulled there."""
        snapshot = self.solve()
        travel = None if snapshot.problem else find_travel(snapshot.run, self._boxes)
        offered = travel is not None and self._offers([travel.key])
        return {"travel": asdict(travel) if travel and offered else None}

    def _offers(self, keys: Iterable[str]) -> bool:
        """Return whether the page may change quantities."""
        return not self.shown or all(key in self.shown for key in keys)

    def describe_moment(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return what the page shows at once of a snapshot: its drawing at the shown time, in the box of the last whole run."""
        if snapshot.problem:
            return self._describe_state(snapshot, None)
        run = snapshot.run
        limits, _ = choose_pace(run)
        _, slow_down = choose_pace(self.run)
        drawn = prepare_moment(run, self.run if snapshot.is_brief else None)
        times = np.clip(np.array([self.shown_time]), *limits)
        shown = show_run(drawn, None, limits, times, slow_down, boxes=self._boxes)
        moment = collect_pictures(shown, slow_down)
        return self._describe_state(snapshot, shown) | {"moment": moment, "equilibria": self._equilibria.draw(run.scene)}

    def describe(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return all that the page shows of a snapshot, as values that JSON knows; while a hand holds something, nothing is rescaled."""
        run = snapshot.run
        shown, slow_down = show_whole_run(run, self._boxes if self.is_held else ())
        self._boxes = [view.box for view in shown.views]
        facts = {
            "accuracy": describe_accuracy(run, shown.times),
            "effects": list_effects(run.scene),
            "dimensions": list_dimensions(run.scene),
        }
        return self._describe_state(snapshot, shown) | {
            "data": collect_data(shown, slow_down),
            "choices": [asdict(one) for one in find_choices(run, snapshot.document).values()],
            "equilibria": self._equilibria.draw(run.scene),
            "facts": {name: [(term, raise_exponents(text)) for term, text in rows] for name, rows in facts.items()},
        }

    def _describe_state(self, snapshot: Snapshot, shown: ShownRun | None) -> dict[str, Any]:
        """Return what belongs to every answer to a state of the document."""
        run = snapshot.run
        quantities = self._offer_quantities(snapshot.document)
        grips = [*find_grips(run, shown.views[0])] if shown and not snapshot.problem else []
        grips = [one for one in grips if self._offers(key for key, *_ in one.effects)]
        return {
            "number": snapshot.number,
            "problem": snapshot.problem,
            "quantities": [asdict(one) for one in quantities.values()],
            "grips": [asdict(one) for one in grips],
            "readings": describe_readings(run),
            "readingsAt": describe_end(run) if snapshot.is_bounded else "At the end of the run",
            "accuracy": describe_bounded_outcome(run) if snapshot.is_bounded else describe_outcome(run),
            "fileName": self.file.name,
            "changes": self.find_changes(),
            "inspections": list_inspections(run),
            "frames": list_frames(shown) if shown else [],
            "canUndo": bool(self._done),
            "canRedo": bool(self._undone),
        }

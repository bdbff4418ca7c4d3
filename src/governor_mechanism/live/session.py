"""One mechanism under the hand: its scene file, what was changed, and the run that answers."""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from threading import Lock
from typing import Any, Final

import governor_mechanism as gm
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.live.equilibria import EquilibriumPlot
from governor_mechanism.live.grips import find_grips
from governor_mechanism.live.inspection import list_inspections
from governor_mechanism.live.quantities import Quantity, find_quantities
from governor_mechanism.live.saving import SceneFile
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.film.timing import select_slow_down
from governor_mechanism.render.number_format import format_closing_lines, format_name
from governor_mechanism.render.page.page_data import collect_data
from governor_mechanism.render.page.views import ShownRun, show_run
from governor_mechanism.render.page.writer import (
    MAX_TRUE_TIME_DURATION,
    choose_sample_times,
    describe_accuracy,
    list_dimensions,
    list_effects,
    raise_exponents,
)
from governor_mechanism.scenes.changed_document import document_of, replace_document_value
from governor_mechanism.units.quantities import format_quantity

MAX_LINE_LENGTH: Final = 120
"""Largest length of the line on the accuracy."""

MAX_UNDONE: Final = 500
"""Number of changes that can be undone."""


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """The answer to one state of the document.

    Attributes
    ----------
    document
        The document; that of the run is an earlier one where there is a problem.
    run
        The last possible run.
    problem
        Why the present values allow none; empty if they do.
    number
        Number of changes before it.
    """

    document: Mapping[str, Any]
    run: Trajectory
    problem: str
    number: int


class Session:
    """The document of a scene with its changes. Its methods may be called from several threads, and all listeners hear of a change.

    Parameters
    ----------
    scene
        Scene with a document.
    shown
        Keys of the quantities that the page offers, with the ends of their sliders in their units; None for the usual ends. Without
        any it offers all.
    """

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
        self._equilibria = EquilibriumPlot(scene)

    @property
    def document(self) -> Mapping[str, Any]:
        """The document with all changes."""
        return self._document

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
        """Change quantities, values in their units; those of one drag, up to its last, are undone together.

        Raises MechanismError for a key that is no quantity of the scene.
        """
        with self._changing:
            known, document = self.find_quantities(), self._document
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

    def solve(self) -> Snapshot:
        """Return the run of the present document, or the last possible one with the reason."""
        with self._solving:
            document, number = self._document, self._number
            if self._last.number == number:
                return self._last
            run, problem = _try_run(document)
            self._last = Snapshot(document=document, run=run or self._last.run, problem=problem, number=number)
            return self._last

    def describe(self, snapshot: Snapshot) -> dict[str, Any]:
        """Return what the page shows of a snapshot, as values that JSON knows."""
        run = snapshot.run
        shown, slow_down = show_whole_run(run)
        quantities = self._offer_quantities(snapshot.document)
        grips = [] if snapshot.problem else [*find_grips(run.scene, shown.views[0])]
        grips = [one for one in grips if all(key in quantities for key, *_ in one.effects)]
        facts = {
            "accuracy": describe_accuracy(run, shown.times),
            "effects": list_effects(run.scene),
            "dimensions": list_dimensions(run.scene),
        }
        return {
            "number": snapshot.number,
            "problem": snapshot.problem,
            "data": collect_data(shown, slow_down),
            "quantities": [asdict(one) for one in quantities.values()],
            "grips": [asdict(one) for one in grips],
            "equilibria": self._equilibria.draw(run.scene),
            "readings": _describe_readings(run),
            "accuracy": _describe_outcome(run),
            "facts": {name: [(term, raise_exponents(text)) for term, text in rows] for name, rows in facts.items()},
            "fileName": self.file.name,
            "changes": self.find_changes(),
            "inspections": list_inspections(run),
            "frames": [[view.picture.scale, view.box[0], view.box[3]] for view in shown.views],
            "canUndo": bool(self._done),
            "canRedo": bool(self._undone),
        }


def show_whole_run(run: Trajectory) -> tuple[ShownRun, float]:
    """Return what a page shows of a whole run, and how many seconds of film a second of it takes at first."""
    limits = float(run.times[0]), float(run.times[-1])
    slow_down = select_slow_down(limits, limits, None, MAX_TRUE_TIME_DURATION)
    return show_run(run, None, limits, choose_sample_times(run, limits, slow_down), slow_down), slow_down


def _try_run(document: Mapping[str, Any]) -> tuple[Trajectory | None, str]:
    """Return the run of a document, or None and why there is none to be shown."""
    try:
        run = gm.run(gm.Scene.from_dict(document))
    except GovernorMechanismError as error:
        problems = error.problems if isinstance(error, MechanismError) else (str(error),)
    else:
        if len(run.times):
            return run, ""
        problems = (run.message,)
    sentence = "; ".join(problems)
    return None, f"{sentence[:1].upper()}{sentence[1:]}. The pictures show the last possible state."


def _describe_outcome(run: Trajectory) -> str:
    """Return in a line how a run ended, how accurate it is, and what was computed."""
    lines, _ = format_closing_lines(run, MAX_LINE_LENGTH)
    return "; ".join([*lines, f"engine {run.cost.engine}, {1e3 * run.cost.wall_time:.3g} ms"])


def _describe_readings(run: Trajectory) -> list[dict[str, Any]]:
    """Return the readings at the end of a run, SI and in words, with the estimates of their errors."""
    described = []
    for name, values in run.readings.items():
        value, unit = float(values[-1]), run.units.get(name, "")
        if math.isfinite(value):
            text = format_quantity(value, unit)
            described.append({"name": name, "words": format_name(name), "unit": unit, "value": value, "text": text})
            described[-1]["error"] = run.reading_errors.get(name)
    return described

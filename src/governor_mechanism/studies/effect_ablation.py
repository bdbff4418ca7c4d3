"""The bill of a scene's effects: what each changes in the readings, what it costs, and which may be left out.

The scene is run as it is, and once for each effect with that one effect switched: off where the scene lists it, on
where it does not and needs no numbers. What an effect costs is the run with it against the run without it.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.effects.bell_crank_masses import BellCranks
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import PLAY, Play
from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.engines import choose
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import foreign_effects
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import FIXED, Scene, Spindle
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.scenes.parser import scene_from_document

REPEATS = 3
"""Runs of each kind; the shortest time counts."""

UNEVEN = "spindle.unevenness"

KEYS = (
    "gravity",
    "centrifugal",
    "rods",
    "spring",
    "dry_friction",
    "oil_brake",
    "stops",
    "play",
    "masses",
    "bell_cranks",
)
"""Of [effects], in the order in which they are told."""

PLAIN: Mapping[str, Effect] = {"gravity": Gravity(), "centrifugal": Centrifugal()}
"""Effects that need no numbers."""


BUILT: Mapping[str, Effect] = {
    "rods": Rods(arm_mass=1.0),
    "play": Play(width=1.0),
    "masses": Masses(crank=1.0),
    "bell_cranks": BellCranks(mass=1.0),
}
"""An example of each effect that bodies are built from; not every machine has them."""


@dataclass(frozen=True, kw_only=True)
class Bill:
    """What a run with or without an effect took: evaluations of the equations of motion, steps, events, seconds."""

    evaluations: int
    steps: int
    events: int
    seconds: float


@dataclass(frozen=True, kw_only=True)
class Toggled:
    """One effect switched: `changes` is the largest change of each reading (SI) over the times both runs reached.

    relative is the largest of them in units of the readings' scales, that of most_changed; None where no run could be
    made. with_it and without_it are the two bills; note says what is not as it should be.
    """

    effect: str
    listed: bool
    changes: Mapping[str, float]
    most_changed: str
    relative: float | None
    with_it: Bill | None
    without_it: Bill | None
    note: str = ""

    @property
    def time_ratio(self) -> float | None:
        """How many times longer a run takes with the effect than without it; None where one of them ends early."""
        if self.with_it is None or self.without_it is None or self.note:
            return None
        return self.with_it.seconds / self.without_it.seconds


@dataclass(frozen=True, kw_only=True)
class EffectsStudy:
    """All effects of a scene, and those tried beside them; accuracy is what was asked of the runs."""

    scene: Scene
    accuracy: float
    engine: str
    base: Bill
    rows: tuple[Toggled, ...]
    untried: tuple[str, ...]

    @property
    def idle(self) -> tuple[str, ...]:
        """Listed effects that change every reading by less than the accuracy: leave those out."""
        return tuple(row.effect for row in self.rows if row.listed and self._small(row))

    @property
    def missing(self) -> tuple[str, ...]:
        """Effects that are not listed and would change some reading by more than the accuracy."""
        return tuple(
            row.effect for row in self.rows if not row.listed and row.relative is not None and not self._small(row)
        )

    def __str__(self) -> str:
        """A line for each effect, and what to leave out."""
        lines = [f"{self.scene.title}: engine {self.engine}, accuracy {self.accuracy:g}, {_told(self.base)}"]
        lines += [_line(row, small=self._small(row)) for row in self.rows]
        if self.idle:
            lines.append(f"leave out: {', '.join(self.idle)} (no reading changes by more than the asked accuracy)")
        if self.missing:
            lines.append(f"not listed, though it would show: {', '.join(self.missing)}")
        if self.untried:
            lines.append(f"not listed, and not tried for want of numbers: {', '.join(self.untried)}")
        return "\n".join(lines)

    def as_json(self) -> dict[str, Any]:
        """All of it as plain values."""
        rows = [asdict(row) | {"changes": dict(row.changes), "time_ratio": row.time_ratio} for row in self.rows]
        told = {"title": self.scene.title, "engine": self.engine, "accuracy": self.accuracy, "base": asdict(self.base)}
        lists = {"leave_out": list(self.idle), "missing": list(self.missing), "untried": list(self.untried)}
        return {**told, "effects": rows, **lists}

    def _small(self, row: Toggled) -> bool:
        return row.relative is not None and row.relative < self.accuracy


def _told(bill: Bill) -> str:
    events = f", {bill.events} events" if bill.events else ""
    return f"{bill.evaluations:,} evaluations, {bill.steps:,} steps{events}, {bill.seconds * 1e3:.3g} ms"


def _line(row: Toggled, *, small: bool) -> str:
    name = f"{row.effect}{'' if row.listed else ' (not listed)'}"
    if row.relative is None or row.with_it is None or row.without_it is None:
        return f"{name:24} {row.note}"
    verdict = "changes nothing you asked for" if small else f"changes {row.most_changed.replace('_', ' ')} most"
    if row.note:
        return f"{name:24} {row.relative:8.1e}  {verdict}; {row.note}"
    cost = f"time x {row.time_ratio:.2f}, evaluations {row.without_it.evaluations:,} -> {row.with_it.evaluations:,}"
    events = f", events {row.without_it.events} -> {row.with_it.events}" if row.with_it.events else ""
    return f"{name:24} {row.relative:8.1e}  {verdict}; {cost}{events}"


def effects_study(
    scene: Scene,
    engine: str = "auto",
    accuracy: float | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> EffectsStudy:
    """Run a scene with each effect switched in turn, all by one engine at one accuracy.

    progress is told how many of all have been run. Raises MechanismError where the scene itself cannot be run.
    """
    chosen, _ = choose(scene.run.engine if engine == "auto" else engine, scene, accuracy)
    asked = scene.run.accuracy if accuracy is None else accuracy

    def ran(which: Scene) -> tuple[Trajectory, Bill]:
        runs = [chosen.run(which, accuracy=asked) for _ in range(REPEATS)]
        return runs[0], _bill(min(runs, key=lambda run: run.cost.wall_time))

    base, bill = ran(scene)
    if not base.times.size:
        raise MechanismError(f"the scene itself comes to nothing: {base.message}")
    switched = dict(_switched(scene))
    rows = []
    for done, (name, (listed, make)) in enumerate(switched.items(), start=1):
        rows.append(_toggled(name, listed, base, bill, make, ran))
        if progress is not None:
            progress(done, len(switched))
    given = [key for key in KEYS if key in switched]
    return EffectsStudy(
        scene=scene,
        accuracy=asked,
        engine=chosen.name,
        base=bill,
        rows=tuple(rows),
        untried=tuple(key for key in KEYS if key not in given and not _foreign(scene, key)),
    )


def _foreign(scene: Scene, key: str) -> bool:
    """Whether no machine of the scene's kind can have an effect."""
    if key not in BUILT:
        return False
    kind = MACHINES.get(scene.part.machine)
    listed = [BUILT[key]]
    return bool(kind.effect_problems(listed) if kind else foreign_effects(scene.part.machine, listed))


def _bill(run: Trajectory) -> Bill:
    cost = run.cost
    evaluations = cost.evaluations.get("equations of motion", max(cost.evaluations.values(), default=0))
    return Bill(evaluations=evaluations, steps=cost.steps, events=cost.events, seconds=cost.wall_time)


def _toggled(
    name: str,
    listed: bool,
    base: Trajectory,
    bill: Bill,
    make: Callable[[], Scene],
    ran: Callable[[Scene], tuple[Trajectory, Bill]],
) -> Toggled:
    try:
        other, others = ran(make())
    except MechanismError as error:
        return Toggled(
            effect=name,
            listed=listed,
            changes={},
            most_changed="",
            relative=None,
            with_it=bill if listed else None,
            without_it=None if listed else bill,
            note=f"cannot be switched: {error.problems[0]}",
        )
    changes = dict(_changes(base, other))
    scaled = {reading: change / base.scales[reading] for reading, change in changes.items()}
    most = max(scaled, key=lambda reading: scaled[reading], default="")
    return Toggled(
        effect=name,
        listed=listed,
        changes=changes,
        most_changed=most,
        relative=scaled.get(most, 0.0),
        with_it=bill if listed else others,
        without_it=others if listed else bill,
        note=_early(base, other, listed),
    )


def _changes(base: Trajectory, other: Trajectory) -> Iterator[tuple[str, float]]:
    shared = min(len(base.times), len(other.times))
    for name, values in base.readings.items():
        if name in other.readings:
            yield name, float(np.max(np.abs(values[:shared] - other.readings[name][:shared]), initial=0.0))


def _early(base: Trajectory, other: Trajectory, listed: bool) -> str:
    if other.outcome.ok or other.outcome is base.outcome is Outcome.ACCURACY_MISSED:
        return ""
    return f"the run {'without' if listed else 'with'} it ends early: {other.detail or other.outcome.value}"


Switch = tuple[bool, Callable[[], Scene]]


def _switched(scene: Scene) -> Iterator[tuple[str, Switch]]:
    """Each effect that can be switched: whether it is listed, and how to make the scene with it switched."""
    if scene.document:
        listed = {key for key, value in dict(scene.document.get("effects", {})).items() if value is not False}
        for key in (key for key in KEYS if key in listed):
            yield key, (True, partial(_read_without, scene, key))
    else:
        for kind in sorted({type(effect) for effect in scene.effects}, key=lambda one: one.__name__):
            yield kind.__name__, (True, partial(_without, scene, kind))
    turning = scene.part.plane != FIXED
    for name, plain in PLAIN.items():
        if type(plain) not in {type(effect) for effect in scene.effects} and (turning or name == "gravity"):
            yield name, (False, partial(replace, scene, effects=(*scene.effects, plain)))
    if isinstance(scene.spindle, Spindle) and scene.spindle.unevenness:
        yield UNEVEN, (True, partial(replace, scene, spindle=replace(scene.spindle, unevenness=0.0)))


def _read_without(scene: Scene, key: str) -> Scene:
    """The scene read anew with one effect switched off, for some effects build the mechanism."""
    document = copy.deepcopy(dict(scene.document))
    document["effects"] = dict(document["effects"]) | {key: False}
    if key == "play":
        start = dict(document.get("start", {}))
        document["start"] = {name: value for name, value in start.items() if PLAY not in name}
    found = scene_from_document(document, scene.source)
    return replace(found, run=scene.run)


def _without(scene: Scene, kind: type[Effect]) -> Scene:
    if kind in {type(example) for example in BUILT.values()}:
        raise MechanismError(f"{kind.__name__} is built into the mechanism of a scene that comes from no file")
    return replace(scene, effects=tuple(effect for effect in scene.effects if type(effect) is not kind))

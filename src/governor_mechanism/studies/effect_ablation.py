"""What each effect of a scene changes in its readings, what it costs, and which effects can be left out.

The scene is run as it is, and once per effect with that effect switched: off if the scene lists it, on if it does not and needs no
parameters. The cost of an effect is the run with it against the run without it.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import unsupported_effect_messages
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import FIXED_PLANE, Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.text_table import format_table

N_TIMED_RUNS = 3
"""Number of timed runs; the shortest time counts."""

SPEED_FLUCTUATION_KEY = "spindle.speed_fluctuation"
"""Key of the speed fluctuation, which is switched like an effect."""

TOGGLED_EFFECT_KEYS = ("gravity", "centrifugal", "rods", "spring", "dry_friction", "dashpot", "stops", "clearance", "masses", "bell_cranks")
"""Keys of [effects] in the order of the report."""

PARAMETERLESS_EFFECTS: Mapping[str, Effect] = {"gravity": Gravity(), "centrifugal": Centrifugal()}
"""Effects without parameters."""


BODY_EFFECT_EXAMPLES: Mapping[str, Effect] = {
    "rods": RodMasses(arm_mass=1.0),
    "clearance": Clearance(width=1.0),
    "masses": CrankMasses(crank=1.0),
    "bell_cranks": BellCrankMasses(mass=1.0),
}
"""An example of each effect that changes the bodies of a machine; not every machine supports them."""


@dataclass(frozen=True, kw_only=True)
class EffectCost:
    """Cost of a run: evaluations of the equations of motion, steps, events, wall time (s)."""

    evaluations: int
    steps: int
    events: int
    wall_time: float


@dataclass(frozen=True, kw_only=True)
class EffectComparison:
    """One switched effect and its changes over the times that both runs reach.

    `changes` is the largest change of each reading (SI); relative_change is the largest in units of the readings' scales, that of
    most_changed_reading, and None without a run. cost_with and cost_without are the costs; note describes a problem.
    """

    effect: str
    listed: bool
    changes: Mapping[str, float]
    most_changed_reading: str
    relative_change: float | None
    cost_with: EffectCost | None
    cost_without: EffectCost | None
    note: str = ""

    @property
    def time_ratio(self) -> float | None:
        """Ratio of the wall times with and without the effect; None if one run ends early."""
        if self.cost_with is None or self.cost_without is None or self.note:
            return None
        return self.cost_with.wall_time / self.cost_without.wall_time


@dataclass(frozen=True, kw_only=True)
class EffectsStudy:
    """Effects of a scene and of those not listed that can be tried.

    Attributes
    ----------
    scene
        The scene.
    accuracy
        Requested accuracy of the runs.
    engine
        Name of the engine.
    base_cost
        Cost of the scene as it is.
    rows
        The switched effects.
    untried
        Keys of effects that need parameters and are not listed.
    """

    scene: Scene
    accuracy: float
    engine: str
    base_cost: EffectCost
    rows: tuple[EffectComparison, ...]
    untried: tuple[str, ...]

    @property
    def negligible(self) -> tuple[str, ...]:
        """Listed effects that change every reading by less than the accuracy; they can be left out."""
        return tuple(row.effect for row in self.rows if row.listed and self._is_negligible(row))

    @property
    def missing(self) -> tuple[str, ...]:
        """Effects that are not listed and would change a reading by more than the accuracy."""
        return tuple(row.effect for row in self.rows if not row.listed and row.relative_change is not None and not self._is_negligible(row))

    def __str__(self) -> str:
        """Return a table with one line per effect, the notes, and what can be left out."""
        cost = self.base_cost
        totals = f"{cost.evaluations:,} evaluations, {cost.steps:,} steps, {cost.events:,} events, {cost.wall_time * 1e3:.3g} ms"
        lists = (
            ("leave out", self.negligible, " (no reading changes by more than the accuracy)"),
            ("not listed, but significant", self.missing, ""),
            ("not listed and not tried, because they need parameters", self.untried, ""),
        )
        return "\n".join(
            [
                f"{self.scene.title}: engine {self.engine}, accuracy {self.accuracy:g}, {totals}",
                format_table(("effect", "change", "largest in", "time", "evaluations", "events"), map(self._cells, self.rows), "lrlr"),
                *(f"{row.effect}: {row.note}" for row in self.rows if row.note),
                *(f"{label}: {', '.join(names)}{remark}" for label, names, remark in lists if names),
            ]
        )

    def as_json(self) -> dict[str, Any]:
        """Return the study as plain values."""
        rows = [asdict(row) | {"changes": dict(row.changes), "time_ratio": row.time_ratio} for row in self.rows]
        header = {"title": self.scene.title, "engine": self.engine, "accuracy": self.accuracy, "base": asdict(self.base_cost)}
        lists = {"leave_out": list(self.negligible), "missing": list(self.missing), "untried": list(self.untried)}
        return {**header, "effects": rows, **lists}

    def _is_negligible(self, row: EffectComparison) -> bool:
        return row.relative_change is not None and row.relative_change < self.accuracy

    def _cells(self, row: EffectComparison) -> tuple[str, ...]:
        """Return the cells of a comparison; costs are without -> with the effect."""
        name = row.effect if row.listed else f"{row.effect} (not listed)"
        if row.relative_change is None or row.cost_with is None or row.cost_without is None:
            return name, "", "", "", "", ""
        largest = "negligible" if self._is_negligible(row) else row.most_changed_reading.replace("_", " ")
        ratio = "" if row.time_ratio is None else f"x {row.time_ratio:.2f}"
        pairs = [(row.cost_without.evaluations, row.cost_with.evaluations), (row.cost_without.events, row.cost_with.events)]
        return name, f"{row.relative_change:.1e}", largest, ratio, *(f"{without:,} -> {with_it:,}" for without, with_it in pairs)


def run_effects_study(
    scene: Scene, engine: str = "auto", accuracy: float | None = None, progress: Callable[[int, int], None] | None = None
) -> EffectsStudy:
    """Run a scene with each effect switched in turn, all by one engine at one accuracy.

    Parameters
    ----------
    scene
        The scene.
    engine
        Name of an engine, or "auto".
    accuracy
        Accuracy of the runs; None: that of the scene.
    progress
        Called with the number of finished runs and the number of all.

    Returns
    -------
    EffectsStudy
        Changes and costs of the effects.

    Raises
    ------
    MechanismError
        If the scene itself cannot be run.
    """
    chosen, _ = select_engine(scene.run.engine if engine == "auto" else engine, scene, accuracy)
    requested_accuracy = scene.run.accuracy if accuracy is None else accuracy

    def run_repeatedly(variant: Scene) -> tuple[Trajectory, EffectCost]:
        runs = [chosen.run(variant, accuracy=requested_accuracy) for _ in range(N_TIMED_RUNS)]
        return runs[0], _cost_of_run(min(runs, key=lambda run: run.cost.wall_time))

    base_run, base_cost = run_repeatedly(scene)
    if not base_run.times.size:
        raise MechanismError(f"the scene itself cannot be run: {base_run.message}")
    switches = dict(_effect_switches(scene))
    rows = []
    for n_done, (name, (listed, make_scene)) in enumerate(switches.items(), start=1):
        rows.append(_compare_toggled(name, listed, base_run, base_cost, make_scene, run_repeatedly))
        if progress is not None:
            progress(n_done, len(switches))
    return EffectsStudy(
        scene=scene,
        accuracy=requested_accuracy,
        engine=chosen.name,
        base_cost=base_cost,
        rows=tuple(rows),
        untried=tuple(key for key in TOGGLED_EFFECT_KEYS if key not in switches and not _is_inapplicable(scene, key)),
    )


def _is_inapplicable(scene: Scene, key: str) -> bool:
    """Return whether the machine of the scene cannot have the effect."""
    if key not in BODY_EFFECT_EXAMPLES:
        return False
    machine_class = MACHINES.get(scene.part.machine)
    listed = [BODY_EFFECT_EXAMPLES[key]]
    return bool(machine_class.effect_problems(listed) if machine_class else unsupported_effect_messages(scene.part.machine, listed))


def _cost_of_run(run: Trajectory) -> EffectCost:
    cost = run.cost
    evaluations = cost.evaluations.get("equations of motion", max(cost.evaluations.values(), default=0))
    return EffectCost(evaluations=evaluations, steps=cost.steps, events=cost.events, wall_time=cost.wall_time)


def _compare_toggled(
    name: str,
    listed: bool,
    base_run: Trajectory,
    base_cost: EffectCost,
    make_scene: Callable[[], Scene],
    run_repeatedly: Callable[[Scene], tuple[Trajectory, EffectCost]],
) -> EffectComparison:
    changes: dict[str, float] = {}
    toggled_cost = None
    try:
        toggled_run, toggled_cost = run_repeatedly(make_scene())
    except MechanismError as error:
        note = f"cannot be switched: {error.problems[0]}"
    else:
        changes, note = dict(_reading_changes(base_run, toggled_run)), _early_end_note(base_run, toggled_run, listed)
    scaled_changes = {reading: change / base_run.scales[reading] for reading, change in changes.items()}
    most_changed = max(scaled_changes, key=lambda reading: scaled_changes[reading], default="")
    return EffectComparison(
        effect=name,
        listed=listed,
        changes=changes,
        most_changed_reading=most_changed,
        relative_change=None if toggled_cost is None else scaled_changes.get(most_changed, 0.0),
        cost_with=base_cost if listed else toggled_cost,
        cost_without=toggled_cost if listed else base_cost,
        note=note,
    )


def _reading_changes(base_run: Trajectory, toggled_run: Trajectory) -> Iterator[tuple[str, float]]:
    n_shared = min(len(base_run.times), len(toggled_run.times))
    for name, values in base_run.readings.items():
        if name in toggled_run.readings:
            yield name, float(np.max(np.abs(values[:n_shared] - toggled_run.readings[name][:n_shared]), initial=0.0))


def _early_end_note(base_run: Trajectory, toggled_run: Trajectory, listed: bool) -> str:
    if toggled_run.outcome.ok or toggled_run.outcome is base_run.outcome is Outcome.ACCURACY_MISSED:
        return ""
    return f"the run {'without' if listed else 'with'} it ends early: {toggled_run.detail or toggled_run.outcome.value}"


EffectSwitch = tuple[bool, Callable[[], Scene]]


def _effect_switches(scene: Scene) -> Iterator[tuple[str, EffectSwitch]]:
    """Yield each effect that can be switched: its name, whether it is listed, and how to build the scene with it switched."""
    if scene.document:
        listed = {key for key, value in dict(scene.document.get("effects", {})).items() if value is not False}
        for key in (key for key in TOGGLED_EFFECT_KEYS if key in listed):
            yield key, (True, partial(_reparse_without, scene, key))
    else:
        for effect_class in sorted({type(effect) for effect in scene.effects}, key=lambda one: one.__name__):
            yield effect_class.__name__, (True, partial(_drop_effect, scene, effect_class))
    can_rotate = scene.part.plane != FIXED_PLANE
    for name, default_effect in PARAMETERLESS_EFFECTS.items():
        if type(default_effect) not in {type(effect) for effect in scene.effects} and (can_rotate or name == "gravity"):
            yield name, (False, partial(replace, scene, effects=(*scene.effects, default_effect)))
    if isinstance(scene.spindle, Spindle) and scene.spindle.speed_fluctuation:
        yield (SPEED_FLUCTUATION_KEY, (True, partial(replace, scene, spindle=replace(scene.spindle, speed_fluctuation=0.0))))


def _reparse_without(scene: Scene, key: str) -> Scene:
    """Return the scene parsed again with one effect off, because some effects change the bodies."""
    document = copy.deepcopy(dict(scene.document))
    document["effects"] = dict(document["effects"]) | {key: False}
    if key == "clearance":
        start = dict(document.get("start", {}))
        document["start"] = {name: value for name, value in start.items() if CLEARANCE_READING not in name}
    parsed = parse_scene_document(document, scene.source)
    return replace(parsed, run=scene.run)


def _drop_effect(scene: Scene, effect_class: type[Effect]) -> Scene:
    if effect_class in {type(example) for example in BODY_EFFECT_EXAMPLES.values()}:
        raise MechanismError(f"{effect_class.__name__} is part of the mechanism, which can be rebuilt for a scene from a file only")
    return scene.with_changes(effects=tuple(effect for effect in scene.effects if type(effect) is not effect_class))

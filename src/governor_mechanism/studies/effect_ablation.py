"""What each effect of a scene changes in its readings, what it costs, and which effects can be left out.

The scene is run as it is, and once per effect with that effect switched: off if the scene lists it, on if it does not and needs no
parameters. A contact of outlines is switched off like an effect. The cost of an effect is the run with it against the run without it.
"""

import copy
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.effects.holding import CLEARANCE_READING
from governor_mechanism.effects.registry import EFFECTS
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.result import Column, Result, format_columns
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.units.quantities import format_reading_name
from governor_mechanism.units.text_table import short_repr

N_TIMED_RUNS = 3
"""Number of timed runs; the shortest time counts."""

SPEED_FLUCTUATION_KEY = "spindle.speed_fluctuation"
"""Key of the speed fluctuation, which is switched like an effect."""

PARAMETERLESS_EFFECTS: Mapping[str, Effect] = {"gravity": Gravity(), "centrifugal": Centrifugal()}
"""Effects without parameters."""


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
class EffectsStudy(Result):
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

    __repr__ = short_repr

    figure = "render.figures.work_precision.effect_ablation_figure"
    record = ("title=scene.title", "accuracy", "engine", "untried", "base=base_cost", "effects=rows", "leave_out=negligible", "missing")
    index = "effect"

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the switched effects; costs are without -> with the effect, and empty without a run."""
        return (
            Column("effect", "effect", lambda row: row.effect if row.listed else f"{row.effect} (not listed)"),
            Column("listed"),
            Column("relative_change", "change", ".1e"),
            Column("most_changed_reading", "largest in", self._format_largest),
            Column("time_ratio", "time", "x {time_ratio:.2f}", side="r"),
            Column("", "evaluations", "{cost_without.evaluations:,} -> {cost_with.evaluations:,}", side="r"),
            Column("", "events", "{cost_without.events:,} -> {cost_with.events:,}", side="r"),
            Column("note"),
            *(Column(name, in_table=False) for name in ("changes", "cost_with", "cost_without")),
        )

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
                format_columns(self.columns, self.rows),
                *(f"{row.effect}: {row.note}" for row in self.rows if row.note),
                *(f"{label}: {', '.join(names)}{remark}" for label, names, remark in lists if names),
            ]
        )

    def _is_negligible(self, row: EffectComparison) -> bool:
        return row.relative_change is not None and row.relative_change < self.accuracy

    def _format_largest(self, row: EffectComparison) -> str:
        if row.relative_change is None:
            return ""
        return "negligible" if self._is_negligible(row) else format_reading_name(row.most_changed_reading)


def run_effects_study(
    scene: Scene,
    engine: str = "auto",
    accuracy: float | None = None,  # accuracy of the runs; None: that of the scene
    # called with the number of finished runs and the number of all
    progress: Callable[[int, int], None] | None = None,
) -> EffectsStudy:
    """Run a scene with each effect switched in turn, all by one engine at one accuracy, and return changes and costs."""
    chosen, _ = select_engine(scene.run.engine if engine == "auto" else engine, scene, accuracy)
    requested_accuracy = scene.run.accuracy if accuracy is None else accuracy

    def run_repeatedly(make_scene: Callable[[], Scene]) -> tuple[Trajectory, EffectCost]:
        variant = make_scene()
        runs = [chosen.run(variant, accuracy=requested_accuracy) for _ in range(N_TIMED_RUNS)]
        return runs[0], _cost_of_run(min(runs, key=lambda run: run.cost.wall_time))

    base_run, base_cost = run_repeatedly(lambda: scene)
    if not base_run.times.size:
        raise MechanismError(f"the scene itself cannot be run: {base_run.message}")
    parts = [(f"{part.name}." if len(scene.parts) > 1 else "", part) for part in scene.parts]
    switches = {f"{prefix}{name}": switch for prefix, part in parts for name, switch in _effect_switches(scene, part)}
    rows = []
    for name, (listed, make_scene) in switches.items():
        rows.append(_compare_toggled(name, listed, base_run, base_cost, partial(run_repeatedly, make_scene)))
        if progress is not None:
            progress(len(rows), len(switches))
    applicable = [f"{prefix}{effect.key}" for prefix, part in parts for effect in EFFECTS if _is_applicable(part, effect)]
    untried = tuple(name for name in applicable if name not in switches)
    return EffectsStudy(
        scene=scene, accuracy=requested_accuracy, engine=chosen.name, base_cost=base_cost, rows=tuple(rows), untried=untried
    )


def _is_applicable(part: Part, effect: type[Effect]) -> bool:
    """Return whether the machine of a part can have the effect."""
    machine_class = MACHINES.get(part.machine)
    if effect is Centrifugal:
        return part.turns
    return not effect.changes_bodies_of or (machine_class is not None and effect in machine_class.supported_effects)


def _cost_of_run(run: Trajectory) -> EffectCost:
    cost = run.cost
    evaluations = cost.evaluations.get("equations of motion", max(cost.evaluations.values(), default=0))
    return EffectCost(evaluations=evaluations, steps=cost.steps, events=cost.events, wall_time=cost.wall_time)


def _compare_toggled(
    name: str, listed: bool, base_run: Trajectory, base_cost: EffectCost, run_toggled: Callable[[], tuple[Trajectory, EffectCost]]
) -> EffectComparison:
    changes, toggled_cost = dict[str, float](), None
    try:
        toggled_run, toggled_cost = run_toggled()
        changes = _reading_changes(base_run, toggled_run)
        note = _early_end_note(base_run, toggled_run, listed)
    except MechanismError as error:
        note = f"cannot be switched: {error.problems[0]}"
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


def _reading_changes(base_run: Trajectory, toggled_run: Trajectory) -> dict[str, float]:
    n_shared = min(len(base_run.times), len(toggled_run.times))
    return {
        name: float(np.max(np.abs(values[:n_shared] - toggled_run.readings[name][:n_shared]), initial=0.0))
        for name, values in base_run.readings.items()
        if name in toggled_run.readings
    }


def _early_end_note(base_run: Trajectory, toggled_run: Trajectory, listed: bool) -> str:
    if toggled_run.outcome.ok or toggled_run.outcome is base_run.outcome is Outcome.ACCURACY_MISSED:
        return ""
    return f"the run {'without' if listed else 'with'} it ends early: {toggled_run.detail or toggled_run.outcome.value}"


EffectSwitch = tuple[bool, Callable[[], Scene]]


def _effect_switches(scene: Scene, part: Part) -> Iterator[tuple[str, EffectSwitch]]:
    """Yield each effect of a part that can be switched: its name, whether it is listed, and how to build the scene with it switched."""
    if scene.document:
        listed = {key for key, value in dict(_part_table(scene.document, part).get("effects", {})).items() if value is not False}
        for key in (effect.key for effect in EFFECTS if effect.key in listed):
            yield key, (True, partial(_reparse_without, scene, part, key))
    else:
        for effect_class in sorted({type(effect) for effect in part.effects}, key=lambda one: one.__name__):
            yield effect_class.__name__, (True, partial(_drop_effect, scene, part, effect_class))
    for name, default_effect in PARAMETERLESS_EFFECTS.items():
        if type(default_effect) not in {type(effect) for effect in part.effects} and (part.turns or name == "gravity"):
            yield name, (False, partial(_replace_part, scene, part, effects=(*part.effects, default_effect)))
    for k, name in enumerate(_contacts_of(part)):
        yield f"contact {name}", (True, partial(_without_contact, scene, part, k, name))
    if isinstance(part.spindle, Spindle) and part.spindle.speed_fluctuation:
        steady = replace(part.spindle, speed_fluctuation=0.0)
        yield SPEED_FLUCTUATION_KEY, (True, partial(_replace_part, scene, part, spindle=steady))


def _contacts_of(part: Part) -> list[str]:
    """Return the names of the contacts of outlines, in the order in which a scene file has them."""
    return list(dict.fromkeys(reading.contact for reading in part.mechanism.readings if isinstance(reading, OutlineGap)))


def _without_contact(scene: Scene, part: Part, k: int, name: str) -> Scene:
    """Return the scene without a contact, the k-th one, and without the start values of its gaps."""
    if not scene.document:
        readings = tuple(one for one in part.mechanism.readings if not isinstance(one, OutlineGap) or one.contact != name)
        return _replace_part(scene, part, mechanism=replace(part.mechanism, readings=readings))
    document = copy.deepcopy(dict(scene.document))
    table = _part_table(document, part)
    table["contact"] = [*table["contact"][:k], *table["contact"][k + 1 :]]
    table["start"] = {key: value for key, value in table.get("start", {}).items() if not key.startswith((f"{name}_gap", f"{name}_rate"))}
    return replace(parse_scene_document(document, scene.source), run=scene.run)


def _part_table(document: Mapping[str, Any], part: Part) -> Any:
    """Return the table of a part: the document itself if it has no tables of parts."""
    return document["part"][part.name] if "part" in document else document


def _replace_part(scene: Scene, part: Part, **changes: Any) -> Scene:
    """Return the scene with changed fields of one part."""
    return replace(scene, parts=tuple(replace(one, **changes) if one is part else one for one in scene.parts))


def _reparse_without(scene: Scene, part: Part, key: str) -> Scene:
    """Return the scene parsed again with one effect off, because some effects change the bodies."""
    document = copy.deepcopy(dict(scene.document))
    table = _part_table(document, part)
    table["effects"] = dict(table["effects"]) | {key: False}
    if key == "clearance":
        table["start"] = {name: value for name, value in table.get("start", {}).items() if CLEARANCE_READING not in name}
    return replace(parse_scene_document(document, scene.source), run=scene.run)


def _drop_effect(scene: Scene, part: Part, effect_class: type[Effect]) -> Scene:
    if effect_class.changes_bodies_of:
        raise MechanismError(f"{effect_class.__name__} is part of the mechanism, which can be rebuilt for a scene from a file only")
    return _replace_part(scene, part, effects=tuple(effect for effect in part.effects if type(effect) is not effect_class))

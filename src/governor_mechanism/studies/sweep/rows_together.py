"""Rows that differ in dimensions and spindle speed only: what they share is parsed and prepared once.

They need the engine `reduced`, and a scene whose forces are all in the table of the reduced model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from governor_mechanism.engines import ReducedEngine, select_engine
from governor_mechanism.engines.certificate import initial_tolerance
from governor_mechanism.engines.reduced.batch import ReducedBatch, UncertifiedResult
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep.quantities import RunQuantity, find_quantity_reading

DIMENSION_PREFIX = "dimensions."
"""First part of the key of a dimension."""

SPEED_KEY = "spindle.speed"
"""Key of the spindle speed."""


def is_quick_key(key: str) -> bool:
    """Return whether rows that differ in the number of a key may be run together."""
    return key == SPEED_KEY or key.startswith(DIMENSION_PREFIX)


@dataclass(frozen=True)
class RowsTogether:
    """Scene, spindle, machine and dimensions before they are changed, and the batch of the runs."""

    scene: Scene
    spindle: Spindle
    machine_class: type[Machine]
    dimensions: Mapping[str, Any]
    batch: ReducedBatch

    def run(self, values: Mapping[str, Any]) -> UncertifiedResult | None:
        """Return the run with values of keys, or None if a row of its own must tell why that does not work."""
        try:
            scene = self._change_scene(values)
        except MechanismError:
            return None
        return None if scene is None else self.batch.run(scene)

    def _change_scene(self, values: Mapping[str, Any]) -> Scene | None:
        """Return the scene with values of keys, or None if it cannot start there. Raise MechanismError if a value is wrong."""
        changes: dict[str, Any] = {}
        changed = {key.removeprefix(DIMENSION_PREFIX): value for key, value in values.items() if key != SPEED_KEY}
        if changed:
            machine = self.machine_class(**{**self.dimensions, **changed})
            if machine.start_problems(self.scene.start.values):
                return None
            changes["mechanism"] = machine.mechanism_with_effects(self.scene.effects)
        if SPEED_KEY in values:
            changes["spindle"] = replace(self.spindle, times=(0.0,), speeds=(values[SPEED_KEY],))
        return self.scene.with_changes(**changes)


def prepare_rows(
    document: Mapping[str, Any], quantities: Sequence[RunQuantity], engine: str, accuracy: float | None
) -> RowsTogether | None:
    """Return what the rows of a sweep share, or None if they must be run one by one.

    Parameters
    ----------
    document
        Document of the scene.
    quantities
        Numbers to take from each run.
    engine
        Name of the engine of all rows, or "auto".
    accuracy
        Relative accuracy of all rows; None keeps that of the scene.

    Returns
    -------
    RowsTogether | None
        Scene, machine and batch.
    """
    from governor_mechanism.scenes.schema import dimensions_table_model  # slow to import: pydantic
    from governor_mechanism.scenes.table import validate

    scene = parse_scene_document(document)
    if len(scene.parts) != 1 or not isinstance(scene.spindle, Spindle):
        return None
    reading_names = [find_quantity_reading(one, scene) for one in quantities]
    machine_class = MACHINES.get(scene.part.machine)
    asked_accuracy = scene.run.accuracy if accuracy is None else accuracy
    chosen_engine, _ = select_engine(scene.run.engine if engine == "auto" else engine, scene, asked_accuracy)
    if machine_class is None or None in reading_names or chosen_engine.name != ReducedEngine.name or chosen_engine.refusal(scene):
        return None
    dimensions = validate(dimensions_table_model(machine_class), document["dimensions"]).given_values()
    names = [name for name in dict.fromkeys(reading_names) if name]
    batch = ReducedBatch(scene, names, initial_tolerance(asked_accuracy), ReducedEngine().step_limit(scene))
    return RowsTogether(scene, scene.spindle, machine_class, dimensions, batch)

"""Fast path for the rows of a sweep over dimensions: what all rows share is parsed and prepared once.

It needs the engine `reduced`, runs without certificates, and a scene whose forces are all in the tables of the reduced
model. A row that does not fit is computed on its own.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from governor_mechanism.engines import ReducedEngine, select_engine
from governor_mechanism.engines.certificate import initial_tolerance
from governor_mechanism.engines.reduced.batch import ReducedBatch, UncertifiedResult
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.studies.sweep.quantities import RunQuantity, find_quantity_reading

DIMENSION_PREFIX = "dimensions."
"""First part of the key of a dimension."""


class BatchedRows:
    """Uncertified runs of one scene with different dimensions."""

    def __init__(self, scene: Scene, machine_class: type[Machine], given_dimensions: Mapping[str, Any], batch: ReducedBatch) -> None:
        self._scene, self._machine_class, self._given_dimensions, self._batch = (scene, machine_class, given_dimensions, batch)

    def run_uncertified(self, dimensions: Mapping[str, float]) -> UncertifiedResult | None:
        """Return the run with changed dimensions (SI), or None if the fast path does not apply."""
        scene = self._scene
        try:
            machine = self._machine_class(**{**self._given_dimensions, **dimensions})
            if machine.start_problems(scene.start.values):
                return None
            mechanism = machine.mechanism_with_effects(scene.effects)
        except MechanismError:
            return None
        return self._batch.run(scene.with_changes(mechanism=mechanism))


def make_batched_rows(
    document: Mapping[str, Any], axes: Sequence[SweepAxis], quantities: Sequence[RunQuantity], engine: str, accuracy: float | None
) -> BatchedRows | None:
    """Return the fast path for the rows of a sweep, or None if it does not apply."""
    from governor_mechanism.scenes.schema import dimensions_table_model  # slow to import: pydantic
    from governor_mechanism.scenes.table import validate

    if not all(axis.key.startswith(DIMENSION_PREFIX) and axis.is_numeric for axis in axes):
        return None
    scene = parse_scene_document(document)
    reading_names = [find_quantity_reading(one, scene) for one in quantities]
    machine_class = MACHINES.get(scene.part.machine)
    requested_accuracy = scene.run.accuracy if accuracy is None else accuracy
    chosen_engine = select_engine(scene.run.engine if engine == "auto" else engine, scene, requested_accuracy)[0]
    if machine_class is None or None in reading_names or chosen_engine.name != ReducedEngine.name or chosen_engine.refusal(scene):
        return None
    given_dimensions = validate(dimensions_table_model(machine_class), document["dimensions"]).given_values()
    batch = ReducedBatch(
        scene, [name for name in dict.fromkeys(reading_names) if name], initial_tolerance(requested_accuracy), ReducedEngine().max_steps
    )
    return BatchedRows(scene, machine_class, given_dimensions, batch)

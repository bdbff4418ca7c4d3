"""Rows of a sweep over dimensions made all at once: what is the same in all is read and made once.

For the engine `reduced` without certificates, and scenes in which its tables are all that acts. A row that is not as
plain as the others is left to be made by itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from governor_mechanism.engines import ReducedEngine, choose
from governor_mechanism.engines.certificate import first_tolerance
from governor_mechanism.engines.reduced.batch import Batch, Glimpse
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import scene_from_document
from governor_mechanism.studies.sweep.parameters import Axis
from governor_mechanism.studies.sweep.quantities import Quantity, reading_named

DIMENSION = "dimensions."


class Rows:
    """Rides of one scene with other dimensions."""

    def __init__(self, scene: Scene, machine: type[Machine], given: Mapping[str, Any], batch: Batch) -> None:
        self._scene, self._machine, self._given, self._batch = scene, machine, given, batch

    def glimpse(self, dimensions: Mapping[str, float]) -> Glimpse | None:
        """The ride with some dimensions changed; None where there is none to be had so quickly."""
        scene = self._scene
        try:
            machine = self._machine(**{**self._given, **dimensions})
            if machine.start_problems(scene.start.values):
                return None
            mechanism = machine.mechanism_with(scene.effects)
        except MechanismError:
            return None
        return self._batch.glimpse(replace(scene, parts=(replace(scene.part, mechanism=mechanism),)))


def rows_together(
    document: Mapping[str, Any],
    axes: Sequence[Axis],
    quantities: Sequence[Quantity],
    engine: str,
    accuracy: float | None,
) -> Rows | None:
    """What makes the rows of such a sweep; None where it is of another kind."""
    from governor_mechanism.scenes.schema import dimensions_table, understood  # pydantic takes long to import

    if not all(axis.key.startswith(DIMENSION) and axis.numeric for axis in axes):
        return None
    scene = scene_from_document(document)
    names = [reading_named(one, scene) for one in quantities]
    machine = MACHINES.get(scene.part.machine)
    asked = scene.run.accuracy if accuracy is None else accuracy
    chosen = choose(scene.run.engine if engine == "auto" else engine, scene, asked)[0]
    if machine is None or None in names or chosen.name != ReducedEngine.name or chosen.refusal(scene):
        return None
    given, problems = understood(dimensions_table(machine), document["dimensions"], "dimensions")
    if problems:
        return None
    batch = Batch(
        scene, [name for name in dict.fromkeys(names) if name], first_tolerance(asked), ReducedEngine().max_steps
    )
    return Rows(scene, machine, given, batch)

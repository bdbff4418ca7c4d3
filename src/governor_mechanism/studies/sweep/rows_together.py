"""Rows that differ in dimensions and spindle speed only: what they share is parsed and prepared once.

They need the engine `reduced`, and a scene whose forces are all in the table of the reduced model.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from threading import Lock
from typing import Any

import numpy as np

from governor_mechanism.engines import ReducedEngine, select_engine
from governor_mechanism.engines.certificate import initial_tolerance
from governor_mechanism.engines.reduced.batch import ReducedBatch, UncertifiedResult
from governor_mechanism.engines.reduced.row_arrays import RecordedRows, lower_row
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.row_numbers import NotRecordable
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.sweep.quantities import RunQuantity, find_quantity_reading
from governor_mechanism.types import FloatArray

DIMENSION_PREFIX = "dimensions."
"""First part of the key of a dimension."""

SPEED_KEY = "spindle.speed"
"""Key of the spindle speed."""

MAX_RECORDS = 16
"""Number of structures of rows that are recorded; rows of further ones are lowered one by one."""


def is_quick_key(key: str) -> bool:
    """Return whether rows that differ in the number of a key may be run together."""
    return key == SPEED_KEY or key.startswith(DIMENSION_PREFIX)


class RowsTogether:
    """Rows whose description and lowering are recorded once for all rows of the same structure. Threads may share them.

    Parameters
    ----------
    keys
        Keys of the rows.
    scene
        Scene before it is changed.
    spindle
        Its spindle.
    machine_class
        Its machine.
    dimensions
        Dimensions of the machine before they are changed.
    batch
        Batch of the runs.
    """

    def __init__(
        self,
        keys: Sequence[str],
        scene: Scene,
        spindle: Spindle,
        machine_class: type[Machine],
        dimensions: Mapping[str, Any],
        batch: ReducedBatch,
    ) -> None:
        self._keys, self._scene, self._spindle = keys, scene, spindle
        self._machine_class, self._dimensions, self._batch = machine_class, dimensions, batch
        self._records: list[RecordedRows] = []
        self._n_trials, self._lock = 0, Lock()

    @property
    def rows_at_once(self) -> int:
        """Largest number of rows to run at once."""
        return self._batch.rows_at_once

    def run(self, values: FloatArray) -> list[UncertifiedResult | None]:
        """Run rows.

        Parameters
        ----------
        values
            Values of the keys, SI; shape (rows, keys).

        Returns
        -------
        list
            The results, or None for a row that a run of its own must tell the end of.
        """
        results: list[UncertifiedResult | None] = [None] * len(values)
        left, n_used = np.arange(len(values)), 0
        while left.size:
            record = self._get_record(n_used, values[left[0]])
            if record is None:
                results[left[0]] = self._run_alone(values[left[0]])
                left = left[1:]
                continue
            numbers, is_valid = record.evaluate(values[left])
            n_used += 1
            if not is_valid.any() or not self._holds(record, values[left[is_valid][-1]]):
                continue
            for index, result in zip(left[is_valid].tolist(), self._batch.run_recorded(record, numbers[is_valid]), strict=True):
                results[index] = result
            left = left[~is_valid]
        return results

    def _get_record(self, index: int, values: FloatArray) -> RecordedRows | None:
        """Return the record of an index, which is made of a row with values of the keys if there is none yet; None if that fails."""
        with self._lock:
            if index == len(self._records) and self._n_trials < MAX_RECORDS:
                self._n_trials += 1
                with suppress(Exception):  # a row that cannot be recorded, for whatever reason, is lowered by itself
                    self._records.append(self._record(values))
            return self._records[index] if index < len(self._records) else None

    def _record(self, values: FloatArray) -> RecordedRows:
        """Return a record of a row with values of the keys. Raise an exception if there is no such row, or it cannot be recorded."""
        record = RecordedRows.record(self._make_scene, self._by_key(values), self._batch.names)
        if not self._holds(record, values):
            raise NotRecordable("the record does not give the arrays of its own row")
        return record

    def _holds(self, record: RecordedRows, values: FloatArray) -> bool:
        """Return whether a record gives the arrays of a row with values of the keys: each batch is checked at its last row."""
        return record.reproduces(values, lower_row(self._make_scene(self._by_key(values)), self._batch.names))

    def _run_alone(self, values: FloatArray) -> UncertifiedResult | None:
        """Return the result of a row with values of the keys, which is described and lowered by itself."""
        try:
            return self._batch.run(self._make_scene(self._by_key(values)))
        except MechanismError:
            return None

    def _by_key(self, values: FloatArray) -> dict[str, float]:
        return dict(zip(self._keys, values.tolist(), strict=True))

    def _make_scene(self, values: Mapping[str, float]) -> Scene:
        """Return the scene with values of keys. Raise MechanismError if a value is wrong, or the scene cannot start."""
        changes: dict[str, Any] = {}
        changed = {key.removeprefix(DIMENSION_PREFIX): value for key, value in values.items() if key != SPEED_KEY}
        if changed:
            machine = self._machine_class(**{**self._dimensions, **changed})
            if problems := machine.start_problems(self._scene.start.values):
                raise MechanismError(*problems)
            changes["mechanism"] = machine.mechanism_with_effects(self._scene.effects)
        if SPEED_KEY in values:
            changes["spindle"] = replace(self._spindle, times=(0.0,), speeds=(values[SPEED_KEY],))
        return self._scene.with_changes(**changes)


def prepare_rows(
    keys: Sequence[str], document: Mapping[str, Any], quantities: Sequence[RunQuantity], engine: str, accuracy: float | None
) -> RowsTogether | None:
    """Return what the rows of a sweep share, or None if they must be run one by one.

    Parameters
    ----------
    keys
        Keys of the rows.
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
        What they share.
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
    return None if batch.lower(scene) is None else RowsTogether(keys, scene, scene.spindle, machine_class, dimensions, batch)

"""The recorded lowering of shipped scenes gives the arrays of the ordinary one for other dimensions, to the last digit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines.reduced.row_arrays import RecordedRows, lower_row
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.part import Spindle
from governor_mechanism.numerics.row_numbers import NotRecordable
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.scenes.schema import dimensions_table_model
from governor_mechanism.scenes.table import validate

N_ROWS = 30


def is_recordable(scene) -> bool:
    """Return whether a scene is one part of a machine that starts from a value of its coordinate, and that no gas drives.

    The notes of an engine are texts with its numbers, and its rows are not run together.
    """
    if len(scene.parts) != 1 or scene.part.machine not in MACHINES:
        return False
    mechanism = scene.part.mechanism
    is_engine = any(isinstance(element, CylinderGas) for element in mechanism.force_elements)
    return not is_engine and not mechanism.count_drivers() and isinstance(scene.start.values.get(mechanism.coordinate), float)


SCENES = {name: scene for name in shipped_scenes() if is_recordable(scene := gm.load(name))}


def scene_maker(scene):
    """Return the function that makes a scene with other dimensions and another spindle speed, and the values that it has."""
    machine_class = MACHINES[scene.part.machine]
    dimensions = validate(dimensions_table_model(machine_class), scene.document["dimensions"]).given_values()
    numbers = {name: value for name, value in dimensions.items() if isinstance(value, float)}
    if isinstance(scene.spindle, Spindle) and len(scene.spindle.speeds) == 1:
        numbers["speed"] = scene.spindle.speeds[0]

    def make_scene(values):
        own = {name: value for name, value in values.items() if name != "speed"}
        changes = {"mechanism": machine_class(**{**dimensions, **own}).mechanism_with_effects(scene.effects)}
        if "speed" in values:
            changes["spindle"] = replace(scene.spindle, speeds=(values["speed"],))
        return scene.with_changes(**changes)

    return make_scene, numbers


@pytest.mark.parametrize("name", SCENES)
def test_recorded_rows_are_those_of_the_ordinary_lowering(name):
    make_scene, numbers = scene_maker(SCENES[name])
    readings = [reading.name for reading in SCENES[name].part.mechanism.readings]
    try:
        record = RecordedRows.record(make_scene, numbers, readings)
    except NotRecordable:
        assert SCENES[name].part.machine in ("hartung_governor", "custom")
        return
    generator, n_compared = np.random.default_rng(0), 0
    for _ in range(N_ROWS):
        values = {key: value * generator.uniform(0.98, 1.02) for key, value in numbers.items()}
        try:
            arrays = lower_row(make_scene(values), readings)
        except MechanismError:
            assert not record.evaluate(np.array([[*values.values()]]))[1].any()
            continue
        is_valid = record.evaluate(np.array([[*values.values()]]))[1][0]
        assert not is_valid or record.reproduces(np.array([*values.values()]), arrays)
        n_compared += is_valid
    assert n_compared > N_ROWS // 3  # the others branch otherwise, or are refused


def test_a_record_of_a_governor_holds_for_all_dimensions_without_another_branch():
    make_scene, numbers = scene_maker(gm.load("porter"))
    record = RecordedRows.record(make_scene, numbers, ["sleeve_lift"])
    rows = np.array([*numbers.values()]) * np.linspace(0.9, 1.1, 50)[:, np.newaxis]
    assert record.evaluate(rows)[1].all()

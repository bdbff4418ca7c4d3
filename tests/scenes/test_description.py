"""The description of a scene: the same readings as those of a run, and what the file says, in words."""

import json
import math

import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ENGINES
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.scenes.description import describe_scene
from governor_mechanism.scenes.library import shipped_scenes
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import parse_quantity


@pytest.mark.parametrize(
    "name", ["porter", "porter_free_spindle", "watt_engine_stable", "governed_engine_mean_torque", "slider_crank_torque"]
)
def test_the_readings_are_those_of_a_run_with_their_units_and_start_values(name):
    scene = gm.load(name).replace({"run.duration": 0.02, "run.output_interval": 0.01, "run.accuracy": 1e-4})
    run = gm.run(scene, certify=False)
    described = {reading.name: reading for reading in describe_scene(scene).readings}
    assert {one: reading.unit for one, reading in described.items()} == dict(run.units)
    given = {one: reading.value for one, reading in described.items() if reading.value is not None}
    assert given
    assert given == pytest.approx({one: run.readings[one][0] for one in given}, abs=1e-9)  # both start from the same assembly


@pytest.mark.parametrize(
    "name", ["porter", "governed_engine", "stephenson_reversing", "andrews_squeezer", "stiff_flyball", "joy", "hartung_dubois"]
)
def test_a_description_is_text_and_json(name):
    description = describe_scene(gm.load(name))
    lines = str(description).splitlines()
    assert lines[0] == f"{description.title} ({name})"
    assert all(line == line.rstrip() for line in lines)
    answer = json.loads(json.dumps(description.as_json(), allow_nan=False))
    assert [engine["name"] for engine in answer["engines"]] == list(ENGINES)
    assert [part["machine"] for part in answer["parts"]] == [part.machine for part in gm.load(name).parts]


def test_dimensions_have_customary_units_and_their_meaning():
    (part,) = describe_scene(gm.load("porter")).parts
    values = {value.name: value for value in part.dimensions}
    assert (values["arm"].value, values["arm"].unit, values["arm"].text) == (0.3, "m", "300 mm")
    assert values["arm"].meaning == "length from the suspension to the ball's centre"
    assert part.spindle == "spindle at 120 rpm"
    assert [effect.name for effect in part.effects] == ["gravity", "centrifugal"]


@pytest.mark.parametrize("name", ["hartnell", "porter_cyclic_damped", "air_engine_heavy_pistons", "watt_improved", "governed_engine"])
def test_what_is_told_of_effects_can_be_set_by_the_keys_that_are_told(name):
    scene = gm.load(name)
    text = str(describe_scene(scene))
    effects = [effect for part in describe_scene(scene).parts for effect in part.effects]
    assert all(f"\n  {effect.key}" in text for effect in effects)
    own = {value.key: value.text for effect in effects for value in effect.values if value.key}
    assert own
    assert all(f"\n  {key} " in text for key in own)
    again = str(describe_scene(scene.replace(own)))
    assert again.splitlines()[1:] == text.splitlines()[1:]  # the copy has no file of which the first line tells


def test_couplings_loads_and_events_are_told_in_words():
    text = str(describe_scene(gm.load("governed_engine")))
    assert "governor.spindle_angle turns 1 times as fast as engine.crank_angle" in text
    assert "multiplies engine.throttle: a table of governor.sleeve_lift: 1 at 80 mm, 0.8 at 120 mm" in text
    assert "resists engine.crank_angle with 300 N m times 1 at 0 s, 1 at 6 s, 0.5 at 6 s" in text
    assert "engine.shaft_speed rises through 126 rpm" in text
    assert "Degrees of freedom: 2" in text


def test_each_engine_says_whether_it_can_run_the_scene():
    answers = {answer.name: answer for answer in describe_scene(gm.load("governed_engine")).engines}
    assert answers["reduced"].is_chosen
    assert answers["multibody"].supported
    assert "couplings" in answers["impulse"].reason
    assert str(answers["impulse"]).startswith("refuses: ")


def test_a_scene_without_a_start_is_described_with_the_reason():
    scene = gm.load("porter")
    wrong = scene.with_changes(start=type(scene.start)(values={"arm_angle": math.radians(100)}))
    description = describe_scene(wrong)
    assert description.problem
    assert str(description).splitlines()[-1] == f"No run is possible: {description.problem}"
    assert all(reading.value is None for reading in description.readings)


def test_every_shipped_scene_is_described():
    """A few of each kind are run above; the others must at least not fail."""
    for name in [name for name in shipped_scenes() if name.startswith(("porter", "air", "watt"))]:
        assert describe_scene(gm.load(name)).engines


@pytest.mark.parametrize("name", gm.list_models())
def test_every_dimension_that_a_scene_gives_is_described(name):
    scene = gm.load(name)
    for part, described in zip(scene.parts, describe_scene(scene).parts, strict=True):
        document = scene.document["part"][part.name] if "part" in scene.document else scene.document
        values = {one.name: one for one in described.dimensions}
        for key, given in document.get("dimensions", {}).items() if part.machine in MACHINES else ():  # else they are the user's own
            declared, value = fields_of(MACHINES[part.machine])[key], values[key].value
            assert value is not None, key
            if given in declared.words:
                assert value == given
            elif not isinstance(given, list | dict):
                assert value == parse_quantity(given, declared.kind, key), key

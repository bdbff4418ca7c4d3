"""Words and switches: what can be chosen, that it acts as in the file, and what is refused."""

import json
import tomllib

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.live.conversation import respond
from governor_mechanism.live.quantities import find_choices
from governor_mechanism.live.session import Session, write_scene


@pytest.fixture
def session():
    return Session(gm.load("porter_dry_friction").replace({"run.duration": "0.2 s"}))


NEEDS_MORE = (
    ("watt_clearance", "effects.rods"),  # links that separate from the sleeve are massless
    ("hartung_right_angle", "effects.bell_cranks"),  # at its speed the heavier masses have no stable equilibrium, in which it starts
    ("governed_engine", "part.engine.effects.piston_masses"),  # its connecting rods are endless
)
"""Effects that ask for another change of their scene."""


@pytest.mark.parametrize("name", ["porter", "watt_clearance", "hartung_right_angle", "joy", "slider_crank", "governed_engine"])
def test_an_effect_that_is_offered_begins_with_values_with_which_the_scene_runs(name):
    session = Session(gm.load(name).replace({"run.duration": "10 ms", "run.output_interval": "1 ms"}))
    for choice in find_choices(session.run, session.document).values():
        if choice.options or choice.value:
            continue
        session.choose(choice.key, True)
        assert bool(session.solve().problem) == ((name, choice.key) in NEEDS_MORE), choice.key
        session.undo()


def test_an_effect_comes_back_as_it_was(session):
    first = session.document
    session.choose("effects.dry_friction", False)
    assert session.solve().run.scene.part.output_effects == ()
    session.choose("effects.dry_friction", True)
    assert session.document == first


def test_a_load_that_is_switched_on_is_a_share_of_the_weight_and_has_a_slider():
    session = Session(gm.load("porter").replace({"run.duration": "0.2 s"}))
    weight = 9.81 * (2 * 5.0 + 20.0)  # of both balls and the sleeve, N
    session.choose("effects.dry_friction", True)
    found = session.find_quantities()["effects.dry_friction.sleeve_lift"]
    assert found.value == pytest.approx(0.01 * weight, rel=0.05)  # of one digit
    assert found.low < found.value < found.high
    session.choose("effects.stops", True)
    low, high = (session.find_quantities()[f"effects.stops.sleeve_lift.{k}"].value for k in (1, 2))
    lifts = 1e3 * session.solve().run.readings["sleeve_lift"]
    assert low < lifts.min() < lifts.max() < high


def test_an_effect_acts_along_another_reading_with_a_load_of_its_kind(session):
    session.choose("effects.dry_friction along", "ball_radius")
    assert session.document["effects"]["dry_friction"] == {"ball_radius": "40 N"}
    session.choose("effects.dry_friction along", "arm_angle")
    assert session.document["effects"]["dry_friction"]["arm_angle"].endswith("N m")
    assert not session.solve().problem
    session.choose("effects.dry_friction along", "sleeve_lift")


@pytest.mark.parametrize(("name", "key", "word"), [
    ("stephenson_arc_middle", "dimensions.rods", "crossed"),
    ("stephenson_arc_middle", "dimensions.connecting_rod", "endless"),
    ("slide_valve_30", "dimensions.setting", "equal cut-offs"),
    ("governed_engine", "part.engine.dimensions.gas_torque", "mean"),
    ("governed_engine", "events.overspeed.direction", "both"),
    ("porter", "start.arm_angle", "equilibrium"),
])  # fmt: skip
def test_a_word_of_the_file_is_chosen_and_taken_back(name, key, word):
    scene = gm.load(name).replace({"run.duration": "10 ms", "run.output_interval": "1 ms"})
    session = Session(scene)
    before = session.document
    choice = find_choices(session.run, before)[key]
    session.choose(key, word)
    assert gm.Scene.from_dict(session.document) == scene.replace({key: word})
    assert not session.solve().problem
    session.choose(key, choice.value)
    assert gm.Scene.from_dict(session.document) == scene


def test_a_start_in_equilibrium_becomes_the_value_that_it_has():
    session = Session(gm.load("hartung_dubois").replace({"run.duration": "10 ms", "run.output_interval": "1 ms"}))
    start = session.run.readings["lever_angle"][0]
    session.choose("start.lever_angle", "a value")
    assert session.solve().run.readings["lever_angle"][0] == pytest.approx(start, rel=1e-5)  # written with six digits


def test_a_spindle_changes_its_speed_and_is_let_free():
    session = Session(gm.load("porter"))
    before = session.document
    session.choose("spindle", "speed over time")
    speeds = session.solve().run.readings["spindle_speed"]
    assert speeds[[0, -1]] == pytest.approx([4 * np.pi, 1.05 * 4 * np.pi], rel=1e-12)
    assert "speed value 2" in [one.words for one in session.find_quantities().values()]
    session.choose("spindle", "free")
    assert not session.solve().problem
    assert session.solve().run.readings["spindle_speed"][0] == pytest.approx(4 * np.pi, rel=1e-12)
    session.choose("spindle", "constant speed")
    assert session.document == before


def test_a_drive_over_time_begins_with_the_motion_that_it_had():
    session = Session(gm.load("jansen"))
    before, angles = session.document, session.run.readings["crank_angle"]
    session.choose("joint.motor motion", "over time")
    assert session.solve().run.readings["crank_angle"] == pytest.approx(angles, abs=1e-9)
    assert any("time 2" in one.words for one in session.find_quantities().values())
    session.choose("joint.motor motion", "constant rate")
    assert session.document == before


def test_an_engine_is_chosen_by_a_message(session):
    assert respond(session, json.dumps({"action": "choose", "key": "run.engine", "value": "multibody"})) is None
    assert session.solve().run.cost.engine == "multibody"
    (engine,) = [one for one in session.describe(session.solve())["choices"] if one["key"] == "run.engine"]
    assert engine["value"] == "multibody"
    assert "impulse" in engine["options"]


def test_a_refused_combination_is_a_sentence():
    session = Session(gm.load("jansen").replace({"run.duration": "0.2 s"}))
    session.choose("run.engine", "reduced")
    assert session.solve().problem.startswith("Engine 'reduced' integrates one free coordinate, but drives move this mechanism")


@pytest.mark.parametrize(("key", "value", "sentence"), [
    ("run.engine", "newton", "engine is one of auto, impulse, multibody, reduced; found .newton."),
    ("run.engine", True, "engine is one of auto"),
    ("effects.gravity", "yes", "gravity is one of True, False; found .yes."),
    ("title", "mine", "'title' is no choice of this scene"),
    ("effects.link_masses", True, "'effects.link_masses' is no choice of this scene"),
])  # fmt: skip
def test_other_choices_are_refused(session, key, value, sentence):
    with pytest.raises(gm.MechanismError, match=sentence):
        session.choose(key, value)


def test_a_choice_is_saved_as_one_would_write_it(session):
    text = gm.load("porter_dry_friction").to_toml()
    session.choose("effects.gravity", False)
    saved = tomllib.loads(write_scene(text, session.document))
    assert saved["effects"]["gravity"] is False

"""Words and switches: what can be chosen, that it acts as in the file, and what is refused."""

import json
import tomllib

import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.live.choices import find_choices
from governor_mechanism.live.conversation import respond
from governor_mechanism.live.saving import write_scene
from governor_mechanism.live.session import Session


@pytest.fixture
def session():
    return Session(gm.load("porter_dry_friction").replace({"run.duration": "0.2 s"}))


@pytest.mark.parametrize("name", ["porter", "watt_clearance", "hartung_right_angle", "joy", "slider_crank", "governed_engine"])
def test_an_effect_that_is_offered_can_be_switched_on(name):
    scene = gm.load(name)
    session = Session(scene.replace({"run.duration": "10 ms", "run.output_interval": "1 ms"}))
    for choice in find_choices(session.document, scene).values():
        if choice.options or choice.value:
            continue
        session.choose(choice.key, True)
        assert not session.solve().problem, choice.key
        session.undo()


def test_an_effect_comes_back_as_it_was(session):
    first = session.document
    session.choose("effects.dry_friction", False)
    assert session.solve().run.scene.part.output_effects == ()
    session.choose("effects.dry_friction", True)
    assert session.document == first


def test_an_effect_that_the_file_does_not_have_begins_with_its_default():
    session = Session(gm.load("porter").replace({"run.duration": "0.2 s"}))
    before = session.solve().run
    session.choose("effects.dry_friction", True)
    run = session.solve().run
    assert [type(effect).__name__ for effect in run.scene.part.output_effects] == ["DryFriction"]
    assert run.readings["arm_angle"][-1] == pytest.approx(before.readings["arm_angle"][-1], abs=1e-6)  # a friction of 0 N
    assert "effects.dry_friction.sleeve_lift" in session.find_quantities()  # and a slider for it


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


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("run.engine", "newton", "engine is one of auto, impulse, multibody, reduced; found .newton."),
        ("run.engine", True, "engine is one of auto"),
        ("effects.gravity", "yes", "gravity is one of True, False; found .yes."),
        ("title", "mine", "'title' is no choice of this scene"),
        ("effects.clearance", True, "'effects.clearance' is no choice of this scene"),
    ],
)
def test_other_choices_are_refused(session, key, value, sentence):
    with pytest.raises(MechanismError, match=sentence):
        session.choose(key, value)


def test_a_choice_is_saved_as_one_would_write_it(session):
    text = gm.load("porter_dry_friction").to_toml()
    session.choose("effects.gravity", False)
    saved = tomllib.loads(write_scene(text, session.document))
    assert saved["effects"]["gravity"] is False

"""Forces of joints that a run reports are arrows in films and on pages."""

import numpy as np
import pytest

import governor_mechanism as gm
from decoding import data_of, page_data_of
from governor_mechanism.render.film.frame_painter import ForceArrows
from governor_mechanism.render.frame_data import REACTION, find_forces

JOINTS = ("pin of ground and crank", "j", "c")
ARROWS = ["pin of ground and crank on crank", "j on thigh", "c on shank"]


@pytest.fixture(scope="module")
def leg():
    scene = gm.load("jansen").replace({"run.readings": [f"reaction.{name}" for name in JOINTS], "effects.gravity": True})
    return gm.run(scene, certify=False)


def test_the_forces_of_named_joints_are_those_of_the_run(leg):
    forces = {force.name: force for force in find_forces(data_of(leg, 11), only_reactions=True)}
    assert list(forces) == ARROWS
    for name, force in zip(JOINTS, forces.values(), strict=True):
        assert force.kind == REACTION
        np.testing.assert_allclose(force.components, leg.reactions[name].force[::40], atol=1e-12)


def test_the_force_on_a_second_body_that_is_the_ground_is_drawn_on_the_first():
    scene = gm.load("jansen")
    joints = [{**joint} for joint in scene.document["joint"]]
    joints[1] |= {"first": "thigh.start", "second": "ground.B", "name": "hip"}
    run = gm.run(scene.replace({"joint": joints, "run.readings": ["reaction.hip"], "effects.gravity": True}), certify=False)
    (force,) = find_forces(data_of(run, 11), only_reactions=True)
    assert (force.name, force.point.body) == ("hip on thigh", "thigh")
    np.testing.assert_allclose(force.components, -run.reactions["hip"].force[::40], atol=1e-12)


def test_a_film_shows_them_without_being_asked_on_the_scale_of_its_bar(leg):
    data = data_of(leg, 11)
    arrows, everything = (ForceArrows(data, data.drawing.bounds, shows_all=shows_all) for shows_all in (False, True))
    assert arrows.kinds == [REACTION]
    assert everything.kinds == ["weight", REACTION]
    largest = max(float(np.hypot(*leg.reactions[name].force[::40].T).max()) for name in JOINTS)
    assert arrows.largest == pytest.approx(largest, rel=1e-9)
    shaft, head = next(iter(arrows.parts())).shapes_at(3)
    force = leg.reactions[JOINTS[0]].force[120]
    assert shaft.lines[0][0] == (0.0, 0.0)
    np.testing.assert_allclose(head.points[0], arrows.scale * force, rtol=1e-9)
    assert not ForceArrows(data, data.drawing.bounds, shows_all=False, is_magnified=True).kinds
    assert not ForceArrows(data_of(gm.run("jansen", certify=False), 11), data.drawing.bounds, shows_all=False).kinds


def test_a_page_has_the_same_arrows(leg):
    forces = page_data_of(leg, leg.times[::40])["views"][0]["forces"]
    assert [arrow["name"] for arrow in forces["arrows"] if arrow["kind"] == REACTION] == ARROWS


def test_the_slider_crank_which_draws_its_loads_draws_them_once():
    run = gm.run(gm.load("slider_crank").replace({"run.readings": ["reaction.crank pin"]}), certify=False)
    data = data_of(run)
    assert data.drawing.shows_joint_forces
    assert not find_forces(data, only_reactions=True)

"""Scenes of parts that touch in the workbench, going on from a state, and against a user's function."""

import json
import math

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import GRAVITY, ROLLER, ball_document
from governor_mechanism.live.session import Session
from governor_mechanism.model.events import EventKind

FLOOR = [[-2, -0.5], [2, -0.5], [2, 0], [-2, 0]]
HEIGHT, RESTITUTION = 0.05, 0.5


def bouncing_scene():
    """A ball that falls on a floor and bounces."""
    return gm.Scene.from_dict(ball_document(FLOOR, (0.0, ROLLER + HEIGHT), restitution=RESTITUTION))


def bounce(time, height=HEIGHT, restitution=RESTITUTION, gravity=GRAVITY):
    """Return the height of the centre of the ball by parabolas between rebounds."""
    speed = -math.sqrt(2 * gravity * height)
    elapsed = time - math.sqrt(2 * height / gravity)
    if elapsed < 0:
        return ROLLER + height - gravity * time**2 / 2
    for _ in range(100):
        speed *= -restitution if speed < 0 else restitution
        if elapsed < 2 * speed / gravity:
            return ROLLER + speed * elapsed - gravity * elapsed**2 / 2
        elapsed -= 2 * speed / gravity
    return ROLLER


def test_a_function_of_a_bouncing_ball_agrees_and_a_planted_mistake_is_found():
    scene, times = bouncing_scene(), {"time": "0 s:0.9 s:19"}
    assert gm.crosscheck(scene, lambda time: bounce(time), "y", times).passed
    assert not gm.crosscheck(scene, lambda time: bounce(time, restitution=0.501), "y", times).passed


def test_the_workbench_runs_a_contact_refuses_an_overlap_and_goes_on_from_a_rest():
    session = Session(bouncing_scene())
    state = session.describe(session.solve())
    assert not state["problem"]
    assert {"x", "y", "ball_gap"} <= {one["name"] for one in state["readings"]}
    json.dumps(state["readings"], allow_nan=False)
    session.change({"start.y": ROLLER - 1e-3})
    assert "overlaps the outline of 'block' by 1 mm at the start" in session.solve().problem
    session.undo()
    assert session.solve().problem == ""
    motion = session.extend_motion("tab", 0.9, 0.5, is_new=True)  # it has come to rest by then
    assert (motion["problem"], motion["isOver"]) == ("", False)
    (height,) = (one for one in motion["readings"] if one["name"] == "y")
    assert height["value"] == pytest.approx(ROLLER, abs=1e-9)


def test_a_run_that_goes_on_in_contact_is_the_whole_run():
    scene = bouncing_scene()
    whole = gm.run(scene, times=np.array([0.0, 0.05, 0.2, 0.35, 0.9]))
    first = gm.run(scene, times=np.array([0.0, 0.2]))
    second = gm.run(scene, times=np.array([0.0, 0.15, 0.7]), start=first.state())
    assert second.readings["y"] == pytest.approx(whole.readings["y"][2:], abs=1e-9)
    rests = [[event.time for event in run.events if event.kind is EventKind.REST] for run in (whole, second)]
    assert rests[1][0] + 0.2 == pytest.approx(rests[0][0], abs=1e-9)

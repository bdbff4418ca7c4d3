"""Turning points and change points of runs, and reversal of the whole motion, which is neither."""

import math

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.model.events import EventKind
from governor_scenes import PORTER, governor_scene


@pytest.mark.long
@pytest.mark.parametrize(("engine", "allowed"), [("multibody", 1e-7), ("reduced", 1e-7), ("impulse", 1e-6)])
def test_crank_passes_the_dead_centres_of_its_slider(engine, allowed):
    run = gm.run("slider_crank_torque", engine=engine, accuracy=1e-6, times=np.linspace(0.0, 0.85, 171))
    found = [event for event in run.events if event.kind == EventKind.TURNING_POINT]
    assert [event.subject for event in found] == ["slider_x"] * 3
    fine = gm.run("slider_crank_torque", engine="multibody", accuracy=1e-10, times=[0.0, *(e.time for e in found)])
    # The slider is at a dead centre every half turn of the crank. The crank speed is at most 20 rad/s, which relates
    # the errors of times and angles.
    angles = fine.readings["crank_angle"][1:]
    np.testing.assert_allclose(angles, math.pi * np.arange(1, 4), atol=20 * allowed)


def test_driven_lever_turns_where_the_crank_is_perpendicular_to_it():
    run = gm.run("quick_return", engine="multibody")
    times = [event.time for event in run.events if event.subject == "lever_angle"]
    # The crank pin moves along the lever where sin(turn) = 80 mm / 200 mm: half a turn + asin(0.4).
    turn = math.asin(0.4) + math.pi
    expected = sorted([turn / math.tau + k for k in range(3)] + [1.5 - turn / math.tau + k for k in range(3)])
    np.testing.assert_allclose(times, expected, atol=1e-12)


def test_reversal_of_the_motion_is_not_an_event():
    scene = governor_scene(PORTER, speed=4 * math.pi, angle=0.7, duration=5.0)
    for engine in ("multibody", "reduced", "impulse"):
        assert gm.run(scene, engine=engine).events == ()


def test_event_as_text():
    run = gm.run("slider_crank_torque", times=np.linspace(0.0, 0.5, 51))
    assert [str(event) for event in run.events] == ["turning point of slider_x at t = 0.450819 s"]

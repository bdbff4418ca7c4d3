"""What moves fast strikes a thin part, however many times longer than its thickness the way of a step is."""

import itertools
import math

import numpy as np
import pytest

import governor_mechanism as gm
from contact_scenes import GRAVITY, ball_document, contact_document, events_of, readings_of, start_of
from governor_mechanism.model.events import EventKind
from scene_documents import pin

FALLS = list(itertools.product((1e-3, 1e-5), (1e-3, 1e-4), (1.0, 100.0), (0.3, 0.377, 2.0)))
"""Thickness of a plate, radius of a ball, its speed and its height above the plate, m and m/s."""


@pytest.mark.parametrize(
    ("engine", "falls"),
    [
        ("multibody", FALLS[::3]),
        ("impulse", FALLS[4:5]),
        pytest.param("multibody", FALLS, marks=pytest.mark.long),
        pytest.param("impulse", FALLS, marks=pytest.mark.long),
    ],
)
def test_a_ball_strikes_a_thin_plate_at_the_time_of_its_fall(engine, falls):
    for thickness, radius, speed, height in falls:
        plate = [[-1, -thickness], [1, -thickness], [1, 0], [-1, 0]]
        scene = gm.Scene.from_dict(ball_document(plate, (0.0, height), (0.0, -speed), radius=radius, restitution=0.5))
        strike = (math.sqrt(speed**2 + 2 * GRAVITY * (height - radius)) - speed) / GRAVITY
        run = gm.run(scene, engine, times=np.linspace(0.0, 1.5 * strike, 7), accuracy=1e-6, certify=False)
        assert events_of(run, EventKind.IMPACT) == pytest.approx([strike], abs=1e-9), (thickness, radius, speed, height)
        assert run.readings["y"].min() > radius - 1e-12


@pytest.mark.parametrize("engine", ["multibody", "reduced"])
@pytest.mark.parametrize("thickness", [1e-2, 1e-4])
def test_a_pendulum_strikes_a_thin_wall(engine, thickness):
    """Its bob touches the wall where the rod is upright but for the radius; it swings back with the share of its speed."""
    length, bob, start = 0.5, 0.002, -2.5
    wall = [[0.0, -2.0], [thickness, -2.0], [thickness, 0.0], [0.0, 0.0]]
    arm = {"name": "arm", "mass": 1.0, "inertia": 0.01, "at": [0, 0], "centre": [0, -length], "points": {"bob": [0, -length]}}
    contact = {"name": "bob", "first": "arm.bob", "radius": bob, "second": "block", "restitution": 0.5}
    readings, at_start = {"angle": {"angle": "arm"}}, {"angle": start, "angle_rate": 0.0}
    document = contact_document(wall, [arm], [contact], readings, at_start, [pin("ground.O", "arm.origin")])
    run = gm.run(gm.Scene.from_dict(document), engine, times=np.linspace(0.0, 1.2, 241), certify=False)
    touch = -math.asin(bob / length)
    lowest = math.acos(math.cos(touch) - 0.25 * (math.cos(touch) - math.cos(start)))
    assert len(events_of(run, EventKind.IMPACT)) == 1
    assert run.readings["angle"].max() <= touch + 1e-9
    after = run.times > run.events[0].time
    assert run.readings["angle"][after].min() == pytest.approx(-lowest, abs=1e-3)


def test_a_wheel_with_several_rollers_strikes_a_thin_plate_with_the_one_that_comes_down():
    """It turns a quarter while it falls, so that another one of its four rollers is below."""
    height, spin, reach, radius = 0.5, 100.0, 0.1, 1e-3
    wheel = {"name": "ball", "mass": 1.0, "inertia": 0.01, "at": [0.0, height]}
    contact = {"name": "tip", "first": ["ball", reach, 0.0], "radius": radius, "repeat": 4, "second": "block"}
    start = start_of((0.0, height, 0.0), (0.0, 0.0, spin))
    document = contact_document([[-1, -1e-4], [1, -1e-4], [1, 0], [-1, 0]], [wheel], [contact], readings_of("ball"), start)
    run = gm.run(gm.Scene.from_dict(document), times=np.linspace(0.0, 0.32, 9), certify=False)

    def lowest(time):
        return height - GRAVITY * time**2 / 2 - reach * max(abs(math.cos(spin * time)), abs(math.sin(spin * time))) - radius

    times = np.linspace(0.0, 0.32, 320001)
    first = times[np.argmax(np.array([lowest(float(time)) for time in times]) < 0.0)]
    assert events_of(run, EventKind.IMPACT)[0] == pytest.approx(first, abs=2e-6)

"""Scenes that once ran without an end, went wrong in silence, or were refused by the wrong engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.engines.multibody.run import MultibodySettings
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Outcome, Trajectory

SLIDER_IN_TURNING_PLANE = """
machine = "custom"
plane = "turning"
[ground]
A = [0, 0]
[[body]]
name = "weight"
mass = 1
at = [0.1, 0]
turns = false
[[joint]]
type = "slider"
first = "ground.A"
second = "weight.origin"
angle = 0
[readings]
radius = { x = "weight.origin" }
[effects]
gravity = false
centrifugal = true
[spindle]
speed = 20.0
[run]
duration = "1000 s"
output_interval = "10 s"
"""
"""The weight flies out with exp(20 t)."""

PARALLELOGRAM_ON_ITS_LINE = """
machine = "custom"
[ground]
A = [0, 0]
B = [1, 0]
[[body]]
name = "a"
mass = 1
rod = { length = 1 }
[[body]]
name = "b"
mass = 1
rod = { length = 1 }
at = [1, 0]
[[body]]
name = "c"
mass = 1
rod = { length = 1 }
at = [1, 0]
[[joint]]
type = "pin"
first = "ground.A"
second = "a.start"
[[joint]]
type = "pin"
first = "ground.B"
second = "b.start"
[[joint]]
type = "pin"
first = "a.end"
second = "c.start"
[[joint]]
type = "pin"
first = "c.end"
second = "b.end"
[readings]
a_angle = { angle = "a" }
b_angle = { angle = "b" }
[effects]
gravity = false
[start]
a_angle = 0.0
a_rate = 1.0
[run]
duration = "1 s"
output_interval = "100 ms"
accuracy = 1e-6
"""
"""A crank and a rocker as long as each other, in line at the start: they may begin to turn alike or against each other."""

ROD_AT_ITS_LARGEST_X = """
machine = "custom"
[ground]
A = [0, 0]
[[body]]
name = "a"
mass = 1
rod = { length = 1 }
[[joint]]
type = "pin"
first = "ground.A"
second = "a.start"
[readings]
x = { x = "a.end" }
[effects]
gravity = true
[run]
duration = "0.5 s"
output_interval = "10 ms"
accuracy = 1e-6
"""

FAST_FLUCTUATION = """
machine = "pendulum_governor"
[dimensions]
arm = 0.3
offset = 0.04
ball_mass = 5
sleeve_mass = 20
[effects]
gravity = true
centrifugal = true
[spindle]
speed = "120 rpm"
speed_fluctuation = 0.5
cycles_per_turn = 200
[start]
arm_angle = "40 deg"
arm_rate = 0.15
[run]
duration = "0.2 s"
output_interval = "20 ms"
accuracy = 1e-4
"""


@pytest.fixture
def run_scene(tmp_path: Path):
    """Return a function that runs the text of a scene with an engine."""

    def run(text: str, engine: str, accuracy: float | None = None) -> Trajectory:
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return gm.run(path, engine=engine, accuracy=accuracy)

    return run


def test_a_body_that_flies_away_ends_the_run(run_scene):
    run = run_scene(SLIDER_IN_TURNING_PLANE, "multibody")
    assert run.outcome is Outcome.LEFT_RANGE
    assert "flies away" in run.message


def test_a_start_on_no_branch_of_a_change_point_is_refused(run_scene):
    with pytest.raises(MechanismError, match="change point, where motion branches"):
        run_scene(PARALLELOGRAM_ON_ITS_LINE, "multibody")


def test_a_start_on_a_branch_of_a_change_point_stays_on_it(run_scene):
    run = run_scene(PARALLELOGRAM_ON_ITS_LINE.replace("a_rate = 1.0", "a_rate = 1.0\nb_rate = 1.0"), "multibody")
    assert run.outcome is Outcome.DONE
    # As a parallelogram the rods turn alike and uniformly: nothing acts on them.
    for name in ("a_angle", "b_angle"):
        np.testing.assert_allclose(run.readings[name], run.times, atol=3 * max(run.error_estimate or 0.0, 1e-12))


def test_auto_goes_on_where_the_reduced_engine_cannot_start(run_scene):
    run, multibody = (run_scene(ROD_AT_ITS_LARGEST_X, engine) for engine in ("auto", "multibody"))
    assert run.outcome is Outcome.DONE
    np.testing.assert_array_equal(run.readings["x"], multibody.readings["x"])


def test_a_fluctuation_faster_than_the_motion_is_not_missed_by_fixed_steps(run_scene):
    run, reference = run_scene(FAST_FLUCTUATION, "impulse"), run_scene(FAST_FLUCTUATION, "reduced", 1e-9)
    assert run.outcome is Outcome.DONE
    for name, scale in run.scales.items():
        error = np.max(np.abs(run.readings[name] - reference.readings[name])) / scale
        assert error <= 3 * run.error_estimate, name


def test_the_default_number_of_steps_falls_with_the_number_of_joints():
    engine = MultibodyEngine(settings=MultibodySettings(max_step_work=1e4))
    run = gm.run("pendulum_iftomm", engine=engine, times=[1e9])
    assert run.outcome is Outcome.STEP_LIMIT
    assert "max_steps = 2000 reached" in run.message  # one joint, and the fixed work of four
    assert engine.step_limit(gm.load("four_bar_chain")) < 1000


def test_a_higher_accuracy_returns_no_worse_a_run():
    looser, tighter = (gm.run("slider_crank_torque", engine="multibody", accuracy=accuracy, times=[3.0]) for accuracy in (1e-10, 1e-11))
    assert tighter.error_estimate <= looser.error_estimate

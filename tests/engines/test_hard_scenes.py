"""Scenes that once ran without an end, went wrong in silence, or were refused by the wrong engine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import governor_mechanism as gm
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.certificate import StepPlan, describe_stall
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.engines.multibody.run import MIN_IMPLICIT_STEPS, ConstrainedIntegrator
from governor_mechanism.engines.multibody.settings import MultibodySettings
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.hard_cases.study import HARD_CASES

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

DOUBLE_PENDULUM = """
machine = "custom"
[ground]
A = [0, 0]
[[body]]
name = "a"
mass = {first_mass}
rod = {{ length = 1 }}
[[body]]
name = "b"
mass = {second_mass}
rod = {{ length = 1 }}
at = [1, 0]
[[joint]]
type = "pin"
first = "ground.A"
second = "a.start"
[[joint]]
type = "pin"
first = "a.end"
second = "b.start"
[readings]
a_angle = {{ angle = "a" }}
b_angle = {{ angle = "b" }}
[effects]
gravity = true
[start]
a_angle = 0.0
b_angle = 0.1
[run]
duration = "2 s"
output_interval = "50 ms"
accuracy = 1e-10
"""

LIGHT_BALLS_PULL_A_HEAVY_SLEEVE = """
machine = "pendulum_governor"
[dimensions]
arm = 0.42
offset = 0.158
ball_mass = 0.0114
sleeve_mass = 73.4
[effects]
gravity = true
centrifugal = true
[spindle]
speed = "153 rpm"
[start]
arm_angle = "30 deg"
[run]
duration = "1 s"
output_interval = "20 ms"
accuracy = 1e-6
"""
"""The sleeve falls until arms and links are in line, a change point that light balls pass in a hundredth of a millisecond."""

RODS_IN_EXPONENTIAL_FLIGHT = """
machine = "custom"
plane = "turning"
[ground]
A = [0, 0]
[[body]]
name = "carriage"
mass = 0.1
rod = { length = 0.2 }
angle = -2.0
[[body]]
name = "rod"
mass = 2
rod = { length = 0.7 }
at = [-0.0832293673094285, -0.181859485365136]
angle = -0.4
[[joint]]
type = "slider"
first = "ground.A"
second = "carriage.start"
angle = 0.475
[[joint]]
type = "driven_turn"
name = "motor"
first = "ground"
second = "carriage"
rate = 0.3
[[joint]]
type = "pin"
first = "carriage.end"
second = "rod.start"
[readings]
x = { x = "rod.end" }
[effects]
gravity = true
centrifugal = true
[spindle]
speed = "110 rpm"
[run]
duration = "3 s"
output_interval = "20 ms"
accuracy = 1e-6
"""
"""A rod on a carriage that flies out along the spindle's plane swings ever faster."""

DAMPED_ROD_IN_EXPONENTIAL_FLIGHT = RODS_IN_EXPONENTIAL_FLIGHT.replace(
    "[readings]", '[[force]]\ntype = "torsion_damper"\nsecond = "rod"\ndamping = 46\n[readings]'
)
"""The same with a rod so strongly damped that the motion is stiff at first."""


@pytest.fixture
def run_scene(tmp_path: Path):
    """Return a function that runs the text of a scene with an engine."""

    def run(text: str, engine: str, accuracy: float | None = None) -> Trajectory:
        path = tmp_path / "scene.toml"
        path.write_text(text)
        return gm.run(path, engine=engine, accuracy=accuracy)

    return run


@pytest.mark.parametrize("engine", ["reduced", "multibody", "impulse"])
def test_a_body_that_flies_away_ends_the_run(run_scene, engine):
    run = run_scene(SLIDER_IN_TURNING_PLANE, engine)
    assert run.outcome is Outcome.LEFT_RANGE
    assert "flies away" in run.message


def double_pendulum_angles(first_mass: float, second_mass: float, times: np.ndarray) -> np.ndarray:
    """Return both angles (2, n) of the double pendulum in minimal coordinates, by scipy."""

    def derivative(_: float, state: np.ndarray) -> list[float]:
        first, second, first_rate, second_rate = state
        cosine, sine = np.cos(first - second), np.sin(first - second)
        mass_matrix = [[first_mass / 3 + second_mass, second_mass / 2 * cosine], [second_mass / 2 * cosine, second_mass / 3]]
        torques = [
            -second_mass / 2 * sine * second_rate**2 - (first_mass / 2 + second_mass) * 9.81 * np.cos(first),
            second_mass / 2 * sine * first_rate**2 - second_mass / 2 * 9.81 * np.cos(second),
        ]
        return [first_rate, second_rate, *np.linalg.solve(mass_matrix, torques)]

    solution = solve_ivp(derivative, (0.0, times[-1]), [0.0, 0.1, 0.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-13, t_eval=times)
    angles: np.ndarray = solution.y[:2]
    return angles


@pytest.mark.parametrize("ratio", [1e-8, 1e-6, 1e-4, 1.0, 1e4, 1e8])
def test_the_ratio_of_the_masses_does_not_limit_the_accuracy(run_scene, ratio):
    masses = {"first_mass": min(ratio, 1.0), "second_mass": min(1 / ratio, 1.0)}
    run = run_scene(DOUBLE_PENDULUM.format(**masses), "multibody")
    assert run.outcome is Outcome.DONE, run.message
    assert run.cost.steps < 1000  # light bodies need no more steps than others
    angles = double_pendulum_angles(*masses.values(), run.times)
    for name, reference in zip(("a_angle", "b_angle"), angles, strict=True):
        np.testing.assert_allclose(run.readings[name], reference, rtol=0, atol=max(run.error_estimate, 2e-11))


def test_light_balls_lead_a_heavy_sleeve_through_its_change_point(run_scene):
    runs = {engine: run_scene(LIGHT_BALLS_PULL_A_HEAVY_SLEEVE, engine) for engine in ("reduced", "multibody")}
    for engine, run in runs.items():
        assert run.outcome is Outcome.LEFT_RANGE, (engine, run.message)
        assert "arms and links are in line" in run.message
    for name, values in runs["reduced"].readings.items():
        allowed = 2e-6 * runs["reduced"].scales[name]
        np.testing.assert_allclose(runs["multibody"].readings[name], values, rtol=0, atol=allowed, err_msg=name)


@pytest.mark.long
def test_a_flight_is_not_refined_below_the_rounding_of_its_positions(run_scene):
    run = run_scene(RODS_IN_EXPONENTIAL_FLIGHT, "multibody", 1e-9)
    assert run.outcome is Outcome.LEFT_RANGE
    assert "flies away" in run.message
    assert run.cost.steps < 60_000
    assert run.error_estimate < 1e-5  # relative to a torque that grows with the square of the distance


@pytest.mark.long
def test_an_impulse_run_of_a_flight_ends_with_its_digits(run_scene):
    run, reference = (run_scene(RODS_IN_EXPONENTIAL_FLIGHT, engine, 1e-3) for engine in ("impulse", "multibody"))
    assert run.outcome is Outcome.LEFT_RANGE
    assert "flies away" in run.message
    assert run.cost.steps < 300_000
    assert run.error_estimate < 0.002
    farthest = np.max(np.hypot(*np.moveaxis(run.poses[..., :2], -1, 0)), axis=1) / 0.7  # in lengths of the rod
    assert 3000 < farthest[-1] < 6000
    for name, values in run.readings.items():
        allowed = run.error_estimate * run.scales[name]
        np.testing.assert_allclose(values, reference.readings[name][: len(values)], rtol=0, atol=allowed, err_msg=name)


def test_implicit_steps_end_where_explicit_ones_take_less_work(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(DAMPED_ROD_IN_EXPONENTIAL_FLIGHT)
    scene = gm.load(path)
    motion = initial_state(scene)
    evaluator = ReadingEvaluator(scene, motion[0])
    settings = MultibodySettings(implicit_step_cost=1000.0)
    integrator = ConstrainedIntegrator(evaluator, motion, np.linspace(0.0, 3.0, 151), 1_000_000, settings)
    assert integrator.integrate(1e-11, StepPlan(max_steps=1_000_000)).status == IntegrationStatus.OUT_OF_RANGE
    assert integrator.implicit_steps == MIN_IMPLICIT_STEPS < integrator.counters[StepCounter.ACCEPTED]


def test_a_stall_names_a_driver_only_where_there_is_one():
    driven, free = gm.load("slider_crank"), gm.load("porter")
    assert "a driver locks" in describe_stall(driven, IntegrationStatus.STALLED)
    assert "driver" not in describe_stall(free, IntegrationStatus.STALLED)
    assert "singular configuration" in describe_stall(free, IntegrationStatus.STALLED)
    assert "without end" in describe_stall(gm.load("porter_dry_friction"), IntegrationStatus.ENDLESS_EVENTS)


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
    for name, values in run.readings.items():
        error = np.max(np.abs(values - reference.readings[name])) / run.scales[name]
        assert error <= 3 * run.error_estimate, name


def test_the_default_number_of_steps_falls_with_the_number_of_joints():
    engine = MultibodyEngine(settings=MultibodySettings(max_step_work=1e4))
    run = gm.run("pendulum_iftomm", engine=engine, times=[1e9])
    assert run.outcome is Outcome.STEP_LIMIT
    assert "max_steps = 2000 reached" in run.message  # one joint, and the fixed work of four
    assert engine.step_limit(gm.load("four_bar_chain")) < 1000


@pytest.mark.long
@pytest.mark.parametrize("engine", ["reduced", "multibody"])
def test_a_higher_accuracy_returns_no_worse_a_run(engine):
    runs = [gm.run("slider_crank_torque", engine=engine, accuracy=accuracy, times=[3.0]) for accuracy in (1e-10, 1e-11, 1e-12)]
    first, *others = [run.error_estimate for run in runs]
    # Below 1e-10 the differences of runs are rounding, by chance: three halvings of the steps give 3e-11 to 2e-10.
    assert first < 1e-10
    assert all(estimate < 1e-10 for estimate in others)


def test_the_estimate_covers_the_rounding_of_large_angles_and_events_stay_within_memory():
    """A torque of 1e8 N m on a rod turns it by 1.5e8 rad in 1 s, exactly 1.5 torque t^2: rounding alone leaves 1e-5 rad."""
    torque = 1e8
    scene = parse_scene_document(HARD_CASES["runaway-torque"].make_document(torque) | {"run": {"duration": 1.0, "output_interval": 0.1}})
    run = ReducedEngine(tolerance=1e-10).run(scene)
    error = np.max(np.abs(run.readings["rod_angle"] - 1.5 * torque * run.times**2))
    assert 1e-6 < error <= run.error_estimate
    assert run.outcome is Outcome.ACCURACY_MISSED
    assert run.events == ()

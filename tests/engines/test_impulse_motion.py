"""Simulated motion against references and the one-coordinate equation of motion, and its order of convergence."""

import math

import numpy as np
import pytest

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.time_inputs import TimeInputs
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_scenes import EXTENDED, PORTER, WATT, governor_scene, porter_open, random_governor
from one_coordinate_reference import integrate_one_coordinate
from reference import zehnder
from rigid_link_governor import porter_with_rods


@pytest.mark.parametrize("accuracy", [1e-6, 1e-8])
def test_porter_open_matches_the_reference_after_two_seconds(accuracy):
    run = ImpulseEngine().run(porter_open(accuracy=accuracy))
    expected = zehnder.PORTER_OPEN_MOTION["constant_speed"]
    assert run.outcome is Outcome.DONE
    assert run.times[-1] == zehnder.PORTER_OPEN_MOTION["time"]
    assert run.readings["arm_angle"][-1] == pytest.approx(expected["arm_angle"], abs=accuracy)
    assert run.rates["arm_angle"][-1] == pytest.approx(expected["arm_rate"], abs=accuracy * zehnder.PORTER_OPEN_MOTION["spindle_speed"])
    torque = expected["drive_torque"]
    assert run.readings["spindle_torque"][-1] == pytest.approx(torque, abs=accuracy * run.scales["spindle_torque"])
    assert run.energy.drift < accuracy
    assert run.joint_gap.max() < accuracy * PORTER["arm"]


@pytest.mark.long
def test_the_estimate_is_not_below_the_true_error_in_random_governors():
    random = np.random.default_rng(20260921)
    n_underestimated, compared = 0, 0
    while compared < 20:
        dimensions, middle = random_governor(random)
        governor = closed.PendulumGovernor(**dimensions)
        speed = float(closed.equilibrium_speed(governor, arm_angle=middle))
        angle, rate = middle + random.uniform(-0.1, 0.1), random.uniform(-0.3, 0.3)
        accuracy = 10 ** random.uniform(-9, -4)
        scene = governor_scene(dimensions, speed=speed, angle=angle, rate=rate, duration=1.0, output_interval=0.05, accuracy=accuracy)
        run = ImpulseEngine().run(scene)
        assert run.outcome in (Outcome.DONE, Outcome.LEFT_RANGE)
        angles, rates = integrate_one_coordinate(scene, run.times)
        true = max(
            np.max(np.abs(run.readings["arm_angle"] - angles)), np.max(np.abs(run.rates["arm_angle"] - rates)) / run.scales["spindle_speed"]
        )
        assert true <= scene.run.accuracy
        n_underestimated += true > run.error_estimate
        compared += 1
    assert n_underestimated <= 1  # 5 %: the reliability of a difference of two extrapolated runs


@pytest.mark.parametrize(
    ("machine", "settings", "certify", "order", "scatter"),
    [
        ("point masses", {"runs": 1}, False, 2, 0.1),
        ("levers", {"runs": 1}, False, 2, 0.1),
        ("rigid links", {"plain": True}, False, 1, 0.1),
        ("rigid links", {"runs": 1}, False, 2, 0.1),
        ("rigid links", {"runs": 2}, False, 3, 0.3),
        ("rigid links", {"runs": 3}, False, 4, 0.4),
        ("rigid links", {"runs": 3}, True, 3, 0.3),
    ],
)
def test_the_error_falls_with_the_stated_order(machine, settings, certify, order, scatter):
    if machine == "rigid links":
        scene, reference = porter_with_rods(speed=13.0, angle=0.9, rate=1.5)
    else:
        start = (PORTER, 13.0, 0.9, 1.5) if machine == "point masses" else (EXTENDED, 8.4, 0.65, 0.5)
        scene = governor_scene(start[0], speed=start[1], angle=start[2], rate=start[3])
        reference = integrate_one_coordinate
    times = np.linspace(0.1, 0.4, 4)  # the largest error over many times has no accidental zero
    expected, _ = reference(scene, times)
    # Fine enough for the leading error to lead, coarse enough to stay above rounding (4e-13).
    coarsest = {1: 256, 2: 16, 3: 8, 4: 4}[1 if settings.get("plain") else order]
    steps = 0.1 / (coarsest * 2 ** np.arange(3))
    errors = []
    for step in steps:
        engine = ImpulseEngine(step=step, iterations=160, **settings)
        run = engine.run(scene, times=times, certify=certify)
        errors.append(np.max(np.abs(run.readings["arm_angle"] - expected)))
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(order, abs=scatter)


def test_poses_velocities_and_readings_are_consistent():
    run = ImpulseEngine().run(porter_open())
    right, sleeve = run.poses[:, 0], run.poses[:, 2]
    angle = run.readings["arm_angle"]
    # 1e-12: the same poses, evaluated by the package and here.
    np.testing.assert_allclose(right[:, 0], run.readings["ball_radius"], atol=1e-12)
    np.testing.assert_allclose(np.arctan2(right[:, 0] - PORTER["offset"], -right[:, 1]), angle, atol=1e-12)
    np.testing.assert_allclose(run.readings["sleeve_lift"], sleeve[:, 1] + 2 * PORTER["arm"], atol=1e-12)
    # 1e-5: the centred difference of 10 ms has an error of h^2/6 times the third derivative.
    difference_quotient = (angle[2:] - angle[:-2]) / (run.times[2:] - run.times[:-2])
    np.testing.assert_allclose(run.rates["arm_angle"][1:-1], difference_quotient, atol=2e-3)


@pytest.mark.parametrize("dimensions", [PORTER, WATT, EXTENDED])
def test_reported_velocities_satisfy_the_joints(dimensions):
    # The jump lies between reported times, so that steps of three lengths meet.
    spindle = Spindle(times=(0.0, 0.237, 0.237), speeds=(8.0, 8.0, 8.4))
    run = ImpulseEngine().run(governor_scene(dimensions, speed=spindle, angle=0.6, duration=0.5, output_interval=0.05))
    jacobian = ConstraintEquations(run.scene.part.mechanism).jacobian(run.poses)
    residual_rates = np.einsum("nebc,nbc->ne", jacobian, run.velocities)
    # 1e-6 of the fastest ball: the accuracy of the poses of the Jacobian.
    np.testing.assert_allclose(residual_rates, 0.0, atol=1e-6 * np.abs(run.velocities).max())


@pytest.mark.long
def test_a_pass_close_to_a_singular_configuration_is_certified():
    # At 0.4 degrees arms and links are nearly collinear and hardly constrain the relative motion of the balls: with few iterations
    # the symmetry is lost while every joint stays closed.
    scene = governor_scene(EXTENDED, speed=8.4, angle=0.75, rate=1.0, duration=1.1, accuracy=1e-8)
    run = ImpulseEngine().run(scene)
    angles, _ = integrate_one_coordinate(scene, run.times)
    assert run.outcome is Outcome.DONE
    assert np.degrees(angles.min()) < 0.5
    assert np.max(np.abs(run.readings["arm_angle"] - angles)) < 1e-8


def test_iterations_are_raised_if_joints_stay_open():
    # With five iterations the run diverges (with ten at a finer step): the joint gap shows it and the iterations are raised.
    dimensions = {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 1.0}
    speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=math.radians(40)))
    scene = governor_scene(dimensions, speed=speed, angle=0.9, rate=1.5, accuracy=1e-8)
    run = ImpulseEngine(iterations=5).run(scene)
    assert run.outcome is Outcome.DONE
    assert run.cost.iterations > 5
    angles, _ = integrate_one_coordinate(scene, run.times)
    assert np.max(np.abs(run.readings["arm_angle"] - angles)) < 1e-8


def test_the_cost_of_a_run_is_counted():
    run = ImpulseEngine(step=0.01, runs=1).run(porter_open())
    assert run.cost.steps == 200
    assert run.cost.runs == 1
    # Three bodies have weight; the sleeve on the axis has no centrifugal load to evaluate.
    assert run.cost.evaluations == {"gravity": 600, "centrifugal": 400}


@pytest.mark.parametrize("cycles_per_turn", [10.0, 300.0])
def test_a_given_step_of_whole_cycles_of_the_speed_sees_the_cycles(cycles_per_turn):
    fluctuating = Spindle(speeds=(12.0,), speed_fluctuation=0.5, cycles_per_turn=cycles_per_turn)
    step = 4 * 2 * np.pi / (cycles_per_turn * 12.0)  # of a quarter of it, all runs would see the mean speed only
    scene = governor_scene(PORTER, speed=fluctuating, angle=0.7, rate=0.15, duration=4 * step, output_interval=step)
    run, reference = ImpulseEngine(step=step).run(scene), MultibodyEngine().run(scene, accuracy=1e-9)
    for name, readings in run.readings.items():
        assert np.max(np.abs(readings - reference.readings[name])) / run.scales[name] <= 3 * run.error_estimate, name


@pytest.mark.parametrize("is_plain", [True, False])
def test_forces_act_where_a_step_ends_and_in_plain_pymunk_where_it_begins(is_plain):
    """A point mass on a spring: positions move by the old velocities, then velocities by the force; joints are set to where both lead."""
    stiffness, mass, h = 90.0, 2.0, 0.01
    scene = Scene.from_dict(
        {
            "machine": "custom",
            "ground": {"A": [0, 0]},
            "body": [{"name": "mass", "mass": mass, "point": True, "at": [0.5, 0]}],
            "force": [{"type": "spring", "first": "ground.A", "second": "mass.origin", "stiffness": stiffness, "free_length": 0.2}],
            "readings": {"x": {"x": "mass.origin"}},
            "run": {"duration": 1.0},
        }
    )
    model, time_inputs, seen = PymunkModel(scene, iterations=20, plain=is_plain), TimeInputs(scene), []
    model._joint_updates.append(lambda poses, inputs: seen.append(poses[0][0]))
    model.start(np.array([[0.5, 0.0, 0.0]]), np.array([[0.7, 0.0, 0.0]]), time_inputs.start_inputs(h))
    x, v = (float(part[0, 0]) for part in model.state())
    seen.clear()
    for _ in range(20):
        model.step(time_inputs.constant_inputs(h))
        force_at = x if is_plain else x + h * v
        x, v = x + h * v, v - h * stiffness / mass * (force_at - 0.2)
        np.testing.assert_allclose([part[0, 0] for part in model.state()], [x, v], rtol=1e-13)
        assert seen[-1] == pytest.approx(x, rel=1e-13)

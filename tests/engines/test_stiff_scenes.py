"""Stiff scenes: the engine detects stiffness, switches to implicit steps, reports it, and agrees with known motions."""

import math

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part
from governor_mechanism.effects.body_forces import Gravity
from governor_mechanism.engines import MultibodyEngine
from governor_mechanism.model.force_elements import Damper, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import Distance, Pin
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.time_functions import InputFunction
from reference import stiff_flyball
from scene_parts import body_angle, body_point, ground_point, make_mechanism, point_mass, rod_body, scene_of, x_reading


def make_scene(mechanism, *, gravity, duration=2.0, values=None):
    return scene_of(mechanism, *([Gravity()] if gravity else []), values=values, duration=duration, output_interval=0.01)


def two_rods(stiffness, damping):
    """Return two uniform rods of 1 m in line, horizontal, with a stiff joint between them: nearly one rod of 2 m."""
    joints = [
        Pin(name="pin", first=ground_point(), second=body_point("upper", -0.5)),
        Pin(name="knee", first=body_point("upper", 0.5), second=body_point("lower", -0.5)),
    ]
    loads = [
        TorsionSpring(name="spring", first="upper", second="lower", stiffness=stiffness),
        TorsionDamper(name="damper", first="upper", second="lower", damping=damping),
    ]
    readings = [body_angle("upper"), BodyAngle(name="bend", quantity="angle", body="lower", reference_body="upper")]
    sketch = [(0.5, 0.0, 0.0), (1.5, 0.0, 0.0)]
    return make_mechanism([rod_body("upper", 1.0, 1.0), rod_body("lower", 1.0, 1.0)], joints, readings, sketch, loads=loads)


@pytest.mark.parametrize(("stiffness", "damping"), [(1e4, 1e4), (1e6, 1e5), (1e3, 1e6)])
def test_two_rods_with_a_stiff_joint_oscillate_as_one(stiffness, damping):
    run = MultibodyEngine().run(make_scene(two_rods(stiffness, damping), gravity=True, duration=0.5), accuracy=1e-6)
    assert run.outcome is gm.Outcome.DONE
    assert run.cost.method.startswith("stiff from t = ")
    assert "implicit" in run.cost.method
    # One uniform rod of 2 m released from the horizontal: a pendulum of length (2/3) 2 m.
    m, length = 0.5, 4 / 3
    sn, _, _, _ = ellipj(ellipk(m) - math.sqrt(9.81 / length) * run.times, m)
    angle = 2 * np.arcsin(math.sqrt(m) * sn) - math.pi / 2
    # The joint moment is at most about 30 N m for 0.5 s: the angle is at most 30 N m * 0.5 s / damping or 30 N m / stiffness.
    max_bend = 30.0 * min(0.5 / damping, 1 / stiffness) + 1e-6
    assert np.max(np.abs(run.readings["bend"])) < max_bend
    assert (
        np.max(np.abs(run.readings["upper"] + math.pi + angle)) < 3 * max_bend
        or np.max(np.abs(run.readings["upper"] - angle)) < 3 * max_bend
    )
    assert run.joint_gap.max() < 1e-12


def damped_mass(rate, place):
    """Return 1 kg at a place (m) on a spring that is slack at 1 m, with a damper: it comes back at about 1/s, or at the rate (1/s)."""
    loads = [
        Spring(name="spring", first=ground_point(), second=body_point("ball"), stiffness=rate, free_length=1.0),
        Damper(name="damper", first=ground_point(), second=body_point("ball"), damping=rate),
    ]
    mechanism = make_mechanism([point_mass("ball", 1.0)], [], [x_reading("ball")], [(place, 0.0, 0.0)], loads=loads)
    return make_scene(mechanism, gravity=False)


@pytest.mark.parametrize("rate", [1e3, 1e4, 1e6, 1e8])
@pytest.mark.parametrize("accuracy", [1e-5, 1e-8, 1e-11])
def test_errors_of_a_damped_mass_follow_the_accuracy_at_any_stiffness(rate, accuracy):
    run = MultibodyEngine().run(damped_mass(rate, 1.1), accuracy=accuracy)
    assert run.outcome is gm.Outcome.DONE
    assert ("implicit" in run.cost.method) == (rate > 1e3)
    fast = -0.5 * (rate + math.sqrt(rate**2 - 4 * rate))
    slow = rate / fast
    exact = 1.0 + 0.1 * (fast * np.exp(slow * run.times) - slow * np.exp(fast * run.times)) / (fast - slow)
    assert np.max(np.abs(run.readings["x"] - exact)) < accuracy


def test_a_stiff_mass_at_rest_stays_there_in_few_steps_and_few_allowed_ones_are_a_named_end():
    resting = MultibodyEngine().run(damped_mass(1e6, 1.0), accuracy=1e-8)
    assert np.all(resting.readings["x"] == 1.0)
    assert resting.cost.steps < 20 * resting.cost.runs
    cut = MultibodyEngine(max_steps=3).run(damped_mass(1e6, 1.1), accuracy=1e-8)
    assert cut.outcome is gm.Outcome.STEP_LIMIT
    assert cut.times[-1] < 2.0


def test_method_of_a_scene_that_is_not_stiff():
    run = MultibodyEngine().run(make_scene(two_rods(10.0, 0.1), gravity=True), accuracy=1e-6)
    assert run.cost.method == "explicit (DOP853)"


@pytest.mark.long
def test_the_stiff_flyball_governor_agrees_with_its_equations_in_three_coordinates():
    times = np.linspace(0.0, 10.0, 41)
    reference = stiff_flyball.solve(times)
    for accuracy in (1e-4, 1e-6, 1e-8, 1e-10):
        run = gm.run("stiff_flyball", times=times, accuracy=accuracy)
        assert run.outcome is gm.Outcome.DONE, accuracy
        assert run.error_estimate <= accuracy
        assert run.cost.method.startswith("stiff from t = 0 s")
        assert run.cost.steps < 5000, accuracy  # two or three runs without explicit steps, which alone would be 13,000 in each
        for name, exact in reference.items():
            # The reference has an error of 2e-12 relative to the largest rate, 7 rad/s.
            assert np.max(np.abs(run.readings[name] - exact)) <= run.reading_errors[name] + 1e-11, (accuracy, name)


def pendulum_angle(times, length, amplitude):
    """Return the angle from the vertical (rad) of a pendulum of equivalent length (m) that is released at its amplitude (rad)."""
    m = math.sin(0.5 * amplitude) ** 2
    sn, _, _, _ = ellipj(ellipk(m) - math.sqrt(9.81 / length) * times, m)
    return 2 * np.arcsin(math.sqrt(m) * sn)


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_a_stiff_joint_of_rods_does_not_shorten_the_steps(stiffness):
    run = MultibodyEngine().run(make_scene(two_rods(stiffness, stiffness), gravity=True, duration=4.0), accuracy=1e-8)
    assert run.outcome is gm.Outcome.DONE
    assert "implicit" in run.cost.method
    # The joint bends by 30 N m / stiffness at most, and passes energy in this proportion; ten times as much for four seconds.
    allowed = 300.0 / stiffness + 1e-8
    np.testing.assert_allclose(run.readings["upper"], pendulum_angle(run.times, 4 / 3, math.pi / 2) - math.pi / 2, rtol=0, atol=allowed)
    assert run.joint_gap.max() < 1e-12
    assert run.cost.steps < 450  # two runs, the second with twice the steps; with heights as independent coordinates they take thousands


def test_other_coordinates_become_independent_where_the_first_ones_turn_back():
    """Two equal pendulums of points in parallel: the spring-damper between them keeps its length, but makes the motion stiff."""
    names = ("left", "right")
    places = {name: 0.5 * k for k, name in enumerate(names)}
    rods = [Distance(name=f"{name} rod", first=ground_point(x), second=body_point(name), length=1.0) for name, x in places.items()]
    loads = [
        Spring(name="spring", first=body_point("left"), second=body_point("right"), stiffness=1e4, free_length=0.5),
        Damper(name="damper", first=body_point("left"), second=body_point("right"), damping=1e4),
    ]
    sketch = [(place + 0.8, -0.6, 0.0) for place in places.values()]
    balls = [point_mass(name, 1.0) for name in names]
    mechanism = make_mechanism(balls, rods, [x_reading(name, name) for name in names], sketch, loads=loads)
    values = {name: place + 0.8 for name, place in places.items()}
    run = MultibodyEngine().run(make_scene(mechanism, gravity=True, duration=4.0, values=values), accuracy=1e-8)
    assert run.outcome is gm.Outcome.DONE
    assert run.cost.method.startswith("stiff from t = 0 s")
    for name, place in places.items():
        exact = place + np.sin(pendulum_angle(run.times, 1.0, math.asin(0.8)))
        assert np.max(np.abs(run.readings[name] - exact)) <= run.reading_errors[name] + 1e-12, name  # rounding of the exact solution
    assert run.joint_gap.max() < 1e-12


def test_a_stiff_motion_follows_steps_of_a_torque():
    """J w' = M - c w: after every step of the torque M, w tends to M / c at the rate c / J."""
    inertia, damping, steps = 2.0, 4e4, np.array([0.0, 0.5, 1.2])
    torques = np.array([100.0, -300.0, 50.0])
    times, values = np.repeat(steps, 2)[1:], np.repeat(torques, 2)[:-1]
    torque = Torque(name="load", second="wheel", moment=InputFunction(times=tuple(times), values=tuple(values)))
    disc = discs_part("engine", {"wheel": inertia}, torque, TorsionDamper(name="damper", second="wheel", damping=damping))
    run = gm.run(coupled_scene(disc), engine="multibody", accuracy=1e-8)
    assert run.outcome is gm.Outcome.DONE
    assert run.cost.method.startswith("stiff from t = 0 s")
    angle, speed, last = np.zeros(len(run.times)), 0.0, 0.0
    for start, end, final in zip(steps, [*steps[1:], run.times[-1]], torques / damping, strict=True):
        within = (run.times >= start) & (run.times <= end)
        decay = np.exp(-damping / inertia * (np.append(run.times[within], end) - start))
        path = last + final * (np.append(run.times[within], end) - start) + (speed - final) * inertia / damping * (1 - decay)
        angle[within], last, speed = path[:-1], path[-1], final + (speed - final) * decay[-1]
    np.testing.assert_allclose(run.readings["wheel_angle"], angle, rtol=0, atol=1e-8)  # the requested accuracy
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize(("damping", "is_stiff"), [(5.0, False), (1e6, True)])
def test_stiffness_is_found_before_the_first_step(damping, is_stiff):
    run = MultibodyEngine().run(make_scene(two_rods(1e4, damping), gravity=True, duration=10.0), accuracy=1e-4)
    assert run.outcome is gm.Outcome.DONE
    assert run.cost.method.startswith("stiff from t = 0 s") is is_stiff

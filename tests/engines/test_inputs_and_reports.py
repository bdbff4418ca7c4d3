"""Quantities that a wrong sign would change: torque of a speed ramp, velocities at a jump, rotated axes, full turns."""

import math
from dataclasses import replace

import numpy as np
import pytest

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.impulse.richardson import RichardsonRefinement
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.machines.pendulum import PendulumGovernor
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point, Slider
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.part import Spindle, Start
from governor_mechanism.model.results.records import Outcome
from governor_scenes import EXTENDED, PORTER, governor_scene
from one_coordinate_reference import integrate_one_coordinate
from scene_parts import body_point, ground_point, make_mechanism, point_mass, rod_body, y_reading

ENGINES = [ImpulseEngine, MultibodyEngine, ReducedEngine]


def with_mechanism(scene, **changes):
    return scene.with_changes(mechanism=replace(scene.mechanism, **changes))


@pytest.mark.parametrize("engine", ENGINES)
def test_torque_of_a_speed_ramp_raises_the_arms_and_accelerates_the_parts(engine):
    ramp = Spindle(times=(0.0, 2.0), speeds=(12.0, 14.0))
    run = engine().run(governor_scene(PORTER, speed=ramp, angle=0.6, accuracy=1e-8))
    governor = closed.PendulumGovernor(**PORTER)
    angles, rates = integrate_one_coordinate(run.scene, run.times)
    speed = 12.0 + run.times
    lifting = [
        closed.drive_torque(governor, arm_angle=a, arm_rate=r, spindle_speed=w) for a, r, w in zip(angles, rates, speed, strict=True)
    ]
    speeding = closed.spindle_inertia(governor, arm_angle=angles) * 1.0  # rad/s2
    inner = slice(0, -1)  # the ramp ends at the last point
    expected = (np.array(lifting) + speeding)[inner]
    allowed = 1e-8 * run.scales["spindle_torque"]
    np.testing.assert_allclose(run.readings["spindle_torque"][inner], expected, atol=allowed)


@pytest.mark.parametrize("engine", ENGINES)
def test_velocities_at_a_jump_of_the_speed_are_correct(engine):
    jump = Spindle(times=(0.0, 0.5, 0.5), speeds=(12.0, 12.0, 14.0))
    run = engine().run(governor_scene(PORTER, speed=jump, angle=0.7, duration=1.0, output_interval=0.25, accuracy=1e-8))
    _, rates = integrate_one_coordinate(run.scene, run.times)
    assert run.times[2] == 0.5
    assert run.outcome is Outcome.DONE
    np.testing.assert_allclose(run.rates["arm_angle"], rates, atol=1e-8 * run.scales["spindle_speed"])


def test_steps_of_two_lengths_keep_the_second_order():
    # Output intervals of 37 and 63 ms: the steps are unequal, and all are halved from level to level.
    jump = Spindle(times=(0.0, 0.237, 0.237), speeds=(12.5, 12.5, 13.5))
    scene = governor_scene(PORTER, speed=jump, angle=0.65)
    times = np.linspace(0.1, 1.0, 10)
    task = RunRequest(times=times, accuracy=1e-6, certify=False, reason="")
    climb = RichardsonRefinement(ImpulseSettings(step=5e-3, runs=1), scene, task)
    expected, rates = integrate_one_coordinate(scene, times)
    levels = range(4)
    reports = [climb.extrapolate_at_level(level).observables for level in levels]
    for found, true in (("readings", expected), ("rates", rates)):
        errors = [np.max(np.abs(getattr(report, found)["arm_angle"] - true)) for report in reports]
        assert np.polyfit(levels, np.log2(errors), 1)[0] == pytest.approx(-2, abs=0.1)


@pytest.mark.parametrize("engine", ENGINES)
def test_lever_may_be_described_in_any_axes(engine):
    scene = governor_scene(EXTENDED, speed=8.4, angle=0.6, duration=0.5)
    mechanism = scene.part.mechanism
    turn = 0.7  # rotation of the body axes, reversed in its points and its angle

    def turned(point: Point) -> Point:
        if point.body == GROUND or point.body == "sleeve":
            return point
        cosine, sine = math.cos(turn), math.sin(turn)
        return Point(body=point.body, x=cosine * point.x + sine * point.y, y=cosine * point.y - sine * point.x)

    def rebuilt(joint: Joint) -> Joint:
        return replace(joint, first=turned(joint.first), second=turned(joint.second))

    initial_guess = tuple(
        (x, y, angle + turn if body.can_rotate else angle)
        for body, (x, y, angle) in zip(mechanism.bodies, mechanism.initial_guess, strict=True)
    )
    other = with_mechanism(scene, joints=tuple(map(rebuilt, mechanism.joints)), initial_guess=initial_guess)
    one, two = engine().run(scene), engine().run(other)
    np.testing.assert_allclose(two.poses[..., :2], one.poses[..., :2], atol=1e-9)
    np.testing.assert_allclose(two.velocities, one.velocities, atol=1e-7)


@pytest.mark.parametrize("engine", ENGINES)
def test_angle_is_continuous_over_full_turns(engine):
    hinge = Pin(name="hinge", first=ground_point(), second=body_point("rod", -0.5))
    reading = LineAngle(name="turned", quantity="angle", start=ground_point(), end=body_point("rod"))
    mechanism = make_mechanism([rod_body("rod", 1.0, 1.0)], [hinge], [reading], [(0.0, -0.5, -math.pi / 2)])
    scene = governor_scene(PORTER, speed=13.0, angle=0.7, output_interval=0.05)
    scene = scene.with_changes(effects=(), mechanism=mechanism, start=Start(values={"turned": 0.0}, rates={"turned": 5.0}))
    run = engine().run(scene)
    assert run.outcome is Outcome.DONE
    np.testing.assert_allclose(run.readings["turned"], 5.0 * run.times, atol=1e-5)
    # There are no forces, so the initial rate sets the time scale.
    assert time_scale(scene) == pytest.approx(1 / 5.0)


def test_body_guided_off_the_axis_has_a_centrifugal_force():
    def evaluations(distance: float) -> int:
        guide = Slider(name="guide", first=ground_point(distance), second=body_point("slug"), angle=math.pi / 2)
        mechanism = make_mechanism([point_mass("slug", 1.0)], [guide], [y_reading("slug", "height")], [(distance, 0.0, 0.0)])
        scene = governor_scene(PORTER, speed=13.0, angle=0.7, duration=0.1)
        scene = scene.with_changes(mechanism=mechanism, start=Start(values={"height": 0.0}))
        return ImpulseEngine().run(scene).cost.evaluations.get("centrifugal", 0)

    assert evaluations(0.0) == 0
    assert evaluations(0.1) > 0


@pytest.mark.parametrize("engine", [pytest.param(ImpulseEngine, marks=pytest.mark.long), MultibodyEngine, ReducedEngine])
def test_link_that_passes_its_dead_centre_ends_the_run_although_the_arm_reverses(engine):
    # The short link becomes perpendicular to the spindle: the arm cannot continue and reverses, the sleeve moves on.
    dimensions = {**PORTER, "link": 0.15}
    limit = PendulumGovernor(**dimensions).mechanism().limits[0]
    scene = governor_scene(dimensions, speed=60.0, angle=limit.high - 0.02, rate=0.5, output_interval=0.25)
    run = engine().run(scene)
    assert run.outcome is Outcome.LEFT_RANGE
    assert "the link is at 90 degrees" in run.message


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("output_interval", [2.0, 0.1])
def test_speed_jump_at_the_end_of_the_run(engine, output_interval):
    jump = Spindle(times=(0.0, 2.0, 2.0), speeds=(13.0, 13.0, 14.0))
    run = engine().run(governor_scene(PORTER, speed=jump, angle=0.7, output_interval=output_interval, accuracy=1e-2))
    assert run.outcome is Outcome.DONE
    _, rates = integrate_one_coordinate(run.scene, run.times)
    np.testing.assert_allclose(run.rates["arm_angle"], rates, atol=1e-2 * run.scales["spindle_speed"])

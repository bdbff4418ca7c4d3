"""The Hartnell governor: geometry, virtual work, agreement of the engines, cross-check, drawing, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.machines.hartnell import HartnellGovernor
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.statics.equilibrium_speed import evaluate_readings

GOVERNOR = HartnellGovernor(ball_arm=0.12, sleeve_arm=0.08, pivot_radius=0.12, ball_mass=2.5)
LOADED = {"dimensions.sleeve_mass": "1.5 kg", "dimensions.bell_crank_angle": "100 deg", "dimensions.inner_radius": "115 mm"}
ANGLES = np.radians([-20.0, -3.0, 0.0, 8.0, 25.0])


@pytest.mark.parametrize("changes", [{}, LOADED], ids=["right angle, no sleeve mass", "obtuse, loaded"])
def test_ball_and_sleeve_are_where_the_two_arms_put_them(changes):
    scene = gm.load("hartnell").replace(changes)
    reduction = SingleDofReduction(scene)
    found = evaluate_readings(reduction.mechanism, reduction.evaluate(ANGLES))
    dimensions = scene.part.dimensions
    np.testing.assert_allclose(found["ball_radius"], 0.12 + 0.12 * np.sin(ANGLES), rtol=1e-12)
    angle = dimensions["bell_crank_angle"]
    lowest = math.asin((dimensions["inner_radius"] - 0.12) / 0.12)
    lift = 0.08 * (np.cos(angle - ANGLES) - math.cos(angle - lowest))
    np.testing.assert_allclose(found["sleeve_lift"], lift, atol=1e-14)


def test_the_obliquity_of_a_right_angle_cancels_so_that_only_the_weight_of_the_balls_is_neglected():
    """The textbook's m w^2 r a = S b / 2 is exact without gravity, and short of m g a tan(beta) with it."""
    governor = closed.HartnellGovernor(ball_arm=0.12, sleeve_arm=0.08, pivot_radius=0.12, ball_mass=2.5)
    radii = np.asarray(closed.ball_radius(governor, arm_angle=ANGLES))
    textbook = closed.textbook_sleeve_force(governor, ball_radius=radii, spindle_speed=30.0)
    weightless = closed.spring_force(replace(governor, gravity=0.0), arm_angle=ANGLES, spindle_speed=30.0)
    np.testing.assert_allclose(weightless, textbook, rtol=1e-13)
    exact = closed.spring_force(governor, arm_angle=ANGLES, spindle_speed=30.0)
    np.testing.assert_allclose(exact - textbook, 2 * 2.5 * 9.81 * np.tan(ANGLES) * 0.12 / 0.08, rtol=1e-10, atol=1e-11)
    oblique = closed.spring_force(replace(governor, gravity=0.0, angle=math.radians(100)), arm_angle=ANGLES, spindle_speed=30.0)
    assert np.max(np.abs(oblique / textbook - 1)) > 0.01


def test_the_engines_agree_and_the_closed_form_agrees_with_them():
    scene = gm.load("hartnell").replace({**LOADED, "run.duration": "1 s"})
    times = np.linspace(0.0, 1.0, 11)
    reduced, multibody = (gm.run(scene, engine=engine, accuracy=1e-9, times=times) for engine in ("reduced", "multibody"))
    for name in ("arm_angle", "ball_radius", "sleeve_lift"):
        np.testing.assert_allclose(multibody.readings[name], reduced.readings[name], atol=1e-8)  # asked of each: 1e-9 of about 1
    report = gm.crosscheck(scene)
    assert report.passed, str(report)
    assert any("small-oscillation period" in row.quantity for row in report.rows)


def test_without_its_spring_the_sleeve_load_is_that_of_the_weights():
    scene = gm.load("hartnell").replace({"effects.spring": False, "start.arm_angle": 0.0, **LOADED})
    static = gm.kinematics(scene, over="arm_angle", values=[0.0])
    # balls upright have no moment: only the sleeve
    assert static.readings["static_sleeve_force"][0] == pytest.approx(1.5 * 9.81, rel=1e-12)


def test_a_start_outside_the_travel_is_refused():
    assert not GOVERNOR.start_problems({"arm_angle": 0.1})
    (problem,) = GOVERNOR.start_problems({"arm_angle": 5.0})
    assert "outside the travel" in problem
    assert "5 deg" in problem


def test_the_travel_ends_where_the_balls_meet_on_the_axis():
    near = replace(GOVERNOR, pivot_radius=0.09, sleeve_arm=0.05)
    limit = near.travel_limit()
    assert limit.low == pytest.approx(-math.asin(0.09 / 0.12), rel=1e-15)
    assert limit.low_message == "the balls meet on the spindle axis"

"""The Proell governor: geometry, virtual work, the textbook formula, agreement of the engines, cross-check, and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum
from governor_mechanism.closed_form import proell as closed
from governor_mechanism.machines.proell import ProellGovernor
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.statics.equilibrium_speed import evaluate_readings

GOVERNOR = ProellGovernor(arm=0.25, extension=0.1, upright_radius=0.15, ball_mass=5.0, sleeve_mass=40.0)
UNEQUAL = {"dimensions.link": "220 mm", "dimensions.offset": "20 mm", "dimensions.lug_offset": "35 mm"}
ANGLES = np.radians([25.0, 40.0, 60.0])


def build_closed_form(**changes: float) -> closed.ProellGovernor:
    values = {"arm": 0.25, "link": 0.22, "extension": 0.1, "bend": -0.5, "ball_mass": 5.0, "sleeve_mass": 40.0}
    return closed.ProellGovernor(**(values | {"offset": 0.02, "lug_offset": 0.035} | changes))


@pytest.mark.parametrize("changes", [{}, UNEQUAL], ids=["equal arms", "offsets"])
def test_the_ball_is_on_the_line_of_its_extension(changes):
    """By complex numbers: joint, lug on the axis side, and the extension turned from the lower arm by the bend."""
    scene = gm.load("proell").replace(changes)
    dimensions = scene.part.dimensions
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate(ANGLES)
    found = evaluate_readings(reduction.mechanism, coefficients)
    joint = dimensions["offset"] - 1j * dimensions["arm"] * np.exp(1j * ANGLES)
    drop = np.sqrt(dimensions["link"] ** 2 - (joint.real - dimensions["lug_offset"]) ** 2)
    lug = dimensions["lug_offset"] + 1j * (joint.imag - drop)
    direction = (joint - lug) / np.abs(joint - lug) * np.exp(-1j * dimensions["extension_angle"])  # outward is clockwise
    ball = joint + dimensions["extension"] * direction
    np.testing.assert_allclose(found["ball_radius"], ball.real, rtol=1e-12)
    right = coefficients.poses[:, reduction.mechanism.body_index("right ball")]
    np.testing.assert_allclose(right[:, :2], np.stack([ball.real, ball.imag], axis=-1), atol=1e-13)
    zero = found["sleeve_lift"] - lug.imag
    np.testing.assert_allclose(zero, zero[0], atol=1e-13)


def test_the_textbook_formula_is_exact_where_the_extension_is_upright():
    """w^2 = (g / h) (f / (f + e)) (m + M (1 + q) / 2) / m."""
    angle = math.radians(38.0)
    joint = 0.02 + 0.25 * math.sin(angle)
    governor = build_closed_form(bend=float(closed.upright_bend(joint_radius=joint, link=0.22, lug_offset=0.035)))
    lean = math.asin((joint - 0.035) / 0.22)
    foot, ratio = 0.22 * math.cos(lean), math.tan(lean) / math.tan(angle)
    height = joint / math.tan(angle)
    squared = 9.81 / height * foot / (foot + 0.1) * (5.0 + 20.0 * (1 + ratio)) / 5.0
    assert closed.equilibrium_speed(governor, arm_angle=angle) == pytest.approx(math.sqrt(squared), rel=1e-13)


def test_a_vanishing_extension_makes_it_a_porter_governor():
    """A ball 1e-9 of the arm beyond the joint moves its speed by as much."""
    lengths = {"arm": 0.25, "offset": 0.02, "lug_offset": 0.035, "link": 0.22}
    porter = pendulum.PendulumGovernor(**lengths, ball_mass=5.0, sleeve_mass=40.0)
    proell = build_closed_form(extension=2.5e-10)
    for function in ("equilibrium_speed",):
        expected = getattr(pendulum, function)(porter, arm_angle=ANGLES)
        np.testing.assert_allclose(getattr(closed, function)(proell, arm_angle=ANGLES), expected, rtol=1e-8)


def test_sarkars_equilibrium_with_upright_extensions_is_unstable():
    """His 163.9 rpm at 150 mm lie where the speed falls as the balls move outward; the formula does not show it."""
    curve = gm.controlling_force("proell", over=np.radians([math.degrees(math.asin(0.6)), 45.0]))
    assert curve.radius[0] == pytest.approx(0.15, rel=1e-12)
    assert curve.stable.tolist() == [False, True]
    lowest = gm.speed_curve("proell", points=400)
    assert 0.15 < lowest.readings["ball_radius"][np.argmin(lowest.speed)] < 0.19


def test_the_engines_agree_and_the_closed_form_agrees_with_them():
    scene = gm.load("proell").replace({**UNEQUAL, "run.duration": "1 s", "start.arm_angle": "50 deg"})
    times = np.linspace(0.0, 1.0, 11)
    reduced, multibody = (gm.run(scene, engine=engine, accuracy=1e-9, times=times) for engine in ("reduced", "multibody"))
    for name in ("arm_angle", "ball_radius", "sleeve_lift"):
        np.testing.assert_allclose(multibody.readings[name], reduced.readings[name], atol=1e-8)  # asked of each: 1e-9 of about 1
    report = gm.crosscheck(scene)
    assert report.passed, str(report)
    assert any("relaxation is not checked" in note for note in report.notes)


def test_a_bend_and_its_upright_radius_are_the_same_governor():
    bent = replace(GOVERNOR, upright_radius=None, extension_angle=-math.asin(0.6))
    assert bent.dimensions() == pytest.approx(GOVERNOR.dimensions(), rel=1e-15)

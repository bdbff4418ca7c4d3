"""Residuals of joints where bodies stand as the joint says, and how far they are from there."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.model import joints as joint_types
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.model.time_functions import PrescribedMotion
from scene_parts import body_angle, body_point, make_mechanism, point_mass, rotating_body, x_reading

LENGTH_SCALE = 0.4
KNOTS, HEIGHTS = (-0.3, -0.1, 0.2, 0.35, 0.6), (0.1, -0.2, 0.3, 0.25, -0.1)
POLYNOMIAL = (0.1, -0.4, 0.3, 0.2, -0.1, 0.02)


def equations_of(*joints: joint_types.Joint) -> ConstraintEquations:
    """Return the equations of joints between the bodies a and b."""
    bodies = [rotating_body(name, 1.0, 1.0) for name in "ab"]
    return ConstraintEquations(make_mechanism(bodies, joints, [body_angle("a")], [(0.0,) * 3, (1.0, 0.0, 0.0)], size=LENGTH_SCALE))


@pytest.mark.parametrize("x", [-0.45, *KNOTS, -0.2, 0.05, 0.3, 0.5, 0.7])
def test_slots_follow_their_curves_over_all_segments(x):
    """The slot of a turned and moved body, beside one of another degree."""
    pin, angle, slope = joint_types.Point(body="b"), 0.3, 0.6
    equations = equations_of(
        joint_types.CurveSlot(
            name="cam", first=joint_types.Point(body="a"), second=pin, angle=slope, curve=PolynomialCurve(coefficients=POLYNOMIAL)
        ),
        joint_types.CurveSlot(
            name="groove", first=joint_types.Point(body="a"), second=pin, angle=slope, curve=SplineCurve(x=KNOTS, y=HEIGHTS)
        ),
        joint_types.CurveSlot(
            name="guide", first=joint_types.Point(body=joint_types.GROUND), second=pin, curve=PolynomialCurve(coefficients=(0.2, 0.5))
        ),
    )
    curves = np.polynomial.Polynomial(POLYNOMIAL), CubicSpline(KNOTS, HEIGHTS)
    for k, curve in enumerate(curves):
        place = complex(0.4, -0.2) + complex(x, float(curve(x)) + 0.01) * np.exp(1j * (angle + slope))
        residuals = equations.residuals(np.array([[0.4, -0.2, angle], [place.real, place.imag, 1.9]]))
        assert residuals[k] == pytest.approx(0.01, abs=1e-15)  # rounding of places
        assert residuals[2] == pytest.approx(place.imag - (0.2 + 0.5 * place.real), abs=1e-15)


ON_BOTH = {"first": joint_types.Point(body="a", x=0.1), "second": joint_types.Point(body="b", y=-0.2)}
LINE = PrescribedMotion(times=(0.0, 1.0), values=(0.2, 0.8))


@pytest.mark.parametrize(
    ("joint", "residual"),
    [
        # The angles are 0.5 and 0.3, the points at (1, 2) and (1.7, 1.4); angles count in length scales.
        (joint_types.Gear(name="j", ratio=-1.7, offset=0.2, **ON_BOTH), LENGTH_SCALE * (0.3 + 1.7 * 0.5 - 0.2)),
        (joint_types.RackAndPinion(name="j", radius=0.3, angle=math.pi / 2, offset=0.1, **ON_BOTH), -0.6 - 0.3 * 0.5 - 0.1),
        (joint_types.ProportionalDisplacement(name="j", ratio=2.5, angle=0.0, offset=0.1, **ON_BOTH), 1.7 - 2.5 * 1.0 - 0.1),
        (joint_types.RotationalDriver(name="j", motion=LINE, **ON_BOTH), LENGTH_SCALE * (0.3 - 0.5 - 0.5)),
        (joint_types.TranslationalDriver(name="j", motion=LINE, angle=-0.5, **ON_BOTH), 0.7 - 0.5),
    ],
)
def test_joints_of_displacements_and_angles(joint, residual):
    first, second = complex(1, 2) - 0.1 * np.exp(0.5j), complex(1.7, 1.4) + 0.2j * np.exp(0.3j)
    poses = np.array([[first.real, first.imag, 0.5], [second.real, second.imag, 0.3]])
    assert equations_of(joint).residuals(poses, 0.5) == pytest.approx([residual], abs=1e-15)


def test_a_weld_of_bodies_that_cannot_rotate_keeps_their_distance_alone():
    weld = joint_types.Weld(name="j", first=body_point("a"), second=body_point("b"))
    mechanism = make_mechanism([point_mass(name, 1.0) for name in "ab"], [weld], [x_reading("a")], [(0.0,) * 3] * 2)
    assert ConstraintEquations(mechanism).joint_indices.tolist() == [0, 0]
    with pytest.raises(MechanismError, match="'j' prescribes a relative angle of two bodies that cannot rotate"):
        ConstraintEquations(replace(mechanism, joints=(replace(weld, relative_angle=0.1),)))


def test_the_largest_gap_has_a_sign_where_it_is_a_single_number():
    pin = joint_types.Pin(name="pin", first=joint_types.Point(body=joint_types.GROUND), second=joint_types.Point(body="a"))
    rod = joint_types.Distance(name="rod", length=2.0, first=joint_types.Point(body=joint_types.GROUND), second=joint_types.Point(body="b"))
    equations = equations_of(pin, rod)
    for distance, expected in ((1.5, -0.5), (2.5, 0.5)):
        joint, gap = equations.largest_gap(np.array([[0.1, 0.0, 0.0], [0.0, distance, 0.0]]))
        assert (joint, gap) == (rod, pytest.approx(expected, abs=1e-15))
    joint, gap = equations.largest_gap(np.array([[0.3, -0.4, 0.0], [0.0, 1.6, 0.0]]))
    assert (joint, gap) == (pin, pytest.approx(0.5, abs=1e-15))

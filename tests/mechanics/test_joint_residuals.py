"""Residuals of joints where bodies stand as the joint says, and how far they are from there."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.model.joints import (
    GROUND,
    CurveSlot,
    Distance,
    Gear,
    Joint,
    Pin,
    Point,
    ProportionalDisplacement,
    RackAndPinion,
    RotationalDriver,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.time_functions import PrescribedMotion
from scene_parts import body_point, make_mechanism, point_mass, x_reading

LENGTH_SCALE = 0.4
KNOTS, HEIGHTS = (-0.3, -0.1, 0.2, 0.35, 0.6), (0.1, -0.2, 0.3, 0.25, -0.1)
POLYNOMIAL = (0.1, -0.4, 0.3, 0.2, -0.1, 0.02)


def equations_of(*joints: Joint) -> ConstraintEquations:
    """Return the equations of joints between the bodies a and b."""
    moments = SecondMoments(xx=1.0)
    return ConstraintEquations(
        Mechanism(
            bodies=(Body(name="a", mass=1.0, second_moments=moments), Body(name="b", mass=1.0, second_moments=moments)),
            joints=joints,
            readings=(BodyAngle(name="turn", quantity="angle", body="a"),),
            coordinate="turn",
            length_scale=LENGTH_SCALE,
            initial_guess=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
        )
    )


@pytest.mark.parametrize("x", [-0.45, *KNOTS, -0.2, 0.05, 0.3, 0.5, 0.7])
def test_slots_follow_their_curves_over_all_segments(x):
    """The slot of a turned and moved body, beside one of another degree."""
    pin, angle, slope = Point(body="b"), 0.3, 0.6
    equations = equations_of(
        CurveSlot(name="cam", first=Point(body="a"), second=pin, angle=slope, curve=PolynomialCurve(coefficients=POLYNOMIAL)),
        CurveSlot(name="groove", first=Point(body="a"), second=pin, angle=slope, curve=SplineCurve(x=KNOTS, y=HEIGHTS)),
        CurveSlot(name="guide", first=Point(body=GROUND), second=pin, curve=PolynomialCurve(coefficients=(0.2, 0.5))),
    )
    curves = np.polynomial.Polynomial(POLYNOMIAL), CubicSpline(KNOTS, HEIGHTS)
    for k, curve in enumerate(curves):
        place = complex(0.4, -0.2) + complex(x, float(curve(x)) + 0.01) * np.exp(1j * (angle + slope))
        residuals = equations.residuals(np.array([[0.4, -0.2, angle], [place.real, place.imag, 1.9]]))
        assert residuals[k] == pytest.approx(0.01, abs=1e-15)  # rounding of places
        assert residuals[2] == pytest.approx(place.imag - (0.2 + 0.5 * place.real), abs=1e-15)


ON_BOTH = {"first": Point(body="a", x=0.1), "second": Point(body="b", y=-0.2)}
LINE = PrescribedMotion(times=(0.0, 1.0), values=(0.2, 0.8))


@pytest.mark.parametrize(
    ("joint", "residual"),
    [
        # The angles are 0.5 and 0.3, the points at (1, 2) and (1.7, 1.4); angles count in length scales.
        (Gear(name="j", ratio=-1.7, offset=0.2, **ON_BOTH), LENGTH_SCALE * (0.3 + 1.7 * 0.5 - 0.2)),
        (RackAndPinion(name="j", radius=0.3, angle=math.pi / 2, offset=0.1, **ON_BOTH), -0.6 - 0.3 * 0.5 - 0.1),
        (ProportionalDisplacement(name="j", ratio=2.5, angle=0.0, offset=0.1, **ON_BOTH), 1.7 - 2.5 * 1.0 - 0.1),
        (RotationalDriver(name="j", motion=LINE, **ON_BOTH), LENGTH_SCALE * (0.3 - 0.5 - 0.5)),
        (TranslationalDriver(name="j", motion=LINE, angle=-0.5, **ON_BOTH), 0.7 - 0.5),
    ],
)
def test_joints_of_displacements_and_angles(joint, residual):
    first, second = complex(1, 2) - 0.1 * np.exp(0.5j), complex(1.7, 1.4) + 0.2j * np.exp(0.3j)
    poses = np.array([[first.real, first.imag, 0.5], [second.real, second.imag, 0.3]])
    assert equations_of(joint).residuals(poses, 0.5) == pytest.approx([residual], abs=1e-15)


def test_a_weld_of_bodies_that_cannot_rotate_keeps_their_distance_alone():
    weld = Weld(name="j", first=body_point("a"), second=body_point("b"))
    mechanism = make_mechanism([point_mass(name, 1.0) for name in "ab"], [weld], [x_reading("a")], [(0.0,) * 3] * 2)
    assert ConstraintEquations(mechanism).joint_indices.tolist() == [0, 0]
    with pytest.raises(MechanismError, match="'j' prescribes a relative angle of two bodies that cannot rotate"):
        ConstraintEquations(replace(mechanism, joints=(replace(weld, relative_angle=0.1),)))


def test_the_largest_gap_has_a_sign_where_it_is_a_single_number():
    pin = Pin(name="pin", first=Point(body=GROUND), second=Point(body="a"))
    rod = Distance(name="rod", length=2.0, first=Point(body=GROUND), second=Point(body="b"))
    equations = equations_of(pin, rod)
    for distance, expected in ((1.5, -0.5), (2.5, 0.5)):
        joint, gap = equations.largest_gap(np.array([[0.1, 0.0, 0.0], [0.0, distance, 0.0]]))
        assert (joint, gap) == (rod, pytest.approx(expected, abs=1e-15))
    joint, gap = equations.largest_gap(np.array([[0.3, -0.4, 0.0], [0.0, 1.6, 0.0]]))
    assert (joint, gap) == (pin, pytest.approx(0.5, abs=1e-15))

"""Joint equations and reductions against differences of themselves: what is written as a derivative is one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from governor_mechanism.closed_form.pendulum import dynamics as closed
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.curves import PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Force, Spring, Torque, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Distance,
    Gear,
    Pin,
    Point,
    Prismatic,
    ProportionalDisplacement,
    RackAndPinion,
    RotationalDriver,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.mechanism import Body, Mechanism, SecondMoments
from governor_mechanism.model.output_variables import BodyAngle
from governor_mechanism.model.scene import FIXED_PLANE, TURNING_PLANE, Part, Scene, Spindle, Start
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from reference.zehnder import PORTER_OPEN
from rigid_link_governor import ARM_MASS, LINK_MASS, porter_with_rods

ON_BOTH = {"first": Point(body="a", x=0.31, y=-0.17), "second": Point(body="b", x=-0.23, y=0.29)}
MOTION = PrescribedMotion(times=(0.0, 0.4, 1.1), values=(0.2, 0.9, -0.3))
JOINTS = [
    Pin(name="j", **ON_BOTH),
    Weld(name="j", relative_angle=0.4, **ON_BOTH),
    Distance(name="j", length=0.7, **ON_BOTH),
    ArcSlot(name="j", radius=0.7, **ON_BOTH),
    Slider(name="j", angle=0.6, **ON_BOTH),
    Prismatic(name="j", angle=0.6, relative_angle=0.3, **ON_BOTH),
    CurveSlot(name="j", angle=0.6, curve=PolynomialCurve(coefficients=(0.1, -0.4, 0.7, 0.9)), **ON_BOTH),
    CurveSlot(name="j", curve=SplineCurve(x=(-4.0, -1.0, 0.5, 4.0), y=(0.3, -0.5, 0.9, 0.2)), **ON_BOTH),
    Gear(name="j", ratio=-1.7, offset=0.2, **ON_BOTH),
    RackAndPinion(name="j", radius=0.3, angle=0.5, offset=0.1, **ON_BOTH),
    ProportionalDisplacement(name="j", ratio=2.3, angle=0.8, offset=0.1, **ON_BOTH),
    RotationalDriver(name="j", motion=MOTION, **ON_BOTH),
    TranslationalDriver(name="j", motion=MOTION, angle=0.4, **ON_BOTH),
]
STEP = 1e-3
"""Differences of fourth order: 1e-12 times some derivatives of size ten, and 1e-16 / STEP^2 of rounding."""


def differences(value):
    """First and second derivative at zero of a function of time."""
    far, near, here, ahead, beyond = (value(k * STEP) for k in (-2, -1, 0, 1, 2))
    first = (8 * (ahead - near) - (beyond - far)) / (12 * STEP)
    return first, (16 * (ahead + near) - (beyond + far) - 30 * here) / (12 * STEP**2)


def two_bodies(*joints):
    moments = SecondMoments(xx=1.0)
    return Mechanism(
        bodies=(Body(name="a", mass=1.0, second_moments=moments), Body(name="b", mass=1.0, second_moments=moments)),
        joints=joints,
        readings=(BodyAngle(name="turn", quantity="angle", body="a"),),
        coordinate="turn",
        length_scale=1.0,
        initial_guess=((0.0, 0.0, 0.0), (1.0, 0.0, 0.0)),
    )


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: type(joint).__name__)
@pytest.mark.parametrize("seed", range(3))
def test_gradient_and_bend_of_a_joint_between_turning_bodies_are_its_derivatives(joint, seed):
    equations = ConstraintEquations(two_bodies(joint))
    random = np.random.default_rng(seed)
    poses, velocities, accelerations = (random.normal(size=(2, 3)) for _ in range(3))
    now = 0.25  # within a piece of the motion

    def opening(time):
        moved = poses + velocities * time + 0.5 * accelerations * time**2
        return equations.residuals(moved, now + time)

    first, second = differences(opening)
    gradient = equations.jacobian(poses)
    asked = equations.prescribed_motion(np.array(now))[:, 1]
    np.testing.assert_allclose(np.sum(gradient * velocities, axis=(-2, -1)) - asked, first, atol=1e-8)
    implied = np.sum(gradient * accelerations, axis=(-2, -1)) - equations.gamma(poses, velocities, now)
    np.testing.assert_allclose(implied, second, atol=1e-6)


def loaded_crank():
    """A slider-crank whose rod and crank carry every load that has a potential."""
    bodies = (
        Body(name="crank", mass=1.0, second_moments=SecondMoments(xx=0.02)),
        Body(name="rod", mass=0.7, second_moments=SecondMoments(xx=0.05)),
    )
    joints = (
        Pin(name="bearing", first=Point(body=GROUND), second=Point(body="crank", x=-0.1)),
        Pin(name="crank pin", first=Point(body="crank", x=0.1), second=Point(body="rod", x=-0.3)),
        Slider(name="guide", first=Point(body=GROUND, y=0.05), second=Point(body="rod", x=0.3), angle=0.1),
    )
    corner = Point(body="rod", x=0.1, y=0.07)
    loads = (
        Spring(name="spring", first=Point(body=GROUND, x=0.5, y=0.9), second=corner, stiffness=70.0, free_length=0.3),
        Spring(name="stay", first=Point(body="crank", y=0.2), second=corner, stiffness=40.0, free_length=0.5),
        TorsionSpring(name="coil", first="crank", second="rod", stiffness=3.0, free_angle=0.4),
        Torque(name="motor", first="rod", second="crank", moment=InputFunction(values=(1.3,))),
        Force(name="push", point=corner, x=InputFunction(values=(2.0,)), y=InputFunction(values=(-5.0,))),
    )
    mechanism = Mechanism(
        bodies=bodies,
        joints=joints,
        force_elements=loads,
        readings=(BodyAngle(name="turn", quantity="angle", body="crank"),),
        coordinate="turn",
        length_scale=0.6,
        initial_guess=((0.05, 0.09, 1.0), (0.4, 0.1, -0.2)),
    )
    part = Part(name="crank", machine="custom", dimensions={}, mechanism=mechanism, plane=FIXED_PLANE)
    return Scene(title="", parts=(part,), effects=(Gravity(),), spindle=Spindle(), start=Start())


def test_a_reductions_primes_are_the_derivatives_of_its_quantities():
    reduction = SingleDofReduction(loaded_crank())
    along = reduction.evaluate([0.9])
    for name in ("potential", "inertia"):
        first, second = differences(lambda way, name=name: getattr(reduction.evaluate([0.9 + way]), name)[0])
        assert getattr(along, f"{name}_derivative")[0] == pytest.approx(first, rel=1e-7)
        if name == "potential":
            assert along.potential_second_derivative[0] == pytest.approx(second, rel=1e-5)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), value=st.floats(0.3, 1.4))
def test_stiffness_is_half_the_slope_of_inertia_times_that_of_the_speed_squared(seed, value):
    """K = J' d(w^2)/dq / 2 for a linkage with any masses and loads that turns with the spindle."""
    random = np.random.default_rng(seed)
    scene = loaded_crank()
    part = scene.part
    bodies = tuple(
        replace(
            body,
            mass=body.mass * random.uniform(0.3, 3.0),
            second_moments=SecondMoments(xx=0.03, yy=random.uniform(0, 0.02), xy=random.uniform(-0.01, 0.01), zz=0.01),
        )
        for body in part.mechanism.bodies
    )
    loads = tuple(
        replace(load, stiffness=load.stiffness * random.uniform(0.3, 3.0)) if isinstance(load, Spring) else load
        for load in part.mechanism.force_elements
    )
    turning = replace(part, mechanism=replace(part.mechanism, bodies=bodies, force_elements=loads), plane=TURNING_PLANE)
    reduction = SingleDofReduction(replace(scene, parts=(turning,), effects=(Gravity(), Centrifugal())))
    along = reduction.evaluate([value])
    square = 2 * along.potential_derivative[0] / along.spindle_inertia_derivative[0]

    def of_rest(way):
        here = reduction.evaluate([value + way])
        return 2 * here.potential_derivative[0] / here.spindle_inertia_derivative[0]

    stiffness = along.potential_second_derivative[0] - 0.5 * square * along.spindle_inertia_second_derivative[0]
    # Near a pole of the curve its differences are worth little: they are measured against the steepness there.
    parts = abs(along.potential_second_derivative[0]) + abs(0.5 * square * along.spindle_inertia_second_derivative[0])
    near_pole = abs(along.spindle_inertia_second_derivative[0] / along.spindle_inertia_derivative[0])
    expected = 0.5 * along.spindle_inertia_derivative[0] * differences(of_rest)[0]
    assert stiffness == pytest.approx(expected, abs=1e-7 * parts * (1 + near_pole) ** 3)


def test_massive_rods_turn_with_the_spindle_as_the_closed_form_says():
    angles = np.radians([20.0, 30.0, 45.0])
    scene, _ = porter_with_rods(speed=12.0, angle=0.6, rate=0.0)
    along = SingleDofReduction(scene).evaluate(angles)
    governor = closed.PendulumGovernor(**PORTER_OPEN["dimensions"], arm_mass=ARM_MASS, link_mass=LINK_MASS)
    square = 2 * along.potential_derivative / along.spindle_inertia_derivative
    np.testing.assert_allclose(np.sqrt(square), closed.equilibrium_speed(governor, arm_angle=angles), rtol=1e-10)
    stiffness = along.potential_second_derivative - 0.5 * square * along.spindle_inertia_second_derivative
    frequency = closed.squared_oscillation_frequency(governor, arm_angle=angles, spindle_speed=np.sqrt(square))
    np.testing.assert_allclose(stiffness / along.inertia, frequency, rtol=1e-8)  # differences of large parts

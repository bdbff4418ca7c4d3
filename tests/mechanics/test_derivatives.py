"""Derivatives of joint equations and of Lagrangian coefficients, against finite differences."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.mechanics.dynamics.output_forces import element_potential_energy
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model import joints as joint_types
from governor_mechanism.model.curves import PolarHarmonics, PolarSpline, PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Force, Spring, Torque, TorsionSpring
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.time_functions import AngleHarmonic, InputFunction, PrescribedMotion
from reference import zehnder
from rigid_link_governor import ARM_MASS, LINK_MASS, porter_with_rods
from scene_parts import body_angle, make_mechanism, scene_of

ON_BOTH = {"first": joint_types.Point(body="a", x=0.31, y=-0.17), "second": joint_types.Point(body="b", x=-0.23, y=0.29)}
MOTION = PrescribedMotion(times=(0.0, 0.4, 1.1), values=(0.2, 0.9, -0.3))
HARMONICS = (AngleHarmonic(amplitude=0.2, order=2, phase=0.3), AngleHarmonic(amplitude=-0.1, order=1, phase=-0.4))
JOINTS = [
    joint_types.Pin(name="j", **ON_BOTH),
    joint_types.Weld(name="j", relative_angle=0.4, **ON_BOTH),
    joint_types.Distance(name="j", length=0.7, **ON_BOTH),
    joint_types.ArcSlot(name="j", radius=0.7, **ON_BOTH),
    joint_types.Slider(name="j", angle=0.6, **ON_BOTH),
    joint_types.Prismatic(name="j", angle=0.6, relative_angle=0.3, **ON_BOTH),
    joint_types.CurveSlot(name="j", angle=0.6, curve=PolynomialCurve(coefficients=(0.1, -0.4, 0.7, 0.9)), **ON_BOTH),
    joint_types.CurveSlot(name="j", angle=-0.2, curve=PolynomialCurve(coefficients=(0.1, -0.4, 0.3, 0.2, -0.1, 0.02)), **ON_BOTH),
    joint_types.CurveSlot(name="j", curve=SplineCurve(x=(-4.0, -1.0, 0.5, 4.0), y=(0.3, -0.5, 0.9, 0.2)), **ON_BOTH),
    joint_types.CurveSlot(name="j", angle=0.4, curve=PolarSpline(angles=(-2.0, -0.5, 1.0, 2.2), radii=(0.6, 0.9, 0.5, 0.8)), **ON_BOTH),
    joint_types.CurveSlot(name="j", curve=PolarHarmonics(radius=0.7, harmonics=HARMONICS), **ON_BOTH),
    joint_types.Gear(name="j", ratio=-1.7, offset=0.2, **ON_BOTH),
    joint_types.RackAndPinion(name="j", radius=0.3, angle=0.5, offset=0.1, **ON_BOTH),
    joint_types.ProportionalDisplacement(name="j", ratio=2.3, angle=0.8, offset=0.1, **ON_BOTH),
    joint_types.RotationalDriver(name="j", motion=MOTION, **ON_BOTH),
    joint_types.TranslationalDriver(name="j", motion=MOTION, angle=0.4, **ON_BOTH),
]
STEP = 1e-3
"""Step of differences of fourth order: error 1e-12 times derivatives of order ten, and rounding of 1e-16 / STEP^2."""


def differences(value):
    """Return the first and second derivative at zero of a function of time."""
    f = [value(k * STEP) for k in (-2, -1, 0, 1, 2)]
    first = (8 * (f[3] - f[1]) - (f[4] - f[0])) / (12 * STEP)
    return first, (16 * (f[3] + f[1]) - (f[4] + f[0]) - 30 * f[2]) / (12 * STEP**2)


def two_bodies(*joints):
    bodies = [Body(name=name, mass=1.0, second_moments=SecondMoments(xx=1.0)) for name in ("a", "b")]
    return make_mechanism(bodies, joints, [body_angle("a", "turn")], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])


@pytest.mark.parametrize("joint", JOINTS, ids=lambda joint: type(joint).__name__)
@pytest.mark.parametrize("seed", range(3))
def test_jacobian_and_gamma_of_a_joint_are_its_derivatives(joint, seed):
    equations = ConstraintEquations(two_bodies(joint))
    random = np.random.default_rng(seed)
    poses, velocities, accelerations = (random.normal(size=(2, 3)) for _ in range(3))
    start_time = 0.25  # within a segment of the motion

    def residual(time):
        moved = poses + velocities * time + 0.5 * accelerations * time**2
        return equations.residuals(moved, start_time + time)

    first, second = differences(residual)
    gradient = equations.jacobian(poses)
    prescribed_rates = equations.prescribed_motion(np.array(start_time))[:, 1]
    np.testing.assert_allclose(np.sum(gradient * velocities, axis=(-2, -1)) - prescribed_rates, first, atol=1e-8)
    implied = np.sum(gradient * accelerations, axis=(-2, -1)) - equations.gamma(poses, velocities, start_time)
    np.testing.assert_allclose(implied, second, atol=1e-6)


def test_equations_at_many_poses_are_those_at_each_of_them():
    mechanism = two_bodies(*(replace(joint, name=f"joint {k}") for k, joint in enumerate(JOINTS)))
    equations, solver, random = ConstraintEquations(mechanism), PositionSolver(mechanism), np.random.default_rng(3)
    poses, velocities, times = random.normal(size=(2, 3, 2, 3)), random.normal(size=(2, 3, 2, 3)), random.uniform(0.1, 0.4, size=(2, 3))
    residuals, jacobian = equations.residuals(poses, times), equations.jacobian(poses)
    gamma, expanded = equations.gamma(poses, velocities, times), solver.expand_free(poses.reshape(2, 3, 6)[..., solver.free_mask])
    for i, k in np.ndindex(2, 3):
        np.testing.assert_array_equal(residuals[i, k], equations.residuals(poses[i, k], times[i, k]))
        np.testing.assert_array_equal(jacobian[i, k], equations.jacobian(poses[i, k]))
        np.testing.assert_array_equal(gamma[i, k], equations.gamma(poses[i, k], velocities[i, k], times[i, k]))
        np.testing.assert_array_equal(expanded[i, k].ravel()[solver.free_mask], poses[i, k].ravel()[solver.free_mask])


def loaded_crank():
    """Return a slider-crank with every force element that has a potential."""
    bodies = (
        Body(name="crank", mass=1.0, second_moments=SecondMoments(xx=0.02)),
        Body(name="rod", mass=0.7, second_moments=SecondMoments(xx=0.05)),
    )
    joints = (
        joint_types.Pin(name="bearing", first=joint_types.Point(body=joint_types.GROUND), second=joint_types.Point(body="crank", x=-0.1)),
        joint_types.Pin(name="crank pin", first=joint_types.Point(body="crank", x=0.1), second=joint_types.Point(body="rod", x=-0.3)),
        joint_types.Slider(
            name="guide", first=joint_types.Point(body=joint_types.GROUND, y=0.05), second=joint_types.Point(body="rod", x=0.3), angle=0.1
        ),
    )
    corner = joint_types.Point(body="rod", x=0.1, y=0.07)
    loads = (
        Spring(
            name="spring", first=joint_types.Point(body=joint_types.GROUND, x=0.5, y=0.9), second=corner, stiffness=70.0, free_length=0.3
        ),
        Spring(name="stay", first=joint_types.Point(body="crank", y=0.2), second=corner, stiffness=40.0, free_length=0.5),
        TorsionSpring(name="coil", first="crank", second="rod", stiffness=3.0, free_angle=0.4),
        Torque(name="motor", first="rod", second="crank", moment=InputFunction(values=(1.3,))),
        Force(name="push", point=corner, x=InputFunction(values=(2.0,)), y=InputFunction(values=(-5.0,))),
    )
    sketch = [(0.05, 0.09, 1.0), (0.4, 0.1, -0.2)]
    return scene_of(make_mechanism(bodies, joints, [body_angle("crank", "turn")], sketch, loads=loads, size=0.6), Gravity())


def potential_of_loaded_crank(reduction, value):
    """Return the potential of weights, springs, the constant moment and the constant force at a crank angle."""
    mechanism, poses = reduction.mechanism, reduction.evaluate([value]).poses
    weights = sum(body.mass * reduction.scene.gravity * pose[1] for body, pose in zip(mechanism.bodies, poses[0], strict=True))
    (_, _, crank_angle), (rod_x, rod_y, rod_angle) = poses[0]
    point = mechanism.force_elements[-1].point
    turned = (point.x + 1j * point.y) * np.exp(1j * rod_angle)
    corner = np.array([rod_x + turned.real, rod_y + turned.imag])
    return weights + element_potential_energy(mechanism, poses)[0] - 1.3 * (crank_angle - rod_angle) - corner @ [2.0, -5.0]


def test_derivatives_of_the_lagrangian_coefficients():
    reduction = SingleDofReduction(loaded_crank())
    coefficients = reduction.evaluate([0.9])
    first, second = differences(lambda step: potential_of_loaded_crank(reduction, 0.9 + step))
    assert coefficients.potential_derivative[0] == pytest.approx(first, rel=1e-7)
    assert coefficients.potential_second_derivative[0] == pytest.approx(second, rel=1e-5)
    first, _ = differences(lambda step: reduction.evaluate([0.9 + step]).inertia[0])
    assert coefficients.inertia_derivative[0] == pytest.approx(first, rel=1e-7)


@settings(max_examples=30)
@given(seed=st.integers(0, 2**32 - 1), value=st.floats(0.3, 1.4))
def test_stiffness_follows_from_the_derivative_of_the_squared_equilibrium_speed(seed, value):
    """K = J' d(w^2)/dq / 2 for a linkage with any masses and loads that rotates with the spindle."""
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
    mechanism = replace(part.mechanism, bodies=bodies, force_elements=loads)
    reduction = SingleDofReduction(scene.with_changes(mechanism=mechanism, plane=TURNING_PLANE, effects=(Gravity(), Centrifugal())))
    coefficients = reduction.evaluate([value])
    square = 2 * coefficients.potential_derivative[0] / coefficients.spindle_inertia_derivative[0]

    def equilibrium_speed_squared(step):
        shifted = reduction.evaluate([value + step])
        return 2 * shifted.potential_derivative[0] / shifted.spindle_inertia_derivative[0]

    stiffness = coefficients.potential_second_derivative[0] - 0.5 * square * coefficients.spindle_inertia_second_derivative[0]
    # Near a pole of the speed curve differences are inaccurate: the tolerance grows with the steepness.
    parts = abs(coefficients.potential_second_derivative[0]) + abs(0.5 * square * coefficients.spindle_inertia_second_derivative[0])
    near_pole = abs(coefficients.spindle_inertia_second_derivative[0] / coefficients.spindle_inertia_derivative[0])
    expected = 0.5 * coefficients.spindle_inertia_derivative[0] * differences(equilibrium_speed_squared)[0]
    assert stiffness == pytest.approx(expected, abs=1e-7 * parts * (1 + near_pole) ** 3)


def crosshead_in_a_turning_plane():
    """Return a slider-crank with a crosshead that moves along an inclined line without turning; every body is wider than high."""
    moments = SecondMoments(xx=0.03, yy=0.01, xy=0.004, zz=0.02)
    bodies = [Body(name=name, mass=mass, second_moments=moments) for name, mass in (("crank", 1.0), ("rod", 0.7), ("crosshead", 2.0))]
    joints = [
        joint_types.Pin(name="bearing", first=joint_types.Point(body=joint_types.GROUND), second=joint_types.Point(body="crank", x=-0.1)),
        joint_types.Pin(name="crank pin", first=joint_types.Point(body="crank", x=0.1), second=joint_types.Point(body="rod", x=-0.3)),
        joint_types.Pin(name="gudgeon", first=joint_types.Point(body="rod", x=0.3), second=joint_types.Point(body="crosshead")),
        joint_types.Prismatic(
            name="guide",
            first=joint_types.Point(body=joint_types.GROUND),
            second=joint_types.Point(body="crosshead"),
            angle=0.1,
            relative_angle=0.2,
        ),
    ]
    sketch = [(0.05, 0.09, 1.0), (0.4, 0.1, -0.2), (0.7, 0.07, 0.2)]
    scene = scene_of(make_mechanism(bodies, joints, [body_angle("crank", "turn")], sketch, size=0.6), Gravity(), Centrifugal())
    return scene.with_changes(plane=TURNING_PLANE)


def test_the_inertia_about_the_spindle_is_that_of_the_places_of_all_masses():
    reduction = SingleDofReduction(crosshead_in_a_turning_plane())

    def inertia(value):
        """Return the sum over the bodies of the squares of the distances of their masses from the axis, and of their depth."""
        total = 0.0
        for body, (x, _, angle) in zip(reduction.mechanism.bodies, reduction.evaluate([value]).poses[0], strict=True):
            axes, one = np.array([np.cos(angle), -np.sin(angle)]), body.second_moments
            total += body.mass * x**2 + axes @ np.array([[one.xx, one.xy], [one.xy, one.yy]]) @ axes + one.zz
        return total

    for value in (-2.0, 0.9):
        coefficients = reduction.evaluate([value])
        first, second = differences(lambda step, value=value: inertia(value + step))
        assert coefficients.spindle_inertia[0] == pytest.approx(inertia(value), rel=1e-13)
        assert coefficients.spindle_inertia_derivative[0] == pytest.approx(first, rel=1e-8)
        assert coefficients.spindle_inertia_second_derivative[0] == pytest.approx(second, rel=1e-6)


def test_massive_rods_agree_with_the_closed_form():
    angles = np.radians([20.0, 30.0, 45.0])
    scene, _ = porter_with_rods(speed=12.0, angle=0.6, rate=0.0)
    coefficients = SingleDofReduction(scene).evaluate(angles)
    governor = closed.PendulumGovernor(**zehnder.PORTER_OPEN["dimensions"], arm_mass=ARM_MASS, link_mass=LINK_MASS)
    square = 2 * coefficients.potential_derivative / coefficients.spindle_inertia_derivative
    np.testing.assert_allclose(np.sqrt(square), closed.equilibrium_speed(governor, arm_angle=angles), rtol=1e-10)
    stiffness = coefficients.potential_second_derivative - 0.5 * square * coefficients.spindle_inertia_second_derivative
    frequency = closed.squared_oscillation_frequency(governor, arm_angle=angles, spindle_speed=np.sqrt(square))
    np.testing.assert_allclose(stiffness / coefficients.inertia, frequency, rtol=1e-8)  # differences of large terms

"""Assembly and equilibria from the joints alone: closed joints, correct tangents, one degree of freedom."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chain_mechanisms import hanging_chain
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.mechanics.kinematics import assembly
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.model.joints import GROUND, Distance, Point
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.numerics.least_squares import least_norm_solution
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.statics.equilibria import find_equilibria
from governor_mechanism.statics.speed_curve import equilibrium_speed_at
from governor_scenes import CROSSED, EXTENDED, PORTER, UNCROSSED_LINKS, WATT, governor_scene, random_governor
from rigid_link_governor import porter_with_rods
from scene_documents import between, custom_document, pin
from scene_parts import body_point, ground_point, make_mechanism, point_mass

ALL = [PORTER, WATT, CROSSED, EXTENDED, UNCROSSED_LINKS]


def mechanism_of(dimensions):
    return MACHINES["pendulum_governor"](**dimensions).mechanism()


@pytest.mark.parametrize("dimensions", ALL)
def test_every_pendulum_governor_has_mobility_one(dimensions):
    assert PositionSolver(mechanism_of(dimensions)).mobility == 1


def test_the_governor_with_rigid_links_has_mobility_one():
    scene, _ = porter_with_rods(speed=13.0, angle=0.7, rate=0.0)
    assert PositionSolver(scene.part.mechanism).mobility == 1


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_any_governor_assembles_with_closed_joints_and_a_correct_tangent(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    mechanism = mechanism_of(dimensions)
    solver = PositionSolver(mechanism)
    poses = solver.solve_at_coordinate(angle)
    # 1e-12 of the length scale: Newton's iteration stops at 1e-13.
    assert np.max(np.abs(solver.equations.residuals(poses))) < 1e-12 * mechanism.length_scale
    assert float(evaluate_output_value(mechanism, "arm_angle", poses)) == pytest.approx(angle, abs=1e-12)
    step = 1e-5
    derivative = (solver.solve_at_coordinate(angle + step) - solver.solve_at_coordinate(angle - step)) / (2 * step)
    # step^2/6 times a third derivative of a few length scales: 1e-9; the closure error over the step: 1e-8.
    np.testing.assert_allclose(solver.solve_velocities(poses, {"arm_angle": 1.0}), derivative, atol=2e-8)


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_gradient_of_every_reading_is_its_derivative(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    mechanism = mechanism_of(dimensions)
    solver = PositionSolver(mechanism)
    step = 1e-5
    ends = [solver.solve_at_coordinate(angle + side * step) for side in (1, -1)]
    tangent = solver.solve_velocities(solver.solve_at_coordinate(angle), {"arm_angle": 1.0})
    for reading in mechanism.readings:
        up, down = (float(evaluate_output_value(mechanism, reading.name, poses)) for poses in ends)
        expected_rate = evaluate_output(mechanism, reading.name, solver.solve_at_coordinate(angle)).rate(tangent)
        assert expected_rate == pytest.approx((up - down) / (2 * step), abs=2e-8)


@settings(max_examples=60)
@given(seed=st.integers(0, 2**32 - 1))
def test_assembled_mechanism_and_closed_form_have_one_equilibrium_speed(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    expected = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=angle))
    scene = governor_scene(dimensions, speed=1.0, angle=angle)
    # 1e-9: joints closed to 1e-13, magnified by the heights of strongly inclined links.
    assert equilibrium_speed_at(scene, np.array([angle]))[0] == pytest.approx(expected, rel=1e-9)


@settings(max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_mechanism_and_closed_form_have_the_same_equilibria(seed):
    dimensions, angle = random_governor(np.random.default_rng(seed))
    governor = closed.PendulumGovernor(**dimensions)
    speed = float(closed.equilibrium_speed(governor, arm_angle=angle))
    scene = governor_scene(dimensions, speed=speed, angle=angle)
    low, high = (getattr(scene.part.mechanism.limits[0], end) for end in ("low", "high"))
    expected = closed.equilibrium_angles(governor, spindle_speed=speed, lowest=low, highest=high)
    found = [equilibrium.coordinate for equilibrium in find_equilibria(scene, speed) if equilibrium.coordinate > low + 1e-3]
    np.testing.assert_allclose(found, [angle for angle in expected if angle > low + 1e-3], atol=1e-8)


def test_a_linkage_that_cannot_reach_names_the_joint_and_the_length():
    mechanism = mechanism_of({**UNCROSSED_LINKS, "link": 0.15})
    with pytest.raises(MechanismError, match=r"joint '(right|left) link' stays open by .* a length near") as refusal:
        PositionSolver(mechanism).solve_at_coordinate(1.4)
    needed = float(str(refusal.value).split("a length near ")[1].split()[0])
    assert needed > 0.15


def test_no_equilibrium_speed_without_both_effects():
    scene = governor_scene(PORTER, speed=13.0, angle=0.7)
    scene = scene.with_changes(effects=())
    with pytest.raises(MechanismError, match="needs both effects"):
        equilibrium_speed_at(scene, np.array([0.7]))


@pytest.mark.parametrize("angle", [0.0, 0.3, -0.3])
def test_from_a_turning_point_of_a_reading_the_first_coordinate_grows(angle):
    """A pendulum of 0.4 m hangs at its lowest point, or lies at the lowest point of a sloping line; a height is requested."""
    up = np.array([-math.sin(angle), math.cos(angle)])
    arm = Distance(name="arm", first=ground_point(), second=body_point("ball"), length=0.4)
    height = PointCoordinate(name="height", quantity="length", point=body_point("ball"), direction_x=up[0], direction_y=up[1])
    mechanism = make_mechanism([point_mass("ball", 1.0)], [arm], [height], [(*(-0.4 * up).tolist(), 0.0)], size=0.4)
    (x, y, _), across = PositionSolver(mechanism).solve({"height": -0.2})[0], 0.4 * math.sqrt(1 - 0.5**2)
    assert (x, y) == pytest.approx(-0.2 * up + across * np.array([up[1], -up[0]]), abs=1e-12)


@pytest.mark.parametrize("factor", [1e-6, 1e6])
def test_velocities_are_as_large_as_the_rates_that_they_have(factor):
    solver = PositionSolver(mechanism_of(PORTER))
    poses = solver.solve_at_coordinate(0.7)
    velocities = solver.solve_velocities(poses, {"arm_angle": 1.0})
    np.testing.assert_allclose(solver.solve_velocities(poses, {"arm_angle": factor}), factor * velocities, atol=1e-12 * factor)
    with pytest.raises(MechanismError, match="contradict"):
        solver.solve_velocities(poses, {"arm_angle": factor, "sleeve_lift": factor})


@pytest.mark.parametrize("slot", [{"type": "arc", "radius": 0.05}, {"type": "curve", "curve": {"radius": 0.05}}])
def test_points_that_are_to_be_apart_may_coincide_in_the_guess(slot):
    """Nothing says on which side of the centre the block stands, so that it takes one of both."""
    bodies = [{"name": "cam", "mass": 1.0, "inertia": 1e-3}, {"name": "block", "mass": 1.0, "turns": False}]
    guide = between("slider", "ground.A", "block.centre", angle="90 deg")
    joints = [pin("ground.A", "cam.origin"), guide, {**slot, "first": "cam.origin", "second": "block.centre"}]
    document = custom_document(size=0.1, body=bodies, joint=joints, readings={"y": {"y": "block.centre"}, "cam": {"angle": "cam"}})
    solver = PositionSolver(parse_scene_document(document).mechanism)
    assert solver.mobility == 1
    assert abs(solver.solve({})[1, 1]) == pytest.approx(0.05, abs=1e-15)


@pytest.mark.parametrize("offset", [0.0, 1e3, 1e6])
def test_joints_far_from_the_origin_close_in_as_few_iterations(offset, monkeypatch):
    """Rounding of far positions is no gap to be closed; Newton's iteration from 1e-4 needs three steps and one to round."""
    steps = []

    def solve(rows, rhs):
        steps.append(least_norm_solution(rows, rhs))
        return steps[-1]

    monkeypatch.setattr(assembly, "least_norm_solution", solve)
    mechanism = hanging_chain(3, duration=1.0, output_interval=1.0).mechanism
    first = replace(mechanism.joints[0], first=Point(body=GROUND, x=offset))
    guess = tuple((offset + x, y + 1e-5, angle + 1e-4) for x, y, angle in mechanism.initial_guess)
    solver = PositionSolver(replace(mechanism, joints=(first, *mechanism.joints[1:]), initial_guess=guess))
    poses = solver.solve({})
    assert np.max(np.abs(solver.equations.residuals(poses))) < 1e-15 * max(offset, 1.0)
    assert len(steps) <= 4

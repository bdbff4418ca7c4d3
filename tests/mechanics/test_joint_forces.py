"""Forces in joints: with them, every body obeys the laws of Newton and Euler."""

from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part
from governor_mechanism.effects.body_forces import Centrifugal, Gravity
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics
from governor_mechanism.mechanics.kinematics.constraint_equations import make_constraint_table
from governor_mechanism.mechanics.kinematics.constraint_rows import rotate_vector
from governor_mechanism.model.force_elements import Spring, Torque
from governor_mechanism.model.joints import GROUND, Pin, Point, Weld
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.part import Part, Spindle
from governor_mechanism.model.time_functions import InputFunction
from governor_scenes import PORTER, governor_scene
from scene_parts import body_angle, body_point, fixed_part, ground_point, make_mechanism

ROUNDING = 1e-12
"""Rounding of the solution of the joint forces, relative to the largest one."""


@pytest.mark.parametrize(("name", "speed"), [("porter_heavy_rods", 12.0), ("slider_crank_torque", None), ("four_bar_chain", None)])
def test_forces_and_moments_on_each_body_give_its_accelerations(name, speed):
    scene = gm.load(name)
    scene = scene.with_changes(start=replace(scene.start, rates={scene.mechanism.coordinate: 0.8}))
    mechanism, (poses, velocities) = scene.mechanism, initial_state(scene)
    if speed is not None:
        scene = scene.with_changes(spindle=replace(scene.spindle, times=(0.0,), speeds=(speed,)))
    result = compute_inverse_dynamics(scene, np.zeros(1), poses[np.newaxis], velocities[np.newaxis], np.zeros((1, 0)))
    total, rows = np.zeros((len(mechanism.bodies), 3)), make_constraint_table(mechanism).rows.table
    for (force_x, force_y, moment), row in zip(result.joint_forces[0], rows, strict=True):
        # The moment is about the point of the joint on the second body.
        point = np.array([row["x2"], row["y2"]])
        if row["second"] >= 0:
            point = poses[row["second"], :2] + np.array(rotate_vector(poses[row["second"], 2], *point))
        for sign, body in ((1, row["second"]), (-1, row["first"])):
            if body >= 0:
                arm_x, arm_y = point - poses[body, :2]
                total[body] += sign * np.array([force_x, force_y, moment + arm_x * force_y - arm_y * force_x])
    for body, pose, forces in zip(mechanism.bodies, poses, total, strict=True):
        forces[1] -= body.mass * scene.gravity
        if speed is not None:
            forces[0] += body.mass * pose[0] * speed**2
            moments = body.second_moments
            forces[2] -= 0.5 * speed**2 * ((moments.xx - moments.yy) * np.sin(2 * pose[2]) + 2 * moments.xy * np.cos(2 * pose[2]))
    for load in mechanism.force_elements:
        total[mechanism.body_index(load.second), 2] += load.moment.values[0]
    mass = np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies])
    is_free = np.array([body.moves for body in mechanism.bodies]).reshape(-1, 3)
    allowed = ROUNDING * np.max(np.abs(result.joint_forces))
    np.testing.assert_allclose(total[is_free], (mass * result.accelerations[0])[is_free], atol=allowed)
    assert np.max(np.abs(velocities)) > 0.5


def test_a_spring_between_coincident_points_has_no_direction_and_does_not_act():
    spring = Spring(name="band", first=Point(body="wheel"), second=Point(body=GROUND), stiffness=70.0, free_length=0.3)
    scene = coupled_scene(
        discs_part("disc", {"wheel": 0.5}, spring, Torque(name="load", second="wheel", moment=InputFunction(values=(2.0,))))
    )
    result = compute_inverse_dynamics(scene, np.zeros(1), np.zeros((1, 1, 3)), np.zeros((1, 1, 3)), np.zeros((1, 0)))
    assert result.accelerations.tolist() == [[[0.0, 0.0, 4.0]]]
    np.testing.assert_allclose(result.joint_forces, 0.0, atol=1e-15)


def test_drives_and_given_speeds_of_several_parts_do_not_mix():
    """A driven mechanism and a governor at a given speed accelerate as each does alone."""
    driven, governor = (
        gm.load("quick_return").part,
        governor_scene(PORTER, speed=Spindle(times=(0.0, 2.0), speeds=(12.0, 14.0)), angle=0.7).part,
    )
    both = coupled_scene(replace(driven, name="shaper"), governor)
    accelerations, power = [], []
    for scene in (both, coupled_scene(driven), coupled_scene(governor)):
        poses, velocities = initial_state(scene)
        result = compute_inverse_dynamics(scene, np.full(1, 0.01), poses[np.newaxis], velocities[np.newaxis], np.zeros((1, 0)))
        accelerations.append(result.accelerations[0])
        power.append(float(result.power[0]))
    np.testing.assert_allclose(accelerations[0], np.concatenate(accelerations[1:]), rtol=1e-12, atol=1e-12)
    assert power[0] == pytest.approx(power[1] + power[2], rel=1e-12)
    assert abs(power[1]) > 1.0
    assert np.max(np.abs(accelerations[1])) > 1.0


@pytest.mark.parametrize("is_turning", [True, False])
def test_bodies_without_mass_add_nothing_to_the_motion(is_turning):
    """A ball at the end of a rod without mass, with or without a joint at which it could turn; 0.7 m long."""
    length, angle = 0.7, 0.6
    end = Pin if not is_turning else Weld
    joints = [
        Pin(name="pivot", first=ground_point(), second=body_point("rod", -0.5 * length)),
        end(name="end", first=body_point("rod", 0.5 * length), second=body_point("ball")),
    ]
    bodies = [Body(name="rod", mass=0.0), Body(name="ball", mass=1.3, can_rotate=is_turning)]
    mechanism = make_mechanism(bodies, joints, [body_angle("rod", "angle")], [(0.0, 0.0, 0.0)] * 2, size=length)
    part = fixed_part(mechanism, Gravity())
    direction = np.array([np.cos(angle), np.sin(angle)])
    poses = np.array([[[*(0.5 * length * direction), angle], [*(length * direction), angle * is_turning]]])
    result = compute_inverse_dynamics(coupled_scene(part), np.zeros(1), poses, np.zeros((1, 2, 3)), np.zeros((1, 0)))
    acceleration = -9.81 * np.cos(angle) / length
    assert result.accelerations[0, 0, 2] == pytest.approx(acceleration, rel=1e-12)
    across = np.array([-direction[1], direction[0]])
    np.testing.assert_allclose(result.accelerations[0, 1, :2], length * acceleration * across, rtol=1e-12)
    force = 1.3 * (length * acceleration * across + [0.0, 9.81])  # along the rod
    np.testing.assert_allclose(result.joint_forces[0, 2:4, :2].sum(axis=0), force, rtol=1e-12, atol=1e-12)


def test_a_point_mass_on_a_pin_swings_as_a_conical_pendulum():
    """Its inertia is that about the pin, where its weight and its centrifugal force have a moment."""
    length, speed, angle = 0.4, 6.0, 0.7
    pivot = Pin(name="pivot", first=ground_point(), second=body_point("bob", y=length))
    sketch = [(length * np.sin(angle), -length * np.cos(angle), angle)]
    mechanism = make_mechanism([Body(name="bob", mass=1.3)], [pivot], [body_angle("bob", "angle")], sketch, size=length)
    loads = {"effects": (Gravity(), Centrifugal()), "spindle": Spindle(speeds=(speed,))}
    part = Part(name="pendulum", machine="custom", dimensions={}, mechanism=mechanism, **loads)
    poses = np.array([mechanism.initial_guess])
    result = compute_inverse_dynamics(coupled_scene(part), np.zeros(1), poses, np.zeros((1, 1, 3)), np.zeros((1, 0)))
    expected = -9.81 / length * np.sin(angle) + speed**2 * np.sin(angle) * np.cos(angle)
    assert result.accelerations[0, 0, 2] == pytest.approx(expected, rel=1e-12)

"""States projected onto joints and drives: what they satisfy, and that no nearer state does."""

from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from coupled_scenes import coupled_scene, discs_part
from governor_mechanism.engines.initial_state import initial_state
from governor_mechanism.mechanics.dynamics.arrays import make_system_workspace
from governor_mechanism.mechanics.dynamics.constrained_solution import StateProjector, project_state
from governor_mechanism.mechanics.dynamics.lowering import make_system
from governor_mechanism.mechanics.kinematics.constraint_equations import ConstraintEquations
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction, stack_local_cubics
from governor_mechanism.model.joints import GROUND, Point, RotationalDriver
from governor_mechanism.model.time_functions import Harmonic, PrescribedMotion

NAMES = ["porter_heavy_rods", "slider_crank_torque", "quick_return"]


def disturbed_states(name: str, size: float):
    """Return a scene, and its start at two times, disturbed."""
    scene, random = gm.load(name), np.random.default_rng(5)
    poses, velocities = (np.repeat(values[np.newaxis], 2, axis=0) for values in initial_state(scene))
    moves = np.array([body.moves for body in scene.mechanism.bodies]).reshape(-1, 3)
    return scene, poses + size * random.normal(size=poses.shape) * moves, velocities + random.normal(size=poses.shape) * moves


@pytest.mark.parametrize("name", NAMES)
def test_projected_states_satisfy_joints_and_drives(name):
    scene, poses, velocities = disturbed_states(name, 1e-3)
    times, equations = np.array([0.0, 1e-4]), ConstraintEquations(scene.mechanism)
    projected = StateProjector(scene).project(times, poses, velocities)
    assert np.max(np.abs(equations.residuals(projected[0], times))) < 1e-14  # rounding of lengths below 1 m
    rates = np.sum(equations.jacobian(projected[0]) * projected[1][:, np.newaxis], axis=(-2, -1))
    np.testing.assert_allclose(rates, equations.prescribed_motion(times)[..., 1], atol=1e-13)
    assert np.max(np.abs(equations.residuals(poses, times))) > 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_without_closing_the_joints_only_velocities_change_by_impulses_of_the_joints(name):
    scene, poses, velocities = disturbed_states(name, 0.0)
    kept, projected = StateProjector(scene).project(np.zeros(2), poses, velocities, closes_joints=False)
    np.testing.assert_array_equal(kept, poses)
    mass = np.array([[body.mass, body.mass, body.planar_inertia] for body in scene.mechanism.bodies])
    impulses = (mass * (projected - velocities)).reshape(2, -1)
    jacobian = ConstraintEquations(scene.mechanism).jacobian(poses).reshape(2, -1, impulses.shape[1])
    moving = mass.ravel() > 0.0  # a body without inertia takes any velocity
    for impulse, rows in zip(impulses[:, moving], jacobian[..., moving], strict=True):
        multipliers = np.linalg.lstsq(rows.T, impulse, rcond=None)[0]
        np.testing.assert_allclose(rows.T @ multipliers, impulse, atol=1e-12 * np.max(np.abs(impulse)))


def test_drives_go_on_in_local_time():
    """The cubics and harmonics of a drive at a time, a little later, are those at the later time."""
    motion = PrescribedMotion.constant_rate(0.2, 1.5, (Harmonic(amplitude=0.3, frequency=2.0, phase=0.5),))
    table = PrescribedMotion(times=(0.0, 0.4, 1.1, 1.6), values=(0.2, 0.9, -0.3, 0.4))
    drives = tuple(
        RotationalDriver(name=f"drive {k}", first=Point(body=GROUND), second=Point(body=f"disc {k}"), motion=one)
        for k, one in enumerate((motion, table))
    )
    part = discs_part("discs", {"disc 0": 0.5, "disc 1": 0.7})
    part = replace(part, mechanism=replace(part.mechanism, joints=(*part.mechanism.joints, *drives)))
    system, functions = make_system(coupled_scene(part))
    found = []
    for time, local_time in ((0.5, 0.3), (0.8, 0.0)):
        poses, velocities = np.zeros((2, 3)), np.zeros((2, 3))
        cubics = stack_local_cubics(functions, np.array([time]))[0]
        project_state(system, make_system_workspace(system), cubics, local_time, poses, velocities, 0.0)
        found.append([poses[:, 2], velocities[:, 2]])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-12)
    exact, end = [CubicTimeFunction(one) for one in (motion, table)], np.array([0.8])
    expected = [[float(one(end)[0]) for one in exact], [float(one.derivative(end)[0]) for one in exact]]
    np.testing.assert_allclose(found[1], expected, rtol=1e-12)

"""Drivers that are released for a kinematic study, and drivers that stand still at their value at 0 s."""

import math
from dataclasses import replace

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.joints import Gear, Joint, RotationalDriver, Slider, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

MOVED_RATE_RATIO = 1e-9
"""Rate of a reading, relative to the largest that a driver gives it, below which a driver does not move it."""


def hold_driver(joint: Joint) -> Joint:
    """Return a joint as it is; instead of a driver, a joint that keeps its value at 0 s."""
    if not isinstance(joint, RotationalDriver | TranslationalDriver):
        return joint
    value = float(CubicTimeFunction(joint.motion)(np.zeros(1))[0])
    if isinstance(joint, RotationalDriver):
        return Gear(name=joint.name, first=joint.first, second=joint.second, ratio=1.0, offset=value)
    along_x, along_y = value * math.cos(joint.angle), value * math.sin(joint.angle)
    start = replace(joint.first, x=joint.first.x + along_x, y=joint.first.y + along_y)
    return Slider(name=joint.name, first=start, second=joint.second, angle=joint.angle + math.pi / 2)


def release_drivers(
    mechanism: Mechanism,
    reading: str,
    start_values: dict[str, float],  # values of readings at the start, SI
) -> Mechanism:
    """Return a mechanism whose drivers do not move a reading: those that did are left out, the others stand still."""
    drivers = [joint for joint in mechanism.joints if isinstance(joint, RotationalDriver | TranslationalDriver)]
    if len(drivers) < 2:
        return replace(mechanism, joints=tuple(joint for joint in mechanism.joints if joint not in drivers))
    solver = PositionSolver(mechanism)
    poses = solver.solve(start_values)
    rates = np.abs(_rates_of_reading(solver, poses, reading))
    moving = [driver for driver, rate in zip(drivers, rates, strict=True) if rate > MOVED_RATE_RATIO * np.max(rates)]
    held = tuple(hold_driver(joint) for joint in mechanism.joints if joint not in moving)
    return replace(mechanism, joints=held, initial_guess=tuple((x, y, angle) for x, y, angle in poses.tolist()))


def _rates_of_reading(solver: PositionSolver, poses: FloatArray, reading: str) -> FloatArray:
    """Return the rate of a reading at unit rate of each driver, at poses (bodies, 3)."""
    mechanism = solver.mechanism
    gradient = evaluate_output(mechanism, reading, poses).gradient
    rates = np.zeros(len(mechanism.joints))
    for row in np.flatnonzero(solver.equations.is_driven):
        unit_rate = np.eye(len(solver.equations.joint_indices))[row]
        velocities = solver.expand_free(np.linalg.lstsq(solver.jacobian(poses, []), unit_rate, rcond=None)[0])
        rates[solver.equations.joint_indices[row]] = float(np.sum(gradient * velocities))
    is_driver = [isinstance(joint, RotationalDriver | TranslationalDriver) for joint in mechanism.joints]
    return rates[is_driver]

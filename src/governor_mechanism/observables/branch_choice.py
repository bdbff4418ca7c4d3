"""Passes near a change point that no engine resolves: there rounding, not mechanics, decides how the motion goes on.

Where a closed chain of links lies in line, two branches of its motion cross. If its lengths miss that configuration by a defect d,
the branches avoid each other at a distance of order sqrt(d), and the motion bends from one line to the other. A run that goes
straight through, because d is below what keeps its joints closed, is on the wrong branch afterwards; other tolerances show the same.
"""

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.observables.sampled_motion import SampledMotion
from governor_mechanism.observables.singular_configurations import find_nearly_singular_samples, locate_nearly_singular_poses
from governor_mechanism.types import FloatArray

EXACT_DEFECT = 1e-13
"""Defect, in length scales, up to which lengths meet a change point exactly: rounding of dimensions and of their sums."""

N_CLOSING_STEPS = 4
"""Newton steps that close the joints after a displacement of `STENCIL_STEP`; they converge quadratically."""

STENCIL_STEP = 1e-3
"""Step of the differences of the defect, in length scales and rad: its third derivatives then matter by 1e-3 only."""

MAX_ITERATIONS = 6
"""Largest number of Newton steps to the saddle of the defect; they converge quadratically."""

MAX_STEP = 0.1
"""Largest of these steps, in length scales and rad."""

MAX_SINGULAR_VALUE_RATIO = 0.02
"""Largest ratio of singular values at which branches cross nearby: a run that goes through between two branches comes closer."""

SADDLE_TOLERANCE = 1e-7
"""Last Newton step, in length scales and rad: the defect, stationary there, is then exact to rounding."""

SAME_CONFIGURATION = 0.2
"""Largest difference of poses, in length scales and rad, of passes through one configuration: samples of fast motions are as far apart."""


def may_branch(mechanism: Mechanism) -> bool:
    """Return whether the passes of a mechanism can be examined: a closed chain of links with one degree of freedom, without drives."""
    position_solver = PositionSolver(mechanism)
    n_rows, n_coordinates = position_solver.scaled_joint_jacobian(position_solver.initial_guess).shape
    is_driven = bool(position_solver.equations.is_driven.any())
    return not is_driven and n_rows + 1 == n_coordinates and len(mechanism.joints) > len(mechanism.bodies)


def find_unresolved_branch(
    mechanism: Mechanism,  # the mechanism, with one degree of freedom and no redundant joints
    motion: SampledMotion,
) -> tuple[float, float] | None:
    """Find the first time at which a motion goes straight through where the branches avoid each other.

    Result: time of the pass, s, and of the last sample that is clearly before it; None if there is no such
    pass.
    """
    position_solver, exact_poses = PositionSolver(mechanism), list[FloatArray]()
    for k in find_nearly_singular_samples(motion).tolist():
        before, after = (_orientation(position_solver, motion.poses[i], motion.velocities[i]) for i in (k - 1, k + 1))
        goes_on = np.sum(motion.velocities[k - 1] * motion.velocities[k + 1]) > 0
        if before * after >= 0 or not goes_on or any(_are_close(position_solver, motion.poses[k], poses) for poses in exact_poses):
            continue
        (time,), (poses,), (singular_value,) = locate_nearly_singular_poses(mechanism, motion, np.array([k]))
        if singular_value < MAX_SINGULAR_VALUE_RATIO and abs(_defect_at_saddle(position_solver, poses, time)) > EXACT_DEFECT:
            return float(time), float(motion.times[k - 1])
        exact_poses.append(poses)
    return None


def _are_close(position_solver: PositionSolver, poses: FloatArray, others: FloatArray) -> bool:
    """Return whether two poses (bodies, 3) are nearly the same, whole turns aside."""
    differences = (poses - others) / position_solver.pose_scales
    differences[:, 2] = np.remainder(differences[:, 2] + np.pi, 2 * np.pi) - np.pi
    return bool(np.max(np.abs(differences)) < SAME_CONFIGURATION)


def _orientation(position_solver: PositionSolver, poses: FloatArray, velocities: FloatArray) -> float:
    """Return the sign of the determinant of constraint Jacobian and velocity.

    It stays the same along a branch, as neither vanishes there, and changes where a motion goes through a crossing of branches.
    """
    velocity = velocities.ravel()[position_solver.free_mask] / position_solver.free_coordinate_scales
    return float(np.linalg.slogdet(np.vstack([position_solver.scaled_joint_jacobian(poses), velocity]))[0])


def _defect_at_saddle(position_solver: PositionSolver, poses: FloatArray, time: float) -> float:
    """Return the defect, in length scales, at the singular configuration next to given poses.

    The defect is what the constraints leave open in the direction in which they depend on each other, while all others are closed.
    """
    for _ in range(MAX_ITERATIONS):
        defect, step_length, poses = _step_to_saddle(position_solver, poses, time)
        if step_length < SADDLE_TOLERANCE:
            return defect
    return 0.0  # no singular configuration is near


def _step_to_saddle(position_solver: PositionSolver, poses: FloatArray, time: float) -> tuple[float, float, FloatArray]:
    """Return the defect at the saddle of its quadratic model, the length of the step to it, and the poses after the step."""
    left, _, right = np.linalg.svd(position_solver.scaled_joint_jacobian(poses))
    weak_row, plane, h = left[:, -1], right[-2:], STENCIL_STEP

    def defect_at(first: float, second: float) -> float:
        moved = _moved(position_solver, poses, first * plane[0] + second * plane[1])
        closed = _closed(position_solver, moved, time, weak_row)
        return float(weak_row @ position_solver.equations.residuals(closed, time)) / position_solver.mechanism.length_scale

    middle, right_value, left_value, up, down = defect_at(0, 0), defect_at(h, 0), defect_at(-h, 0), defect_at(0, h), defect_at(0, -h)
    mixed = (defect_at(h, h) - defect_at(h, -h) - defect_at(-h, h) + defect_at(-h, -h)) / (4 * h**2)
    gradient = np.array([right_value - left_value, up - down]) / (2 * h)
    hessian = np.array([[(right_value - 2 * middle + left_value) / h**2, mixed], [mixed, (up - 2 * middle + down) / h**2]])
    step = -np.linalg.lstsq(hessian, gradient, rcond=1e-3)[0]
    length = float(np.max(np.abs(step)))
    shortened = step * min(1.0, MAX_STEP / length) if length else step
    stepped = _closed(position_solver, _moved(position_solver, poses, shortened @ plane), time, weak_row)
    return middle + 0.5 * float(gradient @ step), length, stepped


def _moved(position_solver: PositionSolver, poses: FloatArray, displacement: FloatArray) -> FloatArray:
    """Return poses displaced by free coordinates, in length scales and rad."""
    moved = poses.ravel().copy()
    moved[position_solver.free_mask] += displacement * position_solver.free_coordinate_scales
    return moved.reshape(poses.shape)


def _closed(position_solver: PositionSolver, poses: FloatArray, time: float, weak_row: FloatArray) -> FloatArray:
    """Return poses at which all constraints except the weak combination are closed."""
    for _ in range(N_CLOSING_STEPS):
        residuals = position_solver.equations.residuals(poses, time) / position_solver.mechanism.length_scale
        residuals -= weak_row * (weak_row @ residuals)
        jacobian = position_solver.scaled_joint_jacobian(poses)
        jacobian -= np.outer(weak_row, weak_row @ jacobian)
        poses = _moved(position_solver, poses, -np.linalg.pinv(jacobian, rcond=1e-8) @ residuals)
    return poses

"""Joint reactions of a run, and which of them are statically determinate."""

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.inverse_dynamics import InverseDynamics
from governor_mechanism.mechanics.dynamics.lowering import ground_pin_of_point_mass
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_equations import make_constraint_table
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
from governor_mechanism.types import FloatArray

NEAR_DEPENDENT_PIVOT_RATIO = 1e-9
"""Pivot ratio (a squared angle) below which the constraint rows are examined for indeterminate forces."""

MIN_PARTICIPATION_RATIO = 1e-6
"""A row takes part in a linear dependence if its component in the left null vector exceeds this."""


def compute_reactions(mechanism: Mechanism, poses: FloatArray, motion_dynamics: InverseDynamics) -> dict[str, Reaction]:
    """Return the reaction of every joint, by name, from poses (n, bodies, 3) and the inverse dynamics of their motion."""
    owner = make_constraint_table(mechanism).joint_indices
    undetermined = _find_undetermined(mechanism, poses, motion_dynamics.pivot_ratios)
    result = {}
    for index, joint in enumerate(mechanism.joints):
        own_rows = owner == index
        forces = motion_dynamics.joint_forces[:, own_rows].sum(axis=1)
        forces[:, :2] += _point_mass_pin_force(mechanism, joint, motion_dynamics)
        result[joint.name] = Reaction(force=forces[:, :2], moment=forces[:, 2], determined=~undetermined[:, index] & bool(own_rows.any()))
    return result


def _point_mass_pin_force(mechanism: Mechanism, joint: Joint, motion_dynamics: InverseDynamics) -> FloatArray:
    """Return the pin force (n, 2), N, on the second body that accelerates a body treated as a point mass about a ground pin.

    The equations of motion about the pin do not contain it.
    """
    total = np.zeros((len(motion_dynamics.accelerations), 2))
    for point, sign in ((joint.second, 1.0), (joint.first, -1.0)):
        index = mechanism.body_index(point.body)
        if index >= 0 and ground_pin_of_point_mass(mechanism, mechanism.bodies[index]) is joint:
            total += sign * mechanism.bodies[index].mass * motion_dynamics.accelerations[:, index, :2]
    return total


def _find_undetermined(mechanism: Mechanism, poses: FloatArray, pivot_ratios: FloatArray) -> NDArray[np.bool_]:
    """Return for each pose and joint (n, joints) whether its forces are statically indeterminate."""
    undetermined = np.zeros((len(poses), len(mechanism.joints)), dtype=np.bool_)
    position_solver = PositionSolver(mechanism)
    for i in np.flatnonzero(pivot_ratios < NEAR_DEPENDENT_PIVOT_RATIO):
        left_singular_vectors, singular_values, _ = np.linalg.svd(position_solver.scaled_joint_jacobian(poses[i]), full_matrices=True)
        rank = int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0])) if singular_values.size else 0
        participating = np.any(np.abs(left_singular_vectors[:, rank:]) > MIN_PARTICIPATION_RATIO, axis=1)
        undetermined[i, np.unique(position_solver.equations.joint_indices[participating])] = True
    return undetermined

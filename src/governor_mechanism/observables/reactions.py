"""Joint forces of a run, and which of them rigid bodies settle."""

from __future__ import annotations

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
"""Rows less independent than this (squared, in the kernel's terms) are looked at for undetermined forces."""

MIN_PARTICIPATION_RATIO = 1e-6
"""A row takes part in a dependence where its part in it is larger than this."""


def compute_reactions(mechanism: Mechanism, poses: FloatArray, motion_dynamics: InverseDynamics) -> dict[str, Reaction]:
    """The reaction of every joint by name, from poses (n, bodies, 3) and what their motion implies."""
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
    """What a lever's pin gives its mass beside what the equations about the pin tell: (n, 2) N on the second body."""
    total = np.zeros((len(motion_dynamics.accelerations), 2))
    for point, sign in ((joint.second, 1.0), (joint.first, -1.0)):
        index = mechanism.body_index(point.body)
        if index >= 0 and ground_pin_of_point_mass(mechanism, mechanism.bodies[index]) is joint:
            total += sign * mechanism.bodies[index].mass * motion_dynamics.accelerations[:, index, :2]
    return total


def _find_undetermined(mechanism: Mechanism, poses: FloatArray, pivot_ratios: FloatArray) -> NDArray[np.bool_]:
    """(n, joints) whether forces within a joint could be exchanged for others without any body noticing."""
    undetermined = np.zeros((len(poses), len(mechanism.joints)), dtype=np.bool_)
    position_solver = PositionSolver(mechanism)
    for i in np.flatnonzero(pivot_ratios < NEAR_DEPENDENT_PIVOT_RATIO):
        left_singular_vectors, singular_values, _ = np.linalg.svd(position_solver.scaled_joint_jacobian(poses[i]), full_matrices=True)
        rank = int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0])) if singular_values.size else 0
        participating = np.any(np.abs(left_singular_vectors[:, rank:]) > MIN_PARTICIPATION_RATIO, axis=1)
        undetermined[i, np.unique(position_solver.equations.joint_indices[participating])] = True
    return undetermined

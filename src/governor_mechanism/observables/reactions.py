"""Joint forces of a run, and which of them rigid bodies settle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.inverse_dynamics import Dynamics
from governor_mechanism.mechanics.dynamics.lowering import lever_pin
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.constraint_equations import joint_table
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.numerics.least_squares import INDEPENDENT
from governor_mechanism.types import FloatArray

DEPENDENT = 1e-9
"""Rows less independent than this (squared, in the kernel's terms) are looked at for undetermined forces."""

SHARE = 1e-6
"""A row takes part in a dependence where its part in it is larger than this."""


def reactions(mechanism: Mechanism, poses: FloatArray, found: Dynamics) -> dict[str, Reaction]:
    """The reaction of every joint by name, from poses (n, bodies, 3) and what their motion implies."""
    owner = joint_table(mechanism).owner
    loose = _undetermined(mechanism, poses, found.independence)
    result = {}
    for index, joint in enumerate(mechanism.joints):
        mine = owner == index
        forces = found.forces[:, mine].sum(axis=1)
        forces[:, :2] += _carried_by_pin(mechanism, joint, found)
        result[joint.name] = Reaction(
            force=forces[:, :2], moment=forces[:, 2], determined=~loose[:, index] & bool(mine.any())
        )
    return result


def _carried_by_pin(mechanism: Mechanism, joint: Joint, found: Dynamics) -> FloatArray:
    """What a lever's pin gives its mass beside what the equations about the pin tell: (n, 2) N on the second body."""
    total = np.zeros((len(found.accelerations), 2))
    for point, sign in ((joint.second, 1.0), (joint.first, -1.0)):
        index = mechanism.body_index(point.body)
        if index >= 0 and lever_pin(mechanism, mechanism.bodies[index]) is joint:
            total += sign * mechanism.bodies[index].mass * found.accelerations[:, index, :2]
    return total


def _undetermined(mechanism: Mechanism, poses: FloatArray, independence: FloatArray) -> NDArray[np.bool_]:
    """(n, joints) whether forces within a joint could be exchanged for others without any body noticing."""
    loose = np.zeros((len(poses), len(mechanism.joints)), dtype=np.bool_)
    assembler = Assembler(mechanism)
    for at in np.flatnonzero(independence < DEPENDENT):
        left, values, _ = np.linalg.svd(assembler.joint_rows(poses[at]), full_matrices=True)
        kept = int(np.sum(values > INDEPENDENT * values[0])) if values.size else 0
        taking_part = np.any(np.abs(left[:, kept:]) > SHARE, axis=1)
        loose[at, np.unique(assembler.equations.owner[taking_part])] = True
    return loose

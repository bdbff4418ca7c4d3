"""Velocities changed by impulses of the joints and of what strikes or holds."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MANY, lightest_change
from governor_mechanism.types import FloatArray

DEPENDENT = 1e-13
"""Singular values below this fraction of the largest one belong to equations that others contain."""

CLOSINGS = 3
"""Newton's steps in which joints are closed: from what one step of the motion opens, to rounding."""


class Thrower:
    """Throws the bodies of one mechanism so that its joints move with them and some readings have given rates."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._assembler = Assembler(mechanism)
        masses = np.array([[b.mass, b.mass, b.moments.xx + b.moments.yy] for b in mechanism.bodies])
        self._masses: FloatArray = masses.ravel()[self._assembler.free]
        self._equations = len(self._assembler.equations.owner)
        self.mobility = self._assembler.mobility
        self._independent = int(self._assembler.free.sum()) - self.mobility == self._equations

    def thrown(
        self, time: float, poses: FloatArray, velocities: FloatArray, gradients: FloatArray, rates: FloatArray
    ) -> FloatArray:
        """Velocities (bodies, 3) from others at poses (bodies, 3), readings with gradients (readings, bodies, 3) having
        the rates (readings,): the nearest in kinetic energy, so impulses along joints and readings bring them about.
        """
        equations, free = self._assembler.equations, self._assembler.free
        joints = self._joints(poses[np.newaxis])[0]
        rows = np.concatenate([joints, gradients.reshape(-1, free.size)[:, free]])
        asked = np.zeros(len(joints))
        if equations.driven.any():
            asked = equations.asked(np.array([time]))[0, :, 1]
        given = velocities.ravel()[free]
        wanted = np.concatenate([asked, rates]) - rows @ given
        thrown = np.zeros(free.size)
        thrown[free] = given + self._nearest(rows[np.newaxis], wanted[np.newaxis])[0]
        return thrown.reshape(velocities.shape)

    def closed(self, times: FloatArray, poses: FloatArray) -> FloatArray:
        """Poses (n, bodies, 3) with closed joints at times (n,) s, nearest to others in their masses."""
        equations, free = self._assembler.equations, self._assembler.free
        closed = poses.copy()
        for _ in range(CLOSINGS):
            change = np.zeros((len(poses), free.size))
            change[:, free] = self._nearest(self._joints(closed), -equations.openings(closed, times))
            closed += change.reshape(poses.shape)
        return closed

    def _joints(self, poses: FloatArray) -> FloatArray:
        """Gradients (n, equations, free coordinates) of the joints at poses (n, bodies, 3)."""
        free = self._assembler.free
        rows: FloatArray = self._assembler.equations.gradients(poses).reshape(len(poses), -1, free.size)[..., free]
        return rows

    def _nearest(self, rows: FloatArray, wanted: FloatArray) -> FloatArray:
        """The least change (n, free coordinates), weighed by mass, that changes rows . change by what is wanted."""
        count, many = rows.shape[1], len(self._masses)
        if count >= MANY:
            pairs = zip(rows, wanted, strict=True)
            found = [lightest_change(one, self._masses, right) for one, right in pairs]
            if all(one is not None for one in found):
                return np.array(found).reshape(len(rows), many)
        system = np.zeros((len(rows), many + count, many + count))
        system[:, :many, :many] = np.diag(self._masses)
        system[:, :many, many:], system[:, many:, :many] = np.swapaxes(rows, 1, 2), rows
        right = np.zeros((len(rows), many + count, 1))
        right[:, many:, 0] = wanted
        if self._independent and count == self._equations:
            solution = np.linalg.solve(system, right)
        else:
            solution = np.linalg.pinv(system, rcond=DEPENDENT, hermitian=True) @ right
        change: FloatArray = solution[:, :many, 0]
        return change

    def energy(self, velocities: FloatArray) -> float:
        """Kinetic energy in the plane (J) at velocities (bodies, 3)."""
        moving = velocities.ravel()[self._assembler.free]
        return 0.5 * float(np.sum(self._masses * moving**2))

"""Velocities that open no joint: the part of given velocities that the mechanism can have."""

from __future__ import annotations

import numpy as np

from governor_mechanism.equations.assembly import Assembler
from governor_mechanism.equations.points import Array
from governor_mechanism.mechanism import Mechanism


class Projector:
    """Projects velocities of one mechanism along its momentum, so that the joints move with them.

    Of all velocities with closed joints these are nearest in kinetic energy: impulses of the joints alone would bring
    them about.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._assembler = Assembler(mechanism)
        self._freedoms = self._assembler.mobility
        bodies = mechanism.bodies
        masses = np.array([[b.mass, b.mass, b.moments.xx + b.moments.yy] for b in bodies])
        self._masses: Array = masses.ravel()[self._assembler.free]

    def velocities(self, poses: Array, velocities: Array, times: Array) -> Array:
        """(n, bodies, 3) from poses and velocities (n, bodies, 3) at times (n,) s."""
        equations, free, count = self._assembler.equations, self._assembler.free, len(poses)
        joints = equations.gradients(poses).reshape(count, -1, free.size)[..., free]
        given = velocities.reshape(count, -1)[:, free]
        driven = np.zeros_like(given)
        if equations.driven.any():
            asked = equations.asked(times)[..., 1]
            driven = (np.linalg.pinv(joints) @ asked[..., np.newaxis])[..., 0]
        # The directions that open no joint are the last right singular vectors.
        motions = np.linalg.svd(joints, full_matrices=True)[2][:, joints.shape[2] - self._freedoms :, :]
        weighted = motions * self._masses
        momentum = weighted @ (given - driven)[..., np.newaxis]
        amounts = np.linalg.solve(weighted @ np.swapaxes(motions, 1, 2), momentum)
        projected = np.zeros((count, free.size))
        projected[:, free] = driven + np.sum(motions * amounts, axis=1)
        return projected.reshape(velocities.shape)

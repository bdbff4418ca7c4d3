"""Velocities that open no joint: the part of given velocities that the mechanism can have."""

from __future__ import annotations

import numpy as np

from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.least_squares import MANY, lightest_change
from governor_mechanism.types import FloatArray


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
        self._masses: FloatArray = masses.ravel()[self._assembler.free]

    def velocities(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """(n, bodies, 3) from poses and velocities (n, bodies, 3) at times (n,) s."""
        if len(self._assembler.equations.owner) < MANY:
            return self._by_directions(poses, velocities, times)
        every = [slice(k, k + 1) for k in range(len(poses))]
        found = [self._by_impulses(poses[k], velocities[k], times[k]) for k in every]
        return np.concatenate([np.zeros((0, *velocities.shape[1:])), *found])

    def _by_impulses(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """Of one instant, by the impulses of many joints; where they depend on each other, by the directions left."""
        equations, free = self._assembler.equations, self._assembler.free
        joints = equations.gradients(poses).reshape(-1, free.size)[:, free]
        wanted = equations.asked(times)[0, :, 1] - joints @ velocities.reshape(-1)[free]
        change = lightest_change(joints, self._masses, wanted)
        if change is None:
            return self._by_directions(poses, velocities, times)
        return velocities + self._assembler.spread(change)

    def _by_directions(self, poses: FloatArray, velocities: FloatArray, times: FloatArray) -> FloatArray:
        """By the directions that joints leave."""
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

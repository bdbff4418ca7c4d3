"""Many poses of a mechanism of mobility one closed at once, each at its value of the leading coordinate."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import Measure, measure
from governor_mechanism.model.mechanism import LineAngle, Mechanism
from governor_mechanism.types import FloatArray

STEPS = 12
"""So many Newton steps are made."""

BRANCH = 0.05
"""Machine sizes, and rad: poses that close farther from where they were expected may be on another branch."""

LOST = 1.0
"""Machine sizes, and rad: after a Newton step of this size nothing is near by."""

SMALL = 1e-8
"""Machine sizes, and rad: after a Newton step of this size rounding alone is left."""


class Closing:
    """Closes the joints of one mechanism at many values of its coordinate, and says how the bodies move along it."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.assembler = Assembler(mechanism)
        self.unit = 1.0 if mechanism.reading(mechanism.coordinate).quantity == "angle" else mechanism.size
        """What a radian, or a machine size, of the coordinate is in SI."""
        self.sizes = np.array([mechanism.size, mechanism.size, 1.0])
        """The same of a pose's coordinates."""
        self._turns = isinstance(mechanism.reading(mechanism.coordinate), LineAngle)

    def at(self, expected: FloatArray, values: FloatArray) -> FloatArray:
        """Poses (n, bodies, 3) at values (n,), on the branches of expected ones.

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        poses, sure = self.near(expected, values)
        for k in np.flatnonzero(~sure):
            poses[k] = self.assembler.poses(float(values[k]), expected[k])
        return poses

    def near(self, expected: FloatArray, values: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
        """Poses (n, bodies, 3) at values (n,), and which of them closed near enough to the expected ones."""
        poses, left, closed = expected.copy(), np.arange(len(values)), np.zeros(len(values), dtype=np.bool_)
        for _ in range(STEPS):
            try:
                step = self._step(poses[left], values[left])
            except MechanismError:
                break
            poses[left] -= step
            size = np.max(np.abs(step) / self.sizes, axis=(-2, -1))
            closed[left] = size < SMALL
            left = left[(size >= SMALL) & (size < LOST)]
            if not left.size:
                break
        stray = np.max(np.abs(poses - expected) / self.sizes, axis=(-2, -1))
        return poses, closed & (stray < BRANCH)

    def path(self, poses: FloatArray) -> tuple[FloatArray, FloatArray]:
        """First and second derivative of poses (n, bodies, 3) by the coordinate.

        Raises MechanismError at a dead centre of the coordinate.
        """
        found = measure(self.mechanism, self.mechanism.coordinate, poses)
        rows = self._rows(poses, found)
        ahead = np.zeros(rows.shape[:-1])
        ahead[:, -1] = 1.0
        tangents = self._solve(rows, ahead)
        bends = self.assembler.equations.bends(poses, tangents)
        turned = -measure(self.mechanism, self.mechanism.coordinate, poses, tangents).bend
        return tangents, self._solve(rows, np.concatenate([bends, turned[:, np.newaxis]], axis=1))

    def _step(self, poses: FloatArray, values: FloatArray) -> FloatArray:
        found = measure(self.mechanism, self.mechanism.coordinate, poses)
        off = found.value - values
        off = np.remainder(off + np.pi, 2 * np.pi) - np.pi if self._turns else off
        return self._solve(self._rows(poses, found), np.column_stack([self.assembler.equations.openings(poses), off]))

    def _rows(self, poses: FloatArray, lead: Measure) -> FloatArray:
        joints = self.assembler.equations.gradients(poses).reshape(len(poses), -1, self.assembler.free.size)
        rows = np.concatenate([joints, lead.gradient.reshape(len(poses), 1, -1)], axis=1)
        return rows[..., self.assembler.free]

    def _solve(self, rows: FloatArray, right: FloatArray) -> FloatArray:
        """Changes of all poses (n, bodies, 3) that the joints and the coordinate ask for."""
        free, square = self.assembler.free, rows.shape[1] == rows.shape[2]
        column = right[..., np.newaxis]
        try:
            found = np.linalg.solve(rows, column) if square else np.linalg.pinv(rows) @ column
        except np.linalg.LinAlgError as error:
            raise MechanismError(
                f"{self.mechanism.coordinate!r} stands at a dead centre there and does not settle the others"
            ) from error
        every = np.zeros((len(rows), free.size))
        every[:, free] = found[..., 0]
        return every.reshape(len(rows), -1, 3)

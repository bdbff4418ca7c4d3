"""Put a mechanism together: poses at a value of its leading coordinate, and the direction in which it can move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.equations.constraints import JointEquations
from governor_mechanism.equations.points import Array
from governor_mechanism.equations.readings import reading_gradient, reading_value
from governor_mechanism.errors import MechanismError
from governor_mechanism.joints import Distance
from governor_mechanism.mechanism import Mechanism

MAX_STEP = 0.1
"""Largest change of the coordinate (rad, or machine sizes) in one continuation step: Newton stays on its branch."""

CLOSED = 1e-13
"""Joints count as closed at this fraction of the machine's size; rounding leaves about 1e-15."""


class Assembler:
    """Assembles one mechanism of mobility one anywhere along its leading coordinate, starting from its sketch."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self.equations = JointEquations(mechanism)
        turns = [body.turns for body in mechanism.bodies]
        self.free = np.array([[True, True, turn] for turn in turns]).ravel()
        """(3 bodies,) which coordinates may change: a body that does not turn keeps its angle."""
        quantity = mechanism.reading(mechanism.coordinate).quantity
        self._scale = 1.0 if quantity == "angle" else mechanism.size

    @property
    def mobility(self) -> int:
        """Freedoms the joints leave at the sketch: free coordinates less the rank of the joint equations."""
        return int(self.free.sum() - np.linalg.matrix_rank(self._gradient(self._sketch())[:-1]))

    def poses(self, value: float, near: Array | None = None) -> Array:
        """Poses (bodies, 3) at a value of the coordinate, on the branch of `near` (or of the sketch).

        Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
        """
        poses = self._newton(self._sketch() if near is None else near, None)
        here = float(reading_value(self.mechanism, self.mechanism.coordinate, poses))
        count = max(1, int(np.ceil(abs(value - here) / (MAX_STEP * self._scale))))
        for target in np.linspace(here, value, count + 1)[1:]:
            poses = self._newton(poses, float(target))
        return poses

    def tangent(self, poses: Array) -> Array:
        """Velocities (bodies, 3) of all bodies when the coordinate grows by one unit a second."""
        matrix = self._gradient(poses)
        right = np.zeros(matrix.shape[0])
        right[-1] = 1.0
        return self._spread(np.linalg.lstsq(matrix, right, rcond=None)[0])

    def _sketch(self) -> Array:
        return np.array(self.mechanism.sketch)

    def _gradient(self, poses: Array) -> Array:
        """Joint equations and, last, the coordinate, by the free coordinates."""
        joints = self.equations.gradients(poses)
        coordinate = reading_gradient(self.mechanism, self.mechanism.coordinate, poses)
        rows: Array = np.concatenate([joints, coordinate[np.newaxis]]).reshape(len(joints) + 1, -1)[:, self.free]
        return rows

    def _newton(self, poses: Array, value: float | None) -> Array:
        """Gauss-Newton on the joints, and on the coordinate where a value is asked for."""
        for _ in range(30):
            residual = self.equations.openings(poses)
            matrix = self._gradient(poses)
            if value is None:
                matrix = matrix[:-1]
            else:
                off = float(reading_value(self.mechanism, self.mechanism.coordinate, poses)) - value
                residual = np.append(residual, off)
            if np.max(np.abs(residual)) < CLOSED * max(self.mechanism.size, self._scale if value is not None else 0.0):
                return poses
            step = self._spread(np.linalg.lstsq(matrix, -residual, rcond=None)[0])
            poses = poses + step
            if np.max(np.abs(step)) < 1e-15 * self.mechanism.size:
                break
        return self._closed_or_refused(poses, value)

    def _closed_or_refused(self, poses: Array, value: float | None) -> Array:
        joint, gap = self.equations.widest(poses)
        if np.isfinite(gap) and abs(gap) < 1e3 * CLOSED * self.mechanism.size:
            return poses
        where = "" if value is None else f" at {self.mechanism.coordinate} = {value:.6g}"
        cure = ""
        if isinstance(joint, Distance):
            stretched = joint.length + gap
            cure = f"; a length near {stretched:.6g} m instead of {joint.length:.6g} m would close it"
        raise MechanismError(
            f"the mechanism cannot be assembled{where}: joint {joint.name!r} stays open by {abs(gap):.6g} m{cure}"
        )

    def _spread(self, free: NDArray[np.floating]) -> Array:
        """Free coordinates back to (bodies, 3), with zeros for bodies that do not turn."""
        everything = np.zeros(self.free.size)
        everything[self.free] = free
        return everything.reshape(-1, 3)

"""Joints as equations: how far each is open (m), and the gradient of that opening.

Every function takes poses of shape (..., bodies, 3), so that a whole trajectory is looked at in one call.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import singledispatch

import numpy as np

from governor_mechanism.equations.points import Array, Placed, place
from governor_mechanism.joints import Distance, Joint, Pin, Slider
from governor_mechanism.mechanism import Mechanism

Row = tuple[Callable[[Array], Array], Callable[[Array], Array]]
"""One scalar equation: opening(poses) -> (...) in m, gradient(poses) -> (..., bodies, 3)."""


@singledispatch
def _rows(joint: Joint, first: Placed, second: Placed) -> list[Row]:
    raise TypeError(f"no equation is written for joints of type {type(joint).__name__}")


@_rows.register
def _(joint: Pin, first: Placed, second: Placed) -> list[Row]:
    return [_along(first, second, np.array(direction)) for direction in ([1.0, 0.0], [0.0, 1.0])]


def _along(first: Placed, second: Placed, direction: Array) -> Row:
    def opening(poses: Array) -> Array:
        gap: Array = (second.position(poses) - first.position(poses)) @ direction
        return gap

    def gradient(poses: Array) -> Array:
        fixed = np.broadcast_to(direction, (*poses.shape[:-2], 2))
        return second.pull_back(poses, fixed) - first.pull_back(poses, fixed)

    return opening, gradient


@_rows.register
def _(joint: Distance, first: Placed, second: Placed) -> list[Row]:
    def span(poses: Array) -> tuple[Array, Array]:
        difference = second.position(poses) - first.position(poses)
        return difference, np.linalg.norm(difference, axis=-1)

    def opening(poses: Array) -> Array:
        return span(poses)[1] - joint.length

    def gradient(poses: Array) -> Array:
        difference, length = span(poses)
        unit = difference / length[..., np.newaxis]
        return second.pull_back(poses, unit) - first.pull_back(poses, unit)

    return [(opening, gradient)]


@_rows.register
def _(joint: Slider, first: Placed, second: Placed) -> list[Row]:
    def normal(poses: Array) -> Array:
        turned = poses[..., first.body, 2] if first.body >= 0 else np.zeros(poses.shape[:-2])
        return np.stack([-np.sin(joint.angle + turned), np.cos(joint.angle + turned)], axis=-1)

    def opening(poses: Array) -> Array:
        gap: Array = np.sum(normal(poses) * (second.position(poses) - first.position(poses)), axis=-1)
        return gap

    def gradient(poses: Array) -> Array:
        across = normal(poses)
        rows = second.pull_back(poses, across) - first.pull_back(poses, across)
        if first.body >= 0:  # the line turns with its body
            along = np.stack([across[..., 1], -across[..., 0]], axis=-1)
            rows[..., first.body, 2] -= np.sum(along * (second.position(poses) - first.position(poses)), axis=-1)
        return rows

    return [(opening, gradient)]


class JointEquations:
    """All joints of a mechanism as one set of equations."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.joints = mechanism.joints
        self._per_joint = [_rows(j, place(mechanism, j.first), place(mechanism, j.second)) for j in mechanism.joints]
        self._all = [row for rows in self._per_joint for row in rows]

    def openings(self, poses: Array) -> Array:
        """(..., equations) m, signed."""
        return np.stack([opening(poses) for opening, _ in self._all], axis=-1)

    def gradients(self, poses: Array) -> Array:
        """(..., equations, bodies, 3): m per m, and m per rad."""
        return np.stack([gradient(poses) for _, gradient in self._all], axis=-3)

    def gap(self, poses: Array) -> Array:
        """(...) m: the widest opening of any joint."""
        widest: Array = np.max(np.abs(self.openings(poses)), axis=-1)
        return widest

    def widest(self, poses: Array) -> tuple[Joint, float]:
        """The joint that is open widest at one set of poses, and its opening (m; signed where it has one equation)."""
        openings = [[float(opening(poses)) for opening, _ in rows] for rows in self._per_joint]
        worst = max(range(len(openings)), key=lambda index: math.hypot(*openings[index]))
        gaps = openings[worst]
        return self.joints[worst], gaps[0] if len(gaps) == 1 else math.hypot(*gaps)

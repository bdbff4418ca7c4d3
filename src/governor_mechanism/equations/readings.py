"""Readings as equations: value and gradient of every named output, over whole trajectories."""

from __future__ import annotations

from functools import singledispatch

import numpy as np

from governor_mechanism.equations.points import Array, place
from governor_mechanism.mechanism import Coordinate, FollowerHeight, LineAngle, Mechanism, Reading


@singledispatch
def _measure(reading: Reading, mechanism: Mechanism, poses: Array) -> tuple[Array, Array]:
    raise TypeError(f"no equation is written for readings of type {type(reading).__name__}")


@_measure.register
def _(reading: LineAngle, mechanism: Mechanism, poses: Array) -> tuple[Array, Array]:
    start, end = place(mechanism, reading.start), place(mechanism, reading.end)
    line = end.position(poses) - start.position(poses)
    across = np.stack([-line[..., 1], line[..., 0]], axis=-1) / np.sum(line**2, axis=-1, keepdims=True)
    return np.arctan2(line[..., 0], -line[..., 1]), end.pull_back(poses, across) - start.pull_back(poses, across)


@_measure.register
def _(reading: Coordinate, mechanism: Mechanism, poses: Array) -> tuple[Array, Array]:
    point = place(mechanism, reading.point)
    direction = np.broadcast_to(np.array([reading.along_x, reading.along_y]), (*poses.shape[:-2], 2))
    value = np.sum(direction * point.position(poses), axis=-1) - reading.zero
    return value, point.pull_back(poses, direction)


@_measure.register
def _(reading: FollowerHeight, mechanism: Mechanism, poses: Array) -> tuple[Array, Array]:
    top, end = place(mechanism, reading.top), place(mechanism, reading.knee)
    knee = (1 - reading.fraction) * top.position(poses) + reading.fraction * end.position(poses)
    reach = knee[..., 0] - reading.line
    drop = np.sqrt(np.maximum(reading.length**2 - reach**2, 0.0))
    # Beyond the link's reach there is no height; the machine's limits end a run before that.
    slope = np.divide(reach, drop, out=np.zeros_like(reach), where=drop > 0)
    direction = np.stack([slope, np.ones_like(reach)], axis=-1)
    gradient = (1 - reading.fraction) * top.pull_back(poses, direction)
    return knee[..., 1] - drop - reading.zero, gradient + reading.fraction * end.pull_back(poses, direction)


def reading_value(mechanism: Mechanism, name: str, poses: Array) -> Array:
    """Value (...) of a reading in SI, from poses (..., bodies, 3)."""
    return _measure(mechanism.reading(name), mechanism, poses)[0]


def reading_gradient(mechanism: Mechanism, name: str, poses: Array) -> Array:
    """Gradient (..., bodies, 3) of a reading: SI units per m, and per rad."""
    return _measure(mechanism.reading(name), mechanism, poses)[1]

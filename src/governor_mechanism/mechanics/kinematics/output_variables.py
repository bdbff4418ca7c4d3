"""Readings as equations: value, gradient and what velocities bend of every named output, over whole trajectories."""

from __future__ import annotations

from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from governor_mechanism.mechanics.kinematics.points import Placed, place
from governor_mechanism.model.mechanism import (
    BodyAngle,
    Coordinate,
    FollowerHeight,
    LineAngle,
    Mechanism,
    Reading,
    Separation,
)
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Measure:
    """A reading at poses (..., bodies, 3): value (...) SI; gradient (..., bodies, 3) SI per m, and per rad.

    bend (...) SI/s2 is what its second derivative has beside gradient . accelerations, from the velocities.
    """

    value: FloatArray
    gradient: FloatArray
    bend: FloatArray


def measure(mechanism: Mechanism, name: str, poses: FloatArray, velocities: FloatArray | None = None) -> Measure:
    """A reading at poses and velocities (..., bodies, 3); at rest where no velocities are given."""
    moving = np.zeros_like(poses) if velocities is None else velocities
    return _measure(mechanism.reading(name), mechanism, poses, moving)


def reading_value(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    """Value (...) of a reading in SI, from poses (..., bodies, 3)."""
    return measure(mechanism, name, poses).value


def reading_gradient(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    """Gradient (..., bodies, 3) of a reading: SI units per m, and per rad."""
    return measure(mechanism, name, poses).gradient


def measured(reading: Reading, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    """Any reading of a mechanism, whether it lists it or not."""
    return _measure(reading, mechanism, poses, velocities)


@singledispatch
def _measure(reading: Reading, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    raise TypeError(f"no equation is written for readings of type {type(reading).__name__}")


@_measure.register
def _(reading: LineAngle, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    start, end = place(mechanism, reading.start), place(mechanism, reading.end)
    line, rate, inward = _between(start, end, poses, velocities)
    squared = np.sum(line**2, axis=-1)
    across = _quarter(line) / squared[..., np.newaxis]
    turning = _dot(across, rate)
    return Measure(
        np.arctan2(line[..., 0], -line[..., 1]) - reading.zero,
        end.pull_back(poses, across) - start.pull_back(poses, across),
        _dot(across, inward) - 2 * turning * _dot(line, rate) / squared,
    )


@_measure.register
def _(reading: BodyAngle, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    value, gradient = np.zeros(poses.shape[:-2]), np.zeros(poses.shape)
    for name, sign in ((reading.body, 1.0), (reading.against, -1.0)):
        index = mechanism.body_index(name)
        if index >= 0:
            value = value + sign * poses[..., index, 2]
            gradient[..., index, 2] += sign
    return Measure(value, gradient, np.zeros(poses.shape[:-2]))


@_measure.register
def _(reading: Separation, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    first, second = place(mechanism, reading.first), place(mechanism, reading.second)
    line, rate, inward = _between(first, second, poses, velocities)
    length = np.linalg.norm(line, axis=-1)
    along = line / length[..., np.newaxis]
    growth = _dot(along, rate)
    return Measure(
        length,
        second.pull_back(poses, along) - first.pull_back(poses, along),
        _dot(along, inward) + (np.sum(rate**2, axis=-1) - growth**2) / length,
    )


@_measure.register
def _(reading: Coordinate, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    origin, point = place(mechanism, reading.origin), place(mechanism, reading.point)
    line, rate, inward = _between(origin, point, poses, velocities)
    direction = origin.turned(poses, np.array([reading.along_x, reading.along_y]))
    gradient = point.pull_back(poses, direction) - origin.pull_back(poses, direction)
    turning = np.zeros(poses.shape[:-2])
    if origin.body >= 0:  # the direction turns with its body
        gradient[..., origin.body, 2] += _dot(_quarter(direction), line)
        turning = velocities[..., origin.body, 2]
    bend = _dot(direction, inward) + 2 * turning * _dot(_quarter(direction), rate) - turning**2 * _dot(direction, line)
    return Measure(_dot(direction, line) - reading.zero, gradient, bend)


@_measure.register
def _(reading: FollowerHeight, mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> Measure:
    top, end = place(mechanism, reading.top), place(mechanism, reading.knee)
    share = reading.fraction

    def mixed(first: FloatArray, second: FloatArray) -> FloatArray:
        return (1 - share) * first + share * second

    knee = mixed(top.position(poses), end.position(poses))
    rate = mixed(top.velocity(poses, velocities), end.velocity(poses, velocities))
    inward = mixed(top.inward(poses, velocities), end.inward(poses, velocities))
    reach = knee[..., 0] - reading.line
    drop = np.sqrt(np.maximum(reading.length**2 - reach**2, 0.0))
    # Beyond the link's reach there is no height; the machine's limits end a run before that.
    slope = np.divide(reach, drop, out=np.zeros_like(reach), where=drop > 0)
    curving = np.divide(1 + slope**2, drop, out=np.zeros_like(reach), where=drop > 0)
    direction = np.stack([slope, np.ones_like(reach)], axis=-1)
    height = knee[..., 1] - drop
    gradient = mixed(top.pull_back(poses, direction), end.pull_back(poses, direction))
    bend = _dot(direction, inward) + curving * rate[..., 0] ** 2
    if reading.against is None:
        return Measure(height - reading.zero, gradient, bend)
    other = place(mechanism, reading.against)
    up = np.broadcast_to(np.array([0.0, 1.0]), direction.shape)
    return Measure(
        other.position(poses)[..., 1] - height - reading.zero,
        other.pull_back(poses, up) - gradient,
        other.inward(poses, velocities)[..., 1] - bend,
    )


def _between(
    start: Placed, end: Placed, poses: FloatArray, velocities: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The line from start to end (..., 2), how it changes, and what turning adds to its second derivative."""
    return (
        end.position(poses) - start.position(poses),
        end.velocity(poses, velocities) - start.velocity(poses, velocities),
        end.inward(poses, velocities) - start.inward(poses, velocities),
    )


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    product: FloatArray = np.sum(first * second, axis=-1)
    return product


def _quarter(vector: FloatArray) -> FloatArray:
    """Turned by a right angle, anticlockwise."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)

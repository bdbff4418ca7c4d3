"""The joint equations, compiled: every joint is one or two rows of one of a few kinds.

A row is an opening (m) between a point of a first and a point of a second body, along a direction that the kind gives.
Bodies are indices into poses (bodies, 3); -1 is the ground.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.points import Array, Whole

DISTANCE, ALONG, ACROSS = 0, 1, 2
"""Kinds: the distance less parameter 0; the part along the fixed direction of parameters 0 and 1; the part across a
line of the first body at angle parameter 0."""


@compiled
def evaluate(
    kind: Whole,
    body: Whole,
    anchor: Array,
    parameter: Array,
    poses: Array,
    velocities: Array,
    opening: Array,
    gradient: Array,
    bend: Array,
) -> None:
    """Fill opening (rows,), gradient (rows, 2, 3) by the poses of both bodies, and bend (rows,).

    bend is what the opening's second derivative has beside gradient . accelerations, negated: joints stay closed when
    gradient . accelerations = bend.
    """
    for i in range(kind.size):
        first, second = body[i, 0], body[i, 1]
        x1, y1, rx1, ry1, u1, v1, w1 = anchor[i, 0], anchor[i, 1], 0.0, 0.0, 0.0, 0.0, 0.0
        if first >= 0:
            cosine, sine, w1 = math.cos(poses[first, 2]), math.sin(poses[first, 2]), velocities[first, 2]
            rx1, ry1 = cosine * x1 - sine * y1, sine * x1 + cosine * y1
            x1, y1 = poses[first, 0] + rx1, poses[first, 1] + ry1
            u1, v1 = velocities[first, 0] - ry1 * w1, velocities[first, 1] + rx1 * w1
        x2, y2, rx2, ry2, u2, v2, w2 = anchor[i, 2], anchor[i, 3], 0.0, 0.0, 0.0, 0.0, 0.0
        if second >= 0:
            cosine, sine, w2 = math.cos(poses[second, 2]), math.sin(poses[second, 2]), velocities[second, 2]
            rx2, ry2 = cosine * x2 - sine * y2, sine * x2 + cosine * y2
            x2, y2 = poses[second, 0] + rx2, poses[second, 1] + ry2
            u2, v2 = velocities[second, 0] - ry2 * w2, velocities[second, 1] + rx2 * w2
        dx, dy, du, dv = x2 - x1, y2 - y1, u2 - u1, v2 - v1
        turn = curl = 0.0
        if kind[i] == DISTANCE:
            length = math.hypot(dx, dy)
            nx, ny = dx / length, dy / length
            opening[i] = length - parameter[i, 0]
            along = nx * du + ny * dv
            curl = (du * du + dv * dv - along * along) / length
        elif kind[i] == ALONG:
            nx, ny = parameter[i, 0], parameter[i, 1]
            opening[i] = nx * dx + ny * dy
        else:
            angle = parameter[i, 0] + (poses[first, 2] if first >= 0 else 0.0)
            nx, ny = -math.sin(angle), math.cos(angle)
            opening[i] = nx * dx + ny * dy
            turn = -(ny * dx - nx * dy)  # the line turns with its body
            curl = -2.0 * w1 * (ny * du - nx * dv) - w1 * w1 * opening[i]
        gradient[i, 0, 0], gradient[i, 0, 1], gradient[i, 0, 2] = -nx, -ny, nx * ry1 - ny * rx1 + turn
        gradient[i, 1, 0], gradient[i, 1, 1], gradient[i, 1, 2] = nx, ny, ny * rx2 - nx * ry2
        inward_x, inward_y = w1 * w1 * rx1 - w2 * w2 * rx2, w1 * w1 * ry1 - w2 * w2 * ry2
        bend[i] = -(nx * inward_x + ny * inward_y + curl)


@compiled
def openings_of(kind: Whole, body: Whole, anchor: Array, parameter: Array, poses: Array) -> Array:
    """Openings (n, rows) of poses (n, bodies, 3)."""
    found = np.empty((poses.shape[0], kind.size))
    still, gradient, bend = np.zeros(poses.shape[1:]), np.empty((kind.size, 2, 3)), np.empty(kind.size)
    for k in range(poses.shape[0]):
        evaluate(kind, body, anchor, parameter, poses[k], still, found[k], gradient, bend)
    return found


@compiled
def gradients_of(kind: Whole, body: Whole, anchor: Array, parameter: Array, poses: Array) -> Array:
    """Gradients (n, rows, bodies, 3) of the openings, by all poses."""
    found = np.zeros((poses.shape[0], kind.size, poses.shape[1], 3))
    still, gradient = np.zeros(poses.shape[1:]), np.empty((kind.size, 2, 3))
    opening, bend = np.empty(kind.size), np.empty(kind.size)
    for k in range(poses.shape[0]):
        evaluate(kind, body, anchor, parameter, poses[k], still, opening, gradient, bend)
        for i in range(kind.size):
            for side in range(2):
                if body[i, side] >= 0:
                    found[k, i, body[i, side]] += gradient[i, side]
    return found

"""The joint equations, compiled: every joint is one to three rows of one of a few kinds.

A row is an opening (m) between a point of a first and a point of a second body, along a direction that the kind gives,
less what a drive asks for. Bodies are indices into poses (bodies, 3); -1 is the ground.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.equations.compiled import compiled
from governor_mechanism.equations.points import Array, Whole

DISTANCE, ALONG, ACROSS = 0, 1, 2
"""Kinds: the distance; the part along a fixed direction, and turning; the part across a line of the first body.

Parameters: (length); (direction x, y, m per rad of the first and of the second body's angle, constant); (angle)."""

PARAMETERS = 5


class Rows(NamedTuple):
    """All equations of a mechanism, as arrays of so many rows.

    kind (rows,); body (rows, 2); anchor (rows, 4): x, y on the first and on the second body; parameter (rows,
    PARAMETERS); source (rows, 3): the program that drives the row or -1, first piece and number of pieces of its curve;
    unit (rows,): m per unit of that program; pieces (all pieces, 5): where each cubic of a curve starts, and its
    coefficients, highest power first.
    """

    kind: Whole
    body: Whole
    anchor: Array
    parameter: Array
    source: Whole
    unit: Array
    pieces: Array


@compiled
def ask(rows: Rows, cubics: Array, since: float, asked: Array) -> None:
    """Fill asked (rows, 3): what drives want of each opening (m, m/s, m/s2); cubics (programs, 4) of the time since."""
    for i in range(rows.kind.size):
        k = rows.source[i, 0]
        if k >= 0:
            a, b, c, d = cubics[k, 0], cubics[k, 1], cubics[k, 2], cubics[k, 3]
            asked[i, 0] = rows.unit[i] * (((a * since + b) * since + c) * since + d)
            asked[i, 1] = rows.unit[i] * ((3.0 * a * since + 2.0 * b) * since + c)
            asked[i, 2] = rows.unit[i] * (6.0 * a * since + 2.0 * b)


@compiled
def curve_at(pieces: Array, first: int, count: int, x: float) -> tuple[float, float, float]:
    """Value, slope and second derivative of a curve of `count` cubics, the first at index `first`."""
    k = first
    while k + 1 < first + count and x >= pieces[k + 1, 0]:
        k += 1
    s, a, b, c, d = x - pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3], pieces[k, 4]
    return ((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c, 6.0 * a * s + 2.0 * b


@compiled
def evaluate(
    rows: Rows, poses: Array, velocities: Array, asked: Array, opening: Array, gradient: Array, bend: Array
) -> None:
    """Fill opening (rows,), gradient (rows, 2, 3) by the poses of both bodies, and bend (rows,).

    bend is what gradient . accelerations must be for joints to stay closed, and drives to be followed.
    """
    kind, body, anchor, parameter = rows.kind, rows.body, rows.anchor, rows.parameter
    for i in range(kind.size):
        first, second = body[i, 0], body[i, 1]
        x1, y1, rx1, ry1, u1, v1, w1, angle1 = anchor[i, 0], anchor[i, 1], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if first >= 0:
            angle1, w1 = poses[first, 2], velocities[first, 2]
            cosine, sine = math.cos(angle1), math.sin(angle1)
            rx1, ry1 = cosine * x1 - sine * y1, sine * x1 + cosine * y1
            x1, y1 = poses[first, 0] + rx1, poses[first, 1] + ry1
            u1, v1 = velocities[first, 0] - ry1 * w1, velocities[first, 1] + rx1 * w1
        x2, y2, rx2, ry2, u2, v2, w2, angle2 = anchor[i, 2], anchor[i, 3], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if second >= 0:
            angle2, w2 = poses[second, 2], velocities[second, 2]
            cosine, sine = math.cos(angle2), math.sin(angle2)
            rx2, ry2 = cosine * x2 - sine * y2, sine * x2 + cosine * y2
            x2, y2 = poses[second, 0] + rx2, poses[second, 1] + ry2
            u2, v2 = velocities[second, 0] - ry2 * w2, velocities[second, 1] + rx2 * w2
        dx, dy, du, dv = x2 - x1, y2 - y1, u2 - u1, v2 - v1
        turn1 = turn2 = curl = 0.0
        if kind[i] == DISTANCE:
            length = math.hypot(dx, dy)
            nx, ny = dx / length, dy / length
            opening[i] = length - parameter[i, 0]
            along = nx * du + ny * dv
            curl = (du * du + dv * dv - along * along) / length
        elif kind[i] == ALONG:
            nx, ny, turn1, turn2 = parameter[i, 0], parameter[i, 1], parameter[i, 2], parameter[i, 3]
            opening[i] = nx * dx + ny * dy + turn1 * angle1 + turn2 * angle2 - parameter[i, 4]
        else:
            angle = parameter[i, 0] + angle1
            ux, uy = math.cos(angle), math.sin(angle)
            nx, ny = -uy, ux
            across, ahead = nx * dx + ny * dy, ux * dx + uy * dy
            sideways, forward = nx * du + ny * dv, ux * du + uy * dv
            opening[i] = across
            turn1 = -ahead  # the line turns with its body
            curl = -2.0 * w1 * forward - w1 * w1 * across
            if rows.source[i, 2] > 0:
                height, slope, curving = curve_at(rows.pieces, rows.source[i, 1], rows.source[i, 2], ahead)
                opening[i] -= height
                turn1 -= slope * across
                rate = forward + w1 * across
                curl -= slope * (2.0 * w1 * sideways - w1 * w1 * ahead) + curving * rate * rate
                nx, ny = nx - slope * ux, ny - slope * uy
        opening[i] -= asked[i, 0]
        gradient[i, 0, 0], gradient[i, 0, 1], gradient[i, 0, 2] = -nx, -ny, nx * ry1 - ny * rx1 + turn1
        gradient[i, 1, 0], gradient[i, 1, 1], gradient[i, 1, 2] = nx, ny, ny * rx2 - nx * ry2 + turn2
        inward_x, inward_y = w1 * w1 * rx1 - w2 * w2 * rx2, w1 * w1 * ry1 - w2 * w2 * ry2
        bend[i] = asked[i, 2] - (nx * inward_x + ny * inward_y + curl)


@compiled
def openings_of(rows: Rows, poses: Array, asked: Array) -> Array:
    """Openings (n, rows) of poses (n, bodies, 3), less what is asked (n, rows, 3)."""
    found = np.empty((poses.shape[0], rows.kind.size))
    still, gradient = np.zeros(poses.shape[1:]), np.empty((rows.kind.size, 2, 3))
    bend = np.empty(rows.kind.size)
    for k in range(poses.shape[0]):
        evaluate(rows, poses[k], still, asked[k], found[k], gradient, bend)
    return found


@compiled
def gradients_of(rows: Rows, poses: Array) -> Array:
    """Gradients (n, rows, bodies, 3) of the openings, by all poses."""
    found = np.zeros((poses.shape[0], rows.kind.size, poses.shape[1], 3))
    still, gradient = np.zeros(poses.shape[1:]), np.empty((rows.kind.size, 2, 3))
    opening, bend, asked = np.empty(rows.kind.size), np.empty(rows.kind.size), np.zeros((rows.kind.size, 3))
    for k in range(poses.shape[0]):
        evaluate(rows, poses[k], still, asked, opening, gradient, bend)
        for i in range(rows.kind.size):
            for side in range(2):
                if rows.body[i, side] >= 0:
                    found[k, i, rows.body[i, side]] += gradient[i, side]
    return found


@compiled
def bends_of(rows: Rows, poses: Array, velocities: Array, asked: Array) -> Array:
    """What gradient . accelerations must be (n, rows), from poses and velocities (n, bodies, 3), asked (n, rows, 3)."""
    found = np.empty((poses.shape[0], rows.kind.size))
    opening, gradient = np.empty(rows.kind.size), np.empty((rows.kind.size, 2, 3))
    for k in range(poses.shape[0]):
        evaluate(rows, poses[k], velocities[k], asked[k], opening, gradient, found[k])
    return found

"""The joint equations, compiled: every joint is one to three rows of one of a few kinds.

A row is an opening (m) between a point of a first and a point of a second body, along a direction that the kind gives,
less what a drive asks for. Bodies are indices into poses (bodies, 3); -1 is the ground.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from governor_mechanism.numerics.jit import compiled, kernel
from governor_mechanism.types import FloatArray, IntArray, RecordArray

DISTANCE, ALONG, ACROSS, LEAN, HANGING = 0, 1, 2, 3, 4
"""Kinds: the distance; the part along a fixed direction, and turning; the part across a line of the first body; the
angle of the line between the points from the downward vertical; the height of a follower hung from the second point.

Parameters: (length); (direction x, y, m per rad of the first and of the second body's angle, constant, what the first
point's way counts less than once); (angle, -, -, -, constant); (-, -, -, -, constant); (of the rod's other end x from
the follower's line, and y, the second point's share of both, length, constant, sign), to which the first point's height
is added. The last two are rad, and what only readings are."""

PARAMETERS = 6

ROW = np.dtype(
    [
        *((name, "i8") for name in ("kind", "first", "second")),
        *((name, "f8") for name in ("x1", "y1", "x2", "y2", "p0", "p1", "p2", "p3", "p4", "p5", "unit")),
        *((name, "i8") for name in ("drive", "piece", "pieces")),
    ]
)
"""One equation: its kind, bodies, points on them, parameters, m per unit of what drives it; the program that does, or
-1; first piece and number of pieces of its curve."""

ASKED, RATE, ASKED_BEND, OPENING, BEND = range(5)
"""Columns of what is known of each row at a moment: what a drive asks for (m, m/s, m/s2), opening (m), bend (m/s2)."""


class Rows(NamedTuple):
    """All equations of a mechanism: table (rows,) of ROW; ends (rows, 2), its bodies once more; pieces (all pieces, 5):
    where each cubic of a curve starts (m), and its coefficients, highest power first.

    Few arrays, because each costs time in every call.
    """

    table: RecordArray
    ends: IntArray
    pieces: FloatArray


@kernel
def ask(rows: Rows, cubics: FloatArray, since: float, line: FloatArray) -> None:
    """Fill what drives ask for into line (rows, 5); cubics (programs, 4) of the time since."""
    for i in range(rows.table.size):
        k, unit = rows.table[i].drive, rows.table[i].unit
        if k >= 0:
            a, b, c, d = cubics[k, 0], cubics[k, 1], cubics[k, 2], cubics[k, 3]
            line[i, ASKED] = unit * (((a * since + b) * since + c) * since + d)
            line[i, RATE] = unit * ((3.0 * a * since + 2.0 * b) * since + c)
            line[i, ASKED_BEND] = unit * (6.0 * a * since + 2.0 * b)


@compiled
def curve_at(pieces: FloatArray, first: int, count: int, x: float) -> tuple[float, float, float]:
    """Value, slope and second derivative of a curve of `count` cubics, the first at index `first`."""
    k = first
    while k + 1 < first + count and x >= pieces[k + 1, 0]:
        k += 1
    s, a, b, c, d = x - pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3], pieces[k, 4]
    return ((a * s + b) * s + c) * s + d, (3.0 * a * s + 2.0 * b) * s + c, 6.0 * a * s + 2.0 * b


@kernel
def evaluate(rows: Rows, poses: FloatArray, velocities: FloatArray, line: FloatArray, gradient: FloatArray) -> None:
    """Fill opening and bend of line (rows, 5), where `ask` was before, and gradient (rows, 2, 3) by both bodies' poses.

    bend is what gradient . accelerations must be for joints to stay closed, and drives to be followed.
    """
    for i in range(rows.table.size):
        row = rows.table[i]
        first, second = row.first, row.second
        x1, y1, rx1, ry1, u1, v1, w1, angle1 = row.x1, row.y1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if first >= 0:
            angle1, w1 = poses[first, 2], velocities[first, 2]
            if x1 != 0.0 or y1 != 0.0:
                cosine, sine = math.cos(angle1), math.sin(angle1)
                rx1, ry1 = cosine * x1 - sine * y1, sine * x1 + cosine * y1
            x1, y1 = poses[first, 0] + rx1, poses[first, 1] + ry1
            u1, v1 = velocities[first, 0] - ry1 * w1, velocities[first, 1] + rx1 * w1
        x2, y2, rx2, ry2, u2, v2, w2, angle2 = row.x2, row.y2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        if second >= 0:
            angle2, w2 = poses[second, 2], velocities[second, 2]
            if x2 != 0.0 or y2 != 0.0:
                cosine, sine = math.cos(angle2), math.sin(angle2)
                rx2, ry2 = cosine * x2 - sine * y2, sine * x2 + cosine * y2
            x2, y2 = poses[second, 0] + rx2, poses[second, 1] + ry2
            u2, v2 = velocities[second, 0] - ry2 * w2, velocities[second, 1] + rx2 * w2
        share = 1.0 - row.p5 if row.kind == ALONG else 1.0
        if share != 1.0:
            x1, y1, rx1, ry1, u1, v1 = share * x1, share * y1, share * rx1, share * ry1, share * u1, share * v1
        dx, dy, du, dv = x2 - x1, y2 - y1, u2 - u1, v2 - v1
        turn1 = turn2 = curl = 0.0
        if row.kind == DISTANCE:
            length = math.hypot(dx, dy)
            nx, ny = dx / length, dy / length
            opening = length - row.p0
            along = nx * du + ny * dv
            curl = (du * du + dv * dv - along * along) / length
        elif row.kind == ALONG:
            nx, ny, turn1, turn2 = row.p0, row.p1, row.p2, row.p3
            opening = nx * dx + ny * dy + turn1 * angle1 + turn2 * angle2 - row.p4
        elif row.kind == LEAN:
            squared = dx * dx + dy * dy
            nx, ny = -dy / squared, dx / squared
            opening = math.atan2(dx, -dy) - row.p4
            curl = -2.0 * (nx * du + ny * dv) * (dx * du + dy * dv) / squared
        elif row.kind == HANGING:
            reach, part = row.p0 + row.p2 * x2, row.p5 * row.p2
            drop = math.sqrt(max(row.p3 * row.p3 - reach * reach, 1e-300))
            lean = reach / drop
            nx, ny = part * lean, part
            opening = row.p5 * (row.p1 + row.p2 * y2 - drop) + y1 - row.p4
            curl = part * row.p2 * (1.0 + lean * lean) / drop * u2 * u2 - w1 * w1 * (nx * rx1 + (ny + 1.0) * ry1)
        else:
            angle = row.p0 + angle1
            ux, uy = math.cos(angle), math.sin(angle)
            nx, ny = -uy, ux
            across, ahead = nx * dx + ny * dy, ux * dx + uy * dy
            sideways, forward = nx * du + ny * dv, ux * du + uy * dv
            opening = across - row.p4
            turn1 = -ahead  # the line turns with its body
            curl = -2.0 * w1 * forward - w1 * w1 * across
            if row.pieces > 0:
                height, slope, curving = curve_at(rows.pieces, row.piece, row.pieces, ahead)
                opening -= height
                turn1 -= slope * across
                rate = forward + w1 * across
                curl -= slope * (2.0 * w1 * sideways - w1 * w1 * ahead) + curving * rate * rate
                nx, ny = nx - slope * ux, ny - slope * uy
        line[i, OPENING] = opening - line[i, ASKED]
        gradient[i, 0, 0], gradient[i, 0, 1] = -share * nx, -share * ny
        gradient[i, 0, 2] = nx * ry1 - ny * rx1 + turn1
        gradient[i, 1, 0], gradient[i, 1, 1], gradient[i, 1, 2] = nx, ny, ny * rx2 - nx * ry2 + turn2
        if row.kind == HANGING:
            gradient[i, 0, 0], gradient[i, 0, 1], gradient[i, 0, 2] = 0.0, 1.0, rx1
        inward_x, inward_y = w1 * w1 * rx1 - w2 * w2 * rx2, w1 * w1 * ry1 - w2 * w2 * ry2
        line[i, BEND] = line[i, ASKED_BEND] - (nx * inward_x + ny * inward_y + curl)


@compiled
def openings_of(rows: Rows, poses: FloatArray, asked: FloatArray) -> FloatArray:
    """Openings (n, rows) of poses (n, bodies, 3), less what is asked (n, rows, 3)."""
    return _found(rows, poses, np.zeros(poses.shape), asked, OPENING)


@compiled
def bends_of(rows: Rows, poses: FloatArray, velocities: FloatArray, asked: FloatArray) -> FloatArray:
    """What gradient . accelerations must be (n, rows), from poses and velocities (n, bodies, 3), asked (n, rows, 3)."""
    return _found(rows, poses, velocities, asked, BEND)


@kernel
def _found(rows: Rows, poses: FloatArray, velocities: FloatArray, asked: FloatArray, column: int) -> FloatArray:
    count = rows.table.size
    found, line, gradient = np.empty((poses.shape[0], count)), np.empty((count, 5)), np.empty((count, 2, 3))
    for k in range(poses.shape[0]):
        for i in range(count):
            for c in range(3):
                line[i, c] = asked[k, i, c]
        evaluate(rows, poses[k], velocities[k], line, gradient)
        for i in range(count):
            found[k, i] = line[i, column]
    return found


@compiled
def gradients_of(rows: Rows, poses: FloatArray) -> FloatArray:
    """Gradients (n, rows, bodies, 3) of the openings, by all poses."""
    count = rows.table.size
    found, still = np.zeros((poses.shape[0], count, poses.shape[1], 3)), np.zeros(poses.shape[1:])
    line, gradient = np.zeros((count, 5)), np.empty((count, 2, 3))
    for k in range(poses.shape[0]):
        evaluate(rows, poses[k], still, line, gradient)
        for i in range(count):
            for side in range(2):
                at = rows.ends[i, side]
                if at >= 0:
                    for c in range(3):
                        found[k, i, at, c] += gradient[i, side, c]
    return found

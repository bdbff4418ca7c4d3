"""Joints as rows of numbers for the compiled equations, and questions about whole trajectories."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from governor_mechanism.equations.points import Array, Whole
from governor_mechanism.equations.rows import ACROSS, ALONG, DISTANCE, gradients_of, openings_of
from governor_mechanism.joints import Distance, Joint, Pin, Point, Slider
from governor_mechanism.mechanism import Mechanism

Row = tuple[int, float, float]
"""Kind and two parameters of one equation."""


@singledispatch
def _rows(joint: Joint) -> list[Row]:
    raise TypeError(f"no equation is written for joints of type {type(joint).__name__}")


@_rows.register
def _(joint: Pin) -> list[Row]:
    return [(ALONG, 1.0, 0.0), (ALONG, 0.0, 1.0)]


@_rows.register
def _(joint: Distance) -> list[Row]:
    return [(DISTANCE, joint.length, 0.0)]


@_rows.register
def _(joint: Slider) -> list[Row]:
    return [(ACROSS, joint.angle, 0.0)]


@dataclass(frozen=True)
class JointTable:
    """All joints of a mechanism as rows; `owner` (rows,) is the joint each row belongs to."""

    kind: Whole
    body: Whole
    anchor: Array
    parameter: Array
    owner: Whole


def joint_table(mechanism: Mechanism, origins: Mapping[str, tuple[float, float]] | None = None) -> JointTable:
    """The rows of a mechanism; its bodies' coordinates are counted from `origins` (body axes, m), or mass centres."""
    rows = [(index, joint, row) for index, joint in enumerate(mechanism.joints) for row in _rows(joint)]

    def anchor(point: Point) -> tuple[float, float]:
        x, y = (origins or {}).get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    ends = [[mechanism.body_index(point.body) for point in (joint.first, joint.second)] for _, joint, _ in rows]
    return JointTable(
        kind=np.array([row[0] for _, _, row in rows], dtype=np.int64),
        body=np.array(ends, dtype=np.int64).reshape(-1, 2),
        anchor=np.array([[*anchor(joint.first), *anchor(joint.second)] for _, joint, _ in rows]).reshape(-1, 4),
        parameter=np.array([row[1:] for _, _, row in rows]).reshape(-1, 2),
        owner=np.array([index for index, _, _ in rows], dtype=np.int64),
    )


class JointEquations:
    """All joints of a mechanism as one set of equations, for poses of shape (..., bodies, 3)."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.joints = mechanism.joints
        self._table = joint_table(mechanism)

    def openings(self, poses: Array) -> Array:
        """(..., equations) m, signed."""
        table, flat = self._table, _flat(poses)
        found = openings_of(table.kind, table.body, table.anchor, table.parameter, flat)
        return found.reshape(*poses.shape[:-2], -1)

    def gradients(self, poses: Array) -> Array:
        """(..., equations, bodies, 3): m per m, and m per rad."""
        table, flat = self._table, _flat(poses)
        found = gradients_of(table.kind, table.body, table.anchor, table.parameter, flat)
        return found.reshape(*poses.shape[:-2], -1, *poses.shape[-2:])

    def gap(self, poses: Array) -> Array:
        """(...) m: the widest opening of any joint."""
        widest: Array = np.max(np.abs(self.openings(poses)), axis=-1)
        return widest

    def widest(self, poses: Array) -> tuple[Joint, float]:
        """The joint that is open widest at one set of poses, and its opening (m; signed where it has one equation)."""
        rows = self.openings(poses)
        gaps = [rows[self._table.owner == index] for index in range(len(self.joints))]
        worst = max(range(len(gaps)), key=lambda index: math.hypot(*gaps[index]))
        return self.joints[worst], float(gaps[worst][0]) if len(gaps[worst]) == 1 else math.hypot(*gaps[worst])


def _flat(poses: Array) -> Array:
    return np.ascontiguousarray(poses, dtype=np.float64).reshape(-1, *poses.shape[-2:])

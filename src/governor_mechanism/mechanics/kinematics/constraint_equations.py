"""Joints as rows of numbers for the compiled equations, and questions about whole trajectories."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    ACROSS,
    ALONG,
    DISTANCE,
    PARAMETERS,
    ROW,
    Rows,
    bends_of,
    gradients_of,
    openings_of,
)
from governor_mechanism.mechanics.kinematics.time_functions import TimeCurve
from governor_mechanism.model.curves import Curve, Polynomial, Table
from governor_mechanism.model.joints import (
    ArcSlot,
    CurveSlot,
    Distance,
    DrivenSlide,
    DrivenTurn,
    Gear,
    Joint,
    Pin,
    Point,
    Prismatic,
    Proportion,
    Rack,
    Slider,
    Weld,
)
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import Motion
from governor_mechanism.types import FloatArray, IntArray, RecordArray


@dataclass(frozen=True)
class Row:
    """One equation of a joint: kind and parameters as in `rows`, the motion that drives it, the curve it follows."""

    kind: int
    parameter: tuple[float, ...]
    motion: Motion | None = None
    unit: float = 1.0
    curve: Curve | None = None


@singledispatch
def _rows(joint: Joint, size: float) -> list[Row]:
    """Equations of a joint; `size` (m) makes angles into openings."""
    raise TypeError(f"no equation is written for joints of type {type(joint).__name__}")


def _turning(turn: float, size: float, motion: Motion | None = None) -> Row:
    return Row(ALONG, (0.0, 0.0, -size, size, size * turn), motion, size)


@_rows.register
def _(joint: Pin, size: float) -> list[Row]:
    return [Row(ALONG, (1.0, 0.0)), Row(ALONG, (0.0, 1.0))]


@_rows.register
def _(joint: Weld, size: float) -> list[Row]:
    return [Row(ALONG, (1.0, 0.0)), Row(ALONG, (0.0, 1.0)), _turning(joint.turn, size)]


@_rows.register
def _(joint: Distance, size: float) -> list[Row]:
    return [Row(DISTANCE, (joint.length,))]


@_rows.register
def _(joint: ArcSlot, size: float) -> list[Row]:
    return [Row(DISTANCE, (joint.radius,))]


@_rows.register
def _(joint: Slider, size: float) -> list[Row]:
    return [Row(ACROSS, (joint.angle,))]


@_rows.register
def _(joint: Prismatic, size: float) -> list[Row]:
    return [Row(ACROSS, (joint.angle,)), _turning(joint.turn, size)]


@_rows.register
def _(joint: CurveSlot, size: float) -> list[Row]:
    return [Row(ACROSS, (joint.angle,), curve=joint.curve)]


@_rows.register
def _(joint: Gear, size: float) -> list[Row]:
    return [Row(ALONG, (0.0, 0.0, -size * joint.ratio, size, size * joint.offset))]


@_rows.register
def _(joint: Rack, size: float) -> list[Row]:
    return [Row(ALONG, (math.cos(joint.angle), math.sin(joint.angle), -joint.radius, 0.0, joint.offset))]


@_rows.register
def _(joint: Proportion, size: float) -> list[Row]:
    direction = math.cos(joint.angle), math.sin(joint.angle)
    return [Row(ALONG, (*direction, 0.0, 0.0, joint.offset, 1.0 - joint.ratio))]


@_rows.register
def _(joint: DrivenTurn, size: float) -> list[Row]:
    return [_turning(0.0, size, joint.motion)]


@_rows.register
def _(joint: DrivenSlide, size: float) -> list[Row]:
    return [Row(ACROSS, (joint.angle - math.pi / 2,), joint.motion)]


@dataclass(frozen=True)
class JointTable:
    """All joints of a mechanism as rows; `owner` (rows,) is the joint each row belongs to.

    motions are what the rows' drives refer to, by position.
    """

    rows: Rows
    owner: IntArray
    motions: tuple[Motion, ...]


def joint_table(mechanism: Mechanism, origins: Mapping[str, tuple[float, float]] | None = None) -> JointTable:
    """The rows of a mechanism; its bodies' coordinates are counted from `origins` (body axes, m), or mass centres."""
    every = [
        (index, joint, row)
        for index, joint in enumerate(mechanism.joints)
        for row in _rows(joint, mechanism.size)
        if not _vacuous(mechanism, joint, row)
    ]

    def anchor(point: Point) -> tuple[float, float]:
        x, y = (origins or {}).get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    table, pieces, motions, begun = np.zeros(len(every), dtype=ROW), [np.zeros((0, 5))], list[Motion](), 0
    for at, (_, joint, row) in enumerate(every):
        curve = np.zeros((0, 5)) if row.curve is None else curve_pieces(row.curve)
        drive = -1 if row.motion is None else len(motions)
        ends = [mechanism.body_index(point.body) for point in (joint.first, joint.second)]
        parameter = row.parameter + (0.0,) * (PARAMETERS - len(row.parameter))
        places = (*anchor(joint.first), *anchor(joint.second))
        table[at] = (row.kind, *ends, *places, *parameter, row.unit, drive, begun, len(curve))
        pieces.append(curve)
        begun += len(curve)
        motions += [] if row.motion is None else [row.motion]
    owner = np.array([index for index, _, _ in every], dtype=np.int64)
    return JointTable(Rows(table, ends_of(table), np.concatenate(pieces)), owner, tuple(motions))


def ends_of(table: RecordArray) -> IntArray:
    """The bodies (n, 2) of records with a first and a second one."""
    return np.stack([table["first"], table["second"]], axis=-1)


def _vacuous(mechanism: Mechanism, joint: Joint, row: Row) -> bool:
    """Whether a row only speaks of the turning of bodies that do not turn; refuses it where it contradicts that."""
    if row.kind != ALONG or row.parameter[:2] != (0.0, 0.0):
        return False
    bodies = [mechanism.body_index(point.body) for point in (joint.first, joint.second)]
    if any(index >= 0 and mechanism.bodies[index].turns for index in bodies):
        return False
    if row.motion is not None or row.parameter[4] != 0.0:
        raise MechanismError(f"joint {joint.name!r} asks two bodies that do not turn to turn against each other")
    return True


def curve_pieces(curve: Curve) -> FloatArray:
    """A curve as cubics (pieces, 5): where each starts (m), and its coefficients, highest power first."""
    if isinstance(curve, Polynomial):
        coefficients = np.zeros(4)
        coefficients[: len(curve.coefficients)] = curve.coefficients
        return np.array([[0.0, *coefficients[::-1]]])
    if isinstance(curve, Table):
        spline = CubicSpline(curve.x, curve.y)
        return np.column_stack([spline.x[:-1], spline.c.T])
    raise TypeError(f"no equation is written for curves of type {type(curve).__name__}")


class JointEquations:
    """All joints of a mechanism as one set of equations, for poses (..., bodies, 3) at times (...) s."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.joints = mechanism.joints
        table = joint_table(mechanism)
        self._rows, self.owner = table.rows, table.owner
        self._drives = [TimeCurve(motion) for motion in table.motions]

    @property
    def driven(self) -> NDArray[np.bool_]:
        """(equations,) which ones a drive moves."""
        driven: NDArray[np.bool_] = self._rows.table["drive"] >= 0
        return driven

    def asked(self, times: FloatArray) -> FloatArray:
        """(..., equations, 3): what drives want of each opening at times (...) s, in m, m/s, m/s2."""
        flat = np.atleast_1d(np.asarray(times, dtype=np.float64)).ravel()
        found = np.zeros((flat.size, len(self.owner), 3))
        for row in np.flatnonzero(self.driven):
            curve, unit = self._drives[self._rows.table[row]["drive"]], self._rows.table[row]["unit"]
            found[:, row] = unit * np.stack([curve(flat), curve.slope(flat), curve.bend(flat)], axis=-1)
        return found.reshape(*np.shape(times), len(self.owner), 3)

    def openings(self, poses: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(..., equations) m, signed."""
        found = openings_of(self._rows, _flat(poses), self._all_asked(poses, times))
        return found.reshape(*poses.shape[:-2], len(self.owner))

    def gradients(self, poses: FloatArray) -> FloatArray:
        """(..., equations, bodies, 3): m per m, and m per rad."""
        found = gradients_of(self._rows, _flat(poses))
        return found.reshape(*poses.shape[:-2], len(self.owner), *poses.shape[-2:])

    def bends(self, poses: FloatArray, velocities: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(..., equations): what gradients . accelerations must be (m/s2)."""
        found = bends_of(self._rows, _flat(poses), _flat(velocities), self._all_asked(poses, times))
        return found.reshape(*poses.shape[:-2], len(self.owner))

    def gap(self, poses: FloatArray, times: FloatArray | float = 0.0) -> FloatArray:
        """(...) m: the widest opening of any joint."""
        widest: FloatArray = np.max(np.abs(self.openings(poses, times)), axis=-1, initial=0.0)
        return widest

    def widest(self, poses: FloatArray, time: float = 0.0) -> tuple[Joint, float]:
        """The joint that is open widest at one set of poses, and its opening (m; signed where it has one equation)."""
        rows = self.openings(poses, time)
        gaps = [rows[self.owner == index] for index in range(len(self.joints))]
        worst = max(range(len(gaps)), key=lambda index: math.hypot(*gaps[index]))
        return self.joints[worst], float(gaps[worst][0]) if len(gaps[worst]) == 1 else math.hypot(*gaps[worst])

    def _all_asked(self, poses: FloatArray, times: FloatArray | float) -> FloatArray:
        every = np.broadcast_to(np.asarray(times, dtype=np.float64), poses.shape[:-2])
        return self.asked(every).reshape(every.size, len(self.owner), 3)


def _flat(poses: FloatArray) -> FloatArray:
    return np.ascontiguousarray(poses, dtype=np.float64).reshape(-1, *poses.shape[-2:])

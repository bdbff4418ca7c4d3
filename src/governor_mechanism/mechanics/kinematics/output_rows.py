"""Readings as rows of the compiled equations, so that loads can act along them and joints hold them.

A gauge is the row whose opening is the reading's value: m, or rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import singledispatch

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    BODY_NORMAL,
    CONSTRAINT_ROW_DTYPE,
    DISTANCE,
    FIXED_DIRECTION,
    FOLLOWER_HEIGHT,
    LINE_ANGLE,
    N_ROW_PARAMETERS,
    ConstraintRows,
)
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import BodyAngle, FollowerHeight, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.types import RecordArray

OutputRowData = tuple[int, Point, Point, tuple[float, ...]]
"""Kind, points and parameters."""

CONSTANT_PARAMETER = {DISTANCE: "p0", FIXED_DIRECTION: "p4", BODY_NORMAL: "p4", LINE_ANGLE: "p4", FOLLOWER_HEIGHT: "p4"}
"""Which parameter of each kind is taken off its opening."""


@singledispatch
def _output_row_data(reading: Reading) -> OutputRowData:
    raise TypeError(f"no row is written for readings of type {type(reading).__name__}")


@_output_row_data.register
def _(reading: LineAngle) -> OutputRowData:
    return LINE_ANGLE, reading.start, reading.end, (0.0, 0.0, 0.0, 0.0, reading.zero)


@_output_row_data.register
def _(reading: BodyAngle) -> OutputRowData:
    return FIXED_DIRECTION, Point(body=reading.reference_body), Point(body=reading.body), (0.0, 0.0, -1.0, 1.0)


@_output_row_data.register
def _(reading: PointDistance) -> OutputRowData:
    return DISTANCE, reading.first, reading.second, (0.0,)


@_output_row_data.register
def _(reading: PointCoordinate) -> OutputRowData:
    if reading.origin.body == GROUND:
        direction = reading.direction_x, reading.direction_y
        return FIXED_DIRECTION, reading.origin, reading.point, (*direction, 0.0, 0.0, reading.zero)
    if not math.isclose(math.hypot(reading.direction_x, reading.direction_y), 1.0, rel_tol=1e-12):
        raise MechanismError(f"nothing can act along {reading.name!r}: its direction is not of unit length")
    angle = math.atan2(-reading.direction_x, reading.direction_y)
    return BODY_NORMAL, reading.origin, reading.point, (angle, 0.0, 0.0, 0.0, reading.zero)


@_output_row_data.register
def _(reading: FollowerHeight) -> OutputRowData:
    if reading.top.body != GROUND:
        raise MechanismError(f"nothing can act along {reading.name!r}: the rod it hangs from has no fixed end")
    complement = 1.0 - reading.fraction
    offset = complement * reading.top.x - reading.guide_x, complement * reading.top.y
    against = reading.reference_point
    sign = 1.0 if against is None else -1.0
    base_point = Point(body=GROUND) if against is None else against
    return FOLLOWER_HEIGHT, base_point, reading.knee, (*offset, reading.fraction, reading.length, reading.zero, sign)


def make_output_rows(mechanism: Mechanism, names: Sequence[str], origins: Mapping[str, tuple[float, float]]) -> ConstraintRows:
    """The gauges of readings by name, bodies counted from `origins` (body axes, m)."""

    def anchor(point: Point) -> tuple[float, float]:
        x, y = origins.get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    table = np.zeros(len(names), dtype=CONSTRAINT_ROW_DTYPE)
    for i, name in enumerate(names):
        kind, first, second, parameters = _output_row_data(mechanism.reading(name))
        bodies = [mechanism.body_index(point.body) for point in (first, second)]
        padded_parameters = parameters + (0.0,) * (N_ROW_PARAMETERS - len(parameters))
        table[i] = (kind, *bodies, *anchor(first), *anchor(second), *padded_parameters, 1.0, -1, 0, 0)
    return ConstraintRows(table, bodies_of_rows(table), np.zeros((0, 5)))


def make_holding_rows(output_rows: RecordArray, indices: Sequence[int], values: Sequence[float]) -> RecordArray:
    """Rows (held,) that hold some gauges at values (m or rad)."""
    rows = output_rows[list(indices)].copy()
    for i, value in enumerate(values):
        rows[i][CONSTANT_PARAMETER[int(rows[i]["kind"])]] += value
    return rows

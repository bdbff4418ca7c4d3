"""Output variables as constraint rows, from which they are evaluated, along which forces act and which contacts hold.

An output row is a constraint row whose residual is the value of the output variable, in m or rad.
"""

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows
from governor_mechanism.mechanics.kinematics.constraint_kernels import CONSTRAINT_ROW_DTYPE, N_ROW_PARAMETERS, ConstraintRows, RowKind
from governor_mechanism.mechanics.kinematics.points import Origins, attachment_fields
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import (
    ArcPosition,
    BodyAngle,
    FollowerHeight,
    LineAngle,
    PointCoordinate,
    PointDistance,
    Reading,
)
from governor_mechanism.types import NO_INDEX

OutputRowData = tuple[int, Point, Point, tuple[float, ...]]
"""Kind, first and second point, and parameters of an output row."""

CONSTANT_PARAMETER = {int(kind): "p0" if kind == RowKind.DISTANCE else "p4" for kind in RowKind}
"""Field of the parameter that is subtracted in the residual, for each kind of row."""


def _output_row_data(reading: Reading) -> OutputRowData:
    """Return kind, points and parameters of the output row of a reading."""
    match reading:
        case LineAngle():
            return RowKind.LINE_ANGLE, reading.start, reading.end, (0.0, 0.0, 0.0, 0.0, reading.zero)
        case BodyAngle():
            return RowKind.FIXED_DIRECTION, Point(body=reading.reference_body), Point(body=reading.body), (0.0, 0.0, -1.0, 1.0)
        case PointDistance():
            return RowKind.DISTANCE, reading.first, reading.second, (0.0,)
        case PointCoordinate():
            return _point_coordinate_row(reading)
        case ArcPosition():
            return RowKind.ARC_POSITION, reading.centre, reading.point, (reading.angle, reading.radius, 0.0, 0.0, reading.zero)
        case FollowerHeight():
            return _follower_height_row(reading)
    raise TypeError(f"no output row is defined for readings of type {type(reading).__name__}")


def _point_coordinate_row(reading: PointCoordinate) -> OutputRowData:
    direction = reading.direction_x, reading.direction_y
    if reading.origin.body == GROUND:
        return RowKind.FIXED_DIRECTION, reading.origin, reading.point, (*direction, 0.0, 0.0, reading.zero)
    if not math.isclose(math.hypot(*direction), 1.0, rel_tol=1e-12):
        raise MechanismError(
            f"reading {reading.name!r} has a direction, relative to a body, of length {math.hypot(*direction):g}; give a unit vector"
        )
    angle = math.atan2(-reading.direction_x, reading.direction_y)
    return RowKind.BODY_NORMAL, reading.origin, reading.point, (angle, 0.0, 0.0, 0.0, reading.zero)


def _follower_height_row(reading: FollowerHeight) -> OutputRowData:
    if reading.top.body != GROUND:
        raise MechanismError(
            f"reading {reading.name!r} has a follower that hangs from a rod whose top is on body {reading.top.body!r}; "
            "the top must be on the ground"
        )
    complement = 1.0 - reading.fraction
    offset = complement * reading.top.x - reading.guide_x, complement * reading.top.y
    reference_point = reading.reference_point
    sign = 1.0 if reference_point is None else -1.0
    base_point = Point(body=GROUND) if reference_point is None else reference_point
    return RowKind.FOLLOWER_HEIGHT, base_point, reading.knee, (*offset, reading.fraction, reading.length, reading.zero, sign)


def make_output_rows(mechanism: Mechanism, names: Sequence[str], origins: Origins) -> ConstraintRows:
    """Return the output rows of some readings.

    Parameters
    ----------
    mechanism
        Mechanism with its readings.
    names
        Names of the readings.
    origins
        Origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out.

    Returns
    -------
    ConstraintRows
        One row for each name.
    """
    return rows_of_readings(mechanism, [mechanism.reading(name) for name in names], origins)


def rows_of_readings(mechanism: Mechanism, readings: Sequence[Reading], origins: Origins) -> ConstraintRows:
    """Return the output rows of readings, which the mechanism need not list, as `make_output_rows` does."""
    table = np.zeros(len(readings), dtype=CONSTRAINT_ROW_DTYPE)
    for i, reading in enumerate(readings):
        kind, first, second, parameters = _output_row_data(reading)
        points = attachment_fields(mechanism, first, second, origins)
        table[i] = (kind, *points, *parameters, *(0.0,) * (N_ROW_PARAMETERS - len(parameters)), 1.0, NO_INDEX, 0, 0)
    return ConstraintRows(table, bodies_of_rows(table), np.zeros((0, 2)))

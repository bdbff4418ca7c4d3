"""Constraint rows as records, and the points of bodies that they join: their places at poses, and their paths."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from governor_mechanism.model.joints import Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.jit import record_dtype
from governor_mechanism.types import GROUND_INDEX, FloatArray, IntArray, RecordArray

CONSTRAINT_ROW_DTYPE = record_dtype(
    ("kind", "i8"),  # a RowKind
    ("first", "i8"),  # first body, or GROUND_INDEX
    ("second", "i8"),  # second body, or GROUND_INDEX
    ("x1", "f8"),  # point on the first body, in its axes, m
    ("y1", "f8"),
    ("x2", "f8"),  # point on the second body, in its axes, m
    ("y2", "f8"),
    ("constant", "f8"),  # what is subtracted, m; rad for LINE_ANGLE
    ("direction_x", "f8"),  # FIXED_DIRECTION: the direction
    ("direction_y", "f8"),
    ("first_angle_factor", "f8"),  # FIXED_DIRECTION: multiples of the angles of the bodies, m/rad
    ("second_angle_factor", "f8"),
    ("third", "i8"),  # FIXED_DIRECTION: a third body, whose angle counts too, or GROUND_INDEX
    ("third_angle_factor", "f8"),
    ("first_point_weight", "f8"),  # FIXED_DIRECTION: factor on the position of the first point
    ("angle", "f8"),  # BODY_NORMAL: angle of the line; ARC_POSITION, POLAR_CURVE: direction of zero, rad
    ("radius", "f8"),  # ARC_POSITION; CURVE_SLIP, PIECES_SLIP: of the roller, m; PROFILE_SLIP: inset of the profile, m
    ("rod_x", "f8"),  # FOLLOWER_HEIGHT: weighted other end of the rod, x from the guide of the follower, m
    ("rod_y", "f8"),
    ("rod_weight", "f8"),  # FOLLOWER_HEIGHT: weight of the second point
    ("link_length", "f8"),  # FOLLOWER_HEIGHT, m
    ("follower_sign", "f8"),  # FOLLOWER_HEIGHT
    ("drive_scale", "f8"),  # m per unit of the drive
    ("drive", "i8"),  # input that drives the row, or NO_INDEX
    ("first_segment", "i8"),  # BODY_NORMAL, POLAR_CURVE: first segment of the guide curve; of distances and slips: of the outline
    ("n_segments", "i8"),  # number of its segments; BODY_NORMAL: 0 for a straight line
    ("n_curve_segments", "i8"),  # PROFILE_DISTANCE, PROFILE_SLIP: number of the segments of the curve behind those of the outline
    # PIECES_DISTANCE, PIECES_SLIP: number of the points behind the segments of which the nearest one is the second point, or 0
    ("n_points", "i8"),
    ("bound_x", "f8"),  # with such points: circle around the outline, m
    ("bound_y", "f8"),
    ("bound_radius", "f8"),
    ("use", "i8"),  # of an output row, FOR_FORCES and FOR_EVENTS
    ("kept_feature", "i8"),  # distances and slips along lines and arcs: feature of the outline that is kept in a step, or NO_FEATURE
    ("kept_point", "i8"),  # with several points: row of the one that is kept in a step, or NO_POINT
)
"""One constraint row; fields of other kinds are zero, but for the weight of the first point, which is 1, and the use, which is any."""


ANY_USE = 0
FOR_FORCES = 1
FOR_EVENTS = 2
"""Uses of an output row: forces follow from it, which every evaluation needs, or event functions do; ANY_USE is for all rows."""

NO_POINT = 0
"""Row of a point where none is kept: points stand behind the segments of an outline."""


class RowColumn(IntEnum):
    """Column of the row values: prescribed value (m), rate (m/s) and acceleration (m/s2), residual (m), gamma (m/s2)."""

    DRIVE_VALUE = 0
    DRIVE_RATE = 1
    DRIVE_ACCELERATION = 2
    RESIDUAL = 3
    GAMMA = 4


N_ROW_COLUMNS = len(RowColumn)
"""Number of columns of the row values."""


class ConstraintRows(NamedTuple):
    """All constraint rows of a mechanism in few arrays, because each array costs time in every call."""

    table: RecordArray  # records of `CONSTRAINT_ROW_DTYPE`; shape (rows,)
    row_bodies: IntArray  # first, second and, if any row has one, third body of each row, as in `table`; shape (rows, sides)
    # polynomial segments of all guide curves: start (m; rad for closed ones), then coefficients, highest
    # power first; shape (segments, columns)
    curve_segments: FloatArray


Origins = Mapping[str, tuple[float, float]]
"""Origin of each body by name, in body axes (m); the mass centre if left out."""


def rotate_vector(angle: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """Return the components of the vector (x, y), floats or arrays, rotated by an angle (rad)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return cosine * x - sine * y, sine * x + cosine * y


def attachment_fields(mechanism: Mechanism, first: Point, second: Point, origins: Origins) -> dict[str, float]:
    """Return the fields of two points in a record: both bodies, and x and y (m) of each relative to its body's origin."""
    fields: dict[str, float] = {"first": mechanism.body_index(first.body), "second": mechanism.body_index(second.body)}
    for number, point in enumerate((first, second), start=1):
        x, y = origins.get(point.body, (0.0, 0.0))
        fields |= {f"x{number}": point.x - x, f"y{number}": point.y - y}
    return fields


def point_path(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Return the path (n, 2), m, of a point at poses (n, bodies, 3)."""
    index = mechanism.body_index(point.body)
    pose = poses[:, index] if index != GROUND_INDEX else np.zeros((len(poses), 3))
    path: FloatArray = pose[:, :2] + np.stack(rotate_vector(pose[:, 2], point.x, point.y), axis=-1)
    return path


def point_paths(mechanism: Mechanism, poses: FloatArray) -> dict[str, FloatArray]:
    """Return the path (n, 2), m, of each point that has a name, a moving pin or a mass centre, at poses (n, bodies, 3)."""
    return {name: point_path(mechanism, poses, point) for name, point in mechanism.path_points.items()}

"""Output variables as constraint rows, from which they are evaluated, along which forces act and which contacts hold.

An output row is a constraint row whose residual is the value of the output variable, in m or rad.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.curves.outline_kernels import N_CURVE_SAMPLES
from governor_mechanism.mechanics.curves.outlines import chains_of, make_curve_pieces, make_pieces, make_profile_pieces
from governor_mechanism.mechanics.curves.segments import concatenate_segments
from governor_mechanism.mechanics.kinematics.constraint_equations import bodies_of_rows, make_row_table, set_fields
from governor_mechanism.mechanics.kinematics.constraint_kernels import ConstraintRows
from governor_mechanism.mechanics.kinematics.points import Origins, attachment_fields
from governor_mechanism.model.curves import CornerOutline, CurveOutline
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.joints.base import RowKind
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import (
    ArcPosition,
    BodyAngle,
    FollowerHeight,
    LineAngle,
    OutlineGap,
    PointCoordinate,
    PointDistance,
    Reading,
)
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class OutputRow:
    """Kind, points and parameters of an output row; the parameters are fields of `CONSTRAINT_ROW_DTYPE`."""

    kind: RowKind
    first: Point
    second: Point
    parameters: Mapping[str, float] = field(default_factory=dict)
    segments: FloatArray | None = None  # those of an outline


def _output_row(reading: Reading) -> OutputRow:
    """Return the output row of a reading."""
    match reading:
        case LineAngle():
            return OutputRow(RowKind.LINE_ANGLE, reading.start, reading.end, {"constant": reading.zero})
        case BodyAngle():
            factors = {"first_angle_factor": -1.0, "second_angle_factor": 1.0}
            return OutputRow(RowKind.FIXED_DIRECTION, Point(body=reading.reference_body), Point(body=reading.body), factors)
        case PointDistance():
            return OutputRow(RowKind.DISTANCE, reading.first, reading.second)
        case PointCoordinate():
            return _point_coordinate_row(reading)
        case ArcPosition():
            arc = {"angle": reading.angle, "radius": reading.radius, "constant": reading.zero}
            return OutputRow(RowKind.ARC_POSITION, reading.centre, reading.point, arc)
        case FollowerHeight():
            return _follower_height_row(reading)
        case OutlineGap():
            return _outline_gap_row(reading)
    raise TypeError(f"no output row is defined for readings of type {type(reading).__name__}")


def _point_coordinate_row(reading: PointCoordinate) -> OutputRow:
    if reading.origin.body == GROUND:
        direction = {"direction_x": reading.direction_x, "direction_y": reading.direction_y}
        return OutputRow(RowKind.FIXED_DIRECTION, reading.origin, reading.point, {**direction, "constant": reading.zero})
    length = math.hypot(reading.direction_x, reading.direction_y)
    if not math.isclose(length, 1.0, rel_tol=1e-12):
        raise MechanismError(f"reading {reading.name!r} has a direction, relative to a body, of length {length:g}; give a unit vector")
    angle = math.atan2(-reading.direction_x, reading.direction_y)
    return OutputRow(RowKind.BODY_NORMAL, reading.origin, reading.point, {"angle": angle, "constant": reading.zero})


def _follower_height_row(reading: FollowerHeight) -> OutputRow:
    if reading.top.body != GROUND:
        raise MechanismError(
            f"reading {reading.name!r} has a follower that hangs from a rod whose top is on body {reading.top.body!r}; "
            "the top must be on the ground"
        )
    complement, reference_point = 1.0 - reading.fraction, reading.reference_point
    parameters = {
        "rod_x": complement * reading.top.x - reading.guide_x,
        "rod_y": complement * reading.top.y,
        "rod_weight": reading.fraction,
        "link_length": reading.length,
        "constant": reading.zero,
        "follower_sign": 1.0 if reference_point is None else -1.0,
    }
    base_point = Point(body=GROUND) if reference_point is None else reference_point
    return OutputRow(RowKind.FOLLOWER_HEIGHT, base_point, reading.knee, parameters)


def _outline_gap_row(reading: OutlineGap) -> OutputRow:
    """Return the row of the distance of a roller from an outline; a curve is followed by its points, which are no segments."""
    outline, profile = reading.outline, reading.profile
    if isinstance(outline, CornerOutline) and profile is not None:
        pieces, curve = make_profile_pieces(outline, reading.chain), make_curve_pieces(profile)
        n_curve_segments = len(curve) - N_CURVE_SAMPLES
        parameters = {"constant": -profile.inset, "n_segments": len(pieces), "n_curve_segments": n_curve_segments}
        return OutputRow(RowKind.PROFILE_DISTANCE, reading.origin, reading.roller, parameters, concatenate_segments([pieces, curve]))
    if isinstance(outline, CornerOutline):
        pieces = make_pieces(chains_of(outline)[reading.chain])
        parameters = {"constant": reading.radius, "n_segments": len(pieces)}
        return OutputRow(RowKind.PIECES_DISTANCE, reading.origin, reading.roller, parameters, pieces)
    if isinstance(outline, CurveOutline):
        pieces = make_curve_pieces(outline)
        parameters = {"constant": reading.radius - outline.inset, "n_segments": len(pieces) - N_CURVE_SAMPLES}
        return OutputRow(RowKind.CURVE_DISTANCE, reading.origin, reading.roller, parameters, pieces)
    raise TypeError(f"no distance is defined from outlines of type {type(outline).__name__}")


def make_output_rows(
    mechanism: Mechanism,
    names: Sequence[str],
    # origin of each body by name, in body axes (m), to which the poses refer; the mass centre if left out
    origins: Origins,
) -> ConstraintRows:
    """Return the output rows of some readings."""
    return rows_of_readings(mechanism, [mechanism.reading(name) for name in names], origins)


def rows_of_readings(mechanism: Mechanism, readings: Sequence[Reading], origins: Origins) -> ConstraintRows:
    """Return the output rows of readings, which the mechanism need not list, as `make_output_rows` does."""
    table, parts, n_segments = make_row_table(len(readings)), [np.zeros((0, 2))], 0
    for record, reading in zip(table, readings, strict=True):
        row = _output_row(reading)
        set_fields(record, attachment_fields(mechanism, row.first, row.second, origins))
        set_fields(record, row.parameters)
        record["kind"] = row.kind
        if row.segments is not None:
            record["first_segment"] = n_segments
            parts.append(row.segments)
            n_segments += len(row.segments)
    return ConstraintRows(table, bodies_of_rows(table), concatenate_segments(parts))

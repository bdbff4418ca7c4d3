"""Constraint equations of joints, as rows of a few kinds."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from governor_mechanism.model.curves import Curve
from governor_mechanism.model.time_functions import PrescribedMotion


class RowKind(IntEnum):
    """Kind of a constraint row; d is the vector from the point of the first body to that of the second.

    DISTANCE: |d|. FIXED_DIRECTION: the component of d along a direction fixed in the plane, plus multiples of both body
    angles and of the angle of a third body. BODY_NORMAL: the component of d normal to a line of the first body, or the
    distance from a curve on that line. POLAR_CURVE: |d| less the radius of a closed curve of the first body in that
    direction. LINE_ANGLE: the angle of d from the downward vertical (rad). FOLLOWER_HEIGHT: the height of a follower that
    hangs by a link from a rod through the second point, plus the height of the first point. ARC_POSITION: the angle of d in
    the axes of the first body, times a radius. LINE_ANGLE, FOLLOWER_HEIGHT and ARC_POSITION serve as outputs only. Of each
    the constant of the row is subtracted.
    """

    DISTANCE = 0
    FIXED_DIRECTION = 1
    BODY_NORMAL = 2
    LINE_ANGLE = 3
    FOLLOWER_HEIGHT = 4
    ARC_POSITION = 5
    POLAR_CURVE = 6


@dataclass(frozen=True)
class ConstraintRow:
    """One constraint equation of a joint.

    `parameters` are the fields of `CONSTRAINT_ROW_DTYPE` that its kind has. `motion` drives the row, in units of `drive_scale` (m per
    unit of the motion). `curve` is the guide curve of a curve slot. `third` is the name of a third body, or the ground, whose angle
    the row contains.
    """

    kind: RowKind
    parameters: Mapping[str, float]
    motion: PrescribedMotion | None = None
    drive_scale: float = 1.0
    curve: Curve | None = None
    third: str | None = None


def coincidence_rows() -> list[ConstraintRow]:
    """Return the rows that make two points coincide."""
    return [ConstraintRow(RowKind.FIXED_DIRECTION, {name: 1.0}) for name in ("direction_x", "direction_y")]


def direction(angle: float) -> dict[str, float]:
    """Return the unit vector at an angle (rad) as fields of a row."""
    return {"direction_x": math.cos(angle), "direction_y": math.sin(angle)}


def relative_angle_row(angle: float, length_scale: float, motion: PrescribedMotion | None = None) -> ConstraintRow:
    """Return the row that keeps the angle (rad) of the second body relative to the first, or drives it by a motion."""
    factors = {"first_angle_factor": -length_scale, "second_angle_factor": length_scale}
    return ConstraintRow(RowKind.FIXED_DIRECTION, {**factors, "constant": length_scale * angle}, motion, length_scale)

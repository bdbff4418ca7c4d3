"""Values, gradients and velocity terms of readings: constraint rows whose residual (m, rad) is the value, for forces and contacts."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.curves.outline_kernels import N_CURVE_SAMPLES
from governor_mechanism.mechanics.curves.outlines import bounding_circle, chains_of, make_curve_pieces, make_pieces
from governor_mechanism.mechanics.curves.segments import concatenate_segments
from governor_mechanism.mechanics.kinematics.constraint_equations import (
    RowEvaluation,
    bodies_of_rows,
    evaluate_row_motions,
    make_row_table,
    set_fields,
)
from governor_mechanism.mechanics.kinematics.constraint_rows import ConstraintRows, Origins, attachment_fields
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
    OutlineSlip,
    PointCoordinate,
    PointDistance,
    Reading,
)
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class OutputRow:
    """Kind, points and parameters of an output row; the parameters are fields of `CONSTRAINT_ROW_DTYPE`."""

    kind: RowKind
    first: Point
    second: Point
    parameters: Mapping[str, float] = field(default_factory=dict)
    segments: FloatArray | None = None  # those of an outline
    others: tuple[Point, ...] = ()  # further second points, of which the nearest to the outline counts


def _row_of_reading(reading: Reading) -> OutputRow:
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
        case OutlineSlip():
            return _outline_slip_row(reading)
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
        pieces, curve = make_pieces(outline, reading.chain), make_curve_pieces(profile)
        n_curve_segments = len(curve) - N_CURVE_SAMPLES
        parameters = {"constant": -profile.inset, "n_segments": len(pieces), "n_curve_segments": n_curve_segments}
        return OutputRow(RowKind.PROFILE_DISTANCE, reading.origin, reading.roller, parameters, concatenate_segments([pieces, curve]))
    if isinstance(outline, CornerOutline):
        chain = chains_of(outline)[reading.chain]
        pieces = make_pieces(outline, reading.chain)
        parameters = {"constant": reading.radius, "n_segments": len(pieces)}
        if reading.others:
            bound = dict(zip(("bound_x", "bound_y", "bound_radius"), bounding_circle(chain), strict=True))
            parameters |= {"n_points": 1 + len(reading.others), **bound}
        return OutputRow(RowKind.PIECES_DISTANCE, reading.origin, reading.roller, parameters, pieces, reading.others)
    if isinstance(outline, CurveOutline):
        pieces = make_curve_pieces(outline)
        parameters = {"constant": reading.radius - outline.inset, "n_segments": len(pieces) - N_CURVE_SAMPLES}
        return OutputRow(RowKind.CURVE_DISTANCE, reading.origin, reading.roller, parameters, pieces)
    raise TypeError(f"no distance is defined from outlines of type {type(outline).__name__}")


SLIP_KINDS = {
    RowKind.CURVE_DISTANCE: RowKind.CURVE_SLIP,
    RowKind.PIECES_DISTANCE: RowKind.PIECES_SLIP,
    RowKind.PROFILE_DISTANCE: RowKind.PROFILE_SLIP,
}
"""Kind of the row of the slip by that of the distance."""


def _outline_slip_row(reading: OutlineSlip) -> OutputRow:
    """Return the row of the sliding of a roller, or of a curve, along an outline."""
    row, gap = _outline_gap_row(reading.gap), reading.gap
    radius = gap.radius if gap.profile is None else gap.profile.inset
    return replace(row, kind=SLIP_KINDS[row.kind], parameters={**row.parameters, "constant": 0.0, "radius": radius})


def _points_of(mechanism: Mechanism, row: OutputRow, origins: Origins) -> list[FloatArray]:
    """Return all second points of a row with several, in the axes of their body, as rows behind its segments."""
    if not row.others or row.segments is None:
        return []
    points = np.zeros((1 + len(row.others), row.segments.shape[1]))
    for values, point in zip(points, (row.second, *row.others), strict=True):
        fields = attachment_fields(mechanism, row.first, point, origins)
        values[-2:] = fields["x2"], fields["y2"]
    return [points]


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
    table = make_row_table(len(readings))
    parts = list[FloatArray]()
    n_segments = 0
    for record, reading in zip(table, readings, strict=True):
        row = _row_of_reading(reading)
        set_fields(record, attachment_fields(mechanism, row.first, row.second, origins))
        set_fields(record, row.parameters)
        record["kind"] = row.kind
        if row.segments is not None:
            record["first_segment"] = n_segments
            parts += [row.segments, *_points_of(mechanism, row, origins)]
            n_segments += sum(map(len, parts)) - n_segments
    return ConstraintRows(table, bodies_of_rows(table), concatenate_segments(parts))


READING_UNITS = {"angle": "rad", "length": "m", "ratio": "1"}
"""Unit of a reading by its quantity."""


class OutputDerivatives:
    """An output variable and its derivatives at poses (..., bodies, 3).

    Parameters
    ----------
    row
        Output row of the variable, for poses of the mass centres.
    poses
        Poses; shape (..., bodies, 3).
    velocities
        Velocities; same shape. Default: zero.
    """

    def __init__(self, row: ConstraintRows, poses: FloatArray, velocities: FloatArray | None = None) -> None:
        self._row = RowEvaluation(row, poses, velocities)

    @property
    def row(self) -> RowEvaluation:
        """Its row."""
        return self._row

    @property
    def value(self) -> FloatArray:
        """Value in SI; shape (...)."""
        return self._row.residuals[..., 0]

    @property
    def gradient(self) -> FloatArray:
        """Derivatives by the poses, in SI per m and per rad; shape (..., bodies, 3)."""
        return self._row.jacobian[..., 0, :, :]

    @property
    def quadratic_velocity_term(self) -> FloatArray:
        """Second time derivative minus gradient times accelerations, SI/s2; shape (...)."""
        return -self._row.gamma[..., 0]

    def rate(self, velocities: FloatArray) -> FloatArray:
        """Return the rate (...) in SI/s at velocities (..., bodies, 3)."""
        rate: FloatArray = np.sum(self.gradient * velocities, axis=(-2, -1))
        return rate

    def acceleration(self, accelerations: FloatArray) -> FloatArray:
        """Return the second time derivative (...) in SI/s2 at the velocities of the evaluation and accelerations (..., bodies, 3)."""
        return self.rate(accelerations) + self.quadratic_velocity_term


def evaluate_output(
    mechanism: Mechanism,
    name: str,
    poses: FloatArray,  # poses; shape (..., bodies, 3)
    velocities: FloatArray | None = None,  # velocities; same shape. Default: zero
) -> OutputDerivatives:
    """Return value, gradient and quadratic velocity term of a reading."""
    return OutputDerivatives(_output_row(mechanism, name), poses, velocities)


def evaluate_readings(
    mechanism: Mechanism,
    poses: FloatArray,  # poses; shape (n, bodies, 3)
    velocities: FloatArray,  # velocities; same shape
) -> tuple[FloatArray, FloatArray]:
    """Return values and rates (readings, n), SI, of all readings of a mechanism; angles of lines lie within half a turn."""
    return evaluate_row_motions(_select_rows(mechanism, slice(len(mechanism.readings))), poses, velocities)


def evaluate_reading_motions(
    mechanism: Mechanism,
    poses: FloatArray,  # poses; shape (n, bodies, 3)
    velocities: FloatArray,  # their derivatives by time, or by a coordinate; same shape
    accelerations: FloatArray,  # their second derivatives; same shape
) -> dict[str, tuple[FloatArray, FloatArray, FloatArray]]:
    """Return all readings (n,), SI, with their first two derivatives, by name; angles of lines lie within half a turn."""
    rows = RowEvaluation(_select_rows(mechanism, slice(len(mechanism.readings))), poses, velocities)
    values = rows.residuals
    rates = rows.derivatives_along(velocities)
    second = rows.derivatives_along(accelerations) - rows.gamma
    return {reading.name: (values[:, k], rates[:, k], second[:, k]) for k, reading in enumerate(mechanism.readings)}


def evaluate_limited_readings(mechanism: Mechanism, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Evaluate the readings that the limits of a mechanism bound, in their order, and their rates, as `evaluate_readings` does."""
    indices = [mechanism.reading_index(limit.reading) for limit in mechanism.limits]
    return evaluate_row_motions(_select_rows(mechanism, indices), poses, velocities)


@once_per_object
def _output_rows(mechanism: Mechanism) -> ConstraintRows:
    """Return the output rows of all readings, in their order."""
    return rows_of_readings(mechanism, mechanism.all_readings, {})


def _select_rows(mechanism: Mechanism, selected: slice | list[int]) -> ConstraintRows:
    rows = _output_rows(mechanism)
    return rows._replace(table=rows.table[selected], row_bodies=rows.row_bodies[selected])


@once_per_object
def _known_output_rows(_: Mechanism) -> dict[str, ConstraintRows]:
    """Return the output rows of single readings that were asked for, by name."""
    return {}


def _output_row(mechanism: Mechanism, name: str) -> ConstraintRows:
    """Return the output row of a reading. Raise MechanismError if there is no reading of that name."""
    known = _known_output_rows(mechanism)
    if name not in known:
        index = mechanism.reading_index(name)
        known[name] = _select_rows(mechanism, slice(index, index + 1))
    return known[name]


def evaluate_output_value(
    mechanism: Mechanism,
    name: str,
    poses: FloatArray,  # poses; shape (..., bodies, 3)
) -> FloatArray:
    """Return the value (...) of a reading, SI."""
    return evaluate_output(mechanism, name, poses).value


def wrap_difference(reading: Reading, difference: float) -> float:
    """Return a difference of two values of a reading; that of the angle of a line within half a turn."""
    return math.remainder(difference, math.tau) if isinstance(reading, LineAngle) else difference


def unwrap_output(reading: Reading, values: FloatArray) -> FloatArray:
    """Return the values (..., n) of a reading along motions, continuous over full turns."""
    is_continuous = not isinstance(reading, LineAngle) or bool((np.abs(values[..., 1:] - values[..., :-1]) < np.pi).all())
    return values if is_continuous else np.unwrap(values)  # the angle of a body is continuous already

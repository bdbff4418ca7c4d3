"""Readings as rows of the compiled equations, so that loads can act along them and joints hold them.

A gauge is the row whose opening is the reading's value: m, or rad.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import singledispatch

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_equations import ends_of
from governor_mechanism.mechanics.kinematics.constraint_kernels import (
    ACROSS,
    ALONG,
    DISTANCE,
    HANGING,
    LEAN,
    PARAMETERS,
    ROW,
    Rows,
)
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import (
    BodyAngle,
    Coordinate,
    FollowerHeight,
    LineAngle,
    Mechanism,
    Reading,
    Separation,
)
from governor_mechanism.types import RecordArray

Row = tuple[int, Point, Point, tuple[float, ...]]
"""Kind, points and parameters."""

CONSTANT = {DISTANCE: "p0", ALONG: "p4", ACROSS: "p4", LEAN: "p4", HANGING: "p4"}
"""Which parameter of each kind is taken off its opening."""


@singledispatch
def _row(reading: Reading) -> Row:
    raise TypeError(f"no row is written for readings of type {type(reading).__name__}")


@_row.register
def _(reading: LineAngle) -> Row:
    return LEAN, reading.start, reading.end, (0.0, 0.0, 0.0, 0.0, reading.zero)


@_row.register
def _(reading: BodyAngle) -> Row:
    return ALONG, Point(body=reading.against), Point(body=reading.body), (0.0, 0.0, -1.0, 1.0)


@_row.register
def _(reading: Separation) -> Row:
    return DISTANCE, reading.first, reading.second, (0.0,)


@_row.register
def _(reading: Coordinate) -> Row:
    if reading.origin.body == GROUND:
        direction = reading.along_x, reading.along_y
        return ALONG, reading.origin, reading.point, (*direction, 0.0, 0.0, reading.zero)
    if not math.isclose(math.hypot(reading.along_x, reading.along_y), 1.0, rel_tol=1e-12):
        raise MechanismError(f"nothing can act along {reading.name!r}: its direction is not of unit length")
    angle = math.atan2(-reading.along_x, reading.along_y)
    return ACROSS, reading.origin, reading.point, (angle, 0.0, 0.0, 0.0, reading.zero)


@_row.register
def _(reading: FollowerHeight) -> Row:
    if reading.top.body != GROUND:
        raise MechanismError(f"nothing can act along {reading.name!r}: the rod it hangs from has no fixed end")
    rest = 1.0 - reading.fraction
    place = rest * reading.top.x - reading.line, rest * reading.top.y
    against = reading.against
    sign = 1.0 if against is None else -1.0
    below = Point(body=GROUND) if against is None else against
    return HANGING, below, reading.knee, (*place, reading.fraction, reading.length, reading.zero, sign)


def gauge_table(mechanism: Mechanism, names: Sequence[str], origins: Mapping[str, tuple[float, float]]) -> Rows:
    """The gauges of readings by name, bodies counted from `origins` (body axes, m)."""

    def anchor(point: Point) -> tuple[float, float]:
        x, y = origins.get(point.body, (0.0, 0.0))
        return point.x - x, point.y - y

    table = np.zeros(len(names), dtype=ROW)
    for at, name in enumerate(names):
        kind, first, second, given = _row(mechanism.reading(name))
        ends = [mechanism.body_index(point.body) for point in (first, second)]
        parameter = given + (0.0,) * (PARAMETERS - len(given))
        table[at] = (kind, *ends, *anchor(first), *anchor(second), *parameter, 1.0, -1, 0, 0)
    return Rows(table, ends_of(table), np.zeros((0, 5)))


def held_at(gauges: RecordArray, which: Sequence[int], values: Sequence[float]) -> RecordArray:
    """Rows (held,) that hold some gauges at values (m or rad)."""
    rows = gauges[list(which)].copy()
    for at, value in enumerate(values):
        rows[at][CONSTANT[int(rows[at]["kind"])]] += value
    return rows

"""[readings] of a custom machine."""

import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any, Final

from governor_mechanism.machines.custom import SketchedBody
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.scenes.custom.field_types import CUSTOM_TYPES, make_unique_name
from governor_mechanism.scenes.table import Table
from governor_mechanism.units.fields import declare
from governor_mechanism.units.problems import ProblemCode, mistake

_X_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=1.0, direction_y=0.0)
_Y_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=0.0, direction_y=1.0)


def _read_angle(*, name: str, angle: str, against: str = GROUND) -> Reading:
    if angle in (against, GROUND):
        raise mistake(ProblemCode.CONFLICT, "angle must name a moving body, and against another body or the ground")
    return BodyAngle(name=name, quantity="angle", body=angle, reference_body=against)


def _read_line(*, name: str, line: list[Point]) -> Reading:
    start, end = _require_different("line", line)
    # LineAngle counts from the downward vertical.
    return LineAngle(name=name, quantity="angle", start=start, end=end, zero=math.pi / 2)


def _read_distance(*, name: str, distance: list[Point]) -> Reading:
    first, second = _require_different("distance", distance)
    return PointDistance(name=name, quantity="length", first=first, second=second)


def _require_different(key: str, points: list[Point]) -> list[Point]:
    if points[0] == points[1]:
        raise mistake(ProblemCode.CONFLICT, f"{key} needs two different points")
    return points


def _coordinate_table(axis: str, make: Callable[..., Any]) -> Table:
    """Return the table of a coordinate of a point, relative to another one."""
    origin = declare(
        "point", key="from", default=Point(body=GROUND), meaning="the point from which it is measured, along the axes of its body"
    )
    point = declare("point", key=axis, meaning=f"the point whose coordinate {axis} it is")
    summary = f"Coordinate {axis} of a point, relative to another one."
    return Table(make=make, fields={"origin": origin, "point": point}, types=CUSTOM_TYPES, summary=summary)


READING_TABLES: Final[Mapping[str, Table]] = {
    "angle": Table(
        make=_read_angle,
        fields={
            "angle": declare("body", meaning='the body whose angle it is, as "crank"'),
            "against": declare("body", default=GROUND, meaning="the body from which the angle is measured"),
        },
        types=CUSTOM_TYPES,
        summary="Angle of a body against another one.",
    ),
    "line": Table(
        make=_read_line,
        fields={"line": declare("two points", meaning="the two points of the line")},
        types=CUSTOM_TYPES,
        summary="Angle of a line from x, counterclockwise.",
    ),
    "x": _coordinate_table("x", _X_COORDINATE),
    "y": _coordinate_table("y", _Y_COORDINATE),
    "distance": Table(
        make=_read_distance,
        fields={"distance": declare("two points", meaning="the two points")},
        types=CUSTOM_TYPES,
        summary="Distance of two points.",
    ),
}
"""Tables of readings by the key that determines the kind of reading; each has one of them."""


def find_reading_kind(values: object) -> str:
    """Return the key that determines the kind, or the kind nearest to a key; "" if there is not exactly one."""
    keys = [key for key in values if isinstance(key, str)] if isinstance(values, Mapping) else []
    kinds = [key for key in keys if key in READING_TABLES]
    kinds = kinds or [kind for key in keys for kind in difflib.get_close_matches(key, list(READING_TABLES), n=1)]
    return kinds[0] if len(kinds) == 1 else ""


def make_default_readings(bodies: Iterable[SketchedBody]) -> list[Reading]:
    """Return the readings of a mechanism without [readings]: the angle of each rotating body, the position of each other one."""
    readings: list[Reading] = []
    for body in bodies:
        base_name = re.sub(r"\W+", "_", body.name).strip("_") or "body"
        base_name = base_name if base_name.isidentifier() else f"body_{base_name}"
        name = make_unique_name(base_name, {reading.name.rpartition("_")[0] for reading in readings}, "_")
        if body.can_rotate:
            readings.append(BodyAngle(name=f"{name}_angle", quantity="angle", body=body.name))
        else:
            coordinates = {"x": _X_COORDINATE, "y": _Y_COORDINATE}
            readings += [make(name=f"{name}_{axis}", point=Point(body=body.name)) for axis, make in coordinates.items()]
    return readings

"""[readings] of a custom machine. Slow to import: pydantic."""

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

from pydantic import Field

from governor_mechanism.machines.custom import SketchedBody
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.scenes.custom.field_types import BodyRef, PointRef, TwoPointRefs, make_unique_name
from governor_mechanism.scenes.problems import ProblemCode, mistake
from governor_mechanism.scenes.table import SceneFileTable, SceneFileTables

_X_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=1.0, direction_y=0.0)
_Y_COORDINATE = partial(PointCoordinate, quantity="length", direction_x=0.0, direction_y=1.0)


class AngleTable(SceneFileTable):
    """Angle of a body against another one."""

    angle: BodyRef = Field(..., description='the body whose angle it is, as "crank"')
    against: BodyRef = Field(GROUND, description="the body from which the angle is measured")

    def make_element(self, **arguments: Any) -> Reading:
        """Return the reading."""
        if self.angle in (self.against, GROUND):
            raise mistake(ProblemCode.CONFLICT, "angle must name a moving body, and against another body or the ground")
        return BodyAngle(quantity="angle", body=self.angle, reference_body=self.against, **arguments)


class LineTable(SceneFileTable):
    """Angle of a line from x, counterclockwise."""

    line: TwoPointRefs = Field(..., description="the two points of the line")

    def make_element(self, **arguments: Any) -> Reading:
        """Return the reading."""
        start, end = _require_different("line", self.line)
        # LineAngle counts from the downward vertical.
        return LineAngle(quantity="angle", start=start, end=end, zero=math.pi / 2, **arguments)


class DistanceTable(SceneFileTable):
    """Distance of two points."""

    distance: TwoPointRefs = Field(..., description="the two points")

    def make_element(self, **arguments: Any) -> Reading:
        """Return the reading."""
        first, second = _require_different("distance", self.distance)
        return PointDistance(quantity="length", first=first, second=second, **arguments)


def _require_different(key: str, points: list[Point]) -> list[Point]:
    if points[0] == points[1]:
        raise mistake(ProblemCode.CONFLICT, f"{key} needs two different points")
    return points


class XTable(SceneFileTable):
    """Coordinate x of a point, relative to another one."""

    element = _X_COORDINATE
    origin: PointRef = Field(
        Point(body=GROUND), alias="from", description="the point from which it is measured, along the axes of its body"
    )
    point: PointRef = Field(alias="x", description="the point whose coordinate x it is")


class YTable(XTable):
    """Coordinate y of a point, relative to another one."""

    element = _Y_COORDINATE
    point: PointRef = Field(alias="y", description="the point whose coordinate y it is")


READING_TABLES: SceneFileTables = {"angle": AngleTable, "line": LineTable, "x": XTable, "y": YTable, "distance": DistanceTable}
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

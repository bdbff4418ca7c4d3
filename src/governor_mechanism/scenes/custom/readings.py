"""[readings] of a custom machine. Slow to import: pydantic."""

import difflib
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from pydantic import Field, TypeAdapter

from governor_mechanism.machines.custom import SketchedBody
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.scenes.custom.field_types import BodyRef, PointRef, TwoPointRefs, make_unique_name
from governor_mechanism.scenes.problems import ProblemCode, mistake
from governor_mechanism.scenes.table import SceneFileTable, union_by_key

READING_KINDS: Final = ("angle", "line", "x", "y", "distance")
"""Keys of [readings.name]; each kind of reading has one of them."""


class ReadingTable(SceneFileTable):
    """[readings.name] of any kind."""

    def build(self, name: str) -> Reading:
        """Return the reading."""
        raise NotImplementedError


class AngleReadingTable(ReadingTable):
    """Angle of a body against another one."""

    angle: BodyRef
    against: BodyRef = GROUND

    def build(self, name: str) -> Reading:
        """Return the reading."""
        if self.angle in (self.against, GROUND):
            raise mistake(ProblemCode.CONFLICT, "angle must name a moving body, and against another body or the ground")
        return BodyAngle(name=name, quantity="angle", body=self.angle, reference_body=self.against)


class LineReadingTable(ReadingTable):
    """Angle of a line from x, counterclockwise."""

    line: TwoPointRefs

    def build(self, name: str) -> Reading:
        """Return the reading."""
        start, end = _require_different("line", self.line)
        # LineAngle counts from the downward vertical.
        return LineAngle(name=name, quantity="angle", start=start, end=end, zero=math.pi / 2)


class DistanceReadingTable(ReadingTable):
    """Distance of two points."""

    distance: TwoPointRefs

    def build(self, name: str) -> Reading:
        """Return the reading."""
        first, second = _require_different("distance", self.distance)
        return PointDistance(name=name, quantity="length", first=first, second=second)


def _require_different(key: str, points: list[Point]) -> list[Point]:
    if points[0] == points[1]:
        raise mistake(ProblemCode.CONFLICT, f"{key} needs two different points")
    return points


class _CoordinateReadingTable(ReadingTable):
    """Coordinate of a point, relative to another one."""

    origin: PointRef | None = Field(None, alias="from")

    def build(self, name: str) -> Reading:
        """Return the reading."""
        axis = "x" if "x" in type(self).model_fields else "y"
        return _point_coordinate(name, getattr(self, axis), axis, self.origin or Point(body=GROUND))


class XReadingTable(_CoordinateReadingTable):
    """Coordinate x of a point."""

    x: PointRef


class YReadingTable(_CoordinateReadingTable):
    """Coordinate y of a point."""

    y: PointRef


def find_reading_kind(values: Any, known_kinds: Sequence[str] = READING_KINDS) -> str:
    """Return the key that determines the kind, or the kind nearest to a key; "" if there is not exactly one."""
    keys = [key for key in values if isinstance(key, str)] if isinstance(values, Mapping) else []
    kinds = [key for key in keys if key in known_kinds]
    kinds = kinds or [kind for key in keys for kind in difflib.get_close_matches(key, known_kinds, n=1)]
    return kinds[0] if len(kinds) == 1 else ""


_READING_TABLES = (AngleReadingTable, LineReadingTable, XReadingTable, YReadingTable, DistanceReadingTable)
READING: Final[TypeAdapter[ReadingTable]] = union_by_key(dict(zip(READING_KINDS, _READING_TABLES, strict=True)), find_reading_kind)
"""[readings.name] of any kind."""


def _point_coordinate(name: str, point: Point, axis: str, origin: Point) -> PointCoordinate:
    x, y = (1.0, 0.0) if axis == "x" else (0.0, 1.0)
    return PointCoordinate(name=name, quantity="length", point=point, direction_x=x, direction_y=y, origin=origin)


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
            readings += [_point_coordinate(f"{name}_{axis}", Point(body=body.name), axis, Point(body=GROUND)) for axis in ("x", "y")]
    return readings

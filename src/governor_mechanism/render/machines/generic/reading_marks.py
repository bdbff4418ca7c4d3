"""Marks of readings that are named by a letter, as in a figure of a textbook: arcs at their angles, and points with their coordinates."""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Moment
from governor_mechanism.render.geometry.points import arc_points, axes_to_plane
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, PoseTuple, Vec2
from governor_mechanism.render.geometry.stroke_letters import is_drawn_letter, make_letters
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents, PlacedMechanism

_ARC_RADIUS, _RADIUS_STEP, _RAY_EXTENSION, _LETTER_DISTANCE, _LETTER_HEIGHT = 0.085, 0.075, 0.03, 0.042, 0.055
"""Radius of the first arc at a hinge and its increase to the next, lengths beyond it, and height of a letter, as fractions of the scale."""
_LETTERS_ASIDE, _LETTERS_ABOVE = 0.15, 0.10
"""Distance of the middle of the letters of coordinates from their point, beside it and above it, as fractions of the length scale."""
_NEAR = 0.12
"""Distance between hinges below which their arcs get different radii, as a fraction of the length scale."""


class _Arc(NamedTuple):
    """Arc of an angle: the hinge (m), the radius (m), and the directions of both axes (rad)."""

    hinge: Vec2
    radius: float
    start: float
    end: float


def reading_mark_parts(extents: MechanismExtents) -> Iterator[DrawnPart]:
    """Yield an arc with its letter between the axes of two bodies at their hinge, and the letters of the coordinates of a point."""
    for number, reading in enumerate(_marked_angles(extents)):
        yield extents.flex(partial(_angle_shapes, number), section_only=True)
        letter = make_letters("letter", (reading.name,), (0.0, 0.0), _LETTER_HEIGHT * extents.length_scale)
        yield Attached(frame=partial(_letter_axes, extents, number), shapes=(letter,), section_only=True)
    yield from _coordinate_parts(extents)


def _marked_angles(extents: MechanismExtents) -> list[BodyAngle]:
    """Return the angles that are named by a letter."""
    readings = extents.part.mechanism.readings
    return [reading for reading in readings if isinstance(reading, BodyAngle) and is_drawn_letter(reading.name)]


@once_per_object
def _marked_arcs(placed: PlacedMechanism) -> Sequence[_Arc]:
    """Return the arcs of all marked angles. An angle of several turns shows as the rest of the last one."""
    u, arcs = placed.unit, list[_Arc]()
    # Clear of the arrows of torques.
    torques = (load for load in placed.mechanism.force_elements if isinstance(load, Torque))
    earlier: list[Vec2] = [placed.hinge_position(load.first, load.second) for load in torques]
    for reading in _marked_angles(placed.extents):
        hinge = placed.hinge_position(reading.reference_body, reading.body)
        n_near = sum(math.dist(hinge, other) < _NEAR * u for other in earlier)
        earlier.append(hinge)
        start, end = placed.pose(reading.reference_body)[2], placed.pose(reading.body)[2]
        arcs.append(_Arc(hinge, (_ARC_RADIUS + n_near * _RADIUS_STEP) * u, start, end))
    return arcs


def _angle_shapes(number: int, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return the two axes of an angle, and its arc."""
    hinge, radius, start, end = _marked_arcs(placed)[number]
    rays = (axes_to_plane((*hinge, one), radius + _RAY_EXTENSION * placed.unit, 0.0) for one in (start, end))
    arc = arc_points(hinge, start, math.remainder(end - start, 2 * math.pi), radius, 24)
    return [Lines("angle ray", tuple((hinge, ray) for ray in rays)), Lines("angle arc", (arc,))]


def _letter_axes(extents: MechanismExtents, number: int, moment: Moment) -> PoseTuple:
    """Return the axes of the letter of an angle, beside the middle of its arc."""
    hinge, radius, start, end = _marked_arcs(extents.placed_at(moment))[number]
    heading = start + 0.5 * math.remainder(end - start, 2 * math.pi)
    return *axes_to_plane((*hinge, heading), radius + _LETTER_DISTANCE * extents.length_scale, 0.0), 0.0


def _coordinate_parts(extents: MechanismExtents) -> Iterator[Attached]:
    """Yield a dot and P (x, y), or the coordinate it has, at each point with a coordinate, on the side away from its body's mass centre.

    That of a mass centre is on the side away from the origin.
    """
    u = extents.length_scale
    letters: defaultdict[Point, list[str]] = defaultdict(list)
    for reading in extents.part.mechanism.readings:
        if isinstance(reading, PointCoordinate) and is_drawn_letter(reading.name) and reading.point.body != GROUND:
            letters[reading.point].append(reading.name)
    for point, names in letters.items():
        dot = Circle("tracer", point.x, point.y, 0.013 * u)
        yield Attached(frame=extents.body_axes(point.body), shapes=(dot,), section_only=True)
        listed = [one for name in names for one in (",", name)][1:]
        letter = make_letters("letter", ["P", "(", *listed, ")"], (0.0, 0.0), _LETTER_HEIGHT * u)
        yield Attached(frame=partial(_coordinate_axes, extents, point), shapes=(letter,), section_only=True)


def _coordinate_axes(extents: MechanismExtents, point: Point, moment: Moment) -> PoseTuple:
    """Return the axes of the letters of coordinates, in their middle."""
    placed, u = extents.placed_at(moment), extents.length_scale
    x, y = placed.position(point)
    across, up = _direction_away((x, y), (placed.pose(point.body)[:2], (0.0, 0.0)), 0.01 * u)
    return x + _LETTERS_ASIDE * u * across, y + _LETTERS_ABOVE * u * up, 0.0


def _direction_away(point: Vec2, centres: Iterable[Vec2], near: float) -> Vec2:
    """Return the direction to a point from the first of some centres that is not near it (m), or up."""
    for x, y in centres:
        distance = math.dist(point, (x, y))
        if distance > near:
            return (point[0] - x) / distance, (point[1] - y) / distance
    return 0.0, 1.0

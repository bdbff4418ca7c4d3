"""Marks of readings that are named by a letter, as in a figure of a textbook: arcs at their angles, and points with their coordinates."""

import math
from collections import defaultdict
from collections.abc import Iterable, Iterator

from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.output_variables import BodyAngle, PointCoordinate
from governor_mechanism.render.geometry.points import arc_points, axes_to_plane
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2
from governor_mechanism.render.geometry.stroke_letters import is_drawn_letter, make_letters
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism

_ARC_RADIUS, _RADIUS_STEP, _RAY_EXTENSION, _LETTER_DISTANCE, _LETTER_HEIGHT = 0.085, 0.075, 0.03, 0.042, 0.055
"""Radius of the first arc at a hinge and its increase to the next, lengths beyond it, and height of a letter, as fractions of the scale."""
_LETTERS_ASIDE, _LETTERS_ABOVE = 0.15, 0.10
"""Distance of the middle of the letters of coordinates from their point, beside it and above it, as fractions of the length scale."""
_NEAR = 0.12
"""Distance between hinges below which their arcs get different radii, as a fraction of the length scale."""


def reading_mark_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield an arc with its letter between the axes of two bodies at their hinge, and the letters of the coordinates of a point."""
    yield from _angle_shapes(placed)
    yield from _coordinate_shapes(placed)


def _angle_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the two axes of each angle, its arc, and its letter. An angle of several turns shows as the rest of the last one."""
    u = placed.unit
    # Clear of the arrows of torques.
    torques = (load for load in placed.mechanism.force_elements if isinstance(load, Torque))
    earlier: list[Vec2] = [placed.hinge_position(load.first, load.second) for load in torques]
    for reading in placed.mechanism.readings:
        if not isinstance(reading, BodyAngle) or not is_drawn_letter(reading.name):
            continue
        hinge = placed.hinge_position(reading.reference_body, reading.body)
        n_near = sum(math.dist(hinge, other) < _NEAR * u for other in earlier)
        radius = (_ARC_RADIUS + n_near * _RADIUS_STEP) * u
        earlier.append(hinge)
        start, end = placed.pose(reading.reference_body)[2], placed.pose(reading.body)[2]
        angle = math.remainder(end - start, 2 * math.pi)
        rays = (axes_to_plane((*hinge, one), radius + _RAY_EXTENSION * u, 0.0) for one in (start, end))
        yield Lines("angle ray", tuple((hinge, ray) for ray in rays))
        yield Lines("angle arc", (arc_points(hinge, start, angle, radius, 24),))
        middle = axes_to_plane((*hinge, start + 0.5 * angle), radius + _LETTER_DISTANCE * u, 0.0)
        yield make_letters("letter", (reading.name,), middle, _LETTER_HEIGHT * u)


def _coordinate_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield a dot and P (x, y), or the coordinate it has, at each point with a coordinate, on the side away from its body's mass centre.

    That of a mass centre is on the side away from the origin.
    """
    u = placed.unit
    letters: defaultdict[Point, list[str]] = defaultdict(list)
    for reading in placed.mechanism.readings:
        if isinstance(reading, PointCoordinate) and is_drawn_letter(reading.name) and reading.point.body != GROUND:
            letters[reading.point].append(reading.name)
    for point, names in letters.items():
        x, y = placed.position(point)
        across, up = _direction_away((x, y), (placed.pose(point.body)[:2], (0.0, 0.0)), 0.01 * u)
        yield Circle("tracer", x, y, 0.013 * u)
        middle = (x + _LETTERS_ASIDE * u * across, y + _LETTERS_ABOVE * u * up)
        listed = [one for name in names for one in (",", name)][1:]
        yield make_letters("letter", ["P", "(", *listed, ")"], middle, _LETTER_HEIGHT * u)


def _direction_away(point: Vec2, centres: Iterable[Vec2], near: float) -> Vec2:
    """Return the direction to a point from the first of some centres that is not near it (m), or up."""
    for x, y in centres:
        distance = math.dist(point, (x, y))
        if distance > near:
            return (point[0] - x) / distance, (point[1] - y) / distance
    return 0.0, 1.0

"""Generic drawing of effects along readings: stops, dashpots, springs and friction on the path of a point.

Only readings that are the coordinate of a point along a direction of the ground can carry these shapes.
"""

import math
from collections.abc import Iterable, Iterator, Sequence

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.render.geometry.body_points import axes_to_plane
from governor_mechanism.render.geometry.outlines import make_burst, make_wall
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, PoseTuple, Vec2, make_rectangle
from governor_mechanism.render.machines.generic.force_elements import damper_lines, spring_lines
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism
from governor_mechanism.render.machines.governor_parts import friction_shoe_shapes
from governor_mechanism.render.run_extents import RunExtents

_STOP_GAP = 0.05
"""Distance of a stop beyond the point that it stops, as a fraction of the length scale."""
_LATERAL_OFFSET = 0.17
"""Distance of dashpots and springs from the path, as a fraction of the length scale."""
_MIN_LENGTH = 0.30
"""Smallest drawn length of dashpots and springs, as a fraction of the length scale."""


def output_effect_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the effects of each reading that is a coordinate of a point, in axes along that coordinate; all move with the point."""
    for effect in placed.extents.effect_state.effects:
        reading = placed.part.mechanism.reading(effect.reading) if isinstance(effect, OutputEffect) else None
        if isinstance(effect, OutputEffect) and isinstance(reading, PointCoordinate) and reading.origin.body == GROUND:
            x, y = placed.position(reading.point)
            value = reading.direction_x * (x - reading.origin.x) + reading.direction_y * (y - reading.origin.y) - reading.zero
            axes = (x, y, math.atan2(reading.direction_y, reading.direction_x))
            yield from _shapes_of_effect(effect, axes, value, placed.extents)


def _shapes_of_effect(effect: OutputEffect, axes: PoseTuple, value: float, extents: RunExtents) -> Iterable[DrawnShape]:
    """Return the shapes of one effect at a value (m) of its reading; `axes` have their origin in the point and x along its path."""
    u, effect_state = extents.length_scale, extents.effect_state
    low, high = effect_state.reading_ranges.get(effect.reading, (value, value))
    match effect:
        case Stops():
            return _stop_shapes(effect, axes, value, extents)
        case DryFriction():
            shoe = make_rectangle("shoe", -0.05 * u, 0.05 * u, -0.085 * u, 0.04 * u - 0.085 * u)
            corners = tuple(axes_to_plane(axes, *corner) for corner in shoe.points)
            return friction_shoe_shapes(effect_state, effect.reading, extents.time, [Polygon("shoe", corners)])
        case Dashpot():
            min_length = _MIN_LENGTH * u
            length = min_length + value - low
            lines = damper_lines(length, (min_length, min_length + high - low), u)
            return _offset_element_shapes("damper", lines, (*axes_to_plane(axes, -length, -_LATERAL_OFFSET * u), axes[2]), length, u)
        case OutputSpring():
            length = _MIN_LENGTH * u + high - value
            start = axes_to_plane(axes, length, -_LATERAL_OFFSET * u)
            return _offset_element_shapes("spring", spring_lines(length, u), (*start, axes[2] + math.pi), length, u)
    return ()


def _stop_shapes(stops: Stops, axes: PoseTuple, value: float, extents: RunExtents) -> Iterator[DrawnShape]:
    u = extents.length_scale
    last_impact = extents.effect_state.recent_impact(stops.reading, extents.time)
    for limit, direction in ((stops.low, -1.0), (stops.high, 1.0)):
        if math.isfinite(limit):
            point = axes_to_plane(axes, limit - value + direction * _STOP_GAP * u, 0.0)
            is_struck = last_impact is not None and last_impact.is_high_stop == (direction > 0)
            yield make_wall(point, axes[2] + (math.pi if direction > 0 else 0.0), 0.07 * u, 0.035 * u)
            yield make_burst("burst", [point] if is_struck else [], 0.07 * u)


def _offset_element_shapes(role: str, lines: Sequence[Sequence[Vec2]], axes: PoseTuple, length: float, u: float) -> list[DrawnShape]:
    """Return a spring or dashpot from a wall at the origin of its axes, with a beam from its end to the path of the point."""
    transformed = tuple(tuple(axes_to_plane(axes, *point) for point in line) for line in lines)
    beam_offset = _LATERAL_OFFSET * u if role == "damper" else -_LATERAL_OFFSET * u
    beam = (axes_to_plane(axes, length, 0.0), axes_to_plane(axes, length, beam_offset))
    return [Lines(role, (*transformed, beam)), make_wall((axes[0], axes[1]), axes[2], 0.05 * u, 0.035 * u)]

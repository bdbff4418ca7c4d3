"""Generic drawing of force elements, and of effects along readings: stops, springs, dampers, friction, and arrows of applied loads.

Only readings that are the coordinate of a point along a direction of the ground can carry the shapes of effects.
"""

import math
from collections.abc import Iterable, Iterator, Sequence

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Distance, Pin, RotationalDriver, TranslationalDriver, Weld
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.render.geometry.outlines import make_arrow, make_box, make_burst, make_wall
from governor_mechanism.render.geometry.points import arc_points, axes_to_plane, place_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, PoseTuple, Vec2
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism
from governor_mechanism.render.machines.generic.rams import ram_drags
from governor_mechanism.render.machines.governor_parts import friction_shoe_shapes

_N_COILS = 6
_ELEMENT_WIDTH = 0.075
"""Width of a zigzag or a cylinder, as a fraction of the length scale."""
_LATERAL_SPACING = 0.065
"""Offset of elements between the same two points from the line, as a fraction of the length scale."""
_ARROW_LENGTH, _ARROW_HEAD_SIZE, _TORQUE_ARROW_RADIUS = 0.30, 0.06, 0.13
_LEAD_RATIO = 0.14
"""Length of the straight ends of a zigzag, as a fraction of its length."""
_STOP_GAP = 0.05
"""Distance of a stop beyond the point that it stops, as a fraction of the length scale."""
_LATERAL_OFFSET = 0.17
"""Distance of dashpots and springs from the path, as a fraction of the length scale."""
_MIN_LENGTH = 0.30
"""Smallest drawn length of dashpots and springs, as a fraction of the length scale."""


def translational_element_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield springs and dampers between their points; side by side if they share both points."""
    u = placed.unit
    loads = _drawn_elements(placed)
    pairs = [frozenset((load.first, load.second)) for load in loads]
    for k, load in enumerate(loads):
        count, number = pairs.count(pairs[k]), pairs[:k].count(pairs[k])
        lateral_offset = (2 * number - (count - 1)) * _LATERAL_SPACING * u
        if load.first != loads[pairs.index(pairs[k])].first:
            lateral_offset = -lateral_offset
        start, end = placed.position(load.first), placed.position(load.second)
        length = math.dist(start, end)
        axes = (*start, math.atan2(end[1] - start[1], end[0] - start[0]))
        is_spring = isinstance(load, Spring)
        element_lines = spring_lines(length, u) if is_spring else damper_lines(length, placed.extents.element_length_range(load), u)
        lines = [place_points(axes, ((x, y + lateral_offset) for x, y in line)) for line in element_lines]
        if lateral_offset:
            # Beams connect an offset element to its points.
            lines += [(start, axes_to_plane(axes, 0.0, lateral_offset)), (end, axes_to_plane(axes, length, lateral_offset))]
        yield Lines("spring" if is_spring else "damper", tuple(lines))
        yield from (Circle("eye", *point, 0.011 * u) for point in (start, end))


def _drawn_elements(placed: PlacedMechanism) -> list[Spring | Damper]:
    """Return the springs and dampers; not those that show as the arrow of their force."""
    elements, arrows = placed.mechanism.force_elements, ram_drags(placed.extents)
    return [element for element in elements if isinstance(element, Spring | Damper) and element.name not in arrows]


def spring_lines(length: float, u: float) -> list[tuple[Vec2, ...]]:
    """Return a zigzag along x from the origin."""
    lead_length, half_width = _LEAD_RATIO * length, 0.5 * _ELEMENT_WIDTH * u
    step = (length - 2 * lead_length) / (2 * _N_COILS)
    coils = [(lead_length + (k + 0.5) * step, half_width if k % 2 else -half_width) for k in range(2 * _N_COILS)]
    return [((0.0, 0.0), (lead_length, 0.0), *coils, (length - lead_length, 0.0), (length, 0.0))]


def damper_lines(length: float, length_range: Vec2, u: float) -> list[tuple[Vec2, ...]]:
    """Return a cylinder along x from the origin with a piston in its open end; piston and rod have fixed lengths if the stroke allows."""
    min_length, max_length = length_range
    gap, stroke, half_width = 0.03 * u, max_length - min_length, 0.5 * _ELEMENT_WIDTH * u
    if stroke < min_length - 3 * gap:
        # The piston moves from `gap` above the bottom to `gap` below the rim, which never reaches the second point.
        rod_length = (stroke + min_length) / 2
        bottom, piston, rim = min_length - rod_length - gap, length - rod_length, max_length - rod_length + gap
    else:
        bottom, piston, rim = 0.2 * length, 0.5 * length, 0.75 * length
    return [
        ((0.0, 0.0), (bottom, 0.0)),
        ((rim, half_width), (bottom, half_width), (bottom, -half_width), (rim, -half_width)),
        ((piston, 0.82 * half_width), (piston, -0.82 * half_width)),
        ((piston, 0.0), (length, 0.0)),
    ]


def wall_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield small hatched walls where springs and dampers are fixed to the ground, except where there is a foot."""
    held = [joint for joint in placed.mechanism.joints if isinstance(joint, Pin | Distance | Weld)]
    occupied = [(point.x, point.y) for joint in held for point in (joint.first, joint.second) if point.body == GROUND]
    loads = _drawn_elements(placed)
    for point, other in (ends for load in loads for ends in ((load.first, load.second), (load.second, load.first))):
        x, y = point.x, point.y
        if point.body == GROUND and (x, y) not in occupied:
            occupied.append((x, y))
            other_x, other_y = placed.position(other)
            yield make_wall((x, y), math.atan2(other_y - y, other_x - x), 0.10 * placed.unit, 0.035 * placed.unit)


def spiral_points(centre: Vec2, start_angle: float, wound_angle: float, u: float) -> tuple[Vec2, ...]:
    """Return a spiral spring inward of `start_angle` (rad), wound up by `wound_angle` (rad) from two and a half turns."""
    sweep = 5 * math.pi - wound_angle
    return tuple(axes_to_plane((*centre, start_angle - sweep * (1 - k / 72)), (0.03 + 0.07 * k / 72) * u, 0.0) for k in range(73))


def torsional_element_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield torsion springs as spirals that wind up, and torsion dampers as drums with a vane."""
    for load in placed.mechanism.force_elements:
        if not isinstance(load, TorsionSpring | TorsionDamper):
            continue
        centre = placed.hinge_position(load.first, load.second)
        outer_angle, inner_angle = placed.pose(load.first)[2], placed.pose(load.second)[2]
        if isinstance(load, TorsionSpring):
            # Beyond one and a half turns a spiral would unwind or close up.
            wound_angle = max(min(inner_angle - outer_angle, 3 * math.pi), -3 * math.pi)
            yield Lines("spring", (spiral_points(centre, outer_angle + 2.2, wound_angle, placed.unit),))
        else:
            yield Circle("drum", *centre, 0.055 * placed.unit)
            yield Lines("damper", (tuple(axes_to_plane((*centre, inner_angle), side * 0.055 * placed.unit, 0.0) for side in (-1, 1)),))


def force_arrow_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield forces as arrows of a length proportional to their magnitude; empty ones for zero."""
    u = placed.unit
    for load in placed.mechanism.force_elements:
        if isinstance(load, Force):
            x, y = placed.position(load.point)
            across, up = placed.extents.load_fractions(load, placed.time)
            yield from make_arrow("force", ((x, y), (x + _ARROW_LENGTH * u * across, y + _ARROW_LENGTH * u * up)), _ARROW_HEAD_SIZE * u)


def torque_arrow_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield torques as curved arrows of a length proportional to their magnitude; empty ones for zero. They go behind the bodies."""
    for load in placed.mechanism.force_elements:
        if isinstance(load, Torque):
            centre = placed.hinge_position(load.first, load.second)
            sweep = 1.5 * math.pi * placed.extents.load_fractions(load, placed.time)[0]
            start = 0.25 * math.pi if sweep > 0 else 0.75 * math.pi
            chain = arc_points(centre, start, sweep, _TORQUE_ARROW_RADIUS * placed.unit, 32)
            yield from make_arrow("force", chain, _ARROW_HEAD_SIZE * placed.unit)


def drive_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield a ring around the pin that a drive rotates, or around the point that it moves."""
    for joint in placed.mechanism.joints:
        if isinstance(joint, TranslationalDriver):
            yield Circle("drive", *placed.position(joint.second), 0.036 * placed.unit)
        elif isinstance(joint, RotationalDriver):
            yield Circle("drive", *placed.hinge_position(joint.first.body, joint.second.body, joint.second), 0.036 * placed.unit)


def output_effect_shapes(placed: PlacedMechanism, without: str = "") -> Iterator[DrawnShape]:
    """Yield the effects of each reading that is a coordinate of a point, in axes along that coordinate; all move with the point.

    Those on the reading `without`, if it is given, are left out.
    """
    for effect in placed.extents.part.effects:
        if isinstance(effect, OutputEffect) and effect.reading == without:
            continue
        reading = placed.mechanism.reading(effect.reading) if isinstance(effect, OutputEffect) else None
        if isinstance(effect, OutputEffect) and isinstance(reading, PointCoordinate) and reading.origin.body == GROUND:
            x, y = placed.position(reading.point)
            value = reading.direction_x * (x - reading.origin.x) + reading.direction_y * (y - reading.origin.y) - reading.zero
            axes = (x, y, math.atan2(reading.direction_y, reading.direction_x))
            yield from _shapes_of_effect(effect, axes, value, placed)


def _shapes_of_effect(effect: OutputEffect, axes: PoseTuple, value: float, placed: PlacedMechanism) -> Iterable[DrawnShape]:
    """Return the shapes of one effect at a value (m) of its reading; `axes` have their origin in the point and x along its path."""
    u, (low, high) = placed.unit, placed.extents.reading_range(effect.reading, (value, value))
    min_length = _MIN_LENGTH * u
    match effect:
        case Stops():
            return _stop_shapes(effect, axes, value, placed)
        case DryFriction():
            shoe = make_box("shoe", axes, (-0.05 * u, 0.05 * u, -0.085 * u, -0.045 * u))
            return friction_shoe_shapes(placed.extents, effect.reading, placed.time, [shoe])
        case Dashpot():
            length = min_length + value - low
            lines = damper_lines(length, (min_length, min_length + high - low), u)
            return _offset_element_shapes("damper", lines, (*axes_to_plane(axes, -length, -_LATERAL_OFFSET * u), axes[2]), length, u)
        case OutputSpring():
            length = min_length + high - value
            start = axes_to_plane(axes, length, -_LATERAL_OFFSET * u)
            return _offset_element_shapes("spring", spring_lines(length, u), (*start, axes[2] + math.pi), length, u)
    return ()


def _stop_shapes(stops: Stops, axes: PoseTuple, value: float, placed: PlacedMechanism) -> Iterator[DrawnShape]:
    u, struck_side = placed.unit, placed.extents.struck_side(stops.reading, placed.time)
    for limit, side in ((stops.low, -1), (stops.high, 1)):
        if math.isfinite(limit):
            point = axes_to_plane(axes, limit - value + side * _STOP_GAP * u, 0.0)
            yield make_wall(point, axes[2] + (math.pi if side > 0 else 0.0), 0.07 * u, 0.035 * u)
            yield make_burst("burst", [point] if struck_side == side else [], 0.07 * u)


def _offset_element_shapes(role: str, lines: Sequence[Sequence[Vec2]], axes: PoseTuple, length: float, u: float) -> list[DrawnShape]:
    """Return a spring or dashpot from a wall at the origin of its axes, with a beam from its end to the path of the point."""
    beam_offset = _LATERAL_OFFSET * u if role == "damper" else -_LATERAL_OFFSET * u
    placed_lines = tuple(place_points(axes, line) for line in (*lines, ((length, 0.0), (length, beam_offset))))
    return [Lines(role, placed_lines), make_wall((axes[0], axes[1]), axes[2], 0.05 * u, 0.035 * u)]

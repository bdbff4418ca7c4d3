"""Generic drawing of force elements, and of effects along readings: stops, springs, dampers, friction, and arrows of applied loads.

Only readings that are the coordinate of a point along a direction of the ground can carry the shapes of effects.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from functools import partial

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction, Stops
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.mechanics.kinematics.constraint_rows import rotate_vector
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Distance, Pin, Point, RotationalDriver, Slider, TranslationalDriver, Weld
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Frame, Moment
from governor_mechanism.render.geometry.outlines import make_arrow, make_burst, make_rectangle, make_wall, spiral_points
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    PoseTuple,
    TextShape,
    Vec2,
    arc_points,
    axes_to_plane,
    place_points,
)
from governor_mechanism.render.machines.generic.joints import RAM_LENGTH, ram_offsets
from governor_mechanism.render.machines.generic.placed_mechanism import LoadFunction, MechanismExtents, PlacedMechanism
from governor_mechanism.render.machines.governor_parts import friction_shoe_parts
from governor_mechanism.render.shown_readings import format_name

_N_COILS = 6
_ELEMENT_WIDTH = 0.075
"""Width of a zigzag or a cylinder, as a fraction of the length scale."""
_LATERAL_SPACING = 0.065
"""Offset of elements between the same two points from the line, as a fraction of the length scale."""
_ARROW_LENGTH = 0.30
_ARROW_HEAD_SIZE = 0.06
_TORQUE_ARROW_RADIUS = 0.13
_LETTER_WIDTH = 0.0235
"""Length of the largest force and of its head, radius of a torque, and width of a letter, as fractions of the length scale."""
_DRIVE_RADIUS = 0.029
"""Radius of the ring around a driven pin, as a fraction of the length scale."""
_LEAD_RATIO = 0.14
"""Length of the straight ends of a zigzag, as a fraction of its length."""
_STOP_GAP = 0.05
"""Distance of a stop beyond the point that it stops, as a fraction of the length scale."""
_LATERAL_OFFSET = 0.17
"""Distance of dashpots and springs from the path, as a fraction of the length scale."""
_MIN_LENGTH = 0.30
"""Smallest drawn length of dashpots and springs, as a fraction of the length scale."""


def translational_element_parts(placed: PlacedMechanism) -> Iterator[DrawnPart]:
    """Yield springs and dampers between their points; side by side if they share both points."""
    loads = _drawn_elements(placed)
    pairs = [frozenset((load.first, load.second)) for load in loads]
    for k, load in enumerate(loads):
        count, number = pairs.count(pairs[k]), pairs[:k].count(pairs[k])
        lateral_offset = (2 * number - (count - 1)) * _LATERAL_SPACING * placed.unit
        if load.first != loads[pairs.index(pairs[k])].first:
            lateral_offset = -lateral_offset
        if placed.extents.part.turns and placed.position(load.second)[0] < placed.position(load.first)[0]:
            lateral_offset = -lateral_offset  # as in a mirror, on the other side of the spindle
        shapes_at = partial(_element_shapes, load, lateral_offset)
        axes_at = partial(_element_axes, load)
        yield placed.extents.flex(shapes_at, axes_at=axes_at, turns=True)
        yield from (eye_part(placed.extents, "eye", point, 0.011 * placed.unit) for point in (load.first, load.second))


def eye_part(extents: MechanismExtents, role: str, point: Point, radius: float, *, turns: bool = True) -> Attached:
    """Return a circle of a radius (m) around a point of a body."""
    return Attached(frame=extents.body_axes(point.body), shapes=(Circle(role, point.x, point.y, radius),), turns=turns)


def _element_axes(load: Spring | Damper, placed: PlacedMechanism) -> PoseTuple:
    """Return the axes of a spring or a damper: the origin is its first point, and x leads to the second."""
    x, y = placed.position(load.first)
    end_x, end_y = placed.position(load.second)
    return x, y, math.atan2(end_y - y, end_x - x)


def _element_shapes(load: Spring | Damper, lateral_offset: float, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return a spring or a damper in its axes, at a distance from the line between its points (m)."""
    u = placed.unit
    length = math.dist(placed.position(load.first), placed.position(load.second))
    is_spring = isinstance(load, Spring)
    element_lines = spring_lines(length, u) if is_spring else damper_lines(length, placed.extents.element_length_range(load), u)
    lines = [tuple((x, y + lateral_offset) for x, y in line) for line in element_lines]
    if lateral_offset:
        # Beams connect an offset element to its points.
        lines += [((x, 0.0), (x, lateral_offset)) for x in (0.0, length)]
    return [Lines("spring" if is_spring else "damper", tuple(lines))]


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
    gap = 0.03 * u
    stroke = max_length - min_length
    half_width = 0.5 * _ELEMENT_WIDTH * u
    if stroke < min_length - 3 * gap:
        # The piston moves from `gap` above the bottom to `gap` below the rim, which never reaches the second point.
        rod_length = (stroke + min_length) / 2
        bottom = min_length - rod_length - gap
        piston = length - rod_length
        rim = max_length - rod_length + gap
    else:
        bottom = 0.2 * length
        piston = 0.5 * length
        rim = 0.75 * length
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


def torsional_element_parts(placed: PlacedMechanism) -> Iterator[DrawnPart]:
    """Yield torsion springs as spirals that wind up, and torsion dampers as drums with a vane."""
    for load in placed.mechanism.force_elements:
        if isinstance(load, TorsionSpring):
            yield placed.extents.flex(partial(_spiral_shapes, load), turns=True)
        elif isinstance(load, TorsionDamper):
            reach = 0.055 * placed.unit
            shapes = (Circle("drum", 0.0, 0.0, reach), Lines("damper", (((-reach, 0.0), (reach, 0.0)),)))
            yield Attached(frame=_vane_axes(placed.extents, load), shapes=shapes)


def _spiral_shapes(load: TorsionSpring, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return a torsion spring; beyond one and a half turns a spiral would unwind or close up."""
    outer_angle = placed.pose(load.first)[2]
    inner_angle = placed.pose(load.second)[2]
    wound_angle = max(min(inner_angle - outer_angle, 3 * math.pi), -3 * math.pi)
    centre = placed.hinge_position(load.first, load.second)
    return [Lines("spring", (spiral_points(centre, outer_angle + 2.2, wound_angle, placed.unit),))]


def _vane_axes(extents: MechanismExtents, load: TorsionDamper) -> Frame:
    """Return the axes of the vane of a damper, at its hinge."""

    def frame(moment: Moment) -> PoseTuple:
        placed = extents.placed_at(moment)
        return *placed.hinge_position(load.first, load.second), placed.pose(load.second)[2]

    return frame


def force_arrow_parts(extents: MechanismExtents) -> Iterator[DrawnPart]:
    """Yield forces as arrows of a length proportional to their magnitude; empty ones for zero."""
    for load in extents.part.mechanism.force_elements:
        if isinstance(load, Force):
            axes_at = partial(_upright_axes, load.point)
            yield extents.flex(partial(_force_arrow, load), axes_at=axes_at, section_only=True)


def _upright_axes(point: Point, placed: PlacedMechanism) -> PoseTuple:
    """Return axes that move with a point and do not turn."""
    return *placed.position(point), 0.0


def _force_arrow(load: Force, placed: PlacedMechanism) -> Iterable[DrawnShape]:
    """Return the arrow of a force, from the origin."""
    u, (across, up) = placed.unit, placed.extents.load_fractions(load, placed.time)
    return make_arrow("force", ((0.0, 0.0), (_ARROW_LENGTH * u * across, _ARROW_LENGTH * u * up)), _ARROW_HEAD_SIZE * u)


def torque_arrow_parts(extents: MechanismExtents) -> Iterator[DrawnPart]:
    """Yield torques as curved arrows of a length proportional to their magnitude; empty ones for zero. They go behind the bodies."""
    for load in extents.part.mechanism.force_elements:
        if isinstance(load, Torque):
            axes_at = partial(_hinge_axes, load)
            yield extents.flex(partial(_torque_arrow, load), axes_at=axes_at, section_only=True)


def _hinge_axes(load: Torque, placed: PlacedMechanism) -> PoseTuple:
    """Return axes that move with the hinge of a torque and do not turn."""
    return *placed.hinge_position(load.first, load.second), 0.0


def _torque_arrow(load: Torque, placed: PlacedMechanism) -> Iterable[DrawnShape]:
    """Return the arrow of a torque around the origin."""
    sweep = 1.5 * math.pi * placed.extents.load_fractions(load, placed.time)[0]
    start = 0.25 * math.pi if sweep > 0 else 0.75 * math.pi
    chain = arc_points((0.0, 0.0), start, sweep, _TORQUE_ARROW_RADIUS * placed.unit, 32)
    return make_arrow("force", chain, _ARROW_HEAD_SIZE * placed.unit)


def drive_parts(placed: PlacedMechanism) -> Iterator[Attached]:
    """Yield a ring around the pin that a drive rotates, or around the point that it moves."""
    for joint in placed.mechanism.joints:
        if isinstance(joint, TranslationalDriver):
            yield eye_part(placed.extents, "drive", joint.second, _DRIVE_RADIUS * placed.unit, turns=False)
        elif isinstance(joint, RotationalDriver):
            point = placed.hinge_point(joint.first.body, joint.second.body, joint.second)
            yield eye_part(placed.extents, "drive", point, _DRIVE_RADIUS * placed.unit, turns=False)


def output_effect_parts(extents: MechanismExtents, without: str = "") -> Iterator[DrawnPart]:
    """Yield the effects of each reading that is a coordinate of a point, in axes along that coordinate; all move with the point.

    Those on the reading `without`, if it is given, are left out.
    """
    for effect in extents.part.effects:
        if not isinstance(effect, OutputEffect) or effect.reading == without:
            continue
        reading = extents.part.mechanism.reading(effect.reading)
        if isinstance(reading, PointCoordinate) and reading.origin.body == GROUND:
            yield from _parts_of_effect(effect, reading, extents)


def _parts_of_effect(effect: OutputEffect, reading: PointCoordinate, extents: MechanismExtents) -> Iterator[DrawnPart]:
    """Yield the parts of one effect."""
    u = extents.length_scale
    match effect:
        case Stops():
            for limit, side in ((effect.low, -1), (effect.high, 1)):
                if math.isfinite(limit):
                    yield extents.flex(partial(_stop_shapes, effect, reading, limit, side))
        case DryFriction():
            shoe = make_rectangle("shoe", -0.05 * u, 0.05 * u, -0.085 * u, -0.045 * u)
            frame = partial(_reading_axes, extents, reading)
            yield from friction_shoe_parts(extents, effect.reading, Attached(frame=frame, shapes=(shoe,), turns=False))
        case Dashpot() | OutputSpring():
            yield extents.flex(lambda placed: _offset_element(effect, reading, placed)[:1], turns=True)
            yield extents.flex(lambda placed: _offset_element(effect, reading, placed)[1:])


def _reading_axes(extents: MechanismExtents, reading: PointCoordinate, moment: Moment) -> PoseTuple:
    """Return axes with their origin in the point of a reading and x along its coordinate."""
    return *extents.placed_at(moment).position(reading.point), math.atan2(reading.direction_y, reading.direction_x)


def _axes_and_value(reading: PointCoordinate, placed: PlacedMechanism) -> tuple[PoseTuple, float]:
    """Return axes in the point of a reading along its coordinate, and its value (m)."""
    x, y = placed.position(reading.point)
    value = reading.direction_x * (x - reading.origin.x) + reading.direction_y * (y - reading.origin.y) - reading.zero
    return (x, y, math.atan2(reading.direction_y, reading.direction_x)), value


def _stop_shapes(stops: Stops, reading: PointCoordinate, limit: float, side: int, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return the stop at one limit (m), and the rays of an impact on it."""
    u, (axes, value) = placed.unit, _axes_and_value(reading, placed)
    is_struck = placed.extents.struck_side(stops.reading, placed.time) == side
    point = axes_to_plane(axes, limit - value + side * _STOP_GAP * u, 0.0)
    wall = make_wall(point, axes[2] + (math.pi if side > 0 else 0.0), 0.07 * u, 0.035 * u)
    return [wall, make_burst([point] if is_struck else [], 0.07 * u)]


def _offset_element(effect: Dashpot | OutputSpring, reading: PointCoordinate, placed: PlacedMechanism) -> list[DrawnShape]:
    """Return a spring or dashpot beside the path of the point, with a beam to it, and the wall that holds its other end."""
    u, (axes, value) = placed.unit, _axes_and_value(reading, placed)
    low, high = placed.extents.reading_range(effect.reading, (value, value))
    min_length, offset = _MIN_LENGTH * u, _LATERAL_OFFSET * u
    if isinstance(effect, Dashpot):
        length = min_length + value - low
        role = "damper"
        heading = axes[2]
        beam_offset = offset
        wall = axes_to_plane(axes, -length, -offset)
        lines = damper_lines(length, (min_length, min_length + high - low), u)
    else:
        length = min_length + high - value
        role = "spring"
        heading = axes[2] + math.pi
        beam_offset = -offset
        wall = axes_to_plane(axes, length, -offset)
        lines = spring_lines(length, u)
    beam = ((length, 0.0), (length, beam_offset))
    placed_lines = tuple(place_points((*wall, heading), line) for line in (*lines, beam))
    return [Lines(role, placed_lines), make_wall(wall, heading, 0.05 * u, 0.035 * u)]


@once_per_object
def ram_drags(extents: MechanismExtents) -> Mapping[str, tuple[Slider, LoadFunction, float]]:
    """Return the dampers that resist a sliding body along its guide and have no room to be drawn in it.

    By name of the damper: the slider, its force on the body along the guide over time (N; the second component is zero), and the largest.
    """
    mechanism, drags = extents.part.mechanism, {}
    for slider in mechanism.joints:
        if not isinstance(slider, Slider) or slider.name not in ram_offsets(extents):
            continue
        low, high = extents.joint_travels[slider.name]
        is_passed = low <= RAM_LENGTH / 2 * extents.length_scale and high >= -RAM_LENGTH / 2 * extents.length_scale
        for damper in mechanism.force_elements:
            if isinstance(damper, Damper) and {damper.first, damper.second} == {slider.first, slider.second} and is_passed:
                force = _drag_along_guide(extents, slider.second, slider.angle, damper.damping)
                drags[damper.name] = (slider, force, float(np.abs(force(extents.run.times)[0]).max()))
    return drags


def _drag_along_guide(extents: MechanismExtents, point: Point, angle: float, damping: float) -> LoadFunction:
    """Return the force of a damper (N) on a body that only slides along a guide, over time."""
    velocities = extents.select_bodies(extents.run.velocities)[:, extents.part.mechanism.body_index(point.body), :2]
    forces = -damping * rotate_vector(-angle, *velocities.T)[0]
    return lambda times: np.array([np.interp(times, extents.run.times, forces), np.zeros(len(times))])


def drag_arrow_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the force of each drag as an arrow at the face of the ram, of a length proportional to it, in front of the ram."""
    u = placed.unit
    for slider, force, largest in ram_drags(placed.extents).values():
        fraction = float(force(np.array([placed.time]))[0, 0]) / largest if largest > 0.0 else 0.0
        axes = (*placed.position(slider.second), slider.angle)
        offset, face = ram_offsets(placed.extents)[slider.name], RAM_LENGTH / 2 * u
        # A push ends at the face, a pull begins there.
        ends = (face, face + abs(fraction) * _ARROW_LENGTH * u)
        start, end = ends if fraction > 0.0 else ends[::-1]
        yield from make_arrow("force", (axes_to_plane(axes, start, offset), axes_to_plane(axes, end, offset)), _ARROW_HEAD_SIZE * u)


def drag_caption_shapes(extents: MechanismExtents) -> Iterator[DrawnShape]:
    """Yield what the arrow of each drag means, above its guide: a damper resists both strokes, not only that of a cut."""
    u = extents.length_scale
    for name, (slider, _, largest) in ram_drags(extents).items():
        text = f"{format_name(name)}: damper, both strokes, up to {largest:.3g} N"
        low, _ = extents.joint_travels[slider.name]
        x, y = axes_to_plane((slider.first.x, slider.first.y, slider.angle), low, ram_offsets(extents)[slider.name] + 0.13 * u)
        yield TextShape("scale", x, y, text, _LETTER_WIDTH * len(text) * u)

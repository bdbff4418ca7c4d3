"""Generic drawing of force elements: springs, dampers, spiral springs, rotary dampers, and arrows of applied forces and torques."""

import math
from collections.abc import Iterator

from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Distance, Pin, RotationalDriver, TranslationalDriver, Weld
from governor_mechanism.render.geometry.body_points import axes_to_plane
from governor_mechanism.render.geometry.outlines import make_arrow, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism

_N_COILS = 6
_ELEMENT_WIDTH = 0.075
"""Width of a zigzag or a cylinder, as a fraction of the length scale."""
_LATERAL_SPACING = 0.065
"""Offset of elements between the same two points from the line, as a fraction of the length scale."""
_ARROW_LENGTH, _ARROW_HEAD_SIZE, _TORQUE_ARROW_RADIUS = 0.30, 0.06, 0.13
_LEAD_RATIO = 0.14
"""Length of the straight ends of a zigzag, as a fraction of its length."""


def translational_element_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield springs and dampers between their points; side by side if they share both points."""
    u = placed.unit
    loads = [load for load in placed.force_elements if isinstance(load, Spring | Damper)]
    pairs = [frozenset((load.first, load.second)) for load in loads]
    for k, load in enumerate(loads):
        count, number = pairs.count(pairs[k]), pairs[:k].count(pairs[k])
        lateral_offset = (2 * number - (count - 1)) * _LATERAL_SPACING * u
        if load.first != loads[pairs.index(pairs[k])].first:
            lateral_offset = -lateral_offset
        start, end = placed.position(load.first), placed.position(load.second)
        length = math.dist(start, end)
        axes = (*start, math.atan2(end[1] - start[1], end[0] - start[0]))
        role = "spring" if isinstance(load, Spring) else "damper"
        element_lines = spring_lines(length, u) if role == "spring" else damper_lines(length, placed.extents.element_lengths[load.name], u)
        lines = [tuple(axes_to_plane(axes, x, y + lateral_offset) for x, y in line) for line in element_lines]
        if lateral_offset:
            # Beams connect an offset element to its points.
            lines += [(start, axes_to_plane(axes, 0.0, lateral_offset)), (end, axes_to_plane(axes, length, lateral_offset))]
        yield Lines(role, tuple(lines))
        yield from (Circle("eye", *point, 0.011 * u) for point in (start, end))


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
    held = [joint for joint in placed.joints if isinstance(joint, Pin | Distance | Weld)]
    occupied = [(point.x, point.y) for joint in held for point in (joint.first, joint.second) if point.body == GROUND]
    loads = [load for load in placed.force_elements if isinstance(load, Spring | Damper)]
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
    for load in placed.force_elements:
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
    """Yield forces as arrows and torques as curved arrows, of a length proportional to their magnitude; empty ones for zero."""
    u = placed.unit
    for load in placed.force_elements:
        if isinstance(load, Force):
            x, y = placed.position(load.point)
            across, up = placed.extents.load_fractions(load)
            chain = [(x, y), (x + _ARROW_LENGTH * u * across, y + _ARROW_LENGTH * u * up)]
        elif isinstance(load, Torque):
            centre = placed.hinge_position(load.first, load.second)
            sweep = 1.5 * math.pi * placed.extents.load_fractions(load)[0]
            start = 0.25 * math.pi if sweep > 0 else 0.75 * math.pi
            chain = [axes_to_plane((*centre, start + sweep * k / 32), _TORQUE_ARROW_RADIUS * u, 0.0) for k in range(33)]
        else:
            continue
        yield from make_arrow("force", chain, _ARROW_HEAD_SIZE * u)


def drive_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield a ring around the pin that a drive rotates, or around the point that it moves."""
    for joint in placed.joints:
        if isinstance(joint, TranslationalDriver):
            yield Circle("drive", *placed.position(joint.second), 0.036 * placed.unit)
        elif isinstance(joint, RotationalDriver):
            centre = placed.hinge_position(joint.first.body, joint.second.body, joint.second)
            yield Circle("drive", *centre, 0.036 * placed.unit)

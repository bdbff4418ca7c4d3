"""Generic drawing of force elements: springs, dampers, spiral springs, rotary dampers, and arrows of applied forces and torques."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.model.force_elements import Damper, Force, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import GROUND, Distance, Pin, RotationalDriver, TranslationalDriver, Weld
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.body_points import axes_to_plane, body_pose, hinge_point, point_position
from governor_mechanism.render.geometry.outlines import make_arrow, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, PoseTuple, Vec2
from governor_mechanism.render.run_extents import RunExtents

_N_COILS = 6
_ELEMENT_WIDTH = 0.075
"""Width of a zigzag or a cylinder, as a fraction of the length scale."""
_LATERAL_SPACING = 0.065
"""Offset of elements between the same two points from the line, as a fraction of the length scale."""
_ARROW_LENGTH, _ARROW_HEAD_SIZE, _TORQUE_ARROW_RADIUS = 0.30, 0.06, 0.13
_LEAD_RATIO = 0.14
"""Length of the straight ends of a zigzag, as a fraction of its length."""


def translational_element_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return springs and dampers between their points; side by side if they share both points."""
    mechanism, u = part.mechanism, extents.length_scale
    loads = [load for load in mechanism.force_elements if isinstance(load, Spring | Damper)]
    end_points = [tuple(point_position(mechanism, poses, point) for point in (load.first, load.second)) for load in loads]
    pairs = [frozenset((load.first, load.second)) for load in loads]
    shapes: list[DrawnShape] = []
    for k, (load, (start, end)) in enumerate(zip(loads, end_points, strict=True)):
        count, number = pairs.count(pairs[k]), pairs[:k].count(pairs[k])
        lateral_offset = (2 * number - (count - 1)) * _LATERAL_SPACING * u
        if load.first != loads[pairs.index(pairs[k])].first:
            lateral_offset = -lateral_offset
        length = math.dist(start, end)
        axes = (*start, math.atan2(end[1] - start[1], end[0] - start[0]))
        role = "spring" if isinstance(load, Spring) else "damper"
        element_lines = spring_lines(length, u) if role == "spring" else damper_lines(length, extents.element_lengths[load.name], u)
        lines = [tuple(axes_to_plane(axes, x, y + lateral_offset) for x, y in line) for line in element_lines]
        if lateral_offset:
            # Beams connect an offset element to its points.
            lines += [(start, axes_to_plane(axes, 0.0, lateral_offset)), (end, axes_to_plane(axes, length, lateral_offset))]
        shapes += [Lines(role, tuple(lines)), Circle("eye", *start, 0.011 * u), Circle("eye", *end, 0.011 * u)]
    return shapes


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


def wall_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return small hatched walls where springs and dampers are fixed to the ground, except where there is a foot."""
    mechanism, u = part.mechanism, extents.length_scale
    held = [joint for joint in mechanism.joints if isinstance(joint, Pin | Distance | Weld)]
    occupied = [(point.x, point.y) for joint in held for point in (joint.first, joint.second) if point.body == GROUND]
    shapes: list[DrawnShape] = []
    for load in mechanism.force_elements:
        if not isinstance(load, Spring | Damper):
            continue
        for point, other in ((load.first, load.second), (load.second, load.first)):
            x, y = point.x, point.y
            if point.body == GROUND and (x, y) not in occupied:
                occupied.append((x, y))
                other_x, other_y = point_position(mechanism, poses, other)
                shapes.append(make_wall((x, y), math.atan2(other_y - y, other_x - x), 0.10 * u, 0.035 * u))
    return shapes


def torsional_element_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return torsion springs as spirals that wind up, and torsion dampers as drums with a vane."""
    mechanism, u = part.mechanism, extents.length_scale
    shapes: list[DrawnShape] = []
    for load in mechanism.force_elements:
        if not isinstance(load, TorsionSpring | TorsionDamper):
            continue
        centre = point_position(mechanism, poses, hinge_point(mechanism, load.first, load.second))
        outer_angle, inner_angle = (body_pose(mechanism, poses, body)[2] for body in (load.first, load.second))
        if isinstance(load, TorsionSpring):
            # Beyond one and a half turns a spiral would unwind or close up.
            wound_angle = max(min(inner_angle - outer_angle, 3 * math.pi), -3 * math.pi)
            sweep = 5 * math.pi - wound_angle
            spiral_points = (
                axes_to_plane((*centre, outer_angle + 2.2 - sweep * (1 - k / 72)), (0.03 + 0.07 * k / 72) * u, 0.0) for k in range(73)
            )
            shapes.append(Lines("spring", (tuple(spiral_points),)))
        else:
            vane = tuple(axes_to_plane((*centre, inner_angle), side * 0.055 * u, 0.0) for side in (-1, 1))
            shapes += [Circle("drum", *centre, 0.055 * u), Lines("damper", (vane,))]
    return shapes


def force_arrow_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return forces as arrows and torques as curved arrows, of a length proportional to their magnitude; none for zero."""
    mechanism, u = part.mechanism, extents.length_scale
    shapes: list[DrawnShape] = []
    for load in mechanism.force_elements:
        if isinstance(load, Force):
            x, y = point_position(mechanism, poses, load.point)
            across, up = extents.load_fractions(load)
            chain = [(x, y), (x + _ARROW_LENGTH * u * across, y + _ARROW_LENGTH * u * up)]
        elif isinstance(load, Torque):
            centre = point_position(mechanism, poses, hinge_point(mechanism, load.first, load.second))
            sweep = 1.5 * math.pi * extents.load_fractions(load)[0]
            start = 0.25 * math.pi if sweep > 0 else 0.75 * math.pi
            chain = [axes_to_plane((*centre, start + sweep * k / 32), _TORQUE_ARROW_RADIUS * u, 0.0) for k in range(33)]
        else:
            continue
        shapes += make_arrow("force", chain, _ARROW_HEAD_SIZE * u)
    return shapes


def drive_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return a ring around the pin that a drive rotates, or around the point that it moves."""
    mechanism, u = part.mechanism, extents.length_scale
    points = [
        joint.second
        if isinstance(joint, TranslationalDriver)
        else hinge_point(mechanism, joint.first.body, joint.second.body, joint.second)
        for joint in mechanism.joints
        if isinstance(joint, RotationalDriver | TranslationalDriver)
    ]
    return [Circle("drive", *point_position(mechanism, poses, point), 0.036 * u) for point in points]

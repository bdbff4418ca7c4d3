"""Generic drawing of guides: straight guides, slots, their sliding blocks, and the feet of ground pins."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.interpolate import CubicSpline

from governor_mechanism.model.curves import Curve, PolynomialCurve, SplineCurve
from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import GROUND, ArcSlot, CurveSlot, Distance, Joint, Pin, Prismatic, Slider, TranslationalDriver, Weld
from governor_mechanism.model.part import TURNING_PLANE, Part
from governor_mechanism.render.geometry.body_points import axes_at, axes_to_plane, distinct_points, point_position
from governor_mechanism.render.geometry.outlines import make_band, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, Vec2, make_hatching
from governor_mechanism.render.machines.generic.gears import rack_bodies
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_SLOT_WIDTH, STRIP_WIDTH = 0.046, 0.100
"""Widths of a slot and of the strip around it, as fractions of the length scale."""
_BLOCK_SIDES, _SPRUNG_BLOCK_SIDES = (0.15, 0.08), (0.16, 0.22)
"""Sides, along and across the guide, of a sliding block and of a mass held by springs in its guide, as fractions of the length scale."""
_GUIDE_EXTENSION = 0.12
"""Length of a guide beyond the travel at each end, as a fraction of the length scale."""
_N_SLOT_SEGMENTS = 48
"""Number of straight segments of a drawn slot."""


def guide_centreline(joint: Joint, extents: RunExtents) -> list[Vec2]:
    """Return the centre line of the guide of the joint's second point (m, in the axes of the joint's first point)."""
    low, high = extents.joint_travels[joint.name]
    extension = _GUIDE_EXTENSION * extents.length_scale
    match joint:
        case ArcSlot(radius=radius):
            extension = min(0.6 * extension / radius, 0.2)
            angles = np.linspace(low - extension, max(high + extension, low + extension), _N_SLOT_SEGMENTS + 1)
            return [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
        case CurveSlot(curve=curve):
            first, last = low - 0.6 * extension, high + 0.6 * extension
            if isinstance(curve, SplineCurve):
                # A table curve ends at its first and last point; it is drawn whole unless the run uses a small part of it.
                max_extension = 0.5 * (high - low) + extension
                first, last = (max(low - max_extension, min(curve.x[0], low)), min(high + max_extension, max(curve.x[-1], high)))
            xs = np.linspace(first, last, _N_SLOT_SEGMENTS + 1)
            return list(zip(xs.tolist(), _curve_ordinates(curve, xs).tolist(), strict=True))
        case _:
            return [(low - extension, 0.0), (high + extension, 0.0)]


def _curve_ordinates(curve: Curve, xs: FloatArray) -> FloatArray:
    match curve:
        case PolynomialCurve(coefficients=coefficients):
            return np.asarray(np.polynomial.polynomial.polyval(xs, coefficients), dtype=np.float64)
        case SplineCurve(x=x, y=y):
            return np.asarray(CubicSpline(x, y)(xs))
    raise NotImplementedError(f"curves of type {type(curve).__name__} cannot be drawn")


def guide_axes(part: Part, poses: Sequence[PoseTuple], joint: Joint) -> PoseTuple:
    """Return the axes of a guide: origin in the joint's first point, x along a straight guide."""
    angle = joint.angle if isinstance(joint, Slider | CurveSlot | TranslationalDriver) else 0.0
    return axes_at(part.mechanism, poses, joint.first, angle)


def guide_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents, *, fixed: bool) -> list[DrawnShape]:
    """Return the guides on the ground (`fixed`) or on bodies; the plate of a body is drawn elsewhere."""
    shapes: list[DrawnShape] = []
    for joint in part.mechanism.joints:
        if joint.name not in extents.joint_travels or (joint.first.body == GROUND) != fixed:
            continue
        axes = guide_axes(part, poses, joint)
        match joint:
            case Slider() if not (fixed and joint.second.body in rack_bodies(part)):
                shapes += _straight_guide_shapes(part, extents, joint, axes, fixed=fixed)
            case ArcSlot() | CurveSlot():
                shapes += _slot_shapes(joint, extents, axes, fixed=fixed)
            case TranslationalDriver() if fixed and not _is_guided_by_slider(part, joint):
                shapes.append(Lines("guide", (tuple(axes_to_plane(axes, *point) for point in guide_centreline(joint, extents)),)))
    return shapes


def block_sides(part: Part, joint: Slider) -> Vec2:
    """Return the sides of the block of a slider; a mass on springs is large enough to show them side by side."""
    body = joint.second.body
    has_no_other_joint = all(body not in (other.first.body, other.second.body) or other is joint for other in part.mechanism.joints)
    has_springs = any(isinstance(load, Spring | Damper) and body in load.bodies for load in part.mechanism.force_elements)
    return _SPRUNG_BLOCK_SIDES if has_no_other_joint and has_springs and body != GROUND else _BLOCK_SIDES


def _straight_guide_shapes(part: Part, extents: RunExtents, joint: Slider, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = extents.length_scale
    (low, _), (high, _) = guide_centreline(joint, extents)
    half_width = 0.5 * block_sides(part, joint)[1] * u
    if not fixed:
        return [_box_shape("slot", axes, ((low + high) / 2, 0.0), (high - low, 2 * half_width))]
    start, end = axes_to_plane(axes, low, 0.0), axes_to_plane(axes, high, 0.0)
    if part.plane == TURNING_PLANE and max(abs(start[0]), abs(end[0])) < 1e-6 * u:
        return [Lines("guide", ((start, end),))]
    middles = ((side, axes_to_plane(axes, (low + high) / 2, side * half_width)) for side in (1, -1))
    return [make_wall(middle, axes[2] - side * math.pi / 2, (high - low) / 2, 0.035 * u) for side, middle in middles]


def _is_guided_by_slider(part: Part, drive: TranslationalDriver) -> bool:
    """Return whether the driven body also runs in a guide, so that its path needs no line."""
    bodies = {drive.first.body, drive.second.body}
    return any(isinstance(joint, Slider) and {joint.first.body, joint.second.body} == bodies for joint in part.mechanism.joints)


def _slot_shapes(joint: ArcSlot | CurveSlot, extents: RunExtents, axes: PoseTuple, *, fixed: bool) -> list[DrawnShape]:
    u = extents.length_scale
    low, high = extents.joint_travels[joint.name]
    rim = "frame plate" if fixed else "plate"
    if isinstance(joint, ArcSlot) and high - low > 2 * math.pi - 0.4:
        edges = (("", STRIP_WIDTH), ("slot", _SLOT_WIDTH), (rim, -_SLOT_WIDTH))
        return [Circle(role or rim, axes[0], axes[1], joint.radius + w * u / 2) for role, w in edges]
    chain = [axes_to_plane(axes, *point) for point in guide_centreline(joint, extents)]
    return [*([make_band(rim, chain, STRIP_WIDTH * u)] if fixed else []), make_band("slot", chain, _SLOT_WIDTH * u)]


def block_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return the blocks that slide in straight guides; a rack is its own block."""
    u = extents.length_scale
    shapes: list[DrawnShape] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Slider) and joint.second.body not in rack_bodies(part):
            axes = guide_axes(part, poses, joint)
            point = point_position(part.mechanism, poses, joint.second)
            along, across = block_sides(part, joint)
            shapes.append(_box_shape("block", (*point, axes[2]), (0.0, 0.0), (along * u, across * u)))
    return shapes


def pin_centres(part: Part, poses: Sequence[PoseTuple]) -> list[Vec2]:
    """Return the visible pin positions: pins, ends of links, points in slots, and points that rotate on a sliding block.

    A bead, which does not rotate and is held in one point, has no pin.
    """
    centres: list[Vec2] = []
    beads = bead_bodies(part)
    rotating_bodies = {body.name for body in part.mechanism.bodies if body.can_rotate}
    for joint in part.mechanism.joints:
        second_point = point_position(part.mechanism, poses, joint.second)
        match joint:
            case Distance():
                ends = (joint.first, joint.second)
                centres += [point_position(part.mechanism, poses, end) for end in ends if end.body not in beads]
            case Pin():
                centres.append(second_point)
            case ArcSlot() | CurveSlot() if joint.second.body not in beads:
                centres.append(second_point)
            case Slider() if not isinstance(joint, Prismatic) and ({joint.first.body, joint.second.body} & rotating_bodies):
                centres.append(second_point)
    return centres


def bead_bodies(part: Part) -> set[str]:
    """Return the names of bodies that do not rotate and are held at their mass centre only, in slots or by links."""
    point_only_joints: dict[str, set[bool]] = {}
    for joint in part.mechanism.joints:
        for point in (joint.first, joint.second):
            is_point_only = isinstance(joint, Distance | ArcSlot | CurveSlot) and not (point.x or point.y)
            point_only_joints.setdefault(point.body, set()).add(is_point_only)
    return {body.name for body in part.mechanism.bodies if not body.can_rotate and point_only_joints.get(body.name) == {True}}


def foot_shapes(part: Part, extents: RunExtents) -> list[DrawnShape]:
    """Return a hatched foot under every pin, link, block or weld on the ground; above it where the mechanism hangs."""
    u = extents.length_scale
    positions = [
        (mine.x, mine.y)
        for joint in part.mechanism.joints
        for mine in (joint.first, joint.second)
        if mine.body == GROUND
        and (isinstance(joint, Pin | Distance | Weld) or (mine is joint.second and isinstance(joint, Slider | ArcSlot | CurveSlot)))
    ]
    return [
        shape for point in distinct_points(positions, 0.01 * u) for shape in _foot_shape(point, u, above=point[1] > extents.mean_height)
    ]


def _foot_shape(position: Vec2, u: float, *, above: bool) -> tuple[DrawnShape, ...]:
    x, y = position
    half_width, height, ground_thickness = 0.06 * u, 0.09 * u, 0.04 * u
    base = y + height if above else y - height
    bottom = base if above else base - ground_thickness
    box = (x - 1.5 * half_width, x + 1.5 * half_width, bottom, bottom + ground_thickness)
    line = Lines("wall", (((box[0], base), (box[1], base)),))
    return (Polygon("frame", ((x, y), (x - half_width, base), (x + half_width, base))), make_hatching("hatching", box, 0.034 * u), line)


def _box_shape(role: str, axes: PoseTuple, centre: Vec2, sides: Vec2) -> Polygon:
    a, b = sides[0] / 2, sides[1] / 2
    corners = ((a, b), (-a, b), (-a, -b), (a, -b))
    return Polygon(role, tuple(axes_to_plane(axes, centre[0] + f, centre[1] + g) for f, g in corners))

"""Generic drawing of meshing toothed wheels, and of racks on their pinions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.model.joints import GROUND, Gear, Point, RackAndPinion, Slider
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.body_points import axes_to_plane, body_pose, point_position
from governor_mechanism.render.geometry.outlines import make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, Vec2
from governor_mechanism.render.run_extents import RunExtents, wheel_radii

_RACK_THICKNESS = 0.09
"""Thickness of a rack, as a fraction of the length scale."""
_CONCENTRIC_WHEEL_RADIUS = 0.16
"""Radius of the larger of two wheels with a common centre, as a fraction of the length scale."""

WheelGeometry = tuple[str, Point, float]
"""Body name, wheel centre on the body, and wheel radius (m)."""


def wheel_bodies(part: Part) -> set[str]:
    """Return the names of bodies drawn as wheels."""
    joints = part.mechanism.joints
    gear_bodies = {point.body for joint in joints if isinstance(joint, Gear) for point in (joint.first, joint.second)}
    return (gear_bodies | {joint.first.body for joint in joints if isinstance(joint, RackAndPinion)}) - {GROUND}


def wheel_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return wheels with spokes that rotate with their bodies, larger ones behind; internal gears are rings."""
    u = extents.length_scale
    shapes: list[DrawnShape] = []
    for body, point, radius in sorted(_wheel_geometries(part, poses, extents), key=lambda wheel: -wheel[2]):
        x, y = point_position(part.mechanism, poses, point)
        shapes += spoked_wheel((x, y, body_pose(part.mechanism, poses, body)[2]), radius, max(radius - 0.035 * u, 0.72 * radius), 0.045 * u)
    return shapes


def spoked_wheel(pose: PoseTuple, radius: float, rim_radius: float, max_hub_radius: float) -> list[DrawnShape]:
    """Return a wheel with four spokes, one of them marked; `rim_radius` (m) is the inner one of its rim."""
    x, y, angle = pose
    ends = [axes_to_plane((x, y, angle + k * math.pi / 2), rim_radius, 0.0) for k in range(4)]
    return [
        Circle("wheel", x, y, radius),
        Circle("wheel web", x, y, rim_radius),
        Lines("spoke", tuple(((x, y), end) for end in ends[1:])),
        Lines("marked spoke", (((x, y), ends[0]),)),
        Circle("wheel", x, y, min(0.22 * rim_radius, max_hub_radius)),
    ]


def _wheel_geometries(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[WheelGeometry]:
    wheels_of_joints: list[WheelGeometry] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, RackAndPinion):
            wheels_of_joints.append((joint.first.body, joint.first, abs(joint.radius)))
        elif isinstance(joint, Gear):
            centre_distance = math.dist(*(point_position(part.mechanism, poses, point) for point in (joint.first, joint.second)))
            if centre_distance > 0.02 * extents.length_scale:
                radii = [float(radius[0]) for radius in wheel_radii(joint.ratio, np.array([centre_distance]))]
            else:
                scale = _CONCENTRIC_WHEEL_RADIUS * extents.length_scale / max(abs(joint.ratio), 1.0)
                radii = [abs(joint.ratio) * scale, scale]
            wheels_of_joints += [(p.body, p, r) for p, r in zip((joint.first, joint.second), radii, strict=True)]
    # A wheel can mesh with several others.
    distinct_wheels: dict[tuple[str, float, float, int], WheelGeometry] = {}
    for body, point, radius in wheels_of_joints:
        distinct_wheels.setdefault((body, point.x, point.y, round(200 * radius / extents.length_scale)), (body, point, radius))
    return list(distinct_wheels.values())


def rack_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return toothed bars that touch the circles of their pinions during the whole run."""
    u = extents.length_scale
    shapes: list[DrawnShape] = []
    for joint in part.mechanism.joints:
        if not isinstance(joint, RackAndPinion):
            continue
        centre, rack_point = (point_position(part.mechanism, poses, point) for point in (joint.first, joint.second))
        low, high = extents.joint_travels[joint.name]
        side, axes = _rack_contact(part, poses, joint)
        rack_coordinate = (rack_point[0] - centre[0]) * math.cos(joint.angle) + (rack_point[1] - centre[1]) * math.sin(joint.angle)
        start, end = rack_coordinate - high - 0.18 * u, rack_coordinate - low + 0.18 * u
        back_offset = side * _RACK_THICKNESS * u
        corners = ((start, 0.0), (end, 0.0), (end, back_offset), (start, back_offset))
        shapes.append(Polygon("rack", tuple(axes_to_plane(axes, *corner) for corner in corners)))
        count = max(round((end - start) / (0.045 * u)), 2)
        teeth: list[tuple[Vec2, ...]] = []
        for k in range(count):
            x = start + (k + 0.5) * (end - start) / count
            teeth.append((axes_to_plane(axes, x, 0.0), axes_to_plane(axes, x, 0.4 * back_offset)))
        shapes.append(Lines("tooth", tuple(teeth)))
    return shapes


def _rack_contact(part: Part, poses: Sequence[PoseTuple], joint: RackAndPinion) -> tuple[float, PoseTuple]:
    """Return the side (+1 or -1) of the pinion on which its rack touches it, and axes there with x along the rack.

    A pinion that rotates anticlockwise drives a rack on the right of the forward direction.
    """
    side = -1.0 if joint.radius > 0 else 1.0
    centre = point_position(part.mechanism, poses, joint.first)
    return side, (*axes_to_plane((*centre, joint.angle), 0.0, side * abs(joint.radius)), joint.angle)


def rack_bed_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return the beds of racks that the ground guides and whose pinions it holds."""
    u = extents.length_scale
    guided_bodies = {joint.second.body for joint in part.mechanism.joints if isinstance(joint, Slider) and joint.first.body == GROUND}
    shapes: list[DrawnShape] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, RackAndPinion) and joint.second.body in guided_bodies:
            side, axes = _rack_contact(part, poses, joint)
            low, high = extents.joint_travels[joint.name]
            half_length = (high - low) / 2 + 0.24 * u
            shapes.append(
                make_wall(axes_to_plane(axes, 0.0, side * _RACK_THICKNESS * u), joint.angle - side * math.pi / 2, half_length, 0.035 * u)
            )
    return shapes


def rack_bodies(part: Part) -> set[str]:
    """Return the names of bodies drawn as racks."""
    return {joint.second.body for joint in part.mechanism.joints if isinstance(joint, RackAndPinion)} - {GROUND}

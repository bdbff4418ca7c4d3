"""Generic drawing of bodies: plates and bars through their joint points, discs, masses and balls."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.model.force_elements import Damper, Force, Spring
from governor_mechanism.model.joints import ArcSlot, CurveSlot, Distance, Joint, Pin, Point, Slider, TranslationalDriver, Weld
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.output_variables import LineAngle, PointCoordinate, PointDistance
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.body_points import GROUND_POSE, axes_to_plane, distinct_points
from governor_mechanism.render.geometry.outlines import convex_hull, make_plate_outline, make_wall
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    PoseTuple,
    Vec2,
    drawn_ball_radius,
    place_point,
)
from governor_mechanism.render.machines.generic.gears import rack_bodies, spoked_wheel, wheel_bodies
from governor_mechanism.render.machines.generic.guides import STRIP_WIDTH, guide_centreline
from governor_mechanism.render.run_extents import RunExtents, flywheel_radius

_BAR_WIDTH = 0.052
"""Width of a bar, as a fraction of the length scale."""
_COINCIDENCE_DISTANCE = 0.02
"""Distance below which two points are drawn as one, as a fraction of the length scale."""
_MASS_SIDES = (0.22, 0.16)
"""Sides of a mass that hangs on springs, as fractions of the length scale."""


def body_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> tuple[list[DrawnShape], list[DrawnShape]]:
    """Return plates, bars and discs, which are behind, and masses and balls, which are in front."""
    behind: list[DrawnShape] = []
    front: list[DrawnShape] = []
    wheel_and_rack_names = wheel_bodies(part) | rack_bodies(part)
    for body, pose in zip(part.mechanism.bodies, poses, strict=True):
        outline = body_outline_points(part, body, extents)
        width = (STRIP_WIDTH if _has_guide(part, body) else _BAR_WIDTH) * extents.length_scale
        if len(outline) > 1:
            behind.append(make_plate_outline("plate", [axes_to_plane(pose, *point) for point in outline], width))
        elif body.name not in wheel_and_rack_names and not _is_sliding_block(part, body):
            disc_shapes, mass_shapes = _single_point_shapes(part, body, pose, extents)
            behind += disc_shapes
            front += mass_shapes
        if len(outline) > 1 and _has_end_mass(part, body, outline, extents):
            front.append(_ball_shape(body, pose, extents))
    return behind, front


def tracer_shapes(part: Part, poses: Sequence[PoseTuple], extents: RunExtents) -> list[DrawnShape]:
    """Return the points that readings follow and no joint holds."""
    return [
        Circle("tracer", *axes_to_plane(at, *point), 0.012 * extents.length_scale)
        for body, at in zip(part.mechanism.bodies, poses, strict=True)
        for point in distinct_points(_reading_points(part, body), _COINCIDENCE_DISTANCE * extents.length_scale)
        if all(math.dist(point, other) > _COINCIDENCE_DISTANCE * extents.length_scale for other in _joint_and_force_points(part, body))
    ]


def body_outline_points(part: Part, body: Body, extents: RunExtents) -> list[Vec2]:
    """Return the points that the body outline contains, in body axes: joint points, slots, and a point mass."""
    tolerance = _COINCIDENCE_DISTANCE * extents.length_scale
    marked = [*_joint_and_force_points(part, body), *_reading_points(part, body), *_slot_points(part, body, extents)]
    points = distinct_points(marked, tolerance)
    is_wheel = body.name in wheel_bodies(part) | rack_bodies(part)
    if not points or (is_wheel and all(math.hypot(*point) <= tolerance for point in points)):
        return points  # a wheel about its own centre; an eccentric wheel is drawn as a rod with a wheel
    if len(points) == 1 and not _is_sliding_block(part, body):
        distance = math.hypot(*points[0])
        if distance > tolerance:
            # A rod with this radius of gyration extends by this ratio beyond its mass centre.
            extension_ratio = min(math.sqrt(3) * _gyration_radius(body) / distance, 1.0)
            return [points[0], (-extension_ratio * points[0][0], -extension_ratio * points[0][1])]
    elif _may_have_ball(part, body) and not _is_inside_hull((0.0, 0.0), points, tolerance):
        return distinct_points([*points, (0.0, 0.0)], tolerance)
    return points


def _joint_and_force_points(part: Part, body: Body) -> list[Vec2]:
    """Return the points of joints and force elements on the body."""
    points: list[Point] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Pin | Distance | Weld):
            points += [joint.first, joint.second]
        elif isinstance(joint, Slider | ArcSlot | CurveSlot | TranslationalDriver):
            points.append(joint.second)
    for load in part.mechanism.force_elements:
        if isinstance(load, Spring | Damper):
            points += [load.first, load.second]
        elif isinstance(load, Force):
            points.append(load.point)
    return [(point.x, point.y) for point in points if point.body == body.name]


def _reading_points(part: Part, body: Body) -> list[Vec2]:
    """Return the points of readings on the body, except the mass centre, which is the default of a reading without a point."""
    points: list[Point] = []
    for reading in part.mechanism.readings:
        match reading:
            case PointCoordinate():
                points.append(reading.point)
            case LineAngle():
                points += [reading.start, reading.end]
            case PointDistance():
                points += [reading.first, reading.second]
    return [(point.x, point.y) for point in points if point.body == body.name and (point.x or point.y)]


def _slot_points(part: Part, body: Body, extents: RunExtents) -> list[Vec2]:
    """Return points of the guides on the body, which its plate must contain."""
    points: list[Vec2] = []
    for joint in part.mechanism.joints:
        if joint.first.body == body.name and isinstance(joint, Slider | ArcSlot | CurveSlot):
            angle = 0.0 if isinstance(joint, ArcSlot) else joint.angle
            axes = (*place_point(GROUND_POSE, joint.first), angle)
            chain = guide_centreline(joint, extents)
            points += [axes_to_plane(axes, *point) for point in chain[:: max(len(chain) // 12, 1)]]
    return points


def _has_guide(part: Part, body: Body) -> bool:
    return any(joint.first.body == body.name and isinstance(joint, Slider | ArcSlot | CurveSlot) for joint in part.mechanism.joints)


def _is_sliding_block(part: Part, body: Body) -> bool:
    """Return whether a sliding block represents the body."""
    return any(isinstance(joint, Slider) and joint.second.body == body.name for joint in part.mechanism.joints)


def _may_have_ball(part: Part, body: Body) -> bool:
    """Return whether a mass centre beyond the joints is a ball: of a pendulum, or of any arm of a governor."""
    return body.can_rotate and (part.turns or not any(body.second_moments.in_plane))


def _is_inside_hull(point: Vec2, points: Sequence[Vec2], tolerance: float) -> bool:
    corners, start, end = convex_hull([*points, point]), points[0], points[-1]
    is_between_ends = math.dist(start, point) + math.dist(point, end) < math.dist(start, end) + tolerance
    return point not in corners or (len(corners) < 3 and is_between_ends)


def _has_end_mass(part: Part, body: Body, outline: Sequence[Vec2], extents: RunExtents) -> bool:
    """Return whether the whole mass is at a corner of the outline, as in a pendulum bob."""
    tolerance = _COINCIDENCE_DISTANCE * extents.length_scale
    return _may_have_ball(part, body) and any(math.hypot(*corner) < tolerance for corner in convex_hull(outline))


def _single_point_shapes(part: Part, body: Body, pose: PoseTuple, extents: RunExtents) -> tuple[list[DrawnShape], list[DrawnShape]]:
    """Return the shapes of a body with at most one point, at its mass centre: disc, hanging mass or ball."""
    u = extents.length_scale
    if body.mass == 0.0 and not body.can_rotate:
        return [make_wall((pose[0], pose[1]), math.pi / 2, 0.10 * u, 0.035 * u)], []  # a moving point of the ground
    joints: list[Joint] = [j for j in part.mechanism.joints if body.name in (j.first.body, j.second.body)]
    hangs_on_springs = any(isinstance(load, Spring | Damper) and body.name in load.bodies for load in part.mechanism.force_elements)
    is_held_by_joint = any(isinstance(joint, Pin | Distance | CurveSlot | ArcSlot) for joint in joints)
    if hangs_on_springs and not is_held_by_joint:
        a, b = 0.5 * _MASS_SIDES[0] * u, 0.5 * _MASS_SIDES[1] * u
        return [], [Polygon("block", tuple(axes_to_plane(pose, x, y) for x, y in ((a, b), (-a, b), (-a, -b), (a, -b))))]
    if (radius := flywheel_radius(part.mechanism)) > 0.0:
        return spoked_wheel(pose, radius, 0.84 * radius, 0.1 * radius), []
    if body.can_rotate and body.planar_inertia > 0.0:
        # A disc with this moment of inertia.
        radius = min(max(math.sqrt(2) * _gyration_radius(body), 0.06 * u), 0.25 * u)
        spoke = (axes_to_plane(pose, 0.0, 0.0), axes_to_plane(pose, radius, 0.0))
        return [Circle("wheel", pose[0], pose[1], radius), Lines("marked spoke", (spoke,))], []
    return [], [_ball_shape(body, pose, extents)]


def _gyration_radius(body: Body) -> float:
    """Return the radius of gyration about the mass centre, m; 0 without mass."""
    xx, yy, _ = body.second_moments.in_plane
    return math.sqrt(max(xx + yy, 0.0) / body.mass) if body.mass else 0.0


def _ball_shape(body: Body, pose: PoseTuple, extents: RunExtents) -> Circle:
    return Circle("ball", pose[0], pose[1], min(0.7 * drawn_ball_radius(body.mass, extents.length_scale), 0.09 * extents.length_scale))

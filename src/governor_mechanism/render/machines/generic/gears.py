"""Generic drawing of meshing toothed wheels, and of racks on their pinions."""

import math
from collections.abc import Iterator

import numpy as np

from governor_mechanism.model.joints import GROUND, Gear, Joint, Point, RackAndPinion, Slider
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.render.geometry.body_points import wheel_radii
from governor_mechanism.render.geometry.outlines import make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, axes_to_plane
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism

_RACK_THICKNESS = 0.09
"""Thickness of a rack, as a fraction of the length scale."""
_CONCENTRIC_WHEEL_RADIUS = 0.16
"""Radius of the larger of two wheels with a common centre, as a fraction of the length scale."""


def toothed_bodies(mechanism: Mechanism) -> set[str]:
    """Return the names of bodies drawn as wheels or racks."""
    return {point.body for joint in mechanism.joints if isinstance(joint, Gear | RackAndPinion) for point in (joint.first, joint.second)}


def rack_bodies(mechanism: Mechanism) -> set[str]:
    """Return the names of bodies drawn as racks."""
    return {joint.second.body for joint in mechanism.joints if isinstance(joint, RackAndPinion)} - {GROUND}


def wheel_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield wheels with spokes that rotate with their bodies, larger ones behind; internal gears are rings."""
    u = placed.unit
    # A wheel can mesh with several others.
    wheels: dict[tuple[str, float, float, int], tuple[Point, float]] = {}
    for joint in placed.mechanism.joints:
        for point, radius in _wheels_of(placed, joint):
            wheels.setdefault((point.body, point.x, point.y, round(200 * radius / u)), (point, radius))
    for point, radius in sorted(wheels.values(), key=lambda wheel: -wheel[1]):
        pose = (*placed.position(point), placed.pose(point.body)[2])
        yield from spoked_wheel(pose, radius, max(radius - 0.035 * u, 0.72 * radius), 0.045 * u)


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


def _wheels_of(placed: PlacedMechanism, joint: Joint) -> list[tuple[Point, float]]:
    """Return the centres on their bodies and the radii (m) of the wheels of a joint."""
    if isinstance(joint, RackAndPinion):
        return [(joint.first, abs(joint.radius))]
    if not isinstance(joint, Gear):
        return []
    centre_distance = math.dist(placed.position(joint.first), placed.position(joint.second))
    if centre_distance > 0.02 * placed.unit:
        first, second = (float(radius[0]) for radius in wheel_radii(joint.ratio, np.array([centre_distance])))
    else:
        second = _CONCENTRIC_WHEEL_RADIUS * placed.unit / max(abs(joint.ratio), 1.0)
        first = abs(joint.ratio) * second
    return [(joint.first, first), (joint.second, second)]


def rack_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield toothed bars that touch the circles of their pinions during the whole run."""
    u = placed.unit
    for joint in placed.mechanism.joints:
        if not isinstance(joint, RackAndPinion):
            continue
        (x, y), (rack_x, rack_y) = placed.position(joint.first), placed.position(joint.second)
        low, high = placed.extents.joint_travels[joint.name]
        side, axes = _rack_contact(placed, joint)
        rack_coordinate = (rack_x - x) * math.cos(joint.angle) + (rack_y - y) * math.sin(joint.angle)
        start, end = rack_coordinate - high - 0.18 * u, rack_coordinate - low + 0.18 * u
        back_offset = side * _RACK_THICKNESS * u
        corners = ((start, 0.0), (end, 0.0), (end, back_offset), (start, back_offset))
        yield Polygon("rack", tuple(axes_to_plane(axes, *corner) for corner in corners))
        count = max(round((end - start) / (0.045 * u)), 2)
        tooth_positions = (start + (k + 0.5) * (end - start) / count for k in range(count))
        yield Lines("tooth", tuple((axes_to_plane(axes, x, 0.0), axes_to_plane(axes, x, 0.4 * back_offset)) for x in tooth_positions))


def _rack_contact(placed: PlacedMechanism, joint: RackAndPinion) -> tuple[float, PoseTuple]:
    """Return the side (+1 or -1) of the pinion on which its rack touches it, and axes there with x along the rack.

    A pinion that rotates anticlockwise drives a rack on the right of the forward direction.
    """
    side = -1.0 if joint.radius > 0 else 1.0
    return side, (*axes_to_plane((*placed.position(joint.first), joint.angle), 0.0, side * abs(joint.radius)), joint.angle)


def rack_bed_shapes(placed: PlacedMechanism) -> Iterator[DrawnShape]:
    """Yield the beds of racks that the ground guides and whose pinions it holds."""
    u = placed.unit
    guided_bodies = {joint.second.body for joint in placed.mechanism.joints if isinstance(joint, Slider) and joint.first.body == GROUND}
    for joint in placed.mechanism.joints:
        if isinstance(joint, RackAndPinion) and joint.second.body in guided_bodies:
            side, axes = _rack_contact(placed, joint)
            low, high = placed.extents.joint_travels[joint.name]
            position = axes_to_plane(axes, 0.0, side * _RACK_THICKNESS * u)
            yield make_wall(position, joint.angle - side * math.pi / 2, (high - low) / 2 + 0.24 * u, 0.035 * u)

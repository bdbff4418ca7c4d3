"""Generic drawing of toothed wheels that touch, and of racks on their pinions."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from governor_mechanism.model.joints import GROUND, Gear, Point, Rack, Slider
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.body_points import pose_of, put, where
from governor_mechanism.render.geometry.outlines import wall
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Polygon, Pose, Shape
from governor_mechanism.render.run_extents import Stage, rims

THICK = 0.09
"""Of a rack, as a fraction of the stage's unit."""
CONCENTRIC = 0.16
"""Radius of the larger of two wheels about one centre, as a fraction of the stage's unit."""

Wheel = tuple[str, Point, float]
"""A body, the wheel's centre on it, and its radius (m)."""


def wheel_bodies(part: Part) -> set[str]:
    """Bodies that are drawn as wheels."""
    joints = part.mechanism.joints
    gears = {point.body for joint in joints if isinstance(joint, Gear) for point in (joint.first, joint.second)}
    return (gears | {joint.first.body for joint in joints if isinstance(joint, Rack)}) - {GROUND}


def wheels(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Wheels with spokes that turn with their bodies, the larger ones behind; inside gears as rings."""
    u = stage.unit
    shapes: list[Shape] = []
    for body, point, radius in sorted(_wheels(part, poses, stage), key=lambda wheel: -wheel[2]):
        x, y = where(part.mechanism, poses, point)
        turn = pose_of(part.mechanism, poses, body)[2]
        rim = max(radius - 0.035 * u, 0.72 * radius)
        shapes += [Circle("wheel", x, y, radius), Circle("wheel web", x, y, rim)]
        arms = tuple(((x, y), put((x, y, turn + k * math.pi / 2), rim, 0.0)) for k in (1, 2, 3))
        marked = (put((x, y, turn), 0.0, 0.0), put((x, y, turn), rim, 0.0))
        shapes += [
            Lines("spoke", arms),
            Lines("marked spoke", (marked,)),
            Circle("wheel", x, y, min(0.22 * rim, 0.045 * u)),
        ]
    return shapes


def _wheels(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Wheel]:
    found: list[Wheel] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Rack):
            found.append((joint.first.body, joint.first, abs(joint.radius)))
        elif isinstance(joint, Gear):
            apart = math.dist(*(where(part.mechanism, poses, point) for point in (joint.first, joint.second)))
            if apart > 0.02 * stage.unit:
                radii = [float(radius[0]) for radius in rims(joint.ratio, np.array([apart]))]
            else:
                scale = CONCENTRIC * stage.unit / max(abs(joint.ratio), 1.0)
                radii = [abs(joint.ratio) * scale, scale]
            found += [(p.body, p, r) for p, r in zip((joint.first, joint.second), radii, strict=True)]
    # One wheel may mesh with several others.
    sizes: dict[tuple[str, float, float, int], Wheel] = {}
    for body, point, radius in found:
        sizes.setdefault((body, point.x, point.y, round(200 * radius / stage.unit)), (body, point, radius))
    return list(sizes.values())


def racks(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Toothed bars that touch the circles of their pinions all along the run."""
    u = stage.unit
    shapes: list[Shape] = []
    for joint in part.mechanism.joints:
        if not isinstance(joint, Rack):
            continue
        centre, far = (where(part.mechanism, poses, point) for point in (joint.first, joint.second))
        low, high = stage.ways[joint.name]
        side, axes = _contact(part, poses, joint)
        here = (far[0] - centre[0]) * math.cos(joint.angle) + (far[1] - centre[1]) * math.sin(joint.angle)
        start, end = here - high - 0.18 * u, here - low + 0.18 * u
        back = side * THICK * u
        corners = ((start, 0.0), (end, 0.0), (end, back), (start, back))
        shapes.append(Polygon("rack", tuple(put(axes, *corner) for corner in corners)))
        count = max(round((end - start) / (0.045 * u)), 2)
        teeth: list[tuple[Pair, ...]] = []
        for k in range(count):
            x = start + (k + 0.5) * (end - start) / count
            teeth.append((put(axes, x, 0.0), put(axes, x, 0.4 * back)))
        shapes.append(Lines("tooth", tuple(teeth)))
    return shapes


def _contact(part: Part, poses: Sequence[Pose], joint: Rack) -> tuple[float, Pose]:
    """On which side of the pinion its rack touches it, and axes there, with x along the rack.

    A pinion that turns anticlockwise drives what touches it on the right of the direction forward.
    """
    side = -1.0 if joint.radius > 0 else 1.0
    centre = where(part.mechanism, poses, joint.first)
    return side, (*put((*centre, joint.angle), 0.0, side * abs(joint.radius)), joint.angle)


def beds(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """What racks slide on, where the ground guides them and holds their pinions."""
    u = stage.unit
    guided = {
        joint.second.body for joint in part.mechanism.joints if isinstance(joint, Slider) and joint.first.body == GROUND
    }
    shapes: list[Shape] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Rack) and joint.second.body in guided:
            side, axes = _contact(part, poses, joint)
            low, high = stage.ways[joint.name]
            half = (high - low) / 2 + 0.24 * u
            shapes.append(wall(put(axes, 0.0, side * THICK * u), joint.angle - side * math.pi / 2, half, 0.035 * u))
    return shapes


def rack_bodies(part: Part) -> set[str]:
    """Bodies that are drawn as racks."""
    return {joint.second.body for joint in part.mechanism.joints if isinstance(joint, Rack)} - {GROUND}

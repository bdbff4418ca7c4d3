"""Generic drawing of bodies: plates and bars through their marked points, discs, masses, and balls."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.model.force_elements import Damper, Force, Spring
from governor_mechanism.model.joints import ArcSlot, CurveSlot, Distance, DrivenSlide, Joint, Pin, Point, Slider, Weld
from governor_mechanism.model.mechanism import Body, Coordinate, LineAngle, Separation
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.body_points import STILL, distinct, put
from governor_mechanism.render.geometry.outlines import hull, plate
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Polygon, Pose, Shape, ball_radius, place
from governor_mechanism.render.machines.generic.gears import rack_bodies, wheel_bodies
from governor_mechanism.render.machines.generic.guides import RIM, slot_chain
from governor_mechanism.render.run_extents import Stage

BAR = 0.052
"""Width of a bar, as a fraction of the stage's unit."""
NEAR = 0.02
"""Points closer than this, as a fraction of the unit, are drawn as one."""
MASS = (0.22, 0.16)
"""Sides of a mass that hangs on springs."""


def bodies(part: Part, poses: Sequence[Pose], stage: Stage) -> tuple[list[Shape], list[Shape]]:
    """Plates, bars and discs, which lie behind; and masses and balls, which lie in front."""
    behind: list[Shape] = []
    front: list[Shape] = []
    drawn = wheel_bodies(part) | rack_bodies(part)
    for body, at in zip(part.mechanism.bodies, poses, strict=True):
        outline = outline_of(part, body, stage)
        width = (RIM if _carries(part, body) else BAR) * stage.unit
        if len(outline) > 1:
            behind.append(plate("plate", [put(at, *spot) for spot in outline], width))
        elif body.name not in drawn and not _rides(part, body):
            disc, lump = _small(part, body, at, stage)
            behind += disc
            front += lump
        if len(outline) > 1 and _ball_at_end(body, outline, stage):
            front.append(_ball(body, at, stage))
    return behind, front


def tracers(part: Part, poses: Sequence[Pose], stage: Stage) -> list[Shape]:
    """Points that readings follow though no joint holds them."""
    return [
        Circle("tracer", *put(at, *spot), 0.012 * stage.unit)
        for body, at in zip(part.mechanism.bodies, poses, strict=True)
        for spot in distinct(_read(part, body), NEAR * stage.unit)
        if all(math.dist(spot, other) > NEAR * stage.unit for other in _held(part, body))
    ]


def outline_of(part: Part, body: Body, stage: Stage) -> list[Pair]:
    """The points a body must reach, in its own axes: marked points, slots, and its mass where it lies in one point."""
    near = NEAR * stage.unit
    found = distinct([*_held(part, body), *_read(part, body), *_slots(part, body, stage)], near)
    wheel = body.name in wheel_bodies(part) | rack_bodies(part)
    if not found or (wheel and all(math.hypot(*spot) <= near for spot in found)):
        return found  # a wheel about its own centre; one that leans is a rod with a wheel
    centre = (0.0, 0.0)
    if len(found) == 1 and not _rides(part, body):
        away = math.hypot(*found[0])
        if away > near:
            # A rod of this radius of gyration reaches as far beyond its mass centre.
            xx, yy, _ = body.moments.in_plane
            beyond = min(math.sqrt(3 * max(xx + yy, 0.0) / body.mass) / away, 1.0)
            return [found[0], (-beyond * found[0][0], -beyond * found[0][1])]
    elif body.turns and _concentrated(body) and not _inside(centre, found, near):
        return distinct([*found, centre], near)
    return found


def _held(part: Part, body: Body) -> list[Pair]:
    """Points of joints and loads."""
    points: list[Point] = []
    for joint in part.mechanism.joints:
        if isinstance(joint, Pin | Distance | Weld):
            points += [joint.first, joint.second]
        elif isinstance(joint, Slider | ArcSlot | CurveSlot | DrivenSlide):
            points.append(joint.second)
    for load in part.mechanism.loads:
        if isinstance(load, Spring | Damper):
            points += [load.first, load.second]
        elif isinstance(load, Force):
            points.append(load.point)
    return [(point.x, point.y) for point in points if point.body == body.name]


def _read(part: Part, body: Body) -> list[Pair]:
    """Points of readings, but for the mass centre, which they may mean where they name no point."""
    points: list[Point] = []
    for reading in part.mechanism.readings:
        match reading:
            case Coordinate():
                points.append(reading.point)
            case LineAngle():
                points += [reading.start, reading.end]
            case Separation():
                points += [reading.first, reading.second]
    return [(point.x, point.y) for point in points if point.body == body.name and (point.x or point.y)]


def _slots(part: Part, body: Body, stage: Stage) -> list[Pair]:
    """What the plate must hold of the guides that the body carries."""
    found: list[Pair] = []
    for joint in part.mechanism.joints:
        if joint.first.body == body.name and isinstance(joint, Slider | ArcSlot | CurveSlot):
            angle = 0.0 if isinstance(joint, ArcSlot) else joint.angle
            axes = (*place(STILL, joint.first), angle)
            chain = slot_chain(joint, stage)
            found += [put(axes, *spot) for spot in chain[:: max(len(chain) // 12, 1)]]
    return found


def _carries(part: Part, body: Body) -> bool:
    return any(
        joint.first.body == body.name and isinstance(joint, Slider | ArcSlot | CurveSlot)
        for joint in part.mechanism.joints
    )


def _rides(part: Part, body: Body) -> bool:
    """Whether a sliding block stands for the body."""
    return any(isinstance(joint, Slider) and joint.second.body == body.name for joint in part.mechanism.joints)


def _concentrated(body: Body) -> bool:
    return not any(body.moments.in_plane)


def _inside(spot: Pair, points: Sequence[Pair], near: float) -> bool:
    corners = hull([*points, spot])
    return spot not in corners or (len(corners) < 3 and _between(spot, points, near))


def _between(spot: Pair, points: Sequence[Pair], near: float) -> bool:
    return math.dist(points[0], spot) + math.dist(spot, points[-1]) < math.dist(points[0], points[-1]) + near


def _ball_at_end(body: Body, outline: Sequence[Pair], stage: Stage) -> bool:
    """Whether the whole mass sits in a corner of the outline, as a pendulum's bob does."""
    near = NEAR * stage.unit
    return body.turns and _concentrated(body) and any(math.hypot(*corner) < near for corner in hull(outline))


def _small(part: Part, body: Body, at: Pose, stage: Stage) -> tuple[list[Shape], list[Shape]]:
    """A body with one marked point, in its mass centre, or none: disc, hung mass, or ball."""
    u = stage.unit
    joints: list[Joint] = [j for j in part.mechanism.joints if body.name in (j.first.body, j.second.body)]
    hung = any(isinstance(load, Spring | Damper) and body.name in load.bodies for load in part.mechanism.loads)
    held = any(isinstance(joint, Pin | Distance | CurveSlot | ArcSlot) for joint in joints)
    if hung and not held:
        a, b = 0.5 * MASS[0] * u, 0.5 * MASS[1] * u
        return [], [Polygon("block", tuple(put(at, x, y) for x, y in ((a, b), (-a, b), (-a, -b), (a, -b))))]
    xx, yy, _ = body.moments.in_plane
    if xx + yy > 0.0 and body.turns:
        # A disc of this moment of inertia.
        radius = min(max(math.sqrt(2 * (xx + yy) / body.mass), 0.06 * u), 0.25 * u)
        spoke = (put(at, 0.0, 0.0), put(at, radius, 0.0))
        return [Circle("wheel", at[0], at[1], radius), Lines("marked spoke", (spoke,))], []
    return [], [_ball(body, at, stage)]


def _ball(body: Body, at: Pose, stage: Stage) -> Circle:
    return Circle("ball", at[0], at[1], min(0.7 * ball_radius(body.mass, stage.unit), 0.09 * stage.unit))

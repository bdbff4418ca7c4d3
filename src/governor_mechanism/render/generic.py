"""The drawing that fits every mechanism: bodies as dots with spokes to their joints, links as bars, guides as lines."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.joints import GROUND, Distance, Point, Slider
from governor_mechanism.mechanism import Mechanism
from governor_mechanism.render.primitives import (
    Circle,
    Lines,
    Pair,
    Polygon,
    Pose,
    Shape,
    ball_radius,
    bar,
    hatching,
    place,
)
from governor_mechanism.scene import TURNING, Part

Array = NDArray[np.float64]


def background(part: Part, poses: Array) -> tuple[Shape, ...]:
    """The axis of a turning plane, guides of the ground, and hatched feet under the ground's pins."""
    mechanism = part.mechanism
    u = mechanism.size
    shapes: list[Shape] = []
    middle = float(poses[:, :, 1].mean())
    if part.plane == TURNING:
        pins = [point.y for point in _points_on(mechanism, GROUND)]
        low, high = min(float(poses[:, :, 1].min()), *pins), max(float(poses[:, :, 1].max()), *pins)
        shapes.append(Lines("axis", (((0.0, low - 0.2 * u), (0.0, high + 0.2 * u)),)))
    for joint in mechanism.joints:
        for mine, other in ((joint.first, joint.second), (joint.second, joint.first)):
            if mine.body != GROUND:
                continue
            if isinstance(joint, Slider) and mine is joint.first:
                shapes.append(_guide(mechanism, joint, other, poses))
            elif not isinstance(joint, Slider):
                shapes += _foot((mine.x, mine.y), u, above=mine.y > middle)
    return tuple(shapes)


def moving(part: Part, pose: Array) -> tuple[Shape, ...]:
    """Bodies, links and joints at one pose."""
    mechanism = part.mechanism
    u = mechanism.size
    poses = _poses(pose)
    shapes: list[Shape] = []
    for body, at in zip(mechanism.bodies, poses, strict=True):
        shapes += [
            bar("arm", at[:2], place(at, point), 0.05 * u)
            for point in _points_on(mechanism, body.name)
            if math.hypot(point.x, point.y) > 1e-6 * u
        ]
    spots: list[Pair] = []
    for joint in mechanism.joints:
        first, second = (_where(mechanism, poses, point) for point in (joint.first, joint.second))
        if isinstance(joint, Distance):
            shapes.append(bar("link", first, second, 0.036 * u))
        if isinstance(joint, Slider):
            shapes.append(_block(joint, poses, mechanism, second, u))
        spots += [first, second] if isinstance(joint, Distance) else [second]
    shapes += [
        Circle("ball", at[0], at[1], 0.7 * ball_radius(body.mass, u))
        for body, at in zip(mechanism.bodies, poses, strict=True)
    ]
    return (*shapes, *(Circle("pivot", *spot, 0.02 * u) for spot in spots))


def plan(part: Part, pose: Array, angle: float) -> tuple[Shape, ...]:
    """Every body at its distance from the axis, seen from above."""
    c, s = math.cos(angle), math.sin(angle)
    u = part.mechanism.size
    places = [(at[0] * c, at[0] * s) for at in _poses(pose)]
    return (
        *(bar("arm", (0.0, 0.0), spot, 0.05 * u) for spot in places),
        *(
            Circle("ball", *spot, 0.7 * ball_radius(body.mass, u))
            for body, spot in zip(part.mechanism.bodies, places, strict=True)
        ),
    )


def _poses(pose: Array) -> list[Pose]:
    return [(float(x), float(y), float(angle)) for x, y, angle in pose]


def _where(mechanism: Mechanism, poses: list[Pose], point: Point) -> Pair:
    index = mechanism.body_index(point.body)
    return (point.x, point.y) if index < 0 else place(poses[index], point)


def _points_on(mechanism: Mechanism, name: str) -> list[Point]:
    ends = [point for joint in mechanism.joints for point in (joint.first, joint.second)]
    return [point for point in ends if point.body == name]


def _foot(spot: Pair, u: float, *, above: bool) -> tuple[Shape, ...]:
    """A bracket under a pin of the ground, or above it where the mechanism hangs from it."""
    x, y = spot
    w, h, ground = 0.06 * u, 0.09 * u, 0.04 * u
    base = y + h if above else y - h
    box = (x - 1.5 * w, x + 1.5 * w, *((base, base + ground) if above else (base - ground, base)))
    return Polygon("frame", ((x, y), (x - w, base), (x + w, base))), hatching("hatching", box, 0.034 * u)


def _guide(mechanism: Mechanism, joint: Slider, rider: Point, poses: Array) -> Shape:
    """A line along the slider, as long as the rider's way over the run and a little more."""
    c, s = math.cos(joint.angle), math.sin(joint.angle)
    x, y, turn = np.moveaxis(poses[:, mechanism.body_index(rider.body), :], -1, 0)
    ahead = x + np.cos(turn) * rider.x - np.sin(turn) * rider.y - joint.first.x
    aloft = y + np.sin(turn) * rider.x + np.cos(turn) * rider.y - joint.first.y
    along = ahead * c + aloft * s
    ends = (float(along.min()) - 0.15 * mechanism.size, float(along.max()) + 0.15 * mechanism.size)
    return Lines("guide", (tuple((joint.first.x + d * c, joint.first.y + d * s) for d in ends),))


def _block(joint: Slider, poses: list[Pose], mechanism: Mechanism, spot: Pair, u: float) -> Shape:
    """A sliding block on its line, turned with the body that carries the line."""
    index = mechanism.body_index(joint.first.body)
    angle = joint.angle + (poses[index][2] if index >= 0 else 0.0)
    c, s = math.cos(angle), math.sin(angle)
    a, b = 0.075 * u, 0.045 * u
    corners = ((a, b), (-a, b), (-a, -b), (a, -b))
    return Polygon("sleeve", tuple((spot[0] + f * c - g * s, spot[1] + f * s + g * c) for f, g in corners))

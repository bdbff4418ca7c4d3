"""The drawing that fits every mechanism, from its bodies, joints, loads and poses alone."""

from __future__ import annotations

import math

from governor_mechanism.model.joints import GROUND, Distance
from governor_mechanism.model.scene import TURNING, Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.body_points import poses_of, where
from governor_mechanism.render.geometry.primitives import Circle, Lines, Shape, ball_radius, bar
from governor_mechanism.render.machines.generic.bodies import bodies, tracers
from governor_mechanism.render.machines.generic.effects import fittings
from governor_mechanism.render.machines.generic.force_elements import arrows, drives, spans, spirals, walls
from governor_mechanism.render.machines.generic.gears import beds, racks, wheels
from governor_mechanism.render.machines.generic.guides import blocks, feet, guides, pins
from governor_mechanism.render.run_extents import Stage
from governor_mechanism.types import FloatArray

LINK, PIN = 0.040, 0.020
"""Width of a massless link and radius of a pin, as fractions of the stage's unit."""


def background(part: Part, poses: FloatArray, stage: Stage) -> tuple[Shape, ...]:
    """The axis of a turning plane, what guides points on the ground, feet, and walls."""
    u = stage.unit
    shapes: list[Shape] = []
    if part.plane == TURNING:
        ends = [point for joint in part.mechanism.joints for point in (joint.first, joint.second)]
        pins = [point.y for point in ends if point.body == GROUND]
        low, high = (
            min(float(poses[:, :, 1].min()), *pins, math.inf),
            max(float(poses[:, :, 1].max()), *pins, -math.inf),
        )
        shapes.append(Lines("axis", (((0.0, low - 0.2 * u), (0.0, high + 0.2 * u)),)))
    middle = poses_of(poses[len(poses) // 2])
    shapes += guides(part, middle, stage, fixed=True)
    shapes += beds(part, middle, stage)
    shapes += feet(part, stage)
    shapes += walls(part, middle, stage)
    return tuple(shapes)


def moving(part: Part, pose: FloatArray, stage: Stage) -> tuple[Shape, ...]:
    """Wheels, bodies, links, blocks, loads and pins at one pose."""
    mechanism, u = part.mechanism, stage.unit
    poses = poses_of(pose)
    behind, front = bodies(part, poses, stage)
    links = [
        bar("link", where(mechanism, poses, joint.first), where(mechanism, poses, joint.second), LINK * u)
        for joint in mechanism.joints
        if isinstance(joint, Distance)
    ]
    return (
        *racks(part, poses, stage),
        *wheels(part, poses, stage),
        *behind,
        *guides(part, poses, stage, fixed=False),
        *links,
        *spans(part, poses, stage),
        *blocks(part, poses, stage),
        *front,
        *spirals(part, poses, stage),
        *drives(part, poses, stage),
        *(Circle("pivot", *spot, PIN * u) for spot in pins(part, poses)),
        *fittings(part, poses, stage),
        *tracers(part, poses, stage),
        *arrows(part, poses, stage),
    )


def plan(part: Part, pose: FloatArray, angle: float, _: Acting = NOTHING) -> tuple[Shape, ...]:
    """Every body at its distance from the axis, seen from above."""
    c, s = math.cos(angle), math.sin(angle)
    u = part.mechanism.size
    places = [(at[0] * c, at[0] * s) for at in poses_of(pose)]
    return (
        *(bar("arm", (0.0, 0.0), spot, 0.05 * u) for spot in places),
        *(
            Circle("ball", *spot, 0.7 * ball_radius(body.mass, u))
            for body, spot in zip(part.mechanism.bodies, places, strict=True)
        ),
    )

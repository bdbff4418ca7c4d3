"""Generic drawing of any mechanism from its bodies, joints, force elements and poses."""

from __future__ import annotations

import math

from governor_mechanism.model.joints import GROUND, Distance
from governor_mechanism.model.part import TURNING_PLANE, Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.body_points import as_pose_tuples, point_position
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, drawn_ball_radius, make_bar
from governor_mechanism.render.machines.generic.bodies import body_shapes, tracer_shapes
from governor_mechanism.render.machines.generic.effects import output_effect_shapes
from governor_mechanism.render.machines.generic.force_elements import (
    drive_shapes,
    force_arrow_shapes,
    torsional_element_shapes,
    translational_element_shapes,
    wall_shapes,
)
from governor_mechanism.render.machines.generic.gears import rack_bed_shapes, rack_shapes, wheel_shapes
from governor_mechanism.render.machines.generic.guides import block_shapes, foot_shapes, guide_shapes, pin_centres
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_LINK_WIDTH, _PIN_RADIUS = 0.040, 0.020
"""Width of a massless link and radius of a pin, as fractions of the length scale."""


def generic_background_shapes(part: Part, poses: FloatArray, extents: RunExtents) -> tuple[DrawnShape, ...]:
    """Return the axis of a rotating plane, the guides on the ground, feet and walls."""
    u = extents.length_scale
    shapes: list[DrawnShape] = []
    if part.plane == TURNING_PLANE:
        ends = [point for joint in part.mechanism.joints for point in (joint.first, joint.second)]
        pins = [point.y for point in ends if point.body == GROUND]
        low, high = (min(float(poses[:, :, 1].min()), *pins, math.inf), max(float(poses[:, :, 1].max()), *pins, -math.inf))
        shapes.append(Lines("axis", (((0.0, low - 0.2 * u), (0.0, high + 0.2 * u)),)))
    mid_poses = as_pose_tuples(poses[len(poses) // 2])
    shapes += guide_shapes(part, mid_poses, extents, fixed=True)
    shapes += rack_bed_shapes(part, mid_poses, extents)
    shapes += foot_shapes(part, extents)
    shapes += wall_shapes(part, mid_poses, extents)
    return tuple(shapes)


def generic_moving_shapes(part: Part, pose: FloatArray, extents: RunExtents) -> tuple[DrawnShape, ...]:
    """Return wheels, bodies, links, blocks, force elements and pins at one pose."""
    mechanism, u = part.mechanism, extents.length_scale
    poses = as_pose_tuples(pose)
    behind, front = body_shapes(part, poses, extents)
    links = [
        make_bar("link", point_position(mechanism, poses, joint.first), point_position(mechanism, poses, joint.second), _LINK_WIDTH * u)
        for joint in mechanism.joints
        if isinstance(joint, Distance)
    ]
    return (
        *rack_shapes(part, poses, extents),
        *wheel_shapes(part, poses, extents),
        *behind,
        *guide_shapes(part, poses, extents, fixed=False),
        *links,
        *translational_element_shapes(part, poses, extents),
        *block_shapes(part, poses, extents),
        *front,
        *torsional_element_shapes(part, poses, extents),
        *drive_shapes(part, poses, extents),
        *(Circle("pivot", *point, _PIN_RADIUS * u) for point in pin_centres(part, poses)),
        *output_effect_shapes(part, poses, extents),
        *tracer_shapes(part, poses, extents),
        *force_arrow_shapes(part, poses, extents),
    )


def generic_plan_shapes(part: Part, pose: FloatArray, angle: float, _: EffectState = NO_EFFECTS) -> tuple[DrawnShape, ...]:
    """Return every body at its distance from the axis, seen from above."""
    c, s = math.cos(angle), math.sin(angle)
    u = part.mechanism.length_scale
    positions = [(position_in_plane[0] * c, position_in_plane[0] * s) for position_in_plane in as_pose_tuples(pose)]
    return (
        *(make_bar("arm", (0.0, 0.0), point, 0.05 * u) for point in positions),
        *(
            Circle("ball", *point, 0.7 * drawn_ball_radius(body.mass, u))
            for body, point in zip(part.mechanism.bodies, positions, strict=True)
        ),
    )

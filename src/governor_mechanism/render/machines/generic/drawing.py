"""Generic drawing of any mechanism from its bodies, joints, force elements and poses."""

import math
from collections.abc import Iterator

from governor_mechanism.model.joints import GROUND, Distance
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import EffectState
from governor_mechanism.render.geometry.body_points import as_pose_tuples
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, drawn_ball_radius, make_bar
from governor_mechanism.render.machines.generic import bodies, effects, force_elements, gears, guides
from governor_mechanism.render.machines.generic.placed_mechanism import PlacedMechanism
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_LINK_WIDTH, _PIN_RADIUS = 0.040, 0.020
"""Width of a massless link and radius of a pin, as fractions of the length scale."""


def background_shapes(part: Part, poses: FloatArray, extents: RunExtents) -> Iterator[DrawnShape]:
    """Yield the axis of a rotating plane, the guides on the ground, feet and walls."""
    placed = PlacedMechanism(part=part, poses=as_pose_tuples(poses[len(poses) // 2]), extents=extents)
    if part.turns:
        fixed_points = [point for joint in placed.joints for point in (joint.first, joint.second) if point.body == GROUND]
        heights = [float(poses[:, :, 1].min()), float(poses[:, :, 1].max()), *(point.y for point in fixed_points)]
        yield Lines("axis", (((0.0, min(heights) - 0.2 * placed.unit), (0.0, max(heights) + 0.2 * placed.unit)),))
    yield from guides.guide_shapes(placed, fixed=True)
    yield from gears.rack_bed_shapes(placed)
    yield from guides.foot_shapes(placed)
    yield from force_elements.wall_shapes(placed)


def moving_shapes(part: Part, pose: FloatArray, extents: RunExtents) -> Iterator[DrawnShape]:
    """Yield wheels, bodies, links, blocks, force elements and pins at one pose; masses and balls are in front of plates and links."""
    placed = PlacedMechanism(part=part, poses=as_pose_tuples(pose), extents=extents)
    shapes_of_bodies = list(bodies.body_shapes(placed))
    yield from gears.rack_shapes(placed)
    yield from gears.wheel_shapes(placed)
    yield from (shape for shape in shapes_of_bodies if shape.role not in ("block", "ball"))
    yield from guides.guide_shapes(placed, fixed=False)
    for joint in placed.joints:
        if isinstance(joint, Distance):
            yield make_bar("link", placed.position(joint.first), placed.position(joint.second), _LINK_WIDTH * placed.unit)
    yield from force_elements.translational_element_shapes(placed)
    yield from guides.block_shapes(placed)
    yield from (shape for shape in shapes_of_bodies if shape.role in ("block", "ball"))
    yield from force_elements.torsional_element_shapes(placed)
    yield from force_elements.drive_shapes(placed)
    yield from (Circle("pivot", *point, _PIN_RADIUS * placed.unit) for point in guides.pin_centres(placed))
    yield from effects.output_effect_shapes(placed)
    yield from bodies.tracer_shapes(placed)
    yield from force_elements.force_arrow_shapes(placed)


def plan_shapes(part: Part, pose: FloatArray, angle: float, _: EffectState) -> Iterator[DrawnShape]:
    """Yield every body at its distance from the axis, seen from above."""
    c, s = math.cos(angle), math.sin(angle)
    u = part.mechanism.length_scale
    positions = [(x * c, x * s) for x, _, _ in as_pose_tuples(pose)]
    yield from (make_bar("arm", (0.0, 0.0), point, 0.05 * u) for point in positions)
    for body, point in zip(part.mechanism.bodies, positions, strict=True):
        yield Circle("ball", *point, 0.7 * drawn_ball_radius(body.mass, u))

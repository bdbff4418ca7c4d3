"""Drawing of the pendulum governor: spindle, cross piece, arms, links, balls, and the sleeve with its load."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.machines.pendulum.bodies import LEFT_BALL, RIGHT_BALL
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.free_space import first_free_position, horizontal_extents, select_extreme_poses
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.governor_parts import bearing_shapes, lift_scale_shapes, lift_ticks, spindle_shapes
from governor_mechanism.render.machines.pendulum.clearance import clearance_lens_contents, clearance_lens_frame, clearance_slot_shapes
from governor_mechanism.render.machines.pendulum.effects import (
    pendulum_moving_effect_shapes,
    pendulum_static_effect_shapes,
    spindle_foot_distance,
)
from governor_mechanism.render.machines.pendulum.proportions import (
    ARM_WIDTH,
    LINK_WIDTH,
    PENDULUM_SPINDLE_HALF_WIDTH,
    PIVOT_RADIUS,
    PendulumProportions,
    pendulum_ball_centres,
    pendulum_proportions,
    pendulum_sides,
    pendulum_sleeve_height,
)
from governor_mechanism.render.machines.pendulum.sleeve import pendulum_sleeve_shapes
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_SCALE_WIDTH = 0.365
"""Width of the lift scale with its numbers, as a fraction of the arm."""


def pendulum_background_shapes(part: Part, poses: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return the spindle in its bearings, the suspension, the axis, the lift scale, and the effects fixed to the frame."""
    governor = pendulum_proportions(part, NO_EFFECTS if extents is None else extents.effect_state)
    u = governor.arm
    heights = pendulum_sleeve_height(governor, part, poses)
    lowest, highest = float(heights.min()), float(heights.max())
    width, drop = governor.sleeve_size
    spindle_foot = lowest - drop - spindle_foot_distance(governor, (lowest, highest))
    w, zero_lift_height = PENDULUM_SPINDLE_HALF_WIDTH * u, governor.zero_lift_height
    linkage_shapes = [shape for pose in select_extreme_poses(poses) for shape in _linkage_shapes(governor, part, pose)]
    return (
        *spindle_shapes(w, (spindle_foot - 0.29 * u, 0.40 * u), spindle_foot - 0.16 * u, 0.33 * u),
        *bearing_shapes(w, 0.15 * u, 0.17 * u, 0.27 * u, 0.034 * u),
        *bearing_shapes(w, 0.15 * u, spindle_foot - 0.14 * u, spindle_foot - 0.04 * u, 0.034 * u),
        make_rectangle("spindle", -1.6 * w, 1.6 * w, spindle_foot - 0.04 * u, spindle_foot - 0.012 * u),
        *pendulum_static_effect_shapes(governor),
        *_suspension_shapes(governor),
        *_lift_scale_shapes(governor, linkage_shapes, width + 0.10 * u, (lowest - zero_lift_height, highest - zero_lift_height)),
        *clearance_lens_frame(governor),
    )


def pendulum_moving_shapes(part: Part, pose: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return sleeve, links, arms, balls, pins and their effects; the right half covers the left one."""
    effect_state, time = (NO_EFFECTS, 0.0) if extents is None else (extents.effect_state, extents.time)
    governor = pendulum_proportions(part, effect_state)
    u = governor.arm
    height = float(pendulum_sleeve_height(governor, part, pose))
    sides = pendulum_sides(governor, part, pose)
    behind, front = pendulum_moving_effect_shapes(governor, part, pose, time)
    pivots = [point for side in sides for point in (side.arm_pivot, side.link_joint, side.link_end)]
    return (
        *behind,
        *pendulum_sleeve_shapes(governor, height),
        *clearance_slot_shapes(governor, height),
        *_linkage_shapes(governor, part, pose),
        *(Lines("ball shine", _highlight_arcs(side.ball, governor.ball_radius)) for side in sides),
        *(Circle("pivot", *point, PIVOT_RADIUS * u) for point in pivots),
        *front,
        *clearance_lens_contents(governor, part, pose, time),
    )


def pendulum_plan_shapes(part: Part, pose: FloatArray, angle: float, effect_state: EffectState = NO_EFFECTS) -> tuple[DrawnShape, ...]:
    """Return sleeve, arms and balls from above; a mark identifies the right ball."""
    governor = pendulum_proportions(part, effect_state)
    c, s = math.cos(angle), math.sin(angle)
    right, left = (float(pendulum_ball_centres(governor, part, pose, name)[0]) for name in (RIGHT_BALL, LEFT_BALL))
    ball_positions = [(left * c, left * s), (right * c, right * s)]
    radius = governor.ball_radius
    return (
        Circle("sleeve", 0.0, 0.0, governor.sleeve_size[0]),
        Lines("plan arm", ((ball_positions[0], ball_positions[1]),)),
        *(Circle("ball", *point, radius) for point in ball_positions),
        Circle("mark", *ball_positions[1], 0.42 * radius),
    )


def pendulum_ball_path(part: Part, poses: FloatArray) -> FloatArray:
    """Return the path (n, 2) (m) of the centre of the right ball."""
    return pendulum_ball_centres(pendulum_proportions(part), part, poses)


def _linkage_shapes(governor: PendulumProportions, part: Part, pose: FloatArray) -> tuple[DrawnShape, ...]:
    """Return links, arms and balls."""
    u, shapes = governor.arm, list[DrawnShape]()
    sides = pendulum_sides(governor, part, pose)
    for side in sides:
        # A link with mass is drawn as a rod.
        role, width = ("rod", 1.2 * LINK_WIDTH) if governor.has_link_bodies else ("link", LINK_WIDTH)
        shapes += [make_bar(role, side.link_joint, side.link_end, width * u), make_bar("arm", side.arm_pivot, side.ball, ARM_WIDTH * u)]
    return (*shapes, *(Circle("ball", *side.ball, governor.ball_radius) for side in sides))


def _highlight_arcs(ball: Vec2, radius: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return two arcs inside the upper left rim of the ball: the highlight of a sphere."""
    return tuple(
        tuple(
            (ball[0] + radius_ratio * radius * math.cos(a), ball[1] + radius_ratio * radius * math.sin(a))
            for a in (math.radians(135 + half_angle * (k / 6 - 1)) for k in range(13))
        )
        for radius_ratio, half_angle in ((0.78, 42.0), (0.60, 30.0))
    )


def _suspension_shapes(governor: PendulumProportions) -> tuple[DrawnShape, ...]:
    """Return the cross piece with the arm pins, keyed to the spindle."""
    u = governor.arm
    half_length = abs(governor.offset)
    return (
        make_rectangle("frame", -0.062 * u, 0.062 * u, -0.062 * u, 0.085 * u),
        make_bar("frame", (-half_length, 0.0), (half_length, 0.0), 0.085 * u),
    )


def _lift_scale_shapes(
    governor: PendulumProportions, linkage_shapes: Sequence[DrawnShape], preferred_x: float, lifts: Vec2
) -> tuple[DrawnShape, ...]:
    """Return a scale (mm) that covers the lifts (m), lowest and highest, at the height of the pointer.

    It is at x = `preferred_x` (m), or further out with leader lines if a part of the linkage passes there.
    """
    u = governor.arm
    shift = governor.zero_lift_height - governor.sleeve_size[1]
    ticks_mm = lift_ticks(lifts, shift, 0.04 * u, 0.1 * u)
    bottom, top = ticks_mm[0][1] - 0.04 * u, ticks_mm[-1][1] + 0.04 * u
    # Leave a small gap to the linkage.
    x = first_free_position(horizontal_extents(linkage_shapes, bottom, top), preferred_x - 0.01 * u, _SCALE_WIDTH * u)
    x = preferred_x if x < preferred_x else x + 0.05 * u
    leaders = () if x == preferred_x else (Lines("leader", tuple(((preferred_x, y), (x, y)) for _, y in ticks_mm)),)
    # Text keeps its size when a wide machine is drawn at a small scale: far out, its space grows with the width.
    text_width = 0.3 * u if x == preferred_x else 0.4 * x
    return (*leaders, *lift_scale_shapes(x, ticks_mm, (0.05 * u, 0.03 * u, 0.065 * u, text_width)))

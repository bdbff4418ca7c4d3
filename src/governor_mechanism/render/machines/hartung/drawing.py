"""Drawing of Hartung's governor: hollow weights with their springs, bell cranks, hangers, sleeve and spindle."""

from __future__ import annotations

import math

from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines.governor_parts import (
    bearing_shapes,
    both_sides,
    lift_scale_shapes,
    lift_ticks,
    mirror_outline,
    spindle_shapes,
)
from governor_mechanism.render.machines.hartung.effects import (
    hartung_impact_shapes,
    hartung_moving_effect_shapes,
    hartung_static_effect_shapes,
    spindle_collar_height,
)
from governor_mechanism.render.machines.hartung.proportions import (
    HARTUNG_SPINDLE_HALF_WIDTH,
    HartungProportions,
    HartungSide,
    hartung_proportions,
    hartung_sides,
    hartung_sleeve_height,
    hartung_weight_centres,
)
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

# Widths and radii as fractions of the weight arm.
_ARM_WIDTH, _HANGER_WIDTH, _PIVOT_RADIUS, _ROD_HALF_WIDTH = 0.17, 0.12, 0.055, 0.05
_N_SPRING_TURNS = 8
"""Coils of each spring; as many as stay distinguishable when the spring is compressed."""


def hartung_background_shapes(part: Part, poses: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return the spindle in its bearings, the frame with fulcrums and spring seats, and the lift scale."""
    governor = hartung_proportions(part, NO_EFFECTS if extents is None else extents.effect_state)
    u, w = governor.arm, HARTUNG_SPINDLE_HALF_WIDTH * governor.arm
    heights = hartung_sleeve_height(part, poses)
    lowest, highest = float(heights.min()), float(heights.max())
    collar_height, top = spindle_collar_height(governor, lowest), governor.half_height + 0.34 * u
    zero = governor.zero_lift_height
    ticks = lift_ticks((lowest - zero, highest - zero), zero, 0.1 * u, 0.3 * u)
    return (
        *spindle_shapes(w, (collar_height - 0.42 * u, top + 0.2 * u), collar_height - 0.30 * u, top + 0.08 * u),
        *bearing_shapes(w, 0.42 * u, top - 0.16 * u, top, 0.09 * u),
        *bearing_shapes(w, 0.42 * u, collar_height - 0.26 * u, collar_height - 0.10 * u, 0.09 * u),
        make_rectangle("spindle", -1.7 * w, 1.7 * w, collar_height - 0.10 * u, collar_height - 0.04 * u),
        *_frame_shapes(governor),
        *hartung_static_effect_shapes(governor, (lowest, highest)),
        *lift_scale_shapes(governor.sleeve_size[0] + 0.38 * u, ticks, (0.14 * u, 0.08 * u, 0.18 * u, 0.9 * u)),
    )


def hartung_moving_shapes(part: Part, pose: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return sleeve, hangers, weights, bell cranks and springs; the right half covers the left one."""
    effect_state, time = (NO_EFFECTS, 0.0) if extents is None else (extents.effect_state, extents.time)
    governor = hartung_proportions(part, effect_state)
    u, height = governor.arm, float(hartung_sleeve_height(part, pose))
    sides = hartung_sides(governor, part, pose)
    coil_strands = [_coil_strands(governor, side) for side in sides]
    behind, front = (tuple(line for pair in coil_strands for line in pair[k]) for k in (0, 1))
    seat, half_rod = governor.spring_seat_radius, _ROD_HALF_WIDTH * u
    return (
        *hartung_moving_effect_shapes(governor, height, time),
        *_sleeve_shapes(governor, height),
        *(shape for side in sides for shape in _weight_shapes(governor, side)),
        *(shape for side in sides for shape in _crank_shapes(governor, side)),
        Lines("coil behind", behind),
        make_rectangle("rod", -seat, seat, -half_rod, half_rod),
        Lines("coil edge", front),
        Lines("coil", front),
        *(Circle("pivot", *point, _PIVOT_RADIUS * u) for side in sides for point in (side.fulcrum, side.sleeve_arm_end, side.lug)),
        *hartung_impact_shapes(governor, sides, time),
    )


def hartung_plan_shapes(part: Part, pose: FloatArray, angle: float, effect_state: EffectState = NO_EFFECTS) -> tuple[DrawnShape, ...]:
    """Return weights, cross rod and sleeve from above; a mark identifies the right weight."""
    governor = hartung_proportions(part, effect_state)
    c, s = math.cos(angle), math.sin(angle)

    def rotate(x: float, y: float) -> Vec2:
        """Rotate a point (m) by the spindle angle."""
        return c * x - s * y, s * x + c * y

    w, h = governor.half_width, governor.half_height
    left, right = (side.weight[0] for side in hartung_sides(governor, part, pose))
    blocks = (((x - w, -h), (x + w, -h), (x + w, h), (x - w, h)) for x in (left, right))
    ends = rotate(-governor.spring_seat_radius, 0.0), rotate(governor.spring_seat_radius, 0.0)
    return (
        Lines("plan arm", (ends,)),
        *(Polygon("ball", tuple(rotate(*corner) for corner in block)) for block in blocks),
        Circle("sleeve", 0.0, 0.0, 0.3 * governor.arm),
        Circle("mark", *rotate(right, 0.0), 0.3 * h),
    )


def hartung_weight_path(part: Part, poses: FloatArray) -> FloatArray:
    """Return the path (n, 2) (m) of the centre of the right weight."""
    return hartung_weight_centres(hartung_proportions(part), part, poses)


def _weight_shapes(governor: HartungProportions, side: HartungSide) -> list[DrawnShape]:
    """Return a weight in section: the bore for its spring is open outward. It stays upright or rotates with its arm."""
    w, h, bore, wall = governor.half_width, governor.half_height, governor.bore_half_height, 0.28 * governor.half_width
    tilt_angle = side.lever_angle if governor.weights_rotate else 0.0
    c, s = math.cos(tilt_angle), math.sin(tilt_angle)

    def to_plane(x: float, y: float) -> Vec2:
        """Return the point of the drawing at (x, y) in the axes of the weight (m)."""
        return side.weight[0] + side.sign * (c * x - s * y), side.weight[1] + s * x + c * y

    corner = 0.12 * h
    lower = [(-w, -h + corner), (-w + corner, -h), (w - corner, -h), (w, -h + corner)]
    outline = [*lower, *((-x, -y) for x, y in lower)]
    hollow = [(-w + wall, -bore), (w, -bore), (w, bore), (-w + wall, bore)]
    shine = (to_plane(-w + 1.6 * corner, h - 0.9 * corner), to_plane(w - 1.6 * corner, h - 0.9 * corner))
    return [
        Polygon("ball", tuple(to_plane(*point) for point in outline)),
        Polygon("weight bore", tuple(to_plane(*point) for point in hollow)),
        Lines("ball shine", (shine,)),
    ]


def _crank_shapes(governor: HartungProportions, side: HartungSide) -> list[DrawnShape]:
    """Return hanger and bell crank of one side; the boss of the crank is at the fulcrum."""
    u = governor.arm
    shapes: list[DrawnShape] = [make_bar("link", side.sleeve_arm_end, side.lug, _HANGER_WIDTH * u)]
    if math.isinf(governor.hanger_length):
        (x, y), half = side.lug, 0.10 * u
        shapes.append(make_rectangle("block", x - half, x + half, y - 0.7 * half, y + 0.7 * half))
    arms = (make_bar("arm", side.fulcrum, end, _ARM_WIDTH * u) for end in (side.weight, side.sleeve_arm_end))
    return [*shapes, *arms, Circle("arm", *side.fulcrum, 0.13 * u)]


def _coil_strands(governor: HartungProportions, side: HartungSide) -> tuple[tuple[tuple[Vec2, ...], ...], tuple[tuple[Vec2, ...], ...]]:
    """Return the strands of a spring from the inner wall of the weight to its seat: those behind the cross rod, those in front of it."""
    start = abs(side.weight[0]) - governor.half_width + 0.28 * governor.half_width
    pitch = (governor.spring_seat_radius - start) / _N_SPRING_TURNS
    half_height = 0.80 * governor.bore_half_height
    low = [(side.sign * (start + (k + 0.1) * pitch), -half_height) for k in range(_N_SPRING_TURNS)]
    high = [(side.sign * (start + (k + 0.55) * pitch), half_height) for k in range(_N_SPRING_TURNS)]
    return tuple(zip(high[:-1], low[1:], strict=True)), tuple(zip(low, high, strict=True))


def _frame_shapes(governor: HartungProportions) -> tuple[DrawnShape, ...]:
    """Return the beam with the fulcrums, keyed to the spindle, and the hub and end plates of the cross rod."""
    u, (x, y) = governor.arm, governor.fulcrum
    plate, bore, seat = 0.06 * u, governor.bore_half_height, governor.spring_seat_radius
    return (
        make_rectangle("frame", -0.2 * u, 0.2 * u, y - 0.12 * u, 0.12 * u),
        make_bar("frame", (-x, y), (x, y), 0.19 * u),
        *(make_rectangle("seat", *side, -1.05 * bore, 1.05 * bore) for side in reversed(both_sides(seat, seat + plate))),
        *(make_rectangle("rod", *side, -0.11 * u, 0.11 * u) for side in reversed(both_sides(seat + plate, seat + 2.4 * plate))),
    )


def _sleeve_shapes(governor: HartungProportions, height: float) -> tuple[DrawnShape, ...]:
    """Return head, collar with the groove for the fork, and a pointer; vertical hangers slide in a slot of the head."""
    u, (half_width, drop) = governor.arm, governor.sleeve_size
    head_half_height, base = 0.14 * u, height - drop
    neck, flange = 0.62 * half_width, 0.14 * u
    waist = height - 1.6 * head_half_height
    outline = (
        (half_width, height + head_half_height),
        (half_width, height - head_half_height),
        (0.72 * half_width, waist),
        (0.72 * half_width, base + 2.6 * flange),
        (neck, base + 2.6 * flange),
        (neck, base + flange),
        (0.9 * half_width, base + flange),
        (0.9 * half_width, base),
    )
    x, y = half_width - 0.06 * u, 0.065 * u
    slot = ((-x, height - y), (x, height - y), (x, height + y), (-x, height + y)) if math.isinf(governor.hanger_length) else ()
    strokes = tuple(((part * half_width, waist - 0.02 * u), (part * half_width, base + 2.7 * flange)) for part in (0.44, 0.56, 0.65))
    tip = half_width + 0.34 * u
    return (
        Polygon("sleeve", mirror_outline(outline)),
        Lines("engraving", strokes),
        Polygon("slot", slot),
        Polygon("pointer", ((tip, height), (tip - 0.2 * u, height + 0.08 * u), (tip - 0.2 * u, height - 0.08 * u))),
    )

"""Drawing of Hartung's governor: hollow weights with their springs, bell cranks, hangers, sleeve and spindle."""

from __future__ import annotations

import math

from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.primitives import (
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    TextShape,
    Vec2,
    make_bar,
    make_hatching,
    make_rectangle,
    round_step,
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
    return (
        Lines("axis", (((0.0, collar_height - 0.42 * u), (0.0, top + 0.2 * u)),)),
        make_rectangle("spindle", -w, w, collar_height - 0.30 * u, top + 0.08 * u),
        Lines("spindle shade", (((0.45 * w, collar_height - 0.30 * u), (0.45 * w, top + 0.08 * u)),)),
        *_bearing_shapes(u, top - 0.16 * u, top),
        *_bearing_shapes(u, collar_height - 0.26 * u, collar_height - 0.10 * u),
        make_rectangle("spindle", -1.7 * w, 1.7 * w, collar_height - 0.10 * u, collar_height - 0.04 * u),
        *_frame_shapes(governor),
        *hartung_static_effect_shapes(governor, (lowest, highest)),
        *_lift_scale_shapes(governor, (lowest - governor.zero_lift_height, highest - governor.zero_lift_height)),
    )


def hartung_moving_shapes(part: Part, pose: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return sleeve, hangers, weights, bell cranks and springs; the right half covers the left one."""
    effect_state, time = (NO_EFFECTS, 0.0) if extents is None else (extents.effect_state, extents.time)
    governor = hartung_proportions(part, effect_state)
    u, height = governor.arm, float(hartung_sleeve_height(part, pose))
    sides = hartung_sides(governor, part, pose)
    shapes: list[DrawnShape] = [*hartung_moving_effect_shapes(governor, height, time), *_sleeve_shapes(governor, height)]
    shapes += [shape for side in sides for shape in _weight_shapes(governor, side)]
    shapes += [shape for side in sides for shape in _crank_shapes(governor, side)]
    coil_strands = [_coil_strands(governor, side) for side in sides]
    behind, front = (tuple(line for pair in coil_strands for line in pair[k]) for k in (0, 1))
    shapes += [
        Lines("coil behind", behind),
        make_rectangle("rod", -governor.spring_seat_radius, governor.spring_seat_radius, -_ROD_HALF_WIDTH * u, _ROD_HALF_WIDTH * u),
    ]
    shapes += [Lines("coil edge", front), Lines("coil", front)]
    shapes += [Circle("pivot", *point, _PIVOT_RADIUS * u) for side in sides for point in (side.fulcrum, side.sleeve_arm_end, side.lug)]
    return (*shapes, *hartung_impact_shapes(governor, sides, time))


def hartung_plan_shapes(part: Part, pose: FloatArray, angle: float, effect_state: EffectState = NO_EFFECTS) -> tuple[DrawnShape, ...]:
    """Return weights, cross rod and sleeve from above; a mark identifies the right weight."""
    governor = hartung_proportions(part, effect_state)
    c, s = math.cos(angle), math.sin(angle)

    def rotate(x: float, y: float) -> Vec2:
        """Rotate a point (m) by the spindle angle."""
        return c * x - s * y, s * x + c * y

    w, h = governor.half_width, governor.half_height
    blocks, weight_centres = list[DrawnShape](), list[Vec2]()
    for side in hartung_sides(governor, part, pose):
        x = side.weight[0]
        weight_centres.append(rotate(x, 0.0))
        corners = ((x - w, -h), (x + w, -h), (x + w, h), (x - w, h))
        blocks.append(Polygon("ball", tuple(rotate(*corner) for corner in corners)))
    ends = rotate(-governor.spring_seat_radius, 0.0), rotate(governor.spring_seat_radius, 0.0)
    return (
        Lines("plan arm", (ends,)),
        *blocks,
        Circle("sleeve", 0.0, 0.0, 0.3 * governor.arm),
        Circle("mark", *weight_centres[1], 0.3 * h),
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
    outline = [(-w, -h + corner), (-w + corner, -h), (w - corner, -h), (w, -h + corner)]
    outline += [(w, h - corner), (w - corner, h), (-w + corner, h), (-w, h - corner)]
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
    shapes.append(make_bar("arm", side.fulcrum, side.weight, _ARM_WIDTH * u))
    shapes.append(make_bar("arm", side.fulcrum, side.sleeve_arm_end, _ARM_WIDTH * u))
    shapes.append(Circle("arm", *side.fulcrum, 0.13 * u))
    return shapes


def _coil_strands(governor: HartungProportions, side: HartungSide) -> tuple[tuple[tuple[Vec2, ...], ...], tuple[tuple[Vec2, ...], ...]]:
    """Return the strands of a spring from the inner wall of the weight to its seat: those behind the cross rod, those in front of it."""
    start = abs(side.weight[0]) - governor.half_width + 0.28 * governor.half_width
    pitch = (governor.spring_seat_radius - start) / _N_SPRING_TURNS
    half_height, y = 0.80 * governor.bore_half_height, 0.0
    front, behind = [], []
    for k in range(_N_SPRING_TURNS):
        left, middle = start + (k + 0.1) * pitch, start + (k + 0.55) * pitch
        right = start + (k + 1.1) * pitch
        front.append(((side.sign * left, y - half_height), (side.sign * middle, y + half_height)))
        if k < _N_SPRING_TURNS - 1:
            behind.append(((side.sign * middle, y + half_height), (side.sign * right, y - half_height)))
    return tuple(behind), tuple(front)


def _frame_shapes(governor: HartungProportions) -> tuple[DrawnShape, ...]:
    """Return the beam with the fulcrums, keyed to the spindle, and the hub and end plates of the cross rod."""
    u, (x, y) = governor.arm, governor.fulcrum
    plate, bore = 0.06 * u, governor.bore_half_height
    return (
        make_rectangle("frame", -0.2 * u, 0.2 * u, y - 0.12 * u, 0.12 * u),
        make_bar("frame", (-x, y), (x, y), 0.19 * u),
        *(
            make_rectangle("seat", min(a, b), max(a, b), -1.05 * bore, 1.05 * bore)
            for a, b in (
                (governor.spring_seat_radius, governor.spring_seat_radius + plate),
                (-governor.spring_seat_radius, -governor.spring_seat_radius - plate),
            )
        ),
        *(
            make_rectangle("rod", min(a, b), max(a, b), -0.11 * u, 0.11 * u)
            for a, b in (
                (governor.spring_seat_radius + plate, governor.spring_seat_radius + 2.4 * plate),
                (-governor.spring_seat_radius - plate, -governor.spring_seat_radius - 2.4 * plate),
            )
        ),
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
    mirrored = tuple((-x, y) for x, y in reversed(outline))
    x, y = half_width - 0.06 * u, 0.065 * u
    slot = ((-x, height - y), (x, height - y), (x, height + y), (-x, height + y)) if math.isinf(governor.hanger_length) else ()
    strokes = tuple(((part * half_width, waist - 0.02 * u), (part * half_width, base + 2.7 * flange)) for part in (0.44, 0.56, 0.65))
    tip = half_width + 0.34 * u
    return (
        Polygon("sleeve", outline + mirrored),
        Lines("engraving", strokes),
        Polygon("slot", slot),
        Polygon("pointer", ((tip, height), (tip - 0.2 * u, height + 0.08 * u), (tip - 0.2 * u, height - 0.08 * u))),
    )


def _bearing_shapes(u: float, bottom: float, top: float) -> tuple[DrawnShape, ...]:
    """Return a bearing in section: two hatched blocks at the sides of the spindle, from bottom to top (m)."""
    inner, outer, shapes = HARTUNG_SPINDLE_HALF_WIDTH * u, 0.42 * u, list[DrawnShape]()
    for left, right in ((-outer, -inner), (inner, outer)):
        shapes += [make_rectangle("bearing", left, right, bottom, top), make_hatching("hatching", (left, right, bottom, top), 0.09 * u)]
    return tuple(shapes)


def _lift_scale_shapes(governor: HartungProportions, lifts: Vec2) -> tuple[DrawnShape, ...]:
    """Return a scale (mm) to the right of the sleeve that covers the lifts (m), lowest and highest."""
    u, (low, high) = governor.arm, lifts
    step = round_step(max(high - low, 0.1 * u), 5)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    # Long enough for two numbers without overlap.
    last = max(last, first + math.ceil(0.3 * u / step))
    ticks_mm = [(k, k * step + governor.zero_lift_height) for k in range(first, last + 1)]
    x = governor.sleeve_size[0] + 0.38 * u
    ticks = tuple(((x, y), (x + (0.14 if k in (first, last) else 0.08) * u, y)) for k, y in ticks_mm)
    labels = [
        TextShape("scale", x + 0.18 * u, y, f"{k * step * 1e3:.6g}{unit}", 0.9 * u)
        for (k, y), unit in ((ticks_mm[0], ""), (ticks_mm[-1], " mm"))
    ]
    return (Lines("scale", (((x, ticks_mm[0][1]), (x, ticks_mm[-1][1])), *ticks)), *labels)

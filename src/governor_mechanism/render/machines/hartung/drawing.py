"""The drawing of Hartung's governor: hollow weights with their springs, bell cranks, hangers, sleeve and spindle."""

from __future__ import annotations

import math

from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.primitives import (
    Circle,
    Lines,
    Pair,
    Polygon,
    Shape,
    Text,
    bar,
    hatching,
    nice_step,
    rectangle,
)
from governor_mechanism.render.machines.hartung.effects import blows, moving_fittings, still_fittings, undermost
from governor_mechanism.render.machines.hartung.proportions import (
    SPINDLE,
    Governor,
    Side,
    governor_of,
    sides_of,
    sleeve_height,
    weight_spots,
)
from governor_mechanism.render.run_extents import Stage
from governor_mechanism.types import FloatArray

# As fractions of the weights' arm.
ARM, HANGER, PIVOT, ROD = 0.17, 0.12, 0.055, 0.05
TURNS = 8
"""Of each spring, as many as can be told apart when it is pressed together."""


def background(part: Part, poses: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Spindle in its bearings, the frame that carries fulcrums and springs' seats, and the scale of the lift."""
    governor = governor_of(part, NOTHING if stage is None else stage.acting)
    u, w = governor.arm, SPINDLE * governor.arm
    heights = sleeve_height(part, poses)
    lowest, highest = float(heights.min()), float(heights.max())
    foot, top = undermost(governor, lowest), governor.half_height + 0.34 * u
    return (
        Lines("axis", (((0.0, foot - 0.42 * u), (0.0, top + 0.2 * u)),)),
        rectangle("spindle", -w, w, foot - 0.30 * u, top + 0.08 * u),
        Lines("spindle shade", (((0.45 * w, foot - 0.30 * u), (0.45 * w, top + 0.08 * u)),)),
        *_bearing(u, top - 0.16 * u, top),
        *_bearing(u, foot - 0.26 * u, foot - 0.10 * u),
        rectangle("spindle", -1.7 * w, 1.7 * w, foot - 0.10 * u, foot - 0.04 * u),
        *_frame(governor),
        *still_fittings(governor, (lowest, highest)),
        *_scale(governor, (lowest - governor.zero, highest - governor.zero)),
    )


def moving(part: Part, pose: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Sleeve, hangers, weights, bell cranks and springs; the right half passes before the left one."""
    acting, time = (NOTHING, 0.0) if stage is None else (stage.acting, stage.time)
    governor = governor_of(part, acting)
    u, height = governor.arm, float(sleeve_height(part, pose))
    sides = sides_of(governor, part, pose)
    shapes: list[Shape] = [*moving_fittings(governor, height, time), *_sleeve(governor, height)]
    shapes += [shape for side in sides for shape in _weight(governor, side)]
    shapes += [shape for side in sides for shape in _crank(governor, side)]
    strands = [_coil(governor, side) for side in sides]
    behind, front = (tuple(line for pair in strands for line in pair[k]) for k in (0, 1))
    shapes += [Lines("coil behind", behind), rectangle("rod", -governor.seat, governor.seat, -ROD * u, ROD * u)]
    shapes += [Lines("coil edge", front), Lines("coil", front)]
    shapes += [Circle("pivot", *spot, PIVOT * u) for side in sides for spot in (side.fulcrum, side.foot, side.lug)]
    return (*shapes, *blows(governor, sides, time))


def plan(part: Part, pose: FloatArray, angle: float, acting: Acting = NOTHING) -> tuple[Shape, ...]:
    """Weights, cross rod and sleeve from above; the right weight carries a mark."""
    governor = governor_of(part, acting)
    c, s = math.cos(angle), math.sin(angle)

    def turned(x: float, y: float) -> Pair:
        return c * x - s * y, s * x + c * y

    w, h = governor.half_width, governor.half_height
    blocks, spots = list[Shape](), list[Pair]()
    for side in sides_of(governor, part, pose):
        x = side.weight[0]
        spots.append(turned(x, 0.0))
        corners = ((x - w, -h), (x + w, -h), (x + w, h), (x - w, h))
        blocks.append(Polygon("ball", tuple(turned(*corner) for corner in corners)))
    ends = turned(-governor.seat, 0.0), turned(governor.seat, 0.0)
    return (
        Lines("plan arm", (ends,)),
        *blocks,
        Circle("sleeve", 0.0, 0.0, 0.3 * governor.arm),
        Circle("mark", *spots[1], 0.3 * h),
    )


def traced(part: Part, poses: FloatArray) -> FloatArray:
    """The path (n, 2) (m) of the right weight's centre."""
    return weight_spots(governor_of(part), part, poses)


def _weight(governor: Governor, side: Side) -> list[Shape]:
    """A block cut open: the bore for its spring is open outward. It keeps upright, or turns with its arm."""
    w, h, bore, wall = governor.half_width, governor.half_height, governor.bore, 0.28 * governor.half_width
    tilt = side.lever if governor.turning else 0.0
    c, s = math.cos(tilt), math.sin(tilt)

    def put(x: float, y: float) -> Pair:
        return side.weight[0] + side.sign * (c * x - s * y), side.weight[1] + s * x + c * y

    corner = 0.12 * h
    outline = [(-w, -h + corner), (-w + corner, -h), (w - corner, -h), (w, -h + corner)]
    outline += [(w, h - corner), (w - corner, h), (-w + corner, h), (-w, h - corner)]
    hollow = [(-w + wall, -bore), (w, -bore), (w, bore), (-w + wall, bore)]
    shine = (put(-w + 1.6 * corner, h - 0.9 * corner), put(w - 1.6 * corner, h - 0.9 * corner))
    return [
        Polygon("ball", tuple(put(*point) for point in outline)),
        Polygon("weight bore", tuple(put(*point) for point in hollow)),
        Lines("ball shine", (shine,)),
    ]


def _crank(governor: Governor, side: Side) -> list[Shape]:
    """Hanger and bell crank of one side; the crank's boss sits on the fulcrum."""
    u = governor.arm
    shapes: list[Shape] = [bar("link", side.foot, side.lug, HANGER * u)]
    if math.isinf(governor.hanger):
        (x, y), half = side.lug, 0.10 * u
        shapes.append(rectangle("block", x - half, x + half, y - 0.7 * half, y + 0.7 * half))
    shapes.append(bar("arm", side.fulcrum, side.weight, ARM * u))
    shapes.append(bar("arm", side.fulcrum, side.foot, ARM * u))
    shapes.append(Circle("arm", *side.fulcrum, 0.13 * u))
    return shapes


def _coil(governor: Governor, side: Side) -> tuple[tuple[tuple[Pair, ...], ...], tuple[tuple[Pair, ...], ...]]:
    """The strands of a spring from the weight's inner wall to its seat: those behind the cross rod, those before it."""
    start = abs(side.weight[0]) - governor.half_width + 0.28 * governor.half_width
    pitch = (governor.seat - start) / TURNS
    half, y = 0.80 * governor.bore, 0.0
    front, behind = [], []
    for k in range(TURNS):
        left, middle = start + (k + 0.1) * pitch, start + (k + 0.55) * pitch
        right = start + (k + 1.1) * pitch
        front.append(((side.sign * left, y - half), (side.sign * middle, y + half)))
        if k < TURNS - 1:
            behind.append(((side.sign * middle, y + half), (side.sign * right, y - half)))
    return tuple(behind), tuple(front)


def _frame(governor: Governor) -> tuple[Shape, ...]:
    """The beam with the fulcrums, keyed to the spindle; hub and end plates of the cross rod."""
    u, (x, y) = governor.arm, governor.fulcrum
    plate, bore = 0.06 * u, governor.bore
    return (
        rectangle("frame", -0.2 * u, 0.2 * u, y - 0.12 * u, 0.12 * u),
        bar("frame", (-x, y), (x, y), 0.19 * u),
        *(
            rectangle("seat", min(a, b), max(a, b), -1.05 * bore, 1.05 * bore)
            for a, b in ((governor.seat, governor.seat + plate), (-governor.seat, -governor.seat - plate))
        ),
        *(
            rectangle("rod", min(a, b), max(a, b), -0.11 * u, 0.11 * u)
            for a, b in (
                (governor.seat + plate, governor.seat + 2.4 * plate),
                (-governor.seat - plate, -governor.seat - 2.4 * plate),
            )
        ),
    )


def _sleeve(governor: Governor, height: float) -> tuple[Shape, ...]:
    """Head, collar with the groove for the fork, and a pointer; vertical hangers slide in a slot of the head."""
    u, (width, drop) = governor.arm, governor.load
    head, base = 0.14 * u, height - drop
    neck, flange = 0.62 * width, 0.14 * u
    waist = height - 1.6 * head
    outline = (
        (width, height + head),
        (width, height - head),
        (0.72 * width, waist),
        (0.72 * width, base + 2.6 * flange),
        (neck, base + 2.6 * flange),
        (neck, base + flange),
        (0.9 * width, base + flange),
        (0.9 * width, base),
    )
    mirrored = tuple((-x, y) for x, y in reversed(outline))
    x, y = width - 0.06 * u, 0.065 * u
    slot = ((-x, height - y), (x, height - y), (x, height + y), (-x, height + y)) if math.isinf(governor.hanger) else ()
    strokes = tuple(
        ((part * width, waist - 0.02 * u), (part * width, base + 2.7 * flange)) for part in (0.44, 0.56, 0.65)
    )
    tip = width + 0.34 * u
    return (
        Polygon("sleeve", outline + mirrored),
        Lines("engraving", strokes),
        Polygon("slot", slot),
        Polygon("pointer", ((tip, height), (tip - 0.2 * u, height + 0.08 * u), (tip - 0.2 * u, height - 0.08 * u))),
    )


def _bearing(u: float, bottom: float, top: float) -> tuple[Shape, ...]:
    """A bearing in section: two hatched blocks beside the spindle, from bottom to top (m)."""
    near, far, shapes = SPINDLE * u, 0.42 * u, list[Shape]()
    for left, right in ((-far, -near), (near, far)):
        shapes += [
            rectangle("bearing", left, right, bottom, top),
            hatching("hatching", (left, right, bottom, top), 0.09 * u),
        ]
    return tuple(shapes)


def _scale(governor: Governor, lifts: Pair) -> tuple[Shape, ...]:
    """A scale right of the sleeve whose marks (mm) cover the lifts (m), lowest and highest."""
    u, (low, high) = governor.arm, lifts
    step = nice_step(max(high - low, 0.1 * u), 5)
    first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
    # Long enough that its two numbers stand apart.
    last = max(last, first + math.ceil(0.3 * u / step))
    marks = [(k, k * step + governor.zero) for k in range(first, last + 1)]
    x = governor.load[0] + 0.38 * u
    ticks = tuple(((x, y), (x + (0.14 if k in (first, last) else 0.08) * u, y)) for k, y in marks)
    words = [
        Text("scale", x + 0.18 * u, y, f"{k * step * 1e3:.6g}{unit}", 0.9 * u)
        for (k, y), unit in ((marks[0], ""), (marks[-1], " mm"))
    ]
    return (Lines("scale", (((x, marks[0][1]), (x, marks[-1][1])), *ticks)), *words)

"""The drawing of the pendulum governor: spindle, cross piece, arms, links, balls, and the sleeve with its load."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.machines.pendulum.machine import LEFT, RIGHT
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.free_space import first_room, telling_poses, widths_between
from governor_mechanism.render.geometry.primitives import (
    Circle,
    Lines,
    Pair,
    Shape,
    Text,
    bar,
    hatching,
    nice_step,
    rectangle,
)
from governor_mechanism.render.machines.pendulum.clearance import lens_frame, lens_inside, slots
from governor_mechanism.render.machines.pendulum.effects import foot_room, moving_fittings, still_fittings
from governor_mechanism.render.machines.pendulum.proportions import (
    ARM,
    LINK,
    PIVOT,
    SPINDLE,
    Governor,
    ball_spots,
    governor_of,
    sides_of,
    sleeve_height,
)
from governor_mechanism.render.machines.pendulum.sleeve import sleeve
from governor_mechanism.render.run_extents import Stage
from governor_mechanism.types import FloatArray

SCALE = 0.365
"""width of that scale with its numbers, as a fraction of the arm"""


def background(part: Part, poses: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Spindle in its bearings, suspension, axis, the scale of the sleeve's lift, and what effects fix to the frame."""
    governor = governor_of(part, NOTHING if stage is None else stage.acting)
    u = governor.arm
    heights = sleeve_height(governor, part, poses)
    lowest, highest = float(heights.min()), float(heights.max())
    width, drop = governor.load
    foot = lowest - drop - foot_room(governor, (lowest, highest))
    w, zero = SPINDLE * u, governor.zero
    passing = [shape for pose in telling_poses(poses) for shape in _linkage(governor, part, pose)]
    return (
        Lines("axis", (((0.0, foot - 0.29 * u), (0.0, 0.40 * u)),)),
        rectangle("spindle", -w, w, foot - 0.16 * u, 0.33 * u),
        Lines("spindle shade", (((0.45 * w, foot - 0.16 * u), (0.45 * w, 0.33 * u)),)),
        *_bearing(u, 0.17 * u, 0.27 * u),
        *_bearing(u, foot - 0.14 * u, foot - 0.04 * u),
        rectangle("spindle", -1.6 * w, 1.6 * w, foot - 0.04 * u, foot - 0.012 * u),
        *still_fittings(governor),
        *_suspension(governor),
        *_scale(governor, passing, width + 0.10 * u, (lowest - zero, highest - zero)),
        *lens_frame(governor),
    )


def moving(part: Part, pose: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Sleeve, links, arms, balls, pins and what effects hang on them; the right half passes before the left one."""
    acting, time = (NOTHING, 0.0) if stage is None else (stage.acting, stage.time)
    governor = governor_of(part, acting)
    u = governor.arm
    height = float(sleeve_height(governor, part, pose))
    sides = sides_of(governor, part, pose)
    behind, front = moving_fittings(governor, part, pose, time)
    spots = [spot for side in sides for spot in (side.top, side.knee, side.ring)]
    return (
        *behind,
        *sleeve(governor, height),
        *slots(governor, height),
        *_linkage(governor, part, pose),
        *(Lines("ball shine", _shine(side.ball, governor.ball)) for side in sides),
        *(Circle("pivot", *spot, PIVOT * u) for spot in spots),
        *front,
        *lens_inside(governor, part, pose, time),
    )


def plan(part: Part, pose: FloatArray, angle: float, acting: Acting = NOTHING) -> tuple[Shape, ...]:
    """Sleeve, arms and balls from above; the right ball carries a mark."""
    governor = governor_of(part, acting)
    c, s = math.cos(angle), math.sin(angle)
    right, left = (float(ball_spots(governor, part, pose, name)[0]) for name in (RIGHT, LEFT))
    places = [(left * c, left * s), (right * c, right * s)]
    radius = governor.ball
    return (
        Circle("sleeve", 0.0, 0.0, governor.load[0]),
        Lines("plan arm", ((places[0], places[1]),)),
        *(Circle("ball", *spot, radius) for spot in places),
        Circle("mark", *places[1], 0.42 * radius),
    )


def traced(part: Part, poses: FloatArray) -> FloatArray:
    """The path (n, 2) (m) of the right ball's centre."""
    return ball_spots(governor_of(part), part, poses)


def _linkage(governor: Governor, part: Part, pose: FloatArray) -> tuple[Shape, ...]:
    """Links, arms and balls."""
    u, shapes = governor.arm, list[Shape]()
    sides = sides_of(governor, part, pose)
    for side in sides:
        # A link with mass is a rod of its own.
        role, width = ("rod", 1.2 * LINK) if governor.heavy_links else ("link", LINK)
        shapes += [bar(role, side.knee, side.ring, width * u), bar("arm", side.top, side.ball, ARM * u)]
    return (*shapes, *(Circle("ball", *side.ball, governor.ball) for side in sides))


def _shine(ball: Pair, radius: float) -> tuple[tuple[Pair, ...], ...]:
    """Two arcs inside the ball's rim, upper left: the light on a sphere."""
    return tuple(
        tuple(
            (ball[0] + share * radius * math.cos(a), ball[1] + share * radius * math.sin(a))
            for a in (math.radians(135 + half * (k / 6 - 1)) for k in range(13))
        )
        for share, half in ((0.78, 42.0), (0.60, 30.0))
    )


def _bearing(u: float, bottom: float, top: float) -> tuple[Shape, ...]:
    """A bearing in section: two hatched blocks beside the spindle, from bottom to top (m)."""
    near, far = SPINDLE * u, 0.15 * u
    shapes: list[Shape] = []
    for left, right in ((-far, -near), (near, far)):
        shapes.append(rectangle("bearing", left, right, bottom, top))
        shapes.append(hatching("hatching", (left, right, bottom, top), 0.034 * u))
    return tuple(shapes)


def _suspension(governor: Governor) -> tuple[Shape, ...]:
    """The cross piece that carries the arms' pins, keyed to the spindle."""
    u = governor.arm
    reach = abs(governor.offset)
    return (
        rectangle("frame", -0.062 * u, 0.062 * u, -0.062 * u, 0.085 * u),
        bar("frame", (-reach, 0.0), (reach, 0.0), 0.085 * u),
    )


def _scale(governor: Governor, passing: Sequence[Shape], near: float, lifts: Pair) -> tuple[Shape, ...]:
    """A scale whose marks (mm) cover the lifts (m), lowest and highest, as the pointer shows them.

    It stands at x = near (m), or where something passes there, beside that, with lines that lead to it.
    """
    u = governor.arm
    shift = governor.zero - governor.load[1]
    low, high = lifts
    step = nice_step(max(high - low, 0.04 * u), 5)
    first = math.floor(low / step + 1e-9)
    # Long enough that its two numbers stand apart.
    last = max(math.ceil(high / step - 1e-9), first + math.ceil(0.1 * u / step))
    marks = [(k, k * step + shift) for k in range(first, last + 1)]
    bottom, top = marks[0][1] - 0.04 * u, marks[-1][1] + 0.04 * u
    # Beside what passes, a little air.
    x = first_room(widths_between(passing, bottom, top), near - 0.01 * u, SCALE * u)
    x = near if x < near else x + 0.05 * u
    leaders = () if x == near else (Lines("leader", tuple(((near, y), (x, y)) for _, y in marks)),)
    ticks = tuple(((x, y), (x + (0.05 if k in (first, last) else 0.03) * u, y)) for k, y in marks)
    # Letters keep their size where a wide machine is drawn small: far out, their room grows with the width.
    room = 0.3 * u if x == near else 0.4 * x
    words = [
        Text("scale", x + 0.065 * u, y, f"{k * step * 1e3:.6g}{unit}", room)
        for (k, y), unit in ((marks[0], ""), (marks[-1], " mm"))
    ]
    return (*leaders, Lines("scale", (((x, marks[0][1]), (x, marks[-1][1])), *ticks)), *words)

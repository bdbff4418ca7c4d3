"""The drawing of the pendulum governor: spindle, cross piece, arms, links, balls, and the sleeve with its load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.machines.pendulum import LEFT, RIGHT, SLEEVE
from governor_mechanism.mechanism import Coordinate, FollowerHeight
from governor_mechanism.render.primitives import (
    CAST_IRON,
    Circle,
    Lines,
    Pair,
    Polygon,
    Shape,
    Text,
    ball_radius,
    bar,
    hatching,
    nice_step,
    rectangle,
)
from governor_mechanism.render.room import first_room, telling_poses, widths_between
from governor_mechanism.render.stage import Stage
from governor_mechanism.scene import Part

Array = NDArray[np.float64]

# All as fractions of the arm: what the scene does not say is drawn in a proportion to it.
SPINDLE = 0.030
"""half width"""
ARM, LINK, PIVOT = 0.058, 0.042, 0.021
GROOVE = 0.62
"""half width of a light sleeve's groove, as a fraction of the sleeve's"""


PASSING = ("arm", "link", "ball")
"""What the scale of the lift keeps clear of."""
SCALE = 0.365
"""width of that scale with its numbers"""


@dataclass(frozen=True, kw_only=True)
class Governor:
    """The dimensions a drawing needs, in m and kg; `loaded` tells whether the sleeve is a body of its own."""

    arm: float
    offset: float
    joint: float
    link: float
    lug: float
    ball_mass: float
    sleeve_mass: float
    loaded: bool


def background(part: Part, poses: Array, _: Stage | None = None) -> tuple[Shape, ...]:
    """Spindle in its bearings, suspension, axis and the scale of the sleeve's lift."""
    governor = _governor(part)
    u = governor.arm
    heights = _sleeve_height(governor, part, poses)
    lowest, highest = float(heights.min()), float(heights.max())
    width, drop = _load(governor)
    foot = lowest - drop - 0.10 * u
    lift = part.mechanism.reading("sleeve_lift")
    zero = lift.zero if isinstance(lift, Coordinate | FollowerHeight) else 0.0
    w = SPINDLE * u
    return (
        Lines("axis", (((0.0, foot - 0.29 * u), (0.0, 0.40 * u)),)),
        rectangle("spindle", -w, w, foot - 0.16 * u, 0.33 * u),
        Lines("spindle shade", (((0.45 * w, foot - 0.16 * u), (0.45 * w, 0.33 * u)),)),
        *_bearing(u, 0.17 * u, 0.27 * u),
        *_bearing(u, foot - 0.14 * u, foot - 0.04 * u),
        rectangle("spindle", -1.6 * w, 1.6 * w, foot - 0.04 * u, foot - 0.012 * u),
        *_suspension(governor),
        *_scale(part, poses, width + 0.10 * u, (lowest - zero, highest - zero), zero - drop),
    )


def moving(part: Part, pose: Array, _: Stage | None = None) -> tuple[Shape, ...]:
    """Sleeve, links, arms, balls and pins; the right half passes before the left one."""
    governor = _governor(part)
    u = governor.arm
    height = float(_sleeve_height(governor, part, pose))
    sides = []
    for name, sign in ((LEFT, -1.0), (RIGHT, 1.0)):
        ball = _centre(part, pose, name)
        top = (sign * governor.offset, 0.0)
        share = governor.joint / governor.arm
        knee = (top[0] + share * (ball[0] - top[0]), top[1] + share * (ball[1] - top[1]))
        sides.append((top, knee, ball, (sign * governor.lug, height)))
    shapes: list[Shape] = [*_sleeve(governor, height)]
    for top, knee, ball, lug in sides:
        shapes += [bar("link", knee, lug, LINK * u), bar("arm", top, ball, ARM * u)]
    radius = ball_radius(governor.ball_mass, u)
    shapes += [Circle("ball", *ball, radius) for _, _, ball, _ in sides]
    shapes += [Lines("ball shine", _shine(ball, radius)) for _, _, ball, _ in sides]
    shapes += [Circle("pivot", *spot, PIVOT * u) for top, knee, _, lug in sides for spot in (top, knee, lug)]
    return tuple(shapes)


def plan(part: Part, pose: Array, angle: float) -> tuple[Shape, ...]:
    """Sleeve, arms and balls from above; the right ball carries a mark."""
    governor = _governor(part)
    u = governor.arm
    c, s = math.cos(angle), math.sin(angle)
    right, left = (_centre(part, pose, name)[0] for name in (RIGHT, LEFT))
    places = [(left * c, left * s), (right * c, right * s)]
    radius = ball_radius(governor.ball_mass, u)
    return (
        Circle("sleeve", 0.0, 0.0, _load(governor)[0]),
        Lines("plan arm", ((places[0], places[1]),)),
        *(Circle("ball", *spot, radius) for spot in places),
        Circle("mark", *places[1], 0.42 * radius),
    )


def _governor(part: Part) -> Governor:
    given = part.dimensions
    arm, offset = given["arm"], given.get("offset", 0.0)
    joint = given.get("arm_joint", arm)
    return Governor(
        arm=arm,
        offset=offset,
        joint=joint,
        link=given.get("link", joint),
        lug=given.get("lug_offset", offset),
        ball_mass=given["ball_mass"],
        sleeve_mass=given.get("sleeve_mass", 0.0),
        loaded=SLEEVE in [body.name for body in part.mechanism.bodies],
    )


def _centre(part: Part, pose: Array, name: str) -> Pair:
    x, y, _ = pose[part.mechanism.body_index(name)]
    return float(x), float(y)


def _sleeve_height(governor: Governor, part: Part, poses: Array) -> Array:
    """Height (...) of the lugs (m) at poses (..., bodies, 3): the sleeve's own, or that of a sleeve without mass."""
    if governor.loaded:
        own: Array = poses[..., part.mechanism.body_index(SLEEVE), 1]
        return own
    ball = poses[..., part.mechanism.body_index(RIGHT), :]
    share = governor.joint / governor.arm
    reach = governor.offset + share * (ball[..., 0] - governor.offset) - governor.lug
    hung: Array = share * ball[..., 1] - np.sqrt(np.maximum(governor.link**2 - reach**2, 0.0))
    return hung


def _load(governor: Governor) -> Pair:
    """Half width and depth below the lugs (m) of a drum of cast iron with the sleeve's mass, or of a light collar."""
    u = governor.arm
    if not governor.loaded:
        return max(0.115 * u, abs(governor.lug) + 0.06 * u), 0.24 * u
    # A cylinder 1.3 radii high has this radius; a load too heavy or too light to be seen well is drawn at the limit.
    radius = math.cbrt(governor.sleeve_mass / (1.3 * math.pi * CAST_IRON))
    radius = min(max(radius, 0.16 * u), 0.38 * u)
    return max(radius, abs(governor.lug) + 0.06 * u), 0.09 * u + 1.3 * radius


def _sleeve(governor: Governor, height: float) -> tuple[Shape, ...]:
    """Lugs, collar and load, with strokes that show the round; hung below the lugs, clear of arms and links."""
    u = governor.arm
    width, drop = _load(governor)
    neck = abs(governor.lug) + 0.06 * u
    ears = [bar("sleeve", (x, height - 0.06 * u), (x, height), 0.085 * u) for x in (-governor.lug, governor.lug)]
    top, base = height - 0.045 * u, height - drop
    outline = (_drum if governor.loaded else _collar)(neck, width, top, base, u)
    round_part = width if governor.loaded else GROOVE * width
    tip = width + 0.085 * u
    mirrored = tuple((-x, y) for x, y in reversed(outline))
    return (
        *ears,
        Polygon("sleeve", outline + mirrored),
        Lines("engraving", _strokes(outline, round_part, base, u)),
        Polygon("pointer", ((tip, base), (tip - 0.07 * u, base + 0.03 * u), (tip - 0.07 * u, base - 0.03 * u))),
    )


def _drum(neck: float, width: float, top: float, base: float, u: float) -> tuple[Pair, ...]:
    """Right half of the load's outline, from the top down: a neck, a rounded shoulder, a body and a foot moulding."""
    round_off = min(0.10 * u, 0.5 * (width - neck)) if width > neck else 0.0
    shoulder = top - 0.045 * u
    corner = tuple(
        (width - round_off * (1 - math.sin(a)), shoulder - round_off * (1 - math.cos(a)))
        for a in (k * math.pi / 12 for k in range(7))
    )
    return ((0.0, top), (neck, top), (neck, shoulder), *corner, (width, base + 0.03 * u), (0.93 * width, base))


def _collar(neck: float, width: float, top: float, base: float, u: float) -> tuple[Pair, ...]:
    """Right half of a light collar's outline, with the groove for the fork that would move the throttle."""
    flange = 0.045 * u
    groove = GROOVE * width
    return (
        (0.0, top),
        (neck, top),
        (width, top - 0.01 * u),
        (width, top - flange - 0.01 * u),
        (groove, top - flange - 0.01 * u),
        (groove, base + flange),
        (width, base + flange),
        (width, base),
    )


def _strokes(outline: tuple[Pair, ...], width: float, base: float, u: float) -> tuple[tuple[Pair, ...], ...]:
    """Upright strokes, close together toward the right edge as an engraver shades a cylinder of half `width`."""
    strokes = []
    for sine in (0.42, 0.57, 0.69, 0.79, 0.87, 0.94):
        x = sine * width
        # The outline starts at the axis: wherever it crosses x, its highest crossing is the top of the stroke.
        tops = [y0 + (y1 - y0) * (x - x0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(outline) if x0 <= x < x1]
        strokes.append(((x, max(tops) - 0.02 * u), (x, base + 0.03 * u)))
    strokes.append(((-0.94 * width, strokes[-1][0][1]), (-0.94 * width, base + 0.03 * u)))
    return tuple(strokes)


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


def _scale(part: Part, poses: Array, near: float, lifts: Pair, shift: float) -> tuple[Shape, ...]:
    """A scale whose marks (mm) cover the lifts (m), lowest and highest; a lift's mark stands at lift + shift (m).

    It stands at x = near (m), or where arms, links or balls pass there, beside them, with lines that lead to it.
    """
    u = part.mechanism.size
    low, high = lifts
    step = nice_step(max(high - low, 0.04 * u), 5)
    first = math.floor(low / step + 1e-9)
    # Long enough that its two numbers stand apart.
    last = max(math.ceil(high / step - 1e-9), first + math.ceil(0.1 * u / step))
    marks = [(k, k * step + shift) for k in range(first, last + 1)]
    bottom, top = marks[0][1] - 0.04 * u, marks[-1][1] + 0.04 * u
    passing = [shape for pose in telling_poses(poses) for shape in moving(part, pose) if shape.role in PASSING]
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

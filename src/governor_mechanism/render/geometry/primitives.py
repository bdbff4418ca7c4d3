"""The plain shapes that pictures are made of: metres, a role, no colours, no plotting library."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from governor_mechanism.model.joints import Point

Vec2 = tuple[float, float]
PoseTuple = tuple[float, float, float]
BoundingBox = tuple[float, float, float, float]
"""left, right, bottom, top (m)."""


@dataclass(frozen=True, slots=True)
class Circle:
    """A filled circle: centre (m) and radius (m)."""

    role: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True, slots=True)
class Polygon:
    """A filled outline; `points` (m) in order, the last joined to the first; none where there is nothing to show."""

    role: str
    points: tuple[Vec2, ...]


@dataclass(frozen=True, slots=True)
class Lines:
    """Open strokes: each of `lines` is a chain of points (m)."""

    role: str
    lines: tuple[tuple[Vec2, ...], ...]


@dataclass(frozen=True, slots=True)
class TextShape:
    """Words whose left middle stands at (x, y) (m); `room` (m) is kept free for them to the right."""

    role: str
    x: float
    y: float
    text: str
    width: float


DrawnShape = Circle | Polygon | Lines | TextShape

HALF_CIRCLE_POINTS = tuple((math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(9))


def make_bar(role: str, start: Vec2, end: Vec2, width: float) -> Polygon:
    """A straight bar with round ends from start to end (m), `width` (m) across."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    length = math.hypot(dx, dy)
    ux, uy = (dx / length, dy / length) if length > 0 else (1.0, 0.0)
    half = width / 2
    # A half circle from the bar's right side round to its left one, in axes (ux, uy), (-uy, ux): round the end it
    # bulges forward, round the start backward.
    half_circle = tuple((half * s, -half * c) for c, s in HALF_CIRCLE_POINTS)
    tip = tuple((end[0] + f * ux - g * uy, end[1] + f * uy + g * ux) for f, g in half_circle)
    tail = tuple((start[0] - f * ux + g * uy, start[1] - f * uy - g * ux) for f, g in half_circle)
    return Polygon(role, tip + tail)


def make_rectangle(role: str, left: float, right: float, bottom: float, top: float) -> Polygon:
    """An upright rectangle (m)."""
    return Polygon(role, ((left, bottom), (right, bottom), (right, top), (left, top)))


def make_hatching(role: str, box: BoundingBox, spacing: float) -> Lines:
    """Section lining: strokes at 45 degrees that fill a box (m), `spacing` (m) apart along x."""
    left, right, bottom, top = box
    height = top - bottom
    strokes: list[tuple[Vec2, ...]] = []
    start_x = left - height + spacing / 2
    while start_x < right:
        low, high = max(start_x, left), min(start_x + height, right)
        strokes.append(((low, bottom + low - start_x), (high, bottom + high - start_x)))
        start_x += spacing
    return Lines(role, tuple(strokes))


def place_point(pose: PoseTuple, point: Point) -> Vec2:
    """Where a point marked on a body stands (m) when the body has that pose."""
    x, y, angle = pose
    c, s = math.cos(angle), math.sin(angle)
    return x + c * point.x - s * point.y, y + s * point.x + c * point.y


def bounding_box(shapes: Iterable[DrawnShape]) -> BoundingBox:
    """The smallest box (m) that holds all shapes; words count by the room kept for them."""
    xs: list[float] = []
    ys: list[float] = []
    for shape in shapes:
        match shape:
            case Circle(_, x, y, radius):
                xs += (x - radius, x + radius)
                ys += (y - radius, y + radius)
            case Polygon(_, points):
                xs += (x for x, _ in points)
                ys += (y for _, y in points)
            case Lines(_, lines):
                xs += (x for line in lines for x, _ in line)
                ys += (y for line in lines for _, y in line)
            case TextShape(_, x, y, _, room):
                xs += (x, x + room)
                ys.append(y)
    return min(xs), max(xs), min(ys), max(ys)


def round_step(span: float, max_steps: int) -> float:
    """The smallest of 1, 2, 5 x 10^n that divides `span` into at most `most` steps."""
    min_step = span / max_steps
    decade = float(10.0 ** math.floor(math.log10(min_step)))
    steps = (m * decade for m in (1.0, 2.0, 5.0, 10.0))
    return next(step for step in steps if step >= min_step * (1 - 1e-9))


def drawn_ball_radius(mass: float, length_scale: float) -> float:
    """Radius (m) of a cast-iron ball of that mass (kg), kept between 4 % and 20 % of `size` (m) to be seen well."""
    return min(max(math.cbrt(3 * mass / (4 * math.pi * CAST_IRON_DENSITY)), 0.04 * length_scale), 0.20 * length_scale)


CAST_IRON_DENSITY = 7200.0
"""kg/m3."""

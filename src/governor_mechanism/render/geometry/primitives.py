"""Shapes of which drawings consist: lengths in metres, a role, no colours, no plotting library."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain

Vec2 = tuple[float, float]
"""Two coordinates x, y (m), or the two ends of an interval."""
PoseTuple = tuple[float, float, float]
"""Position x, y (m) and angle (rad)."""
BoundingBox = tuple[float, float, float, float]
"""left, right, bottom, top (m)."""


@dataclass(frozen=True, slots=True)
class Circle:
    """Filled circle with centre and radius (m)."""

    role: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True, slots=True)
class Polygon:
    """Filled closed outline through `points` (m); empty if there is nothing to show."""

    role: str
    points: tuple[Vec2, ...]


@dataclass(frozen=True, slots=True)
class Lines:
    """Open polylines through points (m)."""

    role: str
    lines: tuple[tuple[Vec2, ...], ...]


@dataclass(frozen=True, slots=True)
class TextShape:
    """Text with its left middle at (x, y) (m); `width` (m) is reserved for it to the right."""

    role: str
    x: float
    y: float
    text: str
    width: float


DrawnShape = Circle | Polygon | Lines | TextShape


def bounding_box(shapes: Iterable[DrawnShape]) -> BoundingBox:
    """Return the smallest box (m) around all shapes; text counts with its reserved width.

    Around nothing it is the box that changes no box which encloses it: left and bottom are infinite, right and top minus infinite.
    """
    points = [point for shape in shapes for point in _extent_points(shape)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs, default=math.inf), max(xs, default=-math.inf), min(ys, default=math.inf), max(ys, default=-math.inf)


def enclose_boxes(boxes: Iterable[BoundingBox]) -> BoundingBox:
    """Return the smallest box (m) around boxes, of which there is at least one."""
    lefts, rights, bottoms, tops = zip(*boxes, strict=True)
    return min(lefts), max(rights), min(bottoms), max(tops)


def _extent_points(shape: DrawnShape) -> Iterable[Vec2]:
    """Return points that have the same bounding box as a shape."""
    match shape:
        case Circle(_, x, y, radius):
            return (x - radius, y - radius), (x + radius, y + radius)
        case Polygon(_, points):
            return points
        case Lines(_, lines):
            return chain.from_iterable(lines)
        case TextShape(_, x, y, _, width):
            return (x, y), (x + width, y)


def round_step(span: float, max_steps: int) -> float:
    """Return the smallest of 1, 2, 5 x 10^n that divides `span` into at most `max_steps` steps."""
    min_step = span / max_steps
    decade = float(10.0 ** math.floor(math.log10(min_step)))
    return next(step for step in (m * decade for m in (1.0, 2.0, 5.0, 10.0)) if step >= min_step * (1 - 1e-9))


def drawn_ball_radius(mass: float, length_scale: float) -> float:
    """Return the radius (m) of a cast-iron ball of a mass (kg), limited to 4 % to 20 % of `length_scale` (m) for visibility."""
    return min(max(math.cbrt(3 * mass / (4 * math.pi * CAST_IRON_DENSITY)), 0.04 * length_scale), 0.20 * length_scale)


CAST_IRON_DENSITY = 7200.0
"""Density of cast iron, kg/m3."""

"""The reversing lever on its notched quadrant, at the lower left of the drawing."""

import math
from collections.abc import Callable, Iterator

from governor_mechanism.render.geometry.attached import Attached, Moment, axes_turned
from governor_mechanism.render.geometry.outlines import make_band, make_bar
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, TextShape, Vec2

HALF_SWING = math.radians(34.0)
"""Angle of the lever from the upright in full gear, rad; full forward gear is toward the cylinder, at the left."""
_QUADRANT_RATIO, _N_NOTCHES = 0.72, 10
"""Radius of the quadrant relative to the lever, and number of spaces between its notches."""


def quadrant_shapes(pivot: Vec2, length: float) -> Iterator[DrawnShape]:
    """Yield the quadrant with its notches and names, for a lever with its pivot and length (m)."""
    radius = _QUADRANT_RATIO * length
    margin = 0.1 * HALF_SWING
    arc = arc_points(pivot, math.pi / 2 - HALF_SWING - margin, 2 * (HALF_SWING + margin), radius, 24)
    yield make_band("bracket", arc, 0.10 * length)
    angles = [math.pi / 2 + HALF_SWING * (2 * k / _N_NOTCHES - 1) for k in range(_N_NOTCHES + 1)]
    notches = tuple(tuple((pivot[0] + r * math.cos(a), pivot[1] + r * math.sin(a)) for r in (radius, 1.07 * radius)) for a in angles)
    yield Lines("division", notches)
    yield TextShape("scale", pivot[0] - 0.62 * length, pivot[1] + 0.06 * length, "ahead", 0.45 * length)
    yield TextShape("scale", pivot[0] + 0.20 * length, pivot[1] + 0.06 * length, "back", 0.40 * length)


def lever_parts(pivot: Vec2, length: float, reverser_at: Callable[[Moment], float]) -> Iterator[Attached]:
    """Yield the lever at a position from 1, full forward, to -1, full back."""
    lever_axes = axes_turned(pivot, lambda moment: math.pi / 2 + HALF_SWING * reverser_at(moment))
    bar, handle = make_bar("arm", (0.0, 0.0), (length, 0.0), 0.07 * length), Circle("ball", length, 0.0, 0.055 * length)
    yield Attached(frame=lever_axes, shapes=(bar, handle, Circle("pivot", 0.0, 0.0, 0.05 * length)))

"""Outlines of parts: plates with rounded corners, bands along a curve, arrows, and hatched walls."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from governor_mechanism.render.geometry.body_points import put
from governor_mechanism.render.geometry.primitives import Box, Lines, Pair, Polygon, Pose, hatching, rectangle

CORNER = 8
"""Pieces a rounded corner is drawn in."""


def hull(points: Sequence[Pair]) -> list[Pair]:
    """The corners of the smallest convex area that holds all points, anticlockwise; those on an edge left out."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    span = max(math.dist(point, ordered[0]) for point in ordered)

    def half(chain: Sequence[Pair]) -> list[Pair]:
        found: list[Pair] = []
        for x, y in chain:
            while len(found) > 1:
                (x0, y0), (x1, y1) = found[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 1e-9 * span**2:
                    break
                found.pop()
            found.append((x, y))
        return found[:-1]

    return half(ordered) + half(ordered[::-1])


def plate(role: str, points: Sequence[Pair], width: float) -> Polygon:
    """A plate round all points, half a `width` (m) beyond the outermost ones: a bar for two, a disc for one."""
    corners = hull(points)
    if len(corners) < 2:
        return Polygon(role, _turn(corners[0], 0.0, 2 * math.pi, width / 2, 2 * CORNER))
    outline: list[Pair] = []
    for before, corner, after in zip((corners[-1], *corners), corners, (*corners[1:], corners[0]), strict=False):
        start, end = (math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in ((before, corner), (corner, after)))
        outline += _turn(corner, start - math.pi / 2, (end - start) % (2 * math.pi), width / 2, CORNER)
    return Polygon(role, tuple(outline))


def band(role: str, chain: Sequence[Pair], width: float) -> Polygon:
    """A strip of a `width` (m) along a chain of points, with round ends."""
    if len(set(chain)) < 2:
        return plate(role, chain[:1], width)
    half = width / 2
    # Towards the next point but one, so that strips of curves have no steps.
    headings = [
        math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip((chain[0], *chain), (*chain[1:], chain[-1]), strict=False)
    ]
    sides = [
        tuple(
            (x + s * half * math.sin(h), y - s * half * math.cos(h)) for (x, y), h in zip(chain, headings, strict=True)
        )
        for s in (1, -1)
    ]
    tip = _turn(chain[-1], headings[-1] - math.pi / 2, math.pi, half, CORNER)
    tail = _turn(chain[0], headings[0] + math.pi / 2, math.pi, half, CORNER)
    return Polygon(role, (*sides[0], *tip, *sides[1][::-1], *tail))


def arrow(role: str, chain: Sequence[Pair], head: float) -> tuple[Lines, Polygon]:
    """A line with a head of that length (m) at its end; nothing where the line has no length."""
    length = sum(math.dist(a, b) for a, b in pairwise(chain))
    if length < 0.1 * head:
        return Lines(role, ()), Polygon(role, ())
    head = min(head, 0.8 * length)
    kept = list(chain)
    tip = kept[-1]
    while len(kept) > 2 and math.dist(kept[-2], tip) < head:
        kept.pop(-2)
    (x0, y0) = kept[-2]
    far = math.dist((x0, y0), tip)
    ux, uy = (tip[0] - x0) / far, (tip[1] - y0) / far
    root = (tip[0] - head * ux, tip[1] - head * uy)
    wings = tuple((root[0] + side * 0.36 * head * -uy, root[1] + side * 0.36 * head * ux) for side in (1, -1))
    return Lines(role, ((*kept[:-1], root),)), Polygon(role, (tip, *wings))


def wall(spot: Pair, heading: float, half: float, depth: float) -> Lines:
    """A fixed wall through a spot, across a heading (rad), hatched on the side it heads away from; all in m."""
    c, s = math.cos(heading), math.sin(heading)

    def at(across: float, behind: float) -> Pair:
        return spot[0] - behind * c - across * s, spot[1] - behind * s + across * c

    count = max(round(2 * half / (0.9 * depth)), 2)
    feet = [-half + (k + 0.5) * 2 * half / count for k in range(count)]
    strokes = tuple((at(foot, 0.0), at(foot - 0.8 * depth, depth)) for foot in feet)
    return Lines("wall", ((at(-half, 0.0), at(half, 0.0)), *strokes))


def burst(role: str, spots: Sequence[Pair], reach: float) -> Lines:
    """Rays round each spot, from half the `reach` (m) to all of it: something has just struck there."""
    rays = [(math.cos(k * math.pi / 4 + 0.2), math.sin(k * math.pi / 4 + 0.2)) for k in range(8)]
    strokes = [
        tuple((x + share * reach * c, y + share * reach * s) for share in (0.45, 1.0))
        for x, y in spots
        for c, s in rays
    ]
    return Lines(role, tuple(strokes))


def block(role: str, axes: Pose, box: Box, spacing: float) -> tuple[Polygon, Lines]:
    """A box (m) of these axes with its section lining, `spacing` (m) apart; the lining's role is named after its."""
    lining = hatching(f"{role} hatching", box, spacing)
    outline = rectangle(role, *box)
    return (
        Polygon(role, tuple(put(axes, *point) for point in outline.points)),
        Lines(lining.role, tuple(tuple(put(axes, *point) for point in stroke) for stroke in lining.lines)),
    )


def _turn(centre: Pair, start: float, sweep: float, radius: float, pieces: int) -> tuple[Pair, ...]:
    angles = (start + sweep * k / pieces for k in range(pieces + 1))
    return tuple((centre[0] + radius * math.cos(a), centre[1] + radius * math.sin(a)) for a in angles)

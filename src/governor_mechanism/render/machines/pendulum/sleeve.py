"""The sleeve of a pendulum governor: lugs, collar and load, shaded as an engraver shades what is round."""

from __future__ import annotations

import math
from itertools import pairwise

from governor_mechanism.render.geometry.primitives import Lines, Pair, Polygon, Shape, bar
from governor_mechanism.render.machines.pendulum.proportions import GROOVE, Governor

SLOT = 0.022
"""Half length of the slots that play makes, as they are drawn, as a fraction of the arm."""
LUG = 0.085
"""Width of a lug, as a fraction of the arm."""


def sleeve(governor: Governor, height: float) -> tuple[Shape, ...]:
    """Lugs, collar and load, with strokes that show the round; hung below the lugs, clear of arms and links."""
    u = governor.arm
    width, drop = governor.load
    neck = abs(governor.lug) + 0.06 * u
    tip = height + (SLOT * u if governor.play else 0.0)
    ears = [bar("sleeve", (x, height - 0.06 * u), (x, tip), LUG * u) for x in (-governor.lug, governor.lug)]
    top, base = height - 0.045 * u, height - drop
    outline = (_drum if governor.loaded else _collar)(neck, width, top, base, u)
    round_part = width if governor.loaded else GROOVE * width
    point = width + 0.085 * u
    mirrored = tuple((-x, y) for x, y in reversed(outline))
    return (
        *ears,
        Polygon("sleeve", outline + mirrored),
        Lines("engraving", _strokes(outline, round_part, base, u)),
        Polygon("pointer", ((point, base), (point - 0.07 * u, base + 0.03 * u), (point - 0.07 * u, base - 0.03 * u))),
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

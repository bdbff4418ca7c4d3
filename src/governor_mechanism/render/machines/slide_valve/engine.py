"""The whole engine in small: shaft with crank and eccentric at the right, rods, crosshead, cylinder at the left."""

from __future__ import annotations

import math

from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Shape, bar, rectangle
from governor_mechanism.render.machines.slide_valve.proportions import Gear, Standing

WIDTH = 2.96
"""Of the strip, in cranks."""

ROD, CYLINDER, BORE = 2.5, 2.5, 0.62
"""In cranks of the engine: piston's rod, length of the cylinder, half its height."""

RISE = 0.90
"""In cranks of the engine: the valve's line over that of the cylinder, in the drawing alone, so that both are seen."""


def small(gear: Gear) -> float:
    """The engine's scale: metres of the picture for a metre."""
    return WIDTH / (1.25 + gear.drawn_rod / gear.crank + 1.0 + ROD + CYLINDER - 1.0)


class _Place:
    """Turns places of the engine (m from the shaft, away from it and up) into places of the picture."""

    def __init__(self, gear: Gear, foot: float) -> None:
        self.scale = small(gear)
        self.x = 0.5 * WIDTH * gear.crank - 1.25 * gear.crank * self.scale
        self.y = foot + 1.2 * gear.crank * self.scale

    def __call__(self, x: float, y: float) -> Pair:
        return self.x - x * self.scale, self.y + y * self.scale


def background(gear: Gear, foot: float) -> tuple[Shape, ...]:
    """Cylinder and chest, guides, the line of the engine; foot (m) is where the strip begins."""
    u, place = gear.crank, _Place(gear, foot)
    near = gear.drawn_rod + (ROD - 1.0) * u
    far = near + CYLINDER * u
    left, right = place(far, 0.0)[0], place(near, 0.0)[0]
    low, high = (place(0.0, y * u)[1] for y in (-BORE, BORE))
    chest = place(0.0, (RISE + 0.30) * u)[1]
    guide = [(place(gear.drawn_rod - 1.25 * u, y * u), place(gear.drawn_rod + 1.25 * u, y * u)) for y in (-0.32, 0.32)]
    return (
        Lines("axis", ((place(-1.2 * u, 0.0), place(far + 0.15 * u, 0.0)),)),
        rectangle("casting", left, right, low, high),
        rectangle("casting", left + 0.15 * (right - left), right - 0.15 * (right - left), high, chest),
        Lines("guide", tuple(guide)),
        Lines(
            "guide",
            (tuple(place(u * math.cos(math.tau * k / 48), u * math.sin(math.tau * k / 48)) for k in range(49)),),
        ),
    )


def moving(gear: Gear, at: Standing, foot: float) -> tuple[Shape, ...]:
    """Crank, eccentric, both rods, crosshead, and the rods of piston and valve."""
    u, place, scale = gear.crank, _Place(gear, foot), small(gear)
    # At 0 the crank points away from the cylinder.
    pin = -u * math.cos(at.angle), u * math.sin(at.angle)
    theta = at.angle + gear.advance
    eccentric = gear.eccentric * math.sin(theta), gear.eccentric * math.cos(theta)
    crosshead = gear.drawn_rod - at.piston
    valve = gear.drawn_eccentric_rod + at.displacement
    near = gear.drawn_rod + (ROD - 1.0) * u
    line = RISE * u
    return (
        Lines("small rod", ((place(crosshead, 0.0), place(near, 0.0)),)),
        Lines("eccentric rod", ((place(valve, line), place(near, line)),)),
        Circle("crank web", *place(0.0, 0.0), 0.30 * u * scale),
        bar("crank web", place(0.0, 0.0), place(*pin), 0.30 * u * scale),
        Circle("eccentric", *place(*eccentric), 1.9 * gear.eccentric * scale),
        Lines("eccentric rod", ((place(*eccentric), place(valve, line)),)),
        Lines("small rod", ((place(*pin), place(crosshead, 0.0)),)),
        rectangle("block", *_span(place, crosshead, 0.24 * u), *_rise(place, 0.30 * u)),
        rectangle("block", *_span(place, valve, 0.10 * u), *_rise(place, 0.13 * u, line)),
        Circle("pivot", *place(0.0, 0.0), 0.10 * u * scale),
        Circle("pivot", *place(*pin), 0.09 * u * scale),
    )


def _span(place: _Place, x: float, half: float) -> Pair:
    return place(x + half, 0.0)[0], place(x - half, 0.0)[0]


def _rise(place: _Place, half: float, y: float = 0.0) -> Pair:
    return place(0.0, y - half)[1], place(0.0, y + half)[1]

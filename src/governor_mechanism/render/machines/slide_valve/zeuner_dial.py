"""Zeuner's diagram on the circle of the crank: it turns with the film, under the piston whose stroke it measures."""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Shape, Text, bar
from governor_mechanism.render.machines.slide_valve.proportions import Gear, Standing
from governor_mechanism.types import FloatArray

WITHIN = 0.80
"""Of the crank's circle: so far an eccentric's radius reaches in the diagram."""

CURVE = 240
"""Points of the true curves, at most."""


def _scale(gear: Gear) -> float:
    """Metres of the picture for a metre of displacement."""
    return WITHIN * gear.crank / gear.eccentric


def _polar(angle: float, length: float) -> Pair:
    return length * math.cos(angle), length * math.sin(angle)


def _ring(radius: float, points: int = 72) -> tuple[Pair, ...]:
    return tuple(_polar(math.tau * k / points, radius) for k in range(points + 1))


def background(gear: Gear, angles: FloatArray, displacements: FloatArray) -> tuple[Shape, ...]:
    """The divided circle, valve circles and laps by theory, and the curves that the run (n,) has drawn."""
    u, scale = gear.crank, _scale(gear)
    ticks = tuple(
        (_polar(math.radians(k), u), _polar(math.radians(k), (1.06 if k % 30 == 0 else 1.03) * u))
        for k in range(0, 360, 10)
    )
    half = 0.5 * gear.eccentric * scale
    centre = half * math.sin(gear.advance), half * math.cos(gear.advance)
    out = math.pi / 2 - gear.advance
    line = _polar(out, 0.95 * u), _polar(out + math.pi, 0.95 * u)
    return (
        Lines("axis", (((-1.12 * u, 0.0), (1.12 * u, 0.0)), ((0.0, -1.06 * u), (0.0, 1.06 * u)), line)),
        Lines("rim", (_ring(u),)),
        Lines("division", ticks),
        *(Lines("lap circle", (_ring(abs(lap) * scale),)) for lap in (gear.outside_lap, gear.inside_lap)),
        *(
            Lines("valve circle", (tuple((s * centre[0] + x, s * centre[1] + y) for x, y in _ring(half)),))
            for s in (1.0, -1.0)
        ),
        Text("scale", 1.09 * u, 0.09 * u, "0°", 0.2 * u),
        Text("scale", -1.28 * u, 0.09 * u, "180°", 0.2 * u),
        *(Lines(f"{end} curve", _curve(angles, side * displacements * scale)) for end, side in ENDS),
    )


ENDS = (("crank end", 1.0), ("head end", -1.0))


def _curve(angles: FloatArray, lengths: FloatArray) -> tuple[tuple[Pair, ...], ...]:
    """The pieces of the first turn in which the displacement goes to one side."""
    first = angles <= angles[0] + math.tau * (1 + 1e-9)
    rows = np.flatnonzero(first)
    rows = rows[:: max(1, len(rows) // CURVE)]
    pieces: list[tuple[Pair, ...]] = []
    piece: list[Pair] = []
    for k in rows:
        if lengths[k] > 0:
            piece.append(_polar(float(angles[k]), float(lengths[k])))
        elif piece:
            pieces.append(tuple(piece))
            piece = []
    return (*pieces, tuple(piece)) if piece else tuple(pieces)


def moving(gear: Gear, at: Standing, height: float) -> tuple[Shape, ...]:
    """The crank with the displacement on its ray, and its projection on the piston at a height (m)."""
    u, scale = gear.crank, _scale(gear)
    pin = _polar(at.angle, u)
    length = at.displacement * scale
    chords = [
        Lines(f"{end} chord", ((((0.0, 0.0), _polar(at.angle, side * length)),) if side * length > 0 else ()))
        for end, side in ENDS
    ]
    marks = [
        Circle(f"{end} mark", *_polar(at.angle, max(side * length, 0.0)), 0.045 * u if side * length > 0 else 0.0)
        for end, side in ENDS
    ]
    return (
        Lines("projection", (_sweep(gear, at, pin), ((at.piston, 0.0), (at.piston, height)))),
        bar("arm", (0.0, 0.0), pin, 0.075 * u),
        *chords,
        *marks,
        Circle("pivot", 0.0, 0.0, 0.055 * u),
        Circle("pivot", *pin, 0.055 * u),
    )


def _sweep(gear: Gear, at: Standing, pin: Pair) -> tuple[Pair, ...]:
    """From the crank pin to the piston's place on the diameter: an arc about the crosshead, or straight down."""
    if math.isinf(gear.rod):
        return pin, (at.piston, 0.0)
    centre = at.piston - gear.rod
    turn = math.asin(pin[1] / gear.rod)
    angles = (turn * k / 12 for k in range(12, -1, -1))
    return tuple((centre + gear.rod * math.cos(a), gear.rod * math.sin(a)) for a in angles)

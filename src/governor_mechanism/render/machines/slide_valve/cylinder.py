"""The cylinder of a slide valve in section: piston, passages, and the valve over its ports in the steam chest.

The valve is drawn larger than the stroke, and the picture says by how much; its ports are as wide as the drawing needs.
"""

from __future__ import annotations

import math

from governor_mechanism.render.geometry.primitives import Lines, Pair, Polygon, Shape, Text, hatching, rectangle
from governor_mechanism.render.machines.slide_valve.proportions import (
    ADMITTING,
    COMPRESSING,
    EXHAUSTING,
    EXPANDING,
    Gear,
    Standing,
    state,
)

# All in cranks, from the middle of the stroke and the foot of the storey up.
FOOT = 1.26
WALL, BORE, BLOCK, CHEST, LID = 0.075, 0.46, 0.30, 0.34, 0.065
PISTON, CLEAR = 0.16, 0.035
"""Thickness of the piston, and the room left at its dead centres."""
VALVE_TRAVEL = 0.33
"""The eccentric as it is drawn in the chest."""
HALF = 1.0 + PISTON / 2 + CLEAR
"""Half the length of the bore."""
ROD, GLAND, REACH = 0.045, 0.16, 1.52
"""Half the thickness of the piston's rod, length of its gland, and where the picture ends at the right."""

# In eccentrics: half the exhaust port, the bridge, the steam port, and the thickness of the valve's back.
EXHAUST, BRIDGE, PORT, BACK, HEIGHT = 0.75, 0.30, 0.62, 0.22, 0.78

TOP = FOOT + 2 * WALL + BORE + BLOCK - WALL + CHEST + LID
"""Of the chest's lid."""


def _levels() -> tuple[float, float, float, float]:
    """Floor and ceiling of the bore, the valve's face, and the chest's ceiling (cranks)."""
    floor = FOOT + WALL
    ceiling = floor + BORE
    face = ceiling + BLOCK
    return floor, ceiling, face, face + CHEST


def drawn_eccentric(gear: Gear) -> float:
    """What the eccentric measures in the drawing of the chest (m); less with long laps, which would not fit."""
    return min(VALVE_TRAVEL, (HALF - 0.02) / _chest_half(gear)) * gear.crank


def magnified(gear: Gear) -> float:
    """How many times larger than the stroke the valve is drawn."""
    return drawn_eccentric(gear) / gear.eccentric


def background(gear: Gear) -> tuple[Shape, ...]:
    """The casting, and live steam in the chest."""
    u = gear.crank
    floor, ceiling, face, roof = _levels()
    outer, inner = (HALF + 0.10) * u, HALF * u
    chest = _chest_half(gear) * drawn_eccentric(gear)
    ends = [_beside(side, inner, outer) for side in (-1, 1)]
    sides = [_beside(side, chest, chest + 0.06 * u) for side in (-1, 1)]
    wall = [
        rectangle("casting", -outer, outer, FOOT * u, face * u),
        *(rectangle("casting", left, right, face * u, roof * u) for left, right in sides),
        rectangle("casting", -chest - 0.10 * u, chest + 0.10 * u, roof * u, (roof + LID) * u),
        rectangle("casting", outer, outer + GLAND * u, (FOOT + 0.13) * u, (FOOT + 2 * WALL + BORE - 0.13) * u),
    ]
    lined = [
        hatching("casting hatching", (-outer, outer, FOOT * u, floor * u), 0.05 * u),
        hatching("casting hatching", (-outer, outer, ceiling * u, face * u), 0.05 * u),
        *(hatching("casting hatching", (left, right, floor * u, ceiling * u), 0.05 * u) for left, right in ends),
        hatching("casting hatching", (-chest - 0.1 * u, chest + 0.1 * u, roof * u, (roof + LID) * u), 0.05 * u),
    ]
    return (
        *wall,
        *lined,
        rectangle("live steam", -chest, chest, face * u, roof * u),
        rectangle("bore", -inner, inner, floor * u, ceiling * u),
        Lines("bore edge", (((-chest, roof * u), (-chest, face * u)), ((chest, roof * u), (chest, face * u)))),
        _exhaust(gear),
        Text("scale", -outer, (FOOT - 0.075) * u, "head end", 0.3 * u),
        Text("scale", outer - 0.48 * u, (FOOT - 0.075) * u, "crank end", 0.48 * u),
        Text("scale", -0.33 * u, (FOOT - 0.075) * u, f"valve {magnified(gear):.3g} : 1", 0.66 * u),
    )


def _beside(side: int, near: float, far: float) -> Pair:
    """From left to right, on one side of the middle."""
    return (near, far) if side > 0 else (-far, -near)


def _edges(gear: Gear) -> tuple[float, float]:
    """Inner and outer edge of a steam port, from the middle (m of the picture)."""
    inner = (EXHAUST + BRIDGE) * drawn_eccentric(gear)
    return inner, inner + PORT * drawn_eccentric(gear)


def _chest_half(gear: Gear) -> float:
    """Half the length of the chest, in eccentrics: ports, lap, and how far the valve goes."""
    lap = max(gear.outside_lap, 0.0) / gear.eccentric
    return EXHAUST + BRIDGE + PORT + lap + 1.22


def _exhaust(gear: Gear) -> Polygon:
    """The exhaust port, a bowl under the face."""
    u, half = gear.crank, EXHAUST * drawn_eccentric(gear)
    face = _levels()[2]
    depth = 0.62 * BLOCK * u
    arc = tuple((half * math.cos(a), face * u - depth * math.sin(a)) for a in (math.pi * k / 16 for k in range(17)))
    return Polygon("spent steam", arc)


def _passage(gear: Gear, side: float) -> tuple[Pair, ...]:
    """A steam port, from the face down to its end of the bore."""
    u = gear.crank
    _, ceiling, face, _ = _levels()
    inner, outer = _edges(gear)
    end, width = HALF * u, 0.15 * u
    points = [
        (inner, face * u),
        (outer, face * u),
        (outer, (face - 0.05) * u),
        (end, (ceiling + 0.17) * u),
        (end, ceiling * u),
        (end - width, ceiling * u),
        (end - width, (ceiling + 0.08) * u),
        (inner, (face - 0.13) * u),
    ]
    return tuple((side * x, y) for x, y in points)


def moving(gear: Gear, at: Standing) -> tuple[Shape, ...]:
    """Steam at both ends, piston with its rod, and the valve."""
    u = gear.crank
    floor, ceiling, face, _ = _levels()
    half = PISTON / 2 * u
    shapes: list[Shape] = []
    for side in (1.0, -1.0):
        now = state(gear, at, side)
        edge = at.piston + side * half
        room = ((edge, floor * u), (side * HALF * u, floor * u), (side * HALF * u, ceiling * u), (edge, ceiling * u))
        for role in (ADMITTING, EXPANDING, EXHAUSTING, COMPRESSING):
            shapes.append(Polygon(role, room if role == now else ()))
            shapes.append(Polygon(role, _passage(gear, side) if role == now else ()))
        shapes.append(Lines("bore edge", (_closed(_passage(gear, side)),)))
    middle = (floor + ceiling) / 2
    box = ((-HALF * u, floor * u), (HALF * u, floor * u), (HALF * u, ceiling * u), (-HALF * u, ceiling * u))
    return (
        *shapes,
        Lines("bore edge", (_closed(box),)),
        rectangle("piston rod", at.piston, REACH * u, (middle - ROD) * u, (middle + ROD) * u),
        rectangle("piston", at.piston - half, at.piston + half, floor * u, ceiling * u),
        Lines("bore edge", tuple(_ring(at.piston + x * u, floor * u, ceiling * u) for x in (-0.03, 0.03))),
        *_valve(gear, at, face * u),
    )


def _ring(x: float, floor: float, ceiling: float) -> tuple[Pair, ...]:
    return (x, floor), (x, ceiling)


def _closed(points: tuple[Pair, ...]) -> tuple[Pair, ...]:
    return (*points, points[0])


def _valve(gear: Gear, at: Standing, face: float) -> tuple[Shape, ...]:
    """The D-shaped valve on the face, its cavity over bridge and exhaust port, and its spindle."""
    s, r = drawn_eccentric(gear), gear.eccentric
    x = -at.displacement / r * s  # away from the shaft is to the left
    inner, outer = _edges(gear)
    far, near = outer + gear.outside_lap / r * s, inner - gear.inside_lap / r * s
    top, u = face + HEIGHT * s, gear.crank
    body = (
        (x - far, face),
        (x - far, face + 0.30 * s),
        (x - near - 0.1 * s, top),
        (x + near + 0.1 * s, top),
        (x + far, face + 0.30 * s),
        (x + far, face),
    )
    roof = top - BACK * s
    cavity = (
        (x - near, face),
        (x - near, face + 0.2 * s),
        (x - near + 0.25 * s, roof),
        (x + near - 0.25 * s, roof),
        (x + near, face + 0.2 * s),
        (x + near, face),
    )
    stem = face + 0.36 * s
    return (
        rectangle("piston rod", x, REACH * u, stem - 0.08 * s, stem + 0.08 * s),
        Polygon("valve", body),
        Polygon("valve cavity", cavity),
    )

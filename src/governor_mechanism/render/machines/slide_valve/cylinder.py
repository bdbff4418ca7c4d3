"""Section of a slide-valve cylinder: piston, passages, and the valve over its ports in the steam chest.

The valve has a larger scale than the stroke; the drawing shows the ratio. The ports are as wide as the drawing needs.
"""

import math
from collections.abc import Iterator

from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.governor_parts import both_sides, mirror_outline
from governor_mechanism.render.machines.slide_valve.proportions import STEAM_PHASES, ValveGearPosition, ValveGearProportions

# In crank radii, from the middle of the stroke and the base of the view.
CYLINDER_BASE = 1.26
_WALL_THICKNESS, _BORE_HEIGHT, _BLOCK_HEIGHT, _CHEST_HEIGHT, _LID_THICKNESS = 0.075, 0.46, 0.30, 0.34, 0.065
_BORE_FLOOR = CYLINDER_BASE + _WALL_THICKNESS
_BORE_CEILING = _BORE_FLOOR + _BORE_HEIGHT
_VALVE_FACE = _BORE_CEILING + _BLOCK_HEIGHT
_CHEST_CEILING = _VALVE_FACE + _CHEST_HEIGHT
CHEST_TOP = _CHEST_CEILING + _LID_THICKNESS
"""Height of the top of the chest lid, in crank radii."""
_PISTON_THICKNESS, _PISTON_CLEARANCE = 0.16, 0.035
"""Thickness of the piston, and clearance at its dead centres, in crank radii."""
_MAX_DRAWN_ECCENTRIC = 0.33
"""Largest drawn eccentricity in the chest, in crank radii."""
_BORE_HALF_LENGTH = 1.0 + _PISTON_THICKNESS / 2 + _PISTON_CLEARANCE
"""Half length of the bore, in crank radii."""
_ROD_HALF_THICKNESS, _GLAND_LENGTH, _PICTURE_RIGHT = 0.045, 0.16, 1.52
"""Half thickness of the piston rod, length of its gland, and right end of the rods, in crank radii."""

# In eccentricities.
_EXHAUST_HALF_WIDTH, _BRIDGE_WIDTH, _PORT_WIDTH, _VALVE_BACK_THICKNESS, _VALVE_HEIGHT = 0.75, 0.30, 0.62, 0.22, 0.78


def drawn_eccentric(valve_gear: ValveGearProportions) -> float:
    """Return the drawn eccentricity in the chest (m); smaller for long laps, which would not fit."""
    return min(_MAX_DRAWN_ECCENTRIC, (_BORE_HALF_LENGTH - 0.02) / _chest_half_length(valve_gear)) * valve_gear.crank


def valve_magnification(valve_gear: ValveGearProportions) -> float:
    """Return the scale of the valve relative to the scale of the stroke."""
    return drawn_eccentric(valve_gear) / valve_gear.eccentric


def cylinder_background_shapes(valve_gear: ValveGearProportions) -> Iterator[DrawnShape]:
    """Yield the casting, and the live steam in the chest."""
    u = valve_gear.crank
    base, floor, ceiling, face, roof = (h * u for h in (CYLINDER_BASE, _BORE_FLOOR, _BORE_CEILING, _VALVE_FACE, _CHEST_CEILING))
    outer, inner = (_BORE_HALF_LENGTH + 0.10) * u, _BORE_HALF_LENGTH * u
    chest = _chest_half_length(valve_gear) * drawn_eccentric(valve_gear)
    lid = (-chest - 0.10 * u, chest + 0.10 * u, roof, CHEST_TOP * u)
    ends = ((left, right, floor, ceiling) for left, right in both_sides(inner, outer))
    yield make_rectangle("casting", -outer, outer, base, face)
    yield from (make_rectangle("casting", *side, face, roof) for side in both_sides(chest, chest + 0.06 * u))
    yield make_rectangle("casting", *lid)
    gland_top = (_BORE_CEILING + _WALL_THICKNESS - 0.13) * u
    yield make_rectangle("casting", outer, outer + _GLAND_LENGTH * u, (CYLINDER_BASE + 0.13) * u, gland_top)
    for section in ((-outer, outer, base, floor), (-outer, outer, ceiling, face), *ends, lid):
        yield make_hatching("casting hatching", section, 0.05 * u)
    yield make_rectangle("live steam", -chest, chest, face, roof)
    yield make_rectangle("bore", -inner, inner, floor, ceiling)
    yield Lines("bore edge", tuple(((x, roof), (x, face)) for x in (-chest, chest)))
    # The exhaust port, a bowl under the valve face.
    half, depth = _EXHAUST_HALF_WIDTH * drawn_eccentric(valve_gear), 0.62 * _BLOCK_HEIGHT * u
    yield Polygon("spent steam", tuple((half * math.cos(a), face - depth * math.sin(a)) for a in (math.pi * k / 16 for k in range(17))))


def _port_edges(valve_gear: ValveGearProportions) -> Vec2:
    """Return the distances of the inner and outer edge of a steam port from the centre (m of the picture)."""
    inner = (_EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH) * drawn_eccentric(valve_gear)
    return inner, inner + _PORT_WIDTH * drawn_eccentric(valve_gear)


def _chest_half_length(valve_gear: ValveGearProportions) -> float:
    """Return the half length of the chest in eccentricities: ports, lap and valve travel."""
    return _EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH + _PORT_WIDTH + max(valve_gear.outside_lap, 0.0) / valve_gear.eccentric + 1.22


def _passage_outline(valve_gear: ValveGearProportions, side: float) -> tuple[Vec2, ...]:
    """Return the outline of a steam passage from the valve face to its end of the bore."""
    u, (inner, outer) = valve_gear.crank, _port_edges(valve_gear)
    face, ceiling = _VALVE_FACE * u, _BORE_CEILING * u
    end, width = _BORE_HALF_LENGTH * u, 0.15 * u
    outer_edge = (outer, face), (outer, (_VALVE_FACE - 0.05) * u), (end, (_BORE_CEILING + 0.17) * u), (end, ceiling)
    inner_edge = (end - width, ceiling), (end - width, (_BORE_CEILING + 0.08) * u), (inner, (_VALVE_FACE - 0.13) * u)
    return tuple((side * x, y) for x, y in ((inner, face), *outer_edge, *inner_edge))


def cylinder_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition) -> Iterator[DrawnShape]:
    """Yield the steam at both ends, the piston with its rod, and the valve."""
    u, piston = valve_gear.crank, position.piston_position
    floor, ceiling = _BORE_FLOOR * u, _BORE_CEILING * u
    half_piston, half_bore = _PISTON_THICKNESS / 2 * u, _BORE_HALF_LENGTH * u
    for side in (1.0, -1.0):
        phase = valve_gear.steam_phase(position, side)
        passage = _passage_outline(valve_gear, side)
        face_x, end_x = piston + side * half_piston, side * half_bore
        steam_space = ((face_x, floor), (end_x, floor), (end_x, ceiling), (face_x, ceiling))
        yield from (Polygon(role, outline if role == phase else ()) for role in STEAM_PHASES for outline in (steam_space, passage))
        yield Lines("bore edge", ((*passage, passage[0]),))
    middle, rod = (_BORE_FLOOR + _BORE_CEILING) / 2 * u, _ROD_HALF_THICKNESS * u
    bore = make_rectangle("bore", -half_bore, half_bore, floor, ceiling)
    yield Lines("bore edge", ((*bore.points, bore.points[0]),))
    yield make_rectangle("piston rod", piston, _PICTURE_RIGHT * u, middle - rod, middle + rod)
    yield make_rectangle("piston", piston - half_piston, piston + half_piston, floor, ceiling)
    yield Lines("bore edge", tuple(((x, floor), (x, ceiling)) for x in (piston - 0.03 * u, piston + 0.03 * u)))
    yield from _valve_shapes(valve_gear, position)


def _valve_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition) -> Iterator[DrawnShape]:
    """Yield the D-slide valve on its face, its cavity over bridge and exhaust port, and its spindle."""
    r, u, scale = drawn_eccentric(valve_gear), valve_gear.crank, valve_magnification(valve_gear)
    face = _VALVE_FACE * u
    x = -position.valve_displacement * scale  # away from the shaft is left
    inner, outer = _port_edges(valve_gear)
    outer, inner = outer + valve_gear.outside_lap * scale, inner - valve_gear.inside_lap * scale
    top, stem = face + _VALVE_HEIGHT * r, face + 0.36 * r
    body = mirror_outline(((outer, face), (outer, face + 0.30 * r), (inner + 0.1 * r, top)))
    cavity = mirror_outline(((inner, face), (inner, face + 0.2 * r), (inner - 0.25 * r, top - _VALVE_BACK_THICKNESS * r)))
    yield make_rectangle("piston rod", x, _PICTURE_RIGHT * u, stem - 0.08 * r, stem + 0.08 * r)
    for role, outline in (("valve", body), ("valve cavity", cavity)):
        yield Polygon(role, tuple((x - dx, y) for dx, y in outline))

"""Section of a slide-valve cylinder: piston, passages, and the valve over its ports in the steam chest.

The valve has a larger scale than the stroke; the drawing shows the ratio. The ports are as wide as the drawing needs.
"""

from __future__ import annotations

import math

from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, TextShape, Vec2, make_hatching, make_rectangle
from governor_mechanism.render.machines.governor_parts import both_sides, mirror_outline
from governor_mechanism.render.machines.slide_valve.proportions import (
    ADMISSION_PHASE,
    COMPRESSION_PHASE,
    EXHAUST_PHASE,
    EXPANSION_PHASE,
    ValveGearPosition,
    ValveGearProportions,
    steam_phase,
)

# In crank radii, from the middle of the stroke and the base of the view.
CYLINDER_BASE = 1.26
_WALL_THICKNESS, _BORE_HEIGHT, _BLOCK_HEIGHT, _CHEST_HEIGHT, _LID_THICKNESS = 0.075, 0.46, 0.30, 0.34, 0.065
_PISTON_THICKNESS, _PISTON_CLEARANCE = 0.16, 0.035
"""Thickness of the piston, and clearance at its dead centres, in crank radii."""
_MAX_DRAWN_ECCENTRIC = 0.33
"""Largest drawn eccentricity in the chest, in crank radii."""
_BORE_HALF_LENGTH = 1.0 + _PISTON_THICKNESS / 2 + _PISTON_CLEARANCE
"""Half length of the bore, in crank radii."""
_ROD_HALF_THICKNESS, _GLAND_LENGTH, _PICTURE_RIGHT = 0.045, 0.16, 1.52
"""Half thickness of the piston rod, length of its gland, and right edge of the picture, in crank radii."""

# In eccentricities.
_EXHAUST_HALF_WIDTH, _BRIDGE_WIDTH, _PORT_WIDTH, _VALVE_BACK_THICKNESS, _VALVE_HEIGHT = 0.75, 0.30, 0.62, 0.22, 0.78

CHEST_TOP = CYLINDER_BASE + 2 * _WALL_THICKNESS + _BORE_HEIGHT + _BLOCK_HEIGHT - _WALL_THICKNESS + _CHEST_HEIGHT + _LID_THICKNESS
"""Height of the top of the chest lid, in crank radii."""


def _section_heights() -> tuple[float, float, float, float]:
    """Return the heights of bore floor, bore ceiling, valve face and chest ceiling (crank radii)."""
    floor = CYLINDER_BASE + _WALL_THICKNESS
    ceiling = floor + _BORE_HEIGHT
    face = ceiling + _BLOCK_HEIGHT
    return floor, ceiling, face, face + _CHEST_HEIGHT


def drawn_eccentric(valve_gear: ValveGearProportions) -> float:
    """Return the drawn eccentricity in the chest (m); smaller for long laps, which would not fit."""
    return min(_MAX_DRAWN_ECCENTRIC, (_BORE_HALF_LENGTH - 0.02) / _chest_half_length(valve_gear)) * valve_gear.crank


def valve_magnification(valve_gear: ValveGearProportions) -> float:
    """Return the scale of the valve relative to the scale of the stroke."""
    return drawn_eccentric(valve_gear) / valve_gear.eccentric


def cylinder_background_shapes(valve_gear: ValveGearProportions) -> tuple[DrawnShape, ...]:
    """Return the casting, and the live steam in the chest."""
    u = valve_gear.crank
    floor, ceiling, face, roof = _section_heights()
    outer, inner = (_BORE_HALF_LENGTH + 0.10) * u, _BORE_HALF_LENGTH * u
    chest = _chest_half_length(valve_gear) * drawn_eccentric(valve_gear)
    roof_edge = chest + 0.10 * u
    sections = [
        (-outer, outer, CYLINDER_BASE * u, floor * u),
        (-outer, outer, ceiling * u, face * u),
        *((left, right, floor * u, ceiling * u) for left, right in both_sides(inner, outer)),
        (-roof_edge, roof_edge, roof * u, (roof + _LID_THICKNESS) * u),
    ]
    gland_top = CYLINDER_BASE + 2 * _WALL_THICKNESS + _BORE_HEIGHT - 0.13
    return (
        make_rectangle("casting", -outer, outer, CYLINDER_BASE * u, face * u),
        *(make_rectangle("casting", *sides, face * u, roof * u) for sides in both_sides(chest, chest + 0.06 * u)),
        make_rectangle("casting", *sections[-1]),
        make_rectangle("casting", outer, outer + _GLAND_LENGTH * u, (CYLINDER_BASE + 0.13) * u, gland_top * u),
        *(make_hatching("casting hatching", section, 0.05 * u) for section in sections),
        make_rectangle("live steam", -chest, chest, face * u, roof * u),
        make_rectangle("bore", -inner, inner, floor * u, ceiling * u),
        Lines("bore edge", (((-chest, roof * u), (-chest, face * u)), ((chest, roof * u), (chest, face * u)))),
        _exhaust_port_shape(valve_gear),
        TextShape("scale", -outer, (CYLINDER_BASE - 0.075) * u, "head end", 0.3 * u),
        TextShape("scale", outer - 0.48 * u, (CYLINDER_BASE - 0.075) * u, "crank end", 0.48 * u),
        TextShape("scale", -0.33 * u, (CYLINDER_BASE - 0.075) * u, f"valve {valve_magnification(valve_gear):.3g} : 1", 0.66 * u),
    )


def _port_edges(valve_gear: ValveGearProportions) -> tuple[float, float]:
    """Return the distances of the inner and outer edge of a steam port from the centre (m of the picture)."""
    inner = (_EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH) * drawn_eccentric(valve_gear)
    return inner, inner + _PORT_WIDTH * drawn_eccentric(valve_gear)


def _chest_half_length(valve_gear: ValveGearProportions) -> float:
    """Return the half length of the chest in eccentricities: ports, lap and valve travel."""
    lap = max(valve_gear.outside_lap, 0.0) / valve_gear.eccentric
    return _EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH + _PORT_WIDTH + lap + 1.22


def _exhaust_port_shape(valve_gear: ValveGearProportions) -> Polygon:
    """Return the exhaust port, a bowl under the valve face."""
    u, half = valve_gear.crank, _EXHAUST_HALF_WIDTH * drawn_eccentric(valve_gear)
    face = _section_heights()[2]
    depth = 0.62 * _BLOCK_HEIGHT * u
    arc = tuple((half * math.cos(a), face * u - depth * math.sin(a)) for a in (math.pi * k / 16 for k in range(17)))
    return Polygon("spent steam", arc)


def _passage_outline(valve_gear: ValveGearProportions, side: float) -> tuple[Vec2, ...]:
    """Return the outline of a steam passage from the valve face to its end of the bore."""
    u = valve_gear.crank
    _, ceiling, face, _ = _section_heights()
    inner, outer = _port_edges(valve_gear)
    end, width = _BORE_HALF_LENGTH * u, 0.15 * u
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


def cylinder_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition) -> tuple[DrawnShape, ...]:
    """Return the steam at both ends, the piston with its rod, and the valve."""
    u = valve_gear.crank
    floor, ceiling, face, _ = _section_heights()
    half_piston = _PISTON_THICKNESS / 2 * u
    piston, half_bore = position.piston_position, _BORE_HALF_LENGTH * u
    shapes: list[DrawnShape] = []
    for side in (1.0, -1.0):
        phase = steam_phase(valve_gear, position, side)
        face_x, end_x, passage = piston + side * half_piston, side * half_bore, _passage_outline(valve_gear, side)
        steam_space = ((face_x, floor * u), (end_x, floor * u), (end_x, ceiling * u), (face_x, ceiling * u))
        for role in (ADMISSION_PHASE, EXPANSION_PHASE, EXHAUST_PHASE, COMPRESSION_PHASE):
            shapes += [Polygon(role, outline if role == phase else ()) for outline in (steam_space, passage)]
        shapes.append(Lines("bore edge", ((*passage, passage[0]),)))
    middle, rod = (floor + ceiling) / 2 * u, _ROD_HALF_THICKNESS * u
    corners = ((-half_bore, floor * u), (half_bore, floor * u), (half_bore, ceiling * u), (-half_bore, ceiling * u))
    rings = tuple(((x, floor * u), (x, ceiling * u)) for x in (piston - 0.03 * u, piston + 0.03 * u))
    return (
        *shapes,
        Lines("bore edge", ((*corners, corners[0]),)),
        make_rectangle("piston rod", piston, _PICTURE_RIGHT * u, middle - rod, middle + rod),
        make_rectangle("piston", piston - half_piston, piston + half_piston, floor * u, ceiling * u),
        Lines("bore edge", rings),
        *_valve_shapes(valve_gear, position, face * u),
    )


def _valve_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition, face: float) -> tuple[DrawnShape, ...]:
    """Return the D-slide valve on its face, its cavity over bridge and exhaust port, and its spindle."""
    r, u = drawn_eccentric(valve_gear), valve_gear.crank
    scale = r / valve_gear.eccentric
    x = -position.valve_displacement * scale  # away from the shaft is left
    inner, outer = _port_edges(valve_gear)
    outer, inner = outer + valve_gear.outside_lap * scale, inner - valve_gear.inside_lap * scale
    top, stem = face + _VALVE_HEIGHT * r, face + 0.36 * r
    body = mirror_outline(((outer, face), (outer, face + 0.30 * r), (inner + 0.1 * r, top)))
    cavity = mirror_outline(((inner, face), (inner, face + 0.2 * r), (inner - 0.25 * r, top - _VALVE_BACK_THICKNESS * r)))
    return (
        make_rectangle("piston rod", x, _PICTURE_RIGHT * u, stem - 0.08 * r, stem + 0.08 * r),
        Polygon("valve", tuple((x - dx, y) for dx, y in body)),
        Polygon("valve cavity", tuple((x - dx, y) for dx, y in cavity)),
    )

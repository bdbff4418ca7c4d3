"""Section of a slide-valve cylinder: piston, passages, and the valve over its ports in the steam chest.

The valve has a larger scale than the stroke; the drawing shows the ratio. The ports are as wide as the drawing needs.
"""

from __future__ import annotations

import math

from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, TextShape, Vec2, make_hatching, make_rectangle
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
    end_walls = [_mirrored_interval(side, inner, outer) for side in (-1, 1)]
    chest_walls = [_mirrored_interval(side, chest, chest + 0.06 * u) for side in (-1, 1)]
    casting = [
        make_rectangle("casting", -outer, outer, CYLINDER_BASE * u, face * u),
        *(make_rectangle("casting", left, right, face * u, roof * u) for left, right in chest_walls),
        make_rectangle("casting", -chest - 0.10 * u, chest + 0.10 * u, roof * u, (roof + _LID_THICKNESS) * u),
        make_rectangle(
            "casting",
            outer,
            outer + _GLAND_LENGTH * u,
            (CYLINDER_BASE + 0.13) * u,
            (CYLINDER_BASE + 2 * _WALL_THICKNESS + _BORE_HEIGHT - 0.13) * u,
        ),
    ]
    casting_hatching = [
        make_hatching("casting hatching", (-outer, outer, CYLINDER_BASE * u, floor * u), 0.05 * u),
        make_hatching("casting hatching", (-outer, outer, ceiling * u, face * u), 0.05 * u),
        *(make_hatching("casting hatching", (left, right, floor * u, ceiling * u), 0.05 * u) for left, right in end_walls),
        make_hatching("casting hatching", (-chest - 0.1 * u, chest + 0.1 * u, roof * u, (roof + _LID_THICKNESS) * u), 0.05 * u),
    ]
    return (
        *casting,
        *casting_hatching,
        make_rectangle("live steam", -chest, chest, face * u, roof * u),
        make_rectangle("bore", -inner, inner, floor * u, ceiling * u),
        Lines("bore edge", (((-chest, roof * u), (-chest, face * u)), ((chest, roof * u), (chest, face * u)))),
        _exhaust_port_shape(valve_gear),
        TextShape("scale", -outer, (CYLINDER_BASE - 0.075) * u, "head end", 0.3 * u),
        TextShape("scale", outer - 0.48 * u, (CYLINDER_BASE - 0.075) * u, "crank end", 0.48 * u),
        TextShape("scale", -0.33 * u, (CYLINDER_BASE - 0.075) * u, f"valve {valve_magnification(valve_gear):.3g} : 1", 0.66 * u),
    )


def _mirrored_interval(side: int, inner: float, outer: float) -> Vec2:
    """Return left and right of an interval on one side of the centre."""
    return (inner, outer) if side > 0 else (-outer, -inner)


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
    shapes: list[DrawnShape] = []
    for side in (1.0, -1.0):
        phase = steam_phase(valve_gear, position, side)
        piston_face = position.piston_position + side * half_piston
        steam_space = (
            (piston_face, floor * u),
            (side * _BORE_HALF_LENGTH * u, floor * u),
            (side * _BORE_HALF_LENGTH * u, ceiling * u),
            (piston_face, ceiling * u),
        )
        for role in (ADMISSION_PHASE, EXPANSION_PHASE, EXHAUST_PHASE, COMPRESSION_PHASE):
            shapes.append(Polygon(role, steam_space if role == phase else ()))
            shapes.append(Polygon(role, _passage_outline(valve_gear, side) if role == phase else ()))
        shapes.append(Lines("bore edge", (_closed_polyline(_passage_outline(valve_gear, side)),)))
    middle = (floor + ceiling) / 2
    bore_outline = (
        (-_BORE_HALF_LENGTH * u, floor * u),
        (_BORE_HALF_LENGTH * u, floor * u),
        (_BORE_HALF_LENGTH * u, ceiling * u),
        (-_BORE_HALF_LENGTH * u, ceiling * u),
    )
    return (
        *shapes,
        Lines("bore edge", (_closed_polyline(bore_outline),)),
        make_rectangle(
            "piston rod",
            position.piston_position,
            _PICTURE_RIGHT * u,
            (middle - _ROD_HALF_THICKNESS) * u,
            (middle + _ROD_HALF_THICKNESS) * u,
        ),
        make_rectangle("piston", position.piston_position - half_piston, position.piston_position + half_piston, floor * u, ceiling * u),
        Lines("bore edge", tuple(_piston_ring(position.piston_position + x * u, floor * u, ceiling * u) for x in (-0.03, 0.03))),
        *_valve_shapes(valve_gear, position, face * u),
    )


def _piston_ring(x: float, floor: float, ceiling: float) -> tuple[Vec2, ...]:
    return (x, floor), (x, ceiling)


def _closed_polyline(points: tuple[Vec2, ...]) -> tuple[Vec2, ...]:
    return (*points, points[0])


def _valve_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition, face: float) -> tuple[DrawnShape, ...]:
    """Return the D-slide valve on its face, its cavity over bridge and exhaust port, and its spindle."""
    drawn_radius, eccentric_radius = drawn_eccentric(valve_gear), valve_gear.eccentric
    valve_centre = -position.valve_displacement / eccentric_radius * drawn_radius  # away from the shaft is left
    inner, outer = _port_edges(valve_gear)
    outer_half_width, inner_half_width = (
        outer + valve_gear.outside_lap / eccentric_radius * drawn_radius,
        inner - valve_gear.inside_lap / eccentric_radius * drawn_radius,
    )
    top, u = face + _VALVE_HEIGHT * drawn_radius, valve_gear.crank
    body = (
        (valve_centre - outer_half_width, face),
        (valve_centre - outer_half_width, face + 0.30 * drawn_radius),
        (valve_centre - inner_half_width - 0.1 * drawn_radius, top),
        (valve_centre + inner_half_width + 0.1 * drawn_radius, top),
        (valve_centre + outer_half_width, face + 0.30 * drawn_radius),
        (valve_centre + outer_half_width, face),
    )
    roof = top - _VALVE_BACK_THICKNESS * drawn_radius
    cavity = (
        (valve_centre - inner_half_width, face),
        (valve_centre - inner_half_width, face + 0.2 * drawn_radius),
        (valve_centre - inner_half_width + 0.25 * drawn_radius, roof),
        (valve_centre + inner_half_width - 0.25 * drawn_radius, roof),
        (valve_centre + inner_half_width, face + 0.2 * drawn_radius),
        (valve_centre + inner_half_width, face),
    )
    stem = face + 0.36 * drawn_radius
    return (
        make_rectangle("piston rod", valve_centre, _PICTURE_RIGHT * u, stem - 0.08 * drawn_radius, stem + 0.08 * drawn_radius),
        Polygon("valve", body),
        Polygon("valve cavity", cavity),
    )

"""Section of a cylinder: casting, bore, piston and rod, and the steam at both ends.

Lengths are in crank radii, from the middle of the stroke and the axis of the bore; the crank end lies at +x.
"""

from collections.abc import Iterator

from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon
from governor_mechanism.render.machines.governor_parts import both_sides

WALL_THICKNESS, BORE_HALF_HEIGHT, END_THICKNESS, GLAND_LENGTH = 0.075, 0.23, 0.10, 0.16
PISTON_THICKNESS, PISTON_CLEARANCE = 0.16, 0.035
"""Thickness of the piston, and clearance at its dead centres."""
BORE_HALF_LENGTH = 1.0 + PISTON_THICKNESS / 2 + PISTON_CLEARANCE
_ROD_HALF_THICKNESS, _GLAND_HALF_HEIGHT, _HATCHING_SPACING = 0.045, 0.175, 0.05


def bore_background_shapes(crank: float, axis: float, top: float) -> Iterator[DrawnShape]:
    """Yield the casting up to a height `top` and the empty bore, with its axis at a height (m); `crank` is the crank radius (m)."""
    u, outer, inner = crank, (BORE_HALF_LENGTH + END_THICKNESS) * crank, BORE_HALF_LENGTH * crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    base = floor - WALL_THICKNESS * u
    gland = _GLAND_HALF_HEIGHT * u
    yield make_rectangle("casting", -outer, outer, base, top)
    yield make_rectangle("casting", outer, outer + GLAND_LENGTH * u, axis - gland, axis + gland)
    ends = ((left, right, floor, ceiling) for left, right in both_sides(inner, outer))
    for section in ((-outer, outer, base, floor), (-outer, outer, ceiling, top), *ends):
        yield make_hatching("casting hatching", section, _HATCHING_SPACING * u)
    yield make_rectangle("bore", -inner, inner, floor, ceiling)


def piston_shapes(crank: float, axis: float, piston: float, rod_end: float) -> Iterator[DrawnShape]:
    """Yield the edge of the bore, and the piston at a position along the stroke with its rod to `rod_end` (m)."""
    u, half_bore = crank, BORE_HALF_LENGTH * crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    rod, half_piston = _ROD_HALF_THICKNESS * u, PISTON_THICKNESS / 2 * u
    bore = make_rectangle("bore", -half_bore, half_bore, floor, ceiling)
    yield Lines("bore edge", ((*bore.points, bore.points[0]),))
    yield make_rectangle("piston rod", piston, rod_end, axis - rod, axis + rod)
    yield make_rectangle("piston", piston - half_piston, piston + half_piston, floor, ceiling)
    yield Lines("bore edge", tuple(((x, floor), (x, ceiling)) for x in (piston - 0.03 * u, piston + 0.03 * u)))


def steam_space(role: str, crank: float, axis: float, piston: float, side: float) -> Polygon:
    """Return the space between the piston and an end of the bore; `side` is 1 at the crank end, -1 at the head end."""
    u = crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    face_x, end_x = piston + side * PISTON_THICKNESS / 2 * u, side * BORE_HALF_LENGTH * u
    return Polygon(role, ((face_x, floor), (end_x, floor), (end_x, ceiling), (face_x, ceiling)))

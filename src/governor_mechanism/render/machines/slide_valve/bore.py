"""Section of a cylinder: casting, bore, piston and rod, and the steam at both ends.

Lengths are in crank radii, from the middle of the stroke and the axis of the bore; the crank end lies at +x.
"""

from collections.abc import Callable, Iterator
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_shifted, fixed
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


def piston_parts(crank: float, axis: float, piston_at: Callable[[Any], float], rod_end: float, *, rod_moves: bool) -> Iterator[DrawnPart]:
    """Yield the edge of the bore, and the piston at a position along the stroke (m) with its rod.

    The rod ends at `rod_end` (m): fixed at the edge of a picture, or, where it moves with the piston, from the piston.
    """
    u, half_bore = crank, BORE_HALF_LENGTH * crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    rod, half_piston = _ROD_HALF_THICKNESS * u, PISTON_THICKNESS / 2 * u
    piston_axes = axes_shifted(lambda moment: (piston_at(moment), 0.0))
    bore = make_rectangle("bore", -half_bore, half_bore, floor, ceiling)
    yield fixed([Lines("bore edge", ((*bore.points, bore.points[0]),))])
    if rod_moves:
        yield Attached(frame=piston_axes, shapes=(make_rectangle("piston rod", 0.0, rod_end, axis - rod, axis + rod),))
    else:
        yield Flexible(shapes_at=lambda moment: [make_rectangle("piston rod", piston_at(moment), rod_end, axis - rod, axis + rod)])
    rings = Lines("bore edge", tuple(((x, floor), (x, ceiling)) for x in (-0.03 * u, 0.03 * u)))
    yield Attached(frame=piston_axes, shapes=(make_rectangle("piston", -half_piston, half_piston, floor, ceiling), rings))


def steam_space(role: str, crank: float, axis: float, piston: float, side: float) -> Polygon:
    """Return the space between the piston and an end of the bore; `side` is 1 at the crank end, -1 at the head end."""
    u = crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    face_x, end_x = piston + side * PISTON_THICKNESS / 2 * u, side * BORE_HALF_LENGTH * u
    return Polygon(role, ((face_x, floor), (end_x, floor), (end_x, ceiling), (face_x, ceiling)))

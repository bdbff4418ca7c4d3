"""A cylinder in section with its ports, its steam chest and the slide valve in it.

Lengths are in crank radii, from the middle of the stroke and the axis of the bore; the crank end lies at +x. Laps and travel are true to
the scale of the valve, which is larger than that of the stroke; the drawing shows the ratio. Ports, bridges and exhaust are as wide as
the drawing needs. The face is the line y = `face`, from the middle of the valve's travel.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, axes_shifted, fixed
from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.governor_parts import both_sides, mirror_outline
from governor_mechanism.render.machines.steam_distribution import (
    SteamDistribution,
    ValveGearPosition,
    changing_space_parts,
    phase_parts,
    steam_phase,
)

# In eccentricities.
_EXHAUST_HALF_WIDTH = 0.75
_BRIDGE_WIDTH = 0.30
_PORT_WIDTH = 0.62
_VALVE_BACK_THICKNESS = 0.22
_VALVE_HEIGHT = 0.78
_LID_OVERHANG = 5 / 3
"""Length by which the lid is longer than the inside of the chest at either end, in thicknesses of the wall."""
_STEM_HEIGHT = 0.36
_STEM_HALF_THICKNESS = 0.08
_END_CLEARANCE = 1.22
"""Height of the middle of the slide valve's spindle above the face, half its thickness, and clearance of the valve at its ends."""


@dataclass(frozen=True, kw_only=True)
class SteamChest:
    """Steam chest of a valve; lengths of the picture, m."""

    distribution: SteamDistribution  # eccentricity and laps
    eccentric: float  # drawn eccentricity
    face: float  # height of the face of the ports
    height: float  # height of the chest above the face
    # side_wall, lid: thickness of the walls at the ends and of the lid
    side_wall: float
    lid: float
    hatching_spacing: float  # distance of the lines of section lining
    bowl_depth: float  # depth of the port in the middle

    @property
    def scale(self) -> float:
        """Metres of the picture per metre of the valve."""
        return self.eccentric / self.distribution.eccentric

    @property
    def half_length(self) -> float:
        """Half length of the inside of the chest."""
        return chest_half_length(self.distribution) * self.eccentric

    @property
    def top(self) -> float:
        """Height of the top of the lid."""
        return self.face + self.height + self.lid

    @property
    def stem_height(self) -> float:
        """Height of the axis of the valve rod."""
        return self.face + (0.5 * self.height if self._has_piston_valve else _STEM_HEIGHT * self.eccentric)

    @property
    def port_edges(self) -> Vec2:
        """Distances of the inner and outer edge of a steam port from the centre."""
        inner = (_EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH) * self.eccentric
        return inner, inner + _PORT_WIDTH * self.eccentric

    @property
    def _has_piston_valve(self) -> bool:
        return self.distribution.outward_sign < 0

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the walls and the lid, the steam around the valve, and the port in the middle."""
        chest, roof = self.half_length, self.face + self.height
        inside, bowl = ("spent steam", "live steam") if self._has_piston_valve else ("live steam", "spent steam")
        lid = (-chest - _LID_OVERHANG * self.side_wall, chest + _LID_OVERHANG * self.side_wall, roof, self.top)
        yield from (make_rectangle("casting", *side, self.face, roof) for side in both_sides(chest, chest + self.side_wall))
        yield make_rectangle("casting", *lid)
        yield make_hatching("casting hatching", lid, self.hatching_spacing)
        yield make_rectangle(inside, -chest, chest, self.face, roof)
        yield Lines("bore edge", tuple(((x, roof), (x, self.face)) for x in (-chest, chest)))
        half = _EXHAUST_HALF_WIDTH * self.eccentric
        angles = [math.pi * k / 16 for k in range(17)]
        yield Polygon(bowl, tuple((half * math.cos(a), self.face - self.bowl_depth * math.sin(a)) for a in angles))

    def valve_parts(self, displacement_at: Callable[[Any], float], rod_end: float, *, rod_moves: bool) -> Iterator[DrawnPart]:
        """Yield the valve at a displacement away from the shaft (m of the valve), and its rod.

        The rod ends at `rod_end`: fixed at the edge of a picture, or, where it moves with the valve, from the middle of the valve.
        """
        valve_axes = axes_shifted(lambda moment: (-displacement_at(moment) * self.scale, 0.0))
        rod_start = -self._valve_edges[1] if self._has_piston_valve else 0.0
        stem, half = self.stem_height, _STEM_HALF_THICKNESS * self.eccentric
        if self._has_piston_valve:
            yield Attached(frame=valve_axes, shapes=(self._admitted_steam(),))
        if rod_moves:
            yield Attached(frame=valve_axes, shapes=(make_rectangle("piston rod", rod_start, rod_end, stem - half, stem + half),))
        else:
            yield Flexible(
                shapes_at=lambda moment: [
                    make_rectangle("piston rod", valve_axes(moment)[0] + rod_start, rod_end, stem - half, stem + half)
                ]
            )
        shapes = self._piston_valve_shapes() if self._has_piston_valve else self._slide_valve_shapes()
        yield Attached(frame=valve_axes, shapes=tuple(shapes))

    @property
    def _valve_edges(self) -> Vec2:
        """Distances of the inner and outer edge of either half of the valve from its middle."""
        inner, outer = self.port_edges
        laps = (self.distribution.inside_lap * self.scale, self.distribution.outside_lap * self.scale)
        inner_lap, outer_lap = laps[::-1] if self._has_piston_valve else laps
        return inner - inner_lap, outer + outer_lap

    def _slide_valve_shapes(self) -> Iterator[DrawnShape]:
        """Yield the D-slide valve on its face, and its cavity over bridge and exhaust port, from its middle."""
        r = self.eccentric
        face = self.face
        inner, outer = self._valve_edges
        top = face + _VALVE_HEIGHT * r
        yield Polygon("valve", mirror_outline(((outer, face), (outer, face + 0.30 * r), (inner + 0.1 * r, top))))
        cavity = ((inner, face), (inner, face + 0.2 * r), (inner - 0.25 * r, top - _VALVE_BACK_THICKNESS * r))
        yield Polygon("valve cavity", mirror_outline(cavity))

    def _admitted_steam(self) -> DrawnShape:
        """Return the live steam between the heads of a piston valve."""
        inner = self._valve_edges[0]
        return make_rectangle("live steam", -inner, inner, self.face, self.face + self.height)

    def _piston_valve_shapes(self) -> Iterator[DrawnShape]:
        """Yield the heads of a piston valve, whose inner edges admit the steam, from its middle."""
        sides = both_sides(*self._valve_edges)
        yield from (make_rectangle("valve", left, right, self.face, self.face + self.height) for left, right in sides)


def chest_half_length(distribution: SteamDistribution) -> float:
    """Return the half length of the chest in eccentricities: ports, lap and valve travel."""
    ports = _EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH + _PORT_WIDTH
    lap = distribution.outside_lap if distribution.outward_sign > 0 else distribution.inside_lap
    return ports + max(lap, 0.0) / distribution.eccentric + _END_CLEARANCE


WALL_THICKNESS = 0.075
BORE_HALF_HEIGHT = 0.23
END_THICKNESS = 0.10
GLAND_LENGTH = 0.16
PISTON_THICKNESS, PISTON_CLEARANCE = 0.16, 0.035
"""Thickness of the piston, and clearance at its dead centres."""
BORE_HALF_LENGTH = 1.0 + PISTON_THICKNESS / 2 + PISTON_CLEARANCE
_ROD_HALF_THICKNESS = 0.045
_GLAND_HALF_HEIGHT = 0.175
_HATCHING_SPACING = 0.05


def bore_background_shapes(crank: float, axis: float, top: float) -> Iterator[DrawnShape]:
    """Yield the casting up to a height `top` and the empty bore, with its axis at a height (m); `crank` is the crank radius (m)."""
    u = crank
    outer = (BORE_HALF_LENGTH + END_THICKNESS) * crank
    inner = BORE_HALF_LENGTH * crank
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


def steam_space(crank: float, axis: float, piston: float, side: float) -> tuple[Vec2, ...]:
    """Return the outline of the space between the piston and an end of the bore; `side` is 1 at the crank end, -1 at the head end."""
    u = crank
    floor, ceiling = axis - BORE_HALF_HEIGHT * u, axis + BORE_HALF_HEIGHT * u
    face_x = piston + side * PISTON_THICKNESS / 2 * u
    end_x = side * BORE_HALF_LENGTH * u
    return (face_x, floor), (end_x, floor), (end_x, ceiling), (face_x, ceiling)


PositionAt = Callable[[Moment], ValveGearPosition]
"""Position of a valve gear at a moment."""

# In crank radii, from the middle of the stroke and the base of the view.
CYLINDER_BASE = 1.26
_BLOCK_HEIGHT = 0.30
_CHEST_HEIGHT = 0.34
_LID_THICKNESS = 0.065
_SIDE_WALL = 0.06
_PICTURE_RIGHT = 1.52
"""Sizes of the block of the ports and of the chest, and right end of the rods."""
_AXIS = CYLINDER_BASE + WALL_THICKNESS + BORE_HALF_HEIGHT
_BORE_CEILING = _AXIS + BORE_HALF_HEIGHT
_VALVE_FACE = _BORE_CEILING + _BLOCK_HEIGHT
CHEST_TOP = _VALVE_FACE + _CHEST_HEIGHT + _LID_THICKNESS
"""Height of the top of the chest lid, in crank radii."""
_MAX_DRAWN_ECCENTRIC = 0.33
"""Largest drawn eccentricity in the chest, in crank radii."""


def valve_magnification(valve_gear: SteamDistribution) -> float:
    """Return the scale of the valve relative to the scale of the stroke."""
    return _chest_of(valve_gear).scale


def cylinder_background_shapes(valve_gear: SteamDistribution) -> Iterator[DrawnShape]:
    """Yield the casting, and the live steam in the chest."""
    u = valve_gear.crank
    yield from bore_background_shapes(u, _AXIS * u, _VALVE_FACE * u)
    yield from _chest_of(valve_gear).background_shapes()


def cylinder_moving_parts(valve_gear: SteamDistribution, position_at: PositionAt) -> Iterator[DrawnPart]:
    """Yield the steam at both ends, the piston with its rod, and the valve."""
    u, chest = valve_gear.crank, _chest_of(valve_gear)
    for side in (1.0, -1.0):
        passage = _passage_outline(chest, u, side)
        phase_at = partial(_phase_at, valve_gear, position_at, side)
        spaces = changing_space_parts(phase_at, partial(_space_at, u, position_at, side))
        for pair in zip(spaces, phase_parts(phase_at, passage), strict=True):
            yield from pair
        yield fixed([Lines("bore edge", ((*passage, passage[0]),))])
    right = _PICTURE_RIGHT * u
    yield from piston_parts(u, _AXIS * u, lambda moment: position_at(moment).piston_position, right, rod_moves=False)
    yield from chest.valve_parts(lambda moment: position_at(moment).valve_displacement, right, rod_moves=False)


def _phase_at(valve_gear: SteamDistribution, position_at: PositionAt, side: float, moment: Moment) -> str:
    return steam_phase(valve_gear, position_at(moment), side)


def _space_at(crank: float, position_at: PositionAt, side: float, moment: Moment) -> tuple[Vec2, ...]:
    """Return the outline of the space between the piston and an end of the bore."""
    return steam_space(crank, _AXIS * crank, position_at(moment).piston_position, side)


def _chest_of(valve_gear: SteamDistribution) -> SteamChest:
    """Return the chest, with a smaller drawn eccentricity for long laps, which would not fit."""
    u = valve_gear.crank
    drawn_eccentric = min(_MAX_DRAWN_ECCENTRIC, (BORE_HALF_LENGTH - 0.02) / chest_half_length(valve_gear)) * u
    return SteamChest(
        distribution=valve_gear,
        eccentric=drawn_eccentric,
        face=_VALVE_FACE * u,
        height=_CHEST_HEIGHT * u,
        side_wall=_SIDE_WALL * u,
        lid=_LID_THICKNESS * u,
        hatching_spacing=0.05 * u,
        bowl_depth=0.62 * _BLOCK_HEIGHT * u,
    )


def _passage_outline(chest: SteamChest, u: float, side: float) -> tuple[Vec2, ...]:
    """Return the outline of a steam passage from the valve face to its end of the bore, for a crank radius `u` (m)."""
    inner, outer = chest.port_edges
    face, ceiling = _VALVE_FACE * u, _BORE_CEILING * u
    end, width = BORE_HALF_LENGTH * u, 0.15 * u
    outer_edge = (outer, face), (outer, (_VALVE_FACE - 0.05) * u), (end, (_BORE_CEILING + 0.17) * u), (end, ceiling)
    inner_edge = (end - width, ceiling), (end - width, (_BORE_CEILING + 0.08) * u), (inner, (_VALVE_FACE - 0.13) * u)
    return tuple((side * x, y) for x, y in ((inner, face), *outer_edge, *inner_edge))

"""Section of a slide-valve cylinder: piston, passages, and the valve over its ports in the steam chest.

The valve has a larger scale than the stroke; the drawing shows the ratio. The ports are as wide as the drawing needs.
"""

from collections.abc import Callable, Iterator
from functools import partial

from governor_mechanism.render.geometry.attached import DrawnPart, Moment, fixed
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Vec2
from governor_mechanism.render.machines.slide_valve.bore import (
    BORE_HALF_HEIGHT,
    BORE_HALF_LENGTH,
    WALL_THICKNESS,
    bore_background_shapes,
    piston_parts,
    steam_space,
)
from governor_mechanism.render.machines.slide_valve.steam_chest import SteamChest, chest_half_length
from governor_mechanism.render.machines.slide_valve.steam_distribution import (
    STEAM_PHASES,
    SteamDistribution,
    ValveGearPosition,
    changing_space_parts,
    phase_parts,
    steam_phase,
)

PositionAt = Callable[[Moment], ValveGearPosition]
"""Position of a valve gear at a moment."""

# In crank radii, from the middle of the stroke and the base of the view.
CYLINDER_BASE = 1.26
_BLOCK_HEIGHT, _CHEST_HEIGHT, _LID_THICKNESS, _SIDE_WALL, _PICTURE_RIGHT = 0.30, 0.34, 0.065, 0.06, 1.52
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
        spaces = changing_space_parts(STEAM_PHASES, phase_at, partial(_space_at, u, position_at, side))
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
    return steam_space("", crank, _AXIS * crank, position_at(moment).piston_position, side).points


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

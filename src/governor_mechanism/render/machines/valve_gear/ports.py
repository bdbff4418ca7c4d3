"""The block of the ports below a steam chest, with straight ports, as a valve gear is drawn with at two scales."""

from collections.abc import Callable, Iterator

from governor_mechanism.render.geometry.attached import Attached, Moment
from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape
from governor_mechanism.render.machines.slide_valve.steam_chest import SteamChest
from governor_mechanism.render.machines.slide_valve.steam_distribution import SteamDistribution, phase_parts

BLOCK_DEPTH = 0.95
"""Depth of the block, in eccentricities."""
_CHEST_HEIGHT, _SIDE_WALL, _LID, _HATCHING_SPACING = 1.06, 0.18, 0.20, 0.17
"""Sizes of the chest, in eccentricities."""


def make_chest(gear: SteamDistribution, eccentric: float) -> SteamChest:
    """Return the chest of a valve gear with a drawn eccentricity (m), its face at height 0."""
    return SteamChest(
        distribution=gear,
        eccentric=eccentric,
        face=0.0,
        height=_CHEST_HEIGHT * eccentric,
        side_wall=_SIDE_WALL * eccentric,
        lid=_LID * eccentric,
        hatching_spacing=_HATCHING_SPACING * eccentric,
        bowl_depth=0.62 * BLOCK_DEPTH * eccentric,
    )


def block_shapes(chest: SteamChest) -> Iterator[DrawnShape]:
    """Yield the block of the ports below the face of a chest."""
    half = chest.half_length + chest.side_wall
    box = (-half, half, chest.face - BLOCK_DEPTH * chest.eccentric, chest.face)
    yield make_rectangle("casting", *box)
    yield make_hatching("casting hatching", box, chest.hatching_spacing)


def port_parts(chest: SteamChest, phase_at: Callable[[Moment], str], side: float) -> Iterator[Attached]:
    """Yield the port of one end in the block, with its steam in the phase of a moment."""
    inner, outer = chest.port_edges
    left, right = sorted((side * inner, side * outer))
    port = make_rectangle("", left, right, chest.face - BLOCK_DEPTH * chest.eccentric, chest.face).points
    yield from phase_parts(phase_at, port)

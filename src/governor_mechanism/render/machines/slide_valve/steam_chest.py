"""Section of a steam chest: the ports in their face, and over them a slide valve, or a piston valve with inside admission.

The face is the line y = `face`, from the middle of the valve's travel; the crank end lies at +x. Laps and travel are true to the scale of
the valve. Ports, bridges and exhaust are as wide as the drawing needs.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_shifted
from governor_mechanism.render.geometry.outlines import make_hatching, make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.governor_parts import both_sides, mirror_outline
from governor_mechanism.render.machines.slide_valve.steam_distribution import SteamDistribution

# In eccentricities.
_EXHAUST_HALF_WIDTH, _BRIDGE_WIDTH, _PORT_WIDTH, _VALVE_BACK_THICKNESS, _VALVE_HEIGHT = 0.75, 0.30, 0.62, 0.22, 0.78
_LID_OVERHANG = 5 / 3
"""Length by which the lid is longer than the inside of the chest at either end, in thicknesses of the wall."""
_STEM_HEIGHT, _STEM_HALF_THICKNESS, _END_CLEARANCE = 0.36, 0.08, 1.22
"""Height of the middle of the slide valve's spindle above the face, half its thickness, and clearance of the valve at its ends."""


@dataclass(frozen=True, kw_only=True)
class SteamChest:
    """Steam chest of a valve; lengths of the picture, m.

    Attributes
    ----------
    distribution
        Eccentricity and laps.
    eccentric
        Drawn eccentricity.
    face
        Height of the face of the ports.
    height
        Height of the chest above the face.
    side_wall, lid
        Thickness of the walls at the ends and of the lid.
    hatching_spacing
        Distance of the lines of section lining.
    bowl_depth
        Depth of the port in the middle.
    """

    distribution: SteamDistribution
    eccentric: float
    face: float
    height: float
    side_wall: float
    lid: float
    hatching_spacing: float
    bowl_depth: float

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
        half, angles = _EXHAUST_HALF_WIDTH * self.eccentric, [math.pi * k / 16 for k in range(17)]
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
        (inner, outer), laps = self.port_edges, (self.distribution.inside_lap * self.scale, self.distribution.outside_lap * self.scale)
        inner_lap, outer_lap = laps[::-1] if self._has_piston_valve else laps
        return inner - inner_lap, outer + outer_lap

    def _slide_valve_shapes(self) -> Iterator[DrawnShape]:
        """Yield the D-slide valve on its face, and its cavity over bridge and exhaust port, from its middle."""
        r, face, (inner, outer) = self.eccentric, self.face, self._valve_edges
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

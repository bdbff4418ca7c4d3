"""Section of a steam chest: the ports in their face, and over them a slide valve, or a piston valve with inside admission.

The face is the line y = `face`, from the middle of the valve's travel; the crank end lies at +x. Laps and travel are true to the scale of
the valve. Ports, bridges and exhaust are as wide as the drawing needs.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

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

    def valve_shapes(self, displacement: float, rod_end: float) -> Iterator[DrawnShape]:
        """Yield the valve at a displacement away from the shaft (m of the valve), and its rod to `rod_end`."""
        x, stem, half = -displacement * self.scale, self.stem_height, _STEM_HALF_THICKNESS * self.eccentric
        rod_start = x - self._valve_edges[1] if self._has_piston_valve else x
        rod = make_rectangle("piston rod", rod_start, rod_end, stem - half, stem + half)
        yield from self._piston_valve_shapes(x, rod) if self._has_piston_valve else self._slide_valve_shapes(x, rod)

    @property
    def _valve_edges(self) -> Vec2:
        """Distances of the inner and outer edge of either half of the valve from its middle."""
        (inner, outer), laps = self.port_edges, (self.distribution.inside_lap * self.scale, self.distribution.outside_lap * self.scale)
        inner_lap, outer_lap = laps[::-1] if self._has_piston_valve else laps
        return inner - inner_lap, outer + outer_lap

    def _slide_valve_shapes(self, x: float, rod: Polygon) -> Iterator[DrawnShape]:
        """Yield the spindle, the D-slide valve on its face, and its cavity over bridge and exhaust port."""
        r, face, (inner, outer) = self.eccentric, self.face, self._valve_edges
        top = face + _VALVE_HEIGHT * r
        body = mirror_outline(((outer, face), (outer, face + 0.30 * r), (inner + 0.1 * r, top)))
        cavity = mirror_outline(((inner, face), (inner, face + 0.2 * r), (inner - 0.25 * r, top - _VALVE_BACK_THICKNESS * r)))
        yield rod
        for role, outline in (("valve", body), ("valve cavity", cavity)):
            yield Polygon(role, tuple((x - dx, y) for dx, y in outline))

    def _piston_valve_shapes(self, x: float, rod: Polygon) -> Iterator[DrawnShape]:
        """Yield the live steam between the two heads, the spindle, and the heads, whose inner edges admit the steam."""
        bottom, roof, (inner, outer) = self.face, self.face + self.height, self._valve_edges
        yield make_rectangle("live steam", x - inner, x + inner, bottom, roof)
        yield rod
        yield from (make_rectangle("valve", x + left, x + right, bottom, roof) for left, right in both_sides(inner, outer))


def chest_half_length(distribution: SteamDistribution) -> float:
    """Return the half length of the chest in eccentricities: ports, lap and valve travel."""
    ports = _EXHAUST_HALF_WIDTH + _BRIDGE_WIDTH + _PORT_WIDTH
    lap = distribution.outside_lap if distribution.outward_sign > 0 else distribution.inside_lap
    return ports + max(lap, 0.0) / distribution.eccentric + _END_CLEARANCE

"""The whole engine at a small scale: flywheel with crank, connecting rod or yoke, crosshead, and cylinder."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, Polygon, Vec2

# In crank radii of the view.
WHEEL_RADIUS, _RIM_WIDTH, _HUB_RADIUS = 1.9, 0.28, 0.36
MAX_DRAWN_ROD, _PISTON_ROD, _CYLINDER_LENGTH, _CYLINDER_HALF_HEIGHT = 4.2, 1.35, 2.5, 0.5
_N_SPOKES = 6


@dataclass(frozen=True, kw_only=True)
class EngineView:
    """Picture of the engine; the shaft is at the left, and the crank turns anticlockwise from its left dead centre.

    Attributes
    ----------
    crank
        Crank radius of the engine, m.
    rod
        Length of its connecting rod, m; infinite for a yoke.
    left, right
        Edges of the picture, m.
    base
        Lower edge of the picture, m.
    length
        Length of the picture in crank radii if longer than needed: the piston rod is that much longer.
    """

    crank: float
    rod: float
    left: float
    right: float
    base: float
    length: float = 0.0

    @cached_property
    def _has_yoke(self) -> bool:
        return math.isinf(self.rod)

    @cached_property
    def _drawn_rod(self) -> float:
        """Length of the connecting rod, or of the rod of the yoke, in crank radii."""
        return 1.2 if self._has_yoke else min(self.rod / self.crank, MAX_DRAWN_ROD)

    @cached_property
    def needed_length(self) -> float:
        """Length of the picture in crank radii with the shortest piston rod."""
        return WHEEL_RADIUS + self._drawn_rod + 1.0 + _PISTON_ROD + _CYLINDER_LENGTH

    @cached_property
    def scale(self) -> float:
        """Crank radius of the picture, m."""
        return (self.right - self.left) / max(self.needed_length, self.length)

    @property
    def height(self) -> float:
        """Height of the picture, m."""
        return 2 * WHEEL_RADIUS * self.scale

    @cached_property
    def shaft(self) -> Vec2:
        """Middle of the shaft in the picture, m."""
        return self.left + WHEEL_RADIUS * self.scale, self.base + WHEEL_RADIUS * self.scale

    def _to_picture(self, x: float, y: float) -> Vec2:
        """Return the place of a point in crank radii from the shaft."""
        return self.shaft[0] + x * self.scale, self.shaft[1] + y * self.scale

    @property
    def cylinder_box(self) -> BoundingBox:
        """Left, right, lower and upper edge of the cylinder in the picture, m."""
        near, far = self._cylinder_ends
        (left, low), (right, high) = self._to_picture(near, -_CYLINDER_HALF_HEIGHT), self._to_picture(far, _CYLINDER_HALF_HEIGHT)
        return left, right, low, high

    @cached_property
    def _cylinder_ends(self) -> Vec2:
        """Ends of the cylinder, in crank radii from the shaft."""
        start = max(self.needed_length, self.length) - WHEEL_RADIUS - _CYLINDER_LENGTH
        return start, start + _CYLINDER_LENGTH

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield centre line, bearing, guides and cylinder."""
        yield Lines("axis", ((self._to_picture(-WHEEL_RADIUS, 0.0), self._to_picture(self._cylinder_ends[1], 0.0)),))
        yield make_rectangle("casting", *self.cylinder_box)
        if not self._has_yoke:
            ends = self._drawn_rod - 1.35, self._drawn_rod + 1.35
            yield Lines("guide", tuple(tuple(self._to_picture(x, y) for x in ends) for y in (-0.33, 0.33)))

    def moving_shapes(self, crank_angle: float) -> Iterator[DrawnShape]:
        """Yield the parts at a crank angle, rad."""
        yield from self.wheel_shapes(crank_angle)
        yield from self.crank_shapes(crank_angle)

    def crank_shapes(self, crank_angle: float) -> Iterator[DrawnShape]:
        """Yield crank, connecting rod and crosshead at a crank angle, rad."""
        s, shaft = self.scale, self.shaft
        pin_x, pin_y = -math.cos(crank_angle), -math.sin(crank_angle)
        pin = self._to_picture(pin_x, pin_y)
        yield make_bar("crank web", shaft, pin, 0.42 * s)
        yield Circle("hub", *shaft, 0.16 * s)
        if self._has_yoke:
            crosshead_x = pin_x + self._drawn_rod
            yield make_bar("rod", self._to_picture(pin_x, -1.15), self._to_picture(pin_x, 1.15), 0.34 * s)
            yield make_bar("slot", self._to_picture(pin_x, -1.05), self._to_picture(pin_x, 1.05), 0.2 * s)
            yield Lines("small rod", ((self._to_picture(pin_x + 0.17, 0.0), self._to_picture(self._cylinder_ends[0], 0.0)),))
        else:
            crosshead_x = pin_x + math.sqrt(self._drawn_rod**2 - pin_y**2)
            crosshead = self._to_picture(crosshead_x, 0.0)
            yield Lines("small rod", ((crosshead, self._to_picture(self._cylinder_ends[0], 0.0)),))
            yield make_bar("rod", pin, crosshead, 0.16 * s)
            yield self._block(crosshead_x)
        yield Circle("pivot", *pin, 0.12 * s)

    def _block(self, x: float) -> Polygon:
        (left, low), (right, high) = self._to_picture(x - 0.25, -0.3), self._to_picture(x + 0.25, 0.3)
        return make_rectangle("block", left, right, low, high)

    def wheel_shapes(self, crank_angle: float) -> Iterator[DrawnShape]:
        """Yield rim, spokes and hub at a crank angle, rad; the spoke opposite to the crank is marked."""
        s, shaft = self.scale, self.shaft
        yield Circle("wheel", *shaft, WHEEL_RADIUS * s)
        yield Circle("wheel web", *shaft, (WHEEL_RADIUS - _RIM_WIDTH) * s)
        spokes = [self._spoke(crank_angle + math.tau * k / _N_SPOKES) for k in range(_N_SPOKES)]
        yield Lines("spoke", tuple(spokes[1:]))
        yield Lines("marked spoke", (spokes[0],))
        yield Circle("hub", *shaft, _HUB_RADIUS * s)
        yield Lines("rim", (arc_points(shaft, 0.0, math.tau, WHEEL_RADIUS * s, 72),))

    def _spoke(self, angle: float) -> tuple[Vec2, Vec2]:
        direction = math.cos(angle), math.sin(angle)
        start, end = _HUB_RADIUS, WHEEL_RADIUS - _RIM_WIDTH
        return self._to_picture(start * direction[0], start * direction[1]), self._to_picture(end * direction[0], end * direction[1])

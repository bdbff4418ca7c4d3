"""The whole engine at a small scale: flywheel with crank, connecting rod or yoke, crosshead, and cylinder."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_shifted, axes_turned, bar_between, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.points import arc_points, axes_to_plane
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, Vec2

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

    def moving_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield the parts; `angle_at` is the crank angle at a moment, rad."""
        yield from self.wheel_parts(angle_at)
        yield from self.crank_parts(angle_at)

    def crank_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield crank, connecting rod and crosshead; `angle_at` is the crank angle at a moment, rad."""
        s, shaft, near_end = self.scale, self.shaft, self._to_picture(self._cylinder_ends[0], 0.0)
        crank_axes = axes_turned(shaft, angle_at)
        yield Attached(frame=crank_axes, shapes=(make_bar("crank web", (0.0, 0.0), (-s, 0.0), 0.42 * s),))
        yield fixed([Circle("hub", *shaft, 0.16 * s)])
        if self._has_yoke:
            yoke_axes = axes_shifted(lambda moment: self._to_picture(-math.cos(angle_at(moment)), 0.0))
            yoke = make_bar("rod", (0.0, -1.15 * s), (0.0, 1.15 * s), 0.34 * s)
            yield Attached(frame=yoke_axes, shapes=(yoke, make_bar("slot", (0.0, -1.05 * s), (0.0, 1.05 * s), 0.2 * s)))
            yield Flexible(shapes_at=lambda moment: [Lines("small rod", ((axes_to_plane(yoke_axes(moment), 0.17 * s, 0.0), near_end),))])
        else:
            crosshead_at = partial(self._crosshead, angle_at)
            yield Flexible(shapes_at=lambda moment: [Lines("small rod", ((crosshead_at(moment), near_end),))])
            pin_at = partial(self._pin, angle_at)
            yield bar_between("rod", lambda moment: (pin_at(moment), crosshead_at(moment)), 0.16 * s, length=self._drawn_rod * s)
            block = make_rectangle("block", -0.25 * s, 0.25 * s, -0.3 * s, 0.3 * s)
            yield Attached(frame=axes_shifted(crosshead_at), shapes=(block,))
        yield Attached(frame=crank_axes, shapes=(Circle("pivot", -s, 0.0, 0.12 * s),))

    def _pin(self, angle_at: Callable[[Any], float], moment: Any) -> Vec2:
        """Return the place of the crank pin."""
        angle = angle_at(moment)
        return self._to_picture(-math.cos(angle), -math.sin(angle))

    def _crosshead(self, angle_at: Callable[[Any], float], moment: Any) -> Vec2:
        """Return the place of the crosshead."""
        angle = angle_at(moment)
        return self._to_picture(-math.cos(angle) + math.sqrt(self._drawn_rod**2 - math.sin(angle) ** 2), 0.0)

    def wheel_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield rim, spokes and hub; `angle_at` is the crank angle at a moment, rad. The spoke opposite to the crank is marked."""
        s, shaft = self.scale, self.shaft
        yield fixed([Circle("wheel", *shaft, WHEEL_RADIUS * s), Circle("wheel web", *shaft, (WHEEL_RADIUS - _RIM_WIDTH) * s)])
        spokes = [self._spoke(math.tau * k / _N_SPOKES) for k in range(_N_SPOKES)]
        shapes = (Lines("spoke", tuple(spokes[1:])), Lines("marked spoke", (spokes[0],)))
        yield Attached(frame=axes_turned(shaft, angle_at), shapes=shapes)
        rim = Lines("rim", (arc_points(shaft, 0.0, math.tau, WHEEL_RADIUS * s, 72),))
        yield fixed([Circle("hub", *shaft, _HUB_RADIUS * s), rim])

    def _spoke(self, angle: float) -> tuple[Vec2, Vec2]:
        """Return the ends of a spoke at an angle (rad) from the shaft."""
        direction, start, end = (math.cos(angle), math.sin(angle)), _HUB_RADIUS * self.scale, (WHEEL_RADIUS - _RIM_WIDTH) * self.scale
        return (start * direction[0], start * direction[1]), (end * direction[0], end * direction[1])

"""Drawing of a slide valve: the engine at a small scale, the cylinder in section, and Zeuner's diagram below the stroke.

The crank circle is below the cylinder and at its scale. The piston position follows from the crank pin by an arc of the
connecting-rod length, as in Marks' construction. The shaft is at the right. The view of the whole engine shows crank and eccentric,
rods, crosshead, and the cylinder at the left.
"""

import math
from collections.abc import Iterator

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.slide_valve import cylinder, zeuner_dial
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearPosition, ValveGearProportions
from governor_mechanism.types import FloatArray

_ENGINE_BASE = cylinder.CHEST_TOP + 0.10
"""Height of the base of the engine view, in crank radii: a small gap above the section."""
_STRIP_WIDTH = 2.96
"""Width of the strip, in crank radii."""
_PISTON_ROD_LENGTH, _CYLINDER_LENGTH, _BORE_HALF_HEIGHT = 2.5, 2.5, 0.62
"""Length of the piston rod, length of the cylinder and half height of the bore, in crank radii of the engine view."""
_VALVE_LINE_HEIGHT = 0.90
"""Height of the valve line above the cylinder axis, in crank radii of the engine view; only so that both are visible."""


class SlideValveDrawing(ValveGearProportions):
    """Drawing of an engine with a slide valve."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel")

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield castings, the divided circle, valve circles, and the curves of the run."""
        angles, valve_positions = (self.poses[:, self.part.mechanism.body_index(name), k] for name, k in ((CRANK, 2), (VALVE, 0)))
        yield from _engine_background_shapes(self)
        yield from cylinder.cylinder_background_shapes(self)
        yield from zeuner_dial.dial_background_shapes(self, angles, valve_positions - self.centre)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield all parts that the crank moves."""
        position = self.position(pose)
        yield from _engine_moving_shapes(self, position)
        yield from cylinder.cylinder_moving_shapes(self, position)
        yield from zeuner_dial.dial_moving_shapes(self, position, cylinder.CYLINDER_BASE * self.crank)


class _EngineToPicture:
    """Map from engine coordinates (m from the shaft, away from it and up) to picture coordinates (m).

    `scale` is in metres of the picture per metre.
    """

    def __init__(self, valve_gear: ValveGearProportions) -> None:
        u = valve_gear.crank
        self.cylinder_near_end = valve_gear.drawn_rod + (_PISTON_ROD_LENGTH - 1.0) * u
        self.scale = _STRIP_WIDTH / (1.25 + valve_gear.drawn_rod / u + 1.0 + _PISTON_ROD_LENGTH + _CYLINDER_LENGTH - 1.0)
        self.x = 0.5 * _STRIP_WIDTH * u - 1.25 * u * self.scale
        self.y = _ENGINE_BASE * u + 1.2 * u * self.scale

    def __call__(self, x: float, y: float) -> Vec2:
        return self.x - x * self.scale, self.y + y * self.scale

    def block(self, x: float, y: float, half_width: float, half_height: float) -> Polygon:
        """Return a sliding block with its centre at (x, y)."""
        (left, bottom), (right, top) = self(x + half_width, y - half_height), self(x - half_width, y + half_height)
        return make_rectangle("block", left, right, bottom, top)


def _engine_background_shapes(valve_gear: ValveGearProportions) -> Iterator[DrawnShape]:
    """Yield cylinder and chest, guides and centre line."""
    u, to_picture = valve_gear.crank, _EngineToPicture(valve_gear)
    cylinder_far_end = to_picture.cylinder_near_end + _CYLINDER_LENGTH * u
    left, low = to_picture(cylinder_far_end, -_BORE_HALF_HEIGHT * u)
    right, high = to_picture(to_picture.cylinder_near_end, _BORE_HALF_HEIGHT * u)
    chest_inset = 0.15 * (right - left)
    chest_top = to_picture(0.0, (_VALVE_LINE_HEIGHT + 0.30) * u)[1]
    yield Lines("axis", ((to_picture(-1.2 * u, 0.0), to_picture(cylinder_far_end + 0.15 * u, 0.0)),))
    yield make_rectangle("casting", left, right, low, high)
    yield make_rectangle("casting", left + chest_inset, right - chest_inset, high, chest_top)
    guide_ends = valve_gear.drawn_rod - 1.25 * u, valve_gear.drawn_rod + 1.25 * u
    yield Lines("guide", tuple(tuple(to_picture(x, y * u) for x in guide_ends) for y in (-0.32, 0.32)))
    yield Lines("guide", (tuple(to_picture(*point) for point in arc_points((0.0, 0.0), 0.0, math.tau, u, 48)),))


def _engine_moving_shapes(valve_gear: ValveGearProportions, position: ValveGearPosition) -> Iterator[DrawnShape]:
    """Yield crank, eccentric, both rods, crosshead, and the rods of piston and valve."""
    u, to_picture = valve_gear.crank, _EngineToPicture(valve_gear)
    scale, shaft, valve_line_height = to_picture.scale, to_picture(0.0, 0.0), _VALVE_LINE_HEIGHT * u
    # At 0 the crank points away from the cylinder.
    pin = to_picture(-u * math.cos(position.crank_angle), u * math.sin(position.crank_angle))
    theta = position.crank_angle + valve_gear.advance
    eccentric = to_picture(valve_gear.eccentric * math.sin(theta), valve_gear.eccentric * math.cos(theta))
    crosshead_x, valve_x = valve_gear.drawn_rod - position.piston_position, valve_gear.drawn_eccentric_rod + position.valve_displacement
    crosshead, valve = to_picture(crosshead_x, 0.0), to_picture(valve_x, valve_line_height)
    yield Lines("small rod", ((crosshead, to_picture(to_picture.cylinder_near_end, 0.0)),))
    yield Lines("eccentric rod", ((valve, to_picture(to_picture.cylinder_near_end, valve_line_height)),))
    yield Circle("crank web", *shaft, 0.30 * u * scale)
    yield make_bar("crank web", shaft, pin, 0.30 * u * scale)
    yield Circle("eccentric", *eccentric, 1.9 * valve_gear.eccentric * scale)
    yield Lines("eccentric rod", ((eccentric, valve),))
    yield Lines("small rod", ((pin, crosshead),))
    yield to_picture.block(crosshead_x, 0.0, 0.24 * u, 0.30 * u)
    yield to_picture.block(valve_x, valve_line_height, 0.10 * u, 0.13 * u)
    yield Circle("pivot", *shaft, 0.10 * u * scale)
    yield Circle("pivot", *pin, 0.09 * u * scale)

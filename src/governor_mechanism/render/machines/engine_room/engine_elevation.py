"""Engine of the room: a horizontal engine with its cylinder in section, or a flywheel alone. Lengths in pixels.

A machine whose cylinder stands below its shaft is turned on its side, with the shaft at the left.
"""

import math
from collections.abc import Callable, Iterator
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_shifted
from governor_mechanism.render.geometry.outlines import make_rectangle
from governor_mechanism.render.geometry.primitives import DrawnShape, Polygon, Vec2
from governor_mechanism.render.machines.engine_room import proportions as room
from governor_mechanism.render.machines.flywheel_engine.cylinder import GAS_ROLES
from governor_mechanism.render.machines.flywheel_engine.drawing import FlywheelEngineDrawing, relative_travel
from governor_mechanism.render.machines.flywheel_engine.engine_view import MAX_DRAWN_ROD, EngineView

# In drawn crank radii.
_WALL, _PISTON_HALF_LENGTH, _FIRST_PISTON_POSITION, _PISTON_ROD = 0.08, 0.15, 0.25, 0.035
_GUIDE_DISTANCE = 0.33
_POSTS = room.GOVERNOR_AXIS - 60.0, room.GOVERNOR_AXIS + 48.0
"""Left edges of the posts under the guides of the crosshead, or under the rod of a yoke, in pixels."""
_LENGTH = EngineView(crank=1.0, rod=MAX_DRAWN_ROD, left=0.0, right=1.0, base=0.0).needed_length


def make_view(crank: float, rod: float) -> EngineView:
    """Return the view of an engine in the room; lengths of crank and connecting rod in m."""
    right = room.ENGINE_LEFT + _LENGTH * room.CRANK_RADIUS
    return EngineView(crank=crank, rod=rod, left=room.ENGINE_LEFT, right=right, base=room.FLOOR, length=_LENGTH)


class EngineElevation:
    """Horizontal engine with its cylinder in section; `scaled` is what of it is drawn to scale."""

    scaled = "stroke"

    def __init__(self, drawing: FlywheelEngineDrawing) -> None:
        self._drawing = drawing
        self.view = make_view(0.5 * drawing.stroke, drawing.connecting_rod)
        left, right, low, high = self.view.cylinder_box
        wall = _WALL * self.view.scale
        self._bore = left + wall, right - wall, low + wall, high - wall

    @property
    def pixels_per_metre(self) -> float:
        """Scale of crank and stroke."""
        return 2 * room.CRANK_RADIUS / self._drawing.stroke

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield bed, guides and cylinder."""
        left, right, low, _ = self.view.cylinder_box
        shaft_y = self.view.shaft[1]
        yield make_rectangle("frame plate", self.view.shaft[0] + 30.0, right + 6.0, room.FLOOR, room.FLOOR + 16.0)
        yield make_rectangle("frame plate", left + 4.0, right - 4.0, room.FLOOR + 16.0, low)
        post_top = shaft_y - (3.0 if math.isinf(self.view.rod) else _GUIDE_DISTANCE * self.view.scale)
        for x in _POSTS:
            yield make_rectangle("frame plate", x, x + 12.0, room.FLOOR + 16.0, post_top)
        yield from self.view.background_shapes()
        yield make_rectangle("bore", *self._bore)

    def wheel_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield the wheel; `angle_at` is the drawn crank angle at a moment, rad."""
        yield from self.view.wheel_parts(angle_at)

    def crank_parts(self, angle_at: Callable[[Any], float], time_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield gas, piston, rods and crank; at a moment, the drawn crank angle (rad) and the time (s) of the gas."""
        half, (_, _, low, high) = _PISTON_HALF_LENGTH * self.view.scale, self._bore

        def piston_at(moment: Any) -> Vec2:
            return self._piston_at(angle_at(moment)), 0.0

        yield Flexible(shapes_at=lambda moment: self._gas_shapes(angle_at(moment), time_at(moment)))
        yield Attached(frame=axes_shifted(piston_at), shapes=(make_rectangle("piston", -half, half, low, high),))
        yield from self.view.crank_parts(angle_at)

    def _travel(self, crank_angle: float) -> float:
        """Return the travel of the piston relative to its stroke."""
        return relative_travel(crank_angle, self.view.crank / self.view.rod)

    def _piston_at(self, crank_angle: float) -> float:
        return self.piston_position(self._travel(crank_angle))

    def _gas_shapes(self, crank_angle: float, time: float) -> Iterator[DrawnShape]:
        """Yield the gas at a drawn crank angle (rad) and a time (s), and the piston rod."""
        (left, right, low, high), travel, u = self._bore, self._travel(crank_angle), self.view.scale
        x, half = self.piston_position(travel), _PISTON_HALF_LENGTH * u
        is_return = bool(math.floor(crank_angle / math.pi) % 2)
        for cylinder in self._drawing.expansion_cylinders(time):
            pressures = cylinder.shaft_side_pressure(travel, is_return), cylinder.far_side_pressure(travel, is_return)
            for (start, end), pressure in zip(((left, x - half), (x + half, right)), pressures, strict=True):
                outline = make_rectangle("bore", start, end, low, high).points
                yield from (Polygon(role, outline if role == cylinder.gas_role(pressure) else ()) for role in GAS_ROLES)
        axis, rod = self.view.shaft[1], _PISTON_ROD * u
        yield make_rectangle("piston rod", self.view.cylinder_box[0], x, axis - rod, axis + rod)

    def piston_position(self, relative_travel: float) -> float:
        """Return the drawn position (x) of the piston at a travel relative to the stroke."""
        return self.view.cylinder_box[0] + (_FIRST_PISTON_POSITION + 2 * relative_travel) * self.view.scale


class WheelElevation:
    """Flywheel of a scene that describes no more of its engine; the marked spoke is at the crank angle."""

    scaled = "wheel"

    def __init__(self, radius: float) -> None:
        self._radius = radius
        self.view = make_view(1.0, math.inf)

    @property
    def pixels_per_metre(self) -> float:
        """Scale of the wheel, if it is a rim."""
        return 0.5 * self.view.height / self._radius

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the bed."""
        yield make_rectangle("frame plate", self.view.shaft[0] + 30.0, room.CYLINDER_END + 6.0, room.FLOOR, room.FLOOR + 16.0)

    def wheel_parts(self, angle_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield the wheel; `angle_at` is the drawn crank angle at a moment, rad."""
        yield from self.view.wheel_parts(angle_at)

    def crank_parts(self, angle_at: Callable[[Any], float], time_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield nothing: the engine has no other parts."""
        yield from ()

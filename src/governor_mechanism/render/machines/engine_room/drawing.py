"""Elevation of an engine room: engine, load, belt drive, governor, bell crank, and throttle or cut-off gear, as in a run."""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.geometry.attached import (
    Attached,
    DrawnPart,
    Flexible,
    Moment,
    Placement,
    at_own_moments,
    axes_shifted,
    fixed,
    shapes_of,
)
from governor_mechanism.render.geometry.outlines import make_rectangle, make_wall, select_extreme_rows
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Polygon, TextShape, Vec2, bounding_box, enclose_boxes
from governor_mechanism.render.geometry.recording import enclose_recorded, record_parts
from governor_mechanism.render.machines.engine_room import arrangement as room
from governor_mechanism.render.machines.engine_room.arrangement import CUT_OFF, THROTTLE, EngineRoomParts, engine_torque, load_torque
from governor_mechanism.render.machines.engine_room.controls import (
    Brake,
    Control,
    ScaleRange,
    Slide,
    Throttle,
    bevel_wheel_parts,
    make_governor_belt,
    pulley_part,
)
from governor_mechanism.render.machines.flywheel_engine import GAS_ROLES, MAX_DRAWN_ROD, EngineView, FlywheelEngineDrawing, relative_travel
from governor_mechanism.render.machines.governor_parts import GovernorDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.types import FloatArray

# In drawn crank radii.
_WALL = 0.08
_PISTON_HALF_LENGTH = 0.15
_FIRST_PISTON_POSITION = 0.25
_PISTON_ROD = 0.035
_GUIDE_DISTANCE = 0.33
_POSTS = room.GOVERNOR_AXIS - 60.0, room.GOVERNOR_AXIS + 48.0
"""Left edges of the posts under the guides of the crosshead, or under the rod of a yoke, in pixels."""
_LENGTH = EngineView(crank=1.0, rod=MAX_DRAWN_ROD, left=0.0, right=1.0, base=0.0).needed_length


def make_view(crank: float, rod: float) -> EngineView:
    """Return the view of an engine in the room; lengths of crank and connecting rod in m."""
    right = room.ENGINE_LEFT + _LENGTH * room.CRANK_RADIUS
    return EngineView(crank=crank, rod=rod, left=room.ENGINE_LEFT, right=right, base=room.FLOOR, length=_LENGTH)


class HorizontalEngine(ABC):
    """Horizontal engine with its cylinder in section; `scaled` is what of it is drawn to scale."""

    scaled: ClassVar[str]

    def __init__(self, view: EngineView) -> None:
        self.view = view
        left, right, low, high = view.cylinder_box
        wall = _WALL * view.scale
        self._bore = left + wall, right - wall, low + wall, high - wall

    @property
    @abstractmethod
    def pixels_per_metre(self) -> float:
        """Scale of what is drawn to scale."""

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
            return self.piston_position(self._travel(angle_at(moment))), 0.0

        yield Flexible(shapes_at=lambda moment: [*self._gas_shapes(angle_at(moment), time_at(moment)), self._piston_rod(angle_at(moment))])
        yield Attached(frame=axes_shifted(piston_at), shapes=(make_rectangle("piston", -half, half, low, high),))
        yield from self.view.crank_parts(angle_at)

    def piston_position(self, relative_travel: float) -> float:
        """Return the drawn position (x) of the piston at a travel relative to the stroke."""
        return self.view.cylinder_box[0] + (_FIRST_PISTON_POSITION + 2 * relative_travel) * self.view.scale

    def _travel(self, crank_angle: float) -> float:
        """Return the travel of the piston relative to its stroke."""
        return relative_travel(crank_angle, self.view.crank / self.view.rod)

    def _piston_rod(self, crank_angle: float) -> DrawnShape:
        """Return the piston rod at a drawn crank angle (rad)."""
        axis, rod = self.view.shaft[1], _PISTON_ROD * self.view.scale
        end = self.piston_position(self._travel(crank_angle))
        return make_rectangle("piston rod", self.view.cylinder_box[0], end, axis - rod, axis + rod)

    @abstractmethod
    def _gas_shapes(self, crank_angle: float, time: float) -> Iterator[DrawnShape]:
        """Yield the gas at a drawn crank angle (rad) and a time (s)."""


class EngineElevation(HorizontalEngine):
    """Engine of a scene with its gas."""

    scaled = "stroke"

    def __init__(self, drawing: FlywheelEngineDrawing) -> None:
        super().__init__(make_view(0.5 * drawing.stroke, drawing.connecting_rod))
        self._drawing = drawing

    @property
    def pixels_per_metre(self) -> float:
        """Scale of crank and stroke."""
        return 2 * room.CRANK_RADIUS / self._drawing.stroke

    def _gas_shapes(self, crank_angle: float, time: float) -> Iterator[DrawnShape]:
        """Yield the gas on both sides of the piston, in the colours of its pressure."""
        (left, right, low, high), travel = self._bore, self._travel(crank_angle)
        x, half = self.piston_position(travel), _PISTON_HALF_LENGTH * self.view.scale
        is_return = bool(math.floor(crank_angle / math.pi) % 2)
        for cylinder in self._drawing.expansion_cylinders(time):
            pressures = cylinder.shaft_side_pressure(travel, is_return), cylinder.far_side_pressure(travel, is_return)
            for (start, end), pressure in zip(((left, x - half), (x + half, right)), pressures, strict=True):
                outline = make_rectangle("bore", start, end, low, high).points
                yield from (Polygon(role, outline if role == cylinder.gas_role(pressure) else ()) for role in GAS_ROLES)


_DRAWN_ROD = 4.0
"""Drawn length of a connecting rod of which the scene says nothing, in crank radii."""


class WheelElevation(HorizontalEngine):
    """Flywheel of a scene that describes no more of its engine than its torque: with a cylinder and rods that show what turns it."""

    scaled = "wheel"

    def __init__(self, radius: float) -> None:
        super().__init__(make_view(1.0, _DRAWN_ROD))
        self._radius = radius

    @property
    def pixels_per_metre(self) -> float:
        """Scale of the wheel, if it is a rim."""
        return 0.5 * self.view.height / self._radius

    def _gas_shapes(self, crank_angle: float, time: float) -> Iterator[DrawnShape]:
        """Yield the bore with nothing in it: the scene knows no pressure."""
        yield make_rectangle("bore", *self._bore)


_LEFT_OUT = ("scale", "leader", "pointer", "axis")
"""Roles of a lift scale, which the plots replace, and of the line of the axis, which the stand below the spindle continues."""
_ROLES_OF_ROOM = ("throttle ", "gearing ")
"""Beginnings of the roles of what the governor drives and what drives it: the room shows both in their places."""
_FORK_HEIGHT_RATIO, _FORK_RADIUS_RATIO = 0.33, 0.9
"""Place of the fork on a sleeve: height over its base and radius, relative to its size."""


class GovernorElevation:
    """A governor that stands in the room with its spindle at the governor's axis."""

    def __init__(
        self,
        drawing: MachineDrawing,  # drawing of the governor
        control_reading: str,  # reading of the governor, by plain name, that moves the control
    ) -> None:
        self._drawing, self._control_reading = drawing, control_reading
        left, right, bottom, top = self._bounds
        half_width = max(-left, right, 1e-9)
        scale = min(room.GOVERNOR_HALF_WIDTH / half_width, (room.GOVERNOR_TOP - room.GOVERNOR_BASE) / (top - bottom))
        self.placement = Placement(
            origin=(room.GOVERNOR_AXIS, room.GOVERNOR_BASE - scale * bottom), x_axis=(scale, 0.0), y_axis=(0.0, scale)
        )

    @property
    def pixels_per_metre(self) -> float:
        """Scale of the governor."""
        return self.placement.scale

    @property
    def fork_x(self) -> float:
        """Position of the fork on the sleeve."""
        half_width = self._drawing.sleeve_size[0] if isinstance(self._drawing, GovernorDrawing) else 0.05 * self._length
        return room.GOVERNOR_AXIS + self.placement.scale * _FORK_RADIUS_RATIO * half_width

    def fork_heights(self, poses: FloatArray, readings: FloatArray) -> FloatArray:
        """Return the heights (n,) of the fork at poses (n, bodies, 3) and values (n,) of the reading that moves the control.

        On a governor without a drawing of its own, the fork rises with that reading.
        """
        drawing, placement = self._drawing, self.placement
        if isinstance(drawing, GovernorDrawing):
            heights: FloatArray = drawing.sleeve_height(poses) - (1.0 - _FORK_HEIGHT_RATIO) * drawing.sleeve_size[1]
            return placement.origin[1] + placement.scale * heights
        low, high = drawing.reading_range(self._control_reading)
        return np.asarray(room.GOVERNOR_BASE + 16.0 + 30.0 * (readings - low) / max(high - low, 1e-12))

    def fixed_parts(self) -> Iterator[DrawnPart]:
        """Yield the spindle in its bearings and what else does not move."""
        yield from self.placement.place_parts(_parts_of_room(self._drawing.fixed))

    def moving_parts(self, governor_at: Callable[[Any], Moment]) -> Iterator[DrawnPart]:
        """Yield the governor; `governor_at` is its own moment at a moment of the room."""
        yield from self.placement.place_parts(at_own_moments(part, governor_at) for part in _parts_of_room(self._drawing.moving))

    @cached_property
    def _bounds(self) -> BoundingBox:
        """Box (m) around the governor at all poses of the run."""
        drawing, poses = self._drawing, self._drawing.poses
        moments = [Moment(poses[k], float(drawing.run.times[k])) for k in select_extreme_rows(poses)]
        moving = enclose_recorded(record_parts([*_parts_of_room(drawing.moving)], moments))
        return enclose_boxes([bounding_box(_without_scale(drawing.static_shapes)), moving])

    @property
    def _length(self) -> float:
        return self._drawing.part.mechanism.length_scale


def _parts_of_room(parts: Iterable[DrawnPart]) -> Iterator[DrawnPart]:
    """Yield parts without what `_without_scale` leaves out."""
    for part in parts:
        if isinstance(part, Flexible):
            yield replace(part, shapes_at=_ShapesOfRoom(part))
        else:
            yield replace(part, shapes=tuple(_without_scale(part.shapes)))


@dataclass(frozen=True, eq=False)
class _ShapesOfRoom:
    """Shapes of a flexible part without what the room leaves out."""

    part: Flexible

    def __call__(self, moment: Any) -> list[DrawnShape]:
        """Return them at a moment."""
        return _without_scale(self.part.shapes_at(moment))


def _without_scale(shapes: Iterable[DrawnShape]) -> list[DrawnShape]:
    """Return the shapes without texts, axis and lift scale, throttle gear and spindle drive."""
    return [
        shape
        for shape in shapes
        if not isinstance(shape, TextShape) and shape.role not in _LEFT_OUT and not shape.role.startswith(_ROLES_OF_ROOM)
    ]


_ROTATION_SLOWING_LIMIT = math.radians(24)
"""Largest turn of the crank between frames that shows its sense of rotation: less than half the pitch of six spokes."""


@dataclass(frozen=True, kw_only=True)
class RoomState:
    """State of the room at one time."""

    time: float  # time, s
    # crank_angle, spindle_angle: drawn angles, rad
    crank_angle: float
    spindle_angle: float
    governor: Moment  # moment of the governor
    fork_height: float  # height of the fork of the bell crank, pixels
    control: float  # opening of the throttle, cut-off, or torque of the engine (N m)
    load: float  # torque of the load relative to its largest in the run


class EngineRoomDrawing:
    """Drawing of a governed engine over a run; lengths in pixels of a 480-pixel frame."""

    def __init__(
        self,
        run: Trajectory,
        governed: EngineRoomParts,  # its governed engine
        engine: MachineDrawing,  # drawing of the engine
        governor: MachineDrawing,  # drawing of the governor
    ) -> None:
        self.run, self.governed = run, governed
        self.engine = EngineElevation(engine) if isinstance(engine, FlywheelEngineDrawing) else WheelElevation(_wheel_radius(governed))
        self.governor = GovernorElevation(governor, governed.governor_reading.rpartition(".")[2])
        self._governor_poses = governor.poses
        self._belt = make_governor_belt(self.engine.view.shaft, governed.ratio)
        self._brake = Brake(self.engine.view.shaft)

    @cached_property
    def control_values(self) -> FloatArray:
        """Opening of the throttle, cut-off or torque (n,) at the reported times."""
        governed = self.governed
        if governed.opening_reading is None:
            return engine_torque(self.run, governed)[1]
        return self.run.readings[f"{governed.engine.name}.{governed.opening_reading}"]

    @cached_property
    def load_values(self) -> FloatArray:
        """Torque of the load (n,) at the reported times, N m."""
        return load_torque(self.run, self.governed)

    @property
    def has_load(self) -> bool:
        """Whether a load resists the shaft."""
        return float(self.load_values.max()) > 0.0

    @cached_property
    def fork_heights(self) -> FloatArray:
        """Height of the fork (n,) at the reported times, pixels."""
        return self.governor.fork_heights(self._governor_poses, self.run.readings[self.governed.governor_reading])

    @cached_property
    def control(self) -> Control:
        """What the governor moves, with its bell crank."""
        values = self.control_values
        heights = self.fork_heights
        fork_x = self.governor.fork_x
        if self.governed.controlled == THROTTLE:
            return Throttle(fork_x, heights, values)
        if self.governed.controlled == CUT_OFF:
            return Slide(fork_x, heights, values, ScaleRange(low=0.0, high=1.0, labels=("0", "1"), name="cut-off"))
        highest = max(float(values.max()), 1e-12)
        step = 0.5 * 10 ** math.floor(math.log10(highest))
        high = step * math.ceil(highest / step)
        return Slide(fork_x, heights, values, ScaleRange(low=0.0, high=high, labels=("0", f"{high:.4g}"), name="torque N m"))

    def fixed_parts(self) -> Iterator[DrawnPart]:
        """Yield all that does not move."""
        axis, shelf = room.GOVERNOR_AXIS, room.GOVERNOR_BASE - 6.0
        foot, head = 20.0, 13.0
        stand = Polygon("frame plate", ((axis - foot, room.FLOOR), (axis + foot, room.FLOOR), (axis + head, shelf), (axis - head, shelf)))
        yield fixed([make_wall((0.5 * room.WIDTH, room.FLOOR), math.pi / 2, 0.5 * room.WIDTH - 8.0, 7.0), stand])
        yield fixed(self.engine.background_shapes())
        yield fixed(self._brake.background_shapes() if self.has_load else ())
        yield fixed(self.control.background_shapes())
        yield fixed([make_rectangle("frame plate", axis - 22.0, self.control.crank.pivot[0] + 8.0, shelf, room.GOVERNOR_BASE)])
        yield fixed(self.control.crank.background_shapes())
        yield from self.governor.fixed_parts()

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield all that moves, back to front."""
        shaft = self.engine.view.shaft
        belt = self._belt
        break_time = self.governed.break_time
        yield from self.engine.wheel_parts(_crank_angle)
        if self.has_load:
            yield pulley_part(shaft, room.LOAD_PULLEY, _crank_angle)
            yield fixed(self._brake.belt_shapes())
        yield pulley_part(shaft, belt.first_radius, _crank_angle)
        yield Flexible(shapes_at=lambda state: belt.belt_shapes(break_time is not None and state.time >= break_time))
        yield from self.engine.crank_parts(_crank_angle, attrgetter("time"))
        sense = 1.0 if self.governed.ratio > 0 else -1.0
        yield from belt.second_pulley_parts(lambda state: sense * state.spindle_angle)
        yield from bevel_wheel_parts(room.LAYSHAFT[1] + room.MAX_PULLEY, attrgetter("spindle_angle"))
        if self.has_load:
            yield from self._brake.moving_parts(_crank_angle, attrgetter("load"))
        yield from self.control.moving_parts(attrgetter("fork_height"), attrgetter("control"))
        yield from self.governor.moving_parts(_governor_moment)

    @cached_property
    def fixed(self) -> tuple[DrawnPart, ...]:
        """All that does not move."""
        return tuple(self.fixed_parts())

    @cached_property
    def moving(self) -> tuple[DrawnPart, ...]:
        """All that moves."""
        return tuple(self.moving_parts())

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield all shapes that do not move."""
        yield from shapes_of(self.fixed, None)

    def moving_shapes(self, state: RoomState) -> Iterator[DrawnShape]:
        """Yield all shapes that move, back to front; every state gives the same number of shapes, of the same kinds and roles."""
        yield from shapes_of(self.moving, state)

    def states(self, times: FloatArray, governor_poses: FloatArray) -> Callable[[int], RoomState]:
        """Return the state of the room at frame k for frame times (f,) s and poses (f, bodies, 3) of the governor."""
        run = self.run
        governed = self.governed
        slowing = self.rotation_slowing(times)
        spindle = run.readings[f"{governed.governor.name}.spindle_angle"]
        controls = np.interp(times, run.times, self.control_values)
        forks = np.interp(times, run.times, self.fork_heights)
        loads = np.interp(times, run.times, self.load_values) / max(float(self.load_values.max()), 1e-12)
        cranks, spindles = (np.interp(times, run.times, angle) / slowing for angle in (run.readings[governed.crank_angle], spindle))

        def state_at(k: int) -> RoomState:
            return RoomState(
                time=float(times[k]),
                crank_angle=float(cranks[k]),
                spindle_angle=float(spindles[k]),
                governor=Moment(governor_poses[k], float(times[k])),
                fork_height=float(forks[k]),
                control=float(controls[k]),
                load=float(loads[k]),
            )

        return state_at

    def rotation_slowing(self, times: FloatArray) -> int:
        """Return the whole number by which all drawn rotations are slowed for frame times (f,) s, so that they do not seem to run back."""
        angles = np.interp(times, self.run.times, self.run.readings[self.governed.crank_angle])
        largest_turn = float(np.max(np.abs(np.diff(angles)), initial=0.0)) * max(1.0, abs(self.governed.ratio))
        return max(math.ceil(largest_turn / _ROTATION_SLOWING_LIMIT), 1)


_crank_angle = attrgetter("crank_angle")
_governor_moment = attrgetter("governor")


def _wheel_radius(governed: EngineRoomParts) -> float:
    """Return the radius (m) of a rim with mass and moment of inertia of the only body of an engine."""
    body = governed.engine.mechanism.bodies[0]
    xx, yy, _ = body.second_moments.in_plane
    return math.sqrt(max(xx + yy, 0.0) / body.mass) or governed.engine.mechanism.length_scale

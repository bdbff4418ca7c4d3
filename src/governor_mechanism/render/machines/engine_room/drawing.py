"""Elevation of an engine room: engine, load, belt drive, governor, bell crank, and throttle or cut-off gear, as in a run."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, Moment, fixed, shapes_of
from governor_mechanism.render.geometry.outlines import make_rectangle, make_wall
from governor_mechanism.render.geometry.primitives import DrawnShape, Polygon
from governor_mechanism.render.machines.engine_room import proportions as room
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
from governor_mechanism.render.machines.engine_room.elevations import EngineElevation, GovernorElevation, WheelElevation
from governor_mechanism.render.machines.flywheel_engine import FlywheelEngineDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.types import FloatArray

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
        values, heights, fork_x = self.control_values, self.fork_heights, self.governor.fork_x
        if self.governed.controlled == THROTTLE:
            return Throttle(fork_x, heights, values)
        if self.governed.controlled == CUT_OFF:
            return Slide(fork_x, heights, values, ScaleRange(low=0.0, high=1.0, labels=("0", "1"), name="cut-off"), has_pipe=True)
        high = max(float(values.max()), 1e-12)
        scale = ScaleRange(low=0.0, high=high, labels=("0", f"{high:.4g}"), name="N m")
        return Slide(fork_x, heights, values, scale, has_pipe=False)

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
        shaft, belt, break_time = self.engine.view.shaft, self._belt, self.governed.break_time
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
        run, governed, slowing = self.run, self.governed, self.rotation_slowing(times)
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

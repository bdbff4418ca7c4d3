"""What the drawing of a valve gear needs to know of valve, piston and crank, from the kinematics of the mechanism and from the run."""

from abc import ABC
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.joints import GROUND, Point, RotationalDriver, Slider
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import PointCoordinate, PointDistance
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.valve import Valve
from governor_mechanism.observables.valve_motion import ValveMotion, crank_driver_of, has_valve_events, valve_motion_of, valve_of
from governor_mechanism.render.geometry.attached import Moment, once_per_moment
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents
from governor_mechanism.render.machines.steam_distribution import ValveGearPosition, sense_of_rotation, steam_phase
from governor_mechanism.types import FloatArray

_STRAIGHTNESS_TOLERANCE = 1e-5
"""Largest distance of a point from its line, relative to its travel: a loose assembly leaves 1e-6, what is not straight shows far more."""


@dataclass(frozen=True, kw_only=True)
class StraightMotion:
    """A point that moves along a line, and the reading that measures it."""

    point: Point  # the point
    # start, start_value: a place on the line, m, and the reading there, m
    start: Vec2
    start_value: float
    direction: Vec2  # unit vector along the line, in which the reading grows

    def place_at(self, value: float) -> Vec2:
        """Return the place (m) of the point where the reading has a value (m)."""
        along = value - self.start_value
        return self.start[0] + along * self.direction[0], self.start[1] + along * self.direction[1]


def find_straight_motion(mechanism: Mechanism, name: str, values: FloatArray, poses: FloatArray) -> StraightMotion | None:
    """Return the line of a reading with values (n,) m at poses (n, bodies, 3); None if its point stands still, or leaves a line."""
    match mechanism.reading(name):
        case PointCoordinate(point=point):
            pass
        case PointDistance(first=first, second=second) if GROUND in (first.body, second.body):
            point = second if first.body == GROUND else first
        case _:
            return None
    path = point_path(mechanism, poses, point)
    low, high = int(np.argmin(values)), int(np.argmax(values))
    travel = float(values[high] - values[low])
    if not travel > 0.0:
        return None
    direction = (path[high] - path[low]) / travel
    deviation = path - path[low] - np.multiply.outer(values - values[low], direction)
    # A direction whose length is not 1 is that of a reading that measures only a component of the motion.
    if max(float(np.abs(deviation).max()) / travel, abs(float(np.hypot(*direction)) - 1.0)) > _STRAIGHTNESS_TOLERANCE:
        return None
    (x, y), (dx, dy) = path[low].tolist(), direction.tolist()
    return StraightMotion(point=point, start=(x, y), start_value=float(values[low]), direction=(dx, dy))


class ValveGearExtents(MechanismExtents, ABC):
    """Sizes (m) of the valve gear of a part; laps have a sign. See `SteamDistribution`."""

    @cached_property
    def valve(self) -> Valve:
        """The valve."""
        return valve_of(self.run.scene)

    @cached_property
    def crank(self) -> float:
        """Half the stroke of the piston."""
        return 0.5 * self._motion.stroke

    @cached_property
    def eccentric(self) -> float:
        """Largest displacement of the valve during the run."""
        return float(np.abs(self.displacements).max())

    @property
    def outside_lap(self) -> float:
        """Lap over the edges that admit steam, be they outer or inner ones."""
        return self.valve.steam_lap

    @property
    def inside_lap(self) -> float:
        """Lap over the edges of the exhaust."""
        return self.valve.exhaust_lap

    @property
    def outward_sign(self) -> float:
        """1 if a displacement away from the shaft admits steam to the crank end, -1 if it admits steam to the head end."""
        return self.valve.outward_sign

    @cached_property
    def valve_line(self) -> StraightMotion:
        """Line of the valve."""
        return self._find_line(self.valve.displacement)

    @cached_property
    def piston_line(self) -> StraightMotion:
        """Line of the piston."""
        return self._find_line(self.valve.piston_travel)

    @cached_property
    def piston_ends(self) -> tuple[float, float]:
        """Reading of the piston at the dead centres of the crank end and of the head end, m."""
        crank_end, head_end = self._motion.evaluate(np.array(self._motion.dead_centres)).readings[self.valve.piston_travel].tolist()
        return crank_end, head_end

    @property
    def centre(self) -> float:
        """Reading of the valve in the centre of its motion, m."""
        return self._motion.centre

    @cached_property
    def displacements(self) -> FloatArray:
        """Displacement of the valve from its centre, away from the shaft, at the reported times, m."""
        return evaluate_output_value(self.part.mechanism, self.valve.displacement, self.poses) - self.centre

    @cached_property
    def crank_angles(self) -> FloatArray:
        """Angle of the crank from the dead centre of the crank end at the reported times, rad, anticlockwise."""
        return self._crank_angle(self.poses)

    @property
    def crank_end_angle(self) -> float:
        """Direction of the crank at the dead centre of the crank end, rad: opposite to the line of the piston, for a crank on that line."""
        dx, dy = self.piston_line.direction
        return float(np.arctan2(-dy, -dx))

    @cached_property
    def replaced_guides(self) -> frozenset[str]:
        """Names of the sliders of valve and crosshead on the ground: cylinder and chest guide them."""
        guided = {self.valve_line.point.body, self.piston_line.point.body}
        sliders = (joint for joint in self.part.mechanism.joints if isinstance(joint, Slider))
        return frozenset(slider.name for slider in sliders if slider.first.body == GROUND and slider.second.body in guided)

    @once_per_moment
    def position_at(self, moment: Moment) -> ValveGearPosition:
        """Return the position of the valve gear at a moment."""
        return self.position(*moment)

    def phase_at(self, side: float, moment: Moment) -> str:
        """Return the phase of the steam at one end at a moment; `side` is 1 at the crank end, -1 at the head end."""
        return steam_phase(self, self.position_at(moment), side)

    def position(self, pose: FloatArray, time: float) -> ValveGearPosition:
        """Return the position of the valve gear at a pose (bodies, 3) and a time (s)."""
        mechanism, valve = self.part.mechanism, self.valve
        displacement, piston = (float(evaluate_output_value(mechanism, name, pose)) for name in (valve.displacement, valve.piston_travel))
        return ValveGearPosition(
            crank_angle=float(self._crank_angle(pose)),
            valve_displacement=displacement - self.centre,
            piston_position=0.5 * sum(self.piston_ends) - piston,
            sense=sense_of_rotation(self.run.times, self.crank_angles, time),
            head_end_angle=self._motion.dead_centres[1],
        )

    @cached_property
    def _motion(self) -> ValveMotion:
        return valve_motion_of(self.run.scene)

    @cached_property
    def _driver(self) -> RotationalDriver:
        return crank_driver_of(self.part.mechanism, self.valve)

    def _crank_angle(self, poses: FloatArray) -> FloatArray:
        """Return the angle of the crank from the dead centre of the crank end (...,) rad at poses (..., bodies, 3)."""
        own, bearer = (self.part.mechanism.body_index(point.body) for point in (self._driver.second, self._driver.first))
        angles: FloatArray = poses[..., own, 2] - (poses[..., bearer, 2] if bearer >= 0 else 0.0) - self._motion.crank_end_angle
        return angles

    def _find_line(self, reading: str) -> StraightMotion:
        values = evaluate_output_value(self.part.mechanism, reading, self.poses)
        line = find_straight_motion(self.part.mechanism, reading, values, self.poses)
        if line is None:
            raise MechanismError(f"the drawing of a valve gear needs a point that moves along a line; that of reading {reading!r} does not")
        return line


def may_be_valve_gear(part: Part) -> bool:
    """Return whether a part has a valve and a piston, and a driver of a crank."""
    valve, joints = part.mechanism.valve, part.mechanism.joints
    return valve is not None and bool(valve.piston_travel) and any(isinstance(joint, RotationalDriver) for joint in joints)


def is_valve_gear(run: Trajectory, part: Part) -> bool:
    """Return whether the run of a part can be drawn as that of a valve gear: its crank turns fully, and valve and piston move in lines."""
    if not (may_be_valve_gear(part) and has_valve_events(run.scene)) or part.mechanism.valve is None:
        return False
    valve, mechanism = part.mechanism.valve, part.mechanism
    lines = (find_straight_motion(mechanism, name, run.readings[name], run.poses) for name in valve.readings)
    if any(line is None for line in lines):
        return False
    try:
        valve_motion_of(run.scene)
    except MechanismError:  # as one that says that the crank cannot turn fully
        return False
    return True

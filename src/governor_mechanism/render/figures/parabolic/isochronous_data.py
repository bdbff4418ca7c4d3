"""Data of Zehnder's plate: the start point, its parabola and circles, and the speed deviations near it."""

import math
from typing import Any, NamedTuple

import numpy as np

from governor_mechanism.closed_form import parabolic as isochronous
from governor_mechanism.closed_form.parabolic import equilibrium_speed_change, parabola_speed_change
from governor_mechanism.closed_form.pendulum import dynamics as pendulum
from governor_mechanism.closed_form.pendulum.kinematics import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

MARKED_ANGLE_CHANGES = np.radians([-4.0, -2.0, -1.0, 1.0, 2.0, 4.0])
"""Changes of the arm angle (rad) with a marker."""

MAX_ANGLE_CHANGE = math.radians(8.0)
"""Largest shown change of the arm angle (rad), up and down."""

_START_ANGLE_RANGE = math.radians(10.0), math.radians(55.0)
"""Arm angles (rad) with a circle of curvature that fits the plate."""

_SPEED_STEP_RATIO = 0.085
"""Target step between the speeds of neighbouring parabolas, as a fraction of the middle speed."""


class SpeedDeviationCurve(NamedTuple):
    """Relative speed changes (n,) against changes of the arm angle (n,) (rad).

    `equilibrium_speed_changes` are those of the equilibrium speed, `parabola_speed_changes` those of the parabola through the ball,
    which Zehnder used.
    """

    angle_changes: FloatArray
    equilibrium_speed_changes: FloatArray
    parabola_speed_changes: FloatArray


class IsochronousPlateData:
    """Data of the plate of a scene, in SI and radians: x from the spindle axis, y up, both zero at the common vertex of all parabolas.

    The start point is the osculation point of crossed arms (`starts_at_osculation`), otherwise an equilibrium. `start_speed` is its
    equilibrium speed. `radius_of_curvature` and `centre_of_curvature` are those of the parabola of this speed there. `suspension` is the
    suspension point of the arm, `travel` the lowest and highest arm angle. `speeds` are seven speeds of the family, with `start_speed` in
    the middle.

    Raises MechanismError unless the governor is a rhombus with the balls at its joints, with gravity and centrifugal force.
    """

    def __init__(self, scene: Scene) -> None:
        if not has_isochronous_parabolas(scene):
            raise MechanismError(
                "isochronous parabolas need machine 'pendulum_governor' with gravity and centrifugal, balls at the joints of arms "
                f"and links, links as long as the arms, and lugs below the suspensions; the scene {scene.title!r} differs"
            )
        self.governor = PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)
        self.travel = next((limit.low, limit.high) for limit in scene.part.mechanism.limits if limit.reading == "arm_angle")
        self.start_angle = angle = _start_angle(self.governor, self.travel, scene)
        self.start_speed = float(pendulum.equilibrium_speed(self.governor, arm_angle=angle))
        self.starts_at_osculation = self.governor.offset < 0
        self.speeds = _speed_family(self.start_speed)
        parameter = self.double_parameter(self.start_speed)
        x = float(pendulum.ball_radius(self.governor, arm_angle=angle))
        y = float(isochronous.parabola_height(abscissa=x, double_parameter=parameter))
        self.radius_of_curvature = radius = float(isochronous.radius_of_curvature(abscissa=x, double_parameter=parameter))
        self.start_point: Vec2 = x, y
        self.suspension: Vec2 = self.governor.offset, y + self.governor.arm * math.cos(angle)
        self.centre_of_curvature: Vec2 = x - radius * math.sin(angle), y + radius * math.cos(angle)

    def double_parameter(self, speed: float) -> float:
        """Return the double parameter (m) of the parabola of one spindle speed (rad/s)."""
        ratio = self.governor.sleeve_mass / self.governor.ball_mass
        return float(isochronous.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=self.governor.gravity))

    def point_at_45_degrees(self, speed: float) -> Vec2:
        """Return the point (m) with x = 2 y, where the parabola of one spindle speed (rad/s) has a slope of 45 degrees."""
        parameter = self.double_parameter(speed)
        return parameter / 2, parameter / 4

    def speed_deviations(self, arm_ratio: float, angle_changes: FloatArray | None = None) -> SpeedDeviationCurve:
        """Return the speed deviations near the start point for an arm of `arm_ratio` radii of curvature.

        `angle_changes` (n,) are changes of the arm angle (rad), by default a grid within MAX_ANGLE_CHANGE. Changes that bring the arm to
        the vertical or the horizontal, or the ball close to the axis or the vertex, are dropped.
        """
        requested_changes = np.linspace(-MAX_ANGLE_CHANGE, MAX_ANGLE_CHANGE, 321) if angle_changes is None else angle_changes
        arm, angle = arm_ratio * self.radius_of_curvature, self.start_angle
        x, y = self.start_point
        angles = angle + requested_changes
        abscissa_ratio = 1 + arm / x * (np.sin(angles) - math.sin(angle))
        height_ratio = 1 + arm / y * (math.cos(angle) - np.cos(angles))
        min_angle = math.radians(0.5)
        valid = (angles > min_angle) & (angles < math.pi / 2 - min_angle) & (abscissa_ratio > 0.1) & (height_ratio > 0.05)
        valid_changes = requested_changes[valid]
        arguments: dict[str, Any] = {"start_angle": angle, "start_abscissa": x, "arm": arm, "angle_change": valid_changes}
        changes = (np.asarray(change(**arguments)) for change in (equilibrium_speed_change, parabola_speed_change))
        return SpeedDeviationCurve(valid_changes, *changes)


def has_isochronous_parabolas(scene: Scene) -> bool:
    """Return whether the plate can show a scene: a rhombic pendulum governor with gravity and centrifugal force.

    Result: true for a pendulum governor with the balls at the joints, links as long as the arms and lugs
    below the suspensions.
    """
    if len(scene.parts) != 1 or scene.part.machine != "pendulum_governor" or not (scene.gravity and scene.has_centrifugal):
        return False
    governor = PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)
    return governor.is_rhombus and math.isclose(governor.joint_length, governor.arm, rel_tol=1e-12)


def _start_angle(governor: PendulumGovernor, travel: tuple[float, float], scene: Scene) -> float:
    """Return the osculation angle, else an equilibrium angle at the first speed, else the middle of the travel above the vertical."""
    if governor.offset < 0:
        return pendulum.least_stable_angle(governor)
    spindle = scene.spindle
    speed = abs((spindle.start_speed or 0.0) if isinstance(spindle, FreeSpindle) else spindle.speeds[0])
    for angle in pendulum.equilibrium_angles(governor, spindle_speed=speed) if speed else ():
        if _START_ANGLE_RANGE[0] <= angle <= _START_ANGLE_RANGE[1]:
            return float(angle)
    return (max(travel[0], 0.0) + travel[1]) / 2


def _speed_family(start_speed: float) -> tuple[float, ...]:
    """Return seven speeds (rad/s, ascending): round values in rpm on both sides of the start speed."""
    rpm = start_speed / RPM
    decade = 10.0 ** math.floor(math.log10(_SPEED_STEP_RATIO * rpm))
    step = min((m * decade for m in (1.0, 2.0, 2.5, 5.0, 10.0)), key=lambda step: abs(math.log(step / (_SPEED_STEP_RATIO * rpm))))
    nearest_multiple = round(rpm / step)
    return tuple((nearest_multiple + k) * step * RPM if k else start_speed for k in range(-3, 4))

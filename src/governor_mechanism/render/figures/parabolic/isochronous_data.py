"""What Zehnder's plate shows, in numbers: the start point, its parabola and circles, and the speeds on leaving it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.closed_form.parabolic import isochronous_curve as isochronous
from governor_mechanism.closed_form.parabolic.speed_deviation import parabola_change_on_leaving, speed_change_on_leaving
from governor_mechanism.closed_form.pendulum import dynamics as pendulum
from governor_mechanism.closed_form.pendulum.dynamics import PendulumGovernor
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.types import FloatArray

Point = tuple[float, float]

SHARES = (1.0, 1.3, 0.7)
"""Arms that are compared on leaving the start point, as shares of the radius of curvature."""

MARKS = np.radians([-4.0, -2.0, -1.0, 1.0, 2.0, 4.0])
"""Changes of the arm angle (rad) that are marked."""

SPAN = math.radians(8.0)
"""Largest change of the arm angle shown (rad), up and down."""

STEEPNESS = math.radians(10.0), math.radians(55.0)
"""A point of rest flatter or steeper than that has a circle of curvature too large for the plate."""

STEP = 0.085
"""Wanted step from one parabola's speed to the next, as a share of the speed in the middle."""


@dataclass(frozen=True, kw_only=True)
class Plate:
    """The plate in SI and radians: x from the spindle axis, y up, both zero at the vertex that all parabolas share.

    The start point is the osculation point of crossed arms (`osculates`), otherwise a point of rest; start_speed rests
    there, and the parabola of that speed has there the radius of curvature. travel is the lowest and highest arm angle,
    speeds are seven of the family with start_speed amid.
    """

    arm: float
    offset: float
    mass_ratio: float
    gravity: float
    travel: tuple[float, float]
    start_angle: float
    start_abscissa: float
    start_speed: float
    osculates: bool
    radius: float
    speeds: tuple[float, ...]

    @property
    def start(self) -> Point:
        """The start point (m)."""
        return self.start_abscissa, float(self.heights(self.start_speed, np.array(self.start_abscissa)))

    @property
    def suspension(self) -> Point:
        """Where the arm hangs (m)."""
        return self.offset, self.start[1] + self.arm * math.cos(self.start_angle)

    @property
    def centre(self) -> Point:
        """Centre of curvature of the parabola at the start point (m)."""
        x, y = self.start
        return x - self.radius * math.sin(self.start_angle), y + self.radius * math.cos(self.start_angle)

    @property
    def share(self) -> float:
        """The governor's own arm over the radius of curvature."""
        return self.arm / self.radius

    def parameter(self, speed: float) -> float:
        """Double parameter (m) of the parabola of one spindle speed (rad/s)."""
        return float(
            isochronous.double_parameter(spindle_speed=speed, mass_ratio=self.mass_ratio, gravity=self.gravity)
        )

    def heights(self, speed: float, abscissae: FloatArray) -> FloatArray:
        """Heights (n,) above the vertex (m) of the parabola of one spindle speed (rad/s) at abscissae (n,)."""
        return np.asarray(isochronous.parabola_height(abscissa=abscissae, double_parameter=self.parameter(speed)))

    def parting_point(self, speed: float) -> Point:
        """The point (m) of the parabola of one spindle speed (rad/s) where it rises at 45 degrees: x = 2 y."""
        x = float(
            isochronous.abscissa_at_45_degrees(spindle_speed=speed, mass_ratio=self.mass_ratio, gravity=self.gravity)
        )
        return x, float(self.heights(speed, np.array(x)))


@dataclass(frozen=True, kw_only=True)
class Leaving:
    """Relative changes of speed (n,) against changes of the arm angle (n,) (rad), on an arm of `share` radii.

    `true` is the speed of rest; `read` the speed of the parabola under the ball, by which Zehnder judged.
    """

    share: float
    turns: FloatArray
    true: FloatArray
    read: FloatArray


def has_parabolas(scene: Scene) -> bool:
    """Whether the plate can show the scene: a plain rhombus of a pendulum governor, with gravity and centrifugal."""
    if len(scene.parts) != 1 or scene.part.machine != "pendulum_governor":
        return False
    if not (scene.gravity and scene.centrifugal):
        return False
    governor = _governor(scene)
    return governor.is_rhombus and math.isclose(governor.joint_length, governor.arm, rel_tol=1e-12)


def plate_of(scene: Scene) -> Plate:
    """The plate of a scene.

    Raises MechanismError for any other scene than a rhombus with the balls at its joints, gravity and centrifugal on.
    """
    if not has_parabolas(scene):
        raise MechanismError(
            "isochronous parabolas are shown of a pendulum governor with gravity and centrifugal, its balls at the "
            "joints of arms and links, its links as long as its arms and its lugs below the suspensions; the scene "
            f"{scene.title!r} is no such governor"
        )
    governor = _governor(scene)
    travel = next((limit.low, limit.high) for limit in scene.part.mechanism.limits if limit.reading == "arm_angle")
    angle = _start_angle(governor, travel, _first_speed(scene))
    abscissa = float(pendulum.ball_radius(governor, arm_angle=angle))
    speed = float(pendulum.equilibrium_speed(governor, arm_angle=angle))
    ratio = governor.sleeve_mass / governor.ball_mass
    parameter = isochronous.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=governor.gravity)
    return Plate(
        arm=governor.arm,
        offset=governor.offset,
        mass_ratio=ratio,
        gravity=governor.gravity,
        travel=travel,
        start_angle=angle,
        start_abscissa=abscissa,
        start_speed=speed,
        osculates=governor.offset < 0,
        radius=float(isochronous.radius_of_curvature(abscissa=abscissa, double_parameter=parameter)),
        speeds=_family(speed),
    )


def leaving(plate: Plate, share: float, turns: FloatArray | None = None) -> Leaving:
    """The speeds on leaving the start point on an arm of `share` radii of curvature.

    turns (n,) are changes of the arm angle (rad), as many as fit within SPAN if left out; those that would bring the
    arm to the vertical or level, or the ball near the axis or the vertex, are dropped.
    """
    wanted = np.linspace(-SPAN, SPAN, 321) if turns is None else turns
    arm, angle = share * plate.radius, plate.start_angle
    x, y = plate.start
    angles = angle + wanted
    across = 1 + arm / x * (np.sin(angles) - math.sin(angle))
    up = 1 + arm / y * (math.cos(angle) - np.cos(angles))
    edge = math.radians(0.5)
    kept = wanted[(angles > edge) & (angles < math.pi / 2 - edge) & (across > 0.1) & (up > 0.05)]
    moved: dict[str, Any] = {"start_angle": angle, "start_abscissa": x, "arm": arm, "angle_change": kept}
    true, read = speed_change_on_leaving(**moved), parabola_change_on_leaving(**moved)
    return Leaving(share=share, turns=kept, true=np.asarray(true), read=np.asarray(read))


def _governor(scene: Scene) -> PendulumGovernor:
    return PendulumGovernor(**scene.part.dimensions, gravity=scene.gravity)


def _first_speed(scene: Scene) -> float:
    spindle = scene.spindle
    return abs(spindle.start_speed if isinstance(spindle, FreeSpindle) else spindle.speeds[0])


def _start_angle(governor: PendulumGovernor, travel: tuple[float, float], speed: float) -> float:
    """The osculation point; without one, a point of rest at the speed; else the middle of the raised arm's travel."""
    if governor.offset < 0:
        return pendulum.least_stable_angle(governor)
    for angle in pendulum.equilibrium_angles(governor, spindle_speed=speed) if speed else ():
        if STEEPNESS[0] <= angle <= STEEPNESS[1]:
            return float(angle)
    return (max(travel[0], 0.0) + travel[1]) / 2


def _family(middle: float) -> tuple[float, ...]:
    """Seven speeds (rad/s, ascending): round ones in rpm to either side of the one in the middle."""
    rpm = middle * 30 / math.pi
    decade = 10.0 ** math.floor(math.log10(STEP * rpm))
    step = min((m * decade for m in (1.0, 2.0, 2.5, 5.0, 10.0)), key=lambda step: abs(math.log(step / (STEP * rpm))))
    whole = round(rpm / step)
    return tuple((whole + k) * step * math.pi / 30 if k else middle for k in range(-3, 4))

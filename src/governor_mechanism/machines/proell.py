"""Proell governor: a Porter governor whose balls sit on upward extensions of the lower arms.

The plane turns with the spindle: x is measured from the spindle axis, y up from the suspension of the upper arms. The arm angle is that
of an upper arm from the downward vertical. A lower arm, its extension and its ball are one body.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from governor_mechanism.machines import base
from governor_mechanism.machines.base import sleeve_lift, x_coordinate
from governor_mechanism.model.joints import GROUND, Distance, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import Limit, LineAngle, StaticForce
from governor_mechanism.types import Vector2
from governor_mechanism.units.fields import optional, quantity
from governor_mechanism.units.quantities import in_mm

RIGHT_BALL = "right ball"
LEFT_BALL = "left ball"
SLEEVE = "sleeve"
SIDE_SIGNS = {RIGHT_BALL: 1.0, LEFT_BALL: -1.0}

N_TRAVEL_SAMPLES = 720
"""Samples per quarter turn to bracket an end of the travel, before bisection."""
MAX_REACH_RATIO = 0.9999
"""Largest horizontal reach of a lower arm, relative to its length: at 1 the sleeve's velocity is infinite for a finite one of the arm."""


@dataclass(frozen=True, kw_only=True)
class ProellGovernor(base.Machine):
    """Balls as points on massless lower arms, upper arms as distances, and a sleeve. Lengths in m, masses in kg, angles in rad."""

    name: ClassVar[str] = "proell"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "arm_angle": "angle of the upper arms from the downward vertical, positive outward",
        "ball_radius": "distance of the right ball from the spindle axis",
        "sleeve_lift": "height of the sleeve above its position with hanging arms, or at the low end of the travel",
        "static_sleeve_force": "force on the sleeve, upward, that balances springs and weights without rotation",
    }

    arm: float = quantity("length", meaning="from the suspension to the joint of upper and lower arm")
    link: float | None = optional("length", meaning="of the lower arm, from this joint to the sleeve; as long as arm if left out")
    extension: float = quantity("length", meaning="of the lower arm beyond the joint, to the ball's centre")
    extension_angle: float | None = quantity(
        "angle",
        sign="any",
        default=None,
        meaning="of the extension from the line of the lower arm, positive outward; 0 if this and upright_radius are left out",
    )
    upright_radius: float | None = optional("length", meaning="of the balls where the extensions are upright, instead of extension_angle")
    offset: float = quantity("length", sign="any", default=0.0, meaning="of the suspension from the spindle axis; negative = crossed arms")
    lug_offset: float | None = optional("length", sign="any", meaning="of the sleeve's lug from the axis; the same as offset if left out")
    ball_mass: float = quantity("mass", meaning="of one ball; there are two")
    sleeve_mass: float = quantity("mass", meaning="of the whole sleeve and its load")

    def dimension_problems(self) -> Iterator[str]:
        """Yield a sentence about dimensions with which the governor cannot be assembled."""
        if self.extension_angle is not None and self.upright_radius is not None:
            yield "extension_angle and upright_radius are both given, and each determines the other; leave one of them out"
            return
        if self.upright_radius is not None and not self._closes_at(self.upright_radius):
            yield (
                f"upright_radius ({in_mm(self.upright_radius)}) is not reached: an arm of {in_mm(self.arm)} and a link of "
                f"{in_mm(self.link_length)} do not meet there; give a radius less than both, from the axis"
            )
            return
        if abs(self.bend) >= math.pi / 2:
            yield (
                f"extension_angle ({math.degrees(self.bend):.6g} deg) must lie between -90 and 90 deg: the balls of a Proell governor are "
                f"above the joints{base.unit_hint(self.bend, math.pi, '-20 deg')}"
            )
        elif self._middle_angle is None:
            yield (
                f"the arms cannot be assembled with the balls off the axis: arm {in_mm(self.arm)}, link {in_mm(self.link_length)}, offset "
                f"{in_mm(self.offset)}, lug_offset {in_mm(self.lug_distance)}; "
                "lengthen the link or bring offset and lug_offset closer together"
            )

    @property
    def link_length(self) -> float:
        """Length of the lower arm, m."""
        return self.arm if self.link is None else self.link

    @property
    def lug_distance(self) -> float:
        """Distance of the sleeve's lug from the axis, m."""
        return self.offset if self.lug_offset is None else self.lug_offset

    @property
    def bend(self) -> float:
        """Angle of the extension from the line of the lower arm, positive outward, rad."""
        if self.upright_radius is not None:
            return -math.asin((self.upright_radius - self.lug_distance) / self.link_length)
        return self.extension_angle or 0.0

    def joint_position(self, arm_angle: float) -> Vector2:
        """Return the distance of the right joint from the axis and its height above the suspension at an arm angle (rad), m."""
        return self.offset + self.arm * math.sin(arm_angle), -self.arm * math.cos(arm_angle)

    def link_angle(self, arm_angle: float) -> float:
        """Return the angle of the right lower arm from the upright, positive outward, at an arm angle (rad), rad."""
        reach = self.joint_position(arm_angle)[0] - self.lug_distance
        return math.asin(reach / self.link_length)

    def ball_position(self, arm_angle: float) -> Vector2:
        """Return the distance of the right ball from the axis and its height above the suspension at an arm angle (rad), m."""
        x, y = self.joint_position(arm_angle)
        angle = self.link_angle(arm_angle) + self.bend
        return x + self.extension * math.sin(angle), y + self.extension * math.cos(angle)

    def sleeve_height(self, arm_angle: float) -> float:
        """Return the height of the sleeve's lugs above the suspension at an arm angle (rad), m."""
        return self.joint_position(arm_angle)[1] - self.link_length * math.cos(self.link_angle(arm_angle))

    def _closes_at(self, joint_radius: float) -> bool:
        return abs(joint_radius - self.offset) < self.arm and abs(joint_radius - self.lug_distance) < self.link_length

    def _failure_at(self, arm_angle: float) -> str:
        """Return why the governor does not work at an arm angle (rad), or an empty text."""
        if abs(arm_angle) >= math.pi / 2:
            return "the arms are at 90 degrees to the spindle (dead centre)"
        if abs(self.joint_position(arm_angle)[0] - self.lug_distance) >= MAX_REACH_RATIO * self.link_length:
            return "the link is at 90 degrees to the spindle (dead centre)"
        if math.tan(arm_angle) + math.tan(self.link_angle(arm_angle)) <= 0:
            return "arms and links are in line (dead centre)"
        return "the balls meet on the spindle axis" if self.ball_position(arm_angle)[0] <= 0 else ""

    @cached_property
    def _middle_angle(self) -> float | None:
        """The arm angle nearest to 40 deg at which the governor works, rad; None if there is none."""
        angles = sorted(
            (math.pi / 2 * k / N_TRAVEL_SAMPLES for k in range(1 - N_TRAVEL_SAMPLES, N_TRAVEL_SAMPLES)),
            key=lambda angle: abs(angle - math.radians(40.0)),
        )
        return next((angle for angle in angles if not self._failure_at(angle)), None)

    def travel_limit(self) -> Limit:
        """Return the range of the arm angle, and what happens at its ends."""
        low, low_message = self._travel_end(-1.0)
        high, high_message = self._travel_end(1.0)
        return Limit(reading="arm_angle", low=low, high=high, low_message=low_message, high_message=high_message)

    def _travel_end(self, direction: float) -> tuple[float, str]:
        """Return the end of the travel in a direction, and the reason, by bisection."""
        valid_angle = failing_angle = self._middle_angle or 0.0
        while not self._failure_at(failing_angle):
            valid_angle = failing_angle
            failing_angle = failing_angle + direction * 0.5 * math.pi / N_TRAVEL_SAMPLES
        while (midpoint := 0.5 * (valid_angle + failing_angle)) not in (valid_angle, failing_angle):
            valid_angle, failing_angle = (valid_angle, midpoint) if self._failure_at(midpoint) else (midpoint, failing_angle)
        return valid_angle, self._failure_at(failing_angle)

    def mechanism(self) -> Mechanism:
        """Build lower arms with their balls, upper arms as distances, and the sleeve on its guide."""
        travel = self.travel_limit()
        # Lift is measured from hanging arms, or from the low end of the travel if they cannot hang.
        zero_lift_angle = min(max(0.0, travel.low), travel.high)
        margin = 0.1 * (travel.high - travel.low)
        joint = self._joint_of_arms(RIGHT_BALL)
        ball = Point(body=RIGHT_BALL)
        sleeve = Point(body=SLEEVE)
        return Mechanism(
            bodies=(
                *(Body(name=name, mass=self.ball_mass) for name in SIDE_SIGNS),
                Body(name=SLEEVE, mass=self.sleeve_mass, can_rotate=False),
            ),
            joints=tuple(self._joints()),
            readings=(
                LineAngle(name="arm_angle", quantity="angle", start=Point(body=GROUND, x=self.offset), end=joint),
                x_coordinate("ball_radius", ball),
                sleeve_lift(sleeve, zero=self.sleeve_height(zero_lift_angle)),
            ),
            derived_readings=(StaticForce(name="static_sleeve_force", reading="sleeve_lift"),),
            coordinate="arm_angle",
            length_scale=self.arm,
            initial_guess=self._poses(min(max(math.radians(40.0), travel.low + margin), travel.high - margin)),
            limits=(travel,),
        )

    def _joints(self) -> Iterator[Joint]:
        for name, sign in SIDE_SIGNS.items():
            side = name.split()[0]
            suspension = Point(body=GROUND, x=sign * self.offset)
            yield Distance(name=f"{side} arm", first=suspension, second=self._joint_of_arms(name), length=self.arm)
            yield Pin(name=f"{side} lug", first=Point(body=SLEEVE, x=sign * self.lug_distance), second=self._lug(name))
        yield Slider(name="spindle guide", first=Point(body=GROUND), second=Point(body=SLEEVE), angle=math.pi / 2)

    def _joint_of_arms(self, name: str) -> Point:
        """Return the joint of upper and lower arm, from the ball; the body's y axis is along the lower arm, toward the joint."""
        x = self.extension * math.sin(self.bend)
        y = self.extension * math.cos(self.bend)
        return Point(body=name, x=-SIDE_SIGNS[name] * x, y=-y)

    def _lug(self, name: str) -> Point:
        joint = self._joint_of_arms(name)
        return Point(body=name, x=joint.x, y=joint.y - self.link_length)

    def _poses(self, arm_angle: float) -> tuple[tuple[float, float, float], ...]:
        """Return the poses of all bodies at an arm angle (rad)."""
        (x, y), angle = self.ball_position(arm_angle), self.link_angle(arm_angle)
        return (x, y, -angle), (-x, y, angle), (0.0, self.sleeve_height(arm_angle), 0.0)

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        return base.travel_problems(values, self.travel_limit(), math.pi, "40 deg")

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI, with the values that stand for omitted ones; the extension by its angle."""
        derived = {"link": self.link_length, "lug_offset": self.lug_distance, "extension_angle": self.bend}
        values = super().dimensions() | derived
        return {name: value for name, value in values.items() if name != "upright_radius"}

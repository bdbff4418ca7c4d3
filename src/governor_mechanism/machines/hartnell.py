"""Hartnell governor: balls on bell cranks, whose rollers lift the sleeve against the effect `spring` on it.

The plane turns with the spindle: x is measured from the spindle axis, y up from the pivots of the bell cranks. The arm angle is that of
a ball's arm from the upright, positive outward. The collar of the sleeve is flat and rests on the rollers, so that sleeve and rollers
have equal vertical displacements at any obliquity of the arms.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.machines import base
from governor_mechanism.machines.base import sleeve_lift, x_coordinate
from governor_mechanism.model.joints import GROUND, Gear, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import Limit, LineAngle, Reading, StaticForce
from governor_mechanism.types import Vector2
from governor_mechanism.units.fields import optional, quantity
from governor_mechanism.units.quantities import in_mm

RIGHT_BALL = "right ball"
LEFT_BALL = "left ball"
SLEEVE = "sleeve"
SIDE_SIGNS = {RIGHT_BALL: 1.0, LEFT_BALL: -1.0}


@dataclass(frozen=True, kw_only=True)
class HartnellGovernor(base.Machine):
    """Two balls as points on massless bell cranks, and a sleeve on their rollers. Lengths in m, masses in kg, angles in rad."""

    name: ClassVar[str] = "hartnell"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "arm_angle": "angle of the ball arms from the upright, positive outward",
        "ball_radius": "distance of the right ball from the spindle axis",
        "sleeve_lift": "height of the sleeve above its position with the balls at inner_radius",
        "static_sleeve_force": "force on the sleeve, upward, that balances springs and weights without rotation",
    }

    ball_arm: float = quantity("length", meaning="from the pivot of a bell crank to its ball's centre")
    sleeve_arm: float = quantity("length", meaning="from the pivot to the roller under the sleeve")
    bell_crank_angle: float = quantity("angle", default=math.pi / 2, meaning="between the two arms of a bell crank")
    pivot_radius: float = quantity("length", meaning="of the pivots from the spindle axis")
    inner_radius: float | None = optional("length", meaning="of the balls where sleeve_lift is 0; pivot_radius, upright arms, if left out")
    ball_mass: float = quantity("mass", meaning="of one ball; there are two")
    sleeve_mass: float | None = optional("mass", meaning="of the whole sleeve; left out where it is neglected")

    def dimension_problems(self) -> Iterator[str]:
        """Yield a sentence about dimensions with which the governor cannot be assembled."""
        degrees = math.degrees(self.bell_crank_angle)
        if degrees >= 180.0:
            yield (
                f"bell_crank_angle ({degrees:.6g} deg) must be less than 180 deg; bell cranks of a Hartnell governor have about 90 deg"
                f"{base.unit_hint(self.bell_crank_angle, math.tau, '90 deg')}"
            )
        elif self.sleeve_arm >= self.pivot_radius:
            yield (
                f"sleeve_arm ({in_mm(self.sleeve_arm)}) must be shorter than pivot_radius ({in_mm(self.pivot_radius)}), "
                "or the rollers would meet on the spindle axis"
            )
        else:
            travel = self.travel_limit()
            low, high = (self.ball_position(angle)[0] for angle in (travel.low, travel.high))
            # zero lift is a height only, so the end of the travel itself is allowed
            if self.inner_radius is not None and not low < self.inner_radius < high:
                yield (
                    f"inner_radius ({in_mm(self.inner_radius)}) is not reached by the balls: on arms of {in_mm(self.ball_arm)} "
                    f"about pivots at {in_mm(self.pivot_radius)} they go from {in_mm(max(low, 0.0))} to {in_mm(high)}"
                )

    def ball_position(self, arm_angle: float) -> Vector2:
        """Return the distance of the right ball from the axis and its height above the pivot at an arm angle (rad), m."""
        arm = self.ball_arm
        return self.pivot_radius + arm * math.sin(arm_angle), arm * math.cos(arm_angle)

    def roller_position(self, arm_angle: float) -> Vector2:
        """Return the distance of the right roller from the axis and its height above the pivot at an arm angle (rad), m."""
        angle = self.bell_crank_angle - arm_angle
        return self.pivot_radius - self.sleeve_arm * math.sin(angle), self.sleeve_arm * math.cos(angle)

    @property
    def zero_lift_angle(self) -> float:
        """Arm angle at zero lift, rad."""
        return 0.0 if self.inner_radius is None else math.asin((self.inner_radius - self.pivot_radius) / self.ball_arm)

    def travel_limit(self) -> Limit:
        """Return the range of the arm angle, and what happens at its ends."""
        level = "the arms of the balls are horizontal (dead centre)"
        roller = "the rollers are below or above their pivots (dead centre)"
        low, low_message = max((-math.pi / 2, level), (self.bell_crank_angle - math.pi, roller))
        if self.pivot_radius < self.ball_arm:
            meeting_angle = -math.asin(self.pivot_radius / self.ball_arm)
            low, low_message = max((low, low_message), (meeting_angle, "the balls meet on the spindle axis"))
        high, high_message = min((math.pi / 2, level), (self.bell_crank_angle, roller))
        return Limit(reading="arm_angle", low=low, high=high, low_message=low_message, high_message=high_message)

    def mechanism(self) -> Mechanism:
        """Build bell cranks with their balls, and the sleeve; without its mass the bell cranks are geared to one another."""
        ball = Point(body=RIGHT_BALL)
        return Mechanism(
            bodies=tuple(self._bodies()),
            joints=tuple(self._joints()),
            readings=self._readings(ball),
            derived_readings=(StaticForce(name="static_sleeve_force", reading="sleeve_lift"),),
            coordinate="arm_angle",
            length_scale=max(self.ball_arm, self.sleeve_arm),
            initial_guess=self._poses(self.zero_lift_angle),
            limits=(self.travel_limit(),),
        )

    def _bodies(self) -> Iterator[Body]:
        yield from (Body(name=name, mass=self.ball_mass) for name in SIDE_SIGNS)
        if self.sleeve_mass is not None:
            yield Body(name=SLEEVE, mass=self.sleeve_mass, can_rotate=False)

    def _joints(self) -> Iterator[Joint]:
        for name, sign in SIDE_SIGNS.items():
            side = name.split()[0]
            pivot = Point(body=GROUND, x=sign * self.pivot_radius)
            yield Pin(name=f"{side} pivot", first=pivot, second=Point(body=name, y=-self.ball_arm))
            if self.sleeve_mass is not None:
                yield Slider(name=f"{side} roller", first=Point(body=SLEEVE), second=self._roller(name), angle=0.0)
        if self.sleeve_mass is None:
            yield Gear(name="balls in step", first=Point(body=RIGHT_BALL), second=Point(body=LEFT_BALL), ratio=-1.0)
        else:
            yield Slider(name="spindle guide", first=Point(body=GROUND), second=Point(body=SLEEVE), angle=math.pi / 2)

    def _readings(self, ball: Point) -> tuple[Reading, ...]:
        """Return the readings; the angle is that of the left arm, from its ball down to its pivot, so that outward is positive."""
        sleeve = self._roller(RIGHT_BALL) if self.sleeve_mass is None else Point(body=SLEEVE)
        left_pivot = Point(body=GROUND, x=-self.pivot_radius)
        return (
            LineAngle(name="arm_angle", quantity="angle", start=Point(body=LEFT_BALL), end=left_pivot),
            x_coordinate("ball_radius", ball),
            sleeve_lift(sleeve, zero=self.roller_position(self.zero_lift_angle)[1]),
        )

    def _poses(self, arm_angle: float) -> tuple[tuple[float, float, float], ...]:
        """Return the poses of all bodies at an arm angle (rad); a ball's axes are those of the plane with its arm upright."""
        x, y = self.ball_position(arm_angle)
        balls = (x, y, -arm_angle), (-x, y, arm_angle)
        return balls if self.sleeve_mass is None else (*balls, (0.0, self.roller_position(arm_angle)[1], 0.0))

    def _roller(self, name: str) -> Point:
        angle, arm = self.bell_crank_angle, self.sleeve_arm
        return Point(body=name, x=-SIDE_SIGNS[name] * arm * math.sin(angle), y=arm * math.cos(angle) - self.ball_arm)

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        return base.travel_problems(values, self.travel_limit(), math.pi / 2, "5 deg")

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI, with the values that stand for omitted ones; a neglected sleeve mass is 0 kg."""
        omitted = {"inner_radius": self.pivot_radius if self.inner_radius is None else self.inner_radius}
        return super().dimensions() | omitted | {"sleeve_mass": self.sleeve_mass or 0.0}

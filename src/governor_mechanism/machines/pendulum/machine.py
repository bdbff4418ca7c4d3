"""Pendulum governors after Watt and Porter: open or crossed arms, extended arms, and separate links.

Geometry after Zehnder, Dinglers Polytechnisches Journal 225 (1877), section 1. The plane turns with the spindle: x is measured from the
spindle axis, y up from the suspension of the arms.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import Machine, dimension_field, unsupported_effect_messages
from governor_mechanism.machines.pendulum.bodies import LEFT_BALL, LEFT_LINK, RIGHT_BALL, RIGHT_LINK, SLEEVE, PendulumBuilder
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Limit, Mechanism
from governor_mechanism.model.scene import TURNING_PLANE

__all__ = ["LEFT_BALL", "LEFT_LINK", "RIGHT_BALL", "RIGHT_LINK", "SLEEVE", "PendulumGovernor"]


@dataclass(frozen=True, kw_only=True)
class PendulumGovernor(Machine):
    """Two balls on arms and a sleeve on links. Lengths in m, masses in kg; the effect `rods` gives mass to arms and links."""

    name: ClassVar[str] = "pendulum_governor"
    plane: ClassVar[str] = TURNING_PLANE

    arm: float = dimension_field("length", "from the suspension to the ball's centre")
    ball_mass: float = dimension_field("mass", "of one ball; there are two")
    offset: float = dimension_field("length", "of the suspension from the spindle axis; negative = crossed arms", default=0.0, signed=True)
    arm_joint: float | None = dimension_field(
        "length", "from the suspension to the joint of arm and link; the whole arm if left out", default=None
    )
    link: float | None = dimension_field("length", "of the sleeve link; as long as arm_joint if left out", default=None)
    lug_offset: float | None = dimension_field(
        "length", "of the sleeve's lug from the axis; the same as offset if left out", default=None, signed=True
    )
    sleeve_mass: float | None = dimension_field(
        "mass", "of the whole sleeve and its load; left out for a governor without a loaded sleeve", default=None
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.joint_length > self.arm:
            raise MechanismError(f"arm_joint ({_mm(self.joint_length)}) lies beyond the ball; it must not exceed arm ({_mm(self.arm)})")
        low, high = self._angle_range_with_ball_off_axis()
        if low >= high:
            raise MechanismError(
                f"offset ({_mm(self.offset)}) puts the balls on or across the spindle axis at every arm angle; "
                f"with an arm of {_mm(self.arm)} it must lie above {_mm(-self.arm)}"
            )
        reach = self._min_link_reach(low, high)
        if reach >= self.link_length:
            raise MechanismError(
                f"link ({_mm(self.link_length)}) is too short to be assembled: between arm joint and sleeve it stays "
                f"open by {_mm(reach - self.link_length)} at best; it closes for a link longer than {_mm(reach)}"
            )

    @property
    def joint_length(self) -> float:
        """Distance of the joint of arm and link from the suspension, m."""
        return self.arm if self.arm_joint is None else self.arm_joint

    @property
    def link_length(self) -> float:
        """Length of the link, m."""
        return self.joint_length if self.link is None else self.link

    @property
    def lug_distance(self) -> float:
        """Distance of the sleeve's lug from the axis, m."""
        return self.offset if self.lug_offset is None else self.lug_offset

    def mechanism(self, rod_masses: RodMasses | None = None, clearance: Clearance | None = None) -> Mechanism:
        """Build balls, sleeve, arms and links.

        Massless arms and links are distances, or levers if the ball is beyond the joint. Arms and links with mass are bodies; an arm is
        one body with its ball, also if the ball has a radius. With clearance the sleeve is free, and `sleeve_clearance` is its height
        above the position on the links. Raise MechanismError for rods or clearance that this governor does not support.
        """
        builder = PendulumBuilder(governor=self, rod_masses=rod_masses, clearance=clearance)
        low, high, low_message, high_message = self._travel_limits()
        angle = min(max(math.radians(40.0), low + 0.1 * (high - low)), high - 0.1 * (high - low))
        travel = Limit(reading="arm_angle", low=low, high=high, low_message=low_message, high_message=high_message)
        return Mechanism(
            bodies=builder.bodies(),
            joints=builder.joints(),
            readings=builder.readings(self.sleeve_height(self._zero_lift_angle())),
            coordinate="arm_angle",
            length_scale=self.arm,
            initial_guess=builder.poses(angle),
            limits=(travel, *builder.dead_centre_limits()),
            internal_outputs=builder.internal_outputs(),
        )

    @classmethod
    def effect_problems(cls, effects: Iterable[Effect]) -> tuple[str, ...]:
        """Return sentences about unsupported effects; `mechanism` checks `rods` and `clearance` for each governor."""
        return unsupported_effect_messages(cls.name, effects, supported=(RodMasses, Clearance))

    def mechanism_with_effects(self, effects: Iterable[Effect]) -> Mechanism:
        """Build the mechanism with the rods and the clearance of a scene's effects."""
        listed = list(effects)
        return self.mechanism(
            rod_masses=next((effect for effect in listed if isinstance(effect, RodMasses)), None),
            clearance=next((effect for effect in listed if isinstance(effect, Clearance)), None),
        )

    def sleeve_height(self, angle: float) -> float:
        """Return the height of the sleeve on its links above the suspension at an arm angle (rad), m."""
        reach = self.offset + self.joint_length * math.sin(angle) - self.lug_distance
        return -self.joint_length * math.cos(angle) - math.sqrt(max(self.link_length**2 - reach**2, 0.0))

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI, with the values that stand for omitted ones; no sleeve load is 0 kg."""
        return {
            "arm": self.arm,
            "ball_mass": self.ball_mass,
            "offset": self.offset,
            "arm_joint": self.joint_length,
            "link": self.link_length,
            "lug_offset": self.lug_distance,
            "sleeve_mass": self.sleeve_mass or 0.0,
        }

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        angle = values.get("arm_angle")
        low, high, low_message, high_message = self._travel_limits()
        if not isinstance(angle, float) or low < angle < high:
            return ()
        message_start = f"start.arm_angle ({math.degrees(angle):g} deg) lies outside the travel"
        allowed = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
        hint = "; a bare number is in rad, so write it with its unit: 40 deg" if abs(angle) > math.pi else ""
        return (f"{message_start} of this governor, {allowed}: {low_message if angle <= low else high_message}{hint}",)

    def _zero_lift_angle(self) -> float:
        """Return the arm angle at zero lift (rad): hanging arms, or the low end of the travel if they cannot hang."""
        low, high, _, _ = self._travel_limits()
        return min(max(0.0, low), high)

    def _angle_range_with_ball_off_axis(self) -> tuple[float, float]:
        ratio = -self.offset / self.arm
        return (math.asin(ratio) if -1 < ratio < 1 else math.copysign(math.pi / 2, ratio)), math.pi / 2

    def _min_link_reach(self, low: float, high: float) -> float:
        """Return the smallest horizontal distance of arm joint and lug over these arm angles (m)."""
        ends = [self.offset + self.joint_length * math.sin(angle) - self.lug_distance for angle in (low, high)]
        return 0.0 if ends[0] * ends[1] <= 0 else min(abs(end) for end in ends)

    def _travel_limits(self) -> tuple[float, float, str, str]:
        """Return the lowest and highest arm angle, and what happens there."""
        low, high = self._angle_range_with_ball_off_axis()
        low_message = "the balls meet on the spindle axis"
        high_message = "the arms are at 90 degrees to the spindle (dead centre)"
        reach = self.lug_distance - self.offset
        in_line_angle = math.asin(reach / (self.joint_length + self.link_length))
        if in_line_angle > low:
            low, low_message = in_line_angle, "arms and links are in line (dead centre)"
        max_sine = (reach + self.link_length) / self.joint_length
        if max_sine < 1.0:
            high, high_message = math.asin(max_sine), "the link is at 90 degrees to the spindle; it is too short"
        return low, high, low_message, high_message


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.6g} mm"

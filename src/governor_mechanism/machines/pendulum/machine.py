"""The pendulum governor: Watt and Porter, arms on or off the axis or crossed, extended arms, links of their own.

Geometry after Zehnder, Dinglers Polytechnisches Journal 225 (1877), section 1. The plane turns with the spindle:
x from the spindle axis, y up, the suspension of the arms at y = 0.
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
    """Two balls on arms, a sleeve on links. Lengths in m, masses in kg; arms and links have mass where rods give it."""

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
        """From the suspension to the joint of arm and link (m)."""
        return self.arm if self.arm_joint is None else self.arm_joint

    @property
    def link_length(self) -> float:
        """Length of the sleeve link (m)."""
        return self.joint_length if self.link is None else self.link

    @property
    def lug_distance(self) -> float:
        """Distance of the sleeve's lug from the axis (m)."""
        return self.offset if self.lug_offset is None else self.lug_offset

    def mechanism(self, rod_masses: RodMasses | None = None, clearance: Clearance | None = None) -> Mechanism:
        """Balls, sleeve, massless arms and links as distances; a lever where the ball stands beyond the joint.

        With rods those of arms and links that have mass are bodies, an arm together with its ball; any ball radius
        makes the arms such bodies too. With play the sleeve is free of the links, and `sleeve_clearance` tells how far it
        stands above where they would hang it. Raises MechanismError for rods and play that this governor has not.
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
        """About masses; rods and play this machine has. Which of its governors have not, `mechanism` says."""
        return unsupported_effect_messages(cls.name, effects, supported=(RodMasses, Clearance))

    def mechanism_with_effects(self, effects: Iterable[Effect]) -> Mechanism:
        """The mechanism with the rods and the play of a scene's effects."""
        listed = list(effects)
        return self.mechanism(
            rod_masses=next((effect for effect in listed if isinstance(effect, RodMasses)), None),
            clearance=next((effect for effect in listed if isinstance(effect, Clearance)), None),
        )

    def sleeve_height(self, angle: float) -> float:
        """Of a sleeve that hangs on its links at an arm angle (rad), above the suspension (m)."""
        reach = self.offset + self.joint_length * math.sin(angle) - self.lug_distance
        return -self.joint_length * math.cos(angle) - math.sqrt(max(self.link_length**2 - reach**2, 0.0))

    def dimensions(self) -> dict[str, float]:
        """All dimensions in SI, those left out filled with what they stand for; no sleeve load is 0 kg."""
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
        """A start angle outside the travel, with the length that would be needed."""
        angle = values.get("arm_angle")
        low, high, low_message, high_message = self._travel_limits()
        if not isinstance(angle, float) or low < angle < high:
            return ()
        message_start = f"start.arm_angle ({math.degrees(angle):g} deg) lies outside the travel"
        allowed = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
        hint = "; a bare number is in rad, so write it with its unit: 40 deg" if abs(angle) > math.pi else ""
        return (f"{message_start} of this governor, {allowed}: {low_message if angle <= low else high_message}{hint}",)

    def _zero_lift_angle(self) -> float:
        """Sleeve lift is counted from hanging arms, or from the low end of the travel where they cannot hang (rad)."""
        low, high, _, _ = self._travel_limits()
        return min(max(0.0, low), high)

    def _angle_range_with_ball_off_axis(self) -> tuple[float, float]:
        ratio = -self.offset / self.arm
        return (math.asin(ratio) if -1 < ratio < 1 else math.copysign(math.pi / 2, ratio)), math.pi / 2

    def _min_link_reach(self, low: float, high: float) -> float:
        """Smallest distance in x between arm joint and lug over these arm angles (m)."""
        ends = [self.offset + self.joint_length * math.sin(angle) - self.lug_distance for angle in (low, high)]
        return 0.0 if ends[0] * ends[1] <= 0 else min(abs(end) for end in ends)

    def _travel_limits(self) -> tuple[float, float, str, str]:
        """Lowest and highest arm angle, and what happens there."""
        low, high = self._angle_range_with_ball_off_axis()
        low_message = "the balls meet on the spindle axis"
        high_message = "the arms stand at 90 degrees to the spindle (dead centre)"
        reach = self.lug_distance - self.offset
        in_line_angle = math.asin(reach / (self.joint_length + self.link_length))
        if in_line_angle > low:
            low, low_message = in_line_angle, "arms and links stand in line (dead centre)"
        max_sine = (reach + self.link_length) / self.joint_length
        if max_sine < 1.0:
            high, high_message = math.asin(max_sine), "the link stands at 90 degrees to the spindle; it is too short"
        return low, high, low_message, high_message


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.6g} mm"

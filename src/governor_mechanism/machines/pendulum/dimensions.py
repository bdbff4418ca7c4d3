"""Dimensions of a pendulum governor and the geometry that follows from them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.machines.base import Machine, dimension_field, optional_field
from governor_mechanism.model.output_variables import Limit


@dataclass(frozen=True, kw_only=True)
class PendulumDimensions(Machine):
    """Dimensions of a pendulum governor. Lengths in m, masses in kg."""

    arm: float = dimension_field("length", "from the suspension to the ball's centre")
    ball_mass: float = dimension_field("mass", "of one ball; there are two")
    offset: float = dimension_field("length", "of the suspension from the spindle axis; negative = crossed arms", default=0.0, signed=True)
    arm_joint: float | None = optional_field("length", "from the suspension to the joint of arm and link; the whole arm if left out")
    link: float | None = optional_field("length", "of the sleeve link; as long as arm_joint if left out")
    lug_offset: float | None = optional_field("length", "of the sleeve's lug from the axis; the same as offset if left out", signed=True)
    sleeve_mass: float | None = optional_field("mass", "of the whole sleeve and its load; left out for a governor without a loaded sleeve")

    def dimension_problems(self) -> Iterator[str]:
        """Yield a sentence about dimensions with which the governor cannot be assembled."""
        low, high = self._angle_range_with_ball_off_axis()
        reach = self._min_link_reach(low, high)
        if self.joint_length > self.arm:
            yield f"arm_joint ({_mm(self.joint_length)}) lies beyond the ball; it must not exceed arm ({_mm(self.arm)})"
        elif low >= high:
            yield (
                f"offset ({_mm(self.offset)}) puts the balls on or across the spindle axis at every arm angle; "
                f"with an arm of {_mm(self.arm)} it must lie above {_mm(-self.arm)}"
            )
        elif reach >= self.link_length:
            yield (
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

    def sleeve_height(self, angle: float) -> float:
        """Return the height of the sleeve on its links above the suspension at an arm angle (rad), m."""
        reach = self._link_reach(angle)
        return -self.joint_length * math.cos(angle) - math.sqrt(max(self.link_length**2 - reach**2, 0.0))

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI, with the values that stand for omitted ones; no sleeve load is 0 kg."""
        omitted = {"arm_joint": self.joint_length, "link": self.link_length, "lug_offset": self.lug_distance}
        return super().dimensions() | omitted | {"sleeve_mass": self.sleeve_mass or 0.0}

    def _angle_range_with_ball_off_axis(self) -> tuple[float, float]:
        ratio = -self.offset / self.arm
        return (math.asin(ratio) if -1 < ratio < 1 else math.copysign(math.pi / 2, ratio)), math.pi / 2

    def _min_link_reach(self, low: float, high: float) -> float:
        """Return the smallest horizontal distance of arm joint and lug over these arm angles (m)."""
        ends = self._link_reach(low), self._link_reach(high)
        return 0.0 if ends[0] * ends[1] <= 0 else min(map(abs, ends))

    def _link_reach(self, angle: float) -> float:
        """Return the horizontal distance of the arm joint from the lug at an arm angle (rad), m."""
        return self.offset + self.joint_length * math.sin(angle) - self.lug_distance

    def travel_limit(self) -> Limit:
        """Return the range of the arm angle, and what happens at its ends."""
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
        return Limit(reading="arm_angle", low=low, high=high, low_message=low_message, high_message=high_message)


def _mm(metres: float) -> str:
    return f"{metres * 1e3:.6g} mm"

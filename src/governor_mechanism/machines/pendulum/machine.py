"""Pendulum governors after Watt and Porter: open or crossed arms, extended arms, and separate links.

Geometry after Zehnder, Dinglers Polytechnisches Journal 225 (1877), section 1. The plane turns with the spindle: x is measured from the
spindle axis, y up from the suspension of the arms.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.machines.base import travel_problems
from governor_mechanism.machines.pendulum.bodies import PendulumBuilder
from governor_mechanism.machines.pendulum.dimensions import PendulumDimensions
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.model.part import TURNING_PLANE


@dataclass(frozen=True, kw_only=True)
class PendulumGovernor(PendulumDimensions):
    """Two balls on arms and a sleeve on links. Lengths in m, masses in kg; the effect `rods` gives mass to arms and links."""

    name: ClassVar[str] = "pendulum_governor"
    plane: ClassVar[str] = TURNING_PLANE
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (RodMasses, Clearance)

    def mechanism(self, rod_masses: RodMasses | None = None, clearance: Clearance | None = None) -> Mechanism:
        """Build balls, sleeve, arms and links.

        Massless arms and links are distances, or levers if the ball is beyond the joint. Arms and links with mass are bodies; an arm is
        one body with its ball, also if the ball has a radius. With clearance the sleeve is free, and `sleeve_clearance` is its height
        above the position on the links. Raise MechanismError for rods or clearance that this governor does not support.
        """
        builder = PendulumBuilder(governor=self, rod_masses=rod_masses, clearance=clearance)
        low, high, low_message, high_message = self.travel_limits()
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

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        return travel_problems(values, "arm_angle", self.travel_limits(), math.pi, "40 deg")

    def _zero_lift_angle(self) -> float:
        """Return the arm angle at zero lift (rad): hanging arms, or the low end of the travel if they cannot hang."""
        low, high, _, _ = self.travel_limits()
        return min(max(0.0, low), high)

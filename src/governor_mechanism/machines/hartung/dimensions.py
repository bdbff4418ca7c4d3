"""Dimensions of a Hartung governor, positions of weights, hangers and sleeve over the lever angle, and limits of the travel."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from governor_mechanism.machines.base import Machine, dimension_field, optional_field
from governor_mechanism.model.output_variables import Limit
from governor_mechanism.types import Vector2

N_TRAVEL_SAMPLES = 720
"""Samples per quarter turn to bracket an end of the travel, before bisection."""


class Failure(NamedTuple):
    """Why the governor does not work at a lever angle, and the cure."""

    sentence: str
    cure: str


ARMS_LEVEL_OUTERMOST = Failure("the weights' arms are horizontal, outermost (dead centre)", "keep outer_angle above -90 deg")
ARMS_LEVEL_INNERMOST = Failure("the weights' arms are horizontal, innermost (dead centre)", "keep inner_angle below 90 deg")
WEIGHTS_MEET = Failure("the weights meet on the spindle axis", "raise fulcrum_radius")
LEVER_DEAD_CENTRE = Failure(
    "the sleeve has a turning point: the lever no longer lifts it", "lower bell_crank_angle, lengthen the hanger where it has a length"
)
HANGER_TOO_SHORT = Failure("the hanger is too short: it is at 90 degrees to the spindle", "lengthen the hanger")


@dataclass(frozen=True, kw_only=True)
class HartungDimensions(Machine):
    """Dimensions of a Hartung governor. Lengths in m, masses in kg, angles in rad, speeds in rad/s."""

    weight_arm: float = dimension_field("length", "from the fulcrum of a bell crank to its weight's centre")
    sleeve_arm: float = dimension_field("length", "from the fulcrum to the hanger")
    bell_crank_angle: float = dimension_field("angle", "between its two arms, 90 to 180 deg", default=math.pi / 2)
    fulcrum_radius: float = dimension_field("length", "of the fulcrum from the spindle axis")
    fulcrum_height: float | None = optional_field(
        "length", "of the fulcrum above the cross axis; as far below as weight_arm is long, if left out", signed=True
    )
    weight_mass: float = dimension_field("mass", "of one weight; there are two")
    sleeve_mass: float = dimension_field("mass", "of the whole sleeve and its load")
    hanger: float | None = optional_field("length", "of the hangers, from bell crank to sleeve", word="vertical")
    lug_offset: float = dimension_field("length", "of the sleeve's lugs from the axis", default=0.0, signed=True)
    inner_angle: float | None = optional_field("angle", "of the lever at the inner end of the stroke", signed=True)
    outer_angle: float | None = optional_field("angle", "of the lever at the outer end of the stroke", signed=True)
    spring_rate: float | None = optional_field("stiffness", "of each spring")
    spring_preload: float | None = optional_field("force", "of each spring at preload_radius", signed=True)
    preload_radius: float | None = optional_field(
        "length", "of a weight where spring_preload is its spring's force; fulcrum_radius if left out"
    )
    spring_wire: float | None = optional_field("length", "of each spring's wire, its diameter")
    spring_coil: float | None = optional_field("length", "of each spring's coil, its mean diameter")
    spring_turns: float | None = optional_field("number", "of each spring's active turns")
    spring_modulus: float | None = optional_field("modulus", "of shear of the springs' wire", max_size=1e13)
    spring_stress_limit: float | None = optional_field("pressure", "that the springs' wire may bear")
    inner_speed: float | None = optional_field("angular_speed", "that holds the weights at the inner end of the stroke")
    outer_speed: float | None = optional_field("angular_speed", "that holds the weights at the outer end of the stroke")
    insensitivity: float = dimension_field("ratio", "that the regulating force is computed with", default=0.04)

    @property
    def fulcrum_y(self) -> float:
        """Height of the fulcrum above the cross axis, m."""
        return -self.weight_arm if self.fulcrum_height is None else self.fulcrum_height

    @property
    def middle_angle(self) -> float:
        """Lever angle at mid stroke, rad; 0 without a stroke."""
        if self.inner_angle is None or self.outer_angle is None:
            return 0.0
        return 0.5 * (self.inner_angle + self.outer_angle)

    def weight_radius(self, lever_angle: float) -> float:
        """Return the distance of a weight's centre from the axis, m."""
        return self.fulcrum_radius - self.weight_arm * math.sin(lever_angle)

    def hanger_top(self, lever_angle: float) -> Vector2:
        """Return the upper end of the right hanger: distance from the axis and height above the fulcrum, m."""
        sleeve_arm_angle = self.bell_crank_angle + lever_angle
        return self.fulcrum_radius - self.sleeve_arm * math.sin(sleeve_arm_angle), self.sleeve_arm * math.cos(sleeve_arm_angle)

    def lug_height(self, lever_angle: float) -> float:
        """Return the height of the sleeve's lugs above the fulcrum, m; that of the hangers' upper ends for vertical hangers."""
        x, y = self.hanger_top(lever_angle)
        return y if self.hanger is None else y - math.sqrt(self.hanger**2 - (x - self.lug_offset) ** 2)

    def lift_derivative(self, lever_angle: float) -> float:
        """Return the derivative of the sleeve height with respect to the lever angle, m/rad."""
        sleeve_arm_angle, (x, _) = self.bell_crank_angle + lever_angle, self.hanger_top(lever_angle)
        hanger_tangent = 0.0
        if self.hanger is not None:
            reach = x - self.lug_offset
            hanger_tangent = reach / math.sqrt(self.hanger**2 - reach**2)
        return -self.sleeve_arm * (math.sin(sleeve_arm_angle) + math.cos(sleeve_arm_angle) * hanger_tangent)

    def failure_at(self, lever_angle: float) -> Failure | None:
        """Return why the governor does not work at a lever angle (rad), or None if it does."""
        if abs(lever_angle) >= math.pi / 2:
            return ARMS_LEVEL_INNERMOST if lever_angle > 0 else ARMS_LEVEL_OUTERMOST
        if self.weight_radius(lever_angle) <= 0:
            return WEIGHTS_MEET
        if self.hanger is not None and abs(self.hanger_top(lever_angle)[0] - self.lug_offset) >= self.hanger:
            return HANGER_TOO_SHORT
        return LEVER_DEAD_CENTRE if self.lift_derivative(lever_angle) >= 0 else None

    def first_failure(self, outer_angle: float, inner_angle: float) -> tuple[float, Failure] | None:
        """Return the first failing lever angle (rad) of a stroke from outer to inner end and its reason, or None."""
        n_samples = max(round((inner_angle - outer_angle) / (math.pi / 2) * N_TRAVEL_SAMPLES), 1)
        angles = (outer_angle + (inner_angle - outer_angle) * k / n_samples for k in range(n_samples + 1))
        return next(((angle, failure) for angle in angles if (failure := self.failure_at(angle))), None)

    def travel_limit(self) -> Limit:
        """Return the working range of the lever angle around mid stroke."""
        (low, low_message), (high, high_message) = (self._travel_end(side) for side in (-1.0, 1.0))
        return Limit(reading="lever_angle", low=low, high=high, low_message=low_message, high_message=high_message)

    def _travel_end(self, direction: float) -> tuple[float, str]:
        valid_angle = failing_angle = self.middle_angle
        while self.failure_at(failing_angle) is None:
            valid_angle, failing_angle = failing_angle, failing_angle + direction * 0.5 * math.pi / N_TRAVEL_SAMPLES
        while (midpoint := 0.5 * (valid_angle + failing_angle)) not in (valid_angle, failing_angle):
            valid_angle, failing_angle = (midpoint, failing_angle) if self.failure_at(midpoint) is None else (valid_angle, midpoint)
        failure = self.failure_at(failing_angle)
        return valid_angle, failure.sentence if failure else ""

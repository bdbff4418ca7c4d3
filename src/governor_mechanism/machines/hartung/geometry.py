"""Geometry of a Hartung governor: positions of weights, hangers and sleeve over the lever angle, and limits of the travel."""

from __future__ import annotations

import math
from dataclasses import dataclass

N_TRAVEL_SAMPLES = 720
"""Samples per quarter turn to bracket an end of the travel, before bisection."""

ARMS_LEVEL_OUTERMOST = "the weights' arms are horizontal, outermost (dead centre)"
ARMS_LEVEL_INNERMOST = "the weights' arms are horizontal, innermost (dead centre)"
WEIGHTS_MEET = "the weights meet on the spindle axis"
LEVER_DEAD_CENTRE = "the sleeve has a turning point: the lever no longer lifts it"
HANGER_TOO_SHORT = "the hanger is too short: it is at 90 degrees to the spindle"

FAILURE_HINTS = {
    ARMS_LEVEL_OUTERMOST: "keep outer_angle above -90 deg",
    ARMS_LEVEL_INNERMOST: "keep inner_angle below 90 deg",
    WEIGHTS_MEET: "raise fulcrum_radius",
    LEVER_DEAD_CENTRE: "lower bell_crank_angle, lengthen the hanger where it has a length",
    HANGER_TOO_SHORT: "lengthen the hanger",
}
"""Cures by failure."""


@dataclass(frozen=True, kw_only=True)
class LeverGeometry:
    """Dimensions that the geometry depends on (m, rad); hanger is None for vertical hangers."""

    weight_arm: float
    sleeve_arm: float
    bell_crank_angle: float
    fulcrum_radius: float
    hanger: float | None
    lug_offset: float

    def weight_radius(self, lever_angle: float) -> float:
        """Return the distance of a weight's centre from the axis, m."""
        return self.fulcrum_radius - self.weight_arm * math.sin(lever_angle)

    def hanger_top(self, lever_angle: float) -> tuple[float, float]:
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

    def failure_at(self, lever_angle: float) -> str | None:
        """Return why the governor does not work at a lever angle (rad), or None if it does."""
        if abs(lever_angle) >= math.pi / 2:
            return ARMS_LEVEL_INNERMOST if lever_angle > 0 else ARMS_LEVEL_OUTERMOST
        if self.weight_radius(lever_angle) <= 0:
            return WEIGHTS_MEET
        if self.hanger is not None and abs(self.hanger_top(lever_angle)[0] - self.lug_offset) >= self.hanger:
            return HANGER_TOO_SHORT
        return LEVER_DEAD_CENTRE if self.lift_derivative(lever_angle) >= 0 else None

    def first_failure(self, outer_angle: float, inner_angle: float) -> tuple[float, str] | None:
        """Return the first failing lever angle (rad) of a stroke from outer to inner end and its reason, or None."""
        n_samples = max(round((inner_angle - outer_angle) / (math.pi / 2) * N_TRAVEL_SAMPLES), 1)
        for k in range(n_samples + 1):
            lever_angle = outer_angle + (inner_angle - outer_angle) * k / n_samples
            sentence = self.failure_at(lever_angle)
            if sentence is not None:
                return lever_angle, sentence
        return None

    def travel_limits(self, middle_angle: float) -> tuple[float, float, str, str]:
        """Return the lowest and highest working lever angle (rad) around middle_angle, and what happens there."""
        (low, low_message), (high, high_message) = (self._travel_limit(middle_angle, side) for side in (-1.0, 1.0))
        return low, high, low_message, high_message

    def _travel_limit(self, middle_angle: float, direction: float) -> tuple[float, str]:
        valid_angle = failing_angle = middle_angle
        while self.failure_at(failing_angle) is None:
            valid_angle, failing_angle = failing_angle, failing_angle + direction * 0.5 * math.pi / N_TRAVEL_SAMPLES
        while True:
            midpoint = 0.5 * (valid_angle + failing_angle)
            if midpoint in (valid_angle, failing_angle):
                return valid_angle, self.failure_at(failing_angle) or ""
            valid_angle, failing_angle = (midpoint, failing_angle) if self.failure_at(midpoint) is None else (valid_angle, midpoint)

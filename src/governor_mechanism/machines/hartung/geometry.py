"""How weights, hangers and sleeve of a Hartung governor follow its lever angle, and how far they can go."""

from __future__ import annotations

import math
from dataclasses import dataclass

PIECES = 720
"""Into so many a quarter turn is divided where an end of the travel is looked for, before it is halved down to."""

LEVEL_OUT = "the weights' arms lie level, outermost (dead centre)"
LEVEL_IN = "the weights' arms lie level, innermost (dead centre)"
MEET = "the weights meet on the spindle axis"
IN_LINE = "the lever passes its dead centre: it no longer lifts the sleeve"
SHORT = "the hanger is too short: it stands at 90 degrees to the spindle"

CURES = {
    LEVEL_OUT: "keep outer_angle above -90 deg",
    LEVEL_IN: "keep inner_angle below 90 deg",
    MEET: "raise fulcrum_radius",
    IN_LINE: "lower bell_crank_angle, lengthen the hanger where it has a length",
    SHORT: "lengthen the hanger",
}
"""What helps against each of them."""


@dataclass(frozen=True, kw_only=True)
class Way:
    """The dimensions that the way depends on, as of the machine (m, rad); hanger None: always vertical."""

    weight_arm: float
    sleeve_arm: float
    angle: float
    fulcrum_radius: float
    hanger: float | None
    lug_offset: float

    def weight_radius(self, lever: float) -> float:
        """Of a weight's centre from the axis (m)."""
        return self.fulcrum_radius - self.weight_arm * math.sin(lever)

    def foot(self, lever: float) -> tuple[float, float]:
        """Where the hanger's upper end stands on the right: from the axis, and above the fulcrum (m)."""
        turn = self.angle + lever
        return self.fulcrum_radius - self.sleeve_arm * math.sin(turn), self.sleeve_arm * math.cos(turn)

    def lug_height(self, lever: float) -> float:
        """Of the sleeve's lugs above the fulcrum (m); of the hangers' upper ends where hangers are vertical."""
        x, y = self.foot(lever)
        return y if self.hanger is None else y - math.sqrt(self.hanger**2 - (x - self.lug_offset) ** 2)

    def lift_slope(self, lever: float) -> float:
        """Of the sleeve's height over the lever angle (m/rad)."""
        turn, (x, _) = self.angle + lever, self.foot(lever)
        tangent = 0.0
        if self.hanger is not None:
            reach = x - self.lug_offset
            tangent = reach / math.sqrt(self.hanger**2 - reach**2)
        return -self.sleeve_arm * (math.sin(turn) + math.cos(turn) * tangent)

    def failure(self, lever: float) -> str | None:
        """What is wrong at a lever angle (rad); None where the governor works."""
        if abs(lever) >= math.pi / 2:
            return LEVEL_IN if lever > 0 else LEVEL_OUT
        if self.weight_radius(lever) <= 0:
            return MEET
        if self.hanger is not None and abs(self.foot(lever)[0] - self.lug_offset) >= self.hanger:
            return SHORT
        return IN_LINE if self.lift_slope(lever) >= 0 else None

    def first_failure(self, outer: float, inner: float) -> tuple[float, str] | None:
        """The lever angle (rad) within a stroke at which something is wrong first, going in; None where nothing is."""
        pieces = max(round((inner - outer) / (math.pi / 2) * PIECES), 1)
        for k in range(pieces + 1):
            lever = outer + (inner - outer) * k / pieces
            sentence = self.failure(lever)
            if sentence is not None:
                return lever, sentence
        return None

    def travel(self, middle: float) -> tuple[float, float, str, str]:
        """Lowest and highest lever angle (rad) round one where all is well, and what happens there."""
        (low, below), (high, above) = (self._end(middle, side) for side in (-1.0, 1.0))
        return low, high, below, above

    def _end(self, middle: float, side: float) -> tuple[float, str]:
        good = bad = middle
        while self.failure(bad) is None:
            good, bad = bad, bad + side * 0.5 * math.pi / PIECES
        while True:
            half = 0.5 * (good + bad)
            if half in (good, bad):
                return good, self.failure(bad) or ""
            good, bad = (half, bad) if self.failure(half) is None else (good, half)

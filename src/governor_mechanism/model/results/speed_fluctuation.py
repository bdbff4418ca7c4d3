"""Speed fluctuation of a shaft in a turn."""

import math
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class SpeedFluctuation:
    """Extreme speeds of a shaft in the last complete turn of a run.

    Attributes
    ----------
    lowest, highest
        Lowest and highest speed, rad/s.
    lowest_angle, highest_angle
        Angles at which the shaft has them, rad.
    """

    lowest: float
    highest: float
    lowest_angle: float
    highest_angle: float

    @property
    def mean(self) -> float:
        """Arithmetic mean of both speeds, rad/s."""
        return 0.5 * (self.lowest + self.highest)

    @property
    def coefficient(self) -> float:
        """Coefficient of speed fluctuation, (highest - lowest) / mean."""
        return (self.highest - self.lowest) / self.mean

    def __str__(self) -> str:
        low, high = (f"{speed:.6g} rad/s at {math.degrees(angle) % 360:.4g} deg" for speed, angle in self._extremes)
        return f"in the last turn {low} to {high}, coefficient of speed fluctuation {self.coefficient:.5g}"

    @property
    def _extremes(self) -> tuple[tuple[float, float], ...]:
        return (self.lowest, self.lowest_angle), (self.highest, self.highest_angle)

    def as_json(self) -> dict[str, float]:
        """Return the speeds, angles, mean and coefficient by name."""
        names = ("lowest", "highest", "lowest_angle", "highest_angle", "mean", "coefficient")
        return {name: getattr(self, name) for name in names}

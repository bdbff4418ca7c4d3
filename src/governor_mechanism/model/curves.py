"""Curves that a point may be guided on, y = f(x) in axes of their own. Frozen values, no maths."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A curve y = f(x), both in m."""


@dataclass(frozen=True, kw_only=True)
class PolynomialCurve(Curve):
    """y = c0 + c1 x + c2 x^2 + c3 x^3 with coefficients (c0, c1, ...) in m, 1, 1/m, 1/m2; a parabola has three."""

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not 1 <= len(self.coefficients) <= 4:
            raise MechanismError(f"a polynomial curve has one to four coefficients; got {len(self.coefficients)}")
        for value in self.coefficients:
            require_finite(value, "", "coefficient of a curve")


@dataclass(frozen=True, kw_only=True)
class SplineCurve(Curve):
    """A smooth curve (cubic spline) through points: x (m) rising, y (m). It ends at the first and the last point."""

    x: tuple[float, ...]
    y: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y) or len(self.x) < 2:
            raise MechanismError(f"the table of a curve needs two points or more, x and y each; got {len(self.x)} and {len(self.y)}")
        for x, y in zip(self.x, self.y, strict=True):
            require_finite(x, "m", "x of a curve's point")
            require_finite(y, "m", "y of a curve's point")
        for before, after in zip(self.x, self.x[1:], strict=False):
            if after <= before:
                raise MechanismError(f"x of a curve's points must rise; {after:g} m follows {before:g} m")

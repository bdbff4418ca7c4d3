"""Guide curves y = f(x) for points, in their own axes. Frozen values without mathematics."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_rising


@dataclass(frozen=True, kw_only=True)
class Curve:
    """Base class of a curve y = f(x); x and y in m."""


@dataclass(frozen=True, kw_only=True)
class PolynomialCurve(Curve):
    """A polynomial y = c0 + c1 x + c2 x^2 + ... of any degree.

    Attributes
    ----------
    coefficients
        c0, c1, ... in m, 1, 1/m, ...; one or more. A parabola has three.
    """

    coefficients: tuple[float, ...]

    def __post_init__(self) -> None:
        if not self.coefficients:
            raise MechanismError("a polynomial curve needs at least one coefficient; [0] is the x axis")
        for value in self.coefficients:
            require_finite(value, "", "coefficient of a curve")


@dataclass(frozen=True, kw_only=True)
class SplineCurve(Curve):
    """A cubic spline through given points. It ends at the first and at the last point.

    Attributes
    ----------
    x
        Abscissas, m, strictly rising; two or more.
    y
        Ordinates, m; as many as x.
    """

    x: tuple[float, ...]
    y: tuple[float, ...]

    def __post_init__(self) -> None:
        if len(self.x) != len(self.y) or len(self.x) < 2:
            raise MechanismError(f"the table of a curve needs two points or more, x and y each; got {len(self.x)} and {len(self.y)}")
        for x, y in zip(self.x, self.y, strict=True):
            require_finite(x, "m", "x of a curve's point")
            require_finite(y, "m", "y of a curve's point")
        require_rising(self.x, "x of a curve's points", " m")

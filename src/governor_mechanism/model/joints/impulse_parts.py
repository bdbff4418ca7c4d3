"""The constraints of pymunk that make up joints, without pymunk."""

from dataclasses import dataclass

from governor_mechanism.model.curves import Curve


@dataclass(frozen=True)
class ImpulsePart:
    """Base class of a constraint between the points or angles of two bodies."""


@dataclass(frozen=True)
class Pivot(ImpulsePart):
    """Both points coincide."""


@dataclass(frozen=True)
class FixedDistance(ImpulsePart):
    """The points keep a distance, m."""

    distance: float


@dataclass(frozen=True)
class FixedAngle(ImpulsePart):
    """The bodies keep a relative angle, rad."""

    angle: float


@dataclass(frozen=True)
class AngleRatio(ImpulsePart):
    """The angle of the second body is ratio times that of the first, plus an offset (rad)."""

    ratio: float
    offset: float


@dataclass(frozen=True)
class Guide(ImpulsePart):
    """The second point stays on a line of the first body at an angle (rad), or on an open or closed curve in axes at that angle."""

    angle: float
    curve: Curve | None = None


@dataclass(frozen=True)
class DrivenOffset(ImpulsePart):
    """The second point has a prescribed distance from a line of the first body at an angle (rad)."""

    angle: float


@dataclass(frozen=True)
class DrivenAngle(ImpulsePart):
    """The bodies have a prescribed relative angle."""

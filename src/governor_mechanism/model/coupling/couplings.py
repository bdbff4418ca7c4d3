"""Couplings between parts of a scene. Frozen values without mathematics."""

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_not_negative
from governor_mechanism.model.time_functions import ReadingFunction


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """Base class of a coupling between parts.

    Attributes
    ----------
    name
        Name in messages and results.
    """

    name: str


@dataclass(frozen=True, kw_only=True)
class RatioCoupling(Coupling):
    """A coupling that makes the second angle turn with ratio times the speed of the first.

    Attributes
    ----------
    first, second
        Readings, angles of bodies or spindles, as "engine.crank_angle" and "governor.spindle_angle".
    ratio
        Ratio of the second speed to the first; negative for the opposite sense of rotation, not 0.
    """

    first: str
    second: str
    ratio: float = 1.0

    def __post_init__(self) -> None:
        require_finite(self.ratio, "", f"ratio of coupling {self.name!r}")
        if self.ratio == 0.0:
            raise MechanismError(f"ratio of coupling {self.name!r} must not be 0; leave the coupling out")
        if self.first == self.second:
            raise MechanismError(f"coupling {self.name!r} couples {self.first!r} to itself; it needs two different angles")


@dataclass(frozen=True, kw_only=True)
class GearCoupling(RatioCoupling):
    """A gear or belt: it transmits a torque, which is the force of the joint of this name.

    Attributes
    ----------
    until
        Time at which the belt breaks, s; None if it never does.
    """

    until: float | None = None

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.until is not None:
            require_not_negative(self.until, "s", f"until of coupling {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class FollowCoupling(RatioCoupling):
    """A spindle that follows the first angle without reaction: the first part feels no torque."""


@dataclass(frozen=True, kw_only=True)
class ControlCoupling(Coupling):
    """A load that follows a reading.

    Attributes
    ----------
    function
        The function of the reading.
    target
        Name of the load: a torque or force of a part, the torque on a spindle, or a dry friction.
    scales
        Whether the load is multiplied by the function, as by a throttle; otherwise the function is added to it.
    """

    function: ReadingFunction
    target: str
    scales: bool = False

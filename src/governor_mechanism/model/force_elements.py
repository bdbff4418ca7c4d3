"""What acts on a mechanism's bodies beside gravity and the spindle's turning. Frozen values; laws in `equations`."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.time_functions import InputFunction


@dataclass(frozen=True, kw_only=True)
class ForceElement:
    """Something that pushes or turns bodies; `name` is what messages and results call it."""

    name: str

    @property
    def bodies(self) -> tuple[str, str]:
        """The two bodies it acts between."""
        raise NotImplementedError


@dataclass(frozen=True, kw_only=True)
class _PointToPointElement(ForceElement):
    """A load along the line between two points, the same on both and opposite."""

    first: Point
    second: Point

    @property
    def bodies(self) -> tuple[str, str]:
        return self.first.body, self.second.body

    def __post_init__(self) -> None:
        _require_distinct_bodies(self)


@dataclass(frozen=True, kw_only=True)
class Spring(_PointToPointElement):
    """Pulls its points together with stiffness (N/m) * (distance - free_length (m)); pushes where it is shorter."""

    stiffness: float
    free_length: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.stiffness, "N/m", f"stiffness of spring {self.name!r}")
        require_finite(self.free_length, "m", f"free length of spring {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Damper(_PointToPointElement):
    """Resists the change of its points' distance with damping (N s/m) * rate."""

    damping: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.damping, "N s/m", f"damping of damper {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class _RotationalElement(ForceElement):
    """A moment on the second body about the first, and the opposite one on the first."""

    second: str
    first: str = GROUND

    @property
    def bodies(self) -> tuple[str, str]:
        return self.first, self.second

    def __post_init__(self) -> None:
        _require_distinct_bodies(self)


@dataclass(frozen=True, kw_only=True)
class TorsionSpring(_RotationalElement):
    """Turns the second body back to free_angle (rad) against the first, with stiffness (N m/rad)."""

    stiffness: float
    free_angle: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.stiffness, "N m/rad", f"stiffness of torsion spring {self.name!r}")
        require_finite(self.free_angle, "rad", f"free angle of torsion spring {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class TorsionDamper(_RotationalElement):
    """Resists the turning of the second body against the first with damping (N m s/rad) * rate."""

    damping: float

    def __post_init__(self) -> None:
        super().__post_init__()
        require_positive(self.damping, "N m s/rad", f"damping of torsion damper {self.name!r}")


@dataclass(frozen=True, kw_only=True)
class Torque(_RotationalElement):
    """A given moment (N m, anticlockwise) on the second body; the first takes the opposite one."""

    moment: InputFunction


@dataclass(frozen=True, kw_only=True)
class Force(ForceElement):
    """A given force (N) at a point of a body, by its parts along the plane's x and y; it keeps its direction."""

    point: Point
    x: InputFunction
    y: InputFunction

    @property
    def bodies(self) -> tuple[str, str]:
        return GROUND, self.point.body

    def __post_init__(self) -> None:
        _require_distinct_bodies(self)


def _require_distinct_bodies(element: ForceElement) -> None:
    first, second = element.bodies
    if first == second:
        raise MechanismError(f"load {element.name!r} acts between body {first!r} and itself; it needs two different bodies")

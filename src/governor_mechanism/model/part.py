"""A part of a scene: a mechanism in its plane, with its effects, spindle, start and laws. Frozen values without mathematics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from governor_mechanism.errors import MechanismError, require_positive
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.units.fields import entry, optional_size, quantity, require_valid_fields
from governor_mechanism.units.quantities import require_plausible
from governor_mechanism.units.text_table import short_repr

if TYPE_CHECKING:
    from governor_mechanism.units.expressions import Expression, Measured


FAMILIES: Final = ("straight-lines", "curves", "walkers", "drives", "gears", "governors", "valve-gears")
"""Families of classic mechanisms."""


@dataclass(frozen=True, kw_only=True)
class LawEquation:
    """Two expressions of readings and dimensions that are equal at every position."""

    # value, equals: the expressions
    value: Expression
    equals: Expression
    within: float  # largest difference, SI
    unit: str  # SI unit of the difference; empty for a plain number

    def __str__(self) -> str:
        return f"{self.value.text} = {self.equals.text}"


@dataclass(frozen=True, kw_only=True)
class Law:
    """What a scene of a classic mechanism proves, as the table [law] of its file states it."""

    statement: str = entry("label", meaning="the law in words")  # the law in words
    # where the mechanism, its dimensions and the law are from
    source: str = entry("label", default="", meaning="where the mechanism, its dimensions and the law are from")
    # one of FAMILIES; empty outside the catalogue
    family: str = entry("choice", words=FAMILIES, default="", meaning="family in the catalogue")
    # reading that drives the mechanism through its travel, or "time" for its drivers
    over: str = entry("reading", meaning="the reading that drives the mechanism through its travel, or time for its drivers")
    # the travel: first and last value of that reading, SI
    between: tuple[float, float] = entry("travel", meaning='the travel, as ["-40 deg", "40 deg"]')
    # number of positions at which the equations are checked
    positions: int = entry("count", default=181, meaning="number of positions at which the equations are checked, 2 to 10000")
    # the equations
    equations: tuple[LawEquation, ...] = entry(
        "equations", key="proves", meaning='the equations, as [{ value = "pen_x", equals = "2 * crank", within = "1e-12 m" }]'
    )
    # dimensions under which the law still holds when they change
    holds_under: tuple[str, ...] = entry("names", default=(), meaning="dimensions that may change without breaking the law")
    # dimensions whose change breaks it
    broken_by: tuple[str, ...] = entry("names", default=(), meaning="dimensions whose change breaks the law")
    dimensions: Mapping[str, Measured] = field(default_factory=dict)  # the dimensions of the scene by name


EQUILIBRIUM: Final = "equilibrium"
"""Start value that stands for the stable equilibrium at the first spindle speed."""

TURNING_PLANE: Final = "turning"
"""Name of a plane that turns with the spindle."""
FIXED_PLANE: Final = "fixed"
"""Name of a plane that does not turn."""


@dataclass(frozen=True, kw_only=True)
class Spindle:
    """A spindle with a given speed, smooth between points of time and constant before the first and after the last point.

    One point is a constant speed; two points at one time are a step.

    Attributes
    ----------
    times
        Points of time, s.
    speeds
        Speeds at these times, rad/s.
    speed_fluctuation
        Coefficient of fluctuation of speed, (highest - lowest) / mean, at least 0 and below 1. The fluctuation is a sine of the
        angle that the mean speed has turned.
    cycles_per_turn
        Cycles of the fluctuation per turn of the spindle.
    turned_angle
        Angle that the mean speed has turned at 0 s, rad; not 0 for a run that goes on from a state.
    """

    times: tuple[float, ...] = (0.0,)
    speeds: tuple[float, ...] = (0.0,)
    speed_fluctuation: float = quantity(
        "ratio",
        limits=(0, 1),
        open_ends="high",
        reason=": it is (highest - lowest) / mean speed",
        default=0.0,
        meaning="the coefficient of fluctuation of the speed, (highest - lowest) / mean, for a cyclic variation",
    )
    cycles_per_turn: float = quantity("number", default=1.0, meaning="the number of fluctuations in a turn")
    turned_angle: float = 0.0

    def __post_init__(self) -> None:
        if not 0 <= self.speed_fluctuation < 1:
            what = "speed fluctuation of the spindle, (highest - lowest) / mean speed"
            raise MechanismError(f"{what}, must be at least 0 and below 1; got {self.speed_fluctuation:g}")
        require_positive(self.cycles_per_turn, "", "cycles per turn of the spindle's speed fluctuation")
        InputFunction(times=self.times, values=self.speeds)  # raises for wrong times and speeds
        for speed in self.speeds:
            require_plausible(speed, "angular_speed", "speed of the spindle")

    @property
    def speed_function(self) -> InputFunction:
        """Mean speed over time, rad/s."""
        return InputFunction(times=self.times, values=self.speeds, integral_before=self.turned_angle)


@dataclass(frozen=True, kw_only=True)
class FreeSpindle:
    """A spindle that turns under a torque, the reaction of the mechanism and, if it is coupled, the other parts.

    Attributes
    ----------
    inertia
        Moment of inertia of the spindle alone, kg m2; at least 0.
    start_speed
        Speed at the start, rad/s; None if it follows from a coupling or from the equilibrium of the whole scene.
    torque
        Torque on the spindle, N m.
    """

    inertia: float = optional_size("moment_of_inertia", meaning="the moment of inertia of the spindle alone, without the governor")
    start_speed: float | None = quantity("angular_speed", sign="any", default=None, meaning="the speed at which a free spindle starts")
    torque: InputFunction = entry(
        "load", "torque", sign="any", default=InputFunction(), meaning="the torque on the spindle; none by default"
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, "the spindle")
        if self.start_speed is not None:
            require_plausible(self.start_speed, "angular_speed", "start speed of the spindle")


@dataclass(frozen=True, kw_only=True)
class Start:
    """Start values and start rates of readings. The initial guess of the mechanism settles the rest.

    Attributes
    ----------
    values
        Start values by reading name, SI, or EQUILIBRIUM.
    rates
        Start rates by reading name, SI/s.
    """

    values: Mapping[str, float | str] = field(default_factory=dict)
    rates: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, rate in self.rates.items():
            require_plausible(rate, "angular_rate", f"start rate of {name!r}")  # that of a length has the same bound


@dataclass(frozen=True, kw_only=True)
class Part:
    """A mechanism in its plane, with the effects on it, its spindle and its start.

    Attributes
    ----------
    name
        Name of the part.
    machine
        Name of the machine in scene files.
    dimensions
        Dimensions of the machine by name, SI.
    mechanism
        The mechanism built from them.
    plane
        TURNING_PLANE or FIXED_PLANE.
    effects
        Physical effects, each at most once, or once per reading.
    spindle
        Spindle with a given speed, or a free or coupled one; at rest in a fixed plane.
    start
        Start values and rates.
    law
        What the mechanism proves; None if its file states no law.
    """

    name: str
    machine: str
    dimensions: Mapping[str, float]
    mechanism: Mechanism
    plane: str = TURNING_PLANE
    effects: tuple[Effect, ...] = ()
    spindle: Spindle | FreeSpindle = field(default_factory=Spindle)
    start: Start = field(default_factory=Start)
    law: Law | None = None

    __repr__ = short_repr

    def __post_init__(self) -> None:
        counts = Counter((type(effect).__name__, getattr(effect, "reading", "")) for effect in self.effects)
        for (kind, reading), count in counts.items():
            if count > 1:
                raise MechanismError(f"effect {kind}{f' on {reading!r}' if reading else ''} is listed twice; list it once")
        is_free = isinstance(self.spindle, FreeSpindle)
        if is_free and self.plane != TURNING_PLANE:
            reason = "a free spindle needs a mechanism that turns with it, and this one is in a fixed plane"
            raise MechanismError(f'{reason}; write plane = "turning", or leave the spindle out')
        if is_free and not self.has_centrifugal:
            raise MechanismError("a free spindle reacts to the bodies that turn with it; list effects.centrifugal, or give spindle.speed")
        for effect in self.output_effects:
            self.mechanism.reading(effect.reading)  # raises for an unknown reading

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Effects along readings; a clearance counts as its stops."""
        return tuple(part for effect in self.effects for part in effect.output_effects)

    @property
    def gravity(self) -> float:
        """Gravitational acceleration along -y, m/s2; 0 without the effect gravity."""
        return sum((effect.gravity for effect in self.effects), 0.0)

    @property
    def has_centrifugal(self) -> bool:
        """Whether bodies in a turning plane carry a centrifugal load."""
        return any(effect.loads_turning_bodies for effect in self.effects)

    @property
    def turns(self) -> bool:
        """Whether the plane of the part turns with a spindle."""
        return self.plane == TURNING_PLANE

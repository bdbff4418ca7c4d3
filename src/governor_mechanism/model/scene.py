"""A scene: parts, couplings, effects, spindle, start and run settings. Frozen values without mathematics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction

EQUILIBRIUM: Final = "equilibrium"
"""Start value that stands for the stable equilibrium at the first spindle speed."""

TURNING_PLANE: Final = "turning"
"""Name of a plane that turns with the spindle."""
FIXED_PLANE: Final = "fixed"
"""Name of a plane that does not turn."""


MAX_SPINDLE_SPEED: Final = 1e6
"""Largest spindle speed, rad/s: no machine turns faster; a larger value is a mistake of units."""
MAX_DURATION: Final = 1e9
"""Largest duration, s: no run lasts longer; a larger value is a mistake of units."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A mechanism in its plane.

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
    """

    name: str
    machine: str
    dimensions: Mapping[str, float]
    mechanism: Mechanism
    plane: str = TURNING_PLANE


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """A coupling between a reading of one part and a coordinate, parameter or force of another."""

    source: str
    target: str
    ratio: float = 1.0


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
    """

    times: tuple[float, ...] = (0.0,)
    speeds: tuple[float, ...] = (0.0,)
    speed_fluctuation: float = 0.0
    cycles_per_turn: float = 1.0

    def __post_init__(self) -> None:
        if not 0 <= self.speed_fluctuation < 1:
            raise MechanismError(
                f"speed fluctuation of the spindle, (highest - lowest) / mean speed, must be at least 0 and below 1; "
                f"got {self.speed_fluctuation:g}"
            )
        require_positive(self.cycles_per_turn, "", "cycles per turn of the spindle's speed fluctuation")
        InputFunction(times=self.times, values=self.speeds)  # validates times and speeds
        for speed in self.speeds:
            _require_plausible_speed(speed)

    @property
    def speed_function(self) -> InputFunction:
        """Mean speed over time, rad/s."""
        return InputFunction(times=self.times, values=self.speeds)


@dataclass(frozen=True, kw_only=True)
class FreeSpindle:
    """A spindle that turns freely under a torque and the reaction of the mechanism.

    Attributes
    ----------
    inertia
        Moment of inertia of the spindle alone, kg m2; at least 0.
    start_speed
        Speed at the start, rad/s.
    torque
        Torque on the spindle over time, N m.
    """

    inertia: float
    start_speed: float
    torque: InputFunction = field(default_factory=InputFunction)

    def __post_init__(self) -> None:
        require_finite(self.inertia, "kg m2", "inertia of the spindle")
        if self.inertia < 0:
            raise MechanismError(f"inertia of the spindle must not be negative; got {self.inertia:g} kg m2")
        require_finite(self.start_speed, "rad/s", "start speed of the spindle")
        _require_plausible_speed(self.start_speed)


def _require_plausible_speed(speed: float) -> None:
    if abs(speed) > MAX_SPINDLE_SPEED:
        raise MechanismError(f"speed of the spindle must be at most {MAX_SPINDLE_SPEED:g} rad/s; got {speed:g} rad/s")


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


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """Settings of a run.

    Attributes
    ----------
    duration
        Duration, s.
    output_interval
        Interval of the reported times, s; at most the duration.
    accuracy
        Largest error, relative to the scale of each reading; below 1.
    engine
        Name of the engine, or "auto".
    """

    duration: float = 10.0
    output_interval: float = 0.01
    accuracy: float = 1e-6
    engine: str = "auto"

    def __post_init__(self) -> None:
        require_positive(self.duration, "s", "duration of the run")
        require_positive(self.output_interval, "s", "reporting interval `output_interval`")
        require_positive(self.accuracy, "", "accuracy")
        if self.duration > MAX_DURATION:
            raise MechanismError(f"duration of the run must be at most {MAX_DURATION:g} s; got {self.duration:g} s")
        if self.output_interval > self.duration:
            raise MechanismError(f"`output_interval` ({self.output_interval:g} s) must not exceed `duration` ({self.duration:g} s)")
        if self.accuracy >= 1:
            raise MechanismError(f"accuracy must be below 1 (it is relative to each reading's scale); got {self.accuracy:g}")


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Complete description of a simulation.

    Attributes
    ----------
    title
        Title.
    parts
        Mechanisms; at least one.
    effects
        Physical effects, each at most once, or once per reading.
    spindle
        Given or free spindle.
    start
        Start values and rates.
    run
        Settings of the run.
    couplings
        Couplings between parts.
    crossings
        Named crossings that the events of a run list; names differ.
    source
        Path or name of the scene file; empty for a scene without one.
    document
        Scene file as a dictionary.
    """

    title: str
    parts: tuple[Part, ...]
    effects: tuple[Effect, ...]
    spindle: Spindle | FreeSpindle
    start: Start
    run: RunSettings = field(default_factory=RunSettings)
    couplings: tuple[Coupling, ...] = ()
    crossings: tuple[NamedCrossing, ...] = ()
    source: str = ""
    document: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kinds = [(type(effect), getattr(effect, "reading", "")) for effect in self.effects]
        for kind, reading in kinds:
            if kinds.count((kind, reading)) > 1:
                location = f" on {reading!r}" if reading else ""
                raise MechanismError(f"effect {kind.__name__}{location} is listed twice; list it once")
        if not self.parts:
            raise MechanismError("a scene needs at least one part")
        has_turning_part = any(part.plane == TURNING_PLANE for part in self.parts)
        if isinstance(self.spindle, FreeSpindle) and not has_turning_part:
            raise MechanismError(
                "a free spindle needs a mechanism that turns with it, and this one is in a fixed plane; "
                'write plane = "turning", or leave the spindle out'
            )
        if isinstance(self.spindle, FreeSpindle) and has_turning_part and not self.has_centrifugal:
            raise MechanismError("a free spindle reacts to the bodies that turn with it; list effects.centrifugal, or give spindle.speed")

        names = [crossing.name for crossing in self.crossings]
        if repeated := [name for name in names if names.count(name) > 1]:
            raise MechanismError(f"crossing {repeated[0]!r} is listed twice; names of events must differ")
        for reading in [item.reading for item in self.output_effects] + [item.reading for item in self.crossings]:
            self.part.mechanism.reading(reading)  # raises for an unknown reading

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """Effects along readings; a clearance counts as its stops."""
        return tuple(part for effect in self.effects for part in effect.output_effects)

    @property
    def part(self) -> Part:
        """The only part. Raise MechanismError if there are several."""
        if len(self.parts) != 1:
            raise MechanismError(f"a scene of one part is needed; this scene has {[part.name for part in self.parts]}")
        return self.parts[0]

    @property
    def gravity(self) -> float:
        """Gravitational acceleration along -y, m/s2; 0 without the effect gravity."""
        return sum((effect.gravity for effect in self.effects), 0.0)

    @property
    def has_centrifugal(self) -> bool:
        """Whether bodies in a turning plane carry a centrifugal load."""
        return any(effect.loads_turning_bodies for effect in self.effects)

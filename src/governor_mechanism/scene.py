"""A scene: parts, couplings, effects, the spindle, the start, how long to run. Frozen values, no maths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.effects import Centrifugal, Effect, Gravity
from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.mechanism import Mechanism

EQUILIBRIUM: Final = "equilibrium"
"""A start value that means: where the mechanism stands still at the first spindle speed."""

TURNING: Final = "turning"
FIXED: Final = "fixed"


FASTEST: Final = 1e6
LONGEST: Final = 1e9
"""rad/s and s: more than any machine turns and any run lasts; beyond them lies a slip of units."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One mechanism in one plane: 'turning' with the spindle, or 'fixed'. `dimensions` are its numbers in SI."""

    name: str
    machine: str
    dimensions: Mapping[str, float]
    mechanism: Mechanism
    plane: str = TURNING


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """Ties a reading of one part to a coordinate, parameter or load of another."""

    source: str
    target: str
    ratio: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Spindle:
    """The spindle's given speed: `times` (s) and `speeds` (rad/s) of a program, smooth between points.

    One point is a constant speed. Two points at one time are a step. Before the first and after the last point the
    speed is held.
    """

    times: tuple[float, ...] = (0.0,)
    speeds: tuple[float, ...] = (0.0,)

    def __post_init__(self) -> None:
        if not self.times or len(self.times) != len(self.speeds):
            raise MechanismError(
                f"a speed program needs as many times as speeds; got {len(self.times)} and {len(self.speeds)}"
            )
        for time, speed in zip(self.times, self.speeds, strict=True):
            require_finite(time, "s", "time of the spindle's speed program")
            require_finite(speed, "rad/s", "speed of the spindle")
            if abs(speed) > FASTEST:
                raise MechanismError(f"speed of the spindle must be at most {FASTEST:g} rad/s; got {speed:g} rad/s")
        for before, after in zip(self.times, self.times[1:], strict=False):
            if after < before:
                raise MechanismError(
                    f"times of the spindle's speed program must not fall; {after:g} s follows {before:g} s"
                )
        for first, _, third in zip(self.times, self.times[1:], self.times[2:], strict=False):
            if first == third:
                raise MechanismError(
                    f"three points of the spindle's speed program stand at {first:g} s; a step takes two"
                )

    @property
    def constant(self) -> bool:
        """True when the speed never changes."""
        return len(set(self.speeds)) == 1


@dataclass(frozen=True, kw_only=True)
class Start:
    """Start value (a number, or EQUILIBRIUM) and rate of each part's coordinate, by reading name."""

    values: Mapping[str, float | str]
    rates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """How long to run (s), how often to report (s), how accurate (relative to each reading's scale), which engine."""

    duration: float = 10.0
    every: float = 0.01
    accuracy: float = 1e-6
    engine: str = "auto"

    def __post_init__(self) -> None:
        require_positive(self.duration, "s", "duration of the run")
        require_positive(self.every, "s", "reporting interval `every`")
        require_positive(self.accuracy, "", "accuracy")
        if self.duration > LONGEST:
            raise MechanismError(f"duration of the run must be at most {LONGEST:g} s; got {self.duration:g} s")
        if self.every > self.duration:
            raise MechanismError(f"`every` ({self.every:g} s) must not exceed `duration` ({self.duration:g} s)")
        if self.accuracy >= 1:
            raise MechanismError(
                f"accuracy must be below 1 (it is relative to each reading's scale); got {self.accuracy:g}"
            )


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Everything a run needs. `document` is the scene file as read, `source` its path or name."""

    title: str
    parts: tuple[Part, ...]
    effects: tuple[Effect, ...]
    spindle: Spindle
    start: Start
    run: RunSettings = field(default_factory=RunSettings)
    couplings: tuple[Coupling, ...] = ()
    source: str = ""
    document: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kinds = [type(effect) for effect in self.effects]
        for kind in kinds:
            if kinds.count(kind) > 1:
                raise MechanismError(f"effect {kind.__name__} stands twice; list it once")
        if not self.parts:
            raise MechanismError("a scene needs at least one part")

    @property
    def part(self) -> Part:
        """The only part; refuses a scene of several."""
        if len(self.parts) != 1:
            raise MechanismError(f"this needs a scene of one part; the scene has {[part.name for part in self.parts]}")
        return self.parts[0]

    @property
    def gravity(self) -> float:
        """m/s2; 0 where the scene lists no gravity."""
        return next((effect.acceleration for effect in self.effects if isinstance(effect, Gravity)), 0.0)

    @property
    def centrifugal(self) -> bool:
        """Whether the spindle's turning loads the bodies."""
        return any(isinstance(effect, Centrifugal) for effect in self.effects)

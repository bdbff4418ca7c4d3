"""A scene: parts, couplings, effects, the spindle, the start, how long to run. Frozen values, no maths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.effect import Effect, OnReading
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import Program

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
    speed is held. unevenness: the speed swings about the program by this part of it from lowest to highest, as a sine
    of the angle that the program has turned, `waves` times a turn.
    """

    times: tuple[float, ...] = (0.0,)
    speeds: tuple[float, ...] = (0.0,)
    unevenness: float = 0.0
    waves: float = 1.0

    def __post_init__(self) -> None:
        if not 0 <= self.unevenness < 1:
            raise MechanismError(
                f"unevenness of the spindle, (highest - lowest) / mean speed, must be at least 0 and below 1; "
                f"got {self.unevenness:g}"
            )
        require_positive(self.waves, "", "waves of the spindle's unevenness in a turn")
        Program(times=self.times, values=self.speeds)  # refuses what is no program
        for speed in self.speeds:
            _require_possible(speed)

    @property
    def program(self) -> Program:
        """The speed as a program (rad/s)."""
        return Program(times=self.times, values=self.speeds)


@dataclass(frozen=True, kw_only=True)
class FreeSpindle:
    """A spindle left to itself: its own moment of inertia (kg m2), start speed (rad/s), and torque on it (N m).

    What the mechanism's bodies take up in turning it loses.
    """

    inertia: float
    start_speed: float
    torque: Program = field(default_factory=Program)

    def __post_init__(self) -> None:
        require_finite(self.inertia, "kg m2", "inertia of the spindle")
        if self.inertia < 0:
            raise MechanismError(f"inertia of the spindle must not be negative; got {self.inertia:g} kg m2")
        require_finite(self.start_speed, "rad/s", "start speed of the spindle")
        _require_possible(self.start_speed)


def _require_possible(speed: float) -> None:
    if abs(speed) > FASTEST:
        raise MechanismError(f"speed of the spindle must be at most {FASTEST:g} rad/s; got {speed:g} rad/s")


@dataclass(frozen=True, kw_only=True)
class Start:
    """Start values (numbers, or EQUILIBRIUM) and rates, by reading name; what they leave open the sketch says."""

    values: Mapping[str, float | str] = field(default_factory=dict)
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
    spindle: Spindle | FreeSpindle
    start: Start
    run: RunSettings = field(default_factory=RunSettings)
    couplings: tuple[Coupling, ...] = ()
    source: str = ""
    document: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        kinds = [(type(effect), getattr(effect, "reading", "")) for effect in self.effects]
        for kind, reading in kinds:
            if kinds.count((kind, reading)) > 1:
                on = f" on {reading!r}" if reading else ""
                raise MechanismError(f"effect {kind.__name__}{on} stands twice; list it once")
        if not self.parts:
            raise MechanismError("a scene needs at least one part")
        turning = any(part.plane == TURNING for part in self.parts)
        if isinstance(self.spindle, FreeSpindle) and not turning:
            raise MechanismError(
                "a free spindle needs a mechanism that turns with it, and this one lives in a fixed plane; "
                'write plane = "turning", or leave the spindle out'
            )
        if isinstance(self.spindle, FreeSpindle) and turning and not self.centrifugal:
            raise MechanismError(
                "a free spindle is slowed by what turns with it; list effects.centrifugal, or give spindle.speed"
            )

        for effect in self.acting:
            self.part.mechanism.reading(effect.reading)  # refuses one that does not exist

    @property
    def acting(self) -> tuple[OnReading, ...]:
        """The effects that act along readings, play as the stops it amounts to."""
        return tuple(acting for effect in self.effects for acting in effect.acting)

    @property
    def part(self) -> Part:
        """The only part; refuses a scene of several."""
        if len(self.parts) != 1:
            raise MechanismError(f"this needs a scene of one part; the scene has {[part.name for part in self.parts]}")
        return self.parts[0]

    @property
    def gravity(self) -> float:
        """m/s2; 0 where the scene lists no gravity."""
        return sum((effect.gravity for effect in self.effects), 0.0)

    @property
    def centrifugal(self) -> bool:
        """Whether the spindle's turning loads the bodies."""
        return any(effect.loads_turning_bodies for effect in self.effects)

"""A scene: parts, couplings, effects, the spindle, the start, how long to run. Frozen values, no maths."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from governor_mechanism.errors import MechanismError, require_finite, require_positive
from governor_mechanism.model.effect import Effect, OutputEffect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction

EQUILIBRIUM: Final = "equilibrium"
"""A start value that means: where the mechanism stands still at the first spindle speed."""

TURNING_PLANE: Final = "turning"
FIXED_PLANE: Final = "fixed"


MAX_SPINDLE_SPEED: Final = 1e6
MAX_DURATION: Final = 1e9
"""rad/s and s: more than any machine turns and any run lasts; beyond them lies a slip of units."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """One mechanism in one plane: 'turning' with the spindle, or 'fixed'. `dimensions` are its numbers in SI."""

    name: str
    machine: str
    dimensions: Mapping[str, float]
    mechanism: Mechanism
    plane: str = TURNING_PLANE


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
    speed is held. speed fluctuation: the speed swings about the program by this part of it from lowest to highest, as a sine
    of the angle that the program has turned, `cycles_per_turn` times a turn.
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
        require_positive(self.cycles_per_turn, "", "waves of the spindle's speed fluctuation in a turn")
        InputFunction(times=self.times, values=self.speeds)  # refuses what is no program
        for speed in self.speeds:
            _require_plausible_speed(speed)

    @property
    def speed_function(self) -> InputFunction:
        """The speed as a program (rad/s)."""
        return InputFunction(times=self.times, values=self.speeds)


@dataclass(frozen=True, kw_only=True)
class FreeSpindle:
    """A spindle left to itself: its own moment of inertia (kg m2), start speed (rad/s), and torque on it (N m).

    What the mechanism's bodies take up in turning it loses.
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
    """Start values (numbers, or EQUILIBRIUM) and rates, by reading name; what they leave open the sketch says."""

    values: Mapping[str, float | str] = field(default_factory=dict)
    rates: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class RunSettings:
    """How long to run (s), how often to report (s), how accurate (relative to each reading's scale), which engine."""

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
                location = f" on {reading!r}" if reading else ""
                raise MechanismError(f"effect {kind.__name__}{location} stands twice; list it once")
        if not self.parts:
            raise MechanismError("a scene needs at least one part")
        has_turning_part = any(part.plane == TURNING_PLANE for part in self.parts)
        if isinstance(self.spindle, FreeSpindle) and not has_turning_part:
            raise MechanismError(
                "a free spindle needs a mechanism that turns with it, and this one lives in a fixed plane; "
                'write plane = "turning", or leave the spindle out'
            )
        if isinstance(self.spindle, FreeSpindle) and has_turning_part and not self.has_centrifugal:
            raise MechanismError("a free spindle is slowed by what turns with it; list effects.centrifugal, or give spindle.speed")

        for effect in self.output_effects:
            self.part.mechanism.reading(effect.reading)  # refuses one that does not exist

    @property
    def output_effects(self) -> tuple[OutputEffect, ...]:
        """The effects that act along readings, play as the stops it amounts to."""
        return tuple(acting for effect in self.effects for acting in effect.output_effects)

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
    def has_centrifugal(self) -> bool:
        """Whether the spindle's turning loads the bodies."""
        return any(effect.loads_turning_bodies for effect in self.effects)

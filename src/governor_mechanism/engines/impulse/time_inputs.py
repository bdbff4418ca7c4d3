"""What happens in time during a march: the spindle's speed, given or free, programs of loads, ways of drives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.impulse.pymunk import Moment
from governor_mechanism.mechanics.dynamics.contacts import keepers_of
from governor_mechanism.mechanics.dynamics.force_laws import free_spindle_speed
from governor_mechanism.mechanics.kinematics.time_functions import SpeedProgram, TimeCurve
from governor_mechanism.model.force_elements import Force, Load, Torque
from governor_mechanism.model.joints import DrivenSlide, DrivenTurn
from governor_mechanism.model.scene import FreeSpindle, Scene
from governor_mechanism.model.time_functions import Program
from governor_mechanism.types import FloatArray

Inertia = Callable[[float], float]


class Clock:
    """The moments of a march, interval by interval; work (J) and angle (rad) of the spindle as far as it has come.

    closing: an interval ends with a kick of its own length and of what held before a jump there, to be restarted after.
    """

    def __init__(self, scene: Scene) -> None:
        mechanism, spindle = scene.part.mechanism, scene.spindle
        self._speed = SpeedProgram(spindle)
        self._free = spindle if isinstance(spindle, FreeSpindle) else None
        self._torque = TimeCurve(self._free.torque) if self._free else None
        self._own = self._free.inertia if self._free else 0.0
        self._loads = [TimeCurve(program) for load in mechanism.loads for program in _programs(load)]
        drives = [joint for joint in mechanism.joints if isinstance(joint, DrivenTurn | DrivenSlide)]
        self._drives = [TimeCurve(joint.motion) for joint in drives]
        self._frictions = [TimeCurve(keeper.friction or Program()) for keeper in keepers_of(scene)]
        self._varying = not self._speed.constant
        self._steady = self._speed.start_speed**2
        self.closing = False

    @property
    def breaks(self) -> FloatArray:
        """Times (s) at which something jumps or has a kink; steps must end there."""
        curves = [self._speed, *self._loads, *self._drives, *self._frictions]
        curves += [self._torque] if self._torque else []
        return np.unique(np.concatenate([curve.breaks for curve in curves]))

    def follow(self, inertia: Inertia) -> None:
        """Begin a march; inertia(ahead) is what turns with the spindle (kg m2), so many seconds from now."""
        self._inertia = inertia
        self.jumps, self.work, self.angle = False, 0.0, 0.0
        self._here = inertia(0.0) if self._varying or self._free else 0.0
        self._turning = self._speed.start_speed
        self._momentum = (self._own + self._here) * self._turning

    def first(self, h: float) -> Moment:
        """The moment of the start, before a first step of h seconds."""
        still = np.zeros(1)
        return Moment(
            h=0.5 * h,
            following=h,
            square=self._steady,
            programs=tuple(float(curve(still)[0]) for curve in self._loads),
            motions=tuple(float(curve(still + h)[0]) for curve in self._drives),
            frictions=tuple(float(curve(still)[0]) for curve in self._frictions),
        )

    def again(self, time: float, h: float) -> Moment:
        """The moment of a start at a later time (s), before a first step of h seconds.

        A kick of half the size, not of half the length: where the length of a step changes, pymunk counts what its
        joints bear from a wrong level, and bounds it wrongly.
        """
        at = np.array([time])
        square = self._turning**2 if self._free else float(self._speed(at)[0]) ** 2
        return Moment(
            h=h,
            following=h,
            square=square,
            scale=0.5,
            programs=tuple(float(curve(at)[0]) for curve in self._loads),
            motions=tuple(float(curve(at + h)[0]) for curve in self._drives),
            frictions=tuple(float(curve(at)[0]) for curve in self._frictions),
        )

    def so_far(self) -> tuple[float, float, float, float, float]:
        """All that a march has added up, to go back to."""
        return self.work, self.angle, self._here, self._turning, self._momentum

    def back(self, so_far: tuple[float, float, float, float, float]) -> None:
        """Go back to what a march had added up then."""
        self.work, self.angle, self._here, self._turning, self._momentum = so_far

    def held(self, h: float) -> Moment:
        """A step of h seconds during which everything stays as it is at the start, the spindle's speed too."""
        first = self.first(h)
        return replace(first, h=h, following=h)

    def interval(self, start: float, end: float, count: int, next_h: float) -> None:
        """Make ready for `count` steps from start to end (s), followed by one of next_h."""
        h = (end - start) / count
        times = start + (end - start) * np.arange(count + 1) / count
        times[-1] = end
        self._h, self._next_h, self._count = h, next_h, count
        curves = [self._speed, *self._loads, *self._frictions] + ([self._torque] if self._torque else [])
        self.jumps = any(_jumps(curve, end) for curve in curves)
        if self._varying:
            after, before = self._speed(times) ** 2, self._speed(times, before=True) ** 2
            self._growth = list(zip((before[1:] - after[:-1]).tolist(), (after[1:] - before[1:]).tolist(), strict=True))
        shared = 0.0 if self.closing else next_h
        self._squares = _kicks(self._speed, times, shared, 2) if self._varying else [self._steady] * count
        if self._torque:
            self._gains = [self._torque.integral(a, b) for a, b in pairwise(times.tolist())]
        self._programs = [_kicks(curve, times, shared, 1) for curve in self._loads]
        self._rubs = [_kicks(curve, times, shared, 1) for curve in self._frictions]
        targets = np.append(times[2:], end + next_h)
        self._motions = [curve(targets).tolist() for curve in self._drives]

    def moment(self, index: int) -> Moment:
        """What the step of that index in the interval ends with."""
        last = index == self._count - 1
        h, following = self._h, self._next_h if last else self._h
        square = self._squares[index]
        if self._varying:
            self._count_work(index)
        if self._free:
            square = self._turn_on(index)
        return Moment(
            h=h,
            following=following,
            square=square,
            scale=0.5 * (h + following) / h,
            programs=tuple(values[index] for values in self._programs),
            motions=tuple(values[index] for values in self._motions),
            frictions=tuple(values[index] for values in self._rubs),
        )

    def _count_work(self, index: int) -> None:
        """Add the work of the speed's change over a step, J omega d(omega): the trapezoid, and a jump at its end."""
        ahead = self._inertia(self._h)
        growth, jump = self._growth[index]
        self.work += 0.25 * (self._here + ahead) * growth + 0.5 * ahead * jump
        self._here = ahead

    def _turn_on(self, index: int) -> float:
        """The free spindle's speed squared at the end of a step, and its angle there by the trapezoid."""
        self._momentum += self._gains[index]
        speed = float(free_spindle_speed(self._momentum, self._own + self._inertia(self._h)))
        self.angle += 0.5 * self._h * (self._turning + speed)
        self._turning = speed
        return speed**2


def _programs(load: Load) -> tuple[Program, ...]:
    if isinstance(load, Force):
        return (load.x, load.y)
    return (load.moment,) if isinstance(load, Torque) else ()


def _kicks(curve: TimeCurve, times: FloatArray, next_h: float, power: int) -> list[float]:
    """The curve, to a power, at the end of each step; where it jumps there, shared as the kick is on either side.

    What lies before the jump alone where nothing follows (next_h is nought).
    """
    after, before = curve(times) ** power, curve(times[-1:], before=True) ** power
    h = times[-1] - times[-2]
    values: list[float] = after[1:].tolist()
    values[-1] = float((h * before[0] + next_h * after[-1]) / (h + next_h))
    return values


def _jumps(curve: TimeCurve, time: float) -> bool:
    at = np.array([time])
    return bool(curve(at)[0] != curve(at, before=True)[0])

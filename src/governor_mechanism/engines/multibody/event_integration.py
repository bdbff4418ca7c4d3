"""Steps a scene in which something sticks, strikes or goes slack: up to where that happens, and on in another mode."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.engines.multibody.contact import Switching
from governor_mechanism.integrators.projected_dop853 import COUNTS, CROSSED, DONE, STALLED, integrate
from governor_mechanism.mechanics.dynamics.contacts import Mode
from governor_mechanism.mechanics.dynamics.equations_of_motion import marks_of
from governor_mechanism.mechanics.dynamics.lowering import System, acts_of
from governor_mechanism.mechanics.dynamics.output_forces import WATCH
from governor_mechanism.types import FloatArray, IntArray

WATCHED, AFTER = 0.2, 0.04
"""Of the longest step: no step is longer while something is watched, and none that follows an event. The two runs of a
certificate have longest steps of their own, and so take other ones here too."""

SAME_TIME = 1e-13
"""Of a time scale: events closer together are at one time."""

MOST_AT_ONCE = 30
"""Events at one time; more are a chatter that does not end."""

MOST_HALVINGS = 40
"""Of a step, in search of where something that begins at nought was below it."""

LEFT = 9
"""How a piece ends, beside those of `dop853`: a station lies outside the limits."""

FEW_STEPS = 60
"""From the beginning of a step to what happens within it takes a handful, but into a change point no end of them."""


class _LostError(Exception):
    """What is watched could not be followed within a step."""


class Stepping(Protocol):
    """What is asked of a stepper."""

    closed: float
    max_steps: int

    def cubics(self, start: float) -> FloatArray: ...
    def outside(self, state: FloatArray) -> bool: ...
    def scale(self) -> FloatArray: ...


class Crossing:
    """Goes on through one run at a tolerance; counts are those of `dop853`."""

    def __init__(self, stepper: Stepping, switching: Switching, tolerance: float, second: float, longest: float,
                 counts: IntArray) -> None:  # fmt: skip
        self._stepper, self._switching, self._counts = stepper, switching, counts
        self._tolerance, self._second, self._longest = tolerance, second, longest * second
        self._last, self._at_once = -np.inf, 0
        self.acts = np.zeros(3, dtype=np.int64)
        """Evaluations of springs, brakes and sliding friction along readings."""
        self._scale = stepper.scale()

    def resume(self, time: float, state: FloatArray) -> None:
        """A program has jumped, or has a kink."""
        self._switching.go_on(time, state, self._stepper.cubics(time))

    def piece(
        self,
        span: tuple[float, float],
        times: FloatArray,
        state: FloatArray,
        step: float,
        found: FloatArray,
        modes: list[Mode],
    ) -> tuple[int, float, int]:
        """From span[0] to span[1], filling found at the times; how it ended, the last step, how many were reached."""
        now, end = span
        filled, switching = 0, self._switching
        while now < end:
            system, crossed = switching.system, np.empty(2)
            left = times[filled:]
            code, step, reached, reached_time = self._stepped(system, (now, end), left, state, step, found[filled:],
                                                              crossed)  # fmt: skip
            modes += [switching.mode] * reached
            filled += reached
            if code != CROSSED:
                return code, step, filled
            now = reached_time
            when, about = self._located(system, now, state, crossed)
            if not about and when - now <= SAME_TIME * self._second:  # nothing after all, and too near to look again
                when = min(end, now + max(step, SAME_TIME * self._second))
            _, _, reached, _ = self._stepped(_quiet(system), (now, when), times[filled:], state, when - now,
                                             found[filled:], crossed)  # fmt: skip
            modes += [switching.mode] * reached
            filled += reached
            now = when
            if filled and self._stepper.outside(found[filled - 1]):
                return LEFT, step, filled  # what happens beyond the limits is no concern of ours, and may never end
            if about and not self._ends(now):
                return STALLED, step, filled
            if about:
                switching.go_on(now, state, self._stepper.cubics(now), about)
            step = min(step, AFTER * self._longest)
        return DONE, step, filled

    def _stepped(
        self,
        system: System,
        span: tuple[float, float],
        times: FloatArray,
        state: FloatArray,
        step: float,
        found: FloatArray,
        crossed: FloatArray,
    ) -> tuple[int, float, int, float]:
        longest = self._longest * (WATCHED if len(system.watch) else 1.0)
        if not span[1] > span[0]:
            return DONE, step, 0, span[0]
        before = int(self._counts[2])
        ended = integrate(system, self._switching.room, self._stepper.cubics(span[0]), span, times, state,
                         self._scale, self._tolerance, step or longest, longest, self._stepper.closed,
                         self._stepper.max_steps, found, self._counts, crossed)  # fmt: skip
        self._count_acts(system, int(self._counts[2]) - before)
        return ended

    def _located(self, system: System, now: float, state: FloatArray, crossed: FloatArray) -> tuple[float, list[int]]:
        """When the first thing watched rises above nought, and whom it concerns; none where it does not after all.

        state is at `now`, and crossed holds the times between which that is.
        """
        low, high = float(crossed[0]), float(crossed[1])
        try:
            times = self._crossings(system, now, state, low, high)
        except _LostError:
            return high, []  # at a change point, say: the step goes over it, and what happens there is looked for again
        if not times:
            return high, []
        when = min(times.values())
        same = [k for k, time in times.items() if time - when <= SAME_TIME * self._second]
        return when, sorted({int(system.watch["about"][k]) for k in same})

    def _crossings(self, system: System, now: float, state: FloatArray, low: float, high: float) -> dict[int, float]:
        """When (s) each mark that has risen above nought at `high` did so, after `low`."""
        cubics, room = self._stepper.cubics(now), self._switching.room

        def marks(time: float) -> FloatArray:
            there = self._reached(system, (now, time), state, cubics)
            return marks_of(system, room, cubics, time - now, there)[0]

        at_low, at_high = marks(low), marks(high)
        crossing = np.flatnonzero(at_high > 0.0)
        times, tiny = dict[int, float](), system.watch["tiny"]
        for k in crossing.tolist():

            def mark(time: float, k: int = k) -> float:
                return float(marks(time)[k])

            begin, end = (
                _below(mark, low, high, min(float(at_low[k]), 0.0)) if at_low[k] >= -float(tiny[k]) else (low, high)
            )
            times[k] = low if begin is None else float(brentq(mark, begin, end, xtol=1e-15, rtol=1e-15))
        return times

    def _reached(self, system: System, span: tuple[float, float], state: FloatArray, cubics: FloatArray) -> FloatArray:
        """The state at span[1] from that at span[0], in a few steps with nothing watched; cubics count from span[0]."""
        there, counts = state.copy(), np.zeros(COUNTS, dtype=np.int64)
        if span[1] > span[0]:
            length = span[1] - span[0]
            code, *_ = integrate(_quiet(system), self._switching.room, cubics, span, np.empty(0),
                                 there, self._scale, self._tolerance, length, self._longest,
                                 self._stepper.closed, FEW_STEPS, np.empty((0, state.size)), counts,
                                 np.empty(2))  # fmt: skip
            self._counts[2:] += counts[2:]
            self._count_acts(system, int(counts[2]))
            if code != DONE:
                raise _LostError
        return there

    def _count_acts(self, system: System, evaluations: int) -> None:
        """Note how often each kind of load along a reading was evaluated: friction that holds is none."""
        self.acts += evaluations * acts_of(system)

    def _ends(self, now: float) -> bool:
        """Whether what happens at one time comes to an end."""
        self._at_once = self._at_once + 1 if now - self._last <= SAME_TIME * self._second else 0
        self._last = now
        return self._at_once < MOST_AT_ONCE


def _below(mark: Callable[[float], float], low: float, high: float, least: float) -> tuple[float | None, float]:
    """A time after low at which a mark that begins at nought is below `least`, and a later one at which it is positive.

    The first is None where it rises at once.
    """
    above = high
    for halving in range(1, MOST_HALVINGS):
        middle = low + (high - low) * 0.5**halving
        found = mark(middle)
        if found < least:
            return middle, above
        above = middle if found > 0.0 else above
    return None, high


def _quiet(system: System) -> System:
    """The same, with nothing watched."""
    return system._replace(watch=np.zeros(0, dtype=WATCH))

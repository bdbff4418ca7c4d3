"""The march of a scene in which something sticks, strikes or goes slack: a step in which that happens is split there.

Where friction slides it is a force; where it holds it is a joint of pymunk that bears no more than that force, so the
joint solver itself says when it slips, and which way. A stop throws back what strikes it, and holds what rests on it by
a joint that only pushes. At what happens the staggered scheme begins anew, from poses and velocities of one time.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from governor_mechanism.engines.impulse.contact import Keeping
from governor_mechanism.engines.impulse.pymunk.model import Assembly
from governor_mechanism.engines.impulse.staggered_stepper import Walk
from governor_mechanism.engines.impulse.step_records import Happening
from governor_mechanism.mechanics.contact.tolerances import SMALLEST_BOUNCE, bounces_left
from governor_mechanism.mechanics.dynamics.contacts import Mode
from governor_mechanism.model.events import LEAVES, SLIPS, STICKS, STRIKES, Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from governor_mechanism.engines.impulse.time_inputs import Clock

SHORT = 1e-4
"""Of a step: so little time before a station is passed without one, or rounding would be divided by it."""

FLIGHT, LANDING = 4, 1.2
"""Steps of a short bounce in a march whose steps are not halved, and the part of its time in which it will be over."""

MOST_AT_ONCE = 60
"""Events within one step; more are a chatter that does not end."""

SMALLEST_PART, RESOLVED = 1e-9, 4e-15
"""Of a step, and of the time that has passed: no step is shorter."""

SOON, RELEASED, LATE = 0.05, 1e-9, 1e-4
"""Of a step: how early what lets go is looked for, how closely, and how late it is let go: it begins to move with no
force at all, and a little too early it would be caught at once.
"""

HALFWAY = 0.5
"""Of a step: earlier than this the load on what is held is reckoned back; in shorter parts it is lost in rounding."""

SAME_STEP = 1e-9
"""Of a step: steps that differ by no more are of one length."""

LOCATED = 1e-13
"""Of a step: how closely an event is located in it."""


class Passage:
    """Marches a scene's assembly through intervals of time from a start, poses and velocities (bodies, 3).

    second (s) is the time scale, level how often the steps are halved, h (s) the first of them. splits counts the steps
    that were split.
    """

    def __init__(
        self,
        scene: Scene,
        assembly: Assembly,
        clock: Clock,
        start: tuple[FloatArray, FloatArray],
        *,
        second: float,
        level: int,
        h: float,
    ) -> None:
        self._clock, self.splits = clock, 0
        self._walk = Walk(scene.part.mechanism, assembly, clock, start, h)
        self._keeping = Keeping(scene, self._walk, second)
        self._flight, self._parts, self._fine, self._lands = math.inf, FLIGHT << level, 0.0, -math.inf
        self._struck, self._rest_at = dict[int, int](), dict[int, float]()
        self._strike({})
        self._go_on(h)
        self._keeping.events.clear()

    def states(self) -> tuple[FloatArray, FloatArray]:
        """Poses and velocities (bodies, 3) of the mass centres where the march is."""
        return self._walk.states()

    @property
    def events(self) -> list[Event]:
        """What happened so far."""
        return self._keeping.events

    @property
    def mode(self) -> Mode:
        """How everything stands."""
        return self._keeping.mode

    @property
    def lost(self) -> float:
        """What brakes, friction and stops have taken so far (J)."""
        return self._walk.here.lost

    def through(self, start: float, end: float, count: int, next_h: float) -> bool:
        """March from start to end (s) in so many steps, followed by one of next_h; False where chatter does not end."""
        whole, now, happened = (end - start) / count, start, 0
        until, steps = end, count
        held_anew = bool(self._keeping.resting()) and abs(whole - self._walk.stepped) > SAME_STEP * whole
        if held_anew or start < self._lands:
            self._walk.close()
            until, steps = self._next_piece(start, end, whole)
        while now < end:
            h = (until - now) / steps
            found = self._steps(now, until, steps, next_h if until == end else h)
            if not found and until == end:
                break
            if found:
                happened += 1
                self._locate(found, h)
            else:
                self._walk.close()
            if happened > MOST_AT_ONCE * count:
                return False
            now = self._walk.here.time
            if end - now < SHORT * whole:
                self._walk.pass_to(end, whole)
                self._go_on(next_h)
                return True
            until, steps = self._next_piece(now, end, whole)
        if self._clock.jumps:
            self._walk.close()
            self._go_on(next_h)
        return True

    def _next_piece(self, now: float, end: float, whole: float) -> tuple[float, int]:
        """Begin anew toward a station at `end` (s) in steps of at most `whole`; until when, and in how many steps.

        A bounce is followed in so many steps that those of every run shorten alike from level to level.
        """
        steps = math.ceil((end - now) / whole * (1 - SHORT))
        flight = self._go_on((end - now) / steps)
        if flight < self._parts * whole:
            self._fine, self._lands = flight / self._parts, now + LANDING * flight
        if self._lands <= now + self._fine:
            return end, steps
        until = min(end, self._lands)
        if end - until < SHORT * whole:
            until = end
        steps = math.ceil((until - now) / min(self._fine, whole))
        self._go_on((until - now) / steps)
        return until, steps

    def _steps(self, start: float, end: float, count: int, next_h: float) -> list[Happening]:
        """Step on until something happens."""
        clock, h = self._clock, (end - start) / count
        self._walk.stepped = h
        clock.interval(start, end, count, next_h)
        if clock.jumps:  # to be gone on from anew, with what holds after it
            clock.interval(start, end, count, h)
        for index in range(count):
            sight, instant = self._walk.step(
                clock.moment(index), end if index == count - 1 else start + (index + 1) * h
            )
            found = self._keeping.happenings(sight)
            if found:
                return found
            self._walk.here = instant
        return []

    def _locate(self, found: list[Happening], h: float) -> None:
        """Go to the first of what happens within h seconds from where the march is, and let it happen."""
        self._walk.close()
        parts = {index: self._part(happening, h) for index, happening in enumerate(found)}
        first = min(1.0, *parts.values())
        _, self._walk.here = self._walk.attempt(max(first, self._least(h)) * h)
        self.splits += 1
        hit = [happening for index, happening in enumerate(found) if parts[index] - first <= 10 * LOCATED]
        for happening in hit:
            self._keeping.let(happening)
        self._walk.throw(self._keeping.resting())
        if any(one.kind == STICKS for one in hit):
            self._keeping.follow_rates()
        self._strike({one.which: one.way for one in hit if one.kind == STRIKES})

    def _part(self, happening: Happening, h: float) -> float:
        """The part of the next h seconds after which something happens; infinite where it does not after all."""
        hold = self._keeping.holds[happening.which] if happening.kind == SLIPS else None
        least = self._least(h)

        def excess(part: float) -> float:
            if part <= least:
                return happening.before
            return happening.excess(self._walk.attempt(part * h, steps=1 if hold is None else 2)[0])

        held = None if hold is None else hold.held
        if hold is not None:
            # What long steps left of the reading off its place a short one would bring back by a force that none bears.
            hold.bound, hold.held = False, self._walk.value(self._keeping.at[happening.which])
        try:
            most, low = excess(1.0), 0.0
            if most <= 0.0:
                return math.inf  # a joint solver that lagged behind
            if happening.kind in (SLIPS, LEAVES):
                low = SOON if happening.kind == LEAVES else HALFWAY
                earlier = excess(low)
                if earlier >= 0.0:
                    risen = low - earlier * (1.0 - low) / (most - earlier) if most > earlier else 0.0
                    return min(max(risen, least) + LATE, low)
                return min(1.0, float(brentq(excess, low, 1.0, xtol=RELEASED, rtol=1e-15)) + LATE)
            if happening.before > -SOON * most:
                # It begins where the last one ended: look for a time at which it has gone on from there.
                low = next((part for part in 0.5 ** np.arange(1, 30) if excess(part) < 0.0), -1.0)
                if low < 0.0:
                    # What has just slipped has no speed to begin with; what else has none had come to rest before.
                    return 1.0 if happening.kind == STICKS and self._keeping.slipped == self._walk.here.time else 0.0
            return float(brentq(excess, low, 1.0, xtol=LOCATED, rtol=1e-15))
        finally:
            if hold is not None:
                hold.bound, hold.held = True, held

    def _least(self, h: float) -> float:
        """The part of h seconds from where the march is that is no mere rounding of its time."""
        return max(SMALLEST_PART, RESOLVED * self._walk.here.time / h)

    def _strike(self, which: dict[int, int]) -> None:
        """Throw back what runs into a stop; what has no speed left rests there. which: the sides of those that ran."""
        keeping, walk = self._keeping, self._walk
        for _ in range(2 * len(keeping.keepers)):
            hitting = keeping.hitting()
            if not hitting:
                break
            back = {k: -keeping.keepers[k].restitution * walk.rate(keeping.at[k]) for k in hitting}
            # What rests on a stop is pressed against it; friction bears no impulse.
            pressed = {keeping.keepers[k].reading: 0.0 for k, hold in enumerate(keeping.holds) if hold.side}
            walk.throw(pressed | {keeping.keepers[k].reading: rate for k, rate in back.items()}, lost=True)
            for k, side in hitting.items():
                keeping.tell_of(k, STRIKES)
                if abs(back[k]) <= keeping.still(k):
                    keeping.stand(k, side)
                else:
                    keeping.slide(k, -side)
                    self._struck[k] = side
            keeping.follow_rates()
        for k, side in which.items():
            if k not in self._struck and not keeping.holds[k].side:  # pressed into it, but with no speed
                keeping.stand(k, side)
                walk.throw(keeping.resting())

    def _go_on(self, h: float) -> float:
        """Begin anew before a step of h seconds; the joint solver says what is still held then.

        How long (s) the shortest bounce that has just begun will last.
        """
        self._flight = math.inf
        for _ in range(len(self._keeping.keepers) + 1):
            self._walk.start(h)
            after = self._walk.acting.rates(self._walk.assembly.velocities())
            if not self._ends_bounces(after, h):
                break
        for k, at in enumerate(self._keeping.at):
            way = self._keeping.lets_go(k, float(after[at]))
            if way:
                self._keeping.slide(k, way)
        self._keeping.tell(self._rest_at)
        self._rest_at = {}
        return self._flight

    def _ends_bounces(self, after: FloatArray, h: float) -> bool:
        """Take the speed of bounces that rise no more; whether there were any."""
        resting = dict[int, float]()
        for k, side in self._struck.items():
            at, keeper = self._keeping.at[k], self._keeping.keepers[k]
            away = -side * float(self._walk.here.rates[at])
            back = side * float(after[at] - self._walk.here.rates[at]) / (0.5 * h)
            if back > 0.0:
                self._flight = min(self._flight, 2 * away / back)
            if keeper.restitution < 1 and back > 0.0 and away**2 < 2 * back * SMALLEST_BOUNCE * self._keeping.sizes[at]:
                returning = self._returning(k, side, h)
                resting[k] = self._walk.here.time + bounces_left(away, back, returning, keeper.restitution)
        for k in resting:
            self._flight = math.inf
            self._keeping.stand(k, self._struck[k])
        self._struck = {}
        self._rest_at |= resting
        if resting:
            self._walk.throw(self._keeping.resting(), lost=True)
            self._keeping.follow_rates()
        return bool(resting)

    def _returning(self, k: int, side: int, h: float) -> float:
        """The acceleration towards its stop of what comes back to it, with friction against that."""
        acting, at = self._walk.acting, self._keeping.at[k]
        onward = acting.sliding
        alone = not self._walk.one_freedom  # else all that rubs goes back with it
        acting.sliding = [sign if alone and other != k else -sign for other, sign in enumerate(onward)]
        self._walk.start(h)
        after = acting.rates(self._walk.assembly.velocities())
        acting.sliding = onward
        self._walk.start(h)
        return side * float(after[at] - self._walk.here.rates[at]) / (0.5 * h)

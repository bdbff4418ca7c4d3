"""How what may be held in one scene stands: friction that slides or sticks, stops that are rested on, slack springs."""

from __future__ import annotations

import math
from collections.abc import Callable

from governor_mechanism.engines.impulse.staggered_stepper import Walk
from governor_mechanism.engines.impulse.step_records import Happening, Sight, beyond, turned
from governor_mechanism.mechanics.contact.tolerances import STANDING, STILL, TOUCHING
from governor_mechanism.mechanics.dynamics.contacts import Mode, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.lowering import acted_on
from governor_mechanism.model.events import LEAVES, PULLS, RESTS, SLACKENS, SLIPS, STICKS, STRIKES, Event
from governor_mechanism.model.scene import Scene

MOVES = 10.0
"""How many times faster than that it must be for what friction and a stop held together to have been let go: what
either of them bears is the joint solver's choice.
"""

BRIEF = 0.06
"""Of a step: what sticks for less has turned, and is driven on: a hold is known to be too weak only as it is moved."""


class Keeping:
    """The keepers of one scene on a walk, the joints that may hold them, and its one-sided springs.

    second (s) is the time scale. events is what happened; slipped (s) when something was let go last.
    """

    def __init__(self, scene: Scene, walk: Walk, second: float) -> None:
        mechanism, names = scene.part.mechanism, acted_on(scene)
        self._walk, self._acting, self._second = walk, walk.acting, second
        self.keepers = keepers_of(scene)
        self.at = [names.index(keeper.reading) for keeper in self.keepers]
        self.sizes = [1.0 if mechanism.reading(name).quantity == "angle" else mechanism.size for name in names]
        self._springs = [spring for spring in springs_of(scene) if spring.one_sided]
        self._spring_at = [names.index(spring.reading) for spring in self._springs]
        self.holds = [
            walk.assembly.hold(k, at, "dry friction" if keeper.friction else "stops", keeper.reading)
            for k, (keeper, at) in enumerate(zip(self.keepers, self.at, strict=True))
        ]
        self.events, self.slipped = list[Event](), -math.inf
        self._told = list[float | None]()
        walk.acting.taut = [
            self._pulls(walk.value(at) - spring.free, at)
            for spring, at in zip(self._springs, self._spring_at, strict=True)
        ]
        for k, keeper in enumerate(self.keepers):
            rate = walk.rate(self.at[k])
            if abs(rate) <= self.still(k):
                self.stand(k, self.side(k))
            elif keeper.friction is not None:
                walk.acting.sliding[k] = int(math.copysign(1.0, rate))

    @property
    def mode(self) -> Mode:
        """How everything stands."""
        held = tuple(self._held(k) for k in range(len(self.keepers)))
        return Mode(held, tuple(self._acting.sliding), tuple(self._acting.taut or ()))

    def happenings(self, sight: Sight) -> list[Happening]:
        """What a step has gone beyond."""
        found = list[Happening]()
        for k, (keeper, hold, at) in enumerate(zip(self.keepers, self.holds, self.at, strict=True)):
            sign, way = self._acting.sliding[k], self.lets_go(k, float(sight.after[at]))
            if way:
                excess = self._freed(k, way) if hold.side else self._overload(k)
                found.append(Happening(LEAVES if hold.side else SLIPS, k, excess, -1.0, way))
            elif sign and sign * float(sight.rates[at]) <= 0.0:
                found.append(Happening(STICKS, k, turned(at, sign), -sign * self._walk.rate(at)))
            if hold.side or hold.held is not None:
                continue
            for side, end in ((1, keeper.high), (-1, keeper.low)):
                if side * (float(sight.values[at]) - end) > 0.0:
                    before = side * (self._walk.value(at) - end)
                    found.append(Happening(STRIKES, k, beyond(at, side, end), before, side))
        for k, (spring, at) in enumerate(zip(self._springs, self._spring_at, strict=True)):
            way = -1 if self._acting.taut and self._acting.taut[k] else 1
            if way * (float(sight.values[at]) - spring.free) > 0.0:
                past = way * (self._walk.value(at) - spring.free)
                found.append(Happening(PULLS, k, beyond(at, way, spring.free), past, way))
        return found

    def let(self, happening: Happening) -> None:
        """Change how a keeper or a spring stands; a strike waits until the joints have been closed."""
        k, acting = happening.which, self._acting
        if happening.kind == PULLS:
            assert acting.taut is not None
            acting.taut[k] = happening.way > 0
            kind = PULLS if acting.taut[k] else SLACKENS
            self.events.append(Event(time=self._walk.here.time, kind=kind, subject=self._springs[k].reading))
        elif happening.kind == STICKS:
            self.stand(k, 0)
        elif happening.kind in (SLIPS, LEAVES):
            self.slide(k, happening.way)

    def stand(self, k: int, side: int) -> None:
        """Hold a keeper where it is, or at its stop of that side."""
        keeper, hold = self.keepers[k], self.holds[k]
        hold.side, hold.end = side, keeper.high if side > 0 else keeper.low
        here = self._walk.value(self.at[k])
        hold.held = None if keeper.friction is None else hold.end if side else here
        self._acting.sliding[k] = 0

    def slide(self, k: int, way: int) -> None:
        """Let go of a keeper, which begins to move that way; not into a stop that it rests at."""
        hold = self.holds[k]
        if hold.side and hold.side == way:
            return
        hold.side, hold.held, self.slipped = 0, None, self._walk.here.time
        self._acting.sliding[k] = way if self.keepers[k].friction is not None else 0

    def follow_rates(self) -> None:
        """After a throw friction opposes the motion that there is now."""
        for k, (keeper, hold, at) in enumerate(zip(self.keepers, self.holds, self.at, strict=True)):
            if keeper.friction is None or hold.side:
                continue
            rate = self._walk.rate(at)
            if abs(rate) > self.still(k):
                self.slide(k, int(math.copysign(1.0, rate)))
            elif hold.held is None:
                self.stand(k, 0)

    def lets_go(self, k: int, rate: float) -> int:
        """Which way what was held moves at the rate right after a kick; 0 where it is still held, or was not."""
        hold = self.holds[k]
        shared = MOVES if hold.side and hold.held is not None else 1.0
        if self._held(k) is None or abs(rate) <= shared * self.still(k):
            return 0
        way = int(math.copysign(1.0, rate))
        if hold.side and (way == hold.side or hold.push > 0.0):
            return 0
        return way if hold.held is None or hold.saturated else 0

    def tell(self, rest_at: dict[int, float]) -> None:
        """Note what has come to be held, or is held no more; rest_at (s) is when the bounces of some will be over."""
        now = [self._held(k) for k in range(len(self.keepers))]
        for k, (keeper, was, is_) in enumerate(zip(self.keepers, self._told, now, strict=False)):
            if (was is None) == (is_ is None):
                continue
            at_stop = (was if is_ is None else is_) in (keeper.low, keeper.high)
            begun, ended = (RESTS, LEAVES) if at_stop else (STICKS, SLIPS)
            time = rest_at.get(k, self._walk.here.time)
            kind = ended if is_ is None else begun
            if kind != SLIPS or not self._stuck_briefly(keeper.reading):
                self.events.append(Event(time=time, kind=kind, subject=keeper.reading))
        self._told = now
        self._walk.holding = bool(self.resting())

    def _stuck_briefly(self, reading: str) -> bool:
        """Whether what slips now had only turned, there or at the start; then that it stuck is told no more."""
        brief = BRIEF * self._walk.stepped
        for at in reversed(range(len(self.events))):
            event = self.events[at]
            if event.subject == reading:
                turned = event.kind == STICKS and self._walk.here.time - event.time <= brief
                if turned:
                    del self.events[at]
                return turned
        return self._walk.here.time <= brief

    def resting(self) -> dict[str, float]:
        """The rates of all that is held, by reading."""
        return {keeper.reading: 0.0 for k, keeper in enumerate(self.keepers) if self._held(k) is not None}

    def hitting(self) -> dict[int, int]:
        """The keepers that run into a stop, and at which side."""
        sides = {k: self.side(k) for k, hold in enumerate(self.holds) if not hold.side}
        return {k: side for k, side in sides.items() if side * self._walk.rate(self.at[k]) > self.still(k)}

    def tell_of(self, k: int, kind: str) -> None:
        """Note what a keeper does now."""
        self.events.append(Event(time=self._walk.here.time, kind=kind, subject=self.keepers[k].reading))

    def side(self, k: int) -> int:
        """At which of its stops a keeper is: 1 the high one, -1 the low one, 0 neither."""
        keeper, at = self.keepers[k], self.at[k]
        stands = abs(self._walk.rate(at)) <= self.still(k)
        near, value = (STANDING if stands else TOUCHING) * self.sizes[at], self._walk.value(at)
        return 1 if value >= keeper.high - near else -1 if value <= keeper.low + near else 0

    def still(self, k: int) -> float:
        return STILL * self.sizes[self.at[k]] / self._second

    def _held(self, k: int) -> float | None:
        hold = self.holds[k]
        return hold.end if hold.side else hold.held

    def _overload(self, k: int) -> Callable[[Sight], float]:
        """By how much what holds a reading exceeds its friction."""
        hold = self.holds[k]
        return lambda sight: hold.friction - sight.bears[k]

    def _freed(self, k: int, way: int) -> Callable[[Sight], float]:
        """How fast a reading leaves its stop; less than nought by the force with which that still pushes alone."""
        hold, at, least = self.holds[k], self.at[k], self.still(k)

        def freed(sight: Sight) -> float:
            if hold.held is None and hold.push > 0.0:
                return -hold.push
            return way * float(sight.after[at]) - (least if hold.held is not None else 0.0)

        return freed

    def _pulls(self, stretch: float, at: int) -> bool:
        """Whether a one-sided spring pulls."""
        return self._walk.rate(at) > 0 if abs(stretch) < TOUCHING * self.sizes[at] else stretch > 0

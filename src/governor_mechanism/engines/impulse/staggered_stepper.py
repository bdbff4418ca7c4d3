"""The steps of an assembly one by one, and its beginning anew from poses and velocities of one time."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from governor_mechanism.engines.impulse.pymunk.model import Assembly
from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.engines.impulse.step_records import Instant, Sight
from governor_mechanism.mechanics.contact.impact import Thrower
from governor_mechanism.mechanics.kinematics.output_variables import reading_gradient
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from governor_mechanism.engines.impulse.time_inputs import Clock

SOLVED = 3
"""How often a start is repeated, so that the joint solver begins from the impulses that it will find."""

ANEW = 4
"""Steps after a beginning in which the joint solver has its impulses still to find."""

CLOSER = 8
"""How many times more solver iterations begin a motion anew, and follow one while something is held: what holds is
told by its force, and not by how the bodies move.
"""


class Walk:
    """An assembly on its way. here: where it is; stepped (s): the length of its last step; holding: whether anything
    is held."""

    def __init__(
        self, mechanism: Mechanism, assembly: Assembly, clock: Clock, start: tuple[FloatArray, FloatArray], h: float
    ) -> None:
        assert assembly.acting is not None
        self.assembly, self.acting, self.clock, self.stepped = assembly, assembly.acting, clock, h
        self.holding, self._anew = False, 0
        self._mechanism, self._thrower = mechanism, Thrower(mechanism)
        self._pinned = assembly.levers()[:, np.newaxis] & np.array([True, True, False])
        clock.closing = True
        assembly.start(*start, clock.first(h))
        clock.follow(assembly.spindle_inertia)
        moving, values = self._carried(start[1]), self.acting.values
        self.here = Instant(0.0, assembly.poses(), moving, values, self.acting.rates(moving), clock.so_far(), 0.0)

    @property
    def one_freedom(self) -> bool:
        """Whether one coordinate settles how everything moves."""
        return self._thrower.mobility == 1

    def value(self, at: int) -> float:
        """Value (m or rad) of a reading."""
        return float(self.here.values[at])

    def rate(self, at: int) -> float:
        """Rate (m/s or rad/s) of a reading."""
        return float(self.here.rates[at])

    def close(self) -> None:
        """Close the joints: how far a step leaves them open depends on its length."""
        self.here = self._closed(self.here)

    def states(self) -> tuple[FloatArray, FloatArray]:
        """Poses and velocities (bodies, 3) of the mass centres where the march is."""
        return self.assembly.of_mass_centres(self.here.poses, self.here.velocities)

    def step(self, moment: Moment, time: float) -> tuple[Sight, Instant]:
        """One step; what is seen at its end, and where it leads to."""
        assembly, acting = self.assembly, self.acting
        assembly.solve_closer(CLOSER if self.holding or self._anew else 1)
        self._anew = max(self._anew - 1, 0)
        before = assembly.velocities()
        assembly.step(moment)
        after = assembly.velocities()
        velocities = (moment.following * before + moment.h * after) / (moment.h + moment.following)
        values, rates = acting.values, acting.rates(velocities)
        instant = Instant(time, assembly.poses(), velocities, values, rates, self.clock.so_far(), acting.lost)
        return Sight(values, rates, acting.rates(after), moment.frictions), instant

    def attempt(self, h: float, steps: int = 1) -> tuple[Sight, Instant]:
        """h seconds alone, from where the march is; it stays there.

        What joints bear is seen from the second step on: the first begins with closed joints, which steps leave open
        by the square of their length, and bears what opens them too.
        """
        self.start(h / steps)
        time = self.here.time
        self.clock.interval(time, time + h, steps, h / steps)
        for index in range(steps):
            sight, instant = self.step(self.clock.moment(index), time + (index + 1) * h / steps)
        closed = self._closed(instant)
        return replace(sight, values=closed.values, rates=closed.rates), closed

    def start(self, h: float) -> None:
        """Begin anew from where the march is, before a step of h seconds."""
        here = self.here
        self.assembly.solve_closer(CLOSER)
        self._anew = ANEW
        for _ in range(SOLVED):
            self.assembly.start(here.poses, here.velocities, self.clock.again(here.time, h))
        self.clock.back(here.added)
        self.acting.lost, self.stepped = here.lost, h

    def throw(self, rates: dict[str, float], *, lost: bool = False) -> None:
        """Change the velocities by impulses of the joints and along readings until these have their rates.

        lost: what energy that takes is counted as lost.
        """
        here = self.here
        poses, velocities = self.states()
        gradients = np.array([reading_gradient(self._mechanism, name, poses) for name in rates])
        gradients = gradients.reshape(-1, *poses.shape)
        thrown = self._thrower.thrown(here.time, poses, velocities, gradients, np.array(list(rates.values())))
        taken = self._thrower.energy(velocities) - self._thrower.energy(thrown) if lost else 0.0
        moving = self._carried(thrown)
        self.here = replace(here, velocities=moving, rates=self.acting.rates(moving), lost=here.lost + taken)

    def pass_to(self, end: float, whole: float) -> None:
        """Go on to a station (s) so near that a step there would be one of rounding."""
        here, left = self.here, end - self.here.time
        if left <= 0.0:
            return
        self.start(whole)
        bend = (self.assembly.velocities() - here.velocities) / (0.5 * whole)
        self.clock.interval(here.time, end, 1, whole)
        self.clock.moment(0)
        self.here = replace(
            here,
            time=end,
            poses=here.poses + left * (here.velocities + 0.5 * left * bend),
            velocities=here.velocities + left * bend,
            values=here.values + left * here.rates,
            rates=here.rates + left * self.acting.rates(bend),
            added=self.clock.so_far(),
            lost=here.lost + left * self.acting.power(here.rates, self.clock.again(here.time, whole).frictions),
        )

    def _closed(self, instant: Instant) -> Instant:
        """The same with closed joints."""
        thrower, time = self._thrower, instant.time
        poses, velocities = self.assembly.of_mass_centres(instant.poses, instant.velocities)
        poses = thrower.closed(np.array([time]), poses[np.newaxis])[0]
        none = np.zeros((0, *poses.shape))
        moving = self._carried(thrower.thrown(time, poses, velocities, none, np.zeros(0)))
        there = np.where(self._pinned, instant.poses, poses)
        self.acting.look(there)
        return replace(
            instant, poses=there, velocities=moving, values=self.acting.values, rates=self.acting.rates(moving)
        )

    def _carried(self, velocities: FloatArray) -> FloatArray:
        """Velocities of mass centres as the carriers have them: the pin of a lever stands still."""
        return np.where(self._pinned, 0.0, velocities)

"""What acts along readings: springs, oil brakes and friction that slides as forces, and what they take."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from governor_mechanism.engines.impulse.pymunk.bodies import Carrier
from governor_mechanism.engines.impulse.pymunk.force_elements import Speeds
from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.mechanics.dynamics.contacts import brakes_of, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.force_laws import brake_force, spring_force
from governor_mechanism.mechanics.dynamics.lowering import acted_on
from governor_mechanism.mechanics.kinematics.constraint_kernels import gradients_of, openings_of
from governor_mechanism.mechanics.kinematics.output_rows import gauge_table
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

Fit = Callable[[FloatArray, FloatArray, FloatArray, Moment], None]
"""Make what holds a reading ready: poses (bodies, 3) that the step is about to reach, values (readings,) and gradients
(readings, bodies, 3) there, what holds then."""


class Acting:
    """The loads along the readings of one scene, at the pose that the next step is about to reach.

    values (readings,) and gradients (readings, bodies, 3) are those of the last step, by the poses of the carriers.
    sliding: the sign of the motion that the friction of each keeper opposes, 0 where it does not slide. taut: whether
    each one-sided spring pulls; None where its length is to say so. lost (J): what brakes and friction have taken.
    """

    def __init__(self, scene: Scene, carriers: list[Carrier], speeds: Speeds) -> None:
        names = acted_on(scene)
        self._carriers, self._speeds = carriers, speeds
        origins = {carrier.body.name: carrier.origin for carrier in carriers}
        self._rows = gauge_table(scene.part.mechanism, names, origins)
        self._nothing_asked = np.zeros((1, len(names), 3))
        self._springs = [(names.index(spring.reading), spring) for spring in springs_of(scene)]
        self._brakes = [(names.index(brake.reading), brake) for brake in brakes_of(scene)]
        keepers = keepers_of(scene)
        self._frictions = sum(keeper.friction is not None for keeper in keepers)
        self._rubbed = [names.index(keeper.reading) for keeper in keepers]
        self.sliding = [0] * len(keepers)
        self.taut: list[bool] | None = None
        self.fits: list[Fit] = []
        self.values, self.gradients = np.zeros(len(names)), np.zeros((len(names), len(carriers), 3))
        self.lost = 0.0
        self._before: tuple[FloatArray, tuple[float, ...]] | None = None

    @property
    def laws(self) -> dict[str, int]:
        """How often one step evaluates each law."""
        counts = {
            "springs on readings": len(self._springs),
            "oil brakes": len(self._brakes),
            "dry friction": self._frictions,
        }
        return {law: count for law, count in counts.items() if count}

    def begin(self) -> None:
        """The next step is the half one with which a motion starts: nothing has moved before it."""
        self._before = None

    def push(self, ahead: float, now: Moment) -> None:
        """Add all loads to the forces on the carriers, and make what holds readings ready."""
        poses = np.array([_ahead(carrier, ahead) for carrier in self._carriers])
        self.look(poses)
        self._count(now)
        forces = np.zeros(len(self.values))
        slack = iter(self.taut or ())
        for at, spring in self._springs:
            value = float(self.values[at])
            if spring.one_sided and not (value > spring.free if self.taut is None else next(slack)):
                continue
            forces[at] -= spring_force(spring.rate, spring.free, value)
        for at, brake in self._brakes:
            forces[at] -= brake_force(brake.linear, brake.quadratic, self._rate(at))
        for at, sign, friction in zip(self._rubbed, self.sliding, now.frictions, strict=True):
            forces[at] -= sign * friction
        loads = (forces @ self.gradients.reshape(len(forces), -1)).reshape(-1, 3) * now.scale
        for carrier, (force_x, force_y, moment) in zip(self._carriers, loads.tolist(), strict=True):
            body = carrier.carried_by
            if force_x or force_y:
                before = body.force
                body.force = (before.x + force_x, before.y + force_y)
            if moment:
                body.torque += moment
        for fit in self.fits:
            fit(poses, self.values, self.gradients, now)

    def look(self, poses: FloatArray) -> None:
        """Take values and gradients at poses (bodies, 3) of the carriers."""
        self.values = openings_of(self._rows, poses[np.newaxis], self._nothing_asked)[0]
        self.gradients = gradients_of(self._rows, poses[np.newaxis])[0]

    def rates(self, velocities: FloatArray) -> FloatArray:
        """How fast all readings change (readings,) at velocities of the carriers (bodies, 3)."""
        found: FloatArray = self.gradients.reshape(len(self.gradients), -1) @ velocities.ravel()
        return found

    def power(self, rates: FloatArray, frictions: tuple[float, ...]) -> float:
        """What brakes and sliding friction take (W) at rates (readings,) and frictions."""
        power = 0.0
        for at, brake in self._brakes:
            rate = float(rates[at])
            power += brake_force(brake.linear, brake.quadratic, rate) * rate
        for at, sign, friction in zip(self._rubbed, self.sliding, frictions, strict=True):
            power += sign * friction * float(rates[at])
        return power

    def _rate(self, at: int) -> float:
        """How fast a reading changes at the end of the coming step."""
        rate = 0.0
        for carrier, (x, y, angle) in zip(self._carriers, self.gradients[at].tolist(), strict=True):
            u, v, w = self._speeds.now[carrier.carried_by]
            rate += x * u + y * v + angle * w
        return rate

    def _count(self, now: Moment) -> None:
        """What brakes and friction take in a step whose way and time are known: the midpoint's power."""
        if self._before is not None:
            values, frictions = self._before
            ways = self.values - values
            for at, brake in self._brakes:
                way = float(ways[at])
                self.lost += brake_force(brake.linear, brake.quadratic, way / now.h) * way
            for at, sign, one, other in zip(self._rubbed, self.sliding, frictions, now.frictions, strict=True):
                self.lost += sign * 0.5 * (one + other) * float(ways[at])
        self._before = self.values, now.frictions


def _ahead(carrier: Carrier, ahead: float) -> tuple[float, float, float]:
    body = carrier.carried_by
    position, velocity = body.position, body.velocity
    x, y = position.x + velocity.x * ahead, position.y + velocity.y * ahead
    return x, y, body.angle + body.angular_velocity * ahead

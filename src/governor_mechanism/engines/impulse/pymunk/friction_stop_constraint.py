"""Joints that hold a reading where it is: by friction up to its force, and by a stop, which only pushes."""

from __future__ import annotations

import math

import numpy as np
import pymunk

from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.errors import UnsupportedEffect
from governor_mechanism.types import FloatArray

BALANCED = 1e-9
"""Of a force: what a moment may be off and still be that of one line of action."""

BEYOND = 1e-3
"""Of its reach: how far a stop's joint is drawn out, so that rounding does not say whether it is."""

NEVER_NOUGHT = 1e-30
"""m/s, rad/s: pymunk takes a limit without any correction as one that is not reached."""


class Hold:
    """What may hold one reading: a joint that bears a friction, and one that only pushes back from a stop.

    Both act along the reading's gradient, and are made anew before every step at the pose it is about to reach. held is
    the value (m or rad) that friction keeps, None while it does not; side is the stop that the reading rests at: 1 the
    high one, -1 the low one, 0 neither. bound: whether friction bears no more than its force.
    """

    def __init__(self, space: pymunk.Space, bodies: list[pymunk.Body], at: int, keeper: int, size: float) -> None:
        self._space, self._bodies, self._at, self._keeper, self._size = space, bodies, at, keeper, size
        self._made: tuple[pymunk.Constraint, pymunk.Constraint] | None = None
        self._in: set[int] = set()
        self.held: float | None = None
        self.end = 0.0
        self.side = 0
        self.bound = True
        self._dt, self._kick, self._unit = 1.0, 1.0, 1.0

    def refuse(self, poses: FloatArray, gradient: FloatArray, effect: str, reading: str) -> None:
        """Refuse a reading along which no joint of pymunk can act: whose forces have not one line of action."""
        moved = _moved(gradient)
        if len(moved) == 2:
            (fx, fy, fm), (gx, gy, gm) = gradient[moved[0]], gradient[moved[1]]
            dx, dy = poses[moved[1], 0] - poses[moved[0], 0], poses[moved[1], 1] - poses[moved[0], 1]
            off = max(abs(fx + gx), abs(fy + gy), abs(fm + gm + dx * gy - dy * gx) / self._size)
            if off < BALANCED * max(math.hypot(fx, fy), abs(fm) / self._size):
                return
        elif len(moved) == 1:
            return
        raise UnsupportedEffect(
            f"engine 'impulse' cannot model {effect} on {reading!r}: what holds it does not act along one line between "
            "two bodies; take engine multibody, or a reading between two bodies or from fixed points"
        )

    def fit(self, poses: FloatArray, values: FloatArray, gradients: FloatArray, now: Moment) -> None:
        """Make the joints ready for the pose about to be reached; take out those that are not needed."""
        self._dt, self._kick = now.h, now.h * now.scale
        if self.held is None and not self.side:
            self._keep(set())
            self._made = None  # what is made anew has borne nothing yet
            return
        gradient, value = gradients[self._at], float(values[self._at])
        if not math.isfinite(value):
            raise ValueError("a body is lost")  # pymunk would end the process
        moved = _moved(gradient)
        second = moved[-1]
        first = moved[0] if len(moved) == 2 else -1
        x, y, turn = gradient[second].tolist()
        straight = math.hypot(x, y)
        turning = straight * self._size < BALANCED * abs(turn)
        self._unit = abs(turn) if turning else straight
        if self._made is None:
            self._made = self._make(first, second, turning)
        friction, stop = self._made
        part = now.h / now.following
        opening = 0.0 if self.held is None else (value - self.held) * part
        over = max(self.side * (value - self.end), 0.0) * part if self.side else 0.0
        if turning:
            # The motor keeps (second's rate - first's) at minus its rate.
            friction.rate = opening * turn / self._unit / self._unit / now.h
            self._fit_limit(stop, first, second, poses, self.side * math.copysign(1.0, turn))
        else:
            normal = (x / straight, y / straight)
            foot = poses[second, 0] + turn / straight * normal[1], poses[second, 1] - turn / straight * normal[0]
            reach = self._size + opening / straight
            self._anchor(friction, first, second, poses, foot, normal, reach)
            out = (self.side * normal[0], self.side * normal[1])
            self._anchor(stop, first, second, poses, foot, out, self._size)
            stop.max = self._size * (1 - BEYOND)
        stop.max_bias = max(over / self._unit / now.h, NEVER_NOUGHT)
        bears = now.frictions[self._keeper]
        friction.max_force = bears * self._unit * now.scale if self.bound else math.inf
        self._keep({which for which, needed in enumerate((self.held is not None, self.side != 0)) if needed})

    @property
    def friction(self) -> float:
        """Force (N, or N m) along the reading with which friction held it in the last step."""
        return self._made[0].impulse / self._kick / self._unit if self._made and self.held is not None else 0.0

    @property
    def push(self) -> float:
        """Force (N, or N m) along the reading with which the stop pushed in the last step."""
        return self._made[1].impulse / self._kick / self._unit if self._made and self.side else 0.0

    @property
    def saturated(self) -> bool:
        """Whether friction bore all that it can in the last step."""
        if self._made is None or self.held is None or not self.bound:
            return False
        joint = self._made[0]
        return bool(joint.impulse >= joint.max_force * self._dt * (1 - 1e-12))

    def _make(self, first: int, second: int, turning: bool) -> tuple[pymunk.Constraint, pymunk.Constraint]:
        one = self._space.static_body if first < 0 else self._bodies[first]
        other = self._bodies[second]
        if turning:
            friction: pymunk.Constraint = pymunk.SimpleMotor(one, other, 0.0)
            stop: pymunk.Constraint = pymunk.RotaryLimitJoint(one, other, 0.0, 0.0)
        else:
            friction = pymunk.PinJoint(one, other)
            friction.distance = self._size
            stop = pymunk.SlideJoint(one, other, (0, 0), (0, 0), 0.0, self._size)
        for joint in (friction, stop):
            joint.collide_bodies = False
            joint.error_bias = 0.0
        friction.max_bias = math.inf
        return friction, stop

    def _fit_limit(self, stop: pymunk.Constraint, first: int, second: int, poses: FloatArray, way: float) -> None:
        turned = float(poses[second, 2]) - (float(poses[first, 2]) if first >= 0 else 0.0)
        stop.min, stop.max = (-math.inf, turned - BEYOND) if way > 0 else (turned + BEYOND, math.inf)

    def _anchor(
        self, joint: pymunk.Constraint, first: int, second: int, poses: FloatArray, foot: tuple[float, float],
        normal: tuple[float, float], reach: float,
    ) -> None:  # fmt: skip
        """From `reach` behind the foot on the first body to the foot on the second, along the normal."""
        behind = foot[0] - reach * normal[0], foot[1] - reach * normal[1]
        joint.anchor_a = behind if first < 0 else _local(poses[first], behind)
        joint.anchor_b = _local(poses[second], foot)

    def _keep(self, wanted: set[int]) -> None:
        """Have just these joints in the space; a joint that comes in has borne nothing yet."""
        if self._made is None or wanted == self._in:
            return
        for which in self._in - wanted:
            self._space.remove(self._made[which])
        for which in wanted - self._in:
            self._space.add(self._made[which])
        self._in = wanted


def _moved(gradient: FloatArray) -> list[int]:
    found: list[int] = np.flatnonzero(np.any(gradient != 0.0, axis=-1)).tolist()
    return found


def _local(pose: FloatArray, point: tuple[float, float]) -> tuple[float, float]:
    dx, dy = point[0] - float(pose[0]), point[1] - float(pose[1])
    cosine, sine = math.cos(float(pose[2])), math.sin(float(pose[2]))
    return cosine * dx + sine * dy, cosine * dy - sine * dx

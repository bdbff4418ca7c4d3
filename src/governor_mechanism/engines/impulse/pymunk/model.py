"""One scene's mechanism in a pymunk space: start it, step it, read it."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pymunk
from numpy.typing import NDArray

from governor_mechanism.engines.impulse.pymunk.bodies import Marked, carry
from governor_mechanism.engines.impulse.pymunk.force_elements import Push, Speeds, effects_on, load_on
from governor_mechanism.engines.impulse.pymunk.friction_stop_constraint import Hold
from governor_mechanism.engines.impulse.pymunk.joints import make
from governor_mechanism.engines.impulse.pymunk.output_forces import Acting
from governor_mechanism.engines.impulse.pymunk.step_inputs import Moment
from governor_mechanism.mechanics.dynamics.contacts import brakes_of
from governor_mechanism.mechanics.dynamics.force_laws import spindle_inertia
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque, TorsionDamper
from governor_mechanism.model.joints import GROUND, DrivenSlide, DrivenTurn, Joint, Pin, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


class Assembly:
    """One scene's mechanism in a pymunk space. `plain` keeps pymunk's own joint correction, loads and start."""

    def __init__(self, scene: Scene, *, iterations: int, plain: bool = False) -> None:
        self.plain = plain
        self._mechanism: Mechanism = scene.part.mechanism
        self._space = pymunk.Space()
        self._iterations = self._space.iterations = iterations
        self._carriers = [carry(self._mechanism, body) for body in self._mechanism.bodies]
        self._space.add(*(carrier.carried_by for carrier in self._carriers))
        drives = [joint for joint in self._mechanism.joints if isinstance(joint, DrivenTurn | DrivenSlide)]
        made = [
            make(joint, *self._ends(joint), self._mechanism.size, drives.index(joint) if joint in drives else -1)
            for joint in self._mechanism.joints
            if not self._within_lever(joint)
        ]
        for constraint in [constraint for one in made for constraint in one.constraints]:
            self._add(constraint)
        self._fits = [fit for one in made for fit in one.fits]
        damped = any(isinstance(load, Damper | TorsionDamper) for load in self._mechanism.loads)
        damped = damped or bool(brakes_of(scene))
        self._speeds = Speeds([carrier.carried_by for carrier in self._carriers] if damped else [])
        self._damped = damped
        effects = [effects_on(scene, carrier) for carrier in self._carriers]
        self._pushes = [push for push, _ in effects] + self._loads()
        self.laws = Counter(law for _, laws in effects for law in laws)
        """How often one step evaluates each force law."""
        self.laws.update({"springs, dampers, forces": len(self._mechanism.loads)} if self._mechanism.loads else {})
        self.acting: Acting | None = None
        """The loads along readings; None where the scene has none."""
        if scene.acting:
            self.acting = Acting(scene, self._carriers, self._speeds)
            self._pushes.append(self.acting.push)
            self.laws.update(self.acting.laws)

    def start(self, poses: FloatArray, velocities: FloatArray, first: Moment) -> None:
        """Stand at poses (bodies, 3) with velocities half a step ahead; in the plain way, as they are.

        The first moment is that at the start, as if half a step had just ended: h is half of the step that follows.
        """
        if self.acting is not None:
            self.acting.begin()
        back = 0.0 if self.plain else first.h
        for carrier, pose, velocity in zip(self._carriers, poses, velocities, strict=True):
            carrier.put(pose, velocity, back)
        if not self.plain:
            self._step(first, 0.0)

    def hold(self, keeper: int, at: int, effect: str, reading: str) -> Hold:
        """The joints that may hold a reading; `at` and keeper are where it stands among readings and keepers.

        Raises UnsupportedEffect for a reading that no joint can hold. The poses must be those of a start.
        """
        assert self.acting is not None
        made = Hold(self._space, [carrier.carried_by for carrier in self._carriers], at, keeper, self._mechanism.size)
        made.refuse(self.poses(), self.acting.gradients[at], effect, reading)
        self.acting.fits.append(made.fit)
        return made

    def step(self, now: Moment) -> None:
        """One pymunk step with all loads set."""
        self._step(now, 0.5 * now.h)

    def _step(self, now: Moment, half: float) -> None:
        ahead = 0.0 if self.plain else now.h
        if self._damped:
            self._speeds.look(0.0 if self.plain else half)
            self._speeds.passed(half + 0.5 * now.following)
        for fit in self._fits:
            fit(now)
        for push in self._pushes:
            push(ahead, now)
        self._space.step(now.h)

    def solve_closer(self, times: int) -> None:
        """Solve the joints with so many times the iterations from now on."""
        self._space.iterations = times * self._iterations

    @property
    def lost(self) -> float:
        """What brakes and friction have taken so far (J)."""
        return 0.0 if self.acting is None else self.acting.lost

    def rest(self) -> None:
        """Take all velocities away."""
        for carrier in self._carriers:
            carrier.carried_by.velocity = (0.0, 0.0)
            carrier.carried_by.angular_velocity = 0.0

    def kinetic_energy(self) -> float:
        """In the plane (J), half a step ahead of the poses."""
        return 0.5 * sum(carrier.carried_by.kinetic_energy for carrier in self._carriers)

    def poses(self) -> FloatArray:
        """Poses (bodies, 3) of the pymunk bodies: see `of_mass_centres`."""
        return np.array([(*c.carried_by.position, c.carried_by.angle) for c in self._carriers])

    def velocities(self) -> FloatArray:
        """Velocities (bodies, 3) of the pymunk bodies, half a step ahead of their poses."""
        return np.array([(*c.carried_by.velocity, c.carried_by.angular_velocity) for c in self._carriers])

    def levers(self) -> NDArray[np.bool_]:
        """(bodies,) which bodies are carried by a pin to the ground."""
        return np.array([carrier.lever for carrier in self._carriers])

    def of_mass_centres(self, poses: FloatArray, velocities: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Poses and velocities (..., bodies, 3) of our bodies from those of the pymunk bodies."""
        poses, velocities = poses.copy(), velocities.copy()
        for index, carrier in enumerate(self._carriers):
            if carrier.lever:
                angle, rate = poses[..., index, 2], velocities[..., index, 2]
                x, y = -carrier.origin[0], -carrier.origin[1]
                arm_x, arm_y = x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)
                poses[..., index, 0] += arm_x
                poses[..., index, 1] += arm_y
                velocities[..., index, 0] = -arm_y * rate
                velocities[..., index, 1] = arm_x * rate
        return poses, velocities

    def spindle_inertia(self, ahead: float) -> float:
        """Moment of inertia (kg m2) about the spindle at the pose predicted `ahead` seconds from now."""
        poses, velocities = self.poses(), self.velocities()
        poses, _ = self.of_mass_centres(poses + ahead * velocities, velocities)
        return float(
            sum(
                spindle_inertia(
                    carrier.body.mass, *carrier.body.moments.in_plane, carrier.body.moments.zz, pose[0], pose[2]
                )
                for carrier, pose in zip(self._carriers, poses, strict=True)
            )
        )

    def _add(self, constraint: pymunk.Constraint) -> None:
        constraint.collide_bodies = False
        if not self.plain:
            constraint.error_bias = 0.0
            constraint.max_bias = math.inf
        self._space.add(constraint)

    def _within_lever(self, joint: Joint) -> bool:
        """A lever turns about its carrier, which cannot move: its pin needs no joint."""
        held = {joint.first.body, joint.second.body}
        return isinstance(joint, Pin) and any(
            carrier.lever and held == {GROUND, carrier.body.name} for carrier in self._carriers
        )

    def _ends(self, joint: Joint) -> tuple[Marked, Marked]:
        return self._on(joint.first), self._on(joint.second)

    def _on(self, point: Point) -> Marked:
        if point.body == GROUND:
            return Marked(self._space.static_body, point.x, point.y)
        carrier = self._carriers[self._mechanism.body_index(point.body)]
        return Marked(carrier.carried_by, *carrier.anchor(point))

    def _loads(self) -> list[Push]:
        taken, pushes = 0, list[Push]()
        for load in self._mechanism.loads:
            count = 2 if isinstance(load, Force) else 1 if isinstance(load, Torque) else 0
            programs = tuple(range(taken, taken + count))
            taken += count
            pushes.append(load_on(load, self._marks(load), self._speeds, programs))
        return pushes

    def _marks(self, load: Load) -> tuple[Marked, Marked]:
        if isinstance(load, Force):
            return self._on(Point(body=GROUND)), self._on(load.point)
        if isinstance(load, Spring | Damper):
            return self._on(load.first), self._on(load.second)
        first, second = load.bodies
        return self._on(Point(body=first)), self._on(Point(body=second))

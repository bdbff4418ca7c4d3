"""The impulse engine: pymunk's bodies and joints, second order, extrapolated from three runs, and certified."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import ClassVar, final

from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.centrifugal import Centrifugal
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.gravity import Gravity
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.impulse.richardson import ImpulseSettings, RichardsonRefinement
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import (
    JOINT_TYPES,
    Joint,
    ProportionalDisplacement,
    RackAndPinion,
    RotationalDriver,
    TranslationalDriver,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Trajectory

UNSUPPORTED_JOINTS: frozenset[type[Joint]] = frozenset((RackAndPinion, ProportionalDisplacement))
"""Joints for which pymunk has no constraint."""


@final
@dataclass(frozen=True, kw_only=True)
class ImpulseEngine(ImpulseSettings, Engine):
    """pymunk as a second-order staggered scheme; steps h, h/2, h/4 give order 3 and a certificate.

    step (s) is the longest step, chosen from the accuracy where it is left out. runs = 1, 2, 3 steps are halved and
    extrapolated (orders 2, 3, and with certify=False 4; a run that finds its own step is always certified).
    iterations of the joint solver are raised, up to max_iterations, while joints stay open wider than the step
    explains. max_steps bounds one run. plain=True is pymunk's ordinary use: order 1, one run.

    Where something sticks, strikes or goes slack the step is split there, and the scheme begins anew: the order is the
    same after it (measured: errors fall by 4 as the step is halved, those of extrapolated runs by about 8, unevenly).
    """

    name: ClassVar[str] = "impulse"
    effects: ClassVar[frozenset[type[Effect]]] = frozenset(
        {Gravity, Centrifugal, RodMasses, BellCrankMasses, CrankMasses, OutputSpring, Dashpot, DryFriction, Stops}
    )
    joints: ClassVar[frozenset[type[Joint]]] = JOINT_TYPES - UNSUPPORTED_JOINTS

    def __post_init__(self) -> None:
        if self.runs not in (1, 2, 3):
            raise MechanismError(f"ImpulseEngine.runs must be 1, 2 or 3; got {self.runs!r}")
        if self.step is None and self.levels != 3:
            raise MechanismError("ImpulseEngine finds its own step from three runs; give step= (s) for fewer runs")
        if self.step is not None and not (self.step > 0 and math.isfinite(self.step)):
            raise MechanismError(f"ImpulseEngine.step must be a positive number of seconds; got {self.step!r}")
        for name in ("iterations", "max_iterations", "max_steps"):
            if getattr(self, name) < 1:
                raise MechanismError(f"ImpulseEngine.{name} must be at least 1; got {getattr(self, name)!r}")

    def _refuses(self, scene: Scene) -> str:
        if not self.plain:
            return ""
        if has_contacts(scene):
            return (
                "engine 'impulse' in pymunk's plain way has no friction, stops and one-sided springs along readings; leave plain=True out"
            )
        if any(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in scene.part.mechanism.joints):
            return "engine 'impulse' in pymunk's plain way does not hold drives; leave plain=True out"
        return ""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        start_time = time.perf_counter()
        refinement = RichardsonRefinement(self, scene, request)
        result = refinement.refine_to_accuracy() if self.step is None else refinement.extrapolate_at_level(0)
        return refinement.make_trajectory(result, time.perf_counter() - start_time)

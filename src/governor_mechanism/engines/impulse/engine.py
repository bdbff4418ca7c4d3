"""Impulse engine: a second-order scheme on pymunk, extrapolated from three runs, with an error certificate."""

import math
from dataclasses import dataclass
from typing import ClassVar, final

from governor_mechanism.effects.holding import Clearance
from governor_mechanism.effects.registry import EFFECT_TYPES
from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.impulse.applied_forces import cannot_rotate_in_pymunk
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of, rubbing_gaps_of
from governor_mechanism.mechanics.dynamics.inputs import reading_functions_of
from governor_mechanism.mechanics.kinematics.constraint_equations import constraint_equations_of
from governor_mechanism.model.curves import CornerOutline
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import JOINT_TYPES, Gear, Joint
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene

POSITIVE_SETTINGS = {"step": "seconds", "monitor_interval": "time scales", "max_step_work": "steps", "max_distance_ratio": "length scales"}
"""Settings that are positive and finite, with their units."""

MIN_COUNTS = {"max_step_halvings": 0} | dict.fromkeys(
    (
        "iterations",
        "max_iterations",
        "max_steps",
        "max_events_per_step",
        "min_steps_per_bounce",
        "restart_iteration_factor",
        "hold_iteration_factor",
    ),
    1,
)
"""Least values of the settings that are integers."""


MIN_ARC_CLEARANCE = 0.05
"""Least radius of the path in a hollow arc, relative to the roller: on a narrower one the force of a turn within a step is not resolved."""


def _is_narrow(gap: OutlineGap) -> bool:
    """Return whether an outline has a hollow arc that is hardly wider than the roller."""
    corners = gap.outline.corners if isinstance(gap.outline, CornerOutline) else ()
    return any(corner.radius < 0.0 and -corner.radius - gap.radius < MIN_ARC_CLEARANCE * gap.radius for corner in corners)


@final
@dataclass(frozen=True, kw_only=True)
class ImpulseEngine(ImpulseSettings, Engine):
    """Second-order staggered scheme on pymunk; runs with steps h, h/2 and h/4 give order 3 and an error estimate.

    A step that contains an event (stick, impact, slack spring) is split there and the scheme restarts, which keeps the order. Measured:
    errors fall by 4 per halving of the step, those of extrapolated runs by about 8, less regularly.

    Attributes
    ----------
    step
        Largest step, s; shorter where the spindle speed fluctuates faster. None chooses it from the accuracy.
    runs
        Number of runs with halved steps that are extrapolated: 1, 2 or 3 (order 2, 3, and with ``certify=False`` 4). A run that chooses
        its own step is always certified.
    plain
        Use pymunk in its ordinary way: order 1, one run.
    iterations
        Number of iterations of the joint solver at first. It is raised while joint gaps are larger than the step explains.
    max_iterations
        Largest number of iterations of the joint solver.
    max_steps
        Largest number of steps of all runs of a request together. Steps with more iterations, event locations and restarts count as the
        steps that take equally long. None chooses it from the scene.
    max_step_work
        Default of `max_steps`, times the work of a step relative to that of a few free bodies: a run ends within some 20 s.
    max_step_halvings
        Largest number of halvings of the first step before the engine gives up.
    monitor_interval
        Largest interval between two checks of the limits, and the largest step that the engine chooses, in time scales of the scene.
    max_events_per_step
        Largest mean number of contact events per step; more are chatter that does not end.
    min_steps_per_bounce
        Number of steps of a short bounce in the coarsest run.
    restart_iteration_factor
        Factor on the solver iterations at restarts.
    hold_iteration_factor
        Factor on the solver iterations while a contact is held, in every second run twice as large: contact decisions use the holding
        force, which converges more slowly than the velocities.
    max_distance_ratio
        Distance from the origin, in length scales, beyond which a body has flown away: pymunk loses digits with the distance.
    """

    name: ClassVar[str] = "impulse"
    effects: ClassVar[frozenset[type[Effect]]] = EFFECT_TYPES - {Clearance}
    # pymunk has no constraint for the others.
    joints: ClassVar[frozenset[type[Joint]]] = frozenset(joint for joint in JOINT_TYPES if joint.impulse_parts is not Joint.impulse_parts)

    def __post_init__(self) -> None:
        """Raise MechanismError for settings out of range."""
        if self.runs not in (1, 2, 3):
            raise MechanismError(f"ImpulseEngine.runs must be 1, 2 or 3; got {self.runs!r}")
        if self.step is None and self.levels != 3:
            raise MechanismError("ImpulseEngine chooses its own step from three runs; give step= (s) for fewer runs")
        for name, unit in POSITIVE_SETTINGS.items():
            value = getattr(self, name)
            if name == "step" and value is None:
                continue
            if value is None or not 0 < value < math.inf:
                raise MechanismError(f"ImpulseEngine.{name} must be a positive number of {unit}; got {value!r}")
        for name, least in MIN_COUNTS.items():
            count = getattr(self, name)
            if name == "max_steps" and count is None:
                continue
            if count < least:
                raise MechanismError(f"ImpulseEngine.{name} must be at least {least}; got {count!r}")

    def _refuses(self, scene: Scene) -> str:
        """Return why the engine cannot run a scene, or an empty string."""
        if len(scene.parts) > 1 or scene.couplings:
            return (
                "engine 'impulse' runs scenes with one part and no couplings; this scene has couplings, or the parts "
                f"{[part.name for part in scene.parts]}: choose engine multibody"
            )
        if functions := reading_functions_of(scene):
            return f"engine 'impulse' cannot model loads that depend on readings, here {functions[0].reading!r}; choose engine multibody"
        if moving := [element.name for element in scene.mechanism.force_elements if element.switch and not element.switch.is_constant]:
            return f"engine 'impulse' cannot model a cut-off that moves, here that of {moving[0]!r}; choose engine multibody"
        if massless := ", ".join(body.name for body in scene.part.mechanism.bodies if body.mass == 0.0):
            return f"engine 'impulse' cannot model bodies without mass and moving points of the ground: {massless}; use engine 'multibody'"
        if rubbing := rubbing_gaps_of(scene):
            return f"engine 'impulse' cannot model friction of contact {rubbing[0].contact!r}; choose engine 'multibody', or leave it out"
        if narrow := [gap.contact for gap in outline_gaps_of(scene) if _is_narrow(gap)]:
            return (
                f"engine 'impulse' cannot follow a hollow arc that is hardly wider than what touches it, here in contact {narrow[0]!r}; "
                "choose engine 'multibody', or widen the arc"
            )
        mechanism = scene.part.mechanism
        if carried := [joint.name for joint in mechanism.joints if isinstance(joint, Gear) and joint.is_carried]:
            text = f"a gear with a carrier, which joins three bodies, here {carried[0]!r}"
            return f"engine 'impulse' cannot model {text}; use engine 'multibody'"
        if points := ", ".join(body.name for body in mechanism.bodies if cannot_rotate_in_pymunk(mechanism, body)):
            return f"engine 'impulse' cannot rotate point masses without a pin to the ground, here {points}; use engine 'multibody'"
        if not self.plain:
            return ""
        if has_contacts(scene):
            return "engine 'impulse' with plain=True has no friction, stops and one-sided springs along readings; leave plain=True out"
        if constraint_equations_of(scene.part.mechanism).is_driven.any():
            return "engine 'impulse' with plain=True does not enforce drives; leave plain=True out"
        return ""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        from governor_mechanism.engines.impulse.richardson import RichardsonRefinement  # slow to import: pymunk

        return RichardsonRefinement(self, scene, request).run()

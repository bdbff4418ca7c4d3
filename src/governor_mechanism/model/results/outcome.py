"""How a run ended, and what it cost."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from governor_mechanism.units.text_table import short_repr


@dataclass(frozen=True, kw_only=True)
class Cost:
    """Cost of a run.

    Attributes
    ----------
    engine
        Name of the engine.
    reason
        Reason for the choice of the engine.
    step
        Longest step of the finest run, s, or its last one.
    steps
        Number of steps.
    runs
        Number of runs for the error certificate.
    evaluations
        Number of evaluations by force law, over all runs.
    wall_time
        Time of the simulation without setup_time, s.
    setup_time
        Time to build tables, s.
    rejected
        Number of rejected steps.
    iterations
        Number of iterations of the joint solver, if it iterates.
    method
        Integration method, if the engine has a choice.
    events
        Number of contact events: stick, slip, impact, slack.
    model_size
        Counts of the model, such as bodies and constraints.
    """

    engine: str
    reason: str
    step: float
    steps: int
    runs: int
    evaluations: Mapping[str, int]
    wall_time: float
    setup_time: float = 0.0
    rejected: int = 0
    iterations: int = 0
    method: str = ""
    events: int = 0
    model_size: Mapping[str, int] = field(default_factory=dict)

    __repr__ = short_repr


FLIGHT_DETAIL = "a body flies away"
"""Cause of the end of a run in which a body leaves every bound; its outcome is LEFT_RANGE."""


class Outcome(Enum):
    """How a run ended. Each value is a sentence for the user."""

    DONE = "ran to the end within the requested accuracy"
    NOT_CERTIFIED = "ran to the end; its accuracy was not certified"
    ACCURACY_MISSED = "ran to the end, but the requested accuracy was not reached; relax it (multibody reaches the highest)"
    LEFT_RANGE = "the mechanism leaves the range in which its description is valid, and the run ends there"
    CONTROL_OUT_OF_RANGE = "a control sets what has a range to a value outside it, and the run ends there"
    SHAFT_STALLED = "the shaft would turn back, and the run ends there"
    DEAD_CENTRE = "the coordinate of the engine has a turning point there; try engine multibody"
    STIFF = "the motion is stiff, and this engine integrates explicitly; try engine multibody"
    STEP_LIMIT = "the run needs more steps than the engine allows; shorten it, slow it, or raise max_steps"
    STALLED = "the integration cannot go on from there"
    BRANCH_UNRESOLVED = "which way the mechanism goes on there is finer than the run resolves; try a higher accuracy or engine multibody"
    JOINT_OPENED = "a joint opened by more than a second-order step explains; try engine multibody"

    @property
    def ok(self) -> bool:
        """Whether the run reached its end and met all requirements."""
        return self in (Outcome.DONE, Outcome.NOT_CERTIFIED)

    def describe(self, detail: str) -> str:
        """Return the outcome as a sentence, after its cause if there is one."""
        return f"{detail}: {self.value}" if detail else self.value

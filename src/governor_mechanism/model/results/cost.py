"""What a run costs: steps, evaluations, times."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from governor_mechanism.units.short_repr import short_repr


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

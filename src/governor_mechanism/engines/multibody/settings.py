"""Numerical settings of the multibody engine."""

from dataclasses import dataclass

from governor_mechanism.engines.certificate import ErrorControlSettings


@dataclass(frozen=True, kw_only=True)
class MultibodySettings(ErrorControlSettings):
    """Numerical settings of the multibody engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    constraint_tolerance_ratio
        Constraint tolerance of the projection as a fraction of the length scale: rounding.
    max_exit_bisections
        Bisections between two monitor times to locate where a motion leaves its range: to rounding.
    restart_step_ratio
        Largest step size after an event, as a fraction of the largest step.
    event_time_tolerance
        Events closer than this, in units of the time scale, are simultaneous.
    max_simultaneous_events
        Largest number of successive events at one time; more are endless chattering.
    """

    constraint_tolerance_ratio: float = 1e-14
    max_exit_bisections: int = 40
    restart_step_ratio: float = 0.04
    event_time_tolerance: float = 1e-13
    max_simultaneous_events: int = 30

"""Settings of the multibody engine."""

from dataclasses import dataclass

from governor_mechanism.engines.certificate import ErrorControlSettings


@dataclass(frozen=True, kw_only=True)
class MultibodySettings(ErrorControlSettings):
    """Numerical settings of the multibody engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    constraint_tolerance_ratio
        Constraint tolerance of the projection as a fraction of the length scale: rounding.
    max_distance_ratio
        Distance from the origin, in length scales, beyond which a body has flown away: rounding exceeds the accuracy there.
    implicit_step_cost
        Number of explicit steps that take as long as an implicit one in a small mechanism; measured from 1 to 30 bodies: 2 to 5.
    implicit_step_cost_per_state
        Additional ones per component of the state: the linear equations of an implicit step are dense.
    restart_step_ratio
        Largest step size after an event, as a fraction of the largest step.
    event_time_tolerance
        Events closer than this, in units of the time scale, are simultaneous.
    max_simultaneous_events
        Largest number of successive events at one time; more are endless chattering.
    """

    constraint_tolerance_ratio: float = 1e-14
    max_distance_ratio: float = 1e6
    implicit_step_cost: float = 4.0
    implicit_step_cost_per_state: float = 0.02
    restart_step_ratio: float = 0.04
    event_time_tolerance: float = 1e-13
    max_simultaneous_events: int = 30

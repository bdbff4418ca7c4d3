"""Numerical settings of the multibody engine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class MultibodySettings:
    """Numerical settings of the multibody engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    max_step_ratio
        Largest step size in units of the scene's step scale, whatever the tolerance.
    first_step_ratio
        First step size as a fraction of the largest one.
    monitor_interval_ratio
        Largest distance of monitor times in units of the time scale; limits are checked at these times.
    constraint_tolerance_ratio
        Constraint tolerance of the projection as a fraction of the length scale: rounding.
    max_stagnant_runs
        Successive refinements without improvement after which the best run is accepted; a single one may be chance.
    max_exit_bisections
        Bisections between two monitor times to locate where a motion leaves its range: to rounding.
    max_interpolation_steps
        Step limit from a monitor time to a time before the next one: a handful suffices, except into a change point.
    event_step_ratio
        Largest step size while event functions are monitored, as a fraction of the largest step. The two runs of a
        certificate have different largest steps, and therefore different steps here too.
    restart_step_ratio
        Largest step size after an event, as a fraction of the largest step.
    event_time_tolerance
        Events closer than this, in units of the time scale, are simultaneous.
    max_simultaneous_events
        Largest number of successive events at one time; more are endless chattering.
    max_bracket_halvings
        Halvings of a step in search of a time at which an event function that starts at zero is negative.
    max_event_location_steps
        Step limit from the start of a step to an event within it: a handful suffices, except into a change point.
    """

    max_step_ratio: float = 2.5
    first_step_ratio: float = 0.004
    monitor_interval_ratio: float = 0.25
    constraint_tolerance_ratio: float = 1e-14
    max_stagnant_runs: int = 4
    max_exit_bisections: int = 40
    max_interpolation_steps: int = 100
    event_step_ratio: float = 0.2
    restart_step_ratio: float = 0.04
    event_time_tolerance: float = 1e-13
    max_simultaneous_events: int = 30
    max_bracket_halvings: int = 40
    max_event_location_steps: int = 60

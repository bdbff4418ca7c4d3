"""Numerical settings of the reduced engine."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ReducedSettings:
    """Numerical settings of the reduced engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    max_step_ratio
        Largest step size in units of the scene's step scale, whatever the tolerance.
    first_step_ratio
        First step size as a fraction of the largest one.
    event_step_ratio
        Largest step size while event functions are monitored, as a fraction of the largest step: they are sampled five times in a step.
    comparison_width_ratio
        Factor on the piece width of the comparison run, so that the certificate includes the interpolation error of the tables.
    max_stagnant_runs
        Successive refinements without improvement after which the best run is accepted; a single one may be chance.
    monitor_interval_ratio
        Spacing of the states between which singular configurations are searched, in time scales and in coordinate scales.
    max_monitor_travel
        Travel between two of these states, in coordinate scales, above which more are inserted.
    max_monitor_times
        Number of these states above which no more are inserted: it bounds memory.
    table_end_step_ratio
        Factor by which a step that leaves the end of the table is shortened.
    min_end_step_ratio
        Step at which the end of the table is reached, relative to the remaining time and to the time scale: rounding.
    min_remaining_travel
        Distance from the end of the table at which it is reached, relative to the coordinate and to its scale: rounding.
    max_interpolation_steps
        Step limit from a monitor time to a time before the next one: a handful suffices.
    """

    max_step_ratio: float = 2.5
    first_step_ratio: float = 0.004
    event_step_ratio: float = 0.2
    comparison_width_ratio: float = 0.7
    max_stagnant_runs: int = 4
    monitor_interval_ratio: float = 0.25
    max_monitor_travel: float = 0.5
    max_monitor_times: int = 200_000
    table_end_step_ratio: float = 0.25
    min_end_step_ratio: float = 1e-12
    min_remaining_travel: float = 1e-14
    max_interpolation_steps: int = 100

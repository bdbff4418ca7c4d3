"""Numerical settings of the reduced engine."""

from dataclasses import dataclass

from governor_mechanism.engines.certificate import ErrorControlSettings


@dataclass(frozen=True, kw_only=True)
class ReducedSettings(ErrorControlSettings):
    """Numerical settings of the reduced engine; the defaults serve all shipped scenes.

    Attributes
    ----------
    comparison_width_ratio
        Factor on the piece width of the comparison run, so that the certificate includes the interpolation error of the tables.
    max_monitor_travel
        Travel between two of these states, in coordinate scales, above which more are inserted.
    table_end_approach
        Step towards the end of the table relative to the time in which the motion would reach it at its present rate.
    table_end_step_ratio
        Factor by which such a step is shortened that leads beyond the end.
    min_end_step_ratio
        Step at which the end of the table is reached, relative to the remaining time and to the time scale: rounding.
    min_remaining_travel
        Distance from the end of the table at which it is reached, relative to the coordinate and to its scale: rounding.
    """

    max_step_work: float = 5e6
    monitor_interval_ratio: float = 0.1
    comparison_width_ratio: float = 0.7
    max_monitor_travel: float = 0.2
    table_end_approach: float = 0.99
    table_end_step_ratio: float = 0.25
    min_end_step_ratio: float = 1e-12
    min_remaining_travel: float = 1e-14

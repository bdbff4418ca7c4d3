"""Settings of the impulse engine."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ImpulseSettings:
    """Settings of an impulse run; ImpulseEngine documents and validates them."""

    step: float | None = None
    runs: int = 3
    plain: bool = False
    iterations: int = 20
    max_iterations: int = 1280
    max_steps: int | None = None
    max_step_work: float = 7e5
    max_step_halvings: int = 12
    monitor_interval: float = 0.25
    max_events_per_step: int = 60
    min_steps_per_bounce: int = 4
    restart_iteration_factor: int = 16
    hold_iteration_factor: int = 48
    max_distance_ratio: float = 5000.0

    @property
    def levels(self) -> int:
        """Return the number of runs, each with half the step of the one before, that make one result."""
        return 1 if self.plain else self.runs

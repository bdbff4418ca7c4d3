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
    max_steps: int = 4_000_000
    max_step_halvings: int = 12
    monitor_interval: float = 0.25
    max_events_per_step: int = 60
    min_steps_per_bounce: int = 4
    hold_iteration_factor: int = 8

    @property
    def levels(self) -> int:
        """Return the number of runs, each with half the step of the one before, that make one result."""
        return 1 if self.plain else self.runs


@dataclass(frozen=True, kw_only=True)
class RelaxationSettings:
    """Settings of a relaxation to equilibrium.

    `iterations` is the number of iterations of the joint solver. `step_ratio` is the step in time scales: it causes no error at rest, so
    it only has to be stable. `max_rest_speed_ratio` is the largest speed of the whole mass that counts as rest, in length scales per time
    scale. `max_steps` is the largest number of steps.
    """

    iterations: int = 60
    step_ratio: float = 0.05
    max_rest_speed_ratio: float = 1e-12
    max_steps: int = 400_000

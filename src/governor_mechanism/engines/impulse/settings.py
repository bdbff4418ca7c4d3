"""Settings of the impulse engine, the budget of work that they allow, and the time grid of the coarsest run."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.base import RunRequest
from governor_mechanism.integrators.time_grid import TimeGrid, make_time_grid
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import FloatArray, IntArray


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


ITERATION_WORK = 1e-3
"""Work of one iteration of the solver at one joint, in units of a step of a few free bodies (20 µs when it was measured)."""

CONTACT_WORK = 3.0
OUTPUT_FORCE_WORK = 0.5
VARYING_INPUT_WORK = 1.0
"""Work that contacts, forces along readings and each varying input add to a step, in the same units."""

INTERVAL_WORK = 8.0
"""Work of beginning an interval of steps, as between two monitor times; each varying input adds as much."""


class StepLimitError(Exception):
    """A run has spent its share of the budget."""


class WorkBudget:
    """Largest work of all runs of a request and that spent so far, in steps with the first number of solver iterations or their time."""

    def __init__(self, settings: ImpulseSettings, scene: Scene, n_varying_inputs: int) -> None:
        self._work_of_iteration = ITERATION_WORK * len(scene.mechanism.joints)
        self._work_without_iterations = 1.0 + CONTACT_WORK * has_contacts(scene) + OUTPUT_FORCE_WORK * len(output_forces_of(scene))
        self._work_without_iterations += VARYING_INPUT_WORK * n_varying_inputs
        self._unit = self._step_work(settings.iterations)
        self._interval_steps = INTERVAL_WORK * (1 + n_varying_inputs) / self._unit
        self.limit = settings.max_steps or int(settings.max_step_work / self._unit)
        self.spent, self._run_end = 0.0, float(self.limit)

    def _step_work(self, iterations: int) -> float:
        return self._work_without_iterations + self._work_of_iteration * iterations

    def steps_per_step(self, iterations: int) -> float:
        """Return as how many steps one with a number of iterations counts."""
        return self._step_work(iterations) / self._unit

    def expected_work(self, n_levels: int, n_steps: FloatArray | IntArray) -> FloatArray:
        """Return the work of a first result over each interval; its coarsest run takes `n_steps` (intervals,) steps there."""
        work: FloatArray = np.asarray((2.0**n_levels - 1.0) * n_steps + n_levels * self._interval_steps, dtype=np.float64)
        return work

    @property
    def remaining(self) -> float:
        """Return the work that is left for further runs."""
        return self.limit - self.spent

    def begin_run(self, later_shares: Sequence[float]) -> None:
        """Begin a run that may spend one share of what remains; later runs of the same result need the other shares."""
        self._run_end = self.spent + self.remaining / (1.0 + sum(later_shares))

    def count_step(self, iterations: int) -> None:
        """Count a step."""
        self.spent += (self._work_without_iterations + self._work_of_iteration * iterations) / self._unit  # without a call for each step

    def count_interval(self) -> None:
        """Count the beginning of an interval of steps."""
        self.spent += self._interval_steps

    def check(self) -> None:
        """Raise StepLimitError if the run has spent its share."""
        if self.spent > self._run_end:
            raise StepLimitError


ERROR_AT_UNIT_STEP = 2e-4
"""Estimated relative error of a run with a step of one time scale, extrapolated as the cube of the step; sets the first step."""


def make_first_grid(
    settings: ImpulseSettings,
    request: RunRequest,
    evaluator: ReadingEvaluator,
    breakpoints: FloatArray,  # times (s) of jumps and kinks of the inputs
    budget: WorkBudget,
) -> tuple[TimeGrid, bool]:
    """Return a grid that the first runs can finish if they meet no events, and whether it reaches the last reported time."""
    step, max_step = choose_steps(settings, evaluator.scene, request.accuracy)
    times = request.times
    if settings.step is None:
        # No run gets further, so the grid needs no monitor times there.
        least_work = float(budget.expected_work(settings.levels, np.ones(1))[0])
        times = times[times <= max_step * budget.limit / least_work]
    grid = make_time_grid(times, breakpoints, step, max_step)
    if settings.step is None and budget.expected_work(settings.levels, grid.min_steps).sum() > budget.limit:
        # A first step that is too short must not shorten the run: begin with the largest step.
        grid = make_time_grid(times, breakpoints, max_step, max_step)
    work_so_far = np.cumsum(budget.expected_work(settings.levels, grid.min_steps))
    n_monitor_times = int(np.searchsorted(work_so_far, budget.limit, side="right")) + 1
    is_complete = n_monitor_times >= len(grid.monitor_times) and len(times) == len(request.times)
    return grid.truncate(n_monitor_times), is_complete


def choose_steps(settings: ImpulseSettings, scene: Scene, accuracy: float) -> tuple[float, float]:
    """Return the step (s) of the coarsest run, and the largest one (s) that a run may take; a requested step has no largest one."""
    if settings.step is not None:
        return min(settings.step, _resolving_step(scene)), math.inf
    max_step = min(settings.monitor_interval * time_scale(scene), _resolving_step(scene))
    return min(time_scale(scene) * float((accuracy / ERROR_AT_UNIT_STEP) ** (1 / 3)), max_step), max_step


def _resolving_step(scene: Scene) -> float:
    """Return the largest step (s) that sees every cycle of the spindle speed: one radian of its fluctuation."""
    # With a whole number of cycles in each step, all runs would agree on a motion without the
    # fluctuation. The time scale resolves the harmonics of drivers, and steps end at the points of
    # programs.
    speeds = [plane.given_speed for plane in scene.system.planes if plane.given_speed and plane.given_speed.speed_fluctuation]
    rates = [max(map(abs, speed.speeds)) * speed.cycles_per_turn for speed in speeds]
    return min((1 / rate for rate in rates if rate), default=math.inf)

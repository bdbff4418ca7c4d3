"""The time grid of the coarsest run: its steps follow from the accuracy, the time scale, the inputs and the budget."""

import math

import numpy as np

from governor_mechanism.engines.base import RunRequest
from governor_mechanism.engines.impulse.settings import ImpulseSettings
from governor_mechanism.engines.impulse.work_budget import WorkBudget
from governor_mechanism.integrators.time_grid import TimeGrid, make_time_grid
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import FloatArray

ERROR_AT_UNIT_STEP = 2e-4
"""Estimated relative error of a run with a step of one time scale, extrapolated as the cube of the step; sets the first step."""


def make_first_grid(
    settings: ImpulseSettings,
    request: RunRequest,
    evaluator: ReadingEvaluator,
    breakpoints: FloatArray,  # times (s) of jumps and kinks of the inputs
    budget: WorkBudget,
) -> tuple[TimeGrid, bool]:
    """Return the grid of the coarsest run, and whether it reaches the last reported time.

    Result: grid that the first runs can finish if they meet no events, and whether it is complete.
    """
    (step, max_step), times = choose_steps(settings, evaluator.scene, request.accuracy), request.times
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
    """Return the step of the coarsest run, and the largest one that a run may take.

    Result: both steps, s; a requested step has no largest one.
    """
    if settings.step is not None:
        return min(settings.step, _resolving_step(scene)), math.inf
    max_step = min(settings.monitor_interval * time_scale(scene), _resolving_step(scene))
    return min(time_scale(scene) * float((accuracy / ERROR_AT_UNIT_STEP) ** (1 / 3)), max_step), max_step


def _resolving_step(scene: Scene) -> float:
    """Return the largest step (s) that sees every cycle of the spindle speed: one radian of its fluctuation.

    With a whole number of cycles in each step, all runs would agree on a motion without the fluctuation. The time scale resolves the
    harmonics of drivers, and steps end at the points of programs.
    """
    speeds = [plane.given_speed for plane in scene.system.planes if plane.given_speed and plane.given_speed.speed_fluctuation]
    rates = [max(map(abs, speed.speeds)) * speed.cycles_per_turn for speed in speeds]
    return min((1 / rate for rate in rates if rate), default=math.inf)

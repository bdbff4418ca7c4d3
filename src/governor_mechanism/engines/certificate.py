"""Error certificate of engines with error control: refine the tolerance until the estimated error meets the accuracy."""

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Generic, TypeVar

import numpy as np

from governor_mechanism.engines.base import RunRequest
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Cost, Outcome, Trajectory
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.types import FloatArray

TOLERANCE_SAFETY_FACTOR = 100.0
"""Ratio of accuracy to first tolerance: the estimate is the error of a run with a ten times larger tolerance."""

COMPARISON_TOLERANCE_RATIO = 10.0
"""Ratio of the comparison run's tolerance to that of the certified run."""

MIN_STEP_TOLERANCE = 1e-15
"""Smallest tolerance that is tried: double precision allows no less."""

Run = TypeVar("Run", bound=RunResult)
"""Result of an engine's run."""


@dataclass(frozen=True, kw_only=True)
class ErrorControlSettings:
    """Settings common to the engines with error control; the defaults serve all shipped scenes.

    Attributes
    ----------
    max_step_ratio
        Largest step size in units of the scene's step scale, whatever the tolerance.
    first_step_ratio
        First step size as a fraction of the largest one.
    event_step_ratio
        Largest step size while event functions are monitored, as a fraction of the largest step: they are sampled five times in a
        step. The two runs of a certificate have different largest steps, and therefore different steps here too.
    monitor_interval_ratio
        Spacing of the monitor times in units of the time scale (for reduced also of the coordinate scale): limits and singular
        configurations are searched between them.
    max_interpolation_steps
        Step limit from a monitor time to a time before the next one: a handful suffices, except into a change point.
    max_stagnant_runs
        Successive refinements without improvement after which the best run is accepted; a single one may be chance.
    """

    max_step_ratio: float = 2.5
    first_step_ratio: float = 0.004
    event_step_ratio: float = 0.2
    monitor_interval_ratio: float = 0.25
    max_interpolation_steps: int = 100
    max_stagnant_runs: int = 4


def check_engine_settings(engine: str, tolerance: float | None, max_steps: int) -> None:
    """Raise MechanismError if the tolerance or the step limit of an engine is out of range."""
    if tolerance is not None and not MIN_STEP_TOLERANCE <= tolerance < 1:
        raise MechanismError(f"{engine}.tolerance must lie between {MIN_STEP_TOLERANCE:g} and 1; got {tolerance!r}")
    if max_steps < 1:
        raise MechanismError(f"{engine}.max_steps must be at least 1; got {max_steps!r}")


def initial_tolerance(accuracy: float) -> float:
    """Return the first tolerance to try for an accuracy.

    Parameters
    ----------
    accuracy
        Requested accuracy relative to the scales.

    Returns
    -------
    float
        Error of one step, relative to the scales of the state.
    """
    return max(accuracy / TOLERANCE_SAFETY_FACTOR, MIN_STEP_TOLERANCE)


class CertifiedRunner(ABC, Generic[Run]):
    """Runs of one scene with decreasing tolerances, until the estimated error meets the requested accuracy."""

    def __init__(self, scene: Scene, request: RunRequest, evaluator: ReadingEvaluator) -> None:
        self.scene, self.request, self.evaluator = scene, request, evaluator
        self.n_runs = 0

    @property
    def setup_time(self) -> float:
        """Time of preparations that the cost of a run lists separately, s."""
        return 0.0

    @abstractmethod
    def run_once(self, tolerance: float, is_comparison: bool = False) -> Run:
        """Run with a tolerance; a comparison run differs in its largest step too, in case that limits the steps."""

    @abstractmethod
    def make_cost(self, best: Run, wall_time: float) -> Cost:
        """Return the cost over all runs."""

    def complete_result(self, best: Run) -> Run:
        """Return the best run with what only its trajectory needs."""
        return best

    def run(self, tolerance: float | None, max_stagnant_runs: int, settings: Mapping[str, Any]) -> Trajectory:
        """Return the trajectory at a given tolerance, or at one that meets the accuracy; settings are recorded in it."""
        start_time = time.perf_counter()
        if not self.request.certify:
            best = self.run_once(tolerance or initial_tolerance(self.request.accuracy))
        elif tolerance is not None:
            best = self.run_certified(tolerance)
        else:
            best = self._refine_tolerance(max_stagnant_runs)
        wall_time = time.perf_counter() - start_time - self.setup_time
        is_certified = best.error_estimate is not None
        return self.evaluator.make_trajectory(
            replace(self.complete_result(best), outcome=best.outcome or classify_accuracy(best.error_estimate, self.request.accuracy)),
            cost=self.make_cost(best, wall_time),
            settings={**settings, "asked_accuracy": self.request.accuracy, "certified": is_certified},
        )

    def run_certified(self, tolerance: float) -> Run:
        """Run twice, and estimate the error of the more accurate run by the difference."""
        worse, better = self.run_once(COMPARISON_TOLERANCE_RATIO * tolerance, is_comparison=True), self.run_once(tolerance)
        n_shared = min(worse.n_reached, better.n_reached)
        time_tolerance = self.request.accuracy * self.evaluator.time_scale
        event_time_error, is_near_event = compare_event_logs(
            better.contact_events, worse.contact_events, better.reported_states.times[:n_shared], time_tolerance
        )
        better_observables, worse_observables = better.observables, worse.observables
        if is_near_event.any() or n_shared < max(worse.n_reached, better.n_reached):
            indices = np.flatnonzero(~is_near_event)
            better_observables, worse_observables = (self.evaluator.evaluate(run.reported_states.at(indices)) for run in (better, worse))
        errors = self.evaluator.compare_observables(better_observables, worse_observables)
        estimate = self.evaluator.to_relative_error(errors)
        if has_contacts(self.scene):
            errors["event times"] = event_time_error
            estimate = max(estimate, event_time_error / self.evaluator.time_scale)
        return replace(better, reading_errors=errors, error_estimate=estimate, n_excluded=int(is_near_event.sum()))

    def _refine_tolerance(self, max_stagnant_runs: int) -> Run:
        """Return the first run whose estimate meets the accuracy, or the best run found.

        The tolerance is reduced until max_stagnant_runs in a row bring no improvement, because a single failure may be chance.
        """
        accuracy = self.request.accuracy
        tolerance = initial_tolerance(accuracy)
        best, n_stagnant = self.run_certified(tolerance), 0
        while best.error_estimate is not None and best.error_estimate > accuracy:
            # With a smaller reduction the estimate may fail to improve merely by the chance of the step sizes.
            tolerance *= min(max(0.5 * accuracy / best.error_estimate, 1e-3), 1 / COMPARISON_TOLERANCE_RATIO)
            if tolerance < MIN_STEP_TOLERANCE:
                break
            better = self.run_certified(tolerance)
            if better.error_estimate is not None and better.error_estimate < best.error_estimate and better.n_reached >= best.n_reached:
                best, n_stagnant = better, 0
                continue
            n_stagnant += 1
            if n_stagnant == max_stagnant_runs:
                break  # the error is now rounding, not discretisation
        return best


def speed_jump_work(evaluator: ReadingEvaluator, time: float, poses: FloatArray) -> float:
    """Return the work (J) that jumps of given spindle speeds do at a time on the bodies of loaded planes, with poses (bodies, 3)."""
    work = 0.0
    for index, (plane, speed_function) in enumerate(zip(evaluator.planes, evaluator.speed_functions, strict=True)):
        before, after = speed_function.limits_at(time) if plane.is_loaded and speed_function else (0.0, 0.0)
        if before != after:
            work += 0.5 * float(evaluator.evaluate_spindle_inertia(index, poses[np.newaxis])[0]) * (after**2 - before**2)
    return work


def describe_end(status: IntegrationStatus, time_text: str, max_steps: int) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time; without outcome if it reached its end."""
    if status == IntegrationStatus.DONE:
        return None, ""
    if status in (IntegrationStatus.STIFF, IntegrationStatus.STALLED):
        return Outcome.STIFF if status == IntegrationStatus.STIFF else Outcome.STALLED, f"at {time_text}"
    return Outcome.STEP_LIMIT, f"max_steps = {max_steps} reached at {time_text}"


def classify_accuracy(error_estimate: float | None, accuracy: float) -> Outcome:
    """Return the outcome of a run that reached its end; the estimate is None without a certificate."""
    if error_estimate is None:
        return Outcome.NOT_CERTIFIED
    return Outcome.DONE if error_estimate <= accuracy else Outcome.ACCURACY_MISSED

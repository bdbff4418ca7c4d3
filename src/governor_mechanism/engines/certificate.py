"""Error certificate of engines with error control: refine the tolerance until the estimated error meets the accuracy."""

import math
import time
from abc import abstractmethod
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from governor_mechanism.engines.base import Engine, Runner, RunRequest
from governor_mechanism.engines.energy_check import smallest_error_of_drift
from governor_mechanism.engines.expected_work import ExpectedWork
from governor_mechanism.engines.stall_causes import describe_stall
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.model.results.outcome import FLIGHT_DETAIL, Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.error_scales import JOINT_GAP
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.types import FloatArray

TOLERANCE_SAFETY_FACTOR = 100.0
"""Ratio of accuracy to first tolerance: the estimate is the error of a run with a ten times larger tolerance."""

COMPARISON_TOLERANCE_RATIO = 10.0
"""Ratio of the comparison run's tolerance to that of the certified run."""

JOINTS_OF_FIXED_WORK = 4
"""Number of joints whose equations take as long as the rest of an evaluation."""

ROUNDING_SAFETY_FACTOR = 3.0
"""Ratio of the bound to the standard deviation of the summed roundings, each of which is at most half a unit in the last place."""

ROUNDINGS_PER_STEP = 13
"""Roundings of a state in one step: it is the sum of its last value and of what twelve stages contribute."""

MIN_STEP_TOLERANCE = 1e-15
"""Smallest tolerance that is tried: double precision allows no less."""

MAX_STEP_TOLERANCE = 1e-6
"""Largest first tolerance: with longer steps the errors of two runs no longer differ as their tolerances do, and no time is saved."""

STEP_LIMITED_SAFETY_FACTOR = 2.0
"""Factor on the estimate of a run that is better than requested: its largest step limits it, not its tolerance.

The errors of the two runs then differ by less than their tolerances do. The factor holds up to an error of 2 / 3 of that of the comparison
run; near the requested accuracy, where tolerances limit both runs, it is a tenth, and the difference itself is an estimate.
"""

MAX_ROUNDING_TOLERANCE = 0.99 * 1e-10 / TOLERANCE_SAFETY_FACTOR
"""Tolerance below which rounding may outweigh discretisation: just less than that of a request for 1e-10, which engines reach."""

ORDER = 8
"""Order of the integration: the number of steps grows by the root of this order of the reduction of the tolerance."""

UNCONFIRMED_ERROR = 1.0
"""Error of states that the comparison run does not reach, relative to their scales: nothing is known of them."""

RUNS_PER_CERTIFICATE = 2
"""Number of runs of which a certificate consists. All certificates of a request together may take as many steps as two runs of full length,
or as one where the step limit ends the motion in any case.
"""

REQUEST_TO_FIRST_RUN_RATIO = 4.5
"""Expected work of a request relative to that of its first run: 2 if the second run confirms it, 11 after two refinements."""


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
    max_step_work
        Default of `max_steps`, times the number of joints plus `JOINTS_OF_FIXED_WORK`: a certified run ends within some 20 s.
    """

    max_step_ratio: float = 2.5
    first_step_ratio: float = 0.004
    event_step_ratio: float = 0.2
    monitor_interval_ratio: float = 0.25
    max_interpolation_steps: int = 100
    max_stagnant_runs: int = 4
    max_step_work: float = 1e6


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
    return max(min(accuracy / TOLERANCE_SAFETY_FACTOR, MAX_STEP_TOLERANCE), MIN_STEP_TOLERANCE)


@dataclass(frozen=True, kw_only=True)
class ErrorControlledEngine(Engine):
    """Engine with error control: it refines its tolerance until the estimated error meets the accuracy.

    Attributes
    ----------
    tolerance
        Error of one step relative to the scales; None chooses it from the accuracy.
    max_steps
        Largest number of steps of one run; None chooses it from the size of the mechanism.
    settings
        Numerical settings.
    """

    tolerance: float | None = None
    max_steps: int | None = None
    settings: ErrorControlSettings = field(default_factory=ErrorControlSettings)

    def __post_init__(self) -> None:
        """Raise MechanismError if the tolerance or the step limit is out of range."""
        name = type(self).__name__
        if self.tolerance is not None and not MIN_STEP_TOLERANCE <= self.tolerance < 1:
            raise MechanismError(f"{name}.tolerance must lie between {MIN_STEP_TOLERANCE:g} and 1; got {self.tolerance!r}")
        if self.max_steps is not None and self.max_steps < 1:
            raise MechanismError(f"{name}.max_steps must be at least 1; got {self.max_steps!r}")

    def step_limit(self, scene: Scene) -> int:
        """Return the largest number of steps of one run of a scene."""
        return self.max_steps or int(self.settings.max_step_work / (JOINTS_OF_FIXED_WORK + len(scene.mechanism.joints)))


class CertifiedRunner(Runner):
    """Runs of one scene with decreasing tolerances, until the estimated error meets the requested accuracy."""

    def __init__(self, engine: ErrorControlledEngine, request: RunRequest, evaluator: ReadingEvaluator) -> None:
        super().__init__(engine.name, asdict(engine), request, evaluator)
        self.engine, self.max_steps = engine, engine.step_limit(evaluator.scene)

    @abstractmethod
    def run_once(self, tolerance: float, is_comparison: bool = False) -> RunResult:
        """Run with a tolerance; a comparison run differs in its largest step too, in case that limits the steps."""

    def find_best(self) -> RunResult:
        """Return the result at the tolerance of the engine, or at one that meets the accuracy."""
        tolerance = self.engine.tolerance
        if not self.request.certify:
            return self.run_once(tolerance or initial_tolerance(self.request.accuracy))
        return self._refine_tolerance() if tolerance is None else self.run_certified(tolerance)

    def run_certified(self, tolerance: float) -> RunResult:
        """Run twice, and estimate the error of the more accurate run by the difference."""
        n_steps_before = self._count_steps() if self.n_runs else 0
        start_time = time.perf_counter()
        worse = self.run_once(COMPARISON_TOLERANCE_RATIO * tolerance, is_comparison=True)
        if self.expected_work is None:
            self.expected_work = self._expect_work(time.perf_counter() - start_time)
        better = self.run_once(tolerance)
        times = better.reported_states.times[: min(worse.n_reached, better.n_reached)]
        time_tolerance = self.request.accuracy * self.evaluator.time_scale
        event_time_error, is_near_event = compare_event_logs(better.contact_events, worse.contact_events, times, time_tolerance)
        result = self.with_error_estimate(better, worse, is_near_event, event_time_error)
        result = self._with_energy_check(self._with_rounding(result, (self._count_steps() - n_steps_before) / RUNS_PER_CERTIFICATE))
        n_missing = better.n_reached - worse.n_reached
        # Runs that both end early may do so on either side of a reported time.
        return result if n_missing <= (better.outcome is not None) else _with_unconfirmed_end(result, worse)

    def _expect_work(self, first_run_time: float) -> ExpectedWork:
        """Return the expected work of the request after its first run, which took a time (s)."""
        n_evaluations = self.count_work()[2]["equations of motion"]
        ratio, n_reported = REQUEST_TO_FIRST_RUN_RATIO, len(self.request.times)
        return ExpectedWork(first_run_time=first_run_time, n_evaluations=ratio * n_evaluations, n_reported=n_reported)

    def _with_rounding(self, result: RunResult, n_steps: float) -> RunResult:
        """Return a result whose errors are at least the roundings of readings and times over its steps, which add up like a random walk."""
        relative = ROUNDING_SAFETY_FACTOR * float(np.finfo(np.float64).eps) * math.sqrt(ROUNDINGS_PER_STEP * n_steps)
        readings, rates, times = result.observables.readings, result.observables.rates, result.reported_states.times
        sizes = {name: np.abs(values) + np.abs(times * rates.get(name, 0.0)) for name, values in readings.items()}
        roundings = {name: relative * float(np.max(size, initial=0.0)) for name, size in sizes.items()}
        errors = {name: max(error, roundings.get(name, 0.0)) for name, error in result.reading_errors.items()}
        estimate = max(result.error_estimate or 0.0, self.evaluator.to_relative_error(errors, result.observables))
        return replace(result, reading_errors=errors, error_estimate=estimate)

    def _with_energy_check(self, result: RunResult) -> RunResult:
        """Return a result whose estimate is at least the error that explains its energy drift, unless drivers alone give the motion."""
        estimate, energy = result.error_estimate or 0.0, result.observables.energy
        error = smallest_error_of_drift(energy, self.evaluator.energy_scale)
        if error <= estimate or mobility_of(self.evaluator.mechanism) == 0:
            return result
        detail = f"the energy balance drifts by {energy.drift:.1e} of its scale, more than errors of {estimate:.1e} in the readings explain"
        return replace(result, error_estimate=error, detail=result.detail or (detail if error > self.request.accuracy else ""))

    def _refine_tolerance(self) -> RunResult:
        """Return the first run whose estimate meets the accuracy, or the best run found."""
        tolerance = _round_to_decade(initial_tolerance(self.request.accuracy))
        best = self._reduce_tolerance(tolerance)
        # A looser request would have been answered by these runs: more steps round more often.
        while (best.error_estimate or 0.0) > self.request.accuracy and tolerance < MAX_ROUNDING_TOLERANCE:
            tolerance = _round_to_decade(COMPARISON_TOLERANCE_RATIO * tolerance)
            best = _choose_better(best, self.run_certified(tolerance))
        return self._allow_for_limited_steps(best)

    def _allow_for_limited_steps(self, result: RunResult) -> RunResult:
        """Return a result that is better than requested with errors raised by STEP_LIMITED_SAFETY_FACTOR, at most up to the accuracy."""
        estimate, accuracy = result.error_estimate or 0.0, self.request.accuracy
        if not 0.0 < estimate < accuracy:
            return result
        factor = min(STEP_LIMITED_SAFETY_FACTOR, accuracy / estimate)
        errors = {name: error if name == JOINT_GAP else factor * error for name, error in result.reading_errors.items()}
        raised = self.evaluator.to_relative_error(errors, result.observables)
        return replace(result, reading_errors=errors, error_estimate=min(max(raised, estimate), accuracy))

    def _reduce_tolerance(self, tolerance: float) -> RunResult:
        """Return the first run, from a tolerance on, whose estimate meets the accuracy, or the best run found.

        The tolerance is reduced until max_stagnant_runs in a row bring no improvement, because a single failure may be chance.
        """
        accuracy, n_stagnant = self.request.accuracy, 0
        best = self.run_certified(tolerance)
        used_steps = last_steps = self._count_steps()
        # After enough runs without improvement the error is rounding, not discretisation.
        while (error := best.error_estimate or 0.0) > accuracy and n_stagnant < self.engine.settings.max_stagnant_runs:
            # With a smaller reduction the estimate may fail to improve merely by the chance of the step sizes.
            reduction = min(max(0.5 * accuracy / error, 1e-3), 1 / COMPARISON_TOLERANCE_RATIO)
            previous_tolerance, tolerance = tolerance, max(_round_to_decade(reduction * tolerance), self._smallest_tolerance(best))
            expected_steps = last_steps * (previous_tolerance / tolerance) ** (1 / ORDER)
            n_runs = 1 if best.outcome is Outcome.STEP_LIMIT else RUNS_PER_CERTIFICATE
            if tolerance >= previous_tolerance or used_steps + expected_steps > n_runs * self.max_steps:
                break
            better = _choose_better(best, self.run_certified(tolerance))
            last_steps, used_steps = self._count_steps() - used_steps, self._count_steps()
            n_stagnant = n_stagnant + 1 if better is best else 0
            best = better
        return best

    def _count_steps(self) -> int:
        """Return the steps of all runs so far, rejected ones included."""
        steps, rejected, _ = self.count_work()
        return steps + rejected

    def _smallest_tolerance(self, result: RunResult) -> float:
        """Return the smallest tolerance for a motion: far from the origin, double precision resolves positions less well."""
        positions = np.abs(result.reported_states.poses[..., :2])
        distance = float(np.max(positions, initial=0.0)) / self.evaluator.mechanism.length_scale
        return max(MIN_STEP_TOLERANCE, float(np.finfo(np.float64).eps) * distance)


def _round_to_decade(tolerance: float) -> float:
    """Return a tolerance, one near rounding rounded down to a power of ten.

    There the error of a run is chance. A request then tries all the runs that a looser one would choose from.
    """
    if tolerance >= MAX_ROUNDING_TOLERANCE * COMPARISON_TOLERANCE_RATIO:
        return tolerance
    return float(10.0 ** math.floor(math.log10(tolerance) + 1e-9))


def _with_unconfirmed_end(result: RunResult, worse: RunResult) -> RunResult:
    """Return a result that does not claim the states after the end of its comparison run."""
    detail = f"the run that it is compared with ends earlier, after {worse.n_reached} of {result.n_reached} reported times: {worse.detail}"
    estimate = max(result.error_estimate or 0.0, UNCONFIRMED_ERROR)
    return replace(result, error_estimate=estimate, detail=result.detail or detail)


def _choose_better(best: RunResult, other: RunResult) -> RunResult:
    """Return the other result if it has a smaller error estimate and gets as far, else the best one so far."""
    estimate = best.error_estimate or 0.0
    return other if (other.error_estimate or estimate) < estimate and other.n_reached >= best.n_reached else best


def speed_jump_work(evaluator: ReadingEvaluator, time: float, poses: FloatArray) -> float:
    """Return the work (J) that jumps of given spindle speeds do at a time on the bodies of loaded planes, with poses (bodies, 3)."""
    work = 0.0
    for rotation in evaluator.rotations:
        if rotation.plane.is_loaded and rotation.speed_function is not None:
            before, after = rotation.speed_function.limits_at(time)
            if before != after:
                work += 0.5 * float(rotation.inertia(poses[np.newaxis])[0]) * (after**2 - before**2)
    return work


def describe_end(scene: Scene, status: IntegrationStatus, time_text: str, max_steps: int) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time; without outcome if it reached its end."""
    if status == IntegrationStatus.DONE:
        return None, ""
    if status == IntegrationStatus.STIFF:
        return Outcome.STIFF, f"at {time_text}"
    if status in (IntegrationStatus.STALLED, IntegrationStatus.ENDLESS_EVENTS):
        return Outcome.STALLED, f"{describe_stall(scene, status)}, at {time_text}"
    if status in (IntegrationStatus.OUT_OF_RANGE, IntegrationStatus.LEFT_LIMITS):
        return Outcome.LEFT_RANGE, f"{FLIGHT_DETAIL}, at {time_text}"
    return Outcome.STEP_LIMIT, f"max_steps = {max_steps} reached at {time_text}"

"""Error certificate of engines with error control: refine the tolerance until the estimated error meets the accuracy."""

from abc import abstractmethod
from dataclasses import asdict, dataclass, field

import numpy as np

from governor_mechanism.engines.base import Engine, Runner, RunRequest
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.types import FloatArray

TOLERANCE_SAFETY_FACTOR = 100.0
"""Ratio of accuracy to first tolerance: the estimate is the error of a run with a ten times larger tolerance."""

COMPARISON_TOLERANCE_RATIO = 10.0
"""Ratio of the comparison run's tolerance to that of the certified run."""

JOINTS_OF_FIXED_WORK = 4
"""Number of joints whose equations take as long as the rest of an evaluation."""

MIN_STEP_TOLERANCE = 1e-15
"""Smallest tolerance that is tried: double precision allows no less."""


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
    max_step_work: float = 3e6


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
        worse, better = self.run_once(COMPARISON_TOLERANCE_RATIO * tolerance, is_comparison=True), self.run_once(tolerance)
        times = better.reported_states.times[: min(worse.n_reached, better.n_reached)]
        time_tolerance = self.request.accuracy * self.evaluator.time_scale
        event_time_error, is_near_event = compare_event_logs(better.contact_events, worse.contact_events, times, time_tolerance)
        return self.with_error_estimate(better, worse, is_near_event, event_time_error)

    def _refine_tolerance(self) -> RunResult:
        """Return the first run whose estimate meets the accuracy, or the best run found.

        The tolerance is reduced until max_stagnant_runs in a row bring no improvement, because a single failure may be chance.
        """
        accuracy, n_stagnant = self.request.accuracy, 0
        tolerance = initial_tolerance(accuracy)
        best = better = self.run_certified(tolerance)
        # After enough runs without improvement the error is rounding, not discretisation.
        while (error := best.error_estimate or 0.0) > accuracy and n_stagnant < self.engine.settings.max_stagnant_runs:
            if tolerance == MIN_STEP_TOLERANCE or better.outcome is Outcome.STEP_LIMIT:
                break
            # With a smaller reduction the estimate may fail to improve merely by the chance of the step sizes.
            reduction = min(max(0.5 * accuracy / error, 1e-3), 1 / COMPARISON_TOLERANCE_RATIO)
            tolerance = max(reduction * tolerance, MIN_STEP_TOLERANCE)
            better = self.run_certified(tolerance)
            is_improvement = (better.error_estimate or error) < error and better.n_reached >= best.n_reached
            best, n_stagnant = (better, 0) if is_improvement else (best, n_stagnant + 1)
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
    if status == IntegrationStatus.OUT_OF_RANGE:
        return Outcome.LEFT_RANGE, f"a body flies away, at {time_text}"
    return Outcome.STEP_LIMIT, f"max_steps = {max_steps} reached at {time_text}"

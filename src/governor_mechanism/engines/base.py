"""What all engines share: the request of a run, the checks before it, and its cost and trajectory after it."""

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, ClassVar, final

import numpy as np

from governor_mechanism.errors import MechanismError, UnsupportedEffect
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.mechanics.contact.tolerances import MIN_REBOUND_HEIGHT
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.joints import Joint
from governor_mechanism.model.results.records import Cost, Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.observables.branch_choice import find_unresolved_branch, may_branch
from governor_mechanism.observables.error_scales import EVENT_TIMES, JOINT_GAP
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import DeferredMotionAnalysis, RunResult, StateHistory, modes_at
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.quantities import format_value


@dataclass(frozen=True, kw_only=True)
class ExpectedWork:
    """Work of all runs of a request, as expected after the first of them."""

    first_run_time: float  # time of the first run, s. In a new process it includes what runs only once.
    n_evaluations: float  # number of evaluations of the equations of motion
    n_reported: int  # number of reported times


Reason = str | Callable[[ExpectedWork | None], str]
"""Why an engine was chosen; a function states it with the expected work, or without where nothing is known of it."""


def state_reason(
    reason: Reason,
    work: ExpectedWork | None,  # expected work; None if it is not known
) -> str:
    """Return a reason as text."""
    return reason if isinstance(reason, str) else reason(work)


MAX_REPORTED_TIMES = 5_000_000
"""Largest number of reported times of one run: it bounds the memory of the results."""


@dataclass(frozen=True, kw_only=True)
class RunRequest:
    """Request of a run: reported times (n,) s, accuracy relative to the scales, whether to certify it, reason of the choice."""

    times: FloatArray
    accuracy: float
    certify: bool
    reason: Reason


class Engine(ABC):
    """Abstract engine that runs a scene.

    Concrete engines own their settings, and never import one another.

    Attributes
    ----------
    name
        Name of the engine in scene files and messages.
    effects
        Types of effects the engine can model.
    joints
        Types of joints the engine can model.
    """

    name: ClassVar[str]
    effects: ClassVar[frozenset[type[Effect]]]
    joints: ClassVar[frozenset[type[Joint]]]

    @abstractmethod
    def _run(self, scene: Scene, request: RunRequest) -> Trajectory: ...

    @final
    def run(
        self,
        scene: Scene,
        *,
        times: Sequence[float] | FloatArray | None = None,
        accuracy: float | None = None,
        certify: bool = True,
        reason: Reason = "asked for",
    ) -> Trajectory:
        """Run a scene from its initial state; a run that ends early returns a trajectory with a named outcome.

        Parameters
        ----------
        scene
            Scene to run.
        times
            Reported times, s, ascending from 0 or later, instead of the scene's own; shape (n,).
        accuracy
            Requested accuracy relative to the scales of the readings, between 0 and 1, instead of the scene's own.
        certify
            Whether to estimate the error by a second run and to refine until it meets the accuracy.
        reason
            Why this engine was chosen; recorded in the cost of the run.

        Returns
        -------
        Trajectory
            Motion, readings, outcome, error estimate and cost.

        Raises
        ------
        UnsupportedEffect
            If the engine cannot model an effect, a joint or another property of the scene.
        MechanismError
            If the accuracy or a time is invalid, or the initial state cannot be assembled.
        """
        if not isinstance(scene, Scene):
            raise MechanismError(f"an engine runs a scene, as from load; found {format_value(scene)}")
        if refusal_reason := self.refusal(scene):
            raise UnsupportedEffect(refusal_reason)
        requested_accuracy = scene.run.accuracy if accuracy is None else accuracy
        if not (isinstance(requested_accuracy, int | float) and 0 < requested_accuracy < 1):
            raise MechanismError(f"accuracy must lie between 0 and 1; got {format_value(requested_accuracy)}")
        reported = make_reported_times(scene) if times is None else _validate_times(times)
        return self._run(scene, RunRequest(times=reported, accuracy=requested_accuracy, certify=certify, reason=reason))

    @final
    def refusal(self, scene: Scene) -> str:
        """Return why this engine cannot run a scene, as a sentence; empty if it can.

        Parameters
        ----------
        scene
            Scene to check.

        Returns
        -------
        str
            Reason, or an empty string.
        """
        refusals = _kept_refusals(scene)
        if self not in refusals:
            refusals[self] = self._find_refusal(scene)
        return refusals[self]

    def _find_refusal(self, scene: Scene) -> str:
        effect_types = {type(effect) for effect in scene.effects}
        joint_types = {type(joint) for joint in scene.mechanism.joints}
        if missing := (effect_types - self.effects) | (joint_types - self.joints):
            names = sorted(missing_type.__name__ for missing_type in missing)
            return f"engine {self.name!r} cannot model {names}; choose another engine or remove them from the scene"
        return self._refuses(scene)

    def _refuses(self, scene: Scene) -> str:
        """Return what an engine refuses in addition to unknown effects and joints; empty if nothing."""
        return ""


@once_per_object
def _kept_refusals(scene: Scene) -> dict[Engine, str]:
    """Return the refusals of a scene that are known, by engine."""
    return {}


# The slower an impact, the more its time depends on the rounding of the position. Measured on bounces down to
# rest: 8 to 23.
BOUNCE_ROUNDING_FACTOR = 30.0
"""Error of the time of an impact, in units of the rounding of a position over the duration of the shortest bounce, both in their scales."""


class Runner(ABC):
    """Runs of one scene with an engine, and the trajectory of the best of them, which records name and settings of the engine."""

    setup_time: float = 0.0  # time of preparations that the cost of a run lists separately, s
    iterations: int = 0  # number of iterations of the joint solver, if it iterates
    method: str = ""  # integration method as text, if the engine has a choice
    # work of all runs, as expected after the first of them; None before, and where there is only one
    expected_work: ExpectedWork | None = None

    def __init__(self, engine: str, settings: dict[str, Any], request: RunRequest, evaluator: ReadingEvaluator) -> None:
        self._engine = engine
        self._settings = settings
        self.request = request
        self.evaluator, self.scene, self.n_runs = evaluator, evaluator.scene, 0

    @abstractmethod
    def find_best(self) -> RunResult:
        """Return the best result that the request allows."""

    @abstractmethod
    def count_work(self) -> tuple[int, int, Mapping[str, int]]:
        """Return the steps, the rejected steps, and the evaluations by force law, over all runs."""

    def complete_result(self, best: RunResult) -> RunResult:
        """Return the best result with what only its trajectory needs."""
        return best

    def with_error_estimate(
        self, result: RunResult, other: RunResult, is_near_event: BoolArray, event_time_difference: float, error_ratio: float = 1.0
    ) -> RunResult:
        """Return a result with its errors: a ratio times its difference from another one, at shared times not near an event."""
        indices = np.flatnonzero(~is_near_event)
        observables = [result.observables, other.observables]
        if len(indices) < max(result.n_reached, other.n_reached):
            runs = (result, other)
            observables = [self.evaluator.evaluate(one.reported_states.at(indices), modes_at(one.reported_modes, indices)) for one in runs]
        differences = self.evaluator.compare_observables(*observables)
        if has_contacts(self.scene):
            differences[EVENT_TIMES] = event_time_difference
        floors = self.evaluator.least_errors(result.observables)
        # The gap of the joints is no difference.
        errors = {name: value if name == JOINT_GAP else max(error_ratio * value, floors[name]) for name, value in differences.items()}
        estimate = self.evaluator.to_relative_error(errors, result.observables)
        return replace(result, reading_errors=errors, error_estimate=estimate, n_excluded=int(is_near_event.sum()))

    def with_least_errors(self, result: RunResult, least_errors: Mapping[str, float]) -> RunResult:
        """Return a result whose errors of readings, rates and event times are at least the given ones (SI)."""
        errors = {name: max(error, least_errors.get(name, 0.0)) for name, error in result.reading_errors.items()}
        estimate = max(result.error_estimate or 0.0, self.evaluator.to_relative_error(errors, result.observables))
        return replace(result, reading_errors=errors, error_estimate=estimate)

    def with_bounce_error(self, result: RunResult) -> RunResult:
        """Return a result whose error of event times is at least that by rounding of positions in the shortest bounce of a contact."""
        # Two runs do not show it: from some bounce on they take the same steps, and round alike. The rate of an impact after a bounce of
        # duration T is a T / 2, with the characteristic acceleration a. It may be larger, but is 4 h / T with the height h, too, and lower
        # bounces than the least are not followed.
        impacts: dict[str, list[float]] = {}
        for event in result.contact_events:
            if event.kind is EventKind.IMPACT:
                impacts.setdefault(event.subject, []).append(event.time)
        reported, largest = result.reported_states, 0.0
        length = self.evaluator.mechanism.length_scale
        for times in impacts.values() if len(reported.times) else ():
            shortest, impact_time = min(((end - start, end) for start, end in pairwise(times) if end > start), default=(math.inf, 0.0))
            poses = np.abs(reported.poses[min(int(np.searchsorted(reported.times, impact_time)), len(reported.times) - 1)])
            size = float(np.max(poses * [1.0, 1.0, length], initial=0.0)) / length
            time_of_length = min(self.evaluator.time_scale**2 / shortest, shortest / (4.0 * MIN_REBOUND_HEIGHT))
            largest = max(largest, size * float(np.finfo(np.float64).eps) * time_of_length)
        return self.with_least_errors(result, {EVENT_TIMES: BOUNCE_ROUNDING_FACTOR * largest}) if largest else result

    def run(self) -> Trajectory:
        """Return the trajectory of the best result."""
        start_time, accuracy = time.perf_counter(), self.request.accuracy
        best = self._end_at_unresolved_branch(self.find_best())
        wall_time = time.perf_counter() - start_time - self.setup_time
        steps, rejected, evaluations = self.count_work()
        cost = Cost(
            engine=self._engine,
            reason=state_reason(self.request.reason, self.expected_work),
            step=best.step,
            steps=steps,
            rejected=rejected,
            runs=self.n_runs,
            iterations=self.iterations,
            wall_time=wall_time,
            setup_time=self.setup_time,
            evaluations=evaluations,
            events=len(best.contact_events),
            model_size=self.evaluator.count_model_size(),
            method=self.method,
        )
        error, outcome = best.error_estimate, best.outcome
        if outcome is None:
            outcome = Outcome.NOT_CERTIFIED if error is None else Outcome.DONE if error <= accuracy else Outcome.ACCURACY_MISSED
        settings = {**self._settings, "asked_accuracy": accuracy, "certified": error is not None}
        return self.evaluator.make_trajectory(replace(self.complete_result(best), outcome=outcome), cost=cost, settings=settings)

    def _end_at_unresolved_branch(self, result: RunResult) -> RunResult:
        """Return a result that ends where the motion goes straight through between branches that avoid each other."""
        # Both runs of a certificate go through alike, so that their difference does not show it.
        # The travel of a machine ends before such a configuration; a mechanism of the user's own
        # may pass it.
        states = result.monitor_states
        if not isinstance(states, StateHistory) or all(part.machine != CUSTOM_MACHINE for part in self.scene.parts):
            return result
        if not may_branch(self.scene.mechanism):
            return result
        motion = DeferredMotionAnalysis(self.scene, result, mobility=1).sample_motion()
        pass_times = find_unresolved_branch(self.scene.mechanism, motion)
        if pass_times is None:
            return result
        time, last_time = pass_times
        reported = result.reported_states
        n_kept = int(np.searchsorted(states.times, last_time, side="right"))
        kept_states = reported.at(slice(int(np.searchsorted(reported.times, last_time, side="right"))))
        indices = np.arange(len(states.times))[result.reported_indices][: len(kept_states.times)]
        modes = result.contact_modes[:n_kept]
        return replace(
            result,
            reported_states=kept_states,
            monitor_states=states.at(slice(n_kept)),
            observables=self.evaluator.evaluate(kept_states, modes_at(modes, indices)),
            contact_modes=modes,
            contact_events=tuple(event for event in result.contact_events if event.time <= last_time),
            reported_indices=indices,
            outcome=Outcome.BRANCH_UNRESOLVED,
            detail=f"the mechanism passes a change point at t = {time:.9g} s",
        )


def make_reported_times(scene: Scene) -> FloatArray:
    """Return the reported times (n,) s: multiples of the output interval and the duration; MechanismError above MAX_REPORTED_TIMES."""
    output_interval, duration = scene.run.output_interval, scene.run.duration
    count = int(np.floor(duration / output_interval * (1 + 1e-12)))
    if count > MAX_REPORTED_TIMES:
        raise MechanismError(f"{count} reported times are too many (at most {MAX_REPORTED_TIMES}); increase run.output_interval")
    times: FloatArray = output_interval * np.arange(count + 1, dtype=np.float64)
    if duration - times[-1] > 1e-9 * output_interval:
        return np.append(times, duration)
    times[-1] = duration
    return times


def _validate_times(given: Sequence[float] | FloatArray) -> FloatArray:
    """Return the given times as an array (n,) s, or raise MechanismError."""
    try:
        times = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError, OverflowError) as error:
        raise MechanismError(f"times must be a list of finite numbers (s); got {format_value(given)}") from error
    if times.ndim != 1 or times.size == 0 or not np.all(np.isfinite(times)):
        raise MechanismError(f"times must be a one-dimensional array of finite numbers; got shape {times.shape}")
    if times[0] < 0 or np.any(np.diff(times) <= 0):
        raise MechanismError("times must start at 0 or later and be strictly increasing")
    return times

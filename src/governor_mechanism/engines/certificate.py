"""Error certificate of engines with error control: halve the steps until the error of a run meets the accuracy."""

from __future__ import annotations

import math
import time
from abc import abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from governor_mechanism.engines.base import Engine, ExpectedWork, Runner, RunRequest
from governor_mechanism.errors import MechanismError
from governor_mechanism.integrators.step_record import NO_STEPS, IntegrationStatus, StepRecord, make_step_record
from governor_mechanism.mechanics.contact.event_log import compare_event_logs
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.contacts import output_forces_of
from governor_mechanism.mechanics.kinematics.assembly import mobility_of
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.results.records import FLIGHT_DETAIL, Energy, Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.error_scales import name_of_rate
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.types import FloatArray

ENERGY_ROUNDING_RATIO = 1e-13
"""Drift relative to the largest of the energies that add up to it: rounding, summed over the steps of a run."""


def smallest_error_of_drift(
    energy: Energy,
    spring_energy_scale: float,  # m (L s)^2 with the rate s of the stiffest spring, k = m s^2, J
) -> float:
    """Return the smallest error of readings and rates, relative to their scales, that changes the energy by its drift.

    With the scales m, L and r of mass, length and rate, an error e moves every point by at most e L and changes its velocity by at most
    e L r. That changes a kinetic energy T by sqrt(2 m T) e L r, in units of m (L r)^2 by e sqrt(2 T); the work of loads by e, because r
    is at least their rate; and the energy V of a spring of stiffness k by sqrt(2 k V) e L.

    Result: error relative to the scales; 0 if the drift is rounding.
    """
    if energy.jacobi.size < 2:
        return 0.0
    terms = (energy.kinetic, energy.potential, energy.rotation, energy.jacobi)
    rounding = ENERGY_ROUNDING_RATIO * max(float(np.max(np.abs(term))) for term in terms) / energy.scale
    kinetic = float(np.max(energy.kinetic + energy.rotation)) / energy.scale
    potential = float(np.ptp(energy.potential)) * spring_energy_scale / energy.scale**2
    change_per_error = 1.0 + math.sqrt(2.0 * kinetic) + math.sqrt(2.0 * potential)
    return max(energy.drift - rounding, 0.0) / change_per_error


def describe_stall(scene: Scene, status: IntegrationStatus) -> str:
    """Return why an integration stalled, from its status and from what the scene has."""
    if status == IntegrationStatus.UNDETERMINED:
        return (
            "friction jams parts that slide on each other: rigid bodies do not determine how they go on; reduce the friction of the "
            "[[contact]], or change the angle at which they press"
        )
    if status == IntegrationStatus.TWO_ROLLERS:
        return (
            "more rollers of a [[contact]] with repeat touch at once than it looks at; give it at_once, up to the number of its rollers, "
            "or give them more room"
        )
    if status == IntegrationStatus.ENDLESS_EVENTS:
        return "contacts change between rest and motion without end; change the restitution of a stop, add a dashpot, or try engine impulse"
    return f"its steps became too small, as where {', or '.join(_possible_causes(scene))}"


def _possible_causes(scene: Scene) -> Iterator[str]:
    """Yield what in a scene can make steps too small, with its cure."""
    mechanism = scene.mechanism
    if any(isinstance(joint, RotationalDriver | TranslationalDriver) for joint in mechanism.joints):
        yield "a driver locks the mechanism (shorten its motion; a kinematic analysis names the joint that stays open)"
    if has_contacts(scene):
        yield "stops and friction jam it (widen the stops or reduce the friction)"
    if output_forces_of(scene) or any(not isinstance(element, Force | Torque) for element in mechanism.force_elements):
        yield "a spring or damper is too stiff for the masses (soften it)"
    yield "it comes to a singular configuration or to forces without bounds (change a length, a load or the start)"


FIRST_TOLERANCE_RATIO = 0.01
"""Ratio of the first tolerance to the accuracy: the error of a run is some ten times that of one step."""

# Where order 8 holds, half a step has an error 512 times smaller, so that this tolerance shortens no step.
FINER_TOLERANCE_RATIO = 0.01
"""Ratio of the tolerance of a run to that of the run whose steps it halves."""

MIN_FINER_TOLERANCE = 1e-13
"""Tolerance below which that of a finer run does not fall: near singular configurations rounding exceeds it, and half steps suffice."""

# With the errors e of the run and f of the finer one, |e| <= |e - f| + |f|. Halved steps halve the error at
# least, whatever sets them: the tolerance, a kink, a limit or an event, for which the order is 1 or more. So
# |f| <= |e| / 2, and |e| <= 2 |e - f|. Where the order of 8 holds, the bound is twice the error.
ERROR_TO_DIFFERENCE_RATIO = 2.0
"""Bound of the error of a run, relative to its difference from a run that takes at most half of each of its steps."""

JOINTS_OF_FIXED_WORK = 4
"""Number of joints whose equations take as long as the rest of an evaluation."""

# Measured on chains of 2 to 10 four-bars, of which all bars lie in one line 14 times: 0.04 to 170 of that.
SINGULAR_PASSAGE_SAFETY_FACTOR = 200.0
"""Bound of the error of passing singular configurations, relative to its order of magnitude."""

# A step rounds the state by 0.29 units in the mean square; what its stages contribute is smaller by the size
# of its change.
ROUNDING_SAFETY_FACTOR = 3.0
"""Ratio of the bound of the summed roundings to a unit in the last place times the root of the number of steps."""

CONFIRMED_ACCURACY = 1e-9
"""Accuracy from which on a third run confirms the other two, which may round alike by chance."""

CONFIRMING_TOLERANCE_RATIO = 0.3
"""Ratio of the tolerance of a confirming run to that of the run that it confirms: enough for other steps."""

MIN_STEP_TOLERANCE = 1e-15
"""Smallest tolerance that is tried: double precision allows no less."""

MAX_STEP_TOLERANCE = 1e-6
"""Largest first tolerance: with longer steps the error no longer falls with the order, and no time is saved."""

MAX_DECADE_TOLERANCE = 1e-11
"""Tolerance up to which tolerances are rounded down to a power of ten: rounding makes errors a matter of chance there."""

TOLERANCE_LOOSENING = 10.0
"""Factor from one tolerance to the next where shorter steps do not reach the accuracy: they round more often."""

USELESS_ERROR = 0.1
"""Error, relative to the scales, from which a result claims no digit, and is not worth further runs."""

ORDER = 8
"""Order of the integration: the number of steps grows by the root of this order of the reduction of the tolerance."""

FLIGHT_GOAL = 1e-5
"""Estimate that ends the refinement of a motion in which a body flies away: rounding grows with the distance, and no work undoes it."""

UNCONFIRMED_ERROR = 1.0
"""Error of states that the comparison run does not reach, relative to their scales: nothing is known of them."""

# All runs of a request together may take as many steps as a certificate of full length.
RUNS_PER_CERTIFICATE = 3
"""Work of a certificate in units of its coarser run: the finer one takes two steps for each of its steps."""

FINER_STEP_LIMIT_RATIO, CUT_STEP_LIMIT_RATIO = 4.0, 2.2
"""Largest number of steps of a finer run relative to `max_steps`: twice as many and what it rejects, with more room where the run that it
confirms does not end at the limit.
"""

MAX_STEP_LIMIT = 10**8
"""Largest value of `max_steps`: the steps of a run are recorded, eight bytes each."""

REQUEST_TO_FIRST_RUN_RATIO = 4.5
"""Expected work of a request relative to that of its first run: 3 if the second run confirms it, 7 with a third one."""


@dataclass(frozen=True, kw_only=True)
class ErrorControlSettings:
    """Settings common to the engines with error control; the defaults serve all shipped scenes."""

    max_step_ratio: float = 2.5  # largest step size in units of the scene's step scale, whatever the tolerance
    first_step_ratio: float = 0.004  # first step size as a fraction of the largest one
    # largest step size while event functions are monitored, as a fraction of the largest step: they are
    # sampled five times in a step
    event_step_ratio: float = 0.2
    # spacing of the monitor times in units of the time scale (for reduced also of the coordinate scale):
    # limits and singular configurations are searched between them
    monitor_interval_ratio: float = 0.25
    # step limit from a monitor time to a time before the next one: a handful suffices, except into a change
    # point
    max_interpolation_steps: int = 100
    # successive halvings of the steps without improvement after which the best run is accepted; a single one
    # may be chance
    max_stagnant_runs: int = 2
    # default of `max_steps`, times the number of joints plus `JOINTS_OF_FIXED_WORK`: a certified run ends
    # within some 20 s
    max_step_work: float = 1e6


def initial_tolerance(accuracy: float) -> float:
    """Return the first tolerance to try for an accuracy: the error of one step, relative to the scales of the state."""
    tolerance = max(min(FIRST_TOLERANCE_RATIO * accuracy, MAX_STEP_TOLERANCE), MIN_STEP_TOLERANCE)
    return tolerance if tolerance > MAX_DECADE_TOLERANCE else float(10.0 ** math.floor(math.log10(tolerance) + 1e-9))


@dataclass(frozen=True, kw_only=True)
class ErrorControlledEngine(Engine):
    """Engine with error control: it halves its steps until the error of a run meets the accuracy."""

    tolerance: float | None = None  # error of one step relative to the scales; None chooses it from the accuracy
    max_steps: int | None = None  # largest number of steps of one run; None chooses it from the size of the mechanism
    settings: ErrorControlSettings = field(default_factory=ErrorControlSettings)  # numerical settings

    def __post_init__(self) -> None:
        """Raise MechanismError if the tolerance or the step limit is out of range."""
        name = type(self).__name__
        if self.tolerance is not None and not MIN_STEP_TOLERANCE <= self.tolerance < 1:
            raise MechanismError(f"{name}.tolerance must lie between {MIN_STEP_TOLERANCE:g} and 1; got {self.tolerance!r}")
        if self.max_steps is not None and not 1 <= self.max_steps <= MAX_STEP_LIMIT:
            raise MechanismError(f"{name}.max_steps must lie between 1 and {MAX_STEP_LIMIT}; got {self.max_steps!r}")

    def step_limit(self, scene: Scene) -> int:
        """Return the largest number of steps of one run of a scene."""
        return self.max_steps or int(self.settings.max_step_work / (JOINTS_OF_FIXED_WORK + len(scene.mechanism.joints)))


@dataclass(frozen=True, kw_only=True)
class StepPlan:
    """Steps of a run: those of a coarser run, of which it takes half, its own record, the most it may take, and its halvings."""

    max_steps: int
    level: int = 0
    coarser_steps: StepRecord = NO_STEPS
    steps: StepRecord = NO_STEPS

    def without_record(self) -> StepPlan:
        """Return a plan of the same steps, which are not recorded again."""
        return replace(self, steps=NO_STEPS)


@dataclass(frozen=True, kw_only=True)
class RecordedRun:
    """Result of a run, its tolerance and plan, and the number of its steps, rejected ones included."""

    result: RunResult
    tolerance: float
    plan: StepPlan
    n_steps: int


class CertifiedRunner(Runner):
    """Runs of one scene, each with at most half of every step of the one before, until the error of one meets the requested accuracy."""

    singular_violation: float = 0.0
    """Violation of the constraints near singular configurations, relative to the length scale."""

    def __init__(self, engine: ErrorControlledEngine, request: RunRequest, evaluator: ReadingEvaluator) -> None:
        settings = vars(engine) | {"settings": dict(vars(engine.settings))}  # numbers and words, which `asdict` would copy one by one
        super().__init__(engine.name, settings, request, evaluator)
        self.engine, self.max_steps = engine, engine.step_limit(evaluator.scene)

    @abstractmethod
    def count_steps(self) -> int:
        """Return the steps of all runs so far, rejected ones included."""

    @abstractmethod
    def run_once(self, tolerance: float, plan: StepPlan) -> RunResult:
        """Run with a tolerance and a plan of the steps."""

    def find_best(self) -> RunResult:
        """Return the result at the tolerance of the engine, or at one that meets the accuracy."""
        tolerance = self.engine.tolerance or initial_tolerance(self.request.accuracy)
        if not self.request.certify:
            return self.run_once(tolerance, StepPlan(max_steps=self.max_steps))
        if self.engine.tolerance is not None:
            return self._certify(tolerance)
        best, n_stagnant = self._halve_steps(tolerance), 0
        # More steps round more often: where they do not help, fewer may.
        while self._misses(best) and self._may_improve(best) and tolerance < MAX_STEP_TOLERANCE:
            tolerance *= TOLERANCE_LOOSENING
            better = _choose_better(best, self._halve_steps(tolerance))
            n_stagnant = n_stagnant + 1 if better is best and not _is_unconfirmed(best) else 0
            best = better
            if n_stagnant >= self.engine.settings.max_stagnant_runs:
                break
        return best

    def _may_improve(self, result: RunResult) -> bool:
        """Return whether other tolerances may give a better result: not at the step limit, nor where not even a digit is left."""
        return result.outcome is not Outcome.STEP_LIMIT and (_is_unconfirmed(result) or (result.error_estimate or 0.0) < USELESS_ERROR)

    def _misses(self, result: RunResult) -> bool:
        """Return whether the error of a result may exceed the requested accuracy, or where a body flies away, what its rounding allows."""
        goal = max(self.request.accuracy, FLIGHT_GOAL) if result.detail.startswith(FLIGHT_DETAIL) else self.request.accuracy
        return (result.error_estimate or 0.0) > goal

    def _halve_steps(self, tolerance: float) -> RunResult:
        """Return the first run, of those that halve the steps of the one before, that meets the accuracy, or the best one."""
        n_steps_before = self.count_steps()
        coarse = self._start(tolerance)
        fine = self._halve(coarse)
        best_run = coarse
        best = self._compare(coarse, fine)
        n_stagnant = 0
        while self._misses(best) and n_stagnant < self.engine.settings.max_stagnant_runs:
            n_used = self.count_steps() - n_steps_before
            if best.outcome is Outcome.STEP_LIMIT or n_used + 2 * fine.n_steps > RUNS_PER_CERTIFICATE * self.max_steps:
                break
            # Shorter steps round more often, and their error of passing singular configurations is larger: beyond the best estimate they
            # do not help.
            useful_error = max(self.request.accuracy, best.error_estimate or 0.0)
            if self._smallest_tolerance(fine.result) >= fine.tolerance or self._estimate_passage_error(fine) > useful_error:
                break
            coarse, fine = fine, self._halve(fine)
            better = _choose_better(best, self._compare(coarse, fine))
            n_stagnant = n_stagnant + 1 if better is best else 0
            best_run, best = (best_run, best) if better is best else (coarse, better)
        if best.outcome is Outcome.STEP_LIMIT or self.request.accuracy > CONFIRMED_ACCURACY:
            return best
        return self._confirm(best_run, best, fine)

    def _confirm(self, run: RecordedRun, result: RunResult, fine: RecordedRun) -> RunResult:
        """Return the result of a run whose errors are at least those by its difference from another finer run, or from one more run."""
        if fine.plan.level > run.plan.level + 1:
            other = fine
        elif run.plan.level:
            other = self._halve(fine)
        else:
            tolerance = max(CONFIRMING_TOLERANCE_RATIO * run.tolerance, MIN_STEP_TOLERANCE)
            other = self._record(tolerance, StepPlan(max_steps=fine.plan.max_steps))
        confirmed = self._compare(run, other)
        estimate = max(result.error_estimate or 0.0, confirmed.error_estimate or 0.0)
        detail = result.detail or confirmed.detail
        return replace(self.with_least_errors(result, confirmed.reading_errors), error_estimate=estimate, detail=detail)

    def _certify(self, tolerance: float) -> RunResult:
        """Return a run at a tolerance, with its error from one that halves its steps."""
        coarse = self._start(tolerance)
        return self._compare(coarse, self._halve(coarse))

    def _start(self, tolerance: float) -> RecordedRun:
        """Return a first run."""
        start_time = time.perf_counter()
        run = self._record(tolerance, StepPlan(max_steps=self.max_steps, steps=make_step_record(self.max_steps)))
        if self.expected_work is None:
            self.expected_work = self._expect_work(time.perf_counter() - start_time)
        return run

    def _halve(self, coarse: RecordedRun) -> RecordedRun:
        """Return a run that takes at most half of each step of another one."""
        smallest = max(MIN_FINER_TOLERANCE, self._smallest_tolerance(coarse.result))
        tolerance = min(coarse.tolerance, max(FINER_TOLERANCE_RATIO * coarse.tolerance, smallest))
        is_cut = coarse.result.outcome is Outcome.STEP_LIMIT
        max_steps = int((CUT_STEP_LIMIT_RATIO if is_cut else FINER_STEP_LIMIT_RATIO) * self.max_steps)
        steps, level = make_step_record(max_steps), coarse.plan.level + 1
        return self._record(tolerance, StepPlan(max_steps=max_steps, level=level, coarser_steps=coarse.plan.steps, steps=steps))

    def _record(self, tolerance: float, plan: StepPlan) -> RecordedRun:
        n_steps_before = self.count_steps()
        result = self.run_once(tolerance, plan)
        return RecordedRun(result=result, tolerance=tolerance, plan=plan, n_steps=self.count_steps() - n_steps_before)

    def _compare(self, coarse: RecordedRun, fine: RecordedRun) -> RunResult:
        """Return the result of the coarser of two runs with its errors, estimated by their difference."""
        result, finer = coarse.result, fine.result
        times = result.reported_states.times[: min(result.n_reached, finer.n_reached)]
        time_tolerance = self.request.accuracy * self.evaluator.time_scale
        event_time_difference, is_near_event = compare_event_logs(result.contact_events, finer.contact_events, times, time_tolerance)
        certified = self.with_error_estimate(result, finer, is_near_event, event_time_difference, ERROR_TO_DIFFERENCE_RATIO)
        if passage_error := self._estimate_passage_error(coarse):
            scales = result.observables.scales
            names = [*result.observables.readings, *map(name_of_rate, result.observables.rates)]
            certified = self.with_least_errors(certified, {name: passage_error * scales[name] for name in names})
        certified = self.with_bounce_error(certified)
        certified = self._with_energy_check(self._with_rounding(certified, coarse.n_steps))
        n_missing = result.n_reached - finer.n_reached
        # Runs that both end early may do so on either side of a reported time.
        return certified if n_missing <= (result.outcome is not None) else _with_unconfirmed_end(certified, finer)

    def _expect_work(self, first_run_time: float) -> ExpectedWork:
        """Return the expected work of the request after its first run, which took a time (s)."""
        n_evaluations = self.count_work()[2]["equations of motion"]
        ratio, n_reported = REQUEST_TO_FIRST_RUN_RATIO, len(self.request.times)
        return ExpectedWork(first_run_time=first_run_time, n_evaluations=ratio * n_evaluations, n_reported=n_reported)

    def _estimate_passage_error(self, run: RecordedRun) -> float:
        """Return the error of passing singular configurations, relative to the scales."""
        # At an angle e (rad) from one, a constraint violation d changes accelerations by d / e^3.
        # Each passage adds its own error, by chance, which two runs may share.
        scales = run.result.observables.scales
        motion_rate = max((scales[name_of_rate(name)] / scales[name] for name in run.result.observables.rates), default=0.0)
        amplification = motion_rate * float(run.plan.steps.singular_amplification[0])
        return SINGULAR_PASSAGE_SAFETY_FACTOR * self.singular_violation * amplification

    def _with_rounding(self, result: RunResult, n_steps: int) -> RunResult:
        """Return a result whose errors are at least the roundings of readings and times over its steps, which add up like a random walk."""
        relative = ROUNDING_SAFETY_FACTOR * float(np.finfo(np.float64).eps) * math.sqrt(n_steps)
        readings = result.observables.readings
        rates = result.observables.rates
        times = result.reported_states.times
        sizes = {name: np.abs(values) + np.abs(times * rates.get(name, 0.0)) for name, values in readings.items()}
        return self.with_least_errors(result, {name: relative * float(size.max(initial=0.0)) for name, size in sizes.items()})

    def _with_energy_check(self, result: RunResult) -> RunResult:
        """Return a result whose estimate is at least the error that explains its energy drift, unless drivers alone give the motion."""
        estimate, energy = result.error_estimate or 0.0, result.observables.energy
        error = smallest_error_of_drift(energy, self.evaluator.energy_scale)
        if error <= estimate or mobility_of(self.evaluator.mechanism) == 0:
            return result
        detail = f"the energy balance drifts by {energy.drift:.1e} of its scale, more than errors of {estimate:.1e} in the readings explain"
        return replace(result, error_estimate=error, detail=result.detail or (detail if error > self.request.accuracy else ""))

    def _smallest_tolerance(self, result: RunResult) -> float:
        """Return the smallest tolerance for a motion: far from the origin, double precision resolves positions less well."""
        positions = np.abs(result.reported_states.poses[..., :2])
        distance = float(np.max(positions, initial=0.0)) / self.evaluator.mechanism.length_scale
        return max(MIN_STEP_TOLERANCE, float(np.finfo(np.float64).eps) * distance)


def _with_unconfirmed_end(result: RunResult, finer: RunResult) -> RunResult:
    """Return a result that does not claim the states after the end of the run that it is compared with."""
    detail = f"the run that it is compared with ends earlier, after {finer.n_reached} of {result.n_reached} reported times: {finer.detail}"
    estimate = max(result.error_estimate or 0.0, UNCONFIRMED_ERROR)
    return replace(result, error_estimate=estimate, detail=result.detail or detail)


def _is_unconfirmed(result: RunResult) -> bool:
    """Return whether a result has states that the run it is compared with does not reach, and which else agree."""
    return result.error_estimate == UNCONFIRMED_ERROR


def _choose_better(best: RunResult, other: RunResult) -> RunResult:
    """Return the other result if it has a smaller error estimate and gets as far, else the best one so far."""
    estimate = best.error_estimate or 0.0
    return other if (other.error_estimate or estimate) < estimate and other.n_reached >= best.n_reached else best


def speed_jump_work(evaluator: ReadingEvaluator, time: float, find_poses: Callable[[], FloatArray]) -> float:
    """Return the work (J) that jumps of given spindle speeds do at a time on the bodies of loaded planes, at poses (bodies, 3)."""
    work = 0.0
    for rotation in evaluator.rotations:
        if rotation.plane.is_loaded and rotation.speed_function is not None and not rotation.speed_function.is_constant:
            before, after = rotation.speed_function.limits_at(time)
            if before != after:
                work += 0.5 * float(rotation.inertia(find_poses()[np.newaxis])[0]) * (after**2 - before**2)
    return work


STALLS = (IntegrationStatus.STALLED, IntegrationStatus.ENDLESS_EVENTS, IntegrationStatus.UNDETERMINED, IntegrationStatus.TWO_ROLLERS)
"""How integrations end that cannot go on."""


def describe_end(scene: Scene, status: IntegrationStatus, time_text: str, max_steps: int) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time; without outcome if it reached its end."""
    if status == IntegrationStatus.DONE:
        return None, ""
    if status == IntegrationStatus.STIFF:
        return Outcome.STIFF, f"at {time_text}"
    if status in STALLS:
        return Outcome.STALLED, f"{describe_stall(scene, status)}, at {time_text}"
    if status in (IntegrationStatus.OUT_OF_RANGE, IntegrationStatus.LEFT_LIMITS):
        return Outcome.LEFT_RANGE, f"{FLIGHT_DETAIL}, at {time_text}"
    return Outcome.STEP_LIMIT, f"max_steps = {max_steps} reached at {time_text}"

"""Error and time of every engine over a ladder of settings.

The reference is a multibody run at a tight tolerance, confirmed by another engine. Every setting is compared with it. Runs are not
certified: the error is measured here.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import accumulate

import numpy as np

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.plain_runs import FittedParameter, compare_runs, fit_slope
from governor_mechanism.studies.work_precision_results import AccuracyStudy, EngineVariant, ErrorReference, WorkPrecisionPoint
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value

LADDER_TOLERANCES = tuple(10.0**-k for k in range(2, 15))
"""Tolerances; where they do not limit the step, several give the same run, which is listed once."""

LADDER_STEP_RATIOS = tuple(0.25 / 2**k for k in range(17))
"""Steps in time scales of the scene."""


@dataclass(frozen=True)
class SettingsLadder:
    """Settings of one engine variant, coarse first; `varies_step` if they are steps, so that an order can be fitted."""

    name: str
    settings: tuple[tuple[str, Engine], ...]
    varies_step: bool


def build_ladders(scene: Scene) -> Iterator[SettingsLadder]:
    """Yield the ladders of every engine, the fastest first."""

    def tolerance_ladder(engine_class: type[ReducedEngine | MultibodyEngine]) -> SettingsLadder:
        settings = tuple((f"tolerance {tolerance:g}", engine_class(tolerance=tolerance)) for tolerance in LADDER_TOLERANCES)
        return SettingsLadder(engine_class.name, settings, varies_step=False)

    def step_ladder(name: str, engine: ImpulseEngine) -> SettingsLadder:
        steps = [ratio * time_scale(scene) for ratio in LADDER_STEP_RATIOS]
        return SettingsLadder(name, tuple((format_step(h), replace(engine, step=h)) for h in steps), varies_step=True)

    yield tolerance_ladder(ReducedEngine)
    yield tolerance_ladder(MultibodyEngine)
    yield step_ladder("impulse extrapolated", ImpulseEngine(step=1.0, runs=3))
    yield step_ladder("impulse staggered", ImpulseEngine(step=1.0, runs=1))
    yield step_ladder("impulse plain", ImpulseEngine(step=1.0, plain=True))


def format_step(step: float) -> str:
    """Return a step (s) as text, such as "step 2.5 ms" or "step 78 µs"."""
    return f"step {step * 1e3:.3g} ms" if step >= 1e-4 else f"step {step * 1e6:.3g} µs"


REFERENCE_TOLERANCE = 1e-14
"""Tolerance of the reference and of the run that confirms it."""

MAX_COMPARED_TIMES = 200
"""Maximum number of intervals between the compared times; more would cost every engine time of their own."""

MAX_SETTING_TIME = 1.0
"""Time (s) that a setting may take; a ladder ends before a setting that would take longer."""

MIN_TIMING_DURATION = 0.15
MIN_REPEATS = 3
MAX_REPEATS = 7
"""Time (s) for which a setting is repeated, the minimum and the maximum number of repeats."""

MAX_CONFIRMATION_ERROR = 1e-3
"""Largest difference from the reference with which an engine confirms it."""

MIN_REACHED_FRACTION = 0.5
"""Fraction of the compared times below which the study is repeated on the shorter duration."""

MAX_COMPARED_JOINT_GAP = 1.0
"""Joint gap (in length scales of the mechanism) above which a run is invalid."""

MAX_STAGNANT_SETTINGS, IMPROVEMENT_RATIO = 2, 0.95
"""Consecutive settings without an improvement by IMPROVEMENT_RATIO, or one whose joint gaps do not decrease either, after which a ladder of
steps continues with more iterations of the joint solver; it ends at MAX_ITERATION_FACTOR.
"""

JOINT_GAP_ROUNDING = 1e-11
"""Joint gap (in length scales of the mechanism) that is rounding."""

ITERATION_FACTOR, MAX_ITERATION_FACTOR = 4, 64
"""Factor on the iterations of the joint solver, each time and in total."""

SAME_RUN_TOLERANCE = 1e-6
"""Relative difference of the errors below which two settings with equally many evaluations are the same run."""

MAX_ASYMPTOTIC_ERROR, N_FITTED_SETTINGS = 0.03, 5
"""Error below which an order is fitted, and number of the finest steps used; no ladder ends above this error."""

ESTIMATE_TOLERANCE_RATIO = 10.0
"""Ratio of the tolerances behind an error estimate: it is the error of the looser run, so a confirmed reference is better by this."""

SCENE_OUTCOMES = (Outcome.DONE, Outcome.NOT_CERTIFIED, Outcome.ACCURACY_MISSED, Outcome.LEFT_RANGE)
"""Outcomes that are due to the scene, not to the engine."""


def run_accuracy_study(
    scene: Scene,
    max_time: float = MAX_SETTING_TIME,  # maximum time of one run of a setting, s
    # called with the number of processed settings and the number of all
    progress: Callable[[int, int], None] | None = None,
    timer: Callable[[], float] = time.perf_counter,  # clock that measures the runs, s
) -> AccuracyStudy:
    """Run a scene by each engine at each setting and measure errors and times."""
    if not (isinstance(max_time, int | float) and 0 < max_time < math.inf):
        raise MechanismError(f"the maximum time of a setting must be a positive number of seconds; got {format_value(max_time)}")
    n_times = min(len(make_reported_times(scene)) - 1, MAX_COMPARED_TIMES) + 1
    benchmark = ErrorBenchmark(scene, np.linspace(0.0, scene.run.duration, n_times), float(max_time), timer=timer)
    reference_run = benchmark.reference_run
    early_end_message = reference_run.message if reference_run.outcome is Outcome.LEFT_RANGE else ""
    if early_end_message and len(reference_run.times) < MIN_REACHED_FRACTION * n_times:
        benchmark = ErrorBenchmark(scene, np.linspace(0.0, reference_run.times[-1], n_times), float(max_time), timer=timer)
    ladders = list(build_ladders(scene))
    *starts, total = accumulate((len(ladder.settings) for ladder in ladders), initial=0)
    variants = []

    def report_progress(n_before: int, n_settings: int) -> None:
        if progress is not None:
            progress(n_before + n_settings, total)

    for ladder, start in zip(ladders, starts, strict=True):
        variants.append(benchmark.run_ladder(ladder, partial(report_progress, start)))
        report_progress(start, len(ladder.settings))
    return AccuracyStudy(
        scene=scene,
        reference=confirm_by_impulse(benchmark.error_reference, variants),
        variants=tuple(variants),
        n_samples=len(benchmark.reference_run.times),
        time_scale=benchmark.time_scale,
        early_end_message=early_end_message,
    )


class ErrorBenchmark:
    """Measures engines against a reference, at most max_time (s) a setting, down to target_error or what the reference resolves."""

    def __init__(
        self, scene: Scene, times: FloatArray, max_time: float, target_error: float = 0.0, timer: Callable[[], float] = time.perf_counter
    ) -> None:
        self.scene = scene
        self.times = times
        self.max_time = max_time
        self.target_error = target_error
        self.timer = timer
        self.time_scale, self.length_scale = time_scale(scene), scene.mechanism.length_scale
        engine = MultibodyEngine(tolerance=REFERENCE_TOLERANCE)
        refusal = engine.refusal(scene)
        if refusal:
            raise MechanismError(f"there is no reference run to measure errors against: {refusal}")
        self.reference_run = engine.run(scene, times=times)
        if len(self.reference_run.times) < 2 or self.reference_run.outcome not in SCENE_OUTCOMES:
            raise MechanismError(f"there is no reference run to measure errors against: {self.reference_run.message}")
        self.error_reference = self._confirm_by_reduced(self.reference_run.error_estimate or 0.0)

    def _confirm_by_reduced(self, estimate: float) -> ErrorReference:
        """Return the reference, confirmed by the reduced engine if that supports the scene."""
        unconfirmed = ErrorReference(
            engine=MultibodyEngine.name, tolerance=REFERENCE_TOLERANCE, estimate=estimate, error=max(estimate, float(np.finfo(float).eps))
        )
        reduced_engine = ReducedEngine(tolerance=REFERENCE_TOLERANCE)
        try:
            run = None if reduced_engine.refusal(self.scene) else reduced_engine.run(self.scene, times=self.times, certify=False)
        except GovernorMechanismError:
            return unconfirmed
        if run is None or self._early_end_message(run):
            return unconfirmed
        errors, event_time_error = compare_runs(run, self.reference_run)
        difference = max(*errors.values(), (event_time_error or 0.0) / self.time_scale)
        error = max(unconfirmed.error / ESTIMATE_TOLERANCE_RATIO, difference)
        return replace(unconfirmed, confirmed_by=reduced_engine.name, confirmation_error=difference, error=error)

    def run_ladder(self, ladder: SettingsLadder, report_progress: Callable[[int], None]) -> EngineVariant:
        """Run the settings of a ladder from coarse to fine until more of them are of no use."""
        refusal = ladder.settings[0][1].refusal(self.scene)
        points: list[WorkPrecisionPoint] = []
        notes: dict[str, list[str]] = {}
        n_stagnant = 0
        time_limit = None
        iteration_factor = 1
        for index, (setting, engine) in enumerate(() if refusal else ladder.settings):
            report_progress(index)
            if isinstance(engine, ImpulseEngine) and iteration_factor > 1:
                engine = replace(engine, iterations=iteration_factor * engine.iterations)
            cost_ratio = 2.0 if ladder.varies_step else 1.0
            if points and cost_ratio * points[-1].wall_time > self.max_time:
                time_limit = self.max_time
                break
            started = self.timer()
            try:
                result = self._measure_setting(ladder.name, setting, engine, points[-1] if points else None)
            except GovernorMechanismError as error:
                if not points:
                    refusal = str(error)
                    break
                result = str(error)
            if result is None:
                continue
            if isinstance(result, str):
                notes.setdefault(result, []).append(setting)
                iteration_factor *= ITERATION_FACTOR if ladder.varies_step and iteration_factor < MAX_ITERATION_FACTOR else 1
                if cost_ratio * (self.timer() - started) > self.max_time:
                    time_limit = self.max_time
                    break
                continue
            smallest_error = min((point.max_error for point in points), default=math.inf)
            points.append(result)
            if result.max_error < max(self.error_reference.resolvable_error, self.target_error):
                break
            # The joint gap decreases if it is at most half that of the coarser setting, or below rounding.
            is_gap_decreasing = len(points) < 2 or result.joint_gap <= max(0.5 * points[-2].joint_gap, JOINT_GAP_ROUNDING)
            is_coarse = smallest_error > MAX_ASYMPTOTIC_ERROR and is_gap_decreasing
            n_stagnant = 0 if is_coarse or result.max_error < IMPROVEMENT_RATIO * smallest_error else n_stagnant + 1
            if ladder.varies_step and n_stagnant and (n_stagnant == MAX_STAGNANT_SETTINGS or not is_gap_decreasing):
                if iteration_factor >= MAX_ITERATION_FACTOR:
                    break
                n_stagnant, iteration_factor = 0, ITERATION_FACTOR * iteration_factor
        order = fit_order(points, self.error_reference.resolvable_error) if ladder.varies_step else None
        return EngineVariant(
            name=ladder.name, points=tuple(points), order=order, refusal=refusal, notes=_format_notes(notes), time_limit=time_limit
        )

    def _measure_setting(
        self, variant: str, setting: str, engine: Engine, previous: WorkPrecisionPoint | None
    ) -> WorkPrecisionPoint | str | None:
        """Return the measured setting, or why it cannot be measured; None if the previous setting gave the same run."""
        run, first_time = self._run_timed(engine)
        shortfall = self._early_end_message(run)
        if shortfall:
            return shortfall
        if isinstance(engine, ImpulseEngine):  # Steps end at reported times and may be shorter than requested.
            setting = format_step(run.cost.step * 2 ** (engine.levels - 1))
        if run.cost.iterations > ImpulseEngine.iterations:
            setting = f"{setting}, {run.cost.iterations} iterations"
        errors, event_time_error = compare_runs(run, self.reference_run)
        joint_gap = float(np.max(run.joint_gap)) / self.length_scale
        if not all(map(math.isfinite, (*errors.values(), run.energy.drift))) or not joint_gap < MAX_COMPARED_JOINT_GAP:
            return "the joints open: the solution is lost"
        worst_reading = max(errors, key=lambda name: errors[name])
        error = errors[worst_reading]
        evaluations = run.cost.evaluations.get("equations of motion", run.cost.steps)
        if previous and evaluations == previous.evaluations and math.isclose(error, previous.error, rel_tol=SAME_RUN_TOLERANCE):
            return None
        wall_times = self._measure_wall_times(engine, first_time)
        return WorkPrecisionPoint(
            variant=variant,
            engine=engine,
            setting=setting,
            error=error,
            worst_reading=worst_reading,
            errors=errors,
            event_time_error=event_time_error,
            max_error=max(error, (event_time_error or 0.0) / self.time_scale),
            wall_time=wall_times[0],
            n_repeats=len(wall_times),
            wall_times=wall_times,
            step=run.cost.step,
            evaluations=evaluations,
            joint_gap=joint_gap,
            drift=run.energy.drift,
        )

    def _measure_wall_times(self, engine: Engine, first_time: float) -> tuple[float, ...]:
        """Return the times (s) of several runs, ascending; the first run is a warm-up unless it takes too long to repeat."""
        if first_time > self.max_time:
            return (first_time,)
        wall_times = [self._run_timed(engine)[1] for _ in range(MIN_REPEATS)]  # one run may be delayed by other processes
        while sum(wall_times) < MIN_TIMING_DURATION and len(wall_times) < MAX_REPEATS:
            wall_times.append(self._run_timed(engine)[1])
        return tuple(sorted(wall_times))

    def _run_timed(self, engine: Engine) -> tuple[Trajectory, float]:
        started = self.timer()
        run = engine.run(self.scene, times=self.times, certify=False)
        return run, self.timer() - started

    def _early_end_message(self, run: Trajectory) -> str:
        """Return the message of a run that ends before the reference does; empty otherwise."""
        is_too_short = len(self.reference_run.times) - len(run.times) > 1
        return run.message if run.outcome not in SCENE_OUTCOMES or is_too_short else ""


def _format_notes(notes: Mapping[str, list[str]]) -> tuple[str, ...]:
    """Return one sentence per reason with the settings concerned."""
    return tuple(f"{settings[0]}{f' to {settings[-1]}' if len(settings) > 1 else ''}: {reason}" for reason, settings in notes.items())


def fit_order(points: list[WorkPrecisionPoint], floor: float) -> FittedParameter | None:
    """Return the order of the error in the step: the log-log slope over the longest sequence of decreasing errors."""
    sequences: list[list[WorkPrecisionPoint]] = [[]]
    previous_error = math.inf
    for point in points:
        is_asymptotic = floor < point.error < MAX_ASYMPTOTIC_ERROR
        if not is_asymptotic or point.error > IMPROVEMENT_RATIO * previous_error:
            sequences.append([])
        if is_asymptotic:
            sequences[-1].append(point)
        previous_error = point.error
    fitted_points = max(sequences, key=len)[-N_FITTED_SETTINGS:]
    if len(fitted_points) < 3:
        return None
    return fit_slope(*(np.log([getattr(point, name) for point in fitted_points]) for name in ("step", "error")))


def confirm_by_impulse(reference: ErrorReference, variants: list[EngineVariant]) -> ErrorReference:
    """Return the reference, confirmed by the best impulse run if the reduced engine cannot confirm it."""
    if reference.confirmation_error is not None:
        return reference
    best_points = [variant.best_point for variant in variants if variant.name.startswith("impulse") and variant.best_point]
    closest = min(best_points, key=lambda point: point.max_error, default=None)
    if closest is None or closest.max_error > MAX_CONFIRMATION_ERROR:
        return reference
    return replace(reference, confirmed_by=closest.variant, confirmation_error=closest.max_error)

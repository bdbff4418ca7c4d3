"""Validity of error estimates: certified runs against exact solutions, or against two references that confirm each other."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exact_motions import MOTIONS, ExactMotion
from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.mechanics.contact.event_log import compare_event_logs, drop_cancelled_events
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.output_variables import CylinderPressure
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.error_scales import EVENT_TIMES, JOINT_GAP, name_of_rate
from random_scenes import RandomScene

ENGINES = ("reduced", "multibody", "impulse")

LOOSE_TOLERANCE, TIGHT_TOLERANCE = 1e-14, 1e-15
"""Tolerances of the reference solutions."""

LARGEST_STEP_RATIO, SHORTEST_STEP_RATIO = 1 / 4, 1 / 6
"""Largest steps of the reference solutions relative to those of a run: where these limit a run, a tolerance alone improves nothing."""

REFERENCE_STEP_RATIO = 10
"""Step limit of a reference relative to that of a run."""

MAX_ERROR_RATIO = 3.0
"""Largest accepted ratio of the true error of a run to its estimate."""

EXACT_DOUBT = 2e-14
"""Error of an exact solution relative to the scales: its readings are rounded to double precision."""

MAX_STEPS = {"reduced": 20_000, "multibody": 20_000, "impulse": 20_000}
"""Step limit of one run, of `impulse` of all runs together: at least ten times what a scene of a few oscillations needs."""

ROUNDING_TOLERANCE = 1e-13
"""Error relative to the scales that is rounding: no estimate is smaller."""

SCENE_OUTCOMES = (Outcome.NOT_CERTIFIED, Outcome.LEFT_RANGE, Outcome.STALLED)
"""Outcomes that a scene determines: its end, the end of its range, or a locking driver."""

COMPLETE_OUTCOMES = (Outcome.DONE, Outcome.ACCURACY_MISSED, Outcome.LEFT_RANGE)
"""Outcomes with which a run claims to have reached its end or the end of the range."""

DERIVED_EVENT_KINDS = (EventKind.TURNING_POINT, EventKind.CHANGE_POINT)
"""Events computed from the motion afterwards; error estimates refer to the others."""


def build_engine(name: str) -> Engine:
    """Return the engine of a name with a step limit."""
    engine_classes: Mapping[str, Any] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}
    engine: Engine = engine_classes[name](max_steps=MAX_STEPS[name])
    return engine


def reference_engine(name: str, tolerance: float, step_ratio: float) -> Engine:
    """Return the engine of reference solutions: with a tolerance, and a largest step relative to that of other runs."""
    engine: Any = build_engine(name)
    settings = replace(engine.settings, max_step_ratio=step_ratio * engine.settings.max_step_ratio)
    return replace(engine, tolerance=tolerance, settings=settings, max_steps=REFERENCE_STEP_RATIO * MAX_STEPS[name])


def engines_of(scene: Scene) -> tuple[str, ...]:
    """Return the names of the engines that take a scene."""
    return tuple(name for name in ENGINES if not build_engine(name).refusal(scene))


def certified_events(run: Trajectory, min_separation: float = 0.0) -> tuple[Event, ...]:
    """Return the events that an error estimate refers to, without those reversed within `min_separation` (s)."""
    if not has_contacts(run.scene):
        return ()
    return drop_cancelled_events([event for event in run.events if event.kind not in DERIVED_EVENT_KINDS], min_separation)


# --- differences of two motions ------------------------------------------------------------------------------------------


def relative_differences(run: Trajectory, other: Trajectory | ExactMotion, accuracy: float) -> dict[str, float]:
    """Return the largest difference of each reading, of each rate and of the event times of two motions, relative to the scales.

    Readings and rates are compared at common reported times away from events, as an error estimate compares them. An exact motion has
    no contact events.
    """
    t_scale = time_scale(run.scene)
    n_shared, time_tolerance = min(len(run.times), len(other.times)), accuracy * t_scale
    expected_events = () if isinstance(other, ExactMotion) else certified_events(other, time_tolerance)
    events = certified_events(run, time_tolerance)
    event_time_error, is_near_event = compare_event_logs(expected_events, events, run.times[:n_shared], time_tolerance)
    found = {EVENT_TIMES: event_time_error / t_scale} if has_contacts(run.scene) else {}
    pairs = {name: (values, other.readings[name]) for name, values in run.readings.items()}
    pairs |= {name_of_rate(name): (values, other.rates[name]) for name, values in run.rates.items()}
    for name, (values, expected) in pairs.items():
        is_compared = ~is_near_event & ~is_in_another_stroke(run, other, name, n_shared)
        largest = float(np.max(np.abs(values[:n_shared] - expected[:n_shared])[is_compared], initial=0.0)) / run.scales[name]
        found[name] = largest if math.isfinite(largest) else math.inf
    return found


def is_in_another_stroke(run: Trajectory, other: Trajectory | ExactMotion, name: str, n_shared: int) -> NDArray[np.bool_]:
    """Return where a reading is a pressure, which jumps at dead centres, and only one of two motions has passed one."""
    for output in run.scene.mechanism.derived_readings:
        if output.name == name and isinstance(output, CylinderPressure):
            strokes, others = (np.floor(one.readings[output.reading][:n_shared] / np.pi) for one in (run, other))
            return np.asarray(strokes != others)
    return np.zeros(n_shared, dtype=np.bool_)


def max_difference(run: Trajectory, other: Trajectory | ExactMotion, accuracy: float) -> float:
    """Return the largest difference between two runs of a scene relative to the scales, as an error estimate defines it."""
    return max(relative_differences(run, other, accuracy).values(), default=0.0)


# --- reference solutions --------------------------------------------------------------------------------------------------


def every_second_time(run: Trajectory) -> Trajectory:
    """Return every second reported time of a run."""
    return replace(
        run,
        times=run.times[::2],
        readings={name: values[::2] for name, values in run.readings.items()},
        rates={name: values[::2] for name, values in run.rates.items()},
    )


@dataclass(eq=False)
class ReferenceSolutions:
    """Reference solutions of a scene by each available method.

    An exact motion needs no confirmation. Otherwise the reference of a run is a solution by another engine, or by other steps, which a
    second solution confirms.
    """

    scene: Scene
    exact: ExactMotion | None = None

    @cached_property
    def reduced(self) -> Trajectory | None:
        """Return the solution by one coordinate, or None."""
        return self._run_reference(reference_engine("reduced", LOOSE_TOLERANCE, LARGEST_STEP_RATIO))

    @cached_property
    def multibody(self) -> Trajectory | None:
        """Return the solution by bodies and joints, or None."""
        return self._run_reference(reference_engine("multibody", LOOSE_TOLERANCE, LARGEST_STEP_RATIO))

    @cached_property
    def refined_multibody(self) -> Trajectory | None:
        """Return the solution by bodies and joints with other steps: twice as many reported times and another tolerance."""
        times = make_reported_times(self.scene)
        finer = np.sort(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
        run = self._run_reference(reference_engine("multibody", TIGHT_TOLERANCE, SHORTEST_STEP_RATIO), finer)
        return None if run is None else every_second_time(run)

    def reference_pairs(self, engine: str) -> Iterator[tuple[Trajectory, Trajectory]]:
        """Yield references for a run of an engine, each by another method and with a solution that confirms it."""
        for bodies in ("multibody", "refined_multibody"):  # the second is run only where the first does not suffice
            one: Trajectory | None = getattr(self, bodies)
            other = self.multibody if self.reduced is None else self.reduced
            if one is None or other is None or one is other:
                continue
            yield (other, one) if engine == MultibodyEngine.name and self.reduced is not None else (one, other)

    def _run_reference(self, engine: Engine, times: NDArray[np.float64] | None = None) -> Trajectory | None:
        if engine.refusal(self.scene):
            return None
        try:
            run = engine.run(self.scene, times=times, certify=False)
        except GovernorMechanismError:
            return None
        return run if run.outcome in SCENE_OUTCOMES and len(run.times) > 1 else None


def references_of(drawn: RandomScene) -> ReferenceSolutions:
    """Return the reference solutions of a random scene, exact ones where the machine has an exact motion."""
    motion = MOTIONS.get(drawn.machine)
    has_motion = motion is not None and drawn.document["machine"] != "pendulum_governor"
    exact = motion(drawn.document, make_reported_times(drawn.scene)) if has_motion else None
    return ReferenceSolutions(drawn.scene, exact)


# --- check of one run --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, kw_only=True)
class CertificateCheck:
    """Check of one error estimate: request, estimate, true error, and why there is no true error if there is none.

    Errors are relative to the scales. `true` is the largest difference from the reference, `least` the smallest error that the doubt of the
    reference leaves open, and `doubt` that of the reading that differs most. `reading_ratio` is the largest ratio of the error of a
    single reading to the estimate of that reading. `set_aside` is empty for a judged run; `failure` is what the run did in place of a
    claim that could be judged.
    """

    machine: str
    number: int
    seed: int
    engine: str
    accuracy: float
    kind: str
    outcome: str = ""
    estimate: float = math.nan
    true: float = math.nan
    least: float = math.nan
    doubt: float = math.nan
    worst: str = ""
    reading_ratio: float = math.nan
    worst_reading: str = ""
    set_aside: str = ""
    failure: str = ""
    seconds: float = 0.0

    @property
    def is_judged(self) -> bool:
        """Return whether the true error is known."""
        return not self.set_aside and not self.failure

    @property
    def is_within_estimate(self) -> bool:
        """Return whether the error is within the estimate."""
        return self.least <= self.estimate

    @property
    def is_beyond_limit(self) -> bool:
        """Return whether the error is beyond three estimates."""
        return self.least > MAX_ERROR_RATIO * self.estimate

    @property
    def claims_too_much(self) -> bool:
        """Return whether the run is DONE with an error above the request."""
        return self.outcome == Outcome.DONE.name and self.least > self.accuracy

    @property
    def overestimation(self) -> float:
        """Return the ratio of the estimate to the true error, or to what is not known of it, or to the least of all estimates."""
        return self.estimate / max(self.true, self.doubt, ROUNDING_TOLERANCE)


def check_certificate(drawn: RandomScene, engine: str, accuracy: float, references: ReferenceSolutions) -> CertificateCheck:
    """Compare one certified run with reference solutions."""
    source = describe_check(drawn, engine, accuracy)
    try:
        run = build_engine(engine).run(drawn.scene, accuracy=accuracy)
    except GovernorMechanismError as error:
        return replace(source, outcome="REFUSED", failure=f"refused: {error}")
    return replace(source, outcome=run.outcome.name, seconds=run.cost.wall_time, **compare_with_references(run, accuracy, references))


def describe_check(drawn: RandomScene, engine: str, accuracy: float) -> CertificateCheck:
    """Return the check of a run before it."""
    return CertificateCheck(machine=drawn.machine, number=drawn.number, seed=drawn.seed, engine=engine, accuracy=accuracy, kind=drawn.kind)


@dataclass(frozen=True)
class ErrorBounds:
    """Differences of a run from a reference by name, and of the reference from what confirms it, relative to the scales."""

    errors: Mapping[str, float]
    doubts: Mapping[str, float] = field(default_factory=dict)

    def doubt(self, name: str) -> float:
        """Return the doubt about the error of a reading: at least the rounding of its exact value."""
        return 0.0 if name == JOINT_GAP else max(self.doubts.get(name, 0.0), EXACT_DOUBT)  # the gap is known exactly

    @property
    def worst(self) -> str:
        """Name of the largest error."""
        return max(self.errors, key=self.errors.__getitem__, default="")

    @property
    def least(self) -> float:
        """Return the least error that the doubts leave open."""
        return max([0.0, *(error - self.doubt(name) for name, error in self.errors.items())])

    @property
    def most(self) -> float:
        """Return the largest error that the doubts leave open."""
        return max((error + self.doubt(name) for name, error in self.errors.items()), default=0.0)

    def decides(self, limits: Sequence[float]) -> bool:
        """Return whether the true error is on one side of each limit whatever the doubt."""
        return not any(self.least <= limit < self.most for limit in limits)


def compare_with_references(run: Trajectory, accuracy: float, references: ReferenceSolutions) -> dict[str, Any]:
    """Return estimate, true error and doubt of the references, or why the true error is unknown."""
    if run.error_estimate is None:
        return {"failure": "no estimate"}
    estimate = run.error_estimate
    if len(run.times) < 2:
        return {"estimate": estimate, "failure": "ended at the start"}
    limits = [estimate, MAX_ERROR_RATIO * estimate, *([accuracy] if run.outcome is Outcome.DONE else [])]
    found: list[tuple[ErrorBounds, int]] = []
    for reference, bounds in bound_errors(run, accuracy, references):
        # The joint gap is part of the estimate and known exactly.
        gap = float(np.max(run.joint_gap)) / run.scene.mechanism.length_scale
        found.append((replace(bounds, errors={**bounds.errors, JOINT_GAP: gap}), len(reference.times)))
        if found[-1][0].most <= min(limits):
            break  # an error that is too large must show against every reference, as these round by chance too
    if not found:
        return {"estimate": estimate, "set_aside": "no reference"}
    best, n_expected = min(found, key=lambda one: one[0].most - one[0].least)
    is_decided = found[-1][0].most <= min(limits) or all(bounds.decides(limits) for bounds, _ in found)
    result = describe_errors(run, found[-1][0] if found[-1][0].most <= min(limits) else best) | {"estimate": estimate}
    if run.outcome in COMPLETE_OUTCOMES and abs(len(run.times) - n_expected) > 1:
        return result | {"true": math.inf, "least": math.inf, "worst": "end of the run"}
    return result if is_decided else result | {"set_aside": "references disagree"}


def describe_errors(run: Trajectory, bounds: ErrorBounds) -> dict[str, Any]:
    """Return the fields of a check that follow from the errors of a run."""
    worst, (ratio, worst_reading) = bounds.worst, compare_reading_errors(run, bounds)
    errors = {"true": bounds.errors[worst], "least": bounds.least, "doubt": bounds.doubt(worst), "worst": worst}
    return errors | {"reading_ratio": ratio, "worst_reading": worst_reading}


def bound_errors(
    run: Trajectory, accuracy: float, references: ReferenceSolutions
) -> Iterator[tuple[Trajectory | ExactMotion, ErrorBounds]]:
    """Yield references for a run, each with the errors of the run by it and its own doubts."""
    if references.exact is not None:
        yield references.exact, ErrorBounds(relative_differences(run, references.exact, accuracy))
        return
    for reference, other in references.reference_pairs(run.cost.engine):
        errors, doubts = relative_differences(run, reference, accuracy), relative_differences(reference, other, accuracy)
        yield reference, ErrorBounds(errors, doubts)


def compare_reading_errors(run: Trajectory, bounds: ErrorBounds) -> tuple[float, str]:
    """Return the largest ratio of the error of a reading to its own estimate, of at least the rounding, and the name of the reading."""
    ratios = {
        name: max(bounds.errors[name] - bounds.doubt(name), 0.0) / max(error / run.scales[name], ROUNDING_TOLERANCE)
        for name, error in run.reading_errors.items()
        if name in bounds.errors and name != JOINT_GAP and run.scales.get(name)
    }
    worst = max(ratios, key=ratios.__getitem__, default="")
    return ratios.get(worst, 0.0), worst

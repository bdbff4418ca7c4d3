"""Validity of error estimates: certified runs against reference solutions by another method."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine, select_engine
from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.errors import GovernorMechanismError
from governor_mechanism.mechanics.contact.event_log import compare_event_logs, drop_cancelled_events
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from random_machines import draw_uniform
from random_scenes import RandomScene

ACCURACIES = {"reduced": (-10.0, -3.0), "multibody": (-10.0, -3.0), "impulse": (-6.0, -3.0), "auto": (-9.0, -3.0)}
"""Exponents of ten between which the requested accuracy of each engine is drawn."""

LOOSE_TOLERANCE, TIGHT_TOLERANCE = 1e-13, 1e-14
"""Tolerances of the reference solutions."""

MAX_REFERENCE_DISAGREEMENT = 0.1
"""Largest difference of two references, relative to the estimate, with which the true error is known."""

MAX_STEPS = {"reduced": 4000, "multibody": 4000, "impulse": 100_000}
"""Step limit of one run, of `impulse` of all runs together: about ten times what a scene of a few oscillations needs."""

MAX_REFERENCE_STEPS = 4 * MAX_STEPS["multibody"]
"""Step limit of a reference, which has shorter steps at a tolerance of 1e-14."""

ROUNDING_TOLERANCE = 1e-13
"""Difference of references, relative to the scales, that is rounding: no estimate is smaller."""

SCENE_OUTCOMES = (Outcome.NOT_CERTIFIED, Outcome.LEFT_RANGE, Outcome.STALLED)
"""Outcomes that a scene determines: its end, the end of its range, or a locking driver."""

COMPLETE_OUTCOMES = (Outcome.DONE, Outcome.ACCURACY_MISSED, Outcome.LEFT_RANGE)
"""Outcomes with which a run claims to have reached its end or the end of the range."""

DERIVED_EVENT_KINDS = (EventKind.TURNING_POINT, EventKind.CHANGE_POINT)
"""Events computed from the motion afterwards; error estimates refer to the others."""


def build_engine(name: str, scene: Scene, accuracy: float) -> Engine:
    """Return the engine of a name with a step limit."""
    if name == "auto":
        return select_engine(name, scene, accuracy)[0]
    engine_classes: Mapping[str, Any] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}
    engine: Engine = engine_classes[name](max_steps=MAX_STEPS[name])
    return engine


def certified_events(run: Trajectory, min_separation: float = 0.0) -> tuple[Event, ...]:
    """Return the events that an error estimate refers to, without those reversed within `min_separation` (s)."""
    if not has_contacts(run.scene):
        return ()
    return drop_cancelled_events([event for event in run.events if event.kind not in DERIVED_EVENT_KINDS], min_separation)


def max_difference(run: Trajectory, other: Trajectory, accuracy: float) -> float:
    """Return the largest difference between two runs of a scene relative to the scales, as an error estimate defines it.

    It includes readings and rates at common reported times away from events, and the times of events.
    """
    scene, t_scale = run.scene, time_scale(run.scene)
    n_shared, time_tolerance = min(len(run.times), len(other.times)), accuracy * t_scale
    event_time_error, is_near_event = compare_event_logs(
        certified_events(other, time_tolerance), certified_events(run, time_tolerance), run.times[:n_shared], time_tolerance
    )
    largest = event_time_error / t_scale if has_contacts(scene) else 0.0
    pairs = {name: (values, other.readings[name]) for name, values in run.readings.items()}
    pairs |= {f"rate of {name}": (values, other.rates[name]) for name, values in run.rates.items()}
    for name, (values, others) in pairs.items():
        difference = float(np.max(np.abs(values[:n_shared] - others[:n_shared])[~is_near_event], initial=0.0))
        if not math.isfinite(difference):
            return math.inf
        largest = max(largest, difference / run.scales[name])
    return largest


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
    """Reference solutions of a scene by each available method."""

    scene: Scene

    @cached_property
    def reduced(self) -> Trajectory | None:
        """Return the solution by one coordinate, or None."""
        return self._run_reference(ReducedEngine(tolerance=LOOSE_TOLERANCE, max_steps=MAX_REFERENCE_STEPS))

    @cached_property
    def multibody(self) -> Trajectory | None:
        """Return the solution by bodies and joints, or None."""
        return self._run_reference(MultibodyEngine(tolerance=LOOSE_TOLERANCE, max_steps=MAX_REFERENCE_STEPS))

    @cached_property
    def refined_multibody(self) -> Trajectory | None:
        """Return the solution by bodies and joints with other steps: twice as many reported times and another tolerance."""
        times = make_reported_times(self.scene)
        finer = np.sort(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
        run = self._run_reference(MultibodyEngine(tolerance=TIGHT_TOLERANCE, max_steps=MAX_REFERENCE_STEPS), finer)
        return None if run is None else every_second_time(run)

    def reference_pairs(self, engine: str) -> Iterator[tuple[Trajectory, Trajectory]]:
        """Yield references for a run of an engine, each by another method and with a solution that confirms it."""
        for bodies in ("multibody", "refined_multibody"):  # the second is run only where the first disagrees
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


@dataclass(frozen=True, kw_only=True)
class CertificateCheck:
    """Check of one error estimate: request, estimate, true error, and why there is no true error if there is none."""

    seed: int
    number: int
    words: str
    group: str
    engine: str
    accuracy: float
    outcome: str
    estimate: float = math.nan
    true: float = math.nan
    doubt: float = math.nan
    set_aside: str = ""
    seconds: float = 0.0

    @property
    def is_judged(self) -> bool:
        """Return whether the true error is known."""
        return not self.set_aside

    @property
    def overestimation(self) -> float:
        """Return the ratio of the estimate to the true error."""
        return self.estimate / max(self.true, MIN_TRUE_ERROR)


MIN_TRUE_ERROR = 1e-16
"""Smaller true errors are zero."""


def draw_accuracies(drawn: RandomScene) -> dict[str, float]:
    """Return the requested accuracy of each engine that can model the scene."""
    random = np.random.default_rng([drawn.seed, drawn.number, 1])
    accuracies = {name: 10 ** draw_uniform(random, *exponents) for name, exponents in ACCURACIES.items()}
    return {name: one for name, one in accuracies.items() if not build_engine(name, drawn.scene, one).refusal(drawn.scene)}


def check_certificate(drawn: RandomScene, engine: str, accuracy: float, references: ReferenceSolutions) -> CertificateCheck:
    """Compare one certified run with reference solutions."""
    try:
        run = build_engine(engine, drawn.scene, accuracy).run(drawn.scene, accuracy=accuracy)
    except GovernorMechanismError as error:
        result: dict[str, Any] = {"outcome": "REFUSED", "set_aside": f"refused: {error}"}
    else:
        result = {"outcome": run.outcome.name, "seconds": run.cost.wall_time} | compare_with_references(run, accuracy, references)
    source: dict[str, Any] = {"seed": drawn.seed, "number": drawn.number, "words": drawn.description, "group": drawn.group}
    return CertificateCheck(engine=engine, accuracy=accuracy, **source, **result)


def compare_with_references(run: Trajectory, accuracy: float, references: ReferenceSolutions) -> dict[str, Any]:
    """Return estimate, true error and difference of the references, or why the true error is unknown."""
    if run.error_estimate is None:
        return {"set_aside": "no estimate"}
    if len(run.times) < 2:
        return {"set_aside": "ended at the start"}
    estimate = run.error_estimate
    best, doubt = None, math.inf
    for one, other in references.reference_pairs(run.cost.engine):
        off = max_difference(one, other, accuracy)
        if best is None or off < doubt:
            best, doubt = one, off
        if doubt <= max(MAX_REFERENCE_DISAGREEMENT * estimate, ROUNDING_TOLERANCE):
            break
    if best is None:
        return {"estimate": estimate, "set_aside": "no reference"}
    # The joint gap is part of the estimate and known exactly.
    gap = float(np.max(run.joint_gap)) / run.scene.part.mechanism.length_scale
    result = {"estimate": estimate, "true": max(max_difference(run, best, accuracy), gap), "doubt": doubt}
    if doubt > max(MAX_REFERENCE_DISAGREEMENT * estimate, ROUNDING_TOLERANCE):
        return result | {"set_aside": "references disagree"}
    if run.outcome in COMPLETE_OUTCOMES and abs(len(run.times) - len(best.times)) > 1:
        return result | {"true": math.inf}
    return result

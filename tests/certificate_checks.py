"""How well the certificate of a run holds: its estimate, against a truth by another way."""

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
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from random_machines import draw_uniform
from random_scenes import RandomScene, draw_scene

ACCURACIES = {"reduced": (-10.0, -3.0), "multibody": (-10.0, -3.0), "impulse": (-6.0, -3.0), "auto": (-9.0, -3.0)}
"""Exponents of ten between which accuracies are asked of each engine."""

LOOSE_TOLERANCE, TIGHT_TOLERANCE = 1e-13, 1e-14
"""Tolerances of references."""

MAX_REFERENCE_DISAGREEMENT = 0.1
"""Of the estimate: two references that agree no better than this do not settle it."""

MAX_STEPS = {"reduced": 4000, "multibody": 4000, "impulse": 20_000}
"""Of one run: a guard, some ten times what a scene of a few swings needs."""

MAX_REFERENCE_STEPS = 4 * MAX_STEPS["multibody"]
"""Of a reference: at tolerances of 1e-14 steps are shorter."""

ROUNDING_TOLERANCE = 1e-13
"""In scales: some hundred roundings of double precision; references that agree so well are trusted, as no estimate is
less.
"""

SCENE_OUTCOMES = (Outcome.NOT_CERTIFIED, Outcome.LEFT_RANGE, Outcome.STALLED)
"""Ways to end that are the scene's: at its end, where its description no longer holds, or where a drive locks."""

COMPLETE_OUTCOMES = (Outcome.DONE, Outcome.ACCURACY_MISSED, Outcome.LEFT_RANGE)
"""Ways to end in which a run says that it came as far as there is to go."""

DERIVED_EVENT_KINDS = (EventKind.TURNING_POINT, EventKind.CHANGE_POINT)
"""Events that are told of a motion afterwards; certificates are of the others."""


def build_engine(name: str, scene: Scene, accuracy: float) -> Engine:
    """The engine of that name, with the guard."""
    if name == "auto":
        return select_engine(name, scene, accuracy)[0]
    kinds: Mapping[str, Any] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}
    engine: Engine = kinds[name](max_steps=MAX_STEPS[name])
    return engine


def certified_events(run: Trajectory, min_separation: float = 0.0) -> tuple[Event, ...]:
    """The events of a run that its certificate speaks of, less what was undone within so many seconds."""
    if not has_contacts(run.scene):
        return ()
    return drop_cancelled_events([event for event in run.events if event.kind not in DERIVED_EVENT_KINDS], min_separation)


def max_difference(run: Trajectory, other: Trajectory, accuracy: float) -> float:
    """The largest difference between two runs of one scene in units of the scales, as a certificate takes it.

    Of readings and rates at the reported times that both came to, away from events, and of the events' times.
    """
    scene, second = run.scene, time_scale(run.scene)
    shared, near = min(len(run.times), len(other.times)), accuracy * second
    late, beside = compare_event_logs(certified_events(other, near), certified_events(run, near), run.times[:shared], near)
    kept = ~beside
    found = late / second if has_contacts(scene) else 0.0
    for values, others, unit in ((run.readings, other.readings, 1.0), (run.rates, other.rates, second)):
        for name, told in values.items():
            off = float(np.max(np.abs(told[:shared] - others[name][:shared])[kept], initial=0.0))
            if not math.isfinite(off):
                return math.inf
            found = max(found, off * unit / run.scales[name])
    return found


def every_second_time(run: Trajectory) -> Trajectory:
    """Every second reported time of a run."""
    return replace(
        run,
        times=run.times[::2],
        readings={name: values[::2] for name, values in run.readings.items()},
        rates={name: values[::2] for name, values in run.rates.items()},
    )


@dataclass(eq=False)
class ReferenceSolutions:
    """What a scene does, as well as it can be known by each way to know it."""

    scene: Scene

    @cached_property
    def reduced(self) -> Trajectory | None:
        """By the one coordinate, where there is one that leads on."""
        return self._run_reference(ReducedEngine(tolerance=LOOSE_TOLERANCE, max_steps=MAX_REFERENCE_STEPS))

    @cached_property
    def multibody(self) -> Trajectory | None:
        """By bodies and joints."""
        return self._run_reference(MultibodyEngine(tolerance=LOOSE_TOLERANCE, max_steps=MAX_REFERENCE_STEPS))

    @cached_property
    def refined_multibody(self) -> Trajectory | None:
        """By bodies and joints, stepped otherwise: to twice as many reported times, at another tolerance."""
        times = make_reported_times(self.scene)
        finer = np.sort(np.concatenate([times, 0.5 * (times[1:] + times[:-1])]))
        found = self._run_reference(MultibodyEngine(tolerance=TIGHT_TOLERANCE, max_steps=MAX_REFERENCE_STEPS), finer)
        return None if found is None else every_second_time(found)

    def reference_pairs(self, engine: str) -> Iterator[tuple[Trajectory, Trajectory]]:
        """What a run of an engine may be held against, by another way than its own, each with what confirms it."""
        for bodies in ("multibody", "refined_multibody"):  # the second is run where the first settles nothing
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
    """How well one certificate held: what was asked, promised, and true; why it cannot be judged, where it cannot."""

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
        """Whether there is a true error."""
        return not self.set_aside

    @property
    def overestimation(self) -> float:
        """How many times the true error the estimate is."""
        return self.estimate / max(self.true, MIN_TRUE_ERROR)


MIN_TRUE_ERROR = 1e-16
"""True errors below this are none."""


def draw_accuracies(drawn: RandomScene) -> dict[str, float]:
    """What is asked of each engine that holds the scene."""
    random = np.random.default_rng([drawn.seed, drawn.number, 1])
    asked = {name: 10 ** draw_uniform(random, *exponents) for name, exponents in ACCURACIES.items()}
    return {name: one for name, one in asked.items() if not build_engine(name, drawn.scene, one).refusal(drawn.scene)}


def check_certificate(drawn: RandomScene, engine: str, accuracy: float, references: ReferenceSolutions) -> CertificateCheck:
    """One certified run held against the truth."""
    try:
        run = build_engine(engine, drawn.scene, accuracy).run(drawn.scene, accuracy=accuracy)
    except GovernorMechanismError as error:
        told: dict[str, Any] = {"outcome": "REFUSED", "set_aside": f"refused: {error}"}
    else:
        told = {"outcome": run.outcome.name, "seconds": run.cost.wall_time} | compare_with_references(run, accuracy, references)
    about: dict[str, Any] = {"seed": drawn.seed, "number": drawn.number, "words": drawn.description, "group": drawn.group}
    return CertificateCheck(engine=engine, accuracy=accuracy, **about, **told)


def compare_with_references(run: Trajectory, accuracy: float, references: ReferenceSolutions) -> dict[str, Any]:
    """Estimate, true error and doubt of a run, or why there are none."""
    if run.error_estimate is None:
        return {"set_aside": "no estimate"}
    if len(run.times) < 2:
        return {"set_aside": "ended at once"}
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
    # What the joints are open by is part of the estimate, and known as it is.
    gap = float(np.max(run.joint_gap)) / run.scene.part.mechanism.length_scale
    found = {"estimate": estimate, "true": max(max_difference(run, best, accuracy), gap), "doubt": doubt}
    if doubt > max(MAX_REFERENCE_DISAGREEMENT * estimate, ROUNDING_TOLERANCE):
        return found | {"set_aside": "references disagree"}
    if run.outcome in COMPLETE_OUTCOMES and abs(len(run.times) - len(best.times)) > 1:
        return found | {"true": math.inf}
    return found


def check_certificates(number: int, seed: int) -> tuple[RandomScene, list[CertificateCheck]]:
    """The certificates of one random scene by every engine that holds it."""
    drawn = draw_scene(number, seed)
    truth = ReferenceSolutions(drawn.scene)
    return drawn, [check_certificate(drawn, engine, asked, truth) for engine, asked in draw_accuracies(drawn).items()]

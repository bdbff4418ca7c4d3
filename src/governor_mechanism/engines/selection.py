"""Select an engine for a scene: the cheapest that can model it, by a simple cost model."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import final

from governor_mechanism.engines.base import Engine, ExpectedWork, Reason, RunRequest
from governor_mechanism.engines.certificate import (
    ORDER,
    REQUEST_TO_FIRST_RUN_RATIO,
    RUNS_PER_CERTIFICATE,
    ErrorControlledEngine,
    initial_tolerance,
)
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.impulse.settings import choose_steps
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.contacts import outline_gaps_of
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.units.quantities import format_value

AnyEngine = ErrorControlledEngine | ImpulseEngine
"""An engine of the package."""

RUN_OVERHEAD_SECONDS = {"reduced": 0.002, "multibody": 0.004, "impulse": 0.005}
"""Time of a run in addition to its steps, s: initial state, tables, certificate."""

REPORT_SECONDS = {"reduced": 1.5e-6, "multibody": 3e-6, "impulse": 1.5e-4}
"""Time of each reported time, s: state, readings and energies of all runs of a certificate."""

EVALUATION_SECONDS = {"reduced": (2e-7, 0.0), "multibody": (3e-7, 3e-7), "impulse": (1.7e-5, 1.5e-6)}
"""Time of one evaluation (of one step for impulse), s, and additional time for each joint, s."""

IMPULSE_CONTACT_RATIO = 4.0
"""Factor on the time of an impulse step in scenes with contacts, which are held and released by further impulses."""

IMPULSE_STEP_LIMIT_RATIO = 0.25
"""Part of the budget of impulse that a run takes in steps before it ends: begun intervals and shares for further runs take the rest."""

STEPS_PER_MOTION, STEPS_PER_MOTION_WITH_CONTACTS = 0.13, 9.0
"""Steps of order 8 in the time that bounds them, at a tolerance of 1, of which a power gives those at another one; with contacts at any
tolerance: medians of the shipped models, from which most differ by less than a factor of 3 and a few by 10.
"""

EVALUATIONS_PER_STEP = 12
"""Evaluations of a step of order 8 without its interpolation."""


def estimate_run_time(
    engine: AnyEngine,
    scene: Scene,
    accuracy: float,
    # work that an engine with error control is expected to do, as judged by its first run; None estimates it
    # from the scene
    work: ExpectedWork | None = None,
) -> float:
    """Return the approximate time of a certified run of an engine, s; for impulse the least one, of a run that needs no refinement."""
    # The engine itself refuses an invalid accuracy.
    valid_accuracy = accuracy if isinstance(accuracy, int | float) and 0 < accuracy < 1 else 1e-6
    n_reported = scene.run.duration / scene.run.output_interval if work is None else work.n_reported
    if isinstance(engine, ImpulseEngine):
        n_units = _count_least_impulse_steps(engine, scene, valid_accuracy, n_reported)
        n_units *= IMPULSE_CONTACT_RATIO if has_contacts(scene) else 1.0
    else:
        n_evaluations = _estimate_evaluations(scene, valid_accuracy) if work is None else work.n_evaluations
        n_units = min(n_evaluations, RUNS_PER_CERTIFICATE * EVALUATIONS_PER_STEP * engine.step_limit(scene))
    base_cost, joint_cost = EVALUATION_SECONDS[engine.name]
    overhead = RUN_OVERHEAD_SECONDS[engine.name] + REPORT_SECONDS[engine.name] * n_reported
    return overhead + n_units * (base_cost + joint_cost * len(scene.mechanism.joints))


def _estimate_evaluations(scene: Scene, accuracy: float) -> float:
    """Return the approximate number of evaluations in the two runs of a certificate."""
    n_motions = scene.run.duration / max_step_scale(scene)
    tolerance_factor = float(initial_tolerance(accuracy) ** (-1 / ORDER))
    n_steps = n_motions * (STEPS_PER_MOTION_WITH_CONTACTS if has_contacts(scene) else STEPS_PER_MOTION * tolerance_factor)
    return RUNS_PER_CERTIFICATE * EVALUATIONS_PER_STEP * n_steps


def _count_least_impulse_steps(engine: ImpulseEngine, scene: Scene, accuracy: float, n_reported: float) -> float:
    """Return the steps of the first three runs of impulse, or those that its budget allows."""
    n_coarsest = max(scene.run.duration / min(choose_steps(engine, scene, accuracy)), n_reported)
    return min(float(2**engine.levels - 1) * n_coarsest, IMPULSE_STEP_LIMIT_RATIO * (engine.max_steps or engine.max_step_work))


def format_seconds(
    seconds: float,  # duration, s
) -> str:
    """Return a duration as '3 ms', '0.2 s' or '40 s'."""
    return f"{max(math.ceil(seconds * 1e3), 1)} ms" if seconds < 0.1 else f"{seconds:.2g} s"


ENGINES: dict[str, type[AnyEngine]] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}
"""Engine classes by name."""

FALLBACK_OUTCOMES = (Outcome.DEAD_CENTRE, Outcome.STIFF, Outcome.STALLED, Outcome.ACCURACY_MISSED)
"""Outcomes of `reduced` that multibody may improve."""

# The second run of a certificate takes twice the steps of the first. More runs follow where the first misses
# the accuracy.
REST_TO_FIRST_RUN_RATIOS = (2.0, REQUEST_TO_FIRST_RUN_RATIO - 1.0)
"""Least and largest expected time of all further runs of a request, relative to its first run."""


@final
@dataclass(frozen=True, kw_only=True)
class ReducedWithFallback(ReducedEngine):
    """The reduced engine, replaced by multibody where its coordinate cannot continue or its accuracy is missed."""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        try:
            reduced_result = super()._run(scene, request)
        except MechanismError as error:
            return MultibodyEngine().run(
                scene, **vars(request) | {"reason": partial(_explain_fallback, str(error), scene, request.accuracy)}
            )
        if reduced_result.outcome not in FALLBACK_OUTCOMES:
            return reduced_result
        cause = f"reduced could not complete the run: {reduced_result.message}"
        fallback_reason = partial(_explain_fallback, cause, scene, request.accuracy)
        multibody_result = MultibodyEngine().run(scene, **vars(request) | {"reason": fallback_reason})
        is_worse = (multibody_result.error_estimate or 1.0) > (reduced_result.error_estimate or 1.0)
        return reduced_result if multibody_result.outcome is Outcome.ACCURACY_MISSED and is_worse else multibody_result


def select_engine(
    name: str | Engine,
    scene: Scene,
    # requested accuracy, instead of the scene's own; it affects the expected cost
    accuracy: float | None = None,
) -> tuple[Engine, Reason]:
    """Return an engine and the reason of the choice; 'auto' is the cheapest that can model the scene; an unknown name raises."""
    if isinstance(name, Engine):
        return name, "given"
    known = ["auto", *ENGINES]
    if not isinstance(name, str) or name not in known:
        raise MechanismError(f"unknown engine {format_value(name)}; the engines are {', '.join(known)}.{did_you_mean(name, known)}")
    if name != "auto":
        return ENGINES[name](), "asked for"
    requested_accuracy = scene.run.accuracy if accuracy is None else accuracy
    engines = {name: engine_class() for name, engine_class in ENGINES.items()}
    capable = {name: engine for name, engine in engines.items() if not engine.refusal(scene)}
    missing = ", ".join(name for name in engines if name not in capable)
    if outline_gaps_of(scene):  # a gap has kinks where another edge becomes the nearest, at which a table may end
        capable.pop("reduced", None)
    if not capable:  # multibody models most, so its refusal is the most specific
        return engines["multibody"], "the engine that can model most"
    cheapest = min(capable.values(), key=lambda engine: estimate_run_time(engine, scene, requested_accuracy))
    others = [engine for engine in capable.values() if engine is not cheapest]
    reason = partial(_explain_choice, cheapest, others, missing, scene, requested_accuracy)
    return (ReducedWithFallback() if cheapest.name == "reduced" else cheapest), reason


def _explain_choice(
    cheapest: AnyEngine, others: Sequence[AnyEngine], missing: str, scene: Scene, accuracy: float, work: ExpectedWork | None
) -> str:
    """Return why an engine is chosen, with the expected times of all engines if the first run of a certificate shows its work."""
    if work is None:
        reason = "the cheapest" + (f" of {', '.join(engine.name for engine in (cheapest, *others))}" if others else "")
    else:
        own_time = _expect_own_time(cheapest, scene, accuracy, work)
        times = ", ".join(_state_other_time(engine, max(estimate_run_time(engine, scene, accuracy, work), own_time)) for engine in others)
        reason = f"the cheapest: about {format_seconds(own_time)}" + (f" ({times})" if times else "")
    return reason + (f"; {missing} cannot model this scene" if missing else "")


def _explain_fallback(cause: str, scene: Scene, accuracy: float, work: ExpectedWork | None) -> str:
    """Return why multibody runs in place of reduced, with its expected time if the first run of a certificate shows its work."""
    return cause if work is None else f"{cause}; about {format_seconds(_expect_own_time(MultibodyEngine(), scene, accuracy, work))}"


def _expect_own_time(engine: AnyEngine, scene: Scene, accuracy: float, work: ExpectedWork) -> float:
    """Return the expected time of the engine that runs, s: its first run as measured, and the rest as counted."""
    # Counted work leaves out implicit steps and tables, and a new process does in its first run what it
    # does only once, so neither is enough.
    least, most = (ratio * work.first_run_time for ratio in REST_TO_FIRST_RUN_RATIOS)
    return work.first_run_time + min(max(estimate_run_time(engine, scene, accuracy, work), least), most)


def _state_other_time(engine: AnyEngine, time: float) -> str:
    """Return the name and the expected time (s) of an engine that is not chosen, which is not expected to be quicker."""
    # How often impulse refines its steps is not known: its time is a bound.
    bound = "at least" if isinstance(engine, ImpulseEngine) else "about"
    return f"{engine.name} {bound} {format_seconds(time)}"

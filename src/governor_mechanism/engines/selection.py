"""Select an engine for a scene: the cheapest that can model it, by a simple cost model.

The numbers were measured on one machine and are rough; only their ratios matter. `python benchmarks/reduced.py` prints
what they represent.
"""

from dataclasses import dataclass
from typing import final

from governor_mechanism.engines.base import Engine, RunRequest
from governor_mechanism.engines.certificate import ORDER, initial_tolerance
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.multibody.engine import MultibodyEngine
from governor_mechanism.engines.reduced.engine import ReducedEngine
from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale, time_scale
from governor_mechanism.mechanics.dynamics.contacts import has_contacts
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome, Trajectory
from governor_mechanism.units.quantities import format_value

ENGINES: dict[str, type[Engine]] = {"reduced": ReducedEngine, "multibody": MultibodyEngine, "impulse": ImpulseEngine}
"""Engine classes by name."""

RUN_OVERHEAD_SECONDS = {"reduced": 0.002, "multibody": 0.004, "impulse": 0.02}
"""Time of a run in addition to its steps, s: initial state, tables, certificate."""

REPORT_SECONDS = {"reduced": 1.5e-6, "multibody": 3e-6, "impulse": 3e-6}
"""Time of each reported time, s: state, readings and energies of both runs of a certificate."""

EVALUATION_SECONDS = {"reduced": (2e-7, 0.0), "multibody": (3e-7, 3e-7), "impulse": (3e-6, 1e-6)}
"""Time of one evaluation (of one step for impulse), s, and additional time for each joint, s."""

STEPS_PER_MOTION, STEPS_PER_MOTION_WITH_CONTACTS = 0.13, 9.0
"""Steps of order 8 in the time that bounds them, at a tolerance of 1, of which a power gives those at another one; with contacts at any
tolerance: medians of the shipped models, from which most differ by less than a factor of 3 and a few by 10.
"""

EVALUATIONS_PER_CERTIFICATE_STEP = 24
"""Evaluations in the two runs of a certificate for each step of one."""

EVENT_COST_RATIO = 4.0
"""Cost factor of impulse runs with effects along readings."""

IMPULSE_STEP_COUNT_MODEL = 34.0, 1.5, -0.28
"""Steps of impulse per time scale over all runs of a certificate: a + b accuracy^c."""


FALLBACK_OUTCOMES = (Outcome.DEAD_CENTRE, Outcome.STIFF, Outcome.STALLED, Outcome.ACCURACY_MISSED)
"""Outcomes of `reduced` that multibody may improve."""


@final
@dataclass(frozen=True, kw_only=True)
class ReducedWithFallback(ReducedEngine):
    """The reduced engine, replaced by multibody where its coordinate cannot continue or its accuracy is missed."""

    def _run(self, scene: Scene, request: RunRequest) -> Trajectory:
        try:
            reduced_result = super()._run(scene, request)
        except MechanismError as error:
            return MultibodyEngine().run(scene, **vars(request) | {"reason": str(error)})
        if reduced_result.outcome not in FALLBACK_OUTCOMES:
            return reduced_result
        fallback_reason = f"reduced could not complete the run: {reduced_result.message}"
        multibody_result = MultibodyEngine().run(scene, **vars(request) | {"reason": fallback_reason})
        is_worse = (multibody_result.error_estimate or 1.0) > (reduced_result.error_estimate or 1.0)
        return reduced_result if multibody_result.outcome is Outcome.ACCURACY_MISSED and is_worse else multibody_result


def select_engine(name: str | Engine, scene: Scene, accuracy: float | None = None) -> tuple[Engine, str]:
    """Return the engine of a name with its default settings; 'auto' selects the cheapest one that can model the scene.

    Parameters
    ----------
    name
        Name of an engine, 'auto', or an engine.
    scene
        Scene to run.
    accuracy
        Requested accuracy, instead of the scene's own; it affects the expected cost.

    Returns
    -------
    tuple[Engine, str]
        Engine, and the reason of the choice.

    Raises
    ------
    MechanismError
        If there is no engine of that name.
    """
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
    if not capable:  # multibody models most, so its refusal is the most specific
        return engines["multibody"], "the engine that can model most"
    run_times = {name: estimate_run_time(name, scene, requested_accuracy) for name in capable}
    cheapest = min(capable, key=lambda name: run_times[name])
    others = ", ".join(f"{name} {format_seconds(run_times[name])}" for name in capable if name != cheapest)
    missing = ", ".join(name for name in engines if name not in capable)
    reason = f"the cheapest: about {format_seconds(run_times[cheapest])}"
    reason += f" ({others})" if others else ""
    reason += f"; {missing} cannot model this scene" if missing else ""
    return (ReducedWithFallback() if cheapest == "reduced" else capable[cheapest]), reason


def estimate_run_time(name: str, scene: Scene, accuracy: float) -> float:
    """Return the approximate time of a certified run of an engine, s."""
    # The engine itself refuses an invalid accuracy.
    valid_accuracy = accuracy if isinstance(accuracy, int | float) and 0 < accuracy < 1 else 1e-6
    n_time_scales, n_joints = scene.run.duration / time_scale(scene), len(scene.mechanism.joints)
    base_cost, joint_cost = EVALUATION_SECONDS[name]
    overhead = RUN_OVERHEAD_SECONDS[name] + REPORT_SECONDS[name] * scene.run.duration / scene.run.output_interval
    cost = base_cost + joint_cost * n_joints
    if name == "impulse":
        offset, factor, exponent = IMPULSE_STEP_COUNT_MODEL
        steps = n_time_scales * (offset + factor * float(valid_accuracy**exponent))
        return overhead + steps * cost * (EVENT_COST_RATIO if scene.output_effects else 1.0)
    n_motions, tolerance_factor = scene.run.duration / max_step_scale(scene), float(initial_tolerance(valid_accuracy) ** (-1 / ORDER))
    steps = n_motions * (STEPS_PER_MOTION_WITH_CONTACTS if has_contacts(scene) else STEPS_PER_MOTION * tolerance_factor)
    return overhead + EVALUATIONS_PER_CERTIFICATE_STEP * steps * cost


def format_seconds(seconds: float) -> str:
    """Return a duration as '3 ms', '0.2 s' or '40 s'."""
    return f"{seconds * 1e3:.0f} ms" if seconds < 0.1 else f"{seconds:.2g} s"

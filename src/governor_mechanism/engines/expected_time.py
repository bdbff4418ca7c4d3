"""Expected time of a certified run of each engine, from the work that it counts.

The times of a unit of work were measured on one machine and are rough. `python benchmarks/predicted_times.py` compares them with
measured times.
"""

import math

from governor_mechanism.engines.certificate import ORDER, RUNS_PER_CERTIFICATE, ErrorControlledEngine, initial_tolerance
from governor_mechanism.engines.expected_work import ExpectedWork
from governor_mechanism.engines.impulse.engine import ImpulseEngine
from governor_mechanism.engines.impulse.first_grid import choose_steps
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.model.scene import Scene

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
    n_motions, tolerance_factor = scene.run.duration / max_step_scale(scene), float(initial_tolerance(accuracy) ** (-1 / ORDER))
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

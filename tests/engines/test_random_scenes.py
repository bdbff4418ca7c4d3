"""Laws that every scene keeps, over random scenes of all machines and over every joint and force element.

Runs end by name and are finite; mirrored scenes mirror; motions without losses reverse; runs repeat bit by bit.
"""

import hashlib
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from itertools import count, islice

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from certificate_checks import max_difference
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.engines import Engine, ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.force_elements import Damper, TorsionDamper
from governor_mechanism.model.part import FreeSpindle, Start
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray
from joint_mechanisms import CASES
from mirrored_scenes import has_mirror_image, mirror_scene, reading_sign
from random_machines import MACHINES
from random_scenes import RandomScene, draw_scene, draw_wild_scene

SEED = 20261202

ACCURATE_ENGINES = {"reduced": ReducedEngine(max_steps=4000), "multibody": MultibodyEngine(max_steps=4000)}

FIXED_STEPS = 50
"""Number of steps of a run of the impulse engine that is not refined."""

ROUNDING = {"reduced": 1e-10, "multibody": 1e-10, "impulse": 1e-8}
"""Difference by rounding alone, relative to the scales: 1e-13, amplified by the motion or by the last bounces of a body that comes to rest;
with the impulse engine also the residual of its iterative solver.
"""

scene_numbers = st.integers(min_value=0, max_value=2**32 - 1)


def supporting_engines(scene: Scene, max_steps: int = 4000) -> Iterator[tuple[Engine, bool]]:
    """Yield the engines that run a scene, and whether they certify: with given steps the impulse engine does not."""
    for engine in (ReducedEngine(max_steps=max_steps), MultibodyEngine(max_steps=max_steps), fixed_step_impulse(scene)):
        if not engine.refusal(scene):
            yield engine, not isinstance(engine, ImpulseEngine)


def fixed_step_impulse(scene: Scene) -> ImpulseEngine:
    """Return an impulse engine that takes one run of `FIXED_STEPS` steps."""
    return ImpulseEngine(step=scene.run.duration / FIXED_STEPS, runs=1, max_steps=4 * FIXED_STEPS)


# --- runs end by name and are finite ----------------------------------------------------------------------------------


def arrays_of(run: Trajectory) -> dict[str, FloatArray]:
    """Return every array of a run by name; each has as many rows as there are times."""
    found = {"poses": run.poses, "velocities": run.velocities, "joint gap": run.joint_gap}
    found |= {f"energy {name}": values for name, values in vars(run.energy).items() if name != "scale"}
    found |= {f"reading {name}": values for name, values in run.readings.items()}
    found |= {f"rate {name}": values for name, values in run.rates.items()}
    for name, reaction in run.reactions.items():
        found |= {f"force of {name}": reaction.force, f"moment of {name}": reaction.moment}
    return found


def assert_finite(run: Trajectory) -> None:
    """Every number of a run is finite, and every array has a row for each reported time."""
    assert isinstance(run.outcome, Outcome)
    for name, values in {"times": run.times, **arrays_of(run)}.items():
        assert len(values) == len(run.times), name
        assert np.all(np.isfinite(values)), f"{name} of {run.cost.engine}: {run.message}"
    assert all(np.isfinite(event.time) for event in run.events)
    assert run.error_estimate is None or np.isfinite(run.error_estimate)
    assert (run.outcome is not Outcome.DONE) or (run.error_estimate is not None and len(run.times) > 0)


@pytest.mark.long
@settings(max_examples=20, derandomize=True)
@given(number=scene_numbers)
def test_wild_scenes_end_by_name_with_finite_numbers(number):
    scene = draw_wild_scene(number, SEED)
    assume(scene is not None)
    for engine, certify in supporting_engines(scene, max_steps=300):
        assert_finite(engine.run(scene, accuracy=1e-4, certify=certify))


def test_a_number_that_is_not_finite_is_detected():
    run = ACCURATE_ENGINES["reduced"].run(draw_scene(0, SEED).scene, accuracy=1e-4)
    assert_finite(run)
    broken = run.joint_gap.copy()
    broken[-1] = np.nan
    with pytest.raises(AssertionError, match="joint gap"):
        assert_finite(replace(run, joint_gap=broken))


# --- reflection ---------------------------------------------------------------------------------------------------------


def unmirror(run: Trajectory) -> Trajectory:
    """Return a run of a mirrored scene with the readings of the scene itself."""
    readings, rates = ({name: reading_sign(run.scene, name) * values for name, values in one.items()} for one in (run.readings, run.rates))
    return replace(run, readings=readings, rates=rates)


def assert_mirrors(scene: Scene, *, impulse: bool = True) -> None:
    """The mirrored scene has the mirrored motion with every engine, and is refused where the scene is."""
    mirrored = mirror_scene(scene)
    for engine in (*ACCURATE_ENGINES.values(), fixed_step_impulse(scene)):
        assert bool(engine.refusal(scene)) == bool(engine.refusal(mirrored))
    for engine, certify in supporting_engines(scene):
        if isinstance(engine, ImpulseEngine) and not impulse:
            continue
        run, other = (engine.run(one, accuracy=1e-6, certify=certify) for one in (scene, mirrored))
        assert run.outcome is other.outcome
        allowed = ROUNDING[engine.name] + sum(one.error_estimate or 0.0 for one in (run, other))
        assert max_difference(run, unmirror(other), 1e-6) <= allowed, engine.name


@settings(max_examples=14, derandomize=True)
@given(number=scene_numbers)
def test_mirrored_scenes_mirror(number):
    scene = draw_scene(number, SEED).scene
    assume(has_mirror_image(scene))
    assert_mirrors(scene)


@pytest.mark.parametrize("case", CASES)
def test_every_joint_and_force_element_mirrors(case):
    exact = CASES[case]()
    assert_mirrors(exact.scene, impulse=exact.impulse)


def test_a_motion_that_does_not_mirror_is_detected():
    scene = CASES["spring that turns"]().scene
    engine = ACCURATE_ENGINES["multibody"]
    run, same = (engine.run(scene, accuracy=1e-6) for _ in range(2))
    assert max_difference(run, unmirror(same), 1e-6) > 1e3 * (run.error_estimate or 0.0)


# --- reversal -----------------------------------------------------------------------------------------------------------


def is_reversible(scene: Scene) -> bool:
    """Return whether nothing dissipates, nothing is driven and nothing depends on time."""
    mechanism, spindle = scene.part.mechanism, scene.part.spindle
    is_lossless = not any(isinstance(element, Damper | TorsionDamper) for element in mechanism.force_elements)
    is_lossless = is_lossless and not any(isinstance(effect, Dashpot) for effect in scene.effects)
    loads = [load for element in mechanism.force_elements for load in element.loads]
    if isinstance(spindle, FreeSpindle):
        is_steady = spindle.torque.is_constant
    else:
        is_steady = spindle.speed_function.is_constant and not spindle.speed_fluctuation
    is_driven = bool(PositionSolver(mechanism).equations.is_driven.any())
    return is_lossless and is_steady and not is_driven and not has_contacts(scene) and all(load.is_constant for load in loads)


def reverse_scene(run: Trajectory) -> Scene:
    """Return the scene that starts where a run ends, with the opposite rates."""
    part = run.scene.part
    poses = run.poses[-1, : len(part.mechanism.bodies)].tolist()
    start = Start(
        values={name: float(run.readings[name][-1]) for name in part.start.values},
        rates={name: -float(run.rates[name][-1]) for name in {**part.start.values, **part.start.rates}},
    )
    changed = run.scene.with_changes(mechanism=replace(part.mechanism, initial_guess=tuple(map(tuple, poses))), start=start)
    if isinstance(part.spindle, FreeSpindle):
        return changed.with_changes(spindle=replace(part.spindle, start_speed=-float(run.readings["spindle_speed"][-1])))
    return changed


def reversal_error(run: Trajectory, back: Trajectory) -> float:
    """Return the largest difference between a motion and the motion back, relative to the scales; rates have the opposite sign."""
    unit = time_scale(run.scene)
    names = [reading.name for reading in run.scene.part.mechanism.readings]
    positions = max(float(np.max(np.abs(run.readings[name] - back.readings[name][::-1]))) / run.scales[name] for name in names)
    rates = max(float(np.max(np.abs(run.rates[name] + back.rates[name][::-1]))) / run.scales[name] for name in names)
    return max(positions, unit * rates)


N_REVERSIBLE = 10
"""Number of reversible scenes: about one random scene in twelve is one."""


@cache
def reversible_scenes() -> tuple[RandomScene, ...]:
    """Return the first random scenes that are reversible."""
    reversible = (drawn for number in count() if is_reversible((drawn := draw_scene(number, SEED)).scene))
    return tuple(islice(reversible, N_REVERSIBLE))


def test_reversible_scenes_are_of_many_machines():
    machines = {drawn.machine for drawn in reversible_scenes()}
    assert len(machines) >= 5, machines


@pytest.mark.long
@pytest.mark.parametrize("name", ["reduced", "multibody", "impulse"])
def test_motions_without_losses_reverse(name):
    for drawn in reversible_scenes():
        scene, number = drawn.scene, drawn.number
        engine = ACCURATE_ENGINES.get(name) or ImpulseEngine(max_steps=20_000)
        if engine.refusal(scene):
            continue
        accuracy = 1e-3 if name == "impulse" else 1e-7
        run = engine.run(scene, accuracy=accuracy)
        assert run.outcome in (Outcome.DONE, Outcome.LEFT_RANGE), (number, run.message)
        if run.outcome is Outcome.DONE:
            back = engine.run(reverse_scene(run), accuracy=accuracy)
            assert back.outcome is Outcome.DONE, (number, back.message)
            # The motion back has the same growth of errors as the motion itself, which the estimates contain.
            assert reversal_error(run, back) <= run.error_estimate + back.error_estimate, number


# --- repetition ---------------------------------------------------------------------------------------------------------


REPEATED_MACHINES = ("Watt", "Hartung", "free engine", "quick return")
"""A governor on links, one with springs, a mechanism under given loads, and one with a drive."""


def hash_of_runs() -> str:
    """Return a hash of every array of a run of some machines with each engine."""
    digest = hashlib.sha256()
    for number in map(list(MACHINES).index, REPEATED_MACHINES):
        scene = draw_scene(number, SEED).scene
        for engine, _ in supporting_engines(scene):
            run = engine.run(scene, accuracy=1e-5, certify=False)
            for values in arrays_of(run).values():
                digest.update(np.ascontiguousarray(values).tobytes())
            digest.update(repr([(event.kind, event.time) for event in run.events]).encode())
            digest.update(repr((run.outcome, run.error_estimate, run.message, run.cost.steps)).encode())
    return digest.hexdigest()


@pytest.mark.long
def test_runs_repeat_bit_by_bit_also_in_another_process():
    first, again = hash_of_runs(), hash_of_runs()
    assert first == again
    folder = os.path.dirname(__file__)
    program = "from test_random_scenes import hash_of_runs; print(hash_of_runs())"
    settings_of_process = {**os.environ, "PYTHONPATH": os.pathsep.join([folder, *sys.path]), "PYTHONHASHSEED": "1"}
    other = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True, env=settings_of_process)
    assert other.stdout.strip() == first

"""Engines multibody and reduced: references to nine digits, agreement with impulse, valid error estimates."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.closed_form import pendulum as closed
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine, ReducedEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.mechanism import Body
from governor_mechanism.model.part import Spindle
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.library import shipped_scenes
from governor_scenes import CROSSED, EXTENDED, PORTER, WATT, governor_scene, porter_open, random_governor
from one_coordinate_reference import integrate_one_coordinate
from reference import zehnder
from rigid_link_governor import porter_with_rods

FINE = pytest.mark.parametrize("engine", [MultibodyEngine, ReducedEngine], ids=["multibody", "reduced"])


@FINE
def test_open_porter_governor_agrees_with_the_reference_to_nine_digits(engine):
    run = engine().run(porter_open(accuracy=1e-11))
    expected = zehnder.PORTER_OPEN_MOTION["constant_speed"]
    assert run.outcome is Outcome.DONE
    assert run.readings["arm_angle"][-1] == pytest.approx(expected["arm_angle"], abs=1e-11)
    assert run.rates["arm_angle"][-1] == pytest.approx(expected["arm_rate"], abs=1e-10)
    assert run.readings["spindle_torque"][-1] == pytest.approx(expected["drive_torque"], abs=1e-9)
    assert run.energy.drift < 1e-10
    assert run.joint_gap.max() < 1e-12 * PORTER["arm"]


@cache
def random_scenes():
    """Return 20 scenes of random governors with their accuracies."""
    random = np.random.default_rng(20261121)
    found = []
    for _ in range(20):
        dimensions, middle = random_governor(random)
        speed = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=middle))
        accuracy = 10 ** random.uniform(-11, -4)
        angle, rate = middle + random.uniform(-0.1, 0.1), random.uniform(-0.3, 0.3)
        scene = governor_scene(dimensions, speed=speed, angle=angle, rate=rate, output_interval=0.05, accuracy=accuracy)
        found.append((scene, accuracy))
    return found


@cache
def reference_motion(number, times):
    """Return angles and rates of a random scene by an independent integration, once for all engines."""
    return integrate_one_coordinate(random_scenes()[number][0], np.array(times))


@FINE
def test_error_of_random_governors_is_within_accuracy_and_estimate(engine):
    fell_short = 0
    for number, (scene, accuracy) in enumerate(random_scenes()):
        run = engine().run(scene)
        assert run.outcome in (Outcome.DONE, Outcome.LEFT_RANGE)
        angles, rates = reference_motion(number, tuple(run.times))
        true = max(
            np.max(np.abs(run.readings["arm_angle"] - angles)), np.max(np.abs(run.rates["arm_angle"] - rates)) / run.scales["spindle_speed"]
        )
        assert true <= accuracy
        assert run.joint_gap.max() < 1e-12 * run.scene.part.mechanism.length_scale
        fell_short += true > run.error_estimate
    assert fell_short <= 1  # the estimate is for a ten times larger tolerance


# Impulse is slow for a crank that keeps accelerating and a chain with a change point at 0.7 s.
COARSER = {
    "slider_crank_torque": (1e-6, 0.6),
    "four_bar_chain": (1e-6, 0.6),
    "andrews_squeezer": (1e-6, 0.03),
    "haug_governor_open": (1e-6, 2.0),
    "pendulum_iftomm": (1e-6, 3.0),
    "porter_heavy_rods": (1e-6, 1.0),
    "stiff_flyball": (1e-5, 0.2),
    "quick_return": (1e-6, 0.5),
}


@pytest.mark.long
@pytest.mark.parametrize("name", shipped_scenes())
def test_engines_agree_on_every_shipped_scene(name):
    scene = gm.load(name)
    if scene.output_effects or (reason := ImpulseEngine().refusal(scene)):
        pytest.skip("its contacts are compared in test_impulse_effects.py" if scene.output_effects else f"impulse: {reason}")
    accuracy, end = COARSER.get(name, (1e-7, min(scene.run.duration, 5.0)))
    times = np.linspace(0.0, end, 101)
    fine, coarse = (gm.run(scene, engine=engine, accuracy=accuracy, times=times) for engine in ("multibody", "impulse"))
    assert fine.outcome is coarse.outcome is Outcome.DONE
    allowed = fine.error_estimate + coarse.error_estimate
    for reading, values in fine.readings.items():
        difference = np.max(np.abs(values - coarse.readings[reading]))
        assert difference <= allowed * fine.scales[reading], reading


STEP = Spindle(times=(0.0, 0.237, 0.237), speeds=(1.0, 1.0, 1.05))
RAMP_BEGUN_BEFORE = Spindle(times=(-1.0, 0.5), speeds=(0.97, 1.03))
SMOOTH = Spindle(times=(0.0, 0.3, 0.7, 1.5), speeds=(1.0, 1.03, 0.99, 1.05))


@pytest.mark.parametrize(
    ("engine", "accuracy"),
    [(MultibodyEngine, 1e-10), (ReducedEngine, 1e-10), (ImpulseEngine, 1e-7)],
    ids=["multibody", "reduced", "impulse"],
)
@pytest.mark.parametrize(("dimensions", "program"), [(WATT, STEP), (CROSSED, RAMP_BEGUN_BEFORE), (EXTENDED, SMOOTH)])
def test_variable_spindle_speed(engine, accuracy, dimensions, program):
    factor = float(closed.equilibrium_speed(closed.PendulumGovernor(**dimensions), arm_angle=0.75))
    spindle = Spindle(times=program.times, speeds=tuple(factor * speed for speed in program.speeds))
    scene = governor_scene(dimensions, speed=spindle, angle=0.75, output_interval=0.05, accuracy=accuracy)
    run = engine().run(scene)
    angles, rates = integrate_one_coordinate(scene, run.times)
    assert run.outcome is Outcome.DONE
    assert np.max(np.abs(run.readings["arm_angle"] - angles)) < accuracy
    assert np.max(np.abs(run.rates["arm_angle"] - rates)) < accuracy * run.scales["spindle_speed"]
    assert run.energy.drift < accuracy  # the energy balance contains the work of the speed changes


@FINE
def test_rigid_links_with_mass_agree_with_the_governor_with_rod_masses(engine):
    scene, reference = porter_with_rods(speed=13.0, angle=0.9, rate=1.5)
    times = np.linspace(0.0, 2.0, 21)
    run = engine().run(scene, times=times, accuracy=1e-10)
    angles, _ = reference(scene, times)
    assert np.max(np.abs(run.readings["arm_angle"] - angles)) < 1e-10


@FINE
def test_the_error_falls_with_the_tolerance(engine):
    scene = porter_open()
    expected, _ = integrate_one_coordinate(scene, np.linspace(0.0, 2.0, 21))
    tolerances = (1e-7, 1e-9, 1e-11)  # larger tolerances are limited by the largest step
    runs = [engine(tolerance=tolerance).run(scene, times=np.linspace(0.0, 2.0, 21), certify=False) for tolerance in tolerances]
    errors = [np.max(np.abs(run.readings["arm_angle"] - expected)) for run in runs]
    assert all(finer < coarser / 10 for coarser, finer in pairwise(errors))


@FINE
@pytest.mark.parametrize(("duration", "max_steps"), [(2.0, 8), (50.0, 20)])  # the second is farther than the longest steps reach
def test_step_limit_ends_the_run_with_a_named_outcome(engine, duration, max_steps):
    run = engine(max_steps=max_steps).run(porter_open(duration=duration))
    assert run.outcome is Outcome.STEP_LIMIT
    assert 0 < run.times[-1] < duration


@FINE
def test_unattainable_accuracy_is_reported_as_missed(engine):
    run = engine().run(porter_open(), accuracy=1e-17)
    assert run.outcome is Outcome.ACCURACY_MISSED
    assert run.error_estimate > 1e-17


def test_rotating_body_without_inertia_is_refused():
    scene = porter_open()
    mechanism = scene.part.mechanism
    bodies = (Body(name="right ball", mass=5.0), *mechanism.bodies[1:])
    scene = scene.with_changes(mechanism=replace(mechanism, bodies=bodies))
    with pytest.raises(MechanismError, match="body 'right ball' has no moment of inertia and can move without moving any other mass"):
        MultibodyEngine().run(scene)


@FINE
@pytest.mark.parametrize("settings", [{"tolerance": 0.0}, {"tolerance": 1e-16}, {"tolerance": 2.0}, {"max_steps": 0}])
def test_invalid_settings_are_refused(engine, settings):
    with pytest.raises(MechanismError, match=rf"Engine\.{next(iter(settings))} must"):
        engine(**settings)


def test_cost_counts_evaluations():
    run = MultibodyEngine().run(porter_open())
    evaluations = run.cost.evaluations["equations of motion"]
    assert run.cost.evaluations == {"equations of motion": evaluations, "gravity": 3 * evaluations, "centrifugal": 3 * evaluations}
    assert run.cost.runs == 2
    # Twelve stages and one derivative after each step, three more where the step has dense output.
    assert 13 * run.cost.steps <= evaluations <= 16 * (run.cost.steps + run.cost.rejected) + 2 * 2


@FINE
@pytest.mark.parametrize("accuracy", [0.9, 0.1, 1e-3, 1e-5])
def test_inaccurate_runs_have_an_estimate(engine, accuracy):
    # The two runs of a certificate must have different steps at any accuracy, otherwise their difference is zero.
    scene = gm.load("pendulum_iftomm")
    times = np.linspace(0.0, 1.0, 11)
    run, true = (engine().run(scene, accuracy=a, times=times) for a in (accuracy, 1e-11))
    error = max(np.max(np.abs(run.readings[name] - true.readings[name])) for name in run.readings)
    assert error <= run.error_estimate <= accuracy


@pytest.mark.parametrize("engine", [MultibodyEngine, ReducedEngine, ImpulseEngine])
def test_unreachable_time_ends_with_a_named_outcome(engine):
    run = gm.run("pendulum_iftomm", engine=engine(max_steps=5000), times=[1e9])
    assert run.outcome is Outcome.STEP_LIMIT
    assert len(run.times) == 0

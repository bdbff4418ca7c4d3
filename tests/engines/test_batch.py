"""Runs of a batch agree with certified runs of the same scenes, whatever the dimensions, and end where these end."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

import governor_mechanism as gm
from governor_mechanism.engines import ReducedEngine
from governor_mechanism.engines.certificate import initial_tolerance
from governor_mechanism.engines.reduced.batch import ReducedBatch
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document

READINGS = ["arm_angle", "ball_radius", "sleeve_lift"]


def draw_governor(generator: np.random.Generator) -> Scene:
    """Return a random Porter governor, or Watt's without a sleeve; a heavy or fast one soon reaches the end of its travel."""
    arm = generator.uniform(0.15, 0.6)
    dimensions = {"arm": arm, "offset": generator.uniform(0.0, 0.3) * arm, "ball_mass": generator.uniform(0.5, 10.0)}
    if generator.random() < 0.8:
        dimensions["sleeve_mass"] = generator.uniform(0.5, 60.0)
    document = {
        "title": "Governor",
        "machine": "pendulum_governor",
        "dimensions": dimensions,
        "effects": {"gravity": True, "centrifugal": True},
        "spindle": {"speed": generator.uniform(3.0, 20.0)},
        "start": {"arm_angle": generator.uniform(0.3, 1.1), "arm_rate": generator.uniform(-1.0, 1.0)},
        "run": {"duration": generator.uniform(0.5, 5.0), "output_interval": 0.05, "accuracy": 10.0 ** generator.uniform(-10.0, -3.0)},
    }
    return parse_scene_document(document)


def run_in_batch(scene: Scene):
    """Return the result of the batch for one scene."""
    return ReducedBatch(scene, READINGS, initial_tolerance(scene.run.accuracy), ReducedEngine().step_limit(scene)).run(scene)


@pytest.mark.parametrize("sleeve_mass", [70.0, 75.0, 85.0])
def test_a_fall_to_the_end_of_the_travel_takes_few_steps(sleeve_mass):
    # The steps shrink before the dead centre, and the table is extended there; both must stay few.
    scene = parse_scene_document(gm.load("porter").document | {"run": {"duration": 2.0, "accuracy": 1e-8}})
    heavier = scene.document | {"dimensions": scene.document["dimensions"] | {"sleeve_mass": sleeve_mass}}
    run = gm.run(parse_scene_document(heavier), engine="reduced", certify=False)
    assert run.outcome is Outcome.LEFT_RANGE
    assert run.cost.steps < 40  # 27, and half as many more
    assert run.cost.evaluations["table pieces"] < 35  # 23, likewise


@pytest.mark.parametrize("seed", range(40))
def test_a_run_of_a_batch_is_the_certified_run_within_the_accuracy_of_both(seed):
    scene = draw_governor(np.random.default_rng(seed))
    found, certified = run_in_batch(scene), gm.run(scene, "reduced")
    reference = gm.run(scene, ReducedEngine(tolerance=1e-14), certify=False)
    if certified.outcome is Outcome.DONE:
        assert found.outcome is Outcome.NOT_CERTIFIED
    else:
        assert found.outcome is certified.outcome
        assert found.detail.partition(", at t")[0] == certified.detail.partition(", at t")[0]
    n = min(len(found.times), len(certified.times), len(reference.times))
    assert max(len(found.times), len(certified.times)) - n <= (found.outcome is not Outcome.NOT_CERTIFIED)
    for name in READINGS:
        for values, others, exact, scale in (
            (found.readings[name], certified.readings[name], reference.readings[name], certified.scales[name]),
            (found.rates[name], certified.rates[name], reference.rates[name], certified.scales[f"rate of {name}"]),
        ):
            allowed = scene.run.accuracy + certified.error_estimate
            assert np.max(np.abs(values[:n] - others[:n])) <= allowed * scale
            assert np.max(np.abs(values[:n] - exact[:n])) <= scene.run.accuracy * scale


def test_the_random_governors_end_in_different_ways():
    """The test above compares complete runs and runs that end early."""
    outcomes = [run_in_batch(draw_governor(np.random.default_rng(seed))).outcome for seed in range(40)]
    assert min(outcomes.count(one) for one in (Outcome.NOT_CERTIFIED, Outcome.LEFT_RANGE)) >= 8


def fall_time(mass):
    """Return the time (s) in which the shipped Porter governor with a sleeve of a mass (kg) falls until arms and links are in line."""
    arm, offset, ball, speed, gravity, start = 0.3, 0.04, 5.0, 4.0 * math.pi, 9.81, math.radians(40.0)

    def potential(angle):
        return -2 * (ball + mass) * gravity * arm * np.cos(angle) - ball * (speed * (offset + arm * np.sin(angle))) ** 2

    def reciprocal_rate(root):  # the angle is the start less the square of the root, so that the integrand is regular
        angle = start - root**2
        inertia = 2 * ball * arm**2 + mass * (2 * arm * math.sin(angle)) ** 2
        return 2 * root / math.sqrt(2 * (potential(start) - potential(angle)) / inertia)

    # Near the start the difference of the potentials cancels, to 1e-16 / 1e-7; that part of the time is linear in the root.
    first = 3e-4
    return quad(reciprocal_rate, first, math.sqrt(start), epsabs=1e-13, epsrel=1e-13)[0] + first * reciprocal_rate(first)


@pytest.mark.parametrize("mass", [70.0, 75.0, 85.0])
def test_a_fall_to_a_change_point_ends_at_the_time_of_the_energy_integral(mass):
    """The table ends before that point, where rounding grows; the rest of the way is extrapolated."""
    porter = gm.load("porter")
    document = {**porter.document, "dimensions": {**porter.document["dimensions"], "sleeve_mass": mass}}
    document["run"] = {**document["run"], "accuracy": 1e-8}
    found = run_in_batch(parse_scene_document(document))
    assert found.outcome is Outcome.LEFT_RANGE
    time = float(found.detail.rpartition("t = ")[2].removesuffix(" s"))
    # Nine digits are told; the accuracy promises 1e-8 of the characteristic time, 1 / (4 pi rad/s).
    assert time == pytest.approx(fall_time(mass), abs=1.3e-9)


def test_tables_are_as_accurate_as_the_steps_need():
    """A looser accuracy takes fewer pieces, and the error that the table adds stays far below the accuracy."""
    scene = gm.load("porter")
    scene = replace(scene, run=replace(scene.run, duration=2.0))
    tight = gm.run(scene, ReducedEngine(tolerance=1e-14), certify=False)
    for accuracy in (1e-4, 1e-6, 1e-8):
        at_accuracy = replace(scene, run=replace(scene.run, accuracy=accuracy))
        found = run_in_batch(at_accuracy)
        assert np.max(np.abs(found.readings["arm_angle"] - tight.readings["arm_angle"])) < accuracy
        assert math.isfinite(found.rates["sleeve_lift"][-1])


def test_a_motion_that_turns_back_just_before_its_bound_does_not_leave_the_range():
    """The arms swing up to 89.9935 degrees, nearer to the horizontal than a table reaches: another engine follows them."""
    changes = {"spindle.speed": 1000.0, "start": {"arm_angle": math.radians(89.99)}, "run.duration": 0.05}
    scene = gm.load("porter").replace(changes)
    assert run_in_batch(scene).outcome is gm.run(scene, engine="reduced").outcome is Outcome.DEAD_CENTRE
    run = gm.run(scene)
    assert run.outcome is Outcome.DONE
    assert run.cost.engine == "multibody"
    assert math.degrees(run.readings["arm_angle"].max()) < 90.0

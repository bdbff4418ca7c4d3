"""The impulse engine ends every run within a budget of work: by name, with what it has, whatever makes the scene hard."""

import math
from typing import Any

import numpy as np
import pytest

from data_files import read_data
from governor_mechanism.engines import ImpulseEngine, MultibodyEngine
from governor_mechanism.engines.impulse.pymunk_model import PymunkModel
from governor_mechanism.engines.impulse.settings import ImpulseSettings, WorkBudget
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document

ARM, OFFSET, BALL, SLEEVE, ANGLE, SPEED = 0.3, 0.04, 5.0, 20.0, math.radians(40), 4 * math.pi

HOLDING_FORCE = (
    2 * 9.81 * ARM * math.sin(ANGLE) * (BALL + SLEEVE) - 2 * BALL * (OFFSET + ARM * math.sin(ANGLE)) * ARM * math.cos(ANGLE) * SPEED**2
) / (2 * ARM * math.sin(ANGLE))
"""Force (N) on the sleeve that holds the governor at rest, by virtual work: negative if it would rise."""


def governor(spindle: Any = "120 rpm", effects: dict[str, Any] | None = None, duration: float = 2.0, **changes: Any) -> Scene:
    """A Porter governor at a speed or a program of speed."""
    dimensions = {"arm": ARM, "offset": OFFSET, "ball_mass": BALL, "sleeve_mass": SLEEVE} | changes.get("dimensions", {})
    table = spindle if isinstance(spindle, dict) else {"speed": spindle}
    start = {"arm_angle": "40 deg"} | changes.get("start", {})
    run = {"duration": duration, "output_interval": duration / 40, "accuracy": 1e-6}
    loads = {"gravity": True, "centrifugal": True} | (effects or {})
    document = {"machine": "pendulum_governor", "dimensions": dimensions, "effects": loads, "spindle": table, "start": start, "run": run}
    return parse_scene_document(document)


STEPS_OF_SPEED = [[0, 11.5], [0.5, 11.5], [0.5, 14.1], [1.5, 14.1], [1.5, 10.5], [2.5, 10.5], [2.5, 13.1]]

HARD_SCENES = {
    "friction near the holding force": governor(effects={"dry_friction": {"sleeve": abs(HOLDING_FORCE) * (1 - 1e-9)}}),
    "steps of speed": governor(
        STEPS_OF_SPEED,
        {"dry_friction": {"sleeve": 20.0}, "stops": {"arm_angle": ["25 deg", "42 deg"], "restitution": 0.5}, "dashpot": {"sleeve": 50.0}},
        duration=4.0,
    ),
    "ramp through zero": governor(
        [[0, "-120 rpm"], [4, "120 rpm"]], {"stops": {"arm_angle": ["15 deg", "45 deg"], "restitution": 0.3}}, duration=4.0
    ),
    "equal slider crank": parse_scene_document(read_data(__file__)["EQUAL_SLIDER_CRANK"]),
    "light ball": governor("6000 rpm", dimensions={"ball_mass": 0.001}),
    "many swings": governor(duration=1e5),
}
"""Scenes whose runs would take minutes or more."""

NAMED_OUTCOMES = (Outcome.DONE, Outcome.ACCURACY_MISSED, Outcome.STEP_LIMIT, Outcome.JOINT_OPENED, Outcome.LEFT_RANGE)


@pytest.fixture
def counted_steps(monkeypatch):
    """The solver iterations of each step of all runs, also of those that locate events."""
    counted, step = [], PymunkModel._step

    def count(model, *arguments):
        counted.append(model._present_iterations)
        return step(model, *arguments)

    monkeypatch.setattr(PymunkModel, "_step", count)
    return counted


@pytest.mark.long
@pytest.mark.parametrize("max_steps", [300, 6000])
@pytest.mark.parametrize("name", HARD_SCENES)
def test_the_work_of_all_runs_together_is_bounded(name, max_steps, counted_steps):
    run = ImpulseEngine(max_steps=max_steps).run(HARD_SCENES[name])
    # A few steps more: a run ends at the step after its last, and each begins with a few for its start.
    assert len(counted_steps) <= max_steps + 20 * run.cost.runs
    assert run.outcome in NAMED_OUTCOMES
    assert len(run.times) >= 1
    assert all(np.all(np.isfinite(values)) for values in run.readings.values())
    if run.outcome in (Outcome.STEP_LIMIT, Outcome.ACCURACY_MISSED):
        assert f"max_steps = {max_steps}" in run.message


def test_the_samples_before_the_limit_are_true():
    scene = HARD_SCENES["steps of speed"]
    run, reference = ImpulseEngine(max_steps=6000).run(scene), MultibodyEngine().run(scene)
    assert run.outcome is Outcome.STEP_LIMIT
    assert 0.5 < run.times[-1] < 4.0
    for reading, values in run.readings.items():
        error = np.max(np.abs(values - reference.readings[reading][: len(run.times)])) / run.scales[reading]
        assert error <= 3 * run.error_estimate, reading


@pytest.mark.long
def test_a_refinement_that_does_not_fit_is_not_begun(counted_steps):
    coarse = ImpulseEngine(max_steps=8000).run(governor(duration=2.0), accuracy=1e-12)
    assert coarse.outcome is Outcome.ACCURACY_MISSED
    assert "max_steps = 8000, for all runs together, allows no better result" in coarse.message
    assert coarse.times[-1] == 2.0
    assert coarse.cost.runs == 3
    n_coarse = len(counted_steps)
    fine = ImpulseEngine(max_steps=400_000).run(governor(duration=2.0), accuracy=1e-10)
    assert fine.error_estimate < coarse.error_estimate
    assert len(counted_steps) - n_coarse > 2 * n_coarse


def test_more_iterations_count_as_more_steps(counted_steps):
    scene = governor("63 rad/s", dimensions={"sleeve_mass": 0.1}, start={"arm_rate": 1.0})
    run = ImpulseEngine(iterations=2, max_steps=20_000).run(scene)
    assert max(counted_steps) > 2
    budget = WorkBudget(ImpulseSettings(iterations=2, max_steps=20_000), scene, 0)
    assert sum(map(budget.steps_per_step, counted_steps)) <= 20_000 + 20 * run.cost.runs * budget.steps_per_step(max(counted_steps))


def test_the_default_falls_with_the_cost_of_a_step():
    settings = ImpulseSettings()
    plain, rubbing = governor(), governor(effects={"dry_friction": {"sleeve": 20.0}})
    limits = [WorkBudget(settings, scene, n_varying).limit for scene, n_varying in ((plain, 0), (plain, 1), (rubbing, 1))]
    assert limits[0] > limits[1] > limits[2] > 50_000
    more_iterations = WorkBudget(ImpulseSettings(iterations=320), plain, 0)
    assert more_iterations.limit < 0.5 * limits[0]

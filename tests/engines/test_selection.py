"""Selection of an engine by `auto`: it can model the scene, meets the accuracy, and is replaced where it cannot continue."""

import re
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ENGINES, ImpulseEngine, ReducedEngine, select_engine
from governor_mechanism.engines.base import ExpectedWork, RunRequest, state_reason
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.engines.selection import estimate_run_time
from governor_mechanism.model.part import Start
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.scenes.library import shipped_scenes

EXPECTED_ENGINES = {
    "porter": ("reduced", "one coordinate, and a run long enough to repay its table"),
    "porter_dry_friction": ("reduced", "friction and stops on one coordinate"),
    "porter_free_spindle": ("reduced", "a free spindle"),
    "hartung_dubois": ("reduced", "one coordinate with a spring"),
    "watt_improved": ("reduced", "one coordinate with contacts"),
    "andrews_squeezer": ("reduced", "one coordinate, whose evaluations cost less than those of ten joints"),
    "porter_clearance": ("multibody", "clearance adds a degree of freedom"),
    "quick_return": ("multibody", "a driver moves the mechanism"),
    "slider_crank": ("multibody", "a driver moves the mechanism"),
}
"""Engine of a shipped scene at its own accuracy, and the reason."""


@pytest.mark.parametrize("name", EXPECTED_ENGINES)
def test_selected_engine_of_shipped_scenes(name):
    expected, why = EXPECTED_ENGINES[name]
    assert select_engine("auto", gm.load(name))[0].name == expected, why


@pytest.mark.parametrize("accuracy", [1e-4, 1e-10])
@pytest.mark.parametrize("name", sorted(shipped_scenes()))
def test_selected_engine_can_model_the_scene(name, accuracy):
    scene = gm.load(name)
    engine, stated_with_work = select_engine("auto", scene, accuracy)
    assert not engine.refusal(scene)
    reason = state_reason(stated_with_work, ExpectedWork(first_run_time=0.25, n_evaluations=1e4, n_reported=101))
    # The second run takes twice as long as the first, and ten thousand evaluations take less than that.
    assert reason.startswith("the cheapest: about 0.75 s")
    # Every other engine is named with its expected time, or as one that cannot model the scene.
    for other, engine_class in ENGINES.items():
        if other != engine.name:
            assert other in (reason.split(";")[1] if engine_class().refusal(scene) else reason.split(";")[0])


@pytest.mark.parametrize("name", ["porter", "andrews_squeezer", "porter_clearance", "quick_return"])
def test_selected_engine_meets_the_accuracy(name):
    run = gm.run(name, accuracy=1e-7)
    assert run.outcome is Outcome.DONE
    assert run.error_estimate <= 1e-7
    assert run.cost.engine == EXPECTED_ENGINES[name][0]
    assert run.cost.reason.startswith("the cheapest: about ")


@pytest.mark.parametrize("name", ["porter_clearance", "quick_return"])
def test_reason_names_the_engines_that_cannot_model_the_scene(name):
    reason = state_reason(select_engine("auto", gm.load(name), 1e-8)[1], None)
    assert reason.startswith("the cheapest of multibody" if name == "quick_return" else "the cheapest;")
    assert "reduced" in reason.split(";")[1]
    assert "cannot model this scene" in reason


def test_expected_times_follow_from_the_first_run():
    scene, first_run = gm.load("porter"), ExpectedWork(first_run_time=0.004, n_evaluations=2e4, n_reported=1001)
    more_work, slow_run = replace(first_run, n_evaluations=3e4), replace(first_run, first_run_time=0.030)
    reason = select_engine("auto", scene, 1e-6)[1]
    chosen, more_chosen, least_chosen, most_chosen = (
        [float(number) for number in re.findall(r"([0-9.]+) ms", state_reason(reason, work))][:2]
        for work in (first_run, more_work, slow_run, replace(first_run, n_evaluations=1e6))
    )
    counted, more_counted = (estimate_run_time(ENGINES["reduced"](), scene, 1e-6, work) for work in (first_run, more_work))
    assert 0.006 < counted < more_counted < 0.014  # within 2 and 3.5 times the first run
    # The first run as measured and the rest as counted, in whole milliseconds, rounded up.
    assert (chosen[0], more_chosen[0]) == (np.ceil(1e3 * (0.004 + counted)), np.ceil(1e3 * (0.004 + more_counted)))
    assert more_chosen[1] > 1.3 * chosen[1]  # the time of multibody grows with the evaluations
    assert least_chosen == [90.0, 90.0]  # what is not chosen is not said to be quicker
    assert most_chosen[0] == pytest.approx(4.5 * 4.0, abs=1.0)  # in whole milliseconds


def test_expected_work_of_a_run_is_that_of_its_first_run():
    scene = gm.load("porter")
    runner = ReducedRunner(ReducedEngine(), scene, RunRequest(times=np.linspace(0.0, 10.0, 101), accuracy=1e-6, certify=True, reason=""))
    runner.run()
    assert runner.expected_work is not None
    assert runner.expected_work.n_reported == 101
    # Two runs, of which the second takes at most twice the steps of the first, are at least half and at most once what is expected.
    assert 0.4 < runner.count_work()[2]["equations of motion"] / runner.expected_work.n_evaluations < 1.0


def test_a_run_that_is_not_certified_states_no_times():
    assert gm.run("porter", certify=False).cost.reason == "the cheapest of reduced, multibody, impulse"


def test_multibody_replaces_reduced_at_a_turning_point_of_its_coordinate():
    scene = gm.load("slider_crank_torque")
    mechanism = replace(scene.part.mechanism, coordinate="slider_x")
    scene = scene.with_changes(
        mechanism=mechanism, start=Start(values={"crank_angle": 0.5}), run=replace(scene.run, duration=1.0, accuracy=1e-6)
    )
    assert gm.run(scene, engine="reduced").outcome is Outcome.DEAD_CENTRE
    run = gm.run(scene)
    assert run.outcome is Outcome.DONE
    assert run.cost.engine == "multibody"
    assert run.cost.reason.startswith("reduced could not complete the run: 'slider_x' is at a turning point")
    assert re.search(r"; about [0-9.]+ m?s$", run.cost.reason)


@pytest.mark.parametrize("name", ENGINES)
def test_estimated_run_time_increases_with_accuracy_and_duration(name):
    scene = gm.load("porter")
    longer = replace(scene, run=replace(scene.run, duration=100.0))
    engine = ENGINES[name]()
    assert estimate_run_time(engine, scene, 1e-4) < estimate_run_time(engine, scene, 1e-10)
    assert estimate_run_time(engine, scene, 1e-6) < estimate_run_time(engine, longer, 1e-6)


def test_plain_pymunk_refuses_drivers():
    with pytest.raises(gm.UnsupportedEffect, match="plain"):
        ImpulseEngine(step=1e-3, runs=1, plain=True).run(gm.load("quick_return"))

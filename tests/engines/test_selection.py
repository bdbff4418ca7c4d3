"""What `auto` takes and why: the cheapest engine that holds a scene, and another where that one leads no farther."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ENGINES, ImpulseEngine, select_engine
from governor_mechanism.engines.selection import estimate_run_time
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.scenes.library import shipped_scenes


def crank(**options):
    """The slider crank of the tests of engine `reduced`."""
    path = Path(__file__).with_name("test_reduced.py")
    found = importlib.util.spec_from_file_location("tests_of_reduced", path)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module.crank(**options)


def test_a_governor_is_given_to_the_reduced_engine_and_the_run_says_why():
    run = gm.run("porter", accuracy=1e-10)
    assert run.cost.engine == "reduced"
    assert run.cost.reason.startswith("the cheapest: about ")
    assert "multibody" in run.cost.reason
    assert "impulse" in run.cost.reason
    assert run.outcome is Outcome.DONE


@pytest.mark.parametrize(("name", "why"), [("porter_clearance", "play is a freedom more"), ("quick_return", "it is driven")])
def test_what_reduced_cannot_hold_goes_to_multibody(name, why):
    engine, reason = select_engine("auto", gm.load(name), 1e-8)
    assert engine.name == "multibody", why
    assert "reduced" in reason.split(";")[1]
    assert "cannot hold this scene" in reason


def test_where_the_coordinate_leads_no_farther_multibody_goes_on():
    scene = crank(coordinate="x", duration=1.0)
    assert gm.run(scene, engine="reduced").outcome is Outcome.DEAD_CENTRE
    run = gm.run(scene)
    assert run.outcome is Outcome.DONE
    assert run.cost.engine == "multibody"
    assert run.cost.reason.startswith("reduced gave it up: 'x' is at a turning point")


@pytest.mark.parametrize("name", sorted(shipped_scenes()))
def test_the_engine_chosen_holds_the_scene_and_is_expected_to_be_the_cheapest(name):
    scene = gm.load(name)
    engine, _ = select_engine("auto", scene)
    assert not engine.refusal(scene)
    able = [other for other, kind in ENGINES.items() if not kind().refusal(scene)]
    assert min(able, key=lambda other: estimate_run_time(other, scene, scene.run.accuracy)) == engine.name


@pytest.mark.parametrize("name", ENGINES)
def test_more_accuracy_and_a_longer_run_are_expected_to_cost_more(name):
    scene = gm.load("porter")
    longer = replace(scene, run=replace(scene.run, duration=100.0))
    assert estimate_run_time(name, scene, 1e-4) < estimate_run_time(name, scene, 1e-10)
    assert estimate_run_time(name, scene, 1e-6) < estimate_run_time(name, longer, 1e-6)


def test_a_refusal_names_the_engine_that_would_do():
    with pytest.raises(gm.UnsupportedEffect, match="drives move this mechanism; choose multibody"):
        gm.run("quick_return", engine="reduced")
    with pytest.raises(gm.UnsupportedEffect, match="Play"):
        gm.run("porter_clearance", engine="reduced")
    with pytest.raises(gm.MechanismError, match="Did you mean 'reduced'"):
        gm.run("porter", engine="reducd")


def test_the_plain_way_of_pymunk_refuses_what_it_does_not_hold():
    with pytest.raises(gm.UnsupportedEffect, match="plain way does not hold drives; leave plain=True out"):
        ImpulseEngine(step=1e-3, runs=1, plain=True).run(gm.load("quick_return"))

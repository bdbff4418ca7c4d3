"""Validity of error estimates over random scenes, and proof that the check can fail.

`make certificates` checks every engine over 300 scenes, of which these are the first 100.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import governor_mechanism as gm
from certificate_checks import (
    CertificateCheck,
    ReferenceSolutions,
    certified_events,
    check_certificate,
    compare_with_references,
    draw_accuracies,
)
from governor_mechanism.effects.bell_crank_masses import BellCrankMasses
from governor_mechanism.effects.clearance import Clearance
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.engines import MultibodyEngine, ReducedEngine
from governor_mechanism.engines.reduced.engine import ReducedRunner
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.part import FreeSpindle
from governor_mechanism.model.results.outcome import Outcome
from random_machines import MACHINES
from random_scenes import draw_scene

SEED = 20261124
N_SCENES, GROUP_SIZE = 100, 20
"""Number of random scenes, and number of scenes in one test."""

MAX_ERROR_RATIO = 3.0
"""Largest ratio of the true error of a run to its estimate."""

MAX_UNJUDGED = {"reduced": 2, "multibody": 3}
"""Largest number of runs in a group whose references disagree; in all scenes they are 2 and 3."""

N_SMOOTH_SCENES = 28
"""Number of scenes of which impulse runs those without contacts: with contacts it takes seconds, sometimes minutes."""

PLAIN_SCENE, IMPACT_SCENE = 0, 16
"""Numbers of a scene of a governor without effects, and of one with impacts."""


@cache
def check_scene(number: int, *engines: str) -> list[CertificateCheck]:
    """Return the checks of all runs of a scene by some engines."""
    scene = draw_scene(number, SEED)
    references, accuracies = ReferenceSolutions(scene.scene), draw_accuracies(scene)
    return [check_certificate(scene, engine, accuracies[engine], references) for engine in engines if engine in accuracies]


def check_scenes(numbers, *engines: str) -> list[CertificateCheck]:
    """Return the checks of all runs of some scenes by some engines."""
    return [check for number in numbers for check in check_scene(number, *engines)]


def judged(checks: list[CertificateCheck]) -> list[CertificateCheck]:
    """Return the checks with a known true error."""
    return [check for check in checks if check.is_judged]


def violations(checks: list[CertificateCheck], factor: float = 1.0) -> list[tuple[int, str, float, float, str]]:
    """Return the judged runs with an error above the limit when their estimate is multiplied by a factor."""
    return [
        (check.number, check.engine, check.estimate, check.true, check.words)
        for check in judged(checks)
        if check.true > MAX_ERROR_RATIO * factor * check.estimate
    ]


@pytest.mark.parametrize("first", range(0, N_SCENES, GROUP_SIZE))
def test_errors_of_accurate_engines_are_within_their_estimates(first):
    checks = check_scenes(range(first, first + GROUP_SIZE), "reduced", "multibody")
    assert not violations(checks)
    for engine, limit in MAX_UNJUDGED.items():
        unjudged = [(check.number, check.set_aside) for check in checks if check.engine == engine and not check.is_judged]
        assert len(unjudged) <= limit, unjudged
        # The estimate is the error of a run with a ten times larger tolerance, or with twice the largest step.
        assert 1 <= np.median([check.overestimation for check in judged(checks) if check.engine == engine]) <= 100


@pytest.mark.parametrize(("number", "accuracy"), [(205, 1e-2), (165, 1e-2), (206, 1e-3), (164, 1e-3)])
def test_estimates_of_loose_requests_are_no_smaller_than_the_errors(number, accuracy):
    # Engines and cranks whose largest step limits both runs of a certificate, not the tolerance.
    scene = draw_scene(number, SEED)
    check = check_certificate(scene, "reduced", accuracy, ReferenceSolutions(scene.scene))
    assert check.is_judged
    assert check.true <= check.estimate <= accuracy, check


def test_errors_of_impulse_are_within_their_estimates():
    smooth = [number for number in range(N_SMOOTH_SCENES) if draw_scene(number, SEED).group != "events"]
    checks = check_scenes(smooth, "impulse")
    assert len(checks) > 0.3 * N_SMOOTH_SCENES
    assert len(judged(checks)) == len(checks)
    assert not violations(checks)
    assert 1 <= np.median([check.overestimation for check in checks]) <= 100


def test_estimate_that_is_a_thousand_times_too_small_is_detected():
    checks = check_scenes(range(14), "reduced", "multibody")
    assert not violations(checks)
    assert len(violations(checks, 1e-3)) > 0.5 * len(judged(checks))  # estimates are about ten times too large


@pytest.mark.parametrize("engine", [ReducedEngine(), MultibodyEngine()], ids=["reduced", "multibody"])
def test_wrong_sample_is_detected(engine):
    drawn = draw_scene(PLAIN_SCENE, SEED)
    assert drawn.group == "plain"
    references, run = ReferenceSolutions(drawn.scene), engine.run(drawn.scene, accuracy=1e-6)
    assert compare_with_references(run, 1e-6, references)["true"] <= MAX_ERROR_RATIO * run.error_estimate
    name = run.scene.part.mechanism.coordinate
    wrong = run.readings[name].copy()
    wrong[len(wrong) // 2] += 10 * run.error_estimate  # one sample of one reading
    result = compare_with_references(replace(run, readings={**run.readings, name: wrong}), 1e-6, references)
    assert result["true"] > MAX_ERROR_RATIO * run.error_estimate


@pytest.mark.parametrize("engine", [ReducedEngine(), MultibodyEngine()], ids=["reduced", "multibody"])
def test_missing_event_is_detected(engine):
    drawn = draw_scene(IMPACT_SCENE, SEED)
    references, run = ReferenceSolutions(drawn.scene), engine.run(drawn.scene, accuracy=1e-6)
    assert certified_events(run)
    assert compare_with_references(run, 1e-6, references)["true"] <= MAX_ERROR_RATIO * run.error_estimate
    assert compare_with_references(replace(run, deferred_results=None), 1e-6, references)["true"] > MAX_ERROR_RATIO * run.error_estimate


# --- random scenes ----------------------------------------------------------------------------------------------------


def test_scene_is_determined_by_its_number():
    for number in range(len(MACHINES)):
        one, two = (draw_scene(number, SEED) for _ in range(2))
        assert one == two
        assert one.scene.part.mechanism != draw_scene(number, SEED + 1).scene.part.mechanism


def test_random_scenes_contain_every_machine_and_effect_and_few_are_refused():
    every = [draw_scene(number, SEED) for number in range(N_SCENES)]
    effects: set[type[Effect]] = {type(effect) for one in every for effect in one.scene.effects}
    assert effects >= {DryFriction, Dashpot, OutputSpring, Stops, Clearance, RodMasses, CrankMasses, BellCrankMasses}
    assert {one.machine for one in every} == set(MACHINES)
    spindles = [one.scene.spindle for one in every if one.scene.has_centrifugal]
    assert any(isinstance(spindle, FreeSpindle) for spindle in spindles)
    assert any(not isinstance(spindle, FreeSpindle) and spindle.speed_fluctuation for spindle in spindles)
    assert any(not isinstance(spindle, FreeSpindle) and len(spindle.times) > 2 for spindle in spindles)
    assert len({type(effect) for one in every for effect in one.scene.output_effects if len(one.scene.output_effects) == 1}) == 4
    assert sum(len(one.refused) for one in every) < 0.2 * N_SCENES


# --- scenes that failed once -----------------------------------------------------------------------------------------------


def test_friction_does_not_hold_a_reading_at_its_turning_point():
    """The mechanism moves on whatever force acts along the reading."""
    drawn = draw_scene(192, 2)
    assert any(isinstance(effect, DryFriction) for effect in drawn.scene.output_effects)
    run = MultibodyEngine(max_steps=2000).run(drawn.scene, accuracy=1e-7)
    assert run.outcome is Outcome.DONE
    assert run.energy.drift < 1e-6
    assert run.energy.dissipated_energy[-1] > 0


def test_coordinate_at_its_turning_point_within_rounding_ends_the_run_with_a_named_outcome():
    scene = draw_scene(108, 2).scene
    run = ReducedEngine(max_steps=2000).run(scene, accuracy=1e-6)
    assert run.outcome is Outcome.DEAD_CENTRE
    assert MultibodyEngine(max_steps=2000).run(scene, accuracy=1e-6).outcome is Outcome.DONE


@pytest.mark.parametrize("n_kept", [0, 5])
def test_states_that_no_comparison_run_reaches_are_not_claimed(monkeypatch, n_kept):
    run_once = ReducedRunner.run_once

    def run_with_short_comparisons(self, tolerance, is_comparison=False):
        result = run_once(self, tolerance, is_comparison)
        if not is_comparison:
            return result
        states = result.reported_states.at(slice(n_kept))
        return replace(result, reported_states=states, observables=self.evaluator.evaluate(states), outcome=Outcome.STALLED, detail="stuck")

    monkeypatch.setattr(ReducedRunner, "run_once", run_with_short_comparisons)
    run = gm.run("porter", engine="reduced")
    assert run.outcome is Outcome.ACCURACY_MISSED
    assert run.error_estimate >= 1.0
    assert "stuck" in run.message

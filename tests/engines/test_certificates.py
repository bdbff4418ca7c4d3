"""What an accuracy estimate is worth: over random scenes, and that the measure which says so can fail.

`python benchmarks/certificates.py` measures every engine over the same scenes, with what is left out here for its time.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

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
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import FreeSpindle
from governor_mechanism.model.trajectory import Outcome
from random_machines import MACHINES
from random_scenes import RandomScene, draw_scene

SEED = 20261124
SCENES, BLOCKS = 300, 3
LAW, SHARE = 3.0, 0.98
"""So many times its estimate may the true error be, and in so many of the runs it must be no more."""

WITHOUT_EVENTS = 42
"""Of so many scenes those that impulse steps smoothly: with events it takes seconds each, and sometimes minutes."""


DRAWN = 10 * len(MACHINES)
"""So many scenes hold everything there is."""

PLAIN, STRUCK = 0, 16
"""Scenes of a governor without effects, and of one whose stops are struck."""


def certified(drawn: RandomScene, *engines: str) -> list[CertificateCheck]:
    truth, asked = ReferenceSolutions(drawn.scene), draw_accuracies(drawn)
    every = [check_certificate(drawn, engine, asked[engine], truth) for engine in engines if engine in asked]
    return [one for one in every if one.is_judged]


def lawful(runs: list[CertificateCheck], factor: float = 1.0) -> float:
    """The share of runs that are no farther off than three times a part of their estimate."""
    return float(np.mean([one.true <= LAW * factor * one.estimate for one in runs]))


def short(runs: list[CertificateCheck]) -> list[tuple[int, str, float, float, str]]:
    """What to look at where the law is broken."""
    return [(one.number, one.engine, one.estimate, one.true, one.words) for one in runs if one.true > LAW * one.estimate]


@pytest.mark.parametrize("first", range(BLOCKS))
def test_estimates_of_fine_engines_are_neither_too_small_nor_much_too_large(first):
    runs = [one for number in range(first, SCENES, BLOCKS) for one in certified(draw_scene(number, SEED), "reduced", "multibody")]
    for engine in ("reduced", "multibody"):
        own = [one for one in runs if one.engine == engine]
        # The others' motion is a drive's, known to rounding, or one that no two engines agree upon closely enough.
        assert len(own) > 0.4 * SCENES / BLOCKS
        assert lawful(own) >= SHARE, short(own)
        # The estimate is the error of a run ten times looser; where steps are bounded otherwise, of one twice as long.
        assert 1 <= np.median([one.overestimation for one in own]) <= 100


def test_estimates_of_impulse_are_neither_too_small_nor_much_too_large():
    drawn = [draw_scene(number, SEED) for number in range(WITHOUT_EVENTS)]
    runs = [one for scene in drawn if scene.group != "events" for one in certified(scene, "impulse")]
    assert len(runs) > 0.3 * WITHOUT_EVENTS
    assert lawful(runs) >= SHARE, short(runs)
    assert 1 <= np.median([one.overestimation for one in runs]) <= 100


def test_an_estimate_a_thousand_times_too_small_is_found_out():
    runs = [one for number in range(14) for one in certified(draw_scene(number, SEED), "reduced", "multibody")]
    assert lawful(runs) == 1.0
    assert lawful(runs, 1e-3) < 0.5  # estimates are some ten times too large, seldom a thousand


@pytest.mark.parametrize("engine", [ReducedEngine(), MultibodyEngine()], ids=["reduced", "multibody"])
def test_a_run_that_is_not_what_it_says_is_found_out(engine):
    drawn = draw_scene(PLAIN, SEED)
    assert drawn.group == "plain"
    truth, run = ReferenceSolutions(drawn.scene), engine.run(drawn.scene, accuracy=1e-6)
    assert compare_with_references(run, 1e-6, truth)["true"] <= LAW * run.error_estimate
    name = run.scene.part.mechanism.coordinate
    wrong = run.readings[name].copy()
    wrong[len(wrong) // 2] += 10 * run.error_estimate  # one sample of one reading
    found = compare_with_references(replace(run, readings={**run.readings, name: wrong}), 1e-6, truth)
    assert found["true"] > LAW * run.error_estimate


@pytest.mark.parametrize("engine", [ReducedEngine(), MultibodyEngine()], ids=["reduced", "multibody"])
def test_an_event_that_is_not_told_is_found_out(engine):
    drawn = draw_scene(STRUCK, SEED)
    truth, run = ReferenceSolutions(drawn.scene), engine.run(drawn.scene, accuracy=1e-6)
    assert certified_events(run)
    assert compare_with_references(run, 1e-6, truth)["true"] <= LAW * run.error_estimate
    assert compare_with_references(replace(run, deferred_results=None), 1e-6, truth)["true"] > LAW * run.error_estimate


# --- what is drawn ----------------------------------------------------------------------------------------------------


def test_a_scene_follows_from_its_number():
    for number in range(len(MACHINES)):
        one, two = (draw_scene(number, SEED) for _ in range(2))
        assert one == two
        assert one.scene.part.mechanism != draw_scene(number, SEED + 1).scene.part.mechanism


def test_every_machine_and_effect_is_drawn_and_little_is_refused():
    every = [draw_scene(number, SEED) for number in range(DRAWN)]
    effects: set[type[Effect]] = {type(effect) for one in every for effect in one.scene.effects}
    assert effects >= {DryFriction, Dashpot, OutputSpring, Stops, Clearance, RodMasses, CrankMasses, BellCrankMasses}
    assert {one.machine for one in every} == set(MACHINES)
    turned = [one.scene.spindle for one in every if one.scene.has_centrifugal]
    assert any(isinstance(spindle, FreeSpindle) for spindle in turned)
    assert any(not isinstance(spindle, FreeSpindle) and spindle.speed_fluctuation for spindle in turned)
    assert any(not isinstance(spindle, FreeSpindle) and len(spindle.times) > 2 for spindle in turned)
    assert len({type(effect) for one in every for effect in one.scene.output_effects if len(one.scene.output_effects) == 1}) == 4
    assert sum(len(one.refused) for one in every) < 0.2 * DRAWN


# --- what it has taught -----------------------------------------------------------------------------------------------


def test_at_its_own_dead_centre_a_rubbed_reading_is_not_held_and_does_not_hold_up_the_run():
    """The mechanism carries it on, whatever force acts along it; it had been held there, step after tiny step."""
    drawn = draw_scene(192, 2)
    assert any(isinstance(effect, DryFriction) for effect in drawn.scene.output_effects)
    run = MultibodyEngine(max_steps=2000).run(drawn.scene, accuracy=1e-7)
    assert run.outcome is Outcome.DONE
    assert run.energy.drift < 1e-6
    assert run.energy.dissipated_energy[-1] > 0


def test_a_coordinate_that_comes_to_its_dead_centre_within_rounding_ends_the_run_by_name():
    scene = draw_scene(108, 2).scene
    run = ReducedEngine(max_steps=2000).run(scene, accuracy=1e-6)
    assert run.outcome is Outcome.DEAD_CENTRE
    assert MultibodyEngine(max_steps=2000).run(scene, accuracy=1e-6).outcome is Outcome.DONE

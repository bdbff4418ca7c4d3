"""The bill of a scene's effects: what is found small is small, what cannot be switched says so."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.rod_masses import Rods
from governor_mechanism.model.time_functions import Program
from governor_mechanism.render.figures.effect_ablation import effects_figure
from governor_mechanism.scenes.parser import scene_from_document
from governor_mechanism.studies.effect_ablation import effects_study

DOCUMENT = {
    "title": "Porter",
    "machine": "pendulum_governor",
    "dimensions": {"arm": 0.3, "offset": 0.04, "ball_mass": 5.0, "sleeve_mass": 20.0},
    "effects": {
        "gravity": True,
        "centrifugal": True,
        "rods": {"arm_mass": "0.6 kg"},
        "dry_friction": {"sleeve": "10 N"},
        "oil_brake": {"sleeve": "1e-9 N s/m"},
        "stops": {"arm_angle": ["15 deg", "60 deg"]},
    },
    "spindle": {"speed": "120 rpm"},
    "start": {"arm_angle": "40 deg"},
    "run": {"duration": "1 s", "every": "10 ms", "accuracy": 1e-6},
}


@pytest.fixture(scope="module")
def study():
    return effects_study(scene_from_document(DOCUMENT))


def test_every_listed_effect_is_switched_and_what_changes_nothing_is_named(study):
    assert [row.effect for row in study.rows if row.listed] == list(DOCUMENT["effects"])
    assert set(study.idle) == {"oil_brake", "stops"}  # a brake of next to nothing, stops that are never met
    assert set(study.untried) == {"spring", "play"}
    assert study.missing == ()
    rows = {row.effect: row for row in study.rows}
    assert rows["stops"].relative == 0.0
    assert 0.0 < rows["oil_brake"].relative < 1e-8
    assert rows["dry_friction"].with_it.events > rows["dry_friction"].without_it.events == 0
    assert rows["gravity"].relative > 0.1
    assert rows["rods"].time_ratio > 0


def test_a_change_is_that_of_two_runs(study):
    """The change of a reading is the difference of the scene's run from one that never listed the effect."""
    less = {key: value for key, value in DOCUMENT["effects"].items() if key != "dry_friction"}
    with_it, without = (gm.run(scene_from_document(document)) for document in (DOCUMENT, DOCUMENT | {"effects": less}))
    row = next(row for row in study.rows if row.effect == "dry_friction")
    expected = np.max(np.abs(with_it.readings["arm_angle"] - without.readings["arm_angle"]))
    assert row.changes["arm_angle"] == pytest.approx(expected, rel=1e-12)


def test_what_is_told_names_every_effect_and_goes_into_json(study):
    text = str(study)
    assert "leave out: oil_brake, stops" in text
    assert all(row.effect in text for row in study.rows)
    told = json.loads(json.dumps(study.as_json(), allow_nan=False))
    assert told["leave_out"] == ["oil_brake", "stops"]
    assert len(told["effects"]) == len(study.rows)


def test_the_figure_is_written_and_refuses_other_names(study, tmp_path):
    path = effects_figure(study, tmp_path / "bill.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    with pytest.raises(gm.MechanismError, match=r"end in \.png"):
        effects_figure(study, tmp_path / "bill.gif")
    assert [file.name for file in tmp_path.iterdir()] == ["bill.png"]


def test_effects_that_are_not_listed_are_tried_where_they_need_no_numbers():
    scene = scene_from_document(DOCUMENT | {"effects": {"gravity": True}, "run": {"duration": "0.1 s"}})
    study = effects_study(scene)
    assert [(row.effect, row.listed) for row in study.rows] == [("gravity", True), ("centrifugal", False)]
    assert study.missing == ("centrifugal",)
    assert "not listed, though it would show: centrifugal" in str(study)


def test_a_scene_made_in_python_is_studied_but_for_what_built_its_mechanism():
    base = scene_from_document(DOCUMENT | {"effects": {"gravity": True, "centrifugal": True}})
    friction = DryFriction(reading="sleeve_lift", force=Program(values=(10.0,)))
    made = replace(base, effects=(*base.effects, friction, OilBrake(reading="sleeve_lift", linear=1e-9)), document={})
    study = effects_study(made)
    assert study.idle == ("OilBrake",)
    gravity = next(row for row in study.rows if row.effect == "Gravity")
    assert gravity.note.startswith("the run without it ends early: arm_angle: the arms stand at 90 degrees")
    assert gravity.time_ratio is None
    with_rods = replace(made, effects=(*made.effects, Rods(arm_mass=0.1)))
    row = next(row for row in effects_study(with_rods).rows if row.effect == "Rods")
    assert row.relative is None
    assert "cannot be switched: Rods is built into the mechanism" in row.note


def test_an_effect_others_need_cannot_be_switched_and_says_why():
    uneven = DOCUMENT | {"spindle": {"speed": "120 rpm", "unevenness": 0.01}, "run": {"duration": "0.1 s"}}
    rows = {row.effect: row for row in effects_study(scene_from_document(uneven)).rows}
    assert "unevenness changes nothing" in rows["centrifugal"].note
    assert rows["spindle.unevenness"].relative > 1e-6

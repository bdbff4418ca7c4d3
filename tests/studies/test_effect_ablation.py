"""Effect ablation: negligible effects, costs, and effects that cannot be switched."""

import json
from dataclasses import replace

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.figures.work_precision import effect_ablation_figure
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.studies.effect_ablation import EffectComparison, EffectCost, run_effects_study
from refusing import refuses
from scene_documents import governor_document

EFFECTS = {"rods": {"arm_mass": "0.6 kg"}, "dry_friction": {"sleeve": "10 N"}, "dashpot": {"sleeve": "1e-9 N s/m"}}
DOCUMENT = governor_document(
    title="Porter",
    effects={"gravity": True, "centrifugal": True, **EFFECTS, "stops": {"arm_angle": ["15 deg", "60 deg"]}},
    spindle={"speed": "120 rpm"},
    start={"arm_angle": "40 deg"},
    run={"duration": "1 s", "output_interval": "10 ms", "accuracy": 1e-6},
)


@pytest.fixture(scope="module")
def study():
    return run_effects_study(parse_scene_document(DOCUMENT))


def test_every_listed_effect_is_switched_and_what_changes_nothing_is_named(study):
    assert [row.effect for row in study.rows if row.listed] == list(DOCUMENT["effects"])
    assert set(study.negligible) == {"dashpot", "stops"}  # a brake of next to nothing, stops that are never met
    assert set(study.untried) == {"spring", "clearance"}
    assert study.missing == ()
    rows = {row.effect: row for row in study.rows}
    assert rows["stops"].relative_change == 0.0
    assert 0.0 < rows["dashpot"].relative_change < 1e-8
    assert rows["dry_friction"].cost_with.events > rows["dry_friction"].cost_without.events == 0
    assert rows["gravity"].relative_change > 0.1


def test_the_time_ratio_is_that_of_the_runs_with_and_without_the_effect():
    costs = {"cost_with": EffectCost(evaluations=10, steps=5, events=0, wall_time=0.3)}
    costs["cost_without"] = replace(costs["cost_with"], wall_time=0.1)
    row = EffectComparison(effect="stops", listed=True, changes={}, most_changed_reading="", relative_change=0.0, **costs)
    assert row.time_ratio == pytest.approx(3.0)
    assert replace(row, note="the run ends early").time_ratio is None
    assert replace(row, cost_without=None).time_ratio is None


def test_a_change_is_that_of_two_runs(study):
    """The change of a reading is the difference of the scene's run from one that never listed the effect."""
    less = {key: value for key, value in DOCUMENT["effects"].items() if key != "dry_friction"}
    with_it, without = (gm.run(parse_scene_document(document)) for document in (DOCUMENT, DOCUMENT | {"effects": less}))
    row = next(row for row in study.rows if row.effect == "dry_friction")
    expected = np.max(np.abs(with_it.readings["arm_angle"] - without.readings["arm_angle"]))
    assert row.changes["arm_angle"] == pytest.approx(expected, rel=1e-12)


def test_the_report_and_the_json_name_every_effect(study):
    text = str(study)
    assert "leave out: dashpot, stops" in text
    assert all(row.effect in text for row in study.rows)
    document = json.loads(json.dumps(study.as_json(), allow_nan=False))
    assert document["leave_out"] == ["dashpot", "stops"]
    assert len(document["effects"]) == len(study.rows)


def test_the_figure_is_written_and_refuses_other_names(study, tmp_path):
    assert effect_ablation_figure(study).save(tmp_path / "effects.png").read_bytes().startswith(b"\x89PNG")
    refuses(r"end in one of \.png", effect_ablation_figure(study).save, tmp_path / "effects.gif")
    assert [file.name for file in tmp_path.iterdir()] == ["effects.png"]


def test_a_difference_of_times_within_the_noise_has_no_bar(study):
    row = next(one for one in study.rows if one.time_ratio is not None)
    shown = {}
    for ratio in (1.05, 1.6):
        cost = replace(row.cost_with, wall_time=ratio * row.cost_without.wall_time)
        changed = replace(study, rows=(replace(row, cost_with=cost),))
        _, panel = effect_ablation_figure(changed).axes
        bars = [one for one in panel.patches if one.get_height() == pytest.approx(0.6)]
        shown[ratio] = len(bars), "below noise" in [text.get_text() for text in panel.texts]
    assert shown == {1.05: (0, True), 1.6: (1, False)}


def test_effects_that_are_not_listed_are_tried_where_they_need_no_numbers():
    scene = parse_scene_document(DOCUMENT | {"effects": {"gravity": True}, "run": {"duration": "0.1 s"}})
    study = run_effects_study(scene)
    assert [(row.effect, row.listed) for row in study.rows] == [("gravity", True), ("centrifugal", False)]
    assert study.missing == ("centrifugal",)
    assert "not listed, but significant: centrifugal" in str(study)


def test_a_scene_made_in_python_is_studied_but_for_what_built_its_mechanism():
    base = parse_scene_document(DOCUMENT | {"effects": {"gravity": True, "centrifugal": True}})
    friction = DryFriction(reading="sleeve_lift", force=InputFunction(values=(10.0,)))
    made = base.with_changes(effects=(*base.effects, friction, Dashpot(reading="sleeve_lift", linear=1e-9)), document={})
    study = run_effects_study(made)
    assert study.negligible == ("Dashpot",)
    gravity = next(row for row in study.rows if row.effect == "Gravity")
    assert gravity.note.startswith("the run without it ends early: arm_angle: the arms are at 90 degrees")
    assert gravity.time_ratio is None
    with_rods = made.with_changes(effects=(*made.effects, RodMasses(arm_mass=0.1)))
    row = next(row for row in run_effects_study(with_rods).rows if row.effect == "RodMasses")
    assert row.relative_change is None
    assert "cannot be switched: RodMasses is part of the mechanism" in row.note


def test_an_effect_others_need_cannot_be_switched_and_says_why():
    fluctuating = DOCUMENT | {"spindle": {"speed": "120 rpm", "speed_fluctuation": 0.01}, "run": {"duration": "0.1 s"}}
    rows = {row.effect: row for row in run_effects_study(parse_scene_document(fluctuating)).rows}
    assert "speed_fluctuation has no effect" in rows["centrifugal"].note
    assert rows["spindle.speed_fluctuation"].relative_change > 1e-6


def test_a_contact_is_switched_off_like_an_effect():
    scene = gm.load("disc_cam").replace({"run.duration": "0.05 s", "start": {"roller_gap": 0.0}})
    study = run_effects_study(scene)
    (row,) = (row for row in study.rows if row.effect == "contact roller")
    assert row.listed
    assert not row.note
    document = {key: value for key, value in dict(scene.document).items() if key not in ("contact", "start")}
    free = gm.run(gm.Scene.from_dict(document), times=gm.run(scene).times)
    assert row.changes["lift"] == pytest.approx(np.abs(free.readings["lift"] - gm.run(scene).readings["lift"]).max(), rel=1e-9)
    assert "contact roller" in str(study)


def test_a_contact_of_a_scene_made_in_python_is_switched_off_too():
    scene = replace(gm.load("disc_cam").replace({"run.duration": "0.02 s"}), document={})
    (row,) = (row for row in run_effects_study(scene).rows if row.effect == "contact roller")
    assert row.changes["lift"] > 1e-4

"""Options of `run` and `--set` of every command; the commands about scenes."""

import json
import os
import tomllib
from pathlib import Path

import pytest
from PIL import Image

import governor_mechanism as gm
from command_line import invoke, json_of, succeed
from governor_mechanism.cli.options import TEMPLATES, complete_machine, complete_scene, load_changed, parse_changes
from governor_mechanism.files.results import count_events
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.scenes.json_schema import scene_schema
from governor_mechanism.scenes.template import TEMPLATE_NAMES, scene_template
from refusing import refuses


def test_values_of_set_are_written_as_in_a_scene_file():
    texts = ["a.b=320mm", 'c="40 deg"', "d = 0.5", "e=true", 'f={ sleeve = "40 N" }', "g=[1, 2]", "h=", "i=x=y"]
    expected = {"a.b": "320mm", "c": "40 deg", "d": 0.5, "e": True, "f": {"sleeve": "40 N"}, "g": [1, 2], "h": None, "i": "x=y"}
    assert parse_changes(texts) == expected
    assert parse_changes(["t=1\nu = 2"]) == {"t": "1\nu = 2"}  # one value, not two keys


@pytest.mark.parametrize("texts", [["dimensions.arm"], ["=3"], ["a..b=1"], ["a=1", "a=2"]])
def test_what_is_no_assignment_is_refused(texts):
    refuses("--set", parse_changes, texts)


def test_a_changed_scene_keeps_its_name_and_is_checked_like_a_file():
    scene = load_changed("porter", ["dimensions.arm=320 mm", "effects.dashpot.sleeve=100 N s/m"], run__duration=1.0)
    assert (scene.part.dimensions["arm"], scene.run.duration, Path(scene.source).stem) == (0.32, 1.0, "porter")
    assert [effect.key for effect in scene.effects] == ["gravity", "centrifugal", "dashpot"]
    assert load_changed("porter", ["dimensions.offset="]).part.dimensions["offset"] == 0.0  # its default
    assert load_changed("porter", None) is gm.load("porter")


def test_run_prints_four_lines_and_writes_a_record_without_paths(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(scene_template("pendulum_governor"), encoding="utf-8")
    words = ["--set", "dimensions.arm=320 mm", "--seconds", "0.5 s", "--title", "Long arms", "--no-film", "--accuracy", "1e-5"]
    result = succeed("run", tmp_path / "mine.toml", *words)
    first, second, third, fourth = result.stdout.splitlines()
    assert first.startswith("Long arms: 0.5 s with engine ")
    assert "(requested 1e-05); computed in " in second
    assert third.startswith(("events: ", "no events"))
    assert fourth == "wrote mine.png, mine.csv, mine.nc, mine.json in results"
    text = (tmp_path / "results" / "mine.json").read_text(encoding="utf-8")
    record = json.loads(text)
    assert str(tmp_path) not in text
    assert (record["scene"], record["title"], record["document"]["dimensions"]["arm"]) == ("mine.toml", "Long arms", "320 mm")
    assert record["end_time"] == 0.5


def test_a_run_with_too_few_steps_ends_by_name(tmp_path):
    result = invoke("run", "porter", "--max-steps", "3", "--seconds", "1", "--no-film", "--out", str(tmp_path))
    assert result.exit_code == 1
    assert "max_steps = 3 reached" in result.stderr
    assert json.loads((tmp_path / "porter.json").read_text(encoding="utf-8"))["outcome"] == "step_limit"


def test_a_film_has_the_size_and_the_frame_rate_that_are_asked_for(tmp_path):
    words = ["run", "porter", "--seconds", "1", "--fps", "5", "--size", "320x320", "--accuracy", "1e-4", "--out", str(tmp_path)]
    succeed(*words)
    with Image.open(tmp_path / "porter.gif") as film:
        assert film.size == (320, 320)
        assert film.n_frames == 5


@pytest.mark.parametrize(
    ("words", "key"),
    [
        (["crosscheck", "slider_crank"], "dimensions.crank_speed=70 rpm"),
        (["equilibria", "porter", "--no-figure"], "dimensions.sleeve_mass=10 kg"),
        (["describe", "porter"], "dimensions.sleeve_mass=10 kg"),
    ],
)
def test_set_changes_the_scene_of_other_commands(words, key):
    assert json_of(*words) != json_of(*words, "--set", key)


def test_each_command_with_a_scene_has_set():
    for words in (["accuracy"], ["effects"], ["sweep"], ["regulation", "loop"], ["regulation", "map"]):
        assert "--set" in invoke(*words, "--help").stdout


def test_events_are_counted_by_kind():
    kinds = [EventKind.TURNING_POINT, EventKind.IMPACT, EventKind.TURNING_POINT, EventKind.CROSSING, EventKind.REST, EventKind.REST]
    events = [Event(time=float(k), kind=kind, subject="cut_off") for k, kind in enumerate(kinds)]
    assert count_events(events) == "events: 1 crossing, 1 impact, 2 rests on stops, 2 turning points; first crossing cut_off at t = 3 s"
    assert count_events([]) == "no events"


@pytest.mark.parametrize("name", ["hartung", "governed-engine", "custom"])
def test_init_prints_a_scene_file(name):
    result = succeed("init", name)
    assert result.stdout == scene_template(name)
    assert tomllib.loads(json_of("init", name)["text"]) == tomllib.loads(result.stdout)


def test_describe_prints_text_and_json():
    text = succeed("describe", "porter").stdout
    assert "arm          300 mm  length from the suspension to the ball's centre" in text
    assert json_of("describe", "porter")["degrees_of_freedom"] == 1


def test_schema_prints_the_schema():
    assert json.loads(succeed("schema").stdout) == json_of("schema") == json.loads(json.dumps(scene_schema()))


def test_the_shell_completes_scenes_files_and_machines(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "watt_mine.toml").write_text("", encoding="utf-8")
    (tmp_path / "water").mkdir()
    (tmp_path / "wattage.txt").write_text("", encoding="utf-8")
    assert complete_scene("watt_i") == ["watt_improved"]
    known = {name for name in (*gm.list_models(), *gm.list_catalogue()) if name.startswith("wat")}
    assert set(complete_scene("wat")) == known | {"water/", "watt_mine.toml"}
    assert complete_scene("no_such_folder/x") == []
    assert complete_machine("sl") == ["slide_valve", "slider_crank"]
    assert TEMPLATES == TEMPLATE_NAMES


def test_the_command_answers_the_shell(monkeypatch):
    settings = {"_GOVERNOR_MECHANISM_COMPLETE": "complete_bash", "COMP_WORDS": "governor-mechanism run porter_c", "COMP_CWORD": "2"}
    result = invoke(prog_name="governor-mechanism", env=os.environ | settings)
    assert result.stdout.split() == ["porter_clearance", "porter_cyclic", "porter_cyclic_damped"]

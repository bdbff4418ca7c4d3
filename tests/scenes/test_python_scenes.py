"""Scenes written and changed in Python are those of the files with the same text, and are checked like them."""

import tomllib

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.scenes import library
from governor_mechanism.scenes.changed_document import format_scene_toml
from governor_mechanism.scenes.parser import parse_scene_document, read_scene_file
from refusing import refusal

PORTER = library.models_folder() / "porter.toml"


@pytest.fixture(scope="module")
def porter() -> Scene:
    return gm.load("porter")


@pytest.mark.parametrize("name", gm.list_models())
def test_the_text_of_every_shipped_scene_is_read_back_as_an_equal_scene(name, tmp_path):
    scene = library.load_scene(name)
    untitled = parse_scene_document({key: value for key, value in scene.document.items() if key != "title"})
    path = tmp_path / "named_by_its_file.toml"
    assert untitled.save(path) == path
    named_by_its_file = read_scene_file(path)
    assert (untitled.title, named_by_its_file.title) == (untitled.parts[0].machine, "named_by_its_file")
    for one in (scene, named_by_its_file):
        assert parse_scene_document(tomllib.loads(one.to_toml())) == one


def test_the_text_holds_whatever_toml_holds():
    document = {
        "title": 'quoted "title" \\ with a backslash, an é and \x7f',
        "empty": {},
        "body": [
            {"name": "a", "points": {"A 1": [0.1, 1e-7], 'dot.and"quote': [1, -2.5e22]}},
            {"name": "b", "nested": [{"x": []}, [True]]},
        ],
        "numbers": [1, 2.0, -0.0, 1e300, 5e-324],
        "part": {"engine": {"machine": "m", "run": {"duration": "1 s"}, "body": [{"name": "c"}]}, "bare": {}},
    }
    assert tomllib.loads(format_scene_toml(document, "two\nlines")) == document


def test_numbers_of_numpy_are_written_as_numbers(porter):
    changed = porter.replace({"dimensions.arm": np.float64(0.32), "run.duration": np.float32(2.0), "dimensions.sleeve_mass": np.int64(20)})
    assert parse_scene_document(tomllib.loads(changed.to_toml())).run.duration == 2.0
    assert "cannot hold" in refusal(format_scene_toml, {"title": object()})


def test_a_dictionary_makes_the_scene_of_the_file(porter):
    scene = gm.Scene.from_dict(tomllib.loads(PORTER.read_text(encoding="utf-8")))
    assert scene == porter
    assert scene.source == ""


def test_a_dictionary_is_copied():
    document = tomllib.loads(PORTER.read_text(encoding="utf-8"))
    scene = gm.Scene.from_dict(document)
    document["dimensions"]["arm"] = "400 mm"
    assert scene.document["dimensions"]["arm"] == "300 mm"


def test_a_dictionary_has_the_mistakes_of_the_file():
    text = PORTER.read_text(encoding="utf-8").replace('arm = "300 mm"', 'arn = "300 mm"').replace("gravity", "gravty")
    with pytest.raises(gm.MechanismError) as of_file:
        parse_scene_document(tomllib.loads(text))
    with pytest.raises(gm.MechanismError) as of_dictionary:
        gm.Scene.from_dict(tomllib.loads(text))
    assert of_dictionary.value.problems == of_file.value.problems
    assert len(of_file.value.problems) == 2


def test_a_start_that_cannot_be_assembled_is_a_mistake_of_the_scene():
    assert "stays open" in refusal(gm.load("four_bar_chain").replace, {"ground.A1": ["5 m", 0]})


def test_a_changed_copy_is_the_scene_of_the_changed_file(porter):
    text = PORTER.read_text(encoding="utf-8").replace('arm = "300 mm"', 'arm = "320 mm"')
    assert porter.replace({"dimensions.arm": "320 mm"}) == parse_scene_document(tomllib.loads(text))
    assert porter.document["dimensions"]["arm"] == "300 mm"  # the original is as it was


def test_none_leaves_a_key_out(porter):
    free = porter.replace({"spindle.speed": None, "spindle.inertia": "0.5 kg m^2", "spindle.start_speed": "120 rpm"})
    assert free.spindle.inertia == 0.5
    assert "effects" not in porter.replace({"effects": None}).document
    assert "no table start.x" in refusal(porter.replace, {"start.x.y": None})


def test_a_title_from_the_name_of_a_file_stays(tmp_path):
    path = tmp_path / "my_governor.toml"
    path.write_text(PORTER.read_text(encoding="utf-8").replace("title =", "# title ="), encoding="utf-8")
    scene = gm.load(path)
    assert scene.title == "my_governor"
    assert scene.replace({"run.duration": 1.0}).title == "my_governor"
    assert tomllib.loads(scene.to_toml())["title"] == "my_governor"


def test_items_of_a_list_are_named_or_numbered():
    chain = gm.load("four_bar_chain")
    by_name, by_number = chain.replace({"body.middle crank.mass": 2.0}), chain.replace({"body.2.mass": 2.0})
    assert by_name == by_number
    assert [body.mass for body in by_name.mechanism.bodies] == [1.0, 2.0, 1.0, 1.0, 1.0]
    without = chain.replace({"body.second coupler": None, "joint.B1 right": None, "joint.B2": None})
    assert [body.name for body in without.mechanism.bodies] == ["first crank", "middle crank", "last crank", "first coupler"]


def test_changes_without_keys_are_refused(porter):
    for values in ({3: 1}, "dimensions.arm=320mm"):
        assert "replace takes values by key" in refusal(porter.replace, values)


def test_a_scene_that_was_composed_of_objects_has_no_file(porter):
    composed = Scene(title=porter.title, parts=porter.parts)
    for method in (composed.to_toml, lambda: composed.replace({"run.duration": 1.0})):
        assert "composed of objects" in refusal(method)
    assert "changed without it" in refusal(porter.with_changes(run=RunSettings(duration=1.0)).to_toml)


def test_a_scene_is_saved_as_a_file_that_is_read_back(porter, tmp_path):
    assert gm.load(porter.save(tmp_path / "mine.toml")) == porter
    for name in ("mine.txt", "mine", ""):
        assert refusal(porter.save, name) == f"the name of a scene file ends in .toml, as my_scene.toml; found {name!r}"
    assert refusal(porter.save, 3).startswith("path must be a path; found 3")


def test_a_description_prints_as_text(porter):
    text = str(porter.describe())
    assert all(word in text for word in ("300 mm", "gravity", "sleeve_lift", "reduced"))

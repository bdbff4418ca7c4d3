"""The JSON Schema of scene files accepts what the parser accepts, and names what an editor should underline."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from governor_mechanism.scenes.json_schema import scene_schema
from governor_mechanism.scenes.library import catalogue_scenes, models_folder, shipped_scenes
from governor_mechanism.scenes.template import TEMPLATE_NAMES, scene_template

jsonschema = pytest.importorskip("jsonschema")

README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")
PORTER = tomllib.loads(shipped_scenes()["porter"].read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def validator():
    schema = scene_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    return jsonschema.Draft7Validator(schema)


def test_the_shipped_file_is_up_to_date():
    """Written by `governor-mechanism schema > models/scene.schema.json`."""
    assert json.loads((models_folder() / "scene.schema.json").read_text(encoding="utf-8")) == json.loads(json.dumps(scene_schema()))


def test_it_accepts_every_shipped_scene_which_names_it(validator):
    for path in shipped_scenes().values():
        text = path.read_text(encoding="utf-8")
        assert text.startswith("#:schema ./scene.schema.json\n")
        assert not [error.message for error in validator.iter_errors(tomllib.loads(text))], path.stem


def test_it_accepts_every_scene_of_the_catalogue(validator):
    for path in catalogue_scenes().values():
        document = tomllib.loads(path.read_text(encoding="utf-8"))
        assert not [error.message for error in validator.iter_errors(document)], path.stem
    assert list(validator.iter_errors({**document, "law": {**document["law"], "family": "bridges"}}))
    assert list(validator.iter_errors({**document, "dimensions": {"crank": ["20 mm"]}}))


def test_it_accepts_the_scenes_of_the_readme_and_those_to_begin_with(validator):
    texts = [*re.findall(r"```toml\n(.*?)```", README, flags=re.DOTALL), *map(scene_template, TEMPLATE_NAMES)]
    assert not [error.message for text in texts for error in validator.iter_errors(tomllib.loads(text))]


def test_every_comment_of_the_template_of_a_custom_machine_is_an_example_that_it_accepts(validator):
    """The comments hold whole tables; uncommented together they exclude each other, but each fits the schema."""
    text = re.sub(r"^# (?=\[|\w+ = )", "", scene_template("custom"), flags=re.MULTILINE)
    document = tomllib.loads(text)
    assert [joint["type"] for joint in document["joint"]][-1] == "driven_turn"
    assert {"link", "events", "plane", "size"} < document.keys()
    assert not [error.message for error in validator.iter_errors(document)]


@pytest.mark.parametrize(
    ("change", "place"),
    [
        ({"machine": "pendulum"}, "machine"),
        ({"dimensions": {"arm": "300 mm", "ball_mass": "5 kg", "amr": 1}}, "dimensions"),
        ({"dimensions": {"arm": -0.3, "ball_mass": "5 kg"}}, "arm"),
        ({"dimensions": {"ball_mass": "5 kg"}}, "dimensions"),
        ({"effects": {"gravty": True}}, "effects"),
        ({"effects": {"dry_friction": {}}}, "dry_friction"),
        ({"spindle": {"sped": "120 rpm"}}, "spindle"),
        ({"run": {"engine": "fast"}}, "engine"),
        ({"events": {"one": {"reading": "arm_angle"}}}, "one"),
        ({"body": []}, ""),
    ],
)
def test_mistakes_are_found_where_they_are(validator, change, place):
    errors = list(validator.iter_errors(PORTER | change))
    assert place in [str(error.absolute_path[-1]) if error.absolute_path else "" for error in errors]


def test_several_parts_and_custom_machines_are_checked_too(validator):
    coupled = tomllib.loads(shipped_scenes()["governed_engine"].read_text(encoding="utf-8"))
    coupled["coupling"]["gear"]["typ"] = coupled["coupling"]["gear"].pop("type")
    coupled["part"]["governor"]["effects"]["gravty"] = True
    custom = tomllib.loads(scene_template("custom"))
    custom["joint"][0]["type"] = "pinn"
    custom["body"][0]["lenght"] = 1.0
    for document, n_errors in ((coupled, 2), (custom, 2)):
        assert len({tuple(error.absolute_path) for error in validator.iter_errors(document)}) == n_errors

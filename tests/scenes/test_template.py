"""Scene files to begin with: every one runs, names all dimensions of its machine, and its comments may be uncommented."""

import dataclasses
import re
import tomllib

import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.scenes.custom.parts import FORCE_TYPES, JOINT_TYPES
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.scenes.template import GOVERNED_ENGINE, TEMPLATE_NAMES, scene_template
from refusing import refuses


def test_there_is_one_for_every_machine():
    assert set(TEMPLATE_NAMES) == {*MACHINES, CUSTOM_MACHINE, GOVERNED_ENGINE}


@pytest.mark.parametrize("name", TEMPLATE_NAMES)
def test_it_runs_for_a_second(name):
    scene = parse_scene_document(tomllib.loads(scene_template(name))).replace({"run.duration": "1 s", "run.accuracy": 1e-5})
    run = gm.run(scene, certify=False)
    assert run.outcome.ok
    assert run.times[-1] == 1.0


@pytest.mark.parametrize("name", MACHINES)
def test_it_names_every_dimension_and_gives_all_that_are_needed(name):
    text = scene_template(name)
    given = tomllib.loads(text)["dimensions"]
    for field in dataclasses.fields(MACHINES[name]):
        assert re.search(rf"^(# )?{field.name} = ", text, flags=re.MULTILINE)
        assert field.name in given or field.default is not dataclasses.MISSING


def problems_of(text: str) -> list[str]:
    try:
        parse_scene_document(tomllib.loads(text))
    except MechanismError as error:
        return list(error.problems)
    return []


@pytest.mark.parametrize("name", [name for name in TEMPLATE_NAMES if name != CUSTOM_MACHINE])
def test_every_key_in_a_comment_is_known(name):
    """Each is uncommented alone, since some exclude each other; so none may be added to the values that are given, but all are known."""
    lines = scene_template(name).splitlines()
    for number, line in enumerate(lines):
        if not re.match(r"# \w+ = ", line) or lines[number - 1].startswith("# [events]"):
            continue
        key = line[2:].partition(" = ")[0]
        text = "\n".join([*(one for one in lines[:number] if not one.startswith(f"{key} = ")), line[2:], *lines[number + 1 :]])
        assert not [problem for problem in problems_of(text) if "unknown" in problem]


def test_that_of_a_custom_machine_names_all_joints_and_forces():
    text = scene_template(CUSTOM_MACHINE)
    assert f"# {', '.join(JOINT_TYPES)}" in text
    assert f"# {', '.join(FORCE_TYPES)}" in text


def test_a_misspelt_machine_is_answered_with_the_nearest_one():
    refuses(r"no machine 'pendulum_govenor'\. Did you mean 'pendulum_governor'\?", scene_template, "pendulum_govenor")
    assert scene_template("governed_engine") == scene_template("governed-engine")

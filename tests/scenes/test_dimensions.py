"""Named dimensions of a custom machine: texts such as "= 2 * crank" follow them, and every mistake in them has one sentence."""

import math
import tomllib
from typing import Any

import pytest

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError

DOCUMENT: dict[str, Any] = {
    "machine": "custom",
    "dimensions": {"crank": "100 mm", "rod": "= 3 * crank", "speed": "60 rpm", "ball": "2 kg", "tilt": "30 deg"},
    "ground": {"O": [0, 0]},
    "body": [
        {"name": "crank", "mass": "= ball / 2", "rod": {"length": "= crank"}, "angle": "= tilt"},
        {"name": "rod", "mass": "= ball", "rod": {"length": "= rod"}, "at": ["= crank", 0]},
    ],
    "joint": [
        {"type": "pin", "first": "ground.O", "second": "crank.start"},
        {"type": "pin", "first": "crank.end", "second": "rod.start"},
        {"type": "slider", "first": "ground.O", "second": "rod.end", "angle": 0},
        {"type": "driven_turn", "first": "ground", "second": "crank", "rate": "= 2 * speed"},
    ],
    "readings": {"crank_angle": {"angle": "crank"}, "slide": {"x": "rod.end"}},
    "run": {"duration": "0.1 s"},
}


def slide_at_zero(scene: gm.Scene) -> float:
    return float(gm.kinematics(scene, "crank_angle", [0.0]).readings["slide"][0])


def problems_of(**changes: Any) -> list[str]:
    with pytest.raises(MechanismError) as refusal:
        gm.Scene.from_dict({**DOCUMENT, **changes})
    return list(refusal.value.problems)


def test_lengths_masses_angles_and_speeds_follow_the_dimensions():
    scene = gm.Scene.from_dict(DOCUMENT)
    assert dict(scene.part.dimensions) == pytest.approx({"crank": 0.1, "rod": 0.3, "speed": 2 * math.pi, "ball": 2.0, "tilt": math.pi / 6})
    assert [body.mass for body in scene.mechanism.bodies] == [1.0, 2.0]
    assert slide_at_zero(scene) == pytest.approx(0.4, rel=1e-12)
    turn = gm.run(scene).readings["crank_angle"]
    assert turn[-1] - turn[0] == pytest.approx(4 * math.pi * 0.1, rel=1e-9)


def test_a_changed_dimension_changes_what_is_defined_by_it():
    scene = gm.Scene.from_dict(DOCUMENT)
    assert slide_at_zero(scene.replace({"dimensions.crank": "200 mm"})) == pytest.approx(0.8, rel=1e-12)
    assert slide_at_zero(scene.replace({"dimensions.rod": "200 mm"})) == pytest.approx(0.3, rel=1e-12)
    again = gm.Scene.from_dict(tomllib.loads(scene.to_toml()))
    assert slide_at_zero(again.replace({"dimensions.crank": "200 mm"})) == pytest.approx(0.8, rel=1e-12)


def test_a_description_lists_the_dimensions_with_their_definitions():
    lines = [line.split() for line in str(gm.Scene.from_dict(DOCUMENT).describe()).splitlines()]
    assert ["crank", "100", "mm"] in lines
    assert ["rod", "300", "mm", "=", "3", "*", "crank"] in lines
    assert ["tilt", "30", "deg"] in lines


def test_dimensions_of_a_part_belong_to_it():
    tables = {key: value for key, value in DOCUMENT.items() if key != "run"}
    scene = gm.Scene.from_dict({"part": {"left": tables, "right": {**tables, "dimensions": {**DOCUMENT["dimensions"], "crank": "50 mm"}}}})
    assert [part.dimensions["rod"] for part in scene.parts] == pytest.approx([0.3, 0.15])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"a": "= b", "b": "= a"}, ["dimensions.a is defined by itself: a -> b -> a", "dimensions.b is defined by itself: b -> a -> b"]),
        (
            {"a": "= crnk"},
            ["dimensions.a names the unknown dimension \"crnk\"; dimensions are crank, rod, speed, ball, tilt, a. Did you mean 'crank'?"],
        ),
        ({"a": "= crank + ball"}, ["dimensions.a: + is between quantities of different units: a length and a mass"]),
        ({"a": "= sqrt(-crank^2)"}, ['dimensions.a "= sqrt(-crank^2)" has no finite value with these dimensions']),
        ({"a": "= 1 / 0"}, ["has no finite value"]),
        ({"a": "3 parsec"}, ['dimensions.a is no quantity; found "3 parsec"']),
        ({"a": True}, ["dimensions.a must be a quantity"]),
        ({"a b": 1}, ["dimensions.a b is no name of a dimension"]),
        ({"sqrt": 1}, ["dimensions.sqrt is no name of a dimension"]),
    ],
)
def test_a_wrong_dimension_is_refused_where_it_stands(change: dict[str, Any], words: list[str]):
    problems = problems_of(dimensions={**DOCUMENT["dimensions"], **change})
    assert len(problems) == len(words)
    assert all(text in problem for text, problem in zip(words, problems, strict=True))


def test_a_dimension_with_a_mistake_is_reported_once_and_not_where_it_is_used():
    assert problems_of(dimensions={**DOCUMENT["dimensions"], "crank": "100 mmm"}) == [
        'dimensions.crank is no quantity; found "100 mmm"; write a number with its unit, as "300 mm", a bare number, '
        'or an expression of other dimensions, as "= 2 * crank"'
    ]


def test_an_expression_of_another_kind_is_refused_with_the_key_that_has_it():
    bodies = [{**DOCUMENT["body"][0], "mass": "= crank"}, {**DOCUMENT["body"][1], "rod": {"length": "= crank / rod"}}]
    assert problems_of(body=bodies) == [
        'body "crank": mass is a mass; "= crank" is a length',
        'body "rod": rod.length is a length; "= crank / rod" is a plain number',
    ]


def test_all_wrong_expressions_of_a_file_are_reported_at_once():
    bodies = [{**DOCUMENT["body"][0], "mass": "= bal"}, {**DOCUMENT["body"][1], "at": ["= 2 *", "= croc"]}]
    problems = problems_of(body=bodies, ground={"O": [0, "= zero"]})
    starts = ["ground.O.2 names", 'body "crank": mass names', 'body "rod": at.1: " 2 *" ends too early', 'body "rod": at.2 names']
    assert len(problems) == len(starts)
    assert all(problem.startswith(start) for problem, start in zip(problems, starts, strict=True))


def test_a_frequency_counts_cycles_of_a_turning_dimension():
    drive = {"type": "driven_turn", "first": "ground", "second": "crank"}
    motion = {"start": 0, "harmonics": [{"amplitude": "= tilt", "frequency": "= speed"}]}
    scene = gm.Scene.from_dict({**DOCUMENT, "joint": [*DOCUMENT["joint"][:3], {**drive, "motion": motion}]})
    angles = gm.kinematics(scene, "time", [0.0, 0.25, 1.0]).readings["crank_angle"]
    assert angles == pytest.approx([0.0, math.pi / 6, 0.0], abs=1e-12)


def test_a_change_of_a_dimension_that_does_not_exist_is_refused():
    with pytest.raises(MechanismError, match=r"dimensions\.crnk is no dimension of this scene; they are crank, .*Did you mean 'crank'\?"):
        gm.Scene.from_dict(DOCUMENT).replace({"dimensions.crnk": "200 mm"})
    tables = {key: value for key, value in DOCUMENT.items() if key != "run"}
    with pytest.raises(MechanismError, match=r"part\.left\.dimensions\.crnk is no dimension of this scene"):
        gm.Scene.from_dict({"part": {"left": tables, "right": tables}}).replace({"part.left.dimensions.crnk": "200 mm"})

"""Wrong types of arguments are refused in sentences, without Python's way of writing values, and results compare without errors."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import governor_mechanism as gm
from governor_mechanism.engines import ReducedEngine

NOT_A_SENTENCE = ("<class", "<function", "<object", "object at", "array(", "PosixPath", "Trajectory(", "\x1b")


@pytest.fixture(scope="module")
def run():
    return gm.run("slider_crank", times=[0.0, 0.1, 0.2])


def refusal(function, *arguments: Any, **options: Any) -> str:
    with pytest.raises(gm.MechanismError) as caught:
        function(*arguments, **options)
    message = str(caught.value)
    assert message
    assert not [mark for mark in NOT_A_SENTENCE if mark in message]
    return message


WRONG_VALUES = [None, 3, True, float("nan"), b"x", [], {}, [None], object(), np.array([1.0, 2.0]), 1j, 10**400, lambda: 0]


@pytest.mark.parametrize("wrong", WRONG_VALUES, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize(
    "function",
    [
        gm.load,
        gm.run,
        gm.crosscheck,
        lambda scene: gm.kinematics(scene, "crank_angle", [0.1]),
        gm.speed_curve,
        lambda scene: gm.insensitivity_band(scene, [0.5], "40 N"),
        gm.controlling_force,
        gm.equilibria,
        gm.linearise,
        lambda scene: gm.stability_limit(scene, "effects.dashpot.sleeve", 0.0, 1.0),
        gm.accuracy_study,
        gm.effects_study,
        lambda scene: gm.sweep(scene, {"dimensions.arm": [0.3]}),
        gm.valve_timing,
        ReducedEngine().run,
        lambda run: gm.film(run, "film.gif"),
    ],
)
def test_what_is_no_scene_or_run_is_refused(function, wrong):
    refusal(function, wrong)


CALLS: dict[str, tuple[Any, dict[str, Any], list[Any]]] = {
    "run": (gm.run, {"scene": "slider_crank", "times": [0.0, 0.1]}, ["engine", "certify", "times", "accuracy"]),
    "crosscheck": (
        gm.crosscheck,
        {"scene": "porter", "kernel": lambda arm: 1.0, "over": {"arm_angle": [0.5]}, "quantity": "sleeve_lift"},
        ["kernel", "quantity", "over", "allowed"],
    ),
    "kinematics": (
        gm.kinematics,
        {"scene": "slider_crank_torque", "over": "crank_angle", "values": [0.1]},
        ["over", "values", "rate", "acceleration"],
    ),
    "speed_curve": (gm.speed_curve, {"scene": "watt_improved", "resistance": 1.0}, ["points", "against"]),
    "controlling_force": (
        gm.controlling_force,
        {"scene": "watt_improved"},
        ["over", "points", "between", "speed_change", "resistance", "against", "radius", "balls"],
    ),
    "equilibria": (gm.equilibria, {"scene": "watt_improved"}, ["spindle_speed"]),
    "linearise": (gm.linearise, {"scene": "porter_dashpot"}, ["spindle_speed", "at"]),
    "limit": (gm.stability_limit, {"scene": "watt_engine_stable", "key": "x", "low": 0.0, "high": 1.0}, ["key"]),
    "accuracy_study": (gm.accuracy_study, {"scene": "slider_crank"}, ["progress"]),
    "effects_study": (gm.effects_study, {"scene": "slider_crank"}, ["engine", "progress"]),
    "sweep": (
        gm.sweep,
        {"scene": "slider_crank", "vary": {"dimensions.crank": [0.1]}, "quantities": ["final crank_angle"]},
        ["vary", "quantities", "engine", "out", "progress"],
    ),
}
WRONG_FOR_ALL = [b"x", {}, [None], object(), 1j, np.array([[1.0, 2.0]])]


@pytest.mark.parametrize(("name", "argument"), [(name, argument) for name, (_, _, arguments) in CALLS.items() for argument in arguments])
def test_arguments_of_wrong_types_are_refused(name, argument):
    function, arguments, _ = CALLS[name]
    for wrong in WRONG_FOR_ALL:
        refusal(function, **{**arguments, argument: wrong})


@pytest.mark.parametrize("accuracy", ["x", float("nan"), True, 0, -1.0, 1.0])
def test_an_accuracy_that_is_none_is_refused(accuracy):
    assert "accuracy must lie between 0 and 1" in refusal(gm.run, "slider_crank", accuracy=accuracy)


def test_a_speed_curve_of_endless_points_is_refused():
    assert "2 to 1,000,000 points; got 10000000000" in refusal(gm.speed_curve, "porter", 10**10)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"path": None}, "path must be a path; found None"),
        ({"size": "large"}, 'size must be a finite number; found "large"'),
        ({"size": 10**10}, "320 to 4320 pixels"),
        ({"part": 3}, "part must be text; found 3"),
        ({"start": "x"}, 'start must be a finite number; found "x"'),
        ({"slow_down": []}, "slow_down must be a finite number; found []"),
        ({"run": [None, None]}, "a film shows a run"),
        ({"path": Path("film.avi")}, "must end in .gif or .mp4"),
    ],
)
def test_a_film_refuses_wrong_arguments(run, tmp_path, options, sentence):
    assert sentence in refusal(gm.film, **{"run": run, "path": tmp_path / "film.gif", **options})
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("returned", [None, "x", [1.0, 2.0], object(), 1j])
def test_a_kernel_that_returns_no_number_is_told_in_a_sentence(returned):
    assert "must return one real number" in refusal(gm.crosscheck, "porter", lambda arm: returned, over={"arm_angle": [0.5]})


def test_results_with_arrays_are_equal_to_themselves_only(run):
    other = gm.run("slider_crank", times=[0.0, 0.1, 0.2])
    assert run == run
    assert run != other
    assert run in [other, run]
    assert len({run, other}) == 2
    for repeated in (lambda: gm.speed_curve("porter", 5), lambda: gm.equilibria("porter"), lambda: run.energy):
        first, second = repeated(), repeated()
        assert first == first
        assert isinstance(first == second, bool)

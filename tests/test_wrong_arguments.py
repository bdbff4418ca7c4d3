"""Wrong types of arguments are refused in sentences, without Python's way of writing values, and results compare without errors."""

import tomllib
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
        lambda scene: gm.sensitivities(scene, ["final arm_angle"], ["dimensions.arm"]),
        lambda scene: gm.fit(scene, {"time": [0.0], "arm_angle": [0.0]}, {"dimensions.arm": (0.2, 0.4)}),
        gm.valve_timing,
        ReducedEngine().run,
        lambda run: gm.film(run, "film.gif"),
    ],
)
def test_what_is_no_scene_or_run_is_refused(function, wrong):
    refusal(function, wrong)


CALLS: dict[str, dict[str, Any]] = tomllib.loads(Path(__file__).with_name("wrong_arguments.toml").read_text(encoding="utf-8"))
EXPLORE = {"scene": "porter", "key": "arm"}
CALLS["explore"] = {"function": lambda scene, key: gm.explore(scene, key), "given": EXPLORE, "wrong": ["key"]}
KERNEL = {"scene": "porter", "kernel": lambda arm: 1.0, "over": {"arm_angle": [0.5]}, "quantity": "sleeve_lift"}
CALLS["crosscheck"] = {"given": KERNEL, "wrong": ["kernel", "quantity", "over", "allowed", "vary", "unit", "random", "seed"]}
WRONG_FOR_ALL = [b"x", {}, [None], object(), 1j, np.array([[1.0, 2.0]])]


@pytest.mark.parametrize(("name", "argument"), [(name, argument) for name, row in CALLS.items() for argument in row["wrong"]])
def test_arguments_of_wrong_types_are_refused(name, argument):
    row = CALLS[name]
    function = row.get("function") or getattr(gm, name)
    for wrong in WRONG_FOR_ALL:
        refusal(function, **{**row.get("given", {}), argument: wrong})


def test_a_number_out_of_range_is_refused_on_entry():
    compare = {"scene": "porter", "kernel": lambda arm: 1.0, "over": {"arm_angle": [0.5]}}
    assert "vary must be values by key" in refusal(gm.crosscheck, **compare, vary=3)
    assert "random must be a whole number" in refusal(gm.crosscheck, **compare, random=-1)
    assert "speed_change is a relative change" in refusal(gm.controlling_force, "porter", speed_change=10**400)


RESULT_METHODS = {
    "save figures": (lambda run: lambda wrong: run.save("folder", figure_formats=wrong), "the formats of figures must be a list"),
    "body": (lambda run: run.scene.mechanism.body_index, "no body"),
    "joint": (lambda run: run.scene.mechanism.joint_index, "no joint"),
    "reading": (lambda run: run.scene.mechanism.reading, "no reading"),
    "CSV": (lambda run: gm.kinematics(run.scene, "time", [0.0, 0.1]).save_csv, "path must be a path"),
    "JSON": (lambda run: gm.valve_timing("slide_valve_30").save_json, "path must be a path"),
    "state space": (lambda run: lambda wrong: gm.linearise("porter_dashpot").state_space(wrong, []), "inputs must be a list of names"),
    "errata": (lambda run: gm.errata("dubois").count, "cause must be one of"),
}


@pytest.mark.parametrize("name", RESULT_METHODS)
def test_methods_of_results_refuse_wrong_arguments(run, name):
    make, sentence = RESULT_METHODS[name]
    method = make(run)
    for wrong in (None, 3, {}, object(), 1j):
        assert sentence in refusal(method, wrong)


TAKES_TEXTS = [
    (lambda angle: gm.insensitivity_band("porter", [angle, 0.5], "40 N").falling_speed, "20 deg", "20 mm"),
    (lambda angle: gm.controlling_force("porter", [angle, 0.5]).force, "20 deg", "20 mm"),
    (lambda angle: gm.kinematics("slider_crank_torque", "crank_angle", [angle, 0.5]).poses, "20 deg", "20 mm"),
    (lambda rate: gm.kinematics("slider_crank_torque", "crank_angle", [0.5], rate=rate).velocities, "20 deg/s", "20 mm/s"),
    (lambda rate: gm.kinematics("slider_crank_torque", "crank_angle", [0.5], 1.0, rate).accelerations, "20 deg/s^2", "20 mm/s^2"),
    (lambda time: gm.kinematics("slider_crank", "time", [0.0, time]).poses, "20 ms", "20 mm"),
    (lambda time: gm.run("slider_crank", times=[0.0, time], accuracy=1e-3).times, "20 ms", "20 mm"),
]


@pytest.mark.parametrize(("function", "text", "other"), TAKES_TEXTS)
def test_a_text_with_a_unit_is_taken_where_a_quantity_is(function, text, other):
    number, unit = text.split()
    in_si = float(number) * {"deg": np.pi / 180, "ms": 1e-3}[unit.partition("/")[0]]
    np.testing.assert_allclose(function(text), function(in_si), rtol=1e-14, atol=1e-300)
    assert f'"{other}" is ' in refusal(function, other)


def test_a_film_takes_texts_for_its_times(run, tmp_path):
    gm.film(run, tmp_path / "film.gif", start="100 ms", stop="0.2 s", layout="machine", size=320)
    assert 'stop is a time; "2 mm" is a length' in refusal(lambda: gm.film(run, tmp_path / "other.gif", stop="2 mm"))


@pytest.mark.parametrize("accuracy", ["x", float("nan"), True, 0, -1.0, 1.0])
def test_an_accuracy_that_is_none_is_refused(accuracy):
    assert "accuracy must lie between 0 and 1" in refusal(gm.run, "slider_crank", accuracy=accuracy)


def test_a_speed_curve_of_endless_points_is_refused():
    assert "2 to 1,000,000 points; got 10000000000" in refusal(gm.speed_curve, "porter", 10**10)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"path": None}, "path must be a path; found None"),
        ({"size": 720.5}, 'size is the height of the film in pixels, as 720, or its width and height, as "1280x720"; got 720.5'),
        ({"size": "large"}, "size 'large' is not understood; write the height of the film in pixels, as 720, or 1280x720"),
        ({"size": "1280x720", "layout": "machine"}, "size '1280x720' is 16:9, and layout machine is not; leave one of them out"),
        ({"size": 10**10}, "320 to 4320 pixels"),
        ({"part": 3}, "part must be text; found 3"),
        ({"start": "x"}, 'start is a time; "x" has no number'),
        ({"slow_down": []}, "slow_down must be a finite number; found []"),
        ({"run": [None, None]}, "a film shows a run"),
        ({"path": Path("film.avi")}, "must end in .gif or .mp4"),
    ],
)
def test_a_film_refuses_wrong_arguments(run, tmp_path, options, sentence):
    assert sentence in refusal(gm.film, **{"run": run, "path": tmp_path / "film.gif", **options})
    assert not list(tmp_path.iterdir())


def test_the_film_of_a_saved_run_takes_a_record(run, tmp_path):
    for wrong in (3, {"size": 720}, object(), 1j):
        assert "film_options must be a record, as gm.FilmOptions(" in refusal(run.save, tmp_path / "out", film="gif", film_options=wrong)
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

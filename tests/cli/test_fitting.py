"""The commands `fit`, `sensitivities` and `optimise`: what they write, their exit status, Ctrl-C."""

import json
import os
import signal

import numpy as np
import pytest

import governor_mechanism as gm
from command_line import invoke, json_of, succeed
from governor_mechanism.studies.fitting.search import Misfit


@pytest.fixture(scope="module")
def lift(tmp_path_factory):
    """A table of the lift of the shipped governor, mm, at 121 rpm."""
    run = gm.run(gm.load("porter").replace({"spindle.speed": "121 rpm"}), times=np.linspace(0.0, 2.0, 101), accuracy=1e-8)
    lines = [f"{time!r},{1e3 * value!r}" for time, value in zip(run.times.tolist(), run.readings["sleeve_lift"].tolist(), strict=True)]
    path = tmp_path_factory.mktemp("data") / "lift.csv"
    path.write_text("time [s],sleeve_lift [mm]\n" + "\n".join(lines) + "\n")
    return path


def fit_words(lift, tmp_path, *words):
    fixed = ("--over", "spindle.speed=110rpm:130rpm", "--noise", "0.1 mm", "--starts", 1, "--no-figure", "--out", tmp_path)
    return ("fit", "porter", "--data", lift, *fixed, *words)


def test_fit_writes_a_scene_that_moves_as_measured(lift, tmp_path):
    record = json_of(*fit_words(lift, tmp_path))
    assert record["rows"][0]["value"] == pytest.approx(121.0 * np.pi / 30.0, rel=1e-6)
    assert gm.load(tmp_path / "porter_fit.toml").spindle.speeds[0] == record["rows"][0]["value"]
    assert {path.name for path in tmp_path.iterdir()} == {"porter_fit.toml", "porter_fit.csv", "porter_fit.json"}


def test_ctrl_c_keeps_the_best_values_so_far(lift, tmp_path, monkeypatch):
    residuals, calls = Misfit.residuals, []

    def interrupted(self, place):
        calls.append(place)
        if len(calls) == 4:
            os.kill(os.getpid(), signal.SIGINT)
        return residuals(self, place)

    monkeypatch.setattr(Misfit, "residuals", interrupted)
    result = invoke(*fit_words(lift, tmp_path))
    assert result.exit_code == 1
    assert "interrupted; these are the best values so far" in result.stdout
    assert gm.load(tmp_path / "porter_fit.toml").run.duration > 0.0


def test_sensitivities_are_printed_with_their_errors(tmp_path):
    words = ["--of", "frequency of arm_angle", "--by", "dimensions.ball_mass", "--by", "dimensions.sleeve_mass", "--out", tmp_path]
    assert " ± " in succeed("sensitivities", "porter", *words).stdout
    rows = json.loads((tmp_path / "porter_sensitivities.json").read_text())["rows"]
    assert sum(row["elasticity"] for row in rows) == pytest.approx(0.0, abs=1e-6)
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv", ".json", ".png"}


def optimise_words(tmp_path, *words, heaviest="6kg"):
    fixed = ("--over", f"dimensions.ball_mass=4kg:{heaviest}", "--set", "run.duration=2 s", "--no-figure", "--out", tmp_path)
    return ("optimise", "porter", *fixed, *words)


def test_optimise_writes_a_scene_with_the_best_values(tmp_path):
    words = ["--minimise", "span sleeve_lift", "--subject-to", "min sleeve_lift >= 60 mm", "--report", "duration", "--film", "gif"]
    record = json_of(*optimise_words(tmp_path, *words))
    assert gm.load(tmp_path / "porter_optimum.toml").part.dimensions["ball_mass"] == record["rows"][0]["value"]
    assert [row["role"] for row in record["quantities"]] == ["minimised", ">= 60 mm", "reported"]
    assert {path.name for path in tmp_path.iterdir()} == {f"porter_optimum.{end}" for end in ("toml", "csv", "json", "gif")}


def test_two_objectives_give_their_trade_off(tmp_path):
    objectives = ["--minimise", "frequency of sleeve_lift", "--maximise", "min sleeve_lift"]
    words = optimise_words(tmp_path, *objectives, "--points", 3, heaviest="5.5kg")  # at 5.77 kg it stands, and has no frequency
    assert "frequency of sleeve_lift against min sleeve_lift" in succeed(*words).stdout
    assert {path.name for path in tmp_path.iterdir()} == {"porter_trade_off.csv", "porter_trade_off.json"}


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (("--noise", "sleeve_lift=0.1 mm"), "give one standard deviation for all readings"),
        (("--without", "1s"), "an interval has a start and an end"),
        (("--over", "spindle.speed=1rpm:2rpm"), "spindle.speed is given twice"),
        (("--profile", "dimensions.arm"), "dimensions.arm is no unknown"),
        ((), "minimise and maximise need one quantity"),
        (("--minimise", "max sleeve_lift", "--subject-to", "max sleeve_lift"), "is no condition"),
        (("--minimise", "max sleeve_lift", "--points", 3), "--points does nothing without a second objective"),
        (("--minimise", "max sleeve_lift", "--minimise", "duration", "--report", "duration"), "--report does nothing with two objectives"),
        (("--minimise", "max sleeve_lift", "--global", "--starts", 3), "--starts does nothing with --global"),
        (("--minimise", "max sleeve_lift", "--over", "dimensions.ball_mass=4kg:6kg"), "dimensions.ball_mass is given twice"),
    ],
)
def test_mistakes_are_sentences(lift, tmp_path, words, sentence):
    is_of_fit = {"--noise", "--without", "--profile", "spindle.speed=1rpm:2rpm"} & set(words)
    result = invoke(*(fit_words(lift, tmp_path, *words) if is_of_fit else optimise_words(tmp_path, *words)))
    assert result.exit_code == 2
    assert sentence in result.stderr
    assert "Traceback" not in result.output

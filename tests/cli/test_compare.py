"""The command `compare` as a person uses it."""

from pathlib import Path

import pytest
from PIL import Image

from command_line import json_of, succeed


@pytest.mark.long
def test_one_table_one_figure_and_one_film(tmp_path: Path) -> None:
    words = ("--seconds", "1 s", "--range", "sleeve_lift=80 mm:120 mm", "--accuracy", "1e-5", "--out", str(tmp_path))
    told = json_of("compare", "porter", "porter_dashpot", "slider_crank", *words)
    assert told["title"] == "porter vs porter_dashpot vs slider_crank"
    assert [Path(name).name for name in told["files"]] == ["comparison.png", "comparison.gif"]
    # A run of 1 s is shown in true time, in few frames.
    with Image.open(tmp_path / "comparison.gif") as film:
        assert film.size == (3 * 480, 480)
    rows = {row["quantity"]: row["values"] for row in told["rows"]}
    assert rows["run: end"] == [1.0, 1.0, 1.0]
    assert rows["working range of"] == ["given values", "given values", None]
    assert told["runs"]["porter"]["settings"]["asked_accuracy"] == 1e-5


def test_a_change_holds_for_all_scenes(tmp_path: Path) -> None:
    words = ("--set", "spindle.speed=124 rpm", "--set", "run.duration=0.05 s", "--no-film", "--no-figure", "--out", str(tmp_path))
    result = succeed("compare", "porter", "porter_dashpot", "--engine", "multibody", *words)
    lines = {line[:22].strip(): line[22:].split() for line in result.stdout.splitlines()}
    assert lines["speed of the spindle"][-4:] == ["124", "rpm", "124", "rpm"]
    assert lines["run: engine"] == ["multibody", "multibody"]
    assert not list(tmp_path.iterdir())


def test_a_change_of_one_scene_shows_before_and_after(tmp_path: Path) -> None:
    words = ("--set", "2:dimensions.arm=320 mm", "--seconds", "0.05 s", "--no-film", "--no-figure", "--accuracy", "1e-4")
    result = succeed("compare", "porter", "porter", *words, "--out", str(tmp_path))
    assert "porter (2): dimensions.arm=320 mm" in result.stdout.splitlines()
    told = json_of("compare", "porter", "porter", *words, "--out", str(tmp_path))
    before, after = next(row["values"] for row in told["rows"] if "lowest" in row["quantity"])
    assert before != after

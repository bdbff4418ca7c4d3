"""The commands `synthesise`: files they read and write, their exit status."""

import pytest

import governor_mechanism as gm
from command_line import invoke, json_of, succeed

TABLES = {
    "reciprocal.toml": """function = "1/x"
over = [1, 2]
input_angles = ["30 deg", "120 deg"]
output_angles = ["240 deg", "330 deg"]
count = 4
""",
    "three.csv": "x [mm],y [mm],angle [deg]\n0,0,0\n40,25,15\n70,60,40\n",
    "gate.csv": "x [mm],y [mm],angle [deg]\n0,0,0\n40,25,15\n70,60,40\n80,110,70\n",
    "handle.csv": "x [mm],y [mm]\n0,0\n40,25\n70,60\n80,110\n",
    "timed.csv": "x [mm],y [mm],input_angle [deg]\n0,0,0\n9,3,1\n1,8,2\n7,-5,80\n-6,2,81\n",
    "line.csv": "x [mm],y [mm]\n" + "".join(f"{x},4000\n" for x in range(0, 4001, 500)),
}


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """The tables are in the present folder, and what the commands write is in `out`."""
    monkeypatch.chdir(tmp_path)
    for name, text in TABLES.items():
        (tmp_path / name).write_text(text)
    return tmp_path / "out"


def words(*more):
    return ("synthesise", *more, "--out", "out")


def test_function_writes_a_scene_that_loads(folder):
    assert [row["defects"] for row in json_of(*words("function", "reciprocal.toml"))["rows"]] == ["none", "branch (2, 3)"]
    assert gm.load(folder / "reciprocal_1.toml").run.duration > 0.0
    assert {path.suffix for path in folder.glob("reciprocal.*")} == {".csv", ".json", ".png"}


def test_positions_in_a_table_are_passed(folder):
    """Every linkage without a defect passes all places; its scene is written."""
    good = [row for row in json_of(*words("positions", "gate.csv"))["rows"] if row["defects"] == "none"]
    assert good
    assert max(row["distance"] for row in good) < 1e-9
    assert gm.load(folder / "gate_1.toml").run.duration > 0.0
    assert (folder / "gate.png").stat().st_size > 5000


def test_path_has_cognates_and_a_scene(folder):
    row = json_of(*words("path", "handle.csv", "--starts", 100, "--seed", 1))["rows"][0]
    assert (row["defects"], len(row["cognates"])) == ("none", 2)
    assert gm.load(folder / "handle_1.toml").run.duration > 0.0
    assert (folder / "handle.png").stat().st_size > 5000


def test_a_search_without_an_answer_ends_with_status_1():
    result = invoke(*words("path", "timed.csv", "--starts", 3))
    assert result.exit_code == 1
    assert "From 3 random starts (seed 0), different, cognates apart: 0" in result.stdout


def test_a_map_of_three_positions_is_drawn(folder):
    assert "input turns fully" in succeed(*words("positions", "three.csv", "--map")).stdout
    assert (folder / "three_map.png").stat().st_size > 5000


LINE = ("dimensions", "chebyshev_lambda", "--point", "rod.end", "--path", "line.csv", "--over", "dimensions.rocker=2m:3m", "--starts", 1)


def test_dimensions_of_a_mechanism_draw_a_line(folder):
    row = json_of(*words(*LINE, "--set", "dimensions.rocker=2.3 m"))["rows"][0]
    assert abs(row["dimensions.rocker"] - 2.5) < 0.02
    assert gm.load(folder / "chebyshev_lambda_dimensions_1.toml").run.duration > 0.0


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (("function", "reciprocal.toml", "--take", 3, "--no-figure"), "must be the number of a linkage, 1 to 2; found 3"),
        (("positions", "three.csv", "--map", "--take", 2), "--take"),
        ((*LINE, "--between", "90deg"), "between must be two values"),
    ],
)
def test_what_is_not_there_is_refused_in_a_sentence(given, sentence):
    result = invoke(*words(*given))
    assert result.exit_code == 2
    assert sentence in result.stderr

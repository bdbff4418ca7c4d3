"""The commands `synthesise`: files they read and write, their exit status."""

import json

from typer.testing import CliRunner

import governor_mechanism as gm
from governor_mechanism.cli.main import app

RECIPROCAL = """function = "1/x"
over = [1, 2]
input_angles = ["30 deg", "120 deg"]
output_angles = ["240 deg", "330 deg"]
count = 4
"""


def invoke(tmp_path, *arguments):
    return CliRunner().invoke(app, ["synthesise", *map(str, arguments), "--out", str(tmp_path)])


def test_function_writes_a_scene_that_loads(tmp_path):
    file = tmp_path / "reciprocal.toml"
    file.write_text(RECIPROCAL)
    result = invoke(tmp_path, "function", file, "--json")
    assert result.exit_code == 0, result.output
    record = json.loads(result.stdout)
    assert [row["defects"] for row in record["rows"]] == ["none", "branch (2, 3)"]
    scene = gm.load(tmp_path / "reciprocal_1.toml")
    assert scene.run.duration > 0.0
    assert {path.suffix for path in tmp_path.glob("reciprocal.*")} == {".toml", ".csv", ".json", ".png"}


def test_a_linkage_that_there_is_not_gets_a_sentence(tmp_path):
    file = tmp_path / "reciprocal.toml"
    file.write_text(RECIPROCAL)
    result = invoke(tmp_path, "function", file, "--take", 3, "--no-figure")
    assert result.exit_code == 2
    assert "must be the number of a linkage, 1 to 2; found 3" in result.stderr


def test_positions_in_a_table_are_passed(tmp_path):
    """Every linkage without a defect passes all places; its scene is written."""
    file = tmp_path / "gate.csv"
    file.write_text("x [mm],y [mm],angle [deg]\n0,0,0\n40,25,15\n70,60,40\n80,110,70\n")
    result = invoke(tmp_path, "positions", file, "--json")
    assert result.exit_code == 0, result.output
    good = [row for row in json.loads(result.stdout)["rows"] if row["defects"] == "none"]
    assert good
    assert max(row["distance"] for row in good) < 1e-9
    assert gm.load(tmp_path / "gate_1.toml").run.duration > 0.0
    assert (tmp_path / "gate.png").stat().st_size > 5000


def test_path_has_cognates_and_a_scene(tmp_path):
    file = tmp_path / "handle.csv"
    file.write_text("x [mm],y [mm]\n0,0\n40,25\n70,60\n80,110\n")
    result = invoke(tmp_path, "path", file, "--starts", 100, "--seed", 1, "--json")
    assert result.exit_code == 0, result.output
    row = json.loads(result.stdout)["rows"][0]
    assert row["defects"] == "none"
    assert len(row["cognates"]) == 2
    assert gm.load(tmp_path / "handle_1.toml").run.duration > 0.0
    assert (tmp_path / "handle.png").stat().st_size > 5000


def test_a_search_without_an_answer_ends_with_status_1(tmp_path):
    file = tmp_path / "timed.csv"
    file.write_text("x [mm],y [mm],input_angle [deg]\n0,0,0\n9,3,1\n1,8,2\n7,-5,80\n-6,2,81\n")
    result = invoke(tmp_path, "path", file, "--starts", 3)
    assert result.exit_code == 1
    assert "From 3 random starts (seed 0), different, cognates apart: 0" in result.stdout


def test_a_map_of_three_positions_is_drawn(tmp_path):
    file = tmp_path / "gate.csv"
    file.write_text("x [mm],y [mm],angle [deg]\n0,0,0\n40,25,15\n70,60,40\n")
    result = invoke(tmp_path, "positions", file, "--map")
    assert result.exit_code == 0, result.output
    assert "input turns fully" in result.stdout
    assert (tmp_path / "gate_map.png").stat().st_size > 5000
    assert invoke(tmp_path, "positions", file, "--map", "--take", 2).exit_code == 2


def test_dimensions_of_a_mechanism_draw_a_line(tmp_path):
    file = tmp_path / "line.csv"
    file.write_text("x [mm],y [mm]\n" + "".join(f"{x},4000\n" for x in range(0, 4001, 500)))
    words = ["dimensions", "chebyshev_lambda", "--point", "rod.end", "--path", file, "--over", "dimensions.rocker=2m:3m", "--starts", 1]
    result = invoke(tmp_path, *words, "--set", "dimensions.rocker=2.3 m", "--json")
    assert result.exit_code == 0, result.output
    assert abs(json.loads(result.stdout)["rows"][0]["dimensions.rocker"] - 2.5) < 0.02
    assert gm.load(tmp_path / "chebyshev_lambda_dimensions_1.toml").run.duration > 0.0
    refused = invoke(tmp_path, *words, "--between", "90deg")
    assert refused.exit_code == 2
    assert "between must be two values" in refused.stderr

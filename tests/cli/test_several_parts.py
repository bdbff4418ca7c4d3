"""Commands on a scene of several parts: an engine and its governor."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.io import netcdf_file
from typer.testing import CliRunner

import governor_mechanism as gm
from governor_mechanism.cli.main import app

READINGS = [
    "engine.crank_angle",
    "governor.arm_angle",
    "governor.ball_radius",
    "governor.sleeve_lift",
    "governor.spindle_speed",
    "governor.spindle_angle",
]


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """The shipped Watt governor on an engine, a second and a half long."""
    shipped = Path(__file__).parents[2] / "models" / "watt_engine_stable.toml"
    text = shipped.read_text(encoding="utf-8").replace('duration = "20 s"', 'duration = "1.5 s"').replace("1e-8", "1e-5")
    path = tmp_path_factory.mktemp("scene") / "engine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def call(*words):
    return CliRunner().invoke(app, list(words))


def test_run_writes_readings_of_all_parts(scene, tmp_path):
    result = call("run", scene, "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert "at 1.5 s: engine.crank_angle " in result.stdout
    with (tmp_path / "engine.csv").open(encoding="utf-8") as stream:
        header = next(csv.reader(stream))
    assert [column.split(" [")[0] for column in header] == ["time", *READINGS]
    record = json.loads((tmp_path / "engine.json").read_text(encoding="utf-8"))
    assert list(record["final"]) == READINGS
    with netcdf_file(tmp_path / "engine.nc", mmap=False) as dataset:
        assert set(READINGS) < set(dataset.variables)
        assert dataset.variables["pose"].shape[1] == len(dataset.bodies.split(b", "))
        speed, rate = (dataset.variables[name][:] for name in ("governor.spindle_speed", "engine.crank_angle_rate"))
    np.testing.assert_allclose(speed, 2.0 * rate, rtol=1e-12)  # the ratio of the belt, to rounding
    with Image.open(tmp_path / "engine.gif") as film:
        assert film.size == (766, 480)  # a panel of 286 pixels for the engine beside the frame of the governor
    with Image.open(tmp_path / "engine.png") as figure:
        assert figure.size[0] > 0


def test_run_as_json_has_the_final_readings_of_all_parts(scene, tmp_path):
    result = call("run", scene, "--no-film", "--json", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    assert list(json.loads(result.stdout)["final"]) == READINGS
    assert not (tmp_path / "engine.gif").exists()


@pytest.mark.parametrize(
    "words",
    [
        ("crosscheck",),
        ("equilibria",),
        ("equilibria", "--resistance", "40 N"),
        *(("regulation", study) for study in ("cyclic", "clearance", "settling", "jump")),
        ("run", "--engine", "impulse"),
    ],
)
def test_commands_for_one_part_say_what_to_do(scene, tmp_path, words):
    command, *options = words
    arguments = [command, *options, scene] if command == "regulation" else [command, scene, *options]
    result = call(*arguments, *(() if command == "crosscheck" else ("--out", str(tmp_path))))
    assert result.exit_code == 2
    assert "'engine'" in result.stderr
    assert "'governor'" in result.stderr
    assert any(cure in result.stderr for cure in ("scene file of its own", "choose engine multibody", "--linearise"))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "call_function",
    [
        gm.crosscheck,
        gm.equilibria,
        gm.speed_curve,
        gm.valve_timing,
        lambda scene: gm.insensitivity_band(scene, [0.5], "40 N"),
        lambda scene: gm.crosscheck(scene, kernel=lambda arm: arm),
        lambda scene: gm.kinematics(scene, "engine.crank_angle", [0.1]),
    ],
)
def test_functions_for_one_part_refuse_several(scene, call_function):
    with pytest.raises(gm.MechanismError, match=r"parts|degrees of freedom"):
        call_function(gm.load(scene))


def test_a_sweep_varies_couplings_and_dimensions_of_parts(scene, tmp_path):
    keys = {"coupling.belt.ratio": "2,2.01", "part.governor.dimensions.arm": "299mm,300mm"}
    vary = [word for key, values in keys.items() for word in ("--vary", f"{key}={values}")]
    quantities = ["--quantity", "final governor.spindle_speed", "--quantity", "final rate of engine.crank_angle"]
    result = call("sweep", scene, *vary, *quantities, "--json", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    with (tmp_path / "engine_sweep.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 4
    for row in rows:
        numbers = {key.split(" [")[0]: value for key, value in row.items()}
        ratio = float(numbers["final governor.spindle_speed"]) / float(numbers["final rate of engine.crank_angle"])
        assert ratio == pytest.approx(float(numbers["coupling.belt.ratio"]), rel=1e-12)


def test_a_sweep_names_the_nearest_reading_of_a_part(scene, tmp_path):
    result = call("sweep", scene, "--vary", "coupling.belt.ratio=2,2.1", "--quantity", "sleeve_lift", "--out", str(tmp_path))
    assert result.exit_code == 2
    assert "Did you mean 'governor.sleeve_lift'?" in result.stderr


def test_effects_are_switched_part_by_part(scene, tmp_path):
    result = call("effects", scene, "--json", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    rows = {row["effect"]: row for row in answer["effects"]}
    assert list(rows) == ["engine.gravity", "governor.gravity", "governor.centrifugal", "governor.dashpot"]
    assert rows["engine.gravity"]["relative_change"] == 0.0  # the flywheel turns about its mass centre
    assert rows["governor.dashpot"]["relative_change"] > 1e-3
    assert "governor.rods" in answer["untried"]
    assert "engine.rods" not in answer["untried"]
    assert "engine.centrifugal" not in answer["untried"]


def test_accuracy_measures_the_engine_that_can_run_it(scene, tmp_path):
    result = call("accuracy", scene, "--longest", "0.05", "--json", "--out", str(tmp_path))
    assert result.exit_code == 0, result.output
    variants = {row["name"]: row for row in json.loads(result.stdout)["variants"]}
    assert len(variants["multibody"]["points"]) > 2
    assert len(variants["reduced"]["points"]) > 2

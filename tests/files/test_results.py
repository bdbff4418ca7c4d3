"""What is written opens again and says the same."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest
from scipy.io import netcdf_file

from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.files import results as saving
from governor_scenes import EXTENDED, governor_scene


@pytest.fixture(scope="module")
def run():
    return ImpulseEngine().run(governor_scene(EXTENDED, speed=8.4, angle=0.6, duration=0.5))


def test_the_csv_holds_every_reading_to_the_last_digit(run, tmp_path):
    saving.save_csv(run, tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    assert header[:3] == ["time [s]", "arm_angle [rad]", "ball_radius [m]"]
    numbers = np.array(rows, dtype=float)
    np.testing.assert_array_equal(numbers[:, 0], run.times)
    np.testing.assert_array_equal(numbers[:, 1], run.readings["arm_angle"])


def test_the_netcdf_holds_every_array(run, tmp_path):
    saving.save_netcdf(run, tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as dataset:
        np.testing.assert_array_equal(dataset.variables["pose"][:], run.poses)
        np.testing.assert_array_equal(dataset.variables["velocity"][:], run.velocities)
        np.testing.assert_array_equal(dataset.variables["sleeve_lift"][:], run.readings["sleeve_lift"])
        np.testing.assert_array_equal(dataset.variables["energy_jacobi"][:], run.energy.jacobi)
        assert dataset.variables["spindle_torque"].units == b"N m"
        assert dataset.bodies == b"right ball, left ball, sleeve"


def test_the_record_says_what_ran_how_it_ended_and_with_which_versions(run, tmp_path):
    saving.save_summary(run, tmp_path / "run.json")
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert record["outcome"] == "done"
    assert record["error_estimate"] == run.error_estimate
    assert record["cost"]["steps"] == run.cost.steps
    assert set(record["versions"]) == {"python", *saving.REPORTED_PACKAGES}


@pytest.mark.parametrize("save", [saving.save_csv, saving.save_netcdf, saving.save_summary])
def test_a_failure_while_writing_leaves_the_old_file(save, run, tmp_path, monkeypatch):
    path = tmp_path / "run"
    path.write_text("old", encoding="utf-8")

    def full(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(KeyboardInterrupt):
        save(run, path)
    assert [item.name for item in tmp_path.iterdir()] == ["run"]
    assert path.read_text(encoding="utf-8") == "old"

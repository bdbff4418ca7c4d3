"""What is written opens again and says the same."""

import csv
import json
import resource

import numpy as np
import pytest
from scipy.io import netcdf_file

import governor_mechanism as gm
from governor_mechanism.engines import ImpulseEngine
from governor_mechanism.errors import MechanismError
from governor_mechanism.files import results as saving
from governor_mechanism.files.writing import save_json, write_all_or_none
from governor_scenes import EXTENDED, governor_scene
from refusing import refuses
from saved_runs import UNUSUAL_NAMES

SAVERS = [gm.Trajectory.save_csv, saving.save_netcdf, gm.Trajectory.save_json]
"""Functions that write a file of a run."""


@pytest.fixture(scope="module")
def run():
    return ImpulseEngine().run(governor_scene(EXTENDED, speed=8.4, angle=0.6, duration=0.5))


def test_the_csv_holds_every_reading_to_the_last_digit(run, tmp_path):
    run.save_csv(tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(encoding="utf-8") as stream:
        comment = next(stream)
        header, *rows = csv.reader(stream)
    assert comment.startswith("# units: time s; arm_angle rad; ball_radius m; ")
    assert header[:3] == ["time", "arm_angle", "ball_radius"]
    numbers = np.array(rows, dtype=float)
    np.testing.assert_array_equal(numbers[:, 0], run.times)
    np.testing.assert_array_equal(numbers[:, 1], run.readings["arm_angle"])


def texts_of(dataset, name):
    return [b"".join(row).rstrip(b"\0").decode() for row in dataset.variables[name][:]]


def assert_motion_is_there(dataset, run):
    for vector, angle, expected in (("position", "angle", run.poses), ("velocity", "angular_velocity", run.velocities)):
        np.testing.assert_array_equal(dataset.variables[vector][:], expected[:, :, :2])
        np.testing.assert_array_equal(dataset.variables[angle][:], expected[:, :, 2])


def test_the_netcdf_holds_every_array(run, tmp_path):
    saving.save_netcdf(run, tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as dataset:
        assert_motion_is_there(dataset, run)
        np.testing.assert_array_equal(dataset.variables["reading_sleeve_lift"][:], run.readings["sleeve_lift"])
        np.testing.assert_array_equal(dataset.variables["energy_jacobi"][:], run.energy.jacobi)
        assert dataset.variables["reading_spindle_torque"].units == b"N m"
        assert texts_of(dataset, "body") == ["right ball", "left ball", "sleeve"]


def test_the_record_says_what_ran_how_it_ended_and_with_which_versions(run, tmp_path):
    run.save_json(tmp_path / "run.json")
    record = json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))
    assert record["outcome"] == "done"
    assert record["error_estimate"] == run.error_estimate
    assert record["cost"]["steps"] == run.cost.steps
    assert set(record["versions"]) == {"python", *saving.REPORTED_PACKAGES}


@pytest.mark.parametrize("save", SAVERS)
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


def test_no_reading_of_a_netcdf_replaces_other_data_and_texts_are_utf8(tmp_path):
    unusual = gm.run(UNUSUAL_NAMES)
    saving.save_netcdf(unusual, tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as dataset:
        assert all(name.isascii() and name.isidentifier() for name in dataset.variables)
        assert (dataset.title.decode(), texts_of(dataset, "body")) == ("Pendel nach Föppl ✓", ["Stange é"])
        assert texts_of(dataset, "joint") == ["Gelenk ü"]
        np.testing.assert_array_equal(dataset.variables["time"][:], unusual.times)
        assert_motion_is_there(dataset, unusual)
        np.testing.assert_array_equal(dataset.variables["joint_gap"][:], unusual.joint_gap)
        np.testing.assert_array_equal(dataset.variables["energy_kinetic"][:], unusual.energy.kinetic)
        assert dataset.variables["reaction_force"].shape == (len(unusual.times), 1, 2)
        for prefix, arrays, start in (("reading_", unusual.readings, ""), ("rate_", unusual.rates, "rate of ")):
            found = {variable.long_name.decode(): variable[:] for name, variable in dataset.variables.items() if name.startswith(prefix)}
            assert set(found) == {f"{start}{name}" for name in arrays}
            for name, values in arrays.items():
                np.testing.assert_array_equal(found[f"{start}{name}"], values)


def test_files_written_together_are_all_there_or_none(tmp_path):
    (tmp_path / "first").write_text("old", encoding="utf-8")
    with pytest.raises(MechanismError, match="missing does not exist"), write_all_or_none():
        [save_json([1], tmp_path / name) for name in ("first", "second", "missing/third")]
    assert {path.name: path.read_text(encoding="utf-8") for path in tmp_path.iterdir()} == {"first": "old"}
    with write_all_or_none():
        save_json([1], tmp_path / "first")
        save_json([2], tmp_path / "second")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["first", "second"]


@pytest.mark.parametrize("save", SAVERS)
def test_a_full_disk_is_told_with_the_name_of_the_file(save, run, tmp_path):
    """A limit on the size of files acts as a full disk does."""
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        refuses(r"cannot write .*full\.disk: File too large", save, run, tmp_path / "full.disk")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert not list(tmp_path.iterdir())


def test_a_folder_in_place_of_a_file_is_told(tmp_path):
    (tmp_path / "taken").mkdir()
    refuses("taken: a folder has this name", save_json, [], tmp_path / "taken")

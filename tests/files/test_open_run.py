"""A saved run opens again as the same run, bit by bit; a damaged one is refused."""

import dataclasses
import json
import math

import numpy as np
import pytest
from scipy.io import netcdf_file

import governor_mechanism as gm
from governor_mechanism.errors import MechanismError
from governor_mechanism.files import netcdf
from governor_mechanism.files.writing import plain_value
from governor_mechanism.model.results.records import Outcome
from refusing import refuses
from saved_runs import SCENES, UNUSUAL_NAMES, saved_run

ARRAYS = ("times", "poses", "velocities", "joint_gap")
PLAIN = ("units", "scales", "outcome", "cost", "detail", "error_estimate", "reading_errors", "n_excluded", "mobility", "notes", "events")


@pytest.fixture
def short():
    return saved_run("slide_valve_30")


def assert_equal_arrays(found, expected):
    """With the same bits, also in what is not a number."""
    assert found.dtype == expected.dtype
    assert found.tobytes() == np.ascontiguousarray(expected).tobytes()


@pytest.mark.parametrize("scene", SCENES)
def test_a_saved_run_opens_as_the_same_run(scene, tmp_path):
    run = saved_run(scene)
    run.save(tmp_path, figures=False)
    opened = gm.open_run(tmp_path)
    for name in ARRAYS:
        assert_equal_arrays(getattr(opened, name), getattr(run, name))
    for name in PLAIN:
        assert getattr(opened, name) == getattr(run, name), name
    for values, expected in ((opened.readings, run.readings), (opened.rates, run.rates)):
        assert list(values) == list(expected)
        for name in expected:
            assert_equal_arrays(values[name], expected[name])
    for field in dataclasses.fields(run.energy):
        np.testing.assert_array_equal(getattr(opened.energy, field.name), getattr(run.energy, field.name))
    assert list(opened.reactions) == list(run.reactions)
    for name, reaction in run.reactions.items():
        for field in dataclasses.fields(reaction):
            np.testing.assert_array_equal(getattr(opened.reactions[name], field.name), getattr(reaction, field.name))
    assert opened.speed_fluctuations == run.speed_fluctuations
    assert opened.recurrences == run.recurrences
    assert opened.settings == json.loads(json.dumps(plain_value(run.settings)))
    assert (opened.scene.title, opened.scene.document, opened.scene.run) == (run.scene.title, run.scene.document, run.scene.run)
    assert (opened.scene.parts, opened.scene.couplings) == (run.scene.parts, run.scene.couplings)


def test_an_opened_run_goes_on_as_the_first_did(short, tmp_path):
    short.save(tmp_path / "first", figures=False)
    opened = gm.open_run(tmp_path / "first" / "slide_valve_30.csv")  # a neighbour of the .nc file stands for the run
    opened.save(tmp_path / "second", figures=False)
    first, second = ((tmp_path / name / "slide_valve_30.csv").read_bytes() for name in ("first", "second"))
    assert first == second
    curves = [run.plot("valve_displacement").axes[0].lines[0].get_xydata() for run in (opened, short)]
    np.testing.assert_array_equal(*curves)


def test_infinite_numbers_and_an_early_end_are_kept(short, tmp_path):
    readings = {**short.readings, "crank_angle": np.full_like(short.times, np.inf)}
    changes = {"readings": readings, "error_estimate": math.inf, "reading_errors": {"crank_angle": math.inf}}
    run = dataclasses.replace(short, outcome=Outcome.LEFT_RANGE, detail="a link opens", **changes)
    run.save(tmp_path, name="open", figures=False)
    opened = gm.open_run(tmp_path / "open.nc")
    assert (opened.error_estimate, opened.reading_errors, opened.message) == (math.inf, {"crank_angle": math.inf}, run.message)
    np.testing.assert_array_equal(opened.readings["crank_angle"], np.inf)
    assert json.loads((tmp_path / "open.json").read_text(encoding="utf-8"))["final"]["crank_angle"] is None


def test_a_scene_that_no_file_describes_is_refused(short, tmp_path):
    """Else the run would open with the mechanism of the file, which is not the one that ran."""
    changed = dataclasses.replace(short.scene.part, plane="turning")
    dataclasses.replace(short, scene=dataclasses.replace(short.scene, parts=(changed,))).save(tmp_path, figures=False)
    refuses(r"has no scene: .*changed in Python", gm.open_run, tmp_path)


@pytest.mark.parametrize("place", [0.1, 0.5, 0.999])
def test_one_wrong_byte_is_found(place, short, tmp_path):
    short.save(tmp_path, figures=False)
    path = tmp_path / "slide_valve_30.nc"
    content = bytearray(path.read_bytes())
    content[int(place * len(content))] ^= 1
    path.write_bytes(content)
    refuses("is damaged", gm.open_run, tmp_path)


def test_files_that_are_no_saved_runs_are_refused(short, tmp_path, monkeypatch):
    def refusal(path):
        with pytest.raises(MechanismError) as refused:
            gm.open_run(path)
        return str(refused.value)

    assert "holds no run" in refusal(tmp_path)
    assert "there is no file or folder" in refusal(tmp_path / "absent.nc")
    (tmp_path / "note.txt").write_text("no run", encoding="utf-8")
    assert "note.txt is no run" in refusal(tmp_path / "note.txt")
    with netcdf_file(tmp_path / "foreign.nc", "w") as foreign:
        foreign.title = b"rainfall"
    assert "foreign.nc is no netCDF file of a run" in refusal(tmp_path)
    short.save(tmp_path, name="own", figures=False)
    assert "several runs, foreign.nc, own.nc" in refusal(tmp_path)
    own = tmp_path / "own.nc"
    own.write_bytes(own.read_bytes()[:-100])
    assert "is damaged" in refusal(own)
    monkeypatch.setattr(netcdf, "FORMAT_VERSION", netcdf.FORMAT_VERSION + 1)
    short.save(tmp_path / "later", figures=False)
    monkeypatch.undo()
    assert f"has version {netcdf.FORMAT_VERSION + 1} of the format" in refusal(tmp_path / "later")


def test_a_run_is_saved_completely_or_refused(short, tmp_path):
    written = saved_run(UNUSUAL_NAMES).save(tmp_path / "new" / "folder")
    assert sorted(path.name for path in written) == [f"unusual_names.{kind}" for kind in ("csv", "json", "nc", "png")]
    assert all(path.stat().st_size for path in written)
    for options, message in (
        ({"film": "avi"}, '"gif", "svg", "mp4"'),
        ({"name": "a/b"}, "must be no path"),
        ({"figures": 1}, "true or false"),
    ):
        refuses(message, short.save, tmp_path / "none", **options)
    refuses("no reported time", dataclasses.replace(short, times=short.times[:0]).save, tmp_path / "none")
    (tmp_path / "taken").write_text("", encoding="utf-8")
    refuses("cannot make the folder", short.save, tmp_path / "taken")
    assert not (tmp_path / "none").exists()

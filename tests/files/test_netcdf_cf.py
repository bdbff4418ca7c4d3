"""The netCDF file of a run by the CF conventions, as xarray and other readers see it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

import governor_mechanism as gm
from governor_mechanism.files.results import save_netcdf
from saved_runs import SCENES, saved_run

FLAGS = {"reading_determined", "reaction_determined"}


@pytest.fixture(params=SCENES)
def run(request):
    return saved_run(request.param)


def test_every_variable_has_a_long_name_a_unit_and_its_coordinates(run, tmp_path):
    """Units are those of udunits, which SI symbols joined by spaces and slashes are; pint reads them independently."""
    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()
    save_netcdf(run, tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as dataset:
        assert dataset.Conventions == b"CF-1.8"
        assert {"title", "source", "history"} <= set(dataset._attributes)
        for name, variable in dataset.variables.items():
            assert re.fullmatch("[a-zA-Z][a-zA-Z0-9_]*", name), name
            assert variable.long_name
            if variable.typecode() == "d":
                assert units.parse_units(variable.units.decode()) is not None
            else:
                assert name in FLAGS or variable._Encoding == b"utf-8"
            for dimension in variable.dimensions:
                assert dimension in dataset.variables or dimension == "event" or dimension.endswith("_letters")
            for other in getattr(variable, "ancillary_variables", b"").decode().split():
                assert set(dataset.variables[other].dimensions) <= set(variable.dimensions)
        for name, rate in ((name, f"rate_{name[8:]}") for name in dataset.variables if name.startswith("reading_")):
            if rate in dataset.variables:
                found, expected = dataset.variables[rate].units.decode(), dataset.variables[name].units.decode()
                assert units.parse_units(found) == units.parse_units(expected) / units.second
        assert json.loads(dataset.scene.decode()) == run.scene.document


def test_scipy_writes_the_same_file(run, tmp_path):
    """Byte by byte, from what it read of ours."""
    save_netcdf(run, tmp_path / "run.nc")
    with netcdf_file(tmp_path / "run.nc", mmap=False) as ours, netcdf_file(tmp_path / "again.nc", "w", version=2) as written:
        for name, value in ours._attributes.items():
            setattr(written, name, value)
        for name, size in ours.dimensions.items():
            written.createDimension(name, size)
        for name, variable in ours.variables.items():
            copy = written.createVariable(name, variable.data.dtype, variable.dimensions)
            copy[...] = variable.data
            for key, value in variable._attributes.items():
                setattr(copy, key, value)
    assert (tmp_path / "again.nc").read_bytes() == (tmp_path / "run.nc").read_bytes()


def test_xarray_opens_the_file_as_the_run_itself(run, tmp_path):
    xarray = pytest.importorskip("xarray")
    save_netcdf(run, tmp_path / "run.nc")
    direct = run.to_xarray()
    with xarray.open_dataset(tmp_path / "run.nc") as opened:
        loaded = opened.load()
    loaded.attrs = {name: loaded.attrs[name] for name in direct.attrs}  # the file has its history and record, too
    xarray.testing.assert_identical(loaded, direct)
    for k, body in enumerate(run.body_names):
        np.testing.assert_array_equal(direct["position"].sel(body=body, component="y"), run.poses[:, k, 1])
        np.testing.assert_array_equal(direct["angular_velocity"].sel(body=body), run.velocities[:, k, 2])
    for name, reaction in run.reactions.items():
        np.testing.assert_array_equal(direct["reaction_force"].sel(joint=name), reaction.force)
    for variable in direct.data_vars.values():
        if "ancillary_variables" in variable.attrs and variable.attrs["long_name"] in run.reading_errors:
            assert float(direct[variable.attrs["ancillary_variables"]]) == run.reading_errors[variable.attrs["long_name"]]
    assert list(direct["event_time"]) == [event.time for event in run.events] if run.events else "event_time" not in direct


def test_pandas_reads_the_table_without_renaming(run, tmp_path):
    pandas = pytest.importorskip("pandas")
    run.save_csv(tmp_path / "run.csv")
    table = pandas.read_csv(tmp_path / "run.csv", comment="#", index_col="time")
    # Some versions of pandas read the last of 17 digits wrong, for speed.
    pandas.testing.assert_frame_equal(table, run.to_dataframe(), check_exact=False, rtol=1e-15, atol=0.0)
    assert (tmp_path / "run.csv").read_text(encoding="utf-8").startswith("# units: time s; ")
    with_rates = run.to_dataframe(rates=True)
    assert with_rates.attrs["units"].keys() == {"time", *with_rates.columns}
    for name, values in run.rates.items():
        np.testing.assert_array_equal(with_rates[f"rate of {name}"], values)


def test_records_name_no_folder_of_this_machine(run, tmp_path):
    folder = str(Path(run.scene.source).resolve().parent).encode()
    for save, name in ((gm.Trajectory.save_csv, "run.csv"), (save_netcdf, "run.nc"), (gm.Trajectory.save_json, "run.json")):
        save(run, tmp_path / name)
        assert folder not in (tmp_path / name).read_bytes()
    assert json.loads((tmp_path / "run.json").read_text(encoding="utf-8"))["scene"] == Path(run.scene.source).name


@pytest.mark.parametrize("package", ["pandas", "xarray"])
def test_a_missing_package_is_named_with_its_cure(package, run, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    with pytest.raises(ValueError, match=rf"pip install 'governor-mechanism\[{package}\]'"):
        run.to_dataframe() if package == "pandas" else run.to_xarray()

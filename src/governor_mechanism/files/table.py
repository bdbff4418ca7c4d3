"""Results as tables of pandas, and runs as data sets of xarray. Both packages are optional."""

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any, Final

from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.netcdf import run_attributes, run_variables
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.types import DataFrame, Dataset, FloatArray

TIME_COLUMN: Final = "time"
"""Name of the column of the reported times."""


def make_data_frame(
    columns: Mapping[str, NDArray[Any] | Sequence[Any]],  # columns by name; shape (n,) each
    *,
    index: str | None = None,  # name of the column that labels the rows; numbers from 0 if None
    # units of columns by name, which `attrs["units"]` of the table holds
    units: Mapping[str, str] | None = None,
) -> DataFrame:
    """Return columns as a table of pandas.

    Raises MechanismError if pandas is not installed.
    """
    pandas = _require("pandas", "a table")
    table = pandas.DataFrame(dict(columns))
    table = table if index is None else table.set_index(index)
    table.attrs["units"] = dict(units or {})
    return table


def reading_columns(run: Trajectory) -> tuple[dict[str, FloatArray], dict[str, str]]:
    """Return times and readings as columns of a table, and their units, by name; a reading "time" is named "reading time".

    Result: columns of shape (n,), SI, and units; the times are the first column, "time".
    """
    names = {name: f"reading {name}" if name == TIME_COLUMN else name for name in run.readings}
    columns = {TIME_COLUMN: run.times, **{column: run.readings[name] for name, column in names.items()}}
    return columns, {TIME_COLUMN: "s", **{column: run.units[name] for name, column in names.items()}}


def tabulate_run(
    run: Trajectory,
    *,
    rates: bool = False,  # whether the table has the rates, too, as columns "rate of ..."
    paths: Sequence[str] = (),  # names of points whose coordinates are columns, too
) -> DataFrame:
    """Return the readings of a run as a table of pandas, with the times as index.

    Result: the table, SI; its `attrs` have the title, the units, the outcome and the error estimate. Raises
    MechanismError if pandas is not installed.
    """
    columns, units = reading_columns(run)
    if rates:
        columns |= {f"rate of {name}": values for name, values in run.rates.items()}
        units |= {f"rate of {name}": f"{run.units[name]}/s" for name in run.rates}
    for name in paths:
        columns |= {f"{name}.{component}": run.paths[name][:, k] for k, component in enumerate("xy")}
        units |= {f"{name}.{component}": "m" for component in "xy"}
    table = make_data_frame(columns, index=TIME_COLUMN, units=units)
    table.attrs |= {"title": run.scene.title, "outcome": run.message, "error_estimate": run.error_estimate}
    return table


def make_xarray_dataset(run: Trajectory) -> Dataset:
    """Return all arrays of a run as a data set of xarray: the same that `xarray.open_dataset` reads from its netCDF file.

    Result: readings, rates, errors, motion, energies, reactions and events with units; coordinates are time,
    body, component and joint. Raises MechanismError if xarray is not installed.
    """
    xarray = _require("xarray", "a data set")
    variables = {one.name: (one.dimensions, one.values, dict(one.attributes)) for one in run_variables(run)}
    labels = variables.get("event_time", ((), None, {}))[2].pop("coordinates", "").split()
    return xarray.Dataset(variables, attrs=run_attributes(run)).set_coords(labels)


def _require(package: str, what: str) -> Any:
    """Return a package, or refuse if it is not installed."""
    try:
        return import_module(package)
    except ImportError as missing:
        raise MechanismError(f"{what} of {package} needs this package: pip install 'governor-mechanism[{package}]'") from missing

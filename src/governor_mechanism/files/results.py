"""Files of a run: CSV of the readings, netCDF of all arrays, JSON of the summary."""

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.files.netcdf import write_netcdf
from governor_mechanism.files.plain_values import finite_or_none, number_or_text, save_json, save_table
from governor_mechanism.files.table import reading_columns
from governor_mechanism.model.results.trajectory import Trajectory

REPORTED_PACKAGES = ("governor-mechanism", "pymunk", "numpy", "scipy")


def save_csv(run: Trajectory, path: Path) -> None:
    """Write times and readings as CSV: a comment with the SI units, a header of the plain names, and one row per reported time.

    The units stand in a comment, because names with units would have to be renamed before use. `pandas.read_csv(path, comment="#")`,
    `numpy.loadtxt`, R and gnuplot skip it.
    """
    columns, units = reading_columns(run)
    comment = "; ".join(f"{name} {unit}" for name, unit in units.items())
    save_table(list(columns), np.column_stack(list(columns.values())).tolist(), path, comment=f"units: {comment}")


def save_netcdf(run: Trajectory, path: Path) -> None:
    """Write all arrays of a run as netCDF-3 by the CF conventions, with all that `gm.open_run` needs to read the run back."""
    write_netcdf(run, run_record(run), path)


def run_record(run: Trajectory) -> dict[str, Any]:
    """Return what of a run is no array, as plain JSON values; `files.saved_run` makes the run of it and of the arrays.

    Result: the summary, and what only a program needs.
    """
    names = {"readings": list(run.readings), "rates": list(run.rates), "bodies": run.body_names, "joints": list(run.reactions)}
    scales = {"scales": run.scales, "energy_scale": run.energy.scale}
    summary = {name: value for name, value in summarise_run(run).items() if name != "document"}  # the scene has a place of its own
    return summary | scales | {"detail": run.detail, "names": names, "run_settings": run.scene.run}


def summarise_run(run: Trajectory) -> dict[str, Any]:
    """Return the summary of a run as plain JSON values.

    Result: scene, engine, settings, outcome, errors, final readings, events, cost and package versions.
    """
    return {
        "scene": Path(run.scene.source).name,  # a record goes to others, whom the folders of this machine do not concern
        "title": run.scene.title,
        "outcome": run.outcome.name.lower(),
        "message": run.message,
        "engine": run.cost.engine,
        "settings": run.settings,
        "error_estimate": None if run.error_estimate is None else number_or_text(run.error_estimate),
        "reading_errors": {name: number_or_text(error) for name, error in run.reading_errors.items()},
        "joint_gap": float(np.max(run.joint_gap, initial=0.0)),
        "energy_drift": run.energy.drift,
        "dissipated": float(run.energy.dissipated_energy[-1]) if len(run.times) else None,
        "n_excluded": run.n_excluded,
        "reported_times": len(run.times),
        "end_time": float(run.times[-1]) if len(run.times) else None,
        "final": {name: finite_or_none(float(values[-1])) for name, values in run.readings.items() if len(values)},
        "units": run.units,
        "mobility": run.mobility,
        "events": run.events,
        "speed_fluctuations": {angle: extremes.as_json() for angle, extremes in run.speed_fluctuations.items()},
        "largest_joint_forces": {name: finite_or_none(float(np.max(one.magnitude, initial=0.0))) for name, one in run.reactions.items()},
        "notes": (*run.notes, *run.event_notes),
        "cost": run.cost,
        "versions": package_versions(),
        "document": run.scene.document,
    }


def save_summary(run: Trajectory, path: Path) -> None:
    """Write the summary of a run as JSON."""
    save_json(summarise_run(run), path)


def package_versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    versions = {"python": platform.python_version()}
    for name in REPORTED_PACKAGES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:  # run from a source tree that was not installed
            versions[name] = "not installed"
    return versions

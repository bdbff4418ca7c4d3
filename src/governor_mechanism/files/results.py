"""Files of a run: CSV of the readings, netCDF of all arrays, JSON of the summary."""

import platform
import re
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.files.plain_values import save_json, save_table
from governor_mechanism.model.trajectory import Trajectory

REPORTED_PACKAGES = ("governor-mechanism", "pymunk", "numpy", "scipy", "numba")


def save_csv(run: Trajectory, path: Path) -> None:
    """Write times and readings as CSV: one row per reported time, SI units in the header.

    Parameters
    ----------
    run
        The run.
    path
        Path of the file.
    """
    header = ["time [s]", *(f"{name} [{run.units[name]}]" for name in run.readings)]
    save_table(header, np.column_stack([run.times, *run.readings.values()]).tolist(), path)


def save_netcdf(run: Trajectory, path: Path) -> None:
    """Write all arrays of a run as netCDF-3, with the dimensions time, body and component (x, y, angle).

    Variables have ASCII names, those of readings with the prefix `reading_` and of their rates `rate_`; the attribute `long_name` is the
    name of the reading. Texts are in UTF-8.

    Parameters
    ----------
    run
        The run.
    path
        Path of the file.
    """
    from scipy.io import netcdf_file

    with atomic_write(path) as temporary, netcdf_file(temporary, "w", version=2) as dataset:
        dataset.title, dataset.outcome = run.scene.title.encode(), run.message.encode()
        dataset.bodies = ", ".join(run.body_names).encode()
        dataset.createDimension("time", len(run.times))
        dataset.createDimension("body", len(run.body_names))
        dataset.createDimension("component", 3)
        columns = [("time", "time", run.times, "s"), ("joint_gap", "joint gap", run.joint_gap, "m")]
        ascii_names = _make_ascii_names(run.readings)
        columns += [(f"reading_{ascii_names[name]}", name, values, run.units[name]) for name, values in run.readings.items()]
        columns += [(f"rate_{ascii_names[name]}", f"rate of {name}", values, f"{run.units[name]}/s") for name, values in run.rates.items()]
        energy_names = ("kinetic", "potential", "rotation", "jacobi", "dissipated_energy")
        columns += [(f"energy_{name.removesuffix('_energy')}", name, getattr(run.energy, name), "J") for name in energy_names]
        for name, long_name, values, unit in columns:
            variable = dataset.createVariable(name, "d", ("time",))
            variable[:] = values
            variable.units, variable.long_name = unit, long_name.encode()
        for name, block in (("pose", run.poses), ("velocity", run.velocities)):
            dataset.createVariable(name, "d", ("time", "body", "component"))[:] = block
        _save_reactions(run, dataset)


def _make_ascii_names(names: Iterable[str]) -> dict[str, str]:
    """Return a name of ASCII letters, digits and underscores for each name, no two alike."""
    ascii_names: dict[str, str] = {}
    for name in sorted(names, key=lambda name: not name.isascii()):
        ascii_name = re.sub("[^a-zA-Z0-9_]", "_", name)
        while ascii_name in ascii_names.values():
            ascii_name += "_"
        ascii_names[name] = ascii_name
    return ascii_names


def _save_reactions(run: Trajectory, dataset: Any) -> None:
    """Write the reactions on second bodies: force x, y (N) and moment (N m), and whether they are determined (1 or 0)."""
    if not run.reactions:
        return
    dataset.joints = ", ".join(run.reactions).encode()
    dataset.createDimension("joint", len(run.reactions))
    blocks = [np.column_stack([one.force, one.moment]) for one in run.reactions.values()]
    dataset.createVariable("reaction", "d", ("time", "joint", "component"))[:] = np.stack(blocks, axis=1)
    is_determined = np.stack([one.determined for one in run.reactions.values()], axis=1)
    dataset.createVariable("reaction_determined", "b", ("time", "joint"))[:] = is_determined


def summarise_run(run: Trajectory) -> dict[str, Any]:
    """Return the summary of a run as plain JSON values.

    Parameters
    ----------
    run
        The run.

    Returns
    -------
    dict
        Scene, engine, settings, outcome, errors, final readings, events, cost and package versions.
    """
    return {
        "scene": run.scene.source,
        "title": run.scene.title,
        "outcome": run.outcome.name.lower(),
        "message": run.message,
        "engine": run.cost.engine,
        "settings": run.settings,
        "error_estimate": run.error_estimate,
        "reading_errors": run.reading_errors,
        "joint_gap": float(np.max(run.joint_gap, initial=0.0)),
        "energy_drift": run.energy.drift,
        "dissipated": float(run.energy.dissipated_energy[-1]) if len(run.times) else None,
        "n_excluded": run.n_excluded,
        "reported_times": len(run.times),
        "end_time": float(run.times[-1]) if len(run.times) else None,
        "final": {name: float(values[-1]) for name, values in run.readings.items() if len(values)},
        "units": run.units,
        "mobility": run.mobility,
        "events": run.events,
        "speed_fluctuations": {angle: extremes.as_json() for angle, extremes in run.speed_fluctuations.items()},
        "largest_joint_forces": {name: float(np.max(one.magnitude, initial=0.0)) for name, one in run.reactions.items()},
        "notes": run.notes,
        "cost": run.cost,
        "versions": package_versions(),
        "document": run.scene.document,
    }


def save_summary(run: Trajectory, path: Path) -> None:
    """Write the summary of a run as JSON.

    Parameters
    ----------
    run
        The run.
    path
        Path of the file.
    """
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

"""A saved run as a run: the same arrays, bit by bit, and what else the program knew of it."""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.netcdf import SavedArrays, read_netcdf
from governor_mechanism.files.run_dataset import energy_of
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.cost import Cost
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.reaction import Reaction
from governor_mechanism.model.results.speed_fluctuation import SpeedFluctuation
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class _SavedResults:
    """Results that a run computes on first access, and that its file holds."""

    saved_reactions: Mapping[str, Reaction]
    saved_events: tuple[Event, ...]
    saved_fluctuations: Mapping[str, SpeedFluctuation]

    def reactions(self) -> Mapping[str, Reaction]:
        """Return the reactions by joint name."""
        return self.saved_reactions

    def events(self) -> tuple[Event, ...]:
        """Return the events in order of time."""
        return self.saved_events

    def event_notes(self) -> tuple[str, ...]:
        """Return nothing: the notes of a saved run include these sentences."""
        return ()

    def speed_fluctuations(self) -> Mapping[str, SpeedFluctuation]:
        """Return the extreme speeds of shafts by the reading of their angle."""
        return self.saved_fluctuations


def open_saved_run(
    # the folder of a saved run, its .nc file, or a file of the same name beside that
    source: str | os.PathLike[str],
) -> Trajectory:
    """Return a run that was saved.

    Raises MechanismError if there is no such file, it is damaged or of another version, or its scene was not
    saved.
    """
    path = _find_file(Path(source))
    saved = read_netcdf(path)
    record, arrays = saved.record, saved.arrays
    scene = _read_scene(saved, path)
    named = {name: {saved.long_names[one]: arrays[one] for one in arrays if one.startswith(name)} for name in ("reading_", "rate_")}
    poses, velocities = (
        np.concatenate([arrays[vector], arrays[angle][..., np.newaxis]], axis=2)
        for vector, angle in (("position", "angle"), ("velocity", "angular_velocity"))
    )
    return Trajectory(
        scene=scene,
        times=arrays["time"],
        poses=poses,
        velocities=velocities,
        readings={name: named["reading_"][name] for name in record["names"]["readings"]},
        rates={name: named["rate_"][f"rate of {name}"] for name in record["names"]["rates"]},
        units=record["units"],
        scales=record["scales"],
        joint_gap=arrays["joint_gap"],
        energy=energy_of(arrays, record["energy_scale"]),
        outcome=Outcome[record["outcome"].upper()],
        cost=Cost(**record["cost"]),
        detail=record["detail"],
        error_estimate=None if record["error_estimate"] is None else float(record["error_estimate"]),
        reading_errors={name: float(error) for name, error in record["reading_errors"].items()},
        settings=record["settings"],
        n_excluded=record["n_excluded"],
        mobility=record["mobility"],
        notes=tuple(record["notes"]),
        deferred_results=_SavedResults(
            saved_reactions=_read_reactions(saved),
            saved_events=tuple(Event(**{**event, "kind": EventKind(event["kind"])}) for event in record["events"]),
            saved_fluctuations={angle: _read_fluctuation(extremes) for angle, extremes in record["speed_fluctuations"].items()},
        ),
    )


def _find_file(source: Path) -> Path:
    """Return the netCDF file of a folder or of a file beside it."""
    if source.is_dir():
        found = sorted(source.glob("*.nc"))
        if len(found) == 1:
            return found[0]
        if found:
            names = ", ".join(path.name for path in found)
            raise MechanismError(f"the folder {source} holds several runs, {names}; give the path of one of these files")
        raise MechanismError(f"the folder {source} holds no run: no file ends in .nc; give the folder that `run --out` or run.save wrote")
    path = source.with_suffix(".nc")
    if not path.is_file():
        what = f"{source} is no run" if source.is_file() else f"there is no file or folder {source}"
        raise MechanismError(f"{what}; give the folder that `run --out` or run.save wrote, or its .nc file")
    return path


def _read_scene(saved: SavedArrays, path: Path) -> Scene:
    """Return the scene of the run, from its document."""
    record = saved.record
    if not saved.document:
        raise MechanismError(
            f"{path} has no scene: that of this run was changed in Python after it was read, and no scene file describes it; "
            "read the arrays with xarray.open_dataset"
        )
    scene = parse_scene_document(saved.document, record["scene"])
    settings = RunSettings(**record["run_settings"])
    run_settings = replace(settings, reactions=tuple(settings.reactions))  # JSON has lists only
    scene = replace(scene, title=record["title"], run=run_settings)
    if [body.name for body in scene.mechanism.bodies] != saved.arrays["body"]:
        raise MechanismError(
            f"{path} was written by another version of governor_mechanism, whose mechanism has other bodies; simulate again"
        )
    return scene


def _read_reactions(saved: SavedArrays) -> dict[str, Reaction]:
    """Return the reactions by joint name."""
    arrays = saved.arrays
    if "joint" not in arrays:
        return {}
    forces, moments, determined = (arrays[f"reaction_{name}"] for name in ("force", "moment", "determined"))
    return {
        name: Reaction(force=_column(forces, k), moment=_column(moments, k), determined=_column(determined, k).astype(bool))
        for k, name in enumerate(saved.record["names"]["joints"])
    }


def _column(values: Any, k: int) -> FloatArray:
    """Return the values of joint k."""
    column: FloatArray = np.ascontiguousarray(values[:, k])
    return column


def _read_fluctuation(extremes: Mapping[str, float]) -> SpeedFluctuation:
    """Return the extreme speeds of a shaft, whose mean and coefficient follow."""
    return SpeedFluctuation(**{name: extremes[name] for name in ("lowest", "highest", "lowest_angle", "highest_angle")})

"""A run as named arrays with units: its netCDF file, the run that is read back from it, and what xarray gets."""

import hashlib
import io
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.classic_netcdf import TEXT_ENCODING, RunVariable, encode_classic_netcdf
from governor_mechanism.files.writing import atomic_write, plain_value
from governor_mechanism.mechanics.dynamics.inputs import lagged_functions_of
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.results.records import Cost, Energy, Outcome, Reaction, Recurrence, SpeedFluctuation
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.scenes.parser import parse_scene_document
from governor_mechanism.types import FloatArray

CONVENTIONS: Final = "CF-1.8"
"""Version of the Climate and Forecast conventions for metadata, which netCDF readers know."""

LENGTH_AXES: Final = ("x", "y")
"""Components of positions, velocities and forces: along the axes of the plane of a part."""

ENERGY_VARIABLES: Final = {
    "kinetic": ("energy_kinetic", "kinetic energy of the motion in the plane"),
    "potential": ("energy_potential", "potential energy of gravity and springs"),
    "rotation": ("energy_rotation", "kinetic energy of the rotation about the spindle"),
    "jacobi": ("energy_jacobi", "Jacobi integral, constant in an exact run"),
    "dissipated_energy": ("energy_dissipated", "energy dissipated since the start"),
}
"""Names and long names of the variables of the fields of `Energy`."""


def run_variables(run: Trajectory) -> list[RunVariable]:
    """Return all arrays of a run by the CF conventions; names of bodies, joints and components are coordinates of text."""
    variables = [RunVariable(name="time", dimensions=("time",), values=run.times, attributes={"units": "s", "long_name": "time"})]
    variables += [_labels("body", run.body_names, "name of the body"), _labels("component", LENGTH_AXES, "axis of the plane of the part")]
    variables += _reading_variables(run)
    motions = (
        ("position", run.poses[..., :2], "m", "position of the mass centre"),
        ("angle", run.poses[..., 2], "rad", "angle of the body, anticlockwise"),
        ("velocity", run.velocities[..., :2], "m/s", "velocity of the mass centre"),
        ("angular_velocity", run.velocities[..., 2], "rad/s", "angular velocity of the body, anticlockwise"),
    )
    variables += [_array(name, ("time", "body"), values, unit, text) for name, values, unit, text in motions]
    variables.append(_array("joint_gap", ("time",), run.joint_gap, "m", "joint gap"))
    energies = ((name, text, getattr(run.energy, key)) for key, (name, text) in ENERGY_VARIABLES.items())
    variables += [_array(name, ("time",), values, "J", text) for name, text, values in energies]
    return [*variables, *_reaction_variables(run), *_event_variables(run)]


def run_attributes(run: Trajectory) -> dict[str, str]:
    """Return the title of a run, the conventions, the program, the outcome, and the scene as JSON."""
    method = f" ({run.cost.method})" if run.cost.method else ""
    texts = {"title": run.scene.title, "Conventions": CONVENTIONS, "outcome": run.message}
    scene = json.dumps(plain_value(find_true_document(run.scene)), ensure_ascii=False)
    return texts | {"source": f"governor_mechanism, simulated by the engine {run.cost.engine}{method}", "scene": scene}


def find_true_document(scene: Scene) -> Mapping[str, Any]:
    """Return the document of a scene, or an empty one if the scene was changed in Python and its document no longer describes it."""
    if not scene.document:
        return {}
    try:
        described = parse_scene_document(scene.document, scene.source)
    except MechanismError:
        return {}
    is_same = all(getattr(described, name) == getattr(scene, name) for name in ("parts", "couplings", "crossings"))
    return scene.document if is_same else {}


def make_ascii_names(names: Iterable[str]) -> dict[str, str]:
    """Return a name of ASCII letters, digits and underscores for each name, no two alike."""
    ascii_names: dict[str, str] = {}
    for name in sorted(names, key=lambda name: not name.isascii()):
        ascii_name = re.sub("[^a-zA-Z0-9_]", "_", name)
        while ascii_name in ascii_names.values():
            ascii_name += "_"
        ascii_names[name] = ascii_name
    return ascii_names


def energy_of(
    arrays: Mapping[str, NDArray[Any]],  # arrays by name; shape (n,)
    scale: float,  # energy scale, J
) -> Energy:
    """Return the energies from the arrays by the names of their variables, and their scale, J."""
    return Energy(scale=scale, **{key: arrays[name] for key, (name, _) in ENERGY_VARIABLES.items()})


def _array(name: str, dimensions: tuple[str, ...], values: NDArray[Any], unit: str, long_name: str, **links: str) -> RunVariable:
    """Return a variable of numbers; vectors have the dimension of components, too."""
    all_dimensions = (*dimensions, "component") if values.ndim > len(dimensions) else dimensions
    return RunVariable(name=name, dimensions=all_dimensions, values=values, attributes={"units": unit, "long_name": long_name, **links})


def _labels(name: str, texts: Iterable[str], long_name: str, dimension: str = "") -> RunVariable:
    return RunVariable(
        name=name, dimensions=(dimension or name,), values=np.array(list(texts), dtype=object), attributes={"long_name": long_name}
    )


def _reading_variables(run: Trajectory) -> Iterator[RunVariable]:
    """Yield readings and rates, each with its largest error beside it if the run is certified; and the error of the joint gap."""
    ascii_names = make_ascii_names(run.readings)
    series = [(f"reading_{ascii_names[name]}", name, values, run.units[name] or "1") for name, values in run.readings.items()]
    series += [
        (f"rate_{ascii_names[name]}", f"rate of {name}", values, f"{run.units[name] or '1'}/s") for name, values in run.rates.items()
    ]
    for name, long_name, values, unit in series:
        error = run.reading_errors.get(long_name)
        if error is None:
            yield _array(name, ("time",), values, unit, long_name)
            continue
        yield _array(name, ("time",), values, unit, long_name, ancillary_variables=f"error_{name}")
        yield _array(f"error_{name}", (), np.array(error), unit, f"largest error of {long_name} at any reported time")


def _reaction_variables(run: Trajectory) -> Iterator[RunVariable]:
    """Yield the reactions on second bodies, and whether they are determined (1 or 0)."""
    if not run.reactions:
        return
    yield _labels("joint", run.reactions, "name of the joint")
    forces, moments, determined = (
        np.stack([getattr(one, name) for one in run.reactions.values()], axis=1) for name in ("force", "moment", "determined")
    )
    link = {"ancillary_variables": "reaction_determined"}
    yield _array("reaction_force", ("time", "joint"), forces, "N", "force of the joint on its second body", **link)
    yield _array("reaction_moment", ("time", "joint"), moments, "N m", "moment of the joint on its second body, anticlockwise", **link)
    flags = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "one_of_many_solutions determined"}
    yield RunVariable(
        name="reaction_determined",
        dimensions=("time", "joint"),
        values=determined.astype(np.int8),
        attributes={"long_name": "whether rigid-body mechanics determines the reaction", **flags},
    )


def _event_variables(run: Trajectory) -> Iterator[RunVariable]:
    """Yield times, kinds and subjects of the events."""
    if not run.events:
        return
    times = np.array([event.time for event in run.events])
    yield _array("event_time", ("event",), times, "s", "time of the event", coordinates="event_kind event_subject")
    yield _labels("event_kind", [event.kind.value for event in run.events], "kind of the event", "event")
    yield _labels("event_subject", [event.subject for event in run.events], "reading or crossing of the event", "event")


FORMAT_VERSION: Final = 1
"""Version of the files of runs. It changes with what `read_netcdf` needs."""

_VERSION_NAME = "governor_mechanism_format"
_RECORD_NAME = "governor_mechanism_record"
_DIGEST_NAME = "governor_mechanism_sha256"
"""Attributes: version of the format, what is no array as JSON, and the digest of the file."""

_NO_DIGEST: Final = b"0" * 64
"""What stands in place of the digest while it is computed."""

_ATTRIBUTE_HEADER_SIZE: Final = 8
"""Bytes between name and value of an attribute in a netCDF-3 file: type and number of letters."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SavedArrays:
    """What a netCDF file of a run holds."""

    arrays: Mapping[str, Any]  # arrays by the names of their variables; texts as lists
    long_names: Mapping[str, str]  # long names of the variables by name
    record: Mapping[str, Any]  # what is no array, in the types of JSON
    document: Mapping[str, Any]  # document of the scene; empty if it has none


def write_netcdf(run: Trajectory, record: Mapping[str, Any], path: Path) -> None:
    """Write all arrays of a run as netCDF-3 by the CF conventions, with units and long names, texts in UTF-8."""
    # Variables have ASCII names, those of readings with the prefix `reading_` and of their rates
    # `rate_`; the attribute `long_name` is the name of the reading.
    program = record["versions"]["governor-mechanism"]
    attributes: dict[str, str | NDArray[Any]] = {
        **run_attributes(run),
        "history": f"{datetime.now(UTC):%Y-%m-%dT%H:%M:%SZ} written by governor_mechanism {program}",
        _VERSION_NAME: np.array([FORMAT_VERSION], dtype=np.int32),
        _RECORD_NAME: json.dumps(plain_value(record), allow_nan=False, ensure_ascii=False),
        _DIGEST_NAME: _NO_DIGEST.decode(),
    }
    content = encode_classic_netcdf(attributes, [_as_letters(variable) for variable in run_variables(run)])
    at = _find_digest(content)
    digest = hashlib.sha256(content).hexdigest().encode()
    with atomic_write(path) as temporary:
        temporary.write_bytes(content[:at] + digest + content[at + len(digest) :])


def read_netcdf(path: Path) -> SavedArrays:
    """Return the arrays and the record of a saved run; raise MechanismError for a file that is none, damaged, or of another version."""
    from scipy.io import netcdf_file  # slow to import

    try:
        content = path.read_bytes()
    except OSError as error:
        raise MechanismError(f"cannot read {path}: {error.strerror or error}") from error
    at = _find_digest(content)
    if not content.startswith(b"CDF") or at < 0:
        raise MechanismError(
            f"{path} is no netCDF file of a run in this format; give the folder or the .nc file that `run --out` or run.save wrote, and "
            "simulate a run again that an earlier version wrote"
        )
    digest, length = content[at : at + len(_NO_DIGEST)], len(_NO_DIGEST)
    if hashlib.sha256(content[:at] + _NO_DIGEST + content[at + length :]).hexdigest().encode() != digest:
        raise MechanismError(f"{path} is damaged: its content does not match its digest; copy it again, or simulate the run again")
    with netcdf_file(io.BytesIO(content), mmap=False) as dataset:
        version = int(getattr(dataset, _VERSION_NAME))
        if version != FORMAT_VERSION:
            raise MechanismError(
                f"{path} has version {version} of the format, and this governor_mechanism reads version {FORMAT_VERSION}; open it with the "
                "governor_mechanism that wrote it, or simulate the run again"
            )
        record, document = (json.loads(getattr(dataset, name).decode(TEXT_ENCODING)) for name in (_RECORD_NAME, "scene"))
        arrays = {name: _native_values(variable) for name, variable in dataset.variables.items()}
        long_names = {name: variable.long_name.decode(TEXT_ENCODING) for name, variable in dataset.variables.items()}
    return SavedArrays(arrays=arrays, long_names=long_names, record=record, document=document)


def _find_digest(content: bytes) -> int:
    """Return the position of the digest in a file, or -1."""
    at = content.find(_DIGEST_NAME.encode())
    padded_length = -(-len(_DIGEST_NAME) // 4) * 4
    return -1 if at < 0 else at + padded_length + _ATTRIBUTE_HEADER_SIZE


def _as_letters(variable: RunVariable) -> RunVariable:
    """Return a variable of texts as one of letters, with a dimension for the longest text; any other variable as it is."""
    if variable.values.dtype.char != "O":
        return variable
    texts = [text.encode(TEXT_ENCODING) for text in variable.values]
    length = max(1, *map(len, texts)) if texts else 1
    return RunVariable(
        name=variable.name,
        dimensions=(*variable.dimensions, f"{variable.name}_letters"),
        values=np.array(texts, dtype=f"S{length}").reshape(-1, 1).view("S1").reshape(len(texts), length),
        attributes={**variable.attributes, "_Encoding": TEXT_ENCODING},
    )


def _native_values(variable: Any) -> NDArray[Any] | list[str]:
    """Return the values of a variable in the byte order of the machine; texts as a list."""
    values: NDArray[Any] = variable.data
    if values.dtype.char in "cS":
        return [b"".join(row).rstrip(b"\0").decode(TEXT_ENCODING) for row in values]
    return values.astype(values.dtype.newbyteorder("="))


@dataclass(frozen=True, kw_only=True)
class _SavedResults:
    """Results that a run computes on first access, and that its file holds."""

    saved_reactions: Mapping[str, Reaction]
    saved_events: tuple[Event, ...]
    saved_fluctuations: Mapping[str, SpeedFluctuation]
    saved_recurrences: Mapping[str, Recurrence]
    has_lags: bool

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

    def recurrences(self) -> Mapping[str, Recurrence]:
        """Return how named crossings recur, by their names."""
        return self.saved_recurrences

    def lags_at(self, k: int) -> tuple[float, ...]:
        """Return none, or raise MechanismError if there are lags: the file holds no states of them."""
        if self.has_lags:
            raise MechanismError("a saved run holds no states of lags; run its scene again to go on from it")
        return ()

    def states_near_events(self, times: FloatArray) -> Mapping[int, tuple[FloatArray, FloatArray]]:
        """Return nothing: a file holds the states at the reported times."""
        return {}


def open_saved_run(
    # the folder of a saved run, its .nc file, or a file of the same name beside that
    source: str | os.PathLike[str],
) -> Trajectory:
    """Return a run that was saved; raise MechanismError if there is none, or its scene was not saved."""
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
            saved_recurrences={name: Recurrence(**one) for name, one in record["recurrences"].items()},
            has_lags=bool(lagged_functions_of(scene)),
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
    run_settings = replace(settings, readings=tuple(settings.readings), paths=tuple(settings.paths))  # JSON has lists only
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

"""A run as named arrays with dimensions and attributes: what its netCDF file holds, and what xarray gets."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.plain_values import plain_value
from governor_mechanism.model.results.energy import Energy
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.parser import parse_scene_document

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


@dataclass(frozen=True, kw_only=True, eq=False)
class RunVariable:
    """An array of a run.

    Attributes
    ----------
    name
        Name of ASCII letters, digits and underscores.
    dimensions
        Names of the dimensions; none for a number.
    values
        Numbers in SI, or texts.
    attributes
        Unit, long name, and links to other variables.
    """

    name: str
    dimensions: tuple[str, ...]
    values: NDArray[Any]
    attributes: Mapping[str, Any] = field(default_factory=dict)


def run_variables(run: Trajectory) -> list[RunVariable]:
    """Return all arrays of a run by the CF conventions; names of bodies, joints and components are coordinates of text.

    Result: coordinates; readings, their rates and their errors; motion; energies; reactions; events.
    """
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
    """Return the document of a scene, or an empty one if the scene was changed in Python and its document no longer describes it.

    Result: keys and tables of a scene file, whose settings of the run may be others.
    """
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

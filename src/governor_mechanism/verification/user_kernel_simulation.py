"""Values that the simulation gives for a user's kernel: results, their errors, and the arguments that belong to them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.custom.dimensions import dimensions_of
from governor_mechanism.types import FloatArray
from governor_mechanism.units.fields import fields_of
from governor_mechanism.units.quantities import QUANTITY_KINDS, parse_quantity

_FIRST_KINDS: dict[str, str] = {kind.si_unit or "1": name for name, kind in list(QUANTITY_KINDS.items())[::-1]}
KINDS_BY_UNIT: Final[dict[str, str]] = {**_FIRST_KINDS, "rad/s": "angular_speed", "J": "torque", "1": "ratio"}
"""Kind of quantity by SI unit; energy has the dimension of a torque."""


def kind_of_unit(si_unit: str) -> str:
    """Return the kind of quantity of an SI unit; that of bare numbers for a unit without other spellings."""
    return KINDS_BY_UNIT.get(si_unit, "ratio")


def unit_factor(
    unit: str,  # a unit such as "rpm"
    si_unit: str,  # SI unit of the same kind
    what: str,
    *,
    is_frequency: bool = False,  # whether the unit counts cycles of a frequency in rad/s: 1 Hz is 2 pi rad/s
) -> float:
    """Return the SI value of one `unit`; raise MechanismError if the unit is unknown or of another kind."""
    if unit == si_unit:
        return 1.0
    if not unit.strip():
        raise MechanismError(f"the unit of {what} is empty; give one, or leave it out for {si_unit}")
    if is_frequency:
        return math.tau * parse_quantity(f"1 {unit}", "frequency", f"the unit of {what}")
    if si_unit not in KINDS_BY_UNIT:
        raise MechanismError(f"{what} is in {si_unit}, and no other unit is known for it; got {unit!r}")
    return parse_quantity(f"1 {unit}", KINDS_BY_UNIT[si_unit], f"the unit of {what}")


def constant_units(scene: Scene) -> dict[str, str]:
    """Return the SI units of gravity and of the numeric dimensions of a scene, by name; of several parts with the part in front."""
    units = {}
    for part in scene.parts:
        prefix = _prefix(scene, part)
        machine = MACHINES.get(part.machine)
        declared = dimensions_of(scene, part) if machine is None else fields_of(machine)
        own_units = {name: one.unit for name, one in declared.items()}
        units[f"{prefix}gravity"] = "m/s^2"
        for name, value in part.dimensions.items():
            if isinstance(value, float | int) and not isinstance(value, bool):
                units[prefix + name] = own_units[name] or "1" if name in own_units else ""
    return units


def constant_values(scene: Scene) -> dict[str, float]:
    """Return gravity and the numeric dimensions of a scene in SI, by the same names; a dimension that is left out is infinite."""
    constants = {_prefix(scene, part) + name: value for part in scene.parts for name, value in _constants_of(part).items()}
    return {name: float(constants[name]) for name in constant_units(scene)}


def _constants_of(part: Part) -> dict[str, Any]:
    return {"gravity": part.gravity, **part.dimensions}


def _prefix(scene: Scene, part: Part) -> str:
    return "" if len(scene.parts) == 1 else f"{part.name}_"


ULPS = (-3.0, -1.0, 1.0, 3.0)
"""Displacements of an argument, in units of four roundings, at which an algebraic result is evaluated again."""

SPREAD_FACTOR = 4.0
"""Error over the spread of the displaced results; four samples of rounding show a half to a quarter of its bound."""

ROUNDING = 16 * np.finfo(float).eps
"""Error of a result relative to itself where displaced results happen to be equal."""


class Series(NamedTuple):
    """Values (n,) of an argument, SI, and its unit."""

    values: FloatArray
    unit: str


class Input(NamedTuple):
    """An argument that the user gives: its SI unit, and its value where it may be left out; None if it must be given."""

    unit: str
    default: float | None = None


@dataclass(frozen=True, kw_only=True)
class Simulated:
    """A quantity as simulated."""

    values: FloatArray  # results, SI; shape (n,)
    errors: FloatArray  # estimates of their errors, SI; shape (n,)
    arguments: Mapping[str, Series]  # what a kernel may take besides dimensions and gravity, by name
    scale: float | None = None  # value to which a tolerance is relative, SI; None for each result itself
    notes: tuple[str, ...] = ()  # sentences on what is missing


Evaluator = Callable[[Scene, Mapping[str, FloatArray], float], Simulated]
"""Function of a scene, the inputs (n,) by name in SI, and the relative accuracy that a run should have."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """A quantity of a scene that a kernel may compute."""

    name: str
    unit: str  # its SI unit
    description: str  # what it is, in a phrase
    inputs: Mapping[str, Input]  # what the user gives by name
    arguments: tuple[str, ...]  # names of further arguments of the kernel besides dimensions and gravity
    evaluate: Evaluator  # function that simulates it
    period: float = 0.0  # period of an angle that counts modulo a turn, rad; 0 for other quantities
    is_frequency: bool = False  # whether a unit such as Hz counts cycles


def evaluate_with_rounding(
    evaluate: Callable[[FloatArray], Mapping[str, FloatArray]], points: FloatArray, name: str
) -> tuple[dict[str, FloatArray], FloatArray]:
    """Return algebraic results (n,) at points (n,) by name, and the errors (n,) of one of them through rounding."""
    # The results are evaluated again at points displaced by a few roundings: their spread shows the
    # rounding of assembly and evaluation, and what the rounding of the points themselves changes.
    scale = max(float(np.max(np.abs(points))), 1e-3)
    displacements = 4 * np.finfo(float).eps * scale * np.array([0.0, *ULPS])
    displaced = points[:, np.newaxis] + displacements  # neighbours in order, so that a path through all points stays short
    try:
        columns = evaluate(displaced.ravel())
    except MechanismError:  # a point may be at an end of the travel
        columns = evaluate(np.clip(displaced, points.min(), points.max()).ravel())
    tables = {key: np.asarray(values).reshape(displaced.shape) for key, values in columns.items()}
    results = {key: table[:, 0] for key, table in tables.items()}
    spread = np.max(np.abs(tables[name] - results[name][:, np.newaxis]), axis=1)
    return results, SPREAD_FACTOR * spread + ROUNDING * np.abs(results[name])

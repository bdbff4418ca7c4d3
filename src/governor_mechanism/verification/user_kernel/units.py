"""Units of results and arguments of a kernel."""

import math
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.registry import MACHINES
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.scenes.custom.dimensions import dimensions_of
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
    """Return the SI value of one `unit`.

    Raises MechanismError if the unit is unknown or of another kind.
    """
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

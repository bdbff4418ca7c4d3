"""Controls applied to the loads they name, and checks of gears."""

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.coupling.couplings import ControlCoupling, GearCoupling
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.time_functions import InputFunction


def apply_control(
    control: ControlCoupling, mechanism: Mechanism, effects: tuple[OutputEffect, ...]
) -> tuple[Mechanism, tuple[OutputEffect, ...]]:
    """Return a mechanism and effects in which the load that a control names follows its reading.

    Parameters
    ----------
    control
        The control.
    mechanism
        Mechanism with its force elements.
    effects
        Effects along readings.

    Returns
    -------
    tuple[Mechanism, tuple[OutputEffect, ...]]
        Both with the changed load.

    Raises
    ------
    MechanismError
        If there is no load of that name.
    """
    loads: dict[str, tuple[Any, str]] = {
        name: (element, field_name) for element in mechanism.force_elements for name, field_name in _loads_of(element, element.name)
    }
    for effect in effects:
        part, _, reading = effect.reading.rpartition(".")
        key = f"{part}.{effect.key}.{reading}" if part else f"{effect.key}.{reading}"
        loads |= {name: (effect, field_name) for name, field_name in _loads_of(effect, key)}
    if control.target not in loads:
        raise MechanismError(
            f"coupling {control.name!r} sets {control.target!r}, which is no load; the loads are {list(loads)}."
            f"{did_you_mean(control.target, list(loads))}"
        )
    owner, field_name = loads[control.target]
    load: InputFunction = getattr(owner, field_name)
    kind = "factors" if control.scales else "functions"
    changed = replace(load, **{kind: (*getattr(load, kind), control.function)})
    new = replace(owner, **{field_name: changed})
    elements = tuple(new if element is owner else element for element in mechanism.force_elements)
    return replace(mechanism, force_elements=elements), tuple(new if effect is owner else effect for effect in effects)


def _loads_of(owner: Any, name: str) -> list[tuple[str, str]]:
    """Return name and field of each load of a force element or an effect; several loads get the name of the field behind."""
    names = [one.name for one in fields(owner) if isinstance(getattr(owner, one.name), InputFunction)]
    return [(name if len(names) == 1 else f"{name}.{one}", one) for one in names]


def check_gears(gears: Sequence[GearCoupling], spindle_angles: Sequence[str], mechanism: Mechanism) -> None:
    """Raise MechanismError for a gear on a spindle that is no coordinate, and for gears in a closed loop.

    Parameters
    ----------
    gears
        The gears.
    spindle_angles
        Names of the angles of all spindles.
    mechanism
        Mechanism whose readings are the coordinates that a gear can couple.

    Raises
    ------
    MechanismError
        If a gear is impossible or superfluous.
    """
    readings = {reading.name for reading in mechanism.readings}
    ratios: dict[str, tuple[str, float]] = {}

    def root_of(name: str) -> tuple[str, float]:
        """Return the first angle of the train that an angle belongs to, and the ratio of the angle to it."""
        parent, ratio = ratios.get(name, (name, 1.0))
        if parent == name:
            return name, 1.0
        root, root_ratio = root_of(parent)
        return root, ratio * root_ratio

    for gear in gears:
        for name in (gear.first, gear.second):
            if name in spindle_angles and name not in readings:
                raise MechanismError(
                    f"gear {gear.name!r} couples {name!r}, whose speed is given or follows another part, so that no torque acts on it; "
                    "use type follow, or leave spindle.speed out"
                )
        (first_root, first_ratio), (second_root, second_ratio) = root_of(gear.first), root_of(gear.second)
        if first_root == second_root:
            through_others = second_ratio / first_ratio
            problem = "is superfluous" if abs(through_others - gear.ratio) <= 1e-12 * abs(gear.ratio) else "contradicts the others"
            raise MechanismError(
                f"gear {gear.name!r} closes a loop of gears and {problem}: through the others the ratio of {gear.second!r} to "
                f"{gear.first!r} is {through_others:g}, and here it is {gear.ratio:g}; leave it out"
            )
        ratios[second_root] = first_root, gear.ratio * first_ratio / second_ratio


def check_reading_functions(mechanism: Mechanism, effects: Sequence[OutputEffect]) -> None:
    """Raise MechanismError for loads that depend on what is no reading, or on what the loads themselves determine.

    Parameters
    ----------
    mechanism
        Mechanism with its force elements and readings.
    effects
        Effects along readings.

    Raises
    ------
    MechanismError
        With a sentence for each function of an unknown reading, a reaction, a force, or a speed that is given.
    """
    names = [reading.name for reading in mechanism.readings]
    speeds = [f"{name.removesuffix('angle')}speed" for name in names if name.rpartition(".")[2] == "spindle_angle"]
    forces = [output.name for output in mechanism.derived_forces] + [joint.name for joint in mechanism.joints]
    problems = []
    for owner in (*mechanism.force_elements, *effects):
        for _, field_name in _loads_of(owner, ""):
            load: InputFunction = getattr(owner, field_name)
            for function in (*load.functions, *load.factors):
                reading, known = function.reading, [*names, *speeds]
                if reading in known:
                    found = "angular_speed" if reading in speeds else mechanism.reading(reading).quantity
                    if function.quantity and function.quantity != found:
                        problems.append(
                            f"a load depends on {reading!r}, which is of the kind {found}, but its function has the units of "
                            f"the kind {function.quantity}; change the units"
                        )
                    continue
                what = f"a load depends on {reading!r}"
                if reading in forces or reading.rpartition(".")[2] == "spindle_torque":
                    problems.append(f"{what}, a force, which follows from the loads: this is an algebraic loop; use a position or a speed")
                elif reading.rpartition(".")[2] == "spindle_speed":
                    problems.append(f"{what}, but that speed is given or follows another part; use time, or the speed it follows")
                else:
                    problems.append(f"{what}, which is no reading; readings are {known}.{did_you_mean(reading, known)}")
    if problems:
        raise MechanismError(*problems)

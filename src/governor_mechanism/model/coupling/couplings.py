"""Couplings between parts of a scene, their checks, and controls applied to the loads they name. Frozen values without mathematics."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from itertools import pairwise
from typing import Any, Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.force_elements import CylinderGas, Force, ForceElement, MeanGasTorque, Torque
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import ShaftSpeed
from governor_mechanism.model.time_functions import InputFunction, LinearFunction, ReadingFunction, TableFunction
from governor_mechanism.units.fields import entry, quantity, require_valid_fields


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """Base class of a coupling between parts."""

    name: str  # name in messages and results


@dataclass(frozen=True, kw_only=True)
class RatioCoupling(Coupling):
    """A coupling that makes the second angle turn with ratio times the speed of the first."""

    # first, second: readings, angles of bodies or spindles, as "engine.crank_angle" and
    # "governor.spindle_angle"
    first: str = entry("label", meaning='the first angle, as "engine.crank_angle"')
    second: str = entry("label", meaning='the second angle, as "governor.spindle_angle"')
    # ratio of the second speed to the first; negative for the opposite sense of rotation, not 0
    ratio: float = quantity(
        "number", sign="not zero", built=True, default=1.0, meaning="the speed of the second angle relative to the first"
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, f"coupling {self.name!r}")
        if self.ratio == 0.0:
            raise MechanismError(f"ratio of coupling {self.name!r} must not be 0; leave the coupling out")
        if self.first == self.second:
            raise MechanismError(f"coupling {self.name!r} couples {self.first!r} to itself; it needs two different angles")


@dataclass(frozen=True, kw_only=True)
class GearCoupling(RatioCoupling):
    """A gear or belt: it transmits a torque, which is the force of the joint of this name."""

    # time at which the belt breaks, s; None if it never does
    until: float | None = quantity(
        "time", sign="not negative", default=None, meaning="the time at which the gear lets go; it holds for good by default"
    )


@dataclass(frozen=True, kw_only=True)
class FollowCoupling(RatioCoupling):
    """A spindle that follows the first angle without reaction: the first part feels no torque."""

    first: str = entry("label", meaning='the angle that is followed, as "engine.crank_angle"')
    second: str = entry("label", meaning='the angle of the spindle that follows, as "governor.spindle_angle"')


@dataclass(frozen=True, kw_only=True)
class LoadCoupling(Coupling):
    """The load of an engine: a torque that resists its shaft."""

    # angle of the shaft, as "engine.crank_angle"; the shaft turns so that it grows
    angle: str = entry("label", meaning='the angle of the shaft, as "engine.crank_angle"')
    rated_torque: float = quantity("torque", meaning='the torque at full load, as "700 N m"')  # torque at full load, N m
    # load over time and readings, relative to the rated torque
    fraction: InputFunction = entry(
        "load",
        "ratio",
        sign="not negative",
        reason=": a load resists",
        noun="fraction",
        default=InputFunction(values=(1.0,)),
        meaning="the share of the rated torque, over time or as a function of a reading; full load by default",
    )

    def __post_init__(self) -> None:
        require_valid_fields(self, f"the load {self.name!r}")

    @property
    def moment(self) -> InputFunction:
        """Moment on the shaft, N m."""
        return self.fraction.scaled(-self.rated_torque)


@dataclass(frozen=True, kw_only=True)
class ControlCoupling(Coupling):
    """A load that follows a reading."""

    function: ReadingFunction  # the function of the reading
    # name of the load: a torque or force of a part, the torque on a spindle, a dry friction, or throttle or
    # cut-off of an engine
    target: str
    # whether the load is multiplied by the function, as by a throttle; otherwise the function is added to it
    scales: bool = False
    quantity: str = ""  # quantity of the function that its units imply: "torque", "force" or "ratio"; empty without units

    def apply(self, mechanism: Mechanism, effects: tuple[OutputEffect, ...]) -> tuple[Mechanism, tuple[OutputEffect, ...]]:
        """Return a mechanism and effects in which the load that the control names follows its reading."""
        what = f"coupling {self.name!r} {'scales' if self.scales else 'sets'} {self.target!r}"
        if fixed := next((one for one in mechanism.fixed_loads if one.name == self.target), None):
            raise MechanismError(f"{what}, but {fixed.reason}")
        named = [(name, (owner, field_name)) for name, owner, field_name in _loads(mechanism, effects)]
        loads = dict(named)
        if [name for name, _ in named].count(self.target) > 1:
            raise MechanismError(f"{what} of an engine with a throttle; control one of them, and leave the other out")
        if self.target not in loads:
            known = f"the loads are {list(loads)}.{did_you_mean(self.target, loads)}"
            raise MechanismError(f"{what}, which is no load; {known}")
        owner, field_name = loads[self.target]
        expected = next((quantity for kind, quantity in _LOAD_QUANTITIES.items() if isinstance(owner, kind)), self.quantity)
        if self.quantity not in ("", expected) and not self.scales:
            found = f"is of the kind {expected}, but its function has the units of the kind {self.quantity}"
            raise MechanismError(f"{what}, which {found}; change the units")
        if expected == "ratio":
            self._check_direction(what)
        load: InputFunction = getattr(owner, field_name) or owner.controlled_default()
        if self.scales:
            controlled = replace(load, factors=(*load.factors, self.function))
        else:
            unit = owner.control_unit if isinstance(owner, ForceElement) else 1.0
            controlled = replace(load, functions=(*load.functions, self.function.scaled(unit)))
        changed = replace(owner, **{field_name: controlled})
        elements = tuple(changed if element is owner else element for element in mechanism.force_elements)
        return replace(mechanism, force_elements=elements), tuple(changed if effect is owner else effect for effect in effects)

    def _check_direction(self, what: str) -> None:
        """Raise MechanismError if a throttle or cut-off turns back over the travel of a governor, or opens as that speeds up."""
        reading = self.function.reading
        if isinstance(self.function, TableFunction):
            changes = [later - value for value, later in pairwise(self.function.values)]
            points = list(zip(self.function.positions, self.function.values, strict=True))
            turns = [k for k in range(1, len(changes)) if changes[k - 1] * changes[k] < 0]
            if turns:
                position, value = points[turns[0]]
                found = f"its table turns back at {reading!r} = {position:.6g}, where it is {value:.6g}"
                raise MechanismError(f"{what}, and {found}; a throttle or cut-off needs a table that only falls, or only rises")
            slope = sum(changes)
        else:
            slope = self.function.gain if isinstance(self.function, LinearFunction) else 0.0
        if slope > 0 and reading.rpartition(".")[2] in RISING_READINGS:
            found = f"which opens as the governor speeds up, because {reading!r} rises with its speed"
            raise MechanismError(f"{what}, {found}: with this positive feedback the engine runs away; let the function fall")


RISING_READINGS: Final = ("sleeve_lift", "ball_radius", "arm_angle", "spindle_speed")
"""Readings of a governor that grow with its speed."""

_LOAD_QUANTITIES: Mapping[type[ForceElement], str] = {CylinderGas: "ratio", MeanGasTorque: "ratio", Torque: "torque", Force: "force"}
"""Quantity of the loads of force elements."""


def _loads(mechanism: Mechanism, effects: Sequence[OutputEffect]) -> Iterator[tuple[str, Any, str]]:
    """Yield name, owner and field of each load; several loads of one owner get the name of the field behind."""
    owners: tuple[Any, ...] = (*mechanism.force_elements, *effects)
    for owner in owners:
        part, dot, reading = ("", "", "") if isinstance(owner, ForceElement) else owner.reading.rpartition(".")
        name = owner.name if isinstance(owner, ForceElement) else f"{part}{dot}{owner.key}.{reading}"
        parameters = owner.controlled_parameters if isinstance(owner, ForceElement) else {}
        yield from ((f"{''.join(owner.name.rpartition('.')[:2])}{one}", owner, one_field) for one, one_field in parameters.items())
        names = [one.name for one in fields(owner) if isinstance(getattr(owner, one.name), InputFunction)]
        names = [one for one in names if one not in parameters.values()]
        yield from ((name if len(names) == 1 else f"{name}.{one}", owner, one) for one in names)


def check_gears(
    gears: Sequence[GearCoupling],
    spindle_angles: Sequence[str],
    mechanism: Mechanism,  # mechanism whose readings are the coordinates that a gear can couple
) -> None:
    """Raise MechanismError for a gear on a spindle that is no coordinate, and for gears in a closed loop."""
    readings = {reading.name for reading in mechanism.readings}
    trains: dict[str, tuple[str, float]] = {}  # the first angle of the train of each angle, and the ratio of the angle to it
    for gear in gears:
        for name in (gear.first, gear.second):
            if name in spindle_angles and name not in readings:
                reason = "whose speed is given or follows another part, so that no torque acts on it"
                raise MechanismError(f"gear {gear.name!r} couples {name!r}, {reason}; use type follow, or leave spindle.speed out")
        (first_root, first_ratio), (second_root, second_ratio) = (trains.setdefault(one, (one, 1.0)) for one in (gear.first, gear.second))
        if first_root == second_root:
            through_others = second_ratio / first_ratio
            problem = "is superfluous" if abs(through_others - gear.ratio) <= 1e-12 * abs(gear.ratio) else "contradicts the others"
            found = f"the ratio of {gear.second!r} to {gear.first!r} is {through_others:g}, and here it is {gear.ratio:g}"
            raise MechanismError(f"gear {gear.name!r} closes a loop of gears and {problem}: through the others {found}; leave it out")
        joined = gear.ratio * first_ratio / second_ratio
        trains |= {name: (first_root, ratio * joined) for name, (root, ratio) in trains.items() if root == second_root}


def find_load_sources(mechanism: Mechanism, effects: tuple[OutputEffect, ...]) -> tuple[Mechanism, tuple[OutputEffect, ...]]:
    """Return a mechanism and effects in which each function of a reading knows the reading whose value or rate it takes."""
    speeds = {one.name: one.reading for one in mechanism.derived_readings if isinstance(one, ShaftSpeed)}
    angles = [one.name for one in mechanism.readings if one.name.rpartition(".")[2] == "spindle_angle"]
    speeds |= {f"{name.removesuffix('angle')}speed": name for name in angles}
    if problems := [*_function_problems(mechanism, effects, speeds)]:
        raise MechanismError(*problems)

    def find_source(function: ReadingFunction) -> ReadingFunction:
        return replace(function, source=speeds.get(function.reading, function.reading), is_rate=function.reading in speeds)

    def find_sources(owner: Any) -> Any:
        loads = {one.name: load for one in fields(owner) if isinstance(load := getattr(owner, one.name), InputFunction)}
        changed = {
            name: replace(load, functions=tuple(map(find_source, load.functions)), factors=tuple(map(find_source, load.factors)))
            for name, load in loads.items()
            if load.depends_on_readings
        }
        return replace(owner, **changed) if changed else owner

    elements = tuple(map(find_sources, mechanism.force_elements))
    if any(new is not old for new, old in zip(elements, mechanism.force_elements, strict=True)):
        mechanism = replace(mechanism, force_elements=elements)  # else the same one, with the results that are kept with it
    return mechanism, tuple(map(find_sources, effects))


def _function_problems(mechanism: Mechanism, effects: Sequence[OutputEffect], speeds: Mapping[str, str]) -> Iterator[str]:
    """Yield a sentence for each function of a reading that a load cannot depend on; `speeds` are those that it can."""
    known = [*(reading.name for reading in mechanism.readings), *speeds]
    results = {output.name: output.unit for output in mechanism.derived_readings} | {joint.name: "N" for joint in mechanism.joints}
    loads = [getattr(owner, field_name) for _, owner, field_name in _loads(mechanism, effects)]
    for function in (function for load in loads if load for function in (*load.functions, *load.factors)):
        reading = function.reading
        what, last_word = f"a load depends on {reading!r}", reading.rpartition(".")[2]
        if reading in known:
            found = "angular_speed" if reading in speeds else mechanism.reading(reading).quantity
            if function.quantity not in ("", found):
                hint = f"the units of the kind {function.quantity}; change the units"
                yield f"{what}, which is of the kind {found}, but its function has {hint}"
        elif reading in results or last_word == "spindle_torque":
            kind = " a force," if results.get(reading, "N m") in ("N", "N m") else ""
            yield f"{what},{kind} which follows from the loads: this is an algebraic loop; use a position or a speed"
        elif last_word == "spindle_speed":
            yield f"{what}, but that speed is given or follows another part; use time, or the speed it follows"
        else:
            yield f"{what}, which is no reading; readings are {known}.{did_you_mean(reading, known)}"

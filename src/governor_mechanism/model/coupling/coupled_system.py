"""The parts of a scene as one mechanism: bodies of all parts, free spindles as shafts, gears as joints. No mathematics."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Final

from governor_mechanism.errors import MechanismError, did_you_mean
from governor_mechanism.model.coupling.couplings import (
    ControlCoupling,
    Coupling,
    FollowCoupling,
    GearCoupling,
    LoadCoupling,
    check_gears,
    find_load_sources,
)
from governor_mechanism.model.effect import OutputEffect
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.joints import GROUND, Gear, Point
from governor_mechanism.model.mechanism import Mechanism, SecondMoments, Shaft
from governor_mechanism.model.output_variables import AppliedTorque, BodyAngle, ShaftSpeed
from governor_mechanism.model.part import FreeSpindle, Part, Spindle, Start

SHAFT_NAME: Final = "spindle"
"""Name of the body of a free or coupled spindle."""

SPINDLE_ANGLE: Final = "spindle_angle"
"""Reading of the angle of a free or coupled spindle."""

SPINDLE_SPEED: Final = "spindle_speed"
"""Reading of the speed of any spindle."""

SPINDLE_TORQUE: Final = "spindle_torque"
"""Name of the torque on a free or coupled spindle."""

LOAD_NAME: Final = "load"
"""Name of the load of a scene, and of that of an engine."""

_NAME_FIELDS: Final = frozenset(
    ("name", "body", "reference_body", "carrier", "reading", "spring", "element", "elements", "first", "second", "contact")
)
"""Fields of descriptions that hold the name of a body, a reading or an element, or names of elements."""


_MERGED_FIELDS: Final = (
    "bodies",
    "joints",
    "readings",
    "initial_guess",
    "limits",
    "stall_limits",
    "internal_outputs",
    "force_elements",
    "derived_readings",
    "fixed_loads",
    "notes",
    "points",
    "ends",
    "outlines",
)
"""Fields of a mechanism that are those of all its parts in turn."""


@dataclass(frozen=True, kw_only=True)
class TurningPlane:
    """A plane that turns with a spindle."""

    prefix: str  # start of the names of its part: empty, or "part."
    bodies: tuple[int, ...]  # indices of its bodies in the coupled mechanism
    given_speed: Spindle | None  # spindle with a given speed that the plane turns with, or None
    shaft: str  # name of the body that the plane turns with if the speed is not given
    ratio: float  # ratio of the plane's speed to that of the spindle or body
    has_reaction: bool  # whether the bodies act on the shaft
    is_loaded: bool  # whether the bodies carry centrifugal forces


@dataclass(frozen=True, kw_only=True)
class CoupledSystem:
    """All parts of a scene as one mechanism."""

    mechanism: Mechanism  # bodies, joints, force elements and readings of all parts, with shafts and gears
    output_effects: tuple[OutputEffect, ...]  # effects along readings of the coupled mechanism
    start: Start  # start values and rates of its readings
    planes: tuple[TurningPlane, ...]  # planes that turn with a spindle
    gravity: tuple[float, ...]  # gravitational acceleration of each body, m/s2; shape (bodies,)
    breaking_gears: Mapping[str, float]  # time (s) at which each gear that breaks does so, by name of the joint


def couple_parts(parts: Sequence[Part], couplings: Sequence[Coupling]) -> CoupledSystem:
    """Return the parts of a scene as one mechanism.

    Names of bodies, readings and so on get the name of their part in front if there are several parts.

    Raises MechanismError if a coupling names an unknown reading or load, or couplings contradict one another.
    """
    prefixes = {f"{part.name}." if len(parts) > 1 else "": part for part in parts}
    follows = _follows_by_spindle(prefixes, couplings)
    pieces = [_part_mechanism(part, prefix, prefixes, f"{prefix}{SPINDLE_ANGLE}" in follows) for prefix, part in prefixes.items()]
    mechanism = pieces[0] if len(pieces) == 1 else _merge(pieces)
    start = _start(prefixes)
    gears = [one for one in couplings if isinstance(one, GearCoupling)]
    check_gears(gears, [f"{prefix}{SPINDLE_ANGLE}" for prefix, part in prefixes.items() if part.turns], mechanism)
    if gears:
        mechanism = replace(mechanism, joints=(*mechanism.joints, *(_gear_joint(gear, mechanism, start) for gear in gears)))
    effects = tuple(with_prefix(effect, prefix, prefixes) for prefix, part in prefixes.items() for effect in part.output_effects)
    for load in couplings:
        if isinstance(load, LoadCoupling):
            mechanism = _with_load(mechanism, load)
    for control in couplings:
        if isinstance(control, ControlCoupling):
            mechanism, effects = control.apply(mechanism, effects)
    mechanism, effects = find_load_sources(mechanism, effects)
    gravity = {body.name: part.gravity for part, piece in zip(parts, pieces, strict=True) for body in piece.bodies}
    return CoupledSystem(
        mechanism=mechanism,
        output_effects=effects,
        start=start,
        planes=tuple(_plane(prefix, follows, mechanism, prefixes) for prefix, part in prefixes.items() if part.turns),
        gravity=tuple(gravity[body.name] for body in mechanism.bodies),
        breaking_gears={gear.name: gear.until for gear in gears if gear.until is not None},
    )


def with_prefix(description: Any, prefix: str, prefixes: Iterable[str]) -> Any:
    """Return a description with a prefix before the names of bodies, readings and elements, unless they begin with one of `prefixes`."""
    kept = tuple(prefixes)
    return rename(description, lambda name: name if name == GROUND or name.startswith(kept) else prefix + name) if prefix else description


def rename(description: Any, new_name: Callable[[str], str]) -> Any:
    """Return a description with new names of bodies, readings and elements."""
    if isinstance(description, tuple):
        return tuple(rename(item, new_name) for item in description)
    if not is_dataclass(description) or isinstance(description, type):
        return description
    values = {one.name: getattr(description, one.name) for one in fields(description)}
    names = {name: new_name(value) for name, value in values.items() if name in _NAME_FIELDS and isinstance(value, str)}
    others = {name: rename(value, new_name) for name, value in values.items() if not isinstance(value, str)}
    if "elements" in values:
        others["elements"] = tuple(map(new_name, values["elements"]))
    return replace(description, **others, **names)


def _follows_by_spindle(prefixes: Mapping[str, Part], couplings: Sequence[Coupling]) -> dict[str, FollowCoupling]:
    """Return the couplings of spindles that follow another part, by the angle of the spindle."""
    follows: dict[str, FollowCoupling] = {}
    free = [f"{prefix}{SPINDLE_ANGLE}" for prefix, part in prefixes.items() if isinstance(part.spindle, FreeSpindle)]
    given = [f"{prefix}{SPINDLE_ANGLE}" for prefix, part in prefixes.items() if part.turns and isinstance(part.spindle, Spindle)]
    for coupling in (one for one in couplings if isinstance(one, FollowCoupling)):
        name, driven = coupling.name, coupling.second
        if driven in given:
            cure = "two drives on one coordinate; leave the speed or the coupling out"
            raise MechanismError(f"coupling {name!r} drives {driven!r}, whose speed is given by spindle.speed: {cure}")
        if driven not in free:
            cure = f"its second angle is one of {free}; a gear couples other angles"
            raise MechanismError(f"coupling {name!r} of type follow drives {driven!r}, which is no spindle; {cure}")
        if driven in follows:
            raise MechanismError(f"couplings {follows[driven].name!r} and {name!r} both drive {driven!r}; leave one of them out")
        follows[driven] = coupling
    for driven, coupling in follows.items():
        if coupling.first in follows:
            reason = f"which follows {follows[coupling.first].first!r} itself"
            raise MechanismError(f"coupling {coupling.name!r} follows {coupling.first!r}, {reason}; follow that one")
        if prefixes[driven.removesuffix(SPINDLE_ANGLE)].spindle != FreeSpindle():
            effect = "inertia, start speed and torque of that spindle have no effect: leave them out, or couple it by a gear"
            raise MechanismError(f"coupling {coupling.name!r} gives the speed of {driven!r}; {effect}")
    return follows


def _part_mechanism(part: Part, prefix: str, prefixes: Iterable[str], follows: bool) -> Mechanism:
    """Return the mechanism of a part, renamed, with a shaft for its spindle if that is a coordinate of its own."""
    # Valve events belong to a part alone.
    mechanism: Mechanism = with_prefix(replace(part.mechanism, valve=None) if prefix else part.mechanism, prefix, prefixes)
    if prefix:
        mechanism = replace(mechanism, coordinate=prefix + mechanism.coordinate)
    if not isinstance(part.spindle, FreeSpindle) or follows:
        return mechanism
    moments = SecondMoments(xx=0.5 * part.spindle.inertia, yy=0.5 * part.spindle.inertia)
    shaft = Shaft(name=f"{prefix}{SHAFT_NAME}", second_moments=moments)
    torque = with_prefix(part.spindle.torque, prefix, prefixes)
    angle = BodyAngle(name=f"{prefix}{SPINDLE_ANGLE}", quantity="angle", body=shaft.name)
    return replace(
        mechanism,
        bodies=(*mechanism.bodies, shaft),
        initial_guess=(*mechanism.initial_guess, (0.0, 0.0, 0.0)),
        readings=(*mechanism.readings, angle),
        force_elements=(*mechanism.force_elements, Torque(name=f"{prefix}{SPINDLE_TORQUE}", second=shaft.name, moment=torque)),
    )


def _merge(pieces: Sequence[Mechanism]) -> Mechanism:
    """Return one mechanism of all pieces; it has no leading coordinate."""
    parts: dict[str, Any] = {name: tuple(item for piece in pieces for item in getattr(piece, name)) for name in _MERGED_FIELDS}
    scales = {one.name: piece.length_scale for piece in pieces for one in (*piece.readings, *piece.internal_outputs)}
    return Mechanism(**parts, coordinate="", length_scale=min(piece.length_scale for piece in pieces), reading_scales=scales)


def _gear_joint(gear: GearCoupling, mechanism: Mechanism, start: Start) -> Gear:
    """Return the joint of a gear; where both angles have start values, they are those of the start."""
    first_start, second_start = (start.values.get(name) for name in (gear.first, gear.second))
    offset = second_start - gear.ratio * first_start if isinstance(first_start, float) and isinstance(second_start, float) else 0.0
    first, second = (Point(body=rotating_body(mechanism, gear.name, name)) for name in (gear.first, gear.second))
    return Gear(name=gear.name, first=first, second=second, ratio=gear.ratio, offset=offset)


def _with_load(mechanism: Mechanism, load: LoadCoupling) -> Mechanism:
    """Return the mechanism with a load on a shaft; it counts as the load torque of the part of the shaft."""
    part = load.angle.rpartition(".")[0]
    own = next((one for one in mechanism.force_elements if one.name == f"{part}.{LOAD_NAME}" and isinstance(one, Torque)), None)
    if own is not None and any(own.moment.values):
        found = f"part {part!r} has a load of its own, {abs(own.moment.values[0]):.6g} N m"
        cure = f"write load_torque = 0 in [part.{part}.dimensions], or leave [load] out"
        raise MechanismError(f"[load] acts on {load.angle!r}, but {found}; {cure}")
    shaft = rotating_body(mechanism, load.name, load.angle)
    reading = f"{part}.load_torque"
    resistance = AppliedTorque(name=reading, reading=load.angle, elements=(load.name,), sign=-1.0)
    own_reading = next((one for one in mechanism.derived_readings if isinstance(one, AppliedTorque) and one.name == reading), None)
    if own_reading:
        resistance = replace(own_reading, elements=(*own_reading.elements, load.name))
    others = tuple(one for one in mechanism.derived_readings if one is not own_reading)
    torque = Torque(name=load.name, second=shaft, moment=load.moment)
    return replace(mechanism, force_elements=(*mechanism.force_elements, torque), derived_readings=(*others, resistance))


def rotating_body(mechanism: Mechanism, coupling: str, name: str) -> str:
    """Return the body whose angle is a reading; raise MechanismError if it is not the angle of one body."""
    angles = {one.name: one.body for one in mechanism.readings if isinstance(one, BodyAngle) and one.reference_body == GROUND}
    if name not in angles:
        known = [reading.name for reading in mechanism.readings]
        what = "is not the angle of a body relative to the ground" if name in known else "is unknown"
        raise MechanismError(f"{name!r} in coupling {coupling!r} {what}; such angles are {list(angles)}.{did_you_mean(name, list(angles))}")
    return angles[name]


def _start(prefixes: Mapping[str, Part]) -> Start:
    """Return the start values and rates of all parts."""
    values = {prefix + name: value for prefix, part in prefixes.items() for name, value in part.start.values.items()}
    rates = {prefix + name: rate for prefix, part in prefixes.items() for name, rate in part.start.rates.items()}
    for prefix, part in prefixes.items():
        if isinstance(part.spindle, FreeSpindle) and part.spindle.start_speed is not None:
            rates[f"{prefix}{SPINDLE_ANGLE}"] = part.spindle.start_speed
    return Start(values=values, rates=rates)


def _plane(prefix: str, follows: Mapping[str, FollowCoupling], mechanism: Mechanism, prefixes: Mapping[str, Part]) -> TurningPlane:
    """Return the turning plane of a part."""
    part = prefixes[prefix]
    coupling = follows.get(f"{prefix}{SPINDLE_ANGLE}")
    leader = prefixes.get(coupling.first.removesuffix(SPINDLE_ANGLE)) if coupling else part
    given_speed = leader.spindle if leader and isinstance(leader.spindle, Spindle) else None
    own_shaft = f"{prefix}{SHAFT_NAME}"
    shaft = "" if given_speed else rotating_body(mechanism, coupling.name, coupling.first) if coupling else own_shaft
    return TurningPlane(
        prefix=prefix,
        bodies=tuple(mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies),
        given_speed=given_speed,
        shaft=shaft,
        ratio=coupling.ratio if coupling else 1.0,
        has_reaction=bool(shaft) and coupling is None,
        is_loaded=part.has_centrifugal,
    )


GIVEN_SPEED_CLAUSE: Final = (
    "a speed that is given: when it passes a value is known before the run; watch the speed of a free or geared spindle, or another reading"
)
"""End of the sentence about a crossing of a given speed."""


@dataclass(frozen=True, kw_only=True)
class AngleRate:
    """A speed as a multiple of the rate of an angle."""

    angle: str  # reading of the angle
    ratio: float = 1.0  # ratio of the speed to the rate of the angle; not 1 for a spindle that follows another shaft


def find_speeds(system: CoupledSystem) -> dict[str, AngleRate]:
    """Return of what the speeds of shafts and spindles are the rates, by name, but for speeds that are given."""
    mechanism = system.mechanism
    speeds = {one.name: AngleRate(angle=one.reading) for one in mechanism.derived_readings if isinstance(one, ShaftSpeed)}
    angles = {one.body: one.name for one in mechanism.readings if isinstance(one, BodyAngle) and one.reference_body == GROUND}
    spindles = {plane.prefix: plane for plane in system.planes if plane.shaft in angles}
    return speeds | {
        f"{prefix}{SPINDLE_SPEED}": AngleRate(angle=angles[plane.shaft], ratio=plane.ratio) for prefix, plane in spindles.items()
    }


def check_crossings(system: CoupledSystem, crossings: Sequence[NamedCrossing]) -> None:
    """Raise MechanismError for a crossing of what is no reading, or of a speed that is given."""
    speeds = find_speeds(system)
    readings = [reading.name for reading in system.mechanism.readings]
    outputs = [*readings, *(output.name for output in system.mechanism.internal_outputs), *speeds]
    given_speeds = {f"{plane.prefix}{SPINDLE_SPEED}" for plane in system.planes} - set(speeds)
    problems = []
    for crossing in crossings:
        what = f"crossing {crossing.name!r}"
        name = crossing.reading
        known = [*readings, *speeds]
        if name in given_speeds:
            problems.append(f"{what} watches {name!r}, {GIVEN_SPEED_CLAUSE}")
        elif name not in outputs:
            problems.append(f"{what}: no reading {name!r}; readings are {known}.{did_you_mean(name, known)}")
    if problems:
        raise MechanismError(*problems)

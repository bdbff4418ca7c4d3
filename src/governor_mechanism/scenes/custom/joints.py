"""The joints, forces and readings of a user's own mechanism, from what their tables mean."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.custom import InitialConfiguration, SketchedBody
from governor_mechanism.model.force_elements import Damper, Force, ForceElement, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    Gear,
    Joint,
    Pin,
    Point,
    Prismatic,
    RackAndPinion,
    RotationalDriver,
    Slider,
    TranslationalDriver,
    Weld,
)
from governor_mechanism.model.output_variables import BodyAngle, LineAngle, PointCoordinate, PointDistance, Reading
from governor_mechanism.model.time_functions import InputFunction, PrescribedMotion
from governor_mechanism.scenes.custom.bodies import PointRegistry, evaluate_all

ParsedTable = Mapping[str, Any]


def _value_or_default(parsed: ParsedTable, key: str, default: float) -> float:
    return float(parsed[key]) if key in parsed else default


def _make_pin(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    return Pin(name=name, first=first, second=second)


def _make_weld(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    return Weld(
        name=name,
        first=first,
        second=second,
        relative_angle=_value_or_default(parsed, "turn", initial_layout.relative_angle(first, second)),
    )


def _make_slider(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    return Slider(name=name, first=first, second=second, angle=parsed["angle"])


def _make_prismatic(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    turn = _value_or_default(parsed, "turn", initial_layout.relative_angle(first, second))
    return Prismatic(name=name, first=first, second=second, angle=parsed["angle"], relative_angle=turn)


def _make_arc_slot(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    return ArcSlot(name=name, first=first, second=second, radius=parsed["radius"])


def _make_curve_slot(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    return CurveSlot(name=name, first=first, second=second, curve=parsed["curve"], angle=parsed.get("angle", 0.0))


def _make_gear(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    ratio = parsed["ratio"]
    offset = _value_or_default(parsed, "offset", initial_layout.relative_angle(first, second, ratio))
    return Gear(name=name, first=first, second=second, ratio=ratio, offset=offset)


def _make_rack(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    first, second = registry.find_two_points(parsed)
    radius, angle = parsed["radius"], parsed.get("angle", 0.0)
    default_offset = initial_layout.displacement_along(first, second, angle) - radius * initial_layout.poses[first.body][2]
    offset = _value_or_default(parsed, "offset", default_offset)
    return RackAndPinion(name=name, first=first, second=second, radius=radius, angle=angle, offset=offset)


def _make_driven_turn(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    (first, second), _ = evaluate_all(lambda: registry.find_two_points(parsed), lambda: _check_drive_keys(parsed, example))
    return RotationalDriver(
        name=name, first=first, second=second, motion=_make_motion(parsed, initial_layout.relative_angle(first, second))
    )


def _make_driven_slide(parsed: ParsedTable, name: str, registry: PointRegistry, initial_layout: InitialConfiguration) -> Joint:
    example = 'rate = "50 mm/s", or motion = [[0, "0 mm"], [1, "50 mm"]]'
    (first, second), _ = evaluate_all(lambda: registry.find_two_points(parsed), lambda: _check_drive_keys(parsed, example))
    angle = parsed["angle"]
    motion = _make_motion(parsed, initial_layout.displacement_along(first, second, angle, first.body))
    return TranslationalDriver(name=name, first=first, second=second, angle=angle, motion=motion)


def _check_drive_keys(parsed: ParsedTable, example: str) -> None:
    conflicting_keys = [key for key in ("rate", "start") if key in parsed]
    if "motion" in parsed and conflicting_keys:
        raise MechanismError(f"{' and '.join(conflicting_keys)} cannot stand beside motion, which tells the whole way")
    if "motion" not in parsed and "rate" not in parsed:
        raise MechanismError(f"rate or motion is missing; write {example}")


def _make_motion(parsed: ParsedTable, default_start: float) -> PrescribedMotion:
    if "motion" in parsed:
        motion: PrescribedMotion = parsed["motion"]
        return motion
    return PrescribedMotion.constant_rate(_value_or_default(parsed, "start", default_start), parsed["rate"])


JOINT_FACTORIES: Final[Mapping[str, Callable[[ParsedTable, str, PointRegistry, InitialConfiguration], Joint]]] = {
    "pin": _make_pin,
    "weld": _make_weld,
    "prismatic": _make_prismatic,
    "slider": _make_slider,
    "arc": _make_arc_slot,
    "curve": _make_curve_slot,
    "gear": _make_gear,
    "rack": _make_rack,
    "driven_turn": _make_driven_turn,
    "driven_slide": _make_driven_slide,
}
"""How each type of joint is made."""


def _make_spring(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    first, second = registry.find_two_points(parsed)
    free_length = parsed.get("free_length", 0.0)
    return Spring(name=name, first=first, second=second, stiffness=parsed["stiffness"], free_length=free_length)


def _make_damper(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    first, second = registry.find_two_points(parsed)
    return Damper(name=name, first=first, second=second, damping=parsed["damping"])


def _make_torsion_spring(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    first, second = registry.require_two_bodies(parsed.get("first", GROUND), parsed["second"])
    free_angle = parsed.get("free_angle", 0.0)
    return TorsionSpring(name=name, first=first, second=second, stiffness=parsed["stiffness"], free_angle=free_angle)


def _make_torsion_damper(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    first, second = registry.require_two_bodies(parsed.get("first", GROUND), parsed["second"])
    return TorsionDamper(name=name, first=first, second=second, damping=parsed["damping"])


def _make_torque(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    first, second = registry.require_two_bodies(parsed.get("against", GROUND), parsed["body"], ("against", "body"))
    return Torque(name=name, first=first, second=second, moment=parsed["moment"])


def _make_force(parsed: ParsedTable, name: str, registry: PointRegistry) -> ForceElement:
    def require_component() -> None:
        if "x" not in parsed and "y" not in parsed:
            raise MechanismError('x or y is missing; write x = "40 N" for a force along x')

    point, _ = evaluate_all(lambda: registry.find_point(parsed["point"], "point"), require_component)
    if point.body == GROUND:
        raise MechanismError("point must be of a moving body; a force on the ground moves nothing")
    return Force(name=name, point=point, x=parsed.get("x", InputFunction()), y=parsed.get("y", InputFunction()))


FORCE_FACTORIES: Final[Mapping[str, Callable[[ParsedTable, str, PointRegistry], ForceElement]]] = {
    "spring": _make_spring,
    "damper": _make_damper,
    "torsion_spring": _make_torsion_spring,
    "torsion_damper": _make_torsion_damper,
    "torque": _make_torque,
    "force": _make_force,
}
"""How each type of force is made."""


def find_connected_bodies(parsed: ParsedTable) -> tuple[str, str]:
    """The two bodies that a joint or force is of, for a name."""
    if "point" in parsed:
        return GROUND, parsed["point"].body
    ends = (parsed.get("first", parsed.get("against", GROUND)), parsed.get("second", parsed.get("body", "")))
    first, second = (str(getattr(end, "body", end)) for end in ends)
    return first, second


def make_custom_reading(kind: str, parsed: ParsedTable, name: str, registry: PointRegistry) -> Reading:
    """The reading of a kind."""
    if kind == "angle":
        against, body = evaluate_all(
            lambda: registry.require_body(parsed.get("against", GROUND), "against"), lambda: registry.require_body(parsed["angle"], "angle")
        )
        if body in (against, GROUND):
            raise MechanismError("angle must name a moving body, and against another one, or the ground")
        return BodyAngle(name=name, quantity="angle", body=body, reference_body=against)
    if kind in ("line", "distance"):
        ends = parsed[kind]
        first, second = evaluate_all(lambda: registry.find_point(ends[0], kind), lambda: registry.find_point(ends[1], kind))
        if first == second:
            raise MechanismError(f"{kind} needs two different points")
        if kind == "distance":
            return PointDistance(name=name, quantity="length", first=first, second=second)
        # Counted from +x instead of from the downward vertical.
        return LineAngle(name=name, quantity="angle", start=first, end=second, zero=math.pi / 2)
    point, origin = evaluate_all(
        lambda: registry.find_point(parsed[kind], kind),
        lambda: registry.find_point(parsed["from"], "from") if "from" in parsed else Point(body=GROUND),
    )
    return _make_coordinate(name, point, kind, origin)


def _make_coordinate(name: str, point: Point, axis: str, origin: Point) -> PointCoordinate:
    along_x, along_y = (1.0, 0.0) if axis == "x" else (0.0, 1.0)
    return PointCoordinate(name=name, quantity="length", point=point, direction_x=along_x, direction_y=along_y, origin=origin)


def make_default_readings(bodies: Iterable[SketchedBody]) -> list[Reading]:
    """What can be said of any mechanism: the angle of each body that turns, the place of each other one."""
    readings: list[Reading] = []
    for body in bodies:
        base_name = re.sub(r"\W+", "_", body.name).strip("_") or "body"
        base_name = base_name if base_name.isidentifier() else f"body_{base_name}"
        used_names = {reading.name.rpartition("_")[0] for reading in readings}
        number, name = 1, base_name
        while name in used_names:
            number += 1
            name = f"{base_name}_{number}"
        if body.can_rotate:
            readings.append(BodyAngle(name=f"{name}_angle", quantity="angle", body=body.name))
        else:
            centre = Point(body=body.name)
            readings += [_make_coordinate(f"{name}_{axis}", centre, axis, Point(body=GROUND)) for axis in ("x", "y")]
    return readings

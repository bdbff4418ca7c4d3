"""The joints, forces and readings of a user's own mechanism, from what their tables mean."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any, Final

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.custom import Sketch, Sketched
from governor_mechanism.model.force_elements import Damper, Force, Load, Spring, Torque, TorsionDamper, TorsionSpring
from governor_mechanism.model.joints import (
    GROUND,
    ArcSlot,
    CurveSlot,
    DrivenSlide,
    DrivenTurn,
    Gear,
    Joint,
    Pin,
    Point,
    Prismatic,
    Rack,
    Slider,
    Weld,
)
from governor_mechanism.model.mechanism import BodyAngle, Coordinate, LineAngle, Reading, Separation
from governor_mechanism.model.time_functions import Motion, Program
from governor_mechanism.scenes.custom.bodies import Places, gathered

Meaning = Mapping[str, Any]


def _given(meaning: Meaning, key: str, otherwise: float) -> float:
    return float(meaning[key]) if key in meaning else otherwise


def _pin(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    return Pin(name=name, first=first, second=second)


def _weld(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    return Weld(name=name, first=first, second=second, turn=_given(meaning, "turn", sketch.turn(first, second)))


def _slider(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    return Slider(name=name, first=first, second=second, angle=meaning["angle"])


def _prismatic(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    turn = _given(meaning, "turn", sketch.turn(first, second))
    return Prismatic(name=name, first=first, second=second, angle=meaning["angle"], turn=turn)


def _arc(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    return ArcSlot(name=name, first=first, second=second, radius=meaning["radius"])


def _curve(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    return CurveSlot(name=name, first=first, second=second, curve=meaning["curve"], angle=meaning.get("angle", 0.0))


def _gear(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    ratio = meaning["ratio"]
    offset = _given(meaning, "offset", sketch.turn(first, second, ratio))
    return Gear(name=name, first=first, second=second, ratio=ratio, offset=offset)


def _rack(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    first, second = places.two(meaning)
    radius, angle = meaning["radius"], meaning.get("angle", 0.0)
    fits = sketch.way(first, second, angle) - radius * sketch.poses[first.body][2]
    offset = _given(meaning, "offset", fits)
    return Rack(name=name, first=first, second=second, radius=radius, angle=angle, offset=offset)


def _driven_turn(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    example = 'rate = "120 rpm", or motion = [[0, "0 deg"], [1, "90 deg"]]'
    (first, second), _ = gathered(lambda: places.two(meaning), lambda: _refuse_drive(meaning, example))
    return DrivenTurn(name=name, first=first, second=second, motion=_motion(meaning, sketch.turn(first, second)))


def _driven_slide(meaning: Meaning, name: str, places: Places, sketch: Sketch) -> Joint:
    example = 'rate = "50 mm/s", or motion = [[0, "0 mm"], [1, "50 mm"]]'
    (first, second), _ = gathered(lambda: places.two(meaning), lambda: _refuse_drive(meaning, example))
    angle = meaning["angle"]
    motion = _motion(meaning, sketch.way(first, second, angle, first.body))
    return DrivenSlide(name=name, first=first, second=second, angle=angle, motion=motion)


def _refuse_drive(meaning: Meaning, example: str) -> None:
    beside = [key for key in ("rate", "start") if key in meaning]
    if "motion" in meaning and beside:
        raise MechanismError(f"{' and '.join(beside)} cannot stand beside motion, which tells the whole way")
    if "motion" not in meaning and "rate" not in meaning:
        raise MechanismError(f"rate or motion is missing; write {example}")


def _motion(meaning: Meaning, start: float) -> Motion:
    if "motion" in meaning:
        found: Motion = meaning["motion"]
        return found
    return Motion.steady(_given(meaning, "start", start), meaning["rate"])


JOINT_MAKERS: Final[Mapping[str, Callable[[Meaning, str, Places, Sketch], Joint]]] = {
    "pin": _pin,
    "weld": _weld,
    "prismatic": _prismatic,
    "slider": _slider,
    "arc": _arc,
    "curve": _curve,
    "gear": _gear,
    "rack": _rack,
    "driven_turn": _driven_turn,
    "driven_slide": _driven_slide,
}
"""How each type of joint is made."""


def _spring(meaning: Meaning, name: str, places: Places) -> Load:
    first, second = places.two(meaning)
    free = meaning.get("free_length", 0.0)
    return Spring(name=name, first=first, second=second, stiffness=meaning["stiffness"], free_length=free)


def _damper(meaning: Meaning, name: str, places: Places) -> Load:
    first, second = places.two(meaning)
    return Damper(name=name, first=first, second=second, damping=meaning["damping"])


def _torsion_spring(meaning: Meaning, name: str, places: Places) -> Load:
    first, second = places.two_bodies(meaning.get("first", GROUND), meaning["second"])
    free = meaning.get("free_angle", 0.0)
    return TorsionSpring(name=name, first=first, second=second, stiffness=meaning["stiffness"], free_angle=free)


def _torsion_damper(meaning: Meaning, name: str, places: Places) -> Load:
    first, second = places.two_bodies(meaning.get("first", GROUND), meaning["second"])
    return TorsionDamper(name=name, first=first, second=second, damping=meaning["damping"])


def _torque(meaning: Meaning, name: str, places: Places) -> Load:
    first, second = places.two_bodies(meaning.get("against", GROUND), meaning["body"], ("against", "body"))
    return Torque(name=name, first=first, second=second, moment=meaning["moment"])


def _force(meaning: Meaning, name: str, places: Places) -> Load:
    def parts() -> None:
        if "x" not in meaning and "y" not in meaning:
            raise MechanismError('x or y is missing; write x = "40 N" for a force along x')

    point, _ = gathered(lambda: places.point(meaning["point"], "point"), parts)
    if point.body == GROUND:
        raise MechanismError("point must be of a moving body; a force on the ground moves nothing")
    return Force(name=name, point=point, x=meaning.get("x", Program()), y=meaning.get("y", Program()))


FORCE_MAKERS: Final[Mapping[str, Callable[[Meaning, str, Places], Load]]] = {
    "spring": _spring,
    "damper": _damper,
    "torsion_spring": _torsion_spring,
    "torsion_damper": _torsion_damper,
    "torque": _torque,
    "force": _force,
}
"""How each type of force is made."""


def bodies_named(meaning: Meaning) -> tuple[str, str]:
    """The two bodies that a joint or force is of, for a name."""
    if "point" in meaning:
        return GROUND, meaning["point"].body
    ends = (meaning.get("first", meaning.get("against", GROUND)), meaning.get("second", meaning.get("body", "")))
    first, second = (str(getattr(end, "body", end)) for end in ends)
    return first, second


def reading_of(kind: str, meaning: Meaning, name: str, places: Places) -> Reading:
    """The reading of a kind."""
    if kind == "angle":
        against, body = gathered(
            lambda: places.body(meaning.get("against", GROUND), "against"),
            lambda: places.body(meaning["angle"], "angle"),
        )
        if body in (against, GROUND):
            raise MechanismError("angle must name a moving body, and against another one, or the ground")
        return BodyAngle(name=name, quantity="angle", body=body, against=against)
    if kind in ("line", "distance"):
        ends = meaning[kind]
        first, second = gathered(lambda: places.point(ends[0], kind), lambda: places.point(ends[1], kind))
        if first == second:
            raise MechanismError(f"{kind} needs two different points")
        if kind == "distance":
            return Separation(name=name, quantity="length", first=first, second=second)
        # Counted from +x instead of from the downward vertical.
        return LineAngle(name=name, quantity="angle", start=first, end=second, zero=math.pi / 2)
    point, origin = gathered(
        lambda: places.point(meaning[kind], kind),
        lambda: places.point(meaning["from"], "from") if "from" in meaning else Point(body=GROUND),
    )
    return _coordinate(name, point, kind, origin)


def _coordinate(name: str, point: Point, axis: str, origin: Point) -> Coordinate:
    along_x, along_y = (1.0, 0.0) if axis == "x" else (0.0, 1.0)
    return Coordinate(name=name, quantity="length", point=point, along_x=along_x, along_y=along_y, origin=origin)


def default_readings(bodies: Iterable[Sketched]) -> list[Reading]:
    """What can be said of any mechanism: the angle of each body that turns, the place of each other one."""
    found: list[Reading] = []
    for body in bodies:
        plain = re.sub(r"\W+", "_", body.name).strip("_") or "body"
        plain = plain if plain.isidentifier() else f"body_{plain}"
        taken = {reading.name.rpartition("_")[0] for reading in found}
        number, name = 1, plain
        while name in taken:
            number += 1
            name = f"{plain}_{number}"
        if body.turns:
            found.append(BodyAngle(name=f"{name}_angle", quantity="angle", body=body.name))
        else:
            centre = Point(body=body.name)
            found += [_coordinate(f"{name}_{axis}", centre, axis, Point(body=GROUND)) for axis in ("x", "y")]
    return found

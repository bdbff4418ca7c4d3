"""What a scene's effects hang on a pendulum governor: stops, springs, brakes and what rubs.

Everything here is drawn only where the scene lists it. Effects on the ball's radius are shown on the arms.
"""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.outlines import band, wall
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Polygon, Shape, bar, rectangle
from governor_mechanism.render.machines.pendulum.proportions import (
    SPINDLE,
    Governor,
    Side,
    arm_angles,
    sides_of,
    sleeve_height,
)
from governor_mechanism.render.machines.pendulum.stops import (
    COLLAR,
    GLAND,
    LIFT,
    SWING,
    arm_stops,
    blows,
    collars,
    over_lugs,
    sits_above,
    sleeve_stops,
    under,
)
from governor_mechanism.types import FloatArray

# As fractions of the arm.
SHOE = 0.060
"""width of the shoes under the sleeve"""
CYLINDER, BESIDE = 0.075, 0.16
"""half width of the dashpot, and how far its middle stands beside the sleeve"""
COILS = 7


def foot_room(governor: Governor, heights: Pair) -> float:
    """From the low end of the load to the spindle's foot (m), where the lugs stand between two heights (m)."""
    u, gland = governor.arm, under(governor) - governor.load[1]
    room = 0.10 * u + gland
    stops, spring = governor.acting.on(Stops, LIFT), governor.acting.on(SpringOn, LIFT)
    if stops and math.isfinite(stops.low):
        room = max(room, heights[0] - (governor.zero + stops.low) + gland + (COLLAR + 0.05) * u)
    if spring and not sits_above(governor, spring):
        room = max(room + 0.12 * u, gland + max(0.30 * u, 0.5 * (heights[1] - heights[0])))
    return room


def still_fittings(governor: Governor) -> tuple[Shape, ...]:
    """What is fixed to the frame: blocks that stop arms and sleeve, the spring's seat, the dashpot's cylinder."""
    return (*arm_stops(governor), *sleeve_stops(governor), *_seat(governor), *_cylinder(governor))


def moving_fittings(
    governor: Governor, part: Part, pose: FloatArray, time: float
) -> tuple[tuple[Shape, ...], tuple[Shape, ...]]:
    """What moves with the governor at a pose (bodies, 3) and a time (s): behind it, and in front of it."""
    height = float(sleeve_height(governor, part, pose))
    angle = float(arm_angles(governor, part, pose))
    sides = sides_of(governor, part, pose)
    behind = (*_piston(governor, height), *_sleeve_spring(governor, height), *_gland(governor, height, time))
    front = (
        *_ball_spring(governor, sides),
        *_spirals(governor, angle),
        *_drums(governor, sides),
        *_arm_shoes(governor, time),
        *blows(governor, time),
    )
    return behind, front


def _heights(governor: Governor) -> Pair:
    """Between what heights the lugs move over the run (m)."""
    low, high = governor.acting.ranges.get(LIFT, (0.0, 0.0))
    return governor.zero + low, governor.zero + high


def _spring_seat(governor: Governor) -> tuple[float, float] | None:
    """The height of the fixed end of the sleeve's spring (m), and the half width of its coils (m)."""
    spring = governor.acting.on(SpringOn, LIFT)
    if spring is None:
        return None
    u = governor.arm
    low, high = _heights(governor)
    if not sits_above(governor, spring):
        return low - governor.load[1] - foot_room(governor, (low, high)), 0.105 * u
    over, half = over_lugs(governor)
    seat = high + over + max(0.24 * u, 0.4 * (high - low))
    seat = max([seat, *(top + 0.05 * u for is_low, (_, _, _, top) in collars(governor) if not is_low)])
    return max(min(seat, -0.085 * u), high + over + 0.04 * u), min(half, 0.085 * u)


def _seat(governor: Governor) -> list[Shape]:
    """A disc on the spindle for the spring to rest against."""
    found, u = _spring_seat(governor), governor.arm
    if found is None:
        return []
    y, half = found
    spring = governor.acting.on(SpringOn, LIFT)
    up = 0.03 * u if spring and sits_above(governor, spring) else -0.03 * u
    return [rectangle("seat", -half - 0.02 * u, half + 0.02 * u, min(y, y + up), max(y, y + up))]


def _sleeve_spring(governor: Governor, height: float) -> list[Shape]:
    """A helical spring round the spindle, between its seat and the sleeve."""
    found, spring = _spring_seat(governor), governor.acting.on(SpringOn, LIFT)
    if found is None or spring is None:
        return []
    y, half = found
    end = height + over_lugs(governor)[0] if sits_above(governor, spring) else height - governor.load[1]
    return [Lines("spring", helix((0.0, min(y, end)), (0.0, max(y, end)), half, SPINDLE * governor.arm))]


def helix(start: Pair, end: Pair, half: float, hidden: float) -> tuple[tuple[Pair, ...], ...]:
    """A helical spring of half width `half` (m) from the side; its back is hidden within `hidden` (m) of the axis."""
    length, pieces = math.dist(start, end), 16 * COILS
    c, s = ((end[0] - start[0]) / length, (end[1] - start[1]) / length) if length > 0 else (0.0, 1.0)
    chains: list[list[Pair]] = [[]]
    for k in range(pieces + 1):
        turn = 2 * math.pi * COILS * k / pieces
        across, along = half * math.cos(turn), length * k / pieces
        if math.sin(turn) < -1e-9 and abs(across) < hidden:
            if chains[-1]:
                chains.append([])
            continue
        chains[-1].append((start[0] + along * c + across * s, start[1] + along * s - across * c))
    return tuple(tuple(chain) for chain in chains if len(chain) > 1)


def _cylinder_box(governor: Governor) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the dashpot (m), long enough for the whole way of its piston."""
    u, (low, high) = governor.arm, _heights(governor)
    x = -(governor.load[0] + BESIDE * u)
    top = low - governor.load[1] - 0.06 * u
    return x - CYLINDER * u, x + CYLINDER * u, top - max(high - low + 0.20 * u, 0.26 * u), top


def _cylinder(governor: Governor) -> list[Shape]:
    """An open cylinder full of oil on a hatched footing, beside the sleeve."""
    if not governor.acting.on(OilBrake, LIFT):
        return []
    u, (left, right, bottom, top) = governor.arm, _cylinder_box(governor)
    thick = 0.016 * u
    return [
        rectangle("dashpot", left, right, bottom, top),
        rectangle("bore", left + thick, right - thick, bottom + thick, top),
        rectangle("oil", left + thick, right - thick, bottom + thick, top - 0.035 * u),
        wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * CYLINDER * u, 0.035 * u),
    ]


def _piston(governor: Governor, height: float) -> list[Shape]:
    """The dashpot's piston, its rod, and the bracket by which the sleeve at a height (m) moves it."""
    if not governor.acting.on(OilBrake, LIFT):
        return []
    u, (left, right, bottom, _) = governor.arm, _cylinder_box(governor)
    x, base = (left + right) / 2, height - governor.load[1]
    piston = bottom + 0.05 * u + height - _heights(governor)[0]
    thick = 0.022 * u
    return [
        rectangle("piston rod", x - 0.013 * u, x + 0.013 * u, piston, base + 0.035 * u),
        rectangle("piston", left + thick, right - thick, piston, piston + 0.035 * u),
        bar("piston rod", (x, base + 0.035 * u), (-0.9 * governor.load[0], base + 0.035 * u), 0.036 * u),
    ]


def _gland(governor: Governor, height: float, time: float) -> list[Shape]:
    """Shoes under the sleeve that rub on the spindle."""
    if not governor.acting.on(DryFriction, LIFT):
        return []
    u, base = governor.arm, height - governor.load[1]
    inner, outer = SPINDLE * u, (SPINDLE + SHOE) * u
    return _shoes(
        governor, LIFT, time, [rectangle("shoe", x, x + outer - inner, base - GLAND * u, base) for x in (-outer, inner)]
    )


def _arm_shoes(governor: Governor, time: float) -> list[Shape]:
    """A shoe over the pin of each arm."""
    friction = governor.acting.on(DryFriction, *SWING)
    if friction is None:
        return []
    u, shoes = governor.arm, []
    for x in (-governor.offset, governor.offset):
        angles = [math.radians(30 + 120 * k / 10) for k in range(11)]
        arc = [(x + 0.075 * u * math.cos(a), 0.075 * u * math.sin(a)) for a in angles]
        shoes.append(band("shoe", arc, 0.040 * u))
    return _shoes(governor, friction.reading, time, shoes)


def _shoes(governor: Governor, reading: str, time: float, shoes: list[Polygon]) -> list[Shape]:
    """The shoes in the colour of what rubs, or of what is held; the others have no outline."""
    held = governor.acting.sticks(reading, time)
    return [
        Polygon(role, shoe.points if shown else ())
        for role, shown in (("shoe", not held), ("held shoe", held))
        for shoe in shoes
    ]


def _drums(governor: Governor, sides: list[Side]) -> list[Shape]:
    """A small rotary damper on each arm's pin, its vane along the arm."""
    if not governor.acting.on(OilBrake, *SWING):
        return []
    u, shapes = governor.arm, list[Shape]()
    for side in sides:
        dx, dy = ((side.ball[k] - side.top[k]) / governor.arm * 0.055 * u for k in (0, 1))
        (x, y) = side.top
        shapes.append(Circle("drum", x, y, 0.055 * u))
        shapes.append(Lines("damper", (((x - dy, y + dx), (x + dy, y - dx)),)))
        shapes.append(Circle("pivot", x, y, 0.016 * u))
    return shapes


def _spirals(governor: Governor, angle: float) -> list[Shape]:
    """A spiral spring round each arm's pin, wound by the arm."""
    if not governor.acting.on(SpringOn, SWING[0]):
        return []
    u, shapes = governor.arm, list[Shape]()
    sweep = 5 * math.pi - angle
    for sign in (-1.0, 1.0):
        spots = []
        for k in range(73):
            turn, radius = 2.2 - sweep * (1 - k / 72), (0.03 + 0.07 * k / 72) * u
            spots.append((sign * (governor.offset + radius * math.cos(turn)), radius * math.sin(turn)))
        shapes.append(Lines("spring", (tuple(spots),)))
    return shapes


def _ball_spring(governor: Governor, sides: list[Side]) -> list[Shape]:
    """A spring from ball to ball."""
    if not governor.acting.on(SpringOn, SWING[1]):
        return []
    (left, y), (right, _) = (side.ball for side in sides)
    ends = (left + governor.ball, y), (right - governor.ball, y)
    return [Lines("spring", helix(*ends, 0.06 * governor.arm, 0.0))]

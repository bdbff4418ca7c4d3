"""What a scene's effects hang on a Hartung governor: stops of its weights, an oil brake, a spring, what rubs."""

from __future__ import annotations

import math

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import block, burst, wall
from governor_mechanism.render.geometry.primitives import Lines, Pair, Polygon, Shape, bar, rectangle
from governor_mechanism.render.machines.hartung.proportions import SPINDLE, Governor, Side
from governor_mechanism.render.machines.pendulum.effects import helix

LIFT = "sleeve_lift"
SWING = ("lever_angle", "weight_radius")
"""The readings that the weights show."""

# As fractions of the weights' arm.
CYLINDER, BESIDE = 0.24, 0.50
"""half width of the dashpot, and how far its middle stands beside the sleeve"""
BLOCK = 0.16
"""Half height of the stops that weights meet."""
SHOE = 0.20


def undermost(governor: Governor, lowest: float) -> float:
    """Where the spindle's lower collar stands (m), with the sleeve's lugs lowest at a height (m)."""
    u, room = governor.arm, 0.14 * governor.arm
    if governor.acting.on(DryFriction, LIFT):
        room += SHOE * u
    if governor.acting.on(SpringOn, LIFT):
        room += 0.9 * u
    return lowest - governor.load[1] - room


def still_fittings(governor: Governor, heights: Pair) -> list[Shape]:
    """What is fixed to the frame: blocks that stop the weights, the dashpot's cylinder, the spring's seat."""
    return [*_weight_stops(governor), *_cylinder(governor, heights), *_seat(governor, heights[0])]


def moving_fittings(governor: Governor, height: float, time: float) -> list[Shape]:
    """What moves with the sleeve, whose lugs stand at a height (m), at a time (s)."""
    return [*_piston(governor, height), *_spring(governor, height), *_shoes(governor, height, time)]


def blows(governor: Governor, sides: list[Side], time: float) -> list[Shape]:
    """Rays where a weight has just struck its stop."""
    stops = governor.acting.on(Stops, *SWING)
    if stops is None:
        return []
    blow = governor.acting.struck(stops.reading, time)
    spots: list[Pair] = []
    if blow is not None:
        inside = blow.high == (stops.reading == SWING[0])  # the lever angle grows inward
        for side in sides:
            face = abs(side.weight[0]) + (-governor.half_width if inside else governor.half_width)
            spots.append((side.sign * face, _level(governor)))
    return [burst("burst", spots, 0.3 * governor.arm)]


def _level(governor: Governor) -> float:
    """The height at which the weights meet their stops (m)."""
    return 0.5 * (governor.bore + governor.half_height)


def _stop_radii(governor: Governor) -> tuple[float, float] | None:
    """Where the weights' centres are stopped, inside and outside (m from the axis; nan where there is none)."""
    stops = governor.acting.on(Stops, *SWING)
    if stops is None:
        return None
    if stops.reading == SWING[1]:
        inner, outer = stops.low, stops.high
    else:
        inner, outer = (governor.radius(end) if math.isfinite(end) else math.nan for end in (stops.high, stops.low))
    return (inner if math.isfinite(inner) else math.nan), (outer if math.isfinite(outer) else math.nan)


def _weight_stops(governor: Governor) -> list[Shape]:
    """Blocks that the weights' faces meet: inside on the hub, outside on brackets from the springs' seats."""
    radii = _stop_radii(governor)
    if radii is None:
        return []
    u, y, shapes = governor.arm, _level(governor), list[Shape]()
    half = min(BLOCK * u, 0.8 * (governor.half_height - governor.bore) / 2)
    inner, outer = radii[0] - governor.half_width, radii[1] + governor.half_width
    if math.isfinite(inner):
        near = max(inner - 0.16 * u, -0.2 * u) if inner > 0.05 * u else inner - 0.1 * u
        shapes.append(rectangle("bracket", -max(near, 0.0), max(near, 0.0), y - 0.5 * half, y + 0.5 * half))
        for sign in (-1.0, 1.0):
            left, right = sorted((sign * max(near, 0.02 * u), sign * inner))
            shapes += block("stop", (0.0, 0.0, 0.0), (left, right, y - half, y + half), 0.07 * u)
    if math.isfinite(outer):
        plate = governor.seat + 0.03 * u
        for sign in (-1.0, 1.0):
            left, right = sorted((sign * outer, sign * (outer + 0.13 * u)))
            shapes.append(bar("bracket", (sign * plate, 0.9 * governor.bore), (sign * plate, y), 0.07 * u))
            shapes.append(bar("bracket", (sign * outer + sign * 0.1 * u, y), (sign * plate, y), 0.07 * u))
            shapes += block("stop", (0.0, 0.0, 0.0), (left, right, y - half, y + half), 0.07 * u)
    return shapes


def _cylinder_box(governor: Governor, heights: Pair) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the dashpot (m), long enough for the whole way of its piston."""
    u, (low, high) = governor.arm, heights
    x = -(governor.load[0] + BESIDE * u)
    top = low - 0.45 * u
    return x - CYLINDER * u, x + CYLINDER * u, top - max(high - low + 0.45 * u, 0.7 * u), top


def _range(governor: Governor) -> Pair:
    """Between what heights the lugs move over the run (m)."""
    low, high = governor.acting.ranges.get(LIFT, (0.0, 0.0))
    return governor.zero + low, governor.zero + high


def _cylinder(governor: Governor, heights: Pair) -> list[Shape]:
    """An open cylinder full of oil on a hatched footing, beside the sleeve."""
    if not governor.acting.on(OilBrake, LIFT):
        return []
    u, (left, right, bottom, top) = governor.arm, _cylinder_box(governor, heights)
    thick = 0.05 * u
    return [
        rectangle("dashpot", left, right, bottom, top),
        rectangle("bore", left + thick, right - thick, bottom + thick, top),
        rectangle("oil", left + thick, right - thick, bottom + thick, top - 0.1 * u),
        wall(((left + right) / 2, bottom), math.pi / 2, 1.35 * CYLINDER * u, 0.1 * u),
    ]


def _piston(governor: Governor, height: float) -> list[Shape]:
    """The dashpot's piston, its rod, and the bracket by which the sleeve moves it."""
    if not governor.acting.on(OilBrake, LIFT):
        return []
    u, low = governor.arm, _range(governor)[0]
    left, right, bottom, _ = _cylinder_box(governor, _range(governor))
    x, thick = (left + right) / 2, 0.06 * u
    piston = bottom + 0.14 * u + height - low
    return [
        rectangle("piston rod", x - 0.04 * u, x + 0.04 * u, piston, height),
        rectangle("piston", left + thick, right - thick, piston, piston + 0.1 * u),
        bar("piston rod", (x, height), (-0.9 * governor.load[0], height), 0.1 * u),
    ]


def _seat(governor: Governor, lowest: float) -> list[Shape]:
    """A disc on the spindle for the sleeve's spring to rest against."""
    if not governor.acting.on(SpringOn, LIFT):
        return []
    u, y, half = governor.arm, undermost(governor, lowest), 0.45 * governor.arm
    return [rectangle("seat", -half, half, y - 0.04 * u, y)]


def _spring(governor: Governor, height: float) -> list[Shape]:
    """A helical spring round the spindle, under the sleeve."""
    if not governor.acting.on(SpringOn, LIFT):
        return []
    start, end = undermost(governor, _range(governor)[0]), height - governor.load[1]
    return [Lines("spring", helix((0.0, start), (0.0, end), 0.36 * governor.arm, SPINDLE * governor.arm))]


def _shoes(governor: Governor, height: float, time: float) -> list[Shape]:
    """Shoes under the sleeve that rub on the spindle, in the colour of what rubs or of what is held."""
    if not governor.acting.on(DryFriction, LIFT):
        return []
    u, base, held = governor.arm, height - governor.load[1], governor.acting.sticks(LIFT, time)
    near, far = SPINDLE * u, (SPINDLE + 0.2) * u
    shoes = [rectangle("shoe", x, x + far - near, base - SHOE * u, base) for x in (-far, near)]
    return [
        Polygon(role, shoe.points if shown else ())
        for role, shown in (("shoe", not held), ("held shoe", held))
        for shoe in shoes
    ]

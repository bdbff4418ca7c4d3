"""Effects drawn on a Hartung governor: weight stops, dashpot, sleeve spring and friction shoes."""

import math
from collections.abc import Iterator

from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.render.geometry.outlines import make_burst, make_hatched_block
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Vec2, make_bar, make_rectangle
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.hartung.proportions import HartungProportions, HartungSide

_WEIGHT_READINGS = ("lever_angle", "weight_radius")
"""Readings that determine the position of the weights."""
_STOP_HALF_HEIGHT = 0.16
"""Half height of the weight stops, as a fraction of the weight arm."""
_SHOE_HEIGHT = 0.20


def spindle_collar_height(governor: HartungProportions) -> float:
    """Return the height (m) of the lower spindle collar, below the sleeve at its lowest."""
    u, gap = governor.arm, 0.14 * governor.arm
    if governor.find_lift_effect(DryFriction):
        gap += _SHOE_HEIGHT * u
    if governor.find_lift_effect(OutputSpring):
        gap += 0.9 * u
    return governor.lug_height_range[0] - governor.sleeve_size[1] - gap


def static_effect_shapes(governor: HartungProportions) -> Iterator[DrawnShape]:
    """Yield the shapes fixed to the frame: weight stops, dashpot cylinder and spring seat."""
    u = governor.arm
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        yield from _weight_stop_shapes(governor, stops)
    yield from parts.cylinder_shapes(governor)
    if governor.find_lift_effect(OutputSpring):
        y = spindle_collar_height(governor)
        yield make_rectangle("seat", -0.45 * u, 0.45 * u, y - 0.04 * u, y)


def moving_effect_shapes(governor: HartungProportions, height: float, time: float) -> Iterator[DrawnShape]:
    """Yield the shapes that move with the sleeve, with its lugs at a height (m), at a time (s)."""
    u, base = governor.arm, height - governor.sleeve_size[1]
    w = governor.spindle_ratio * u
    yield from parts.piston_shapes(governor, height, height)
    if governor.find_lift_effect(OutputSpring):
        yield Lines("spring", parts.helical_spring_lines((0.0, spindle_collar_height(governor)), (0.0, base), 0.36 * u, w))
    yield from parts.spindle_shoe_shapes(governor, time, base, (0.2, _SHOE_HEIGHT))


def impact_shapes(governor: HartungProportions, sides: list[HartungSide], time: float) -> Iterator[DrawnShape]:
    """Yield rays where a weight has just struck its stop."""
    if stops := governor.find_effect(Stops, *_WEIGHT_READINGS):
        struck_side, points = governor.struck_side(stops.reading, time), list[Vec2]()
        if struck_side:
            is_inner_stop = (struck_side > 0) == (stops.reading == "lever_angle")  # the lever angle increases inward
            face = -governor.weight_size[0] if is_inner_stop else governor.weight_size[0]
            points = [(side.sign * (abs(side.weight[0]) + face), _stop_height(governor)) for side in sides]
        yield make_burst("burst", points, 0.3 * governor.arm)


def _stop_height(governor: HartungProportions) -> float:
    """Return the height (m) at which the weights meet their stops."""
    return 0.5 * (governor.bore_half_height + governor.weight_size[1])


def _stop_radii(governor: HartungProportions, stops: Stops) -> Vec2:
    """Return the radii (m) of the weight centres at the inner and outer stop; not finite where there is no stop."""
    if stops.reading == "weight_radius":
        return stops.low, stops.high
    inner, outer = (governor.weight_radius(angle) if math.isfinite(angle) else math.nan for angle in (stops.high, stops.low))
    return inner, outer


def _weight_stop_shapes(governor: HartungProportions, stops: Stops) -> Iterator[DrawnShape]:
    """Yield the blocks that stop the weights: inside on the hub, outside on brackets from the spring seats."""
    u, y, (weight_half_width, weight_half_height) = governor.arm, _stop_height(governor), governor.weight_size
    inner_radius, outer_radius = _stop_radii(governor, stops)
    half_height = min(_STOP_HALF_HEIGHT * u, 0.8 * (weight_half_height - governor.bore_half_height) / 2)
    inner, outer = inner_radius - weight_half_width, outer_radius + weight_half_width
    if math.isfinite(inner):
        hub_face = max(inner - 0.16 * u, -0.2 * u) if inner > 0.05 * u else inner - 0.1 * u
        yield make_rectangle("bracket", -max(hub_face, 0.0), max(hub_face, 0.0), y - 0.5 * half_height, y + 0.5 * half_height)
        near, far = sorted((max(hub_face, 0.02 * u), inner))
        yield from parts.hatched_pair_shapes("stop", (near, far), (y - half_height, y + half_height), 0.07 * u)
    if math.isfinite(outer):
        plate = governor.spring_seat_radius + 0.03 * u
        for sign, sides in zip((-1.0, 1.0), parts.both_sides(outer, outer + 0.13 * u), strict=True):
            yield make_bar("bracket", (sign * plate, 0.9 * governor.bore_half_height), (sign * plate, y), 0.07 * u)
            yield make_bar("bracket", (sign * outer + sign * 0.1 * u, y), (sign * plate, y), 0.07 * u)
            yield from make_hatched_block("stop", (0.0, 0.0, 0.0), (*sides, y - half_height, y + half_height), 0.07 * u)

"""Drawing of the sleeve of a pendulum governor: lugs, collar and load, with engraved shading, and slots for the clearance of the links."""

import math
from collections.abc import Iterator
from itertools import pairwise

from governor_mechanism.machines.pendulum.machine import SLEEVE
from governor_mechanism.render.geometry.attached import Attached
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.governor_parts import mirror_outline
from governor_mechanism.render.machines.pendulum.proportions import GROOVE_RATIO, PendulumProportions

_SLOT_HALF_LENGTH = 0.022
"""Half length of the clearance slots in the lugs, as a fraction of the arm."""
_LUG_WIDTH = 0.085
"""Width of a lug, as a fraction of the arm."""


def sleeve_parts(governor: PendulumProportions) -> Iterator[Attached]:
    """Yield the lugs, the rest of the sleeve, which is round, and the slots for the clearance of the links."""
    has_lugs_aside = governor.lug_offset != 0.0
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_lug_shapes(governor)), turns=has_lugs_aside)
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_sleeve_shapes(governor)), turns=False)
    yield Attached(frame=governor.sleeve_axes, shapes=tuple(_clearance_slot_shapes(governor)), turns=has_lugs_aside)


def _lug_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    u = governor.arm
    lug_top = _SLOT_HALF_LENGTH * u if governor.clearance else 0.0
    for x in (-governor.lug_offset, governor.lug_offset):
        yield make_bar("sleeve", (x, -0.06 * u), (x, lug_top), _LUG_WIDTH * u)


def _sleeve_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield collar and load with shading; the load is below the lugs, clear of arms and links."""
    u, (width, drop) = governor.arm, governor.sleeve_size
    is_loaded = SLEEVE in governor.body_names
    neck, top, base = abs(governor.lug_offset) + 0.06 * u, -0.045 * u, -drop
    outline = (_drum_outline if is_loaded else _collar_outline)(neck, width, top, base, u)
    yield Polygon("sleeve", mirror_outline(outline))
    yield Lines("engraving", _shading_strokes(outline, width if is_loaded else GROOVE_RATIO * width, base, u))
    tip = width + 0.085 * u
    yield Polygon("pointer", ((tip, base), (tip - 0.07 * u, base + 0.03 * u), (tip - 0.07 * u, base - 0.03 * u)))


def _drum_outline(neck: float, width: float, top: float, base: float, u: float) -> tuple[Vec2, ...]:
    """Return the right half of the outline of the load, from the top down: neck, rounded shoulder, body and foot moulding."""
    corner_radius = min(0.10 * u, 0.5 * (width - neck)) if width > neck else 0.0
    shoulder = top - 0.045 * u
    corner = tuple(
        (width - corner_radius * (1 - math.sin(a)), shoulder - corner_radius * (1 - math.cos(a)))
        for a in (k * math.pi / 12 for k in range(7))
    )
    return ((0.0, top), (neck, top), (neck, shoulder), *corner, (width, base + 0.03 * u), (0.93 * width, base))


def _collar_outline(neck: float, width: float, top: float, base: float, u: float) -> tuple[Vec2, ...]:
    """Return the right half of the outline of a light collar, with the groove for the throttle fork."""
    flange, groove = 0.045 * u, GROOVE_RATIO * width
    upper_flange = (width, top - 0.01 * u), (width, top - flange - 0.01 * u), (groove, top - flange - 0.01 * u)
    return (0.0, top), (neck, top), *upper_flange, (groove, base + flange), (width, base + flange), (width, base)


def _shading_strokes(outline: tuple[Vec2, ...], width: float, base: float, u: float) -> tuple[tuple[Vec2, ...], ...]:
    """Return upright strokes whose spacing decreases toward the right edge: the shading of a cylinder of half width `width`."""
    strokes = []
    for sine in (0.42, 0.57, 0.69, 0.79, 0.87, 0.94):
        x = sine * width
        # The outline starts at the axis; its highest crossing of x is the top of the stroke.
        tops = [y0 + (y1 - y0) * (x - x0) / (x1 - x0) for (x0, y0), (x1, y1) in pairwise(outline) if x0 <= x < x1]
        strokes.append(((x, max(tops) - 0.02 * u), (x, base + 0.03 * u)))
    strokes.append(((-0.94 * width, strokes[-1][0][1]), (-0.94 * width, base + 0.03 * u)))
    return tuple(strokes)


def _clearance_slot_shapes(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield a slot in each lug; none without clearance."""
    half_length = _SLOT_HALF_LENGTH * governor.arm
    for x in (-governor.lug_offset, governor.lug_offset) if governor.clearance else ():
        yield make_bar("slot", (x, -half_length), (x, half_length), 0.05 * governor.arm)

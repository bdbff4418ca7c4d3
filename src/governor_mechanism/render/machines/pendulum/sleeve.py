"""Drawing of the sleeve of a pendulum governor: lugs, collar and load, with engraved shading, and the clearance of the links in it.

The clearance shows as slots in the lugs, and as an enlarged detail of one slot.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

from governor_mechanism.effects.clearance import CLEARANCE_READING
from governor_mechanism.machines.pendulum.machine import SLEEVE
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.render.machines.governor_parts import mirror_outline
from governor_mechanism.render.machines.pendulum.proportions import GROOVE_RATIO, PendulumProportions
from governor_mechanism.types import FloatArray

_SLOT_HALF_LENGTH = 0.022
"""Half length of the clearance slots in the lugs, as a fraction of the arm."""
_LUG_WIDTH = 0.085
"""Width of a lug, as a fraction of the arm."""
_EYELET_RADIUS = 0.040
"""Radius of the eye of a link, as a fraction of the arm."""
_LENS_LEFT, _LENS_BOTTOM, _LENS_WIDTH, _LENS_HEIGHT = -0.66, 0.06, 0.34, 0.42
"""Rectangle of the detail, next to the upper bearing, as fractions of the arm."""
_MAX_DRAWN_CLEARANCE = 0.13
"""Largest size of the clearance in the detail, as a fraction of the arm."""
_SLOT_CENTRE_HEIGHT = 0.16
"""Height of the slot centre in the detail, as a fraction of the arm."""


def sleeve_shapes(governor: PendulumProportions, height: float) -> Iterator[DrawnShape]:
    """Yield lugs, collar and load with shading; the load is below the lugs, clear of arms and links."""
    u, (width, drop) = governor.arm, governor.sleeve_size
    is_loaded = SLEEVE in governor.body_names
    lug_top = height + (_SLOT_HALF_LENGTH * u if governor.clearance else 0.0)
    for x in (-governor.lug_offset, governor.lug_offset):
        yield make_bar("sleeve", (x, height - 0.06 * u), (x, lug_top), _LUG_WIDTH * u)
    neck, top, base = abs(governor.lug_offset) + 0.06 * u, height - 0.045 * u, height - drop
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


def clearance_slot_shapes(governor: PendulumProportions, height: float) -> Iterator[DrawnShape]:
    """Yield a slot in each lug of a sleeve at a height (m); none without clearance."""
    half_length = _SLOT_HALF_LENGTH * governor.arm
    for x in (-governor.lug_offset, governor.lug_offset) if governor.clearance else ():
        yield make_bar("slot", (x, height - half_length), (x, height + half_length), 0.05 * governor.arm)


def clearance_magnification(governor: PendulumProportions) -> float:
    """Return the magnification of the clearance in the detail: 1, 2 or 5 x 10^n."""
    max_magnification = _MAX_DRAWN_CLEARANCE * governor.arm / governor.clearance
    decade = float(10.0 ** math.floor(math.log10(max_magnification)))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= max_magnification * (1 + 1e-9))


def clearance_lens_frame(governor: PendulumProportions) -> Iterator[DrawnShape]:
    """Yield the frame of the detail and its magnification; none without clearance."""
    if not governor.clearance:
        return
    u, magnification = governor.arm, clearance_magnification(governor)
    ratio = f"{magnification:g} : 1" if magnification >= 1.0 else f"1 : {1 / magnification:g}"
    yield make_rectangle("lens", _LENS_LEFT * u, (_LENS_LEFT + _LENS_WIDTH) * u, _LENS_BOTTOM * u, (_LENS_BOTTOM + _LENS_HEIGHT) * u)
    yield TextShape("scale", _LENS_LEFT * u, (_LENS_BOTTOM + _LENS_HEIGHT + 0.075) * u, f"clearance, {ratio}", 0.62 * u)


def clearance_lens_contents(governor: PendulumProportions, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
    """Yield a lug with its slot, and in it the eye of a link from above; the eye flashes at an impact."""
    if not governor.clearance:
        return
    u, magnification = governor.arm, clearance_magnification(governor)
    offset = float(governor.sleeve_height(pose) - governor.taut_link_height(pose))
    x, y = (_LENS_LEFT + _LENS_WIDTH / 2) * u, (_LENS_BOTTOM + _SLOT_CENTRE_HEIGHT) * u
    half_clearance = magnification * governor.clearance / 2
    pin = (x, y - min(max(magnification * offset, -half_clearance), half_clearance))
    radius = _EYELET_RADIUS * u
    lug_top = (_LENS_BOTTOM + 2 * _SLOT_CENTRE_HEIGHT - 0.02) * u
    yield make_rectangle("sleeve", x - 0.11 * u, x + 0.11 * u, _LENS_BOTTOM * u, lug_top)
    yield make_bar("slot", (x, y - half_clearance), (x, y + half_clearance), 2 * radius)
    yield make_rectangle("link", x - 0.024 * u, x + 0.024 * u, pin[1], (_LENS_BOTTOM + _LENS_HEIGHT) * u)
    yield Circle("eyelet", *pin, radius)
    yield Circle("struck", *pin, radius if governor.struck_side(CLEARANCE_READING, time) else 0.0)
    yield Circle("pivot", *pin, 0.018 * u)

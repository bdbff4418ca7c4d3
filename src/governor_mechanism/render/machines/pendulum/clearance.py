"""Clearance between links and sleeve: slots in the sleeve lugs, and an enlarged detail of one slot."""

import math
from collections.abc import Iterator

from governor_mechanism.effects.clearance import CLEARANCE_READING
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, TextShape, make_bar, make_rectangle
from governor_mechanism.render.machines.pendulum.proportions import PendulumProportions
from governor_mechanism.render.machines.pendulum.sleeve import SLOT_HALF_LENGTH
from governor_mechanism.types import FloatArray

_EYELET_RADIUS = 0.040
"""Radius of the eye of a link, as a fraction of the arm."""
_LENS_LEFT, _LENS_BOTTOM, _LENS_WIDTH, _LENS_HEIGHT = -0.66, 0.06, 0.34, 0.42
"""Rectangle of the detail, next to the upper bearing, as fractions of the arm."""
_MAX_DRAWN_CLEARANCE = 0.13
"""Largest size of the clearance in the detail, as a fraction of the arm."""
_SLOT_CENTRE_HEIGHT = 0.16
"""Height of the slot centre in the detail, as a fraction of the arm."""


def clearance_slot_shapes(governor: PendulumProportions, height: float) -> Iterator[DrawnShape]:
    """Yield a slot in each lug of a sleeve at a height (m); none without clearance."""
    half_length = SLOT_HALF_LENGTH * governor.arm
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
    yield Circle("struck", *pin, radius if governor.effect_state.recent_impact(CLEARANCE_READING, time) else 0.0)
    yield Circle("pivot", *pin, 0.018 * u)

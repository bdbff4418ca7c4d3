"""Play between links and sleeve: slots in the sleeve's lugs, and a detail of one, so much larger that it is seen."""

from __future__ import annotations

import math

from governor_mechanism.effects.clearance import CLEARANCE_READING
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, TextShape, make_bar, make_rectangle
from governor_mechanism.render.machines.pendulum.proportions import PendulumProportions, pendulum_sleeve_height, taut_link_height
from governor_mechanism.render.machines.pendulum.sleeve import SLOT_HALF_LENGTH
from governor_mechanism.types import FloatArray

# As fractions of the arm.
_EYELET_RADIUS = 0.040
"""radius of a link's eye"""
_LENS_LEFT, _LENS_BOTTOM, _LENS_WIDTH, _LENS_HEIGHT = -0.66, 0.06, 0.34, 0.42
"""the detail's place, beside the bearing at the top"""
_MAX_DRAWN_CLEARANCE = 0.13
"""what the play measures in the detail at most"""
_SLOT_CENTRE_HEIGHT = 0.16
"""height of the slot's middle in it"""


def clearance_slot_shapes(governor: PendulumProportions, height: float) -> tuple[DrawnShape, ...]:
    """A slot in each lug of a sleeve at a height (m); none without play."""
    if not governor.clearance:
        return ()
    u = governor.arm
    return tuple(
        make_bar("slot", (x, height - SLOT_HALF_LENGTH * u), (x, height + SLOT_HALF_LENGTH * u), 0.05 * u)
        for x in (-governor.lug_offset, governor.lug_offset)
    )


def clearance_magnification(governor: PendulumProportions) -> float:
    """How many times larger the detail shows the play: 1, 2 or 5 x 10^n."""
    max_magnification = _MAX_DRAWN_CLEARANCE * governor.arm / governor.clearance
    decade = float(10.0 ** math.floor(math.log10(max_magnification)))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= max_magnification * (1 + 1e-9))


def clearance_lens_frame(governor: PendulumProportions) -> tuple[DrawnShape, ...]:
    """The frame of the detail, and how large it shows the play; none without play."""
    if not governor.clearance:
        return ()
    u, magnification = governor.arm, clearance_magnification(governor)
    ratio = f"{magnification:g} : 1" if magnification >= 1.0 else f"1 : {1 / magnification:g}"
    return (
        make_rectangle("lens", _LENS_LEFT * u, (_LENS_LEFT + _LENS_WIDTH) * u, _LENS_BOTTOM * u, (_LENS_BOTTOM + _LENS_HEIGHT) * u),
        TextShape("scale", _LENS_LEFT * u, (_LENS_BOTTOM + _LENS_HEIGHT + 0.075) * u, f"play, {ratio}", 0.62 * u),
    )


def clearance_lens_contents(governor: PendulumProportions, part: Part, pose: FloatArray, time: float) -> tuple[DrawnShape, ...]:
    """A lug with its slot, and in it the eye of a link, hung from above, which flashes when it strikes."""
    if not governor.clearance:
        return ()
    u, magnification = governor.arm, clearance_magnification(governor)
    offset = float(pendulum_sleeve_height(governor, part, pose) - taut_link_height(governor, part, pose))
    x, y = (_LENS_LEFT + _LENS_WIDTH / 2) * u, (_LENS_BOTTOM + _SLOT_CENTRE_HEIGHT) * u
    half_clearance = magnification * governor.clearance / 2
    pin = (x, y - min(max(magnification * offset, -half_clearance), half_clearance))
    width = 2 * _EYELET_RADIUS * u
    return (
        make_rectangle("sleeve", x - 0.11 * u, x + 0.11 * u, _LENS_BOTTOM * u, (_LENS_BOTTOM + 2 * _SLOT_CENTRE_HEIGHT - 0.02) * u),
        make_bar("slot", (x, y - half_clearance), (x, y + half_clearance), width),
        make_rectangle("link", x - 0.024 * u, x + 0.024 * u, pin[1], (_LENS_BOTTOM + _LENS_HEIGHT) * u),
        Circle("eyelet", *pin, _EYELET_RADIUS * u),
        Circle("struck", *pin, _EYELET_RADIUS * u if governor.effect_state.recent_impact(CLEARANCE_READING, time) else 0.0),
        Circle("pivot", *pin, 0.018 * u),
    )

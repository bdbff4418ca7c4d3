"""Play between links and sleeve: slots in the sleeve's lugs, and a detail of one, so much larger that it is seen."""

from __future__ import annotations

import math

from governor_mechanism.effects.clearance import PLAY
from governor_mechanism.model.scene import Part
from governor_mechanism.render.geometry.primitives import Circle, Shape, Text, bar, rectangle
from governor_mechanism.render.machines.pendulum.proportions import Governor, hung_height, sleeve_height
from governor_mechanism.render.machines.pendulum.sleeve import SLOT
from governor_mechanism.types import FloatArray

# As fractions of the arm.
EYELET = 0.040
"""radius of a link's eye"""
LEFT, BOTTOM, WIDE, HIGH = -0.66, 0.06, 0.34, 0.42
"""the detail's place, beside the bearing at the top"""
WAY = 0.13
"""what the play measures in the detail at most"""
SLOT_MIDDLE = 0.16
"""height of the slot's middle in it"""


def slots(governor: Governor, height: float) -> tuple[Shape, ...]:
    """A slot in each lug of a sleeve at a height (m); none without play."""
    if not governor.play:
        return ()
    u = governor.arm
    return tuple(
        bar("slot", (x, height - SLOT * u), (x, height + SLOT * u), 0.05 * u) for x in (-governor.lug, governor.lug)
    )


def magnified(governor: Governor) -> float:
    """How many times larger the detail shows the play: 1, 2 or 5 x 10^n."""
    most = WAY * governor.arm / governor.play
    decade = float(10.0 ** math.floor(math.log10(most)))
    return next(step * decade for step in (5.0, 2.0, 1.0) if step * decade <= most * (1 + 1e-9))


def lens_frame(governor: Governor) -> tuple[Shape, ...]:
    """The frame of the detail, and how large it shows the play; none without play."""
    if not governor.play:
        return ()
    u, times = governor.arm, magnified(governor)
    ratio = f"{times:g} : 1" if times >= 1.0 else f"1 : {1 / times:g}"
    return (
        rectangle("lens", LEFT * u, (LEFT + WIDE) * u, BOTTOM * u, (BOTTOM + HIGH) * u),
        Text("scale", LEFT * u, (BOTTOM + HIGH + 0.075) * u, f"play, {ratio}", 0.62 * u),
    )


def lens_inside(governor: Governor, part: Part, pose: FloatArray, time: float) -> tuple[Shape, ...]:
    """A lug with its slot, and in it the eye of a link, hung from above, which flashes when it strikes."""
    if not governor.play:
        return ()
    u, times = governor.arm, magnified(governor)
    off = float(sleeve_height(governor, part, pose) - hung_height(governor, part, pose))
    x, y = (LEFT + WIDE / 2) * u, (BOTTOM + SLOT_MIDDLE) * u
    half = times * governor.play / 2
    pin = (x, y - min(max(times * off, -half), half))
    width = 2 * EYELET * u
    return (
        rectangle("sleeve", x - 0.11 * u, x + 0.11 * u, BOTTOM * u, (BOTTOM + 2 * SLOT_MIDDLE - 0.02) * u),
        bar("slot", (x, y - half), (x, y + half), width),
        rectangle("link", x - 0.024 * u, x + 0.024 * u, pin[1], (BOTTOM + HIGH) * u),
        Circle("eyelet", *pin, EYELET * u),
        Circle("struck", *pin, EYELET * u if governor.acting.struck(PLAY, time) else 0.0),
        Circle("pivot", *pin, 0.018 * u),
    )

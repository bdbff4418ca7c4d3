"""What the drawing of a slide valve measures by, and how the gear stands at a pose. The shaft lies at the right."""

from __future__ import annotations

import math
from dataclasses import dataclass

from governor_mechanism.machines.driven_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.model.scene import Part
from governor_mechanism.types import FloatArray

LONGEST_ROD, LONGEST_ECCENTRIC_ROD = 5.5, 3.2
"""In cranks: a longer rod, or an endless one, is drawn as long as that."""


@dataclass(frozen=True, kw_only=True)
class Gear:
    """Sizes (m), laps with their signs; rod and eccentric_rod may be infinite. centre is that of the valve's swing."""

    crank: float
    rod: float
    eccentric: float
    eccentric_rod: float
    advance: float
    outside_lap: float
    inside_lap: float
    centre: float

    @property
    def drawn_rod(self) -> float:
        """The connecting rod as it is drawn (m)."""
        return min(self.rod, LONGEST_ROD * self.crank)

    @property
    def drawn_eccentric_rod(self) -> float:
        """The eccentric rod as it is drawn (m)."""
        return min(self.eccentric_rod, LONGEST_ECCENTRIC_ROD * self.crank)


@dataclass(frozen=True, kw_only=True)
class Standing:
    """The gear at a pose: crank angle (rad), displacement of the valve away from the shaft (m).

    piston (m) is its place along the stroke, -crank at the head end (left) to crank at the crank end (right).
    """

    angle: float
    displacement: float
    piston: float


def gear_of(part: Part) -> Gear:
    """The measures of a slide valve's part."""
    sizes = part.dimensions
    return Gear(
        crank=sizes["crank"],
        rod=sizes["connecting_rod"],
        eccentric=sizes["eccentric"],
        eccentric_rod=sizes["eccentric_rod"],
        advance=sizes["advance"],
        outside_lap=sizes["outside_lap"],
        inside_lap=sizes["inside_lap"],
        centre=sizes["centre"],
    )


def standing(part: Part, gear: Gear, pose: FloatArray) -> Standing:
    """How the gear stands at a pose (bodies, 3)."""
    mechanism = part.mechanism
    crosshead = float(pose[mechanism.body_index(CROSSHEAD), 0])
    return Standing(
        angle=float(pose[mechanism.body_index(CRANK), 2]),
        displacement=float(pose[mechanism.body_index(VALVE), 0]) - gear.centre,
        piston=-(crosshead - (0.0 if math.isinf(gear.rod) else gear.rod)),
    )


ADMITTING, EXPANDING, EXHAUSTING, COMPRESSING = "live steam", "expanding steam", "spent steam", "pressed steam"


def state(gear: Gear, at: Standing, side: float) -> str:
    """What the steam does at one end: side is 1 at the crank end, -1 at the head end."""
    opened = side * at.displacement
    if opened > gear.outside_lap:
        return ADMITTING
    if -opened > gear.inside_lap:
        return EXHAUSTING
    # The piston leaves the crank end in the first half of the turn.
    return EXPANDING if side * math.sin(at.angle) > 0 else COMPRESSING

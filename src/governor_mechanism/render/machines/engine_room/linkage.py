"""Bell crank from the sleeve of a governor, and the rod from it to what the governor controls. Lengths in pixels, angles in rad."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Vec2
from governor_mechanism.render.machines.engine_room import proportions as room
from governor_mechanism.types import FloatArray

_LEVER_LENGTH, _MIN_LEVER_LENGTH = 50.0, 22.0
_MIN_ARM, _MAX_ARM = 8.0, 44.0


@dataclass(frozen=True, kw_only=True)
class BellCrank:
    """A bell crank whose fork follows the sleeve; the other arm points up (`side` 1) or down (-1) and pulls a rod to the right."""

    fork_x: float
    pivot: Vec2
    arm: float
    side: int

    def arm_end(self, sleeve_height: float) -> Vec2:
        """Return the end of the arm for a height of the sleeve."""
        x, y = self.pivot
        angle = math.atan2(sleeve_height - y, self.fork_x - x) - self.side * 0.5 * math.pi
        return x + self.arm * math.cos(angle), y + self.arm * math.sin(angle)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the post that carries the pivot."""
        x, y = self.pivot
        yield make_bar("bracket", (x, room.GOVERNOR_BASE - 6.0), (x, y), 7.0)

    def moving_shapes(self, sleeve_height: float, rod_end: Vec2) -> Iterator[DrawnShape]:
        """Yield lever, arm and rod for a height of the sleeve and the other end of the rod."""
        end = self.arm_end(sleeve_height)
        yield make_bar("rod", end, rod_end, 3.2)
        yield make_bar("arm", self.pivot, (self.fork_x, sleeve_height), 5.5)
        yield make_bar("arm", self.pivot, end, 5.5)
        yield from (Circle("pivot", *point, 2.2) for point in (end, self.pivot, (self.fork_x, sleeve_height)))


def make_bell_crank(fork_x: float, sleeve_heights: FloatArray, rod_travel: float, side: int) -> BellCrank:
    """Return the bell crank for the heights (n,) of the sleeve over a run and the travel of the rod, so that the rod keeps its length.

    Where the arm would become too long, the lever is shorter.
    """
    low, high = float(sleeve_heights.min()), float(sleeve_heights.max())
    lever, arm = _LEVER_LENGTH, _MIN_ARM
    if high > low:
        arm = 0.5 * rod_travel / math.sin(math.atan2(0.5 * (high - low), lever))
    if arm > _MAX_ARM:
        arm = _MAX_ARM
        lever = max(0.5 * (high - low) / math.tan(math.asin(min(0.5 * rod_travel / arm, 0.9))), _MIN_LEVER_LENGTH)
    return BellCrank(fork_x=fork_x, pivot=(fork_x + lever, 0.5 * (low + high)), arm=max(arm, _MIN_ARM), side=side)

"""Bell crank from the sleeve of a governor, and the rod from it to what the governor controls. Lengths in pixels, angles in rad."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, axes_along, axes_shifted, bar_between
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

    def moving_parts(self, sleeve_at: Callable[[Any], float], rod_end_at: Callable[[Any], Vec2]) -> Iterator[DrawnPart]:
        """Yield lever, arm and rod; at a moment, the height of the sleeve and the other end of the rod."""

        def rod_ends(moment: Any) -> tuple[Vec2, Vec2]:
            return self.arm_end(sleeve_at(moment)), rod_end_at(moment)

        def lever_ends(moment: Any) -> tuple[Vec2, Vec2]:
            return self.pivot, (self.fork_x, sleeve_at(moment))

        arm_axes = axes_along(lambda moment: (self.pivot, self.arm_end(sleeve_at(moment))))
        # The fork of the lever slides on the sleeve.
        yield bar_between("rod", rod_ends, 3.2)
        yield bar_between("arm", lever_ends, 5.5)
        yield Attached(frame=arm_axes, shapes=(make_bar("arm", (0.0, 0.0), (self.arm, 0.0), 5.5),))
        yield Attached(frame=arm_axes, shapes=tuple(Circle("pivot", x, 0.0, 2.2) for x in (self.arm, 0.0)))
        fork_axes = axes_shifted(lambda moment: (self.fork_x, sleeve_at(moment)))
        yield Attached(frame=fork_axes, shapes=(Circle("pivot", 0.0, 0.0, 2.2),))


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

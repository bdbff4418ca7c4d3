"""Load of the engine: a belt to a line shaft with a Prony brake, whose weight shows the load. Lengths in pixels."""

import math
from collections.abc import Callable, Iterator
from typing import Any

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, axes_turned, fixed
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2
from governor_mechanism.render.machines.engine_room import proportions as room
from governor_mechanism.render.machines.engine_room.belts import BeltDrive

_DRUM, _BLOCK_HALF_WIDTH, _BLOCK_HEIGHT = 13.0, 10.0, 6.0
_HANGER = 12.0
"""Length of the rod on which the weight hangs."""


class Brake:
    """Prony brake on a line shaft: its drum drags the blocks, and the weight at the end of the lever holds them back."""

    def __init__(self, shaft: Vec2) -> None:
        self._belt = BeltDrive(first=shaft, second=room.LINE_SHAFT, first_radius=room.LOAD_PULLEY, second_radius=room.LOAD_PULLEY)

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the bracket of the line shaft under the ceiling."""
        x, y = room.LINE_SHAFT
        yield make_wall((x, room.HEIGHT - 8.0), -math.pi / 2, 20.0, 6.0)
        yield make_bar("bracket", (x, y), (x, room.HEIGHT - 12.0), 9.0)

    def belt_shapes(self) -> Iterator[DrawnShape]:
        """Yield the belt from the shaft of the engine."""
        yield from self._belt.belt_shapes()

    def moving_parts(self, angle_at: Callable[[Any], float], fraction_at: Callable[[Any], float]) -> Iterator[DrawnPart]:
        """Yield line shaft, brake and weight; at a moment, the drawn angle (rad) of the shaft, and the load relative to its largest."""
        (x, y), end = room.LINE_SHAFT, room.LINE_SHAFT[0] + room.BRAKE_ARM
        yield from self._belt.second_pulley_parts(angle_at)
        drum = Circle("frame", 0.0, 0.0, _DRUM), Lines("mark spoke", (((0.0, 0.0), (0.9 * _DRUM, 0.0)),))
        yield Attached(frame=axes_turned((x, y), angle_at), shapes=drum)
        yield fixed(self._frame_shapes())
        yield Flexible(shapes_at=lambda moment: [self._weight(fraction_at(moment))])
        yield fixed([Circle("pivot", end, y + _DRUM + 8.0, 2.2)])

    def _frame_shapes(self) -> Iterator[DrawnShape]:
        """Yield the blocks with their bolts, the lever, and the rod on which the weight hangs."""
        (x, y), top, end = room.LINE_SHAFT, room.LINE_SHAFT[1] + _DRUM, room.LINE_SHAFT[0] + room.BRAKE_ARM
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, y - _DRUM - _BLOCK_HEIGHT, y - _DRUM)
        yield Lines("small rod", tuple(((x + side, y - _DRUM - _BLOCK_HEIGHT), (x + side, top + 8.0)) for side in (-17.0, 17.0)))
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, top, top + _BLOCK_HEIGHT)
        yield make_bar("arm", (x - 20.0, top + 8.0), (end, top + 8.0), 5.0)
        yield Lines("small rod", (((end, top + 8.0), (end, top + 8.0 - _HANGER)),))

    def _weight(self, fraction: float) -> Polygon:
        """Return the weight for a fraction of the largest load of the run."""
        end, weight_top = room.LINE_SHAFT[0] + room.BRAKE_ARM, room.LINE_SHAFT[1] + _DRUM + 8.0 - _HANGER
        height = max(fraction, 0.0) * room.MAX_WEIGHT_HEIGHT
        return make_rectangle("weight", end - 0.5 * room.WEIGHT_WIDTH, end + 0.5 * room.WEIGHT_WIDTH, weight_top - height, weight_top)

"""Load of the engine: a belt to a line shaft with a Prony brake, whose weight shows the load. Lengths in pixels."""

import math
from collections.abc import Iterator

from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle, make_wall
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2
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

    def moving_shapes(self, angle: float, fraction: float) -> Iterator[DrawnShape]:
        """Yield line shaft, brake and weight at a drawn angle (rad) of the shaft, for a fraction of the largest load of the run."""
        (x, y), top = room.LINE_SHAFT, room.LINE_SHAFT[1] + _DRUM
        yield from self._belt.second_pulley_shapes(angle)
        yield Circle("frame", x, y, _DRUM)
        yield Lines("mark spoke", (((x, y), (x + 0.9 * _DRUM * math.cos(angle), y + 0.9 * _DRUM * math.sin(angle))),))
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, y - _DRUM - _BLOCK_HEIGHT, y - _DRUM)
        yield Lines("small rod", tuple(((x + side, y - _DRUM - _BLOCK_HEIGHT), (x + side, top + 8.0)) for side in (-17.0, 17.0)))
        yield make_rectangle("shoe", x - _BLOCK_HALF_WIDTH, x + _BLOCK_HALF_WIDTH, top, top + _BLOCK_HEIGHT)
        end = x + room.BRAKE_ARM
        yield make_bar("arm", (x - 20.0, top + 8.0), (end, top + 8.0), 5.0)
        weight_top = top + 8.0 - _HANGER
        yield Lines("small rod", (((end, top + 8.0), (end, weight_top)),))
        height = max(fraction, 0.0) * room.MAX_WEIGHT_HEIGHT
        yield make_rectangle("weight", end - 0.5 * room.WEIGHT_WIDTH, end + 0.5 * room.WEIGHT_WIDTH, weight_top - height, weight_top)
        yield Circle("pivot", end, top + 8.0, 2.2)

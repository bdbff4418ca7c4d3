"""Governor of the room: its own drawing, enlarged or reduced to fit, without its lift scale. Lengths in pixels."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, Moment, at_own_moments
from governor_mechanism.render.geometry.free_space import select_extreme_rows
from governor_mechanism.render.geometry.placement import Placement
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, TextShape, bounding_box, enclose_boxes
from governor_mechanism.render.machines.engine_room import proportions as room
from governor_mechanism.render.machines.governor_parts import GovernorDrawing
from governor_mechanism.render.machines.machine_drawing import MachineDrawing
from governor_mechanism.types import FloatArray

_LEFT_OUT = ("scale", "leader", "pointer", "axis")
"""Roles of a lift scale, which the plots replace, and of the line of the axis, which the stand below the spindle continues."""
_ROLES_OF_ROOM = ("throttle ", "gearing ")
"""Beginnings of the roles of what the governor drives and what drives it: the room shows both in their places."""
_FORK_HEIGHT_RATIO, _FORK_RADIUS_RATIO = 0.33, 0.9
"""Place of the fork on a sleeve: height over its base and radius, relative to its size."""


class GovernorElevation:
    """A governor that stands in the room with its spindle at the governor's axis.

    Parameters
    ----------
    drawing
        Drawing of the governor.
    control_reading
        Reading of the governor, by plain name, that moves the control.
    """

    def __init__(self, drawing: MachineDrawing, control_reading: str) -> None:
        self._drawing, self._control_reading = drawing, control_reading
        left, right, bottom, top = self._bounds
        half_width = max(-left, right, 1e-9)
        scale = min(room.GOVERNOR_HALF_WIDTH / half_width, (room.GOVERNOR_TOP - room.GOVERNOR_BASE) / (top - bottom))
        self.placement = Placement(
            origin=(room.GOVERNOR_AXIS, room.GOVERNOR_BASE - scale * bottom), x_axis=(scale, 0.0), y_axis=(0.0, scale)
        )

    @property
    def pixels_per_metre(self) -> float:
        """Scale of the governor."""
        return self.placement.scale

    @property
    def fork_x(self) -> float:
        """Position of the fork on the sleeve."""
        half_width = self._drawing.sleeve_size[0] if isinstance(self._drawing, GovernorDrawing) else 0.05 * self._length
        return room.GOVERNOR_AXIS + self.placement.scale * _FORK_RADIUS_RATIO * half_width

    def fork_heights(self, poses: FloatArray, readings: FloatArray) -> FloatArray:
        """Return the heights (n,) of the fork at poses (n, bodies, 3) and values (n,) of the reading that moves the control.

        On a governor without a drawing of its own, the fork rises with that reading.
        """
        drawing, placement = self._drawing, self.placement
        if isinstance(drawing, GovernorDrawing):
            heights: FloatArray = drawing.sleeve_height(poses) - (1.0 - _FORK_HEIGHT_RATIO) * drawing.sleeve_size[1]
            return placement.origin[1] + placement.scale * heights
        low, high = drawing.reading_range(self._control_reading)
        return np.asarray(room.GOVERNOR_BASE + 16.0 + 30.0 * (readings - low) / max(high - low, 1e-12))

    def fixed_parts(self) -> Iterator[DrawnPart]:
        """Yield the spindle in its bearings and what else does not move."""
        yield from self.placement.place_parts(_parts_of_room(self._drawing.fixed))

    def moving_parts(self, governor_at: Callable[[Any], Moment]) -> Iterator[DrawnPart]:
        """Yield the governor; `governor_at` is its own moment at a moment of the room."""
        yield from self.placement.place_parts(at_own_moments(part, governor_at) for part in _parts_of_room(self._drawing.moving))

    @cached_property
    def _bounds(self) -> BoundingBox:
        """Box (m) around the governor at all poses of the run."""
        drawing, poses = self._drawing, self._drawing.poses
        rows = select_extreme_rows(poses)
        boxes = [bounding_box(_without_scale(drawing.moving_shapes(poses[k], float(drawing.run.times[k])))) for k in rows]
        return enclose_boxes([bounding_box(_without_scale(drawing.static_shapes)), *boxes])

    @property
    def _length(self) -> float:
        return self._drawing.part.mechanism.length_scale


def _parts_of_room(parts: Iterable[DrawnPart]) -> Iterator[DrawnPart]:
    """Yield parts without what `_without_scale` leaves out."""
    for part in parts:
        if isinstance(part, Flexible):
            yield replace(part, shapes_at=_ShapesOfRoom(part))
        else:
            yield replace(part, shapes=tuple(_without_scale(part.shapes)))


@dataclass(frozen=True, eq=False)
class _ShapesOfRoom:
    """Shapes of a flexible part without what the room leaves out."""

    part: Flexible

    def __call__(self, moment: Any) -> list[DrawnShape]:
        """Return them at a moment."""
        return _without_scale(self.part.shapes_at(moment))


def _without_scale(shapes: Iterable[DrawnShape]) -> list[DrawnShape]:
    """Return the shapes without texts, axis and lift scale, throttle gear and spindle drive."""
    return [
        shape
        for shape in shapes
        if not isinstance(shape, TextShape) and shape.role not in _LEFT_OUT and not shape.role.startswith(_ROLES_OF_ROOM)
    ]

"""Drawing of any valve gear with its engine; below it the valve on its ports at a larger scale and a key, beside it the diagram."""

import math
from collections.abc import Iterator, Sequence
from functools import cached_property, partial

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, fixed, shapes_of
from governor_mechanism.render.geometry.free_space import find_free_corner
from governor_mechanism.render.geometry.placement import Placement
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Vec2, bounding_box
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.slide_valve import zeuner_dial
from governor_mechanism.render.machines.slide_valve.steam_chest import SteamChest
from governor_mechanism.render.machines.slide_valve.steam_key import SteamKey, scale_note_shapes
from governor_mechanism.render.machines.valve_gear.in_place import EngineInPlace
from governor_mechanism.render.machines.valve_gear.ports import block_shapes, make_chest, port_parts
from governor_mechanism.render.machines.valve_gear.proportions import ValveGearExtents
from governor_mechanism.types import FloatArray

# As fractions of the width of the picture.
_SECTION_WIDTH, _KEY_PLACE, _NOTE_PLACE, _NOTE_WIDTH, _KEY_SIZE = 0.45, 0.48, 0.765, 0.235, 0.20
_ROW_HEIGHT, _ROW_GAP = 0.17, 0.025
"""Height of the row below the engine with its gap, and the gap."""
_ASPECT_RATIO = 1.74
"""Least width of the picture over its height: that of the place above the plots of a film, which is then filled."""
_N_SAMPLES = 40
"""Number of times of the run at which the extent of the engine is taken."""
_DIAL_RADII = (0.07, 0.11)
"""Radius of the valve diagram beyond the row, and the largest one in a corner beside the engine."""
_DIAL_ROOM = 1.35
"""Half the side of the square that a diagram needs with its words, in radii."""
_ROD_END = 1.25
"""Length of the drawn valve rod from the middle of the section, in half lengths of the chest."""


class ValveGearDrawing(GenericDrawing, ValveGearExtents):
    """Drawing of a valve gear whose valve and piston move along lines."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the engine and the ground of the gear, the section of the valve, the key and the divided circle."""
        note, scales = self._row_place(_NOTE_PLACE, _NOTE_WIDTH), {"engine": 1.0, "valve": self._section.scale}
        yield fixed(self._engine.background_shapes())
        yield from super().fixed_parts()
        yield fixed(self._section_axes.place((*block_shapes(self._section), *self._section.background_shapes())))
        yield fixed(self._key.background_shapes())
        yield fixed(self._dial.background_shapes())
        yield fixed(scale_note_shapes(note, _KEY_SIZE * self._width, scales))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield steam, piston and valve, the gear, the section of the valve, and the diagram of the last turn."""
        yield from self._engine_parts
        yield from self._section_axes.place_parts(self._section_parts())
        yield from self._key.moving_parts(self, self.position_at)
        yield Flexible(shapes_at=self._curve_shapes)
        yield from self._dial.crank_parts(self.position_at)

    @cached_property
    def _engine_parts(self) -> tuple[DrawnPart, ...]:
        """Steam, piston and valve, and the gear."""
        return *self._engine.moving_parts(), *super().moving_parts()

    def named_places(self, poses: FloatArray) -> dict[str, FloatArray]:
        """Return the places (n, 2) m of the bodies, and of valve and piston where the engine has them, at poses (n, bodies, 3)."""
        positions = [self.position(pose, float(self.run.times[0])) for pose in poses]
        valve, piston = (np.array([place(one) for one in positions]) for place in (self._engine.valve_place, self._engine.piston_place))
        return super().named_places(poses) | {self.valve_line.point.body: valve, "piston": piston}

    def _section_parts(self) -> Iterator[DrawnPart]:
        """Yield the ports with their steam, and the valve."""
        for side in (1.0, -1.0):
            yield from port_parts(self._section, partial(self.phase_at, side), side)
        rod_end = _ROD_END * self._section.half_length
        yield from self._section.valve_parts(lambda moment: self.position_at(moment).valve_displacement, rod_end, rod_moves=False)

    def _curve_shapes(self, moment: Moment) -> Iterator[DrawnShape]:
        """Yield the displacements of the turn before."""
        position = self.position_at(moment)
        sense = position.sense
        angles, displacements = zeuner_dial.turn_before(sense * self.crank_angles, self.displacements, sense * position.crank_angle)
        yield from self._dial.curve_shapes(sense * angles, displacements)

    @cached_property
    def _engine(self) -> EngineInPlace:
        return EngineInPlace(self)

    @cached_property
    def _engine_shapes(self) -> Sequence[DrawnShape]:
        """The shapes of the engine with its gear at times of the run."""
        shapes = [*self._engine.background_shapes(), *shapes_of(super().fixed_parts(), self.first_moment)]
        for k in range(0, len(self.poses), max(1, len(self.poses) // _N_SAMPLES)):
            shapes += shapes_of(self._engine_parts, Moment(self.poses[k], float(self.run.times[k])))
        return shapes

    @cached_property
    def _upper_box(self) -> BoundingBox:
        """Box (m) of the part of the picture with engine and gear, as wide as suits the height of the whole."""
        left, right, bottom, top = bounding_box(self._engine_shapes)
        filled_width = _ASPECT_RATIO * (top - bottom) / (1.0 - _ASPECT_RATIO * _ROW_HEIGHT)
        margin = max(0.5 * (filled_width - (right - left)), 0.0)
        return left - margin, right + margin, bottom, top

    @property
    def _width(self) -> float:
        left, right, _, _ = self._upper_box
        return right - left

    @property
    def _crank_side(self) -> float:
        """-1 if the crank end lies at the left."""
        return -1.0 if self.piston_line.direction[0] >= 0.0 else 1.0

    def _row_place(self, start: float, width: float) -> Vec2:
        """Return the upper left corner (m) of what begins in the row at a distance from the side of the shaft, in widths of the picture."""
        left, right, bottom, _ = self._upper_box
        x = left + start * self._width if self._crank_side < 0 else right - (start + width) * self._width
        return x, bottom - _ROW_GAP * self._width

    @cached_property
    def _section(self) -> SteamChest:
        """The chest at a larger scale."""
        unit = make_chest(self, 1.0)
        return make_chest(self, _SECTION_WIDTH * self._width / ((1.0 + _ROD_END) * unit.half_length))

    @cached_property
    def _section_axes(self) -> Placement:
        """Axes in the middle of the face of the section; x leads to the side of the picture where the shaft is."""
        left, top = self._row_place(0.0, _SECTION_WIDTH)
        side, chest = self._crank_side, self._section
        x = left + (_ROD_END if side < 0 else 1.0) * chest.half_length
        return Placement(origin=(x, top - chest.top), x_axis=(side, 0.0), y_axis=(0.0, 1.0))

    @cached_property
    def _key(self) -> SteamKey:
        return SteamKey(self._row_place(_KEY_PLACE, _NOTE_PLACE - _KEY_PLACE), _KEY_SIZE * self._width, -self._crank_side)

    @cached_property
    def _dial(self) -> zeuner_dial.ZeunerDial:
        """The valve diagram: in the largest free corner beside the engine, or else beyond the row below it."""
        left, right, bottom, top = box = self._upper_box
        smallest, largest = (radius * self._width for radius in _DIAL_RADII)
        (x, y), side = find_free_corner(self._engine_shapes, box)
        radius = min(0.5 * side / _DIAL_ROOM, largest)
        if radius < smallest:
            radius, y = smallest, bottom  # at the far end of the row
            x = right + 2 * _DIAL_ROOM * radius if self._crank_side < 0 else left - 2 * _DIAL_ROOM * radius
        inward = _DIAL_ROOM * radius
        place = x + math.copysign(inward, left + 0.5 * self._width - x), y + math.copysign(inward, 0.5 * (bottom + top) - y)
        return zeuner_dial.ZeunerDial(self, place, radius, self.crank_end_angle)

"""What a film draws over the elevation of one part: rotation, paths, forces, names and an angle, with the space that these need."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.results.film_options import FilmOptions
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.label_placement import LABEL_HEIGHT, LETTER_WIDTH, PlacedLabel, place_labels
from governor_mechanism.render.film.labels import AngleArc, find_labels
from governor_mechanism.render.film.layout import PixelView
from governor_mechanism.render.film.overlays import ForceArrows, box_with_rotation_arrow, rotation_arrow, shows_bodies, trace_shapes
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Lines, TextShape
from governor_mechanism.render.style import INK

AddText = Callable[..., Any]
"""Writes words at a position (pixels) with a height (pixels) and a colour."""


class ElevationOverlay:
    """Shapes over the elevation of a part in a box (m), as chosen by options; `box` (m) has space for them."""

    def __init__(self, data: FrameData, box: BoundingBox, options: FilmOptions) -> None:
        self._data = data
        self.static_shapes: list[DrawnShape] = []
        self.box = box
        turns = data.part.plane == TURNING_PLANE and bool(np.ptp(data.spindle_angle) > 0.0)
        if turns:
            self.static_shapes += rotation_arrow(data, box)
            self.box = box_with_rotation_arrow(box)
        if options.traces:
            self.static_shapes += trace_shapes(data)
        self.arrows = ForceArrows(data, box, is_shown=options.forces)
        self.box = self.arrows.enclosing_box(self.box)
        self._angle = AngleArc(data) if options.labels else None
        self._labels = [*find_labels(data), *self._angle.labels] if self._angle is not None else []
        if self._labels and not shows_bodies(data):
            # Words of such a drawing reach beyond its box where it is scaled down.
            left, right, bottom, top = self.box
            self.box = left, right + 0.15 * (right - left), bottom, top
        self._placed: list[PlacedLabel] = []

    @property
    def label_width(self) -> float:
        """Width of the column of names, pixels; zero without names."""
        return max((LETTER_WIDTH * LABEL_HEIGHT * len(label.name) + 10.0 for label in self._labels), default=0.0)

    def place_labels(self, view: PixelView, add_text: AddText, shift: float) -> None:
        """Write the names at the right of a view."""
        words = [shape for shape in self.static_shapes if isinstance(shape, TextShape)]
        self._placed = place_labels(self._data, self._labels, view, words)
        for label in self._placed:
            add_text(label.name, (view.rect[2] + 6.0 - shift, label.height), LABEL_HEIGHT, color=INK)

    def parts(self) -> Iterator[DrawnPart]:
        """Yield the parts that move, whose moments are the numbers of the frames."""
        yield from self.arrows.parts()
        if self._angle is not None:
            yield Flexible(shapes_at=self._angle.shapes_at)
        if self._placed:
            yield Flexible(shapes_at=self._label_lines)

    def _label_lines(self, k: int) -> list[DrawnShape]:
        return [Lines("label line", tuple(piece for label in self._placed for piece in label.lines[k]))]

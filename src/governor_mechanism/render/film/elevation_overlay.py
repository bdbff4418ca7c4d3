"""What a film draws over the elevation of one part: rotation, paths, forces, names and an angle, with the space that these need."""

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.labels import AngleArc, Label, find_labels
from governor_mechanism.render.film.layout import PixelView
from governor_mechanism.render.film.options import FilmOptions
from governor_mechanism.render.film.overlays import ForceArrows, box_with_rotation_arrow, rotation_arrow, shows_bodies, trace_shapes
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Lines, Vec2
from governor_mechanism.render.style import INK

LABEL_HEIGHT, LABEL_PITCH = 9.5, 15.0
"""Height of a name, and smallest distance to the next, pixels."""
_LETTER_WIDTH = 0.62
"""Width of a letter relative to its height, about that of the widest words."""

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
        labels = [*find_labels(data), *self._angle.labels] if self._angle is not None else []
        middle = len(data.times) // 2
        # From the top, so that their lines do not cross.
        self._labels = sorted(labels, key=lambda label: -float(label.points[middle, 1]))
        if labels and not shows_bodies(data):
            # Words of such a drawing reach beyond its box where it is scaled down.
            left, right, bottom, top = self.box
            self.box = left, right + 0.15 * (right - left), bottom, top
        # Where the lines of the names begin, m.
        self._starts: list[Vec2] = []

    @property
    def label_width(self) -> float:
        """Width of the column of names, pixels; zero without names."""
        return max((_LETTER_WIDTH * LABEL_HEIGHT * len(label.name) + 10.0 for label in self._labels), default=0.0)

    def place_labels(self, view: PixelView, add_text: AddText, shift: float) -> None:
        """Write the names at the right of a view, each about as high as its part in the middle of the film."""
        left, top, right, bottom = view.rect
        middle = len(self._data.times) // 2
        heights = [(top + bottom) / 2 - (float(label.points[middle, 1]) - view.y) * view.scale for label in self._labels]
        for label, y in zip(self._labels, _spread(heights, top + LABEL_PITCH, bottom - LABEL_PITCH), strict=True):
            add_text(label.name, (right + 6.0 - shift, y), LABEL_HEIGHT, color=INK)
            self._starts.append((view.x + (right + 2.0 - (left + right) / 2) / view.scale, view.y - (y - (top + bottom) / 2) / view.scale))

    def shapes_at(self, k: int) -> Iterable[DrawnShape]:
        """Yield the shapes of frame k."""
        yield from self.arrows.shapes_at(k)
        if self._angle is not None:
            yield from self._angle.shapes_at(k)
        lines = [(start, _point_of(label, k)) for start, label in zip(self._starts, self._labels, strict=True)]
        if lines:
            yield Lines("label line", tuple(lines))


def _point_of(label: Label, k: int) -> Vec2:
    return float(label.points[k, 0]), float(label.points[k, 1])


def _spread(heights: list[float], top: float, bottom: float) -> list[float]:
    """Return heights (pixels, downward, in order) moved apart to LABEL_PITCH, between top and bottom."""
    placed = [max(y, top) for y in heights]
    for k in range(1, len(placed)):
        placed[k] = max(placed[k], placed[k - 1] + LABEL_PITCH)
    if placed and placed[-1] > bottom:
        placed[-1] = bottom
        for k in range(len(placed) - 2, -1, -1):
            placed[k] = min(placed[k], placed[k + 1] - LABEL_PITCH)
    return placed

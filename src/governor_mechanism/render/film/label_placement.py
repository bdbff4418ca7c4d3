"""Where the names beside a drawing stand: each about as high as its part, with a line to it that avoids words and scales.

A line that cannot avoid them is broken there.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.render.film.labels import Label
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.pixel_view import PixelView
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, TextShape, Vec2, bounding_box
from governor_mechanism.types import FloatArray, IntArray

Piece = tuple[Vec2, Vec2]
"""Both ends of a piece of a line, m."""
_MIN_STEP = 1e-12
"""Smallest extent (m) of a line along an axis: a shorter one is divided by this."""


def shares_within(starts: FloatArray, ends: FloatArray, boxes: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the shares of lines from starts (..., 2) to ends (..., 2) at which they enter and leave boxes (..., 4).

    A line passes its box if it enters it before it leaves it.
    """
    enters = np.zeros(np.broadcast_shapes(starts.shape[:-1], ends.shape[:-1], boxes.shape[:-1]))
    leaves = np.ones_like(enters)
    for axis in (0, 1):
        start, step = starts[..., axis], ends[..., axis] - starts[..., axis]
        step = np.where(np.abs(step) < _MIN_STEP, _MIN_STEP, step)
        first, second = ((boxes[..., 2 * axis + k] - start) / step for k in (0, 1))
        enters, leaves = np.maximum(enters, np.minimum(first, second)), np.minimum(leaves, np.maximum(first, second))
    return enters, leaves


def break_lines(start: Vec2, ends: FloatArray, boxes: FloatArray) -> list[tuple[Piece, ...]]:
    """Return the pieces of lines from a start to ends (f, 2) m outside of boxes (n, 4) m: equally many for each, some of them empty."""
    enters, leaves = shares_within(np.array(start), ends[:, None], boxes[None])
    is_passed = (enters < leaves).any(axis=0)
    enters, leaves = enters[:, is_passed], leaves[:, is_passed]
    return [_break_line(start, (x, y), gaps) for (x, y), gaps in zip(ends.tolist(), np.stack([enters, leaves], axis=-1), strict=True)]


def _break_line(start: Vec2, end: Vec2, gaps: FloatArray) -> tuple[Piece, ...]:
    """Return the pieces of a line without gaps (n, 2), whose ends are shares of the line; a gap that ends before it begins is none."""

    def point(share: float) -> Vec2:
        return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])

    pieces, reached = [], 0.0
    for enters, leaves in sorted(gaps.tolist()):
        if enters < leaves and leaves > reached:
            pieces.append((point(reached), point(max(enters, reached))))
            reached = leaves
    pieces.append((point(reached), end))
    return (*pieces, *[(end, end)] * (len(gaps) + 1 - len(pieces)))


LABEL_HEIGHT, LABEL_PITCH = 9.5, 15.0
"""Height of a name, and smallest distance to the next, pixels."""
LETTER_WIDTH = 0.62
"""Width of a letter relative to its height, about that of the widest words."""
LINE_START = 2.0
"""Distance (pixels) of the start of a line from the drawing, at its right."""
_TEXT_HEIGHT, _MARGIN = 8.5, 2.0
"""Height of the words of a drawing, and the distance that a line keeps from them and from scales, pixels."""
_SCALE_ROLES = frozenset({"scale", "pointer"})
"""Roles of shapes off which a value is read."""
_EMPTY_BOX: BoundingBox = (1e9, -1e9, 1e9, -1e9)
"""A box (m) that no line passes."""
_MAX_FRAMES = 24
"""Number of frames at which crossings are counted: a line moves little between them."""
_STEP = 2.5
"""Distance of the compared heights, pixels."""
_CROSSING_COST = 400.0
"""Displacement (pixels) of a name that is worth one crossing at every frame: a name moves for each that it can avoid."""


@dataclass(frozen=True, kw_only=True)
class PlacedLabel:
    """A name, its middle height (pixels from the top), and the pieces (m) of the line to its part at each frame."""

    name: str
    height: float
    lines: Sequence[tuple[Piece, ...]]


def place_labels(data: FrameData, labels: Sequence[Label], view: PixelView, others: Sequence[DrawnShape] = ()) -> list[PlacedLabel]:
    """Return the names from the top, in the order of their parts in the middle of the film, so that their lines do not cross.

    `others` are shapes that are drawn besides the machine.
    """
    if not labels:
        return []
    top, bottom = view.rect[1] + LABEL_PITCH, view.rect[3] - LABEL_PITCH
    heights = np.linspace(top, bottom, max(round((bottom - top) / _STEP), 2) + 1)
    frames = np.unique(np.linspace(0, len(data.times) - 1, _MAX_FRAMES).astype(int))
    fixed = list(_boxes_of([*data.drawing.static_shapes, *others], view))
    boxes = _boxes_at(data, frames, view, fixed)
    chosen = [_choose_points(label, view, heights, frames, boxes) for label in labels]
    middle = len(data.times) // 2
    order = sorted(range(len(labels)), key=lambda k: -float(chosen[k][0][middle, 1]))
    natural = [view.row_of(float(chosen[k][0][middle, 1])) for k in order]
    costs = np.array([_CROSSING_COST * chosen[k][1] + np.abs(heights - y) for k, y in zip(order, natural, strict=True)])
    rows = _choose_heights(heights, costs) or _spread(natural, top, bottom)
    fixed_boxes = np.array(fixed).reshape(-1, 4)

    def place(k: int, row: float) -> PlacedLabel:
        start = view.line_x(LINE_START), view.height_of(row)
        return PlacedLabel(name=labels[k].name, height=row, lines=break_lines(start, chosen[k][0], fixed_boxes))

    return [place(k, row) for k, row in zip(order, rows, strict=True)]


def _boxes_at(data: FrameData, frames: IntArray, view: PixelView, fixed: Sequence[BoundingBox]) -> FloatArray:
    """Return the boxes (f, n, 4) m of words and scales at frames, those that are fixed and those that move; some are empty."""
    by_frame = [[*fixed, *_boxes_of(data.drawing.moving_shapes(data.poses[k], float(data.times[k])), view)] for k in frames.tolist()]
    count = max(map(len, by_frame))
    return np.array([[*boxes, *[_EMPTY_BOX] * (count - len(boxes))] for boxes in by_frame]).reshape(len(by_frame), count, 4)


def _boxes_of(shapes: Iterable[DrawnShape], view: PixelView) -> Iterable[BoundingBox]:
    """Yield the boxes (m) of words and scales, with their margins."""
    for shape in shapes:
        margin = _MARGIN / view.scale
        if isinstance(shape, TextShape):
            width, half_height = LETTER_WIDTH * _TEXT_HEIGHT * len(shape.text) / view.scale, 0.5 * _TEXT_HEIGHT / view.scale
            yield shape.x - margin, shape.x + width + margin, shape.y - half_height - margin, shape.y + half_height + margin
        elif shape.role in _SCALE_ROLES:
            left, right, low, high = bounding_box([shape])
            yield left - margin, right + margin, low - margin, high + margin


def _choose_points(
    label: Label, view: PixelView, heights: FloatArray, frames: FloatArray, boxes: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the point (f, 2) m of a name, and by height (h,) the mean number of crossings: of its points, the first with the fewest."""
    starts = np.column_stack([np.full(len(heights), view.line_x(LINE_START)), [view.height_of(row) for row in heights.tolist()]])
    counted = [(points, _count_crossings(starts, points[frames], boxes)) for points in (label.points, *label.other_points)]
    return min(counted, key=lambda one: float(one[1].min()))


def _count_crossings(starts: FloatArray, ends: FloatArray, boxes: FloatArray) -> FloatArray:
    """Return the mean number (h,) of boxes (f, n, 4) that lines cross from starts (h, 2) to an end (f, 2) that moves."""
    if not boxes.shape[1]:
        return np.zeros(len(starts))
    enters, leaves = shares_within(starts[:, None, None], ends[None, :, None], boxes[None])
    crossings: FloatArray = (enters < leaves).sum(axis=2).mean(axis=1)
    return crossings


def _choose_heights(heights: FloatArray, costs: FloatArray) -> list[float] | None:
    """Return the heights (n,) of names in order, LABEL_PITCH apart, with the least sum of costs (n, h); None if there is no space.

    From the top, the least cost of all names so far is known for each height of the last one.
    """
    apart = int(np.ceil(LABEL_PITCH / (heights[1] - heights[0]) - 1e-9))
    totals, choices = costs[0], []
    for cost in costs[1:]:
        best = np.minimum.accumulate(totals)
        before = np.concatenate([np.full(apart, np.inf), best])[: len(totals)]
        choices.append(totals)
        totals = cost + before
    if not np.isfinite(totals).any():
        return None
    chosen = [int(totals.argmin())]
    for totals_before in reversed(choices):
        chosen.append(int(totals_before[: chosen[-1] - apart + 1].argmin()))
    return [float(heights[k]) for k in reversed(chosen)]


def _spread(heights: list[float], top: float, bottom: float) -> list[float]:
    """Return heights (pixels, downward, in order) moved apart to LABEL_PITCH, between top and bottom if there is space."""
    placed = [max(y, top) for y in heights]
    for k in range(1, len(placed)):
        placed[k] = max(placed[k], placed[k - 1] + LABEL_PITCH)
    if placed and placed[-1] > bottom:
        placed[-1] = bottom
        for k in range(len(placed) - 2, -1, -1):
            placed[k] = min(placed[k], placed[k + 1] - LABEL_PITCH)
    return placed

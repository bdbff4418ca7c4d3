"""Names of the parts of a machine on a film, each about as high as its part, with a line to it; and the arc of the main angle.

A line avoids words and scales; one that cannot is broken there.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from governor_mechanism.mechanics.kinematics.points import point_path
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import (
    SMALL_TEXT,
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    PixelView,
    Polygon,
    TextShape,
    Vec2,
    arc_points,
    bounding_box,
)
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.page.part_names import name_part
from governor_mechanism.render.shown_readings import format_name
from governor_mechanism.types import FloatArray, IntArray

MAX_LABELS = 10
"""Largest number of names: more would be denser than the drawing."""
MAX_PLACES = 6
"""Largest number of shapes of one name to which its line may lead."""
_UNNAMED = frozenset(
    {
        *("", "angle", "applied load", "axis", "divisions", "ground", "guide", "impact", "marked spoke", "pin", "pointer", "projection"),
        *("reaction", "rim", "scale", "shaft", "slot", "spoke"),
    }
)
"""Names that say what the drawing shows anyway."""
_NEAR = 0.03
"""Distance of two parts, relative to the length scale, below which only the first is named: their lines would end at one point."""
_ARC_RADIUS = 0.3
"""Radius of the arc of the angle, relative to the length of the arm."""


@dataclass(frozen=True, kw_only=True)
class Label:
    """A name and the point (f, 2) m of its part at each frame; `other_points` are those of its other shapes."""

    name: str
    points: FloatArray
    other_points: tuple[FloatArray, ...] = ()


def find_labels(data: FrameData) -> list[Label]:
    """Return the names of the parts.

    Bodies of a mechanism of one's own have names; other parts are known by the roles of their shapes.
    """
    middle = len(data.times) // 2
    labels = _labels_of_bodies(data, data.drawing) if isinstance(data.drawing, GenericDrawing) else _labels_of_roles(data, middle)
    return labels[:MAX_LABELS]


def _labels_of_bodies(data: FrameData, drawing: GenericDrawing) -> list[Label]:
    return [Label(name=format_name(name), points=points) for name, points in drawing.named_places(data.poses).items()]


def _labels_of_roles(data: FrameData, middle: int) -> list[Label]:
    """Return a label for each name: of its shapes, first the one furthest to the right in the middle of the film."""
    count, drawing = len(data.times), data.drawing
    frames = [list(drawing.moving_shapes(pose, float(time))) for pose, time in zip(data.poses, data.times, strict=True)]
    found: dict[str, list[tuple[float, FloatArray]]] = {}
    for position, shape in enumerate(chain(frames[middle], drawing.static_shapes)):
        name, anchor = name_part(shape.role, data.part.machine, "")[0], _anchor(shape)
        if name in _UNNAMED or "steam" in name or name.startswith("pressure") or anchor is None:
            continue
        is_moving = position < len(frames[middle])
        points = [_anchor(frame[position]) or anchor for frame in frames] if is_moving else [anchor] * count
        found.setdefault(name, []).append((anchor[0], np.array(points)))
    near, labels = _NEAR * data.part.mechanism.length_scale, list[Label]()
    for name, places in found.items():
        first, *others = (points for _, points in sorted(places, key=lambda place: -place[0])[:MAX_PLACES])
        if all(math.dist(first[middle], other.points[middle]) > near for other in labels):
            labels.append(Label(name=name, points=first, other_points=tuple(others)))
    return labels


def _anchor(shape: DrawnShape) -> Vec2 | None:
    """Return a point in the middle of a shape, or None for an empty one or words."""
    match shape:
        case Circle(_, x, y, _):
            return x, y
        case Polygon(_, points) if points:
            return _mean(points)
        case Lines(_, lines) if lines:
            return lines[0][len(lines[0]) // 2]
        case _:
            return None


def _mean(points: Sequence[Vec2]) -> Vec2:
    return sum(x for x, _ in points) / len(points), sum(y for _, y in points) / len(points)


class AngleArc:
    """Arc from the downward vertical to the line whose angle is the leading reading of a governor; nothing for another reading.

    `labels` has its name.
    """

    def __init__(self, data: FrameData) -> None:
        mechanism = data.part.mechanism
        readings = (one for one in mechanism.readings if one.name == mechanism.coordinate)
        reading = next((one for one in readings if isinstance(one, LineAngle)), None)
        self.labels: list[Label] = []
        if reading is None:
            return
        self._origins, ends = (point_path(mechanism, data.poses, point) for point in (reading.start, reading.end))
        x, y = (ends - self._origins).T
        self._angles, self._radius = np.arctan2(x, -y), _ARC_RADIUS * float(np.hypot(x[0], y[0]))
        middle = self._radius * np.column_stack([np.sin(0.5 * self._angles), -np.cos(0.5 * self._angles)])
        self.labels.append(Label(name=format_name(reading.name), points=self._origins + middle))

    def shapes_at(self, k: int) -> list[DrawnShape]:
        """Return the arc and the vertical from which it counts."""
        if not self.labels:
            return []
        x, y = self._origins[k].tolist()
        arc = arc_points((x, y), -math.pi / 2, float(self._angles[k]), self._radius, 24)
        return [Lines("angle ray", (((x, y), (x, y - 1.25 * self._radius)),)), Lines("angle arc", (arc,))]


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


LABEL_HEIGHT, LABEL_PITCH = SMALL_TEXT, 16.0
"""Height of a name, and smallest distance to the next, pixels."""
LETTER_WIDTH = 0.62
"""Width of a letter relative to its height, about that of the widest words."""
LINE_START = 2.0
"""Distance (pixels) of the start of a line from the drawing, at its right."""
_TEXT_HEIGHT, _MARGIN = SMALL_TEXT, 2.0
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
    """Return the names from the top, in the order in which their lines cross least over the film.

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
    order = choose_order(np.array([points[frames] for points, _ in chosen]), (view.line_x(LINE_START), view.y))
    natural = [view.row_of(float(chosen[k][0][middle, 1])) for k in order]
    costs = np.array([_CROSSING_COST * chosen[k][1] + np.abs(heights - y) for k, y in zip(order, natural, strict=True)])
    rows = _choose_heights(heights, costs) or _spread(natural, top, bottom)
    fixed_boxes = np.array(fixed).reshape(-1, 4)

    def place(k: int, row: float) -> PlacedLabel:
        start = view.line_x(LINE_START), view.height_of(row)
        return PlacedLabel(name=labels[k].name, height=row, lines=break_lines(start, chosen[k][0], fixed_boxes))

    return [place(k, row) for k, row in zip(order, rows, strict=True)]


def choose_order(points: FloatArray, start: Vec2) -> list[int]:
    """Return the order from the top in which lines from near a start (m), at the right, to points (n, f, 2) m cross least.

    Two lines cross at a frame where the upper one leads to the flatter direction. The order is improved by moving one line at a time.
    """
    slopes = (points[..., 1] - start[1]) / np.maximum(start[0] - points[..., 0], _MIN_STEP)
    crossings = (slopes[:, None] < slopes[None]).sum(axis=2)  # of a line, by row, above another, by column
    order: list[int] = np.argsort(-slopes.mean(axis=1), kind="stable").tolist()

    def count(rows: Sequence[int]) -> int:
        return int(np.triu(crossings[np.ix_(rows, rows)], 1).sum())

    best = count(order)
    while True:
        moved = [
            [*rest[:place], one, *rest[place:]] for one in order for rest in [[k for k in order if k != one]] for place in range(len(order))
        ]
        candidate = min(moved, key=count, default=order)
        if count(candidate) >= best:
            return order
        order, best = candidate, count(candidate)


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

"""Labels in a film: what they name, and where they stand clear of each other and of what is drawn.

A line avoids words and scales; one that cannot is broken there.

A name keeps its height while its part moves. Where two lines cross all the same, the lower one has a gap.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, combinations

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
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
    is_wording,
)
from governor_mechanism.render.page.part_names import name_part
from governor_mechanism.render.shown_readings import format_name
from governor_mechanism.types import BoolArray, FloatArray, IntArray

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
    """Return the names of the parts, of bodies of one's own mechanism, or by the roles of their shapes."""
    from governor_mechanism.render.machines.generic.drawing import GenericDrawing  # slow to import, and only for names

    if isinstance(data.drawing, GenericDrawing):
        labels = [Label(name=format_name(name), points=points) for name, points in data.drawing.named_places(data.poses).items()]
    else:
        labels = _labels_of_roles(data, len(data.times) // 2)
    return labels[:MAX_LABELS]


def _labels_of_roles(data: FrameData, middle: int) -> list[Label]:
    """Return a label for each name: of its shapes, first the one furthest to the right in the middle of the film."""
    count, drawing = len(data.times), data.drawing
    frames = [list(drawing.moving_shapes(pose, float(time))) for pose, time in zip(data.poses, data.times, strict=True)]
    found: dict[str, list[tuple[float, FloatArray]]] = {}
    for position, shape in enumerate(chain(frames[middle], drawing.static_shapes)):
        name, _, _ = name_part(shape.role, data.part.machine, "")[0].partition(",")  # without what a page says of its state
        anchor = _anchor(shape)
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
    """Return a point in the middle of a shape, or None for an empty one, words or a key."""
    if is_wording(shape):
        return None
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
    """Return the shares of lines at which they enter and leave boxes (..., 4); one passes its box if it enters it first."""
    enters = np.zeros(np.broadcast_shapes(starts.shape[:-1], ends.shape[:-1], boxes.shape[:-1]))
    leaves = np.ones_like(enters)
    for axis in (0, 1):
        start, step = starts[..., axis], ends[..., axis] - starts[..., axis]
        step = np.where(np.abs(step) < _MIN_STEP, _MIN_STEP, step)
        first, second = ((boxes[..., 2 * axis + k] - start) / step for k in (0, 1))
        enters = np.maximum(enters, np.minimum(first, second))
        leaves = np.minimum(leaves, np.maximum(first, second))
    return enters, leaves


def break_lines(start: Vec2, ends: FloatArray, boxes: FloatArray, other_gaps: FloatArray | None = None) -> list[tuple[Piece, ...]]:
    """Return the pieces of lines from a start to ends (f, 2) m outside of boxes (n, 4) m and other gaps (f, m, 2), as shares of lines.

    They are equally many for each line, some of them empty.
    """
    enters, leaves = shares_within(np.array(start), ends[:, None], boxes[None])
    is_passed = (enters < leaves).any(axis=0)
    gaps = np.stack([enters[:, is_passed], leaves[:, is_passed]], axis=-1)
    if other_gaps is not None:
        gaps = np.concatenate([gaps, other_gaps], axis=1)
    return [_break_line(start, (x, y), one) for (x, y), one in zip(ends.tolist(), gaps, strict=True)]


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
_MIN_NUMBER_PITCH = 10.0
"""Smallest distance (pixels) of the middles of two numbers of a scale."""
_MAX_FRAMES = 24
"""Number of frames at which crossings are counted: a line moves little between them."""
_STEP = 4.0
"""Distance of the compared heights, pixels."""
_WORD_COST, _LINE_COST = 400.0, 1000.0
"""Displacement (pixels) of a name that is worth one crossing at every frame, with a word or a scale, and with another line."""
_MAX_SWEEPS = 8
"""Number of times that all names are moved; two or three suffice mostly."""
_MIN_GAIN = 1e-6
"""Smallest gain (pixels) for which a name moves."""
_MIN_WIDTH = 1e-12
"""Smallest length (m) of a line: a shorter one is divided by this."""
_HALF_GAP = 4.0
"""Half the gap (pixels) of a line where another one crosses it."""


@dataclass(frozen=True, kw_only=True)
class PlacedLabel:
    """A name, its middle height (pixels from the top), and the pieces (m) of the line to its part at each frame."""

    name: str
    height: float
    lines: Sequence[tuple[Piece, ...]]


def place_labels(data: FrameData, labels: Sequence[Label], view: PixelView, resting: Sequence[DrawnShape]) -> list[PlacedLabel]:
    """Return the names from the top, at heights and with lines that cross little over the film, neither each other nor resting words."""
    if not labels:
        return []
    frames = np.unique(np.linspace(0, len(data.times) - 1, _MAX_FRAMES).astype(int))
    fixed = list(_boxes_of(resting, view))
    boxes = _boxes_at(data, frames, view, fixed)
    points = [np.array([label.points, *label.other_points]) for label in labels]
    rows, chosen = _Places(view, [one[:, frames] for one in points], boxes).choose()
    order = np.argsort(rows).tolist()
    ends = np.array([points[k][chosen[k]] for k in order])
    starts = np.array([(view.line_x(LINE_START), view.height_of(rows[k])) for k in order])
    gaps = _gaps_at_crossings(starts, ends, _HALF_GAP / view.scale)
    fixed_boxes = np.array(fixed).reshape(-1, 4)

    def place(place: int, k: int) -> PlacedLabel:
        lines = break_lines(starts[place], ends[place], fixed_boxes, gaps[place])
        return PlacedLabel(name=labels[k].name, height=rows[k], lines=lines)

    return [place(position, k) for position, k in enumerate(order)]


def thin_out_numbers(shapes: Sequence[DrawnShape], view: PixelView) -> list[DrawnShape]:
    """Return shapes without the numbers of a scale that would touch the one above them in a view: words do not shrink with it."""
    lowest: dict[float, float] = {}
    touching = set[int]()
    for shape in sorted((one for one in shapes if isinstance(one, TextShape)), key=lambda one: -one.y):
        column = round(shape.x, 9)
        is_near = lowest.get(column, math.inf) - shape.y < _MIN_NUMBER_PITCH / view.scale
        if is_near and shape.text.replace(".", "").isdigit():
            touching.add(id(shape))
        else:
            lowest[column] = shape.y
    return [shape for shape in shapes if id(shape) not in touching]


class _Places:
    """Search for the heights of names in a view and the points (a, f, 2) m of each to which its line leads."""

    # Costs (pixels) are the distances of its point, along and across, and those of words and scales in boxes (f, n, 4) m and of other lines
    # that its line crosses.

    def __init__(self, view: PixelView, points: Sequence[FloatArray], boxes: FloatArray) -> None:
        top, bottom = view.rect[1] + LABEL_PITCH, view.rect[3] - LABEL_PITCH
        self._rows = np.linspace(top, bottom, max(round((bottom - top) / _STEP), 2) + 1)
        self._apart = int(np.ceil(LABEL_PITCH / (self._rows[1] - self._rows[0]) - 1e-9))
        self._x, self._points = view.line_x(LINE_START), points
        self._heights = np.array([view.height_of(row) for row in self._rows.tolist()])
        starts = np.column_stack([np.full(len(self._heights), self._x), self._heights])
        words = [np.array([_count_crossings(starts, one, boxes) for one in ends]) for ends in points]
        steps = [view.scale * np.abs(ends[:, None] - starts[:, None]) for ends in points]
        self._lengths = [np.hypot(one[..., 0], one[..., 1]).mean(axis=-1) for one in steps]
        self._costs = [_WORD_COST * word + one.sum(axis=-1).mean(axis=-1) for word, one in zip(words, steps, strict=True)]
        self._places: IntArray = np.zeros(len(points), dtype=np.int64)
        self._chosen: IntArray = np.zeros(len(points), dtype=np.int64)

    def choose(self) -> tuple[list[float], list[int]]:
        """Return the row (pixels from the top) of each name, and the number of its point."""
        if (len(self._points) - 1) * self._apart >= len(self._rows):
            return np.linspace(self._rows[0], self._rows[-1], len(self._points))[self._order()].tolist(), self._chosen.tolist()
        self._begin()
        for _ in range(_MAX_SWEEPS):
            moved = [self._move(k) for k in range(len(self._points))]
            swapped = [self._swap(*pair) for pair in combinations(range(len(self._points)), 2)]
            if not any(moved + swapped):
                break
        return self._rows[self._places].tolist(), self._chosen.tolist()

    def _order(self) -> IntArray:
        """Return the place of each name in the order in which the first points follow each other from the top."""
        means = [-float(one[0, :, 1].mean()) for one in self._points]
        places: IntArray = np.argsort(np.argsort(means, kind="stable"), kind="stable")
        return places

    def _begin(self) -> None:
        """Put the names at equal distances, and exchange them as long as lines get shorter: those of parts at rest then do not cross."""
        places = np.linspace(0, len(self._rows) - 1, len(self._points)).astype(int)[self._order()]
        lengths = [one[0] for one in self._lengths]
        is_shorter = True
        while is_shorter:
            is_shorter = False
            for i, j in combinations(range(len(places)), 2):
                (a, b), (first, second) = places[[i, j]], (lengths[i], lengths[j])
                if first[b] + second[a] < first[a] + second[b] - _MIN_GAIN:
                    places[[i, j]] = b, a
                    is_shorter = True
        self._places = places

    def _costs_at(self, k: int, places: IntArray, others: Sequence[int]) -> FloatArray:
        """Return the costs (a, p) of the points of a name at places, beside other names."""
        costs: FloatArray = self._costs[k][:, places]
        if not others:
            return costs
        other_ends = np.array([self._points[j][self._chosen[j]] for j in others])
        heights = self._heights[places][:, None, None]
        other_heights = self._heights[self._places[others]][:, None]
        crossed = _lines_cross(self._x, heights, self._points[k][:, None, None], other_heights, other_ends)
        total: FloatArray = costs + _LINE_COST * crossed.mean(axis=-1).sum(axis=-1)
        return total

    def _cost_of(self, k: int, others: Sequence[int]) -> float:
        """Return the costs of a name as it stands, beside other names."""
        return float(self._costs_at(k, self._places[[k]], others)[self._chosen[k], 0])

    def _move(self, k: int) -> bool:
        """Move a name to the best of the free places; return whether one is better."""
        others = [j for j in range(len(self._points)) if j != k]
        distances = np.abs(np.arange(len(self._rows))[:, None] - self._places[others])
        free = np.flatnonzero((distances >= self._apart).all(axis=1))
        costs = self._costs_at(k, free, others)
        point, place = np.unravel_index(int(costs.argmin()), costs.shape)
        if costs[point, place] >= self._cost_of(k, others) - _MIN_GAIN:
            return False
        self._places[k], self._chosen[k] = free[place], point
        return True

    def _swap(self, first: int, second: int) -> bool:
        """Let two names change places if that is better, and return whether they did."""
        rest = [j for j in range(len(self._points)) if j not in (first, second)]
        pair = [first, second]
        places = self._places.copy()
        chosen = self._chosen.copy()
        before = self._cost_of(first, rest) + self._cost_of(second, [*rest, first])
        self._places[pair] = places[[second, first]]
        after = 0.0
        for k, others in ((first, rest), (second, [*rest, first])):
            costs = self._costs_at(k, self._places[[k]], others)[:, 0]
            self._chosen[k] = costs.argmin()
            after += costs.min()
        if after < before - _MIN_GAIN:
            return True
        self._places, self._chosen = places, chosen
        return False


def _lines_cross(x: float, heights: FloatArray, ends: FloatArray, other_heights: FloatArray, other_ends: FloatArray) -> BoolArray:
    """Return whether lines from heights (...) at x (m) to ends (..., 2) at its left cross others: their order changes on the shorter."""
    shorter = np.maximum(ends[..., 0], other_ends[..., 0])

    def height_there(start: FloatArray, end: FloatArray) -> FloatArray:
        share: FloatArray = (x - shorter) / np.maximum(x - end[..., 0], _MIN_WIDTH)
        return start + share * (end[..., 1] - start)

    above = height_there(heights, ends) - height_there(other_heights, other_ends)
    crossed: BoolArray = (heights - other_heights) * above < 0.0
    return crossed


def _gaps_at_crossings(starts: FloatArray, ends: FloatArray, half_gap: float) -> list[FloatArray]:
    """Return the gaps (f, m, 2), shares of lines from starts (n, 2) to ends (n, f, 2) m, where earlier ones cross; none ends first."""
    steps = ends - starts[:, None]
    return [_gaps_of_line(starts[: k + 1], steps[: k + 1], half_gap) for k in range(len(starts))]


def _gaps_of_line(starts: FloatArray, steps: FloatArray, half_gap: float) -> FloatArray:
    """Return the gaps (f, m, 2) of the last of some lines, from starts by steps, where the others cross it."""
    (*_, own), between = steps, starts[:-1, None] - starts[-1]
    determinant = _cross(own, steps[:-1])
    determinant = np.where(determinant == 0.0, np.inf, determinant)  # parallel lines do not cross
    share = _cross(between, steps[:-1]) / determinant
    other_share = _cross(between, own) / determinant
    is_crossed = (share > 0.0) & (share < 1.0) & (other_share > 0.0) & (other_share < 1.0)
    reach = half_gap / np.maximum(np.hypot(*own.T), _MIN_WIDTH)
    gaps = np.stack([np.where(is_crossed, share - reach, 1.0), np.where(is_crossed, share + reach, 0.0)], axis=-1)
    clipped: FloatArray = np.moveaxis(gaps[is_crossed.any(axis=1)], 0, 1).clip(0.0, 1.0)
    return clipped


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the z component of the vector products of vectors (..., 2)."""
    product: FloatArray = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return product


def _boxes_at(data: FrameData, frames: IntArray, view: PixelView, fixed: Sequence[BoundingBox]) -> FloatArray:
    """Return the boxes (f, n, 4) m of words and scales at frames, those that are fixed and those that move; some are empty."""
    by_frame = [[*fixed, *_boxes_of(data.drawing.moving_shapes(data.poses[k], float(data.times[k])), view)] for k in frames.tolist()]
    count = max(map(len, by_frame))
    return np.array([[*boxes, *[_EMPTY_BOX] * (count - len(boxes))] for boxes in by_frame]).reshape(len(by_frame), count, 4)


def _boxes_of(shapes: Iterable[DrawnShape], view: PixelView) -> Iterator[BoundingBox]:
    """Yield the boxes (m) of words and scales, with their margins."""
    for shape in shapes:
        margin = _MARGIN / view.scale
        if isinstance(shape, TextShape):
            width = LETTER_WIDTH * _TEXT_HEIGHT * len(shape.text) / view.scale
            half_height = 0.5 * _TEXT_HEIGHT / view.scale
            yield shape.x - margin, shape.x + width + margin, shape.y - half_height - margin, shape.y + half_height + margin
        elif shape.role in _SCALE_ROLES:
            left, right, low, high = bounding_box([shape])
            yield left - margin, right + margin, low - margin, high + margin


def _count_crossings(starts: FloatArray, ends: FloatArray, boxes: FloatArray) -> FloatArray:
    """Return the mean number (h,) of boxes (f, n, 4) that lines cross from starts (h, 2) to an end (f, 2) that moves."""
    if not boxes.shape[1]:
        return np.zeros(len(starts))
    enters, leaves = shares_within(starts[:, None, None], ends[None, :, None], boxes[None])
    crossings: FloatArray = (enters < leaves).sum(axis=2).mean(axis=1)
    return crossings

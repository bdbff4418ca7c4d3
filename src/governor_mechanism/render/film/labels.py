"""Names of the parts of a machine on a film, each about as high as its part, with a line to it; and the arc of the main angle.

A line avoids words and scales; one that cannot is broken there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from governor_mechanism.mechanics.kinematics.points import point_path
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, Vec2, arc_points
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.page.part_names import name_part
from governor_mechanism.render.shown_readings import format_name
from governor_mechanism.types import FloatArray

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
    """Return the shares of lines at which they enter and leave boxes (..., 4); one passes its box if it enters it first."""
    enters = np.zeros(np.broadcast_shapes(starts.shape[:-1], ends.shape[:-1], boxes.shape[:-1]))
    leaves = np.ones_like(enters)
    for axis in (0, 1):
        start, step = starts[..., axis], ends[..., axis] - starts[..., axis]
        step = np.where(np.abs(step) < _MIN_STEP, _MIN_STEP, step)
        first, second = ((boxes[..., 2 * axis + k] - start) / step for k in (0, 1))
        enters, leaves = np.maximum(enters, np.minimum(first, second)), np.minimum(leaves, np.maximum(first, second))
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

"""A drawing at several moments: the poses of what moves as a whole, and the points of what changes its form."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np

from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Frame, fixed_axes
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    TextShape,
    Vec2,
    bounding_box,
    enclose_boxes,
)
from governor_mechanism.types import BoolArray, FloatArray

_STRETCH = 32
"""Number of moments whose shapes are kept at a time: the garbage collector searches millions of points again and again."""

_KINDS = {Circle: "circle", Polygon: "polygon", Lines: "lines", TextShape: "text"}

Outline = tuple[int, ...]
"""Number of points of each polyline of a shape: one number for a polygon."""


@dataclass(frozen=True, kw_only=True)
class RecordedShape:
    """A shape at n moments; lengths in the unit of its drawing."""

    part: DrawnPart  # the part of the drawing to which it belongs
    # role, kind: role of its style; "circle", "polygon", "lines" or "text"
    role: str
    kind: str
    outline: Outline  # number of points of each polyline
    poses: FloatArray | None  # poses (n, 3) of its axes; None for axes that do not move
    # points in its axes; shape (1 or n, points, 2). While the shape is hidden they are those of another
    # moment.
    points: FloatArray
    visible: BoolArray  # whether there is anything to show; shape (n,)
    radii: FloatArray  # radii of a circle; shape (1 or n,); empty for other shapes
    text: str = ""  # content of a text
    text_width: float = 0.0  # width that is reserved for it
    # where the number of points changes, those in the axes at each moment, a tuple of polylines (m, 2);
    # else empty
    changing: tuple[tuple[FloatArray, ...], ...] = ()

    def placed_points(self) -> FloatArray:
        """Return the points in the plane; shape (1 or n, points, 2)."""
        return self.points if self.poses is None else move_points(self.poses, self.points)

    def placed_lines(self) -> Iterator[tuple[FloatArray, ...]]:
        """Yield the polylines (m, 2) in the plane at each moment, of a shape whose number of points changes."""
        for k, lines in enumerate(self.changing):
            yield lines if self.poses is None else tuple(move_points(self.poses[k : k + 1], line)[0] for line in lines)


def record_parts(parts: Sequence[DrawnPart], moments: Sequence[Any]) -> list[RecordedShape]:
    """Return the shapes of the parts of a drawing at moments, back to front, without those that are never there."""
    poses = _record_frames(dict.fromkeys(part.frame for part in parts if part.frame is not fixed_axes), moments)
    recorded: list[RecordedShape] = []
    for part in parts:
        if isinstance(part, Flexible):
            recorded += _record_flexible(part, poses.get(part.frame), moments)
        else:
            visible = np.array([part.is_shown(moment) for moment in moments])
            recorded += (_record_attached(part, shape, poses.get(part.frame), visible) for shape in part.shapes)
    return [shape for shape in recorded if shape.visible.any()]


def move_points(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (points, 2) or (n, points, 2) in axes, at poses (n, 3) of these; shape (n, points, 2)."""
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x, y = points[..., 0], points[..., 1]
    return np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=-1)


def enclose_recorded(shapes: Iterable[RecordedShape]) -> BoundingBox:
    """Return the smallest box around shapes at all moments at which they are visible; around nothing, as `bounding_box`."""
    box = bounding_box(())
    for shape in shapes:
        changing = [line for lines in shape.placed_lines() for line in lines]
        points = np.concatenate(changing)[np.newaxis] if changing else shape.placed_points()
        rows = shape.visible if len(points) == len(shape.visible) else slice(None)
        radii = shape.radii[rows] if len(shape.radii) > 1 else shape.radii if len(shape.radii) else np.zeros(1)
        x, y = (points[rows][..., axis] for axis in (0, 1))
        radius = radii[:, np.newaxis]
        own = float((x - radius).min()), float((x + radius).max()) + shape.text_width, float((y - radius).min()), float((y + radius).max())
        box = enclose_boxes([box, own])
    return box


def horizontal_extents(
    shapes: Iterable[RecordedShape],
    bottom: float,  # bottom, top: the heights
    top: float,
) -> list[Vec2]:
    """Return the horizontal extent of each circle and each convex polygon between two heights, at each moment at which it is there."""
    extents = list[Vec2]()
    for shape in shapes:
        points = shape.placed_points()
        if shape.kind == "circle":
            distance = np.maximum(np.maximum(bottom - points[:, 0, 1], points[:, 0, 1] - top), 0.0)
            half = np.sqrt(np.maximum(shape.radii**2 - distance**2, 0.0))
            lows = points[:, 0, 0] - half
            highs = points[:, 0, 0] + half
            is_there = half > 0.0
        elif shape.kind == "polygon":
            lows, highs = _extents_of_edges(points, np.roll(points, -1, axis=1), bottom, top)
            is_there = lows <= highs
        else:
            continue
        extents += zip(lows[is_there].tolist(), highs[is_there].tolist(), strict=True)
    return extents


def _extents_of_edges(starts: FloatArray, ends: FloatArray, bottom: float, top: float) -> tuple[FloatArray, FloatArray]:
    """Return the least and the largest x (n,) of edges (n, edges, 2) between two heights; infinite the other way where there is none."""
    is_rising = (starts[..., 1] <= ends[..., 1])[..., np.newaxis]
    (x0, y0), (x1, y1) = (np.moveaxis(np.where(is_rising, *pair), -1, 0) for pair in ((starts, ends), (ends, starts)))
    is_within = (y1 >= bottom) & (y0 <= top)
    rise = np.where(y1 > y0, y1 - y0, 1.0)
    heights = [np.clip(height, y0, y1) for height in (bottom, top)]
    ends_within = [np.where(y1 > y0, x0 + (x1 - x0) * (one - y0) / rise, end) for one, end in zip(heights, (x0, x1), strict=True)]
    lows = np.where(is_within, np.minimum(*ends_within), np.inf).min(axis=1)
    highs = np.where(is_within, np.maximum(*ends_within), -np.inf).max(axis=1)
    return lows, highs


def _record_frames(frames: Iterable[Frame], moments: Sequence[Any]) -> dict[Frame, FloatArray]:
    """Return the poses (n, 3) of axes at moments; their angles are continuous."""
    ordered = list(frames)
    # Moment by moment: axes of one drawing follow from the same positions.
    rows = np.array([[frame(moment) for frame in ordered] for moment in moments]).reshape(len(moments), len(ordered), 3)
    rows[..., 2] = np.unwrap(rows[..., 2], axis=0)
    return {frame: rows[:, k] for k, frame in enumerate(ordered)}


def _record_attached(part: Attached, shape: DrawnShape, poses: FloatArray | None, visible: BoolArray) -> RecordedShape:
    """Return an attached shape over time."""
    lines = _polylines_of(shape)
    points = np.array(list(chain.from_iterable(lines)), dtype=float).reshape(1, -1, 2)
    has_content = points.size > 0 and not (isinstance(shape, Circle) and not shape.radius > 0.0)
    return RecordedShape(
        part=part,
        role=shape.role,
        kind=_KINDS[type(shape)],
        outline=tuple(len(line) for line in lines),
        poses=poses,
        points=points,
        visible=visible & has_content,
        radii=np.array([shape.radius] if isinstance(shape, Circle) else []),
        text=shape.text if isinstance(shape, TextShape) else "",
        text_width=shape.width if isinstance(shape, TextShape) else 0.0,
    )


@dataclass(frozen=True, kw_only=True)
class _Stretch:
    """One shape at some moments: outlines, the points (m, 2) of all one after the other, and radii of a circle."""

    outlines: Sequence[Outline]
    points: FloatArray
    radii: FloatArray


def _record_flexible(part: Flexible, poses: FloatArray | None, moments: Sequence[Any]) -> Iterator[RecordedShape]:
    """Yield the shapes of a part that change their form."""
    stretches = []
    for start in range(0, len(moments), _STRETCH):
        columns = zip(*(tuple(part.shapes_at(moment)) for moment in moments[start : start + _STRETCH]), strict=True)
        stretches.append([_read_stretch(column) for column in columns])
    for first, column in zip(part.shapes_at(moments[0]), zip(*stretches, strict=True), strict=True):
        yield _record_column(part, poses, first, column)


def _read_stretch(column: Sequence[DrawnShape]) -> _Stretch:
    """Return one shape at some moments."""
    polylines = [_polylines_of(shape) for shape in column]
    points = np.array([point for lines in polylines for line in lines for point in line], dtype=float).reshape(-1, 2)
    radii = np.array([shape.radius for shape in column if isinstance(shape, Circle)])
    return _Stretch(outlines=[tuple(len(line) for line in lines) for lines in polylines], points=points, radii=radii)


def _record_column(part: Flexible, poses: FloatArray | None, first: DrawnShape, stretches: Sequence[_Stretch]) -> RecordedShape:
    """Return one shape over time."""
    outlines = [outline for stretch in stretches for outline in stretch.outlines]
    points = np.concatenate([stretch.points for stretch in stretches])
    radii = np.concatenate([stretch.radii for stretch in stretches])
    counts = np.array([sum(outline) for outline in outlines])
    starts = np.cumsum(counts) - counts
    visible = counts > 0 if not len(radii) else radii > 0.0
    shown = sorted({outline for outline in outlines if sum(outline)})
    outline = shown[0] if len(shown) == 1 else ()
    frames: tuple[tuple[FloatArray, ...], ...] = ()
    placed = np.zeros((len(outlines), 0, 2))
    if len(shown) > 1:
        frames = tuple(_split_lines(points[start:], one) for start, one in zip(starts.tolist(), outlines, strict=True))
    elif shown:
        rows = starts[_nearest_visible(visible)]
        placed = points[rows[:, None] + np.arange(sum(outline))]
    return RecordedShape(
        part=part,
        role=first.role,
        kind=_KINDS[type(first)],
        outline=outline,
        poses=poses,
        points=placed,
        visible=visible,
        radii=radii,
        text=first.text if isinstance(first, TextShape) else "",
        text_width=first.width if isinstance(first, TextShape) else 0.0,
        changing=frames,
    )


def _split_lines(points: FloatArray, outline: Outline) -> tuple[FloatArray, ...]:
    """Return the polylines (m, 2) of an outline whose points (n, 2) come first, without empty ones."""
    ends = np.cumsum(outline, dtype=int)
    return tuple(points[end - length : end] for end, length in zip(ends.tolist(), outline, strict=True) if length)


def _polylines_of(shape: DrawnShape) -> Sequence[Sequence[Vec2]]:
    """Return the polylines of a shape; one point for a circle and a text."""
    match shape:
        case Polygon(_, points):
            return (points,)
        case Lines(_, lines):
            return lines
        case _:
            return (((shape.x, shape.y),),)


def _nearest_visible(visible: BoolArray) -> list[int]:
    """Return for each moment the last visible one up to it, or the first visible one of all."""
    rows = np.where(visible, np.arange(len(visible)), -1)
    rows = np.maximum.accumulate(rows)
    rows[rows < 0] = int(np.argmax(visible))
    chosen: list[int] = rows.tolist()
    return chosen


SPHERE_ROLE = "ball"
SEEN_AS = {"weight section": SPHERE_ROLE}
"""Role that a shape in section has from outside."""

_MAX_RATIO = 0.018
"""Largest half thickness of a bar or plate, relative to the larger side of the drawing; a weight is as thick as it is high."""
_PIN_LENGTH_RATIO = 1.6
"""Half the length of a pin, relative to its radius: it ends outside the bars that it joins."""


def find_half_thickness(shape: RecordedShape, size: float) -> float | None:
    """Return half the thickness of a shape of a drawing whose larger side is `size`, or None for what does not turn."""
    # The thickness of a ball is its diameter, and that of a bar its width.
    if not shape.part.turns or shape.part.section_only or shape.changing or shape.kind == "text" or not shape.points.size:
        return None
    if shape.kind == "circle":
        radius = float(shape.radii[0])
        return radius if shape.role == SPHERE_ROLE else _PIN_LENGTH_RATIO * radius
    if shape.kind == "lines":
        return 0.0
    outline = shape.points[0] - shape.points[0].mean(axis=0)
    _, _, axes = np.linalg.svd(outline, full_matrices=False)
    half_width = float(np.ptp(outline @ axes.T, axis=0).min()) / 2
    return half_width if SEEN_AS.get(shape.role, shape.role) == SPHERE_ROLE else min(half_width, _MAX_RATIO * size)

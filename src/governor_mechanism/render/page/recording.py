"""Shapes of a drawing at all sample times, in the coordinates of the picture: x to the right and y down, in 1/10 000 of its larger side."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, Polygon, TextShape, Vec2
from governor_mechanism.types import FloatArray

PICTURE_SIZE = 10_000
"""Length of the larger side of a picture: all positions are rounded to one unit, less than a tenth of a pixel on most screens."""

_MIN_GAIN = 0.25
"""Squared change of an outline that begins at another point, relative to that without, below which it begins there."""

_STRETCH = 32
"""Number of samples whose shapes are kept at a time: with millions of points, the garbage collector would search them again and again."""

Outline = tuple[int, ...]
"""Number of points of each polyline of a shape: one number for a polygon."""


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Map from the plane of a drawing (m) to a picture that shows a box (m)."""

    box: BoundingBox

    @property
    def scale(self) -> float:
        """Units of the picture per metre."""
        left, right, bottom, top = self.box
        return PICTURE_SIZE / max(right - left, top - bottom)

    @property
    def size(self) -> Vec2:
        """Width and height of the picture."""
        left, right, bottom, top = self.box
        return (right - left) * self.scale, (top - bottom) * self.scale

    def place(self, points: FloatArray) -> FloatArray:
        """Return the positions in the picture of points (..., 2) m."""
        left, _, _, top = self.box
        return np.stack([(points[..., 0] - left) * self.scale, (top - points[..., 1]) * self.scale], axis=-1)

    def place_poses(self, poses: FloatArray) -> FloatArray:
        """Return poses (..., 3) m and rad in the picture; angles become clockwise, as y points down."""
        return np.concatenate([self.place(poses[..., :2]), -poses[..., 2:]], axis=-1)


@dataclass(frozen=True, kw_only=True)
class RecordedShape:
    """A shape over time.

    Attributes
    ----------
    role, kind
        Role of its style; "circle", "polygon", "lines" or "text".
    outline
        Number of points of each polyline.
    points
        Positions in the picture; shape (samples, points, 2). While the shape is hidden they are those of another time.
    visible
        Whether there is anything to show; shape (samples,).
    radii
        Radii of a circle; shape (samples,); empty for other shapes.
    text
        Content of a text.
    changing
        Points of each sample, where their number changes: a tuple of polylines (m, 2) for each sample; else empty.
    """

    role: str
    kind: str
    outline: Outline
    points: FloatArray
    visible: NDArray[np.bool_]
    radii: FloatArray
    text: str = ""
    changing: tuple[tuple[FloatArray, ...], ...] = ()


def record_shapes(picture: Picture, shapes_at: Callable[[int], Sequence[DrawnShape]], n_samples: int) -> list[RecordedShape]:
    """Return the shapes at samples 0 to `n_samples` - 1, back to front; every sample has the same shapes."""
    stretches = []
    for start in range(0, n_samples, _STRETCH):
        columns = zip(*(shapes_at(k) for k in range(start, min(start + _STRETCH, n_samples))), strict=True)
        stretches.append([_read_stretch(column) for column in columns])
    return [_record_column(picture, first, column) for first, column in zip(shapes_at(0), zip(*stretches, strict=True), strict=True)]


@dataclass(frozen=True, kw_only=True)
class _Stretch:
    """One shape at some samples: the outline at each, the points (m, 2) of all one after the other, m, and the radii of a circle, m."""

    outlines: Sequence[Outline]
    points: FloatArray
    radii: FloatArray


def _read_stretch(column: Sequence[DrawnShape]) -> _Stretch:
    """Return one shape at some samples."""
    polylines = [_polylines_of(shape) for shape in column]
    points = np.array([point for lines in polylines for line in lines for point in line], dtype=float).reshape(-1, 2)
    radii = np.array([shape.radius for shape in column if isinstance(shape, Circle)])
    return _Stretch(outlines=[tuple(len(line) for line in lines) for lines in polylines], points=points, radii=radii)


def _record_column(picture: Picture, first: DrawnShape, stretches: Sequence[_Stretch]) -> RecordedShape:
    """Return one shape over time."""
    kind = {Circle: "circle", Polygon: "polygon", Lines: "lines", TextShape: "text"}[type(first)]
    outlines = [outline for stretch in stretches for outline in stretch.outlines]
    points = picture.place(np.concatenate([stretch.points for stretch in stretches]))
    radii = np.concatenate([stretch.radii for stretch in stretches]) * picture.scale
    counts = np.array([sum(outline) for outline in outlines])
    starts = np.cumsum(counts) - counts
    visible = counts > 0 if not len(radii) else radii > 0.0
    shown = sorted({outline for outline in outlines if sum(outline)})
    text = first.text if isinstance(first, TextShape) else ""
    if len(shown) > 1:
        frames = tuple(_split_lines(points[start:], outline) for start, outline in zip(starts.tolist(), outlines, strict=True))
        empty = np.zeros((len(outlines), 0, 2))
        return RecordedShape(role=first.role, kind=kind, outline=(), points=empty, visible=visible, radii=radii, changing=frames)
    outline = shown[0] if shown else ()
    rows = starts[_nearest_visible(visible)]
    placed = points[rows[:, None] + np.arange(sum(outline))] if shown else np.zeros((len(outlines), 0, 2))
    if kind == "polygon":
        placed = align_outlines(placed)
    return RecordedShape(role=first.role, kind=kind, outline=outline, points=placed, visible=visible, radii=radii, text=text)


def _split_lines(points: FloatArray, outline: Outline) -> tuple[FloatArray, ...]:
    """Return the polylines (m, 2) of an outline whose points (n, 2) come first, without empty ones."""
    ends = np.cumsum(outline, dtype=int)
    return tuple(points[end - length : end] for end, length in zip(ends.tolist(), outline, strict=True) if length)


def align_outlines(points: FloatArray) -> FloatArray:
    """Return closed outlines (samples, points, 2) of which each begins at the point where the one before began.

    A drawing may begin at another corner at every pose, such as the leftmost one; then no point of its outline would move with the body.
    """
    n_samples, n_points, _ = points.shape
    if n_samples < 2 or n_points < 2:
        return points
    changes = np.stack([((np.roll(points[1:], -shift, axis=1) - points[:-1]) ** 2).sum(axis=(1, 2)) for shift in range(n_points)])
    best = changes.argmin(axis=0)
    steps = np.where(changes[best, np.arange(n_samples - 1)] < _MIN_GAIN * changes[0], best, 0)
    shifts = np.concatenate([[0], np.cumsum(steps)]) % n_points
    if not shifts.any():
        return points
    columns = (np.arange(n_points) + shifts[:, None]) % n_points
    aligned: FloatArray = points[np.arange(n_samples)[:, None], columns]
    return aligned


def _polylines_of(shape: DrawnShape) -> Sequence[Sequence[Vec2]]:
    """Return the polylines of a shape; one point for a circle and a text."""
    match shape:
        case Polygon(_, points):
            return (points,)
        case Lines(_, lines):
            return lines
        case _:
            return (((shape.x, shape.y),),)


def _nearest_visible(visible: NDArray[np.bool_]) -> list[int]:
    """Return for each sample the last visible one up to it, or the first visible one of all."""
    rows = np.where(visible, np.arange(len(visible)), -1)
    rows = np.maximum.accumulate(rows)
    rows[rows < 0] = int(np.argmax(visible))
    chosen: list[int] = rows.tolist()
    return chosen

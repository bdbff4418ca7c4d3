"""A governor from outside: its spindle turns, and what turns with it passes in front of the axis and behind it.

What turns is projected and sorted by depth; bodies of revolution and the frame look the same from all sides. Which is which is stated by
the parts of the drawing.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np

from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    Polygon,
    TextShape,
    Vec2,
    arc_points,
    convex_hull,
)
from governor_mechanism.render.geometry.recording import SEEN_AS, SPHERE_ROLE, RecordedShape, find_half_thickness, record_parts
from governor_mechanism.types import BoolArray, FloatArray

EYE_DISTANCE_RATIO = 12.0
"""Distance of the eye from the axis, relative to the reach of the machine: far, for a slight perspective."""


@dataclass(frozen=True, kw_only=True)
class TurnedPlane:
    """A plane through the axis x = 0, turned by an angle and seen by an eye in front of the axis."""

    # rotation of the plane, anticlockwise seen from above, rad: what was at the right passes behind the
    # axis first
    angle: float
    reach: float  # largest distance of the machine from the axis, m
    middle: float  # height of the eye, m

    def depths(self, points: FloatArray, offset: float = 0.0) -> FloatArray:
        """Return how far points (n, 2) are in front of the axis (n,), m; they are `offset` (m) before the plane."""
        depths: FloatArray = -points[:, 0] * math.sin(self.angle) + offset * math.cos(self.angle)
        return depths

    def sizes(self, depths: FloatArray) -> FloatArray:
        """Return how much larger than at the axis things at depths (n,) m appear."""
        sizes: FloatArray = 1.0 / (1.0 - depths / (EYE_DISTANCE_RATIO * self.reach))
        return sizes

    def project(self, points: FloatArray, offset: float = 0.0) -> FloatArray:
        """Return where points (n, 2) at an offset (m) from the plane are seen; shape (n, 2)."""
        size = self.sizes(self.depths(points, offset))
        across = points[:, 0] * math.cos(self.angle) + offset * math.sin(self.angle)
        return np.column_stack([across * size, self.middle + (points[:, 1] - self.middle) * size])

    def project_plate(self, outline: FloatArray, half_thickness: float) -> FloatArray:
        """Return the seen outline (m, 2) of a plate without dents, from its outline (n, 2) and half its thickness."""
        return hull_of(np.concatenate([self.project(outline, -half_thickness), self.project(outline, half_thickness)]))


def hull_of(points: FloatArray) -> FloatArray:
    """Return the corners (m, 2) of the convex hull of points (n, 2), anticlockwise."""
    return np.array(convex_hull([(x, y) for x, y in points.tolist()])).reshape(-1, 2)


def area_of(outline: FloatArray) -> float:
    """Return the area within a closed outline (n, 2), m2."""
    following = np.roll(outline, -1, axis=0)
    return 0.5 * abs(float(np.sum(outline[:, 0] * following[:, 1] - following[:, 0] * outline[:, 1])))


_PIN_CORNERS = 16
"""Number of corners that stand for the rim of a pin."""
_DENTED_RATIO = 0.9
"""Area of an outline relative to that of its hull below which the outline has dents, so that its hull would show what is not there."""
_PIN_REACH_RATIO = 2.4
"""Distance from the centre of a pin, relative to its radius, within which the outline of a plate passes that the pin holds."""
_SUNK_RATIO = 0.9
"""Distance from the centre of a ball, relative to its radius, at which a bar that ends in it is cut off: just inside."""
_PIN_LEAD = 1e-9
"""Depth (m) of a pin's end in front of its plates: far more than rounding, and far less than the thickness of any part."""
_DEPTH_DECIMALS = 12
"""Decimals of a depth (m) that count: far more than any thickness needs, and far fewer than rounding changes."""
_HIGHLIGHTS = ((0.78, 42.0), (0.60, 30.0))
"""Radius relative to that of its ball, and half angle in degrees, of each arc of the light on a ball."""

Spheres = Sequence[tuple[FloatArray, float]]
"""Centre (2,) m and radius (m) of each ball in the turning plane."""


@dataclass(frozen=True, kw_only=True)
class _Solid:
    """A shape over the frames, positions in m from the axis: points (n or 1, m, 2), radii (n or 1,), where it is shown (n or 1,)."""

    # `half_thickness` is None for what does not turn or is round. `frames` are the polylines of a shape whose number of points changes.

    role: str
    kind: str
    outline: tuple[int, ...]
    points: FloatArray
    radii: FloatArray
    visible: BoolArray
    half_thickness: float | None
    text: str
    is_thin: bool
    frames: tuple[tuple[FloatArray, ...], ...]

    @property
    def is_sphere(self) -> bool:
        """Whether it looks round from all sides."""
        return self.kind == "circle" and self.role == SPHERE_ROLE and self.half_thickness is not None

    @property
    def is_pin(self) -> bool:
        """Whether it is a pin across the turning plane."""
        return self.kind == "circle" and self.half_thickness is not None and not self.is_sphere

    @property
    def n_shapes(self) -> int:
        """Number of shapes as which it is seen: a ball has the light on it beside its outline."""
        return 2 if self.is_sphere else 1

    def points_at(self, k: int) -> FloatArray:
        """Return the points (m, 2) at frame k."""
        points: FloatArray = self.points[min(k, len(self.points) - 1)]
        return points

    def radius_at(self, k: int) -> float:
        """Return the radius at frame k, m."""
        return float(self.radii[min(k, len(self.radii) - 1)]) if len(self.radii) else 0.0

    def is_visible_at(self, k: int) -> bool:
        """Return whether there is anything to show at frame k."""
        return bool(self.visible[min(k, len(self.visible) - 1)])


def outside_box(bounds: BoundingBox) -> BoundingBox:
    """Return the box (m) around a drawing with such bounds (m) in all positions of its spindle."""
    left, right, bottom, top = bounds
    half_width = max(abs(left), abs(right)) * (1.0 + 1.0 / EYE_DISTANCE_RATIO)
    return -half_width, half_width, bottom, top


class OutsideView:
    """The view of a part that turns with a spindle, at the frames of its data.

    Every frame has the same shapes, of the same kinds and roles, in the same order; `order_at` says which are in front.
    """

    def __init__(self, data: FrameData) -> None:
        self._data, drawing = data, data.drawing
        left, right, bottom, top = drawing.bounds
        self.reach, self._middle = max(abs(left), abs(right)), 0.5 * (bottom + top)
        size = max(right - left, top - bottom)
        moments = [data.moment_at(k) for k in range(len(data.times))]
        recorded = [*record_parts(drawing.fixed, moments[:1]), *record_parts(drawing.moving, moments)]
        shown = [shape for shape in recorded if not shape.part.section_only]
        solids = [piece for shape in shown for piece in _split_lines(_make_solid(shape, size))]
        self._balls = [solid for solid in solids if solid.is_sphere]
        self._solids = [solid for solid in solids if not _is_inside(solid, self._spheres_at(0))]
        self._pinned = [_plates_at(solid, self._solids) for solid in self._solids]

    def plane_at(self, k: int) -> TurnedPlane:
        """Return the turned plane of frame k."""
        return TurnedPlane(angle=float(self._data.spindle_angle[k]), reach=self.reach, middle=self._middle)

    def shapes_at(self, k: int) -> list[DrawnShape]:
        """Return the shapes of frame k as seen, in an order that is the same for all frames."""
        plane, spheres = self.plane_at(k), self._spheres_at(k)
        return [shape for solid in self._solids for shape in _seen_shapes(solid, k, plane, spheres)]

    def order_at(self, k: int) -> list[int]:
        """Return the numbers of the shapes of frame k from the furthest to the nearest."""
        plane = self.plane_at(k)
        depths = [_depth(solid, k, plane) for solid in self._solids]
        # A pin is as long as its plates are thick together, so it is seen in front of them.
        nearest = [max([depths[number], *(depths[plate] + _PIN_LEAD for plate in plates)]) for number, plates in enumerate(self._pinned)]
        by_shape = [depth for depth, solid in zip(nearest, self._solids, strict=True) for _ in range(solid.n_shapes)]
        # Of shapes at one depth, the later is in front, whatever the rounding.
        return sorted(range(len(by_shape)), key=lambda number: (round(by_shape[number], _DEPTH_DECIMALS), number))

    def _spheres_at(self, k: int) -> Spheres:
        return [(ball.points_at(k)[0], ball.radius_at(k)) for ball in self._balls]


def _make_solid(shape: RecordedShape, size: float) -> _Solid:
    """Return a recorded shape of a drawing whose larger side is `size` (m), with its thickness."""
    points = shape.placed_points()
    is_dented = len(points) > 0 and shape.kind == "polygon" and area_of(points[0]) < _DENTED_RATIO * area_of(hull_of(points[0]))
    return _Solid(
        role=SEEN_AS.get(shape.role, shape.role),
        kind=shape.kind,
        outline=shape.outline,
        points=points,
        radii=shape.radii,
        visible=shape.visible,
        half_thickness=find_half_thickness(shape, size),
        text=shape.text,
        is_thin=is_dented and shape.role not in SEEN_AS,
        frames=tuple(shape.placed_lines()),
    )


def _split_lines(solid: _Solid) -> Iterator[_Solid]:
    """Yield the polylines of a shape that turns as shapes of their own, so that each has its own depth."""
    if solid.kind != "lines" or solid.half_thickness is None:
        yield solid
        return
    for end, length in zip(accumulate(solid.outline), solid.outline, strict=True):
        yield replace(solid, points=solid.points[:, end - length : end], outline=(length,))


def _is_inside(solid: _Solid, spheres: Spheres) -> bool:
    """Return whether a pin is inside a ball at first, where it cannot be seen."""
    if not solid.is_pin:
        return False
    centre, radius = solid.points_at(0)[0], solid.radius_at(0)
    return any(math.dist(centre, middle) + radius < ball_radius for middle, ball_radius in spheres)


def _plates_at(pin: _Solid, solids: Sequence[_Solid]) -> list[int]:
    """Return the indices of the plates that a pin holds; none for another shape."""
    if not pin.is_pin:
        return []
    centre, reach = pin.points_at(0)[0], _PIN_REACH_RATIO * pin.radius_at(0)

    def is_near(solid: _Solid) -> bool:
        is_plate = solid.kind == "polygon" and solid.half_thickness is not None
        return is_plate and bool((np.hypot(*(solid.points_at(0) - centre).T) < reach).any())

    return [index for index, solid in enumerate(solids) if is_near(solid)]


def _depth(solid: _Solid, k: int, plane: TurnedPlane) -> float:
    """Return how far the nearest side of a shape is in front of the axis, m; what is round is at the axis."""
    if solid.half_thickness is None:
        return 0.0
    depth = float(plane.depths(solid.points_at(k)).mean())
    if solid.is_sphere:
        return depth + solid.radius_at(k)
    return depth + (0.0 if solid.is_thin else solid.half_thickness)


def _seen_shapes(solid: _Solid, k: int, plane: TurnedPlane, spheres: Spheres) -> Iterator[DrawnShape]:
    """Yield the `n_shapes` shapes as which a solid is seen at frame k; a ball with the light on it."""
    is_visible = solid.is_visible_at(k)
    points = solid.points_at(k) if len(solid.points) else np.zeros((0, 2))
    thickness = solid.half_thickness
    radius = solid.radius_at(k) if solid.is_visible_at(k) else 0.0
    if thickness is None:
        yield _flat_shape(solid, k, points if is_visible else points[:0], radius)
    elif solid.is_sphere:
        x, y = plane.project(points)[0].tolist()
        size = float(plane.sizes(plane.depths(points))[0])
        yield Circle(solid.role, x, y, radius * size)
        arcs = [arc_points((x, y), math.radians(135 - half), math.radians(2 * half), r * radius * size, 12) for r, half in _HIGHLIGHTS]
        yield Lines("ball shine", tuple(arcs) if radius else ())
    elif solid.kind == "lines":
        yield Lines(solid.role, (_as_points(plane.project(points)),) if is_visible else ())
    else:
        yield Polygon(solid.role, _as_points(_seen_outline(solid, points, radius, plane, spheres)) if is_visible else ())


def _seen_outline(solid: _Solid, points: FloatArray, radius: float, plane: TurnedPlane, spheres: Spheres) -> FloatArray:
    """Return the outline (n, 2) m of a pin, a plate or a bar as seen; what has dents has no thickness, and does not end in a ball."""
    if solid.is_thin:
        return plane.project(points)
    outline = _rim_points(points[0], radius) if solid.is_pin else _cut_at_spheres(points, spheres)
    return plane.project_plate(outline, solid.half_thickness or 0.0)


def _flat_shape(solid: _Solid, k: int, points: FloatArray, radius: float) -> DrawnShape:
    """Return a shape that looks the same from all sides."""
    if solid.frames:
        lines = tuple(_as_points(line) for line in solid.frames[min(k, len(solid.frames) - 1)])
        return Polygon(solid.role, lines[0] if lines else ()) if solid.kind == "polygon" else Lines(solid.role, lines)
    if solid.kind in ("circle", "text"):
        x, y = solid.points_at(k)[0].tolist()
        return Circle(solid.role, x, y, radius) if solid.kind == "circle" else TextShape(solid.role, x, y, solid.text, 0.0)
    if solid.kind == "polygon":
        return Polygon(solid.role, _as_points(points))
    ends = accumulate(solid.outline)
    return Lines(solid.role, tuple(_as_points(points[end - n : end]) for end, n in zip(ends, solid.outline, strict=True) if len(points)))


def _as_points(points: FloatArray) -> tuple[Vec2, ...]:
    return tuple((x, y) for x, y in points.tolist())


def _rim_points(centre: FloatArray, radius: float) -> FloatArray:
    """Return points (n, 2) of the rim of a circle."""
    angles = np.linspace(0.0, 2 * math.pi, _PIN_CORNERS, endpoint=False)
    rim: FloatArray = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    return rim


def _cut_at_spheres(points: FloatArray, spheres: Spheres) -> FloatArray:
    """Return the outline (n, 2) of a bar that ends in the middle of a ball, cut off at the surface: what is inside cannot be seen."""
    for centre, radius in spheres:
        middle = points.mean(axis=0) - centre
        distance = float(np.hypot(*middle))
        if distance < radius:
            continue
        direction, offsets = middle / distance, points - centre
        is_sunk = np.hypot(*offsets.T) <= radius
        missing = _SUNK_RATIO * radius - offsets @ direction
        points = np.where(is_sunk[:, None], points + missing[:, None] * direction, points)
    return points

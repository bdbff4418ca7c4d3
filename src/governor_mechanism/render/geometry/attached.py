"""Shapes of a drawing, made once: attached to axes that move, or drawn at every moment, as a spring, a belt or steam."""

import math
from collections.abc import Callable, Hashable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import wraps
from typing import Any, NamedTuple, TypeVar

from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Polygon, PoseTuple, TextShape, Vec2
from governor_mechanism.types import FloatArray

R = TypeVar("R")

Frame = Callable[[Any], PoseTuple]
"""Axes that move: their pose at a moment of the drawing, which for a machine is a `Moment`."""


def fixed_axes(moment: Any) -> PoseTuple:
    """Return the axes of what does not move."""
    return (0.0, 0.0, 0.0)


class Moment(NamedTuple):
    """What the drawing of a machine depends on: poses (bodies, 3) of its bodies, and a time (s)."""

    pose: FloatArray
    time: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Attached:
    """Shapes that move as one."""

    frame: Frame  # axes to which they are attached: those of a body, or of a part that the mechanism does not have
    shapes: tuple[DrawnShape, ...]  # shapes in these axes, back to front, m
    # whether they turn with the spindle, in a plane that turns; what is round or fixed to the frame looks
    # the same from all sides
    turns: bool = True
    section_only: bool = False  # whether only a section shows them, and not the view from outside
    shown: Callable[[Any], bool] | None = None  # whether they are there at a moment; always if None

    def is_shown(self, moment: Any) -> bool:
        """Return whether the shapes are there at a moment."""
        return self.shown is None or self.shown(moment)


@dataclass(frozen=True, kw_only=True, eq=False)
class Flexible:
    """As many shapes at every moment, of the same kinds and roles, in axes that may move; they turn and are cut as `Attached` ones."""

    shapes_at: Callable[[Any], Iterable[DrawnShape]]
    frame: Frame = fixed_axes
    turns: bool = False
    section_only: bool = False


DrawnPart = Attached | Flexible
"""A part of a drawing."""


def bar_between(role: str, ends_at: Callable[[Any], tuple[Vec2, Vec2]], width: float, *, length: float | None = None) -> DrawnPart:
    """Return a bar of a width (m) between two moving points, whose distance is a `length` (m), or changes if that is None."""
    if length is None:
        return Flexible(shapes_at=lambda moment: [make_bar(role, *ends_at(moment), width)])
    return Attached(frame=axes_along(ends_at), shapes=(make_bar(role, (0.0, 0.0), (length, 0.0), width),))


def fixed(shapes: Iterable[DrawnShape], *, turns: bool = False, section_only: bool = False) -> Attached:
    """Return shapes that do not move in the plane."""
    return Attached(frame=fixed_axes, shapes=tuple(shapes), turns=turns, section_only=section_only)


@dataclass(frozen=True)
class BodyAxes:
    """Axes of a body of a mechanism, by its index."""

    index: int

    def __call__(self, moment: Moment) -> PoseTuple:
        """Return the pose of the body."""
        x, y, angle = moment.pose[self.index].tolist()
        return x, y, angle


def axes_along(ends_at: Callable[[Any], tuple[Vec2, Vec2]]) -> Frame:
    """Return the axes of a bar between two points: the origin is the first one, and x leads to the second."""

    def frame(moment: Any) -> PoseTuple:
        (x, y), (end_x, end_y) = ends_at(moment)
        return x, y, math.atan2(end_y - y, end_x - x)

    return frame


def axes_turned(centre: Vec2, angle_at: Callable[[Any], float]) -> Frame:
    """Return the axes of what turns about a fixed centre (m), from an angle (rad) at a moment."""
    return lambda moment: (*centre, angle_at(moment))


def axes_shifted(place_at: Callable[[Any], Vec2]) -> Frame:
    """Return the axes of what moves with a point and does not turn."""

    def frame(moment: Any) -> PoseTuple:
        return *place_at(moment), 0.0

    return frame


_MAX_KEPT = 4096
"""Number of moments whose results are kept."""


def once_per_moment(method: Callable[[Any, Any], R]) -> Callable[[Any, Any], R]:
    """Return a method of a moment that keeps its results: many axes follow from the same positions."""
    name = f"_kept_{method.__name__}"

    @wraps(method)
    def kept(self: Any, moment: Any) -> R:
        # By identity: a pose has no hash. The moment is kept too, so that no other one takes its identity.
        results: dict[int, tuple[Any, R]] = self.__dict__.setdefault(name, {})
        found = results.get(id(moment))
        if found is None:
            if len(results) >= _MAX_KEPT:
                results.clear()
            found = results[id(moment)] = (moment, method(self, moment))
        return found[1]

    return kept


def place_shape(axes: PoseTuple, shape: DrawnShape) -> DrawnShape:
    """Return a shape given in axes (m, rad) where it stands in the plane; words stay upright."""
    x0, y0, angle = axes
    c, s = math.cos(angle), math.sin(angle)

    def place(line: tuple[Vec2, ...]) -> tuple[Vec2, ...]:
        return tuple([(x0 + c * x - s * y, y0 + s * x + c * y) for x, y in line])

    match shape:
        case Polygon(role, points):
            return Polygon(role, place(points))
        case Lines(role, lines):
            return Lines(role, tuple([place(line) for line in lines]))
        case Circle(role, x, y, radius):
            return Circle(role, *place(((x, y),))[0], radius)
        case TextShape(role, x, y, text, width):
            return TextShape(role, *place(((x, y),))[0], text, width)


def into_axes(axes: PoseTuple, shapes: Iterable[DrawnShape]) -> tuple[DrawnShape, ...]:
    """Return shapes of the plane in axes that have a pose (m, rad)."""
    x, y, angle = axes
    c, s = math.cos(angle), math.sin(angle)
    inverse = (-c * x - s * y, s * x - c * y, -angle)
    return tuple(place_shape(inverse, shape) for shape in shapes)


def hide_shape(shape: DrawnShape) -> DrawnShape:
    """Return a shape without anything to show."""
    match shape:
        case Circle(role, x, y, _):
            return Circle(role, x, y, 0.0)
        case Polygon(role, _):
            return Polygon(role, ())
        case Lines(role, _):
            return Lines(role, ())
        case TextShape(role, x, y, _, _):
            return TextShape(role, x, y, "", 0.0)


def own_shapes(part: DrawnPart, moment: Any) -> Iterable[DrawnShape]:
    """Return the shapes of a part in its axes at a moment."""
    return part.shapes_at(moment) if isinstance(part, Flexible) else part.shapes


def shapes_of(parts: Iterable[DrawnPart], moment: Any) -> Iterator[DrawnShape]:
    """Yield the shapes of parts where they stand at a moment, back to front."""
    poses: dict[Hashable, PoseTuple] = {}
    for part in parts:
        axes = poses.get(part.frame)
        if axes is None:
            axes = poses[part.frame] = part.frame(moment)
        is_shown = isinstance(part, Flexible) or part.is_shown(moment)
        for shape in own_shapes(part, moment):
            placed = shape if axes == (0.0, 0.0, 0.0) else place_shape(axes, shape)
            yield placed if is_shown else hide_shape(placed)


def at_own_moments(part: DrawnPart, own_moment: Callable[[Any], Any]) -> DrawnPart:
    """Return a part of a drawing as one of a larger drawing; `own_moment` is its moment at one of the larger drawing."""
    frame = part.frame if part.frame is fixed_axes else _OwnAxes(part.frame, own_moment)
    if isinstance(part, Flexible):
        shapes_at = part.shapes_at
        return replace(part, frame=frame, shapes_at=lambda moment: shapes_at(own_moment(moment)))
    shown = part.shown
    return replace(part, frame=frame, shown=None if shown is None else lambda moment: shown(own_moment(moment)))


@dataclass(frozen=True)
class _OwnAxes:
    """Axes of a drawing with moments of its own; equal for equal axes."""

    frame: Frame
    own_moment: Callable[[Any], Any]

    def __call__(self, moment: Any) -> PoseTuple:
        """Return their pose at a moment of the larger drawing."""
        return self.frame(self.own_moment(moment))


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Axes in the picture: their origin (m), and the vectors of one metre along x and along y, equally long; a left pair mirrors."""

    origin: Vec2
    x_axis: Vec2
    y_axis: Vec2

    def __call__(self, point: Vec2) -> Vec2:
        """Return the place (m) of a point given in the axes (m)."""
        x0, y0 = self.origin
        ax, ay = self.x_axis
        bx, by = self.y_axis
        x, y = point
        return x0 + x * ax + y * bx, y0 + x * ay + y * by

    def coordinates(self, place: Vec2) -> Vec2:
        """Return the point in the axes (m) that has a place (m)."""
        (ax, ay), (bx, by) = self.x_axis, self.y_axis
        x, y = place[0] - self.origin[0], place[1] - self.origin[1]
        return (ax * x + ay * y) / self.scale**2, (bx * x + by * y) / self.scale**2

    def place(self, shapes: Iterable[DrawnShape]) -> Iterator[DrawnShape]:
        """Yield shapes that are given in the axes; words stay upright and keep their width."""
        for shape in shapes:
            match shape:
                case Polygon(role, points):
                    yield Polygon(role, tuple(map(self, points)))
                case Lines(role, lines):
                    yield Lines(role, tuple(tuple(map(self, line)) for line in lines))
                case Circle(role, x, y, radius):
                    yield Circle(role, *self((x, y)), radius * math.hypot(*self.x_axis))
                case TextShape(role, x, y, text, width):
                    yield TextShape(role, *self((x, y)), text, width)

    @property
    def scale(self) -> float:
        """Length in the picture of one metre of the axes, m."""
        return math.hypot(*self.x_axis)

    def place_pose(self, pose: PoseTuple) -> PoseTuple:
        """Return the pose in the picture of axes that have a pose in these axes."""
        (ax, ay), (bx, by) = self.x_axis, self.y_axis
        handedness = math.copysign(1.0, ax * by - ay * bx)
        return *self(pose[:2]), math.atan2(ay, ax) + handedness * pose[2]

    def place_parts(self, parts: Iterable[DrawnPart]) -> Iterator[DrawnPart]:
        """Yield parts of a drawing that is given in the axes."""
        (ax, ay), (bx, by) = self.x_axis, self.y_axis
        # What is attached is scaled and mirrored in its own axes, and turned with these.
        handed_scale = math.copysign(self.scale, ax * by - ay * bx)
        own = Placement(origin=(0.0, 0.0), x_axis=(self.scale, 0.0), y_axis=(0.0, handed_scale))
        for part in parts:
            frame = _PlacedFrame(self, part.frame)
            if isinstance(part, Flexible):
                yield replace(part, frame=frame, shapes_at=_PlacedShapes(own, part))
            else:
                yield replace(part, frame=frame, shapes=tuple(own.place(part.shapes)))


@dataclass(frozen=True)
class _PlacedFrame:
    """Axes that are placed; equal for equal axes."""

    placement: Placement
    frame: Frame

    def __call__(self, moment: Any) -> PoseTuple:
        """Return their pose in the picture."""
        return self.placement.place_pose(self.frame(moment))


@dataclass(frozen=True, eq=False)
class _PlacedShapes:
    """Shapes of a flexible part that is placed."""

    placement: Placement
    part: Flexible

    def __call__(self, moment: Any) -> Iterator[DrawnShape]:
        """Yield them in the picture."""
        return self.placement.place(self.part.shapes_at(moment))

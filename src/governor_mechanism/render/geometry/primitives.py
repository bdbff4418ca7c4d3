"""Shapes of which drawings consist (lengths in metres, a role, no colours), points in axes and over a run, and the view in pixels."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain

import numpy as np

from governor_mechanism.mechanics.curves.outlines import outline_points
from governor_mechanism.mechanics.curves.segments import evaluate_polar_curve, make_curve_segments
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path, rotate_vector
from governor_mechanism.model.curves import PolarCurve
from governor_mechanism.model.force_elements import Damper, Force, Spring
from governor_mechanism.model.joints import CurveSlot, Gear, Pin, Point, RackAndPinion
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray

Vec2 = tuple[float, float]
"""Two coordinates x, y (m), or the two ends of an interval."""
PoseTuple = tuple[float, float, float]
"""Position x, y (m) and angle (rad)."""
BoundingBox = tuple[float, float, float, float]
"""left, right, bottom, top (m)."""


@dataclass(frozen=True, slots=True)
class Circle:
    """Filled circle with centre and radius (m)."""

    role: str
    x: float
    y: float
    radius: float


@dataclass(frozen=True, slots=True)
class Polygon:
    """Filled closed outline through `points` (m); empty if there is nothing to show."""

    role: str
    points: tuple[Vec2, ...]


@dataclass(frozen=True, slots=True)
class Lines:
    """Open polylines through points (m)."""

    role: str
    lines: tuple[tuple[Vec2, ...], ...]


@dataclass(frozen=True, slots=True)
class TextShape:
    """Text with its left middle at (x, y) (m); `width` (m) is reserved for it to the right."""

    role: str
    x: float
    y: float
    text: str
    width: float


DrawnShape = Circle | Polygon | Lines | TextShape


KEY = " key"
"""End of the role of a sample in a key: that of what it stands for, and this."""


def is_wording(shape: DrawnShape) -> bool:
    """Return whether a shape is a text, or the sample of a key, which means nothing without the text beside it."""
    return isinstance(shape, TextShape) or shape.role.endswith(KEY)


def bounding_box(shapes: Iterable[DrawnShape]) -> BoundingBox:
    """Return the smallest box (m) around shapes, text with its reserved width; around none one that changes no other box: +-inf."""
    points = [point for shape in shapes for point in _extent_points(shape)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    return min(xs, default=math.inf), max(xs, default=-math.inf), min(ys, default=math.inf), max(ys, default=-math.inf)


def enclose_boxes(boxes: Iterable[BoundingBox]) -> BoundingBox:
    """Return the smallest box (m) around boxes, of which there is at least one."""
    lefts, rights, bottoms, tops = zip(*boxes, strict=True)
    return min(lefts), max(rights), min(bottoms), max(tops)


def _extent_points(shape: DrawnShape) -> Iterable[Vec2]:
    """Return points that have the same bounding box as a shape."""
    match shape:
        case Circle(_, x, y, radius):
            return (x - radius, y - radius), (x + radius, y + radius)
        case Polygon(_, points):
            return points
        case Lines(_, lines):
            return chain.from_iterable(lines)
        case TextShape(_, x, y, _, width):
            return (x, y), (x + width, y)


def round_step(span: float, max_steps: int) -> float:
    """Return the smallest of 1, 2, 5 x 10^n that divides `span` into at most `max_steps` steps."""
    min_step = span / max_steps
    decade = float(10.0 ** math.floor(math.log10(min_step)))
    return next(step for step in (m * decade for m in (1.0, 2.0, 5.0, 10.0)) if step >= min_step * (1 - 1e-9))


def drawn_ball_radius(mass: float, length_scale: float) -> float:
    """Return the radius (m) of a cast-iron ball of a mass (kg), limited to 4 % to 20 % of `length_scale` (m) for visibility."""
    return min(max(math.cbrt(3 * mass / (4 * math.pi * CAST_IRON_DENSITY)), 0.04 * length_scale), 0.20 * length_scale)


CAST_IRON_DENSITY = 7200.0
"""Density of cast iron, kg/m3."""


def axes_to_plane(axes: PoseTuple, x: float, y: float) -> Vec2:
    """Return the position in the plane (m) of a point (x, y) (m) given in axes, such as those of a body."""
    c, s = math.cos(axes[2]), math.sin(axes[2])
    return axes[0] + c * x - s * y, axes[1] + s * x + c * y


def place_points(axes: PoseTuple, points: Iterable[Vec2]) -> tuple[Vec2, ...]:
    """Return the positions in the plane (m) of points given in axes."""
    return tuple(axes_to_plane(axes, *point) for point in points)


def arc_points(centre: Vec2, start: float, sweep: float, radius: float, n_segments: int = 8) -> tuple[Vec2, ...]:
    """Return points of an arc from a start angle on by a sweep (rad)."""
    x, y = centre
    angles = [start + sweep * k / n_segments for k in range(n_segments + 1)]
    return tuple([(x + radius * math.cos(a), y + radius * math.sin(a)) for a in angles])


def distinct_points(points: Iterable[Vec2], min_distance: float) -> list[Vec2]:
    """Return the points in order, without those closer than `min_distance` (m) to an earlier one."""
    kept: list[Vec2] = []
    for point in points:
        if all(math.dist(point, other) >= min_distance for other in kept):
            kept.append(point)
    return kept


def convex_hull(points: Sequence[Vec2]) -> list[Vec2]:
    """Return the corners of the convex hull of points, anticlockwise, without points on an edge."""
    ordered = sorted(set(points))
    if len(ordered) < 3:
        return ordered
    span = max(math.dist(point, ordered[0]) for point in ordered)

    def half_hull(chain: Sequence[Vec2]) -> list[Vec2]:
        """Return the corners of the hull above or below the points."""
        corners: list[Vec2] = []
        for x, y in chain:
            while len(corners) > 1:
                (x0, y0), (x1, y1) = corners[-2:]
                if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 1e-9 * span**2:
                    break
                corners.pop()
            corners.append((x, y))
        return corners[:-1]

    return half_hull(ordered) + half_hull(ordered[::-1])


def drawn_point_paths(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Return the paths (n, m, 2) m of all drawn points: mass centres, ends of joints and elements, rims of wheels, outlines."""
    ended = [*mechanism.joints, *(load for load in mechanism.force_elements if isinstance(load, Spring | Damper))]
    points = [point for element in ended for point in (element.first, element.second)]
    points += [load.point for load in mechanism.force_elements if isinstance(load, Force)]
    paths = [poses[:, :, :2], *(point_path(mechanism, poses, point)[:, None] for point in dict.fromkeys(points))]
    for joint in mechanism.joints:
        if isinstance(joint, Gear | RackAndPinion):
            wheels = (joint.first,) if isinstance(joint, RackAndPinion) else wheel_centres(mechanism, poses, joint)
            centres = [point_path(mechanism, poses, point) for point in wheels]
            radii = [np.full(len(poses), abs(joint.radius))] if isinstance(joint, RackAndPinion) else _radii_of_gear(joint, centres)
            for centre, radius in zip(centres, radii, strict=True):
                paths += [(centre + sign * radius[:, None])[:, None] for sign in (-1, 1)]
        if isinstance(joint, CurveSlot) and isinstance(joint.curve, PolarCurve):
            outline = place_points((joint.first.x, joint.first.y, joint.angle), closed_curve_points(joint.curve, 24))
            paths += [point_path(mechanism, poses, Point(body=joint.first.body, x=x, y=y))[:, None] for x, y in outline]
    for one in mechanism.outlines:
        corners = [(x + one.origin.x, y + one.origin.y) for x, y in outline_points(one.outline)[::4]]
        paths += [point_path(mechanism, poses, Point(body=one.origin.body, x=x, y=y))[:, None] for x, y in corners]
    return np.concatenate(paths, axis=1)


def closed_curve_points(curve: PolarCurve, count: int) -> list[Vec2]:
    """Return points of a closed curve at equal angles, in its axes, m."""
    segments = make_curve_segments(curve)
    angles = [math.tau * k / count for k in range(count)]
    radii = [evaluate_polar_curve(segments, 0, len(segments), angle)[0] for angle in angles]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for radius, angle in zip(radii, angles, strict=True)]


MAX_CENTRE_SHIFT = 1e-3
"""Motion of the centre of a wheel against the carrier, relative to the length scale, which is only an open joint."""


def wheel_centres(mechanism: Mechanism, poses: FloatArray, gear: Gear) -> tuple[Point, ...]:
    """Return the centres of both wheels of a gear, which its carrier holds in their places over a run with poses (n, bodies, 3)."""
    # They are the points of the gear, or the pins of the wheels on the carrier. A gear without wheels
    # has none: it relates two angles otherwise, as those of an arm and of a wheel on it whose ring is
    # no body.
    centres = [_held_point(mechanism, poses, gear, point) for point in (gear.first, gear.second)]
    return tuple(centre for centre in centres if centre is not None) if None not in centres else ()


def _held_point(mechanism: Mechanism, poses: FloatArray, gear: Gear, point: Point) -> Point | None:
    """Return the point of a wheel that does not move against the carrier of its gear; None without any."""
    pins = (joint for joint in mechanism.joints if isinstance(joint, Pin) and set(joint.bodies) == {point.body, gear.carrier})
    own_pins = (end for pin in pins for end in (pin.first, pin.second) if end.body == point.body)
    index = mechanism.body_index(gear.carrier)
    carrier = poses[:, index] if index >= 0 else np.zeros((len(poses), 3))
    for candidate in (point, *own_pins):
        offset = point_path(mechanism, poses, candidate) - carrier[:, :2]
        place = np.stack(rotate_vector(-carrier[:, 2], *offset.T))
        if np.ptp(place, axis=1).max() < MAX_CENTRE_SHIFT * mechanism.length_scale:
            return candidate
    return None


def _radii_of_gear(gear: Gear, centres: Sequence[FloatArray]) -> Sequence[FloatArray]:
    return wheel_radii(gear.ratio, np.hypot(*(centres[1] - centres[0]).T)) if centres else ()


def wheel_radii(ratio: float, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the radii (m) of two wheels in contact at a distance (m): external for a negative ratio, else internal."""
    # Wheels of equal size that turn in the same sense do not touch; a belt can connect them.
    second_radius = distance / abs(ratio - 1) if abs(ratio - 1) > 0.05 else 0.3 * distance
    return abs(ratio) * second_radius, second_radius


PixelRect = tuple[float, float, float, float]
"""left, top, right, bottom (pixels) from the upper left corner of the frame."""

SMALL_TEXT = 11.0
"""Height (pixels of a frame 480 high) of the smallest words, in which all captions and scales are written."""
ELEVATION_RECT: PixelRect = (8.0, 42.0, 286.0, 436.0)
"""Rectangle of the machine in a film of 480 pixels."""


@dataclass(frozen=True, kw_only=True)
class PixelView:
    """View of a plane in `rect` (pixels): `scale` pixels per metre, with the point (x, y) (m) in the middle."""

    rect: PixelRect
    scale: float
    x: float
    y: float

    @property
    def box(self) -> BoundingBox:
        """Return the bounding box (m) that the whole rectangle shows: left, right, bottom, top."""
        left, top, right, bottom = self.rect
        half_width = (right - left) / 2 / self.scale
        half_height = (bottom - top) / 2 / self.scale
        return self.x - half_width, self.x + half_width, self.y - half_height, self.y + half_height

    def height_of(self, row: float) -> float:
        """Return the height (m) of a row (pixels from the top)."""
        return self.y - (row - (self.rect[1] + self.rect[3]) / 2) / self.scale

    def line_x(self, distance: float) -> float:
        """Return the place (m) at a distance (pixels) right of the rectangle."""
        return self.box[1] + distance / self.scale


def fit_view(box: BoundingBox, rect: PixelRect) -> PixelView:
    """Return the view that shows a box (m) as large as possible and centred in `rect`."""
    left, top, right, bottom = rect
    x0, x1, y0, y1 = box
    scale = min((right - left) / (x1 - x0), (bottom - top) / (y1 - y0))
    return PixelView(rect=rect, scale=scale, x=(x0 + x1) / 2, y=(y0 + y1) / 2)


def share_scale(first: PixelView, second: PixelView) -> tuple[PixelView, PixelView]:
    """Return two views of one machine on the smaller of their scales; the second shows like heights at the heights of the first."""
    scale = min(first.scale, second.scale)
    middles = [(view.rect[1] + view.rect[3]) / 2 for view in (first, second)]
    return replace(first, scale=scale), replace(second, scale=scale, y=first.y + (middles[0] - middles[1]) / scale)

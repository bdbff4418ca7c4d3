"""What a film draws over a machine: the sense of rotation, and on demand paths and forces. Shapes in metres, without colours."""

import math
from collections.abc import Iterable, Iterator
from functools import partial

import numpy as np

from governor_mechanism.render.forces import DrawnForce, find_forces
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, axes_shifted, axes_turned
from governor_mechanism.render.geometry.outlines import make_arrow
from governor_mechanism.render.geometry.points import arc_points, point_path
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Lines, TextShape, Vec2
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.machines.governor_parts import GovernorDrawing
from governor_mechanism.types import FloatArray

_ARROW_SIZE = 0.055
"""Half width of the arrow of rotation, relative to the height of the drawing."""
_FORCE_LENGTH, _FORCE_HEAD = 0.24, 0.035
"""Length of the largest force, and of the head of an arrow, relative to the larger side of the drawing."""
_MIN_FORCE_RATIO = 0.01
"""Force relative to the largest, below which no arrow is drawn: it would be shorter than a pixel or two."""
_PLAN_ARROW = math.radians(55)
"""Angle of the arrow of rotation on the ring of the plan view."""


def shows_bodies(data: FrameData) -> bool:
    """Return whether a drawing shows the bodies where they are; a diagram of a valve gear, for one, has a map of its own."""
    return isinstance(data.drawing, GovernorDrawing | GenericDrawing)


def rotation_arrow(data: FrameData, box: BoundingBox) -> list[DrawnShape]:
    """Return an arrow around the axis of a spindle, seen from the side, above a box (m), in the sense of its first rotation."""
    _, _, bottom, top = box
    size = _ARROW_SIZE * (top - bottom)
    sense = 1.0 if data.spindle_angle[-1] >= data.spindle_angle[0] else -1.0
    # The front half of a circle around the axis, whose height is foreshortened; anticlockwise from above is to the right in front.
    front = [(sense * x, top + 0.9 * size + 0.4 * y) for x, y in arc_points((0.0, 0.0), math.radians(160), math.radians(235), size, 32)]
    return [*make_arrow("rotation", front, 0.55 * size), TextShape("rotation", 1.35 * size, top + 0.9 * size, "ω", size)]


def box_with_rotation_arrow(box: BoundingBox) -> BoundingBox:
    """Return a box (m) with space for the arrow of rotation at its top."""
    left, right, bottom, top = box
    return left, right, bottom, top + 1.7 * _ARROW_SIZE * (top - bottom)


def plan_parts(data: FrameData, ring_radius: float) -> list[DrawnPart]:
    """Return the plan view, as parts whose moments are the numbers of the frames, with an arrow of rotation on its ring.

    The arrow is in front of the hand, and as long as the rotation since the last frame if that is longer: a speed too high for the frame
    rate shows as a closed ring.
    """
    angles = data.spindle_angle
    sense = math.copysign(1.0, float(angles[-1] - angles[0]))
    is_turning = bool(np.ptp(angles) > 0.0)

    def arrow(k: int) -> Iterable[DrawnShape]:
        step = float(angles[k]) - float(angles[max(k - 1, 0)])
        length = min(max(abs(step), _PLAN_ARROW), 2 * math.pi) if is_turning else 0.0
        return make_arrow("sweep", arc_points((0.0, 0.0), -sense * length, sense * length, ring_radius, 32), 0.24 * ring_radius)

    def plane(k: int) -> Iterable[DrawnShape]:
        _, *shapes = data.drawing.dial_shapes(data.poses[k], 0.0, 0.0, ring_radius)
        return shapes

    frame = axes_turned((0.0, 0.0), lambda k: float(angles[k]))
    return [Flexible(shapes_at=arrow, frame=frame), Flexible(shapes_at=plane, frame=frame)]


def trace_shapes(data: FrameData) -> list[DrawnShape]:
    """Return the paths of the mass centres in the shown time, and the path that the drawing traces."""
    poses = data.poses_at(data.sample_times)
    paths = [poses[:, index, :2] for index in range(poses.shape[1])] if shows_bodies(data) else []
    if (traced := data.drawing.traced_path(poses)) is not None:
        paths.append(traced)
    moving = [path for path in paths if np.ptp(path, axis=0).max(initial=0.0) > 1e-6 * data.part.mechanism.length_scale]
    return [Lines("path", tuple(tuple(map(tuple, path.tolist())) for path in moving))]


class ForceArrows:
    """Arrows of the forces on the bodies of a part, all on one scale for a drawing in a box (m)."""

    def __init__(self, data: FrameData, box: BoundingBox, *, is_shown: bool) -> None:
        left, right, bottom, top = box
        size = max(right - left, top - bottom)
        self._head = _FORCE_HEAD * size
        forces = find_forces(data) if is_shown and shows_bodies(data) else []
        self.largest = max((_magnitude(force) for force in forces), default=0.0)
        self._forces = [force for force in forces if _magnitude(force) > _MIN_FORCE_RATIO * self.largest]
        # Metres per newton.
        self.scale = _FORCE_LENGTH * size / self.largest if self.largest else 0.0
        self._starts = [point_path(data.part.mechanism, data.poses, force.point) for force in self._forces]

    @property
    def kinds(self) -> list[str]:
        """Return the kinds of the forces, each once."""
        return list(dict.fromkeys(force.kind for force in self._forces))

    def enclosing_box(self, box: BoundingBox) -> BoundingBox:
        """Return the smallest box (m) around a box and all arrows."""
        if not self._forces:
            return box
        tips = np.concatenate([s + self.scale * f.components for s, f in zip(self._starts, self._forces, strict=True)])
        (x0, y0), (x1, y1) = tips.min(axis=0).tolist(), tips.max(axis=0).tolist()
        return min(box[0], x0), max(box[1], x1), min(box[2], y0), max(box[3], y1)

    def parts(self) -> Iterator[DrawnPart]:
        """Yield the arrows, whose moments are the numbers of the frames."""
        for force, start in zip(self._forces, self._starts, strict=True):
            frame = axes_shifted(partial(_point_of, start))
            yield Flexible(shapes_at=partial(self._arrow, force), frame=frame)

    def _arrow(self, force: DrawnForce, k: int) -> Iterable[DrawnShape]:
        """Return the arrow of a force at frame k, from the origin."""
        return make_arrow(f"{force.kind} force", ((0.0, 0.0), _point_of(self.scale * force.components, k)), self._head)


def _magnitude(force: DrawnForce) -> float:
    """Return the largest magnitude of a force, N."""
    return float(np.hypot(*force.components.T).max(initial=0.0))


def _point_of(path: FloatArray, k: int) -> Vec2:
    """Return the point of a path (n, 2) at frame k."""
    x, y = path[k].tolist()
    return x, y

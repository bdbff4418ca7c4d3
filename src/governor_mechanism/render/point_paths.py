"""Paths of points in a drawing: the whole curve, and a tail behind the point."""

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Final

import numpy as np

from governor_mechanism.mechanics.kinematics.point_paths import point_path
from governor_mechanism.model.joints import Point
from governor_mechanism.model.part import Part
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.frame_data import FrameData, shows_bodies
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, fixed
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Lines, Vec2, bounding_box, enclose_boxes
from governor_mechanism.types import FloatArray

TRACE_DURATION: Final = 1.0
"""Duration (s of film) of the traced path that is shown."""


def requested_points(
    scene: Scene,
    part: Part,
    names: Sequence[str] | None,  # names of points; those of the scene (`run.paths`) if None
) -> Mapping[str, Point]:
    """Return the points of a part whose paths are shown, by the names that they have in the part."""
    known = part.mechanism.path_points
    own_names = [name.removeprefix(f"{part.name}.") for name in (scene.run.paths if names is None else names)]
    return {name: known[name] for name in own_names if name in known}


def curve_shape(curves: Sequence[FloatArray]) -> Lines:
    """Return whole curves (n, 2), m."""
    return Lines("path", tuple(tuple(map(tuple, curve.tolist())) for curve in curves))


class PointPaths:
    """Paths of points in the shown time: whole curves (sample times, 2), and places of the points at the frames (frames, 2), m."""

    def __init__(self, data: FrameData, names: Sequence[str] | None) -> None:
        self._data = data
        mechanism = data.part.mechanism
        points = requested_points(data.drawing.run.scene, data.part, names).values() if shows_bodies(data) else []
        sampled = data.poses_at(data.sample_times)
        self.curves = [point_path(mechanism, sampled, point) for point in points]
        self.places = [point_path(mechanism, data.poses, point) for point in points]

    def enclosing_box(self, box: BoundingBox) -> BoundingBox:
        """Return the smallest box (m) around a box and all curves."""
        return enclose_boxes([box, *(bounding_box([shape]) for shape in self.shapes)])

    @property
    def shapes(self) -> list[DrawnShape]:
        """The whole curves, which are in front of the bodies: a wheel would hide them."""
        return [curve_shape(self.curves)] if self.curves else []

    def parts(self) -> Iterator[DrawnPart]:
        """Yield the whole curves, and in front of them what follows the points, whose moments are the numbers of the frames."""
        if self.curves:
            yield fixed(self.shapes, section_only=True)
        for curve, places in zip(self.curves, self.places, strict=True):
            yield Flexible(shapes_at=partial(self._tail, curve, places))

    def _tail(self, curve: FloatArray, places: FloatArray, k: int) -> list[DrawnShape]:
        """Return the last second of film before frame k of a curve (s, 2), m, which ends at its point (f, 2) of the frame."""
        return [Lines("tail", (last_second(self._data, curve, places, k),))]


def last_second(data: FrameData, curve: FloatArray, places: FloatArray, k: int) -> tuple[Vec2, ...]:
    """Return the part in the last second of film before frame k of a curve (s, 2) m, which ends at its point (f, 2) m of the frame."""
    time = float(data.times[k])
    first, last = np.searchsorted(data.sample_times, (time - TRACE_DURATION / data.slow_down, time))
    return *map(tuple, curve[first:last].tolist()), tuple(places[k].tolist())

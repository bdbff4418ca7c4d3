"""Layers of the elevation that show the motion: paths of points, their velocities and accelerations, instantaneous centres."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.model.joints import GROUND, Point
from governor_mechanism.model.mechanism import GROUND_LINK, Link, LinkGraph, Mechanism
from governor_mechanism.model.motion_readings import InstantaneousCentre
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.model.part import Part
from governor_mechanism.model.results.pictures import FilmLayer
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.motion_readings import Motion, evaluate_motion_reading, point_velocity
from governor_mechanism.render.frame_data import FrameData, shows_bodies
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, axes_shifted, fixed
from governor_mechanism.render.geometry.outlines import make_arrow
from governor_mechanism.render.geometry.primitives import BoundingBox, DrawnShape, Lines, Vec2, arc_points, bounding_box, enclose_boxes
from governor_mechanism.types import FloatArray

_ARROW_LENGTH, _ARROW_HEAD = 0.24, 0.03
"""Length of the longest arrow of a layer, and of the head of an arrow, relative to the larger side of the drawing."""
_MARK = 0.014
"""Radius of the mark of an instantaneous centre, relative to the larger side of the drawing."""
_ROOM = 0.15
"""Distance beyond the drawing up to which instantaneous centres are shown, relative to its larger side: others are far away."""
_MAX_POINTS = 6
"""Largest number of points with arrows."""

LAYER_NAMES = {FilmLayer.VELOCITY: "velocity", FilmLayer.ACCELERATION: "acceleration", FilmLayer.POLES: "instantaneous centre"}
"""Words for the layers, which are also the roles of their shapes."""
_SYMBOLS = {FilmLayer.VELOCITY: "v", FilmLayer.ACCELERATION: "a"}
_UNITS = {FilmLayer.VELOCITY: "m/s", FilmLayer.ACCELERATION: "m/s²"}


@dataclass(frozen=True, eq=False)
class _Arrow:
    """A vector at a point over the frames: where it starts (f, 2), m, and its components (f, 2), SI."""

    layer: FilmLayer
    starts: FloatArray
    components: FloatArray


class MotionLayers:
    """The chosen layers of a part for a drawing in a box (m); the arrows of each have a scale of their own."""

    def __init__(self, data: FrameData, box: BoundingBox, layers: Sequence[FilmLayer]) -> None:
        left, right, bottom, top = box
        self._size, self._layers = max(right - left, top - bottom), layers
        room = _ROOM * self._size
        self._shown = (left - room, right + room, bottom - room, top + room)
        self._arrows = [arrow for layer in layers if layer in _UNITS for arrow in _make_arrows(data, layer)]
        self._poles = _find_poles(data) if FilmLayer.POLES in layers else []
        self._largest = {
            layer: max((float(np.hypot(*one.components.T).max()) for one in self._arrows if one.layer is layer), default=0.0)
            for layer in layers
        }

    @property
    def captions(self) -> list[tuple[str, str]]:
        """Role and words of each layer: what it shows, and how large its longest arrow is."""
        words = {layer: f"{_SYMBOLS[layer]} ≤ {self._largest[layer]:.3g} {_UNITS[layer]}" for layer in self._layers if layer in _UNITS}
        return [(LAYER_NAMES[layer], words.get(layer, "poles")) for layer in self._layers]

    def enclosing_box(self, box: BoundingBox) -> BoundingBox:
        """Return the smallest box (m) around a box, all arrows, and the centres that are shown."""
        points = [one.starts + self._scale(one.layer) * one.components for one in self._arrows]
        points += [path[self._is_near(path)] for path in self._poles]
        filled = [one for one in points if len(one)]
        return enclose_boxes([box, *((*_span(one[:, 0]), *_span(one[:, 1])) for one in filled)])

    def parts(self) -> Iterator[DrawnPart]:
        """Yield arrows and marks, whose moments are the numbers of the frames."""
        for arrow in self._arrows:
            yield Flexible(shapes_at=partial(self._arrow_at, arrow), frame=axes_shifted(partial(_point_at, arrow.starts)))
        for path in self._poles:
            yield Flexible(shapes_at=partial(self._mark_at, path, self._is_near(path)))

    def _scale(self, layer: FilmLayer) -> float:
        """Return the length of an arrow in m per SI unit."""
        largest = self._largest[layer]
        return _ARROW_LENGTH * self._size / largest if largest else 0.0

    def _is_near(self, path: FloatArray) -> FloatArray:
        """Return at which frames (f,) a centre (f, 2) is shown; at infinity it is nowhere."""
        left, right, bottom, top = self._shown
        x, y = path.T
        near: FloatArray = (left < x) & (x < right) & (bottom < y) & (y < top)
        return near

    def _arrow_at(self, arrow: _Arrow, k: int) -> Iterable[DrawnShape]:
        """Return an arrow at frame k, from the origin."""
        tip = _point_at(self._scale(arrow.layer) * arrow.components, k)
        return make_arrow(LAYER_NAMES[arrow.layer], ((0.0, 0.0), tip), _ARROW_HEAD * self._size)

    def _mark_at(self, path: FloatArray, is_near: FloatArray, k: int) -> Iterable[DrawnShape]:
        """Return the mark of a centre at frame k: a circle with a cross, or nothing where it is far away."""
        role = LAYER_NAMES[FilmLayer.POLES]
        if not is_near[k]:
            return [Lines(role, ())]
        (x, y), radius = _point_at(path, k), _MARK * self._size
        ring = tuple(arc_points((x, y), 0.0, 2 * math.pi, radius, 24))
        return [Lines(role, (ring, ((x - 2 * radius, y), (x + 2 * radius, y)), ((x, y - 2 * radius), (x, y + 2 * radius))))]


def _span(values: FloatArray) -> Vec2:
    return float(values.min()), float(values.max())


def _point_at(path: FloatArray, k: int) -> Vec2:
    """Return the point of a path (f, 2) at frame k."""
    x, y = path[k].tolist()
    return x, y


def _shown_points(mechanism: Mechanism) -> list[Point]:
    """Return the points that have arrows: those with a name, or else pins that move, or else mass centres."""
    named = [one.point for one in mechanism.points]
    pins = [hinge.point for hinge in LinkGraph(mechanism).hinges if GROUND not in hinge.points]
    return (named or pins or list(mechanism.path_points.values()))[:_MAX_POINTS]


def _make_arrows(data: FrameData, layer: FilmLayer) -> Iterator[_Arrow]:
    """Yield the arrows of velocities, or of accelerations: differences of the velocities at the reported times."""
    drawing, mechanism = data.drawing, data.part.mechanism
    times = drawing.run.times
    for point in _shown_points(mechanism):
        vectors = point_velocity(mechanism, drawing.poses, drawing.select_bodies(drawing.run.velocities), point)
        if layer is FilmLayer.ACCELERATION:
            vectors = np.gradient(vectors, times, axis=0) if len(times) > 1 else np.zeros_like(vectors)
        components = np.column_stack([np.interp(data.times, times, column) for column in vectors.T])
        yield _Arrow(layer, point_path(mechanism, data.poses, point), components)


def _find_poles(data: FrameData) -> list[FloatArray]:
    """Return the instantaneous centres (f, 2), m, against the ground of the bodies without a pivot there."""
    mechanism = data.part.mechanism
    velocities = data.velocities_at(data.times)
    pivoted = {link for hinge in LinkGraph(mechanism).hinges_of(GROUND_LINK) for link in hinge.links}
    motion = Motion(mechanism=mechanism, poses=data.poses, velocities=velocities, accelerations=np.zeros_like(velocities), rates={})
    found = list[FloatArray]()
    for body in mechanism.bodies:
        if body.can_rotate and Link(body.name) not in pivoted:
            name = f"instantaneous_centre.{body.name}.{GROUND}"
            centres = [InstantaneousCentre(name=name, first=body.name, second=GROUND, pin=None, component=axis) for axis in "xy"]
            coordinates = [evaluate_motion_reading(motion, one) for one in centres]
            found.append(np.column_stack([one for one in coordinates if one is not None]))
    return found


TRACE_DURATION: Final = 1.0
"""Duration (s of film) of the traced path that is shown."""


def requested_points(
    scene: Scene,
    part: Part,
    names: Sequence[str] | None,  # names of points; those of the scene (`run.paths`) if None, or else the point marked P (x, y)
) -> Mapping[str, Point]:
    """Return the points of a part whose paths are shown, by the names that they have in the part."""
    known = part.mechanism.path_points
    own_names = [name.removeprefix(f"{part.name}.") for name in (scene.run.paths if names is None else names)]
    if names is None and not own_names:
        return _marked_point(part.mechanism)
    return {name: known[name] for name in own_names if name in known}


def _marked_point(mechanism: Mechanism) -> Mapping[str, Point]:
    """Return the point whose coordinates are the readings x and y, if there is one."""
    named = {one.name: one.point for one in mechanism.readings if isinstance(one, PointCoordinate)}
    return {"P": named["x"]} if named.get("x") == named.get("y") and "x" in named else {}


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

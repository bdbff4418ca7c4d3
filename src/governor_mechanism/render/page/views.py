"""Views of a run: the elevation of each part, or the engine room of a governed engine and its governor; and how their shapes move."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from governor_mechanism.model.results.pictures import FilmLayer
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.frame_data import FrameData, find_parts, shows_bodies
from governor_mechanism.render.geometry.attached import DrawnPart, at_own_moments, fixed, shapes_of
from governor_mechanism.render.geometry.primitives import ELEVATION_RECT, BoundingBox, DrawnShape, Vec2, fit_view
from governor_mechanism.render.geometry.recording import RecordedShape, move_points
from governor_mechanism.render.machines.engine_room import arrangement as room
from governor_mechanism.render.machines.engine_room.arrangement import EngineRoomParts, find_governed_engine
from governor_mechanism.render.machines.engine_room.drawing import EngineRoomDrawing
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.motion_layers import MotionLayers, PointPaths
from governor_mechanism.render.page.part_names import ENGINE_ROOM
from governor_mechanism.render.shown_readings import format_name
from governor_mechanism.types import FloatArray

PICTURE_SIZE = 10_000
"""Length of the larger side of a picture: all positions are rounded to one unit, less than a tenth of a pixel on most screens."""


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

    def enlarge(self, points: FloatArray) -> FloatArray:
        """Return points (..., 2) m of axes of their own in such axes of the picture."""
        return points * (self.scale, -self.scale)


MAX_STROKE = 24.0
"""Thickest stroke of width 1, units of the picture: 2 pixels in a picture of 800."""


@dataclass(frozen=True, kw_only=True)
class Trail:
    """The last second of film of a path."""

    role: str  # role of its style: "trace" behind what moves, or "tail" in front of it
    places: FloatArray  # where the point is at the samples, in the drawing; shape (samples, 2)


@dataclass(frozen=True, kw_only=True)
class PageView:
    """One drawing of a page."""

    # name, machine: name of the part, empty if there is only one; name of its machine in scene files, or
    # ENGINE_ROOM
    name: str
    machine: str
    box: BoundingBox  # box around the drawing at all times, in its own unit of length: m, or pixels of an engine room
    # fixed, moving: parts of the drawing that do not move, and in front of them those that move, back to
    # front
    fixed: Sequence[DrawnPart]
    moving: Sequence[DrawnPart]
    moment_at: Callable[[int], Any]  # moment of the drawing at a sample
    stroke_scale: float  # length in the drawing that a stroke of width 1 takes
    data: FrameData  # the part of the run whose bodies and forces the view shows
    # map from poses (..., 3) of that part, m and rad, to the drawing
    place_poses: Callable[[FloatArray], FloatArray] = field(default=np.asarray)
    # names of the scale bars, with units of the drawing in a metre; empty name for the only one
    scales: Mapping[str, float]
    # whether the bodies are drawn where they are; a diagram of a valve gear, for one, has a map of its own
    shows_bodies: bool = True
    # whether the shapes of bodies are called by the names of these, as in a drawing of any mechanism
    names_bodies: bool = False
    # has_plane, has_outside: whether the elevation is shown, and the view from outside of a plane that
    # turns
    has_plane: bool = True
    has_outside: bool = False
    rotation_slowing: int = 1  # number of turns for which the drawing shows one
    trails: Sequence["Trail"] = ()  # what stays behind a point for a second of film

    @property
    def static_shapes(self) -> Sequence[DrawnShape]:
        """Shapes that do not move."""
        return tuple(shapes_of(self.fixed, None))

    def shapes_at(self, k: int) -> Sequence[DrawnShape]:
        """Return the moving shapes of a sample."""
        return tuple(shapes_of(self.moving, self.moment_at(k)))

    @property
    def picture(self) -> Picture:
        """Map from the drawing to its picture."""
        return Picture(box=self.box)

    @property
    def stroke(self) -> float:
        """Stroke of width 1 in units of the picture: that of the films, but not thicker in a picture that fills the page."""
        return min(self.stroke_scale * self.picture.scale, MAX_STROKE)


@dataclass(frozen=True, kw_only=True)
class ShownRun:
    """What a page shows of a run at its sample times (n,) s; `governed` and `room` are those of a governed engine, or None."""

    run: Trajectory
    times: FloatArray
    parts: Sequence[FrameData]
    views: Sequence[PageView]
    governed: EngineRoomParts | None = None
    room: EngineRoomDrawing | None = None


def show_run(
    run: Trajectory,
    part: str | None,  # name of the only part to show
    time_span: Vec2,  # the shown time, s
    times: FloatArray,  # sample times within it, s; shape (n,)
    slow_down: float,  # seconds of film per second of the run
    paths: Sequence[str] | None = None,  # names of the points whose paths are drawn; those of the scene if None
    layers: Sequence[FilmLayer] = (),  # what is drawn of the motion
    boxes: Sequence[BoundingBox] = (),  # boxes of the views, if they are to be those of an earlier drawing; else they fit this run
) -> ShownRun:
    """Return what a page shows of a run, or of one part of it."""
    governed = find_governed_engine(run.scene) if part is None else None
    shown = (governed.engine, governed.governor) if governed else find_parts(run, part)
    parts = [FrameData(run, one, time_span, times, slow_down) for one in shown]
    if governed is None:
        given: Sequence[BoundingBox | None] = boxes or [None] * len(parts)
        views = [_view_part(data, len(parts) > 1, PointPaths(data, paths), layers, box) for data, box in zip(parts, given, strict=True)]
        return ShownRun(run=run, times=times, parts=parts, views=views)
    drawing = EngineRoomDrawing(run, governed, parts[0].drawing, parts[1].drawing)
    governor = _view_part(parts[1], True, PointPaths(parts[1], ()), box=boxes[1] if boxes else None, has_plane=False)
    return ShownRun(
        run=run, times=times, parts=parts, views=[_view_room(drawing, parts[1], times), governor], governed=governed, room=drawing
    )


def _view_part(
    data: FrameData,
    is_one_of_many: bool,
    paths: PointPaths,
    layers: Sequence[FilmLayer] = (),
    box: BoundingBox | None = None,
    *,
    has_plane: bool = True,
) -> PageView:
    """Return the view of one part, with paths of its points and layers of its motion, in a given box or one that fits."""
    drawing = data.drawing
    motion = MotionLayers(data, box or drawing.bounds, layers if shows_bodies(data) else ())
    box = box or motion.enclosing_box(paths.enclosing_box(drawing.bounds))
    samples = {float(time): k for k, time in enumerate(data.times)}
    traced = drawing.traced_path(data.poses)
    trails = [Trail(role="trace", places=traced)] if traced is not None else []
    return PageView(
        name=format_name(data.part.name) if is_one_of_many else "",
        machine=data.part.machine,
        box=box,
        fixed=drawing.fixed,
        moving=(
            *drawing.moving,
            fixed(paths.shapes, section_only=True),
            *(at_own_moments(part, lambda moment: samples[moment.time]) for part in motion.parts()),
        ),
        moment_at=data.moment_at,
        stroke_scale=1.0 / fit_view(box, ELEVATION_RECT).scale,
        data=data,
        scales={"": 1.0},
        shows_bodies=shows_bodies(data),
        names_bodies=isinstance(drawing, GenericDrawing),
        has_plane=has_plane,
        has_outside=data.part.turns and "spindle_speed" in data.readings,
        trails=[*trails, *(Trail(role="tail", places=places) for places in paths.places)],
    )


def _view_room(drawing: EngineRoomDrawing, governor: FrameData, times: FloatArray) -> PageView:
    """Return the view of an engine room; its bodies are those of the governor."""
    placement = drawing.governor.placement

    def place_poses(poses: FloatArray) -> FloatArray:
        x, y, angle = (poses[..., column] for column in range(3))
        (x0, y0), scale = placement.origin, placement.scale
        return np.stack([x0 + scale * x, y0 + scale * y, angle], axis=-1)

    return PageView(
        name="",
        machine=ENGINE_ROOM,
        box=(0.0, room.WIDTH, 0.0, room.HEIGHT),
        fixed=drawing.fixed,
        moving=drawing.moving,
        moment_at=drawing.states(times, governor.poses),
        stroke_scale=1.0,
        data=governor,
        place_poses=place_poses,
        shows_bodies=shows_bodies(governor),
        rotation_slowing=drawing.rotation_slowing(times),
        scales={drawing.engine.scaled: drawing.engine.pixels_per_metre, "governor": drawing.governor.pixels_per_metre},
    )


TOLERANCE = 0.6
"""Largest deviation of a described position from the recorded one, units of the picture: about that of rounding."""
MAX_MODES = 10
"""Largest number of modes of a deforming shape: beyond, its points are written as they are."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """A rigid motion."""

    name: str  # name of the body that moves so; empty for axes of the drawing
    poses: FloatArray  # position in the picture and clockwise angle, rad; shape (samples, 3)


@dataclass(frozen=True, kw_only=True)
class Mode:
    """A deformation: displacements (points, 2) for an amplitude of 1, and the amplitude (samples,), units of the picture."""

    displacements: FloatArray
    amplitudes: FloatArray


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How a shape moves."""

    points: FloatArray  # points in the axes of the track, or in the picture; shape (points, 2)
    track: int | None = None  # index of the track; None for a shape without one
    modes: tuple[Mode, ...] = ()  # deformations that are added to the points
    is_changing: bool = False  # whether the points have to be taken from the record, sample by sample


@dataclass
class TrackTable:
    """The tracks of a picture, to which new ones are added as shapes need them."""

    picture: Picture
    tracks: list[Track] = field(default_factory=list)

    def describe(self, shape: RecordedShape) -> Motion:
        """Return how a shape moves."""
        if shape.changing:
            return Motion(points=np.zeros((0, 2)), is_changing=True)
        if shape.poses is None:
            points, track = self.picture.place(shape.points), None
            if shape.kind in ("circle", "text") and not _is_constant(points):
                poses = np.pad(points[:, 0], ((0, 0), (0, 1)))
                points, track = self._follow(poses, np.zeros((1, 1, 2)))
        else:
            points, track = self._follow(self.picture.place_poses(shape.poses), self.picture.enlarge(shape.points))
        return Motion(points=points[0], track=track) if _is_constant(points) else find_modes(points, track)

    def _follow(self, poses: FloatArray, points: FloatArray) -> tuple[FloatArray, int | None]:
        """Return points (1 or samples, points, 2) of axes with poses (samples, 3) in those of a track, with its number."""
        # Axes that move as one share a track. Axes that do not move have none, and their points are in the picture.
        reach = float(np.hypot(points[..., 0], points[..., 1]).max())
        sweep = np.ptp(poses, axis=0)
        if sweep[0] + sweep[1] + sweep[2] * reach < TOLERANCE:
            return move_points(poses[:1], points), None
        for index, track in enumerate(self.tracks):
            relative = _relative_poses(track.poses, poses)
            if np.ptp(relative[:, :2], axis=0).max() + np.ptp(relative[:, 2]) * reach < TOLERANCE:
                return move_points(relative.mean(axis=0)[None], points), index
        self.tracks.append(Track(name="", poses=poses))
        return points, len(self.tracks) - 1


def _is_constant(points: FloatArray) -> bool:
    """Return whether points (samples, points, 2) do not move."""
    return bool(np.abs(points - points[:1]).max(initial=0.0) < TOLERANCE)


def _relative_poses(track: FloatArray, poses: FloatArray) -> FloatArray:
    """Return poses (samples, 3) in the axes of a track (samples, 3)."""
    x, y, angle = (poses - track).T
    c, s = np.cos(track[:, 2]), np.sin(track[:, 2])
    return np.column_stack([c * x + s * y, c * y - s * x, angle])


def find_modes(points: FloatArray, track: int | None) -> Motion:
    """Return the deformation of points (samples, points, 2) of a track in few modes (principal components).

    If it takes many, the points are written sample by sample.
    """
    n_samples, n_points, _ = points.shape
    mean = points.mean(axis=0)
    deviations = (points - mean).reshape(n_samples, -1)
    # Of the smaller of the two products with the transpose: much faster than a decomposition of all, and far more accurate than a unit.
    is_tall = n_samples > deviations.shape[1]
    squares, vectors = np.linalg.eigh(deviations.T @ deviations if is_tall else deviations @ deviations.T)
    count = int(np.sum(squares[-MAX_MODES:] > 0.0))
    order = np.arange(len(squares) - 1, len(squares) - 1 - count, -1)
    sizes = np.sqrt(squares[order])
    directions = vectors[:, order].T if is_tall else (vectors[:, order].T @ deviations) / sizes[:, np.newaxis]
    left = deviations @ directions.T / sizes
    rest = deviations.copy()
    modes: list[Mode] = []
    for k in range(count):
        largest = float(np.abs(directions[k]).max())
        displacements = directions[k] / largest
        amplitudes = left[:, k] * sizes[k] * largest
        rest -= np.outer(amplitudes, displacements)
        modes.append(Mode(displacements=displacements.reshape(n_points, 2), amplitudes=amplitudes))
        if np.abs(rest).max() <= TOLERANCE:
            return Motion(points=mean, track=track, modes=tuple(modes))
    return Motion(points=mean, is_changing=True)

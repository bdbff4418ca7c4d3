"""How the shapes of a page move: with a track (a rigid motion), by a few modes of deformation, or sample by sample.

A page draws an outline once and then moves it.
"""

from dataclasses import dataclass, field

import numpy as np

from governor_mechanism.render.geometry.recording import RecordedShape, move_points
from governor_mechanism.render.page.views import Picture
from governor_mechanism.types import FloatArray

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
        """Return points (1 or samples, points, 2) of axes with poses (samples, 3) in those of a track, with its number.

        Axes that move as one share a track. Axes that do not move have none, and their points are in the picture.
        """
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
        displacements, amplitudes = directions[k] / largest, left[:, k] * sizes[k] * largest
        rest -= np.outer(amplitudes, displacements)
        modes.append(Mode(displacements=displacements.reshape(n_points, 2), amplitudes=amplitudes))
        if np.abs(rest).max() <= TOLERANCE:
            return Motion(points=mean, track=track, modes=tuple(modes))
    return Motion(points=mean, is_changing=True)

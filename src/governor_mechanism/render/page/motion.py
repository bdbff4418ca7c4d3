"""How recorded shapes move: not at all, with a track (a rigid motion), by a few modes of deformation, or in another way.

A page draws an outline once and then moves it. The four descriptions are tried in this order; each has to reproduce all positions.
"""

from dataclasses import dataclass, field

import numpy as np

from governor_mechanism.render.page.recording import RecordedShape
from governor_mechanism.types import FloatArray

TOLERANCE = 0.6
"""Largest deviation of a described position from the recorded one (units of the picture): about that of rounding to a unit."""
MAX_MODES = 10
"""Largest number of modes of a deforming shape: beyond, its points are written as they are."""
_N_TRIALS = 16
"""Number of samples at which a description is tried before all are."""
_MIN_POLE_ROTATION = 0.3
"""Range of the angle (rad) from which on a fixed point of a rotation is sought."""


@dataclass(frozen=True, kw_only=True)
class Track:
    """A rigid motion.

    Attributes
    ----------
    name
        Name of the body that moves so; empty for a motion that was found from shapes.
    poses
        Position in the picture and clockwise angle, rad; shape (samples, 3).
    """

    name: str
    poses: FloatArray


@dataclass(frozen=True, kw_only=True)
class Mode:
    """A deformation: displacements (points, 2) for an amplitude of 1, and the amplitude (samples,) in units of the picture."""

    displacements: FloatArray
    amplitudes: FloatArray


@dataclass(frozen=True, kw_only=True)
class Motion:
    """How a shape moves.

    Attributes
    ----------
    points
        Points in the axes of the track, or in the picture; shape (points, 2).
    track
        Index of the track; None for a shape without one.
    modes
        Deformations that are added to the points.
    is_changing
        Whether the points have to be taken from the record, sample by sample.
    """

    points: FloatArray
    track: int | None = None
    modes: tuple[Mode, ...] = ()
    is_changing: bool = False


@dataclass
class TrackTable:
    """The tracks of a picture, to which new ones are added as shapes need them."""

    tracks: list[Track] = field(default_factory=list)

    def describe(self, shape: RecordedShape) -> Motion:
        """Return how a shape moves."""
        if shape.changing:
            return Motion(points=np.zeros((0, 2)), is_changing=True)
        points = shape.points
        if not points.size or np.abs(points - points[:1]).max() < TOLERANCE:
            return Motion(points=points[0])
        for index, track in enumerate(self.tracks):
            local = _find_fixed_outline(track.poses, points)
            if local is not None:
                return Motion(points=local, track=index)
        poses = _find_rigid_motion(points)
        local = _find_fixed_outline(poses, points)
        if local is not None:
            self.tracks.append(Track(name="", poses=poses))
            return Motion(points=local, track=len(self.tracks) - 1)
        return _find_modes(points)


def move_points(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (points, 2) in axes, at poses (samples, 3) of these; shape (samples, points, 2)."""
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    x, y = points[:, 0], points[:, 1]
    return np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], axis=-1)


def _find_fixed_outline(poses: FloatArray, points: FloatArray) -> FloatArray | None:
    """Return the points in axes at poses (samples, 3), if they rest there, or None."""
    trials = np.linspace(0, len(points) - 1, min(len(points), _N_TRIALS)).astype(int)
    outline = _to_axes(poses[:1], points[:1])[0]
    for rows in (trials, slice(None)):
        local = _to_axes(poses[rows], points[rows])
        if np.abs(local - outline).max() > 2 * TOLERANCE:
            return None
    middle: FloatArray = (local.min(axis=0) + local.max(axis=0)) / 2
    return middle if np.abs(local - middle).max() <= TOLERANCE else None


def _to_axes(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Return points (samples, points, 2) in axes at poses (samples, 3)."""
    x, y = points[..., 0] - poses[:, :1], points[..., 1] - poses[:, 1:2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    return np.stack([c * x + s * y, c * y - s * x], axis=-1)


def _find_rigid_motion(points: FloatArray) -> FloatArray:
    """Return the rigid motion (samples, 3) that fits points (samples, points, 2) best, about its most nearly fixed point."""
    centres = points.mean(axis=1)
    arms = points - centres[:, None]
    first = arms[0]
    sines = (first[:, 0] * arms[..., 1] - first[:, 1] * arms[..., 0]).sum(axis=1)
    cosines = (first * arms).sum(axis=(1, 2))
    angles = np.unwrap(np.arctan2(sines, cosines))
    reach = float(np.hypot(*first.T).max())
    if np.ptp(angles) * reach < TOLERANCE:
        angles = np.zeros(len(points))
    poses = np.column_stack([centres, angles])
    if np.ptp(angles) < _MIN_POLE_ROTATION:
        return poses
    pole = _find_pole(poses)
    return np.column_stack([move_points(poses, pole[None])[:, 0], angles])


def _find_pole(poses: FloatArray) -> FloatArray:
    """Return the point (2,) in axes at poses (samples, 3) that moves least: that of a crank is on its shaft."""
    c, s, one, zero = np.cos(poses[:, 2]), np.sin(poses[:, 2]), np.ones(len(poses)), np.zeros(len(poses))
    # The unknowns are the point in the axes and its mean position.
    rows = np.concatenate([np.column_stack([c, -s, -one, zero]), np.column_stack([s, c, zero, -one])])
    pole: FloatArray = np.linalg.lstsq(rows, -np.concatenate([poses[:, 0], poses[:, 1]]), rcond=None)[0][:2]
    return pole


def _find_modes(points: FloatArray) -> Motion:
    """Return a deformation in few modes (principal components), or a changing shape if it takes many."""
    n_samples, n_points, _ = points.shape
    mean = points.mean(axis=0)
    deviations = (points - mean).reshape(n_samples, -1)
    left, sizes, directions = np.linalg.svd(deviations, full_matrices=False)
    rest = deviations.copy()
    modes: list[Mode] = []
    for k in range(min(MAX_MODES, len(sizes))):
        largest = float(np.abs(directions[k]).max())
        displacements, amplitudes = directions[k] / largest, left[:, k] * sizes[k] * largest
        rest -= np.outer(amplitudes, displacements)
        modes.append(Mode(displacements=displacements.reshape(n_points, 2), amplitudes=amplitudes))
        if np.abs(rest).max() <= TOLERANCE:
            return Motion(points=mean, modes=tuple(modes))
    return Motion(points=mean, is_changing=True)

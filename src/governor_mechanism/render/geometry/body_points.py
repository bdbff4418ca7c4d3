"""Paths of points over a run with poses (n, bodies, 3)."""

import numpy as np

from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.model.force_elements import Damper, Force, Spring
from governor_mechanism.model.joints import Gear, Point, RackAndPinion
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.types import FloatArray


def point_path(mechanism: Mechanism, poses: FloatArray, point: Point) -> FloatArray:
    """Return the path (n, 2) m of a point."""
    index = mechanism.body_index(point.body)
    pose = poses[:, index] if index >= 0 else np.zeros((len(poses), 3))
    path: FloatArray = pose[:, :2] + np.stack(rotate_vector(pose[:, 2], point.x, point.y), axis=-1)
    return path


def drawn_point_paths(mechanism: Mechanism, poses: FloatArray) -> FloatArray:
    """Return the paths (n, m, 2) m of all drawn points: mass centres, ends of joints and elements, rims of wheels."""
    ended = [*mechanism.joints, *(load for load in mechanism.force_elements if isinstance(load, Spring | Damper))]
    points = [point for element in ended for point in (element.first, element.second)]
    points += [load.point for load in mechanism.force_elements if isinstance(load, Force)]
    paths = [poses[:, :, :2], *(point_path(mechanism, poses, point)[:, None] for point in dict.fromkeys(points))]
    for joint in mechanism.joints:
        if isinstance(joint, Gear | RackAndPinion):
            centres = [point_path(mechanism, poses, point) for point in (joint.first, joint.second)]
            distance = np.hypot(*(centres[1] - centres[0]).T)
            radii = [np.full(len(poses), abs(joint.radius))] if isinstance(joint, RackAndPinion) else wheel_radii(joint.ratio, distance)
            for centre, radius in zip(centres, radii, strict=False):
                paths += [(centre + sign * radius[:, None])[:, None] for sign in (-1, 1)]
    return np.concatenate(paths, axis=1)


def wheel_radii(ratio: float, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the radii (m) of two wheels in contact at a centre distance (m): external for a negative ratio, else internal.

    Wheels of equal size that turn in the same sense do not touch; a belt can connect them.
    """
    second_radius = distance / abs(ratio - 1) if abs(ratio - 1) > 0.05 else 0.3 * distance
    return abs(ratio) * second_radius, second_radius

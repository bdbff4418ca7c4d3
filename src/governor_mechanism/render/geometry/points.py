"""Points: given in axes, on arcs, around a shape, and over a run with poses (n, bodies, 3)."""

import math
from collections.abc import Iterable, Sequence

import numpy as np

from governor_mechanism.mechanics.kinematics.constraint_equations import make_curve_segments
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_polar_curve
from governor_mechanism.mechanics.kinematics.point_paths import point_path
from governor_mechanism.mechanics.kinematics.points import rotate_vector
from governor_mechanism.model.curves import PolarCurve
from governor_mechanism.model.force_elements import Damper, Force, Spring
from governor_mechanism.model.joints import CurveSlot, Gear, Pin, Point, RackAndPinion
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2
from governor_mechanism.types import FloatArray


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
    """Return the paths (n, m, 2) m of all drawn points: mass centres, ends of joints and elements, rims of wheels."""
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
    """Return the centres of both wheels of a gear, which its carrier holds in their places over a run with poses (n, bodies, 3).

    They are the points of the gear, or the pins of the wheels on the carrier. A gear without wheels has none: it relates two angles
    otherwise, as those of an arm and of a wheel on it whose ring is no body.
    """
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
    """Return the radii (m) of two wheels in contact at a centre distance (m): external for a negative ratio, else internal.

    Wheels of equal size that turn in the same sense do not touch; a belt can connect them.
    """
    second_radius = distance / abs(ratio - 1) if abs(ratio - 1) > 0.05 else 0.3 * distance
    return abs(ratio) * second_radius, second_radius

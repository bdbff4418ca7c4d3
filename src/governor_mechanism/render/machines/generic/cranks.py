"""Generic drawing of cranks: the circles of pins that go round, and the discs that carry them."""

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from governor_mechanism.model.joints import GROUND, Pin
from governor_mechanism.model.mechanism import Body
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.render.geometry.points import arc_points, distinct_points
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2
from governor_mechanism.render.machines.generic.placed_mechanism import MechanismExtents

_MIN_TURN = 1.9 * math.pi
"""Angle (rad) from which on a body counts as turning round: nearly a turn."""
_MAX_DISC_RADIUS = 0.35
"""Largest radius of a drawn disc, as a fraction of the length scale."""
_MIN_CIRCLE_RADIUS = 0.03
"""Radius below which the circle of a pin is left out, as a fraction of the length scale."""


class _Crank(NamedTuple):
    """A body that goes round a fixed pin: the centre (m), the radii of its other joints (m), and that of its disc (m; 0 without)."""

    centre: Vec2
    radii: Sequence[float]
    disc_radius: float


@once_per_object
def _find_cranks(extents: MechanismExtents) -> Sequence[_Crank]:
    """Return the bodies that go round a pin on the ground during the run."""
    mechanism, u, cranks = extents.part.mechanism, extents.length_scale, []
    for pin in mechanism.joints:
        if not isinstance(pin, Pin) or GROUND not in (pin.first.body, pin.second.body):
            continue
        ground, own = (pin.first, pin.second) if pin.first.body == GROUND else (pin.second, pin.first)
        index = mechanism.body_index(own.body)
        if index < 0 or float(np.ptp(extents.poses[:, index, 2])) < _MIN_TURN:
            continue
        joined = [point for joint in mechanism.joints for point in (joint.first, joint.second) if point.body == own.body]
        points = distinct_points([(own.x, own.y), *((point.x, point.y) for point in joined)], 0.01 * u)[1:]
        radii = sorted({round(math.dist((own.x, own.y), point), 12) for point in points})
        has_disc = bool(radii) and math.hypot(own.x, own.y) < 1e-9 * u
        cranks.append(_Crank((ground.x, ground.y), radii, _disc_radius(mechanism.bodies[index]) if has_disc else 0.0))
    return cranks


def _disc_radius(body: Body) -> float:
    """Return the radius of a uniform disc with the moments of inertia of a body (m), or 0 if they are not those of a disc."""
    xx, yy, xy = body.second_moments.in_plane
    is_round = xx > 0.0 and abs(xx - yy) <= 1e-9 * xx and abs(xy) <= 1e-9 * xx
    return 2 * math.sqrt(xx / body.mass) if is_round and body.mass else 0.0


def crank_shapes(extents: MechanismExtents) -> Iterator[DrawnShape]:
    """Yield the discs of cranks, which look alike at every angle, and the circles on which their pins move."""
    u = extents.length_scale
    for crank in _find_cranks(extents):
        if crank.disc_radius:
            yield Circle("crank web", *crank.centre, min(crank.disc_radius, _MAX_DISC_RADIUS * u))
        circles = (arc_points(crank.centre, 0.0, 2 * math.pi, radius, 72) for radius in crank.radii if radius > _MIN_CIRCLE_RADIUS * u)
        yield Lines("crank circle", tuple(circles))

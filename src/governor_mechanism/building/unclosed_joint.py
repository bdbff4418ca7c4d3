"""Message about a mechanism that does not close: which joint stays open, by how much, and in which direction."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from governor_mechanism.machines.base import rotate_point
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.model.joints import GROUND, Distance, Pin, Point, Weld
from governor_mechanism.types import FloatArray

N_SEARCHES: Final = 6
"""Number of guesses from which the smallest gap is sought; the search of one takes about 10 ms."""

CLOSED_JOINT_WEIGHT: Final = 1e3
"""Weight of a joint that is to close, relative to one that may open: what it leaves open is less than a thousandth of the gap."""


def explain_unclosed_joint(
    solver: PositionSolver,
    guesses: Sequence[FloatArray],  # guessed poses; shape (bodies, 3) each
    held: Sequence[str],  # names of the bodies that keep the angles of the guesses
    # poses (bodies, 3) in which the joints close at other angles of these bodies; None if there are none
    possible: FloatArray | None,
) -> str:
    """Return a sentence on the joint that stays open where all joints together are nearest to closing."""
    indices = [solver.mechanism.body_index(name) for name in held]
    evenly = [minimise_gaps(solver, guess, indices) for guess in guesses[:N_SEARCHES]]
    nearest = min(evenly, key=lambda poses: _sum_of_squares(solver, poses))
    opened = _last_open_joint(solver, nearest)
    poses = minimise_gaps(solver, nearest, indices, opened)  # with the whole gap at one joint, it is what a length must make up for
    joint, gap = solver.equations.largest_gap(poses)
    ends = [_position(solver, poses, point) for point in (joint.first, joint.second)]
    dx, dy = ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]
    at_angles = f" at the given angle of {' and '.join(map(repr, held))}" if held else ""
    text = f"the mechanism cannot be assembled{at_angles}: at best joint {joint.name!r} stays open by {abs(gap):.4g} m"
    places = [
        f"its point on {point.body!r} is at [{x:.4g}, {y:.4g}] m" for point, (x, y) in zip((joint.first, joint.second), ends, strict=True)
    ]
    if isinstance(joint, Pin | Weld):
        places[1] += f", {math.degrees(math.atan2(dy, dx)):.1f} deg from there"
    cure = "change a length or a point of the ground"
    if isinstance(joint, Distance):
        cure = f"a length near {math.hypot(dx, dy):.4g} m instead of {joint.length:.4g} m would close it"
    if possible is not None and held:
        angles = [
            f"{name!r} at {math.degrees(math.remainder(possible[k, 2], math.tau)):.3g} deg" for name, k in zip(held, indices, strict=True)
        ]
        cure += f", or begin with {' and '.join(angles)}"
    return f"{text}: {' and '.join(places)}; {cure}"


def minimise_gaps(
    solver: PositionSolver,
    guess: FloatArray,  # poses; shape (bodies, 3)
    held: Sequence[int],
    opened: int | None = None,  # number of the joint that may open; None for any joint
) -> FloatArray:
    """Return the poses near a guess with the least sum of squared gaps.

    Result: poses; shape (bodies, 3).
    """
    from scipy.optimize import least_squares  # slow to import, and few mechanisms need it

    scales, length = solver.free_coordinate_scales, solver.mechanism.length_scale
    is_held = np.zeros((len(solver.mechanism.bodies), 3), dtype=np.bool_)
    is_held[list(held), 2] = True
    columns = np.flatnonzero(~is_held.ravel()[solver.free_mask])
    weights = np.ones(len(solver.equations.joint_indices))
    if opened is not None:
        weights[solver.equations.joint_indices != opened] = CLOSED_JOINT_WEIGHT

    def poses_at(change: FloatArray) -> FloatArray:
        free_change = np.zeros(len(scales))
        free_change[columns] = change
        return guess + solver.expand_free(scales * free_change)

    result = least_squares(
        lambda change: weights * solver.equations.residuals(poses_at(change), 0.0) / length,
        np.zeros(len(columns)),
        jac=lambda change: weights[:, np.newaxis] * solver.scaled_joint_jacobian(poses_at(change))[:, columns],
        max_nfev=200,
    )
    return poses_at(result.x)


def _last_open_joint(solver: PositionSolver, poses: FloatArray) -> int:
    """Return the number of the last joint that is open: the user added it last, to close what was there."""
    gaps = np.abs(solver.equations.residuals(poses, 0.0))
    return int(solver.equations.joint_indices[np.flatnonzero(gaps > 0.1 * np.max(gaps))[-1]])


def _sum_of_squares(solver: PositionSolver, poses: FloatArray) -> float:
    return float(np.sum(solver.equations.residuals(poses, 0.0) ** 2))


def _position(solver: PositionSolver, poses: FloatArray, point: Point) -> tuple[float, float]:
    """Return the position of a point, m, rounded to three decimals of the length scale for the message."""
    x, y, angle = (0.0, 0.0, 0.0) if point.body == GROUND else poses[solver.mechanism.body_index(point.body)].tolist()
    dx, dy = rotate_point(point.x, point.y, angle)
    decimals = 3 - math.floor(math.log10(solver.mechanism.length_scale))
    return round(x + dx, decimals) + 0.0, round(y + dy, decimals) + 0.0

"""The distance of a governor's ball from the spindle axis, and the number of balls that share the load."""

from dataclasses import dataclass
from numbers import Integral

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import PointCoordinate
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value

USUAL_NAMES = ("ball_radius", "weight_radius")
"""Names of the reading in the machines of the package; a mechanism with other distances from the axis, too, may use them."""

MIRROR_TOLERANCE = 1e-9
"""Distance from the mirror image, in length scales, within which two bodies are mirror images: rounding of the assembly, with room."""

MAX_BALLS = 100
"""Largest number of balls; a larger one is a mistake."""


@dataclass(frozen=True, kw_only=True)
class BallRadius:
    """Reading of a ball's distance from the spindle axis.

    Attributes
    ----------
    name
        Name of the reading.
    sign
        1, or -1 if the reading is negative because the ball is to the left of the spindle.
    n_balls
        Number of balls that share the load.
    """

    name: str
    sign: float
    n_balls: int


def find_ball_radius(
    reduction: SingleDofReduction,
    # name of the reading; None for `ball_radius`, `weight_radius`, or the only distance from the axis
    name: str | None,
    # number of balls; None for two if another body of equal mass is the mirror image of the ball, and else
    # one
    balls: int | None,
) -> BallRadius:
    """Return the reading of the ball's distance from the spindle axis.

    Raises MechanismError if there is no such reading, it is no distance from the spindle axis, or the number
    is wrong.
    """
    mechanism = reduction.mechanism
    reading = _choose_reading(mechanism) if name is None else _validate_reading(mechanism, name)
    if balls is not None and (not isinstance(balls, Integral) or isinstance(balls, bool) or not 1 <= balls <= MAX_BALLS):
        raise MechanismError(f"balls must be a number of balls from 1 to {MAX_BALLS}; got {format_value(balls)}")
    travel = reduction.range_of_motion
    poses = reduction.evaluate(np.linspace(travel.low, travel.high, 5)).poses
    middle = float(evaluate_output_value(mechanism, reading.name, poses)[2])
    number = (2 if _has_mirror_image(mechanism, reading.point.body, poses) else 1) if balls is None else int(balls)
    return BallRadius(name=reading.name, sign=-1.0 if middle < 0.0 else 1.0, n_balls=number)


def _distances_from_axis(mechanism: Mechanism) -> dict[str, PointCoordinate]:
    """Return the readings that are x coordinates of points of bodies, by name."""
    return {one.name: one for one in mechanism.readings if isinstance(one, PointCoordinate) and _is_distance_from_axis(one)}


def _is_distance_from_axis(reading: PointCoordinate) -> bool:
    return (
        abs(reading.direction_x) == 1.0
        and reading.direction_y == 0.0
        and reading.zero == 0.0
        and (reading.origin.body, reading.origin.x) == (GROUND, 0.0)
        and reading.point.body != GROUND
    )


def _choose_reading(mechanism: Mechanism) -> PointCoordinate:
    candidates = _distances_from_axis(mechanism)
    names = [name for name in USUAL_NAMES if name in candidates] or list(candidates)
    if not names:
        raise MechanismError(
            "a controlling force needs a reading that is the distance of a ball from the spindle axis, and this mechanism has none; "
            'add one to [readings], such as ball_radius = { x = "ball.centre" }'
        )
    if len(names) > 1:
        raise MechanismError(f"several readings are distances from the spindle axis: {names}; give one of them as `radius`")
    return candidates[names[0]]


def _validate_reading(mechanism: Mechanism, name: object) -> PointCoordinate:
    if not isinstance(name, str):
        raise MechanismError(f"`radius` must be the name of a reading; got {format_value(name)}")
    mechanism.reading(name)  # raises for an unknown name
    candidates = _distances_from_axis(mechanism)
    if name not in candidates:
        raise MechanismError(f"{name!r} is not the distance of a ball from the spindle axis; such readings are {[*candidates]}")
    return candidates[name]


def _has_mirror_image(mechanism: Mechanism, ball: str, poses: FloatArray) -> bool:
    """Return whether another body of equal mass moves as the mirror image of the ball in the spindle axis."""
    index = mechanism.body_index(ball)
    images = np.abs(poses[:, :, :2] - poses[:, [index], :2] * [-1.0, 1.0]).max(axis=(0, 2)) <= MIRROR_TOLERANCE * mechanism.length_scale
    masses = np.array([body.mass for body in mechanism.bodies])
    is_same_mass = np.abs(masses - masses[index]) <= 1e-12 * masses[index]  # rounding of joined masses
    return bool(np.any(np.delete(images & is_same_mass, index)))

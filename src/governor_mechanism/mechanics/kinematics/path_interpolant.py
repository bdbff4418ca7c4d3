"""Interpolant of the poses along the leading coordinate of a mechanism with one degree of freedom: initial guesses for assembly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.numerics.hermite import cubic_hermite
from governor_mechanism.types import FloatArray

PATH_BISECTIONS = 24
"""Number of bisections that locate a coordinate value on the path closely enough for Newton's iteration."""

MIN_PATH_INTERVALS = 16
"""Smallest number of intervals between path points over a range."""

TANGENT_ERROR_TOLERANCE = 1e-3
"""Largest difference, in length scales and rad, between neighbouring poses and their trapezoidal prediction from the tangents."""

MIN_PATH_SPACING_RATIO = 1e-9
"""Smallest spacing of path points relative to the largest spacing."""


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A point of the path: arc length, leading coordinate and its derivative along the path, poses and their tangent (bodies, 3)."""

    arc_length: float
    value: float
    coordinate_derivative: float
    poses: FloatArray
    tangent: FloatArray


@dataclass(frozen=True, eq=False)
class PathInterpolant:
    """Path points in ascending order of the leading coordinate, as arrays (m,) and (m, bodies, 3)."""

    arc_lengths: FloatArray
    values: FloatArray
    coordinate_derivatives: FloatArray
    poses: FloatArray
    tangents: FloatArray

    @classmethod
    def from_points(cls, points: Sequence[PathPoint]) -> PathInterpolant:
        """Return the interpolant through points, without those at which the coordinate does not increase."""
        ascending = [points[0]]
        ascending += [following for previous, following in pairwise(points) if following.value > previous.value]
        field_names = ("arc_length", "value", "coordinate_derivative", "poses", "tangent")
        return cls(*(np.array([getattr(point, name) for point in ascending]) for name in field_names))

    def predict_poses(self, values: FloatArray) -> FloatArray:
        """Return poses (n, bodies, 3) at values (n,) of the coordinate by cubic Hermite interpolation; clamp beyond the ends.

        The coordinate may turn back at an end: the poses are a smooth function of the arc length, not of the coordinate.
        """
        intervals = np.clip(np.searchsorted(self.values, values) - 1, 0, len(self.values) - 2)
        length = self.arc_lengths[intervals + 1] - self.arc_lengths[intervals]
        value_ends, pose_ends = (
            (samples[intervals], samples[intervals + 1], derivatives[intervals], derivatives[intervals + 1])
            for samples, derivatives in ((self.values, self.coordinate_derivatives), (self.poses, self.tangents))
        )
        low, high = np.zeros(len(values)), np.ones(len(values))
        for _ in range(PATH_BISECTIONS):
            middle = 0.5 * (low + high)
            is_below = cubic_hermite(*value_ends, length, middle) < values
            low, high = np.where(is_below, middle, low), np.where(is_below, high, middle)
        fraction = 0.5 * (low + high)[:, np.newaxis, np.newaxis]
        poses: FloatArray = cubic_hermite(*pose_ends, length[:, np.newaxis, np.newaxis], fraction)
        return poses

    def with_previous_period(self, pose_increment: FloatArray, period: float) -> PathInterpolant:
        """Return a periodic path with one more period in front; pose_increment (bodies, 3) is the change of the poses per period."""
        return PathInterpolant(
            np.concatenate([self.arc_lengths[:-1] - (self.arc_lengths[-1] - self.arc_lengths[0]), self.arc_lengths]),
            np.concatenate([self.values[:-1] - period, self.values]),
            np.concatenate([self.coordinate_derivatives[:-1], self.coordinate_derivatives]),
            np.concatenate([self.poses[:-1] - pose_increment, self.poses]),
            np.concatenate([self.tangents[:-1], self.tangents]),
        )


@dataclass(frozen=True, eq=False)
class _CurvedPathPoint(PathPoint):
    """A path point at a value of the coordinate, which is also its arc length, with the second derivative of the poses (bodies, 3)."""

    curvature: FloatArray


def build_path(mechanism: Mechanism, low: float, high: float) -> PathInterpolant:
    """Return the path over a range of the coordinate, built outward from the initial guess, each point from its neighbour.

    Raises MechanismError, naming the joint that stays open, where the mechanism cannot be assembled.
    """
    position_solver = CoordinateSolver(mechanism)
    initial_value = min(max(position_solver.initial_coordinate, low), high)
    first_point = _solve_path_point(position_solver, initial_value, position_solver.solve_at_coordinate(initial_value))
    max_spacing = (high - low) / MIN_PATH_INTERVALS
    lower_points, upper_points = (_extend_path(position_solver, first_point, end, max_spacing) for end in (low, high))
    return PathInterpolant.from_points([*lower_points[::-1], first_point, *upper_points])


def _extend_path(
    position_solver: CoordinateSolver, first_point: _CurvedPathPoint, end: float, max_spacing: float
) -> list[_CurvedPathPoint]:
    """Return the points after the first one up to an end; short steps keep them from jumping to another branch."""
    points, point, step = list[_CurvedPathPoint](), first_point, max_spacing
    while point.value != end:
        step = min(step, max_spacing)
        value = end if abs(end - point.value) <= step else point.value + math.copysign(step, end - point.value)
        next_point, prediction_error = _try_next_point(position_solver, point, value)
        if prediction_error > TANGENT_ERROR_TOLERANCE and step > MIN_PATH_SPACING_RATIO * max_spacing:
            step /= 2
            continue
        if next_point is None:
            next_point = _solve_path_point(position_solver, value, point.poses)
        point = next_point
        points.append(point)
        step = 2 * step if prediction_error < TANGENT_ERROR_TOLERANCE / 8 else step
    return points


def _try_next_point(position_solver: CoordinateSolver, point: _CurvedPathPoint, value: float) -> tuple[_CurvedPathPoint | None, float]:
    """Return the point at a nearby value, or None if Newton's iteration fails, and the error of the tangents' prediction."""
    displacement = value - point.value
    guess = point.poses + displacement * point.tangent + 0.5 * displacement**2 * point.curvature
    nodes, is_solved = position_solver.try_solve_nodes(guess[np.newaxis], np.array([value]))
    if not is_solved[0]:
        return None, math.inf
    next_point = _CurvedPathPoint(value, value, 1.0, *nodes[0])
    prediction_error = next_point.poses - point.poses - 0.5 * displacement * (point.tangent + next_point.tangent)
    return next_point, float(np.max(np.abs(prediction_error) / position_solver.pose_scales))


def _solve_path_point(position_solver: CoordinateSolver, value: float, guess: FloatArray) -> _CurvedPathPoint:
    return _CurvedPathPoint(value, value, 1.0, *position_solver.solve_nodes(guess[np.newaxis], np.array([value]))[0])

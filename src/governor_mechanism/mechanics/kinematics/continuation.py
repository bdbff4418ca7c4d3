"""Path continuation of a mechanism with one degree of freedom, from its initial guess to the end of its motion, and the poses along it.

An end is a limit of a reading, a turning point of the coordinate (beyond it some joint would stay open), a change point where
the joints leave a second direction of motion, a mass centre that reaches the spindle axis, or the initial guess again after a
closed motion. An interpolant of the poses along the coordinate gives initial guesses for assembly.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value, wrap_difference
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.numerics.interpolation import cubic_hermite
from governor_mechanism.numerics.least_squares import RANK_TOLERANCE
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
        """Return poses (n, bodies, 3) at values (n,) of the coordinate by cubic Hermite interpolation; clamp beyond the ends."""
        # The coordinate may turn back at an end: the poses are a smooth function of the arc length,
        # not of the coordinate.
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
    """Return the path over a range of the coordinate, built outward from the initial guess; MechanismError names an open joint."""
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
    points = list[_CurvedPathPoint]()
    point = first_point
    step = max_spacing
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


INITIAL_PATH_STEP = 0.02
MIN_PATH_STEP = 1e-5
MAX_PATH_STEP = 1.0
"""First, smallest and largest step along the path, as the norm of all changes in length scales and rad."""

MAX_CORRECTOR_RATIO = 0.2
"""Largest distance of the corrected point from the predicted one relative to the step; a longer one halves the step."""

STEP_DOUBLING_CURVATURE = 0.02
"""Deviation of poses and readings from their linear prediction, relative to the step, below which the step is doubled."""

MIN_CONDITION_RATIO = 0.5
"""Smallest ratio of the reciprocal condition numbers at the ends of a step; below it the step is halved."""

BIFURCATION_TOLERANCE = 1e-6
"""Reciprocal condition number of the joint Jacobian below which it is rank-deficient and the path may bifurcate."""

ILL_CONDITIONED_LIMIT = 1e-3
"""Reciprocal condition number below which closing the joints leaves pose errors much larger than rounding."""

PATH_CLOSURE_TOLERANCE = 1e-6
"""Distance from the initial poses, apart from whole turns, below which the path is closed; length scales and rad."""

MAX_PATH_LENGTH = 50.0
"""Length at which the continuation of an unbounded motion stops; length scales and rad."""


@dataclass(frozen=True, eq=False)
class ContinuationPoint(PathPoint):
    """A path point with the reciprocal condition number of the joint Jacobian; `tangent` is the unit vector of the free coordinates."""

    reciprocal_condition: float


@dataclass(frozen=True, eq=False)
class PathEnd:
    """The end of a path: coordinate, message, the points up to it, and whether the path is closed."""

    value: float
    message: str
    points: tuple[PathPoint, ...]
    is_closed: bool = False


class PathContinuation:
    """Trace the motion of a mechanism from its initial guess; MechanismError for another mobility than one, or at a turning point."""

    def __init__(self, mechanism: Mechanism, *, rotates_with_spindle: bool) -> None:
        self.mechanism, self.position_solver = mechanism, PositionSolver(mechanism)
        initial_poses = self.position_solver.solve({})
        if self.position_solver.count_degrees_of_freedom(initial_poses) != 1:
            raise MechanismError(
                "a range of motion needs one degree of freedom; this mechanism has mobility "
                f"{self.position_solver.count_degrees_of_freedom(initial_poses)}"
            )
        self._is_angle = mechanism.reading(mechanism.coordinate).quantity == "angle"
        self._coordinate_scale = self.mechanism.output_scale(mechanism.coordinate)
        singular_values, right_singular_vectors = np.linalg.svd(self.position_solver.scaled_joint_jacobian(initial_poses))[1:]
        self._rank = int(np.sum(singular_values > RANK_TOLERANCE * singular_values[0])) if singular_values.size else 0
        coordinate_derivative = self.position_solver.output_derivative(mechanism.coordinate, initial_poses, right_singular_vectors[-1])
        if abs(coordinate_derivative) < RANK_TOLERANCE * self._coordinate_scale:
            raise MechanismError(f"{mechanism.coordinate!r} is at a turning point in the initial guess; move the initial guess a little")
        value = self._output_value(mechanism.coordinate, initial_poses)
        self.start = self._make_point(initial_poses, right_singular_vectors[-1] * math.copysign(1.0, coordinate_derivative), value, 0.0)
        # Mass centres off the spindle axis that move towards or away from it may reach it.
        tolerance = RANK_TOLERANCE * mechanism.length_scale
        start_tangent = self._body_tangent(self.start)
        crosses_axis = np.all(np.abs([initial_poses[:, 0], start_tangent[:, 0]]) > tolerance, axis=0)
        self._axis_crossing_bodies = np.flatnonzero(crosses_axis & rotates_with_spindle).tolist()
        self._monitored_readings = list(dict.fromkeys([mechanism.coordinate, *(limit.reading for limit in mechanism.limits)]))

    def find_end(self, direction: float) -> PathEnd:
        """Return the end of the path in a direction (1 or -1 along the coordinate), with its points from the initial guess on."""
        start_derivative = direction * self.start.coordinate_derivative
        point = replace(self.start, tangent=direction * self.start.tangent, coordinate_derivative=start_derivative)
        points = [point]
        step = INITIAL_PATH_STEP
        n_turns = 1
        while MAX_PATH_LENGTH - point.arc_length > MIN_PATH_STEP:
            next_point, step = self._next_point(point, min(step, MAX_PATH_LENGTH - point.arc_length))
            while end_found := self._find_end_in_step([*points[-2:], next_point], direction, n_turns):
                if end_found[1] or self._matches_start(end_found[0].poses):
                    break
                n_turns += 1
            if end_found is not None:
                return self._make_end(points, *end_found, direction)
            points.append(next_point)
            point = next_point
        message = f"the motion was followed over a length of {MAX_PATH_LENGTH:g} length scales or rad and no farther"
        return self._make_end(points, point, message, direction)

    def pose_increment(self, end: PathEnd) -> FloatArray:
        """Return the change of the poses (bodies, 3) over a closed path: whole turns of bodies."""
        increment = np.zeros_like(self.start.poses)
        increment[:, 2] = math.tau * np.round((end.points[-1].poses - self.start.poses)[:, 2] / math.tau)
        return increment

    def _make_end(self, points: list[ContinuationPoint], last_point: ContinuationPoint, message: str, direction: float) -> PathEnd:
        """Return a path end whose points have arc length and tangent oriented with increasing coordinate."""
        path_points = []
        for point in (*(point for point in points if point.arc_length < last_point.arc_length), last_point):
            derivative = direction * point.coordinate_derivative
            tangent = direction * self._body_tangent(point)
            path_points.append(PathPoint(direction * point.arc_length, point.value, derivative, point.poses, tangent))
        return PathEnd(last_point.value, message, tuple(path_points), not message)

    def _body_tangent(self, point: ContinuationPoint) -> FloatArray:
        return self.position_solver.expand_free(self.position_solver.free_coordinate_scales * point.tangent)

    def _next_point(self, point: ContinuationPoint, step: float) -> tuple[ContinuationPoint, float]:
        """Return the next point and the step to try from there."""
        while True:
            next_point, corrector_distance = self._try_step(point, step)
            if step < MIN_PATH_STEP:
                break
            if next_point is not None and corrector_distance < MAX_CORRECTOR_RATIO * step:
                min_condition = MIN_CONDITION_RATIO * point.reciprocal_condition
                if next_point.reciprocal_condition >= min_condition or step <= INITIAL_PATH_STEP:
                    break
            step /= 2
        if next_point is None:
            raise MechanismError(f"the motion cannot be followed beyond {self.mechanism.coordinate} = {point.value:.6g}")
        curvature = max(corrector_distance, *(self._linearity_error(name, point, next_point) for name in self._monitored_readings)) / step
        is_well_conditioned = next_point.reciprocal_condition > (1 - STEP_DOUBLING_CURVATURE) * point.reciprocal_condition
        if curvature < STEP_DOUBLING_CURVATURE and is_well_conditioned:
            return next_point, min(2 * step, MAX_PATH_STEP)
        return next_point, step if curvature < 2 * STEP_DOUBLING_CURVATURE else max(step / 2, min(step, INITIAL_PATH_STEP))

    def _try_step(self, point: ContinuationPoint, step: float) -> tuple[ContinuationPoint | None, float]:
        """Return the corrected point after a step, or None if the joints do not close, and its distance from the predicted one."""
        predicted = point.poses + step * self._body_tangent(point)
        try:
            poses = self.position_solver.solve({}, predicted)
        except MechanismError:
            return None, math.inf
        correction = (poses - predicted).ravel()[self.position_solver.free_mask] / self.position_solver.free_coordinate_scales
        return self._point_at_poses(poses, point, step), float(np.linalg.norm(correction))

    def _linearity_error(self, name: str, point: ContinuationPoint, next_point: ContinuationPoint) -> float:
        """Return the deviation of a reading from its linear prediction over a step, in length scales or rad."""
        change = self._output_value(name, next_point.poses) - self._output_value(name, point.poses)
        change = wrap_difference(self.mechanism.reading(name), change)
        derivative = self.position_solver.output_derivative(name, point.poses, point.tangent)
        return abs(change - (next_point.arc_length - point.arc_length) * derivative) / self.mechanism.output_scale(name)

    def _make_point(
        self, poses: FloatArray, previous_tangent: FloatArray, value: float = 0.0, arc_length: float = 0.0
    ) -> ContinuationPoint:
        """Return the point at assembled poses, with the free direction that continues the previous tangent."""
        singular_values, right_singular_vectors = np.linalg.svd(self.position_solver.scaled_joint_jacobian(poses))[1:]
        reciprocal_condition = float(singular_values[self._rank - 1] / singular_values[0]) if self._rank else 1.0
        # Where the joints leave a second direction of motion, the tangent is continued straight on.
        null_space = right_singular_vectors[self._rank - (1 if reciprocal_condition < BIFURCATION_TOLERANCE else 0) :]
        tangent = null_space.T @ (null_space @ previous_tangent)
        tangent = tangent / np.linalg.norm(tangent)
        coordinate_derivative = self.position_solver.output_derivative(self.mechanism.coordinate, poses, tangent)
        return ContinuationPoint(arc_length, value, coordinate_derivative, poses, tangent, reciprocal_condition)

    def _find_end_in_step(self, points: list[ContinuationPoint], direction: float, n_turns: int) -> tuple[ContinuationPoint, str] | None:
        """Return the end within the last step with its message, or None if there is none or only a turn already counted."""
        point, next_point = points[-2:]
        ends = [
            (self._locate_zero(point, next_point, violation), message)
            for violation, message in self._end_conditions(point, direction, n_turns)
            if violation(next_point.poses) >= 0.0
        ]
        turns_back = direction * point.coordinate_derivative > 0.0 >= direction * next_point.coordinate_derivative
        if turns_back and next_point.reciprocal_condition > BIFURCATION_TOLERANCE:
            turning_point = self._locate_zero(
                point, next_point, lambda poses: -direction * self._make_point(poses, point.tangent).coordinate_derivative
            )
            ends.append((turning_point, self._turning_point_message(turning_point.poses, direction)))
        triples = [points] if len(points) == 3 else []
        if ends:  # a change point may lie in the same step, before the end
            step = min(INITIAL_PATH_STEP, next_point.arc_length - point.arc_length)
            triples.append([point, next_point, self._next_point(next_point, step)[0]])
        for first, middle, last in triples:
            if middle.reciprocal_condition < min(first.reciprocal_condition, last.reciprocal_condition):
                change_point = self._find_change_point([first, middle, last])
                message = "change point: the joints leave a second direction of motion"
                ends += [] if change_point is None else [(change_point, message)]
        return min(ends, key=lambda end: direction * end[0].value, default=None)

    def _point_after(self, previous: ContinuationPoint, distance: float) -> ContinuationPoint:
        """Return the assembled point at a distance after another one."""
        return self._point_at_poses(self._correct_poses(previous, distance), previous, distance)

    def _point_at_poses(self, poses: FloatArray, previous: ContinuationPoint, distance: float) -> ContinuationPoint:
        return self._make_point(poses, previous.tangent, self._unwrapped_coordinate(poses, previous.value), previous.arc_length + distance)

    def _end_conditions(
        self, point: ContinuationPoint, direction: float, n_turns: int
    ) -> Iterator[tuple[Callable[[FloatArray], float], str]]:
        """Yield functions that are negative on the path, each with the message of its zero; a whole turn has an empty message."""
        for limit in self.mechanism.limits:
            if limit.reading != self.mechanism.coordinate:
                yield partial(self._limit_violation, limit.reading, -1.0, limit.low), limit.low_message
                yield partial(self._limit_violation, limit.reading, 1.0, limit.high), limit.high_message
        for k in self._axis_crossing_bodies:
            message = f"the mass centre of {self.mechanism.bodies[k].name!r} reaches the spindle axis"
            yield partial(self._axis_crossing_distance, k), message
        if self._is_angle:
            value = self.start.value
            yield (lambda poses: direction * (self._unwrapped_coordinate(poses, point.value) - value) - n_turns * math.tau, "")

    def _matches_start(self, poses: FloatArray) -> bool:
        """Return whether poses are the initial ones apart from whole turns of bodies."""
        difference = poses - self.start.poses
        difference[:, 2] -= math.tau * np.round(difference[:, 2] / math.tau)
        return bool(np.all(np.abs(difference) < PATH_CLOSURE_TOLERANCE * self.position_solver.pose_scales))

    def _limit_violation(self, name: str, sign: float, limit: float, poses: FloatArray) -> float:
        return sign * (self._output_value(name, poses) - limit)

    def _axis_crossing_distance(self, body: int, poses: FloatArray) -> float:
        """Return how far, m, a mass centre has passed the spindle axis from its original side."""
        return -math.copysign(1.0, self.start.poses[body, 0]) * float(poses[body, 0])

    def _locate_zero(
        self, point: ContinuationPoint, next_point: ContinuationPoint, violation: Callable[[FloatArray], float]
    ) -> ContinuationPoint:
        """Return the point between two at which a violation function is zero."""
        from scipy.optimize import brentq  # slow to import

        if violation(point.poses) >= 0.0:
            return self._point_after(point, 0.0)
        find_zero = partial(brentq, a=0.0, b=next_point.arc_length - point.arc_length, xtol=1e-13, rtol=1e-13)
        crossing_point = self._point_after(point, find_zero(lambda s: violation(self._correct_poses(point, s))))
        if crossing_point.reciprocal_condition > ILL_CONDITIONED_LIMIT:
            return crossing_point
        return self._point_on_cubic(point, next_point, find_zero(lambda s: violation(self._hermite_poses(point, next_point, s))))

    def _point_on_cubic(self, point: ContinuationPoint, next_point: ContinuationPoint, distance: float) -> ContinuationPoint:
        return self._point_at_poses(self._hermite_poses(point, next_point, distance), point, distance)

    def _hermite_poses(self, point: ContinuationPoint, next_point: ContinuationPoint, distance: float) -> FloatArray:
        """Return poses on the cubic between two points; near a singularity they are more accurate than assembled ones."""
        length = next_point.arc_length - point.arc_length
        tangents = (self._body_tangent(point), self._body_tangent(next_point))
        poses: FloatArray = cubic_hermite(point.poses, next_point.poses, *tangents, length, distance / length)
        return poses

    def _correct_poses(self, point: ContinuationPoint, distance: float) -> FloatArray:
        return self.position_solver.solve({}, point.poses + distance * self._body_tangent(point))

    def _find_change_point(self, points: list[ContinuationPoint]) -> ContinuationPoint | None:
        """Return the point between three at which the joint Jacobian loses rank, or None."""
        from scipy.optimize import minimize_scalar  # slow to import

        for point, next_point in pairwise(points):
            point_at = partial(self._point_on_cubic, point, next_point)
            bounds = (0.0, next_point.arc_length - point.arc_length)
            minimum = minimize_scalar(
                lambda distance, at=point_at: at(distance).reciprocal_condition, bounds=bounds, method="bounded", options={"xatol": 1e-12}
            )
            if minimum.fun < BIFURCATION_TOLERANCE:
                return point_at(float(minimum.x))
        return None

    def _turning_point_message(self, poses: FloatArray, direction: float) -> str:
        """Return why the coordinate turns back: the joint that would stay open beyond."""
        name = self.mechanism.coordinate
        value = self._output_value(self.mechanism.coordinate, poses)
        try:
            with np.errstate(invalid="ignore"):  # a vanishing distance has no direction
                self.position_solver.solve_at_coordinate(value + direction * 1e-3 * self._coordinate_scale, poses)
        except MechanismError as error:
            return f"turning point: {name} turns back; beyond it, {error.problems[0].partition(': ')[2]}"
        return f"turning point: {name} turns back there"

    def _unwrapped_coordinate(self, poses: FloatArray, reference: float) -> float:
        """Return the coordinate at poses; the angle of a line is unwrapped to the value nearest the reference."""
        value = self._output_value(self.mechanism.coordinate, poses)
        if isinstance(self.mechanism.reading(self.mechanism.coordinate), LineAngle):
            return reference + math.remainder(value - reference, math.tau)
        return value

    def _output_value(self, name: str, poses: FloatArray) -> float:
        with np.errstate(invalid="ignore"):  # a vanishing distance: its value is correct
            return float(evaluate_output_value(self.mechanism, name, poses))

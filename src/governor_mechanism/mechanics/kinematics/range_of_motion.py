"""Range of motion of a mechanism with one degree of freedom: its limits, what causes them, and the path between them.

Without a given limit of the leading coordinate the motion is traced from the initial guess in both directions (see
`continuation`). With a given limit the path is built between its ends, and cut where another reading reaches a limit of its own.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.kinematics.continuation import MAX_PATH_LENGTH, PathContinuation, PathEnd, PathInterpolant, build_path
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import Limit, LineAngle
from governor_mechanism.types import FloatArray

RANGE_END_MARGIN = 1e-5
"""Fraction of the range left out at each end, where the mechanism may be at a turning point."""

N_LIMIT_SAMPLES = 257
"""Number of coordinate values at which the other readings are compared with their limits."""

RANGE_CACHE_SIZE = 16
"""Number of mechanisms whose range of motion is cached: one study of a scene needs it several times."""


@dataclass(frozen=True, eq=False)
class RangeOfMotion:
    """The range of the leading coordinate (SI) and a sentence on what happens at each end.

    low and high lie inside `ends` by a small margin; for a closed motion they are one `period` (else 0) apart and the same
    configuration. `full_turn` may be added to a value without changing the poses (else 0). path covers the range, and one of a
    closed motion extends beyond both ends.
    """

    low: float
    high: float
    low_message: str
    high_message: str
    ends: tuple[float, float]
    path: PathInterpolant
    period: float = 0.0
    full_turn: float = 0.0

    def unwrap_values(self, values: FloatArray) -> FloatArray:
        """Return values (n,) of the coordinate shifted by whole turns into the range, where that is possible."""
        if not self.full_turn:
            return values
        low, high = (self.low, self.high) if self.period else self.ends
        shifted = values + self.full_turn * np.ceil((low - values) / self.full_turn)
        is_unchanged = ((low <= values) & (values <= high)) | (shifted > high) | (np.abs(shifted - values) > MAX_PATH_LENGTH)
        unwrapped: FloatArray = np.where(is_unchanged, values, shifted)
        return unwrapped

    def find_distinct(self, extents: Sequence[tuple[float, float]], tolerance: float) -> list[int]:
        """Return the indices of extents of the coordinate in the range; one at both ends of a period counts once, at the high end."""
        middles = [0.5 * (low + high) for low, high in extents]
        inside = [k for k, middle in enumerate(middles) if self.low - tolerance < middle < self.high + tolerance]
        if not self.period:
            return inside
        return [k for k in inside if not any(low - tolerance < middles[k] + self.period < high + tolerance for low, high in extents)]

    def contains(self, values: FloatArray) -> NDArray[np.bool_]:
        """Return which of the values (n,) lie in the range."""
        if self.period:
            return np.asarray((self.low <= values) & (values <= self.high))
        return np.asarray((self.ends[0] < values) & (values < self.ends[1]))


def find_range_of_motion(mechanism: Mechanism, *, rotates_with_spindle: bool) -> RangeOfMotion:
    """Return the range of motion of a mechanism, in a fixed plane or one that rotates with the spindle, or raise MechanismError."""
    # A limit given for the leading coordinate is taken as it is; without one the motion is traced from
    # the initial guess. Errors: another number of degrees of freedom than one, a coordinate that does
    # not change, limits of other readings that leave no range.
    return _find_range(replace(mechanism, force_elements=()), rotates_with_spindle)


@lru_cache(maxsize=RANGE_CACHE_SIZE)
def _find_range(mechanism: Mechanism, rotates_with_spindle: bool) -> RangeOfMotion:
    """Return the range of motion of a mechanism without the force elements, on which it does not depend."""
    for limit in mechanism.limits:
        if limit.reading == mechanism.coordinate:
            return _range_within_limits(mechanism, limit)
    return trace_range_of_motion(mechanism, rotates_with_spindle=rotates_with_spindle)


def trace_range_of_motion(mechanism: Mechanism, *, rotates_with_spindle: bool) -> RangeOfMotion:
    """Return the range found by tracing the motion from the initial guess in both directions, ignoring limits of the coordinate itself."""
    continuation = PathContinuation(mechanism, rotates_with_spindle=rotates_with_spindle)
    high_end = continuation.find_end(1.0)
    if high_end.is_closed:
        return _full_rotation_range(continuation, high_end)
    low_end = continuation.find_end(-1.0)
    if not high_end.value > low_end.value:
        raise MechanismError(f"{mechanism.coordinate!r} does not change while the mechanism moves; choose another coordinate")
    path = PathInterpolant.from_points([*low_end.points[:0:-1], *high_end.points])
    return _with_end_margins(mechanism, (low_end.value, high_end.value), (low_end.message, high_end.message), path)


def _full_rotation_range(continuation: PathContinuation, high_end: PathEnd) -> RangeOfMotion:
    """Return the range of a closed motion: half a period to either side of the initial guess."""
    initial_value = continuation.start.value
    n_turns = round((high_end.value - continuation.start.value) / math.tau)
    period = math.tau * n_turns
    several_turns = f"closed motion after {n_turns} turns: {n_turns / 2:g} turns from the initial guess"
    message = "full rotation: half a turn from the initial guess" if n_turns == 1 else several_turns
    low, high = initial_value - 0.5 * period, initial_value + 0.5 * period
    path = PathInterpolant.from_points(high_end.points).with_previous_period(continuation.pose_increment(high_end), period)
    return RangeOfMotion(low, high, message, message, (low, high), path, period, period)


def _with_end_margins(mechanism: Mechanism, ends: tuple[float, float], messages: tuple[str, str], path: PathInterpolant) -> RangeOfMotion:
    full_turn = math.tau if isinstance(mechanism.reading(mechanism.coordinate), LineAngle) else 0.0
    return RangeOfMotion(*_apply_margin(*ends), *messages, ends, path, full_turn=full_turn)


def _apply_margin(low: float, high: float) -> tuple[float, float]:
    margin = RANGE_END_MARGIN * (high - low)
    return low + margin, high - margin


def _range_within_limits(mechanism: Mechanism, coordinate_limit: Limit) -> RangeOfMotion:
    """Return the range between the limits of the coordinate, restricted by those of other readings."""
    ends = (coordinate_limit.low, coordinate_limit.high)
    messages = (coordinate_limit.low_message, coordinate_limit.high_message)
    full_range = _with_end_margins(mechanism, ends, messages, build_path(mechanism, *_apply_margin(*ends)))
    other_limits = [limit for limit in mechanism.limits if limit is not coordinate_limit]
    return _restrict_to_other_limits(mechanism, full_range, other_limits) if other_limits else full_range


def _restrict_to_other_limits(mechanism: Mechanism, full_range: RangeOfMotion, other_limits: list[Limit]) -> RangeOfMotion:
    """Return the part of a range within the limits of other readings: the one with the initial guess, else the longest."""
    position_solver = CoordinateSolver(mechanism)
    values = np.linspace(full_range.low, full_range.high, N_LIMIT_SAMPLES)
    is_inside = np.all(_limit_violations(position_solver, full_range.path, other_limits, values) < 0.0, axis=0)
    if is_inside.all():
        return full_range
    if not is_inside.any():
        raise MechanismError(
            f"the mechanism has no range of motion: over the whole range of {mechanism.coordinate!r}, {full_range.ends[0]:.6g} to "
            f"{full_range.ends[1]:.6g}, other readings are outside their limits: {other_limits[0].reading!r} must lie within "
            f"{other_limits[0].low:.6g} to {other_limits[0].high:.6g}; change the dimensions"
        )
    first, last = _select_valid_interval(is_inside, values, position_solver.initial_coordinate)
    ends = list(full_range.ends)
    messages = [full_range.low_message, full_range.high_message]
    for side, index, outside_index in ((0, first, first - 1), (1, last, last + 1)):
        if 0 <= outside_index < N_LIMIT_SAMPLES:
            ends[side], messages[side] = _locate_limit(position_solver, full_range.path, other_limits, values[index], values[outside_index])
    return _with_end_margins(mechanism, (ends[0], ends[1]), (messages[0], messages[1]), full_range.path)


def _limit_violations(position_solver: CoordinateSolver, path: PathInterpolant, limits: list[Limit], values: FloatArray) -> FloatArray:
    """Return the amounts (2 limits, n) by which readings exceed the low and the high end of each limit at values (n,)."""
    poses = position_solver.solve_nodes(path.predict_poses(values), values)[:, 0]
    readings = [evaluate_output_value(position_solver.mechanism, limit.reading, poses) for limit in limits]
    pairs = [(limit.low - value, value - limit.high) for limit, value in zip(limits, readings, strict=True)]
    return np.concatenate(pairs)


def _select_valid_interval(is_inside: NDArray[np.bool_], values: FloatArray, initial_value: float) -> tuple[int, int]:
    """Return the first and last index of the valid run with the initial value, else of the longest one."""
    runs = find_runs(is_inside)
    containing = [run for run in runs if values[run[0]] <= initial_value <= values[run[1]]]
    return max(containing or runs, key=lambda run: run[1] - run[0])


def find_runs(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the first and last index of each run of true values in a mask (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return list(zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True))


def _locate_limit(
    position_solver: CoordinateSolver, path: PathInterpolant, limits: list[Limit], inside: float, outside: float
) -> tuple[float, str]:
    """Return the first value between inside and outside at which a reading reaches a limit, with its message."""
    from scipy.optimize import brentq  # slow to import

    def violation_at(value: float, side: int) -> float:
        return float(_limit_violations(position_solver, path, limits, np.array([value]))[side, 0])

    messages = [message for limit in limits for message in (limit.low_message, limit.high_message)]
    exceeded = np.flatnonzero(_limit_violations(position_solver, path, limits, np.array([outside]))[:, 0] >= 0.0)
    crossings = [
        (float(brentq(violation_at, inside, outside, args=(side,), xtol=1e-14, rtol=1e-14)), messages[side]) for side in exceeded.tolist()
    ]
    return min(crossings, key=lambda crossing: abs(crossing[0] - inside))

"""Time grid of a run: reported times, breakpoints of the inputs, and further times at which limits are monitored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray, IntArray

SAME_TIME_RATIO = 1e-12
"""Times closer than this fraction of the run are the same time."""


MAX_COUNTED_STEPS = 2.0**40
"""Largest number of steps of one interval that is represented: no run is allowed more."""


@dataclass(frozen=True)
class TimeGrid:
    """Times of a run at which its state is recorded."""

    monitor_times: FloatArray  # recorded times, s, ascending from 0; shape (n,)
    reported_indices: IntArray  # index of each reported time in `monitor_times`
    min_steps: IntArray  # smallest number of steps in each interval; shape (n - 1,)

    def truncate(self, n_times: int) -> TimeGrid:
        """Return the grid of the first `n_times` monitor times."""
        return TimeGrid(self.monitor_times[:n_times], self.reported_indices[self.reported_indices < n_times], self.min_steps[: n_times - 1])


def sort_distinct(times: FloatArray) -> FloatArray:
    """Return times in ascending order, each once: `numpy.unique` would import masked arrays, which takes as long as a short run."""
    ascending: FloatArray = np.sort(times)
    is_new = np.ones(len(ascending), dtype=bool)
    is_new[1:] = ascending[1:] != ascending[:-1]
    return ascending[is_new]


def divide_intervals(
    knots: FloatArray,  # ends of the intervals, ascending; shape (n,)
    n_intervals: IntArray,  # number of equal intervals in each of them; shape (n - 1,)
) -> FloatArray:
    """Return the knots and points that divide the intervals between them into equal ones, ascending."""
    ends = np.cumsum(n_intervals)
    interval = np.repeat(np.arange(len(n_intervals)), n_intervals)
    place = np.arange(1, len(interval) + 1) - (ends - n_intervals)[interval]
    points = knots[:-1][interval] + place * (np.diff(knots) / n_intervals)[interval]
    points[ends - 1] = knots[1:]
    return np.append(knots[:1], points)


def make_time_grid(
    times: FloatArray,  # reported times, s, ascending; shape (n,). Without any, the grid has the start only
    breakpoints: FloatArray,  # times at which an input function or its derivative jumps, s
    max_step: float,  # largest step, s
    max_interval: float,  # largest distance of two monitor times, s
) -> TimeGrid:
    """Return the grid of a run from 0 s on, with all reported times and all breakpoints up to the last of them."""
    if not times.size:
        return TimeGrid(np.zeros(1), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    inner_breakpoints = breakpoints[(breakpoints > 0) & (breakpoints <= times[-1] * (1 + SAME_TIME_RATIO))]
    # 0.1 * 3 is not 0.3: a reported time next to a breakpoint is that breakpoint, else there would be an interval of rounding.
    at_breakpoint = np.abs(times[:, np.newaxis] - inner_breakpoints).min(axis=1, initial=np.inf) < SAME_TIME_RATIO * times[-1]
    knots = sort_distinct(np.concatenate([[0.0], times[~at_breakpoint], inner_breakpoints]))
    n_intervals = np.maximum(1, np.ceil(np.diff(knots) / max_interval * (1 - 1e-12)).astype(np.int64))
    monitor_times = divide_intervals(knots, n_intervals)
    min_steps = np.maximum(1, np.ceil(np.minimum(np.diff(monitor_times) / max_step * (1 - 1e-12), MAX_COUNTED_STEPS)).astype(np.int64))
    # The velocity at a jump of a load is extrapolated from the two half steps before it.
    min_steps = np.where(np.isin(monitor_times[1:], inner_breakpoints), np.maximum(min_steps, 2), min_steps)
    reported_indices = np.searchsorted(monitor_times, times - SAME_TIME_RATIO * times[-1])
    return TimeGrid(monitor_times, reported_indices, min_steps)

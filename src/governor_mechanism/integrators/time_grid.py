"""The stations of a fixed-step run: reported times, breaks of the spindle's speed, and more to watch limits at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray

SAME_TIME_RATIO = 1e-12
"""Times closer than this fraction of the run are one."""


MAX_COUNTED_STEPS = 2.0**40
"""Steps of one interval beyond which their number no longer matters: no run is allowed so many."""


@dataclass(frozen=True)
class TimeGrid:
    """Stations (s), the index of each reported time among them, and the coarsest number of steps in each interval."""

    monitor_times: FloatArray
    reported_indices: np.ndarray[tuple[int], np.dtype[np.int64]]
    min_steps: np.ndarray[tuple[int], np.dtype[np.int64]]

    def truncate(self, n_times: int) -> TimeGrid:
        """The same grid, cut after so many stations."""
        return TimeGrid(self.monitor_times[:n_times], self.reported_indices[self.reported_indices < n_times], self.min_steps[: n_times - 1])


def make_time_grid(times: FloatArray, breakpoints: FloatArray, max_step: float, max_interval: float) -> TimeGrid:
    """A grid whose steps are at most `step` and whose stations are at most `longest` apart (s), starting at 0.

    Without reported times, the start alone.
    """
    if not times.size:
        return TimeGrid(np.zeros(1), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    inner_breakpoints = breakpoints[(breakpoints > 0) & (breakpoints <= times[-1] * (1 + SAME_TIME_RATIO))]
    # 0.1 * 3 is not 0.3: a reported time beside a break is that break, or an interval of rounding would be stepped.
    at_breakpoint = np.abs(times[:, np.newaxis] - inner_breakpoints).min(axis=1, initial=np.inf) < SAME_TIME_RATIO * times[-1]
    knots = np.unique(np.concatenate([[0.0], times[~at_breakpoint], inner_breakpoints]))
    n_intervals = np.maximum(1, np.ceil(np.diff(knots) / max_interval * (1 - 1e-12)).astype(np.int64))
    monitor_times = np.concatenate(
        [[knots[0]]] + [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(knots, knots[1:], n_intervals, strict=False)]
    )
    min_steps = np.maximum(1, np.ceil(np.minimum(np.diff(monitor_times) / max_step * (1 - 1e-12), MAX_COUNTED_STEPS)).astype(np.int64))
    # A velocity next to a jump of the load is found from the two half steps before it.
    min_steps = np.where(np.isin(monitor_times[1:], inner_breakpoints), np.maximum(min_steps, 2), min_steps)
    reported_indices = np.searchsorted(monitor_times, times - SAME_TIME_RATIO * times[-1])
    return TimeGrid(monitor_times, reported_indices, min_steps)

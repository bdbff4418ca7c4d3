"""The stations of a fixed-step run: reported times, breaks of the spindle's speed, and more to watch limits at."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.types import FloatArray

SAME = 1e-12
"""Times closer than this fraction of the run are one."""


UNCOUNTED = 2.0**40
"""Steps of one interval beyond which their number no longer matters: no run is allowed so many."""


@dataclass(frozen=True)
class Grid:
    """Stations (s), the index of each reported time among them, and the coarsest number of steps in each interval."""

    stations: FloatArray
    reported: np.ndarray[tuple[int], np.dtype[np.int64]]
    steps: np.ndarray[tuple[int], np.dtype[np.int64]]

    def first(self, stations: int) -> Grid:
        """The same grid, cut after so many stations."""
        return Grid(self.stations[:stations], self.reported[self.reported < stations], self.steps[: stations - 1])


def make_grid(times: FloatArray, breaks: FloatArray, step: float, longest: float) -> Grid:
    """A grid whose steps are at most `step` and whose stations are at most `longest` apart (s), starting at 0.

    Without reported times, the start alone.
    """
    if not times.size:
        return Grid(np.zeros(1), np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64))
    inner = breaks[(breaks > 0) & (breaks <= times[-1] * (1 + SAME))]
    # 0.1 * 3 is not 0.3: a reported time beside a break is that break, or an interval of rounding would be stepped.
    beside = np.abs(times[:, np.newaxis] - inner).min(axis=1, initial=np.inf) < SAME * times[-1]
    marks = np.unique(np.concatenate([[0.0], times[~beside], inner]))
    pieces = np.maximum(1, np.ceil(np.diff(marks) / longest * (1 - 1e-12)).astype(np.int64))
    stations = np.concatenate(
        [[marks[0]]] + [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(marks, marks[1:], pieces, strict=False)]
    )
    steps = np.maximum(1, np.ceil(np.minimum(np.diff(stations) / step * (1 - 1e-12), UNCOUNTED)).astype(np.int64))
    # A velocity next to a jump of the load is found from the two half steps before it.
    steps = np.where(np.isin(stations[1:], inner), np.maximum(steps, 2), steps)
    reported = np.searchsorted(stations, times - SAME * times[-1])
    return Grid(stations, reported, steps)

"""The part of a run of a governed engine in which the governor moves: what a film shows."""

import math

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.geometry.primitives import round_step
from governor_mechanism.render.machines.engine_room.arrangement import EngineRoomParts

_TAIL_FRACTION, _BAND_FRACTION = 0.1, 0.03
"""Last part of a run that tells where a reading settles, and how far it may be outside that range, relative to the range of the run."""
_HUNTING_FRACTION = 0.3
"""Range of the last part of a run, relative to that of the run, above which the governor hunts."""
_MARGIN_FRACTION, _MIN_MARGIN = 0.3, 2.0
"""Time that is shown after the governor has settled: relative to the time before, and at least (s)."""


def settled_time(run: Trajectory, governed: EngineRoomParts) -> float:
    """Return a round time (s) soon after the governor has settled for the rest of the run, or the end of the run if it does not."""
    values, times = run.readings[governed.governor_reading], run.times
    tail = values[-max(round(_TAIL_FRACTION * len(values)), 1) :]
    band, is_hunting = _BAND_FRACTION * float(np.ptp(values)), bool(np.ptp(tail) > _HUNTING_FRACTION * np.ptp(values))
    outside = np.flatnonzero((values < tail.min() - band) | (values > tail.max() + band))
    first, last = float(times[0]), float(times[-1])
    if is_hunting or not len(outside) or last - first < 2 * _MIN_MARGIN:
        return last
    settled = float(times[outside[-1]]) - first
    step = round_step(last - first, 20)
    return min(first + step * math.ceil((settled + max(_MARGIN_FRACTION * settled, _MIN_MARGIN)) / step), last)

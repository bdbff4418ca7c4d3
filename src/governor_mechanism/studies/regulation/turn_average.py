"""Speed of a shaft averaged over a turn, and how evenly it turns within one."""

import math
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True, eq=False)
class TurnAverage:
    """Mean speed over one turn, as a function of time.

    Attributes
    ----------
    times
        Middle of each turn, s; shape (n,).
    periods
        Time that each turn takes, s; shape (n,).
    speeds
        Mean speed over it, rad/s; shape (n,).
    fluctuations
        Highest less lowest speed in it, over the mean; shape (n,).
    """

    times: FloatArray
    periods: FloatArray
    speeds: FloatArray
    fluctuations: FloatArray


def average_over_turns(
    times: FloatArray,  # times, s; shape (n,)
    angles: FloatArray,  # angle of the shaft, rad, rising; shape (n,)
    speeds: FloatArray,  # its rate, rad/s, above 0; shape (n,)
) -> TurnAverage:
    """Return the mean speed over the turn about each reported time.

    Result: averages over the turns that lie between the first and the last time; one for each time at which
    such a turn ends.
    """
    time_at = CubicHermiteSpline(angles, times, 1.0 / speeds)
    ends = np.flatnonzero(angles >= angles[0] + math.tau)
    starts = time_at(angles[ends] - math.tau)
    first = np.searchsorted(angles, angles[ends] - math.tau)
    periods = times[ends] - starts
    means = math.tau / periods
    spans = np.array([np.ptp(speeds[i : j + 1]) for i, j in zip(first, ends, strict=True)])
    return TurnAverage(times=0.5 * (starts + times[ends]), periods=periods, speeds=means, fluctuations=spans / means)

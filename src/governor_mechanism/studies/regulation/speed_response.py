"""How the mean speed of a shaft answers a change of the load: extreme and last speed, overshoot, settling, hunting."""

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.types import FloatArray

SETTLING_BAND = 0.05
"""Half-width of the settling band about the last speed, relative to the whole change of speed: the usual one of speed governing."""

HUNTING_RATIO = 0.8
"""Part of the amplitude in the third quarter after the change above which that in the last one is a sustained oscillation."""

MIN_REVERSALS = 2
"""Passages of the middle speed in the second half after the change that make an oscillation; a steady drift has one."""


class Verdict(StrEnum):
    """How the speed behaves after a change of load."""

    SETTLES = "settles"
    HUNTS = "hunts"
    UNDECIDED = "has not settled by the end of the run"
    STALLS = "stalls"
    ENDED = "ended early"


@dataclass(frozen=True, kw_only=True)
class SpeedResponse:
    """Response of the mean speed of a shaft; the attributes are those of `LoadChangeStudy`, not a number where a run ends early."""

    verdict: Verdict
    mean_speeds: tuple[float, float, float]
    overshoot: float = math.nan
    settling_time: float = math.inf
    speed_error_integral: float = math.nan
    hunting_amplitude: float = math.nan
    hunting_period: float = math.nan


def reached_end(run: Trajectory) -> bool:
    """Return whether a run reached its end, with the accuracy asked for or without."""
    return run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED


def judge_speed(
    run: Trajectory,
    begin: float,  # begin of the change, s
    first: float,  # mean speed before the change, rad/s
    times: FloatArray,  # times after the begin of the change, s; shape (n,)
    speeds: FloatArray,  # mean speeds there, rad/s; shape (n,)
) -> SpeedResponse:
    """Return how the mean speed of a shaft answers a change of the load."""
    end = float(run.times[-1])
    quarters = [speeds[(times >= begin + a * (end - begin)) & (times <= begin + b * (end - begin))] for a, b in ((0.5, 0.75), (0.75, 1.0))]
    if not reached_end(run) or not all(len(quarter) > 1 for quarter in quarters):
        verdict = Verdict.STALLS if run.outcome == Outcome.SHAFT_STALLED else Verdict.ENDED
        last = float(speeds[-1]) if len(speeds) else first
        return SpeedResponse(verdict=verdict, mean_speeds=(first, last, last))
    amplitudes = [0.5 * float(np.ptp(quarter)) for quarter in quarters]
    middle = 0.5 * float(quarters[1].max() + quarters[1].min())
    largest = float(np.max(np.abs(speeds - first)))
    is_sustained = amplitudes[1] > SETTLING_BAND * largest and amplitudes[1] > HUNTING_RATIO * amplitudes[0]
    second_half = speeds[times >= begin + 0.5 * (end - begin)]
    is_oscillation = np.count_nonzero(np.diff(np.sign(second_half - middle))) >= MIN_REVERSALS
    hunts = is_sustained and is_oscillation
    last = middle if hunts else float(speeds[-1])
    deviation = speeds - last
    change = last - first
    direction = math.copysign(1.0, change) if change else 1.0
    extreme = float(speeds[np.argmax(direction * speeds)])
    outside = np.flatnonzero(np.abs(deviation) > SETTLING_BAND * abs(change))
    settled = len(outside) < len(times) and (not len(outside) or outside[-1] + 1 < len(times))
    settled = settled and float(times[outside[-1]] if len(outside) else begin) < begin + 0.9 * (end - begin) and not hunts
    return SpeedResponse(
        verdict=Verdict.HUNTS if hunts else Verdict.SETTLES if settled else Verdict.UNDECIDED,
        mean_speeds=(first, extreme, last),
        overshoot=direction * (extreme - last) / abs(change) if change else math.nan,
        settling_time=(float(times[outside[-1] + 1]) - begin if len(outside) else 0.0) if settled else math.inf,
        speed_error_integral=float(np.trapezoid(np.abs(deviation), times)),
        hunting_amplitude=amplitudes[1] / middle,
        hunting_period=_period(times, speeds - middle, begin + 0.5 * (end - begin)) if hunts else math.nan,
    )


def _period(times: FloatArray, deviation: FloatArray, begin: float) -> float:
    """Return the mean time between upward zero crossings from a time on, s; not a number for fewer than two."""
    rising = np.flatnonzero((deviation[:-1] < 0.0) & (deviation[1:] >= 0.0) & (times[:-1] >= begin))
    fractions = deviation[rising] / (deviation[rising] - deviation[rising + 1])
    crossings = times[rising] + fractions * (times[rising + 1] - times[rising])
    return float(np.mean(np.diff(crossings))) if len(crossings) > 1 else math.nan

"""Sample times of a page: equal steps, short enough that a cubic through the samples follows the motion."""

import math

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.types import FloatArray

SAMPLE_RATE = 30.0
"""Samples per second of the film in which the page plays at first."""
MAX_ROTATION = 0.4
"""Largest rotation of a body between samples, rad: a cubic through samples of a circle then deviates by 1/4000 of its radius."""
MIN_SAMPLES, MAX_SAMPLES = 60, 3000
"""Range of the number of samples; the upper bound keeps the file small."""


def choose_sample_times(run: Trajectory, time_span: Vec2, slow_down: float) -> FloatArray:
    """Return the sample times (n,) s of the shown part of a run whose seconds take `slow_down` seconds of film."""
    start, stop = time_span
    duration = stop - start
    if duration <= 0.0:
        return np.array([start])
    count = max(SAMPLE_RATE * slow_down * duration, _fastest_rotation(run) * duration / MAX_ROTATION, MIN_SAMPLES)
    return np.linspace(start, stop, min(math.ceil(count), MAX_SAMPLES) + 1)


def _fastest_rotation(run: Trajectory) -> float:
    """Return the largest angular speed of a body or a spindle, rad/s."""
    speeds = [run.velocities[..., 2], *(values for name, values in run.readings.items() if name.endswith("spindle_speed"))]
    return max(float(np.abs(speed).max(initial=0.0)) for speed in speeds)

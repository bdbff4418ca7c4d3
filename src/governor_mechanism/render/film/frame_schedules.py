"""When the frames of a film are shown, and for how long: in a GIF, in an animated drawing and in a video."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from governor_mechanism.types import FloatArray

FrameSchedule = tuple[FloatArray, list[int]]
"""Times of the frames (s) and the display time of each in hundredths of a second."""
Schedule = Callable[[float, float, float, float], FrameSchedule]
"""Returns the frames from a start to a stop (s) at a frame rate (1/s) and a slow-down."""


def schedule_frames(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> FrameSchedule:
    """Return the frames of a film whose frames may last differently long.

    The display times add up to `slow_down` times the shown duration. Each frame is shown from half a step before its time to half a step
    after it, so the first and the last frame are shown half as long as the others.
    """
    hundredths = max(round((stop - start) * slow_down * 100), 1)
    steps = round(hundredths / 100 * frames_per_second)
    if steps < 1:
        return np.array([start]), [hundredths]
    times = np.linspace(start, stop, steps + 1)
    edges = [0, *(round(hundredths * (k + 0.5) / steps) for k in range(steps)), hundredths]
    return times, [end_edge - start_edge for start_edge, end_edge in pairwise(edges)]


def schedule_equal_steps(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> FrameSchedule:
    """Return frames from the start to the stop, between which a drawing moves evenly: as in a GIF, but at equal times."""
    times, delays = schedule_frames(start, stop, frames_per_second, slow_down)
    return (times, delays) if len(times) > 1 else (np.array([start, stop]), [delays[0], 0])


def schedule_video_frames(start: float, stop: float, frames_per_second: float, slow_down: float = 1.0) -> FrameSchedule:
    """Return one frame at the middle of each step: every frame of a video lasts equally long."""
    duration = (stop - start) * slow_down
    count = max(round(duration * frames_per_second), 1)
    return start + (stop - start) * (np.arange(count) + 0.5) / count, [round(100 * duration / count)] * count

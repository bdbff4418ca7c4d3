"""Two runs side by side with equal scale, axes of readings, and time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.layout import ELEVATION_RECT, HEADER_RULE_Y, REFERENCE_SIZE
from governor_mechanism.render.film.reading_panel import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.film.shared_limits import SharedLimits
from governor_mechanism.render.machines.registry import drawing_bounds, plan_ring_radius
from governor_mechanism.render.number_format import display_unit_of
from governor_mechanism.render.style import RULE, parse_rgb

FrameDataFactory = Callable[[Trajectory], FrameData]
"""Return the frame data of a run."""


class SideBySidePainter:
    """Frames side by side with a thin rule between them; `paint(k)` returns the pixels of frame k."""

    def __init__(self, painters: Sequence[FramePainter], size: int) -> None:
        self.painters = painters
        factor = size / REFERENCE_SIZE
        self._rule_rows = slice(round((HEADER_RULE_Y + 7) * factor), round(ELEVATION_RECT[3] * factor))
        self._size = size

    def paint(self, k: int) -> NDArray[np.uint8]:
        """Return frame k as opaque RGBA pixels (size, number of runs * size, 4)."""
        pixels = np.concatenate([painter.paint(k) for painter in self.painters], axis=1)
        for index in range(1, len(self.painters)):
            pixels[self._rule_rows, index * self._size, :3] = parse_rgb(RULE)
        return pixels


def make_side_by_side(
    runs: Sequence[Trajectory], titles: Sequence[str] | None, make_frame_data: FrameDataFactory, size: int
) -> SideBySidePainter:
    """Return the painter of several runs, each under its title or that of its scene."""
    frame_data = [make_frame_data(run) for run in runs]
    names = [run.scene.title for run in runs] if titles is None else titles
    boxes = [drawing_bounds(data.part, data.run_poses, data.run_times, data.effect_state) for data in frame_data]
    left, right, bottom, top = zip(*boxes, strict=True)
    ring_radius = max(plan_ring_radius(data.part, data.run_poses, data.effect_state) for data in frame_data)
    limits = {name: _common_limits(frame_data, name) for data in frame_data for name in data.readings}
    shared_limits = [
        SharedLimits(title=name, box=(min(left), max(right), min(bottom), max(top)), ring_radius=ring_radius, axis_limits=limits)
        for name in names
    ]
    painters = [
        FramePainter(run, data, size, shared_limits=limits_of_run)
        for run, data, limits_of_run in zip(runs, frame_data, shared_limits, strict=True)
    ]
    return SideBySidePainter(painters, size)


def _common_limits(frame_data: Sequence[FrameData], name: str) -> tuple[float, float]:
    """Return the limits of an axis, in the display unit, for a reading of all runs that have it."""
    data_with_reading = [data for data in frame_data if name in data.readings]
    factor = display_unit_of(data_with_reading[0].units.get(name, ""))[1]
    values = np.concatenate([data.readings[name] for data in data_with_reading])
    return axis_limits_for(values * factor, READING_NOISE_RATIO * max(data.scales.get(name, 0.0) for data in data_with_reading) * factor)


def check_run_pair(runs: Sequence[Trajectory], titles: Sequence[str] | None) -> None:
    """Raise MechanismError unless there is one run, or two that report the same times."""
    if len(runs) not in (1, 2):
        raise MechanismError(f"a film shows one run, or two side by side; got {len(runs)}")
    if titles is not None and len(runs) == 1:
        raise MechanismError("titles are for a film of two runs; one run takes the title of its scene")
    if titles is not None and (isinstance(titles, str) or len(titles) != 2):
        raise MechanismError(f"titles must be a list of two, one for each run; got {titles!r}")
    if len(runs) == 2 and not _have_same_times(*(run.times for run in runs)):
        first, second = (_describe_times(run) for run in runs)
        raise MechanismError(
            f"two runs side by side must report the same times; the first reports {first}, the second {second}; "
            "use the same duration and output interval for both"
        )


def _have_same_times(first: NDArray[np.float64], second: NDArray[np.float64]) -> bool:
    """Return whether two arrays of times (s) are equal up to rounding."""
    return len(first) == len(second) and bool(np.allclose(first, second, rtol=1e-9, atol=1e-12))


def _describe_times(run: Trajectory) -> str:
    """Return a phrase for the reported times of a run."""
    if not len(run.times):
        return "none"
    suffix = "" if run.outcome.ok else " and ended early" if run.times[-1] < run.scene.run.duration else ""
    return f"{len(run.times)} times from {run.times[0]:g} to {run.times[-1]:g} s{suffix}"

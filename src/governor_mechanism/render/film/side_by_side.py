"""Two runs side by side with equal scale, axes of readings, and time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.layout import ELEVATION_RECT, HEADER_RULE_Y, REFERENCE_SIZE
from governor_mechanism.render.film.reading_panel import READING_NOISE_RATIO, axis_limits_for
from governor_mechanism.render.film.shared_limits import SharedLimits
from governor_mechanism.render.geometry.primitives import BoundingBox
from governor_mechanism.render.number_format import display_unit_of
from governor_mechanism.render.style import RULE, parse_rgb

FrameDataFactory = Callable[[Trajectory], Sequence[FrameData]]
"""Return the frame data of the shown parts of a run."""


class SideBySidePainter:
    """Frames side by side with a thin rule between them; `paint(k)` returns the pixels of frame k."""

    def __init__(self, painters: Sequence[FramePainter], size: int) -> None:
        self.painters = painters
        factor = size / REFERENCE_SIZE
        self._rule_rows = slice(round((HEADER_RULE_Y + 7) * factor), round(ELEVATION_RECT[3] * factor))

    def paint(self, k: int) -> NDArray[np.uint8]:
        """Return frame k as opaque RGBA pixels (size, number of runs * width of one, 4)."""
        pixels = np.concatenate([painter.paint(k) for painter in self.painters], axis=1)
        for index in range(1, len(self.painters)):
            pixels[self._rule_rows, index * pixels.shape[1] // len(self.painters), :3] = parse_rgb(RULE)
        return pixels


def make_side_by_side(
    runs: Sequence[Trajectory], titles: Sequence[str] | None, make_frame_data: FrameDataFactory, size: int
) -> SideBySidePainter:
    """Return the painter of several runs, each under its title or that of its scene."""
    frame_data = [make_frame_data(run) for run in runs]
    if len({len(data) for data in frame_data}) > 1:
        raise MechanismError("two runs side by side must have equally many parts; choose one part with part=..., or write two films")
    names = [run.scene.title for run in runs] if titles is None else titles
    own_limits = [SharedLimits.from_run(run, data) for run, data in zip(runs, frame_data, strict=True)]
    shared_limits = SharedLimits(
        title="",
        boxes=tuple(_enclosing_box(boxes) for boxes in zip(*(limits.boxes for limits in own_limits), strict=True)),
        ring_radius=max(limits.ring_radius for limits in own_limits),
        axis_limits={
            key: _common_limits([one for one in column if name in one.readings], name)
            for column in zip(*frame_data, strict=True)
            for data in column
            for name in data.readings
            for key in [(data.part.name, name)]
        },
    )
    painters = [
        FramePainter(run, data[-1], size, shared_limits=replace(shared_limits, title=name), neighbours=data[:-1])
        for run, data, name in zip(runs, frame_data, names, strict=True)
    ]
    return SideBySidePainter(painters, size)


def _enclosing_box(boxes: Sequence[BoundingBox]) -> BoundingBox:
    """Return the smallest box that contains several."""
    left, right, bottom, top = zip(*boxes, strict=True)
    return min(left), max(right), min(bottom), max(top)


def _common_limits(data_with_reading: Sequence[FrameData], name: str) -> tuple[float, float]:
    """Return the limits of an axis, in the display unit, for a reading of several runs."""
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

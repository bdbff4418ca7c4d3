"""Frames of one run, or of two side by side with equal scale, axes of readings, and time."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import FrameData
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.layout import ELEVATION_RECT, HEADER_RULE_Y, REFERENCE_SIZE
from governor_mechanism.render.film.shared_limits import shared_limits
from governor_mechanism.render.style import RULE, parse_rgb


class SideBySidePainter:
    """Frames of runs side by side, with a thin rule between them; `paint(k)` returns the pixels of frame k.

    `frame_data` are the shown parts of each run. Each run stands under its title or that of its scene.
    """

    def __init__(
        self, runs: Sequence[Trajectory], titles: Sequence[str] | None, frame_data: Sequence[Sequence[FrameData]], size: int
    ) -> None:
        if len({len(data) for data in frame_data}) > 1:
            raise MechanismError("two runs side by side must have equally many parts; choose one part with part=..., or write two films")
        limits = shared_limits(frame_data)
        self.painters = [
            FramePainter(run, data[-1], size, title=title, limits=limits, neighbours=data[:-1])
            for run, data, title in zip(runs, frame_data, titles if titles is not None else [None] * len(runs), strict=True)
        ]
        factor = size / REFERENCE_SIZE
        self._rule_rows = slice(round((HEADER_RULE_Y + 7) * factor), round(ELEVATION_RECT[3] * factor))

    def paint(self, k: int) -> RgbaPixels:
        """Return frame k as opaque RGBA pixels (size, number of runs * width of one, 4)."""
        pixels = np.concatenate([painter.paint(k) for painter in self.painters], axis=1)
        for index in range(1, len(self.painters)):
            pixels[self._rule_rows, index * pixels.shape[1] // len(self.painters), :3] = parse_rgb(RULE)
        return pixels


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

"""Two runs side by side: equal in scale, in the axes of their readings, and in time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.frame_data import Moments
from governor_mechanism.render.film.frame_painter import Picture
from governor_mechanism.render.film.layout import ELEVATION, HEADER, SIDE
from governor_mechanism.render.film.reading_panel import NOISE, limits_for
from governor_mechanism.render.film.shared_limits import Frame
from governor_mechanism.render.machines.registry import extent, plan_ring
from governor_mechanism.render.number_format import everyday
from governor_mechanism.render.style import RULE, rgb

MomentsOf = Callable[[Trajectory], Moments]


class Beside:
    """Pictures side by side, with a thin rule between them; `paint(k)` gives the pixels of frame k."""

    def __init__(self, pictures: Sequence[Picture], size: int) -> None:
        self._pictures = pictures
        factor = size / SIDE
        self._rule = slice(round((HEADER + 7) * factor), round(ELEVATION[3] * factor))
        self._size = size

    def paint(self, k: int) -> NDArray[np.uint8]:
        """Frame k as RGBA, (size, number of pictures * size, 4), opaque."""
        pixels = np.concatenate([picture.paint(k) for picture in self._pictures], axis=1)
        for number in range(1, len(self._pictures)):
            pixels[self._rule, number * self._size, :3] = rgb(RULE)
        return pixels


def pictures_beside(
    runs: Sequence[Trajectory], titles: Sequence[str] | None, moments_of: MomentsOf, size: int
) -> Beside:
    """The pictures of several runs, each under its title, or its scene's."""
    shown = [moments_of(run) for run in runs]
    names = [run.scene.title for run in runs] if titles is None else titles
    boxes = [extent(each.part, each.all_poses, each.all_times, each.acting) for each in shown]
    left, right, bottom, top = zip(*boxes, strict=True)
    ring = max(plan_ring(each.part, each.all_poses, each.acting) for each in shown)
    limits = {name: _limits(shown, name) for each in shown for name in each.readings}
    frames = [
        Frame(title=name, box=(min(left), max(right), min(bottom), max(top)), ring=ring, limits=limits)
        for name in names
    ]
    pictures = [Picture(run, each, size, frame=frame) for run, each, frame in zip(runs, shown, frames, strict=True)]
    return Beside(pictures, size)


def _limits(shown: Sequence[Moments], name: str) -> tuple[float, float]:
    """The range of an axis for a reading of all runs that have it, in its everyday unit."""
    having = [each for each in shown if name in each.readings]
    factor = everyday(having[0].units.get(name, ""))[1]
    values = np.concatenate([each.readings[name] for each in having])
    return limits_for(values * factor, NOISE * max(each.scales.get(name, 0.0) for each in having) * factor)


def check_pair(runs: Sequence[Trajectory], titles: Sequence[str] | None) -> None:
    """Raise MechanismError for what is no film of one run, or of two that report the same times."""
    if len(runs) not in (1, 2):
        raise MechanismError(f"a film shows one run, or two side by side; got {len(runs)}")
    if titles is not None and len(runs) == 1:
        raise MechanismError("titles are for a film of two runs; one run stands under its scene's title")
    if titles is not None and (isinstance(titles, str) or len(titles) != 2):
        raise MechanismError(f"titles must be two, one for each run; got {titles!r}")
    if len(runs) == 2 and not _same_times(*(run.times for run in runs)):
        first, second = (_told(run) for run in runs)
        raise MechanismError(
            f"two runs side by side must report the same times; the first reports {first}, the second {second}; "
            "run both for as long and as often"
        )


def _same_times(first: NDArray[np.float64], second: NDArray[np.float64]) -> bool:
    return len(first) == len(second) and bool(np.allclose(first, second, rtol=1e-9, atol=1e-12))


def _told(run: Trajectory) -> str:
    if not len(run.times):
        return "none"
    early = "" if run.outcome.ok else " and ended early" if run.times[-1] < run.scene.run.duration else ""
    return f"{len(run.times)} times from {run.times[0]:g} to {run.times[-1]:g} s{early}"

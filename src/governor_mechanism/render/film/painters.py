"""Painters of all films: one run, several side by side, or the engine room of a governed engine; and a frame of each as a picture."""

import os
from collections.abc import Sequence
from itertools import accumulate
from pathlib import Path
from typing import Protocol

import numpy as np
from PIL import Image

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmLayout, FilmOptions
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.artists import themed_colour
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.frame_canvas import FrameCanvas
from governor_mechanism.render.film.frame_painter import ElevationOverlay, FramePainter, heights_of_words, views_of
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.layout import HEADER_RULE_Y, REFERENCE_SIZE, machine_frame_height
from governor_mechanism.render.film.options import find_engine_room
from governor_mechanism.render.frame_data import FrameData, ShownParts, enclosing_box, find_parts, on_one_scale
from governor_mechanism.render.geometry.primitives import ELEVATION_RECT, Vec2
from governor_mechanism.render.style import RULE
from governor_mechanism.types import FloatArray

_AIR = 8.0
"""Distance (pixels) of a machine alone from the words above and below it, where the frame is as high as it needs."""


def machine_height(parts: ShownParts, compared: Sequence[ShownParts], options: FilmOptions) -> float:
    """Return the height (pixels of 480) of a frame in which the parts of a run, without plots, take the whole width; at most a square."""
    if options.layout not in (FilmLayout.MACHINE, FilmLayout.BARE) or any(any(views_of(data, options.view)) for data in parts):
        return REFERENCE_SIZE
    above = layout.PART_NAME_HEIGHT if len(parts) > 1 or options.exaggerate > 1.0 else 0.0
    heights = []
    for data, column in zip(parts, zip(*compared, strict=True), strict=True):
        overlay = ElevationOverlay(data, enclosing_box(on_one_scale(column, data), options.layout), options)
        left, right, bottom, top = overlay.box
        drawing = (top - bottom) / (right - left) * layout.MACHINE_WIDTH
        heights.append(above + drawing + 2 * _AIR + sum(heights_of_words(data, overlay)))
    return machine_frame_height(max(heights), options)


class Painter(Protocol):
    """Frames of a film: pixels that the next frame overwrites, or a copy of them."""

    @property
    def canvases(self) -> Sequence[FrameCanvas]:
        """The canvases of the runs, from left to right."""

    def draw(self, k: int) -> RgbaPixels:
        """Return frame k, in pixels that the next frame overwrites."""

    def paint(self, k: int) -> RgbaPixels:
        """Return frame k."""


class SideBySidePainter:
    """Frames of runs side by side, with a thin rule between them; `paint(k)` returns a copy of the pixels of frame k.

    `frame_data` are the shown parts of each run; runs with as many parts share the axes of their readings. Each run stands under its title
    or that of its scene.
    """

    def __init__(
        self,
        runs: Sequence[Trajectory],
        titles: Sequence[str] | None,
        frame_data: Sequence[ShownParts],
        options: FilmOptions = DEFAULT_OPTIONS,
    ) -> None:
        compared = [[other for other in frame_data if len(other) == len(data)] for data in frame_data]
        height = max(machine_height(data, others, options) for data, others in zip(frame_data, compared, strict=True))
        names = titles if titles is not None else [None] * len(runs)
        self.painters = [
            FramePainter(run, data, options.size, title=title, compared=others, options=options, height=height)
            for run, data, title, others in zip(runs, frame_data, names, compared, strict=True)
        ]
        self._rule = [round(255 * part) for part in themed_colour(RULE, options.theme)[:3]]
        factor = options.size / REFERENCE_SIZE
        self._rule_rows = slice(round((HEADER_RULE_Y + 7) * factor), round((ELEVATION_RECT[3] - REFERENCE_SIZE + height) * factor))

    @property
    def canvases(self) -> Sequence[FrameCanvas]:
        """The canvases of the runs, from left to right."""
        return self.painters

    def paint(self, k: int) -> RgbaPixels:
        """Return frame k as opaque RGBA pixels (size, sum of the widths, 4)."""
        return self.draw(k).copy()

    def draw(self, k: int) -> RgbaPixels:
        """Return frame k as `paint` does, in pixels that the next frame overwrites."""
        if len(self.painters) == 1:
            return self.painters[0].draw(k)
        frames = [painter.draw(k) for painter in self.painters]
        pixels = np.concatenate(frames, axis=1)
        for edge in accumulate(frame.shape[1] for frame in frames[:-1]):
            pixels[self._rule_rows, edge, :3] = self._rule
        return pixels


def make_painter(
    runs: Sequence[Trajectory],
    time_span: Vec2,
    times: FloatArray,
    slow_down: float,
    options: FilmOptions = DEFAULT_OPTIONS,
    titles: Sequence[str] | None = None,
) -> Painter:
    """Return the painter of runs at frame times (f,) s within a time span (s), at the slow-down that is chosen for them."""
    if governed := find_engine_room([one.scene for one in runs], options.part):
        engine, governor = (FrameData(runs[0], shown, time_span, times, slow_down) for shown in (governed.engine, governed.governor))
        from governor_mechanism.render.film.engine_room_painter import EngineRoomPainter  # slow to import, and only for engine rooms

        return EngineRoomPainter(runs[0], governed, engine, governor, options.size, options=options)
    looks = options.readings, options.exaggerate
    frame_data = [[FrameData(one, shown, time_span, times, slow_down, *looks) for shown in find_parts(one, options.part)] for one in runs]
    return SideBySidePainter(runs, titles, frame_data, options)


def write_still(
    run: Trajectory,
    path: str | os.PathLike[str],
    *,
    # time of the frame, s. None is the last reported time, at which the plots show the whole run
    time: float | None = None,
    size: int = 720,
) -> Path:
    """Write one frame of the film of a run as a picture of all its parts."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a picture's name must end in .png; got {target.name!r}")
    if not len(run.times):
        raise MechanismError(f"the run has no reported time, so there is nothing to show; its message: {run.message}")
    first, last = float(run.times[0]), float(run.times[-1])
    moment = last if time is None else time
    if not first <= moment <= last:
        raise MechanismError(f"time of a picture must lie within the run, {first:g}..{last:g} s; got {moment:g} s")
    painter = make_painter((run,), (first, last), np.array([moment]), 1.0, FilmOptions(size=size))
    with atomic_write(target) as temporary:
        Image.fromarray(painter.paint(0)[..., :3].copy()).save(temporary, format="png")
    return target

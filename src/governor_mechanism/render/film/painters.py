"""Painters of all films: one run, several side by side, or the engine room of a governed engine."""

from collections.abc import Sequence
from itertools import accumulate
from typing import Protocol

import numpy as np

from governor_mechanism.model.results.film_options import DEFAULT_OPTIONS, FilmOptions
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.film.engine_room_painter import EngineRoomPainter
from governor_mechanism.render.film.frame_canvas import FrameCanvas
from governor_mechanism.render.film.frame_painter import FramePainter
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.layout import HEADER_RULE_Y, REFERENCE_SIZE
from governor_mechanism.render.film.options import find_engine_room
from governor_mechanism.render.frame_data import FrameData, ShownParts, find_parts
from governor_mechanism.render.geometry.pixel_view import ELEVATION_RECT
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import RULE
from governor_mechanism.render.theme import themed_colour
from governor_mechanism.types import FloatArray


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
        self.painters = []
        for run, data, title in zip(runs, frame_data, titles if titles is not None else [None] * len(runs), strict=True):
            compared = [other for other in frame_data if len(other) == len(data)]
            self.painters.append(FramePainter(run, data, options.size, title=title, compared=compared, options=options))
        self._rule = [round(255 * part) for part in themed_colour(RULE, options.theme)[:3]]
        factor = options.size / REFERENCE_SIZE
        self._rule_rows = slice(round((HEADER_RULE_Y + 7) * factor), round(ELEVATION_RECT[3] * factor))

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
        return EngineRoomPainter(runs[0], governed, engine, governor, options.size, options=options)
    looks = options.readings, options.exaggerate
    frame_data = [[FrameData(one, shown, time_span, times, slow_down, *looks) for shown in find_parts(one, options.part)] for one in runs]
    return SideBySidePainter(runs, titles, frame_data, options)

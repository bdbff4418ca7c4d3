"""Paints one frame: the machine at the left in true proportions, its main readings growing at the right.

Everything that stands still is drawn once and kept; a frame restores it and draws only what moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text as Words
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import TURNING
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.film.digit_cache import Counter
from governor_mechanism.render.film.frame_data import Moments
from governor_mechanism.render.film.layout import CAPTION, CLOSING, DIAL, ELEVATION, HEADER, SIDE, View, cells, fit
from governor_mechanism.render.film.reading_panel import NOISE, ReadingPlot, Series
from governor_mechanism.render.film.shared_limits import Frame
from governor_mechanism.render.geometry.primitives import Circle, Lines, Pair, Shape, nice_step
from governor_mechanism.render.machines.registry import (
    ARC_WORDS,
    background_shapes,
    drawing_of,
    moving_shapes,
    plan_shapes,
)
from governor_mechanism.render.number_format import closing_lines, everyday, numerals, pace_words
from governor_mechanism.render.run_extents import stage_of
from governor_mechanism.render.style import GREEN, INK, PAPER, QUIET, RULE, SANS, SERIES, SERIF, VERMILLION, Brush

DPI = 64
"""A power of two, so that size / DPI * DPI is exactly the size."""
SMALLEST = 320
"""Pixels; below this nothing can be read."""
TRACE = 1.0
"""Seconds of film, of the traced body's path that is shown."""
MOST_READINGS = {True: 3, False: 4}
"""In the side panel, with and without the dial."""
CLOSING_LETTERS = 94
"""In the last lines; so many fit in their usual size, or nearly."""


class Pane:
    """Axes in metres that show shapes: some still, and some that `shapes_at(k)` gives for frame k."""

    def __init__(
        self, figure: Figure, view: View, size: int, still: Sequence[Shape], shapes_at: Callable[[int], Sequence[Shape]]
    ) -> None:
        left, top, right, bottom = (edge / size for edge in view.rect)
        axes = figure.add_axes((left, 1 - bottom, right - left, bottom - top))
        axes.set_axis_off()
        x0, x1, y0, y1 = view.box
        axes.set(xlim=(x0, x1), ylim=(y0, y1))
        pixel = size / SIDE * 72 / DPI
        Brush(axes, pixel).paint(still)
        self._shapes_at = shapes_at
        self._brush = Brush(axes, pixel, layer=3)
        self.artists = self._brush.paint(shapes_at(0))

    def move(self, k: int) -> None:
        """Put the moving shapes where they stand in frame k."""
        self._brush.move(self.artists, self._shapes_at(k))


def _clock(times: NDArray[np.float64]) -> list[str]:
    """The frames' times in s, with two decimals, or more where frames follow one another faster."""
    step = float(times[-1] - times[0]) / max(len(times) - 1, 1)
    decimals = 2 if step >= 0.005 or step <= 0.0 else min(math.ceil(-math.log10(step)), 9)
    return [f"{time:.{decimals}f}" for time in times]


def _canvas(figure: Figure) -> Any:
    """An off-screen canvas; its methods carry no types."""
    return FigureCanvasAgg(figure)


class Picture:
    """The figure of one film. `move(k)` puts every artist where it stands in frame k; `paint(k)` gives its pixels."""

    def __init__(
        self, run: Trajectory, moments: Moments, size: int = 480, *, frame: Frame | None = None, animated: bool = True
    ) -> None:
        if size < SMALLEST:
            raise MechanismError(f"size of a film must be at least {SMALLEST} pixels; got {size}")
        self.moments = moments
        self._frame = frame or Frame.around(run, moments)
        self.view = fit(self._frame.box, ELEVATION, size)
        self.figure = Figure(figsize=(size / DPI, size / DPI), dpi=DPI, facecolor=PAPER)
        self._canvas = _canvas(self.figure)
        self._size = size
        # Points in one pixel of a 480-pixel picture.
        self._pixel = size / SIDE * 72 / DPI
        self._counters: list[Counter] = []
        room = self._count(_clock(moments.times), "s", (468, 18), 12, color=INK)
        self._write_frame(run, room - 24)
        self._movers: list[Pane | ReadingPlot] = [self._elevation(), *self._reading_plots()]
        if self._has_dial:
            self._movers.append(self._plan())
        self._drawn = [artist for mover in self._movers for artist in mover.artists]
        for artist in (*self._drawn, *(counter.artist for counter in self._counters)):
            artist.set_animated(animated)
        self._canvas.draw()
        self._still = self._canvas.copy_from_bbox(self.figure.bbox)
        for counter in self._counters:
            counter.cut(self._canvas)

    def move(self, k: int) -> None:
        """Put everything that moves where it stands in frame k."""
        for mover in (*self._movers, *self._counters):
            mover.move(k)

    def paint(self, k: int) -> NDArray[np.uint8]:
        """Frame k as RGBA, (size, size, 4), opaque."""
        for mover in self._movers:
            mover.move(k)
        self._canvas.restore_region(self._still)
        renderer = self._canvas.get_renderer()
        for artist in self._drawn:
            artist.draw(renderer)
        pixels = np.array(self._canvas.buffer_rgba(), dtype=np.uint8)
        for counter in self._counters:
            counter.stamp(pixels, k)
        return pixels

    @property
    def _has_dial(self) -> bool:
        return self.moments.part.plane == TURNING and "spindle_speed" in self.moments.readings

    def _elevation(self) -> Pane:
        moments = self.moments
        part, poses, times = moments.part, moments.poses, moments.times
        stage = stage_of(part, moments.all_poses, moments.all_times, moments.acting)
        traced = drawing_of(part).traced
        path = None if traced is None else traced(part, poses)

        def shapes_at(k: int) -> Sequence[Shape]:
            shapes = moving_shapes(part, poses[k], stage.at(float(times[k])))
            return shapes if path is None else (self._trace(path, k), *shapes)

        still = background_shapes(part, moments.all_poses, stage)
        return Pane(self.figure, self.view, self._size, still, shapes_at)

    def _trace(self, path: NDArray[np.float64], k: int) -> Lines:
        """The piece of a path (f, 2) (m) of the last second of film before frame k."""
        times = self.moments.times
        first = int(np.searchsorted(times, times[k] - TRACE / self.moments.slow))
        return Lines("trace", (tuple(map(tuple, path[first : k + 1].tolist())),))

    def _plan(self) -> Pane:
        moments = self.moments
        ring = self._frame.ring
        reach = 1.06 * ring
        view = fit((-reach, reach, -reach, reach), DIAL, self._size)
        sweeps = np.diff(moments.spindle_angle, prepend=moments.spindle_angle[0])

        def shapes_at(k: int) -> Sequence[Shape]:
            angle, sweep = float(moments.spindle_angle[k]), float(sweeps[k])
            return plan_shapes(moments.part, moments.poses[k], angle, sweep, ring, moments.acting)

        lines = [(words, QUIET) for words in drawing_of(moments.part).plan_words]
        lines += [(words, GREEN) for words in ARC_WORDS]
        for line, (words, ink) in enumerate(reversed(lines)):
            self._write(words, (398, 446 - 13.5 * line), 9.5, color=ink)
        still = (Circle("ring", 0.0, 0.0, ring),)
        return Pane(self.figure, view, self._size, still, shapes_at)

    def _reading_plots(self) -> list[ReadingPlot]:
        moments = self.moments
        names = self._main_readings()
        plots: list[ReadingPlot] = []
        if not names:
            return plots
        for name, cell, colour in zip(names, cells(len(names), self._has_dial), SERIES, strict=False):
            unit, factor = everyday(moments.units.get(name, ""))
            values = moments.readings[name] * factor
            ink = GREEN if name == "spindle_speed" else colour
            noise = NOISE * moments.scales.get(name, 0.0) * factor
            limits = self._frame.limits.get(name)
            series = Series(span=moments.span, times=moments.times, values=values, noise=noise, limits=limits)
            plots.append(ReadingPlot(self.figure, cell, ink, series, self._pixel))
            left, top, right, _ = cell
            room = self._count(numerals(values), unit, (right, top + 7), 12, color=ink, fontweight="bold") - left - 8
            self._write(name.replace("_", " "), (left, top + 7), 12.5, fontfamily=SERIF, room=room)
        return plots

    def _main_readings(self) -> list[str]:
        """The readings that the drawing asks for; else the leading coordinate, another one, and the spindle's speed."""
        readings = self.moments.readings
        wanted = drawing_of(self.moments.part).readings
        most = MOST_READINGS[self._has_dial]
        if not wanted:
            own = [name for name in readings if not name.startswith("spindle")]
            wanted = (self.moments.part.mechanism.coordinate, *own)
            if self._has_dial:
                wanted = (*list(dict.fromkeys(wanted))[: most - 1], "spindle_speed", *own)
        return [name for name in dict.fromkeys(wanted) if name in readings][:most]

    def _count(self, texts: list[str], unit: str, at: Pair, height: float, **style: Any) -> float:
        """A number that changes with every frame, before a unit; `at` is where the unit ends (pixels of 480).

        Returns where the longest number begins.
        """
        gap = 0.0 if unit == "°" else 0.35 * height
        width = self._write(unit, at, height, ha="right", **style).get_window_extent(self._canvas.get_renderer()).width
        place = (at[0] - width * SIDE / self._size - gap, at[1])
        text = self._write(max(texts, key=len), place, height, ha="right", **style)
        longest = float(text.get_window_extent(self._canvas.get_renderer()).width) * SIDE / self._size
        self._counters.append(Counter(text, texts))
        return float(place[0]) - longest

    def _write_frame(self, run: Trajectory, room: float) -> None:
        """Title, rules, footer, caption and scale bar."""
        self._write(" ".join(self._frame.title.split()), (12, 18), 15, fontfamily=SERIF, room=room)
        lines, bad = closing_lines(run, CLOSING_LETTERS)
        rule, heights = CLOSING[len(lines)]
        for y in (HEADER, rule):
            self._stroke((12, y), (468, y), RULE)
        for words, y in zip(lines, heights, strict=True):
            size = 10 if len(lines) == 1 else 9.5
            self._write(words, (12, y), size, color=VERMILLION if bad else QUIET, room=456 if bad else 340)
        if not bad:
            self._write(f"engine: {run.cost.engine}", (468, 470), 10, color=QUIET, ha="right")
        self._scale_bar()

    def _scale_bar(self) -> None:
        """A length in round millimetres, to measure the picture by."""
        left, top, right, bottom = CAPTION
        scale = self.view.scale * SIDE / self._size
        length = nice_step((right - left) / scale, 8)
        y = (top + bottom) / 2
        self._stroke((left, y), (left + length * scale, y), QUIET)
        for x in (left, left + length * scale):
            self._stroke((x, y - 3), (x, y + 3), QUIET)
        self._write(f"{length * 1e3:g} mm", (left + length * scale + 6, y), 9.5, color=QUIET)
        turning, pace = self.moments.part.plane == TURNING, pace_words(self.moments.slow)
        words = f"turning plane, {pace}" if turning and pace else "seen in the turning plane" if turning else pace
        if words:
            self._write(words, (right, y), 9.5, color=QUIET, ha="right")

    def _stroke(self, start: Pair, end: Pair, colour: str) -> None:
        """A thin line between two places in pixels of a 480-pixel picture."""
        xs, ys = zip(start, end, strict=True)
        line = Line2D([x / SIDE for x in xs], [1 - y / SIDE for y in ys], color=colour, linewidth=0.8 * self._pixel)
        self.figure.add_artist(line)

    def _write(self, words: str, at: Pair, height: float, *, room: float | None = None, **style: Any) -> Words:
        """Text at a place and of a height in pixels of a 480-pixel picture, made to fit into `room` pixels."""
        settings = {"color": INK, "fontfamily": SANS, "va": "center_baseline", "parse_math": False} | style
        text = Words(at[0] / SIDE, 1 - at[1] / SIDE, words, fontsize=height * self._pixel)
        text.set(transform=self.figure.transFigure, **settings)
        self.figure.add_artist(text)
        if room is not None:
            self._squeeze(text, room * self._size / SIDE)
        return text

    def _squeeze(self, text: Words, room: float) -> None:
        """Make a text smaller, by a quarter at most, then cut its end off, until it fits into `room` pixels."""
        renderer = self._canvas.get_renderer()
        width = text.get_window_extent(renderer).width
        text.set_fontsize(float(text.get_fontsize()) * min(1.0, max(0.75, room / max(width, 1.0))))
        words = text.get_text()
        while len(words) > 1 and text.get_window_extent(renderer).width > room:
            words = words[:-1]
            text.set_text(words.rstrip() + "…")

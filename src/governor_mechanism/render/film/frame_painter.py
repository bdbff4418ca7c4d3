"""Painter of one run: the parts at the left in true proportions, the curves of their main readings at the right.

Everything static is drawn once; each frame restores it and draws only what moves.
"""

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from itertools import zip_longest
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from matplotlib.text import Text as Words

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import TURNING_PLANE
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.frame_data import FrameData, ShownParts, common_axis_limits, enclosing_box
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.layout import PixelView, fit_view, reading_rects, shift_rect
from governor_mechanism.render.film.moving_artist import MovingArtist
from governor_mechanism.render.film.moving_parts import CachedNumber, Panel, plot_reading
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines, Vec2, round_step
from governor_mechanism.render.machines.machine_drawing import SWEEP_ARC_CAPTION
from governor_mechanism.render.number_format import display_unit_of, format_closing_lines, format_film_speed, format_name, format_numbers
from governor_mechanism.render.style import GREEN, INK, MUTED, RULE, SANS_FONT, SERIES_COLOURS, SERIF_FONT, VERMILLION, Brush, artist_paths
from governor_mechanism.types import FloatArray

FRAME_DPI = 64
"""A power of two, so that size / DPI * DPI is exactly the size."""
MIN_FRAME_SIZE, MAX_FRAME_SIZE = 320, 4320
"""Smallest frame (pixels) in which text is readable, and the largest that screens show."""
TRACE_DURATION = 1.0
"""Duration (s of film) of the traced path that is shown."""
MAX_SHOWN_READINGS = {True: 3, False: 4}
"""Number of readings in the side panel, with and without the dial."""
FRAME_CLOSING_LINE_LENGTH = 94
"""Number of characters in the closing lines that fit at about their normal size."""


def _format_times(times: FloatArray) -> list[str]:
    """Format the frame times (s) with two decimals, or with more if frames follow one another faster."""
    step = float(times[-1] - times[0]) / max(len(times) - 1, 1)
    decimals = 2 if step >= 0.005 or step <= 0.0 else min(math.ceil(-math.log10(step)), 9)
    return [f"{time:.{decimals}f}" for time in times]


class FramePainter:
    """Figure of one film: `update(k)` moves every artist to frame k, `draw(k)` returns the pixels of frame k.

    Of the `parts` of the run, only the last one can have a plan view, and all positions count from its frame. `compared` are the parts of
    all runs that share the limits of this frame, by default those of this run alone.
    """

    def __init__(
        self,
        run: Trajectory,
        parts: ShownParts,
        size: int = 480,
        *,
        title: str | None = None,
        compared: Sequence[ShownParts] = (),
        animated: bool = True,
    ) -> None:
        if not MIN_FRAME_SIZE <= size <= MAX_FRAME_SIZE:
            raise MechanismError(f"size of a film must be {MIN_FRAME_SIZE} to {MAX_FRAME_SIZE} pixels; got {size}")
        self._shown_parts = parts
        self.frame_data = frame_data = parts[-1]
        # Whether the plan of the turning plane is shown.
        self._has_dial = frame_data.part.plane == TURNING_PLANE and "spindle_speed" in frame_data.readings
        # By part, its data in all runs.
        self._columns = list(zip(*(compared or [parts]), strict=True))
        # Widths in pixels of 480: what the neighbours add, and all; the whole frame is a whole number of pixels wide.
        self._shift = round((len(parts) - 1) * layout.PART_PITCH * size / layout.REFERENCE_SIZE) * layout.REFERENCE_SIZE / size
        self._width = layout.REFERENCE_SIZE + self._shift
        self.figure = Page(self._width / layout.REFERENCE_SIZE * size / FRAME_DPI, size / FRAME_DPI, dpi=FRAME_DPI)
        self._canvas = cast(Any, FigureCanvasAgg(self.figure))  # its methods have no types
        self._size = size
        # Points per pixel of a 480-pixel frame.
        self._points_per_pixel = size / layout.REFERENCE_SIZE * 72 / FRAME_DPI
        self._counters: list[CachedNumber] = []
        left_edge = self._add_number(_format_times(frame_data.times), "s", (468, 18), 12, color=INK)
        self._add_title_and_footer(run, run.scene.title if title is None else title, left_edge - 24)
        self._panels: list[Panel] = [self._make_elevation(data, k) for k, data in enumerate(self._shown_parts)]
        self._panels += self._make_reading_plots()
        if self._has_dial:
            self._panels.append(self._make_plan())
        moving_artists = [moving.artist for panel in self._panels for moving in panel.artists]
        for artist in (*moving_artists, *(counter.artist for counter in self._counters)):
            artist.set_animated(animated)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(self.figure.bbox)
        for counter in self._counters:
            counter.cache_glyphs(self._canvas)

    def update(self, k: int) -> None:
        """Move all animated artists and numbers to frame k."""
        moving: list[Panel | CachedNumber] = [*self._panels, *self._counters]
        for one in moving:
            one.update(k)

    def draw(self, k: int) -> RgbaPixels:
        """Return frame k as opaque RGBA pixels (size, width, 4) of the canvas, which the next frame overwrites."""
        self._canvas.restore_region(self._background)
        renderer = self._canvas.get_renderer()
        for panel in self._panels:
            panel.draw(renderer, k)
        pixels: RgbaPixels = np.asarray(self._canvas.buffer_rgba())
        for counter in self._counters:
            counter.blit(pixels, k)
        return pixels

    def _make_elevation(self, frame_data: FrameData, position: int) -> Panel:
        """Return the panel of a part at a position from the left, and write its scale bar and, if there are several, its name."""
        shift, name_height = position * layout.PART_PITCH - self._shift, 0.0
        if len(self._shown_parts) > 1:
            x, y = layout.PART_NAME_POSITION
            self._add_text(format_name(frame_data.part.name), (x + shift, y), 12.5, fontfamily=SERIF_FONT, max_width=260)
            name_height = layout.PART_NAME_HEIGHT
        self.view = fit_view(enclosing_box(self._columns[position]), shift_rect(layout.ELEVATION_RECT, shift + self._shift, name_height))
        self._add_scale_bar(frame_data, self.view, shift)
        drawing, poses = frame_data.drawing, frame_data.poses
        path = drawing.traced_path(poses)

        def shapes_at(k: int) -> Sequence[DrawnShape]:
            trace = () if path is None else (self._traced_path(path, k),)
            return (*trace, *drawing.moving_shapes(poses[k], float(frame_data.times[k])))

        return self._make_shape_panel(self.view, drawing.static_shapes, shapes_at)

    def _make_shape_panel(
        self, view: PixelView, static_shapes: Sequence[DrawnShape], shapes_at: Callable[[int], Sequence[DrawnShape]]
    ) -> Panel:
        """Return a panel in metres with static shapes and with the moving shapes `shapes_at(k)` of frame k."""
        axes = self._add_axes(view.rect)
        axes.set_axis_off()
        axes.set(xlim=view.box[:2], ylim=view.box[2:])
        Brush(axes, self._points_per_pixel).paint(static_shapes)
        brush = Brush(axes, self._points_per_pixel, base_zorder=3)
        artists = [MovingArtist(artist) for artist in brush.paint(shapes_at(0))]
        return Panel(artists, lambda k: artist_paths(shapes_at(k)))

    def _add_axes(self, rect: layout.PixelRect) -> Axes:
        """Add axes in a rectangle (pixels of 480)."""
        left, right = (x / self._width for x in rect[::2])
        top, bottom = (y / layout.REFERENCE_SIZE for y in rect[1::2])
        return self.figure.add_panel((left, 1 - bottom, right - left, bottom - top), grid=None)

    def _traced_path(self, path: FloatArray, k: int) -> Lines:
        """Return the part of a path (f, 2) m in the last second of film before frame k."""
        times = self.frame_data.times
        first = int(np.searchsorted(times, times[k] - TRACE_DURATION / self.frame_data.slow_down))
        return Lines("trace", (tuple(map(tuple, path[first : k + 1].tolist())),))

    def _make_plan(self) -> Panel:
        """Return the panel of the turning plane seen from above, and write its caption."""
        frame_data = self.frame_data
        ring_radius = max(data.drawing.dial_ring_radius() for data in self._columns[-1])
        half_width = 1.06 * ring_radius
        view = fit_view((-half_width, half_width, -half_width, half_width), shift_rect(layout.DIAL_RECT, self._shift))
        angle_steps = np.diff(frame_data.spindle_angle, prepend=frame_data.spindle_angle[0])

        def shapes_at(k: int) -> Sequence[DrawnShape]:
            angle, angle_step = float(frame_data.spindle_angle[k]), float(angle_steps[k])
            return frame_data.drawing.dial_shapes(frame_data.poses[k], angle, angle_step, ring_radius)

        lines = [(text, MUTED) for text in frame_data.drawing.plan_caption]
        lines += [(text, GREEN) for text in SWEEP_ARC_CAPTION]
        for line, (text, colour) in enumerate(reversed(lines)):
            self._add_text(text, (398, 446 - 13.5 * line), 9.5, color=colour)
        return self._make_shape_panel(view, (Circle("ring", 0.0, 0.0, ring_radius),), shapes_at)

    def _make_reading_plots(self) -> list[Panel]:
        """Return the plots of the shown readings, and write their names and numbers."""
        selected = self._select_readings()
        plots: list[Panel] = []
        for (frame_data, name), rect, colour in zip(selected, reading_rects(len(selected), self._has_dial), SERIES_COLOURS, strict=False):
            reading = frame_data.readings[name]
            unit, factor = display_unit_of(reading.unit)
            values = reading.values * factor
            reading_colour = GREEN if name == "spindle_speed" else colour
            left, top, right, bottom = rect
            plot_rect = (left + layout.LABEL_WIDTH, top + layout.HEADING_HEIGHT, right - 3.0, bottom - layout.TIME_LABEL_HEIGHT)
            axes = self._add_axes(shift_rect(plot_rect, self._shift))
            limits = common_axis_limits(self._columns[self._shown_parts.index(frame_data)], name)
            plots.append(plot_reading(axes, reading_colour, frame_data, values, limits, self._points_per_pixel))
            number_left = self._add_number(format_numbers(values), unit, (right, top + 7), 12, color=reading_colour, fontweight="bold")
            self._add_text(format_name(name), (left, top + 7), 12.5, fontfamily=SERIF_FONT, max_width=number_left - left - 8)
        return plots

    def _select_readings(self) -> list[tuple[FrameData, str]]:
        """Return the readings to show, each with its part: of several parts the first of each, then the second, and so on."""
        max_readings = MAX_SHOWN_READINGS[self._has_dial]
        columns = [[(data, name) for name in self._readings_of_part(data, max_readings)] for data in self._shown_parts]
        return [one for row in zip_longest(*columns) for one in row if one is not None][:max_readings]

    def _readings_of_part(self, frame_data: FrameData, max_readings: int) -> list[str]:
        """Return the readings that the drawing lists, or else the leading coordinate, another reading and the spindle speed."""
        readings = frame_data.readings
        names = frame_data.drawing.panel_readings
        if not names:
            machine_readings = [name for name in readings if not name.startswith("spindle")]
            names = (frame_data.part.mechanism.coordinate, *machine_readings)
            if self._has_dial:
                names = (*list(dict.fromkeys(names))[: max_readings - 1], "spindle_speed", *machine_readings)
        return [name for name in dict.fromkeys(names) if name in readings]

    def _add_number(self, texts: list[str], unit: str, position: Vec2, height: float, **style: Any) -> float:
        """Add a number that changes with every frame before a unit that ends at `position` (pixels of 480).

        Return the left edge of the longest number.
        """
        gap = 0.0 if unit == "°" else 0.35 * height
        width = self._add_text(unit, position, height, ha="right", **style).get_window_extent().width
        number_position = (position[0] - width * layout.REFERENCE_SIZE / self._size - gap, position[1])
        text = self._add_text(max(texts, key=len), number_position, height, ha="right", **style)
        max_width = float(text.get_window_extent().width) * layout.REFERENCE_SIZE / self._size
        self._counters.append(CachedNumber(text, texts))
        return float(number_position[0]) - max_width

    def _add_title_and_footer(self, run: Trajectory, title: str, max_title_width: float) -> None:
        """Add title, rules and footer."""
        left = 12 - self._shift
        self._add_text(" ".join(title.split()), (left, 18), 15, fontfamily=SERIF_FONT, max_width=max_title_width + self._shift)
        lines, is_failure = format_closing_lines(run, FRAME_CLOSING_LINE_LENGTH)
        rule_y, line_positions = layout.CLOSING_LINE_LAYOUT[len(lines)]
        for y in (layout.HEADER_RULE_Y, rule_y):
            self._add_line((left, y), (468, y), RULE)
        for text, y in zip(lines, line_positions, strict=True):
            size = 10 if len(lines) == 1 else 9.5
            width = (456 if is_failure else 340) + self._shift
            self._add_text(text, (left, y), size, color=VERMILLION if is_failure else MUTED, max_width=width)
        if not is_failure:
            self._add_text(f"engine: {run.cost.engine}", (468, 470), 10, color=MUTED, ha="right")

    def _add_scale_bar(self, frame_data: FrameData, view: PixelView, shift: float) -> None:
        """Add a scale bar of a round length in millimetres below the elevation of a part."""
        left, top, right, bottom = shift_rect(layout.CAPTION_RECT, shift)
        length = round_step((right - left) / view.scale, 8)
        y = (top + bottom) / 2
        self._add_line((left, y), (left + length * view.scale, y), MUTED)
        for x in (left, left + length * view.scale):
            self._add_line((x, y - 3), (x, y + 3), MUTED)
        self._add_text(f"{length * 1e3:g} mm", (left + length * view.scale + 6, y), 9.5, color=MUTED)
        text = format_film_speed(frame_data.slow_down)
        if frame_data.part.plane == TURNING_PLANE:
            text = f"turning plane, {text}" if text else "seen in the turning plane"
        if text:
            self._add_text(text, (right, y), 9.5, color=MUTED, ha="right")

    def _add_line(self, start: Vec2, end: Vec2, colour: str) -> None:
        """Add a thin line between two positions (pixels of 480)."""
        xs, ys = zip(start, end, strict=True)
        columns, rows = [(x + self._shift) / self._width for x in xs], [1 - y / layout.REFERENCE_SIZE for y in ys]
        self.figure.add_artist(Line2D(columns, rows, color=colour, linewidth=0.8 * self._points_per_pixel))

    def _add_text(self, content: str, position: Vec2, height: float, *, max_width: float | None = None, **style: Any) -> Words:
        """Add text at a position and of a height (pixels of 480), fitted into `max_width` pixels."""
        settings = {"color": INK, "fontfamily": SANS_FONT, "va": "center_baseline", "parse_math": False} | style
        x, y = (position[0] + self._shift) / self._width, 1 - position[1] / layout.REFERENCE_SIZE
        text = Words(x, y, content, fontsize=height * self._points_per_pixel)
        text.set(transform=self.figure.transFigure, **settings)
        self.figure.add_artist(text)
        if max_width is not None:
            self._shrink_to_width(text, max_width * self._size / layout.REFERENCE_SIZE)
        return text

    def _shrink_to_width(self, text: Words, max_width: float) -> None:
        """Shrink a text by at most a quarter, then cut off its end, until it fits into `max_width` pixels."""
        width = text.get_window_extent().width
        text.set_fontsize(float(text.get_fontsize()) * min(1.0, max(0.75, max_width / max(width, 1.0))))
        content = text.get_text()

        def is_too_wide(length: int) -> bool:
            text.set_text(content if length == len(content) else content[:length].rstrip() + "…")
            return bool(text.get_window_extent().width > max_width)

        if is_too_wide(len(content)):
            is_too_wide(max(1, bisect_left(range(len(content)), True, key=is_too_wide) - 1))

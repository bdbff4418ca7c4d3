"""Canvas of one film: title, footer, panels, numbers, headings; what is static is drawn once, and only what moves in each frame."""

import math
from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, Self, cast

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from matplotlib.text import Text as Words
from matplotlib.transforms import Bbox

from governor_mechanism.model.results.pictures import DEFAULT_OPTIONS, FilmLayout, FilmOptions
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.artists import Brush, Picture, artist_paths, group_shapes, recolour
from governor_mechanism.render.figures.page import Page, PanelRect, plain_labels
from governor_mechanism.render.film import layout
from governor_mechanism.render.film.gif_encoder import RgbaPixels
from governor_mechanism.render.film.moving_parts import (
    CachedNumber,
    CurvePanel,
    MovingArtist,
    Panel,
    PartPaths,
    ShapePanel,
    SortedPanel,
    plot_panel,
)
from governor_mechanism.render.frame_data import FrameData
from governor_mechanism.render.geometry.attached import DrawnPart, Flexible, shapes_of
from governor_mechanism.render.geometry.primitives import SMALL_TEXT, DrawnShape, PixelRect, PixelView, Vec2
from governor_mechanism.render.plot_panels import PlotPanel
from governor_mechanism.render.shown_readings import choose_ticks, format_closing_lines
from governor_mechanism.render.style import INK, MUTED, RULE, SANS_FONT, SERIF_FONT, VERMILLION
from governor_mechanism.types import BoolArray, FloatArray

NAME_HEIGHTS, NUMBER_HEIGHT = (12.5, 12.0, 11.5, 11.0), 11.5
"""Heights (pixels) of a name, the first with which it has a place beside its number, and that of the number."""
LINE_PITCH = 15.0
"""Height (pixels) that a second line adds to a heading: its number is clear of the descenders above it."""
SHORT_NAMES = {"valve displacement": "valve"}
"""Names that would be too long for a heading beside others."""
_FIRST_LINE = 7.0
"""Distance (pixels) of the middle of the first line from the top."""
_NUMBER_GAP = 6.0
_NAME_GAP = 4.0
_SLACK = 1.0
"""Smallest distance (pixels) of a name to the number, and to the next name; and what letters in whole pixels may take more."""


class TextCanvas(Protocol):
    """What writes words and numbers; positions, heights and widths are in pixels of a frame 480 high."""

    def add_text(self, content: str, position: Vec2, height: float, *, max_width: float | None = None, **style: Any) -> Any:
        """Add text."""

    def add_number(self, texts: list[str], unit: str, position: Vec2, height: float, **style: Any) -> float:
        """Add a number that changes with every frame before a unit that ends at the position; return its left edge."""

    def measure_text(self, content: str, height: float, **style: Any) -> float:
        """Return the width of a text."""

    def measure_number(self, texts: list[str], unit: str, height: float, **style: Any) -> float:
        """Return the largest width of a number with its unit."""


@dataclass(frozen=True, kw_only=True)
class PlotHeading:
    """The heading of a plot: the names of its curves with their colours, and the number of the first curve at each frame."""

    names: Sequence[str]
    numbers: list[str]
    unit: str
    colour: str
    name_colours: Sequence[str] = (INK,)

    @classmethod
    def of(cls, panel: PlotPanel, times: FloatArray) -> Self:
        """Return the heading of a panel at frame times (f,) s: the names have the colours of their curves if there are several."""
        main, *others = panel.curves
        name = f"{main.name} {panel.name}" if any(curve.has_own_mean for curve in others) else panel.name
        named = [curve for curve in others if not curve.has_own_mean]
        colours = [curve.colour for curve in (main, *named)] if named else [INK]
        names = (SHORT_NAMES.get(name, name), *(curve.name for curve in named))
        return cls(names=names, numbers=panel.numbers_at(times), unit=panel.unit, colour=main.colour, name_colours=colours)

    def width_in_one_line(self, canvas: TextCanvas, height: float) -> float:
        """Return the width that names of a height need beside the number."""
        number = canvas.measure_number(self.numbers, self.unit, NUMBER_HEIGHT, fontweight="bold")
        return self._names_width(canvas, height) + number + _NUMBER_GAP + _SLACK

    def write(self, canvas: TextCanvas, ends: Vec2, top: float, height: float | None) -> None:
        """Write the heading between two ends from a top on: names of a height beside the number, or without one in the line above it."""
        left, right = ends
        y = top + _FIRST_LINE
        number_y = y + (LINE_PITCH if height is None else 0.0)
        style = {"color": self.colour, "fontweight": "bold"}
        number_left = canvas.add_number(self.numbers, self.unit, (right, number_y), NUMBER_HEIGHT, **style)
        beside_number = number_left - _NUMBER_GAP
        if height is not None:
            self._write_names(canvas, self.names, (left, beside_number), y, height)
        elif len(self.names) > 1 or self._names_width(canvas, NAME_HEIGHTS[-1]) <= right - left:
            self._write_names(canvas, self.names, ends, y, self._highest_in(canvas, right - left))
        else:
            first, second = _split_name(canvas, self.names[0], right - left)
            self._write_names(canvas, (first,), ends, y, NAME_HEIGHTS[-1])
            self._write_names(canvas, (second,), (left, beside_number), number_y, NAME_HEIGHTS[-1])

    def _highest_in(self, canvas: TextCanvas, width: float) -> float:
        """Return the largest height with which the names have a place in a width of their own, or the smallest."""
        return next((one for one in NAME_HEIGHTS if self._names_width(canvas, one) <= width), NAME_HEIGHTS[-1])

    def _write_names(self, canvas: TextCanvas, names: Sequence[str], ends: Vec2, y: float, height: float) -> None:
        """Write names of a height in one line between two ends."""
        x, right = ends
        for name, colour in zip(_with_commas(names), self.name_colours, strict=False):
            canvas.add_text(name, (x, y), height, color=colour, fontfamily=SERIF_FONT, max_width=max(right - x, height))
            x += canvas.measure_text(name, height, fontfamily=SERIF_FONT) + _NAME_GAP

    def _names_width(self, canvas: TextCanvas, height: float, names: Sequence[str] | None = None) -> float:
        """Return the width of names in one line."""
        words = _with_commas(self.names if names is None else names)
        return sum(canvas.measure_text(name, height, fontfamily=SERIF_FONT) for name in words) + _NAME_GAP * (len(words) - 1)


@dataclass(frozen=True, kw_only=True)
class HeadingRow:
    """Headings of plots side by side: widths (pixels) of columns, height of names beside numbers, None if a line cannot hold both."""

    widths: Sequence[float]
    height: float | None

    @classmethod
    def fit(cls, canvas: TextCanvas, headings: Sequence[PlotHeading], width: float) -> Self:
        """Return the row in a width: all columns are equal, but for those whose headings need more."""
        for height in NAME_HEIGHTS:
            needs = [one.width_in_one_line(canvas, height) for one in headings]
            if sum(needs) <= width:
                return cls(widths=_share_width(needs, width), height=height)
        return cls(widths=[width / len(headings)] * len(headings), height=None)


def _share_width(needs: Sequence[float], width: float) -> list[float]:
    """Return the shares of a width, as equal as they can be if none is below its need."""
    wide: set[int] = set()
    while True:
        rest = (width - sum(needs[k] for k in wide)) / max(len(needs) - len(wide), 1)
        wider = {k for k, need in enumerate(needs) if need > rest}
        if wider <= wide:
            return [need if k in wide else rest for k, need in enumerate(needs)]
        wide |= wider


def _with_commas(names: Sequence[str]) -> list[str]:
    return [*(f"{name}," for name in names[:-1]), names[-1]]


def _split_name(canvas: TextCanvas, name: str, width: float) -> tuple[str, str]:
    """Return the words of a name that have a place in a line of a width, at least one, and the other words."""
    words = name.split(" ")
    fitting = [
        k for k in range(2, len(words)) if canvas.measure_text(" ".join(words[:k]), NAME_HEIGHTS[-1], fontfamily=SERIF_FONT) <= width
    ]
    count = max(fitting, default=1)
    return " ".join(words[:count]), " ".join(words[count:])


FRAME_DPI = 64
"""A power of two, so that size / DPI * DPI is exactly the size."""
FRAME_CLOSING_LINE_LENGTH = 94
"""Number of characters in the closing lines that fit at about their normal size."""


def _format_times(times: FloatArray, has_ended: BoolArray) -> list[str]:
    """Format the frame times (s) with two decimals, or with more if frames follow one another faster; the last one of a run that ended."""
    step = float(times[-1] - times[0]) / max(int((~has_ended).sum()) - 1, 1)
    decimals = 2 if step >= 0.005 or step <= 0.0 else min(math.ceil(-math.log10(step)), 9)
    return [f"{'ended at ' * bool(ended)}{time:.{decimals}f}" for time, ended in zip(times, has_ended, strict=True)]


def _unit_gap(unit: str, height: float) -> float:
    """Return the distance (pixels) of a number of a height to its unit."""
    return 0.0 if unit == "°" else 0.35 * height


class FrameCanvas:
    """Figure of one film: `update(k)` moves every artist to frame k, `draw(k)` returns the pixels of frame k.

    Positions are pixels of a frame `height` high and `width` wide, for one part, which is wider by `shift` of them at the left, where
    positions are negative; 480 of them are `size` pixels.
    """

    def __init__(
        self,
        size: int,
        shift: float,
        options: FilmOptions = DEFAULT_OPTIONS,
        width: float = layout.REFERENCE_SIZE,
        height: float = layout.REFERENCE_SIZE,
    ) -> None:
        # The whole frame is a whole number of pixels wide and high.
        self._shift, self._right, self._height = (
            round(length * size / layout.REFERENCE_SIZE) * layout.REFERENCE_SIZE / size for length in (shift, width, height)
        )
        self._width = self._right + self._shift
        self._options = options
        self._shows_words = options.layout is not FilmLayout.BARE
        width, height = (length / layout.REFERENCE_SIZE * size / FRAME_DPI for length in (self._width, self._height))
        self.figure = Page(width, height, dpi=FRAME_DPI)
        self._canvas = cast(Any, FigureCanvasAgg(self.figure))  # its methods have no types
        self._size = size
        # Points per pixel of a 480-pixel frame.
        self._points_per_pixel = size / layout.REFERENCE_SIZE * 72 / FRAME_DPI
        self.counters: list[CachedNumber] = []
        self.panels: list[Panel] = []

    def _finish(self, panels: Sequence[Panel], animated: bool) -> None:
        """Keep the panels, give all artists the colours of the theme, draw what is static, and store the characters of the numbers."""
        self.panels = list(panels)
        recolour(self.figure, self._options.theme)
        moving_artists = [moving.artist for panel in self.panels for moving in panel.artists]
        for artist in (*moving_artists, *(counter.artist for counter in self.counters)):
            artist.set_animated(animated)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(self.figure.bbox)
        for counter in self.counters:
            counter.cache_glyphs(self._canvas)

    def update(self, k: int) -> None:
        """Move all animated artists and numbers to frame k."""
        moving: list[Panel | CachedNumber] = [*self.panels, *self.counters]
        for one in moving:
            one.update(k)

    def draw(self, k: int) -> RgbaPixels:
        """Return frame k as opaque RGBA pixels (size, width, 4) of the canvas, which the next frame overwrites."""
        self._canvas.restore_region(self._background)
        renderer = self._canvas.get_renderer()
        for panel in self.panels:
            panel.draw(renderer, k)
        pixels: RgbaPixels = np.asarray(self._canvas.buffer_rgba())
        for counter in self.counters:
            counter.blit(pixels, k)
        return pixels

    def _make_shape_panel(self, view: PixelView, static_shapes: Sequence[DrawnShape], parts: Sequence[DrawnPart]) -> Panel:
        """Return a panel in metres with static shapes and with the parts of a drawing, whose moments are the numbers of the frames."""
        brush = self._paint_still(view, static_shapes)
        first = list(shapes_of(parts, 0))
        artists = [MovingArtist(artist) for artist in brush.paint(first)]
        groups = group_shapes(first)
        return ShapePanel(artists, PartPaths(parts), parts, groups)

    def _make_sorted_panel(
        self,
        view: PixelView,
        static_shapes: Sequence[DrawnShape],
        shapes_at: Callable[[int], Sequence[DrawnShape]],
        order_at: Callable[[int], Sequence[int]],
    ) -> Panel:
        """Return a panel in metres with static shapes and with moving shapes, each an artist of its own, drawn in the order of frame k."""
        brush = self._paint_still(view, static_shapes)
        groups = [[shape] for shape in shapes_at(0)]
        artists = [MovingArtist(artist) for group in groups for artist in brush.paint(group)]
        parts = [Flexible(shapes_at=shapes_at)]
        return SortedPanel(artists, lambda k: [path for shape in shapes_at(k) for path in artist_paths([shape])], parts, groups, order_at)

    def _paint_still(self, view: PixelView, static_shapes: Sequence[DrawnShape]) -> Brush:
        """Draw static shapes in a new picture, and return the brush for what moves in front of them."""
        left, right, bottom, top = view.box
        picture = Picture(self.figure, self._rect_in_figure(view.rect), Bbox([[left, bottom], [right, top]]))
        # Behind all words, and behind lines of the frame.
        Brush(picture, self._points_per_pixel, base_zorder=-2, shows_words=self._shows_words).paint(static_shapes)
        return Brush(picture, self._points_per_pixel, base_zorder=-1, shows_words=self._shows_words)

    def _rect_in_figure(self, rect: PixelRect) -> PanelRect:
        """Return the place in the figure of a rectangle (pixels of 480)."""
        left, right = (x / self._width for x in rect[::2])
        top, bottom = (y / self._height for y in rect[1::2])
        return left, 1 - bottom, right - left, bottom - top

    def add_number(self, texts: list[str], unit: str, position: Vec2, height: float, **style: Any) -> float:
        """Add a number that changes with every frame before a unit that ends at `position` (pixels of 480); return its left edge."""
        width = self._width_of(self.add_text(unit, position, height, ha="right", **style))
        number_position = (position[0] - width - _unit_gap(unit, height), position[1])
        text = self.add_text(max(texts, key=len), number_position, height, ha="right", **style)
        max_width = self._width_of(text)
        if self._shows_words:
            self.counters.append(CachedNumber(text, texts))
        return float(number_position[0]) - max_width

    def _add_title_and_footer(self, run: Trajectory, title: str, frame_data: FrameData, note: str = "") -> None:
        """Add title, time with a note before it, rules and footer; a run that has ended before the film says so."""
        times = _format_times(frame_data.times, frame_data.has_ended)
        left = 12 - self._shift
        right = self.add_number(times, "s", (self._right - 12, 18), 12, color=INK)
        if note:
            right -= 14.0
            right -= self._width_of(self.add_text(note, (right, 18), SMALL_TEXT, color=MUTED, ha="right"))
        self.add_text(" ".join(title.split()), (left, 18), 15, fontfamily=SERIF_FONT, max_width=right - 24 + self._shift)
        lines, is_failure = format_closing_lines(run, FRAME_CLOSING_LINE_LENGTH)
        rise = layout.REFERENCE_SIZE - self._height
        rule_y, line_positions = layout.CLOSING_LINE_LAYOUT[len(lines)]
        has_footer = self._options.footer or is_failure
        for y in (layout.HEADER_RULE_Y, rule_y - rise)[: 1 + has_footer]:
            self._add_line((left, y), (self._right - 12, y), RULE)
        if not has_footer:
            return
        for text, y in zip(lines, line_positions, strict=True):
            width = self._right - (24 if is_failure else 140) + self._shift
            self.add_text(text, (left, y - rise), SMALL_TEXT, color=VERMILLION if is_failure else MUTED, max_width=width)
        if not is_failure:
            self.add_text(f"engine: {run.cost.engine}", (self._right - 12, 470 - rise), SMALL_TEXT, color=MUTED, ha="right")

    def _measure_labels(self, limits: Vec2) -> float:
        """Return the width (pixels of 480) of the tick labels of an upright axis with limits, and of its ticks."""
        labels = plain_labels(choose_ticks(limits), limits)
        return max((self.measure_text(label, SMALL_TEXT) for label in labels), default=0.0) + layout.TICK_WIDTH

    def _add_line(self, start: Vec2, end: Vec2, colour: str) -> None:
        """Add a thin line between two positions (pixels of 480), to which words belong."""
        if not self._shows_words:
            return
        xs, ys = zip(start, end, strict=True)
        columns = [(x + self._shift) / self._width for x in xs]
        rows = [1 - y / self._height for y in ys]
        self.figure.add_artist(Line2D(columns, rows, color=colour, linewidth=0.8 * self._points_per_pixel))

    def _add_scale_bar(self, start: Vec2, length: float, words: str) -> float:
        """Add a scale bar of a length in pixels from a position on, with its words, and return where these end."""
        (left, y), right = start, start[0] + length
        self._add_line((left, y), (right, y), MUTED)
        for x in (left, right):
            self._add_line((x, y - 3), (x, y + 3), MUTED)
        text = self.add_text(words, (right + 6, y), SMALL_TEXT, color=MUTED)
        return right + 6.0 + self._width_of(text)

    def _make_plot(self, panel: PlotPanel, data: FrameData, place: PixelRect, *, has_time_labels: bool) -> CurvePanel:
        """Return the plot of a panel at a place in which its axes have room at the right, and below for times."""
        left, top, right, bottom = place
        rect = layout.shift_rect((left, top, right - 3.0, bottom - layout.PLOT_BOTTOM), self._shift)
        axes = self.figure.add_panel(self._rect_in_figure(rect), grid=None)
        return plot_panel(axes, panel, data, self._points_per_pixel, has_time_labels=has_time_labels)

    def add_text(self, content: str, position: Vec2, height: float, *, max_width: float | None = None, **style: Any) -> Words:
        """Add text at a position and of a height (pixels of 480), fitted into `max_width` pixels; unseen in a frame without words."""
        settings = {"color": INK, "fontfamily": SANS_FONT, "va": "center_baseline", "parse_math": False} | style
        x = (position[0] + self._shift) / self._width
        y = 1 - position[1] / self._height
        text = Words(x, y, content, fontsize=height * self._points_per_pixel)
        text.set(transform=self.figure.transFigure, visible=self._shows_words, **settings)
        self.figure.add_artist(text)
        if max_width is not None:
            self._shrink_to_width(text, max_width * self._size / layout.REFERENCE_SIZE)
        return text

    def measure_text(self, content: str, height: float, **style: Any) -> float:
        """Return the width of a text of a height, pixels of 480."""
        text = self.add_text(content, (0.0, 0.0), height, **style)
        width = self._width_of(text)
        text.remove()
        return width

    def measure_number(self, texts: list[str], unit: str, height: float, **style: Any) -> float:
        """Return the largest width of a number with its unit, pixels of 480."""
        widths = [self.measure_text(content, height, **style) for content in (max(texts, key=len), unit)]
        return sum(widths) + _unit_gap(unit, height)

    def _width_of(self, text: Words) -> float:
        """Return the width of a text, pixels of 480."""
        return float(text.get_window_extent().width) * layout.REFERENCE_SIZE / self._size

    def _shrink_to_width(self, text: Words, max_width: float) -> None:
        """Shrink a text by at most a quarter, then cut off its end, until it fits into `max_width` pixels."""
        height, width = float(text.get_fontsize()), text.get_window_extent().width
        share = min(1.0, max(0.75, max_width / max(width, 1.0)))
        text.set_fontsize(height * share)
        # Letters start at whole pixels, so that the width does not follow the height exactly.
        while text.get_window_extent().width > max_width and share > 0.75:
            share -= 0.01
            text.set_fontsize(height * share)
        content = text.get_text()

        def is_too_wide(length: int) -> bool:
            text.set_text(content if length == len(content) else content[:length].rstrip() + "…")
            return bool(text.get_window_extent().width > max_width)

        if is_too_wide(len(content)):
            is_too_wide(max(1, bisect_left(range(len(content)), True, key=is_too_wide) - 1))

"""Common parts of all figures: pages with titles and notes, framed plates in the style of old engravings, panels, files."""

import io
import math
import os
import textwrap
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FuncFormatter, NullFormatter, ScalarFormatter
from matplotlib.transforms import Bbox
from numpy.typing import ArrayLike

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.writing import atomic_write
from governor_mechanism.model.results.pictures import Theme
from governor_mechanism.render.artists import WHITE, themed
from governor_mechanism.render.figure_files import FigureFormat
from governor_mechanism.render.range_bands import RangeBand, name_cycles
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SANS_FONT, SERIF_FONT
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import INCH
from governor_mechanism.units.problems import PATH, TEXT, check_arguments

_METADATA_WITHOUT_DATE: Mapping[str, Mapping[str, None]] = {
    FigureFormat.PNG: {"Software": None},
    FigureFormat.SVG: {"Date": None, "Creator": None},
    FigureFormat.PDF: {"CreationDate": None, "Creator": None, "Producer": None},
}
"""Metadata that are left out, by the format of a file: equal figures give equal files."""

FIGURE_DPI = 100
"""Resolution of figures, dots per inch."""

_MM_PER_INCH = 1e3 * INCH
PLATE_WIDTH = 297 / _MM_PER_INCH
PLATE_HEIGHT = 210 / _MM_PER_INCH
PLATE_DPI = 140
"""Width and height of a plate, inches, which are those of a sheet A4 on its side, and its resolution, dots per inch."""

_FRAME_INSETS_MM = ((5.0, 1.8), (6.5, 0.6))
"""Distance of each line of a plate's frame from the edge, mm, which most printers reach, and its width, points."""

_MAX_TITLE_LETTERS = 80
"""Number of letters of a title that fit on the line under the heading of a plate."""

MM_PER_M = 1e3
DASHED = (0, (5, 2.5))
CHAIN_DOTTED = (0, (10, 2.5, 1.5, 2.5))
DOTTED = (0, (1, 1.8))
"""Lengths of dashes and gaps, in line widths."""

SERIES_LINE_STYLES: tuple[Any, ...] = ("-", (0, (6, 2)), (0, (8, 1.8, 1.5, 1.8)), (0, (1.5, 1.2)))
SERIES_MARKERS = ("o", "s", "^", "D")
"""Line styles and markers of curves beside their colours (`SERIES_COLOURS`): a figure is readable in grey, too."""

_TEXT_HALO = withStroke(linewidth=3.0, foreground=PAPER)

AxesPoint = tuple[Any, Any]
"""Coordinates x and y: numbers or arrays of them."""

PanelRect = tuple[float, float, float, float]
"""Left and lower edge, width and height of a panel, in fractions of the figure."""


class Panel(Axes):
    """Axes with quiet lines, serif labels, notes in a small font, and labels of points with formulas between dollars."""

    @property
    def aspect_ratio(self) -> float:
        """Width over height of the panel."""
        return self.bbox.width / self.bbox.height

    def style(
        self, *, tick_colour: str = MUTED, tick_size: float = 8.0, which: str = "major", grid: Literal["both", "x"] | None = "both"
    ) -> None:
        """Style the panel with two spines, small tick labels of a colour, and a grid."""
        self.set_facecolor(PAPER)
        for side, spine in self.spines.items():
            spine.set(visible=side in ("left", "bottom"), color=MUTED, linewidth=0.8)
        self.tick_params(which=which, color=MUTED, labelcolor=tick_colour, labelsize=tick_size, labelfontfamily=SANS_FONT)
        if grid:
            self.grid(axis=grid, color=RULE, linewidth=0.6)
            self.set_axisbelow(True)

    def label(self, x_label: str = "", y_label: str = "", *, size: float = 10.0, **style: Any) -> None:
        """Write serif labels of the axes."""
        style = {"color": INK, "fontsize": size, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", **style}
        self.set_xlabel(x_label, **style)
        self.set_ylabel(y_label, **style)

    def write_note(
        self, text: str, point: tuple[float, float], offset: tuple[float, float] = (0, 0), *, xycoords: Any = "data", **style: Any
    ) -> Annotation:
        """Write a small text at an offset (points) from a point of the panel."""
        note = self.annotate(text, point, offset, xycoords=xycoords, textcoords="offset points")
        note.set(**{"fontsize": 8.5, "fontfamily": SANS_FONT, "parse_math": False, **style})
        return note

    def annotate_point(self, point: AxesPoint, label: str, offset: AxesPoint = (0, 0), **properties: Any) -> Annotation:
        """Write a label at `offset` points from a point of the panel, with a halo, and return it."""
        annotation = self.annotate(label, point, offset, textcoords="offset points", annotation_clip=False)
        text_style = {"color": INK, "fontsize": 10.5, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", "zorder": 9, **properties}
        annotation.set(**text_style, path_effects=[_TEXT_HALO])
        return annotation

    def show_region(self, centre: AxesPoint, half_width: float) -> None:
        """Show the region of a half width around a centre, to one scale on both axes."""
        half_height = half_width / self.aspect_ratio
        self.set(xlim=(centre[0] - half_width, centre[0] + half_width), ylim=(centre[1] - half_height, centre[1] + half_height))

    def show_points(self, points: FloatArray, *, margin: float, min_half_width: float) -> None:
        """Show points (n, 2) with a margin relative to their extent, to one scale on both axes, with plain numbers at the ticks."""
        low = points.min(axis=0)
        high = points.max(axis=0)
        half_width = 0.5 * max(float(high[0] - low[0]), self.aspect_ratio * float(high[1] - low[1]))
        self.show_region(tuple((low + high) / 2), max((1.0 + margin) * half_width, min_half_width))
        format_plain_ticks(self.xaxis, self.get_xlim())
        format_plain_ticks(self.yaxis, self.get_ylim())

    def write_heading(self, heading: str, *, y: float, size: float = 11.0) -> None:
        """Write a heading above the left end of the panel, at a height in fractions of the panel."""
        self.text(0.0, y, heading, transform=self.transAxes, color=INK, fontsize=size, fontfamily=SERIF_FONT, parse_math=False)


class Page(Figure):
    """Figure of a width and height in inches, with title, subtitle, footnotes and panels."""

    def __init__(
        self, width: float, height: float, title: str = "", subtitle: str = "", *, dpi: float = FIGURE_DPI, subtitle_y: float = 0.895
    ) -> None:
        super().__init__(figsize=(width, height), dpi=dpi, facecolor=PAPER)
        if title:
            self.write_title(title)
        if subtitle:
            self.write_title(subtitle, y=subtitle_y, size=10, colour=MUTED)

    def add_panel(
        self, place: PanelRect | SubplotSpec, x_label: str = "", y_label: str = "", *, label_size: float = 10.0, **style: Any
    ) -> Panel:
        """Add a panel at a rectangle or in a cell of a grid, with its labels and style."""
        panel = Panel(self, place.get_position(self) if isinstance(place, SubplotSpec) else place)
        self.add_axes(panel)
        panel.style(**style)
        panel.label(x_label, y_label, size=label_size)
        return panel

    def write_title(self, title: str, *, x: float = 0.02, y: float = 0.945, size: float = 15.0, colour: str = INK) -> None:
        """Write a title or subtitle at a position in fractions of the page."""
        self.text(x, y, title, fontsize=size, va="center", color=colour, fontfamily=SERIF_FONT, parse_math=False)

    def write_footnote(self, text: str, *, x: float = 0.02, y: float = 0.018, size: float = 7.5, **style: Any) -> Text:
        """Write a small text at a position in fractions of the page."""
        return self.text(x, y, text, **{"color": MUTED, "fontsize": size, "fontfamily": SANS_FONT, "parse_math": False, **style})

    @check_arguments(path=PATH, theme=TEXT)
    def save(
        self,
        # the file; its name ends in .png, .svg or .pdf. SVG and PDF hold vectors; texts are outlines in SVG
        # and TrueType in PDF, as journals ask
        path: str | os.PathLike[str],
        theme: str = Theme.LIGHT,
    ) -> Path:
        """Write the page as PNG, on light ground, or as SVG or PDF, on white, to be printed; an exception leaves no file behind."""
        target = Path(path)
        file_format = target.suffix.lower().removeprefix(".")
        if file_format not in _METADATA_WITHOUT_DATE:
            endings = ", ".join(f".{name}" for name in _METADATA_WITHOUT_DATE)
            raise MechanismError(f"a figure's name must end in one of {endings}; got {target.name!r}")
        if theme not in set(Theme):
            raise MechanismError(f"a figure's theme must be one of {', '.join(Theme)}; got {theme!r}")
        # equal figures give equal files; TrueType, since journals refuse fonts of Type 3
        settings = rc_context({"svg.hashsalt": "figure", "pdf.fonttype": 42})
        with atomic_write(target) as temporary, themed(self, Theme(theme), PAPER if file_format == "png" else WHITE), settings:
            FigureCanvasAgg(self)
            metadata = _METADATA_WITHOUT_DATE[file_format]
            # matplotlib would choose the canvas by the ending of the temporary name
            self.savefig(temporary, format=file_format, dpi=self.dpi, facecolor="auto", metadata=metadata)
        return target

    def _repr_png_(self) -> bytes:
        """Return the page as a PNG, which a notebook shows."""
        stream = io.BytesIO()
        FigureCanvasAgg(self)
        self.savefig(stream, format="png", dpi=self.dpi, facecolor="auto")
        return stream.getvalue()


class Plate(Page):
    """Framed page with a heading above a scene title and the source, and captions by their positions."""

    def __init__(self, heading: str, title: str, source: str, captions: Mapping[tuple[float, float], str]) -> None:
        super().__init__(PLATE_WIDTH, PLATE_HEIGHT, dpi=PLATE_DPI)
        for inset, width in _FRAME_INSETS_MM:
            corner = inset / _MM_PER_INCH / PLATE_WIDTH, inset / _MM_PER_INCH / PLATE_HEIGHT
            self.add_artist(Rectangle(corner, 1 - 2 * corner[0], 1 - 2 * corner[1], fill=False, edgecolor=INK, linewidth=width))
        self.write_text(0.5, 0.937, heading, 22, ha="center", va="center")
        short_title = textwrap.shorten(title, _MAX_TITLE_LETTERS, placeholder=" …")
        self.write_text(0.5, 0.901, f"{short_title}; {source}", 11.5, ha="center", va="center", color=MUTED, parse_math=False)
        for (x, y), caption in captions.items():
            self.write_text(x, y, caption, 11.5, fontstyle="italic")

    def write_text(self, x: float, y: float, text: str, size: float, **properties: Any) -> Text:
        """Write serif text with formulas between dollars at a position in fractions of the plate."""
        text_style = {"color": INK, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", **properties}
        return self.text(x, y, text, fontsize=size, **text_style)

    def write_dimensions(self, text: str, x: float = 0.5, y: float = 0.043, size: float = 10.5) -> None:
        """Write dimensions centred at a position below the panels, with typographic minus signs."""
        self.write_text(x, y, text.replace(" -", " −"), size, ha="center", color=MUTED)

    def add_plate_panel(self, rect: PanelRect, x_label: str = "", y_label: str = "") -> Panel:
        """Add a panel with labelled axes, or without axes if it has no labels."""
        panel = self.add_panel(rect, x_label, y_label, label_size=10.5, tick_size=9.0, grid=None)
        panel.axison = bool(x_label)
        return panel


LABEL_DIRECTIONS = ((1, 0), (1, 1), (-1, 0), (-1, 1), (0, 1), (1, -1), (-1, -1), (0, -1))
"""Directions of a label from its point: signs of right and up, the preferred one first."""

_LETTER_WIDTH_RATIO = 0.56
"""Width of a letter, or a little less, as a fraction of the font size."""

_LABEL_DISTANCE_PIXELS = 10.0
_SETTING_DISTANCE_PIXELS = 6.0
_RING_RADIUS_PIXELS = 9.0
"""Distance of a label and of a setting from its point, and half width of a ring around a point, pixels."""

_DISTANCE_FACTORS = (1.0, 2.2, 3.6)
"""Distances of a label that must be written, relative to the first: it moves away from its point rather than over a line."""

_SAMPLE_PIXELS = 3.0
"""Distance of the points of a line that count where a label covers it, pixels."""

_MAX_COVERED_POINTS = 3.0
"""Number of points of lines above which the label of a setting is left out."""

_OVERLAP_COST = 1000.0
"""Cost of a place where a label would cover another one, in points of a line that it covers."""

_HALO = withStroke(linewidth=2.5, foreground=PAPER)
"""Ground of a label, so that no line runs through it."""


class LabelPlacer:
    """Places labels next to points of the axes, away from lines and earlier labels."""

    def __init__(self, panel: Panel, lines: Sequence[FloatArray]) -> None:
        self._panel = panel
        self._occupied_boxes: list[Bbox] = []
        self._curve_points = np.concatenate([np.empty((0, 2)), *(self._sample_curve(line) for line in lines)])

    def place_label(
        self, words: str, x: float, y: float, colour: str, size: float, directions: Sequence[tuple[int, int]], *, must: bool = True
    ) -> None:
        """Write a label next to a point (data), by signs of right and up, where it covers least; unless it `must`, not over another."""
        pixels_per_point = self._panel.figure.dpi / 72
        width = _LETTER_WIDTH_RATIO * size * pixels_per_point * len(words)
        height = 1.3 * size * pixels_per_point
        at_x, at_y = self._panel.transData.transform((x, y))
        boxes = []
        for factor in _DISTANCE_FACTORS if must else _DISTANCE_FACTORS[:1]:
            distance = factor * (_LABEL_DISTANCE_PIXELS if must else _SETTING_DISTANCE_PIXELS)
            for right, up in directions:
                low = at_x + right * distance + (right - 1) / 2 * width
                boxes.append(Bbox.from_bounds(low, at_y + up * (distance + height / 2) - height / 2, width, height))
        box = min(boxes, key=self._overlap_cost)
        if not must and self._overlap_cost(box) > _MAX_COVERED_POINTS:
            return
        self._occupied_boxes.append(box)
        left, middle = self._panel.transData.inverted().transform((box.x0, (box.y0 + box.y1) / 2))
        note = self._panel.write_note(words, (left, middle), color=colour, fontsize=size, va="center", zorder=5, annotation_clip=False)
        note.set_path_effects([_HALO])

    def reserve(self, x: float, y: float) -> None:
        """Keep a ring around a point (data) free of labels."""
        middle = self._panel.transData.transform((x, y))
        self._occupied_boxes.append(Bbox([middle - _RING_RADIUS_PIXELS, middle + _RING_RADIUS_PIXELS]))

    def _sample_curve(self, line: FloatArray) -> FloatArray:
        """Return points (m, 2), pixels, on a line through points (n, 2)."""
        ends = self._panel.transData.transform(line)
        counts = [max(round(float(np.hypot(*(b - a))) / _SAMPLE_PIXELS), 2) for a, b in pairwise(ends)]
        return np.concatenate([ends, *(np.linspace(a, b, n) for n, (a, b) in zip(counts, pairwise(ends), strict=True))])

    def _overlap_cost(self, box: Bbox) -> float:
        covered_points = np.all((self._curve_points > np.asarray(box.min) - 3) & (self._curve_points < np.asarray(box.max) + 3), axis=1)
        n_overlaps = sum(box.overlaps(other) for other in self._occupied_boxes)
        outside = not (self._panel.bbox.contains(*box.min) and self._panel.bbox.contains(*box.max))
        return float(covered_points.sum()) + _OVERLAP_COST * n_overlaps + 10.0 * _OVERLAP_COST * outside


def polar_points(angles: ArrayLike, lengths: ArrayLike, centre: AxesPoint = (0.0, 0.0)) -> AxesPoint:
    """Return points (n,), (n,) at lengths and angles (rad) from a centre."""
    return centre[0] + np.multiply(lengths, np.cos(angles)), centre[1] + np.multiply(lengths, np.sin(angles))


def add_legend(parent: Axes | Figure, text_style: dict[str, Any] | None = None, **properties: Any) -> None:
    """Add a legend without a frame to a panel or a page, with its texts in a style."""
    for text in parent.legend(**{"frameon": False, **properties}).get_texts():
        text.set(**(text_style or {}))


def format_plain_ticks(axis: Axis, limits: tuple[float, float]) -> None:
    """Write tick labels as whole numbers, without a common factor above the axis."""
    axis.set_major_formatter(_plain_formatter(limits))


def plain_labels(ticks: Sequence[float], limits: tuple[float, float]) -> list[str]:
    """Return the labels that `format_plain_ticks` writes at ticks of an axis with limits; axes cost some 10 ms."""
    formatter = _plain_formatter(limits)
    formatter.create_dummy_axis()
    formatter.axis.set_view_interval(*limits)
    return list(formatter.format_ticks(ticks))


def _plain_formatter(limits: tuple[float, float]) -> Any:
    """Return the formatter of tick labels between limits."""
    plain = ScalarFormatter(useOffset=False)
    plain.set_scientific(False)
    return plain if 1e-3 <= max(map(abs, limits)) < 1e6 else FuncFormatter(lambda value, _: format_power(value))


_RAISED_DIGITS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
"""Signs of an exponent."""


def format_power(value: float) -> str:
    """Return a number of at most four digits, with a power of ten as it is printed, not as it is typed: −5×10⁶."""
    digits, _, exponent = f"{value + 0.0:.4g}".partition("e")
    power = f"×10{str(int(exponent)).translate(_RAISED_DIGITS)}" if exponent else ""
    return digits.replace("-", "−") + power


def use_plain_decades(*axes: Any) -> None:
    """Write plain numbers, or powers of ten for long ones, at the decades of logarithmic axes, and none between them."""
    for axis in axes:
        axis.set_major_formatter(FuncFormatter(lambda value, _: _format_decade(value)))
        axis.set_minor_formatter(NullFormatter())


def _format_decade(value: float) -> str:
    """Return a number of at most five digits as it is, and another decade as a power of ten."""
    if not value > 0.0 or 0.9e-3 < value < 0.9e5:
        return f"{value:g}"
    exponent = round(math.log10(value))
    return f"$10^{{{exponent}}}$" if math.isclose(value, 10.0**exponent) else f"{value:g}"


BAND_OPACITY = 0.3
"""Opacity of a band: the grid stays visible through it, and the mean stands out from it."""


LINE_WIDTH = 1.3
"""Width of a curve over time, points."""


def draw_range_band(
    panel: Panel,
    band: RangeBand,
    colour: str,  # colour of the mean, and with BAND_OPACITY that of the band
    line_style: Any = "-",
    line_width: float = LINE_WIDTH,
) -> None:
    """Draw a band and its mean."""
    panel.fill_between(band.times, band.low, band.high, color=colour, alpha=BAND_OPACITY, linewidth=0)
    panel.plot(band.mean_times, band.means, color=colour, linestyle=line_style, linewidth=line_width)


def band_handles(bands: Sequence[RangeBand]) -> list[Artist]:
    """Return the entries of a legend of bands and means; none without a band."""
    if not bands:
        return []
    cycle = name_cycles(bands)
    return [
        Patch(facecolor=BLUE, alpha=BAND_OPACITY, linewidth=0, label=f"range within {cycle}"),
        Line2D([], [], color=BLUE, linewidth=LINE_WIDTH, label=f"mean over {cycle}"),
    ]

"""One reading in the side panel: its name, its value in numbers, and its curve growing in time."""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, MaxNLocator, ScalarFormatter

from governor_mechanism.render.film.layout import SIDE, Rect
from governor_mechanism.render.geometry.primitives import Pair
from governor_mechanism.render.style import PAPER, QUIET, RULE, SANS
from governor_mechanism.types import FloatArray

LABELS, HEADING, TIMES = 30.0, 24.0, 16.0
"""Pixels kept free at the left for the marks of the axis, above for the heading, below for the times."""


NOISE = 1e-6
"""What is less than this fraction of a reading's scale is drawn as rest."""


def limits_for(values: FloatArray, noise: float = 0.0) -> tuple[float, float]:
    """The range of an axis: the values with a margin, and so wide that changes up to `noise` do not look like a motion.

    Nor do changes far below the value itself.
    """
    low, high = float(values.min()), float(values.max())
    half = max(0.58 * (high - low), 0.02 * max(abs(low), abs(high)), 25 * noise, 1e-9)
    middle = (low + high) / 2
    return middle - half, middle + half


def plain_numbers(axis: Axis, limits: tuple[float, float]) -> None:
    """Marks with whole numbers written out: no common factor is printed apart from them, over the heading."""
    largest = max(map(abs, limits))
    plain = ScalarFormatter(useOffset=False)
    plain.set_scientific(False)
    axis.set_major_formatter(plain if 1e-3 <= largest < 1e6 else FormatStrFormatter("%.4g"))


@dataclass(frozen=True, kw_only=True)
class Series:
    """What a plot shows: values (f,) in its unit at times (f,) s within span (s); up to `noise` they count as equal.

    limits are the ends of the axis, where the values do not set them.
    """

    span: Pair
    times: FloatArray
    values: FloatArray
    noise: float
    limits: Pair | None = None


class ReadingPlot:
    """A small plot within `cell` (pixels of a 480-pixel picture); `pixel` is as many points as one of these has."""

    def __init__(self, figure: Figure, cell: Rect, colour: str, series: Series, pixel: float) -> None:
        span = series.span
        left, top, right, bottom = cell
        box = (left + LABELS, top + HEADING, right - 3.0, bottom - TIMES)
        place = (box[0] / SIDE, 1 - box[3] / SIDE, (box[2] - box[0]) / SIDE, (box[3] - box[1]) / SIDE)
        axes = figure.add_axes(place, facecolor=PAPER)
        limits = series.limits or limits_for(series.values, series.noise)
        axes.set(xlim=(span[0], max(span[1], span[0] + 1e-9)), ylim=limits)
        self._dress(axes, span, pixel)
        self._times, self._values = series.times, series.values
        self._curve = Line2D([], [], color=colour, linewidth=1.5 * pixel, solid_joinstyle="round", zorder=3)
        self._dot = Line2D([], [], color=colour, marker="o", markersize=6 * pixel, clip_on=False, zorder=4)
        self._dot.set(markeredgecolor=PAPER, markeredgewidth=0.8 * pixel)
        self.artists: list[Artist] = [self._curve, self._dot]
        for line in (self._curve, self._dot):
            axes.add_line(line)

    def move(self, k: int) -> None:
        """Show the curve up to frame k."""
        self._curve.set_data(self._times[: k + 1], self._values[: k + 1])
        self._dot.set_data(self._times[k : k + 1], self._values[k : k + 1])

    def _dress(self, axes: Axes, span: Pair, pixel: float) -> None:
        """Quiet axes: two spines, few marks, faint lines across."""
        for side, spine in axes.spines.items():
            spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8 * pixel)
        low, high = axes.get_ylim()
        marks = MaxNLocator(3, min_n_ticks=2).tick_values(low, high)
        axes.set_yticks([mark for mark in marks if low <= mark <= high])
        plain_numbers(axes.yaxis, (low, high))
        axes.set_xticks(span, labels=[f"{span[0]:.4g}", f"{span[1]:.4g} s"])
        axes.tick_params(length=3 * pixel, width=0.8 * pixel, color=QUIET, pad=2 * pixel)
        axes.tick_params(labelcolor=QUIET, labelsize=8.5 * pixel, labelfontfamily=SANS)
        axes.grid(axis="y", color=RULE, linewidth=0.7 * pixel)
        axes.set_axisbelow(True)
        # The labels of the times stand inside the plot's width, so that they never leave the picture.
        first, last = axes.get_xticklabels()
        first.set_horizontalalignment("left")
        last.set_horizontalalignment("right")

"""Work-precision diagram: error against time, one line per engine variant, both axes logarithmic."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from governor_mechanism.render.figures.page import (
    FIGURE_DPI,
    label_axes,
    new_figure,
    save_png,
    style_axes,
    use_plain_decades,
    write_footnote,
    write_note,
    write_title,
)
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, RULE, SANS_FONT, SKY, VERMILLION
from governor_mechanism.studies.regression import FittedParameter
from governor_mechanism.studies.work_precision.results import AccuracyStudy, EngineVariant, WorkPrecisionPoint, format_wall_time
from governor_mechanism.types import FloatArray

_AXES_HEIGHT_RATIO = 0.75
"""Height of the axes, as a fraction of the figure."""

_MAX_TITLE_LETTERS = 60
"""Number of letters of a scene title that fit on a line; a longer title has a smaller font."""

_LETTER_WIDTH_RATIO = 0.56
"""Width of a letter, or a little less, as a fraction of the font size."""

_LABEL_DISTANCE_PIXELS, _RING_RADIUS_PIXELS = 10.0, 9.0
"""Distance of a label from its point, and half width of a ring around a point, pixels."""

_VARIANT_STYLES = {
    "reduced": (GREEN, "o"),
    "multibody": (BLUE, "s"),
    "impulse extrapolated": ("#7a3600", "^"),
    "impulse staggered": (VERMILLION, "D"),
    "impulse plain": (MUTED, "v"),
}
"""Colour and marker of each variant."""


def work_precision_figure(study: AccuracyStudy, path: str | os.PathLike[str], requested_error: float | None = None) -> Path:
    """Write a PNG of error against time for every setting.

    An exception leaves no file behind.

    Parameters
    ----------
    study
        Result of a work-precision study.
    path
        File to write; another ending than .png raises MechanismError.
    requested_error
        Relative error to mark, with the cheapest setting of each variant that reaches it.

    Returns
    -------
    Path
        The path of the file.
    """
    figure = new_figure(8.4, 5.6)
    axes = figure.add_axes((0.095, 0.105, 0.875, _AXES_HEIGHT_RATIO))
    _prepare_axes(axes, study, requested_error)
    shown = [variant for variant in study.variants if variant.points]
    lines = []
    for variant in shown:
        colour, marker = _variant_style(variant)
        milliseconds = np.array([1e3 * point.wall_time for point in variant.points])
        errors = np.array([_plotted_error(point, study) for point in variant.points])
        axes.plot(milliseconds, errors, color=colour, marker=marker, markersize=4.5, linewidth=1.5, zorder=3)
        lines.append((milliseconds, errors))
    if requested_error is not None:
        lines.append((np.array(axes.get_xlim()), np.full(2, requested_error)))
    placer = LabelPlacer(axes, lines)
    if requested_error is not None:
        _mark_requested_error(axes, study, requested_error, placer)
    _label_variants(axes, shown, study, placer)
    size = min(14.0, 14.0 * _MAX_TITLE_LETTERS / len(study.scene.title)) if study.scene.title else 14.0
    write_title(figure, f"{study.scene.title}: error against time", size=size)
    reference = study.reference
    accuracy_text = f"against {reference.engine} at tolerance {reference.tolerance:g}, error {reference.error:.0e}"
    write_footnote(figure, f"{accuracy_text}; {reference.confirmation}", y=0.895, size=8, va="center")
    return save_png(figure, path)


def _plotted_error(point: WorkPrecisionPoint, study: AccuracyStudy) -> float:
    return max(point.max_error, study.reference.resolvable_error)


class LabelPlacer:
    """Places labels next to points of the axes, away from lines and earlier labels."""

    def __init__(self, axes: Axes, lines: Sequence[tuple[FloatArray, FloatArray]]) -> None:
        self._axes = axes
        self._axes_box = axes.get_window_extent()
        self._occupied_boxes: list[Bbox] = []
        self._curve_points = np.concatenate([self._sample_curve(*line) for line in lines]) if lines else np.empty((0, 2))

    def place_label(self, words: str, x: float, y: float, colour: str, size: float, directions: Sequence[tuple[int, int]]) -> None:
        """Write a label next to a point (data) where it covers least; `directions` are signs of right and up."""
        pixels_per_point = FIGURE_DPI / 72
        width, height = _LETTER_WIDTH_RATIO * size * pixels_per_point * len(words), 1.3 * size * pixels_per_point
        at_x, at_y = self._axes.transData.transform((x, y))
        boxes = []
        for right, up in directions:
            low = at_x + right * _LABEL_DISTANCE_PIXELS + (right - 1) / 2 * width
            boxes.append(Bbox.from_bounds(low, at_y + up * (_LABEL_DISTANCE_PIXELS + height / 2) - height / 2, width, height))
        box = min(boxes, key=self._overlap_cost)
        self._occupied_boxes.append(box)
        left, middle = self._axes.transData.inverted().transform((box.x0, (box.y0 + box.y1) / 2))
        text = self._axes.text(left, middle, words, color=colour, fontsize=size, fontfamily=SANS_FONT, va="center", zorder=5)
        text.set_parse_math(False)

    def reserve(self, x: float, y: float) -> None:
        """Keep a ring around a point (data) free of labels."""
        middle = self._axes.transData.transform((x, y))
        self._occupied_boxes.append(Bbox([middle - _RING_RADIUS_PIXELS, middle + _RING_RADIUS_PIXELS]))

    def _sample_curve(self, x: FloatArray, y: FloatArray) -> FloatArray:
        ends = self._axes.transData.transform(np.column_stack([x, y]))
        parts = [np.linspace(a, b, 60) for a, b in pairwise(ends)]
        return np.concatenate([ends, *parts])

    def _overlap_cost(self, box: Bbox) -> float:
        covered_points = np.all((self._curve_points > np.asarray(box.min) - 3) & (self._curve_points < np.asarray(box.max) + 3), axis=1)
        n_overlaps = sum(box.overlaps(other) for other in self._occupied_boxes)
        outside = not (self._axes_box.contains(*box.min) and self._axes_box.contains(*box.max))
        return float(covered_points.sum()) + 100.0 * n_overlaps + 1000.0 * outside


_NAME_DIRECTIONS = ((1, 0), (1, 1), (-1, 0), (-1, 1), (0, 1), (1, -1), (-1, -1), (0, -1))
"""Directions of a name from its point, the preferred one first."""

_TIME_DIRECTIONS = ((-1, -1), (-1, 0), (1, -1), (1, 0), (1, 1), (-1, 1), (0, -1))
"""Directions of a time from its point, the preferred one first."""


def _label_variants(axes: Axes, variants: Sequence[EngineVariant], study: AccuracyStudy, placer: LabelPlacer) -> None:
    """Write a name at the coarse end of each line."""
    for variant in variants:
        point = variant.points[0]
        order = "" if variant.order is None else f", order {_format_order(variant.order)}"
        position = 1e3 * point.wall_time, _plotted_error(point, study)
        placer.place_label(f"{variant.name}{order}", *position, _variant_style(variant)[0], 9.0, _NAME_DIRECTIONS)


def _format_order(order: FittedParameter) -> str:
    """Return an order with its standard error, if the error is at least 0.05."""
    return f"{order.value:.1f} ± {order.standard_error:.1f}" if order.standard_error >= 0.05 else f"{order.value:.1f}"


def _variant_style(variant: EngineVariant) -> tuple[str, str]:
    return _VARIANT_STYLES.get(variant.name, (SKY, "x"))


def _mark_requested_error(axes: Axes, study: AccuracyStudy, requested_error: float, placer: LabelPlacer) -> None:
    axes.axhline(requested_error, color=INK, linewidth=1.0, linestyle=(0, (5, 3)), zorder=2)
    placer.place_label(f"requested {requested_error:g}", axes.get_xlim()[1], requested_error, INK, 8.5, ((-1, 1), (-1, -1)))
    cheapest_points = [point for variant in study.variants if (point := variant.cheapest_for(requested_error)) is not None]
    positions = [(1e3 * point.wall_time, _plotted_error(point, study)) for point in cheapest_points]
    for x, y in positions:
        axes.plot([x], [y], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=INK, zorder=4)
        placer.reserve(x, y)
    for (x, y), point in zip(positions, cheapest_points, strict=True):
        placer.place_label(format_wall_time(point.wall_time), x, y, INK, 8.5, _TIME_DIRECTIONS)


def _prepare_axes(axes: Axes, study: AccuracyStudy, requested_error: float | None) -> None:
    milliseconds = [1e3 * point.wall_time for point in study.points] or [1.0, 10.0]
    errors = [*(_plotted_error(point, study) for point in study.points), *([] if requested_error is None else [requested_error])] or [1.0]
    floor = study.reference.resolvable_error
    axes.set(xscale="log", yscale="log")
    axes.set_xlim(min(milliseconds) / 2.5, max(milliseconds) * 2.0)
    low = min(floor, min(errors))
    axes.set_ylim(low / 30, max(*errors, 100 * low) * 30)
    axes.axhspan(low / 30, floor, color=RULE, alpha=0.45, linewidth=0)
    xycoords = ("axes fraction", "data")
    write_note(axes, "below the error of the reference", (1.0, floor), (-4, -11), xycoords=xycoords, color=MUTED, fontsize=8, ha="right")
    has_event_errors = any(point.event_time_error is not None for point in study.points)
    label = f"largest error of a reading{' or an event time' if has_event_errors else ''}, in units of its scale"
    label_axes(axes, "time of a run, ms", label)
    use_plain_decades(axes.xaxis)
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_formatter(NullFormatter())
    style_axes(axes, tick_colour=INK, which="both")

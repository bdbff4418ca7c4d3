"""Work-precision diagram: error against time, one line per engine variant, both axes logarithmic."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from governor_mechanism.render.figures.page import FIGURE_DPI, Page, Panel, use_plain_decades
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PURPLE, RULE, SKY, VERMILLION
from governor_mechanism.studies.work_precision.results import AccuracyStudy, EngineVariant, WorkPrecisionPoint, format_wall_time
from governor_mechanism.types import FloatArray

_PANEL_HEIGHT_RATIO = 0.75
"""Height of the panel, as a fraction of the figure."""

_MAX_TITLE_LETTERS = 60
"""Number of letters of a scene title that fit on a line; a longer title has a smaller font."""

_LETTER_WIDTH_RATIO = 0.56
"""Width of a letter, or a little less, as a fraction of the font size."""

_LABEL_DISTANCE_PIXELS, _RING_RADIUS_PIXELS = 10.0, 9.0
"""Distance of a label from its point, and half width of a ring around a point, pixels."""

_VARIANT_STYLES = {
    "reduced": (GREEN, "o"),
    "multibody": (BLUE, "s"),
    "impulse extrapolated": (PURPLE, "^"),
    "impulse staggered": (VERMILLION, "D"),
    "impulse plain": (MUTED, "v"),
}
"""Colour and marker of each variant."""


def work_precision_figure(study: AccuracyStudy, requested_error: float | None = None) -> Page:
    """Draw error against time for every setting.

    Parameters
    ----------
    study
        Result of a work-precision study.
    requested_error
        Relative error to mark, with the cheapest setting of each variant that reaches it.

    Returns
    -------
    Page
        The figure; `save` writes it.
    """
    page = Page(8.4, 5.6)
    panel = _add_panel(page, study, requested_error)
    shown = [variant for variant in study.variants if variant.points]
    lines = [np.array([_position(point, study) for point in variant.points]) for variant in shown]
    for variant, line in zip(shown, lines, strict=True):
        colour, marker = _variant_style(variant)
        panel.plot(*line.T, color=colour, marker=marker, markersize=4.5, linewidth=1.5, zorder=3)
    if requested_error is not None:
        lines.append(np.column_stack([panel.get_xlim(), np.full(2, requested_error)]))
    placer = LabelPlacer(panel, lines)
    if requested_error is not None:
        _mark_requested_error(panel, study, requested_error, placer)
    for variant in shown:
        placer.place_label(_variant_label(variant), *_position(variant.points[0], study), _variant_style(variant)[0], 9.0, _NAME_DIRECTIONS)
    size = min(14.0, 14.0 * _MAX_TITLE_LETTERS / len(study.scene.title)) if study.scene.title else 14.0
    page.write_title(f"{study.scene.title}: error against time", size=size)
    reference = study.reference
    accuracy_text = f"against {reference.engine} at tolerance {reference.tolerance:g}, error {reference.error:.0e}"
    page.write_footnote(f"{accuracy_text}; {reference.confirmation}", y=0.895, size=8, va="center")
    return page


def _position(point: WorkPrecisionPoint, study: AccuracyStudy) -> tuple[float, float]:
    """Return the time (ms) and the plotted error of a point."""
    return 1e3 * point.wall_time, max(point.max_error, study.reference.resolvable_error)


class LabelPlacer:
    """Places labels next to points of the axes, away from lines and earlier labels."""

    def __init__(self, panel: Panel, lines: Sequence[FloatArray]) -> None:
        self._panel = panel
        self._occupied_boxes: list[Bbox] = []
        self._curve_points = np.concatenate([np.empty((0, 2)), *(self._sample_curve(line) for line in lines)])

    def place_label(self, words: str, x: float, y: float, colour: str, size: float, directions: Sequence[tuple[int, int]]) -> None:
        """Write a label next to a point (data) where it covers least; `directions` are signs of right and up."""
        pixels_per_point = FIGURE_DPI / 72
        width, height = _LETTER_WIDTH_RATIO * size * pixels_per_point * len(words), 1.3 * size * pixels_per_point
        at_x, at_y = self._panel.transData.transform((x, y))
        boxes = []
        for right, up in directions:
            low = at_x + right * _LABEL_DISTANCE_PIXELS + (right - 1) / 2 * width
            boxes.append(Bbox.from_bounds(low, at_y + up * (_LABEL_DISTANCE_PIXELS + height / 2) - height / 2, width, height))
        box = min(boxes, key=self._overlap_cost)
        self._occupied_boxes.append(box)
        left, middle = self._panel.transData.inverted().transform((box.x0, (box.y0 + box.y1) / 2))
        self._panel.write_note(words, (left, middle), color=colour, fontsize=size, va="center", zorder=5, annotation_clip=False)

    def reserve(self, x: float, y: float) -> None:
        """Keep a ring around a point (data) free of labels."""
        middle = self._panel.transData.transform((x, y))
        self._occupied_boxes.append(Bbox([middle - _RING_RADIUS_PIXELS, middle + _RING_RADIUS_PIXELS]))

    def _sample_curve(self, line: FloatArray) -> FloatArray:
        """Return points (m, 2), pixels, on a line through points (n, 2)."""
        ends = self._panel.transData.transform(line)
        return np.concatenate([ends, *(np.linspace(a, b, 60) for a, b in pairwise(ends))])

    def _overlap_cost(self, box: Bbox) -> float:
        covered_points = np.all((self._curve_points > np.asarray(box.min) - 3) & (self._curve_points < np.asarray(box.max) + 3), axis=1)
        n_overlaps = sum(box.overlaps(other) for other in self._occupied_boxes)
        outside = not (self._panel.bbox.contains(*box.min) and self._panel.bbox.contains(*box.max))
        return float(covered_points.sum()) + 100.0 * n_overlaps + 1000.0 * outside


_NAME_DIRECTIONS = ((1, 0), (1, 1), (-1, 0), (-1, 1), (0, 1), (1, -1), (-1, -1), (0, -1))
"""Directions of a name from its point, the preferred one first."""

_TIME_DIRECTIONS = ((-1, -1), (-1, 0), (1, -1), (1, 0), (1, 1), (-1, 1), (0, -1))
"""Directions of a time from its point, the preferred one first."""


def _variant_label(variant: EngineVariant) -> str:
    """Return the name of a variant and its order, with the standard error of the order if it is at least 0.05."""
    if variant.order is None:
        return variant.name
    value, error = variant.order.value, variant.order.standard_error
    return f"{variant.name}, order {value:.1f}" + (f" ± {error:.1f}" if error >= 0.05 else "")


def _variant_style(variant: EngineVariant) -> tuple[str, str]:
    return _VARIANT_STYLES.get(variant.name, (SKY, "x"))


def _mark_requested_error(panel: Panel, study: AccuracyStudy, requested_error: float, placer: LabelPlacer) -> None:
    panel.axhline(requested_error, color=INK, linewidth=1.0, linestyle=(0, (5, 3)), zorder=2)
    placer.place_label(f"requested {requested_error:g}", panel.get_xlim()[1], requested_error, INK, 8.5, ((-1, 1), (-1, -1)))
    cheapest_points = [point for variant in study.variants if (point := variant.cheapest_for(requested_error)) is not None]
    for point in cheapest_points:
        x, y = _position(point, study)
        panel.plot([x], [y], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=INK, zorder=4)
        placer.reserve(x, y)
    for point in cheapest_points:
        placer.place_label(format_wall_time(point.wall_time), *_position(point, study), INK, 8.5, _TIME_DIRECTIONS)


def _add_panel(page: Page, study: AccuracyStudy, requested_error: float | None) -> Panel:
    """Add a panel with logarithmic axes that hold all points, the requested error and the error of the reference."""
    has_event_errors = any(point.event_time_error is not None for point in study.points)
    label = f"largest error of a reading{' or an event time' if has_event_errors else ''}, in units of its scale"
    panel = page.add_panel((0.095, 0.105, 0.875, _PANEL_HEIGHT_RATIO), "time of a run, ms", label, tick_colour=INK, which="both")
    positions = [_position(point, study) for point in study.points]
    milliseconds = [time for time, _ in positions] or [1.0, 10.0]
    errors = [*(error for _, error in positions), *([] if requested_error is None else [requested_error])] or [1.0]
    floor = study.reference.resolvable_error
    low = min(floor, *errors)
    xlim = min(milliseconds) / 2.5, max(milliseconds) * 2.0
    panel.set(xscale="log", yscale="log", xlim=xlim, ylim=(low / 30, max(*errors, 100 * low) * 30))
    panel.axhspan(low / 30, floor, color=RULE, alpha=0.45, linewidth=0)
    xycoords = ("axes fraction", "data")
    panel.write_note("below the error of the reference", (1.0, floor), (-4, -11), xycoords=xycoords, color=MUTED, fontsize=8, ha="right")
    use_plain_decades(panel.xaxis)
    panel.yaxis.set_major_locator(LogLocator(numticks=12))
    panel.yaxis.set_minor_formatter(NullFormatter())
    return panel

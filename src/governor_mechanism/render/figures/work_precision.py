"""Work-precision diagram, error against time with one line per engine variant; and what each effect changes and costs."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter

from governor_mechanism.render.figures.page import DASHED, LABEL_DIRECTIONS, LabelPlacer, Page, Panel, use_plain_decades
from governor_mechanism.render.shown_readings import format_name
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, PURPLE, RULE, VERMILLION
from governor_mechanism.studies.effect_ablation import EffectsStudy
from governor_mechanism.studies.work_precision_results import AccuracyStudy, EngineVariant, WorkPrecisionPoint, format_wall_time

_PANEL_HEIGHT_RATIO = 0.745
"""Height of the panel, as a fraction of the figure."""

_MAX_TITLE_LETTERS = 60
"""Number of letters of a scene title that fit on a line; a longer title has a smaller font."""

_VARIANT_STYLES: dict[str, tuple[str, str, Any]] = {
    "reduced": (GREEN, "o", "-"),
    "multibody": (BLUE, "s", (0, (6, 1.5))),
    "impulse extrapolated": (PURPLE, "^", (0, (8, 1.8, 1.5, 1.8))),
    "impulse staggered": (VERMILLION, "D", (0, (3, 1.5))),
    "impulse plain": (MUTED, "v", (0, (1.5, 1.2))),
}
"""Colour, marker and line style of each variant."""


def work_precision_figure(
    study: AccuracyStudy,
    # relative error to mark, with the cheapest setting of each variant that reaches it
    requested_error: float | None = None,
) -> Page:
    """Draw error against time for every setting; `save` writes it."""
    page = Page(8.4, 5.6)
    panel = _add_panel(page, study, requested_error)
    shown = [variant for variant in study.variants if variant.points]
    lines = [np.array([_position(point, study) for point in variant.points]) for variant in shown]
    for variant, line in zip(shown, list(lines), strict=True):
        colour, marker, style = _variant_style(variant)
        panel.plot(*line.T, color=colour, marker=marker, markersize=4.5, linewidth=1.4, linestyle=style, zorder=3)
        for point, (_, error) in zip(variant.points, line, strict=True):
            bar = np.array([(1e3 * point.wall_times[0], error), (1e3 * point.wall_times[-1], error)])
            panel.plot(*bar.T, color=colour, linewidth=1.0, zorder=2.5, solid_capstyle="butt")
            lines.append(bar)
    if requested_error is not None:
        lines.append(np.column_stack([panel.get_xlim(), np.full(2, requested_error)]))
    placer = LabelPlacer(panel, lines)
    if requested_error is not None:
        _mark_requested_error(panel, study, requested_error, placer)
    for variant in shown:
        placer.place_label(_variant_label(variant), *_position(variant.points[0], study), _variant_style(variant)[0], 9.0, LABEL_DIRECTIONS)
    marked = _winners(study, requested_error)
    for variant in shown:
        for point in (one for one in variant.points if one not in marked):
            colour = _variant_style(variant)[0]
            placer.place_label(_setting_label(point), *_position(point, study), colour, 7.0, LABEL_DIRECTIONS, must=False)
    size = min(14.0, 14.0 * _MAX_TITLE_LETTERS / len(study.scene.title)) if study.scene.title else 14.0
    page.write_title(f"{study.scene.title}: error against time", size=size)
    reference = study.reference
    accuracy_text = f"against {reference.engine} at tolerance {reference.tolerance:g}, error {reference.error:.0e}"
    page.write_footnote(f"{accuracy_text}; {reference.confirmation}", y=0.91, size=8, va="center")
    page.write_footnote(_KEY if requested_error is None else f"{_KEY}; ring: fastest within the request", y=0.018)
    return page


def _position(point: WorkPrecisionPoint, study: AccuracyStudy) -> tuple[float, float]:
    """Return the median time (ms) and the plotted error of a point."""
    return 1e3 * float(np.median(point.wall_times)), max(point.max_error, study.reference.resolvable_error)


_KEY = "at each point its tolerance or step; point: median time; bar: shortest to longest of repeats"

_TIME_DIRECTIONS = ((-1, -1), (-1, 0), (1, -1), (1, 0), (1, 1), (-1, 1), (0, -1))
"""Directions of a time from its point, the preferred one first."""


def _variant_label(variant: EngineVariant) -> str:
    """Return the name of a variant and its order, with the standard error of the order if it is at least 0.05."""
    if variant.order is None:
        return variant.name
    value, error = variant.order.value, variant.order.standard_error
    return f"{variant.name}, order {value:.1f}" + (f" ± {error:.1f}" if error >= 0.05 else "")


def _setting_label(point: WorkPrecisionPoint) -> str:
    """Return a tolerance as 1e-6, or a step."""
    name, _, value = point.setting.partition(" ")
    return f"{float(value):.0e}".replace("e-0", "e-") if name == "tolerance" else value


def _variant_style(variant: EngineVariant) -> tuple[str, str, Any]:
    return _VARIANT_STYLES.get(variant.name, (INK, "x", "-"))


def _winners(study: AccuracyStudy, requested_error: float | None) -> list[WorkPrecisionPoint]:
    """Return the fastest point of each variant within the requested error."""
    if requested_error is None:
        return []
    return [point for variant in study.variants if (point := variant.cheapest_for(requested_error)) is not None]


def _mark_requested_error(panel: Panel, study: AccuracyStudy, requested_error: float, placer: LabelPlacer) -> None:
    panel.axhline(requested_error, color=INK, linewidth=1.0, linestyle=(0, (5, 3)), zorder=2)
    placer.place_label(f"requested {requested_error:g}", panel.get_xlim()[1], requested_error, INK, 8.5, ((-1, 1), (-1, -1)))
    cheapest_points = _winners(study, requested_error)
    for point in cheapest_points:
        x, y = _position(point, study)
        panel.plot([x], [y], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=INK, zorder=4)
        placer.reserve(x, y)
    for point in cheapest_points:
        words = f"{format_wall_time(float(np.median(point.wall_times)))} at {_setting_label(point)}"
        placer.place_label(words, *_position(point, study), INK, 8.5, _TIME_DIRECTIONS)


def _add_panel(page: Page, study: AccuracyStudy, requested_error: float | None) -> Panel:
    """Add a panel with logarithmic axes that hold all points, the requested error and the error of the reference."""
    has_event_errors = any(point.event_time_error is not None for point in study.points)
    label = f"Largest error of a reading{' or an event time' if has_event_errors else ''} [its scale]"
    panel = page.add_panel((0.095, 0.125, 0.875, _PANEL_HEIGHT_RATIO), "Time of a run [ms]", label, tick_colour=INK, which="both")
    positions = [_position(point, study) for point in study.points]
    milliseconds = [1e3 * time for point in study.points for time in (point.wall_times[0], point.wall_times[-1])] or [1.0, 10.0]
    errors = [*(error for _, error in positions), *([] if requested_error is None else [requested_error])] or [1.0]
    floor = study.reference.resolvable_error
    low = min(floor, *errors)
    xlim = min(milliseconds) / 4.0, max(milliseconds) * 2.0
    panel.set(xscale="log", yscale="log", xlim=xlim, ylim=(low / 30, max(*errors, 100 * low) * 30))
    panel.axhspan(low / 30, floor, color=RULE, alpha=0.45, linewidth=0)
    xycoords = ("axes fraction", "data")
    panel.write_note("below the error of the reference", (1.0, floor), (-4, -11), xycoords=xycoords, color=MUTED, fontsize=8, ha="right")
    use_plain_decades(panel.xaxis)
    panel.yaxis.set_major_locator(LogLocator(numticks=12))
    panel.yaxis.set_minor_formatter(NullFormatter())
    return panel


_FIGURE_WIDTH = 8.4
_ROW_HEIGHT = 0.42
_HEADER_HEIGHT = 1.6
"""Figure width, row height, height of header and footer together, inches."""

_MIN_PLOTTED_CHANGE = 1e-16
"""Left end of the bars of changes; smaller changes are not visible."""

_TIME_NOISE_RATIO = 0.1
"""Change of the time below which no bar is drawn: the shortest of three equal runs differs by up to a tenth from one study to the next."""


def effect_ablation_figure(study: EffectsStudy) -> Page:
    """Draw the largest change of any reading by each effect, the requested accuracy, and the time of each effect; `save` writes it."""
    rows_height = _ROW_HEIGHT * max(len(study.rows), 1)
    height = _HEADER_HEIGHT + rows_height
    page = Page(_FIGURE_WIDTH, height)
    bottom, axes_height = 0.85 / height, rows_height / height
    add_panel = partial(page.add_panel, label_size=9, tick_colour=INK, grid="x")
    changes = add_panel((0.2, bottom, 0.42, axes_height), "Largest change of a reading [its scale]")
    _draw_changes(changes, study)
    costs = add_panel((0.68, bottom, 0.28, axes_height), "Time with it / time without it [1]")
    costs.sharey(changes)
    _draw_costs(costs, study)
    page.write_title(f"{study.scene.title}: cost of its effects", y=1 - 0.3 / height, size=14)
    return page


def _draw_changes(panel: Panel, study: EffectsStudy) -> None:
    rows = study.rows
    for position, row in enumerate(reversed(rows)):
        if row.relative_change is None:
            panel.text(study.accuracy, position, " cannot be switched off", va="center", fontsize=8, color=MUTED)
            continue
        if row.relative_change < study.accuracy:
            panel.write_note("below it", (study.accuracy, position), (-4, 0), va="center", ha="right", fontsize=8, color=MUTED)
            continue
        panel.barh(position, row.relative_change - _MIN_PLOTTED_CHANGE, left=_MIN_PLOTTED_CHANGE, height=0.6, color=BLUE)
        note = f"{row.relative_change:.1g} ({format_name(row.most_changed_reading)})"
        panel.write_note(note, (row.relative_change, position), (-4, 0), va="center", ha="right", fontsize=7.5, color=PAPER)
    panel.axvline(study.accuracy, color=VERMILLION, linewidth=1.2, linestyle=DASHED)
    point = (study.accuracy, len(rows) - 0.45)
    panel.write_note("requested accuracy", point, (3, 2), color=VERMILLION, fontsize=8, annotation_clip=False)
    panel.set(xscale="log", xlim=(min(1e-2 * study.accuracy, 1e-10), 10.0), ylim=(-0.6, len(rows) - 0.4))
    labels = (format_name(row.effect.replace("spindle.", "")) + ("" if row.listed else " (not listed)") for row in reversed(rows))
    panel.set_yticks(range(len(rows)), list(labels))


def _draw_costs(panel: Panel, study: EffectsStudy) -> None:
    for position, row in enumerate(reversed(study.rows)):
        ratio = row.time_ratio
        style: dict[str, Any] = {"va": "center", "fontsize": 8}
        if ratio is None:
            panel.write_note("a run without it ends early", (1.0, position), (4, 0), color=MUTED, **style)
        elif abs(ratio - 1.0) < _TIME_NOISE_RATIO:
            panel.write_note("below noise", (1.0, position), (4, 0), color=MUTED, **style)
        else:
            panel.barh(position, ratio - 1.0, left=1.0, height=0.6, color=MUTED)
            offset, alignment = (4, "left") if ratio >= 1 else (-4, "right")
            panel.write_note(f"{ratio:.2f}", (ratio, position), (offset, 0), ha=alignment, color=INK, **style)
    panel.axvline(1.0, color=INK, linewidth=0.8)
    shown = [1.0, *(row.time_ratio for row in study.rows if row.time_ratio is not None)]
    panel.set_xlim(min(0.9, min(shown) - 0.25), max(2.0, 1.25 * max(shown)))
    panel.write_note(
        f"noise: ±{_TIME_NOISE_RATIO:.0%}", (1.0, len(study.rows) - 0.45), (3, 2), color=MUTED, fontsize=8, annotation_clip=False
    )
    panel.axvspan(1 - _TIME_NOISE_RATIO, 1 + _TIME_NOISE_RATIO, color=RULE, alpha=0.6, linewidth=0, zorder=0)
    panel.tick_params(labelleft=False)

"""Figure of a comparison: speed curves, controlling forces and shared readings of several scenes, overlaid."""

import math
from collections.abc import Sequence
from textwrap import shorten
from typing import Any

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import (
    CHAIN_DOTTED,
    DASHED,
    DOTTED,
    MM_PER_M,
    Page,
    Panel,
    PanelRect,
    add_legend,
    draw_range_band,
)
from governor_mechanism.render.plot_panels import PanelCurve, PlotPanel
from governor_mechanism.render.range_bands import count_turns, name_cycles
from governor_mechanism.render.shown_readings import display_unit_of, format_label
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.compared_quantities import GovernorStatics, leading_reading
from governor_mechanism.studies.comparison import Comparison
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

_STYLES: tuple[tuple[str, Any], ...] = (
    (BLUE, "-"),
    (VERMILLION, DASHED),
    (GREEN, CHAIN_DOTTED),
    (SERIES_COLOURS[-1], DOTTED),
    (SKY, (0, (3, 1.2, 1, 1.2, 1, 1.2))),
    (MUTED, (0, (9, 2))),
)
"""Colour and line style of each scene: distinguishable without colours, too."""

_MAX_PLOTS = 2
"""Largest number of shared readings over time."""

_MAX_GROUPS = 3
"""Largest number of leading readings beside each other, if the scenes share none."""

_PREFERRED = ("sleeve_lift", "collar_height", "shaft_speed", "spindle_speed", "arm_angle")
"""Shared readings that are drawn before others."""

_SPEED_MARGIN = 0.6
_FORCE_LIMIT = 2.0
_RADIUS_MARGIN = 0.2
"""Margin of the speeds around those of working, relative to their range; largest controlling force and margin of the radius, relative to
equilibrium."""

_MIN_SPEED_RANGE = 0.08
"""Smallest range of the shown speeds, relative to the speed."""

_UNLIKE_RATIO = 1.5
"""Ratio of the speeds of two governors above which they are drawn relative to the speed of each spindle."""

_WIDTH = 10.5
_ROW_HEIGHT = 3.1
_MARGIN = 0.55
"""Width of the figure, height of a row of panels, and of title and lower margin each, inches."""

_READING_LINE_WIDTH = 1.5
"""Width of a reading over time, points."""

_NAME_HEIGHT = 0.21
_MAX_NAME_LETTERS = 110
_MAX_LETTERS_OF_TWO = 62
"""Height of a line of the legend, inches; largest number of letters of a scene in it, and of one beside another."""


def comparison_figure(comparison: Comparison) -> Page:
    """Draw the speed curves and controlling forces of the governors, and what the runs share over time; `save` writes it."""
    plots = _choose_plots(comparison)
    rows = (1 if comparison.governors else 0) + (1 if plots else 0)
    titled = [name if name == run.scene.title else f"{name}: {run.scene.title}" for name, run in _named(comparison)]
    names = [shorten(name, _MAX_NAME_LETTERS, placeholder=" …") for name in titled]
    n_columns = 2 if max(map(len, names)) <= _MAX_LETTERS_OF_TWO else 1
    head = _MARGIN + math.ceil(len(names) / n_columns) * _NAME_HEIGHT
    height = head + max(rows, 1) * _ROW_HEIGHT
    page = Page(_WIDTH, height, dpi=110)
    page.write_title(comparison.title, y=1 - 0.3 / height)
    row = rows - 1
    if comparison.governors:
        places = _row_rects(height, row, 2 if _has_forces(comparison) else 1)
        _draw_speed_curves(page.add_panel(places[0]), comparison)
        if len(places) > 1:
            labels = "Ball radius / that in equilibrium [1]", "Force / that in equilibrium [1]"
            _draw_forces(page.add_panel(places[1], *labels), comparison)
        row = 0
    for (name, indices), rect in zip(plots, _row_rects(height, row, len(plots)), strict=True):
        _draw_reading(page.add_panel(rect, "Time [s]"), comparison, name, indices)
    _add_names(page, names, n_columns, height)
    return page


def _named(comparison: Comparison) -> list[tuple[str, Trajectory]]:
    return list(zip(comparison.names, comparison.runs, strict=True))


def _row_rects(height: float, row: int, count: int) -> list[PanelRect]:
    """Return the rectangles of the panels of a row, counted from below, in fractions of the page."""
    bottom = (_MARGIN + row * _ROW_HEIGHT) / height
    left = 0.075
    right = 0.975
    gap = 0.085
    width = (right - left - (count - 1) * gap) / max(count, 1)
    return [(left + k * (width + gap), bottom, width, (_ROW_HEIGHT - 0.85) / height) for k in range(count)]


def _add_names(page: Page, names: Sequence[str], n_columns: int, height: float) -> None:
    """Write the legend of all scenes below the title."""
    if not page.axes:  # no run has a reported time
        return
    panel = page.axes[0]
    handles = [
        panel.plot([], [], color=colour, linestyle=style, linewidth=1.9, label=name)[0]
        for name, (colour, style) in zip(names, _STYLES, strict=False)
    ]
    position: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (0.012, 1 - 0.44 / height), "ncols": n_columns}
    add_legend(page, {"color": INK}, handles=handles, fontsize=8.5, handlelength=3.6, **position)


def _choose_plots(comparison: Comparison) -> Sequence[tuple[str, Sequence[int]]]:
    """Return the readings over time: shared ones that move, or else the leading one of each scene; with the positions of its scenes."""
    runs = comparison.runs
    moving: list[tuple[str, Sequence[int]]] = []
    for name, full_names in comparison.shared_readings.items():
        indices = [k for k, full in enumerate(full_names) if full is not None]
        if any(_moves(runs[k], full) for k, full in enumerate(full_names) if full is not None):
            moving.append((name, indices))
    moving.sort(key=lambda one: (-len(one[1]), _PREFERRED.index(one[0]) if one[0] in _PREFERRED else len(_PREFERRED)))
    if moving:
        return moving[:_MAX_PLOTS]
    groups: dict[str, list[int]] = {}
    for k in range(len(runs)):
        if len(runs[k].times) and leading_reading(runs[k]) in runs[k].readings:
            groups.setdefault(leading_reading(runs[k]), []).append(k)
    return [*groups.items()][:_MAX_GROUPS]


def _moves(run: Trajectory, name: str) -> bool:
    """Return whether a reading changes by more than the noise of a drawing."""
    return bool(np.ptp(run.readings[name]) > 1e-6 * max(run.scales.get(name, 0.0), float(np.abs(run.readings[name]).max())))


def _draw_reading(panel: Panel, comparison: Comparison, name: str, indices: Sequence[int]) -> None:
    """Draw a reading of some scenes over time, or its range and mean; a dot marks where a shorter run ends."""
    last = max(float(comparison.runs[k].times[-1]) for k in indices)
    names = {k: comparison.shared_readings.get(name, {k: name})[k] or name for k in indices}
    unit, factor = display_unit_of(comparison.runs[indices[-1]].units[names[indices[-1]]])
    curves = [
        PanelCurve(name=names[k], times=run.times, values=run.readings[names[k]] * factor, series=k, turns=count_turns(run))
        for k, run in ((k, comparison.runs[k]) for k in indices)
    ]
    limits = min(float(np.min(curve.values)) for curve in curves), max(float(np.max(curve.values)) for curve in curves)
    plot = PlotPanel(name=name, unit=unit, curves=curves, limits=limits, may_have_bands=True)
    of_curves = plot.find_bands(panel.bbox.width, panel.bbox.height, _READING_LINE_WIDTH * float(panel.figure.dpi) / 72)
    for curve, band in zip(curves, of_curves, strict=True):
        colour, style = _STYLES[curve.series]
        if band is None:
            panel.plot(curve.times, curve.values, color=colour, linestyle=style, linewidth=_READING_LINE_WIDTH)
        else:
            draw_range_band(panel, band, colour, style, _READING_LINE_WIDTH)
    shorter = [curve for curve in curves if curve.times[-1] < last * (1 - 1e-9)]
    for curve in shorter:
        colour, _ = _STYLES[curve.series]
        panel.plot(curve.times[-1:], curve.values[-1:], "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=5)
    bands = [band for band in of_curves if band is not None]
    panel.set_ylabel(format_label(name, unit))
    panel.set_xlim(0.0, last)
    panel.ticklabel_format(axis="y", useOffset=False)
    notes = ["dot: end of a shorter run" for _ in shorter[:1]] + [
        f"band, line: range and mean within {name_cycles(bands)}" for _ in bands[:1]
    ]
    if notes:
        panel.write_note("; ".join(notes), (1.0, 1.02), xycoords="axes fraction", ha="right", color=MUTED, fontsize=7.5)


def _draw_speed_curves(panel: Panel, comparison: Comparison) -> None:
    """Draw equilibrium speed over the sleeve; unstable parts thin; dots are the equilibria at the speed of each spindle."""
    governors = comparison.governors
    speeds = [one.spindle_speed for _, one in governors]
    is_relative = min(speeds) > 0 and max(speeds) > _UNLIKE_RATIO * min(speeds)
    has_sleeve = all("sleeve_lift" in one.curve.readings for _, one in governors)
    windows, xs = [], []
    for k, statics in governors:
        factor = 1 / statics.spindle_speed if is_relative else 1 / RPM
        x = _places(statics, has_sleeve)
        curve, (colour, style) = statics.curve, _STYLES[k]
        window = _speed_window(statics)
        windows += [value * factor for value in window]
        shown = curve.has_equilibrium & (curve.speed > window[0]) & (curve.speed < window[1])
        xs += [float(value) for value in (x[shown].min(), x[shown].max())] if shown.any() else []
        for part, width in ((curve.stable, 1.9), (~curve.stable, 0.9)):
            values = np.where(curve.has_equilibrium & _with_neighbours(part), curve.speed * factor, np.nan)
            panel.plot(x, values, color=colour, linestyle=style, linewidth=width)
        ends = None if statics.controlling_force is None else statics.controlling_force.working_range
        if ends is not None:
            places = np.interp(np.sort(ends.coordinate), curve.coordinate, x)
            speeds_there = ends.speed[np.argsort(ends.coordinate)] * factor
            panel.plot(places, speeds_there, "|", color=colour, markersize=11, markeredgewidth=1.6, zorder=4)
        if statics.equilibrium is not None:
            place = float(np.interp(statics.equilibrium.coordinate, curve.coordinate, x))
            fill = colour if statics.equilibrium.stable and not statics.is_beyond_stops else PAPER
            panel.plot([place], [statics.spindle_speed * factor], "o", color=colour, markerfacecolor=fill, markersize=7, zorder=5)
    y_label = "Speed / that of the spindle [1]" if is_relative else "Equilibrium speed [rpm]"
    panel.label("Sleeve lift [mm]" if has_sleeve else "Share of the travel [%]", y_label)
    panel.set_ylim(min(windows), max(windows))
    if xs:
        margin = 0.04 * (max(xs) - min(xs)) or 1.0
        panel.set_xlim(min(xs) - margin, max(xs) + margin)
    panel.ticklabel_format(axis="y", useOffset=False)
    is_unstable = any((~one.curve.stable & one.curve.has_equilibrium).any() for _, one in governors)
    note = "dot: at the speed of the spindle, hollow if not held; ticks: working range" + ("; thin: not stable" if is_unstable else "")
    panel.write_note(note, (0.0, 1.02), xycoords="axes fraction", color=MUTED, fontsize=7.5)


def _places(statics: GovernorStatics, has_sleeve: bool) -> FloatArray:
    """Return the sleeve lift (mm), or the share of the travel (%), along the speed curve."""
    curve = statics.curve
    if has_sleeve:
        return curve.readings["sleeve_lift"] * MM_PER_M
    first, last = float(curve.coordinate[0]), float(curve.coordinate[-1])
    share: FloatArray = 100 * (curve.coordinate - first) / (last - first)
    return share


def _with_neighbours(part: Any) -> Any:
    """Return a mask with the next point, so that parts of a curve join."""
    return part | np.concatenate([[False], part[:-1]])


def _speed_window(statics: GovernorStatics) -> tuple[float, float]:
    """Return the speeds (rad/s) to show: those of the working range, of the spindle in the run, and a margin."""
    speeds = [statics.spindle_speed, *(speed for _, speed in statics.curve.folds)]
    ends = None if statics.controlling_force is None else statics.controlling_force.working_range
    if ends is not None:
        speeds += ends.speed.tolist()
    low, high = min(speeds), max(speeds)
    margin = max(_SPEED_MARGIN * (high - low), 0.5 * _MIN_SPEED_RANGE * high)
    return max(low - margin, 0.0), high + margin


def _has_forces(comparison: Comparison) -> bool:
    return any(one.controlling_force is not None and one.at_equilibrium is not None for _, one in comparison.governors)


def _draw_forces(panel: Panel, comparison: Comparison) -> None:
    """Draw the controlling forces relative to equilibrium, beside the line of one speed: what is steeper there is stable."""
    radii: list[float] = []
    for k, statics in comparison.governors:
        force, point = statics.controlling_force, statics.at_equilibrium
        if force is None or point is None:
            continue
        colour, style = _STYLES[k]
        x, y = force.radius / point.radius[0], force.force / point.force[0]
        panel.plot(x, y, color=colour, linestyle=style, linewidth=1.9)
        ends = force.working_range
        if ends is not None:
            panel.plot(ends.radius / point.radius[0], ends.force / point.force[0], "|", color=colour, markersize=11, markeredgewidth=1.6)
            radii += (ends.radius / point.radius[0]).tolist()
    low = min([1.0, *radii]) - _RADIUS_MARGIN
    high = max([1.0, *radii]) + _RADIUS_MARGIN
    line = np.array([max(low, 0.0), high])
    panel.plot(line, line, color=INK, linewidth=0.8)
    panel.plot([1.0], [1.0], "o", color=INK, markersize=5, zorder=5)
    panel.set(xlim=(line[0], high), ylim=(max(0.0, 1 - _FORCE_LIMIT * (1 - line[0])), 1 + _FORCE_LIMIT * (high - 1)))
    panel.write_note(
        "controlling force; thin: speed line; steeper there is stable; ticks: working range",
        (0.0, 1.02),
        xycoords="axes fraction",
        color=MUTED,
        fontsize=7.5,
    )

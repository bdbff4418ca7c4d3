"""Figure of a sweep: curves over one key, heat maps over two, rows of heat maps over three."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import Page, Panel, add_legend, axis_limits_for, format_plain_ticks
from governor_mechanism.render.figures.sweep_axis import SweepAxisScale, label_with_unit
from governor_mechanism.render.figures.sweep_heatmaps import draw_heatmaps
from governor_mechanism.render.figures.sweep_key import (
    KEY_LINE_HEIGHT,
    SCENE_LINE,
    draw_key,
    draw_missing_cells,
    ending_handles,
    number_endings,
    scene_handle,
    wrap_handles,
)
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import INK, SANS_FONT, SERIES_COLOURS
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import BoolArray

_FIGURE_WIDTH, _PANEL_HEIGHT = 8.4, 2.9
"""Width of a figure of curves and height of each panel, inches."""

_HEADER_HEIGHT, _FOOTER_HEIGHT = 0.75, 0.75
"""Heights above and below the panels, inches."""

_MAX_NAME_LETTERS = 20
"""Number of letters per line of a curve name in the legend."""

_MAX_MARKED_VALUES = 60
"""Largest number of values of a key whose points are marked."""

_MAX_SWEEP_AXES = 3


def sweep_figure(sweep: Sweep) -> Page:
    """Draw every quantity of a sweep over the varied keys, in everyday units.

    Rows without a number are hatched by the way in which they ended. The values of the scene itself are marked.

    Result: the figure; `save` writes it. Raises MechanismError if the sweep has more than three keys.
    """
    if len(sweep.axes) > _MAX_SWEEP_AXES:
        raise MechanismError(
            f"a figure shows at most {_MAX_SWEEP_AXES} keys, and this sweep varies {len(sweep.axes)}; sweep over fewer keys"
        )
    return _draw_curves(sweep) if len(sweep.axes) == 1 else draw_heatmaps(sweep)


def _draw_curves(sweep: Sweep) -> Page:
    """Draw a panel for the quantities of each unit, with a curve for each quantity."""
    axis_scale = SweepAxisScale(sweep.axes[0])
    groups: dict[str, list[RunQuantity]] = {}
    for quantity in sweep.quantities:
        groups.setdefault(quantity.display_unit[1] or quantity.name, []).append(quantity)
    handles = ending_handles(sweep)
    if axis_scale.scene_position is not None:
        handles.insert(0, scene_handle([axis_scale], **SCENE_LINE))
    footer = _FOOTER_HEIGHT + KEY_LINE_HEIGHT * (wrap_handles(handles, _FIGURE_WIDTH) + 0.5 * bool(handles))
    height = _HEADER_HEIGHT + footer + _PANEL_HEIGHT * len(groups)
    page = Page(_FIGURE_WIDTH, height)
    has_legends = any(len(group) > 1 for group in groups.values())
    margins = {"left": 0.1, "right": 0.76 if has_legends else 0.96, "top": 1 - (_HEADER_HEIGHT + 0.2) / height, "bottom": footer / height}
    grid = page.add_gridspec(len(groups), 1, hspace=0.42, **margins)
    for k, group in enumerate(groups.values()):
        _draw_panel(page.add_panel(grid[k, 0], axis_scale.label if k == len(groups) - 1 else ""), sweep, axis_scale, group)
    page.write_title(sweep.title, y=1 - 0.32 / height)
    draw_key(page, handles, 0.1 * _FIGURE_WIDTH)
    return page


_LINE_STYLES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1, 1)))
"""Line styles of the curves of a panel by turns: of two that coincide both are seen."""


def _draw_panel(panel: Panel, sweep: Sweep, axis_scale: SweepAxisScale, group: Sequence[RunQuantity]) -> None:
    factor, unit = group[0].display_unit
    columns = [sweep.column(quantity.name)[axis_scale.order] * factor for quantity in group]
    handles = []
    for k, (quantity, values) in enumerate(zip(group, columns, strict=True)):
        (line,) = panel.plot(axis_scale.positions, values, color=SERIES_COLOURS[k % len(SERIES_COLOURS)], linewidth=1.5, markersize=3.5)
        style = _LINE_STYLES[k % len(_LINE_STYLES)]
        line.set(linestyle=style if axis_scale.axis.is_numeric else "", marker="o" if len(values) <= _MAX_MARKED_VALUES else "")
        line.set_label(textwrap.fill(format_name(quantity.name), _MAX_NAME_LETTERS))
        handles.append(line)
    finite_values = np.concatenate([values[np.isfinite(values)] for values in columns])
    if finite_values.size:
        panel.set_ylim(axis_limits_for(finite_values))
        format_plain_ticks(panel.yaxis, panel.get_ylim())
    else:
        panel.set_yticks([])
    axis_scale.apply_to(panel, "x")
    _draw_missing_rows(panel, sweep, axis_scale, np.any(np.isnan(columns), axis=0))
    if axis_scale.scene_position is not None:
        panel.axvline(axis_scale.scene_position, zorder=1.5, **SCENE_LINE)
    if len(handles) > 1:
        text_style = {"color": INK, "fontfamily": SANS_FONT, "parse_math": False}
        add_legend(panel, text_style, handles=handles, loc="upper left", bbox_to_anchor=(1.015, 1.02), fontsize=8.5)
    panel.write_heading(label_with_unit(group[0].name, unit) if len(group) == 1 else unit or "value", y=1.05)


def _draw_missing_rows(panel: Panel, sweep: Sweep, axis_scale: SweepAxisScale, is_missing: BoolArray) -> None:
    """Fill the cells of rows that lack a number over the whole height of the panel."""
    places, low_and_high = number_endings(sweep)[axis_scale.order], np.array(panel.get_ylim())
    draw_missing_cells(panel, sweep, places[None, :], is_missing[None, :], (axis_scale.cell_edges(), low_and_high))
    panel.set_ylim(*low_and_high)

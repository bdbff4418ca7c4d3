"""Figure of a sweep: curves over one key, heat maps over two, rows of heat maps over three."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.artists import OVER_COLOUR_MAP
from governor_mechanism.render.figures.page import Page, Panel, PanelRect, add_legend, format_plain_ticks
from governor_mechanism.render.figures.sweep_axis import (
    KEY_LINE_HEIGHT,
    ROUND_STEPS,
    SCENE_LINE,
    SCENE_MARKER,
    SweepAxisScale,
    draw_key,
    draw_missing_cells,
    ending_handles,
    label_with_unit,
    number_endings,
    scene_handle,
    wrap_handles,
)
from governor_mechanism.render.shown_readings import axis_limits_for, format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, SKY
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import BoolArray, FloatArray

_MAP_WIDTH = 3.1
_MAP_HEIGHT = 2.5
_MAP_SPACING_X = 0.25
_MAP_SPACING_Y = 0.8
"""Size of a map and spacing between maps, inches."""

_SINGLE_MAP_RATIO = 1.7
_TEXT_MARGIN = 0.45
_LEFT_MARGIN = 0.85
_RIGHT_MARGIN = 0.95
_TOP_MARGIN = 1.05
_BOTTOM_MARGIN = 0.75
_COLOUR_BAR_WIDTH = 0.16
"""Further left margin beside words, margins around the maps, and width of a colour bar, inches."""

_MAX_THIRD_KEY_MAPS = 6
"""Largest number of shown values of a third key, from the first to the last."""

_SWEEP_COLOUR_MAP = LinearSegmentedColormap.from_list("sweep", ["#f3eedb", SKY, BLUE, "#004a75"])

_UNIFORM_TOLERANCE = 1e-4
"""Range of values, relative to the largest one, below which a map has one colour."""

_MIN_SHARED_RATIO = 1 / 3
"""Part of a common colour scale that each of its maps must use."""

_N_LEVELS = 7
"""Largest number of contours of a map."""

_MIN_CONTOUR_VALUES = 4
"""Smallest number of values of a key from which contours are drawn."""

_MAX_ROUGHNESS = 0.6
"""Mean second difference of neighbouring values relative to their mean first difference above which contours would be a tangle; 1.7 for
noise."""


def draw_heatmaps(sweep: Sweep) -> Page:
    """Draw a row of maps for each quantity: one map, or one for each shown value of the third key."""
    return _HeatmapPage(sweep).draw()


@dataclass(frozen=True)
class _Layout:
    """Sizes of a page of maps, inches, and the number of maps across and down."""

    columns: int
    rows: int
    map_width: float
    map_height: float
    spacing_x: float
    left_margin: float
    footer: float

    @property
    def size(self) -> tuple[float, float]:
        width = self.left_margin + self.columns * self.map_width + (self.columns - 1) * self.spacing_x + _RIGHT_MARGIN
        return width, _TOP_MARGIN + self.rows * self.map_height + (self.rows - 1) * _MAP_SPACING_Y + self.footer

    def rect(self, row: int, column: int) -> PanelRect:
        """Return the rectangle of a map in fractions of the page."""
        width, height = self.size
        left = self.left_margin + column * (self.map_width + self.spacing_x)
        top = _TOP_MARGIN + row * (self.map_height + _MAP_SPACING_Y)
        return left / width, 1 - (top + self.map_height) / height, self.map_width / width, self.map_height / height


class _HeatmapPage:
    """Page of the maps of a sweep over two or three keys."""

    def __init__(self, sweep: Sweep) -> None:
        self._sweep = sweep
        self._scales = [SweepAxisScale(axis) for axis in sweep.axes]
        self._is_flat = len(sweep.axes) == 2
        self._third_indices = self._shown_third_indices()
        self._places = number_endings(sweep).reshape(*sweep.shape[:2], -1)
        self._norms = _colour_norms(sweep)

    def draw(self) -> Page:
        """Return the page."""
        sweep, n_quantities = self._sweep, len(self._sweep.quantities)
        handles = [*self._scene_handles(), *ending_handles(sweep)]
        layout = self._lay_out(0.0)
        footer = _BOTTOM_MARGIN + KEY_LINE_HEIGHT * (wrap_handles(handles, layout.size[0]) + 0.5 * bool(handles))
        layout = self._lay_out(footer)
        width, height = layout.size
        page = Page(width, height)
        for k, quantity in enumerate(sweep.quantities):
            if self._is_flat:
                row, column = divmod(k, layout.columns)
                panel = self._draw_map(page, layout.rect(row, column), quantity, 0, x_label=True, y_label=True)
                has_own_bar = column == layout.columns - 1 or k == n_quantities - 1 or self._norms[k] is not self._norms[k + 1]
                heading = label_with_unit(quantity.name, quantity.display_unit[1])
                panel.write_heading(heading, y=1.04, size=10.5)
            else:
                panel = self._draw_row(page, layout, k)
                has_own_bar = True
            if has_own_bar:
                self._draw_colour_bar(page, panel, k)
        page.write_title(sweep.title, x=0.25 / width, y=1 - 0.34 / height)
        draw_key(page, handles)
        if not self._is_flat and len(self._third_indices) < sweep.shape[2]:
            text = f"{len(self._third_indices)} of the {sweep.shape[2]} values of {label_with_unit(sweep.axes[2].key, '')} are shown"
            page.write_footnote(text, x=1 - 0.2 / width, y=0.1 / height, size=8, ha="right")
        return page

    def _lay_out(self, footer: float) -> _Layout:
        n_quantities = len(self._sweep.quantities)
        word_margin = 0.0 if self._scales[1].axis.is_numeric else _TEXT_MARGIN
        left_margin = _LEFT_MARGIN + word_margin
        if not self._is_flat:
            return _Layout(len(self._third_indices), n_quantities, _MAP_WIDTH, _MAP_HEIGHT, _MAP_SPACING_X, left_margin, footer)
        map_scale = _SINGLE_MAP_RATIO if n_quantities == 1 else 1.2
        columns = min(n_quantities, 2 if n_quantities != 3 else 3)
        spacing_x = _MAP_SPACING_X + _RIGHT_MARGIN + 0.4 + word_margin
        return _Layout(
            columns, -(-n_quantities // columns), map_scale * _MAP_WIDTH, map_scale * _MAP_HEIGHT, spacing_x, left_margin, footer
        )

    def _shown_third_indices(self) -> list[int]:
        """Return the indices of the shown values of the third key."""
        if self._is_flat:
            return [0]
        count = self._sweep.shape[2]
        return sorted({round(k) for k in np.linspace(0, count - 1, min(count, _MAX_THIRD_KEY_MAPS))})

    def _scene_handles(self) -> list[Artist]:
        """Return the entry of the key for the scene itself, if it is on a map."""
        is_shown = all(scale.scene_position is not None for scale in self._scales)
        if not is_shown or not (self._is_flat or any(map(self._is_scene_at, self._third_indices))):
            return []
        return [scene_handle(self._scales, linestyle="", **SCENE_MARKER)]

    def _is_scene_at(self, third_index: int) -> bool:
        return self._is_flat or self._sweep.axes[2].values[third_index] == self._sweep.axes[2].scene_value

    def _draw_row(self, page: Page, layout: _Layout, k: int) -> Panel:
        """Draw the maps of a quantity for the shown values of the third key, and return the last one."""
        third = self._scales[2]
        for column, third_index in enumerate(self._third_indices):
            rect = layout.rect(k, column)
            is_last_row = k == len(self._sweep.quantities) - 1
            panel = self._draw_map(page, rect, self._sweep.quantities[k], third_index, x_label=is_last_row, y_label=not column)
            value = third.format_value(third.axis.values[third_index])
            panel.write_heading(f"{label_with_unit(third.axis.key, '')} {value}", y=1.04, size=10.5)
        return panel

    def _draw_map(self, page: Page, rect: PanelRect, quantity: RunQuantity, third_index: int, *, x_label: bool, y_label: bool) -> Panel:
        across, up = self._scales[:2]
        panel = page.add_panel(rect, across.label if x_label else "", up.label if y_label else "", label_size=9.5, grid=None)
        panel.spines[["top", "right"]].set_visible(True)
        panel.tick_params(labelleft=y_label)
        order, factor = np.ix_(across.order, up.order), quantity.display_unit[0]
        values = (self._sweep.grid(quantity.name).reshape(self._places.shape)[..., third_index] * factor)[order].T
        edges = (across.cell_edges(), up.cell_edges())
        norm = self._norms[self._sweep.quantities.index(quantity)]
        panel.pcolormesh(*edges, np.ma.masked_invalid(values), cmap=_SWEEP_COLOUR_MAP, norm=norm, rasterized=True)
        draw_missing_cells(panel, self._sweep, self._places[..., third_index][order].T, ~np.isfinite(values), edges)
        across.apply_to(panel, "x", cells=True)
        up.apply_to(panel, "y", cells=True)
        if across.axis.is_numeric and up.axis.is_numeric:
            _draw_contours(panel, across.positions, up.positions, values, norm)
        x, y = across.scene_position, up.scene_position
        if x is not None and y is not None and self._is_scene_at(third_index):
            panel.plot([x], [y], linestyle="", zorder=6, **SCENE_MARKER)
        return panel

    def _draw_colour_bar(self, page: Page, panel: Panel, k: int) -> None:
        """Draw the colour bar of a quantity right of its map."""
        box = panel.get_position()
        width = page.get_figwidth()
        quantity = self._sweep.quantities[k]
        unit = quantity.display_unit[1]
        bar = page.add_panel((box.x1 + 0.12 / width, box.y0, _COLOUR_BAR_WIDTH / width, box.height), grid=None)
        page.colorbar(ScalarMappable(self._norms[k], _SWEEP_COLOUR_MAP), cax=bar).outline.set(edgecolor=MUTED, linewidth=0.8)
        bar.yaxis.set_major_locator(MaxNLocator(_N_LEVELS, min_n_ticks=2, steps=ROUND_STEPS))
        format_plain_ticks(bar.yaxis, bar.get_ylim())
        bar.label(y_label=unit if self._is_flat else label_with_unit(quantity.name, unit), size=9.5)


def _colour_norms(sweep: Sweep) -> list[Normalize]:
    """Return the colour scale of each quantity; those of one unit share one if each of them uses enough of it."""
    columns = [sweep.column(one.name) * one.display_unit[0] for one in sweep.quantities]
    limits = [(float(np.min(own)), float(np.max(own))) if (own := column[np.isfinite(column)]).size else (0.0, 1.0) for column in columns]
    norms = [_make_norm(*own) for own in limits]
    for unit in {one.display_unit[1] for one in sweep.quantities} - {""}:
        members = [k for k, one in enumerate(sweep.quantities) if one.display_unit[1] == unit]
        low = min(limits[k][0] for k in members)
        high = max(limits[k][1] for k in members)
        if min(limits[k][1] - limits[k][0] for k in members) > _MIN_SHARED_RATIO * (high - low):
            shared = _make_norm(low, high)
            for k in members:
                norms[k] = shared
    return norms


def _make_norm(low: float, high: float) -> Normalize:
    """Return the colour scale between two values; nearly equal values have one colour."""
    is_uniform = low == high or high - low < _UNIFORM_TOLERANCE * max(abs(low), abs(high))
    return Normalize(*(axis_limits_for(np.array([low, high])) if is_uniform else (low, high)))


def _draw_contours(panel: Panel, x: FloatArray, y: FloatArray, values: FloatArray, norm: Normalize) -> None:
    """Draw labelled contours at round values, unless the values are too few or too rough."""
    finite = values[np.isfinite(values)]
    if min(values.shape) < _MIN_CONTOUR_VALUES or not finite.size or _roughness(values) > _MAX_ROUGHNESS:
        return
    low, high = float(norm.vmin or 0.0), float(norm.vmax or 0.0)
    levels = [one for one in MaxNLocator(_N_LEVELS, steps=ROUND_STEPS).tick_values(low, high) if finite.min() < one < finite.max()]
    if not levels or float(np.ptp(finite)) < _UNIFORM_TOLERANCE * float(np.max(np.abs(finite))):
        return
    contours = panel.contour(x, y, np.ma.masked_invalid(values), levels=levels, colors=[INK], linewidths=0.8, alpha=0.8)
    contours.set_gid(OVER_COLOUR_MAP)
    labels: Any = panel.clabel(contours, fmt="%g", fontsize=7.5, inline_spacing=3)
    for label in labels:
        label.set(fontfamily=SANS_FONT, color=INK, gid=OVER_COLOUR_MAP, path_effects=[withStroke(linewidth=2.2, foreground=PAPER)])


def _roughness(values: FloatArray) -> float:
    """Return the mean second difference of neighbouring values relative to the mean first difference."""
    first = np.concatenate([np.abs(np.diff(values, axis=axis)).ravel() for axis in (0, 1)])
    second = np.concatenate([np.abs(np.diff(values, n=2, axis=axis)).ravel() for axis in (0, 1)])
    first, second = first[np.isfinite(first)], second[np.isfinite(second)]
    if not first.size or not second.size or not first.any():
        return np.inf
    return float(second.mean() / first.mean())


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
    """Draw all quantities of a sweep over its keys, in everyday units; MechanismError if it has more than three keys."""
    # Rows without a number are hatched by the way in which they ended. The values of the scene itself
    # are marked.
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
    places = number_endings(sweep)[axis_scale.order]
    low_and_high = np.array(panel.get_ylim())
    draw_missing_cells(panel, sweep, places[None, :], is_missing[None, :], (axis_scale.cell_edges(), low_and_high))
    panel.set_ylim(*low_and_high)

"""Heat maps of a sweep over two keys, and rows of heat maps over three keys."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from governor_mechanism.render.figures.page import label_axes, new_figure, write_footnote, write_heading, write_title
from governor_mechanism.render.film.reading_panel import axis_limits_for, format_plain_ticks
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SANS_FONT, SKY, STEEL
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import FloatArray

_MAP_WIDTH, _MAP_HEIGHT, _MAP_SPACING_X, _MAP_SPACING_Y = 3.1, 2.5, 0.25, 0.7
"""Size of a map and spacing between maps, inches."""

_SINGLE_MAP_RATIO = 1.7
_LEFT_MARGIN, _RIGHT_MARGIN, _TOP_MARGIN, _BOTTOM_MARGIN, _COLOUR_BAR_WIDTH = 0.85, 0.95, 0.8, 0.7, 0.16
"""Margins around the maps and width of a colour bar, inches."""

_MAX_THIRD_KEY_MAPS = 6
"""Largest number of shown values of a third key, from the first to the last."""

_SWEEP_COLOUR_MAP = LinearSegmentedColormap.from_list("sweep", ["#f0ecd9", SKY, BLUE, "#00243d"])

_FAILURE_STYLES = ((RULE, "////"), (STEEL, "...."), (PAPER, "xxxx"), (RULE, "\\\\\\\\"), (STEEL, "----"))
"""Colour and hatching of cells without a number, by the order of outcomes."""

_UNIFORM_TOLERANCE = 1e-4
"""Range of values, relative to the largest one, below which a map has one colour."""

_MAX_HATCHED_CELLS = 20_000
"""Largest number of cells with hatching; in larger maps hatching is slow and too fine to see."""

_MAX_TICKS = 24
"""Largest number of text labels on an axis."""

_AXIS_MARGIN_RATIO = 0.02
"""Margin of an axis of curves beyond its outer values, as a fraction of its length."""

_MIN_LOGARITHMIC_RATIO = 100.0
"""Ratio of the largest to the smallest positive value from which an axis is logarithmic."""


@dataclass(frozen=True, kw_only=True)
class SweepAxisScale:
    """Axis of a sweep on an axis of a figure: positions of its values in ascending order, and their labels."""

    label: str
    positions: FloatArray
    edges: FloatArray
    order: NDArray[np.intp]
    is_numeric: bool
    is_logarithmic: bool
    tick_labels: tuple[str, ...]

    @classmethod
    def from_axis(cls, axis: SweepAxis) -> SweepAxisScale:
        """Create the scale of a sweep axis: numbers in everyday units, text values at integer positions in the given order."""
        factor, unit = axis.display_unit
        tick_labels = tuple(f"{v * factor:.5g} {unit}".strip() if isinstance(v, float) else str(v) for v in axis.values)
        values = np.array(axis.values, dtype=float) * factor if axis.is_numeric else np.arange(float(len(axis.values)))
        order = np.argsort(values, kind="stable")
        values = values[order]
        is_logarithmic = axis.is_numeric and values[0] > 0 and values[-1] >= _MIN_LOGARITHMIC_RATIO * values[0]
        transformed = np.log(values) if is_logarithmic else values
        midpoints = (transformed[1:] + transformed[:-1]) / 2
        outer_half_widths = (midpoints[0] - transformed[0], transformed[-1] - midpoints[-1]) if len(transformed) > 1 else (0.5, 0.5)
        edges = np.concatenate([[transformed[0] - outer_half_widths[0]], midpoints, [transformed[-1] + outer_half_widths[1]]])
        return cls(
            label=label_with_unit(axis.key, unit if axis.is_numeric else ""),
            positions=values,
            edges=np.exp(edges) if is_logarithmic else edges,
            order=order,
            is_numeric=axis.is_numeric,
            is_logarithmic=is_logarithmic,
            tick_labels=tick_labels,
        )

    def apply_to(self, axes: Axes, axis_name: Literal["x", "y"], *, cells: bool = False) -> None:
        """Set scale, limits and ticks of a figure axis; the limits are those of the cells, or the outer values with a margin."""
        axis = axes.xaxis if axis_name == "x" else axes.yaxis
        set_limits = axes.set_xlim if axis_name == "x" else axes.set_ylim
        if self.is_logarithmic:
            (axes.set_xscale if axis_name == "x" else axes.set_yscale)("log")
        if cells or len(self.positions) == 1 or not self.is_numeric:
            set_limits(self.edges[0], self.edges[-1])
        elif self.is_logarithmic:
            margin = (self.positions[-1] / self.positions[0]) ** _AXIS_MARGIN_RATIO
            set_limits(self.positions[0] / margin, self.positions[-1] * margin)
        else:
            margin = _AXIS_MARGIN_RATIO * (self.positions[-1] - self.positions[0])
            set_limits(self.positions[0] - margin, self.positions[-1] + margin)
        if not self.is_numeric:
            step = -(-len(self.positions) // _MAX_TICKS)
            axis.set_ticks(list(self.positions[::step]), labels=list(self.tick_labels[::step]))
        elif not self.is_logarithmic:
            axis.set_major_locator(MaxNLocator(5 if axis_name == "x" else 6, min_n_ticks=2))
            format_plain_ticks(axis, (self.positions[0], self.positions[-1]))


def label_with_unit(name: str, unit: str) -> str:
    """Return the label of a key or a quantity with its unit."""
    text = format_name(name.removeprefix("dimensions.").removeprefix("effects."))
    return f"{text}, {unit}" if unit else text


def draw_heatmaps(sweep: Sweep) -> Figure:
    """Draw a row of maps for each quantity: one map, or one for each shown value of the third key."""
    third_indices = _shown_third_indices(sweep)
    is_two_dimensional = len(sweep.axes) == 2
    map_scale = _SINGLE_MAP_RATIO if is_two_dimensional and len(sweep.quantities) == 1 else 1.2 if is_two_dimensional else 1.0
    columns = min(len(sweep.quantities), 2) if is_two_dimensional else len(third_indices)
    rows = -(-len(sweep.quantities) // columns) if is_two_dimensional else len(sweep.quantities)
    colour_bar_space = _RIGHT_MARGIN if is_two_dimensional else 0.0
    map_width, map_height = _MAP_WIDTH * map_scale, _MAP_HEIGHT * map_scale
    map_spacing = _MAP_SPACING_X + (colour_bar_space + 0.55 if is_two_dimensional else 0.0)
    width = _LEFT_MARGIN + columns * map_width + (columns - 1) * map_spacing + _RIGHT_MARGIN
    height = _TOP_MARGIN + 0.25 + rows * map_height + (rows - 1) * (_MAP_SPACING_Y + 0.1) + _BOTTOM_MARGIN + _legend_height(sweep)
    figure = new_figure(width, height)

    def add_map_axes(row: int, column: int) -> Axes:
        """Add the axes of a map at a row and a column."""
        left = _LEFT_MARGIN + column * (map_width + map_spacing)
        top = _TOP_MARGIN + 0.25 + row * (map_height + _MAP_SPACING_Y + 0.1)
        return figure.add_axes((left / width, 1 - (top + map_height) / height, map_width / width, map_height / height))

    for k, quantity in enumerate(sweep.quantities):
        grid_cells = [divmod(k, columns)] if is_two_dimensional else [(k, column) for column in range(columns)]
        map_axes = [add_map_axes(*cell) for cell in grid_cells]
        _draw_map_row(figure, sweep, quantity, map_axes, third_indices, is_last_row=is_two_dimensional or k == rows - 1)
    write_title(figure, sweep.title, x=0.25 / width, y=1 - 0.32 / height)
    _draw_legend(figure, sweep, width, height)
    return figure


def _shown_third_indices(sweep: Sweep) -> list[int]:
    """Return the indices of the shown values of the third key."""
    if len(sweep.axes) == 2:
        return [0]
    count = sweep.shape[2]
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, _MAX_THIRD_KEY_MAPS))})


def _draw_map_row(
    figure: Figure, sweep: Sweep, quantity: RunQuantity, map_axes: list[Axes], third_indices: list[int], *, is_last_row: bool
) -> None:
    factor, unit = quantity.display_unit
    axis_scales = [SweepAxisScale.from_axis(axis) for axis in sweep.axes]
    values = sweep.grid(quantity.name).reshape(*sweep.shape[:2], -1) * factor
    outcomes = np.array(["" if row.ok else row.outcome for row in sweep.rows]).reshape(values.shape)
    finite = values[np.isfinite(values)]
    value_range = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    is_uniform = value_range[1] - value_range[0] < _UNIFORM_TOLERANCE * max(map(abs, value_range))
    norm = Normalize(*(axis_limits_for(np.array(value_range)) if is_uniform or value_range[0] == value_range[1] else value_range))
    order = np.ix_(axis_scales[0].order, axis_scales[1].order)
    mesh: Any = None
    for axes, third_index in zip(map_axes, third_indices, strict=True):
        mesh = _draw_map(axes, axis_scales, values[..., third_index][order].T, outcomes[..., third_index][order].T, sweep, norm)
        if axes is map_axes[0]:
            label_axes(axes, y_label=axis_scales[1].label, size=9.5)
        else:
            axes.tick_params(labelleft=False)
        if is_last_row:
            label_axes(axes, axis_scales[0].label, size=9.5)
        heading = label_with_unit(quantity.name, unit) if len(sweep.axes) == 2 else _third_key_label(sweep, third_index)
        write_heading(axes, heading, y=1.04, size=10.5)
    _draw_colour_bar(figure, map_axes[-1], mesh, "" if len(sweep.axes) == 2 else label_with_unit(quantity.name, unit))


def _third_key_label(sweep: Sweep, index: int) -> str:
    axis = sweep.axes[2]
    return f"{label_with_unit(axis.key, '')} {SweepAxisScale.from_axis(axis).tick_labels[index]}"


def _draw_map(
    axes: Axes, axis_scales: list[SweepAxisScale], values: FloatArray, outcomes: NDArray[Any], sweep: Sweep, norm: Normalize
) -> Any:
    """Draw one map; cells of failed rows are hatched by outcome, and filled with a plain colour if they have no number."""
    x_edges, y_edges = axis_scales[0].edges, axis_scales[1].edges
    axes.set_facecolor(PAPER)
    mesh = axes.pcolormesh(x_edges, y_edges, np.ma.masked_invalid(values), cmap=_SWEEP_COLOUR_MAP, norm=norm, rasterized=True)
    for outcome, (colour, hatch) in zip(_failure_outcomes(sweep), cycle(_FAILURE_STYLES), strict=False):
        has_outcome = outcomes == outcome
        cells = np.ma.masked_where(~has_outcome, np.zeros(values.shape))
        if has_outcome.any() and not np.isfinite(values[has_outcome]).any():
            axes.pcolormesh(x_edges, y_edges, cells, cmap=ListedColormap([colour]))
        if has_outcome.any() and values.size <= _MAX_HATCHED_CELLS:
            hatching = axes.pcolor(x_edges, y_edges, cells, cmap=ListedColormap(["none"]), hatch=hatch)
            hatching.set(edgecolor=MUTED, linewidth=0.0)
    axis_scales[0].apply_to(axes, "x", cells=True)
    axis_scales[1].apply_to(axes, "y", cells=True)
    for spine in axes.spines.values():
        spine.set(color=MUTED, linewidth=0.8)
    axes.tick_params(color=MUTED, labelcolor=MUTED, labelsize=8, labelfontfamily=SANS_FONT)
    return mesh


def _draw_colour_bar(figure: Figure, map_axes: Axes, mesh: Any, label: str) -> None:
    box = map_axes.get_position()
    width = figure.get_figwidth()
    axes = figure.add_axes((box.x1 + 0.12 / width, box.y0, _COLOUR_BAR_WIDTH / width, box.height))
    bar = figure.colorbar(mesh, cax=axes)
    bar.outline.set(edgecolor=MUTED, linewidth=0.8)
    axes.tick_params(color=MUTED, labelcolor=MUTED, labelsize=8, labelfontfamily=SANS_FONT)
    axes.yaxis.set_major_locator(MaxNLocator(6, min_n_ticks=2))
    format_plain_ticks(axes.yaxis, axes.get_ylim())
    label_axes(axes, y_label=label, size=9.5)


def _failure_outcomes(sweep: Sweep) -> list[str]:
    """Return the outcomes of the failed rows."""
    return list(dict.fromkeys(row.outcome for row in sweep.rows if not row.ok))


def _legend_height(sweep: Sweep) -> float:
    return 0.3 if _failure_outcomes(sweep) or (len(sweep.axes) == 3 and len(_shown_third_indices(sweep)) < sweep.shape[2]) else 0.0


def _draw_legend(figure: Figure, sweep: Sweep, width: float, height: float) -> None:
    """Draw the legend of failed cells, and the number of shown values of a third key."""
    counts = sweep.outcomes
    handles = [
        Patch(facecolor=colour, edgecolor=MUTED, hatch=hatch, linewidth=0.6, label=f"{name.replace('_', ' ')} ({counts[name]})")
        for name, (colour, hatch) in zip(_failure_outcomes(sweep), cycle(_FAILURE_STYLES), strict=False)
    ]
    if handles:
        corner = (0.2 / width, 0.02 / height)
        legend = figure.legend(handles=handles, loc="lower left", bbox_to_anchor=corner, ncols=len(handles), frameon=False)
        for name in legend.get_texts():
            name.set(color=INK, fontsize=8.5, fontfamily=SANS_FONT)
    third_indices = _shown_third_indices(sweep)
    if len(sweep.axes) == 3 and len(third_indices) < sweep.shape[2]:
        text = f"{len(third_indices)} of the {sweep.shape[2]} values of {label_with_unit(sweep.axes[2].key, '')} are shown"
        write_footnote(figure, text, x=1 - 0.2 / width, y=0.12 / height, size=8, ha="right")

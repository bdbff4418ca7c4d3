"""Heat maps of a sweep over two keys, and rows of heat maps over three keys."""

from itertools import cycle
from typing import Any, Literal

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from governor_mechanism.render.figures.page import Page, Panel, PanelRect, add_legend, axis_limits_for, format_plain_ticks
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SANS_FONT, SKY, STEEL
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.studies.sweep.quantities import RunQuantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.studies.sweep.rows import OK_ROW_OUTCOMES
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


class SweepAxisScale:
    """Axis of a sweep on an axis of a figure: positions of its values in ascending order.

    Numbers are in everyday units; text values are at integer positions in the given order.
    """

    def __init__(self, axis: SweepAxis) -> None:
        self.axis = axis
        factor, _ = axis.display_unit
        values = np.array(axis.values, dtype=float) * factor if axis.is_numeric else np.arange(float(len(axis.values)))
        self.order = np.argsort(values, kind="stable")
        self.positions: FloatArray = values[self.order]
        first, last = self.positions[[0, -1]]
        self.is_logarithmic = axis.is_numeric and first > 0 and last >= _MIN_LOGARITHMIC_RATIO * first

    @property
    def label(self) -> str:
        """Label of the axis."""
        return label_with_unit(self.axis.key, self.axis.display_unit[1] if self.axis.is_numeric else "")

    def cell_edges(self) -> FloatArray:
        """Return the edges of the cells around the positions."""
        transformed = np.log(self.positions) if self.is_logarithmic else self.positions
        midpoints = (transformed[1:] + transformed[:-1]) / 2
        outer_half_widths = (midpoints[0] - transformed[0], transformed[-1] - midpoints[-1]) if len(transformed) > 1 else (0.5, 0.5)
        edges = np.concatenate([[transformed[0] - outer_half_widths[0]], midpoints, [transformed[-1] + outer_half_widths[1]]])
        return np.exp(edges) if self.is_logarithmic else edges

    def format_value(self, index: int) -> str:
        """Return a value of the axis as text."""
        value, (factor, unit) = self.axis.values[index], self.axis.display_unit
        return f"{value * factor:.5g} {unit}".strip() if isinstance(value, float) else str(value)

    def apply_to(self, panel: Panel, axis_name: Literal["x", "y"], *, cells: bool = False) -> None:
        """Set scale, limits and ticks of a figure axis; the limits are those of the cells, or the outer values with a margin."""
        if self.is_logarithmic:
            panel.set(**{f"{axis_name}scale": "log"})
        panel.set(**{f"{axis_name}lim": self._limits(cells=cells)})
        axis = panel.xaxis if axis_name == "x" else panel.yaxis
        if not self.axis.is_numeric:
            indices = range(0, len(self.positions), -(-len(self.positions) // _MAX_TICKS))
            axis.set_ticks([self.positions[k] for k in indices], labels=[self.format_value(k) for k in indices])
        elif not self.is_logarithmic:
            axis.set_major_locator(MaxNLocator(5 if axis_name == "x" else 6, min_n_ticks=2))
            format_plain_ticks(axis, (self.positions[0], self.positions[-1]))

    def _limits(self, *, cells: bool) -> tuple[float, float]:
        low, high = self.positions[0], self.positions[-1]
        if cells or len(self.positions) == 1 or not self.axis.is_numeric:
            edges = self.cell_edges()
            return edges[0], edges[-1]
        if self.is_logarithmic:
            factor = (high / low) ** _AXIS_MARGIN_RATIO
            return low / factor, high * factor
        margin = _AXIS_MARGIN_RATIO * (high - low)
        return low - margin, high + margin


def label_with_unit(name: str, unit: str) -> str:
    """Return the label of a key or a quantity with its unit."""
    text = format_name(name.removeprefix("dimensions.").removeprefix("effects."))
    return f"{text}, {unit}" if unit else text


def failure_counts(sweep: Sweep) -> dict[str, int]:
    """Return the number of failed rows by outcome."""
    return {outcome: count for outcome, count in sweep.outcomes.items() if outcome not in OK_ROW_OUTCOMES}


def draw_heatmaps(sweep: Sweep) -> Page:
    """Draw a row of maps for each quantity: one map, or one for each shown value of the third key."""
    third_indices = _shown_third_indices(sweep)
    scales = [SweepAxisScale(axis) for axis in sweep.axes]
    is_two_dimensional, n_quantities = len(sweep.axes) == 2, len(sweep.quantities)
    map_scale = _SINGLE_MAP_RATIO if is_two_dimensional and n_quantities == 1 else 1.2 if is_two_dimensional else 1.0
    columns = min(n_quantities, 2) if is_two_dimensional else len(third_indices)
    rows = -(-n_quantities // columns) if is_two_dimensional else n_quantities
    map_width, map_height = _MAP_WIDTH * map_scale, _MAP_HEIGHT * map_scale
    spacing_x, spacing_y = _MAP_SPACING_X + (_RIGHT_MARGIN + 0.55 if is_two_dimensional else 0.0), _MAP_SPACING_Y + 0.1
    header, footer = _TOP_MARGIN + 0.25, _BOTTOM_MARGIN + (0.3 if failure_counts(sweep) or _n_hidden_maps(sweep) else 0.0)
    width = _LEFT_MARGIN + columns * map_width + (columns - 1) * spacing_x + _RIGHT_MARGIN
    height = header + rows * map_height + (rows - 1) * spacing_y + footer
    page = Page(width, height)
    for k, quantity in enumerate(sweep.quantities):
        rects = []
        for row, column in [divmod(k, columns)] if is_two_dimensional else [(k, column) for column in range(columns)]:
            left, top = _LEFT_MARGIN + column * (map_width + spacing_x), header + row * (map_height + spacing_y)
            rects.append((left / width, 1 - (top + map_height) / height, map_width / width, map_height / height))
        x_label = scales[0].label if is_two_dimensional or k == rows - 1 else ""
        _draw_map_row(page, sweep, quantity, scales, dict(zip(third_indices, rects, strict=True)), x_label)
    page.write_title(sweep.title, x=0.25 / width, y=1 - 0.32 / height)
    _draw_legend(page, sweep)
    return page


def _shown_third_indices(sweep: Sweep) -> list[int]:
    """Return the indices of the shown values of the third key."""
    if len(sweep.axes) == 2:
        return [0]
    count = sweep.shape[2]
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, _MAX_THIRD_KEY_MAPS))})


def _draw_map_row(
    page: Page, sweep: Sweep, quantity: RunQuantity, scales: list[SweepAxisScale], rects: dict[int, PanelRect], x_label: str
) -> None:
    """Draw the maps of a quantity at rectangles by the index of the third key, with a colour bar."""
    factor, unit = quantity.display_unit
    is_two_dimensional, quantity_label = len(scales) == 2, label_with_unit(quantity.name, unit)
    values = sweep.grid(quantity.name).reshape(*sweep.shape[:2], -1) * factor
    outcomes = sweep.failures.reshape(values.shape)
    order = np.ix_(scales[0].order, scales[1].order)
    norm = _colour_norm(values)
    for third_index, rect in rects.items():
        y_label = "" if third_index else scales[1].label
        panel = page.add_panel(rect, x_label, y_label, label_size=9.5, grid=None)
        panel.spines[["top", "right"]].set_visible(True)
        mesh = _draw_map(panel, scales, values[..., third_index][order].T, outcomes[..., third_index][order].T, sweep, norm)
        panel.tick_params(labelleft=bool(y_label))
        third_label = "" if is_two_dimensional else f"{label_with_unit(sweep.axes[2].key, '')} {scales[2].format_value(third_index)}"
        panel.write_heading(third_label or quantity_label, y=1.04, size=10.5)
    box, width = panel.get_position(), page.get_figwidth()
    bar_rect = box.x1 + 0.12 / width, box.y0, _COLOUR_BAR_WIDTH / width, box.height
    _draw_colour_bar(page, bar_rect, mesh, "" if is_two_dimensional else quantity_label)


def _colour_norm(values: FloatArray) -> Normalize:
    """Return the colour scale of values; nearly equal values have one colour."""
    finite = values[np.isfinite(values)]
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    is_uniform = low == high or high - low < _UNIFORM_TOLERANCE * max(abs(low), abs(high))
    return Normalize(*(axis_limits_for(np.array([low, high])) if is_uniform else (low, high)))


def _draw_map(panel: Panel, scales: list[SweepAxisScale], values: FloatArray, outcomes: NDArray[Any], sweep: Sweep, norm: Normalize) -> Any:
    """Draw one map; cells of failed rows are hatched by outcome, and filled with a plain colour if they have no number."""
    edges = scales[0].cell_edges(), scales[1].cell_edges()
    mesh = panel.pcolormesh(*edges, np.ma.masked_invalid(values), cmap=_SWEEP_COLOUR_MAP, norm=norm, rasterized=True)
    for outcome, (colour, hatch) in zip(failure_counts(sweep), cycle(_FAILURE_STYLES), strict=False):
        has_outcome = outcomes == outcome
        cells = np.ma.masked_where(~has_outcome, np.zeros(values.shape))
        if has_outcome.any() and not np.isfinite(values[has_outcome]).any():
            panel.pcolormesh(*edges, cells, cmap=ListedColormap([colour]))
        if has_outcome.any() and values.size <= _MAX_HATCHED_CELLS:
            hatching = panel.pcolor(*edges, cells, cmap=ListedColormap(["none"]), hatch=hatch)
            hatching.set(edgecolor=MUTED, linewidth=0.0)
    scales[0].apply_to(panel, "x", cells=True)
    scales[1].apply_to(panel, "y", cells=True)
    return mesh


def _draw_colour_bar(page: Page, rect: PanelRect, mesh: Any, label: str) -> None:
    panel = page.add_panel(rect, grid=None)
    page.colorbar(mesh, cax=panel).outline.set(edgecolor=MUTED, linewidth=0.8)
    panel.yaxis.set_major_locator(MaxNLocator(6, min_n_ticks=2))
    format_plain_ticks(panel.yaxis, panel.get_ylim())
    panel.label(y_label=label, size=9.5)


def _n_hidden_maps(sweep: Sweep) -> int:
    """Return the number of values of a third key without a map."""
    return sweep.shape[2] - len(_shown_third_indices(sweep)) if len(sweep.axes) == 3 else 0


def _draw_legend(page: Page, sweep: Sweep) -> None:
    """Draw the legend of failed cells, and the number of shown values of a third key."""
    width, height = page.get_size_inches()
    handles = [
        Patch(facecolor=colour, edgecolor=MUTED, hatch=hatch, linewidth=0.6, label=f"{name.replace('_', ' ')} ({count})")
        for (name, count), (colour, hatch) in zip(failure_counts(sweep).items(), cycle(_FAILURE_STYLES), strict=False)
    ]
    if handles:
        corner = (0.2 / width, 0.02 / height)
        text_style = {"color": INK, "fontsize": 8.5, "fontfamily": SANS_FONT}
        add_legend(page, text_style, handles=handles, loc="lower left", bbox_to_anchor=corner, ncols=len(handles))
    if hidden := _n_hidden_maps(sweep):
        count = sweep.shape[2]
        text = f"{count - hidden} of the {count} values of {label_with_unit(sweep.axes[2].key, '')} are shown"
        page.write_footnote(text, x=1 - 0.2 / width, y=0.12 / height, size=8, ha="right")

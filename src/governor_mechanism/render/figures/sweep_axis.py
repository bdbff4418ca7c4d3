"""A varied key of a sweep on an axis of a figure; rows without a number, the scene itself, and the key of both."""

import textwrap
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from governor_mechanism.render.figures.page import Page, Panel, add_legend, format_plain_ticks
from governor_mechanism.render.shown_readings import format_label
from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT, STEEL
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.studies.sweep.rows import RowEnding
from governor_mechanism.types import BoolArray, FloatArray, IntArray

_MAX_TICKS = 24
"""Largest number of text labels on an axis."""

_MAX_TICKED_VALUES = 5
"""Largest number of numbers of a key that all have a tick of their own."""

_AXIS_MARGIN_RATIO = 0.02
"""Margin of an axis of curves beyond its outer values, as a fraction of its length."""

_MIN_LOGARITHMIC_RATIO = 100.0
"""Ratio of the largest to the smallest positive value from which an axis is logarithmic."""

ROUND_STEPS = (1, 2, 2.5, 5, 10)
"""Distances of ticks and contours, times a power of ten."""


class SweepAxisScale:
    """Positions of the values of a sweep's axis, ascending: numbers in everyday units, text at whole numbers in the given order."""

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

    @property
    def scene_position(self) -> float | None:
        """Position of the value that the scene itself has; None if it has none within the range."""
        value = self.axis.scene_value
        if self.axis.is_numeric:
            position = value * self.axis.display_unit[0] if isinstance(value, float) else None
        else:
            position = float(self.axis.values.index(value)) if value in self.axis.values else None
        edges = self.cell_edges()
        return position if position is not None and edges[0] <= position <= edges[-1] else None

    def cell_edges(self) -> FloatArray:
        """Return the edges of the cells around the positions."""
        transformed = np.log(self.positions) if self.is_logarithmic else self.positions
        midpoints = (transformed[1:] + transformed[:-1]) / 2
        outer_half_widths = (midpoints[0] - transformed[0], transformed[-1] - midpoints[-1]) if len(transformed) > 1 else (0.5, 0.5)
        edges = np.concatenate([[transformed[0] - outer_half_widths[0]], midpoints, [transformed[-1] + outer_half_widths[1]]])
        return np.exp(edges) if self.is_logarithmic else edges

    def format_value(self, value: float | str | bool | None) -> str:
        """Return a value of the axis as text."""
        if isinstance(value, bool):
            return "on" if value else "off"
        factor, unit = self.axis.display_unit
        return f"{value * factor:.5g} {unit}".strip() if isinstance(value, float) else str(value)

    def apply_to(self, panel: Panel, axis_name: Literal["x", "y"], *, cells: bool = False) -> None:
        """Set scale, limits and ticks of a figure axis; the limits are those of the cells, or the outer values with a margin."""
        if self.is_logarithmic:
            panel.set(**{f"{axis_name}scale": "log"})
        panel.set(**{f"{axis_name}lim": self._limits(cells=cells)})
        axis = panel.xaxis if axis_name == "x" else panel.yaxis
        if not self.axis.is_numeric:
            indices = range(0, len(self.positions), -(-len(self.positions) // _MAX_TICKS))
            axis.set_ticks([self.positions[k] for k in indices], labels=[self.format_value(self.axis.values[k]) for k in indices])
        elif len(self.positions) <= _MAX_TICKED_VALUES:
            axis.set_ticks(self.positions.tolist(), labels=[f"{one:.5g}" for one in self.positions.tolist()], minor=False)
            axis.set_ticks([], minor=True)
        elif not self.is_logarithmic:
            axis.set_major_locator(MaxNLocator(6, min_n_ticks=2, steps=ROUND_STEPS))
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
    return format_label(name.removeprefix("dimensions.").removeprefix("effects."), unit)


_RESULT_STYLES = ((RULE, "////"), (STEEL, "...."), ("#e3e3dc", "\\\\\\\\"), ("#dfe6ea", "xxxx"), (RULE, "----"))
"""Colour and hatching of rows whose ending is a result, by turns."""

_FAILURE_STYLES = (("#f0cdb5", "xxxx"), ("#f0cdb5", "++++"), ("#f0cdb5", "oooo"))
"""Colour and hatching of rows that failed, by turns."""

KEY_LINE_HEIGHT = 0.19
"""Height of a line of the key, inches."""

_LETTERS_PER_INCH = 13.5
_KEY_FONT_SIZE = 8.5
_HANDLE_WIDTH = 0.6
"""Letters of the key in an inch, their size in points, and the width of what they explain, inches."""

SCENE_MARKER: dict[str, Any] = {"marker": "o", "markersize": 8, "markerfacecolor": PAPER, "markeredgecolor": INK, "markeredgewidth": 1.6}
"""Marker of the scene itself on a map."""

SCENE_LINE: dict[str, Any] = {"color": MUTED, "linewidth": 1.0, "linestyle": (0, (4, 3))}
"""Line at the value of the scene itself beside curves."""


def number_endings(sweep: Sweep) -> IntArray:
    """Return the place of each row's ending in `endings`, and -1 for a row that ran to its end and has all its numbers; shape (rows,)."""
    places = np.full(len(sweep.rows), -1)
    for place, ending in enumerate(sweep.endings):
        places[ending.rows] = place
    return places


def _styles_of(endings: Sequence[RowEnding]) -> list[tuple[str, str]]:
    """Return colour and hatching of each ending."""
    styles, counts = [], {True: 0, False: 0}
    for ending in endings:
        known = _RESULT_STYLES if ending.is_result else _FAILURE_STYLES
        styles.append(known[counts[ending.is_result] % len(known)])
        counts[ending.is_result] += 1
    return styles


def draw_missing_cells(panel: Panel, sweep: Sweep, places: IntArray, is_missing: BoolArray, edges: tuple[FloatArray, FloatArray]) -> None:
    """Fill the cells without a number in the style of their ending."""
    # `places` has the place of the ending of each cell and `is_missing` whether it has no number; both
    # have the shape (cells up, cells across). `edges` are those of the cells across and up.
    for place, (colour, hatch) in enumerate(_styles_of(sweep.endings)):
        vertices = [
            corner
            for row, is_hatched in enumerate((places == place) & is_missing)
            for first, last in _find_runs(is_hatched)
            for corner in _rectangle(edges[0][[first, last]], edges[1][[row, row + 1]])
        ]
        if vertices:
            codes = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY] * (len(vertices) // 5)
            panel.add_patch(PathPatch(Path(vertices, codes), facecolor=colour, edgecolor=MUTED, hatch=hatch, linewidth=0.0, zorder=0.5))


def _find_runs(is_chosen: BoolArray) -> list[tuple[int, int]]:
    """Return first index and end of each run of true values."""
    changes = np.flatnonzero(np.diff(np.concatenate([[False], is_chosen, [False]])))
    return list(zip(changes[::2].tolist(), changes[1::2].tolist(), strict=True))


def _rectangle(x: FloatArray, y: FloatArray) -> list[tuple[float, float]]:
    (left, right), (low, high) = x.tolist(), y.tolist()
    return [(left, low), (right, low), (right, high), (left, high), (left, low)]


def ending_handles(sweep: Sweep) -> list[Artist]:
    """Return the entries of the key for the endings of a sweep."""
    handles: list[Artist] = []
    for ending, (colour, hatch) in zip(sweep.endings, _styles_of(sweep.endings), strict=True):
        text = f"{ending.count:,} of {len(sweep.rows):,} rows {ending.text.replace('_', ' ')}"
        handles.append(Patch(facecolor=colour, edgecolor=MUTED, hatch=hatch, linewidth=0.6, label=text))
    return handles


def scene_handle(scales: Sequence[SweepAxisScale], **style: Any) -> Line2D:
    """Return the entry of the key for the values that the scene itself has."""
    values = ", ".join(scale.format_value(scale.axis.scene_value) for scale in scales)
    return Line2D([], [], label=f"the scene itself: {values}", **style)


def wrap_handles(handles: Sequence[Artist], width: float) -> int:
    """Wrap the labels of the key to a page of a width, inches, and return the number of their lines."""
    n_lines = 0
    for handle in handles:
        text = textwrap.fill(str(handle.get_label()), int((width - _HANDLE_WIDTH) * _LETTERS_PER_INCH))
        handle.set_label(text)
        n_lines += text.count("\n") + 1
    return n_lines


def draw_key(page: Page, handles: Sequence[Artist], left: float = 0.12) -> None:
    """Draw the key at the foot of a page, from a distance to its left edge, inches."""
    if handles:
        width, height = page.get_size_inches()
        style = {"color": INK, "fontsize": _KEY_FONT_SIZE, "fontfamily": SANS_FONT, "parse_math": False}
        corner = (left / width, 0.05 / height)
        add_legend(page, style, handles=list(handles), loc="lower left", bbox_to_anchor=corner, borderaxespad=0.0, labelspacing=0.35)

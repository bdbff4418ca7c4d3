"""What the figures of a sweep show beside its numbers: rows without one, the scene itself, and the key of both."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from governor_mechanism.render.figures.page import Page, Panel, add_legend
from governor_mechanism.render.figures.sweep_axis import SweepAxisScale
from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT, STEEL
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.studies.sweep.row_endings import RowEnding
from governor_mechanism.types import BoolArray, FloatArray, IntArray

_RESULT_STYLES = ((RULE, "////"), (STEEL, "...."), ("#e3e3dc", "\\\\\\\\"), ("#dfe6ea", "xxxx"), (RULE, "----"))
"""Colour and hatching of rows whose ending is a result, by turns."""

_FAILURE_STYLES = (("#f0cdb5", "xxxx"), ("#f0cdb5", "++++"), ("#f0cdb5", "oooo"))
"""Colour and hatching of rows that failed, by turns."""

KEY_LINE_HEIGHT = 0.19
"""Height of a line of the key, inches."""

_LETTERS_PER_INCH, _KEY_FONT_SIZE, _HANDLE_WIDTH = 13.5, 8.5, 0.6
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
    """Fill the cells without a number in the style of their ending.

    `places` has the place of the ending of each cell and `is_missing` whether it has no number; both have the shape (cells up, cells
    across). `edges` are those of the cells across and up.
    """
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

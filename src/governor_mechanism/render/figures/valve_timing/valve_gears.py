"""Figure of valve gears compared: lead, travel and inequality of the cut-off over the cut-off, from full forward to full back gear."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D

from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Page, PanelRect, add_legend
from governor_mechanism.render.style import INK, MUTED, SANS_FONT, SERIES_COLOURS
from governor_mechanism.studies.valve_gears import ValveGear, ValveGears
from governor_mechanism.types import FloatArray

_PAGE_SIZE = 12.0, 5.4
"""Width and height of the figure, inches."""

_BOTTOM, _HEIGHT, _WIDTH = 0.235, 0.56, 0.265
_LEFT_EDGES = (0.055, 0.385, 0.715)
"""Lower edge, height, width and left edges of the panels, in fractions of the figure."""

_COLOURS = (*SERIES_COLOURS, "#8a5fa8", "#8a6a00", "#5b6b7a")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Colours and markers of the gears."""

_N_MARKED = 3
"""Every which point of a line has its marker."""

_WIDEST_LINE, _NARROWEST_LINE = 4.2, 1.4
"""Widths of the first and the last line, points: lines on each other stay visible."""

_COUNT_WORDS = {2: "Two", 3: "Three", 4: "Four", 5: "Five", 6: "Six", 7: "Seven"}

_PANELS: tuple[tuple[str, str, Callable[[ValveGear], FloatArray]], ...] = (
    ("Lead", "Mean lead of both ends [mm]", lambda gear: MM_PER_M * gear.leads.mean(axis=1)),
    ("Travel of the valve", "Travel [mm]", lambda gear: MM_PER_M * gear.travel),
    ("Inequality of the ends", "Cut-off, crank end less head end [%]", lambda gear: 100 * (gear.cut_offs[:, 0] - gear.cut_offs[:, 1])),
)
"""Heading, label of the ordinate and ordinates of each panel."""


def valve_gears_figure(study: ValveGears) -> Page:
    """Draw lead, travel and inequality of the cut-off of valve gears over their mean cut-off."""
    count = len(study.gears)
    title = f"{_COUNT_WORDS.get(count, count)} valve gears compared" if count > 1 else study.gears[0].title
    page = Page(*_PAGE_SIZE, title, "from full forward gear (solid) over mid gear (circle) to full back gear (dashed)")
    colours = [_COLOURS[k % len(_COLOURS)] for k in range(count)]
    widths = np.linspace(_WIDEST_LINE, _NARROWEST_LINE, count) if count > 1 else [2.0]
    for left, (heading, label, ordinates) in zip(_LEFT_EDGES, _PANELS, strict=True):
        _draw_panel(page, (left, _BOTTOM, _WIDTH, _HEIGHT), (heading, label), study.gears, ordinates, colours, widths)
    handles = [
        Line2D([], [], color=colour, linewidth=width, marker=_MARKERS[k % len(_MARKERS)], markersize=6, label=gear.name)
        for k, (gear, colour, width) in enumerate(zip(study.gears, colours, widths, strict=True))
    ]
    style = {"fontfamily": SANS_FONT, "fontsize": 9, "color": INK}
    add_legend(page, style, handles=handles, loc="lower center", ncols=min(count, 5), bbox_to_anchor=(0.5, 0.045))
    page.write_footnote("cut-offs are mean values of both ends, in % of the stroke; in back gear the crank turns the other way")
    return page


def _draw_panel(
    page: Page,
    rect: PanelRect,
    labels: tuple[str, str],
    gears: Sequence[ValveGear],
    ordinates: Callable[[ValveGear], FloatArray],
    colours: Sequence[str],
    widths: Sequence[float] | FloatArray,
) -> None:
    """Draw one panel: its heading and the label of its ordinate, and a line for each gear."""
    panel = page.add_panel(rect, "Mean cut-off [% of the stroke]", labels[1])
    panel.write_heading(labels[0], y=1.04)
    for k, (gear, colour, width) in enumerate(zip(gears, colours, widths, strict=True)):
        cut_off, values = 100 * gear.cut_offs.mean(axis=1), ordinates(gear)
        for is_shown, style in ((gear.positions >= 0, "-"), (gear.positions <= 0, DASHED)):
            panel.plot(cut_off[is_shown], values[is_shown], color=colour, linewidth=width, linestyle=style, dash_capstyle="butt")
        marker: dict[str, Any] = {"marker": _MARKERS[k % len(_MARKERS)], "markersize": 5, "linestyle": "none", "color": colour}
        panel.plot(cut_off[k % _N_MARKED :: _N_MARKED], values[k % _N_MARKED :: _N_MARKED], **marker)
        middle = int(np.argmin(np.abs(gear.positions)))
        panel.plot(cut_off[middle], values[middle], "o", color=colour, markerfacecolor="none", markersize=10, markeredgewidth=1.2)
    low, high = panel.get_ylim()
    if low <= 0 <= high:
        panel.axhline(0.0, color=MUTED, linewidth=0.8)
    else:
        panel.set_ylim(0.0, high)

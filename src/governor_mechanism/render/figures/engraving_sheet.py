"""Common sheet of plates in the style of old engravings: double frame, lettering, quiet axes."""

from __future__ import annotations

import textwrap
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text
from numpy.typing import ArrayLike

from governor_mechanism.render.figures.page import label_axes, new_figure, style_axes
from governor_mechanism.render.style import INK, MUTED, PAPER, SERIF_FONT

PLATE_WIDTH, PLATE_HEIGHT, PLATE_DPI = 13.0, 8.6, 120
"""Width and height, inches, and resolution, dots per inch."""

_MAX_TITLE_LETTERS = 80
"""Number of letters of a title that fit on the line under the heading."""

MM_PER_M = 1e3
DASHED, CHAIN_DOTTED, DOTTED = (0, (5, 2.5)), (0, (10, 2.5, 1.5, 2.5)), (0, (1, 1.8))
"""Lengths of dashes and gaps, in line widths."""

_TEXT_HALO = withStroke(linewidth=3.0, foreground=PAPER)

AxesPoint = tuple[Any, Any]
"""Coordinates x and y: numbers or arrays of them."""


def new_plate(heading: str, title: str, source: str) -> Figure:
    """Return an empty framed plate of PLATE_WIDTH by PLATE_HEIGHT inches, with a heading above a scene title and the source."""
    figure = new_figure(PLATE_WIDTH, PLATE_HEIGHT, PLATE_DPI)
    for inches, width in ((0.14, 1.8), (0.21, 0.6)):
        corner = inches / PLATE_WIDTH, inches / PLATE_HEIGHT
        box = Rectangle(corner, 1 - 2 * corner[0], 1 - 2 * corner[1], transform=figure.transFigure)
        box.set(fill=False, edgecolor=INK, linewidth=width)
        figure.add_artist(box)
    write_text(figure, 0.5, 0.937, heading, 22, ha="center", va="center")
    short_title = textwrap.shorten(title, _MAX_TITLE_LETTERS, placeholder=" …")
    write_text(figure, 0.5, 0.901, f"{short_title}; {source}", 11.5, ha="center", va="center", color=MUTED, parse_math=False)
    return figure


def write_text(figure: Figure, x: float, y: float, text: str, size: float, **properties: Any) -> Text:
    """Write serif text with formulas between dollars at a position in fractions of the figure."""
    text_style = {"color": INK, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", **properties}
    return figure.text(x, y, text, fontsize=size, **text_style)


def annotate_point(axes: Axes, point: AxesPoint, label: str, offset: AxesPoint = (0, 0), **properties: Any) -> Annotation:
    """Write a label at `offset` points from a point of a panel, with a halo; formulas are between dollars."""
    annotation = axes.annotate(label, point, offset, textcoords="offset points", annotation_clip=False)
    text_style = {"color": INK, "fontsize": 10.5, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", "zorder": 9, **properties}
    annotation.set(**text_style)
    annotation.set_path_effects([_TEXT_HALO])
    return annotation


def draw_point(axes: Axes, x: float, y: float, **style: Any) -> None:
    """Draw a round marker at a point."""
    axes.plot([x], [y], "o", **style)


def polar_points(angles: ArrayLike, lengths: ArrayLike, centre: AxesPoint = (0.0, 0.0)) -> AxesPoint:
    """Return points (n,), (n,) at lengths and angles (rad) from a centre."""
    return centre[0] + np.multiply(lengths, np.cos(angles)), centre[1] + np.multiply(lengths, np.sin(angles))


def add_line_legend(axes: Axes, entries: dict[str, dict[str, Any]], *, colour: str, size: float, **properties: Any) -> None:
    """Add a legend of line styles by label."""
    handles = [Line2D([], [], label=label, **style) for label, style in entries.items()]
    legend = axes.legend(handles=handles, **properties)
    for text in legend.get_texts():
        text.set(fontfamily=SERIF_FONT, fontsize=size, math_fontfamily="stix", color=colour)


def style_plate_axes(axes: Axes, x_label: str, y_label: str) -> None:
    """Style axes with two spines and serif labels."""
    style_axes(axes, grid=None)
    label_axes(axes, x_label, y_label, size=10.5, math_fontfamily="stix")

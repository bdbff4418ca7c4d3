"""Common parts of all figures: PNG files, titles, quiet axes and notes."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FuncFormatter, NullFormatter

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT, SERIF_FONT

FIGURE_DPI = 100
"""Resolution of figures, dots per inch."""


def new_figure(width: float, height: float, dpi: float = FIGURE_DPI) -> Figure:
    """Return an empty figure of a width and height in inches."""
    return Figure(figsize=(width, height), dpi=dpi, facecolor=PAPER)


def require_png(path: str | os.PathLike[str]) -> Path:
    """Return the path of a figure; raise MechanismError unless the name ends in .png."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    return target


def save_png(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure as a PNG and return its path; an exception leaves no file behind.

    Raises MechanismError unless the name ends in .png.
    """
    target = require_png(path)
    with atomic_write(target) as temporary:
        # Without the program name in the metadata, equal figures give equal files.
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def write_title(figure: Figure, title: str, *, x: float = 0.02, y: float = 0.945, size: float = 15.0, colour: str = INK) -> None:
    """Write a title or subtitle at a position in fractions of the figure."""
    figure.text(x, y, title, fontsize=size, va="center", color=colour, fontfamily=SERIF_FONT, parse_math=False)


def write_footnote(figure: Figure, text: str, *, x: float = 0.02, y: float = 0.018, size: float = 7.5, **style: Any) -> Text:
    """Write a small text at a position in fractions of the figure."""
    return figure.text(x, y, text, **{"color": MUTED, "fontsize": size, "fontfamily": SANS_FONT, "parse_math": False, **style})


def style_axes(
    axes: Axes,
    *,
    tick_colour: str = MUTED,
    tick_size: float = 8.0,
    which: Literal["major", "both"] = "major",
    grid: Literal["both", "x"] | None = "both",
    is_grid_below: bool = True,
) -> None:
    """Style axes with two spines, small tick labels of a colour, and a grid."""
    axes.set_facecolor(PAPER)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=MUTED, linewidth=0.8)
    axes.tick_params(which=which, color=MUTED, labelcolor=tick_colour, labelsize=tick_size, labelfontfamily=SANS_FONT)
    if grid:
        axes.grid(axis=grid, color=RULE, linewidth=0.6)
        if is_grid_below:
            axes.set_axisbelow(True)


def label_axes(axes: Axes, x_label: str = "", y_label: str = "", *, size: float = 10.0, **style: Any) -> None:
    """Write serif labels of the axes."""
    style = {"color": INK, "fontsize": size, "fontfamily": SERIF_FONT, **style}
    if x_label:
        axes.set_xlabel(x_label, **style)
    if y_label:
        axes.set_ylabel(y_label, **style)


def write_note(
    axes: Axes, text: str, point: tuple[float, float], offset: tuple[float, float] = (0, 0), *, xycoords: Any = "data", **style: Any
) -> Annotation:
    """Write a small text at an offset (points) from a point of the axes."""
    note = axes.annotate(text, point, offset, xycoords=xycoords, textcoords="offset points")
    note.set(**{"fontsize": 8.5, "fontfamily": SANS_FONT, "parse_math": False, **style})
    return note


def write_heading(axes: Axes, heading: str, *, y: float, size: float = 11.0) -> None:
    """Write a heading above the left end of axes, at a height in fractions of the axes."""
    axes.text(0.0, y, heading, transform=axes.transAxes, color=INK, fontsize=size, fontfamily=SERIF_FONT, parse_math=False)


def use_plain_decades(*axes: Any) -> None:
    """Write plain numbers at the decades of logarithmic axes, and none between them."""
    for axis in axes:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())

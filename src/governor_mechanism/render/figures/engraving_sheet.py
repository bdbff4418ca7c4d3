"""What plates in the manner of old engravings share: the sheet with its double frame, its lettering, quiet axes."""

from __future__ import annotations

import os
import textwrap
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.render.style import INK, PAPER, QUIET, SANS, SERIF

WIDTH, HEIGHT, DPI = 13.0, 8.6, 120
"""Inches, and dots per inch."""

TITLE_LETTERS = 80
"""So many fit in the line under the heading."""

MM = 1e3
DASHES, CHAIN, DOTS = (0, (5, 2.5)), (0, (10, 2.5, 1.5, 2.5)), (0, (1, 1.8))
"""Strokes and gaps, in widths of the line."""

HALO = withStroke(linewidth=3.0, foreground=PAPER)

Pair = tuple[float, float]


def sheet(heading: str, title: str, source: str) -> Figure:
    """An empty plate of WIDTH by HEIGHT inches, framed, with a heading over a scene's title and the source."""
    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI, facecolor=PAPER)
    for inches, width in ((0.14, 1.8), (0.21, 0.6)):
        corner = inches / WIDTH, inches / HEIGHT
        box = Rectangle(corner, 1 - 2 * corner[0], 1 - 2 * corner[1], transform=figure.transFigure)
        box.set(fill=False, edgecolor=INK, linewidth=width)
        figure.add_artist(box)
    write(figure, 0.5, 0.937, heading, 22, ha="center", va="center")
    shown = textwrap.shorten(title, TITLE_LETTERS, placeholder=" …")
    write(figure, 0.5, 0.901, f"{shown}; {source}", 11.5, ha="center", va="center", color=QUIET, parse_math=False)
    return figure


def save(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write the plate as a PNG, equal for equal plates; returns the path. An exception leaves no file behind."""
    target = Path(path)
    with written_beside(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def require_png(path: str | os.PathLike[str]) -> None:
    """Refuse a name that does not end in .png."""
    if Path(path).suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {Path(path).name!r}")


def write(figure: Figure, x: float, y: float, words: str, size: float, **properties: Any) -> Text:
    """Words in the plate's serif letters, formulas between dollars, at a place in fractions of the figure."""
    look = {"color": INK, "fontfamily": SERIF, "math_fontfamily": "stix", **properties}
    return figure.text(x, y, words, fontsize=size, **look)


def letter(axes: Axes, at: Pair, words: str, offset: Pair = (0, 0), **properties: Any) -> Annotation:
    """Words `offset` points away from a point of a panel, clear of what lies beneath; formulas between dollars."""
    text = axes.annotate(words, at, offset, textcoords="offset points", annotation_clip=False)
    look = {"color": INK, "fontsize": 10.5, "fontfamily": SERIF, "math_fontfamily": "stix", "zorder": 9, **properties}
    text.set(**look)
    text.set_path_effects([HALO])
    return text


def dress(axes: Axes, across: str, up: str) -> None:
    """Quiet axes with two spines and labels in serif letters."""
    axes.set_facecolor(PAPER)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    look: dict[str, Any] = {"color": INK, "fontsize": 10.5, "fontfamily": SERIF, "math_fontfamily": "stix"}
    axes.set_xlabel(across, **look)
    axes.set_ylabel(up, **look)

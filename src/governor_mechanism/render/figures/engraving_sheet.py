"""Common sheet of plates in the style of old engravings: double frame, captions, lettering, panels."""

import textwrap
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation, Text
from numpy.typing import ArrayLike

from governor_mechanism.render.figures.page import Page, Panel, PanelRect
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


class PlatePanel(Panel):
    """Panel of a plate; text may contain formulas between dollars."""

    @property
    def aspect_ratio(self) -> float:
        """Width over height of the panel."""
        return self.bbox.width / self.bbox.height

    def show_region(self, centre: AxesPoint, half_width: float) -> None:
        """Show the region of a half width around a centre, to one scale on both axes."""
        half_height = half_width / self.aspect_ratio
        self.set(xlim=(centre[0] - half_width, centre[0] + half_width), ylim=(centre[1] - half_height, centre[1] + half_height))

    def draw_point(self, x: float, y: float, **style: Any) -> None:
        """Draw a round marker at a point."""
        self.plot([x], [y], "o", **style)

    def annotate_point(self, point: AxesPoint, label: str, offset: AxesPoint = (0, 0), **properties: Any) -> Annotation:
        """Write a label at `offset` points from a point of the panel, with a halo."""
        annotation = self.annotate(label, point, offset, textcoords="offset points", annotation_clip=False)
        text_style = {"color": INK, "fontsize": 10.5, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", "zorder": 9, **properties}
        annotation.set(**text_style)
        annotation.set_path_effects([_TEXT_HALO])
        return annotation


class Plate(Page):
    """Framed page with a heading above a scene title and the source, and captions by their positions."""

    def __init__(self, heading: str, title: str, source: str, captions: Mapping[tuple[float, float], str]) -> None:
        super().__init__(PLATE_WIDTH, PLATE_HEIGHT, PLATE_DPI)
        for inches, width in ((0.14, 1.8), (0.21, 0.6)):
            corner = inches / PLATE_WIDTH, inches / PLATE_HEIGHT
            box = Rectangle(corner, 1 - 2 * corner[0], 1 - 2 * corner[1], transform=self.transFigure)
            box.set(fill=False, edgecolor=INK, linewidth=width)
            self.add_artist(box)
        self.write_text(0.5, 0.937, heading, 22, ha="center", va="center")
        short_title = textwrap.shorten(title, _MAX_TITLE_LETTERS, placeholder=" …")
        self.write_text(0.5, 0.901, f"{short_title}; {source}", 11.5, ha="center", va="center", color=MUTED, parse_math=False)
        for (x, y), caption in captions.items():
            self.write_text(x, y, caption, 11.5, fontstyle="italic")

    def write_text(self, x: float, y: float, text: str, size: float, **properties: Any) -> Text:
        """Write serif text with formulas between dollars at a position in fractions of the plate."""
        text_style = {"color": INK, "fontfamily": SERIF_FONT, "math_fontfamily": "stix", **properties}
        return self.text(x, y, text, fontsize=size, **text_style)

    def write_dimensions(self, text: str, x: float = 0.5, y: float = 0.043) -> None:
        """Write dimensions centred at a position below the panels, with typographic minus signs."""
        self.write_text(x, y, text.replace(" -", " −"), 10.5, ha="center", color=MUTED)

    def add_plate_panel(self, rect: PanelRect, labels: tuple[str, str] | None = None) -> PlatePanel:
        """Add a panel with labelled axes, or without axes."""
        panel = PlatePanel(self, rect)
        self.add_axes(panel)
        if labels is None:
            panel.set_axis_off()
        else:
            panel.style(grid=None)
            panel.label(*labels, size=10.5, math_fontfamily="stix")
        return panel


def polar_points(angles: ArrayLike, lengths: ArrayLike, centre: AxesPoint = (0.0, 0.0)) -> AxesPoint:
    """Return points (n,), (n,) at lengths and angles (rad) from a centre."""
    return centre[0] + np.multiply(lengths, np.cos(angles)), centre[1] + np.multiply(lengths, np.sin(angles))

"""Common parts of all figures: pages with titles and notes, panels with quiet axes, PNG files."""

import os
from pathlib import Path
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.gridspec import SubplotSpec
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FuncFormatter, NullFormatter

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.render.style import INK, MUTED, PAPER, RULE, SANS_FONT, SERIF_FONT

FIGURE_DPI = 100
"""Resolution of figures, dots per inch."""

PanelRect = tuple[float, float, float, float]
"""Left and lower edge, width and height of a panel, in fractions of the figure."""


def require_png(path: str | os.PathLike[str]) -> Path:
    """Return the path of a figure; raise MechanismError unless the name ends in .png."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    return target


class Panel(Axes):
    """Axes with quiet lines, serif labels, and notes in a small font."""

    def style(
        self,
        *,
        tick_colour: str = MUTED,
        tick_size: float = 8.0,
        which: Literal["major", "both"] = "major",
        grid: Literal["both", "x"] | None = "both",
        is_grid_below: bool = True,
    ) -> None:
        """Style the panel with two spines, small tick labels of a colour, and a grid."""
        self.set_facecolor(PAPER)
        for side, spine in self.spines.items():
            spine.set(visible=side in ("left", "bottom"), color=MUTED, linewidth=0.8)
        self.tick_params(which=which, color=MUTED, labelcolor=tick_colour, labelsize=tick_size, labelfontfamily=SANS_FONT)
        if grid:
            self.grid(axis=grid, color=RULE, linewidth=0.6)
            if is_grid_below:
                self.set_axisbelow(True)

    def label(self, x_label: str = "", y_label: str = "", *, size: float = 10.0, **style: Any) -> None:
        """Write serif labels of the axes."""
        style = {"color": INK, "fontsize": size, "fontfamily": SERIF_FONT, **style}
        self.set_xlabel(x_label, **style)
        self.set_ylabel(y_label, **style)

    def write_note(
        self, text: str, point: tuple[float, float], offset: tuple[float, float] = (0, 0), *, xycoords: Any = "data", **style: Any
    ) -> Annotation:
        """Write a small text at an offset (points) from a point of the panel."""
        note = self.annotate(text, point, offset, xycoords=xycoords, textcoords="offset points")
        note.set(**{"fontsize": 8.5, "fontfamily": SANS_FONT, "parse_math": False, **style})
        return note

    def write_heading(self, heading: str, *, y: float, size: float = 11.0) -> None:
        """Write a heading above the left end of the panel, at a height in fractions of the panel."""
        self.text(0.0, y, heading, transform=self.transAxes, color=INK, fontsize=size, fontfamily=SERIF_FONT, parse_math=False)


class Page(Figure):
    """Figure of a width and height in inches, with titles, footnotes and panels."""

    def __init__(self, width: float, height: float, dpi: float = FIGURE_DPI) -> None:
        super().__init__(figsize=(width, height), dpi=dpi, facecolor=PAPER)

    def add_panel(
        self, place: PanelRect | SubplotSpec, x_label: str = "", y_label: str = "", *, label_size: float = 10.0, **style: Any
    ) -> Panel:
        """Add a panel at a rectangle or in a cell of a grid, with its labels and style."""
        panel = Panel(self, place.get_position(self) if isinstance(place, SubplotSpec) else place)
        self.add_axes(panel)
        panel.style(**style)
        panel.label(x_label, y_label, size=label_size)
        return panel

    def write_title(self, title: str, *, x: float = 0.02, y: float = 0.945, size: float = 15.0, colour: str = INK) -> None:
        """Write a title or subtitle at a position in fractions of the page."""
        self.text(x, y, title, fontsize=size, va="center", color=colour, fontfamily=SERIF_FONT, parse_math=False)

    def write_footnote(self, text: str, *, x: float = 0.02, y: float = 0.018, size: float = 7.5, **style: Any) -> Text:
        """Write a small text at a position in fractions of the page."""
        return self.text(x, y, text, **{"color": MUTED, "fontsize": size, "fontfamily": SANS_FONT, "parse_math": False, **style})

    def save_png(self, path: str | os.PathLike[str]) -> Path:
        """Write the page as a PNG and return its path; an exception leaves no file behind.

        Raises MechanismError unless the name ends in .png.
        """
        target = require_png(path)
        with atomic_write(target) as temporary:
            # Without the program name in the metadata, equal figures give equal files.
            canvas: Any = FigureCanvasAgg(self)
            canvas.print_png(str(temporary), metadata={"Software": None})
        return target


def add_legend(parent: Axes | Figure, text_style: dict[str, Any] | None = None, **properties: Any) -> None:
    """Add a legend without a frame to a panel or a page, with its texts in a style."""
    for text in parent.legend(**{"frameon": False, **properties}).get_texts():
        text.set(**(text_style or {}))


def use_plain_decades(*axes: Any) -> None:
    """Write plain numbers at the decades of logarithmic axes, and none between them."""
    for axis in axes:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())

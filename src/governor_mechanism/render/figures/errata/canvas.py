"""The page of a figure of an erratum: small, so that its letters are legible at 480 pixels of width, and fine enough to be enlarged."""

from governor_mechanism.render.figures.page import Page, Panel, PanelRect
from governor_mechanism.render.style import INK, MUTED

WIDTH, HEIGHT, DPI = 5.6, 3.9, 180
"""Width and height, inches, and resolution, dots per inch: 1008 by 702 pixels."""

TEXT_SIZE = 10.0
"""Size of the texts, points."""


def new_page(title: str, subtitle: str) -> Page:
    """Return an empty page with a title and a line below it."""
    page = Page(WIDTH, HEIGHT, dpi=DPI)
    page.write_title(title, y=0.94, size=14.5)
    page.write_title(subtitle, y=0.868, size=10.0, colour=MUTED)
    return page


def add_panel(page: Page, rect: PanelRect, x_label: str, y_label: str) -> Panel:
    """Add a panel with large labels."""
    return page.add_panel(rect, x_label, y_label, label_size=11.0, tick_size=9.5, tick_colour=INK)

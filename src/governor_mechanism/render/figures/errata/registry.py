"""The figure of the main error of each paper."""

from collections.abc import Callable, Mapping

from governor_mechanism.render.figures.errata.bell_crank import draw_bell_crank
from governor_mechanism.render.figures.errata.cylinder_ends import draw_cylinder_ends
from governor_mechanism.render.figures.errata.flywheel import draw_flywheel
from governor_mechanism.render.figures.errata.osculation import draw_osculation
from governor_mechanism.render.figures.page import Page
from governor_mechanism.studies.errata.erratum import Paper

DRAWINGS: Mapping[Paper, Callable[[], Page]] = {
    Paper.REDTENBACHER: draw_flywheel,
    Paper.ZEHNDER: draw_osculation,
    Paper.MARKS: draw_cylinder_ends,
    Paper.DUBOIS: draw_bell_crank,
}
"""Function that draws the main error, by paper."""


def draw_erratum(paper: Paper) -> Page:
    """Draw the main error of a paper.

    Result: the figure; `save` writes it.
    """
    return DRAWINGS[paper]()

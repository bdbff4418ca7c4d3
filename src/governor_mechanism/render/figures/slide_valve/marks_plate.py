"""Marks' plate: the error term of the eccentric rod as parabola, circle and hyperbola, and three other diagrams."""

from __future__ import annotations

import math
import os
from pathlib import Path

from matplotlib.figure import Figure

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.engraving_sheet import MM_PER_M, new_plate, write_text
from governor_mechanism.render.figures.page import require_png, save_png
from governor_mechanism.render.figures.slide_valve.marks_panels import (
    draw_approximation_errors,
    draw_error_construction,
    draw_reuleaux_diagram,
    draw_valve_ellipse,
)
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValveDiagramData, valve_diagram_data
from governor_mechanism.render.figures.slide_valve.zeuner_plate import MARKS_SOURCE
from governor_mechanism.render.style import MUTED

_HEADING = "Marks’ construction of the error term"

_PANEL_RECTS = {
    "construction": (0.03, 0.505, 0.47, 0.335),
    "errors": (0.60, 0.545, 0.355, 0.285),
    "ellipse": (0.068, 0.125, 0.40, 0.305),
    "reuleaux": (0.565, 0.085, 0.40, 0.355),
}
"""Left and lower edge, width and height of the panels, in fractions of the figure."""


def marks_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Marks' plate for the scene of a slide valve with a finite eccentric rod, and return its path.

    Raises MechanismError for another machine and for an infinite eccentric rod. An exception leaves no file behind.
    """
    require_png(path)
    return save_png(draw_marks_plate(valve_diagram_data(scene)), path)


def draw_marks_plate(data: ValveDiagramData) -> Figure:
    """Return the plate as a figure; raise MechanismError for an infinite eccentric rod, which has no error term."""
    if data.eccentric.has_infinite_rod:
        raise MechanismError("Marks' construction needs a finite eccentric_rod; an infinite one has no error term")
    figure = new_plate(_HEADING, data.title, MARKS_SOURCE)
    captions = (
        "Fig. 1.  On any crank ray $OP$ the displacement is larger by the ordinate $z$ of the curve",
        "Fig. 2.  Errors of parabola and circle",
        "Fig. 3.  The valve’s ellipse: its displacement over the stroke of the piston",
        "Fig. 4.  Reuleaux’s circle, theory: $\\xi_0$ is the distance from an inclined diameter",
    )
    for k, caption in enumerate(captions):
        write_text(figure, (0.03, 0.545)[k % 2], (0.862, 0.462)[k // 2], caption, 11.5, fontstyle="italic")
    draw_error_construction(figure.add_axes(_PANEL_RECTS["construction"]), data)
    draw_approximation_errors(figure.add_axes(_PANEL_RECTS["errors"]), data)
    draw_valve_ellipse(figure.add_axes(_PANEL_RECTS["ellipse"]), data)
    draw_reuleaux_diagram(figure.add_axes(_PANEL_RECTS["reuleaux"]), data)
    r, rod = data.eccentric.radius, data.eccentric.rod
    text = (
        f"eccentric $r$ = {r * MM_PER_M:.4g} mm,  rod $l$ = {rod * MM_PER_M:.5g} mm,  advance $\\delta$ = "
        f"{math.degrees(data.eccentric.advance):.4g}°;  neglected terms are of order $r^4/8l^3$ = "
        f"{r**4 / (8 * rod**3) * MM_PER_M:.3g} mm"
    )
    write_text(figure, 0.5, 0.043, text.replace("= -", "= −"), 10.5, ha="center", color=MUTED)
    return figure

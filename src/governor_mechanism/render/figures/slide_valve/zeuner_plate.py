"""Zeuner's plate: the polar diagram of a slide valve, simulated curves over the theoretical circles, and the steam phases."""

from __future__ import annotations

import math
import os
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.engraving_sheet import MM_PER_M, PLATE_HEIGHT, PLATE_WIDTH, new_plate, write_text
from governor_mechanism.render.figures.page import require_png, save_png
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValveDiagramData, valve_diagram_data
from governor_mechanism.render.figures.slide_valve.zeuner_panels import CYLINDER_ENDS, draw_polar_diagram, draw_stroke_diagram
from governor_mechanism.render.style import INK, MUTED, RULE, SERIF_FONT
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent

MARKS_SOURCE = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"
_HEADING = "Zeuner’s diagram of the slide valve"

_POLAR_RECT = (0.028, 0.07, 0.545, 0.785)
_STROKES_RECT = (0.645, 0.115, 0.287, 0.205)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_COLUMN_POSITIONS = (0.605, 0.742, 0.805, 0.866, 0.917, 0.965)
"""Left edge of the first column of the table, right edges of the others, in fractions of the figure."""


def zeuner_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Zeuner's plate for the scene of a slide valve, and return its path.

    Raises MechanismError for another machine. An exception leaves no file behind.
    """
    require_png(path)
    return save_png(draw_zeuner_plate(valve_diagram_data(scene)), path)


def draw_zeuner_plate(data: ValveDiagramData) -> Figure:
    """Return the plate as a figure."""
    figure = new_plate(_HEADING, data.title, MARKS_SOURCE)
    caption = "Fig. 1.  Valve displacement on the crank ray: circle by theory, bold curve by the mechanism"
    write_text(figure, 0.03, 0.862, caption, 11.5, fontstyle="italic")
    draw_polar_diagram(figure.add_axes(_POLAR_RECT), data, _POLAR_RECT[2] * PLATE_WIDTH / (_POLAR_RECT[3] * PLATE_HEIGHT))
    _write_event_table(figure, data)
    write_text(figure, 0.605, 0.36, "Fig. 2.  Steam phases over the stroke", 11.5, fontstyle="italic")
    draw_stroke_diagram(figure.add_axes(_STROKES_RECT), data)
    _write_dimensions(figure, data)
    return figure


def _write_event_table(figure: Figure, data: ValveDiagramData) -> None:
    """Write the table of valve events by cylinder end."""
    top, row_height = 0.862, 0.036
    write_text(figure, _COLUMN_POSITIONS[0], top, "Valve events of the mechanism", 11.5, fontstyle="italic")
    column_headings = ("crank", "theory", "shift", "stroke", "theory")
    for x, column_heading, unit in zip(_COLUMN_POSITIONS[1:], column_headings, ("deg", "deg", "deg", "%", "%"), strict=True):
        write_text(figure, x, top - 0.036, column_heading, 10.5, ha="right", color=MUTED)
        write_text(figure, x, top - 0.056, unit, 8.5, ha="right", color=MUTED)
    _draw_rule(figure, top - 0.064)
    y = top - 0.09
    for end, _, colour in CYLINDER_ENDS:
        write_text(figure, _COLUMN_POSITIONS[0], y, end, 11, color=colour, fontstyle="italic")
        for event in data.events.rows:
            if event.name.startswith(end):
                y -= row_height
                _write_event_row(figure, y, event, colour)
        y -= row_height + 0.008
    _draw_rule(figure, y + row_height - 0.006)


def _write_event_row(figure: Figure, y: float, event: ValveEvent, colour: str) -> None:
    write_text(figure, _COLUMN_POSITIONS[0] + 0.012, y, event.name.rsplit(" ", 1)[1], 11.5, color=colour)
    numbers = (
        f"{math.degrees(event.simulated):.3f}",
        f"{math.degrees(event.theory):.3f}",
        f"{math.degrees(event.shift):+.3f}".replace("-", "−"),
        f"{100 * event.simulated_stroke:.2f}",
        f"{100 * event.theory_stroke:.2f}",
    )
    for k, (x, number) in enumerate(zip(_COLUMN_POSITIONS[1:], numbers, strict=True)):
        write_text(figure, x, y, number, 11.5, ha="right", color=MUTED if k in (1, 4) else INK)


def _draw_rule(figure: Figure, y: float) -> None:
    figure.add_artist(Line2D([_COLUMN_POSITIONS[0], _COLUMN_POSITIONS[-1]], [y, y], color=RULE, linewidth=1.0))


def _write_dimensions(figure: Figure, data: ValveDiagramData) -> None:
    """Write the dimensions of the valve gear below the diagram."""
    eccentric, crank_train = data.eccentric, data.crank_train
    rods = [
        f"${name}$ = {'∞' if math.isinf(value) else f'{value * MM_PER_M:.5g} mm'}"
        for name, value in (("l", eccentric.rod), ("L", crank_train.rod))
    ]
    leads = " and ".join(f"{lead * MM_PER_M:.4g}" for lead in data.events.leads)
    text = (
        f"eccentric $r$ = {eccentric.radius * MM_PER_M:.4g} mm,  rod {rods[0]},  advance $\\delta$ = "
        f"{math.degrees(eccentric.advance):.4g}°,  laps $e$ = {data.outside_lap * MM_PER_M:.4g}, $i$ = "
        f"{data.inside_lap * MM_PER_M:.4g} mm,  crank $R$ = {crank_train.crank * MM_PER_M:.4g} mm,  rod {rods[1]};  leads {leads} mm"
    )
    write_text(figure, 0.5, 0.043, text.replace(" -", " −"), 10.5, ha="center", color=MUTED, fontfamily=SERIF_FONT)

"""Zeuner's plate: the polar diagram of a slide valve, true curves over the theoretical circles, and what steam does."""

from __future__ import annotations

import math
import os
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.engraving_sheet import HEIGHT, MM, WIDTH, require_png, save, sheet, write
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValvePlate, valve_plate
from governor_mechanism.render.figures.slide_valve.zeuner_panels import CRANK_END, HEAD_END, draw_polar, draw_strokes
from governor_mechanism.render.style import INK, QUIET, RULE, SERIF
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent

SOURCE = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"
HEADING = "Zeuner’s diagram of the slide valve"

POLAR = (0.028, 0.07, 0.545, 0.785)
STROKES = (0.645, 0.115, 0.287, 0.205)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

COLUMNS = (0.605, 0.742, 0.805, 0.866, 0.917, 0.965)
"""Where the columns of the table stand: the first begins, the others end there."""


def zeuner_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Zeuner's plate for the scene of a slide valve.

    Returns the path. Raises MechanismError for another machine; an exception leaves no file behind.
    """
    require_png(path)
    return save(draw(valve_plate(scene)), path)


def draw(plate: ValvePlate) -> Figure:
    """The plate as a figure."""
    figure = sheet(HEADING, plate.title, SOURCE)
    caption = (
        "Fig. 1.  The valve’s displacement on the ray of the crank: on a circle by theory, in truth on the bold curve"
    )
    write(figure, 0.03, 0.862, caption, 11.5, fontstyle="italic")
    draw_polar(figure.add_axes(POLAR), plate, POLAR[2] * WIDTH / (POLAR[3] * HEIGHT))
    _table(figure, plate)
    write(figure, 0.605, 0.36, "Fig. 2.  What the steam does over the stroke", 11.5, fontstyle="italic")
    draw_strokes(figure.add_axes(STROKES), plate)
    _sizes(figure, plate)
    return figure


def _table(figure: Figure, plate: ValvePlate) -> None:
    """The events in numbers, by cylinder ends."""
    top, row = 0.862, 0.036
    write(figure, COLUMNS[0], top, "The events of steam on the mechanism", 11.5, fontstyle="italic")
    heads = ("crank", "theory", "later by", "stroke", "theory")
    for x, head, unit in zip(COLUMNS[1:], heads, ("deg", "deg", "deg", "%", "%"), strict=True):
        write(figure, x, top - 0.036, head, 10.5, ha="right", color=QUIET)
        write(figure, x, top - 0.056, unit, 8.5, ha="right", color=QUIET)
    _rule(figure, top - 0.064)
    y = top - 0.09
    for end, colour in (("crank end", CRANK_END), ("head end", HEAD_END)):
        write(figure, COLUMNS[0], y, end, 11, color=colour, fontstyle="italic")
        for event in plate.events.rows:
            if event.name.startswith(end):
                y -= row
                _line(figure, y, event, colour)
        y -= row + 0.008
    _rule(figure, y + row - 0.006)


def _line(figure: Figure, y: float, event: ValveEvent, colour: str) -> None:
    write(figure, COLUMNS[0] + 0.012, y, event.name.rsplit(" ", 1)[1], 11.5, color=colour)
    numbers = (
        f"{math.degrees(event.simulated):.3f}",
        f"{math.degrees(event.theory):.3f}",
        f"{math.degrees(event.shift):+.3f}".replace("-", "−"),
        f"{100 * event.simulated_stroke:.2f}",
        f"{100 * event.theory_stroke:.2f}",
    )
    for k, (x, number) in enumerate(zip(COLUMNS[1:], numbers, strict=True)):
        write(figure, x, y, number, 11.5, ha="right", color=QUIET if k in (1, 4) else INK)


def _rule(figure: Figure, y: float) -> None:
    figure.add_artist(Line2D([COLUMNS[0], COLUMNS[-1]], [y, y], color=RULE, linewidth=1.0))


def _sizes(figure: Figure, plate: ValvePlate) -> None:
    """The gear in numbers, beneath the diagram."""
    eccentric, train = plate.eccentric, plate.train
    rods = [
        f"${name}$ = {'∞' if math.isinf(value) else f'{value * MM:.5g} mm'}"
        for name, value in (("l", eccentric.rod), ("L", train.rod))
    ]
    leads = " and ".join(f"{lead * MM:.4g}" for lead in plate.events.leads)
    words = (
        f"eccentric $r$ = {eccentric.radius * MM:.4g} mm,  rod {rods[0]},  advance $\\delta$ = "
        f"{math.degrees(eccentric.advance):.4g}°,  laps $e$ = {plate.outside_lap * MM:.4g}, $i$ = "
        f"{plate.inside_lap * MM:.4g} mm,  crank $R$ = {train.crank * MM:.4g} mm,  rod {rods[1]};  leads {leads} mm"
    )
    write(figure, 0.5, 0.043, words.replace(" -", " −"), 10.5, ha="center", color=QUIET, fontfamily=SERIF)

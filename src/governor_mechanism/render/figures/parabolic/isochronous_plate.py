"""Zehnder's plate: the isochronous parabolas with the ball's circle, and the speeds on leaving the start point."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.engraving_sheet import HEIGHT, WIDTH, require_png, save, sheet, write
from governor_mechanism.render.figures.parabolic.isochronous_data import SHARES, Plate, has_parabolas, plate_of
from governor_mechanism.render.figures.parabolic.isochronous_panels import ARMS, draw_family, draw_leaving
from governor_mechanism.render.style import QUIET, VERMILLION

__all__ = ["draw", "has_parabolas", "parabolas_figure"]

LEFT, RIGHT = (0.058, 0.135, 0.502, 0.71), (0.658, 0.475, 0.268, 0.37)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

HEADING = "The isochronous parabolas and the governor’s circle"
SOURCE = "after L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1–14"
CAPTIONS = (
    "Fig. 1.  On each parabola $x^2 = c\\,y$, $c = 2g\\,(1+m)/\\omega^2$, a ball rests anywhere at one speed",
    "Fig. 2.  Leaving the start point on a circle",
)

VERDICTS = {
    1.0: ("lower going down, higher going up: of use both ways", "least at the start, higher both ways: of use upward"),
    1.3: ("lower both ways: of use downward only", "lower going up, higher going down: unstable here"),
    0.7: ("higher both ways: of use upward only", "higher going up, lower going down: of use both ways"),
}
"""By arm as a share of the radius of curvature: the speeds in Zehnder's text on leaving the start, and in truth."""

REASON = (
    "Zehnder judged by the parabola on which the ball comes to sit. But rest asks",
    "for the slope of the ball’s path, $\\tan\\,\\alpha = \\omega^2 x\\,/\\,g\\,(1+m)$, and not for its height.",
    "His advice holds all the same: take $l \\leq \\rho$, start lowest, and use the arc upward.",
)


def parabolas_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Zehnder's plate for a scene that has_parabolas.

    Returns the path. Raises MechanismError for another scene; an exception leaves no file behind.
    """
    require_png(path)
    return save(draw(plate_of(scene), scene.title), path)


def draw(plate: Plate, title: str) -> Figure:
    """The plate as a figure of WIDTH by HEIGHT inches."""
    figure = sheet(HEADING, title, SOURCE)
    for x, caption in zip((0.03, 0.605), CAPTIONS, strict=True):
        write(figure, x, 0.862, caption, 11.5, fontstyle="italic")
    draw_family(figure.add_axes(LEFT), plate, (LEFT[2] * WIDTH) / (LEFT[3] * HEIGHT))
    draw_leaving(figure.add_axes(RIGHT), plate)
    _dimensions(figure, plate)
    _verdicts(figure)
    return figure


def _dimensions(figure: Figure, plate: Plate) -> None:
    """The governor and its start point in numbers, beneath the left panel."""
    x, y = (1e3 * value for value in plate.start)
    governor = (
        f"arm $l$ = {plate.arm * 1e3:.4g} mm,  suspension $e$ = {plate.offset * 1e3:.4g} mm from the axis,  "
        f"$m = Q/P$ = {plate.mass_ratio:.3g},  $g$ = {plate.gravity:.4g} m/s²"
    )
    point = (
        f"{'osculation' if plate.osculates else 'start'} point $x_1$ = {x:.1f} mm,  $y_1$ = {y:.1f} mm,  "
        f"$\\alpha_1$ = {math.degrees(plate.start_angle):.2f}°,  {plate.start_speed * 30 / math.pi:.4g} rpm;  "
        f"circle of curvature (broken): $\\rho$ = {plate.radius * 1e3:.4g} mm"
    )
    for line, words in enumerate((governor, point)):
        write(figure, 0.309, 0.067 - 0.026 * line, words.replace("= -", "= −"), 10.5, ha="center", color=QUIET)


def _verdicts(figure: Figure) -> None:
    """What Zehnder's text says, struck out, and what is true, beneath the right panel."""
    edge, words, top, row = 0.605, 0.688, 0.36, 0.058
    write(figure, edge, top + 0.04, "Speeds of rest on leaving the start:", 11.5, fontstyle="italic")
    _strike(figure, write(figure, 0.79, top + 0.04, "as Zehnder read", 11.5, fontstyle="italic", color=QUIET))
    write(figure, 0.89, top + 0.04, "and as they are", 11.5, fontstyle="italic")
    for k, share in enumerate(SHARES):
        arm, y = ARMS[share], top - k * row
        figure.add_artist(Line2D([edge, edge + 0.018], [y - 0.003] * 2, color=arm.colour, linewidth=2))
        write(figure, edge + 0.024, y - 0.01, arm.name, 13, color=arm.colour)
        wrong, right = VERDICTS[share]
        _strike(figure, write(figure, words, y + 0.003, wrong, 11, color=QUIET))
        write(figure, words, y - 0.021, right, 11.5)
    for line, reason in enumerate(REASON):
        write(figure, edge, 0.142 - 0.031 * line, reason, 11)


def _strike(figure: Figure, text: Text) -> None:
    """A line through the words, as on a corrected proof."""
    canvas: Any = FigureCanvasAgg(figure)
    box = text.get_window_extent(canvas.get_renderer()).transformed(figure.transFigure.inverted())
    middle = box.y0 + 0.45 * box.height
    figure.add_artist(Line2D([box.x0 - 0.003, box.x1 + 0.003], [middle, middle], color=VERMILLION, linewidth=1.2))

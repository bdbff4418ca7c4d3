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
from governor_mechanism.render.figures.engraving_sheet import PLATE_HEIGHT, PLATE_WIDTH, new_plate, require_png, save_plate, write_text
from governor_mechanism.render.figures.parabolic.isochronous_data import (
    ARM_RATIOS,
    IsochronousPlateData,
    has_isochronous_parabolas,
    isochronous_plate_data,
)
from governor_mechanism.render.figures.parabolic.isochronous_panels import ARM_STYLES, draw_parabola_family, draw_speed_deviations
from governor_mechanism.render.style import MUTED, VERMILLION

__all__ = ["draw_isochronous_plate", "has_isochronous_parabolas", "isochronous_figure"]

_FAMILY_RECT, _DEVIATION_RECT = (0.058, 0.135, 0.502, 0.71), (0.658, 0.475, 0.268, 0.37)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_HEADING = "The isochronous parabolas and the governor’s circle"
_SOURCE = "after L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1–14"
_CAPTIONS = (
    "Fig. 1.  On each parabola $x^2 = c\\,y$, $c = 2g\\,(1+m)/\\omega^2$, a ball rests anywhere at one speed",
    "Fig. 2.  Leaving the start point on a circle",
)

ZEHNDER_VERDICTS = {
    1.0: ("lower going down, higher going up: of use both ways", "least at the start, higher both ways: of use upward"),
    1.3: ("lower both ways: of use downward only", "lower going up, higher going down: unstable here"),
    0.7: ("higher both ways: of use upward only", "higher going up, lower going down: of use both ways"),
}
"""By arm as a share of the radius of curvature: the speeds in Zehnder's text on leaving the start, and in truth."""

_REASON = (
    "Zehnder judged by the parabola on which the ball comes to sit. But rest asks",
    "for the slope of the ball’s path, $\\tan\\,\\alpha = \\omega^2 x\\,/\\,g\\,(1+m)$, and not for its height.",
    "His advice holds all the same: take $l \\leq \\rho$, start lowest, and use the arc upward.",
)


def isochronous_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Zehnder's plate for a scene that has_parabolas.

    Returns the path. Raises MechanismError for another scene; an exception leaves no file behind.
    """
    require_png(path)
    return save_plate(draw_isochronous_plate(isochronous_plate_data(scene), scene.title), path)


def draw_isochronous_plate(data: IsochronousPlateData, title: str) -> Figure:
    """The plate as a figure of WIDTH by HEIGHT inches."""
    figure = new_plate(_HEADING, title, _SOURCE)
    for x, caption in zip((0.03, 0.605), _CAPTIONS, strict=True):
        write_text(figure, x, 0.862, caption, 11.5, fontstyle="italic")
    draw_parabola_family(figure.add_axes(_FAMILY_RECT), data, (_FAMILY_RECT[2] * PLATE_WIDTH) / (_FAMILY_RECT[3] * PLATE_HEIGHT))
    draw_speed_deviations(figure.add_axes(_DEVIATION_RECT), data)
    _write_dimensions(figure, data)
    _write_verdicts(figure)
    return figure


def _write_dimensions(figure: Figure, data: IsochronousPlateData) -> None:
    """The governor and its start point in numbers, beneath the left panel."""
    x, y = (1e3 * value for value in data.start_point)
    governor = (
        f"arm $l$ = {data.arm * 1e3:.4g} mm,  suspension $e$ = {data.offset * 1e3:.4g} mm from the axis,  "
        f"$m = Q/P$ = {data.mass_ratio:.3g},  $g$ = {data.gravity:.4g} m/s²"
    )
    point = (
        f"{'osculation' if data.starts_at_osculation else 'start'} point $x_1$ = {x:.1f} mm,  $y_1$ = {y:.1f} mm,  "
        f"$\\alpha_1$ = {math.degrees(data.start_angle):.2f}°,  {data.start_speed * 30 / math.pi:.4g} rpm;  "
        f"circle of curvature (broken): $\\rho$ = {data.radius_of_curvature * 1e3:.4g} mm"
    )
    for line, words in enumerate((governor, point)):
        write_text(figure, 0.309, 0.067 - 0.026 * line, words.replace("= -", "= −"), 10.5, ha="center", color=MUTED)


def _write_verdicts(figure: Figure) -> None:
    """What Zehnder's text says, struck out, and what is true, beneath the right panel."""
    left, text_left, top, row = 0.605, 0.688, 0.36, 0.058
    write_text(figure, left, top + 0.04, "Speeds of rest on leaving the start:", 11.5, fontstyle="italic")
    _strike_out(figure, write_text(figure, 0.79, top + 0.04, "as Zehnder read", 11.5, fontstyle="italic", color=MUTED))
    write_text(figure, 0.89, top + 0.04, "and as they are", 11.5, fontstyle="italic")
    for k, arm_ratio in enumerate(ARM_RATIOS):
        arm, y = ARM_STYLES[arm_ratio], top - k * row
        figure.add_artist(Line2D([left, left + 0.018], [y - 0.003] * 2, color=arm.colour, linewidth=2))
        write_text(figure, left + 0.024, y - 0.01, arm.name, 13, color=arm.colour)
        zehnder_text, correct_text = ZEHNDER_VERDICTS[arm_ratio]
        _strike_out(figure, write_text(figure, text_left, y + 0.003, zehnder_text, 11, color=MUTED))
        write_text(figure, text_left, y - 0.021, correct_text, 11.5)
    for line, reason in enumerate(_REASON):
        write_text(figure, left, 0.142 - 0.031 * line, reason, 11)


def _strike_out(figure: Figure, text: Text) -> None:
    """A line through the words, as on a corrected proof."""
    canvas: Any = FigureCanvasAgg(figure)
    box = text.get_window_extent(canvas.get_renderer()).transformed(figure.transFigure.inverted())
    middle = box.y0 + 0.45 * box.height
    figure.add_artist(Line2D([box.x0 - 0.003, box.x1 + 0.003], [middle, middle], color=VERMILLION, linewidth=1.2))

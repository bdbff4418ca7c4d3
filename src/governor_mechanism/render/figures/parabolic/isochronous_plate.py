"""Zehnder's plate: isochronous parabolas with the circle of the ball, and the speed deviations near the start point."""

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
from governor_mechanism.render.figures.engraving_sheet import PLATE_HEIGHT, PLATE_WIDTH, new_plate, write_text
from governor_mechanism.render.figures.page import save_png
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
    "Fig. 1.  On each parabola $x^2 = c\\,y$, $c = 2g\\,(1+m)/\\omega^2$, a ball is in equilibrium at one speed",
    "Fig. 2.  Speed deviation on a circle through the start point",
)

ZEHNDER_VERDICTS = {
    1.0: ("lower below, higher above: usable both ways", "minimum at the start: usable upward"),
    1.3: ("lower both ways: usable downward only", "lower above, higher below: unstable here"),
    0.7: ("higher both ways: usable upward only", "higher above, lower below: usable both ways"),
}
"""Speed deviations near the start point in Zehnder's text and in fact, by ratio of the arm to the radius of curvature."""

_REASON = (
    "Zehnder compared the parabolas through the ball. Equilibrium depends",
    "on the slope of the ball’s path, $\\tan\\,\\alpha = \\omega^2 x\\,/\\,g\\,(1+m)$, not on its height.",
    "His advice is still correct: $l \\leq \\rho$, start at the lowest point, use the arc above it.",
)


def isochronous_figure(scene: Scene, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of Zehnder's plate for a scene with isochronous parabolas (`has_isochronous_parabolas`).

    An exception leaves no file behind.

    Parameters
    ----------
    scene
        Scene of a rhombic pendulum governor; another scene raises MechanismError.
    path
        File to write; another ending than .png raises MechanismError.

    Returns
    -------
    Path
        The path of the file.
    """
    return save_png(draw_isochronous_plate(isochronous_plate_data(scene), scene.title), path)


def draw_isochronous_plate(data: IsochronousPlateData, title: str) -> Figure:
    """Return the plate as a figure of PLATE_WIDTH by PLATE_HEIGHT inches."""
    figure = new_plate(_HEADING, title, _SOURCE)
    for x, caption in zip((0.03, 0.605), _CAPTIONS, strict=True):
        write_text(figure, x, 0.862, caption, 11.5, fontstyle="italic")
    draw_parabola_family(figure.add_axes(_FAMILY_RECT), data, (_FAMILY_RECT[2] * PLATE_WIDTH) / (_FAMILY_RECT[3] * PLATE_HEIGHT))
    draw_speed_deviations(figure.add_axes(_DEVIATION_RECT), data)
    _write_dimensions(figure, data)
    _write_verdicts(figure)
    return figure


def _write_dimensions(figure: Figure, data: IsochronousPlateData) -> None:
    """Write the dimensions of the governor and its start point below the left panel."""
    x, y = (1e3 * value for value in data.start_point)
    governor = (
        f"arm $l$ = {data.arm * 1e3:.4g} mm,  suspension $e$ = {data.offset * 1e3:.4g} mm from the axis,  "
        f"$m = Q/P$ = {data.mass_ratio:.3g},  $g$ = {data.gravity:.4g} m/s²"
    )
    point = (
        f"{'osculation' if data.starts_at_osculation else 'start'} point $x_1$ = {x:.1f} mm,  $y_1$ = {y:.1f} mm,  "
        f"$\\alpha_1$ = {math.degrees(data.start_angle):.2f}°,  {data.start_speed * 30 / math.pi:.4g} rpm;  "
        f"circle of curvature (dashed): $\\rho$ = {data.radius_of_curvature * 1e3:.4g} mm"
    )
    for line, text in enumerate((governor, point)):
        write_text(figure, 0.309, 0.067 - 0.026 * line, text.replace("= -", "= −"), 10.5, ha="center", color=MUTED)


def _write_verdicts(figure: Figure) -> None:
    """Write Zehnder's text, struck out, and the correct text below the right panel."""
    left, text_left, top, row = 0.605, 0.688, 0.36, 0.058
    write_text(figure, left, top + 0.04, "Equilibrium speeds near the start:", 11.5, fontstyle="italic")
    _strike_out(figure, write_text(figure, 0.79, top + 0.04, "by Zehnder", 11.5, fontstyle="italic", color=MUTED))
    write_text(figure, 0.89, top + 0.04, "correct", 11.5, fontstyle="italic")
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
    """Draw a line through a text, as on a corrected proof."""
    canvas: Any = FigureCanvasAgg(figure)
    box = text.get_window_extent(canvas.get_renderer()).transformed(figure.transFigure.inverted())
    middle = box.y0 + 0.45 * box.height
    figure.add_artist(Line2D([box.x0 - 0.003, box.x1 + 0.003], [middle, middle], color=VERMILLION, linewidth=1.2))

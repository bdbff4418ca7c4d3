"""Figure of Zehnder's statements on leaving the point of osculation: the speed of rest by his reasoning, and by equilibrium."""

import numpy as np

from governor_mechanism.closed_form import parabolic
from governor_mechanism.render.figures.errata.canvas import TEXT_SIZE, add_panel, new_page
from governor_mechanism.render.figures.page import DASHED, Page, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, SERIF_FONT, VERMILLION
from governor_mechanism.studies.design.pendulum import design_pendulum
from governor_mechanism.studies.errata.zehnder import LONGER, SHORTER
from governor_mechanism.types import FloatArray, FloatOrArray

_DEGREES: FloatArray = np.linspace(-4.0, 4.0, 161)
_COLOURS = {LONGER: VERMILLION, 1.0: GREEN, SHORTER: BLUE}


def draw_osculation() -> Page:
    """Draw the change of the speed of rest beside the point, for arms of three lengths."""
    start = design_pendulum().start
    page = new_page("Zehnder on leaving the point of osculation", "he looks at the parabola on which the ball sits; its slope decides")
    panel = add_panel(page, (0.125, 0.155, 0.695, 0.655), "Arm angle from the point of osculation [deg]", "Change of the speed of rest [%]")
    for ratio, colour in _COLOURS.items():
        path: dict[str, FloatOrArray] = {
            "start_angle": start.arm_angle,
            "start_abscissa": start.abscissa,
            "arm": ratio * start.radius_of_curvature,
            "angle_change": np.radians(_DEGREES),
        }
        true = 100 * np.asarray(parabolic.equilibrium_speed_change(**path))
        panel.plot(_DEGREES, true, color=colour, linewidth=2.2)
        panel.plot(_DEGREES, 100 * np.asarray(parabolic.parabola_speed_change(**path)), color=colour, linewidth=1.6, linestyle=DASHED)
        text = "$l = \\rho$" if ratio == 1.0 else f"$l = {ratio:g}\\,\\rho$"
        panel.annotate_point((4.0, float(true[-1])), text, (6, 0), color=colour, fontsize=TEXT_SIZE + 1.5, va="center")
    panel.axvline(0.0, color=INK, linewidth=0.8)
    panel.set(xlim=(-4, 4), ylim=(-3, 5.2))
    panel.plot([], [], color=INK, linewidth=2.2, label="true, by equilibrium")
    panel.plot([], [], color=INK, linewidth=1.6, linestyle=DASHED, label="Zehnder’s reasoning, in numbers")
    ground = {"frameon": True, "facecolor": PAPER, "edgecolor": "none", "framealpha": 1.0}
    add_legend(panel, {"fontfamily": SERIF_FONT}, fontsize=TEXT_SIZE, loc="upper right", labelcolor=INK, handlelength=2.6, **ground)
    for x, side, text in ((-3.9, "left", "below the point"), (3.9, "right", "above")):
        panel.annotate_point((x, -2.85), text, ha=side, fontsize=TEXT_SIZE, fontstyle="italic")
    return page

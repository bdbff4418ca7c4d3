"""Figure of Redtenbacher's flywheel: the speed over a turn with the printed and with the right wheel, and the band it should keep."""

import numpy as np

from governor_mechanism.closed_form.flywheel.equilibrium import shaft_speed
from governor_mechanism.closed_form.flywheel.wheel import speed_limits
from governor_mechanism.render.figures.errata.canvas import TEXT_SIZE, add_panel, new_page
from governor_mechanism.render.figures.page import DASHED, Page
from governor_mechanism.render.style import BLUE, GREEN, VERMILLION
from governor_mechanism.studies.design.flywheel import DEFAULT_ENERGY_RATIO, PAPER_INPUTS, closed_cycle
from governor_mechanism.studies.design.flywheel_paper import PAPER_ENGINE, compare_with_paper
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

_DEGREES: FloatArray = np.linspace(0.0, 360.0, 721)


def draw_flywheel() -> Page:
    """Draw the speed of the shaft over a turn."""
    comparison = compare_with_paper()
    light, right, closed = comparison.wheels
    engine, mean = closed_cycle(PAPER_ENGINE), PAPER_INPUTS.speed
    total = next(term for term in comparison.terms if term.quantity == "sum of the bracket")
    page = new_page(
        f"Redtenbacher’s flywheel is {100 * (1 - total.printed / total.recomputed):.0f} % too light",
        f"it leaves the band that µ = {DEFAULT_ENERGY_RATIO:g} allows; the right wheel needs {100 * (right.excess - 1):.0f} % more",
    )
    panel = add_panel(page, (0.135, 0.155, 0.835, 0.655), "Crank angle [deg]", "Speed of the shaft [rpm]")
    # The wheel that the closed cycle needs runs from edge to edge of the band.
    limits = {"inertia": closed.inertia, "energy": closed.bracket * engine.full_pressure_work, "mean_speed": mean}
    low, high = (float(speed) / RPM for speed in speed_limits(**limits, mean_energy=True))
    panel.axhspan(low, high, color=GREEN, alpha=0.14, linewidth=0)
    for wheel, colour, style in ((light, VERMILLION, "-"), (right, BLUE, DASHED)):
        speeds = shaft_speed(engine, crank_angle=np.radians(_DEGREES), inertia=wheel.inertia, mean_speed=mean)
        panel.plot(_DEGREES, np.asarray(speeds) / RPM, color=colour, linewidth=2.0, linestyle=style)
    panel.set(xlim=(0, 360), ylim=(low - 0.55, high + 0.75), xticks=range(0, 361, 45))
    texts = (
        ((95.8, high + 0.46), f"by the printed {total.printed:.4f}: {light.inertia:,.0f} kg m²", VERMILLION, "center"),
        ((190.0, (low + high) / 2), f"right:\n{right.inertia:,.0f} kg m²", BLUE, "center"),
        ((5.0, high - 0.12), "allowed band", GREEN, "left"),
    )
    for point, text, colour, side in texts:
        panel.annotate_point(point, text, color=colour, ha=side, fontsize=TEXT_SIZE + 0.5, va="bottom" if point[1] > high else "center")
    return page

"""Indicator diagrams: pressure over the travel of a piston."""

import numpy as np

from governor_mechanism.render.figures.page import CHAIN_DOTTED, Panel
from governor_mechanism.render.style import MUTED
from governor_mechanism.types import FloatArray

_PA_PER_BAR = 1e5


def draw_loop(panel: Panel, travel: FloatArray, upper: FloatArray, lower: FloatArray, colour: str) -> None:
    """Draw a closed loop of pressures (n,) in bar over travels (n,) in percent of the stroke, and shade its area."""
    panel.fill_between(travel, lower, upper, color=colour, alpha=0.13, linewidth=0, zorder=2)
    loop = np.concatenate([travel, travel[::-1], travel[:1]]), np.concatenate([upper, lower[::-1], upper[:1]])
    panel.plot(*loop, color=colour, linewidth=1.8, zorder=4)


def finish_indicator_panel(panel: Panel, supply_pressure: float, atmospheric_pressure: float, name: str, colour: str) -> None:
    """Draw the line of the atmosphere, and set the limits and the name of a diagram; pressures in Pa."""
    highest, atmosphere = supply_pressure / _PA_PER_BAR, atmospheric_pressure / _PA_PER_BAR
    panel.axhline(atmosphere, color=MUTED, linewidth=0.8, linestyle=CHAIN_DOTTED, zorder=1)
    panel.set(xlim=(-3, 103), ylim=(0, 1.22 * highest), xticks=(0, 25, 50, 75, 100))
    panel.annotate_point((50, 1.12 * highest), name, ha="center", color=colour, fontstyle="italic")
    panel.annotate_point((101, atmosphere), "atmosphere", (0, -12), ha="right", fontsize=9, color=MUTED)

"""What the plates of an engine with a flywheel share: places of the figures, tangential force, extreme speeds, indicator diagrams."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.render.figures.page import CHAIN_DOTTED, Panel, Plate
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SKY
from governor_mechanism.types import BoolArray, FloatArray

_CAPTION_PLACES = ((0.03, 0.862), (0.545, 0.862), (0.03, 0.462), (0.545, 0.462))
"""Left and lower ends of the captions, in fractions of the plate."""

SPEED_RECT, FOURTH_RECT = (0.085, 0.125, 0.41, 0.305), (0.61, 0.125, 0.355, 0.305)
_FORCE_RECT, _INDICATOR_RECTS = (0.085, 0.555, 0.41, 0.275), ((0.61, 0.555, 0.155, 0.275), (0.815, 0.555, 0.15, 0.275))
"""Left and lower edge, width and height of the panels, in fractions of the plate."""

PA_PER_BAR, N_PER_KN = 1e5, 1e3


class EnginePlate(Plate):
    """Plate with four figures: tangential force, indicator diagrams, shaft speed, and one more."""

    def __init__(self, heading: str, title: str, source: str, captions: Sequence[str]) -> None:
        numbered = (f"Fig. {number}.  {caption}" for number, caption in enumerate(captions, start=1))
        super().__init__(heading, title, source, dict(zip(_CAPTION_PLACES, numbered, strict=True)))

    def add_force_panel(
        self, degrees: FloatArray, force: FloatArray, load: FloatArray, is_shaded: BoolArray, limit: int
    ) -> tuple[Panel, float, float]:
        """Draw a tangential force (kN) over the crank angle (deg), shaded to the load; return the panel and the range of the forces."""
        panel = self.add_plate_panel(_FORCE_RECT, "Crank angle $\\varphi$ [deg]", "Tangential force [kN]")
        panel.fill_between(degrees, load, force, where=is_shaded.tolist(), color=SKY, alpha=0.45, linewidth=0, zorder=2)
        panel.plot(degrees, force, color=BLUE, linewidth=2.0, zorder=4)
        low, high = float(min(force.min(), load.min())), float(force.max())
        margins = low - 0.08 * (high - low), high + 0.18 * (high - low)
        panel.set(xlim=(0, limit), ylim=margins, xticks=range(0, limit + 1, limit // 6))
        return panel, low, high

    def add_indicator(
        self, index: int, name: str, colour: str, travel: FloatArray, upper: FloatArray, lower: FloatArray, pressures: tuple[float, float]
    ) -> Panel:
        """Draw a loop of pressures (Pa) over travels (fractions of the stroke), of a cylinder between supply and atmosphere (Pa)."""
        label = "Pressure [bar]" if index == 0 else " "
        panel = self.add_plate_panel(_INDICATOR_RECTS[index], "Piston travel [% of stroke]", label)
        travel, upper, lower = 100 * travel, upper / PA_PER_BAR, lower / PA_PER_BAR
        highest, atmosphere = (pressure / PA_PER_BAR for pressure in pressures)
        panel.fill_between(travel, lower, upper, color=colour, alpha=0.13, linewidth=0, zorder=2)
        loop = np.concatenate([travel, travel[::-1], travel[:1]]), np.concatenate([upper, lower[::-1], upper[:1]])
        panel.plot(*loop, color=colour, linewidth=1.8, zorder=4)
        panel.axhline(atmosphere, color=MUTED, linewidth=0.8, linestyle=CHAIN_DOTTED, zorder=1)
        panel.set(xlim=(-3, 103), ylim=(0, 1.22 * highest), xticks=(0, 25, 50, 75, 100))
        panel.annotate_point((50, 1.12 * highest), name, ha="center", color=colour, fontstyle="italic")
        panel.annotate_point((101, atmosphere), "atmosphere", (0, -12), ha="right", fontsize=9, color=MUTED)
        return panel


def mark_extreme(panel: Panel, point: tuple[float, float], text: str, offset: tuple[float, float], zorder: float | None = None) -> None:
    """Mark a point of extreme speed with its angle."""
    panel.plot(*point, "o", color=INK, markerfacecolor=PAPER, markersize=6, zorder=zorder)
    panel.annotate_point(point, text, offset)

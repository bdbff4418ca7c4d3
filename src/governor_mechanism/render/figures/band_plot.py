"""Curves in figures, drawn as a light band with its mean where their oscillations are too narrow to be resolved."""

from collections.abc import Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from governor_mechanism.render.figures.page import Panel
from governor_mechanism.render.range_bands import RangeBand, name_cycles
from governor_mechanism.render.style import BLUE

BAND_OPACITY = 0.3
"""Opacity of a band: the grid stays visible through it, and the mean stands out from it."""


LINE_WIDTH = 1.3
"""Width of a curve over time, points."""


def draw_range_band(
    panel: Panel,
    band: RangeBand,
    colour: str,  # colour of the mean, and with BAND_OPACITY that of the band
    line_style: Any = "-",
    line_width: float = LINE_WIDTH,
) -> None:
    """Draw a band and its mean."""
    panel.fill_between(band.times, band.low, band.high, color=colour, alpha=BAND_OPACITY, linewidth=0)
    panel.plot(band.mean_times, band.means, color=colour, linestyle=line_style, linewidth=line_width)


def band_handles(bands: Sequence[RangeBand]) -> list[Artist]:
    """Return the entries of a legend of bands and means; none without a band."""
    if not bands:
        return []
    cycle = name_cycles(bands)
    return [
        Patch(facecolor=BLUE, alpha=BAND_OPACITY, linewidth=0, label=f"range within {cycle}"),
        Line2D([], [], color=BLUE, linewidth=LINE_WIDTH, label=f"mean over {cycle}"),
    ]

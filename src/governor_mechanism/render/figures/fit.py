"""Figure of a fit: measured values with the fitted run, and the residuals below, for each reading."""

from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.shown_readings import display_unit_of, format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, VERMILLION
from governor_mechanism.studies.fitting.results import Fit

_WIDTH, _ROW_HEIGHT, _HEADER, _FOOTER = 8.0, 3.6, 0.9, 0.6
"""Width of the page, height for each reading, and heights above and below, inches."""


def _describe(fit: Fit) -> str:
    """Return what was fitted to what, in a line."""
    n_values, n_unknowns = sum(len(one.values) for one in fit.measurements), len(fit.rows)
    return f"{n_unknowns} value{'s' * (n_unknowns > 1)} fitted to {n_values} measured ones; band: two standard deviations of the noise"


def fit_figure(fit: Fit) -> Page:
    """Draw measured and fitted values over time, and the residuals with two standard deviations of the noise."""
    height = _HEADER + _FOOTER + _ROW_HEIGHT * len(fit.measurements)
    page = Page(_WIDTH, height, fit.title, _describe(fit), subtitle_y=1 - 0.7 * _HEADER / height)
    ratios = [2.4, 1.0] * len(fit.measurements)
    margins = {"left": 0.11, "right": 0.97, "top": 1 - _HEADER / height, "bottom": _FOOTER / height}
    grid = page.add_gridspec(2 * len(fit.measurements), 1, height_ratios=ratios, hspace=0.3, **margins)
    for k, one in enumerate(fit.measurements):
        unit, factor = display_unit_of(one.unit)
        panel = page.add_panel(grid[2 * k, 0], "", f"{format_name(one.reading)} [{unit}]")
        panel.plot(one.times, one.values * factor, ".", color=MUTED, markersize=3, label="measured")
        panel.plot(fit.run.times, fit.run.readings[one.reading] * factor, color=BLUE, linewidth=1.4, label="fitted run")
        panel.legend(loc="best", frameon=False, fontsize=8)
        below = page.add_panel(grid[2 * k + 1, 0], "time [s]", f"residual [{unit}]", label_size=9)
        below.set_xlim(panel.get_xlim())
        limit = 2.0 * fit.noise[one.reading] * factor
        below.axhspan(-limit, limit, color=BLUE, alpha=0.12, linewidth=0)
        below.axhline(0.0, color=INK, linewidth=0.6)
        residuals = fit.residuals[one.reading] * factor
        below.plot(one.times[: len(residuals)], residuals, ".", color=VERMILLION, markersize=2.5)
    return page

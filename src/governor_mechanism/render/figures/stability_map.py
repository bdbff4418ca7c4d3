"""Figure of a stability map: growth rate over two parameters with its borders, and the same points in Vyshnegradskii's plane."""

from typing import Any

import numpy as np
from matplotlib.colors import TwoSlopeNorm

from governor_mechanism.render.figures.page import DASHED, Page, Panel, add_legend
from governor_mechanism.render.number_format import format_label
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SERIF_FONT, VERMILLION
from governor_mechanism.render.theme import OVER_COLOUR_MAP
from governor_mechanism.studies.regulation.stability_map import StabilityMap
from governor_mechanism.studies.sweep.parameters import SweepAxis

_COLOUR_MAP = "PuOr_r"
"""Diverging colours that stay apart without colour vision: stable and hunting on their two sides."""

_LEGEND: dict[str, Any] = {
    "fontsize": 7.5,
    "loc": "upper right",
    "frameon": True,
    "framealpha": 1.0,
    "facecolor": PAPER,
    "edgecolor": "none",
}
"""Place and ground of a legend over points."""

_PLANE_LIMIT = 6.0
"""Largest Vyshnegradskii's parameter that is drawn."""


def stability_map_figure(study: StabilityMap) -> Page:
    """Draw the map and, if the closed form applies, Vyshnegradskii's plane."""
    has_plane = bool(np.isfinite(study.parameters).any())
    page = Page(10.4 if has_plane else 6.4, 5.4, "Where the governed engine is stable", study.title, subtitle_y=0.885)
    panel = page.add_panel((0.075, 0.135, 0.43, 0.68) if has_plane else (0.12, 0.135, 0.70, 0.68), _label(study.x), _label(study.y))
    _draw_map(page, panel, study, (0.515, 0.135, 0.012, 0.68) if has_plane else (0.84, 0.135, 0.02, 0.68))
    if has_plane:
        _draw_plane(page, study)
    page.write_footnote(_footnote(study))
    return page


def _label(axis: SweepAxis) -> str:
    """Return the name of a parameter with its unit."""
    words = [word for word in axis.key.split(".") if word not in ("part", "dimensions", "effects")]
    return format_label(" ".join(words), axis.display_unit[1].replace("^2", "²"))


def _draw_map(page: Page, panel: Panel, study: StabilityMap, colour_bar: tuple[float, float, float, float]) -> None:
    """Draw the growth rates in colours, and the borders over them."""
    x, y = (np.array(axis.values) * axis.display_unit[0] for axis in (study.x, study.y))
    rates = study.growth_rates
    limit = float(np.nanpercentile(np.abs(rates), 97)) or 1.0
    norm = TwoSlopeNorm(0.0, -limit, limit)
    mesh = panel.pcolormesh(x, y, rates, cmap=_COLOUR_MAP, norm=norm, shading="gouraud" if np.isfinite(rates).all() else "nearest")
    panel.grid(False)
    with np.errstate(invalid="ignore"):
        has_border = np.nanmin(rates) < 0.0 < np.nanmax(rates)
        if has_border:
            panel.contour(x, y, rates, levels=[0.0], colors=[INK], linewidths=1.6).set_gid(OVER_COLOUR_MAP)
            panel.plot([], [], color=INK, linewidth=1.6, label="eigenvalues, mean torque")
        excess = study.parameters[0] * study.parameters[1] - 1.0
        if np.isfinite(excess).all() and excess.min() < 0.0 < excess.max():
            panel.contour(x, y, excess, levels=[0.0], colors=[PAPER], linewidths=2.6).set_gid(OVER_COLOUR_MAP)
            panel.contour(x, y, excess, levels=[0.0], colors=[INK], linewidths=1.2, linestyles=[DASHED]).set_gid(OVER_COLOUR_MAP)
            panel.plot([], [], color=INK, linewidth=1.2, linestyle=DASHED, label="Vyshnegradskii, $x\\,y = 1$")
    x_factor, y_factor = study.x.display_unit[0], study.y.display_unit[0]
    cyclic = [(point.x * x_factor, point.cyclic * y_factor) for point in study.border if point.cyclic is not None]
    if cyclic:
        panel.plot(*zip(*cyclic, strict=True), "o", color=VERMILLION, markeredgecolor=PAPER, markersize=6, label="simulated, cyclic torque")
    place = study.place[0] * x_factor, study.place[1] * y_factor
    if np.isfinite(place).all():
        panel.plot(*place, "*", color=BLUE, markeredgecolor=PAPER, markersize=13, label="the scene")
    panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    add_legend(panel, {"color": INK, "math_fontfamily": "stix"}, **_LEGEND)
    bar_axes = page.add_axes(colour_bar)
    bar = page.colorbar(mesh, cax=bar_axes)
    bar.ax.tick_params(labelsize=8, colors=MUTED)
    bar.outline.set_visible(False)
    bar.ax.set_ylabel("Growth rate [1/s]", fontsize=8.5, color=INK, fontfamily=SERIF_FONT)


def _draw_plane(page: Page, study: StabilityMap) -> None:
    """Draw the points in the plane of Vyshnegradskii's parameters, with the hyperbola."""
    panel = page.add_panel((0.665, 0.135, 0.315, 0.68), "$x = a\\,/\\,c^{1/3}$ [1]", "$y = b\\,/\\,c^{2/3}$ [1]")
    first, second = study.parameters.reshape(2, -1)
    is_shown = (first < _PLANE_LIMIT) & (second < _PLANE_LIMIT)
    stable = (study.growth_rates < 0.0).ravel()
    for chosen, colour, marker, label in ((stable, BLUE, ".", "eigenvalues: stable"), (~stable, VERMILLION, "x", "eigenvalues: hunts")):
        rows = chosen & is_shown
        panel.plot(first[rows], second[rows], marker, color=colour, markersize=3.5, linewidth=0, label=label)
    curve = np.linspace(1.0 / _PLANE_LIMIT, _PLANE_LIMIT, 200)
    panel.plot(curve, 1.0 / curve, color=INK, linewidth=1.4, label="$x\\,y = 1$")
    panel.set(xlim=(0.0, _PLANE_LIMIT), ylim=(0.0, _PLANE_LIMIT))
    add_legend(panel, {"color": INK, "math_fontfamily": "stix"}, **_LEGEND)


def _footnote(study: StabilityMap) -> str:
    """Return what is drawn, in a line."""
    shifts = [point.cyclic / point.mean - 1 for point in study.border if point.cyclic is not None]
    parts = [f"load {100 * study.load_fraction:.4g} % of the rated torque", "colour: growth rate of the least damped motion, mean torque"]
    if shifts:
        parts.append(f"the cyclic torque moves the border by {min(shifts):+.2%} to {max(shifts):+.2%}")
    return "; ".join(parts)

"""Figures of a Hartung governor design: its astatic spring lines, and the uniformity of its sleeve force."""

import math

import numpy as np
from numpy.typing import ArrayLike

from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, SERIES_LINE_STYLES, Page, Panel, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, SERIF_FONT, VERMILLION
from governor_mechanism.studies.design import hartung_paper as paper
from governor_mechanism.studies.design.hartung import HartungDesign, build_hartung_layout
from governor_mechanism.studies.printed_numbers import select_deviations
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM

_PAPER_ANGLES_DEG = (90.0, 132.0, 137.332)
"""Bell-crank angles (deg): Hartung's right angle, Dubois' angle, and the angle from Dubois' formula."""

_MAX_ENLARGED_SPREAD = 0.2
"""Largest variation of a force, relative to its mean, that is also shown enlarged."""


def spring_lines_figure(
    design: HartungDesign,
    *,
    # whether to plot the points of Dubois' table and mark its misprint (his Figs. 12 and 13)
    with_printed_points: bool = False,
) -> Page:
    """Draw the astatic spring forces at both speeds, and the straight spring line between them.

    Result: the figure; `save` writes it.
    """
    layout, inputs = design.layout, design.inputs
    slow, fast = (f"{speed / RPM:.4g} rpm" for speed in (inputs.slow_speed, inputs.fast_speed))
    page = _new_page("Astatic spring forces", f"and the effective spring from {slow} inside to {fast} outside")
    panel = page.add_panel((0.10, 0.15, 0.79, 0.66), "Radius of the weights' centres [mm]", "Force of each spring [kgf]")
    for forces, colour, style, text in (
        (layout.fast_forces, VERMILLION, DASHED, f"equilibrium at {fast}"),
        (layout.slow_forces, BLUE, CHAIN_DOTTED, f"equilibrium at {slow}"),
        (layout.spring_forces, INK, "-", f"spring, {layout.spring_rate / KILOGRAM_FORCE_1853 / MM_PER_M:.4g} kgf/mm"),
    ):
        panel.plot(layout.radii * MM_PER_M, forces / KILOGRAM_FORCE_1853, color=colour, linewidth=1.5, linestyle=style, label=text)
    if with_printed_points:
        _plot_printed_points(panel)
    _add_newton_axis(panel, "Force of each spring [N]")
    add_legend(panel, {"fontfamily": SANS_FONT}, fontsize=8.5, loc="upper left", handlelength=3.0, labelcolor=INK)
    weight_arm, sleeve_arm = (f"{arm * MM_PER_M:.5g} mm" for arm in (layout.governor.weight_arm, layout.governor.sleeve_arm))
    text = f"bell crank {math.degrees(design.angle):.5g} deg, arms {weight_arm} and {sleeve_arm}; one kgf is {KILOGRAM_FORCE_1853:g} N"
    page.write_footnote(text, y=0.022)
    return page


def sleeve_force_figure(design: HartungDesign) -> Page:
    """Draw the static sleeve force over the stroke, for several bell-crank angles and the best one.

    Result: the figure; `save` writes it.
    """
    layouts = [(angle, build_hartung_layout(design.inputs, math.radians(angle))) for angle in _shown_angles(design)]
    page = _new_page("Uniformity of the static sleeve force", "each angle with straight spring lines through both speeds")
    labels = "Lever angle (outward) [deg]", "Static sleeve force S [kgf]"
    panel, enlarged = page.add_panel((0.09, 0.15, 0.375, 0.60), *labels), page.add_panel((0.555, 0.15, 0.345, 0.60), *labels)
    enlarged.write_heading("The most uniform ones, enlarged", y=1.03)
    lines = zip((*SERIES_COLOURS, INK, MUTED), (*SERIES_LINE_STYLES, "-", DASHED), strict=True)
    for (angle, layout), (colour, style) in zip(layouts, lines, strict=False):
        best = abs(math.radians(angle) - design.best_angle) < math.radians(0.01)
        text = f"{angle:.6g} deg: {100 * layout.spread:.3g} %" + (", the best" if best else "")
        lever_angles, forces = np.degrees(layout.levers), layout.static_forces / KILOGRAM_FORCE_1853
        panel.plot(lever_angles, forces, color=colour, linewidth=1.6, linestyle=style, label=text)
        if layout.spread < _MAX_ENLARGED_SPREAD:
            enlarged.plot(lever_angles, forces, color=colour, linewidth=1.6, linestyle=style)
    low, high = panel.get_ylim()
    panel.set_ylim(low - 0.55 * (high - low), high)
    _add_newton_axis(enlarged, "Static sleeve force S [N]")
    panel.invert_xaxis()
    enlarged.invert_xaxis()
    add_legend(panel, {"fontfamily": SANS_FONT}, fontsize=8.5, loc="lower right", handlelength=3.0, labelcolor=INK)
    text = f"percent: largest minus smallest force over the stroke, relative to their mean; one kgf is {KILOGRAM_FORCE_1853:g} N"
    page.write_footnote(text, y=0.022)
    return page


def _shown_angles(design: HartungDesign) -> list[float]:
    """Return the angles of the paper (deg), and those of the design and the best one if they differ visibly."""
    angles = list(_PAPER_ANGLES_DEG)
    for angle in (design.best_angle, design.angle):
        degrees = math.degrees(angle)
        if min(abs(degrees - other) for other in angles) > 0.2:
            angles.append(round(degrees, 3))
    return sorted(angles)


def _plot_printed_points(panel: Panel) -> None:
    """Plot Dubois' table; the misprint is ringed."""
    radii = [row[0] for row in paper.PRINTED_SPRING_FORCES]
    for column, colour in ((1, BLUE), (2, VERMILLION)):
        panel.plot(radii, [row[column] for row in paper.PRINTED_SPRING_FORCES], "o", color=colour, markersize=4, markerfacecolor=PAPER)
    for step in select_deviations(paper.compare_with_paper().table):
        radius = next(row[0] for row in paper.PRINTED_SPRING_FORCES if step.printed in row[1:])
        panel.plot([radius], [step.printed], "o", color=GREEN, markersize=13, markerfacecolor="none")
        panel.write_note(f"printed {step.printed:g},\nrecomputed {step.recomputed:.1f}", (radius, step.printed), (-12, 20), color=GREEN)
    speeds = " and ".join(f"{speed:g}" for speed in paper.PAPER_SPEEDS)
    panel.plot([], [], "o", color=MUTED, markersize=4, markerfacecolor=PAPER, label=f"Dubois' table, {speeds} rad/s")


def _add_newton_axis(panel: Panel, label: str) -> None:
    """Add a scale in newtons at the right of a panel in kilogram-force."""
    axis = panel.secondary_yaxis("right", functions=(_to_newtons, _to_kilogram_forces))
    axis.set_ylabel(label, fontsize=10, fontfamily=SERIF_FONT, color=INK)
    axis.tick_params(color=MUTED, labelcolor=MUTED, labelsize=8, labelfontfamily=SANS_FONT)
    axis.spines["right"].set(color=MUTED, linewidth=0.8)


def _to_newtons(forces: ArrayLike) -> FloatArray:
    return np.multiply(forces, KILOGRAM_FORCE_1853)


def _to_kilogram_forces(forces: ArrayLike) -> FloatArray:
    return np.divide(forces, KILOGRAM_FORCE_1853)


def _new_page(title: str, subtitle: str) -> Page:
    return Page(7.6, 5.2, title, subtitle, dpi=120, subtitle_y=0.89)

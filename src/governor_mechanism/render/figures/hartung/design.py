"""Figures of a Hartung governor design: its astatic spring lines, and the uniformity of its sleeve force."""

import math

import numpy as np

from governor_mechanism.render.figures.page import MM_PER_M, Page, Panel, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, VERMILLION
from governor_mechanism.studies.hartung import paper_comparison as paper
from governor_mechanism.studies.hartung.design import HartungDesign, build_hartung_layout
from governor_mechanism.studies.hartung.inputs import KILOGRAM_FORCE

_PAPER_ANGLES_DEG = (90.0, 132.0, 137.332)
"""Bell-crank angles (deg): Hartung's right angle, Dubois' angle, and the angle from Dubois' formula."""

_MAX_ENLARGED_SPREAD = 0.2
"""Largest variation of a force, relative to its mean, that is also shown enlarged."""


def spring_lines_figure(design: HartungDesign, *, with_printed_points: bool = False) -> Page:
    """Draw the astatic spring forces at both speeds, and the straight spring line between them.

    Parameters
    ----------
    design
        Design of the governor.
    with_printed_points
        Whether to plot the points of Dubois' table and mark its misprint (his Figs. 12 and 13).

    Returns
    -------
    Page
        The figure; `save` writes it.
    """
    layout, inputs = design.layout, design.inputs
    slow, fast = (f"{speed * 30 / math.pi:.4g} rpm" for speed in (inputs.slow_speed, inputs.fast_speed))
    page = _new_page("Astatic spring forces", f"and the effective spring from {slow} inside to {fast} outside")
    panel = page.add_panel((0.11, 0.15, 0.85, 0.66), "Radius of the weights' centres [mm]", "Force of each spring [kgf]")
    for forces, colour, text in (
        (layout.fast_forces, VERMILLION, f"equilibrium at {fast}"),
        (layout.slow_forces, BLUE, f"equilibrium at {slow}"),
        (layout.spring_forces, INK, f"spring, {layout.spring_rate / KILOGRAM_FORCE / MM_PER_M:.4g} kgf/mm"),
    ):
        panel.plot(layout.radii * MM_PER_M, forces / KILOGRAM_FORCE, color=colour, linewidth=1.5, label=text)
    if with_printed_points:
        _plot_printed_points(panel)
    add_legend(panel, {"fontfamily": SANS_FONT}, fontsize=8.5, loc="upper left", handlelength=1.6, labelcolor=INK)
    weight_arm, sleeve_arm = (f"{arm * MM_PER_M:.5g} mm" for arm in (layout.governor.weight_arm, layout.governor.sleeve_arm))
    text = f"bell crank {math.degrees(design.angle):.5g} deg, arms {weight_arm} and {sleeve_arm}; one kgf is {KILOGRAM_FORCE:g} N"
    page.write_footnote(text, y=0.022)
    return page


def sleeve_force_figure(design: HartungDesign) -> Page:
    """Draw the static sleeve force over the stroke, for several bell-crank angles and the best one.

    Parameters
    ----------
    design
        Design of the governor.

    Returns
    -------
    Page
        The figure; `save` writes it.
    """
    layouts = [(angle, build_hartung_layout(design.inputs, math.radians(angle))) for angle in _shown_angles(design)]
    page = _new_page("Uniformity of the static sleeve force", "each angle with straight spring lines through both speeds")
    panel = page.add_panel((0.09, 0.15, 0.40, 0.66), "Lever angle (outward) [deg]", "Static sleeve force S [kgf]")
    enlarged = page.add_panel((0.585, 0.15, 0.395, 0.66), "the most uniform ones, enlarged")
    for (angle, layout), colour in zip(layouts, (*SERIES_COLOURS, INK, MUTED), strict=False):
        best = abs(math.radians(angle) - design.best_angle) < math.radians(0.01)
        text = f"{angle:.6g} deg: {100 * layout.spread:.3g} %" + (", the best" if best else "")
        lever_angles, forces = np.degrees(layout.levers), layout.static_forces / KILOGRAM_FORCE
        panel.plot(lever_angles, forces, color=colour, linewidth=1.6, label=text)
        if layout.spread < _MAX_ENLARGED_SPREAD:
            enlarged.plot(lever_angles, forces, color=colour, linewidth=1.6)
    panel.set_ylim(0.0, 1.12 * max(float(layout.static_forces.max()) for _, layout in layouts) / KILOGRAM_FORCE)
    panel.invert_xaxis()
    enlarged.invert_xaxis()
    add_legend(panel, {"fontfamily": SANS_FONT}, fontsize=8.5, loc="lower right", handlelength=1.6, labelcolor=INK)
    page.write_footnote("percent: largest minus smallest force over the stroke, relative to their mean", y=0.022)
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
    """Plot Dubois' table; values that differ by more than slide-rule accuracy are ringed."""
    radii = [row[0] for row in paper.PRINTED_SPRING_FORCES]
    for column, colour in ((1, BLUE), (2, VERMILLION)):
        panel.plot(radii, [row[column] for row in paper.PRINTED_SPRING_FORCES], "o", color=colour, markersize=4, markerfacecolor=PAPER)
    misprints = [step for step in paper.compare_with_paper().table if abs(step.printed - step.recomputed) > paper.SLIDE_RULE_TOLERANCE]
    for step in misprints:
        radius = next(row[0] for row in paper.PRINTED_SPRING_FORCES if step.printed in row[1:])
        panel.plot([radius], [step.printed], "o", color=GREEN, markersize=13, markerfacecolor="none")
        panel.write_note(f"printed {step.printed:g},\nrecomputed {step.recomputed:.1f}", (radius, step.printed), (-12, 20), color=GREEN)
    speeds = " and ".join(f"{speed:g}" for speed in paper.PAPER_SPEEDS)
    panel.plot([], [], "o", color=MUTED, markersize=4, markerfacecolor=PAPER, label=f"Dubois' table, {speeds} rad/s")


def _new_page(title: str, subtitle: str) -> Page:
    return Page(7.6, 5.2, title, subtitle, dpi=120, subtitle_y=0.89)

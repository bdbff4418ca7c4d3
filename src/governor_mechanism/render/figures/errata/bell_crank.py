"""Figure of Dubois' bell crank: the angle that he uses and that of his formula drawn to scale, and the sleeve force that each gives."""

import math

import numpy as np
from matplotlib.patches import Arc, Circle

from governor_mechanism.render.figures.errata.canvas import TEXT_SIZE, add_panel, new_page
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Page, Panel
from governor_mechanism.render.style import BLUE, INK, LIGHT_STEEL, MUTED, PAPER, VERMILLION
from governor_mechanism.studies.design.hartung import PAPER_INPUTS, HartungLayout, build_hartung_layout
from governor_mechanism.studies.design.hartung_paper import compare_with_paper
from governor_mechanism.studies.errata.dubois import USED_ANGLE_DEG
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853

_LEFT_RECT, _RIGHT_RECT = (0.015, 0.03, 0.385, 0.79), (0.515, 0.16, 0.47, 0.62)
_ARC_DIAMETERS = (62.0, 106.0)
"""Diameters of the arcs of both angles, mm."""


def draw_bell_crank() -> Page:
    """Draw the bell crank at the angle of the paper's governor and at the right one, and the static sleeve force over the stroke.

    The paper prints 133 degrees for its formula, takes 132 degrees as the even number next to it, and makes all that follows with these.
    """
    number = next(one for one in compare_with_paper().numbers if one.quantity == "angle of the bell crank")
    layouts = [build_hartung_layout(PAPER_INPUTS, math.radians(angle)) for angle in (USED_ANGLE_DEG, number.recomputed)]
    page = new_page(
        "Dubois’ bell crank: 137.33°, not 133°",
        f"for tan γ = −106/115 he prints {number.printed:.0f}°, and uses {USED_ANGLE_DEG:.0f}°; the right angle makes the force even",
    )
    _draw_cranks(page.add_panel(_LEFT_RECT, grid=None), layouts)
    _draw_forces(add_panel(page, _RIGHT_RECT, "Lever angle, outward [deg]", "Static sleeve force [kgf]"), layouts)
    return page


def _draw_cranks(panel: Panel, layouts: list[HartungLayout]) -> None:
    """Draw both cranks from one fulcrum, the spindle axis at the left."""
    panel.axison = False
    governor = layouts[0].governor
    centre = MM_PER_M * governor.fulcrum_radius
    top = MM_PER_M * governor.weight_arm
    panel.plot([0, 0], [-165, 150], color=MUTED, linewidth=0.9, linestyle=CHAIN_DOTTED)
    panel.plot([centre] * 2, [0, top], color=INK, linewidth=4.0, solid_capstyle="round")
    panel.add_patch(Circle((centre, top), 21, facecolor=LIGHT_STEEL, edgecolor=INK, linewidth=1.2, zorder=4))
    panel.annotate_point((centre, top), "weight", ha="center", va="center", fontsize=TEXT_SIZE - 1)
    for layout, colour, style, diameter in zip(layouts, (VERMILLION, BLUE), (DASHED, "-"), _ARC_DIAMETERS, strict=True):
        angle, arm = layout.governor.angle, MM_PER_M * layout.governor.sleeve_arm
        end = centre - arm * math.sin(angle), arm * math.cos(angle)
        panel.plot([centre, end[0]], [0, end[1]], color=colour, linewidth=2.6, linestyle=style, zorder=3)
        panel.add_patch(Circle(end, 5, facecolor=PAPER, edgecolor=colour, linewidth=1.4, zorder=5))
        degrees = math.degrees(angle)
        panel.add_patch(Arc((centre, 0), diameter, diameter, theta1=90, theta2=90 + degrees, color=colour, linewidth=1.4))
    panel.add_patch(Circle((centre, 0), 5, facecolor=PAPER, edgecolor=INK, linewidth=1.4, zorder=6))
    used, right = (math.degrees(layout.governor.angle) for layout in layouts)
    panel.annotate_point((centre + 6, -30), f"used\n{used:.0f}°", color=VERMILLION, fontsize=TEXT_SIZE, va="top", linespacing=1.1)
    panel.annotate_point((centre - 58, 36), f"right\n{right:.2f}°", color=BLUE, fontsize=TEXT_SIZE, ha="right", linespacing=1.1)
    panel.annotate_point((-3, 140), "spindle axis", (-4, 0), ha="right", va="top", color=MUTED, fontsize=TEXT_SIZE - 1, rotation=90)
    panel.show_region((64.0, -14.0), 112.0)


def _draw_forces(panel: Panel, layouts: list[HartungLayout]) -> None:
    """Draw the static sleeve force over the stroke with each angle."""
    labels = ((-15.0, 470.5), "right"), ((15.0, 501.5), "left")
    for layout, colour, style, (point, side) in zip(layouts, (VERMILLION, BLUE), (DASHED, "-"), labels, strict=True):
        forces = layout.static_forces / KILOGRAM_FORCE_1853
        panel.plot(np.degrees(layout.levers), forces, color=colour, linewidth=2.2, linestyle=style)
        degrees = math.degrees(layout.governor.angle)
        text = f"{degrees:.{0 if colour == VERMILLION else 2}f}°: changes by {100 * layout.spread:.1f} %"
        panel.annotate_point(point, text, color=colour, fontsize=TEXT_SIZE, ha=side)
    panel.invert_xaxis()
    low, high = panel.get_ylim()
    panel.set(ylim=(low - 0.25 * (high - low), high + 0.35 * (high - low)), xticks=range(-15, 16, 5))

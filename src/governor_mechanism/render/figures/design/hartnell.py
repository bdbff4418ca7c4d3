"""Figure of a designed Hartnell governor: its controlling force between the speed lines, and the speed over the lift of both springs."""

import numpy as np

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Page, Panel, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SANS_FONT, VERMILLION
from governor_mechanism.studies.design.hartnell import HartnellDesign, SleeveSpring
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.places import fill_places

_N_CURVE_POINTS = 121
"""Points of a curve over the travel."""


_SUBTITLE = (
    "balls {inputs.ball_mass:.4g} kg, arms {inputs.ball_arm:.4g/mm} and {inputs.sleeve_arm:.4g mm} at {inputs.bell_crank_angle:.4g deg}; "
    "spring {exact.rate:.4g N/mm} with {exact.forces[0]:.4g} N in the lowest position"
)


def hartnell_figure(design: HartnellDesign) -> Page:
    """Draw the figure of a design.

    Result: the figure; `save` writes it.
    """
    page = Page(9.6, 5.4, design.scene.title, fill_places(_SUBTITLE, design), dpi=120, subtitle_y=0.895)
    angles = np.linspace(*design.travel.arm_angles, _N_CURVE_POINTS)
    _draw_force(page.add_panel((0.075, 0.145, 0.395, 0.575), "Radius of the balls [mm]", "Force on each ball [N]"), design, angles)
    _draw_speed(page.add_panel((0.575, 0.145, 0.395, 0.575), "Lift of the sleeve [mm]", "Speed of equilibrium [rpm]"), design, angles)
    page.write_footnote("textbook: weight of the balls and obliquity of the arms neglected; exact: neither", y=0.022)
    return page


def _draw_force(panel: Panel, design: HartnellDesign, angles: FloatArray) -> None:
    """Draw the controlling force of the exact spring over the radius, and the centrifugal force of both speeds."""
    governor, inputs = design.governor, design.inputs
    radii = np.asarray(closed.ball_radius(governor, arm_angle=angles))
    speeds = np.asarray(_speeds(design, design.exact, angles))
    for speed, colour, style in ((inputs.highest_speed, VERMILLION, DASHED), (inputs.lowest_speed, BLUE, CHAIN_DOTTED)):
        label = f"centrifugal force at {speed / RPM:.5g} rpm"
        panel.plot(radii * MM_PER_M, governor.ball_mass * speed**2 * radii, color=colour, linestyle=style, linewidth=1.4, label=label)
    force = governor.ball_mass * speeds**2 * radii
    panel.plot(radii * MM_PER_M, force, color=INK, linewidth=2.0, label="controlling force, exact spring")
    _mark_ends(panel, radii * MM_PER_M, force)
    _add_legend(panel)


def _draw_speed(panel: Panel, design: HartnellDesign, angles: FloatArray) -> None:
    """Draw the speed of equilibrium of the exact governor over the lift, with either spring."""
    lifts = MM_PER_M * _lifts(design, angles)
    for wanted in (design.inputs.lowest_speed, design.inputs.highest_speed):
        panel.axhline(wanted / RPM, color=MUTED, linewidth=0.8, linestyle=DASHED)
    for spring, colour, style, label in (
        (design.exact, INK, "-", "exact spring"),
        (design.textbook, GREEN, CHAIN_DOTTED, "textbook spring"),
    ):
        speeds = _speeds(design, spring, angles) / RPM
        panel.plot(lifts, speeds, color=colour, linestyle=style, linewidth=2.0, label=f"{label}, {spring.rate / 1e3:.4g} N/mm")
        _mark_ends(panel, lifts, speeds)
    panel.plot([], [], color=MUTED, linewidth=0.8, linestyle=DASHED, label="wanted speeds")
    _add_legend(panel)


def _speeds(design: HartnellDesign, spring: SleeveSpring, angles: FloatArray) -> FloatArray:
    """Return the speeds (n,) of equilibrium of the exact governor (rad/s) at arm angles (n,), rad."""
    forces = spring.forces[0] + spring.rate * _lifts(design, angles)
    return np.asarray(closed.equilibrium_speed(design.governor, arm_angle=angles, spring_force=forces))


def _lifts(design: HartnellDesign, angles: FloatArray) -> FloatArray:
    """Return the lifts (n,) of the sleeve (m) at arm angles (n,), rad."""
    heights = np.asarray(closed.sleeve_height(design.governor, arm_angle=angles))
    return np.asarray(heights - heights[0])


def _mark_ends(panel: Panel, x: FloatArray, y: FloatArray) -> None:
    panel.plot(x[[0, -1]], y[[0, -1]], "o", color=INK, markerfacecolor=PAPER, markersize=5, zorder=5)


def _add_legend(panel: Panel) -> None:
    options = {"fontsize": 8.5, "handlelength": 3.0, "labelcolor": INK}
    add_legend(panel, {"fontfamily": SANS_FONT}, loc="lower left", bbox_to_anchor=(0.0, 1.0), **options)

"""The figure of the main error of each paper: small, each says one thing, and its letters are legible at 480 pixels of width."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np
from matplotlib.patches import Arc, Circle

from governor_mechanism.closed_form import parabolic
from governor_mechanism.closed_form.flywheel import speed_limits
from governor_mechanism.closed_form.flywheel_equilibrium import shaft_speed
from governor_mechanism.closed_form.slide_valve import event_angle
from governor_mechanism.papers.dubois import USED_ANGLE_DEG
from governor_mechanism.papers.errata_results import Errata
from governor_mechanism.papers.erratum import ECCENTRIC, LAPS, Paper
from governor_mechanism.papers.zehnder import LONGER, SHORTER
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Page, Panel, PanelRect, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, LIGHT_STEEL, MUTED, PAPER, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.studies.design import hartung
from governor_mechanism.studies.design.flywheel import DEFAULT_ENERGY_RATIO, PAPER_ENGINE, PAPER_INPUTS, closed_cycle, compare_with_paper
from governor_mechanism.studies.design.hartung import HartungLayout
from governor_mechanism.studies.design.pendulum import design_pendulum
from governor_mechanism.types import FloatArray, FloatOrArray
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM

_PAGE_SIZE = (5.6, 3.9)
"""Width and height, inches."""

_RESOLUTION = 180
"""Dots per inch: 1008 by 702 pixels."""

_TEXT_SIZE = 10.0
"""Size of the texts, points."""


def _new_page(title: str, subtitle: str) -> Page:
    """Return an empty page with a title and a line below it."""
    page = Page(*_PAGE_SIZE, dpi=_RESOLUTION)
    page.write_title(title, y=0.94, size=14.5)
    page.write_title(subtitle, y=0.868, size=10.0, colour=MUTED)
    return page


def _add_panel(page: Page, rect: PanelRect, x_label: str, y_label: str) -> Panel:
    """Add a panel with large labels."""
    return page.add_panel(rect, x_label, y_label, label_size=11.0, tick_size=9.5, tick_colour=INK)


_CRANK_DEGREES: FloatArray = np.linspace(0.0, 360.0, 721)


def draw_flywheel() -> Page:
    """Draw the speed of the shaft over a turn."""
    comparison = compare_with_paper()
    light, right, closed = comparison.wheels
    engine, mean = closed_cycle(PAPER_ENGINE), PAPER_INPUTS.speed
    total = next(term for term in comparison.terms if term.quantity == "sum of the bracket")
    page = _new_page(
        f"Redtenbacher’s flywheel is {100 * (1 - total.printed / total.recomputed):.0f} % too light",
        f"it leaves the band that µ = {DEFAULT_ENERGY_RATIO:g} allows; the right wheel needs {100 * (right.excess - 1):.0f} % more",
    )
    panel = _add_panel(page, (0.135, 0.155, 0.835, 0.655), "Crank angle [deg]", "Speed of the shaft [rpm]")
    # The wheel that the closed cycle needs runs from edge to edge of the band.
    limits = {"inertia": closed.inertia, "energy": closed.bracket * engine.full_pressure_work, "mean_speed": mean}
    low, high = (float(speed) / RPM for speed in speed_limits(**limits, mean_energy=True))
    panel.axhspan(low, high, color=GREEN, alpha=0.14, linewidth=0)
    for wheel, colour, style in ((light, VERMILLION, "-"), (right, BLUE, DASHED)):
        speeds = shaft_speed(engine, crank_angle=np.radians(_CRANK_DEGREES), inertia=wheel.inertia, mean_speed=mean)
        panel.plot(_CRANK_DEGREES, np.asarray(speeds) / RPM, color=colour, linewidth=2.0, linestyle=style)
    panel.set(xlim=(0, 360), ylim=(low - 0.55, high + 0.75), xticks=range(0, 361, 45))
    texts = (
        ((95.8, high + 0.46), f"by the printed {total.printed:.4f}: {light.inertia:,.0f} kg m²", VERMILLION, "center"),
        ((190.0, (low + high) / 2), f"right:\n{right.inertia:,.0f} kg m²", BLUE, "center"),
        ((5.0, high - 0.12), "allowed band", GREEN, "left"),
    )
    for point, text, colour, side in texts:
        panel.annotate_point(point, text, color=colour, ha=side, fontsize=_TEXT_SIZE + 0.5, va="bottom" if point[1] > high else "center")
    return page


_ARM_DEGREES: FloatArray = np.linspace(-4.0, 4.0, 161)
_ARM_COLOURS = {LONGER: VERMILLION, 1.0: GREEN, SHORTER: BLUE}


def draw_osculation() -> Page:
    """Draw the change of the speed of rest beside the point, for arms of three lengths."""
    start = design_pendulum().start
    page = _new_page("Zehnder on leaving the point of osculation", "he looks at the parabola on which the ball sits; its slope decides")
    panel = _add_panel(
        page, (0.125, 0.155, 0.695, 0.655), "Arm angle from the point of osculation [deg]", "Change of the speed of rest [%]"
    )
    for ratio, colour in _ARM_COLOURS.items():
        path: dict[str, FloatOrArray] = {
            "start_angle": start.arm_angle,
            "start_abscissa": start.abscissa,
            "arm": ratio * start.radius_of_curvature,
            "angle_change": np.radians(_ARM_DEGREES),
        }
        true = 100 * np.asarray(parabolic.equilibrium_speed_change(**path))
        panel.plot(_ARM_DEGREES, true, color=colour, linewidth=2.2)
        panel.plot(_ARM_DEGREES, 100 * np.asarray(parabolic.parabola_speed_change(**path)), color=colour, linewidth=1.6, linestyle=DASHED)
        text = "$l = \\rho$" if ratio == 1.0 else f"$l = {ratio:g}\\,\\rho$"
        panel.annotate_point((4.0, float(true[-1])), text, (6, 0), color=colour, fontsize=_TEXT_SIZE + 1.5, va="center")
    panel.axvline(0.0, color=INK, linewidth=0.8)
    panel.set(xlim=(-4, 4), ylim=(-3, 5.2))
    panel.plot([], [], color=INK, linewidth=2.2, label="true, by equilibrium")
    panel.plot([], [], color=INK, linewidth=1.6, linestyle=DASHED, label="Zehnder’s reasoning, in numbers")
    ground = {"frameon": True, "facecolor": PAPER, "edgecolor": "none", "framealpha": 1.0}
    add_legend(panel, {"fontfamily": SERIF_FONT}, fontsize=_TEXT_SIZE, loc="upper right", labelcolor=INK, handlelength=2.6, **ground)
    for x, side, text in ((-3.9, "left", "below the point"), (3.9, "right", "above")):
        panel.annotate_point((x, -2.85), text, ha=side, fontsize=_TEXT_SIZE, fontstyle="italic")
    return page


_PAPER_SENSES = {"compression": 1, "release": 1, "admission": -1, "cut-off": -1}
"""Sense of the change that the paper states for the end whose fill shrinks, by the event that begins it; at the other end the opposite."""

_EVENT_NAMES = {"compression": "compression", "release": "pre-release", "admission": "pre-admission", "cut-off": "fill"}
_END_BARS = {"crank end": (BLUE, 0.19), "head end": (VERMILLION, -0.19)}
"""Colours of the ends, and the heights of their bars above the middle of the row."""


def draw_cylinder_ends() -> Page:
    """Draw the changes as bars, with the senses that the paper states."""
    page = _new_page(
        "Marks’ error term at the two ends of the cylinder",
        "three of the four changes go together as the paper states; compression does not",
    )
    panel = _add_panel(page, (0.215, 0.155, 0.765, 0.655), "Change by the finite eccentric rod [% of the stroke]", "")
    panel.grid(visible=False, axis="y")
    for row, (event, sense) in enumerate(_PAPER_SENSES.items()):
        for end, (colour, height) in _END_BARS.items():
            change = _change(end, event)
            stated = sense if end == "crank end" else -sense
            panel.barh(-row + height, change, height=0.34, color=colour, zorder=3)
            is_right = math.copysign(1, change) == stated
            text = ("grows" if stated > 0 else "shrinks") + ("" if is_right else " (wrong)")
            offset, side = ((5, 0), "left") if change > 0 else ((-5, 0), "right")
            style = {"color": MUTED} if is_right else {"color": INK, "fontweight": "bold"}
            panel.annotate_point((change, -row + height), text, offset, ha=side, va="center", fontsize=_TEXT_SIZE, **style)
    panel.axvline(0.0, color=INK, linewidth=0.9, zorder=4)
    panel.axhspan(-0.5, 0.5, color=SKY, alpha=0.16, linewidth=0)
    panel.set(
        xlim=(-1.75, 1.75),
        ylim=(-4.35, 0.55),
        yticks=range(0, -len(_PAPER_SENSES), -1),
        yticklabels=[_EVENT_NAMES[event] for event in _PAPER_SENSES],
    )
    panel.tick_params(axis="y", length=0, labelsize=_TEXT_SIZE + 0.5, labelcolor=INK)
    panel.annotate_point((-1.7, -3.72), "crank end: its fill shrinks", color=BLUE, fontsize=_TEXT_SIZE, va="center")
    panel.annotate_point((1.7, -3.72), "head end: its fill grows", color=VERMILLION, fontsize=_TEXT_SIZE, va="center", ha="right")
    panel.annotate_point(
        (0, -4.12), "words at the bars: what the paper states of such an end", color=MUTED, fontsize=_TEXT_SIZE, va="center", ha="center"
    )
    return page


def _change(end: str, event: str) -> float:
    """Return by how much the rod changes what the event begins or ends, in percent of the stroke; the connecting rod is infinitely long."""
    exact, theory = (_stroke_fraction(end, event, rod) for rod in (ECCENTRIC.rod, math.inf))
    return 100 * (exact - theory) * (-1 if event == "release" else 1)


def _stroke_fraction(end: str, event: str, rod: float) -> float:
    """Return the part of the stroke, from the event's own end, at which the piston is."""
    angle = event_angle(replace(ECCENTRIC, rod=rod), event=f"{end} {event}", **LAPS)
    return (1 - math.cos(angle)) / 2 if end == "crank end" else (1 + math.cos(angle)) / 2


_CRANK_RECT = (0.015, 0.03, 0.385, 0.79)
_FORCE_RECT = (0.515, 0.16, 0.47, 0.62)
_ARC_DIAMETERS = (62.0, 106.0)
"""Diameters of the arcs of both angles, mm."""


def draw_bell_crank() -> Page:
    """Draw the bell crank at the angle of the paper's governor and at the right one, and the static sleeve force over the stroke.

    The paper prints 133 degrees for its formula, takes 132 degrees as the even number next to it, and makes all that follows with these.
    """
    number = next(one for one in hartung.compare_with_paper().numbers if one.quantity == "angle of the bell crank")
    layouts = [hartung.build_hartung_layout(hartung.PAPER_INPUTS, math.radians(angle)) for angle in (USED_ANGLE_DEG, number.recomputed)]
    page = _new_page(
        "Dubois’ bell crank: 137.33°, not 133°",
        f"for tan γ = −106/115 he prints {number.printed:.0f}°, and uses {USED_ANGLE_DEG:.0f}°; the right angle makes the force even",
    )
    _draw_cranks(page.add_panel(_CRANK_RECT, grid=None), layouts)
    _draw_forces(_add_panel(page, _FORCE_RECT, "Lever angle, outward [deg]", "Static sleeve force [kgf]"), layouts)
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
    panel.annotate_point((centre, top), "weight", ha="center", va="center", fontsize=_TEXT_SIZE - 1)
    for layout, colour, style, diameter in zip(layouts, (VERMILLION, BLUE), (DASHED, "-"), _ARC_DIAMETERS, strict=True):
        angle, arm = layout.governor.angle, MM_PER_M * layout.governor.sleeve_arm
        end = centre - arm * math.sin(angle), arm * math.cos(angle)
        panel.plot([centre, end[0]], [0, end[1]], color=colour, linewidth=2.6, linestyle=style, zorder=3)
        panel.add_patch(Circle(end, 5, facecolor=PAPER, edgecolor=colour, linewidth=1.4, zorder=5))
        degrees = math.degrees(angle)
        panel.add_patch(Arc((centre, 0), diameter, diameter, theta1=90, theta2=90 + degrees, color=colour, linewidth=1.4))
    panel.add_patch(Circle((centre, 0), 5, facecolor=PAPER, edgecolor=INK, linewidth=1.4, zorder=6))
    used, right = (math.degrees(layout.governor.angle) for layout in layouts)
    panel.annotate_point((centre + 6, -30), f"used\n{used:.0f}°", color=VERMILLION, fontsize=_TEXT_SIZE, va="top", linespacing=1.1)
    panel.annotate_point((centre - 58, 36), f"right\n{right:.2f}°", color=BLUE, fontsize=_TEXT_SIZE, ha="right", linespacing=1.1)
    panel.annotate_point((-3, 140), "spindle axis", (-4, 0), ha="right", va="top", color=MUTED, fontsize=_TEXT_SIZE - 1, rotation=90)
    panel.show_region((64.0, -14.0), 112.0)


def _draw_forces(panel: Panel, layouts: list[HartungLayout]) -> None:
    """Draw the static sleeve force over the stroke with each angle."""
    labels = ((-15.0, 470.5), "right"), ((15.0, 501.5), "left")
    for layout, colour, style, (point, side) in zip(layouts, (VERMILLION, BLUE), (DASHED, "-"), labels, strict=True):
        forces = layout.static_forces / KILOGRAM_FORCE_1853
        panel.plot(np.degrees(layout.levers), forces, color=colour, linewidth=2.2, linestyle=style)
        degrees = math.degrees(layout.governor.angle)
        text = f"{degrees:.{0 if colour == VERMILLION else 2}f}°: changes by {100 * layout.spread:.1f} %"
        panel.annotate_point(point, text, color=colour, fontsize=_TEXT_SIZE, ha=side)
    panel.invert_xaxis()
    low, high = panel.get_ylim()
    panel.set(ylim=(low - 0.25 * (high - low), high + 0.35 * (high - low)), xticks=range(-15, 16, 5))


DRAWINGS: Mapping[Paper, Callable[[], Page]] = {
    Paper.REDTENBACHER: draw_flywheel,
    Paper.ZEHNDER: draw_osculation,
    Paper.MARKS: draw_cylinder_ends,
    Paper.DUBOIS: draw_bell_crank,
}
"""Function that draws the main error, by paper."""


def draw_erratum(paper: Paper) -> Page:
    """Draw the main error of a paper."""
    return DRAWINGS[paper]()


def errata_figures(errata: Errata) -> Mapping[str, Page]:
    """Draw the main error of each paper that has errata there, by the end of the name of its file."""
    return {f"_{paper}": draw_erratum(paper) for paper in errata.papers}

"""Figures of designed governors: Zehnder's construction of a pendulum governor, Hartnell's spring, and Hartung's spring lines."""

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from governor_mechanism.closed_form import hartnell as closed
from governor_mechanism.closed_form import parabolic, pendulum
from governor_mechanism.render.figures.page import (
    CHAIN_DOTTED,
    DASHED,
    DOTTED,
    MM_PER_M,
    SERIES_LINE_STYLES,
    Page,
    Panel,
    add_legend,
    polar_points,
)
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SANS_FONT, SERIES_COLOURS, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.studies.design import hartung as paper
from governor_mechanism.studies.design.hartnell import HartnellDesign, SleeveSpring
from governor_mechanism.studies.design.hartung import HartungDesign, build_hartung_layout
from governor_mechanism.studies.design.pendulum import TARGET_FRACTION, PendulumDesign
from governor_mechanism.studies.design.simulated import SimulatedPendulum
from governor_mechanism.studies.design.skeleton import select_deviations
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import KILOGRAM_FORCE_1853, RPM
from governor_mechanism.units.text_table import fill_places

_PATH_RECT = (0.065, 0.10, 0.42, 0.735)
_SPEED_RECT = (0.575, 0.535, 0.335, 0.30)
_RUN_SPEED_RECT = (0.575, 0.295, 0.335, 0.13)
_RUN_LIFT_RECT = (0.575, 0.10, 0.335, 0.155)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_N_CURVE_POINTS = 201
"""Points of a curve."""

_SUBTITLE = (
    "arms {governor.arm:.4g mm}{joint}, offset {governor.offset:.4g mm}, balls {governor.ball_mass:.4g} kg, sleeve "
    "{governor.sleeve_mass:.4g} kg; resistance {requirement.resistance:.4g} N, insensitivity {inputs.insensitivity:.3%}"
)

_LOW_COLOUR, _HIGH_COLOUR = BLUE, VERMILLION
"""Colours of the lowest and the highest position."""

_AXIS_NAME_RATIO = 0.1
"""Height of the name of the spindle axis over that of the governor."""

_DOWN = -math.pi / 2
"""Direction from which arm angles are measured, rad from the horizontal."""


def pendulum_figure(design: PendulumDesign, simulated: SimulatedPendulum) -> Page:
    """Draw the figure of a design; `save` writes it."""
    joint = "" if design.inputs.joint_ratio == 1 else fill_places(", joint at {joint_length:.4g mm}", design.governor)
    subtitle = fill_places(_SUBTITLE, design, joint=joint).replace(" -", " −")
    page = Page(11.5, 8.0, design.scene.title, subtitle, dpi=110, subtitle_y=0.912)
    _draw_path(page.add_panel(_PATH_RECT, "Distance from the spindle axis [mm]", "Height above the vertex of the parabolas [mm]"), design)
    _draw_speed(page.add_panel(_SPEED_RECT, "Lift of the sleeve [mm]", "Speed [rpm]"), design, simulated)
    _draw_run(
        page.add_panel(_RUN_SPEED_RECT, "", "Speed [rpm]"), page.add_panel(_RUN_LIFT_RECT, "Time [s]", "Lift [mm]"), design, simulated
    )
    page.write_footnote("after L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1–14, steps I to VIII", y=0.016)
    return page


def _draw_path(panel: Panel, design: PendulumDesign) -> None:
    """Draw the parabolas of both speeds, the path of the ball on its circle, and the governor in both positions, to one scale."""
    governor, start = design.governor, design.start
    suspension = governor.offset, start.ordinate + governor.arm * math.cos(start.arm_angle)
    centre = polar_points(math.pi / 2 + start.arm_angle, start.radius_of_curvature, (start.abscissa, start.ordinate))
    lowest_pin = suspension[1] - 2 * governor.joint_length * math.cos(start.arm_angle)
    span = design.arm_angles[1] - design.arm_angles[0]
    # Below the sleeve there is room for the name of the axis.
    ys = 0.0, suspension[1], lowest_pin - _AXIS_NAME_RATIO * (suspension[1] - lowest_pin)
    _show_all(panel, (0.0, suspension[0], 1.25 * design.ball_radii[1]), ys)
    bottom, top = panel.get_ylim()
    panel.plot([0, 0], [bottom, top], color=MUTED, linewidth=1.0, linestyle=CHAIN_DOTTED, zorder=1)
    panel.annotate_point((0, bottom), "spindle axis", (4, 4), color=MUTED, rotation=90, va="bottom", fontsize=9)
    for speed, colour in ((design.requirement.lowest_speed, _LOW_COLOUR), (design.requirement.highest_speed, _HIGH_COLOUR)):
        _draw_parabola(panel, design, speed, colour)
    angles = np.linspace(max(0.02, design.arm_angles[0] - 0.5 * span), design.arm_angles[1] + 0.5 * span, _N_CURVE_POINTS)
    if not design.is_osculating:
        circle = polar_points(_DOWN + angles, start.radius_of_curvature * MM_PER_M, _to_mm(centre))
        label = f"circle of curvature, $\\rho$ = {start.radius_of_curvature * MM_PER_M:.4g} mm"
        panel.plot(*circle, color=MUTED, linewidth=1.2, linestyle=DASHED, zorder=3, label=label)
    length = f"$l$ = {governor.arm * MM_PER_M:.4g} mm" + (" = $\\rho$" if design.is_osculating else "")
    path = polar_points(_DOWN + angles, governor.arm * MM_PER_M, _to_mm(suspension))
    panel.plot(*path, color=INK, linewidth=1.0, linestyle=DOTTED, zorder=4)
    swing = polar_points(_DOWN + np.linspace(*design.arm_angles, 60), governor.arm * MM_PER_M, _to_mm(suspension))
    panel.plot(*swing, color=INK, linewidth=2.4, zorder=4, label=f"path of the ball, {length}")
    for angle, colour, index in zip(design.arm_angles, (_LOW_COLOUR, _HIGH_COLOUR), (1, 2), strict=True):
        _draw_position(panel, design, suspension, angle, colour, index)
    panel.plot(*_to_mm(suspension), "o", color=INK, markerfacecolor=PAPER, markersize=6, zorder=7)
    panel.annotate_point(_to_mm(suspension), "suspension", (0, 6), ha="center", va="bottom", fontsize=9.5)
    add_legend(panel, {"color": INK, "math_fontfamily": "stix"}, loc="lower left", bbox_to_anchor=(0.0, 1.0), fontsize=8.5, ncols=2)


def _show_all(panel: Panel, xs: tuple[float, ...], ys: tuple[float, ...]) -> None:
    """Set limits (mm) that contain the points, to one scale on both axes."""
    left, right, bottom, top = (MM_PER_M * value for value in (min(xs), max(xs), min(ys), max(ys)))
    margin = 0.07 * max(right - left, top - bottom)
    left = left - margin
    right = right + margin
    bottom = bottom - margin
    top = top + margin
    missing = panel.aspect_ratio * (top - bottom) - (right - left)
    if missing > 0:
        left, right = left - 0.5 * missing, right + 0.5 * missing
    else:
        bottom = bottom + 0.5 * missing / panel.aspect_ratio
        top = top - 0.5 * missing / panel.aspect_ratio
    panel.set(xlim=(left, right), ylim=(bottom, top), aspect="equal")


def _draw_parabola(panel: Panel, design: PendulumDesign, speed: float, colour: str) -> None:
    """Draw the parabola of equilibrium at a speed, moved up or down so that it touches the path of the ball where this speed holds it."""
    governor = design.governor
    is_lowest = speed == design.requirement.lowest_speed
    angle, radius = (values[0 if is_lowest else 1] for values in (design.arm_angles, design.ball_radii))
    ratio = design.requirement.mass_ratio
    parameter = float(parabolic.double_parameter(spindle_speed=speed, mass_ratio=ratio, gravity=governor.gravity))
    suspension_height = design.start.ordinate + governor.arm * math.cos(design.start.arm_angle)
    shift = suspension_height - governor.arm * math.cos(angle) - radius**2 / parameter
    x = np.linspace(0.0, panel.get_xlim()[1] / MM_PER_M, _N_CURVE_POINTS)
    y = x**2 / parameter + shift
    label = f"parabola of {speed / RPM:.5g} rpm" + ("" if is_lowest else ", moved to the ball")
    panel.plot(x * MM_PER_M, y * MM_PER_M, color=colour, linewidth=1.3, linestyle="-" if is_lowest else DASHED, zorder=2, label=label)


def _draw_position(panel: Panel, design: PendulumDesign, suspension: Vec2, angle: float, colour: str, index: int) -> None:
    """Draw arm, link and sleeve of one side at an arm angle."""
    governor = design.governor
    style: dict[str, Any] = {"color": colour, "zorder": 5, "solid_capstyle": "round"}
    ball, joint = (polar_points(_DOWN + angle, length, suspension) for length in (governor.arm, governor.joint_length))
    pin = suspension[0], suspension[1] - 2 * governor.joint_length * math.cos(angle)
    points = [_to_mm(point) for point in (suspension, ball)]
    panel.plot(*zip(*points, strict=True), linewidth=1.6, **style)
    panel.plot(*zip(_to_mm(joint), _to_mm(pin), strict=True), linewidth=0.9, **style)
    x, y = _to_mm(pin)
    half = abs(x) + 0.035 * governor.arm * MM_PER_M
    panel.plot([-half, half], [y, y], linewidth=4.0, **style)
    panel.plot(*_to_mm(ball), "o", color=colour, markeredgecolor=PAPER, markersize=11, zorder=6)
    degrees, radius = math.degrees(angle), MM_PER_M * ball[0]
    text = f"$\\alpha_{index}$ = {degrees:.2f}°\n$x_{index}$ = {radius:.1f} mm"
    offset, side = ((11, -4), "top") if index == 1 else ((11, -5), "center")
    panel.annotate_point(_to_mm(ball), text, offset, color=colour, va=side, fontsize=9.5, linespacing=1.3)
    panel.annotate_point((half, y), f"sleeve {'low' if index == 1 else 'high'}", (5, 0), color=colour, va="center", fontsize=9)


def _to_mm(point: Vec2) -> Vec2:
    return MM_PER_M * point[0], MM_PER_M * point[1]


def _draw_speed(panel: Panel, design: PendulumDesign, simulated: SimulatedPendulum) -> None:
    """Draw the speed of rest over the lift with the band in which the resistance holds the sleeve, and the limits of VII and VIII."""
    fractions = np.linspace(0.0, 1.0, _N_CURVE_POINTS)
    low, high = (math.cos(angle) for angle in design.arm_angles)
    angles = np.arccos(low + fractions * (high - low))
    speeds = np.asarray(pendulum.equilibrium_speed(design.governor, arm_angle=angles)) / RPM
    lifts = fractions * design.sleeve_lift * MM_PER_M
    falling, rising = (speeds * math.sqrt(1 + sign * design.inputs.insensitivity) for sign in (-1, 1))
    label = f"held by {design.requirement.resistance:.3g} N: (1) and (2)"
    panel.fill_between(lifts, falling, rising, color=SKY, alpha=0.25, linewidth=0, label=label)
    panel.plot(lifts, speeds, color=INK, linewidth=1.8, label="speed of rest, (3)")
    trials = [trial.arm_angle for trial in design.trials]
    trial_lifts = design.sleeve_lift * MM_PER_M * (low - np.cos(trials)) / (low - high)
    panel.plot(trial_lifts, [trial.speed / RPM for trial in design.trials], "o", color=INK, markersize=4, label="tried in VI", zorder=4)
    found = {number.quantity: number.found for number in simulated.numbers}
    ends = [found[f"speed of rest, {end} position"] for end in ("lowest", "highest")]
    marker: dict[str, Any] = {"color": GREEN, "markerfacecolor": "none", "markersize": 11, "markeredgewidth": 1.5, "zorder": 5}
    panel.plot(lifts[[0, -1]], ends, "o", label="statics of the scene", clip_on=False, **marker)
    for limit, text, colour in zip(design.speed_limits, ("$n_1''$", "$n_2'$"), (_LOW_COLOUR, _HIGH_COLOUR), strict=True):
        panel.axhline(limit / RPM, color=colour, linewidth=0.9, linestyle=CHAIN_DOTTED)
        panel.annotate_point((lifts[-1], limit / RPM), f"{text} {limit / RPM:.6g}", (7, 0), color=colour, va="center", fontsize=9.5)
    panel.set_xlim(0.0, lifts[-1])
    add_legend(panel, {"color": INK}, loc="lower left", bbox_to_anchor=(-0.02, 0.99), ncols=2, fontsize=8, columnspacing=1.2)
    panel.write_heading("Speed over the lift", y=1.19)


def _draw_run(speed_panel: Panel, lift_panel: Panel, design: PendulumDesign, simulated: SimulatedPendulum) -> None:
    """Draw speed and lift of the run: held until the band is left, then rising to the place of rest."""
    run, breakaway = simulated.run, simulated.breakaway[0]
    times = run.times
    speed = run.readings["spindle_speed"] / RPM
    begins = design.equilibrium_speed(design.middle_angle) * math.sqrt(1 + design.inputs.insensitivity) / RPM
    speed_panel.plot(times, speed, color=GREEN, linewidth=1.6)
    speed_panel.axhline(begins, color=MUTED, linewidth=0.9, linestyle=DASHED)
    text = f"by (1) it breaks away at {begins:.6g} rpm"
    speed_panel.write_note(text, (times[-1], begins), (-3, -11), ha="right", color=MUTED)
    speed_panel.tick_params(labelbottom=False)
    middle = float(run.readings["sleeve_lift"][0])
    lift = (run.readings["sleeve_lift"] - middle + 0.5 * design.sleeve_lift) * MM_PER_M
    wanted = TARGET_FRACTION * design.sleeve_lift * MM_PER_M
    lift_panel.plot(times, lift, color=SERIES_COLOURS[-1], linewidth=1.6)
    lift_panel.axhline(wanted, color=MUTED, linewidth=0.9, linestyle=DASHED)
    lift_panel.write_note(f"by (1) it rises to {wanted:.4g} mm", (times[0], wanted), (3, 3), color=MUTED)
    lift_panel.set_ylim(0.42 * design.sleeve_lift * MM_PER_M, 0.83 * design.sleeve_lift * MM_PER_M)
    for panel in (speed_panel, lift_panel):
        panel.axvline(breakaway, color=MUTED, linewidth=0.8, linestyle=DOTTED)
        panel.set_xlim(float(times[0]), float(times[-1]))
    found = {number.quantity: number.found for number in simulated.numbers}["(1) breaks away half way up"]
    note = f"breaks away at {found:.6g} rpm"
    lift_panel.write_note(note, (breakaway, lift_panel.get_ylim()[0]), (4, 4), color=INK)
    speed_panel.write_heading("Simulated rise of the speed from half the lift", y=1.08)


_N_HARTNELL_POINTS = 121
"""Points of a curve over the travel."""


_HARTNELL_SUBTITLE = (
    "balls {inputs.ball_mass:.4g} kg, arms {inputs.ball_arm:.4g/mm} and {inputs.sleeve_arm:.4g mm} at {inputs.bell_crank_angle:.4g deg}; "
    "spring {exact.rate:.4g N/mm} with {exact.forces[0]:.4g} N in the lowest position"
)


def hartnell_figure(design: HartnellDesign) -> Page:
    """Draw the figure of a design; `save` writes it."""
    page = Page(9.6, 5.4, design.scene.title, fill_places(_HARTNELL_SUBTITLE, design), dpi=120, subtitle_y=0.895)
    angles = np.linspace(*design.travel.arm_angles, _N_HARTNELL_POINTS)
    _draw_force(page.add_panel((0.075, 0.145, 0.395, 0.575), "Radius of the balls [mm]", "Force on each ball [N]"), design, angles)
    _draw_hartnell_speed(
        page.add_panel((0.575, 0.145, 0.395, 0.575), "Lift of the sleeve [mm]", "Speed of equilibrium [rpm]"), design, angles
    )
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


def _draw_hartnell_speed(panel: Panel, design: HartnellDesign, angles: FloatArray) -> None:
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
    """Draw the astatic spring forces at both speeds, and the straight spring line between them; `save` writes it."""
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
    """Draw the static sleeve force over the stroke, for several bell-crank angles and the best one; `save` writes it."""
    layouts = [(angle, build_hartung_layout(design.inputs, math.radians(angle))) for angle in _shown_angles(design)]
    page = _new_page("Uniformity of the static sleeve force", "each angle with straight spring lines through both speeds")
    labels = "Lever angle (outward) [deg]", "Static sleeve force S [kgf]"
    panel = page.add_panel((0.09, 0.15, 0.375, 0.60), *labels)
    enlarged = page.add_panel((0.555, 0.15, 0.345, 0.60), *labels)
    enlarged.write_heading("The most uniform ones, enlarged", y=1.03)
    lines = zip((*SERIES_COLOURS, INK, MUTED), (*SERIES_LINE_STYLES, "-", DASHED), strict=True)
    for (angle, layout), (colour, style) in zip(layouts, lines, strict=False):
        best = abs(math.radians(angle) - design.best_angle) < math.radians(0.01)
        text = f"{angle:.6g} deg: {100 * layout.spread:.3g} %" + (", the best" if best else "")
        lever_angles = np.degrees(layout.levers)
        forces = layout.static_forces / KILOGRAM_FORCE_1853
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

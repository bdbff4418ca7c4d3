"""Figure of a designed pendulum governor: Zehnder's construction, the speed over the lift, and the simulated rise of the speed."""

import math
from typing import Any

import numpy as np

from governor_mechanism.closed_form import parabolic
from governor_mechanism.closed_form.pendulum import dynamics
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, DOTTED, MM_PER_M, Page, Panel, add_legend, polar_points
from governor_mechanism.render.geometry.primitives import Vec2
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.design.pendulum import TARGET_FRACTION, PendulumDesign
from governor_mechanism.studies.design.simulated_governors import SimulatedPendulum
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.places import fill_places

_PATH_RECT, _SPEED_RECT = (0.065, 0.10, 0.42, 0.735), (0.575, 0.535, 0.335, 0.30)
_RUN_SPEED_RECT, _RUN_LIFT_RECT = (0.575, 0.295, 0.335, 0.13), (0.575, 0.10, 0.335, 0.155)
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
    """Draw the figure of a design.

    Result: the figure; `save` writes it.
    """
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
    left, right, bottom, top = left - margin, right + margin, bottom - margin, top + margin
    missing = panel.aspect_ratio * (top - bottom) - (right - left)
    if missing > 0:
        left, right = left - 0.5 * missing, right + 0.5 * missing
    else:
        bottom, top = bottom + 0.5 * missing / panel.aspect_ratio, top - 0.5 * missing / panel.aspect_ratio
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
    speeds = np.asarray(dynamics.equilibrium_speed(design.governor, arm_angle=angles)) / RPM
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

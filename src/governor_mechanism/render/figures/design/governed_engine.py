"""Figure of a designed engine under its governor: speed along the sleeve, Vyshnegradskii's plane, and the simulated change of load."""

import math

import numpy as np

from governor_mechanism.closed_form.pendulum import dynamics, sizing
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Page, Panel, add_legend
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.design.governed_engine import GovernedEngineDesign
from governor_mechanism.studies.design.simulated_engines import SimulatedEngine
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.places import fill_places

_N_CURVE_POINTS = 201
"""Points of a curve."""

_PLANE_LIMIT_RATIO = 1.35
"""Sides of the plane of x and y over the largest values shown."""

_SPEED_RECT, _PLANE_RECT, _STEP_RECT = (0.075, 0.535, 0.40, 0.325), (0.585, 0.535, 0.385, 0.325), (0.075, 0.105, 0.765, 0.325)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_TITLE = "Governed engine of {horsepower:.4g} PS at {inputs.speed:.4g rpm} with a droop of {inputs.droop:.3%}"
_SUBTITLE = (
    "flywheel {flywheel.inertia:.5g} kg m²; arms {governor.governor.arm:.4g mm}, offset {governor.governor.offset:.4g mm}, balls "
    "{governor.governor.ball_mass:.4g} kg, sleeve {governor.governor.sleeve_mass:.4g} kg; gear {governor.gear_ratio:.4g}; dashpot "
    "{dashpot.damping:.4g} N s/m"
)

_LOAD_COLOURS = (VERMILLION, GREEN, INK)
"""Colours of full, half and no load."""


def governed_engine_figure(design: GovernedEngineDesign, simulated: SimulatedEngine) -> Page:
    """Draw the figure of a design.

    Result: the figure; `save` writes it.
    """
    page = Page(11.0, 8.0, fill_places(_TITLE, design), fill_places(_SUBTITLE, design).replace(" -", " −"), dpi=110, subtitle_y=0.912)
    _draw_speed(page.add_panel(_SPEED_RECT, "Sleeve lift [mm]", "Equilibrium speed of the shaft [rpm]"), design)
    _draw_plane(page.add_panel(_PLANE_RECT, "$x = a/c^{1/3}$", "$y = b/c^{2/3}$"), design)
    _draw_step(page.add_panel(_STEP_RECT, "Time [s]", "Speed of the shaft [rpm]"), design, simulated)
    free, resisted = simulated.cyclic.overshoot, simulated.resisted.overshoot
    page.write_footnote(
        f"load falls from the whole to the half: overshoot {free:.2%} of the change of speed, {resisted:.2%} with the resistance at the "
        f"sleeve; speed fluctuation at full load {simulated.fluctuation:.4%}, wanted {simulated.wanted_fluctuation:.4%}"
    )
    return page


def _draw_speed(panel: Panel, design: GovernedEngineDesign) -> None:
    """Draw the equilibrium speed over the lift of the sleeve, with the band of insensitivity and the loads."""
    governor = design.governor
    (lowest, _), (highest, _) = design.throttle_points
    lifts = np.linspace(lowest, highest, _N_CURVE_POINTS)
    angles = sizing.angle_of_lift(arm=governor.governor.arm, lift=lifts)
    speeds = np.asarray(dynamics.equilibrium_speed(governor.governor, arm_angle=angles)) / governor.gear_ratio / RPM
    # Zehnder's (1) and (2); a resistance above the weight of the sleeve holds it at standstill too.
    low, high = (speeds * math.sqrt(max(0.0, 1 + sign * governor.insensitivity)) for sign in (-1, 1))
    panel.fill_between(lifts * MM_PER_M, low, high, color=SKY, alpha=0.25, linewidth=0)
    panel.plot(lifts * MM_PER_M, speeds, color=BLUE, linewidth=1.8)
    note = f"band: {design.inputs.resistance:.3g} N hold the sleeve, insensitivity {governor.insensitivity:.3%}"
    panel.write_note(note, (0.985, 0.03), xycoords="axes fraction", ha="right", color=INK)
    panel.write_heading("Speed over the travel of the sleeve", y=1.04)
    for setting, colour in zip((design.throttle[0], design.throttle[2], design.throttle[-1]), _LOAD_COLOURS, strict=True):
        point = setting.lift * MM_PER_M, setting.speed / RPM
        panel.plot(*point, "o", color=colour, markeredgecolor=PAPER, markersize=7, zorder=5)
        side = "right" if setting.load_fraction < 0.5 else "left"
        offset = (-9 if side == "right" else 9, 5 if side == "right" else -12)
        panel.annotate_point(point, f"{setting.load_fraction:.0%} load, throttle {setting.opening:.3f}", offset, ha=side, color=colour)
    panel.set_xlim(lifts[0] * MM_PER_M, lifts[-1] * MM_PER_M)


def _draw_plane(panel: Panel, design: GovernedEngineDesign) -> None:
    """Draw the limit x y = 1, the way of each load with a growing dashpot, and the chosen one."""
    motions = design.dashpot.motions
    x_limit, y_limit = (_PLANE_LIMIT_RATIO * max(3.0, *values) for values in (_values(design, "x"), _values(design, "y")))
    limit = np.linspace(1 / y_limit, x_limit, _N_CURVE_POINTS)
    panel.fill_between(limit, 1 / limit, y_limit, color=GREEN, alpha=0.08, linewidth=0)
    panel.fill_between([0.0, *limit], 0.0, [y_limit, *(1 / limit)], color=VERMILLION, alpha=0.10, linewidth=0)
    panel.plot(limit, 1 / limit, color=INK, linewidth=1.4)
    # Above the cusp (3, 3) between these branches all roots are real; they are traced by the double root -r: x = 2 r + 1 / r^2.
    doubles = np.geomspace(0.1, 10.0, 4 * _N_CURVE_POINTS)
    panel.plot(
        2 * doubles + doubles**-2, doubles**2 + 2 / doubles, color=MUTED, linewidth=1.0, linestyle=DASHED, label="all roots real between"
    )
    for motion, colour in zip(motions, _LOAD_COLOURS, strict=True):
        panel.plot([0.0, x_limit], [motion.y, motion.y], color=colour, linewidth=0.8, linestyle=CHAIN_DOTTED)
        label = f"{motion.load_fraction:.0%} load: decay {motion.decay_rate:.3f} 1/s"
        panel.plot(motion.x, motion.y, "o", color=colour, markeredgecolor=PAPER, markersize=7, zorder=5, linestyle="none", label=label)
    panel.write_note("stable", (0.25, 0.93), xycoords="axes fraction", color=INK)
    add_legend(panel, {"color": INK}, loc=(0.40, 0.2), fontsize=8.5)
    panel.write_note("hunts", (0.02, 0.03), xycoords="axes fraction", color=INK)
    panel.annotate_point((x_limit / 3, 3 / x_limit), "$x\\,y = 1$", (4, 4))
    panel.set(xlim=(0.0, x_limit), ylim=(0.0, y_limit))
    panel.write_heading("Vyshnegradskii's plane; a stronger dashpot increases x", y=1.04)


def _values(design: GovernedEngineDesign, name: str) -> list[float]:
    return [float(getattr(motion, name)) for motion in design.dashpot.motions]


def _draw_step(panel: Panel, design: GovernedEngineDesign, simulated: SimulatedEngine) -> None:
    """Draw the speed when the load falls: that of every instant, its mean over a turn, and that with the mean torque."""
    cyclic, mean_torque = simulated.cyclic, simulated.mean_torque
    begin, times = cyclic.change_times[0], cyclic.run.times
    # The settling of the start is of no interest; some turns before the change are.
    first = max(0.0, begin - 0.3 * (float(times[-1]) - begin))
    panel.plot(times, np.asarray(cyclic.run.readings["engine.shaft_speed"]) / RPM, color=SKY, linewidth=0.8, label="cyclic torque")
    panel.plot(cyclic.average.times, cyclic.average.speeds / RPM, color=BLUE, linewidth=1.8, label="mean over a turn")
    mean_speeds = np.asarray(mean_torque.run.readings["engine.shaft_speed"]) / RPM
    panel.plot(mean_torque.run.times, mean_speeds, color=INK, linewidth=1.1, linestyle=DASHED, label="mean torque")
    resisted = simulated.resisted.average
    panel.plot(
        resisted.times, resisted.speeds / RPM, color=SERIES_COLOURS[-1], linewidth=1.5, linestyle=CHAIN_DOTTED, label="with the resistance"
    )
    for speed, colour, name in zip(simulated.wanted_speeds, _LOAD_COLOURS, ("full", "half", "no"), strict=True):
        panel.axhline(speed / RPM, color=colour, linewidth=0.8, linestyle=CHAIN_DOTTED)
        text = f"wanted at {name} load:\n{speed / RPM:.4f} rpm"
        panel.write_note(text, (float(times[-1]), speed / RPM), (5, 0), va="center", color=colour, annotation_clip=False)
    panel.axvline(begin, color=MUTED, linewidth=0.8)
    panel.set_xlim(first, float(times[-1]))
    panel.write_note("load to the half", (begin, panel.get_ylim()[0]), (4, 4), color=MUTED)
    panel.write_heading("Simulated change of load", y=1.04)
    add_legend(panel, {"color": INK}, loc="lower right", bbox_to_anchor=(1.0, 0.99), ncols=4, fontsize=8.5)

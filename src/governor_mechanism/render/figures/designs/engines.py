"""Figures of designed engines: the plate of a flywheel, and an engine under its governor with a change of load."""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from governor_mechanism.closed_form import flywheel_engine as closed
from governor_mechanism.closed_form import pendulum, pendulum_sizing
from governor_mechanism.closed_form.flywheel_engine import AirEngine
from governor_mechanism.render.figures.page import CHAIN_DOTTED, DASHED, MM_PER_M, Page, Panel, Plate, add_legend
from governor_mechanism.render.figures.plates.engines import FOURTH_RECT, N_PER_KN, PA_PER_BAR, SPEED_RECT, EnginePlate, mark_extreme
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.design.flywheel import FlywheelDesign, PaperComparison
from governor_mechanism.studies.design.governed_engine import GovernedEngineDesign
from governor_mechanism.studies.design.simulated import SimulatedEngine, SimulatedWheel
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM
from governor_mechanism.units.text_table import fill_places

_CAPTIONS = (
    "Tangential force of the air at the crank pin, in the intervals 1 to 4, and load",
    "Indicator diagrams of expansion cylinder and pump",
    "Simulated speed of the shaft, with the load that closes the cycle",
)
_BRACKET_CAPTION = "The terms of the bracket: work from $\\alpha$ to $\\beta$, divided by $A\\,p\\,L$"
_WORK_CAPTION = "Work that the flywheel stores"

_TERM_COLUMNS = (0.57, 0.8, 1.0)
"""Right ends of the columns of numbers, in fractions of their panel."""

_WHEEL_STYLES = (VERMILLION, CHAIN_DOTTED), (BLUE, "-"), (INK, DASHED)
"""Colours and line styles of the flywheels."""

_N_STROKE_POINTS = 721
"""Number of points of each curve."""


def draw_flywheel_plate(
    design: FlywheelDesign,
    simulated: Sequence[SimulatedWheel],  # the flywheel as it ran, or those by each of the paper's sums
    # the paper's numbers, if the design is that of the paper: its flywheel is drawn beside the right one, and
    # its terms are printed
    comparison: PaperComparison | None = None,
) -> Plate:
    """Draw the plate of a design; `save` writes it."""
    captions = (*_CAPTIONS, _WORK_CAPTION if comparison is None else _BRACKET_CAPTION)
    title = "Flywheel of an air-expansion engine"
    plate = EnginePlate("Redtenbacher’s flywheel", title, "after Die Luftexpansions-Maschine, Mannheim 1853", captions)
    _draw_forces(plate, design)
    _draw_cylinders(plate, design.engine)
    _draw_speeds(plate.add_plate_panel(SPEED_RECT, "Crank angle $\\varphi$ [deg]", "Shaft speed [rad/s]"), design, simulated)
    if comparison is None:
        _draw_stored_work(plate.add_plate_panel(FOURTH_RECT, "Crank angle $\\varphi$ [deg]", "Stored work $E/ApL$ [1]"), design)
    else:
        _write_terms(plate.add_plate_panel(FOURTH_RECT), comparison)
    plate.write_dimensions(_dimensions_text(design))
    return plate


def _dimensions_text(design: FlywheelDesign) -> str:
    engine, atmosphere = design.engine, design.engine.atmospheric_pressure
    return (
        f"$p$ = {engine.supply_pressure / atmosphere:.4g},  $r$ = {engine.back_pressure / atmosphere:.4g},  "
        f"$R$ = {engine.load_pressure / atmosphere:.5g} atmospheres;  cut-off {engine.cut_off:.4g},  clearances "
        f"{engine.clearance:.3g} and {engine.pump_clearance:.3g};  $ApL$ = {engine.full_pressure_work / 1e3:.4g} kJ;  "
        f"flywheel {design.inertia:.5g} kg m²,  $\\mu$ = {design.energy_ratio:.4g}"
    )


def _angles(n_strokes: int = 1) -> FloatArray:
    """Return crank angles (rad) of some strokes, without the last dead centre, where the next stroke would begin."""
    return np.linspace(0.0, n_strokes * math.pi, _N_STROKE_POINTS * n_strokes, endpoint=False)


def _draw_forces(plate: EnginePlate, design: FlywheelDesign) -> None:
    """Draw the tangential force over a stroke, the load line, and the excess area between the angles of extreme speed."""
    engine, extremes = design.engine, design.fluctuation
    crank = engine.stroke / 2 * N_PER_KN
    angles = _angles()
    force = np.asarray(closed.gas_torque(engine, crank_angle=angles)) / crank
    load = engine.load_torque / crank
    inside = np.mod(angles - extremes.slowest_angle, math.pi) <= extremes.fastest_angle - extremes.slowest_angle
    panel, low, high = plate.add_force_panel(np.degrees(angles), force, np.full_like(force, load), inside, 180)
    panel.axhline(load, color=VERMILLION, linewidth=1.5, zorder=3)
    for limit in design.interval_limits:
        panel.axvline(math.degrees(limit), color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=1)
    edges = [0.0, *(math.degrees(limit) for limit in design.interval_limits), 180.0]
    for number, (left, right) in enumerate(pairwise(edges), start=1):
        panel.annotate_point(((left + right) / 2, high + 0.1 * (high - low)), f"{number}", ha="center", color=MUTED, fontsize=10)
    for angle, letter, offset in ((extremes.slowest_angle, "\\alpha", (8, -15)), (extremes.fastest_angle, "\\beta", (9, 6))):
        point = math.degrees(angle % math.pi), load
        mark_extreme(panel, point, f"${letter}$ = {point[0]:.4g}°", offset, zorder=6)
    middle = math.degrees((extremes.slowest_angle + extremes.fastest_angle) / 2 % math.pi)
    text = f"excess work {extremes.energy / 1e3:.4g} kJ\n= {design.bracket:.4f} $ApL$"
    panel.annotate_point((middle, load + 0.35 * (high - load)), text, ha="center", linespacing=1.4)
    panel.annotate_point((178, load), "load", (0, 5), ha="right", color=VERMILLION)


def _draw_cylinders(plate: EnginePlate, engine: AirEngine) -> None:
    """Draw the pressure in one end of cylinder and pump over a turn; the pump takes in on one stroke and compresses on the stroke back."""
    angles = _angles()
    travel = np.asarray(closed.piston_travel(crank_angle=angles))
    laws = (closed.expansion_pressure, closed.delivery_pressure, closed.suction_pressure)
    expansion, compression, intake = (np.asarray(law(engine, crank_angle=angles)) for law in laws)
    pressures = engine.supply_pressure, engine.atmospheric_pressure
    exhaust = np.full_like(expansion, engine.back_pressure)
    panel = plate.add_indicator(0, "expansion cylinder", BLUE, travel, expansion, exhaust, pressures)
    at, highest = 100 * engine.cut_off, engine.supply_pressure / PA_PER_BAR
    panel.plot([at, at], [0.0, highest], color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=1)
    panel.annotate_point((at, highest), "cut-off", (4, -2), fontsize=9.5, color=MUTED)
    homeward = np.interp(1 - travel, travel, compression)
    plate.add_indicator(1, "compression pump", VERMILLION, travel, homeward, intake, pressures)


def _draw_speeds(panel: Panel, design: FlywheelDesign, simulated: Sequence[SimulatedWheel]) -> None:
    """Draw the simulated speed over two turns with each flywheel, and the speeds that mu allows."""
    panel.axhspan(design.lowest_speed, design.highest_speed, color=GREEN, alpha=0.13, linewidth=0, zorder=1)
    panel.axhline(design.inputs.speed, color=MUTED, linewidth=0.8, linestyle=CHAIN_DOTTED, zorder=2)
    low = min(float(wheel.speeds.min()) for wheel in simulated)
    high = max(float(wheel.speeds.max()) for wheel in simulated)
    spread, line = high - low, 0.1 * (high - low)
    panel.set(xlim=(0, 720), ylim=(low - 0.12 * spread, high + 0.12 * spread + (len(simulated) + 1) * line), xticks=range(0, 721, 90))
    for index, (wheel, (colour, style)) in enumerate(zip(simulated, _WHEEL_STYLES, strict=False)):
        panel.plot(np.degrees(wheel.crank_angles), wheel.speeds, color=colour, linewidth=1.8, linestyle=style, zorder=4)
        text = f"{wheel.sized_by}, {wheel.inertia:.4g} kg m²: coefficient {wheel.coefficient:.4f}"
        panel.annotate_point((8, high + (len(simulated) + 1 - index) * line - 0.03 * spread), text, color=colour, va="center", fontsize=10)
    text = f"shaded: {'' if design.inputs.inertia else 'allowed, '}$\\mu$ = {design.energy_ratio:.4g}"
    panel.annotate_point((8, high + line - 0.03 * spread), text, color=GREEN, va="center", fontsize=10)


def _draw_stored_work(panel: Panel, design: FlywheelDesign) -> None:
    """Draw the stored work over a stroke, with its extremes."""
    engine = design.engine
    extremes = design.fluctuation
    angles = _angles()
    unit = engine.full_pressure_work
    panel.plot(np.degrees(angles), np.asarray(closed.stored_work(engine, crank_angle=angles)) / unit, color=BLUE, linewidth=2.0)
    panel.axhline(0.0, color=MUTED, linewidth=0.8, linestyle=CHAIN_DOTTED)
    for angle, letter, offset in ((extremes.slowest_angle, "\\alpha", (8, -16)), (extremes.fastest_angle, "\\beta", (0, 7))):
        point = math.degrees(angle % math.pi), float(closed.stored_work(engine, crank_angle=angle % math.pi)) / unit
        mark_extreme(panel, point, f"${letter}$: ${point[1]:.4g}$", offset)
    low, high = panel.get_ylim()
    panel.set(xlim=(0, 180), ylim=(low - 0.08 * (high - low), high + 0.1 * (high - low)), xticks=range(0, 181, 30))


def _write_terms(panel: Panel, comparison: PaperComparison) -> None:
    """Write the seven terms, their sum and the coefficient, printed and recomputed; the wrong ones are coloured."""
    exact = (*comparison.exact_terms, sum(comparison.exact_terms), comparison.exact_coefficient)
    n_terms = len(comparison.exact_terms)
    names = [term.quantity for term in comparison.terms]
    names[-1] = "coefficient of $\\mu N/n$"
    panel.set(xlim=(0, 1), ylim=(-1.6 - len(names), 0))
    for x, text in zip(_TERM_COLUMNS, ("printed", "at 3° and 95°", "exact angles"), strict=True):
        panel.annotate_point((x, -0.5), text, ha="right", va="center", color=MUTED, fontstyle="italic")
    for index, (name, term, value) in enumerate(zip(names, comparison.terms, exact, strict=True)):
        height = -1.6 - index - 0.3 * (index >= n_terms)
        is_wrong = index >= n_terms or term == comparison.wrong_term
        panel.annotate_point((0, height), name, va="center")
        for x, number, digits in zip(_TERM_COLUMNS, (term.printed, term.recomputed, value), (4, 6, 6), strict=True):
            text = f"{number:.{digits if abs(number) < 1 else 0}f}".replace("-", "−")
            colour = VERMILLION if is_wrong and number == term.printed else INK
            panel.annotate_point((x, height), text, ha="right", va="center", color=colour, fontweight="bold" if is_wrong else "normal")
    panel.plot([0, 1], [-1.3 - n_terms] * 2, color=INK, linewidth=0.7)


_N_CURVE_POINTS = 201
"""Points of a curve."""

_PLANE_LIMIT_RATIO = 1.35
"""Sides of the plane of x and y over the largest values shown."""

_SPEED_RECT = (0.075, 0.535, 0.40, 0.325)
_PLANE_RECT = (0.585, 0.535, 0.385, 0.325)
_STEP_RECT = (0.075, 0.105, 0.765, 0.325)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_TITLE = "Governed engine of {inputs.power:.4g PS} at {inputs.speed:.4g rpm} with a droop of {inputs.droop:.3%}"
_SUBTITLE = (
    "flywheel {flywheel.inertia:.5g} kg m²; arms {governor.governor.arm:.4g mm}, offset {governor.governor.offset:.4g mm}, balls "
    "{governor.governor.ball_mass:.4g} kg, sleeve {governor.governor.sleeve_mass:.4g} kg; gear {governor.gear_ratio:.4g}; dashpot "
    "{dashpot.damping:.4g} N s/m"
)

_LOAD_COLOURS = (VERMILLION, GREEN, INK)
"""Colours of full, half and no load."""


def governed_engine_figure(design: GovernedEngineDesign, simulated: SimulatedEngine) -> Page:
    """Draw the figure of a design; `save` writes it."""
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
    angles = pendulum_sizing.angle_of_lift(arm=governor.governor.arm, lift=lifts)
    speeds = np.asarray(pendulum.equilibrium_speed(governor.governor, arm_angle=angles)) / governor.gear_ratio / RPM
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

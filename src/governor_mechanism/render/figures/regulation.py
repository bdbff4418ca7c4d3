"""Figures of the regulation studies: cyclic sleeve motion, clearance, settling, jump through a fold, change of load, stability map."""

import math
from typing import Any

import numpy as np
from matplotlib.colors import TwoSlopeNorm
from matplotlib.patches import Rectangle

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.render.artists import OVER_COLOUR_MAP
from governor_mechanism.render.figures.page import (
    BAND_OPACITY,
    DASHED,
    MM_PER_M,
    SERIES_LINE_STYLES,
    SERIES_MARKERS,
    Page,
    Panel,
    PanelRect,
    add_legend,
    use_plain_decades,
)
from governor_mechanism.render.machines.engine_room.arrangement import engine_torque, find_governed_engine
from governor_mechanism.render.range_bands import COLUMN_WIDTH, make_range_band
from governor_mechanism.render.shown_readings import format_label
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, RULE, SERIES_COLOURS, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.studies.regulation.cyclic_irregularity import ClearanceStudy, CyclicMotionStudy
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine
from governor_mechanism.studies.regulation.governor_studies import GovernorStudies
from governor_mechanism.studies.regulation.load_change import SETTLING_BAND, LoadChangeStudy, Verdict
from governor_mechanism.studies.regulation.speed_changes import SETTLING_TOLERANCE, FoldJumpStudy, SettlingStudy
from governor_mechanism.studies.regulation.stability_map import StabilityMap
from governor_mechanism.studies.sweep.parameters import SweepAxis
from governor_mechanism.types import FloatArray
from governor_mechanism.units.constants import RPM

_PAGE_SIZE = 7.2, 5.0
"""Width and height of a figure, inches."""

_PANEL_RECT = (0.11, 0.14, 0.85, 0.69)
"""Rectangle of the panel in a figure of one panel, in fractions of the figure."""

_RATIO_RECT, _REST_RECT = (0.11, 0.255, 0.85, 0.55), (0.11, 0.15, 0.85, 0.07)
"""Rectangles of the panel of ratios and of the strip below it for a sleeve at rest, whose ratio has no logarithm."""


def governor_studies_figure(studies: GovernorStudies) -> Figure:
    """Draw the results of a study of some governors in one figure."""
    first, *others = studies.results
    figure: Figure = first.plot(*others)
    return figure


def cyclic_figure(study: CyclicMotionStudy) -> Page:
    """Draw the sleeve amplitude against speed fluctuation over insensitivity band."""
    page = Page(*_PAGE_SIZE, "The sleeve moves when the speed fluctuation exceeds the insensitivity band", study.title)
    panel = _add_panel(page, _PANEL_RECT, "Speed fluctuation / insensitivity band [1]", "Sleeve stroke in a turn [mm]")
    order = np.argsort(study.fluctuation_ratios)
    fluctuation_ratios = study.fluctuation_ratios[order]
    amplitudes = study.amplitudes[order] * MM_PER_M
    panel.axvspan(0.0, study.threshold, color=SKY, alpha=0.18, linewidth=0)
    panel.plot(fluctuation_ratios, amplitudes, "o-", color=BLUE, linewidth=1.6, markersize=4)
    highest = float(amplitudes.max())
    panel.set(xlim=(0.0, float(fluctuation_ratios.max())), ylim=(-0.03 * highest, 1.05 * highest))
    transform = panel.get_xaxis_transform()
    panel.write_note("at rest", (study.threshold / 2, 0.10), xycoords=transform, ha="center", color=INK)
    panel.axvline(study.threshold, color=VERMILLION, linewidth=1.0, linestyle=DASHED)
    panel.write_note(f"threshold {study.threshold:.6f}", (study.threshold, 0.30), (6, 0), xycoords=transform, color=VERMILLION)
    excess = fluctuation_ratios - study.threshold
    above_threshold = (excess > 0) & (amplitudes > 0)
    if np.sum(above_threshold) > 2:
        _draw_onset(page, study, excess[above_threshold], np.sort(amplitudes[above_threshold]))
    page.write_footnote(f"band {study.insensitivity_band:.4f} of the mean speed; last of {study.n_turns + 1} turns")
    return page


def _draw_onset(page: Page, study: CyclicMotionStudy, excess: FloatArray, amplitudes: FloatArray) -> None:
    """Draw the amplitudes beyond the threshold on logarithmic scales."""
    # The labels of the inset stand on paper, not on the shading of the panel.
    page.add_artist(Rectangle((0.115, 0.395), 0.37, 0.415, transform=page.transFigure, facecolor=PAPER, linewidth=0, zorder=0.5))
    inset = _add_panel(page, (0.20, 0.48, 0.265, 0.30), "Excess over the threshold [1]", "Stroke [mm]", size=8)
    inset.set_zorder(1)
    inset.loglog(excess, amplitudes, "o", color=BLUE, markersize=3)
    exponent = study.onset_exponent
    if np.isfinite(exponent.value):
        near_threshold = excess < 0.01
        line = amplitudes[near_threshold][-1] * (excess / excess[near_threshold][-1]) ** exponent.value
        inset.loglog(excess, line, color=VERMILLION, linewidth=1.0, linestyle=DASHED, zorder=1)
        inset.write_note(f"exponent {exponent}", (0.97, 0.06), xycoords="axes fraction", ha="right", color=VERMILLION, fontsize=7.5)


def clearance_figure(*studies: ClearanceStudy) -> Page:
    """Draw the sleeve amplitude over that without clearance, against clearance, one line per study."""
    for study in studies:
        if study.amplitude_without_clearance == 0:
            raise MechanismError(
                f"{study.title!r} has no sleeve motion without clearance, the reference of the figure; increase the speed fluctuation"
            )
    page = Page(*_PAGE_SIZE, "Small clearance does not stop cyclic sleeve motion", "large clearance does, if the balls can swing within it")
    panel = _add_panel(page, _RATIO_RECT, "", "Sleeve stroke / stroke without clearance [1]")
    strip = _add_panel(page, _REST_RECT, "Clearance between links and sleeve [mm]", "")
    for index, (study, colour) in enumerate(zip(studies, SERIES_COLOURS, strict=False)):
        style: dict[str, Any] = {"color": colour, "marker": SERIES_MARKERS[index], "markersize": 4.5}
        order = np.argsort(study.clearances)
        clearances = study.clearances[order] * MM_PER_M
        ratio = study.amplitudes[order] / study.amplitude_without_clearance
        is_at_rest = ratio == 0
        moving = np.where(is_at_rest, np.nan, ratio)
        panel.plot(clearances, moving, linewidth=1.2, linestyle=SERIES_LINE_STYLES[index], label=study.title, **style)
        strip.plot(clearances[is_at_rest], np.full(int(is_at_rest.sum()), index), linestyle="none", **style)
    panel.set_yscale("log")
    all_clearances = np.concatenate([study.clearances for study in studies]) * MM_PER_M
    for axes in (panel, strip):
        axes.set(xscale="log", xlim=(0.8 * float(all_clearances.min()), 1.25 * float(all_clearances.max())))
        use_plain_decades(axes.xaxis)
    use_plain_decades(panel.yaxis)
    panel.tick_params(labelbottom=False)
    strip.set(ylim=(-0.7, len(studies) - 0.3), yticks=[0.5 * (len(studies) - 1)], yticklabels=["at rest"])
    strip.tick_params(axis="y", length=0, labelcolor=INK)
    strip.grid(visible=False, axis="y")
    strip.set_facecolor(RULE)
    add_legend(panel, {"color": INK}, fontsize=8.5, loc="upper left")
    low, high = panel.get_ylim()
    panel.set_ylim(low, high * (high / low) ** 0.25)
    return page


def settling_figure(study: SettlingStudy) -> Page:
    """Draw the settling time against the dashpot coefficient with the shortest time marked."""
    page = Page(*_PAGE_SIZE, "Dashpot with the shortest settling time", study.title)
    panel = _add_panel(page, _PANEL_RECT, "Dashpot coefficient at the sleeve [N s/m]", "Settling time [s]")
    settled = np.isfinite(study.settling_times)
    times = study.settling_times[settled]
    panel.plot(study.damping_coefficients[settled], times, "o-", color=BLUE, linewidth=1.4, markersize=3.5)
    best_damping, best_time = study.best
    panel.plot([best_damping], [best_time], "o", color=VERMILLION, markersize=8)
    panel.set(xscale="log", ylim=(0.0, 1.08 * float(times.max())))
    use_plain_decades(panel.xaxis)
    panel.write_note(f"{best_time:.3g} s with {best_damping:.3g} N s/m", study.best, (0, -16), ha="center", color=VERMILLION)
    for text, x in (("oscillates", 0.12), ("creeps", 0.86)):
        panel.write_note(text, (x, 0.30), xycoords="axes fraction", ha="center", color=MUTED)
    band = f"{SETTLING_TOLERANCE:.0%} of their travel around the new equilibrium"
    page.write_footnote(f"from the load change until the arms stay within {band}")
    return page


def fold_jump_figure(study: FoldJumpStudy) -> Page:
    """Draw the passage speed and its delay against the rate of the speed ramp."""
    page = Page(*_PAGE_SIZE, "A faster change of speed delays the jump", study.title)
    left = _add_panel(page, (0.105, 0.17, 0.36, 0.64), "Rate of the speed ramp [rad/s²]", "Passage speed [rad/s]")
    right = _add_panel(page, (0.60, 0.17, 0.36, 0.64), "Rate of the speed ramp [rad/s²]", "Delay [rad/s]")
    order = np.argsort(study.ramp_rates)
    rates, rising_delay = study.ramp_rates[order], study.rising_delay[order]
    up = f"up: exponent {study.rising_exponent}"
    down = f"down: exponent {study.falling_exponent}"
    for speeds, static, delay, colour, marker, label, text, shift in (
        (study.rising_speeds, study.stop_speed, rising_delay, VERMILLION, "s", up, "leaves its stop", -11),
        (study.falling_speeds, study.fold_speed, study.falling_delay[order], BLUE, "o", down, "fold", 5),
    ):
        left.axhline(static, color=colour, linewidth=0.9, linestyle=DASHED)
        left.semilogx(rates, speeds[order], color=colour, marker=marker, markersize=3.5, linewidth=1.3)
        left.write_note(f"{text}, {static:.6g}", (float(rates[0]), static), (0, shift), color=colour, fontsize=8)
        right.loglog(rates, delay, marker, color=colour, markersize=3.5, label=label)
    if np.all(np.isfinite(study.asymptotic_delay)):
        right.loglog(rates, study.asymptotic_delay[order], color=INK, linewidth=0.9, label=r"fold: $\propto\dot\omega^{2/3}$")
    # The constant of rate (ln(1 / rate) / divergence rate + constant) is that of the slowest run.
    constant = rising_delay[0] / rates[0] - np.log(1 / rates[0]) / study.divergence_rate
    rising_law = rates * (np.log(1 / rates) / study.divergence_rate + constant)
    right.loglog(rates, rising_law, color=INK, linewidth=0.9, linestyle=DASHED, label=r"stop: $\dot\omega\,\ln(1/\dot\omega)\,/\,\lambda$")
    low, high = left.get_ylim()
    left.set_ylim(low - 0.05 * (high - low), high)
    add_legend(right, {"color": INK, "math_fontfamily": "stix"}, fontsize=8, loc="upper left", handlelength=1.4, borderaxespad=0.2)
    right.set_ylim(top=12 * float(rising_delay.max()))
    passage = f"rate of the ramp ω̇; passage at {np.degrees(study.fold_position):.4g} deg, the minimum of the equilibrium speed"
    growth = f"divergence rate at the stop λ = {study.divergence_rate:.4g} 1/s, from the delays {study.rising_divergence_rate}"
    page.write_footnote(f"{passage}\n{growth}", y=0.012, linespacing=1.3)
    return page


def _add_panel(page: Page, rect: PanelRect, x_label: str, y_label: str, *, size: float = 10) -> Panel:
    return page.add_panel(rect, x_label, y_label, label_size=size, tick_size=0.8 * size, which="both")


def load_change_figure(study: LoadChangeStudy) -> Page:
    """Draw speed, sleeve lift, and torque with load, over time."""
    page = Page(8.0, 7.4, study.conclusion[:1].upper() + study.conclusion[1:], study.title, subtitle_y=0.915)
    governed = GovernedEngine(study.run.scene)
    run = study.run
    times, begin = run.times, study.change_times[0]
    speed, sleeve, torque = (page.add_panel((0.10, y, 0.86, 0.225), "", label) for y, label in _PANELS)
    angles = run.readings[governed.shaft_angle]
    n_columns = math.ceil(speed.bbox.width / COLUMN_WIDTH)
    speeds = run.rates[governed.shaft_angle] / RPM
    lift = run.readings[governed.sleeve] * MM_PER_M
    bands = [make_range_band(times, values, angles / math.tau, n_columns) for values in (speeds, lift)]
    if not governed.has_mean_torque:
        for panel, band in zip((speed, sleeve), bands, strict=True):
            panel.fill_between(band.times, band.low, band.high, color=BLUE, alpha=BAND_OPACITY, linewidth=0)
        speed.write_note("line: mean over a turn; band: range within it", (0.985, 0.06), **_corner(MUTED))
    speed.plot(study.average.times, study.average.speeds / RPM, color=BLUE, linewidth=1.6)
    _draw_settling(speed, study)
    sleeve.plot(bands[1].mean_times, bands[1].means, color=BLUE, linewidth=1.6)
    _draw_torques(torque, study, governed)
    for panel in (speed, sleeve, torque):
        panel.axvline(begin, color=MUTED, linewidth=0.9, linestyle=DASHED)
        panel.set_xlim(0.0, float(study.run.scene.run.duration))
        panel.label("", panel.get_ylabel())
    torque.label("Time [s]", torque.get_ylabel())
    page.write_footnote(_load_change_footnote(study, governed))
    return page


_HALO = {"facecolor": PAPER, "edgecolor": "none", "alpha": 0.8, "pad": 1.0}
"""Ground of a note above curves."""

_PANELS = ((0.635, "Speed of the shaft [rpm]"), (0.36, "Sleeve lift [mm]"), (0.085, "Torque [N m]"))
"""Lower edge and label of each panel."""


def _draw_settling(panel: Panel, study: LoadChangeStudy) -> None:
    """Draw the equilibria of statics, and the settling band where the speed settles."""
    end = study.run.scene.run.duration
    begin = study.change_times[0]
    for point, span in ((study.before, (0.0, begin)), (study.after, (begin, end))):
        if point is not None:
            panel.plot(span, [point.shaft_speed / RPM] * 2, color=VERMILLION, linewidth=1.0, linestyle=DASHED)
    if study.after is not None:
        height = study.after.shaft_speed / RPM
        panel.write_note("equilibrium by statics", (end, height), (-4, 4), ha="right", color=VERMILLION, fontsize=8, bbox=_HALO)
    if study.verdict is Verdict.SETTLES:
        first, _, last = (one / RPM for one in study.mean_speeds)
        half = SETTLING_BAND * abs(last - first)
        panel.axhspan(last - half, last + half, color=GREEN, alpha=0.15, linewidth=0)
        settled = begin + study.settling_time
        panel.axvline(settled, color=GREEN, linewidth=0.9)
        low = panel.get_ylim()[0]
        panel.write_note(f"settled after {study.settling_time:.3g} s", (settled, low), (5, 5), color=GREEN, fontsize=8)


def _draw_torques(panel: Panel, study: LoadChangeStudy, governed: GovernedEngine) -> None:
    """Draw the torque of the engine averaged over a turn, and the load."""
    run = study.run
    part = governed.shaft_angle.rpartition(".")[0]
    if arrangement := find_governed_engine(run.scene):
        panel.plot(*engine_torque(run, arrangement), color=BLUE, linewidth=1.6)
        panel.write_note("engine, mean over a turn" if not governed.has_mean_torque else "engine", (0.985, 0.88), **_corner(BLUE))
    panel.plot(run.times, run.readings[f"{part}.load_torque"], color=INK, linewidth=1.2, linestyle=DASHED)
    panel.write_note("load (dashed)", (0.985, 0.76), **_corner(INK))


def _corner(colour: str) -> dict[str, Any]:
    return {"xycoords": "axes fraction", "ha": "right", "color": colour, "fontsize": 8, "bbox": _HALO}


def _load_change_footnote(study: LoadChangeStudy, governed: GovernedEngine) -> str:
    """Return droop, overshoot and fluctuation in a line."""
    droop = f"droop {study.droop:+.3%}, by statics {study.static_droop:+.3%}"
    overshoot = f"overshoot {study.overshoot:.1%} of the change" if np.isfinite(study.overshoot) else ""
    cyclic = (
        "" if governed.has_mean_torque else f"speed fluctuation in a turn {study.fluctuations[0]:.2%}, then {study.fluctuations[1]:.2%}"
    )
    accuracy = f"engine {study.run.cost.engine}"
    return "; ".join(text for text in (droop, overshoot, cyclic, accuracy) if text)


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
    page.write_footnote(_map_footnote(study))
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
    if x.min() <= place[0] <= x.max() and y.min() <= place[1] <= y.max():
        panel.plot(*place, "*", color=BLUE, markeredgecolor=PAPER, markersize=13, label="the scene")
    panel.set(xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    if panel.get_legend_handles_labels()[0]:
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
    for chosen, colour, marker, label in ((stable, BLUE, ".", "eigenvalues: stable"), (~stable, VERMILLION, "x", "hunts")):
        rows = chosen & is_shown
        panel.plot(first[rows], second[rows], marker, color=colour, markersize=3.5, linewidth=0, label=label)
    curve = np.linspace(1.0 / _PLANE_LIMIT, _PLANE_LIMIT, 200)
    panel.plot(curve, 1.0 / curve, color=INK, linewidth=1.4, label="$x\\,y = 1$")
    widest = float(first[is_shown].max(initial=1.0))
    panel.set(xlim=(0.0, min(1.5 * widest, _PLANE_LIMIT)), ylim=(0.0, _PLANE_LIMIT))
    above = {"loc": "lower left", "bbox_to_anchor": (0.0, 1.0), "ncols": 3, "columnspacing": 1.4, "frameon": False}
    add_legend(panel, {"color": INK, "math_fontfamily": "stix"}, **{**_LEGEND, **above})


def _map_footnote(study: StabilityMap) -> str:
    """Return what is drawn, in a line."""
    shifts = [point.cyclic / point.mean - 1 for point in study.border if point.cyclic is not None]
    parts = [f"load {100 * study.load_fraction:.4g} % of the rated torque", "colour: growth rate of the least damped motion, mean torque"]
    if shifts:
        parts.append(f"the cyclic torque moves the border by {min(shifts):+.2%} to {max(shifts):+.2%}")
    return "; ".join(parts)

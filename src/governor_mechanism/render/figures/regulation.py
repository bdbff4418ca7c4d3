"""Figures of the regulation studies: cyclic sleeve motion, clearance, settling time, and jump through a fold."""

from typing import Any

import numpy as np
from matplotlib.patches import Rectangle

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import (
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
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.regulation.cyclic_irregularity import ClearanceStudy, CyclicMotionStudy
from governor_mechanism.studies.regulation.fold_jump import FoldJumpStudy
from governor_mechanism.studies.regulation.settling_time import SETTLING_TOLERANCE, SettlingStudy
from governor_mechanism.types import FloatArray

_PAGE_SIZE = 7.2, 5.0
"""Width and height of a figure, inches."""

_PANEL_RECT = (0.11, 0.14, 0.85, 0.69)
"""Rectangle of the panel in a figure of one panel, in fractions of the figure."""

_RATIO_RECT, _REST_RECT = (0.11, 0.255, 0.85, 0.55), (0.11, 0.15, 0.85, 0.07)
"""Rectangles of the panel of ratios and of the strip below it for a sleeve at rest, whose ratio has no logarithm."""


def cyclic_figure(study: CyclicMotionStudy) -> Page:
    """Draw the sleeve amplitude against speed fluctuation over insensitivity band."""
    page = Page(*_PAGE_SIZE, "The sleeve moves when the speed fluctuation exceeds the insensitivity band", study.title)
    panel = _add_panel(page, _PANEL_RECT, "Speed fluctuation / insensitivity band [1]", "Sleeve stroke in a turn [mm]")
    order = np.argsort(study.fluctuation_ratios)
    fluctuation_ratios, amplitudes = study.fluctuation_ratios[order], study.amplitudes[order] * MM_PER_M
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
    """Draw the sleeve amplitude over that without clearance, against clearance, one line per study.

    Raises MechanismError if a scene has no cyclic sleeve motion without clearance.
    """
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
        clearances, ratio = study.clearances[order] * MM_PER_M, study.amplitudes[order] / study.amplitude_without_clearance
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
    up, down = f"up: exponent {study.rising_exponent}", f"down: exponent {study.falling_exponent}"
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

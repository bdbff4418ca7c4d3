"""Figures of the regulation studies: cyclic sleeve motion, clearance, settling time, and jump through a fold."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import (
    label_axes,
    new_figure,
    save_png,
    style_axes,
    use_plain_decades,
    write_footnote,
    write_note,
    write_title,
)
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from governor_mechanism.studies.regulation.cyclic_irregularity import ClearanceStudy, CyclicMotionStudy
    from governor_mechanism.studies.regulation.fold_jump import FoldJumpStudy
    from governor_mechanism.studies.regulation.settling_time import SettlingStudy


_MM_PER_M = 1e3

_AXES_RECT = (0.11, 0.14, 0.85, 0.69)
"""Rectangle of the axes in a figure of one panel, in fractions of the figure."""


def cyclic_figure(study: CyclicMotionStudy, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the sleeve amplitude against speed fluctuation over insensitivity band, and return its path."""
    figure = _new_figure("The sleeve moves when the speed fluctuation exceeds the insensitivity band", study.title)
    axes = _add_axes(figure, _AXES_RECT, "speed fluctuation / insensitivity band", "sleeve stroke in a turn, mm")
    order = np.argsort(study.fluctuation_ratios)
    fluctuation_ratios, amplitudes = study.fluctuation_ratios[order], study.amplitudes[order] * _MM_PER_M
    axes.axvspan(0.0, study.threshold, color=SKY, alpha=0.18, linewidth=0)
    axes.plot(fluctuation_ratios, amplitudes, color=BLUE, linewidth=1.6)
    axes.plot(fluctuation_ratios, amplitudes, "o", color=BLUE, markersize=4)
    axes.set_xlim(0.0, float(fluctuation_ratios.max()))
    axes.set_ylim(-0.03 * float(amplitudes.max()), 1.05 * float(amplitudes.max()))
    transform = axes.get_xaxis_transform()
    write_note(axes, "at rest", (study.threshold / 2, 0.10), xycoords=transform, ha="center", color=BLUE)
    axes.axvline(study.threshold, color=VERMILLION, linewidth=1.0)
    write_note(axes, f"threshold {study.threshold:.6f}", (study.threshold, 0.30), (6, 0), xycoords=transform, color=VERMILLION)
    excess = study.fluctuation_ratios - study.threshold
    above_threshold = (excess > 0) & (study.amplitudes > 0)
    if np.sum(above_threshold) > 2:
        _draw_onset(figure, study, np.sort(excess[above_threshold]), np.sort(study.amplitudes[above_threshold]) * _MM_PER_M)
    write_footnote(figure, f"band {study.insensitivity_band:.4f} of the mean speed; last of {study.n_turns + 1} turns")
    return save_png(figure, path)


def _draw_onset(figure: Figure, study: CyclicMotionStudy, excess: FloatArray, amplitudes: FloatArray) -> None:
    """Draw the amplitudes beyond the threshold on logarithmic scales."""
    inset = _add_axes(figure, (0.20, 0.48, 0.26, 0.30), "excess over the threshold", "mm", size=8)
    inset.loglog(excess, amplitudes, "o", color=BLUE, markersize=3)
    exponent = study.onset_exponent
    if np.isfinite(exponent.value):
        near_threshold = excess < 0.01
        line = amplitudes[near_threshold][-1] * (excess / excess[near_threshold][-1]) ** exponent.value
        inset.loglog(excess, line, color=VERMILLION, linewidth=1.0, zorder=1)
        text = f"exponent {exponent}"
        write_note(inset, text, (0.97, 0.06), xycoords="axes fraction", ha="right", color=VERMILLION, fontsize=7.5)


def clearance_figure(studies: Sequence[ClearanceStudy], path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the sleeve amplitude over that without clearance, against clearance, one line per study, and return its path.

    Raises MechanismError if a scene has no cyclic sleeve motion without clearance.
    """
    for study in studies:
        if study.amplitude_without_clearance == 0:
            raise MechanismError(
                f"{study.title!r} has no sleeve motion without clearance, the reference of the figure; increase the speed fluctuation"
            )
    figure = _new_figure("Small clearance does not stop cyclic sleeve motion", "large clearance does, if the balls can swing within it")
    axes = _add_axes(figure, (0.11, 0.19, 0.85, 0.64), "clearance between links and sleeve, mm", "sleeve stroke / stroke without clearance")
    for study, colour in zip(studies, SERIES_COLOURS, strict=False):
        order = np.argsort(study.clearances)
        clearances, ratio = (study.clearances[order] * _MM_PER_M, study.amplitudes[order] / study.amplitude_without_clearance)
        is_stationary = ratio == 0
        plotted = np.where(is_stationary, _ZERO_PLOTTED_AT, ratio)
        axes.plot(clearances, plotted, color=colour, linewidth=1.0)
        axes.plot(clearances[~is_stationary], plotted[~is_stationary], "o", color=colour, markersize=4.5)
        axes.plot(clearances[is_stationary], plotted[is_stationary], "o", color=colour, markerfacecolor=PAPER, markersize=6)
        largest = int(np.argmax(plotted))
        write_note(axes, study.title, (clearances[largest], plotted[largest]), (4, 8), color=colour)
        if is_stationary.any():
            write_note(axes, "at rest", (clearances[is_stationary][-1], _ZERO_PLOTTED_AT), (0, 9), color=colour, ha="right")
    axes.set(xscale="log", yscale="log")
    use_plain_decades(axes.xaxis, axes.yaxis)
    axes.set_ylim(0.7 * _ZERO_PLOTTED_AT, 30)
    write_footnote(figure, "\n".join(f"{study.title}: {study.conclusion}" for study in studies))
    return save_png(figure, path)


_ZERO_PLOTTED_AT = 0.1
"""Ordinate of zero on the logarithmic scale."""


def settling_figure(study: SettlingStudy, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the settling time against the dashpot coefficient with the shortest time marked, and return its path."""
    figure = _new_figure("Dashpot with the shortest settling time", study.title)
    axes = _add_axes(figure, _AXES_RECT, "dashpot coefficient at the sleeve, N s/m", "settling time, s")
    settled = np.isfinite(study.settling_times)
    damping_coefficients, times = study.damping_coefficients[settled], study.settling_times[settled]
    axes.plot(damping_coefficients, times, color=BLUE, linewidth=1.4)
    axes.plot(damping_coefficients, times, "o", color=BLUE, markersize=3.5)
    best_damping, best_time = study.best
    axes.plot([best_damping], [best_time], "o", color=VERMILLION, markersize=8)
    axes.set_xscale("log")
    use_plain_decades(axes.xaxis)
    axes.set_ylim(0.0, 1.08 * float(times.max()))
    write_note(axes, f"{best_time:.3g} s with {best_damping:.3g} N s/m", study.best, (0, -16), ha="center", color=VERMILLION)
    for text, x in (("oscillates", 0.12), ("creeps", 0.86)):
        write_note(axes, text, (x, 0.30), xycoords="axes fraction", ha="center", color=MUTED)
    band = f"{study.tolerance:.0%} of their travel around the new equilibrium"
    write_footnote(figure, f"from the load change until the arms stay within {band}")
    return save_png(figure, path)


def fold_jump_figure(study: FoldJumpStudy, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the passage speed and its delay against the rate of the speed ramp, and return its path."""
    figure = _new_figure("A faster change of speed delays the jump", study.title)
    left = _add_axes(figure, (0.105, 0.15, 0.36, 0.66), "rate of the speed ramp, rad/s²", "passage speed, rad/s")
    right = _add_axes(figure, (0.60, 0.15, 0.36, 0.66), "rate of the speed ramp, rad/s²", "delay, rad/s")
    order = np.argsort(study.ramp_rates)
    rates = study.ramp_rates[order]
    kinds = (
        (study.rising_speeds[order], study.stop_speed, study.rising_delay[order], VERMILLION, "up", study.rising_exponent),
        (study.falling_speeds[order], study.fold_speed, study.falling_delay[order], BLUE, "down", study.falling_exponent),
    )
    for speeds, static, delay, colour, text, exponent in kinds:
        left.axhline(static, color=colour, linewidth=0.9, linestyle=(0, (5, 3)))
        left.semilogx(rates, speeds, "o-", color=colour, markersize=3.5, linewidth=1.3)
        right.loglog(rates, delay, "o", color=colour, markersize=3.5, label=f"{text}: exponent {exponent}")
    for (_, static, _, colour, _, _), text, shift in zip(kinds, ("leaves its stop", "fold"), (-11, 5), strict=True):
        write_note(left, f"{text}, {static:.6g}", (float(rates[0]), static), (0, shift), color=colour, fontsize=8)
    if np.all(np.isfinite(study.asymptotic_delay)):
        right.loglog(rates, study.asymptotic_delay[order], color=INK, linewidth=0.9, label="fold law, rate^(2/3)")
    rising_law = _rising_delay_law(study, rates, study.rising_delay[order])
    right.loglog(rates, rising_law, color=MUTED, linewidth=0.9, label="rate x ln(1 / rate) / divergence rate")
    low, high = left.get_ylim()
    left.set_ylim(low - 0.05 * (high - low), high)
    right.legend(frameon=False, fontsize=7.5, loc="upper left", handlelength=1.4, borderaxespad=0.2)
    right.set_ylim(top=12 * float(study.rising_delay.max()))
    passage = f"passage at {np.degrees(study.fold_position):.4g} deg, the minimum of the equilibrium speed"
    growth = f"divergence rate at the stop {study.divergence_rate:.4g} 1/s, from the delays {study.rising_divergence_rate}"
    write_footnote(figure, f"{passage}; {growth}")
    return save_png(figure, path)


def _rising_delay_law(study: FoldJumpStudy, rates: FloatArray, delays: FloatArray) -> FloatArray:
    """Return rate (ln(1 / rate) / divergence rate + constant), with the constant from the slowest run."""
    constant = delays[0] / rates[0] - np.log(1 / rates[0]) / study.divergence_rate
    law: FloatArray = rates * (np.log(1 / rates) / study.divergence_rate + constant)
    return law


def _new_figure(title: str, subtitle: str) -> Figure:
    figure = new_figure(7.2, 5.0)
    write_title(figure, title)
    write_title(figure, subtitle, y=0.895, size=10, colour=MUTED)
    return figure


def _add_axes(figure: Figure, rect: tuple[float, float, float, float], x_label: str, y_label: str, *, size: float = 10) -> Axes:
    axes = figure.add_axes(rect)
    label_axes(axes, x_label, y_label, size=size)
    style_axes(axes, tick_size=0.8 * size, which="both")
    return axes

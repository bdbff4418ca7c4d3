"""Figures of the studies of regulation: twitching, play, settling, and the jump. They draw, and reckon nothing."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.render.style import BLUE, INK, PAPER, QUIET, RULE, SANS, SERIES, SERIF, SKY, VERMILLION
from governor_mechanism.types import FloatArray

if TYPE_CHECKING:
    from governor_mechanism.studies.regulation.registry import Jump, PlayAndTwitch, Settling, Twitch


WIDTH, HEIGHT, DPI = 7.2, 5.0, 100
"""Inches, and dots per inch."""

MM = 1e3

FRAME = (0.11, 0.14, 0.85, 0.69)
"""Of the axes in a figure of one panel."""


def twitch_figure(study: Twitch, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the sleeve's amplitude against unevenness over standing band. Returns the path."""
    figure = _figure("Twitching begins where the unevenness exceeds the standing band", study.title)
    axes = _axes(figure, FRAME, "unevenness / standing band", "sleeve, lowest to highest in a turn, mm")
    order = np.argsort(study.shares)
    shares, amplitudes = study.shares[order], study.amplitudes[order] * MM
    axes.axvspan(0.0, study.threshold, color=SKY, alpha=0.18, linewidth=0)
    axes.plot(shares, amplitudes, color=BLUE, linewidth=1.6)
    axes.plot(shares, amplitudes, "o", color=BLUE, markersize=4)
    axes.set_xlim(0.0, float(shares.max()))
    axes.set_ylim(-0.03 * float(amplitudes.max()), 1.05 * float(amplitudes.max()))
    _words(axes, study.threshold / 2, 0.10, "stands still", BLUE, across=True)
    words = f"threshold {study.threshold:.6f}"
    axes.axvline(study.threshold, color=VERMILLION, linewidth=1.0)
    _words(axes, study.threshold, 0.30, words, VERMILLION, across=True, shift=6, ha="left")
    excess = study.shares - study.threshold
    near = (excess > 0) & (study.amplitudes > 0)
    if np.sum(near) > 2:
        _onset(figure, study, np.sort(excess[near]), np.sort(study.amplitudes[near]) * MM)
    _foot(figure, f"band {study.band:.4f} of the mean speed; counted in the last of {study.turns + 1} turns")
    return _written(figure, path)


def _onset(figure: Figure, study: Twitch, excess: FloatArray, amplitudes: FloatArray) -> None:
    """The same beyond the threshold, on logarithmic scales."""
    inset = _axes(figure, (0.20, 0.48, 0.26, 0.30), "excess over the threshold", "mm", size=8)
    inset.loglog(excess, amplitudes, "o", color=BLUE, markersize=3)
    exponent = study.onset
    if np.isfinite(exponent.value):
        small = excess < 0.01
        line = amplitudes[small][-1] * (excess / excess[small][-1]) ** exponent.value
        inset.loglog(excess, line, color=VERMILLION, linewidth=1.0, zorder=1)
        _words(inset, 0.97, 0.06, f"exponent {exponent}", VERMILLION, ha="right", size=7.5)


def play_figure(studies: Sequence[PlayAndTwitch], path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the sleeve's amplitude, over that without play, against play: a line for each study.

    Raises MechanismError for a study of a scene that does not twitch without play.
    """
    for study in studies:
        if study.without_play == 0:
            raise MechanismError(f"{study.title!r} stands still without play: there is nothing to compare with")
    figure = _figure("Small play is no remedy against twitching", "a wide one is, where the balls can swing within it")
    axes = _axes(figure, (0.11, 0.19, 0.85, 0.64), "play between links and sleeve, mm", "twitch / twitch without play")
    for study, colour in zip(studies, SERIES, strict=False):
        order = np.argsort(study.plays)
        plays, ratio = study.plays[order] * MM, study.amplitudes[order] / study.without_play
        still = ratio == 0
        shown = np.where(still, STANDS_STILL, ratio)
        axes.plot(plays, shown, color=colour, linewidth=1.0)
        axes.plot(plays[~still], shown[~still], "o", color=colour, markersize=4.5)
        axes.plot(plays[still], shown[still], "o", color=colour, markerfacecolor=PAPER, markersize=6)
        most = int(np.argmax(shown))
        note = axes.annotate(study.title, (plays[most], shown[most]), (4, 8), textcoords="offset points")
        note.set(color=colour, fontsize=8.5, fontfamily=SANS, parse_math=False)
        if still.any():
            note = axes.annotate("stands still", (plays[still][-1], STANDS_STILL), (0, 9), textcoords="offset points")
            note.set(color=colour, fontsize=8.5, fontfamily=SANS, ha="right")
    axes.set_xscale("log")
    axes.set_yscale("log")
    _plain(axes, x=True, y=True)
    axes.set_ylim(0.7 * STANDS_STILL, 30)
    _foot(figure, "\n".join(f"{study.title}: {study.finding}" for study in studies))
    return _written(figure, path)


STANDS_STILL = 0.1
"""Where nought is drawn on the logarithmic scale."""


def settling_figure(study: Settling, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the time to settle against the strength of the oil brake, the shortest marked."""
    figure = _figure("The brake that settles soonest", study.title)
    axes = _axes(figure, FRAME, "oil brake on the sleeve, N s/m", "time to settle, s")
    settled = np.isfinite(study.times)
    brakes, times = study.brakes[settled], study.times[settled]
    axes.plot(brakes, times, color=BLUE, linewidth=1.4)
    axes.plot(brakes, times, "o", color=BLUE, markersize=3.5)
    brake, best = study.best
    axes.plot([brake], [best], "o", color=VERMILLION, markersize=8)
    axes.set_xscale("log")
    _plain(axes, x=True)
    axes.set_ylim(0.0, 1.08 * float(times.max()))
    note = axes.annotate(f"{best:.3g} s with {brake:.3g} N s/m", (brake, best), (0, -16), textcoords="offset points")
    note.set(ha="center", color=VERMILLION, fontsize=8.5, fontfamily=SANS)
    _words(axes, 0.12, 0.30, "swings", QUIET)
    _words(axes, 0.86, 0.30, "creeps", QUIET)
    _foot(
        figure, f"from the change of load until the arms stay within {study.within:.0%} of their way about the new rest"
    )
    return _written(figure, path)


def jump_figure(study: Jump, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the speeds of passage against the rate of the ramp, and of their delays on logarithmic scales."""
    figure = _figure("The jump comes later the faster the speed changes", study.title)
    left = _axes(figure, (0.105, 0.15, 0.36, 0.66), "ramp of the speed, rad/s²", "speed of passage, rad/s")
    right = _axes(figure, (0.60, 0.15, 0.36, 0.66), "ramp of the speed, rad/s²", "delay, rad/s")
    order = np.argsort(study.rates)
    rates = study.rates[order]
    kinds = (
        (study.rising[order], study.stop_speed, study.rising_delay[order], VERMILLION, "up", study.rising_exponent),
        (study.falling[order], study.fold_speed, study.falling_delay[order], BLUE, "down", study.falling_exponent),
    )
    for speeds, static, delay, colour, words, exponent in kinds:
        left.axhline(static, color=colour, linewidth=0.9, linestyle=(0, (5, 3)))
        left.semilogx(rates, speeds, "o-", color=colour, markersize=3.5, linewidth=1.3)
        right.loglog(rates, delay, "o", color=colour, markersize=3.5, label=f"{words}: exponent {exponent}")
    for (_, static, _, colour, _, _), words, shift in zip(kinds, ("leaves its stop", "fold"), (-11, 5), strict=True):
        place = (float(rates[0]), static)
        note = left.annotate(f"{words}, {static:.6g}", place, (0, shift), textcoords="offset points")
        note.set(color=colour, fontsize=8, fontfamily=SANS)
    if np.all(np.isfinite(study.law)):
        right.loglog(rates, study.law[order], color=INK, linewidth=0.9, label="law of the fold, rate^(2/3)")
    late = _rising_law(study, rates, study.rising_delay[order])
    right.loglog(rates, late, color=QUIET, linewidth=0.9, label="rate x ln(1 / rate) / growth")
    low, high = left.get_ylim()
    left.set_ylim(low - 0.05 * (high - low), high)
    right.legend(frameon=False, fontsize=7.5, loc="upper left", handlelength=1.4, borderaxespad=0.2)
    right.set_ylim(top=12 * float(study.rising_delay.max()))
    passage = f"passage of the arms through {np.degrees(study.fold):.4g} deg, where the speed of rest is least"
    growth = f"growth on the stop {study.growth:.4g} 1/s, shown by the delays {study.rising_growth}"
    _foot(figure, f"{passage}; {growth}")
    return _written(figure, path)


def _rising_law(study: Jump, rates: FloatArray, delays: FloatArray) -> FloatArray:
    """rate (ln(1 / rate) / growth + constant), through the slowest run."""
    constant = delays[0] / rates[0] - np.log(1 / rates[0]) / study.growth
    law: FloatArray = rates * (np.log(1 / rates) / study.growth + constant)
    return law


def _figure(title: str, below: str) -> Figure:
    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI, facecolor=PAPER)
    words = figure.text(0.02, 0.945, title, fontsize=15, va="center")
    words.set(color=INK, fontfamily=SERIF, parse_math=False)
    words = figure.text(0.02, 0.895, below, fontsize=10, va="center")
    words.set(color=QUIET, fontfamily=SERIF, parse_math=False)
    return figure


def _axes(figure: Figure, place: tuple[float, float, float, float], x: str, y: str, *, size: float = 10) -> Axes:
    axes = figure.add_axes(place)
    axes.set_facecolor(PAPER)
    axes.set_xlabel(x, color=INK, fontsize=size, fontfamily=SERIF)
    axes.set_ylabel(y, color=INK, fontsize=size, fontfamily=SERIF)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=0.8 * size, labelfontfamily=SANS, which="both")
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)
    return axes


def _plain(axes: Axes, *, x: bool = False, y: bool = False) -> None:
    """Plain numbers at the decades of a logarithmic scale."""
    for axis in [*([axes.xaxis] if x else []), *([axes.yaxis] if y else [])]:
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def _words(
    axes: Axes,
    x: float,
    y: float,
    words: str,
    colour: str,
    *,
    across: bool = False,
    shift: float = 0,
    ha: str = "center",
    size: float = 8.5,
) -> None:
    """Words at a part of the axes; across: x is a value instead."""
    system: Any = axes.get_xaxis_transform() if across else axes.transAxes
    text = axes.annotate(words, (x, y), (shift, 0), xycoords=system, textcoords="offset points")
    text.set(ha=ha, color=colour, fontsize=size, fontfamily=SANS)
    text.set_parse_math(False)


def _foot(figure: Figure, words: str) -> None:
    figure.text(0.02, 0.018, words, color=QUIET, fontsize=7.5, fontfamily=SANS).set_parse_math(False)


def _written(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write the figure; an exception leaves no file behind."""
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    with written_beside(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target

"""Figure of the characteristic of a governor: its equilibrium speed over the travel."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import DASHED, Page, Panel, add_legend
from governor_mechanism.render.number_format import display_unit_of, format_label
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
from governor_mechanism.units.constants import RPM

_MAX_SHOWN_SPEED_RATIO = 1.6
"""Largest shown speed over the median speed; the curve is unbounded towards a dead centre."""


def speed_curve_figure(curve: SpeedCurve, equilibria: Sequence[Equilibrium] = ()) -> Page:
    """Draw speed against travel: stable solid, unstable dashed, folds and equilibria marked.

    Result: the figure; `save` writes it.
    """
    scene = curve.scene
    unit, factor = display_unit_of("rad" if _is_angle(scene, curve.coordinate_name) else "m")
    page = Page(7.2, 5.2, scene.title)
    x_label = format_label(curve.coordinate_name, unit)
    panel = page.add_panel((0.11, 0.155, 0.85, 0.715), x_label, "Equilibrium speed [rpm]")
    panel.set_axisbelow("line")
    low, high = _speed_limits(curve)
    _draw_curve(panel, curve, factor)
    if curve.insensitivity_band is not None:
        _draw_band(panel, scene, curve, curve.insensitivity_band, factor, high)
    _mark_folds(panel, curve, factor)
    _mark_equilibria(panel, curve, equilibria, factor)
    panel.set(xlim=(curve.coordinate[0] * factor, curve.coordinate[-1] * factor), ylim=(low, high))
    if panel.get_legend_handles_labels()[0]:
        add_legend(panel, fontsize=8.5, loc="upper center")
    page.write_footnote(f"low end: {curve.low_end_message};  high end: {curve.high_end_message}", y=0.02)
    return page


def _is_angle(scene: Scene, reading: str) -> bool:
    return scene.part.mechanism.reading(reading).quantity == "angle"


def _speed_limits(curve: SpeedCurve) -> tuple[float, float]:
    """Return the lowest and the highest speed (rpm) in the figure."""
    rpm = curve.speed[curve.has_equilibrium] / RPM
    if not rpm.size:
        return 0.0, 1.0
    middle = float(np.median(rpm))
    shown = rpm[rpm < _MAX_SHOWN_SPEED_RATIO * middle]
    margin = 0.08 * (float(np.ptp(shown)) or middle)
    return max(float(shown.min()) - 2 * margin, 0.0), float(shown.max()) + margin


def _draw_curve(panel: Panel, curve: SpeedCurve, factor: float) -> None:
    if not curve.has_equilibrium.any():
        text = "no spindle speed gives an equilibrium: no load opposes the centrifugal force"
        panel.write_note(text, (0.5, 0.5), xycoords="axes fraction", ha="center", color=INK, fontsize=9, fontfamily=SERIF_FONT)
    kinds: tuple[tuple[NDArray[np.bool_], Any, float, str], ...] = (
        (curve.stable, "-", 1.8, "stable"),
        (~curve.stable & ~curve.astatic, DASHED, 1.8, "unstable"),
        (curve.astatic, "-", 3.0, "neutral: in equilibrium anywhere, so that any other speed drives it to an end"),
    )
    for kind, style, width, text in kinds:
        speed_rpm = np.where(curve.has_equilibrium & kind, curve.speed / RPM, np.nan)
        if not np.all(np.isnan(speed_rpm)):
            panel.plot(curve.coordinate * factor, speed_rpm, linestyle=style, color=BLUE, linewidth=width, label=text)
    if curve.astatic.all():
        _draw_astatic_directions(panel, curve, factor)


def _draw_astatic_directions(panel: Panel, curve: SpeedCurve, factor: float) -> None:
    """Draw where an astatic governor goes at other speeds: outward above its one speed, inward below it."""
    rpm, (inner, outer) = float(np.median(curve.speed)) / RPM, curve.coordinate[[0, -1]] * factor
    for ratio, text, start, stop in ((1.015, "faster: to the outer end", 0.35, 0.65), (0.985, "slower: to the inner end", 0.65, 0.35)):
        tail, head = ((inner + part * (outer - inner), ratio * rpm) for part in (start, stop))
        arrow = {"arrowstyle": "-|>", "color": MUTED, "linewidth": 1.4}
        panel.annotate("", head, tail, arrowprops=arrow)
        panel.write_note(text, ((tail[0] + head[0]) / 2, ratio * rpm), (0, 5), ha="center", color=MUTED)
    panel.write_note(f"{rpm:.5g} rpm", (inner, rpm), (6, 5), color=BLUE)


def _draw_band(panel: Panel, scene: Scene, curve: SpeedCurve, band: InsensitivityBand, factor: float, high: float) -> None:
    """Draw the speeds at which a resistance holds the governor; the band is not clipped at the upper limit."""
    slow, fast = (np.minimum(speed / RPM, 2 * high) for speed in (band.falling_speed, band.rising_speed))
    unit = "N m" if _is_angle(scene, band.against) else "N"
    text = f"held by {band.resistance:g} {unit} at the {band.against.replace('_', ' ')}"
    panel.fill_between(curve.coordinate * factor, slow, fast, where=curve.has_equilibrium, color=SKY, alpha=0.25, label=text)


def _mark_folds(panel: Panel, curve: SpeedCurve, factor: float) -> None:
    for value, speed in curve.folds:
        panel.plot([value * factor], [speed / RPM], "D", color=VERMILLION, markersize=6)
        text = f"jump at {speed / RPM:.4g} rpm"
        panel.write_note(text, (value * factor, speed / RPM), (0, -16), ha="center", color=VERMILLION)


def _mark_equilibria(panel: Panel, curve: SpeedCurve, equilibria: Sequence[Equilibrium], factor: float) -> None:
    for equilibrium in (one for one in equilibria if not one.astatic):
        speed = float(np.interp(equilibrium.coordinate, curve.coordinate, curve.speed / RPM))
        fill, kind = (INK, "stable") if equilibrium.stable else (PAPER, "unstable")
        label = f"{kind} equilibrium, {speed:.4g} rpm"
        panel.plot([equilibrium.coordinate * factor], [speed], "o", color=INK, markerfacecolor=fill, markersize=7, label=label)

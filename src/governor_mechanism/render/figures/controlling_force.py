"""Statics of a governor: its equilibrium speed over the travel, and the force on a ball over its distance with a fan of speed lines."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.model.results.pictures import Figure
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import DASHED, DOTTED, MM_PER_M, Page, Panel, add_legend
from governor_mechanism.render.figures.plates.isochronous import has_isochronous_parabolas, isochronous_figure
from governor_mechanism.render.shown_readings import display_unit_of, format_label, format_name
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.statics.controlling_force import ControllingForce
from governor_mechanism.statics.equilibria import Equilibrium
from governor_mechanism.statics.equilibrium_speed import WorkingRange
from governor_mechanism.statics.speed_curve import InsensitivityBand, SpeedCurve
from governor_mechanism.studies.equilibrium_report import EquilibriumReport, GovernorForces
from governor_mechanism.types import BoolArray, FloatArray
from governor_mechanism.units.constants import RPM

_MAX_SHOWN_SPEED_RATIO = 1.6
"""Largest shown speed over the median speed; the curve is unbounded towards a dead centre."""


def speed_curve_figure(curve: SpeedCurve, equilibria: Sequence[Equilibrium] = ()) -> Page:
    """Draw speed against travel: stable solid, unstable dashed, folds and equilibria marked; `save` writes it."""
    scene = curve.scene
    unit, factor = display_unit_of("rad" if _is_angle(scene, curve.coordinate_name) else "m")
    page = Page(7.2, 5.2, scene.title)
    x_label = format_label(curve.coordinate_name, unit)
    panel = page.add_panel((0.11, 0.155, 0.85, 0.715), x_label, "Equilibrium speed [rpm]")
    panel.set_axisbelow("line")
    low, high = _speed_limits(curve)
    _draw_speed_curve(panel, curve, factor)
    if curve.insensitivity_band is not None:
        _draw_band(panel, scene, curve, curve.insensitivity_band, factor, high)
    _mark_folds(panel, curve, factor)
    _mark_equilibrium_speeds(panel, curve, equilibria, factor)
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


def _draw_speed_curve(panel: Panel, curve: SpeedCurve, factor: float) -> None:
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
            # Points of one speed would be set to one row of pixels or the next by their rounding.
            panel.plot(curve.coordinate * factor, speed_rpm, linestyle=style, color=BLUE, linewidth=width, label=text, snap=False)
    if curve.astatic.all():
        _draw_astatic_directions(panel, curve, factor)


def _draw_astatic_directions(panel: Panel, curve: SpeedCurve, factor: float) -> None:
    """Draw where an astatic governor goes at other speeds: outward above its one speed, inward below it."""
    rpm = float(np.median(curve.speed)) / RPM
    inner, outer = curve.coordinate[[0, -1]] * factor
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


def _mark_equilibrium_speeds(panel: Panel, curve: SpeedCurve, equilibria: Sequence[Equilibrium], factor: float) -> None:
    for equilibrium in (one for one in equilibria if not one.astatic):
        speed = float(np.interp(equilibrium.coordinate, curve.coordinate, curve.speed / RPM))
        fill, kind = (INK, "stable") if equilibrium.stable else (PAPER, "unstable")
        label = f"{kind} equilibrium, {speed:.4g} rpm"
        panel.plot([equilibrium.coordinate * factor], [speed], "o", color=INK, markerfacecolor=fill, markersize=7, label=label)


_SHOWN_BEYOND_RANGE = 0.25
"""Part of the travel that is shown beyond either end of a working range that nothing limits, in widths of the range."""

_MAX_TITLE_LETTERS = 84
"""Number of letters of a title that fit on the page."""

_MIN_LABEL_DISTANCE = 0.055
"""Smallest distance of the labels of two speed lines, in heights of the panel."""

_MIN_TOP_DISTANCE = 0.12
"""Smallest distance of two labels above the panel, in widths of the panel."""

_N_SPEED_LINES = 6
"""Number of intervals of speed that the fan has at most, about."""

_MIN_SPEED_LINES = 4
"""Number of speed lines below which the fan gets one more on either side."""


def controlling_force_figure(curve: ControllingForce, equilibria: Sequence[Equilibrium] = ()) -> Page:
    """Draw the controlling force of one ball: stable solid, unstable dashed, with speed lines, working range and friction."""
    scene = curve.scene
    title = textwrap.shorten(scene.title, _MAX_TITLE_LETTERS, placeholder=" …")
    page = Page(7.6, 5.6, title, _subtitle(curve), subtitle_y=0.888)
    panel = page.add_panel((0.10, 0.16, 0.79, 0.675), format_label(f"{curve.radius_name} r", "mm"), "Controlling force C of one ball [N]")
    panel.set_axisbelow("line")
    shown = _shown_part(curve)
    if not shown.any():
        panel.write_note("no spindle speed gives an equilibrium", (0.5, 0.5), xycoords="axes fraction", ha="center", color=INK)
        return page
    limits = _axis_limits(curve, shown)
    panel.set(xlim=(0.0, limits[0]), ylim=(0.0, limits[1]))
    _draw_speed_lines(panel, curve, shown, limits)
    if curve.resistance:
        _draw_friction_band(panel, scene, curve, shown)
    _draw_force_curve(panel, curve, shown)
    if curve.working_range is not None:
        _draw_working_range(panel, curve.working_range, limits)
    _mark_equilibrium_forces(panel, curve, shown, equilibria)
    add_legend(panel, fontsize=8.5, loc="upper left", bbox_to_anchor=(0.0, 1.0))
    page.write_footnote(_format_effort(scene, curve, equilibria), y=0.047)
    page.write_footnote(_definition(curve), y=0.02)
    return page


def _subtitle(curve: ControllingForce) -> str:
    """Return sensitiveness and range of speed, or why there are none."""
    ends = curve.working_range
    if ends is None:
        return "no working range: the scene has no stops, and none is given"
    low, high = (f"{speed / RPM:.4g}" for speed in ends.speed)
    if curve.astatic.all():
        return f"isochronous: in equilibrium anywhere at {low} rpm, so that any change of speed moves it to an end of its travel"
    text = f"equilibrium at {low} rpm at the inner and {high} rpm at the outer end"
    if not ends.stable:
        return f"{text}; between them it is unstable in part"
    text = f"from {low} to {high} rpm, sensitiveness {100 * ends.sensitiveness:.3g} %"
    if curve.resistance:
        falling, rising = ends.falling_speed[0] / RPM, ends.rising_speed[1] / RPM
        text += f"; with resistance from {falling:.4g} to {rising:.4g} rpm"
    return text


def _format_effort(scene: Scene, curve: ControllingForce, equilibria: Sequence[Equilibrium]) -> str:
    """Return effort and power at the first stable equilibrium, or the effort at an astatic one."""
    chosen = next((one for one in equilibria if one.stable or one.astatic), None)
    if chosen is None:
        return ""
    effort = curve.effort
    mean_force, power, speed = (
        float(np.interp(chosen.coordinate, curve.coordinate, values)) for values in (effort.effort, effort.power, curve.speed)
    )
    unit = "N m" if scene.part.mechanism.reading(curve.against).quantity == "angle" else "N"
    text = f"at {speed / RPM:.4g} rpm, for {100 * effort.speed_change:g} % more: effort {mean_force:.3g} {unit} at the "
    has_power = np.interp(chosen.coordinate, curve.coordinate, effort.has_lift) == 1.0
    return f"{text}{format_name(curve.against)}" + (f", power {power:.3g} J" if has_power else "")


def _definition(curve: ControllingForce) -> str:
    number = "one ball" if curve.n_balls == 1 else f"each of {curve.n_balls} balls"
    mass = curve.equivalent_mass[curve.equivalent_mass > 0.0]
    is_point = mass.size and np.ptp(mass) <= 1e-6 * mass.max()
    lines = "speed lines C = m ω² r, straight" if is_point else "speed lines ½ ω² dJ/dr (balls, arms and links)"
    return f"C of {number} by virtual work: dV = {curve.n_balls if curve.n_balls > 1 else ''}C dr;  {lines}; stable where C is steeper"


def _shown_part(curve: ControllingForce) -> BoolArray:
    """Return which points are shown: about the working range, or up to a speed not far above the median."""
    shown: BoolArray = curve.has_equilibrium & (curve.force > 0.0)
    if curve.working_range is not None:
        inner, outer = curve.working_range.radius
        margin = _SHOWN_BEYOND_RANGE * (outer - inner) if curve.working_range.limited_by == "values" else 0.0
        return np.asarray(shown & (curve.radius >= inner - margin) & (curve.radius <= outer + margin))
    if not shown.any():
        return shown
    shown &= curve.speed < _MAX_SHOWN_SPEED_RATIO * float(np.median(curve.speed[shown]))
    return shown


def _axis_limits(curve: ControllingForce, shown: BoolArray) -> tuple[float, float]:
    """Return the largest radius (mm) and the largest force (N) of the figure."""
    highest = curve.rising_force if curve.resistance else curve.force
    return 1.08 * MM_PER_M * float(curve.radius[shown].max()), 1.12 * float(highest[shown].max())


def _draw_force_curve(panel: Panel, curve: ControllingForce, shown: BoolArray) -> None:
    kinds = (
        (curve.stable, "-", BLUE, "stable: steeper than the speed line"),
        (~curve.stable & ~curve.astatic, DASHED, VERMILLION, "unstable: less steep than the speed line"),
        (curve.astatic, (0, (3, 1.2)), GREEN, "neutral: it is a speed line itself"),
    )
    for kind, style, colour, text in kinds:
        force = np.where(shown & kind, curve.force, np.nan)
        if not np.all(np.isnan(force)):
            panel.plot(curve.radius * MM_PER_M, force, linestyle=style, color=colour, linewidth=2.0, label=text, zorder=4)


def _draw_friction_band(panel: Panel, scene: Scene, curve: ControllingForce, shown: BoolArray) -> None:
    unit = "N m" if scene.part.mechanism.reading(curve.against).quantity == "angle" else "N"
    text = f"held by {curve.resistance:g} {unit} at the {format_name(curve.against)}"
    radius = curve.radius * MM_PER_M
    panel.fill_between(radius, curve.falling_force, curve.rising_force, where=shown, color=SKY, alpha=0.25, linewidth=0, label=text)
    for force in (curve.falling_force, curve.rising_force):
        panel.plot(radius, np.where(shown, force, np.nan), color=SKY, linewidth=0.9, zorder=3)


def _draw_speed_lines(panel: Panel, curve: ControllingForce, shown: BoolArray, limits: tuple[float, float]) -> None:
    """Draw the fan of speed lines from the origin, each with its speed where it leaves the panel."""
    order = np.argsort(curve.radius[shown])
    radius, mass = curve.radius[shown][order], curve.equivalent_mass[shown][order]
    radius = np.append(radius, limits[0] / MM_PER_M)
    mass = np.append(mass, mass[-1])
    next_top = math.inf  # largest radius (mm) of the next label above the panel
    for rpm in _choose_speeds(curve, shown):
        force = mass * (rpm * RPM) ** 2 * radius
        style: dict[str, Any] = {"color": MUTED, "fontsize": 8, "annotation_clip": False}
        if force[-1] <= limits[1]:
            panel.write_note(f"{rpm:.6g} rpm", (limits[0], force[-1]), (4, 0), va="center", **style)
        else:
            top = float(np.interp(limits[1], np.append(0.0, force), np.append(0.0, radius))) * MM_PER_M
            if top > next_top:
                continue
            next_top = top - _MIN_TOP_DISTANCE * limits[0]
            panel.write_note(f"{rpm:.6g} rpm", (top, limits[1]), (0, 3), ha="center", **style)
        panel.plot(np.append(0.0, radius * MM_PER_M), np.append(0.0, force), color=MUTED, linewidth=0.8, zorder=1)


def _choose_speeds(curve: ControllingForce, shown: BoolArray) -> FloatArray:
    """Return round speeds (rpm) a little below and above the shown equilibrium speeds, at distances that leave room for the labels."""
    rpm = curve.speed[shown] / RPM
    low, high = float(rpm.min()), float(rpm.max())
    # The force grows with the square of the speed, so that labels at the right edge are 2 (step / speed) of the height apart.
    step = _round_up(max((high - low) / _N_SPEED_LINES, 0.5 * _MIN_LABEL_DISTANCE * high))
    first = math.floor(low / step * (1 + 1e-9))
    last = math.ceil(high / step * (1 - 1e-9))
    if last - first + 1 < _MIN_SPEED_LINES:
        first, last = first - 1, last + 1
    return step * np.arange(max(first, 1), last + 1, dtype=np.float64)


def _round_up(value: float) -> float:
    """Return the next of 1, 2, 2.5 and 5 times a power of ten."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(factor * decade for factor in (1.0, 2.0, 2.5, 5.0, 10.0) if factor * decade >= value * (1 - 1e-12))


def _draw_working_range(panel: Panel, ends: WorkingRange, limits: tuple[float, float]) -> None:
    """Mark both ends of the working range, and name what limits it."""
    radius = ends.radius * MM_PER_M
    panel.axvspan(*radius, color=INK, alpha=0.045, linewidth=0, zorder=0)
    kind = "stop" if ends.limited_by == "stops" else "end"
    for name, side, at, force in zip(("inner", "outer"), ("right", "left"), radius, ends.force, strict=True):
        panel.plot([at, at], [0.0, limits[1]], color=INK, linewidth=0.8, linestyle=DOTTED, zorder=2)
        panel.plot([at], [force], "o", color=INK, markersize=3.5, zorder=5)
        panel.write_note(f"{name} {kind}", (at, 0.0), (-3 if side == "right" else 3, 5), ha=side, color=INK, fontsize=8)


def _mark_equilibrium_forces(panel: Panel, curve: ControllingForce, shown: BoolArray, equilibria: Sequence[Equilibrium]) -> None:
    """Mark equilibria on the curve: filled if stable, and else hollow."""
    for equilibrium in (one for one in equilibria if not one.astatic):
        radius, force = (float(np.interp(equilibrium.coordinate, curve.coordinate, values)) for values in (curve.radius, curve.force))
        if curve.radius[shown].min() <= radius <= curve.radius[shown].max():
            fill = INK if equilibrium.stable else PAPER
            panel.plot([radius * MM_PER_M], [force], "o", color=INK, markerfacecolor=fill, markersize=7, zorder=6)
            speed = float(np.interp(equilibrium.coordinate, curve.coordinate, curve.speed)) / RPM
            panel.annotate_point((radius * MM_PER_M, force), f"{speed:.4g} rpm", (7, -11), fontsize=9)


def equilibrium_figures(report: EquilibriumReport) -> Mapping[str, Figure]:
    """Draw speed curve, controlling force if there are balls, and Zehnder's plate for the governors that it covers."""
    if report.curve is None:
        return {}
    figures = {"_characteristic": report.curve.plot(report.equilibria)}
    if isinstance(report.forces, GovernorForces):
        figures["_controlling_force"] = report.forces.curve.plot(report.equilibria)
    if has_isochronous_parabolas(report.scene):
        figures["_parabolas"] = isochronous_figure(report.scene)
    return figures

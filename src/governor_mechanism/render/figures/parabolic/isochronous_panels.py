"""The two panels of Zehnder's plate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from governor_mechanism.render.figures.engraving_sheet import (
    CHAIN_DOTTED,
    DASHED,
    DOTTED,
    MM_PER_M,
    AxesPoint,
    annotate_point,
    draw_point,
    polar_points,
    style_plate_axes,
)
from governor_mechanism.render.figures.parabolic.isochronous_data import (
    ARM_RATIOS,
    MARKED_ANGLE_CHANGES,
    MAX_ANGLE_CHANGE,
    IsochronousPlateData,
    PlatePoint,
    speed_deviation_curve,
)
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, ROLE_STYLES, SERIES_COLOURS, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.types import FloatArray

_RPM_PER_RAD_S = 30 / math.pi


@dataclass(frozen=True)
class ArmStyle:
    """Label and colour of an arm."""

    name: str
    colour: str


ARM_STYLES = {
    1.0: ArmStyle("$l = \\rho$", BLUE),
    1.3: ArmStyle("$l = 1.3\\,\\rho$", SERIES_COLOURS[3]),
    0.7: ArmStyle("$l = 0.7\\,\\rho$", GREEN),
}
"""Styles by ratio of the arm to the radius of curvature."""


@dataclass(frozen=True)
class FamilyPanelLimits:
    """Limits of the left panel (mm)."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> float:
        """Larger side (mm)."""
        return max(self.right - self.left, self.top - self.bottom)


def family_panel_limits(data: IsochronousPlateData, aspect: float) -> FamilyPanelLimits:
    """Return limits with width : height = aspect that contain both centres, the horizontal arm and the 45-degree point."""
    x45, y45 = data.point_at_45_degrees(data.start_speed)
    xs = (0.0, data.centre_of_curvature[0], data.suspension[0], data.offset + data.arm, 1.5 * x45)
    ys = (0.0, data.centre_of_curvature[1], data.suspension[1], 1.5 * y45)
    left, right, bottom, top = (MM_PER_M * value for value in (min(xs), max(xs), min(ys), max(ys)))
    margin = 0.06 * max(right - left, top - bottom)
    left, right, bottom, top = left - 2.8 * margin, right + margin / 2, bottom - margin, top + margin
    missing_width = aspect * (top - bottom) - (right - left)
    if missing_width > 0:
        return FamilyPanelLimits(left - 0.35 * missing_width, right + 0.65 * missing_width, bottom, top)
    return FamilyPanelLimits(left, right, bottom, top - missing_width / aspect)


def draw_parabola_family(axes: Axes, data: IsochronousPlateData, aspect: float) -> None:
    """Draw the left panel: parabolas, the ball path and the circle of curvature, in mm and to one scale on both axes."""
    limits = family_panel_limits(data, aspect)
    style_plate_axes(axes, "distance from the spindle axis, mm", "height above the vertex, mm")
    axes.set(xlim=(limits.left, limits.right), ylim=(limits.bottom, limits.top), aspect="equal")
    axes.plot([0, 0], [limits.bottom, limits.top], color=MUTED, linewidth=1.0, linestyle=CHAIN_DOTTED, zorder=1)
    annotate_point(axes, (0, limits.top), "spindle axis", (5, 0), color=MUTED, rotation=90, va="top")
    for speed in data.speeds:
        _draw_parabola(axes, data, limits, speed)
    _draw_45_degree_line(axes, data, limits)
    _draw_governor(axes, data, limits)
    _draw_circle_of_curvature(axes, data)


def _draw_parabola(axes: Axes, data: IsochronousPlateData, limits: FamilyPanelLimits, speed: float) -> None:
    """Draw one parabola of the family on both sides, with its speed at the edge of the panel."""
    is_start_speed = speed == data.start_speed
    colour, width = (INK, 2.0) if is_start_speed else (MUTED, 0.8)
    c = data.double_parameter(speed) * MM_PER_M
    end = min(limits.right, math.sqrt(c * limits.top))
    for limit, width_ratio in ((end, 1.0), (max(limits.left, -end), 0.5)):
        x = np.linspace(0, limit, 200)
        axes.plot(x, x**2 / c, color=colour, linewidth=width * width_ratio, zorder=2)
    text = f"{speed * _RPM_PER_RAD_S:.4g}" + (" rpm" if is_start_speed else "")
    offset, ha, va = ((5, 0), "left", "center") if end == limits.right else ((0, 4), "center", "bottom")
    annotate_point(axes, (end, end**2 / c), text, offset, ha=ha, va=va, color=colour, weight="bold" if is_start_speed else "normal")


def _draw_45_degree_line(axes: Axes, data: IsochronousPlateData, limits: FamilyPanelLimits) -> None:
    """Draw the line x = 2 y, and the 45-degree tangents of the parabolas on it."""
    end = min(limits.right, 2 * limits.top)
    axes.plot([0, end], [0, end / 2], color=GREEN, linewidth=1.0, zorder=3)
    half_length = 0.018 * limits.size
    points = [tuple(MM_PER_M * value for value in data.point_at_45_degrees(speed)) for speed in data.speeds]
    visible_points = [(x, y) for x, y in points if x + half_length < limits.right and y + half_length < limits.top]
    for x, y in visible_points:
        axes.plot([x - half_length, x + half_length], [y - half_length, y + half_length], color=GREEN, linewidth=1.4, zorder=4)
        draw_point(axes, x, y, color=GREEN, markersize=3.5, zorder=4)
    text = "on $x = 2y$ all slopes are 45°\nand the spacing is largest:\nZehnder's start point"
    annotate_point(axes, (limits.right, limits.bottom), text, (0, 5), color=GREEN, ha="right", va="bottom", linespacing=1.4)


def _draw_circle_of_curvature(axes: Axes, data: IsochronousPlateData) -> None:
    """Draw the osculating circle of the parabola at the start point, its centre and radius."""
    centre, start = _to_mm(data.centre_of_curvature), _to_mm(data.start_point)
    circle = _circle_points(centre, data.radius_of_curvature * MM_PER_M, np.linspace(-math.pi / 6, math.pi / 2 + 0.1, 400))
    axes.plot(*circle, color=BLUE, linewidth=1.3, linestyle=DASHED, zorder=5)
    axes.plot(*centre, "+", color=BLUE, markersize=12, markeredgewidth=1.5, zorder=8)
    if data.starts_at_osculation:
        text = "suspension,\ncentre of\ncurvature"
    else:
        text = "centre of\ncurvature"
        axes.plot(*zip(centre, start, strict=True), color=BLUE, linewidth=0.8, linestyle=DASHED, zorder=3)
        suspension = _to_mm(data.suspension)
        middle = (centre[0] + suspension[0]) / 2, (centre[1] + suspension[1]) / 2
        _label_along_arm(axes, data, middle, f"$\\rho$ = {data.radius_of_curvature * MM_PER_M:.4g} mm", BLUE)
    annotate_point(axes, centre, text, (-9, -9), color=BLUE, ha="right", va="top")


def _draw_governor(axes: Axes, data: IsochronousPlateData, limits: FamilyPanelLimits) -> None:
    """Draw suspension, arm and ball at the start point, and the path of the ball, wide over the travel."""
    suspension, start, arm = _to_mm(data.suspension), _to_mm(data.start_point), data.arm * MM_PER_M
    low, high = data.travel
    axes.plot(*_circle_points(suspension, arm, np.linspace(low, high, 300)), color=SKY, linewidth=6, alpha=0.75, zorder=3)
    axes.plot(*_circle_points(suspension, arm, np.linspace(low - 0.3, low, 60)), color=SKY, linewidth=1.2, zorder=3)
    axes.plot(*zip(suspension, start, strict=True), color=INK, linewidth=1.8, zorder=6)
    ball = ROLE_STYLES["ball"]
    axes.add_patch(Circle(start, 0.02 * limits.size, facecolor=ball.fill, edgecolor=ball.stroke, linewidth=1.2, zorder=7))
    axes.plot(*start, "o", color=PAPER, markersize=2.5, zorder=8)
    axes.plot(*suspension, "o", color=INK, markerfacecolor=PAPER, markersize=8, zorder=7)
    arm_ratio_text = "= \\rho$" if data.starts_at_osculation else f"= {data.arm / data.radius_of_curvature:.2f}\\,\\rho$"
    middle = (suspension[0] + start[0]) / 2, (suspension[1] + start[1]) / 2
    _label_along_arm(axes, data, middle, f"$l {arm_ratio_text} = {arm:.4g} mm", INK)
    if not data.starts_at_osculation:
        annotate_point(axes, suspension, "suspension", (9, 2), va="center")
    annotate_point(axes, _circle_points(suspension, arm, high), "path of the ball", (-22, 0), ha="right", va="center", color=BLUE)
    parabola_ordinate = 0.5 * start[0] ** 2 / (data.double_parameter(data.speeds[0]) * MM_PER_M)
    axes.plot([start[0]] * 2, [start[1], parabola_ordinate], color=INK, linewidth=0.7, zorder=6)
    text = f"{'osculation' if data.starts_at_osculation else 'start'} point"
    crowded = start[0] - limits.left > 0.65 * (limits.right - limits.left)
    annotate_point(axes, (start[0], parabola_ordinate), text, (0, -3), ha="right" if crowded else "center", va="top")
    _draw_arm_angle(axes, data)


def _draw_arm_angle(axes: Axes, data: IsochronousPlateData) -> None:
    """Draw the arm angle at the start, from the vertical below the suspension."""
    suspension, arc_radius = _to_mm(data.suspension), 0.24 * data.arm * MM_PER_M
    axes.plot([suspension[0]] * 2, [suspension[1], suspension[1] - 1.15 * arc_radius], color=MUTED, linewidth=0.7, zorder=3)
    axes.plot(*_circle_points(suspension, arc_radius, np.linspace(0, data.start_angle, 60)), color=MUTED, linewidth=0.7, zorder=3)
    annotate_point(
        axes, _circle_points(suspension, arc_radius, data.start_angle / 2), "$\\alpha_1$", (2, -8), ha="center", va="center", color=MUTED
    )


def _label_along_arm(axes: Axes, data: IsochronousPlateData, middle: PlatePoint, text: str, colour: str) -> None:
    """Write a label along the arm, above it."""
    offset, rotation = polar_points(data.start_angle, 10), math.degrees(data.start_angle) - 90
    annotate_point(axes, middle, text, offset, color=colour, ha="center", va="center", rotation=rotation)


def _to_mm(point: PlatePoint) -> PlatePoint:
    return MM_PER_M * point[0], MM_PER_M * point[1]


def _circle_points(centre: PlatePoint, radius: float, angles: FloatArray | float) -> AxesPoint:
    """Return points (n,), (n,) of a circle at angles (n,) from the downward vertical (rad)."""
    return centre[0] + radius * np.sin(angles), centre[1] - radius * np.cos(angles)


def draw_speed_deviations(axes: Axes, data: IsochronousPlateData) -> None:
    """Draw the right panel: changes of the equilibrium speed (percent) against changes of the arm angle (deg) for three arms."""
    style_plate_axes(axes, "change of the arm angle, deg", "change of the equilibrium speed, %")
    curves = {arm_ratio: speed_deviation_curve(data, arm_ratio) for arm_ratio in ARM_RATIOS}
    limit = 1.5 * 100 * float(np.abs(curves[0.7].equilibrium_speed_changes).max())
    axis_limit = 1.05 * math.degrees(MAX_ANGLE_CHANGE)
    axes.set(xlim=(-axis_limit, axis_limit), ylim=(-limit, limit))
    axes.axhline(0, color=MUTED, linewidth=0.8, zorder=1)
    axes.axvline(0, color=MUTED, linewidth=0.8, zorder=1)
    for arm_ratio, curve in curves.items():
        arm = ARM_STYLES[arm_ratio]
        degrees, percent = np.degrees(curve.angle_changes), 100 * curve.equilibrium_speed_changes
        parabola_percent = 100 * curve.parabola_speed_changes
        is_rising = np.gradient(percent, degrees) > 0
        for is_stable, style in ((True, "-"), (False, DASHED)):
            part = np.where(is_rising == is_stable, percent, np.nan)
            axes.plot(degrees, part, color=arm.colour, linewidth=2.2, linestyle=style, zorder=4)
        axes.plot(degrees, parabola_percent, color=arm.colour, linewidth=1.1, linestyle=DOTTED, zorder=3)
        axes.plot(degrees[[0, -1]], parabola_percent[[0, -1]], "x", color=VERMILLION, markersize=7, markeredgewidth=1.6, zorder=6)
        marked_changes = speed_deviation_curve(data, arm_ratio, MARKED_ANGLE_CHANGES)
        points = np.degrees(marked_changes.angle_changes), 100 * marked_changes.equilibrium_speed_changes
        axes.plot(*points, "o", color=arm.colour, markersize=4.5, zorder=5)
        annotate_point(axes, (degrees[-1], percent[-1]), arm.name, (9, 0), color=arm.colour, va="center", fontsize=12)
    _add_legend(axes)


def _add_legend(axes: Axes) -> None:
    cross = {"marker": "x", "markersize": 7, "markeredgewidth": 1.6, "markeredgecolor": VERMILLION}
    styles: list[dict[str, Any]] = [
        {"linewidth": 2.2},
        {"linewidth": 2.2, "linestyle": DASHED},
        {"linewidth": 1.1, "linestyle": DOTTED, **cross},
    ]
    labels = ("stable", "unstable", "parabola through the ball")
    handles = [Line2D([], [], color=INK, label=label, **style) for label, style in zip(labels, styles, strict=True)]
    text_style = {"family": SERIF_FONT, "size": 10}
    legend = axes.legend(handles=handles, loc="lower right", bbox_to_anchor=(1.08, 0), framealpha=1, handlelength=2.5, prop=text_style)
    legend.get_frame().set(facecolor=PAPER, linewidth=0)

"""The two panels of Zehnder's plate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from governor_mechanism.render.figures.engraving_sheet import CHAIN, DASHES, DOTS, MM, dress, letter
from governor_mechanism.render.figures.parabolic.isochronous_data import MARKS, SHARES, SPAN, Plate, Point, leaving
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, SERIES, SERIF, SKY, STYLES, VERMILLION
from governor_mechanism.types import FloatArray

PER_MINUTE = 30 / math.pi


@dataclass(frozen=True)
class Arm:
    """How an arm is named and coloured."""

    name: str
    colour: str


ARMS = {1.0: Arm("$l = \\rho$", BLUE), 1.3: Arm("$l = 1.3\\,\\rho$", SERIES[3]), 0.7: Arm("$l = 0.7\\,\\rho$", GREEN)}
"""By share of the radius of curvature."""


@dataclass(frozen=True)
class View:
    """What the left panel shows (mm)."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def size(self) -> float:
        """The larger side (mm)."""
        return max(self.right - self.left, self.top - self.bottom)


def view_of(plate: Plate, aspect: float) -> View:
    """Room of width : height = aspect for both centres, the arm raised level and the point of 45 degrees."""
    x45, y45 = plate.parting_point(plate.start_speed)
    xs = (0.0, plate.centre[0], plate.suspension[0], plate.offset + plate.arm, 1.5 * x45)
    ys = (0.0, plate.centre[1], plate.suspension[1], 1.5 * y45)
    left, right, bottom, top = (MM * value for value in (min(xs), max(xs), min(ys), max(ys)))
    margin = 0.06 * max(right - left, top - bottom)
    left, right, bottom, top = left - 2.8 * margin, right + margin / 2, bottom - margin, top + margin
    lacking = aspect * (top - bottom) - (right - left)
    if lacking > 0:
        return View(left - 0.35 * lacking, right + 0.65 * lacking, bottom, top)
    return View(left, right, bottom, top - lacking / aspect)


def draw_family(axes: Axes, plate: Plate, aspect: float) -> None:
    """The left panel: parabolas, the ball's path and the circle of curvature, in mm and to one scale both ways."""
    view = view_of(plate, aspect)
    dress(axes, "distance from the spindle axis, mm", "height above the vertex, mm")
    axes.set(xlim=(view.left, view.right), ylim=(view.bottom, view.top), aspect="equal")
    axes.plot([0, 0], [view.bottom, view.top], color=QUIET, linewidth=1.0, linestyle=CHAIN, zorder=1)
    letter(axes, (0, view.top), "spindle axis", (5, 0), color=QUIET, rotation=90, va="top")
    for speed in plate.speeds:
        _parabola(axes, plate, view, speed)
    _parting_line(axes, plate, view)
    _governor(axes, plate, view)
    _circle_of_curvature(axes, plate)


def _parabola(axes: Axes, plate: Plate, view: View, speed: float) -> None:
    """One parabola of the family, to both sides, with its speed where it leaves the view."""
    own = speed == plate.start_speed
    colour, width = (INK, 2.0) if own else (QUIET, 0.8)
    c = plate.parameter(speed) * MM
    end = min(view.right, math.sqrt(c * view.top))
    for limit, share in ((end, 1.0), (max(view.left, -end), 0.5)):
        x = np.linspace(0, limit, 200)
        axes.plot(x, x**2 / c, color=colour, linewidth=width * share, zorder=2)
    words = f"{speed * PER_MINUTE:.4g}" + (" rpm" if own else "")
    to_the_right = {"offset": (5, 0), "ha": "left", "va": "center"}
    above = {"offset": (0, 4), "ha": "center", "va": "bottom"}
    look: dict[str, Any] = to_the_right if end == view.right else above
    letter(axes, (end, end**2 / c), words, **look, color=colour, weight="bold" if own else "normal")


def _parting_line(axes: Axes, plate: Plate, view: View) -> None:
    """The line x = 2 y, and on every parabola its tangent of 45 degrees there."""
    end = min(view.right, 2 * view.top)
    axes.plot([0, end], [0, end / 2], color=GREEN, linewidth=1.0, zorder=3)
    half = 0.018 * view.size
    points = [tuple(MM * value for value in plate.parting_point(speed)) for speed in plate.speeds]
    seen = [(x, y) for x, y in points if x + half < view.right and y + half < view.top]
    for x, y in seen:
        axes.plot([x - half, x + half], [y - half, y + half], color=GREEN, linewidth=1.4, zorder=4)
        axes.plot([x], [y], "o", color=GREEN, markersize=3.5, zorder=4)
    words = "on $x = 2y$ all rise at 45°\nand neighbours part most:\nZehnder would start here"
    letter(axes, (view.right, view.bottom), words, (0, 5), color=GREEN, ha="right", va="bottom", linespacing=1.4)


def _circle_of_curvature(axes: Axes, plate: Plate) -> None:
    """The circle that osculates the parabola at the start point, its centre and radius."""
    centre, start = _mm(plate.centre), _mm(plate.start)
    x, y = _on_circle(centre, plate.radius * MM, np.linspace(-math.pi / 6, math.pi / 2 + 0.1, 400))
    axes.plot(x, y, color=BLUE, linewidth=1.3, linestyle=DASHES, zorder=5)
    axes.plot(*centre, "+", color=BLUE, markersize=12, markeredgewidth=1.5, zorder=8)
    if plate.osculates:
        words = "suspension,\ncentre of\ncurvature"
    else:
        words = "centre of\ncurvature"
        axes.plot(*zip(centre, start, strict=True), color=BLUE, linewidth=0.8, linestyle=DASHES, zorder=3)
        hang = _mm(plate.suspension)
        middle = (centre[0] + hang[0]) / 2, (centre[1] + hang[1]) / 2
        _along(axes, plate, middle, f"$\\rho$ = {plate.radius * MM:.4g} mm", BLUE)
    letter(axes, centre, words, (-9, -9), color=BLUE, ha="right", va="top")


def _governor(axes: Axes, plate: Plate, view: View) -> None:
    """Suspension, arm and ball at the start point, and the ball's path, broad over the travel."""
    hang, start, arm = _mm(plate.suspension), _mm(plate.start), plate.arm * MM
    low, high = plate.travel
    axes.plot(*_on_circle(hang, arm, np.linspace(low, high, 300)), color=SKY, linewidth=6, alpha=0.75, zorder=3)
    axes.plot(*_on_circle(hang, arm, np.linspace(low - 0.3, low, 60)), color=SKY, linewidth=1.2, zorder=3)
    axes.plot(*zip(hang, start, strict=True), color=INK, linewidth=1.8, zorder=6)
    ball = STYLES["ball"]
    axes.add_patch(Circle(start, 0.02 * view.size, facecolor=ball.fill, edgecolor=ball.stroke, linewidth=1.2, zorder=7))
    axes.plot(*start, "o", color=PAPER, markersize=2.5, zorder=8)
    axes.plot(*hang, "o", color=INK, markerfacecolor=PAPER, markersize=8, zorder=7)
    own = "= \\rho$" if plate.osculates else f"= {plate.arm / plate.radius:.2f}\\,\\rho$"
    middle = (hang[0] + start[0]) / 2, (hang[1] + start[1]) / 2
    _along(axes, plate, middle, f"$l {own} = {arm:.4g} mm", INK)
    if not plate.osculates:
        letter(axes, hang, "suspension", (9, 2), va="center")
    end = _on_circle(hang, arm, np.array(high))
    letter(axes, (float(end[0]), float(end[1])), "path of the ball", (-22, 0), ha="right", va="center", color=BLUE)
    below = 0.5 * start[0] ** 2 / (plate.parameter(plate.speeds[0]) * MM)
    axes.plot([start[0]] * 2, [start[1], below], color=INK, linewidth=0.7, zorder=6)
    words = f"{'osculation' if plate.osculates else 'start'} point"
    crowded = start[0] - view.left > 0.65 * (view.right - view.left)
    letter(axes, (start[0], below), words, (0, -3), ha="right" if crowded else "center", va="top")
    _angle(axes, plate)


def _angle(axes: Axes, plate: Plate) -> None:
    """The arm angle at the start, from the vertical beneath the suspension."""
    hang, reach = _mm(plate.suspension), 0.24 * plate.arm * MM
    axes.plot([hang[0]] * 2, [hang[1], hang[1] - 1.15 * reach], color=QUIET, linewidth=0.7, zorder=3)
    axes.plot(*_on_circle(hang, reach, np.linspace(0, plate.start_angle, 60)), color=QUIET, linewidth=0.7, zorder=3)
    x, y = _on_circle(hang, reach, np.array(plate.start_angle / 2))
    letter(axes, (float(x), float(y)), "$\\alpha_1$", (2, -8), ha="center", va="center", color=QUIET)


def _along(axes: Axes, plate: Plate, middle: Point, words: str, colour: str) -> None:
    """Words along the arm, above it."""
    slope = math.degrees(plate.start_angle) - 90
    a = plate.start_angle
    offset = 10 * math.cos(a), 10 * math.sin(a)
    letter(axes, middle, words, offset, color=colour, ha="center", va="center", rotation=slope)


def _mm(point: Point) -> Point:
    return MM * point[0], MM * point[1]


def _on_circle(centre: Point, radius: float, angles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points (n,), (n,) of a circle at angles (n,) from the downward vertical (rad)."""
    return centre[0] + radius * np.sin(angles), centre[1] - radius * np.cos(angles)


def draw_leaving(axes: Axes, plate: Plate) -> None:
    """The right panel: changes of the speed of rest (percent) against changes of the arm angle (deg) for three arms."""
    dress(axes, "change of the arm angle, deg", "change of the speed of rest, %")
    curves = {share: leaving(plate, share) for share in SHARES}
    limit = 1.5 * 100 * float(np.abs(curves[0.7].true).max())
    reach = 1.05 * math.degrees(SPAN)
    axes.set(xlim=(-reach, reach), ylim=(-limit, limit))
    axes.axhline(0, color=QUIET, linewidth=0.8, zorder=1)
    axes.axvline(0, color=QUIET, linewidth=0.8, zorder=1)
    for share, curve in curves.items():
        arm = ARMS[share]
        degrees, percent, read = np.degrees(curve.turns), 100 * curve.true, 100 * curve.read
        rising = np.gradient(percent, degrees) > 0
        for wanted, style in ((True, "-"), (False, DASHES)):
            part = np.where(rising == wanted, percent, np.nan)
            axes.plot(degrees, part, color=arm.colour, linewidth=2.2, linestyle=style, zorder=4)
        axes.plot(degrees, read, color=arm.colour, linewidth=1.1, linestyle=DOTS, zorder=3)
        axes.plot(degrees[[0, -1]], read[[0, -1]], "x", color=VERMILLION, markersize=7, markeredgewidth=1.6, zorder=6)
        marks = leaving(plate, share, MARKS)
        axes.plot(np.degrees(marks.turns), 100 * marks.true, "o", color=arm.colour, markersize=4.5, zorder=5)
        letter(axes, (degrees[-1], percent[-1]), arm.name, (9, 0), color=arm.colour, va="center", fontsize=12)
    _key(axes)


def _key(axes: Axes) -> None:
    handles = [
        Line2D([], [], color=INK, linewidth=2.2, label="stable"),
        Line2D([], [], color=INK, linewidth=2.2, linestyle=DASHES, label="unstable"),
        Line2D(
            [],
            [],
            color=INK,
            linewidth=1.1,
            linestyle=DOTS,
            marker="x",
            markersize=7,
            markeredgewidth=1.6,
            markeredgecolor=VERMILLION,
            label="parabola under the ball",
        ),
    ]
    key = axes.legend(
        handles=handles,
        loc="lower right",
        bbox_to_anchor=(1.08, 0),
        framealpha=1,
        handlelength=2.5,
        prop={"family": SERIF, "size": 10},
    )
    key.get_frame().set(facecolor=PAPER, linewidth=0)

"""The plate of a slider crank's bearings: what they carry over a turn, by its run and by the closed form."""

from __future__ import annotations

import math
import os
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from numpy.typing import NDArray

from governor_mechanism.closed_form.slider_crank import BearingLoads, CrankTrain, bearing_loads, crosshead_distance
from governor_mechanism.effects.crank_masses import Masses
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.engraving_sheet import (
    CHAIN,
    DASHES,
    HEIGHT,
    WIDTH,
    dress,
    letter,
    require_png,
    save,
    sheet,
    write,
)
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, SERIES, SERIF, STEEL, VERMILLION
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.slider_crank import train_of

HEADING = "What the bearings of a slider crank carry"
SOURCE = "by inertia and weight, the crank turning steadily"

FORCES, ENGINE = (0.062, 0.37, 0.50, 0.46), (0.03, 0.085, 0.54, 0.2)
TORQUE, GUIDE = (0.655, 0.545, 0.30, 0.285), (0.655, 0.135, 0.30, 0.285)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

FIGURE, USUAL = 0.008, 2
"""Breadth of a figure of the numbers up the first panel's side, of the whole plate; so many figures find room there."""

BEARINGS = {"shaft": BLUE, "crank pin": VERMILLION, "gudgeon": GREEN}

KILO = 1e-3

WHOLE = math.tau * (1 - 1e-9)
"""rad: a whole turn, but for rounding."""

LEAST = 1e-3
"""kN: less is drawn as rest, as of a balanced crank that moves nothing."""

EVERY, SHOWN = 30, 300
"""deg of the crank: between the marks that are named, and where the engine is shown."""

ARROW = 1.3
"""Length of the largest arrow, in cranks."""


def bearings_figure(run: Trajectory, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the loads of a slider crank's bearings, from a run of at least a turn in which parts have mass.

    Returns the path. Raises MechanismError for other runs; an exception leaves no file behind.
    """
    require_png(path)
    return save(draw(run), path)


def draw(run: Trajectory) -> Figure:
    """The plate as a figure. Raises MechanismError for runs that it cannot show."""
    scene = run.scene
    _refuse(run)
    sizes = scene.part.dimensions
    train, speed = train_of(scene), sizes["crank_speed"]
    turn = np.linspace(0.0, math.tau, 721)
    exact = bearing_loads(train, crank_angle=turn, crank_rate=speed, gravity=scene.gravity)
    one = run.readings["crank_angle"] <= sizes["crank_start"] + math.tau
    figure = sheet(HEADING, scene.title, SOURCE)
    captions = (
        (0.03, 0.862, "Fig. 1.  Forces of frame on crank, crank on rod, and rod on crosshead, with the crank’s angle"),
        (0.03, 0.292, f"Fig. 2.  The same at {SHOWN} degrees, as arrows on the parts that feel them"),
        (0.605, 0.862, "Fig. 3.  Torque of the drive"),
        (0.605, 0.452, "Fig. 4.  Force of the guide on the crosshead"),
    )
    for x, y, caption in captions:
        write(figure, x, y, caption, 11.5, fontstyle="italic")
    _forces(figure.add_axes(FORCES), run, exact, one)
    _engine(figure.add_axes(ENGINE), train, exact)
    angles = np.degrees(run.readings["crank_angle"][one] % math.tau)
    drive, guide = run.reactions["drive"].moment[one], run.reactions["crosshead guide"].force[one, 1]
    _curve(figure.add_axes(TORQUE), (angles, drive), (turn, exact.torque), "torque, N m", 1.0)
    _curve(figure.add_axes(GUIDE), (angles, guide), (turn, exact.guide), "force upward, kN", KILO)
    _sizes(figure, run, train)
    return figure


def _refuse(run: Trajectory) -> None:
    part = run.scene.part
    massive = any(isinstance(effect, Masses) for effect in run.scene.effects)
    if part.machine != "slider_crank" or not massive or part.mechanism.loads or run.scene.acting:
        raise MechanismError(
            "loads of bearings are shown of machine 'slider_crank' with effects.masses, and nothing else that acts on "
            f"its parts; this scene has {part.machine!r}"
        )
    if not len(run.times) or np.ptp(run.readings["crank_angle"]) < WHOLE:
        raise MechanismError("loads of bearings are shown over a whole turn, and the run ends before one; lengthen it")


def _forces(axes: Axes, run: Trajectory, exact: BearingLoads, one: NDArray[np.bool_]) -> None:
    """Each force as a point of the plane (kN), over a turn: the run's points on the closed form's curve."""
    dress(axes, "force along the line of the crosshead, kN", "force across it, kN")
    axes.axhline(0, color=QUIET, linewidth=0.7, zorder=1)
    axes.axvline(0, color=QUIET, linewidth=0.7, zorder=1)
    curves = {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}
    every = np.concatenate([force for name, force in curves.items() if name in run.reactions]) * KILO
    room = 0.12 * max(np.ptp(every[:, 0]), np.ptp(every[:, 1]), LEAST)
    low, high = every.min(axis=0) - room, every.max(axis=0) + room
    # Room for numbers of many figures between the label and the frame.
    more = FIGURE * max(len(f"{1.25 * float(np.abs(every[:, 1]).max()):.0f}") - USUAL, 0)
    axes.set_position((FORCES[0] + more, FORCES[1], FORCES[2] - more, FORCES[3]))
    aspect = (FORCES[2] - more) * WIDTH / (FORCES[3] * HEIGHT)
    half = max((high[0] - low[0]) / 2, aspect * (high[1] - low[1]) / 2)
    middle = (low + high) / 2
    axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half / aspect, middle[1] + half / aspect))
    handles = []
    for name, force in curves.items():
        if name not in run.reactions:
            continue
        colour = BEARINGS[name]
        axes.plot(*(force.T * KILO), color=colour, linewidth=1.8, zorder=3)
        found = run.reactions[name].force[one] * KILO
        axes.plot(found[::4, 0], found[::4, 1], "o", color=colour, markersize=2.6, zorder=4)
        for degree in range(0, 360, EVERY):
            at = force[2 * degree] * KILO
            axes.plot(*at, "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=5)
            if name == "shaft":
                out = at - middle
                offset = 11 * out / max(float(np.hypot(*out)), 1e-12)
                letter(
                    axes, tuple(at), f"{degree}°", tuple(offset), ha="center", va="center", fontsize=8.5, color=QUIET
                )
        handles.append(Line2D([], [], color=colour, linewidth=1.8, marker="o", markersize=5, label=name))
    key = axes.legend(handles=handles, loc="upper right", frameon=False, handlelength=2.2)
    for text in key.get_texts():
        text.set(fontfamily=SERIF, fontsize=10.5)


def _engine(axes: Axes, train: CrankTrain, exact: BearingLoads) -> None:
    """The slider crank at one angle, with each force as an arrow from its bearing."""
    k, r = 2 * SHOWN, train.crank
    angle = math.radians(SHOWN)
    pin = r * math.cos(angle), r * math.sin(angle)
    end = float(np.asarray(crosshead_distance(train, crank_angle=angle))), 0.0
    aspect = ENGINE[2] * WIDTH / (ENGINE[3] * HEIGHT)
    middle = (end[0] + r) / 2 - r / 2
    half = max((end[0] + 3.2 * r) / 2, aspect * 1.25 * r)
    axes.set(xlim=(middle - half, middle + half), ylim=(-half / aspect, half / aspect), aspect="equal")
    axes.set_axis_off()
    axes.plot([-1.3 * r, end[0] + r], [0, 0], color=QUIET, linewidth=0.7, linestyle=CHAIN, zorder=1)
    axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=QUIET, linewidth=0.7, linestyle=DASHES, zorder=1))
    guide, block = 0.26 * r, 0.22 * r
    for side in (guide, -guide):
        axes.plot([end[0] - 0.9 * r, end[0] + 0.9 * r], [side, side], color=QUIET, linewidth=1.0, zorder=2)
    for start, stop, width in (((0.0, 0.0), pin, 7.0), (pin, end, 5.0)):
        for colour, thick in ((INK, width + 1.6), (STEEL, width)):
            xs, ys = zip(start, stop, strict=True)
            axes.plot(xs, ys, color=colour, linewidth=thick, solid_capstyle="round", zorder=3)
    box = Rectangle(
        (end[0] - 0.3 * r, -block), 0.6 * r, 2 * block, facecolor=STEEL, edgecolor=INK, linewidth=0.9, zorder=4
    )
    axes.add_patch(box)
    for spot in ((0.0, 0.0), pin, end):
        axes.plot(*spot, "o", color=INK, markerfacecolor=PAPER, markersize=7, zorder=5)
    forces = (
        ((0.0, 0.0), exact.main[k], BLUE),
        (pin, exact.crank_pin[k], VERMILLION),
        (end, exact.gudgeon[k], GREEN),
        (end, np.array([0.0, exact.guide[k]]), SERIES[3]),
    )
    largest = max(*(float(np.hypot(*force)) for _, force, _ in forces), LEAST / KILO)
    for spot, force, colour in forces:
        tip = spot[0] + ARROW * r * force[0] / largest, spot[1] + ARROW * r * force[1] / largest
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tip, spot, arrowprops=arrow, zorder=8)


def _curve(
    axes: Axes, found: tuple[FloatArray, FloatArray], exact: tuple[FloatArray, FloatArray], name: str, factor: float
) -> None:
    """A load over the crank's angle: points of the run, the curve of the closed form, and its mean."""
    dress(axes, "crank angle from the outer dead centre, deg", name)
    axes.axhline(0, color=QUIET, linewidth=0.7, zorder=1)
    axes.plot(np.degrees(exact[0]), exact[1] * factor, color=SERIES[3], linewidth=1.8, zorder=3)
    axes.plot(found[0][::4], found[1][::4] * factor, "o", color=SERIES[3], markersize=2.6, zorder=4)
    mean = float(np.mean(exact[1][:-1])) * factor
    axes.axhline(mean, color=INK, linewidth=0.7, linestyle=DASHES, zorder=2)
    axes.set(xlim=(0, 360), xticks=range(0, 361, 60))


def _sizes(figure: Figure, run: Trajectory, train: CrankTrain) -> None:
    """Sizes and masses, beneath the panels."""
    speed = run.scene.part.dimensions["crank_speed"] * 30 / math.pi
    words = (
        f"crank $R$ = {train.crank * 1e3:.4g} mm, {train.crank_mass:.4g} kg at {train.crank_centre * 1e3:.4g} mm;  rod "
        f"$L$ = {train.rod * 1e3:.5g} mm, {train.rod_mass:.4g} kg at {train.rod_centre * 1e3:.4g} mm;  crosshead "
        f"{train.crosshead_mass:.4g} kg;  {speed:.4g} rpm.  Curves: closed form, points: engine {run.cost.engine}; "
        "broken: the mean"
    )
    write(figure, 0.5, 0.043, words.replace(" -", " −"), 10.5, ha="center", color=QUIET)

"""Plate of the bearing loads of a slider crank over a turn, from a run and from the closed form."""

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
from governor_mechanism.effects.crank_masses import CrankMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.figures.engraving_sheet import (
    CHAIN_DOTTED,
    DASHED,
    PLATE_HEIGHT,
    PLATE_WIDTH,
    annotate_point,
    new_plate,
    polar_points,
    style_plate_axes,
    write_text,
)
from governor_mechanism.render.figures.page import require_png, save_png
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, SERIF_FONT, STEEL, VERMILLION
from governor_mechanism.types import FloatArray
from governor_mechanism.verification.slider_crank import build_crank_train

_HEADING = "Bearing loads of a slider crank"
_SOURCE = "from inertia and weight, at constant crank speed"

_FORCES_RECT, _ENGINE_RECT = (0.062, 0.37, 0.50, 0.46), (0.03, 0.085, 0.54, 0.2)
_TORQUE_RECT, _GUIDE_RECT = (0.655, 0.545, 0.30, 0.285), (0.655, 0.135, 0.30, 0.285)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_DIGIT_WIDTH, _N_DIGITS_WITHOUT_SHIFT = 0.008, 2
"""Width of a digit of the ordinate labels, as a fraction of the figure; number of digits that fit without moving the axes."""

_BEARING_COLOURS = {"shaft": BLUE, "crank pin": VERMILLION, "gudgeon": GREEN}

_KILO_PER_UNIT = 1e-3

MIN_FULL_TURN = math.tau * (1 - 1e-9)
"""Smallest crank rotation (rad) that counts as a whole turn; the margin allows for rounding."""

_MIN_FORCE_SCALE_KN = 1e-3
"""Smallest force scale (kN); a balanced crank without moving masses has zero force."""

_LABEL_INTERVAL_DEG, _SHOWN_ANGLE_DEG = 30, 300
"""Crank angle between labelled markers, and crank angle of the drawn engine (deg)."""

_MAX_ARROW_LENGTH = 1.3
"""Length of the longest arrow, in crank radii."""


def bearing_loads_figure(run: Trajectory, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the bearing loads of a slider crank, from a run of at least one turn with masses, and return its path.

    Raises MechanismError for other runs. An exception leaves no file behind.
    """
    require_png(path)
    return save_png(draw_bearing_loads(run), path)


def draw_bearing_loads(run: Trajectory) -> Figure:
    """Return the plate as a figure; raise MechanismError for a run that it cannot show."""
    scene = run.scene
    _check_run(run)
    dimensions = scene.part.dimensions
    crank_train, speed = build_crank_train(scene), dimensions["crank_speed"]
    crank_angles = np.linspace(0.0, math.tau, 721)
    exact = bearing_loads(crank_train, crank_angle=crank_angles, crank_rate=speed, gravity=scene.gravity)
    first_turn = run.readings["crank_angle"] <= dimensions["crank_start"] + math.tau
    figure = new_plate(_HEADING, scene.title, _SOURCE)
    captions = (
        (0.03, 0.862, "Fig. 1.  Forces of frame on crank, crank on rod, and rod on crosshead, with crank angles"),
        (0.03, 0.292, f"Fig. 2.  The same at {_SHOWN_ANGLE_DEG} degrees, as arrows at the loaded parts"),
        (0.605, 0.862, "Fig. 3.  Drive torque"),
        (0.605, 0.452, "Fig. 4.  Guide force on the crosshead"),
    )
    for x, y, caption in captions:
        write_text(figure, x, y, caption, 11.5, fontstyle="italic")
    _draw_force_loci(figure.add_axes(_FORCES_RECT), run, exact, first_turn)
    _draw_engine(figure.add_axes(_ENGINE_RECT), crank_train, exact)
    angles = np.degrees(run.readings["crank_angle"][first_turn] % math.tau)
    drive, guide = run.reactions["drive"].moment[first_turn], run.reactions["crosshead guide"].force[first_turn, 1]
    _draw_load_curve(figure.add_axes(_TORQUE_RECT), (angles, drive), (crank_angles, exact.torque), "torque, N m", 1.0)
    _draw_load_curve(figure.add_axes(_GUIDE_RECT), (angles, guide), (crank_angles, exact.guide), "force upward, kN", _KILO_PER_UNIT)
    _write_dimensions(figure, run, crank_train)
    return figure


def _check_run(run: Trajectory) -> None:
    part = run.scene.part
    has_masses = any(isinstance(effect, CrankMasses) for effect in run.scene.effects)
    if part.machine != "slider_crank" or not has_masses or part.mechanism.force_elements or run.scene.output_effects:
        raise MechanismError(
            "bearing loads need machine 'slider_crank' with effects.masses, and no output effects or force elements; "
            f"this scene has machine {part.machine!r}; the closed form knows no other loads"
        )
    if not len(run.times) or np.ptp(run.readings["crank_angle"]) < MIN_FULL_TURN:
        raise MechanismError("bearing loads need a run of a whole turn of the crank, and this run is shorter; increase run.duration")


def _draw_force_loci(axes: Axes, run: Trajectory, exact: BearingLoads, first_turn: NDArray[np.bool_]) -> None:
    """Draw each force over a turn as a locus in the plane (kN): points of the run on the curve of the closed form."""
    style_plate_axes(axes, "force along the line of the crosshead, kN", "force across it, kN")
    axes.axhline(0, color=MUTED, linewidth=0.7, zorder=1)
    axes.axvline(0, color=MUTED, linewidth=0.7, zorder=1)
    curves = {"shaft": exact.main, "crank pin": exact.crank_pin, "gudgeon": exact.gudgeon}
    all_forces = np.concatenate([force for name, force in curves.items() if name in run.reactions]) * _KILO_PER_UNIT
    margin = 0.12 * max(np.ptp(all_forces[:, 0]), np.ptp(all_forces[:, 1]), _MIN_FORCE_SCALE_KN)
    low, high = all_forces.min(axis=0) - margin, all_forces.max(axis=0) + margin
    # Leave room for numbers of many digits between the label and the frame.
    label_space = _DIGIT_WIDTH * max(len(f"{1.25 * float(np.abs(all_forces[:, 1]).max()):.0f}") - _N_DIGITS_WITHOUT_SHIFT, 0)
    axes.set_position((_FORCES_RECT[0] + label_space, _FORCES_RECT[1], _FORCES_RECT[2] - label_space, _FORCES_RECT[3]))
    aspect = (_FORCES_RECT[2] - label_space) * PLATE_WIDTH / (_FORCES_RECT[3] * PLATE_HEIGHT)
    half_width = max((high[0] - low[0]) / 2, aspect * (high[1] - low[1]) / 2)
    middle = (low + high) / 2
    axes.set(xlim=(middle[0] - half_width, middle[0] + half_width), ylim=(middle[1] - half_width / aspect, middle[1] + half_width / aspect))
    handles = []
    for name, force in curves.items():
        if name not in run.reactions:
            continue
        colour = _BEARING_COLOURS[name]
        axes.plot(*(force.T * _KILO_PER_UNIT), color=colour, linewidth=1.8, zorder=3)
        simulated = run.reactions[name].force[first_turn] * _KILO_PER_UNIT
        axes.plot(simulated[::4, 0], simulated[::4, 1], "o", color=colour, markersize=2.6, zorder=4)
        for degree in range(0, 360, _LABEL_INTERVAL_DEG):
            point = force[2 * degree] * _KILO_PER_UNIT
            axes.plot(*point, "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=5)
            if name == "shaft":
                outward = point - middle
                offset = 11 * outward / max(float(np.hypot(*outward)), 1e-12)
                annotate_point(axes, tuple(point), f"{degree}°", tuple(offset), ha="center", va="center", fontsize=8.5, color=MUTED)
        handles.append(Line2D([], [], color=colour, linewidth=1.8, marker="o", markersize=5, label=name))
    legend = axes.legend(handles=handles, loc="upper right", frameon=False, handlelength=2.2)
    for text in legend.get_texts():
        text.set(fontfamily=SERIF_FONT, fontsize=10.5)


def _draw_engine(axes: Axes, crank_train: CrankTrain, exact: BearingLoads) -> None:
    """Draw the slider crank at one angle, with each force as an arrow at its bearing."""
    angle_index, r = 2 * _SHOWN_ANGLE_DEG, crank_train.crank
    angle = math.radians(_SHOWN_ANGLE_DEG)
    pin = polar_points(angle, r)
    crosshead = float(np.asarray(crosshead_distance(crank_train, crank_angle=angle))), 0.0
    aspect = _ENGINE_RECT[2] * PLATE_WIDTH / (_ENGINE_RECT[3] * PLATE_HEIGHT)
    middle = (crosshead[0] + r) / 2 - r / 2
    half_width = max((crosshead[0] + 3.2 * r) / 2, aspect * 1.25 * r)
    axes.set(xlim=(middle - half_width, middle + half_width), ylim=(-half_width / aspect, half_width / aspect), aspect="equal")
    axes.set_axis_off()
    axes.plot([-1.3 * r, crosshead[0] + r], [0, 0], color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=MUTED, linewidth=0.7, linestyle=DASHED, zorder=1))
    guide, block = 0.26 * r, 0.22 * r
    for side in (guide, -guide):
        axes.plot([crosshead[0] - 0.9 * r, crosshead[0] + 0.9 * r], [side, side], color=MUTED, linewidth=1.0, zorder=2)
    for start, stop, width in (((0.0, 0.0), pin, 7.0), (pin, crosshead, 5.0)):
        for colour, line_width in ((INK, width + 1.6), (STEEL, width)):
            axes.plot(*zip(start, stop, strict=True), color=colour, linewidth=line_width, solid_capstyle="round", zorder=3)
    box = Rectangle((crosshead[0] - 0.3 * r, -block), 0.6 * r, 2 * block, facecolor=STEEL, edgecolor=INK, linewidth=0.9, zorder=4)
    axes.add_patch(box)
    for point in ((0.0, 0.0), pin, crosshead):
        axes.plot(*point, "o", color=INK, markerfacecolor=PAPER, markersize=7, zorder=5)
    forces = (
        ((0.0, 0.0), exact.main[angle_index], BLUE),
        (pin, exact.crank_pin[angle_index], VERMILLION),
        (crosshead, exact.gudgeon[angle_index], GREEN),
        (crosshead, np.array([0.0, exact.guide[angle_index]]), SERIES_COLOURS[3]),
    )
    largest = max(*(float(np.hypot(*force)) for _, force, _ in forces), _MIN_FORCE_SCALE_KN / _KILO_PER_UNIT)
    for point, force, colour in forces:
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", tuple(np.add(point, _MAX_ARROW_LENGTH * r * force / largest)), point, arrowprops=arrow, zorder=8)


def _draw_load_curve(
    axes: Axes, simulated: tuple[FloatArray, FloatArray], exact: tuple[FloatArray, FloatArray], label: str, factor: float
) -> None:
    """Draw a load over the crank angle: points of the run, the curve of the closed form, and its mean."""
    style_plate_axes(axes, "crank angle from the outer dead centre, deg", label)
    axes.axhline(0, color=MUTED, linewidth=0.7, zorder=1)
    axes.plot(np.degrees(exact[0]), exact[1] * factor, color=SERIES_COLOURS[3], linewidth=1.8, zorder=3)
    axes.plot(simulated[0][::4], simulated[1][::4] * factor, "o", color=SERIES_COLOURS[3], markersize=2.6, zorder=4)
    mean = float(np.mean(exact[1][:-1])) * factor
    axes.axhline(mean, color=INK, linewidth=0.7, linestyle=DASHED, zorder=2)
    axes.set(xlim=(0, 360), xticks=range(0, 361, 60))


def _write_dimensions(figure: Figure, run: Trajectory, crank_train: CrankTrain) -> None:
    """Write lengths and masses below the panels."""
    speed = run.scene.part.dimensions["crank_speed"] * 30 / math.pi
    text = (
        f"crank $R$ = {crank_train.crank * 1e3:.4g} mm, {crank_train.crank_mass:.4g} kg at {crank_train.crank_centre * 1e3:.4g} mm;  rod "
        f"$L$ = {crank_train.rod * 1e3:.5g} mm, {crank_train.rod_mass:.4g} kg at {crank_train.rod_centre * 1e3:.4g} mm;  crosshead "
        f"{crank_train.crosshead_mass:.4g} kg;  {speed:.4g} rpm.  Curves: closed form, points: engine {run.cost.engine}; "
        "dashed: the mean"
    )
    write_text(figure, 0.5, 0.043, text.replace(" -", " −"), 10.5, ha="center", color=MUTED)

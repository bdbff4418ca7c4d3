"""Figures of a designed Hartung governor: its astatic spring lines, and how even its sleeve force is."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, RULE, SANS, SERIES, SERIF, VERMILLION
from governor_mechanism.studies.hartung.design import KGF, HartungDesign, lay_out
from governor_mechanism.studies.hartung.paper_comparison import FORCES, SLIDE_RULE, SPEEDS, dubois

SIZE, DPI = (7.6, 5.2), 120
PLACE = (0.11, 0.15, 0.85, 0.66)
MM = 1e3
ANGLES = (90.0, 132.0, 137.332)
"""deg: Hartung's right angle, the angle that Dubois takes, and the one that his formula gives."""


NEARLY = 0.2
"""Of the mean: forces that change by less are shown enlarged."""


def spring_lines_figure(design: HartungDesign, path: str | os.PathLike[str], *, printed: bool = False) -> Path:
    """Write a PNG of the spring forces that hold the weights at both speeds, and of the straight spring between them.

    printed: with the points of Dubois' table, whose misprint is marked (his Figs. 12 and 13).
    """
    layout, inputs = design.layout, design.inputs
    slow, fast = (f"{speed * 30 / math.pi:.4g} rpm" for speed in (inputs.slow_speed, inputs.fast_speed))
    figure, axes = _begin("Astatic spring forces", f"and the effective spring from {slow} inside to {fast} outside")
    x = layout.radii * MM
    for forces, colour, words in (
        (layout.fast_forces, VERMILLION, f"holds at {fast}"),
        (layout.slow_forces, BLUE, f"holds at {slow}"),
        (layout.spring_forces, INK, f"spring, {layout.rate / KGF / MM:.4g} kgf/mm"),
    ):
        axes.plot(x, forces / KGF, color=colour, linewidth=1.5, label=words)
    if printed:
        _printed_points(axes)
    axes.set_xlabel("radius of the weights' centres, mm", color=INK, fontsize=10, fontfamily=SERIF)
    axes.set_ylabel("force of each spring, kgf", color=INK, fontsize=10, fontfamily=SERIF)
    _legend(axes, "upper left")
    words = f"bell crank {math.degrees(design.angle):.5g} deg, arms {_mm(layout.governor.weight_arm)} and "
    return _written(figure, f"{words}{_mm(layout.governor.sleeve_arm)}; one kgf is {KGF:g} N", path)


def sleeve_force_figure(design: HartungDesign, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of the static sleeve force over the stroke, for several angles of the bell crank and the best one."""
    layouts = [(angle, lay_out(design.inputs, math.radians(angle))) for angle in _angles(design)]
    figure, axes = _begin("How even the static sleeve force is", "each angle with springs straight through both speeds")
    axes.set_position((0.09, 0.15, 0.40, 0.66))
    near = figure.add_axes((0.585, 0.15, 0.395, 0.66))
    _furnish(near)
    for (angle, layout), colour in zip(layouts, (*SERIES, INK, QUIET), strict=False):
        best = abs(math.radians(angle) - design.best_angle) < math.radians(0.01)
        words = f"{angle:.6g} deg: {100 * layout.spread:.3g} %" + (", the best" if best else "")
        levers, forces = np.degrees(layout.levers), layout.static_forces / KGF
        axes.plot(levers, forces, color=colour, linewidth=1.6, label=words)
        if layout.spread < NEARLY:
            near.plot(levers, forces, color=colour, linewidth=1.6)
    axes.set_ylim(0.0, 1.12 * max(float(layout.static_forces.max()) for _, layout in layouts) / KGF)
    axes.set_ylabel("static sleeve force S, kgf", color=INK, fontsize=10, fontfamily=SERIF)
    for each, words in ((axes, "lever angle, deg, going out"), (near, "the same, the even ones enlarged")):
        each.invert_xaxis()
        each.set_xlabel(words, color=INK, fontsize=10, fontfamily=SERIF)
    _legend(axes, "lower right")
    return _written(figure, "percent: largest less smallest force over the stroke, of their mean", path)


def _angles(design: HartungDesign) -> list[float]:
    """The paper's angles (deg), and those of the design and the best one where a line could tell them from these."""
    kept = list(ANGLES)
    for angle in (design.best_angle, design.angle):
        degrees = math.degrees(angle)
        if min(abs(degrees - other) for other in kept) > 0.2:
            kept.append(round(degrees, 3))
    return sorted(kept)


def _printed_points(axes: Axes) -> None:
    """Dubois' table; what is no slip of a slide rule is ringed."""
    radii = [row[0] for row in FORCES]
    for column, colour in ((1, BLUE), (2, VERMILLION)):
        axes.plot(radii, [row[column] for row in FORCES], "o", color=colour, markersize=4, markerfacecolor=PAPER)
    wrong = [step for step in dubois().table if abs(step.printed - step.recomputed) > SLIDE_RULE]
    for step in wrong:
        radius = next(row[0] for row in FORCES if step.printed in row[1:])
        axes.plot([radius], [step.printed], "o", color=GREEN, markersize=13, markerfacecolor="none")
        words = f"printed {step.printed:g},\nrecomputed {step.recomputed:.1f}"
        note = axes.annotate(words, (radius, step.printed), (-12, 20), textcoords="offset points")
        note.set(color=GREEN, fontsize=8.5, fontfamily=SANS)
    speeds = " and ".join(f"{speed:g}" for speed in SPEEDS)
    axes.plot([], [], "o", color=QUIET, markersize=4, markerfacecolor=PAPER, label=f"Dubois' table, {speeds} rad/s")


def _begin(title: str, below: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=SIZE, dpi=DPI, facecolor=PAPER)
    figure.text(0.02, 0.945, title, fontsize=15, va="center", color=INK, fontfamily=SERIF)
    figure.text(0.02, 0.89, below, fontsize=10, va="center", color=QUIET, fontfamily=SERIF)
    axes = figure.add_axes(PLACE)
    _furnish(axes)
    return figure, axes


def _furnish(axes: Axes) -> None:
    axes.set_facecolor(PAPER)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)


def _legend(axes: Axes, place: Literal["upper left", "lower right"]) -> None:
    legend = axes.legend(frameon=False, fontsize=8.5, loc=place, handlelength=1.6, labelcolor=INK)
    for text in legend.get_texts():
        text.set_fontfamily(SANS)


def _mm(metres: float) -> str:
    return f"{metres * MM:.5g} mm"


def _written(figure: Figure, foot: str, path: str | os.PathLike[str]) -> Path:
    """Write the figure; an exception leaves no file behind."""
    figure.text(0.02, 0.022, foot, color=QUIET, fontsize=7.5, fontfamily=SANS)
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    with written_beside(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target

"""Still figures of runs, off-screen."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from governor_mechanism.errors import MechanismError
from governor_mechanism.files import written_beside
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, RULE, SANS, SERIF, SHOWN, VERMILLION, accuracy_line
from governor_mechanism.trajectory import Trajectory

Array = NDArray[np.float64]

WIDTH, ROW, BORDER = 9.6, 1.9, 0.85
"""Inches: of the figure, of a row of plots, of title and footer together."""
DPI = 100
ROUNDING = 1e-18
"""What is drawn for a zero on a logarithmic axis."""


def readings_figure(run: Trajectory, path: str | os.PathLike[str]) -> Path:
    """Write a PNG of every reading over time, in everyday units, with the joint gap and the energy drift below them.

    Returns the path. An exception leaves no file behind.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    if not len(run.times):
        raise MechanismError(f"the run holds no reported time, so there is nothing to show; it says: {run.message}")
    figure = _draw(run)
    with written_beside(target) as temporary:
        # Without the name of the program, equal runs give equal files.
        FigureCanvasAgg(figure).print_png(str(temporary), metadata={"Software": None})
    return target


def _draw(run: Trajectory) -> Figure:
    rows = math.ceil(len(run.readings) / 2) + 1
    figure = Figure(figsize=(WIDTH, rows * ROW + BORDER), dpi=DPI, facecolor=PAPER)
    height = rows * ROW + BORDER
    grid = figure.add_gridspec(
        rows, 2, left=0.075, right=0.985, top=1 - 0.75 / height, bottom=0.75 / height, hspace=0.62, wspace=0.17
    )
    for k, (name, values) in enumerate(run.readings.items()):
        _reading(figure.add_subplot(grid[k // 2, k % 2]), run, name, values)
    drift = np.abs(run.energy.jacobi - run.energy.jacobi[0]) / run.energy.scale
    _errors(figure.add_subplot(grid[rows - 1, 0]), run.times, run.joint_gap, "widest joint gap", "m")
    _errors(figure.add_subplot(grid[rows - 1, 1]), run.times, drift, "energy drift", "of the energy scale")
    for axes in figure.axes[-2:]:
        axes.set_xlabel("time, s", color=QUIET, fontsize=8, fontfamily=SANS)
    title = {"color": INK, "fontfamily": SERIF, "parse_math": False}
    figure.text(0.02, 1 - 0.27 / height, run.scene.title, fontsize=15, va="center", **title)
    words, bad = accuracy_line(run)
    figure.text(0.02, 0.16 / height, words, color=VERMILLION if bad else QUIET, fontsize=8.5, va="center", fontfamily=SANS)
    return figure

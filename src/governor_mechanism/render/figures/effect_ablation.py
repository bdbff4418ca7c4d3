"""Figure of effect ablation: the change that each effect causes, and its cost."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import atomic_write
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SANS_FONT, SERIF_FONT, SKY, VERMILLION
from governor_mechanism.studies.effect_ablation import EffectsStudy

_FIGURE_WIDTH, _ROW_HEIGHT, _HEADER_HEIGHT, _DPI = 8.4, 0.42, 1.6, 100
"""Figure width, row height, height of header and footer together (inches), and resolution (dots per inch)."""

_MIN_PLOTTED_CHANGE = 1e-16
"""Left end of the bars of changes; smaller changes are not visible."""


def effect_ablation_figure(study: EffectsStudy, path: str | os.PathLike[str]) -> Path:
    """Write a PNG with the largest change of any reading by each effect, the requested accuracy, and the time of each effect.

    An exception leaves no file behind.

    Parameters
    ----------
    study
        Result of an effect study.
    path
        File to write; its name ends in .png.

    Returns
    -------
    Path
        The path of the file.

    Raises
    ------
    MechanismError
        If the name does not end in .png.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    height = _HEADER_HEIGHT + _ROW_HEIGHT * max(len(study.rows), 1)
    figure = Figure(figsize=(_FIGURE_WIDTH, height), dpi=_DPI, facecolor=PAPER)
    bottom, axes_height = 0.85 / height, _ROW_HEIGHT * max(len(study.rows), 1) / height
    changes_axes = figure.add_axes((0.2, bottom, 0.42, axes_height))
    costs_axes = figure.add_axes((0.68, bottom, 0.28, axes_height), sharey=changes_axes)
    _draw_changes(changes_axes, study)
    _draw_costs(costs_axes, study)
    title = figure.text(0.02, 1 - 0.3 / height, f"{study.scene.title}: cost of its effects", fontsize=14, va="center")
    title.set(color=INK, fontfamily=SERIF_FONT, parse_math=False)
    with atomic_write(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def _draw_changes(axes: Axes, study: EffectsStudy) -> None:
    rows = study.rows
    positions = np.arange(len(rows))[::-1]
    for position, row in zip(positions, rows, strict=True):
        if row.relative_change is None:
            axes.text(study.accuracy, position, " cannot be switched off", va="center", fontsize=8, color=MUTED)
            continue
        within_accuracy = row.relative_change < study.accuracy
        axes.barh(
            position,
            max(row.relative_change, 2 * _MIN_PLOTTED_CHANGE),
            left=_MIN_PLOTTED_CHANGE,
            height=0.6,
            color=SKY if within_accuracy else BLUE,
        )
    axes.axvline(study.accuracy, color=VERMILLION, linewidth=1.2)
    text = axes.annotate("requested accuracy", (study.accuracy, len(rows) - 0.45), (3, 2), textcoords="offset points")
    text.set(color=VERMILLION, fontsize=8, fontfamily=SANS_FONT, annotation_clip=False)
    axes.set_xscale("log")
    axes.set_xlim(min(1e-2 * study.accuracy, 1e-10), 10.0)
    axes.set_yticks(positions, [_effect_label(row.effect, listed=row.listed) for row in rows])
    axes.set_ylim(-0.6, len(rows) - 0.4)
    _style_axes(axes, "largest change of a reading, in units of its scale")


def _draw_costs(axes: Axes, study: EffectsStudy) -> None:
    for position, row in zip(range(len(study.rows) - 1, -1, -1), study.rows, strict=True):
        ratio = row.time_ratio
        if ratio is not None:
            axes.barh(position, ratio - 1.0, left=1.0, height=0.6, color=MUTED)
            side = 4 if ratio >= 1 else -4
            text = axes.annotate(f"{ratio:.2f}", (ratio, position), (side, 0), textcoords="offset points")
            text.set(va="center", ha="left" if ratio >= 1 else "right", fontsize=8, fontfamily=SANS_FONT, color=INK)
    axes.axvline(1.0, color=INK, linewidth=0.8)
    axes.margins(x=0.25)
    axes.tick_params(labelleft=False)
    _style_axes(axes, "time with it / without it")


def _effect_label(effect: str, *, listed: bool) -> str:
    label = effect.replace("_", " ").replace("spindle.", "")
    return label if listed else f"{label} (not listed)"


def _style_axes(axes: Axes, label: str) -> None:
    axes.set_facecolor(PAPER)
    axes.set_xlabel(label, color=INK, fontsize=9, fontfamily=SERIF_FONT)
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=MUTED, linewidth=0.8)
    axes.tick_params(color=MUTED, labelcolor=INK, labelsize=8, labelfontfamily=SANS_FONT)
    axes.grid(axis="x", color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)

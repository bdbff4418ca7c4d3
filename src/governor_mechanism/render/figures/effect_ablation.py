"""Figure of effect ablation: the change that each effect causes, and its cost."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from governor_mechanism.render.figures.page import label_axes, new_figure, save_png, style_axes, write_note, write_title
from governor_mechanism.render.number_format import format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, SKY, VERMILLION
from governor_mechanism.studies.effect_ablation import EffectsStudy

_FIGURE_WIDTH, _ROW_HEIGHT, _HEADER_HEIGHT = 8.4, 0.42, 1.6
"""Figure width, row height, height of header and footer together, inches."""

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
        File to write; another ending than .png raises MechanismError.

    Returns
    -------
    Path
        The path of the file.
    """
    height = _HEADER_HEIGHT + _ROW_HEIGHT * max(len(study.rows), 1)
    figure = new_figure(_FIGURE_WIDTH, height)
    bottom, axes_height = 0.85 / height, _ROW_HEIGHT * max(len(study.rows), 1) / height
    changes_axes = figure.add_axes((0.2, bottom, 0.42, axes_height))
    costs_axes = figure.add_axes((0.68, bottom, 0.28, axes_height), sharey=changes_axes)
    _draw_changes(changes_axes, study)
    _draw_costs(costs_axes, study)
    write_title(figure, f"{study.scene.title}: cost of its effects", y=1 - 0.3 / height, size=14)
    return save_png(figure, path)


def _draw_changes(axes: Axes, study: EffectsStudy) -> None:
    rows = study.rows
    positions = np.arange(len(rows))[::-1]
    for position, row in zip(positions, rows, strict=True):
        if row.relative_change is None:
            axes.text(study.accuracy, position, " cannot be switched off", va="center", fontsize=8, color=MUTED)
            continue
        width, colour = max(row.relative_change, 2 * _MIN_PLOTTED_CHANGE), SKY if row.relative_change < study.accuracy else BLUE
        axes.barh(position, width, left=_MIN_PLOTTED_CHANGE, height=0.6, color=colour)
    axes.axvline(study.accuracy, color=VERMILLION, linewidth=1.2)
    point = (study.accuracy, len(rows) - 0.45)
    write_note(axes, "requested accuracy", point, (3, 2), color=VERMILLION, fontsize=8, annotation_clip=False)
    axes.set_xscale("log")
    axes.set_xlim(min(1e-2 * study.accuracy, 1e-10), 10.0)
    axes.set_yticks(positions, [_effect_label(row.effect, listed=row.listed) for row in rows])
    axes.set_ylim(-0.6, len(rows) - 0.4)
    style_axes(axes, tick_colour=INK, grid="x")
    label_axes(axes, "largest change of a reading, in units of its scale", size=9)


def _draw_costs(axes: Axes, study: EffectsStudy) -> None:
    for position, row in zip(range(len(study.rows) - 1, -1, -1), study.rows, strict=True):
        ratio = row.time_ratio
        if ratio is not None:
            axes.barh(position, ratio - 1.0, left=1.0, height=0.6, color=MUTED)
            offset, alignment = (4, "left") if ratio >= 1 else (-4, "right")
            write_note(axes, f"{ratio:.2f}", (ratio, position), (offset, 0), va="center", ha=alignment, fontsize=8, color=INK)
    axes.axvline(1.0, color=INK, linewidth=0.8)
    axes.margins(x=0.25)
    axes.tick_params(labelleft=False)
    style_axes(axes, tick_colour=INK, grid="x")
    label_axes(axes, "time with it / without it", size=9)


def _effect_label(effect: str, *, listed: bool) -> str:
    label = format_name(effect.replace("spindle.", ""))
    return label if listed else f"{label} (not listed)"

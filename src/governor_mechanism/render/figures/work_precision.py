"""Error against time as a figure: a line for each variant of each engine, both ways logarithmic."""

from __future__ import annotations

import os
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.transforms import Bbox

from governor_mechanism.errors import MechanismError
from governor_mechanism.files.atomic_write import written_beside
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, RULE, SANS, SERIF, SKY, VERMILLION
from governor_mechanism.studies.regression import Fitted
from governor_mechanism.studies.work_precision.results import AccuracyStudy, Point, Variant, spoken_time
from governor_mechanism.types import FloatArray

WIDTH, HEIGHT, DPI = 8.4, 5.6, 100

TALL = 0.75
"""Of the figure's height: that of the axes."""

LONG = 60
"""Letters of a scene's title that fit in a line; longer ones are written smaller."""

LETTER = 0.56
"""Of the size of type: how wide a letter is, or a little less."""

AWAY, RING = 10.0, 9.0
"""Pixels: how far words stand from their point, and half the width of a ring about one."""

LOOKS = {
    "reduced": (GREEN, "o"),
    "multibody": (BLUE, "s"),
    "impulse extrapolated": ("#7a3600", "^"),
    "impulse staggered": (VERMILLION, "D"),
    "impulse plain": (QUIET, "v"),
}
"""Colour and marker of a variant."""


def accuracy_figure(study: AccuracyStudy, path: str | os.PathLike[str], wanted: float | None = None) -> Path:
    """Write a PNG: error against time for every setting; `wanted` is an error to mark, and what reaches it quickest.

    Returns the path. An exception leaves no file behind.
    """
    target = Path(path)
    if target.suffix.lower() != ".png":
        raise MechanismError(f"a figure's name must end in .png; got {target.name!r}")
    figure = Figure(figsize=(WIDTH, HEIGHT), dpi=DPI, facecolor=PAPER)
    axes = figure.add_axes((0.095, 0.105, 0.875, TALL))
    _dress(axes, study, wanted)
    shown = [variant for variant in study.variants if variant.points]
    lines = []
    for variant in shown:
        colour, marker = _look(variant)
        seconds = np.array([1e3 * point.seconds for point in variant.points])
        errors = np.array([_height(point, study) for point in variant.points])
        axes.plot(seconds, errors, color=colour, marker=marker, markersize=4.5, linewidth=1.5, zorder=3)
        lines.append((seconds, errors))
    if wanted is not None:
        lines.append((np.array(axes.get_xlim()), np.full(2, wanted)))
    room = Room(axes, lines)
    if wanted is not None:
        _mark_wanted(axes, study, wanted, room)
    _name_lines(axes, shown, study, room)
    size = min(14.0, 14.0 * LONG / len(study.scene.title)) if study.scene.title else 14.0
    title = figure.text(0.02, 0.945, f"{study.scene.title}: error against time", fontsize=size, va="center")
    title.set(color=INK, fontfamily=SERIF, parse_math=False)
    beneath = figure.text(0.02, 0.895, _reference(study), fontsize=8, va="center", color=QUIET, fontfamily=SANS)
    beneath.set_parse_math(False)
    with written_beside(target) as temporary:
        canvas: Any = FigureCanvasAgg(figure)
        canvas.print_png(str(temporary), metadata={"Software": None})
    return target


def _reference(study: AccuracyStudy) -> str:
    reference = study.reference
    told = f"against {reference.engine} at tolerance {reference.tolerance:g}, good to {reference.error:.0e}"
    return f"{told}; {reference.confirmation}"


def _height(point: Point, study: AccuracyStudy) -> float:
    return max(point.reach, study.reference.floor)


class Room:
    """Where on the axes words find room: beside a point, away from lines and from words that stand already."""

    def __init__(self, axes: Axes, lines: Sequence[tuple[FloatArray, FloatArray]]) -> None:
        self._axes = axes
        self._frame = axes.get_window_extent()
        self._full: list[Bbox] = []
        self._dots = np.concatenate([self._along(*line) for line in lines]) if lines else np.empty((0, 2))

    def put(self, words: str, x: float, y: float, colour: str, size: float, places: Sequence[tuple[int, int]]) -> None:
        """Write words beside a point (data), where they cover least; `places` are signs of how far right and up."""
        pixel = DPI / 72
        width, height = LETTER * size * pixel * len(words), 1.3 * size * pixel
        at_x, at_y = self._axes.transData.transform((x, y))
        boxes = []
        for right, up in places:
            low = at_x + right * AWAY + (right - 1) / 2 * width
            boxes.append(Bbox.from_bounds(low, at_y + up * (AWAY + height / 2) - height / 2, width, height))
        box = min(boxes, key=self._covered)
        self._full.append(box)
        left, middle = self._axes.transData.inverted().transform((box.x0, (box.y0 + box.y1) / 2))
        text = self._axes.text(left, middle, words, color=colour, fontsize=size, fontfamily=SANS, va="center", zorder=5)
        text.set_parse_math(False)

    def keep(self, x: float, y: float) -> None:
        """Leave a ring about a point (data) free."""
        middle = self._axes.transData.transform((x, y))
        self._full.append(Bbox([middle - RING, middle + RING]))

    def _along(self, x: FloatArray, y: FloatArray) -> FloatArray:
        ends = self._axes.transData.transform(np.column_stack([x, y]))
        parts = [np.linspace(a, b, 60) for a, b in pairwise(ends)]
        return np.concatenate([ends, *parts])

    def _covered(self, box: Bbox) -> float:
        inside = np.all((self._dots > np.asarray(box.min) - 3) & (self._dots < np.asarray(box.max) + 3), axis=1)
        met = sum(box.overlaps(other) for other in self._full)
        outside = not (self._frame.contains(*box.min) and self._frame.contains(*box.max))
        return float(inside.sum()) + 100.0 * met + 1000.0 * outside


BESIDE = ((1, 0), (1, 1), (-1, 0), (-1, 1), (0, 1), (1, -1), (-1, -1), (0, -1))
"""Where a name may stand beside its point, the best first."""

BELOW = ((-1, -1), (-1, 0), (1, -1), (1, 0), (1, 1), (-1, 1), (0, -1))
"""Where the time of a point may stand."""


def _name_lines(axes: Axes, variants: Sequence[Variant], study: AccuracyStudy, room: Room) -> None:
    """A name at the coarse end of each line."""
    for variant in variants:
        point = variant.points[0]
        order = "" if variant.order is None else f", order {_spoken(variant.order)}"
        place = 1e3 * point.seconds, _height(point, study)
        room.put(f"{variant.name}{order}", *place, _look(variant)[0], 9.0, BESIDE)


def _spoken(order: Fitted) -> str:
    """With its scatter, where that shows."""
    return f"{order.value:.1f} ± {order.scatter:.1f}" if order.scatter >= 0.05 else f"{order.value:.1f}"


def _look(variant: Variant) -> tuple[str, str]:
    return LOOKS.get(variant.name, (SKY, "x"))


def _mark_wanted(axes: Axes, study: AccuracyStudy, wanted: float, room: Room) -> None:
    axes.axhline(wanted, color=INK, linewidth=1.0, linestyle=(0, (5, 3)), zorder=2)
    room.put(f"asked {wanted:g}", axes.get_xlim()[1], wanted, INK, 8.5, ((-1, 1), (-1, -1)))
    found = [point for variant in study.variants if (point := variant.cheapest_for(wanted)) is not None]
    places = [(1e3 * point.seconds, _height(point, study)) for point in found]
    for x, y in places:
        axes.plot([x], [y], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=INK, zorder=4)
        room.keep(x, y)
    for (x, y), point in zip(places, found, strict=True):
        room.put(spoken_time(point.seconds), x, y, INK, 8.5, BELOW)


def _dress(axes: Axes, study: AccuracyStudy, wanted: float | None) -> None:
    seconds = [1e3 * point.seconds for point in study.points] or [1.0, 10.0]
    errors = [*(_height(point, study) for point in study.points), *([] if wanted is None else [wanted])] or [1.0]
    floor = study.reference.floor
    axes.set_facecolor(PAPER)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(min(seconds) / 2.5, max(seconds) * 2.0)
    low = min(floor, min(errors))
    axes.set_ylim(low / 30, max(*errors, 100 * low) * 30)
    axes.axhspan(low / 30, floor, color=RULE, alpha=0.45, linewidth=0)
    words = axes.annotate(
        "less than the reference can tell", (1.0, floor), (-4, -11), xycoords=("axes fraction", "data"),
        textcoords="offset points",
    )  # fmt: skip
    words.set(color=QUIET, fontsize=8, fontfamily=SANS, ha="right")
    axes.set_xlabel("milliseconds of a whole run", color=INK, fontsize=10, fontfamily=SERIF)
    held = any(point.late is not None for point in study.points)
    label = f"largest error of a reading{' or an event time' if held else ''}, in units of its scale"
    axes.set_ylabel(label, color=INK, fontsize=10, fontfamily=SERIF)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_formatter(NullFormatter())
    for side, spine in axes.spines.items():
        spine.set(visible=side in ("left", "bottom"), color=QUIET, linewidth=0.8)
    axes.tick_params(which="both", color=QUIET, labelcolor=INK, labelsize=8, labelfontfamily=SANS)
    axes.grid(color=RULE, linewidth=0.6)
    axes.set_axisbelow(True)

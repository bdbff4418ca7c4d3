"""Heat maps of a sweep over two keys, and rows of them over three."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from governor_mechanism.render.film.reading_panel import limits_for, plain_numbers
from governor_mechanism.render.style import BLUE, INK, PAPER, QUIET, RULE, SANS, SERIF, SKY, STEEL
from governor_mechanism.studies.sweep.parameters import Axis
from governor_mechanism.studies.sweep.quantities import Quantity
from governor_mechanism.studies.sweep.results import Sweep
from governor_mechanism.types import FloatArray

DPI = 100
MAP_WIDTH, MAP_HEIGHT, SPACE_ACROSS, SPACE_DOWN = 3.1, 2.5, 0.25, 0.7
"""Inches: of a map and between maps; a map by itself is larger by LARGER."""

LARGER = 1.7
LEFT, RIGHT, HEAD, FOOT, BAR = 0.85, 0.95, 0.8, 0.7, 0.16
"""Inches: beside, above and below the maps, and the width of a colour bar."""

MOST_PICTURES = 6
"""Of a third key, so many values are shown, from the first to the last."""

COLOURS = LinearSegmentedColormap.from_list("sweep", ["#f0ecd9", SKY, BLUE, "#00243d"])

FAILED_LOOKS = ((RULE, "////"), (STEEL, "...."), (PAPER, "xxxx"), (RULE, "\\\\\\\\"), (STEEL, "----"))
"""Colour and hatching of cells without a number, by the order of outcomes."""

EVEN = 1e-4
"""Of the greatest value: a map whose values differ by less is of one colour."""

MOST_HATCHED = 20_000
"""Cells: in larger maps hatching would take long, and be too fine to be seen."""

MOST_TICKS = 24
"""Words on an axis; of more only some are written."""

MARGIN = 0.02
"""Of its length an axis of curves goes on beyond its outer values."""

DECADES = 100.0
"""Positive values that span as much stand on a logarithmic axis."""


@dataclass(frozen=True, kw_only=True)
class Ruler:
    """An axis of a sweep along an axis of a figure: where its values stand, in rising order, and their names."""

    label: str
    places: FloatArray
    edges: FloatArray
    order: NDArray[np.intp]
    numeric: bool
    logarithmic: bool
    names: tuple[str, ...]

    @classmethod
    def of(cls, axis: Axis) -> Ruler:
        """Numbers in everyday units, words one beside the other in the order in which they were given."""
        factor, unit = axis.everyday
        names = tuple(f"{v * factor:.5g} {unit}".strip() if isinstance(v, float) else str(v) for v in axis.values)
        values = np.array(axis.values, dtype=float) * factor if axis.numeric else np.arange(float(len(axis.values)))
        order = np.argsort(values, kind="stable")
        values = values[order]
        logarithmic = axis.numeric and values[0] > 0 and values[-1] >= DECADES * values[0]
        along = np.log(values) if logarithmic else values
        middles = (along[1:] + along[:-1]) / 2
        half = (middles[0] - along[0], along[-1] - middles[-1]) if len(along) > 1 else (0.5, 0.5)
        edges = np.concatenate([[along[0] - half[0]], middles, [along[-1] + half[1]]])
        return cls(
            label=named(axis.key, unit if axis.numeric else ""),
            places=values,
            edges=np.exp(edges) if logarithmic else edges,
            order=order,
            numeric=axis.numeric,
            logarithmic=logarithmic,
            names=names,
        )

    def set_along(self, axes: Axes, which: Literal["x", "y"], *, cells: bool = False) -> None:
        """Scale, ends and marks of an axis of a figure; its ends are those of the cells, or the outer values."""
        along = axes.xaxis if which == "x" else axes.yaxis
        limits = axes.set_xlim if which == "x" else axes.set_ylim
        if self.logarithmic:
            (axes.set_xscale if which == "x" else axes.set_yscale)("log")
        if cells or len(self.places) == 1 or not self.numeric:
            limits(self.edges[0], self.edges[-1])
        elif self.logarithmic:
            margin = (self.places[-1] / self.places[0]) ** MARGIN
            limits(self.places[0] / margin, self.places[-1] * margin)
        else:
            margin = MARGIN * (self.places[-1] - self.places[0])
            limits(self.places[0] - margin, self.places[-1] + margin)
        if not self.numeric:
            step = -(-len(self.places) // MOST_TICKS)
            along.set_ticks(list(self.places[::step]), labels=list(self.names[::step]))
        elif not self.logarithmic:
            along.set_major_locator(MaxNLocator(5 if which == "x" else 6, min_n_ticks=2))
            plain_numbers(along, (self.places[0], self.places[-1]))


def named(name: str, unit: str) -> str:
    """A key or a quantity with its unit, as a label."""
    words = name.removeprefix("dimensions.").removeprefix("effects.").replace(".", " ").replace("_", " ")
    return f"{words}, {unit}" if unit else words


def draw_maps(sweep: Sweep) -> Figure:
    """A row of maps for each quantity: one map, or one for each value of the third key."""
    shown = _shown(sweep)
    alone = len(sweep.axes) == 2
    larger = LARGER if alone and len(sweep.quantities) == 1 else 1.2 if alone else 1.0
    columns = min(len(sweep.quantities), 2) if alone else len(shown)
    rows = -(-len(sweep.quantities) // columns) if alone else len(sweep.quantities)
    bar_room = RIGHT if alone else 0.0
    wide, high = MAP_WIDTH * larger, MAP_HEIGHT * larger
    across = SPACE_ACROSS + (bar_room + 0.55 if alone else 0.0)
    width = LEFT + columns * wide + (columns - 1) * across + RIGHT
    height = HEAD + 0.25 + rows * high + (rows - 1) * (SPACE_DOWN + 0.1) + FOOT + _legend_room(sweep)
    figure = Figure(figsize=(width, height), dpi=DPI, facecolor=PAPER)

    def place(row: int, column: int) -> Axes:
        left = LEFT + column * (wide + across)
        top = HEAD + 0.25 + row * (high + SPACE_DOWN + 0.1)
        return figure.add_axes((left / width, 1 - (top + high) / height, wide / width, high / height))

    for k, one in enumerate(sweep.quantities):
        spots = [divmod(k, columns)] if alone else [(k, column) for column in range(columns)]
        _row_of_maps(figure, sweep, one, [place(*spot) for spot in spots], shown, last=alone or k == rows - 1)
    title = figure.text(0.25 / width, 1 - 0.32 / height, sweep.title, fontsize=15, va="center")
    title.set(color=INK, fontfamily=SERIF, parse_math=False)
    _legend(figure, sweep, width, height)
    return figure


def _shown(sweep: Sweep) -> list[int]:
    """Which values of the third key are shown."""
    if len(sweep.axes) == 2:
        return [0]
    count = sweep.shape[2]
    return sorted({round(k) for k in np.linspace(0, count - 1, min(count, MOST_PICTURES))})


def _row_of_maps(
    figure: Figure, sweep: Sweep, one: Quantity, places: list[Axes], shown: list[int], *, last: bool
) -> None:
    factor, unit = one.everyday
    rulers = [Ruler.of(axis) for axis in sweep.axes]
    values = sweep.grid(one.name).reshape(*sweep.shape[:2], -1) * factor
    outcomes = np.array(["" if row.ok else row.outcome for row in sweep.rows]).reshape(values.shape)
    finite = values[np.isfinite(values)]
    ends = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    even = ends[1] - ends[0] < EVEN * max(map(abs, ends))
    scale = Normalize(*(limits_for(np.array(ends)) if even or ends[0] == ends[1] else ends))
    order = np.ix_(rulers[0].order, rulers[1].order)
    mesh: Any = None
    for axes, third in zip(places, shown, strict=True):
        mesh = _map(axes, rulers, values[..., third][order].T, outcomes[..., third][order].T, sweep, scale)
        if axes is places[0]:
            axes.set_ylabel(rulers[1].label, color=INK, fontsize=9.5, fontfamily=SERIF)
        else:
            axes.tick_params(labelleft=False)
        if last:
            axes.set_xlabel(rulers[0].label, color=INK, fontsize=9.5, fontfamily=SERIF)
        heading = named(one.name, unit) if len(sweep.axes) == 2 else _third(sweep, third)
        words = axes.text(0.0, 1.04, heading, transform=axes.transAxes, color=INK, fontsize=10.5, fontfamily=SERIF)
        words.set_parse_math(False)
    _colour_bar(figure, places[-1], mesh, "" if len(sweep.axes) == 2 else named(one.name, unit))


def _third(sweep: Sweep, at: int) -> str:
    axis = sweep.axes[2]
    return f"{named(axis.key, '')} {Ruler.of(axis).names[at]}"


def _map(
    axes: Axes, rulers: list[Ruler], values: FloatArray, outcomes: NDArray[Any], sweep: Sweep, scale: Normalize
) -> Any:
    """One map; cells of rows that ended otherwise are hatched by their outcomes, and grey where there is no number."""
    across, up = rulers[0].edges, rulers[1].edges
    axes.set_facecolor(PAPER)
    mesh = axes.pcolormesh(across, up, np.ma.masked_invalid(values), cmap=COLOURS, norm=scale, rasterized=True)
    for outcome, (colour, hatch) in zip(_bad(sweep), cycle(FAILED_LOOKS), strict=False):
        here = outcomes == outcome
        cells = np.ma.masked_where(~here, np.zeros(values.shape))
        if here.any() and not np.isfinite(values[here]).any():
            axes.pcolormesh(across, up, cells, cmap=ListedColormap([colour]))
        if here.any() and values.size <= MOST_HATCHED:
            marks = axes.pcolor(across, up, cells, cmap=ListedColormap(["none"]), hatch=hatch)
            marks.set(edgecolor=QUIET, linewidth=0.0)
    rulers[0].set_along(axes, "x", cells=True)
    rulers[1].set_along(axes, "y", cells=True)
    for spine in axes.spines.values():
        spine.set(color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    return mesh


def _colour_bar(figure: Figure, beside: Axes, mesh: Any, label: str) -> None:
    box = beside.get_position()
    width = figure.get_figwidth()
    axes = figure.add_axes((box.x1 + 0.12 / width, box.y0, BAR / width, box.height))
    bar = figure.colorbar(mesh, cax=axes)
    bar.outline.set(edgecolor=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, labelfontfamily=SANS)
    axes.yaxis.set_major_locator(MaxNLocator(6, min_n_ticks=2))
    plain_numbers(axes.yaxis, axes.get_ylim())
    if label:
        axes.set_ylabel(label, color=INK, fontsize=9.5, fontfamily=SERIF)


def _bad(sweep: Sweep) -> list[str]:
    """The outcomes of rows that ended otherwise."""
    return list(dict.fromkeys(row.outcome for row in sweep.rows if not row.ok))


def _legend_room(sweep: Sweep) -> float:
    return 0.3 if _bad(sweep) or (len(sweep.axes) == 3 and len(_shown(sweep)) < sweep.shape[2]) else 0.0


def _legend(figure: Figure, sweep: Sweep, width: float, height: float) -> None:
    """The outcomes of cells without a number, and how many values of a third key are left out."""
    counts = sweep.outcomes
    handles = [
        Patch(
            facecolor=colour,
            edgecolor=QUIET,
            hatch=hatch,
            linewidth=0.6,
            label=f"{name.replace('_', ' ')} ({counts[name]})",
        )
        for name, (colour, hatch) in zip(_bad(sweep), cycle(FAILED_LOOKS), strict=False)
    ]
    if handles:
        corner = (0.2 / width, 0.02 / height)
        legend = figure.legend(
            handles=handles, loc="lower left", bbox_to_anchor=corner, ncols=len(handles), frameon=False
        )
        for name in legend.get_texts():
            name.set(color=INK, fontsize=8.5, fontfamily=SANS)
    shown = _shown(sweep)
    if len(sweep.axes) == 3 and len(shown) < sweep.shape[2]:
        words = f"{len(shown)} of the {sweep.shape[2]} values of {named(sweep.axes[2].key, '')} are shown"
        figure.text(1 - 0.2 / width, 0.12 / height, words, color=QUIET, fontsize=8, fontfamily=SANS, ha="right")

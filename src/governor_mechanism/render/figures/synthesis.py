"""Figures of synthesised four-bars: each at its positions with the path of its point, and what is particular to a kind of synthesis."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from governor_mechanism.render.figures.page import SERIES_LINE_STYLES, Page, Panel, add_legend
from governor_mechanism.render.geometry.primitives import round_step
from governor_mechanism.render.style import BLUE, GREEN, GREEN_EDGES, INK, LIGHT_STEEL, MUTED, PAPER, RULE, SERIES_COLOURS, SKY, VERMILLION
from governor_mechanism.studies.synthesis.pivot_map import REGIONS
from governor_mechanism.types import ComplexArray, FloatArray

if TYPE_CHECKING:
    from governor_mechanism.studies.synthesis.function import FunctionSynthesis
    from governor_mechanism.studies.synthesis.linkage import Synthesis, SynthesisedLinkage
    from governor_mechanism.studies.synthesis.path import PathSynthesis
    from governor_mechanism.studies.synthesis.pivot_map import PivotMap
    from governor_mechanism.studies.synthesis.positions import PositionSynthesis

MAX_SHOWN: Final = 6
"""Number of linkages in a figure; of more the first ones are drawn, and the figure says so."""

MAX_POSITIONS: Final = 9
"""Number of positions in which a linkage is drawn, of more along a curve some of them."""

_CELL = 3.1
_HEADING = 0.75
_FOOT = 0.4
_GAP = 0.12
"""Width and height of the room of a linkage, and heights of heading and foot, and gap between rooms, inches."""
_ERROR_HEIGHT, _CURVE_HEIGHT = 2.9, 6.0
"""Heights of a panel of errors and of one of Burmester's curves, over the whole width below the linkages, inches."""

_CURVE_EXTENT = 2.0
"""Half the height of the region in which Burmester's curves are shown, relative to the extent of the positions."""

_MAP_SIZE = 9.6, 6.0
"""Width and height of the map of a pivot, inches."""
_REGION_COLOURS: Final = (GREEN_EDGES[0], GREEN_EDGES[1], "#f4bd94", "#cdc5b8", LIGHT_STEEL, PAPER)
"""Colours of the regions of that map, in the order of their names."""
_MAP_COLOURS: Final = LinearSegmentedColormap.from_list("transmission", ("#fbe0bf", SKY, "#00436a"))


def synthesis_figure(
    result: Synthesis, title: str = "Synthesised four-bars", points: ComplexArray | None = None, below: float = 0.0
) -> Page:
    """Draw the best linkages at their positions, with the points that were asked for, and room below (inches) for a panel."""
    rows = result.rows[:MAX_SHOWN]
    n_columns = max(min(3, len(rows)), 2)
    n_rows = max(math.ceil(len(rows) / n_columns), 1)
    width, height = n_columns * _CELL, _HEADING + n_rows * _CELL + _FOOT + below
    page = Page(width, height)
    page.write_title(title, y=1 - 0.28 / height, size=13)
    page.write_title(result.notes[0] if result.notes else "", y=1 - 0.55 / height, size=8.5, colour=MUTED)
    for k, row in enumerate(rows):
        line, column = divmod(k, n_columns)
        bottom = _FOOT + below + (n_rows - 1 - line) * _CELL
        place = ((column * _CELL + _GAP) / width, bottom / height, (_CELL - 2 * _GAP) / width, (_CELL - 0.3) / height)
        panel = page.add_panel(place, grid=None)
        panel.axison = False
        _draw_linkage(panel, row, points)
        panel.write_heading(f"{row.number}  {row.linkage.type}; defects: {row.defects}", y=1.02, size=8.5)
    page.legend(
        handles=_key(),
        loc="lower center",
        bbox_to_anchor=(0.5, (below + 0.05) / height),
        ncols=6,
        frameon=False,
        fontsize=8,
        handlelength=1.6,
    )
    if len(result.rows) > MAX_SHOWN:
        page.write_footnote(f"the first {MAX_SHOWN} of {len(result.rows)} linkages", y=0.1 / height)
    return page


def _key() -> list[Line2D]:
    """Return what the lines and points of a linkage mean."""
    lines = {"input": (BLUE, 2.0), "output": (VERMILLION, 2.0), "coupler": (INK, 1.4), "other positions": (RULE, 1.4), "path": (GREEN, 0.9)}
    points = Line2D([], [], color=VERMILLION, marker=".", markersize=5, linestyle="none", label="asked for")
    return [*(Line2D([], [], color=colour, linewidth=width, label=label) for label, (colour, width) in lines.items()), points]


def _draw_linkage(panel: Panel, row: SynthesisedLinkage, points: ComplexArray | None) -> None:
    """Draw a linkage at all its positions, the path of its point, and the points asked for."""
    first, second = row.linkage.fixed
    path = row.check.path
    panel.plot(path[:, 0], path[:, 1], color=GREEN, linewidth=0.9, zorder=1)
    step = math.ceil(len(row.positions) / MAX_POSITIONS)
    for k, (start, end, point) in reversed(list(enumerate(row.positions[::step]))):
        colour, wide = (INK, 2.0) if k == 0 else (RULE, 1.0)
        _line(panel, (first, start), BLUE if k == 0 else colour, wide, k)
        _line(panel, (second, end), VERMILLION if k == 0 else colour, wide, k)
        _line(panel, (start, end, point, start), colour, 0.7 * wide, k)
    pivots = np.array([first, second])
    panel.plot(pivots.real, pivots.imag, "^", color=INK, markersize=7, zorder=5)
    joints = row.positions[0, :2]
    panel.plot(joints.real, joints.imag, "o", color=INK, markerfacecolor=PAPER, markersize=4.5, zorder=6)
    asked = row.positions[:, 2] if points is None else points
    panel.plot(asked.real, asked.imag, ".", color=VERMILLION, markersize=5, zorder=7)
    everything = np.concatenate([pivots, row.positions.ravel(), asked, path[:, 0] + 1j * path[:, 1]])
    low, high = _corners(everything)
    middle = 0.5 * (low + high)
    half_width = 0.58 * max((high - low).real, panel.aspect_ratio * (high - low).imag)
    panel.show_region((middle.real, middle.imag - 0.06 * half_width), half_width)  # with space for the bar below
    _draw_scale(panel, half_width)


def _draw_scale(panel: Panel, half_width: float) -> None:
    """Draw a bar of a round length (mm) at the lower left of a linkage whose panel is two half widths (m) wide."""
    length = round_step(2.0 * half_width, 6)
    share = length / (2.0 * half_width)
    ends = (0.0, share)
    panel.plot(ends, (0.02, 0.02), "|-", color=MUTED, linewidth=0.9, markersize=4, transform=panel.transAxes, clip_on=False)
    panel.text(share + 0.02, 0.02, f"{1e3 * length:g} mm", transform=panel.transAxes, color=MUTED, fontsize=7.5, va="center_baseline")


def _corners(points: ComplexArray) -> tuple[complex, complex]:
    return complex(points.real.min(), points.imag.min()), complex(points.real.max(), points.imag.max())


def _line(panel: Panel, points: tuple[complex, ...], colour: str, width: float, depth: int) -> None:
    chain = np.array(points)
    panel.plot(chain.real, chain.imag, color=colour, linewidth=width, solid_capstyle="round", zorder=4.0 if depth == 0 else 2.0)


def function_figure(result: FunctionSynthesis) -> Page:
    """Draw the linkages, and their structural errors over the input."""
    task = result.task
    title = f"Four-bars that generate {task.text}" if task.text else "Function generators"
    page = synthesis_figure(result, title, below=_ERROR_HEIGHT if task.text else 0.0)
    if task.text:
        height = page.get_figheight()
        panel = page.add_panel((0.11, 0.72 / height, 0.85, (_ERROR_HEIGHT - 1.25) / height), "Input [deg]", "Structural error [deg]")
        for k, row in enumerate(result.rows[:4]):
            errors = np.degrees(result.structural_error(row.number))
            if np.all(np.isfinite(errors)) and not row.check.defects:
                _draw_errors(panel, errors, k, row.number)
        panel.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1)
        panel.plot(np.degrees(result.pairs[:, 0]), np.zeros(len(result.pairs)), "o", color=INK, markersize=4, zorder=4)
        add_legend(panel, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2, fontsize=8)
    return page


def position_figure(result: PositionSynthesis) -> Page:
    """Draw the linkages, and for four positions Burmester's curves."""
    has_curves = bool(len(result.centre_curve))
    title = f"Four-bars through {len(result.positions)} positions of a body"
    page = synthesis_figure(result, title, below=_CURVE_HEIGHT if has_curves else 0.0)
    if has_curves:
        height = page.get_figheight()
        panel = page.add_panel((0.11, 0.72 / height, 0.85, (_CURVE_HEIGHT - 1.25) / height), "x [mm]", "y [mm]")
        places = 1e3 * result.positions[:, :2]
        for curve, label, colour in ((result.centre_curve, "fixed pivots", BLUE), (result.circle_curve, "moving pivots", VERMILLION)):
            panel.plot(*(1e3 * curve.T), ".", color=colour, markersize=2.5, label=label, zorder=2)
        panel.plot(*places.T, "o", color=INK, markersize=4, label="positions", zorder=4)
        panel.show_region(tuple(places.mean(axis=0)), panel.aspect_ratio * _CURVE_EXTENT * float(np.ptp(places, axis=0).max()))
        add_legend(panel, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.2, fontsize=8, markerscale=2.0)
    return page


def path_figure(result: PathSynthesis) -> Page:
    """Draw the linkages with the points of the path."""
    points = result.points @ np.array([1.0, 1j])
    return synthesis_figure(result, f"Four-bars along {len(points)} points of a path", points)


def _draw_errors(panel: Panel, errors: FloatArray, k: int, number: int) -> None:
    panel.plot(
        errors[:, 0], errors[:, 1], color=SERIES_COLOURS[k], linestyle=SERIES_LINE_STYLES[k], linewidth=1.4, label=f"linkage {number}"
    )


def pivot_map_figure(result: PivotMap) -> Page:
    """Draw what four-bar each place of the second pivot makes, and the transmission angle of those without defects."""
    varied, others = ("moving", "fixed") if result.varied == "moving_pivots" else ("fixed", "moving")
    page = Page(*_MAP_SIZE)
    page.write_title(f"Places of the second {varied} pivot for three positions of a body", y=0.95, size=13)
    page.write_title(f"the {others} pivot and the lengths follow; the link at the first pivot is the input", y=0.9, size=8.5, colour=MUTED)
    count = round(math.sqrt(len(result.x)))
    x, y = 1e3 * result.x[:count], 1e3 * result.y[::count]
    codes = np.array([REGIONS.index(name) for name in result.region])
    angles = np.where(codes < 2, np.degrees(result.transmission), np.nan).reshape(count, count)
    values = (codes.reshape(count, count), ListedColormap(_REGION_COLOURS), (-0.5, len(REGIONS) - 0.5)), (angles, _MAP_COLOURS, (0.0, 90.0))
    for k, (grid, colours, (low, high)) in enumerate(values):
        panel = page.add_panel((0.08 + 0.47 * k, 0.2, 0.4, 0.62), "x [mm]", "" if k else "y [mm]", grid=None)
        mesh = panel.pcolormesh(x, y, grid, cmap=colours, vmin=low, vmax=high, shading="nearest", rasterized=True)
        _draw_bodies(panel, result)
        panel.set_aspect("equal")
        if k:
            panel.write_heading("least transmission angle [deg], without defects", y=1.03, size=10)
            page.colorbar(mesh, cax=page.add_panel((0.58, 0.095, 0.34, 0.02), grid=None), orientation="horizontal")
        else:
            panel.write_heading("what each place makes", y=1.03, size=10)
    shown = [code for code in range(len(REGIONS)) if np.any(codes == code)]
    patches = [Patch(facecolor=_REGION_COLOURS[code], label=REGIONS[code]) for code in shown]
    page.legend(handles=patches, loc="lower left", bbox_to_anchor=(0.06, 0.03), ncols=3, frameon=False, fontsize=8)
    return page


def _draw_bodies(panel: Panel, result: PivotMap) -> None:
    """Draw the positions as frames of axes, and the first pivot with the one that follows from it."""
    size = 0.05e3 * float(np.ptp(result.x))
    for x, y, angle in result.positions:
        for turn, colour in ((0.0, INK), (0.5 * math.pi, MUTED)):
            end = size * np.exp(1j * (angle + turn))
            panel.plot([1e3 * x, 1e3 * x + end.real], [1e3 * y, 1e3 * y + end.imag], color=colour, linewidth=1.4, zorder=4)
    first, other = 1e3 * result.first
    moving, fixed = (first, other) if result.varied == "moving_pivots" else (other, first)
    panel.plot(*np.transpose([fixed, moving]), color=BLUE, linewidth=1.6, zorder=5)
    panel.plot(*fixed, "^", color=INK, markersize=7, zorder=6)
    panel.plot(*moving, "o", color=INK, markerfacecolor=PAPER, markersize=5, zorder=6)

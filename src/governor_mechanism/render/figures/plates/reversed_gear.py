"""Plates of gears that are reversed: Zeuner's diagrams of all gears, the die's paths in the link, and several gears compared."""

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, valve_motion_of, valve_of
from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Page, Panel, PanelRect, Plate, add_legend, polar_points
from governor_mechanism.render.style import BLUE, INK, MUTED, RULE, SANS_FONT, SERIES_COLOURS, VERMILLION
from governor_mechanism.studies.valve_gears import PAPER_SUSPENSIONS, DiePaths, ValveGear, ValveGears
from governor_mechanism.types import FloatArray

PLATE_COUNT = 17
"""Number of gears in which a gear is followed for the plate; every second one has a diagram of its own."""

_SOURCE = "after G. Zeuner, Treatise on Valve-Gears"
_POLAR_RECT = (0.03, 0.075, 0.53, 0.775)
_CURVE_RECTS = ((0.67, 0.655, 0.28, 0.165), (0.67, 0.395, 0.28, 0.165), (0.67, 0.135, 0.28, 0.165))
"""Left and lower edge, width and height of the panels, in fractions of the plate."""
_CAPTIONS = {
    (0.03, 0.862): "Fig. 1.  Valve displacement on the crank ray in all gears, crank end",
    (0.605, 0.862): "Fig. 2.  The valve against the gear",
}
_N_ANGLES = 361
_END_COLOURS = (BLUE, VERMILLION)
_END_LINE_STYLES: tuple[Any, ...] = ("-", DASHED)


def draw_gear_plate(
    gear: ValveGear,  # the gear in its positions from full forward to full back gear
) -> Plate:
    """Draw the plate of a gear."""
    plate = Plate("The valve in every gear", gear.title, _SOURCE, _CAPTIONS)
    _draw_polar_curves(plate.add_plate_panel(_POLAR_RECT), gear)
    curves = (
        ("Lead [mm]", MM_PER_M * gear.leads),
        ("Cut-off [%]", 100.0 * gear.cut_offs),
        ("Travel [mm]", MM_PER_M * gear.travel[:, np.newaxis]),
    )
    panels = [
        plate.add_panel(rect, "", label, label_size=10.5, tick_size=9.0) for rect, (label, _) in zip(_CURVE_RECTS, curves, strict=True)
    ]
    for panel, (_, values) in zip(panels, curves, strict=True):
        _draw_against_gear(panel, gear.positions, values)
    panels[-1].label("Gear [1]: 1 full forward, 0 mid, −1 full back", "Travel [mm]", size=10.5)
    handles = [
        Line2D([], [], color=colour, linestyle=style, label=end)
        for end, colour, style in zip(CYLINDER_ENDS, _END_COLOURS, _END_LINE_STYLES, strict=True)
    ]
    text_style = {"fontfamily": SANS_FONT, "fontsize": 9, "color": INK}
    place: dict[str, Any] = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2}
    add_legend(panels[0], text_style, handles=handles, handlelength=3.0, **place)
    return plate


def _draw_against_gear(panel: Panel, positions: FloatArray, values: FloatArray) -> None:
    """Draw values (n, ends) against the gear; full forward gear is at the left."""
    colours = _END_COLOURS if values.shape[1] > 1 else (INK,)
    for column, colour, style in zip(values.T, colours, _END_LINE_STYLES, strict=False):
        panel.plot(positions, column, color=colour, linewidth=1.6, linestyle=style)
    panel.set_xlim(1.0, -1.0)
    panel.set_xticks([1.0, 0.5, 0.0, -0.5, -1.0])


def _draw_polar_curves(panel: Panel, gear: ValveGear) -> None:
    """Draw the displacement that opens the crank end's ports, on every ray, in every second gear; crests and lap circles."""
    angles = np.linspace(0.0, math.tau, _N_ANGLES)
    crests = []
    largest = 0.0
    valve = valve_of(gear.scenes[0])
    for k, (position, scene) in enumerate(zip(gear.positions, gear.scenes, strict=True)):
        motion = valve_motion_of(scene)
        displacement = MM_PER_M * motion.valve.outward_sign * motion.displacements(angles)
        rays = angles if position >= 0 else -angles  # in back gear the crank turns the other way
        crest = int(np.argmax(displacement))
        crests.append(polar_points(rays[crest], displacement[crest]))
        largest = max(largest, float(displacement[crest]))
        if k % 2 == 0:
            is_middle = position == 0.0
            shown = np.where(displacement > 0, displacement, np.nan)
            colour = INK if is_middle else BLUE if position > 0 else VERMILLION
            panel.plot(*polar_points(rays, shown), color=colour, linewidth=2.0 if abs(position) in (0.0, 1.0) else 1.0)
            if abs(position) in (0.0, 0.5, 1.0):
                offset = (6 * math.cos(rays[crest]) + 3, 7 * math.sin(rays[crest]) - 3)
                panel.annotate_point(crests[-1], f"{position:+.1f}".replace("-", "−").replace("+0.0", "0"), offset, fontsize=9.5)
    panel.plot(*np.array(crests).T, color=MUTED, linewidth=1.2, linestyle=DASHED)
    for lap, letter in ((valve.steam_lap, "steam lap"), (valve.exhaust_lap, "")):
        panel.add_patch(Circle((0.0, 0.0), abs(lap) * MM_PER_M, fill=False, edgecolor=MUTED, linewidth=0.9))
        if letter:
            panel.write_note(letter, (-abs(lap) * MM_PER_M, 0.0), (-4, 4), ha="right", color=MUTED)
    reach = 1.06 * largest
    right = 0.2 * reach + reach * panel.aspect_ratio
    panel.plot((-0.55 * reach, right), (0.0, 0.0), color=RULE, linewidth=0.9, zorder=0)
    panel.plot((0.0, 0.0), (-reach, reach), color=RULE, linewidth=0.9, zorder=0)
    panel.write_note("dead centre, crank end", (right, 0.0), (0, 5), ha="right", color=MUTED)
    panel.write_note("dashed: crests of all gears; on the ray of the dead centre a curve is at lap and lead", (0.0, -reach), (0, -6),
                     ha="center", color=MUTED)  # fmt: skip
    panel.show_region((0.2 * reach, 0.0), 1.03 * reach * panel.aspect_ratio)


SOURCE = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"

_PATHS_BOTTOM = 0.135
_PATHS_HEIGHT = 0.655
_LEFT = 0.085
_RIGHT = 0.965
_GAP = 0.012
"""Place of the row of panels, in fractions of the plate."""


def draw_die_path_plate(title: str, paths: Sequence[DiePaths], own_suspension: str) -> Plate:
    """Draw a panel for each suspension."""
    plate = Plate("The die in the link", title, SOURCE, {})
    width = (_RIGHT - _LEFT - _GAP * (len(paths) - 1)) / len(paths)
    reach = 1.3 * max(float(np.max(np.abs(one.displacements))) for one in paths) * MM_PER_M
    height = 1.06 * max(float(np.max(np.abs(one.offsets))) for one in paths) * MM_PER_M
    for k, one in enumerate(paths):
        panel = plate.add_panel(
            (_LEFT + k * (width + _GAP), _PATHS_BOTTOM, width, _PATHS_HEIGHT), "Valve displacement [mm]", label_size=10.5, tick_size=9.0
        )
        panel.set(xlim=(-reach, reach), ylim=(-height, height))
        if k:
            panel.tick_params(labelleft=False)
        else:
            panel.label("Valve displacement [mm]", "Position of the die along the arc [mm]", size=10.5)
        number = PAPER_SUSPENSIONS.get(one.suspension, "")
        own = " (this gear)" if one.suspension == own_suspension else ""
        panel.write_heading(f"{number + '.  ' if number else ''}{one.suspension.capitalize()}{own}", y=1.035, size=11.5)
        panel.write_heading(_slip_text(one), y=1.008, size=9)
        _draw_paths(panel, one, BLUE if own else INK)
    plate.write_dimensions(
        "a closed path for each gear, from full forward (top) to full back; dashed: rod pins; slip: height of a path, ahead, mid, back"
    )
    return plate


def _slip_text(paths: DiePaths) -> str:
    """Return the slips in full forward, mid and full back gear."""
    ends = paths.slips[[0, len(paths.gears) // 2, -1]] * MM_PER_M
    return "slip {:.1f}, {:.1f}, {:.1f} mm".format(*ends.tolist())


def _draw_paths(panel: Panel, paths: DiePaths, colour: str) -> None:
    """Draw a closed path for each gear, the rod pins and the nominal positions of the die."""
    panel.axvline(0.0, color=MUTED, linewidth=0.6)
    for side in (1.0, -1.0):
        panel.axhline(side * paths.half_arc * MM_PER_M, color=MUTED, linewidth=0.8, linestyle=DASHED)
    for gear, displacement, offset in zip(paths.gears, paths.displacements, paths.offsets, strict=True):
        panel.plot(displacement * MM_PER_M, offset * MM_PER_M, color=colour, linewidth=1.4)
        k = int(np.argmax(displacement))
        panel.plot(displacement[:1] * MM_PER_M, offset[:1] * MM_PER_M, marker="o", markersize=3.0, color=VERMILLION)
        point = (float(displacement[k]) * MM_PER_M, float(offset[k]) * MM_PER_M)
        if abs(gear) in (0.0, 0.5, 1.0):
            panel.annotate_point(point, f"{gear:+.1f}".replace("-", "−").replace("+0.0", "0"), (5, -3), fontsize=8.5, color=MUTED)


_PAGE_SIZE = 12.0, 5.4
"""Width and height of the figure, inches."""

_BOTTOM = 0.235
_HEIGHT = 0.56
_WIDTH = 0.265
_LEFT_EDGES = (0.055, 0.385, 0.715)
"""Lower edge, height, width and left edges of the panels, in fractions of the figure."""

_COLOURS = (*SERIES_COLOURS, "#8a5fa8", "#8a6a00", "#5b6b7a")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")
"""Colours and markers of the gears."""

_N_MARKED = 5
"""Every which point of a line has its marker."""

_LEAST_SPAN = 0.1
"""Share of its values over which an ordinate must change to fill its panel: a constant would show its rounding."""
_WIDEST_LINE, _NARROWEST_LINE = 3.2, 1.2
"""Widths of the first and the last line, points: lines on each other stay visible."""

_COUNT_WORDS = {2: "Two", 3: "Three", 4: "Four", 5: "Five", 6: "Six", 7: "Seven"}

_PANELS: tuple[tuple[str, str, Callable[[ValveGear], FloatArray]], ...] = (
    ("Lead", "Mean lead of both ends [mm]", lambda gear: MM_PER_M * gear.leads.mean(axis=1)),
    ("Travel of the valve", "Travel [mm]", lambda gear: MM_PER_M * gear.travel),
    ("Inequality of the ends", "Cut-off, crank end less head end [%]", lambda gear: 100 * (gear.cut_offs[:, 0] - gear.cut_offs[:, 1])),
)
"""Heading, label of the ordinate and ordinates of each panel."""


def valve_gears_figure(study: ValveGears) -> Page:
    """Draw lead, travel and inequality of the cut-off of valve gears over their mean cut-off."""
    count = len(study.gears)
    title = f"{_COUNT_WORDS.get(count, count)} valve gears compared" if count > 1 else study.gears[0].title
    page = Page(*_PAGE_SIZE, title, "from full forward gear (solid) over mid gear (circle) to full back gear (dashed)")
    colours = [_COLOURS[k % len(_COLOURS)] for k in range(count)]
    widths = np.linspace(_WIDEST_LINE, _NARROWEST_LINE, count) if count > 1 else [2.0]
    for left, (heading, label, ordinates) in zip(_LEFT_EDGES, _PANELS, strict=True):
        _draw_panel(page, (left, _BOTTOM, _WIDTH, _HEIGHT), (heading, label), study.gears, ordinates, colours, widths)
    handles = [
        Line2D([], [], color=colour, linewidth=width, marker=_MARKERS[k % len(_MARKERS)], markersize=6, label=gear.name)
        for k, (gear, colour, width) in enumerate(zip(study.gears, colours, widths, strict=True))
    ]
    style = {"fontfamily": SANS_FONT, "fontsize": 9, "color": INK}
    add_legend(page, style, handles=handles, loc="lower center", ncols=min(count, 5), bbox_to_anchor=(0.5, 0.045))
    page.write_footnote("cut-offs are mean values of both ends, in % of the stroke; in back gear the crank turns the other way")
    return page


def _draw_panel(
    page: Page,
    rect: PanelRect,
    labels: tuple[str, str],
    gears: Sequence[ValveGear],
    ordinates: Callable[[ValveGear], FloatArray],
    colours: Sequence[str],
    widths: Sequence[float] | FloatArray,
) -> None:
    """Draw one panel: its heading and the label of its ordinate, and a line for each gear."""
    panel = page.add_panel(rect, "Mean cut-off [% of the stroke]", labels[1])
    panel.write_heading(labels[0], y=1.04)
    for k, (gear, colour, width) in enumerate(zip(gears, colours, widths, strict=True)):
        cut_off, values = 100 * gear.cut_offs.mean(axis=1), ordinates(gear)
        for is_shown, style in ((gear.positions >= 0, "-"), (gear.positions <= 0, DASHED)):
            panel.plot(cut_off[is_shown], values[is_shown], color=colour, linewidth=width, linestyle=style, dash_capstyle="butt")
        marker: dict[str, Any] = {"marker": _MARKERS[k % len(_MARKERS)], "markersize": 5, "linestyle": "none", "color": colour}
        panel.plot(cut_off[k % _N_MARKED :: _N_MARKED], values[k % _N_MARKED :: _N_MARKED], **marker)
        middle = int(np.argmin(np.abs(gear.positions)))
        panel.plot(cut_off[middle], values[middle], "o", color=colour, markerfacecolor="none", markersize=10, markeredgewidth=1.2)
    low, high = panel.get_ylim()
    if low <= 0 <= high:
        panel.axhline(0.0, color=MUTED, linewidth=0.8)
    elif high - low < _LEAST_SPAN * max(abs(low), abs(high)):
        panel.set_ylim(min(1.08 * low, 0.0), max(1.08 * high, 0.0))

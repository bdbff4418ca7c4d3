"""Plate of a gear that is reversed: Zeuner's diagrams of all its gears on one sheet, and lead, cut-off and travel against the gear."""

import math
from typing import Any

import numpy as np
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, valve_motion_of, valve_of
from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Panel, Plate, add_legend, polar_points
from governor_mechanism.render.style import BLUE, INK, MUTED, RULE, SANS_FONT, VERMILLION
from governor_mechanism.studies.valve_gears import ValveGear
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
    add_legend(panels[0], text_style, handles=handles, loc="lower center", ncols=2, handlelength=3.0)
    return plate


def _draw_against_gear(panel: Panel, positions: FloatArray, values: FloatArray) -> None:
    """Draw values (n, ends) against the gear; full forward gear is at the left."""
    colours = _END_COLOURS if values.shape[1] > 1 else (INK,)
    for column, colour, style in zip(values.T, colours, _END_LINE_STYLES, strict=False):
        panel.plot(positions, column, color=colour, linewidth=1.6, linestyle=style)
    panel.set_xlim(1.0, -1.0)


def _draw_polar_curves(panel: Panel, gear: ValveGear) -> None:
    """Draw the displacement that opens the crank end's ports, on every ray, in every second gear; crests and lap circles."""
    angles, crests, largest = np.linspace(0.0, math.tau, _N_ANGLES), [], 0.0
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
    panel.plot((-0.55 * reach, reach), (0.0, 0.0), color=RULE, linewidth=0.9, zorder=0)
    panel.plot((0.0, 0.0), (-reach, reach), color=RULE, linewidth=0.9, zorder=0)
    panel.write_note("dead centre, crank end", (reach, 0.0), (0, 5), ha="right", color=MUTED)
    panel.write_note("dashed: crests of all gears; on the ray of the dead centre a curve is at lap and lead", (0.0, -reach), (0, -6),
                     ha="center", color=MUTED)  # fmt: skip
    panel.show_region((0.2 * reach, 0.0), 1.03 * reach * panel.aspect_ratio)

"""Plate of the die's paths in the link: its position along the arc over the valve's displacement in all gears, for each suspension."""

from collections.abc import Sequence

import numpy as np

from governor_mechanism.render.figures.page import DASHED, MM_PER_M, Panel, Plate
from governor_mechanism.render.style import BLUE, INK, MUTED, VERMILLION
from governor_mechanism.studies.stephenson.die_paths import PAPER_SUSPENSIONS, DiePaths

SOURCE = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"

_BOTTOM, _HEIGHT, _LEFT, _RIGHT, _GAP = 0.135, 0.655, 0.085, 0.965, 0.012
"""Place of the row of panels, in fractions of the plate."""


def draw_die_path_plate(title: str, paths: Sequence[DiePaths], own_suspension: str) -> Plate:
    """Draw a panel for each suspension."""
    plate = Plate("The die in the link", title, SOURCE, {})
    width = (_RIGHT - _LEFT - _GAP * (len(paths) - 1)) / len(paths)
    reach = 1.3 * max(float(np.max(np.abs(one.displacements))) for one in paths) * MM_PER_M
    height = 1.06 * max(float(np.max(np.abs(one.offsets))) for one in paths) * MM_PER_M
    for k, one in enumerate(paths):
        panel = plate.add_panel(
            (_LEFT + k * (width + _GAP), _BOTTOM, width, _HEIGHT), "Valve displacement [mm]", label_size=10.5, tick_size=9.0
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

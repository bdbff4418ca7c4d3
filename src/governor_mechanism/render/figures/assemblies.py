"""Sheet of all assemblies of a mechanism: a drawing of each, with its number, on one scale."""

import math
from typing import Final

from governor_mechanism.render.figures.page import Page
from governor_mechanism.render.geometry.primitives import enclose_boxes
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.part_run import motion_at_rest
from governor_mechanism.render.style import MUTED, VERMILLION, Brush
from governor_mechanism.studies.kinematics import Assemblies

MAX_SHOWN: Final = 36
"""Number of assemblies on a sheet; of more the first ones are drawn, and the sheet says so."""

_CELL, _HEADING, _FOOT, _MARGIN = 2.1, 0.75, 0.3, 0.15
"""Width and height of a cell, and height of the heading, of the foot, and width of the margins, inches."""

_PIXEL = 0.45
"""Width of a line of one pixel of a film, points: thumbnails are smaller than frames."""


def assemblies_figure(assemblies: Assemblies) -> Page:
    """Draw all assemblies on one scale, with their numbers; that in which the scene starts has a coloured one."""
    count = min(len(assemblies), MAX_SHOWN)
    n_columns = max(3, math.ceil(math.sqrt(1.6 * count)))
    n_rows = math.ceil(count / n_columns)
    width, height = 2 * _MARGIN + n_columns * _CELL, _HEADING + n_rows * _CELL + _FOOT
    page = Page(width, height)
    page.write_title(assemblies.scene.title, y=1 - 0.28 / height, size=13)
    page.write_title(_subtitle(assemblies), y=1 - 0.55 / height, size=9, colour=MUTED)
    poses = assemblies.poses[:count]
    drawings = [GenericDrawing(run=motion_at_rest(assemblies.scene, one[None]), part=assemblies.scene.part) for one in poses]
    left, right, bottom, top = enclose_boxes([drawing.bounds for drawing in drawings])
    half = 0.55 * max(right - left, top - bottom)
    for k, drawing in enumerate(drawings):
        row, column = divmod(k, n_columns)
        rect = (_MARGIN + column * _CELL) / width, (_FOOT + (n_rows - 1 - row) * _CELL) / height, _CELL / width, _CELL / height
        panel = page.add_panel(rect, grid=None)
        panel.axison = False
        panel.show_region(((left + right) / 2, (bottom + top) / 2), half)
        moment = drawing.first_moment
        Brush(panel, _PIXEL).paint([*drawing.static_shapes, *drawing.moving_shapes(moment.pose, moment.time)])
        colour, weight = (VERMILLION, "bold") if k + 1 == assemblies.taken else (MUTED, "normal")
        panel.write_note(str(k + 1), (0.04, 0.92), xycoords="axes fraction", fontsize=11, color=colour, fontweight=weight)
    page.write_footnote(_footnote(assemblies), y=0.1 / height)
    return page


def _subtitle(assemblies: Assemblies) -> str:
    """Return the number of the assemblies and what holds them."""
    return assemblies.summary.removeprefix(f"{assemblies.scene.title}: ")


def _footnote(assemblies: Assemblies) -> str:
    """Return what the coloured number means, and how many are not shown."""
    shown = f"the first {MAX_SHOWN} of {len(assemblies)}; " if len(assemblies) > MAX_SHOWN else ""
    taken = f"the scene starts in {assemblies.taken}; " if assemblies.taken else ""
    return f"{shown}{taken}assembly = number chooses one"

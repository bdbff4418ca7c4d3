"""Paths of points in the plane of a mechanism, to one scale on both axes."""

from collections.abc import Mapping, Sequence

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.render.figures.page import SERIES_LINE_STYLES, Page, Panel, add_legend
from governor_mechanism.render.style import PAPER, SERIES_COLOURS
from governor_mechanism.types import FloatArray

_WIDTH, _HEIGHT = 7.2, 6.4
"""Size of the figure, inches."""
_MILLIMETRES = 1e3
_MAX_CURVES = 8
"""Largest number of paths that are drawn if none is named."""
_SAME_RATIO = 1e-6
"""Distance of two curves, or size of one, relative to the largest curve, below which they are one curve, or it is a point."""
_MIN_HALF_WIDTH = 1e-3
"""Smallest half width of the panel, mm; a point may stand still."""


def path_figure(
    title: str,
    subtitle: str,
    paths: Mapping[str, FloatArray],  # paths by the name of the point, m; shape (n, 2)
    names: Sequence[str],  # what to draw; if empty the first paths of points that move, each curve once
) -> Page:
    """Return the figure of the paths of some points; raise MechanismError for a point without a path, or if there are none."""
    different = [] if names else _different_curves(paths)
    shown = list(names) or different[:_MAX_CURVES]
    curves = {name: _MILLIMETRES * paths[name] for name in shown}
    if not curves or not all(map(len, curves.values())):
        raise MechanismError("there are no paths to draw: no point is named, no pin moves, or the run has no reported time")
    page = Page(_WIDTH, _HEIGHT, title, subtitle)
    panel = page.add_panel((0.11, 0.1, 0.86, 0.74), "x [mm]", "y [mm]")
    draw_paths(panel, {name: paths[name] for name in shown})
    add_legend(panel, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(len(curves), 4), borderaxespad=0.2)
    left_out = [] if names else list(paths)[_MAX_CURVES:]
    page.write_footnote("dots: start of the paths" + (f"; not shown: {', '.join(left_out)}" if left_out else ""))
    return page


def draw_paths(panel: Panel, paths: Mapping[str, FloatArray]) -> None:
    """Draw paths (n, 2), m, by the names of their points, in mm to one scale on both axes, with a dot at their starts."""
    curves = {name: _MILLIMETRES * path for name, path in paths.items()}
    panel.show_points(np.concatenate(list(curves.values())), margin=0.1, min_half_width=_MIN_HALF_WIDTH)
    for number, (name, curve) in enumerate(curves.items()):
        colour = SERIES_COLOURS[number % len(SERIES_COLOURS)]
        line_style = SERIES_LINE_STYLES[number % len(SERIES_LINE_STYLES)]
        panel.plot(curve[:, 0], curve[:, 1], color=colour, linestyle=line_style, linewidth=1.6, label=name, zorder=3)
        panel.plot(*curve[0], "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=4)


def _different_curves(paths: Mapping[str, FloatArray]) -> list[str]:
    """Return the names of the points that move, without those whose curve is that of an earlier one."""
    size = max((float(np.ptp(path, axis=0).max(initial=0.0)) for path in paths.values() if len(path)), default=0.0)
    names: list[str] = []
    for name, path in paths.items():
        moves = len(path) > 0 and float(np.ptp(path, axis=0).max()) > _SAME_RATIO * size
        if moves and not any(float(np.abs(path - paths[other]).max()) <= _SAME_RATIO * size for other in names):
            names.append(name)
    return names

"""Polar plots of the forces of joints: the tip of the force on the second body, in the axes of the plane or of that body."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.figures.page import Page, Panel
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, VERMILLION
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import TEXT, check_arguments

FORCE_AXES: Final = ("plane", "body")
"""Axes of a polar plot: those of the plane, or those of the second body of the joint, which turn with it."""

_MAX_PANELS, _N_COLUMNS = 6, 3
_PANEL_SIZE, _HEADER_HEIGHT, _FOOTER_HEIGHT = 3.3, 1.1, 0.45
"""Side of a panel with its labels, and heights of title and footnote, inches."""

_MIN_FORCE: Final = 1e-9
"""Smallest half width of a panel, N; a joint may carry nothing."""


@check_arguments(axes=TEXT)
def joint_force_figure(
    run: Trajectory,
    joints: Sequence[str],  # names of joints; all that a rigid model determines if empty
    axes: str = "plane",
) -> Page:
    """Return the polar plots of joint forces."""
    shown = _choose_joints(run, joints, axes)
    n_columns, n_rows = min(len(shown), _N_COLUMNS), math.ceil(min(len(shown), _MAX_PANELS) / _N_COLUMNS)
    height = n_rows * _PANEL_SIZE + _HEADER_HEIGHT + _FOOTER_HEIGHT
    page = Page(max(n_columns, 2) * _PANEL_SIZE, height)
    page.write_title("Forces of joints", y=1 - 0.3 / height)
    page.write_title(run.scene.title, y=1 - 0.58 / height, size=10, colour=MUTED)
    grid = page.add_gridspec(
        n_rows,
        max(n_columns, 2),
        left=0.09,
        right=0.97,
        top=1 - _HEADER_HEIGHT / height,
        bottom=(_FOOTER_HEIGHT + 0.45) / height,
        wspace=0.42,
        hspace=0.48,
    )
    for number, name in enumerate(shown[:_MAX_PANELS]):
        panel = page.add_panel(grid[divmod(number, max(n_columns, 2))], "x [N]", "y [N]", label_size=9.0)
        _draw_force(panel, name, _forces_in_axes(run, name, axes))
    page.write_footnote(_footnote(run, shown, axes), x=0.02, y=0.16 / height)
    return page


def _choose_joints(run: Trajectory, joints: Sequence[str], axes: str) -> list[str]:
    """Return the joints to draw; raise MechanismError as `joint_force_figure`."""
    if axes not in FORCE_AXES:
        raise MechanismError(f"axes of a polar plot must be one of {', '.join(FORCE_AXES)}; found {axes!r}")
    if not len(run.times):
        raise MechanismError("a polar plot of joint forces needs a reported time, and the run ended before its first")
    undetermined = [name for name in joints if not run.reactions[name].determined.any()]
    if undetermined:
        names = ", ".join(map(repr, undetermined))
        raise MechanismError(f"a rigid model does not determine the force of {names}, as joints are redundant; leave it out of the plot")
    shown = list(joints) or [name for name, one in run.reactions.items() if one.determined.any() and np.any(one.force)]
    if not shown:
        raise MechanismError("no joint of this run carries a force that a rigid model determines; there is nothing to plot")
    return shown


def _footnote(run: Trajectory, shown: Sequence[str], axes: str) -> str:
    """Return what the curves are, and which joints are left out."""
    where = "axes of the plane" if axes == "plane" else "axes of that body"
    left_out = f"; not shown: {', '.join(shown[_MAX_PANELS:])}" if len(shown) > _MAX_PANELS else ""
    return f"Force on the second body, {where}; dot: start of the run, arrow: sense; engine {run.cost.engine}{left_out}"


def _forces_in_axes(run: Trajectory, name: str, axes: str) -> FloatArray:
    """Return the force (n, 2) of a joint, N, in the axes of the plane or of its second body."""
    force = run.reactions[name].force
    mechanism = run.scene.mechanism
    body = mechanism.joints[mechanism.joint_index(name)].second.body
    if axes == "plane" or body == GROUND:
        return force
    angle = run.poses[:, mechanism.body_index(body), 2]
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.stack([cosine * force[:, 0] + sine * force[:, 1], cosine * force[:, 1] - sine * force[:, 0]], axis=1)


def _draw_force(panel: Panel, name: str, force: FloatArray) -> None:
    """Draw the curve of a force (n, 2), N, around the zero, to one scale on both axes."""
    panel.show_points(np.vstack([force, np.zeros((1, 2))]), margin=0.12, min_half_width=_MIN_FORCE)
    panel.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1)
    panel.axvline(0.0, color=MUTED, linewidth=0.8, zorder=1)
    panel.plot(force[:, 0], force[:, 1], color=BLUE, linewidth=1.4, zorder=3)
    panel.plot(*force[0], "o", color=VERMILLION, markeredgecolor=PAPER, markersize=6, zorder=5)
    _draw_sense(panel, force)
    panel.text(0.0, 1.05, name, transform=panel.transAxes, color=INK, fontsize=10.5, parse_math=False)


def _draw_sense(panel: Panel, force: FloatArray) -> None:
    """Draw an arrowhead on the curve where it has gone a sixth of its length."""
    half_width = 0.5 * float(np.ptp(panel.get_xlim()))
    lengths = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(force, axis=0).T))])
    if lengths[-1] < 0.05 * half_width:
        return
    place = min(lengths[-1] / 6, half_width)
    index = min(int(np.searchsorted(lengths, place)), len(force) - 1)
    start, tip = force[max(index - 1, 0)], force[index]
    panel.annotate("", tuple(tip), tuple(start), arrowprops={"arrowstyle": "-|>", "color": BLUE, "linewidth": 1.4}, zorder=4)

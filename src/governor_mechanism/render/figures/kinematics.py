"""Figures of kinematics: paths of points to one scale, a study over the drive, the sheet of all assemblies; polar plots of joint forces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from textwrap import shorten
from typing import TYPE_CHECKING, Final

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import GROUND
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.render.artists import Brush
from governor_mechanism.render.figures.page import SERIES_LINE_STYLES, Page, Panel, add_legend
from governor_mechanism.render.geometry.primitives import enclose_boxes
from governor_mechanism.render.machines.generic.drawing import GenericDrawing
from governor_mechanism.render.part_run import motion_at_rest
from governor_mechanism.render.range_bands import note_coarse_turns
from governor_mechanism.render.shown_readings import axis_limits_for, choose_multiple, display_unit_of, format_label, format_name
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, SERIES_COLOURS, VERMILLION
from governor_mechanism.studies.assemblies import Assemblies
from governor_mechanism.types import FloatArray
from governor_mechanism.units.problems import TEXT, check_arguments

if TYPE_CHECKING:
    from governor_mechanism.studies.kinematics import KinematicStudy


_PATHS_WIDTH, _PATHS_HEIGHT = 7.2, 6.4
"""Size of the figure, inches."""
_MILLIMETRES = 1e3
_MAX_POINT_PATHS = 8
"""Largest number of paths that are drawn if none is named."""
_SAME_RATIO = 1e-6
"""Distance of two curves, or size of one, relative to the largest curve, below which they are one curve, or it is a point."""
_MIN_HALF_WIDTH = 1e-3
"""Smallest half width of the panel, mm; a point may stand still."""


def path_figure(
    subtitle: str,
    paths: Mapping[str, FloatArray],  # paths by the name of the point, m; shape (n, 2)
    names: Sequence[str],  # what to draw; if empty the first paths of points that move, each curve once
) -> Page:
    """Return the figure of the paths of some points; raise MechanismError for a point without a path, or if there are none."""
    different = [] if names else _different_curves(paths)
    shown = list(names) or different[:_MAX_POINT_PATHS]
    curves = {name: _MILLIMETRES * paths[name] for name in shown}
    if not curves or not all(map(len, curves.values())):
        raise MechanismError("there are no paths to draw: no point is named, no pin moves, or the run has no reported time")
    page = Page(_PATHS_WIDTH, _PATHS_HEIGHT, "Paths of points", subtitle)
    panel = page.add_panel((0.11, 0.1, 0.86, 0.74), "x [mm]", "y [mm]")
    draw_paths(panel, {name: paths[name] for name in shown})
    add_legend(panel, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=min(len(curves), 4), borderaxespad=0.2)
    left_out = [] if names else list(paths)[_MAX_POINT_PATHS:]
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


_WIDTH = 11.0
_MIN_HEIGHT = 5.6
_PANEL_HEIGHT = 1.65
_MARGINS = 1.5
"""Width of the figure, its least height, and the heights of a panel and of the margins, inches."""
_MAX_PATHS = 4
_MAX_PANELS = 6
_MAX_CURVES = 4
_BOTTOM = 0.78
"""Height of the lower edge of the lowest panels, inches."""
_LEGEND_LETTERS = 62
"""Letters of all names in the legend of a panel."""
_ADVANTAGE_LIMIT = 4.0
"""Largest value that is shown of a reading that has gaps, relative to the third quartile of its magnitude: it is infinite there."""

_KINDS: Final = ("transmission_angle", "velocity", "acceleration", "mechanical_advantage", "curvature")
"""Kinds of readings with a panel, in their order; the positions of instantaneous centres are curves beside the paths."""
_CENTRE: Final = "instantaneous_centre"


def kinematics_figure(study: KinematicStudy) -> Page:
    """Return the figure of a kinematic study; a study without further readings shows those of the mechanism by their units."""
    groups = _group_readings(study)
    height = max(_MIN_HEIGHT, _MARGINS + _PANEL_HEIGHT * len(groups))
    page = Page(_WIDTH, height, subtitle=study.scene.title, subtitle_y=1 - 0.6 / height)
    page.write_title("Kinematics", y=1 - 0.3 / height)
    _draw_paths(page, study, height)
    drive = display_unit_of(study.units.get(study.over, "s"))
    for number, (heading, names) in enumerate(groups.items()):
        room = (height - _MARGINS - 0.16) / len(groups)
        bottom = _BOTTOM + room * (len(groups) - 1 - number)
        is_last = number == len(groups) - 1
        panel = page.add_panel((0.57, bottom / height, 0.4, (room - 0.42) / height), format_label(study.over, drive[0]) if is_last else "")
        _draw_readings(panel, study, heading, names, drive[1])
        if not is_last:
            panel.tick_params(labelbottom=False)
    page.write_footnote(_describe_linkage(study), y=0.14 / height)
    return page


def _group_readings(study: KinematicStudy) -> dict[str, list[str]]:
    """Return the readings of each panel by its heading."""
    groups: dict[str, list[str]] = {}
    for kind in _KINDS:
        names = [name for name in study.readings if name.startswith(f"{kind}.")]
        unit = display_unit_of(study.units[names[0]])[0] if names else ""
        if names:
            groups[format_label(kind, unit)] = names[:_MAX_CURVES]
    if groups:
        return groups
    for name in study.readings:
        if name != study.over and "." not in name:
            unit = display_unit_of(study.units[name])[0]
            groups.setdefault(f"Readings [{unit.replace('°', 'deg')}]" if unit else "Readings", []).append(name)
    return {heading: names[:_MAX_CURVES] for heading, names in list(groups.items())[:_MAX_PANELS]}


def _draw_paths(page: Page, study: KinematicStudy, height: float) -> None:
    """Draw the paths that the scene names, or of named points, or of the first ones, and beside them curves of instantaneous centres."""
    panel = page.add_panel((0.065, _BOTTOM / height, 0.42, 1 - 1.91 / height), "x [mm]", "y [mm]")
    scene = study.scene
    named = list(scene.run.paths) or [name for name in study.paths if any(name == point.name for point in scene.mechanism.points)]
    shown = named or [name for name, path in study.paths.items() if np.ptp(path, axis=0).max() > 0.0] or list(study.paths)
    draw_paths(panel, {name: study.paths[name] for name in shown[:_MAX_PATHS]})
    centres = [name.removesuffix(".x") for name in study.readings if name.startswith(f"{_CENTRE}.") and name.endswith(".x")]
    for number, centre in enumerate(name for name in centres if f"{name}.y" in study.readings):
        points = 1e3 * np.column_stack([study.readings[f"{centre}.{axis}"] for axis in "xy"])
        colour = SERIES_COLOURS[(number + 3) % len(SERIES_COLOURS)]
        label = f"centre of {' and '.join(centre.split('.')[1:])}"
        panel.plot(points[:, 0], points[:, 1], color=colour, linestyle=(0, (1.5, 1.5)), linewidth=1.1, label=label, zorder=2)
    add_legend(panel, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.2, fontsize=8)


def _draw_readings(panel: Panel, study: KinematicStudy, heading: str, names: list[str], drive_factor: float) -> None:
    """Draw readings over the drive, with a legend above the panel."""
    drive = study.values * drive_factor
    shown = list[FloatArray]()
    for number, name in enumerate(names):
        values = study.readings[name] * display_unit_of(study.units[name])[1]
        label = shorten(_legend_name(name, names), max(_LEGEND_LETTERS // len(names), 8), placeholder=" …")
        style = {"color": SERIES_COLOURS[number % len(SERIES_COLOURS)], "linestyle": SERIES_LINE_STYLES[number % len(SERIES_LINE_STYLES)]}
        panel.plot(drive, _without_jumps(values, study.over), linewidth=1.4, label=label, zorder=3, **style)
        shown.append(values[np.isfinite(values)])
    everything = np.concatenate(shown)
    if everything.size:
        limit = _ADVANTAGE_LIMIT * float(np.quantile(np.abs(everything), 0.75))
        is_clipped = heading.startswith(("Mechanical", "Curvature")) and float(np.max(np.abs(everything))) > limit > 0.0
        panel.set_ylim(axis_limits_for(np.clip(everything, -limit, limit) if is_clipped else everything))
    if heading.startswith("Transmission"):
        panel.axhline(90.0, color=MUTED, linewidth=0.8, zorder=1)
    panel.set_xlim(float(drive.min()), float(drive.max()))
    panel.write_heading(heading, y=1.05, size=9.5)
    add_legend(panel, {"color": INK}, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, borderaxespad=0.1, fontsize=8)


def _legend_name(name: str, names: list[str]) -> str:
    """Return the name of a reading in the legend of its panel: without its kind, and without a component that all have."""
    components = {one.rpartition(".")[2] for one in names}
    whole = name.rpartition(".")[0] if components == {"magnitude"} else name
    return format_name(whole.partition(".")[2] if "." in whole else whole)


def _without_jumps(values: FloatArray, over: str) -> FloatArray:
    """Return values with a gap where they pass from one infinity to the other."""
    jumps = np.flatnonzero((values[:-1] * values[1:] < 0.0) & (np.abs(np.diff(values)) > 4.0 * np.nanquantile(np.abs(values), 0.75)))
    broken = values.copy()
    broken[jumps] = np.nan
    return broken


def _describe_linkage(study: KinematicStudy) -> str:
    """Return the speed of the drive, mobility, and the classes of the first four-bars, as a footnote."""
    classes = [f"{' - '.join(one.links)}: {one.grashof}" for one in study.four_bars]
    return "; ".join([study.drive_in_words, str(study.mobility), *classes[:2]])


MAX_SHOWN: Final = 36
"""Number of assemblies on a sheet; of more the first ones are drawn, and the sheet says so."""

_CELL = 2.1
_HEADING = 0.75
_FOOT = 0.3
_MARGIN = 0.15
"""Width and height of a cell, and height of the heading, of the foot, and width of the margins, inches."""

_PIXEL = 0.45
"""Width of a line of one pixel of a film, points: thumbnails are smaller than frames."""


def assemblies_figure(assemblies: Assemblies) -> Page:
    """Draw all assemblies on one scale, with their numbers; that in which the scene starts has a coloured one."""
    count = min(len(assemblies), MAX_SHOWN)
    n_columns = 2 if count in (1, 2, 4) else max(3, math.ceil(math.sqrt(1.6 * count)))
    n_rows = math.ceil(count / n_columns)
    width = 2 * _MARGIN + n_columns * _CELL
    height = _HEADING + n_rows * _CELL + _FOOT
    page = Page(width, height)
    page.write_title(assemblies.scene.title, y=1 - 0.28 / height, size=13)
    page.write_title(_subtitle(assemblies), y=1 - 0.55 / height, size=9, colour=MUTED)
    poses = assemblies.poses[:count]
    drawings = [GenericDrawing(run=motion_at_rest(assemblies.scene, one[None]), part=assemblies.scene.part) for one in poses]
    left, right, bottom, top = enclose_boxes([drawing.bounds for drawing in drawings])
    size = max(right - left, top - bottom)
    for k, drawing in enumerate(drawings):
        row, column = divmod(k, n_columns)
        rect = (_MARGIN + column * _CELL) / width, (_FOOT + (n_rows - 1 - row) * _CELL) / height, _CELL / width, _CELL / height
        panel = page.add_panel(rect, grid=None)
        panel.axison = False
        panel.show_region(((left + right) / 2, (bottom + top) / 2 - 0.06 * size), 0.58 * size)  # below, the words have room
        moment = drawing.first_moment
        Brush(panel, _PIXEL).paint([*drawing.static_shapes, *drawing.moving_shapes(moment.pose, moment.time)])
        colour, weight = (VERMILLION, "bold") if k + 1 == assemblies.taken else (MUTED, "normal")
        panel.write_note(str(k + 1), (0.04, 0.92), xycoords="axes fraction", fontsize=11, color=colour, fontweight=weight)
        if "to" in (travel := assemblies.travels[k]):
            panel.write_note(f"drive {travel}".replace("-", "−"), (0.04, 0.02), xycoords="axes fraction", fontsize=8, color=MUTED)
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


FORCE_AXES: Final = ("plane", "body")
"""Axes of a polar plot: those of the plane, or those of the second body of the joint, which turn with it."""

_MAX_FORCE_PANELS, _N_FORCE_COLUMNS = 6, {1: 1, 2: 2, 4: 2}
"""Largest number of panels, and number of columns by that of joints; of others there are three."""
_PANEL_SIZE = 3.3
_ONLY_PANEL_SIZE = 5.4
_FORCES_HEADER_HEIGHT = 1.1
_FORCES_FOOTER_HEIGHT = 0.45
"""Side of a panel with its labels, and of an only panel, and heights of title and footnote, inches."""
_ORDINATE_WIDTH: Final = 0.85
"""Width of the label and the numbers to the left of the first panel, inches."""
_MAX_FORCE_TICKS: Final = 5
"""Largest number of intervals between numbers on an axis."""
_NOTE_HEIGHT: Final = 0.17
"""Height of a line of the footnote, inches."""
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
    n_columns = _N_FORCE_COLUMNS.get(len(shown), 3)
    n_rows = math.ceil(min(len(shown), _MAX_FORCE_PANELS) / n_columns)
    side = _ONLY_PANEL_SIZE if n_columns == 1 else _PANEL_SIZE
    notes = [_describe_forces(run, shown, axes), *note_coarse_turns(run)]
    width = n_columns * side
    height = n_rows * side + _FORCES_HEADER_HEIGHT + _FORCES_FOOTER_HEIGHT + _NOTE_HEIGHT * len(notes)
    page = Page(width, height)
    page.write_title("Forces of joints", y=1 - 0.3 / height)
    page.write_title(run.scene.title, y=1 - 0.58 / height, size=10, colour=MUTED)
    grid = page.add_gridspec(
        n_rows,
        n_columns,
        left=_ORDINATE_WIDTH / width,
        right=0.97,
        top=1 - _FORCES_HEADER_HEIGHT / height,
        bottom=(_FORCES_FOOTER_HEIGHT + 0.35 + _NOTE_HEIGHT * len(notes)) / height,
        wspace=0.42,
        hspace=0.48,
    )
    forces = {name: _forces_in_axes(run, name, axes) for name in shown[:_MAX_FORCE_PANELS]}
    unit, factor = choose_multiple("N", np.concatenate(list(forces.values())))
    for number, (name, force) in enumerate(forces.items()):
        panel = page.add_panel(grid[divmod(number, n_columns)], f"x [{unit}]", f"y [{unit}]", label_size=9.0)
        _draw_force(panel, name, force * factor)
    for number, note in enumerate(reversed(notes)):
        page.write_footnote(note, y=(0.12 + number * _NOTE_HEIGHT) / height)
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


def _describe_forces(run: Trajectory, shown: Sequence[str], axes: str) -> str:
    """Return what the curves are, and which joints are left out."""
    where = "axes of the plane" if axes == "plane" else "axes of that body"
    left_out = f"; not shown: {', '.join(shown[_MAX_FORCE_PANELS:])}" if len(shown) > _MAX_FORCE_PANELS else ""
    return f"Force on the second body, {where}; dot: start, arrow: sense; engine {run.cost.engine}{left_out}"


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
    panel.locator_params(nbins=_MAX_FORCE_TICKS)
    panel.axhline(0.0, color=MUTED, linewidth=0.8, zorder=1)
    panel.axvline(0.0, color=MUTED, linewidth=0.8, zorder=1)
    panel.plot(force[:, 0], force[:, 1], color=BLUE, linewidth=1.4, zorder=3)
    panel.plot(*force[0], "o", color=VERMILLION, markeredgecolor=PAPER, markersize=6, zorder=5)
    _draw_sense(panel, force)
    panel.write_note(name, (0.0, 1.0), (0, 8), xycoords="axes fraction", color=INK, fontsize=10.5)


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

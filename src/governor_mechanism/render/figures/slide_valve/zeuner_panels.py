"""The two panels of Zeuner's plate. The crank rotates anticlockwise from the dead centre at the crank end, at the right."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, Rectangle

from governor_mechanism.render.figures.engraving_sheet import (
    CHAIN_DOTTED,
    DASHED,
    MM_PER_M,
    PLATE_DPI,
    add_line_legend,
    annotate_point,
    draw_point,
    polar_points,
)
from governor_mechanism.render.figures.label_placement import LabelBox, TextLabel, label_shifts
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValveDiagramData
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SERIF_FONT, VERMILLION
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent

CRANK_END_COLOUR, HEAD_END_COLOUR = BLUE, VERMILLION
CYLINDER_ENDS = (("crank end", 1.0, CRANK_END_COLOUR), ("head end", -1.0, HEAD_END_COLOUR))
"""Name of each end, sign of the valve displacement that admits steam to it, and colour."""

_STEAM_COLOURS = {CRANK_END_COLOUR: "#cfe4f1", HEAD_END_COLOUR: "#f8dcc6"}
"""Fill colours of the two ends."""

_RIM_RATIO, _RIM_CLEARANCE_RATIO, _HALF_HEIGHT_RATIO = 1.22, 1.08, 1.23
"""Radius of the crank circle over the eccentricity, its least ratio to the displacement; half height of the panel over the crank circle."""

_MIN_LABELLED_STROKE_PERCENT = 14.0
"""Smallest part of the stroke (percent) with a label."""

_LEGEND_SIZE_POINTS, _LABEL_MARGIN_POINTS = (125.0, 62.0), 8.0
"""Width and height of the legend in the corner; largest extension of labels beyond the panel (points)."""

_MIN_LABEL_DISTANCE_DEG = 4.5
"""Smallest distance (deg) of an angle label from an event."""


def draw_polar_diagram(axes: Axes, data: ValveDiagramData, aspect: float) -> None:
    """Draw the polar diagram, in mm of the valve displacement."""
    rim_radius = _rim_radius(data)
    height = 2 * _HALF_HEIGHT_RATIO * rim_radius
    axes.set(xlim=(-aspect * height / 2, aspect * height / 2), ylim=(-height / 2, height / 2), aspect="equal")
    axes.set_axis_off()
    _draw_rim(axes, rim_radius, [math.degrees(event.simulated) for event in data.events.rows])
    _draw_steam_areas(axes, data)
    _draw_circles(axes, data)
    for event in data.events.rows:
        _draw_event_ray(axes, event, rim_radius)
    _label_events(axes, data, rim_radius)
    draw_displacement_curves(axes, data, linewidth=2.4, zorder=5, solid_capstyle="round")
    _label_diagram(axes, data, rim_radius)


def _rim_radius(data: ValveDiagramData) -> float:
    """Return the radius of the crank circle (mm), outside all curves."""
    return max(_RIM_RATIO * data.eccentric.radius, _RIM_CLEARANCE_RATIO * float(np.max(np.abs(data.displacement)))) * MM_PER_M


def event_kind_and_colour(event: ValveEvent) -> tuple[str, str]:
    """Return the kind of a valve event, and the colour of its cylinder end."""
    end, kind = event.name.rsplit(" ", 1)
    return kind, CRANK_END_COLOUR if end == "crank end" else HEAD_END_COLOUR


def draw_event_marker(axes: Axes, x: float, y: float, colour: str, *, size: float = 6) -> None:
    """Draw the round marker of a valve event."""
    draw_point(axes, x, y, color=colour, markeredgecolor=PAPER, markersize=size, zorder=6)


def _draw_rim(axes: Axes, rim_radius: float, event_angles: Sequence[float]) -> None:
    """Draw the crank circle with a degree scale, and the axes."""
    axes.add_patch(Circle((0, 0), rim_radius, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    axes.add_patch(Circle((0, 0), 1.025 * rim_radius, fill=False, edgecolor=MUTED, linewidth=0.5, zorder=3))
    for degree in range(0, 360, 2):
        length = 1.025 if degree % 10 else 1.045
        axes.plot(*polar_points(math.radians(degree), [rim_radius, length * rim_radius]), color=MUTED, linewidth=0.5, zorder=3)
    for degree in range(0, 360, 30):
        if all(abs(math.remainder(degree - other, 360)) >= _MIN_LABEL_DISTANCE_DEG for other in event_angles):
            position = polar_points(math.radians(degree), 1.08 * rim_radius)
            annotate_point(axes, position, f"{degree}°", ha="center", va="center", fontsize=8.5, color=MUTED)
    for ends in (((-rim_radius, rim_radius), (0, 0)), ((0, 0), (-rim_radius, rim_radius))):
        axes.plot(*ends, color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)


def _draw_steam_areas(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the admission areas between the circle of the outside lap and the valve curve."""
    lap = max(data.outside_lap, 0.0) * MM_PER_M
    for _, side, colour in CYLINDER_ENDS:
        length = side * data.displacement * MM_PER_M
        is_open = length > lap
        angles, lengths = data.angles[is_open], length[is_open]
        # Start at the first open angle, because the opening of the crank end includes the dead centre.
        gaps = np.flatnonzero(np.diff(angles) > 1.5 * math.tau / (len(data.angles) - 1))
        first = int(gaps[0]) + 1 if len(gaps) else 0
        angles, lengths = np.roll(angles, -first), np.roll(lengths, -first)
        edge = polar_points(np.append(angles, angles[::-1]), np.append(lengths, np.full(len(angles), lap)))
        axes.fill(*edge, color=_STEAM_COLOURS[colour], linewidth=0, zorder=0.5)


def _draw_circles(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the two theoretical valve circles, their line of centres, and the lap circles."""
    r, advance = data.eccentric.radius * MM_PER_M, data.eccentric.advance
    x, y = math.sin(advance) * r / 2, math.cos(advance) * r / 2
    for sign in (1, -1):
        axes.add_patch(Circle((sign * x, sign * y), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=4))
        draw_point(axes, sign * x, sign * y, color=INK, markersize=3, zorder=5)
    axes.plot([-2.3 * x, 2.3 * x], [-2.3 * y, 2.3 * y], color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=2)
    for lap in (data.outside_lap, data.inside_lap):
        axes.add_patch(Circle((0, 0), abs(lap) * MM_PER_M, fill=False, edgecolor=MUTED, linewidth=0.9, zorder=3))


def _draw_event_ray(axes: Axes, event: ValveEvent, rim_radius: float) -> None:
    """Draw the crank at an event, solid for the mechanism and dashed for the theory."""
    _, colour = event_kind_and_colour(event)
    for angle, width, line_colour, style in ((event.simulated, 1.1, colour, "-"), (event.theory, 0.6, INK, DASHED)):
        axes.plot(*polar_points(angle, [0, rim_radius]), linewidth=width, color=line_colour, linestyle=style, zorder=3.5)
    draw_event_marker(axes, *polar_points(event.simulated, rim_radius), colour)


def _label_events(axes: Axes, data: ValveDiagramData, rim_radius: float) -> None:
    """Write the names of the events outside the rim, shifted clear of each other and of the legend."""
    box = axes.get_window_extent()
    width, height = box.width * 72 / PLATE_DPI, box.height * 72 / PLATE_DPI
    legend_box = -width / 2, -width / 2 + _LEGEND_SIZE_POINTS[0], -height / 2, -height / 2 + _LEGEND_SIZE_POINTS[1]
    margin = _LABEL_MARGIN_POINTS
    allowed_box = (-width / 2 - margin, width / 2 + margin, -height / 2 - margin, height / 2)
    events = [(event, event.simulated) for event in data.events.rows]
    scale = height / (2 * _HALF_HEIGHT_RATIO * rim_radius)
    label_events(axes, events, 1.06 * rim_radius, scale, allowed_box, [legend_box], offset=(3, 2), centred=(0.05, 0.55), size=10.5)


def label_events(
    axes: Axes,
    events: Sequence[tuple[ValveEvent, float]],
    radius: float,
    scale: float,
    allowed_box: LabelBox,
    occupied: Sequence[LabelBox] = (),
    *,
    offset: tuple[float, float],
    centred: tuple[float, float],
    size: float,
) -> None:
    """Write the kinds of events at angles (rad) outside a circle of a radius, shifted clear of each other and of occupied boxes.

    `scale` is the size of a data unit in points. Labels with |cos| and |sin| of their angle below `centred` are centred.
    """
    directions = [(math.cos(angle), math.sin(angle)) for _, angle in events]
    offsets = [(math.copysign(offset[0], x), math.copysign(offset[1], y)) for x, y in directions]
    labels = [
        TextLabel(
            text=event_kind_and_colour(event)[0],
            size=size,
            position=(radius * scale * x + dx, radius * scale * y + dy),
            ha="left" if x > centred[0] else "right" if x < -centred[0] else "center",
            va="bottom" if y > centred[1] else "top" if y < -centred[1] else "center",
            outward_direction=(x, y),
        )
        for (event, _), (x, y), (dx, dy) in zip(events, directions, offsets, strict=True)
    ]
    shifts = label_shifts(labels, occupied, allowed_box)
    for (event, _), label, (x, y), (dx, dy), shift in zip(events, labels, directions, offsets, shifts, strict=True):
        style = {"ha": label.ha, "va": label.va, "fontsize": size, "color": event_kind_and_colour(event)[1]}
        annotate_point(axes, (radius * x, radius * y), label.text, (dx + shift[0], dy + shift[1]), **style)


def draw_displacement_curves(axes: Axes, data: ValveDiagramData, rotation: float = 0.0, **style: Any) -> None:
    """Draw the displacement of the mechanism (mm) on every ray, rotated by an angle (rad)."""
    for _, side, colour in CYLINDER_ENDS:
        length = np.where(side * data.displacement > 0, side * data.displacement * MM_PER_M, np.nan)
        axes.plot(*polar_points(data.angles + rotation, length), color=colour, **style)


def _label_diagram(axes: Axes, data: ValveDiagramData, rim_radius: float) -> None:
    """Label the curves, circles and dead centres."""
    r, advance = data.eccentric.radius * MM_PER_M, data.eccentric.advance
    line_of_centres_angle = math.pi / 2 - advance
    text_style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 10.5, "fontstyle": "italic", "linespacing": 1.4}
    for end, side, colour in CYLINDER_ENDS:
        position = polar_points(line_of_centres_angle, side * 0.62 * r)
        text = f"steam to the {end}\n$\\xi \\leq$ {float(np.max(side * data.displacement)) * MM_PER_M:.1f} mm"
        annotate_point(axes, position, text, color=colour, **text_style)
    for lap, text in ((data.outside_lap, "$e$"), (data.inside_lap, "$i$")):
        if lap:
            radius = abs(lap) * MM_PER_M
            position, offset = polar_points(line_of_centres_angle + math.radians(25), radius), (0, -8) if radius > 0.15 * r else (5, 7)
            annotate_point(axes, position, text, offset, ha="center", va="center", color=MUTED, fontsize=11)
    _draw_advance_angle(axes, rim_radius, advance)
    note_style: dict[str, Any] = {"fontsize": 9.5, "color": MUTED, "fontstyle": "italic"}
    annotate_point(axes, (0.985 * rim_radius, 0), "dead centre, crank end", (0, 4), ha="right", va="bottom", **note_style)
    annotate_point(axes, (-0.985 * rim_radius, 0), "dead centre, head end", (0, -5), ha="left", va="top", **note_style)
    _add_legend(axes)


def _draw_advance_angle(axes: Axes, rim_radius: float, advance: float) -> None:
    """Draw the angle of advance at the rim."""
    low, high = sorted((math.pi / 2 - advance, math.pi / 2))
    arc = Arc((0, 0), 1.84 * rim_radius, 1.84 * rim_radius, theta1=math.degrees(low), theta2=math.degrees(high))
    arc.set(color=MUTED, linewidth=0.8, zorder=3)
    axes.add_patch(arc)
    annotate_point(
        axes, polar_points(math.pi / 2 - advance / 2, 0.92 * rim_radius), "$\\delta$", color=MUTED, ha="center", va="center", fontsize=12
    )


def _add_legend(axes: Axes) -> None:
    """Add the legend of mechanism and theory in the corner."""
    entries: dict[str, dict[str, Any]] = {
        "displacement": {"color": CRANK_END_COLOUR, "linewidth": 2.4},
        r"$r\,\sin(\omega+\delta)$, theory": {"color": INK, "linewidth": 0.9},
        "event": {"color": CRANK_END_COLOUR, "linewidth": 1.1, "marker": "o", "markevery": [1]},
        "event, theory": {"color": INK, "linewidth": 0.6, "linestyle": DASHED},
    }
    properties = {"loc": "lower left", "bbox_to_anchor": (-0.005, -0.01), "frameon": False, "handlelength": 2.4}
    add_line_legend(axes, entries, colour=MUTED, size=9.5, **properties)


def draw_stroke_diagram(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the phases of the steam at each end, as the piston goes out and back, over the stroke."""
    axes.set(xlim=(0, 100), ylim=(-0.2, 3.75))
    for side, spine in axes.spines.items():
        spine.set(visible=side == "bottom", color=MUTED, linewidth=0.8)
    axes.tick_params(color=MUTED, labelcolor=MUTED, labelsize=8, left=False, labelleft=False)
    axes.set_facecolor(PAPER)
    axes.set_xlabel("stroke from the dead centre of each end, %", color=INK, fontsize=10.5, fontfamily=SERIF_FONT)
    for (end, _, colour), base in zip(CYLINDER_ENDS, (2.0, 0.0), strict=True):
        events_by_name = {event_kind_and_colour(row)[0]: row for row in data.events.rows if row.name.startswith(end)}
        stroke_percent = {name: 100 * row.simulated_stroke for name, row in events_by_name.items()}
        for left, right, floor, phase in _stroke_phases(stroke_percent, base):
            fill_colour = {"steam": _STEAM_COLOURS[colour], "compression": RULE}.get(phase, PAPER)
            box = Rectangle((left, floor), right - left, 0.7, facecolor=fill_colour, edgecolor=colour, linewidth=1.0, zorder=2)
            axes.add_patch(box)
            if right - left > _MIN_LABELLED_STROKE_PERCENT:
                annotate_point(axes, ((left + right) / 2, floor + 0.35), phase, ha="center", va="center", fontsize=9.5)
        for name, row in events_by_name.items():
            floor = base + (0.8 if name in ("cut-off", "release") else 0.0)
            axes.plot([100 * row.theory_stroke] * 2, [floor, floor + 0.7], color=INK, linewidth=1.0, linestyle=DASHED)
        label_style = {"ha": "right", "va": "center", "color": colour, "linespacing": 1.3}
        annotate_point(axes, (0, base + 0.75), end.replace(" ", "\n"), (-7, 0), **label_style)
        for text, height in (("out", 1.15), ("back", 0.35)):
            annotate_point(axes, (100, base + height), text, (5, 0), va="center", color=MUTED, fontsize=9.5)


def _stroke_phases(stroke_percent: Mapping[str, float], base: float) -> list[tuple[float, float, float, str]]:
    """Return start and end (percent of the stroke), height and name of each phase: outward above, return below."""
    out_height, back_height = base + 0.8, base
    return [
        (0.0, stroke_percent["cut-off"], out_height, "steam"),
        (stroke_percent["cut-off"], stroke_percent["release"], out_height, "expansion"),
        (stroke_percent["release"], 100.0, out_height, "exhaust"),
        (stroke_percent["compression"], 100.0, back_height, "exhaust"),
        (stroke_percent["admission"], stroke_percent["compression"], back_height, "compression"),
        (0.0, stroke_percent["admission"], back_height, "steam"),
    ]

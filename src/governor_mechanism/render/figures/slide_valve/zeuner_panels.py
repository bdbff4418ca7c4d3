"""The two panels of Zeuner's plate. The crank rotates anticlockwise from the dead centre at the crank end, at the right."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Rectangle

from governor_mechanism.render.figures.engraving_sheet import CHAIN_DOTTED, DASHED, MM_PER_M, PLATE_DPI, AxesPoint, annotate_point
from governor_mechanism.render.figures.label_placement import TextLabel, label_shifts
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValveDiagramData
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SERIF_FONT, VERMILLION
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent
from governor_mechanism.types import FloatArray

CRANK_END_COLOUR, HEAD_END_COLOUR = BLUE, VERMILLION
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
    _draw_displacement_curves(axes, data)
    _label_diagram(axes, data, rim_radius)


def _rim_radius(data: ValveDiagramData) -> float:
    """Return the radius of the crank circle (mm), outside all curves."""
    return max(_RIM_RATIO * data.eccentric.radius, _RIM_CLEARANCE_RATIO * float(np.max(np.abs(data.displacement)))) * MM_PER_M


def _polar_to_cartesian(angles: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    return lengths * np.cos(angles), lengths * np.sin(angles)


def _draw_rim(axes: Axes, rim_radius: float, event_angles: Sequence[float]) -> None:
    """Draw the crank circle with a degree scale, and the axes."""
    axes.add_patch(Circle((0, 0), rim_radius, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    axes.add_patch(Circle((0, 0), 1.025 * rim_radius, fill=False, edgecolor=MUTED, linewidth=0.5, zorder=3))
    for degree in range(0, 360, 2):
        length = 1.025 if degree % 10 else 1.045
        x, y = math.cos(math.radians(degree)), math.sin(math.radians(degree))
        axes.plot(
            [rim_radius * x, length * rim_radius * x], [rim_radius * y, length * rim_radius * y], color=MUTED, linewidth=0.5, zorder=3
        )
    for degree in range(0, 360, 30):
        if any(abs(math.remainder(degree - other, 360)) < _MIN_LABEL_DISTANCE_DEG for other in event_angles):
            continue
        x, y = math.cos(math.radians(degree)), math.sin(math.radians(degree))
        position = 1.08 * rim_radius * x, 1.08 * rim_radius * y
        annotate_point(axes, position, f"{degree}°", ha="center", va="center", fontsize=8.5, color=MUTED)
    for ends in (((-rim_radius, rim_radius), (0, 0)), ((0, 0), (-rim_radius, rim_radius))):
        axes.plot(*ends, color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)


def _draw_steam_areas(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the admission areas between the circle of the outside lap and the valve curve."""
    lap = max(data.outside_lap, 0.0) * MM_PER_M
    for side, colour in ((1.0, CRANK_END_COLOUR), (-1.0, HEAD_END_COLOUR)):
        length = side * data.displacement * MM_PER_M
        is_open = length > lap
        angles, lengths = data.angles[is_open], length[is_open]
        # Start at the first open angle, because the opening of the crank end includes the dead centre.
        gaps = np.flatnonzero(np.diff(angles) > 1.5 * math.tau / (len(data.angles) - 1))
        first = int(gaps[0]) + 1 if len(gaps) else 0
        angles, lengths = np.roll(angles, -first), np.roll(lengths, -first)
        outer_edge, inner_edge = (_polar_to_cartesian(angles, lengths), _polar_to_cartesian(angles[::-1], np.full(len(angles), lap)))
        axes.fill(
            np.append(outer_edge[0], inner_edge[0]),
            np.append(outer_edge[1], inner_edge[1]),
            color=_STEAM_COLOURS[colour],
            linewidth=0,
            zorder=0.5,
        )


def _draw_circles(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the two theoretical valve circles, their line of centres, and the lap circles."""
    r, advance = data.eccentric.radius * MM_PER_M, data.eccentric.advance
    x, y = math.sin(advance) * r / 2, math.cos(advance) * r / 2
    for sign in (1, -1):
        axes.add_patch(Circle((sign * x, sign * y), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=4))
        axes.plot([sign * x], [sign * y], "o", color=INK, markersize=3, zorder=5)
    axes.plot([-2.3 * x, 2.3 * x], [-2.3 * y, 2.3 * y], color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=2)
    for lap in (data.outside_lap, data.inside_lap):
        axes.add_patch(Circle((0, 0), abs(lap) * MM_PER_M, fill=False, edgecolor=MUTED, linewidth=0.9, zorder=3))


def _draw_event_ray(axes: Axes, event: ValveEvent, rim_radius: float) -> None:
    """Draw the crank at an event, solid for the mechanism and dashed for the theory."""
    colour = CRANK_END_COLOUR if event.name.startswith("crank") else HEAD_END_COLOUR
    for angle, width, line_colour, style in ((event.simulated, 1.1, colour, "-"), (event.theory, 0.6, INK, DASHED)):
        x, y = rim_radius * math.cos(angle), rim_radius * math.sin(angle)
        axes.plot([0, x], [0, y], linewidth=width, color=line_colour, linestyle=style, zorder=3.5)
    x, y = math.cos(event.simulated), math.sin(event.simulated)
    axes.plot([rim_radius * x], [rim_radius * y], "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=6)


def _label_events(axes: Axes, data: ValveDiagramData, rim_radius: float) -> None:
    """Write the names of the events outside the rim, shifted clear of each other and of the legend."""
    box = axes.get_window_extent()
    points = 72 / PLATE_DPI
    width, height = box.width * points, box.height * points
    scale = height / (2 * _HALF_HEIGHT_RATIO * rim_radius)
    labels = []
    for event in data.events.rows:
        x, y = math.cos(event.simulated), math.sin(event.simulated)
        base_offset = 3 * math.copysign(1, x), 2 * math.copysign(1, y)
        labels.append(
            TextLabel(
                text=event.name.rsplit(" ", 1)[1],
                size=10.5,
                position=(1.06 * rim_radius * scale * x + base_offset[0], 1.06 * rim_radius * scale * y + base_offset[1]),
                ha="left" if x > 0.05 else "right" if x < -0.05 else "center",
                va="bottom" if y > 0.55 else "top" if y < -0.55 else "center",
                outward_direction=(x, y),
            )
        )
    legend_box = -width / 2, -width / 2 + _LEGEND_SIZE_POINTS[0], -height / 2, -height / 2 + _LEGEND_SIZE_POINTS[1]
    allowed_box = (-width / 2 - _LABEL_MARGIN_POINTS, width / 2 + _LABEL_MARGIN_POINTS, -height / 2 - _LABEL_MARGIN_POINTS, height / 2)
    label_offsets = label_shifts(labels, [legend_box], allowed_box)
    for event, label, shift in zip(data.events.rows, labels, label_offsets, strict=True):
        x, y = label.outward_direction
        offset = 3 * math.copysign(1, x) + shift[0], 2 * math.copysign(1, y) + shift[1]
        colour = CRANK_END_COLOUR if event.name.startswith("crank") else HEAD_END_COLOUR
        position = 1.06 * rim_radius * x, 1.06 * rim_radius * y
        annotate_point(axes, position, label.text, offset, ha=label.ha, va=label.va, color=colour, fontsize=label.size)


def _draw_displacement_curves(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the displacement of the mechanism on every ray."""
    for side, colour in ((1.0, CRANK_END_COLOUR), (-1.0, HEAD_END_COLOUR)):
        length = np.where(side * data.displacement > 0, side * data.displacement * MM_PER_M, np.nan)
        axes.plot(*_polar_to_cartesian(data.angles, length), color=colour, linewidth=2.4, zorder=5, solid_capstyle="round")


def _label_diagram(axes: Axes, data: ValveDiagramData, rim_radius: float) -> None:
    """Label the curves, circles and dead centres."""
    r, advance = data.eccentric.radius * MM_PER_M, data.eccentric.advance
    line_of_centres_angle = math.pi / 2 - advance
    for angle, text, colour in (
        (line_of_centres_angle, "steam to the crank end", CRANK_END_COLOUR),
        (line_of_centres_angle + math.pi, "steam to the head end", HEAD_END_COLOUR),
    ):
        position: AxesPoint = 0.62 * r * math.cos(angle), 0.62 * r * math.sin(angle)
        max_displacement = float(np.max((1.0 if colour == CRANK_END_COLOUR else -1.0) * data.displacement)) * MM_PER_M
        text_style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 10.5, "fontstyle": "italic", "linespacing": 1.4}
        annotate_point(axes, position, f"{text}\n$\\xi \\leq$ {max_displacement:.1f} mm", color=colour, **text_style)
    for lap, text in ((data.outside_lap, "$e$"), (data.inside_lap, "$i$")):
        if lap:
            angle = line_of_centres_angle + math.radians(25)
            position = abs(lap) * MM_PER_M * math.cos(angle), abs(lap) * MM_PER_M * math.sin(angle)
            annotate_point(
                axes,
                position,
                text,
                (0, -8) if abs(lap) * MM_PER_M > 0.15 * r else (5, 7),
                ha="center",
                va="center",
                color=MUTED,
                fontsize=11,
            )
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
    middle = math.pi / 2 - advance / 2
    position = 0.92 * rim_radius * math.cos(middle), 0.92 * rim_radius * math.sin(middle)
    annotate_point(axes, position, "$\\delta$", color=MUTED, ha="center", va="center", fontsize=12)


def _add_legend(axes: Axes) -> None:
    """Add the legend of mechanism and theory in the corner."""
    handles = [
        Line2D([], [], color=CRANK_END_COLOUR, linewidth=2.4, label="displacement"),
        Line2D([], [], color=INK, linewidth=0.9, label="$r\\,\\sin(\\omega+\\delta)$, theory"),
        Line2D([], [], color=CRANK_END_COLOUR, linewidth=1.1, marker="o", markevery=[1], label="event"),
        Line2D([], [], color=INK, linewidth=0.6, linestyle=DASHED, label="event, theory"),
    ]
    text_style = {"family": SERIF_FONT, "size": 9.5, "math_fontfamily": "stix"}
    legend = axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(-0.005, -0.01), frameon=False, handlelength=2.4)
    for text in legend.get_texts():
        text.set(fontfamily=text_style["family"], fontsize=text_style["size"], math_fontfamily=text_style["math_fontfamily"], color=MUTED)


def draw_stroke_diagram(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the phases of the steam at each end, as the piston goes out and back, over the stroke."""
    axes.set(xlim=(0, 100), ylim=(-0.2, 3.75))
    for side, spine in axes.spines.items():
        spine.set(visible=side == "bottom", color=MUTED, linewidth=0.8)
    axes.tick_params(color=MUTED, labelcolor=MUTED, labelsize=8, left=False, labelleft=False)
    axes.set_facecolor(PAPER)
    axes.set_xlabel("stroke from the dead centre of each end, %", color=INK, fontsize=10.5, fontfamily=SERIF_FONT)
    for end, colour, base in (("crank end", CRANK_END_COLOUR, 2.0), ("head end", HEAD_END_COLOUR, 0.0)):
        events_by_name = {row.name.rsplit(" ", 1)[1]: row for row in data.events.rows if row.name.startswith(end)}
        stroke_percent = {name: 100 * row.simulated_stroke for name, row in events_by_name.items()}
        for left, right, floor, phase in _stroke_phases(stroke_percent, base):
            _draw_stroke_phase(axes, (left, right, floor), phase, colour)
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


def _draw_stroke_phase(axes: Axes, extent: tuple[float, float, float], phase: str, colour: str) -> None:
    left, right, floor = extent
    fill_colour = {"steam": _STEAM_COLOURS[colour], "compression": RULE}.get(phase, PAPER)
    box = Rectangle((left, floor), right - left, 0.7, facecolor=fill_colour, edgecolor=colour, linewidth=1.0, zorder=2)
    axes.add_patch(box)
    if right - left > _MIN_LABELLED_STROKE_PERCENT:
        annotate_point(axes, ((left + right) / 2, floor + 0.35), phase, ha="center", va="center", fontsize=9.5)

"""The four panels of Marks' plate."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.render.figures.engraving_sheet import (
    CHAIN_DOTTED,
    DASHED,
    MM_PER_M,
    PLATE_DPI,
    annotate_point,
    draw_point,
    polar_points,
    style_plate_axes,
)
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValveDiagramData
from governor_mechanism.render.figures.slide_valve.zeuner_panels import (
    CRANK_END_COLOUR,
    CYLINDER_ENDS,
    draw_displacement_curves,
    draw_event_marker,
    event_kind_and_colour,
    label_events,
)
from governor_mechanism.render.style import BLUE, GREEN, INK, MUTED, PAPER, SERIES_COLOURS, VERMILLION

_PARABOLA_COLOUR, _CIRCLE_COLOUR = SERIES_COLOURS[3], GREEN

_N_CURVE_POINTS = 401
"""Number of points of each curve."""

_UM_PER_M = 1e6

_LABEL_MARGIN_POINTS = 12.0
"""Largest extension of labels above and below the panel, points."""


def draw_error_construction(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the construction to scale (mm): valve circles on their line of centres, Marks' curves over it, one ray."""
    eccentric, r = data.eccentric, data.eccentric.radius * MM_PER_M
    axes.set(xlim=(-1.66 * r, 1.22 * r), ylim=(-0.66 * r, 0.66 * r), aspect="equal")
    axes.set_axis_off()
    for ends in (([-1.18 * r, 1.18 * r], [0, 0]), ([0, 0], [-0.6 * r, 0.6 * r])):
        axes.plot(*ends, color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    for side in (1, -1):
        axes.add_patch(Circle((side * r / 2, 0), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=3))
    draw_displacement_curves(axes, data, eccentric.advance - math.pi / 2, linewidth=2.2, zorder=4)
    x = np.linspace(-data.eccentric.radius, data.eccentric.radius, _N_CURVE_POINTS)
    for z, colour, style in (
        (closed.parabola_error(eccentric, theoretical=x), _PARABOLA_COLOUR, DASHED),
        (closed.circle_error(eccentric, theoretical=x), _CIRCLE_COLOUR, "-"),
    ):
        axes.plot(x * MM_PER_M, np.asarray(z) * MM_PER_M, color=colour, linewidth=1.5, linestyle=style, zorder=5)
    _draw_sample_ray(axes, data)
    _label_construction(axes, data)


def _label_construction(axes: Axes, data: ValveDiagramData) -> None:
    r = data.eccentric.radius * MM_PER_M
    centre_distance = r * math.sin(data.eccentric.advance)
    for position, text in ((centre_distance, "$m$"), (-centre_distance, "$m'$")):
        draw_point(axes, position, 0, color=INK, markerfacecolor=PAPER, markersize=5, zorder=6)
        annotate_point(axes, (position, 0), text, (0, -14), ha="center", fontsize=11)
    annotate_point(axes, (0, 0), "$O$", (-9, -13), fontsize=11)
    text = "Marks’ circle\nof radius $l$ and\nhis parabola\n(dashed), both\nthrough $m$, $m'$"
    annotate_point(axes, (-1.62 * r, 0.6 * r), text, va="top", color=_CIRCLE_COLOUR, fontsize=9.5, linespacing=1.4)
    annotate_point(axes, (-1.62 * r, -0.58 * r), "thin: theory\nbold: mechanism", va="bottom", fontsize=9.5, linespacing=1.4)


_SAMPLE_RAY_ANGLE = math.radians(33.0)
"""Angle (rad) between the drawn ray and the line of centres."""


def _draw_sample_ray(axes: Axes, data: ValveDiagramData) -> None:
    """Draw one ray: its chord in the valve circle, transferred to the line of centres; there the error, transferred to the ray."""
    angle, r = _SAMPLE_RAY_ANGLE, data.eccentric.radius
    theoretical = r * math.cos(angle)
    z = float(closed.hyperbola_error(data.eccentric, theoretical=theoretical)) * MM_PER_M
    x = theoretical * MM_PER_M
    axes.plot(*polar_points(angle, [0, 1.16 * r * MM_PER_M]), color=INK, linewidth=0.9, zorder=3)
    axes.plot(*polar_points(np.linspace(0.0, angle, 40), x), color=MUTED, linewidth=0.8, linestyle=DASHED, zorder=3)
    for line in (([x, x], [0.0, z]), polar_points(angle, [x, x + z])):
        axes.plot(*line, color=VERMILLION, linewidth=3.0, zorder=7, solid_capstyle="butt")
    draw_point(axes, *polar_points(angle, x), color=INK, markerfacecolor=PAPER, markersize=5, zorder=8)
    annotate_point(axes, polar_points(angle, x), "$P$", (-4, 9), fontsize=11)
    annotate_point(axes, polar_points(angle, 1.1 * r * MM_PER_M), f"$z$ = {z:.2f} mm", (4, -9), color=VERMILLION)


def draw_approximation_errors(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the errors of parabola and circle relative to the exact curve (um), with points of the mechanism on the exact curve."""
    eccentric = data.eccentric
    x = np.linspace(-eccentric.radius, eccentric.radius, _N_CURVE_POINTS)
    exact_errors = np.asarray(closed.hyperbola_error(eccentric, theoretical=x))
    parabola, circle = (
        (np.asarray(curve(eccentric, theoretical=x)) - exact_errors) * _UM_PER_M for curve in (closed.parabola_error, closed.circle_error)
    )
    style_plate_axes(axes, "theoretical displacement $\\xi_0 = r\\,\\sin(\\omega+\\delta)$, mm", "deviation from the exact error, µm")
    simulated_errors = data.displacement - data.theoretical_displacement + data.events.centre - closed.equal_lead_centre(eccentric)
    closed_form_errors = np.asarray(closed.hyperbola_error(eccentric, theoretical=data.theoretical_displacement))
    points = data.theoretical_displacement[::10] * MM_PER_M, (simulated_errors - closed_form_errors)[::10] * _UM_PER_M
    axes.plot(*points, "o", color=BLUE, markersize=4.5, zorder=3)
    axes.axhline(0, color=BLUE, linewidth=0.9, zorder=2)
    low, high = min(parabola.min(), circle.min()), max(parabola.max(), circle.max())
    height = high - low
    for z, colour, style in ((parabola, _PARABOLA_COLOUR, DASHED), (circle, _CIRCLE_COLOUR, "-")):
        axes.plot(x * MM_PER_M, z, color=colour, linewidth=2.0, linestyle=style, zorder=4)
    axes.set(xlim=(1.06 * x[0] * MM_PER_M, 1.06 * x[-1] * MM_PER_M), ylim=(low - 0.2 * height, high + 0.25 * height))
    for z, colour, name, position, alignment in (
        (parabola, _PARABOLA_COLOUR, "parabola", (-0.35 * eccentric.radius * MM_PER_M, high), "center"),
        (circle, _CIRCLE_COLOUR, "circle", (x[-1] * MM_PER_M, float(circle[-1])), "right"),
    ):
        annotate_point(axes, position, f"{name}: at most {np.abs(z).max():.3g} µm", (0, 8), ha=alignment, va="bottom", color=colour)
    text = "on the hyperbola $(z+d)^2-\\xi_0^2=l^2-r^2$:\npoints of the mechanism"
    annotate_point(axes, (0, 0), text, (0, -7), ha="center", va="top", color=BLUE, linespacing=1.4, fontsize=9.5)


def draw_valve_ellipse(axes: Axes, data: ValveDiagramData) -> None:
    """Draw the valve displacement over the piston travel: the theoretical ellipse, and the curve with two finite rods."""
    style_plate_axes(axes, "piston travel from the crank end, % of the stroke", "valve’s displacement $\\xi$, mm")
    axes.plot(100 * data.theoretical_piston_travel, data.theoretical_displacement * MM_PER_M, color=INK, linewidth=0.9, zorder=3)
    axes.plot(100 * data.piston_travel, data.displacement * MM_PER_M, color=BLUE, linewidth=2.4, zorder=4)
    for lap, text in ((data.outside_lap, "$e$"), (-data.outside_lap, "$-e$"), (data.inside_lap, "$i$"), (-data.inside_lap, "$-i$")):
        axes.axhline(lap * MM_PER_M, color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=2)
        annotate_point(axes, (104, lap * MM_PER_M), text.replace("-", "−"), (5, 0), va="center", color=MUTED, fontsize=10)
    for event in data.events.rows:
        _, colour = event_kind_and_colour(event)
        piston_travel = event.simulated_stroke if colour == CRANK_END_COLOUR else 1 - event.simulated_stroke
        lap = float(np.interp(event.simulated, data.angles, data.displacement))
        draw_event_marker(axes, 100 * piston_travel, lap * MM_PER_M, colour, size=7)
    axes.set_xlim(-4, 104)
    for end, side, colour in CYLINDER_ENDS:
        position = 50 - 23 * side, 0.68 * side * float(np.max(side * data.displacement)) * MM_PER_M
        annotate_point(axes, position, f"steam to the {end}", ha="center", va="center", color=colour, fontstyle="italic")
    position = 0, 0.86 * float(data.theoretical_displacement.min()) * MM_PER_M
    annotate_point(axes, position, "thin: both rods infinite", color=INK, fontsize=9.5)


def draw_reuleaux_diagram(axes: Axes, data: ValveDiagramData) -> None:
    """Draw Reuleaux's circle: the distance of the crank pin from a diameter inclined by the advance, with lines at the laps."""
    r, advance = data.eccentric.radius * MM_PER_M, data.eccentric.advance
    axes.set(xlim=(-1.75 * r, 1.75 * r), ylim=(-1.1 * r, 1.1 * r), aspect="equal")
    axes.set_axis_off()
    axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    axes.plot([-1.06 * r, 1.06 * r], [0, 0], color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)
    diameter_direction = np.array([math.cos(advance), -math.sin(advance)])
    normal_direction = np.array([math.sin(advance), math.cos(advance)])
    axes.plot(*np.outer(diameter_direction, [-1.12 * r, 1.12 * r]), color=INK, linewidth=0.9, linestyle=CHAIN_DOTTED, zorder=2)
    for event in data.events.rows:
        event_kind, colour = event_kind_and_colour(event)
        if event_kind in ("admission", "release"):
            side, lap, _ = closed.VALVE_EVENTS[event.name]
            lap_distance = side * (data.outside_lap if lap == "outside" else data.inside_lap) * MM_PER_M
            half_chord = math.sqrt(max(r**2 - lap_distance**2, 0.0))
            line = lap_distance * normal_direction[:, None] + np.outer(diameter_direction, [-half_chord, half_chord])
            axes.plot(*line, color=colour, linewidth=1.2, zorder=3)
        axes.plot(*polar_points(event.theory, [0, r]), color=colour, linewidth=0.7, zorder=2.5)
        draw_event_marker(axes, *polar_points(event.theory, r), colour)
    _label_pins(axes, data)
    start, arrow = 0.1 * r * diameter_direction, 0.62 * r * normal_direction
    axes.annotate("", tuple(start + arrow), tuple(start), arrowprops={"arrowstyle": "<->", "color": MUTED, "linewidth": 0.7})
    axes.plot(*polar_points(np.linspace(-advance, 0.0, 30), 0.78 * r), color=MUTED, linewidth=0.8, zorder=3)
    annotate_point(axes, polar_points(-advance / 2, 0.78 * r), "$\\delta$", (5, 0), va="center", color=MUTED)
    annotate_point(axes, tuple(start + 0.5 * arrow), "$\\xi_0$", (8, 0), color=MUTED)


def _label_pins(axes: Axes, data: ValveDiagramData) -> None:
    """Write the names of the events outside Reuleaux's circle, shifted clear of each other."""
    r, box = data.eccentric.radius * MM_PER_M, axes.get_window_extent()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    scale = 72 / PLATE_DPI * min(box.width / (right - left), box.height / (top - bottom))
    allowed_box = scale * left, scale * right, scale * bottom - _LABEL_MARGIN_POINTS, scale * top + _LABEL_MARGIN_POINTS
    events = [(event, event.theory) for event in data.events.rows]
    label_events(axes, events, r, scale, allowed_box, offset=(5, 3), centred=(0.0, 0.5), size=9.5)

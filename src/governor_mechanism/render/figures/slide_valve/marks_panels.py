"""The four panels of Marks' plate."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.render.figures.engraving_sheet import CHAIN, DASHES, DPI, MM, dress, letter
from governor_mechanism.render.figures.label_placement import Word, shifts
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValvePlate
from governor_mechanism.render.figures.slide_valve.zeuner_panels import CRANK_END, HEAD_END
from governor_mechanism.render.style import BLUE, GREEN, INK, PAPER, QUIET, SERIES, VERMILLION

PARABOLA, CIRCLE = SERIES[3], GREEN

POINTS = 401
"""Of each curve."""

MICRO = 1e6

LINES = 12.0
"""Points: so far above and below its panel may names stand."""


def draw_construction(axes: Axes, plate: ValvePlate) -> None:
    """The construction to scale (mm): valve circles on their line of centres, Marks' curves over it, one ray."""
    eccentric, r = plate.eccentric, plate.eccentric.radius * MM
    axes.set(xlim=(-1.66 * r, 1.22 * r), ylim=(-0.66 * r, 0.66 * r), aspect="equal")
    axes.set_axis_off()
    axes.plot([-1.18 * r, 1.18 * r], [0, 0], color=QUIET, linewidth=0.7, linestyle=CHAIN, zorder=1)
    axes.plot([0, 0], [-0.6 * r, 0.6 * r], color=QUIET, linewidth=0.7, linestyle=CHAIN, zorder=1)
    turned = plate.angles + eccentric.advance - math.pi / 2
    for side, colour in ((1, CRANK_END), (-1, HEAD_END)):
        axes.add_patch(Circle((side * r / 2, 0), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=3))
        length = np.where(side * plate.displacement > 0, side * plate.displacement * MM, np.nan)
        axes.plot(length * np.cos(turned), length * np.sin(turned), color=colour, linewidth=2.2, zorder=4)
    x = np.linspace(-plate.eccentric.radius, plate.eccentric.radius, POINTS)
    for z, colour, style in (
        (closed.parabola_error(eccentric, theoretical=x), PARABOLA, DASHES),
        (closed.circle_error(eccentric, theoretical=x), CIRCLE, "-"),
    ):
        axes.plot(x * MM, np.asarray(z) * MM, color=colour, linewidth=1.5, linestyle=style, zorder=5)
    _sample(axes, plate)
    _construction_names(axes, plate)


def _construction_names(axes: Axes, plate: ValvePlate) -> None:
    r = plate.eccentric.radius * MM
    at = r * math.sin(plate.eccentric.advance)
    for place, words in ((at, "$m$"), (-at, "$m'$")):
        axes.plot([place], [0], "o", color=INK, markerfacecolor=PAPER, markersize=5, zorder=6)
        letter(axes, (place, 0), words, (0, -14), ha="center", fontsize=11)
    letter(axes, (0, 0), "$O$", (-9, -13), fontsize=11)
    words = "Marks’ circle\nof radius $l$ and\nhis parabola\n(broken), both\nthrough $m$, $m'$"
    letter(axes, (-1.62 * r, 0.6 * r), words, va="top", color=CIRCLE, fontsize=9.5, linespacing=1.4)
    words = "thin: by theory\nbold: in truth"
    letter(axes, (-1.62 * r, -0.58 * r), words, va="bottom", fontsize=9.5, linespacing=1.4)


SAMPLE = math.radians(33.0)
"""Between the ray that is shown and the line of centres."""


def _sample(axes: Axes, plate: ValvePlate) -> None:
    """One ray: its piece in the valve circle, laid off on the line of centres; there the error, laid off on the ray."""
    r = plate.eccentric.radius
    theoretical = r * math.cos(SAMPLE)
    z = float(closed.hyperbola_error(plate.eccentric, theoretical=theoretical)) * MM
    x = theoretical * MM
    ray = math.cos(SAMPLE), math.sin(SAMPLE)
    axes.plot([0, 1.16 * r * MM * ray[0]], [0, 1.16 * r * MM * ray[1]], color=INK, linewidth=0.9, zorder=3)
    turn = np.linspace(0.0, SAMPLE, 40)
    axes.plot(x * np.cos(turn), x * np.sin(turn), color=QUIET, linewidth=0.8, linestyle=DASHES, zorder=3)
    for start, end in (((x, 0.0), (x, z)), ((x * ray[0], x * ray[1]), ((x + z) * ray[0], (x + z) * ray[1]))):
        axes.plot(*zip(start, end, strict=True), color=VERMILLION, linewidth=3.0, zorder=7, solid_capstyle="butt")
    axes.plot([x * ray[0]], [x * ray[1]], "o", color=INK, markerfacecolor=PAPER, markersize=5, zorder=8)
    letter(axes, (x * ray[0], x * ray[1]), "$P$", (-4, 9), fontsize=11)
    letter(axes, (1.1 * r * MM * ray[0], 1.1 * r * MM * ray[1]), f"$z$ = {z:.2f} mm", (4, -9), color=VERMILLION)


def draw_errors(axes: Axes, plate: ValvePlate) -> None:
    """What parabola and circle give beyond the exact error (um), with the mechanism's own points on the exact one."""
    eccentric = plate.eccentric
    x = np.linspace(-eccentric.radius, eccentric.radius, POINTS)
    true = np.asarray(closed.hyperbola_error(eccentric, theoretical=x))
    parabola, circle = (
        (np.asarray(curve(eccentric, theoretical=x)) - true) * MICRO
        for curve in (closed.parabola_error, closed.circle_error)
    )
    dress(axes, "theoretical displacement $\\xi_0 = r\\,\\sin(\\omega+\\delta)$, mm", "beyond the exact error, µm")
    found = plate.displacement - plate.theory + plate.events.centre - closed.equal_lead_centre(eccentric)
    exact = np.asarray(closed.hyperbola_error(eccentric, theoretical=plate.theory))
    axes.plot(plate.theory[::10] * MM, (found - exact)[::10] * MICRO, "o", color=BLUE, markersize=4.5, zorder=3)
    axes.axhline(0, color=BLUE, linewidth=0.9, zorder=2)
    low, high = min(parabola.min(), circle.min()), max(parabola.max(), circle.max())
    tall = high - low
    for z, colour, style in ((parabola, PARABOLA, DASHES), (circle, CIRCLE, "-")):
        axes.plot(x * MM, z, color=colour, linewidth=2.0, linestyle=style, zorder=4)
    axes.set(xlim=(1.06 * x[0] * MM, 1.06 * x[-1] * MM), ylim=(low - 0.2 * tall, high + 0.25 * tall))
    for z, colour, name, at, side in (
        (parabola, PARABOLA, "parabola", (-0.35 * eccentric.radius * MM, high), "center"),
        (circle, CIRCLE, "circle", (x[-1] * MM, float(circle[-1])), "right"),
    ):
        words = f"{name}: at most {np.abs(z).max():.3g} µm"
        letter(axes, at, words, (0, 8), ha=side, va="bottom", color=colour)
    words = "on the hyperbola $(z+d)^2-\\xi_0^2=l^2-r^2$:\npoints of the mechanism"
    letter(axes, (0, 0), words, (0, -7), ha="center", va="top", color=BLUE, linespacing=1.4, fontsize=9.5)


def draw_ellipse(axes: Axes, plate: ValvePlate) -> None:
    """The valve's displacement over the piston's way: an ellipse by theory, and what two finite rods make of it."""
    dress(axes, "way of the piston from the crank end, % of the stroke", "valve’s displacement $\\xi$, mm")
    axes.plot(100 * plate.piston_theory, plate.theory * MM, color=INK, linewidth=0.9, zorder=3)
    axes.plot(100 * plate.piston, plate.displacement * MM, color=BLUE, linewidth=2.4, zorder=4)
    for lap, words in (
        (plate.outside_lap, "$e$"),
        (-plate.outside_lap, "$-e$"),
        (plate.inside_lap, "$i$"),
        (-plate.inside_lap, "$-i$"),
    ):
        axes.axhline(lap * MM, color=QUIET, linewidth=0.7, linestyle=DASHES, zorder=2)
        letter(axes, (104, lap * MM), words.replace("-", "−"), (5, 0), va="center", color=QUIET, fontsize=10)
    for event in plate.events.rows:
        crank_end = event.name.startswith("crank")
        way = event.simulated_stroke if crank_end else 1 - event.simulated_stroke
        lap = float(np.interp(event.simulated, plate.angles, plate.displacement))
        colour = CRANK_END if crank_end else HEAD_END
        axes.plot([100 * way], [lap * MM], "o", color=colour, markeredgecolor=PAPER, markersize=7, zorder=6)
    axes.set_xlim(-4, 104)
    for way, extreme, words, colour in (
        (27, plate.displacement.max(), "steam to the crank end", CRANK_END),
        (73, plate.displacement.min(), "steam to the head end", HEAD_END),
    ):
        at = way, 0.68 * float(extreme) * MM
        letter(axes, at, words, ha="center", va="center", color=colour, fontstyle="italic")
    letter(axes, (0, 0.86 * float(plate.theory.min()) * MM), "thin: both rods endless", color=INK, fontsize=9.5)


def draw_reuleaux(axes: Axes, plate: ValvePlate) -> None:
    """Reuleaux's circle: the crank pin's distance from a diameter that leans by the advance, lines at the laps."""
    r, advance = plate.eccentric.radius * MM, plate.eccentric.advance
    axes.set(xlim=(-1.75 * r, 1.75 * r), ylim=(-1.1 * r, 1.1 * r), aspect="equal")
    axes.set_axis_off()
    axes.add_patch(Circle((0, 0), r, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    axes.plot([-1.06 * r, 1.06 * r], [0, 0], color=QUIET, linewidth=0.7, linestyle=CHAIN, zorder=1)
    along = np.array([math.cos(advance), -math.sin(advance)])
    across = np.array([math.sin(advance), math.cos(advance)])
    axes.plot(*np.outer(along, [-1.12 * r, 1.12 * r]), color=INK, linewidth=0.9, linestyle=CHAIN, zorder=2)
    for event in plate.events.rows:
        colour = CRANK_END if event.name.startswith("crank") else HEAD_END
        what = event.name.rsplit(" ", 1)[1]
        if what in ("admission", "release"):
            side, lap, _ = closed.EVENTS[event.name]
            size = side * (plate.outside_lap if lap == "outside" else plate.inside_lap) * MM
            half = math.sqrt(max(r**2 - size**2, 0.0))
            line = size * across[:, None] + np.outer(along, [-half, half])
            axes.plot(*line, color=colour, linewidth=1.2, zorder=3)
        pin = r * math.cos(event.theory), r * math.sin(event.theory)
        axes.plot([0, pin[0]], [0, pin[1]], color=colour, linewidth=0.7, zorder=2.5)
        axes.plot(*pin, "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=6)
    _pin_names(axes, plate)
    reach = 0.62 * r
    axes.annotate(
        "",
        tuple(reach * across + 0.1 * r * along),
        tuple(0.1 * r * along),
        arrowprops={"arrowstyle": "<->", "color": QUIET, "linewidth": 0.7},
    )
    lean = np.linspace(-advance, 0.0, 30)
    axes.plot(0.78 * r * np.cos(lean), 0.78 * r * np.sin(lean), color=QUIET, linewidth=0.8, zorder=3)
    middle = 0.78 * r * math.cos(advance / 2), -0.78 * r * math.sin(advance / 2)
    letter(axes, middle, "$\\delta$", (5, 0), va="center", color=QUIET)
    letter(axes, tuple(0.5 * reach * across + 0.1 * r * along), "$\\xi_0$", (8, 0), color=QUIET)


def _pin_names(axes: Axes, plate: ValvePlate) -> None:
    """The events' names outside Reuleaux's circle, moved where they would stand on each other."""
    r, box = plate.eccentric.radius * MM, axes.get_window_extent()
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    scale = 72 / DPI * min(box.width / (right - left), box.height / (top - bottom))
    pins = [(math.cos(event.theory), math.sin(event.theory)) for event in plate.events.rows]
    offsets = [(5 * math.copysign(1, x), 3 * math.copysign(1, y)) for x, y in pins]
    words = [
        Word(
            words=event.name.rsplit(" ", 1)[1],
            size=9.5,
            at=(scale * r * x + offset[0], scale * r * y + offset[1]),
            ha="left" if x > 0 else "right",
            va="bottom" if y > 0.5 else "top" if y < -0.5 else "center",
            out=(x, y),
        )
        for event, (x, y), offset in zip(plate.events.rows, pins, offsets, strict=True)
    ]
    room = scale * left, scale * right, scale * bottom - LINES, scale * top + LINES
    moved = shifts(words, [], room)
    for event, word, (x, y), start, shift in zip(plate.events.rows, words, pins, offsets, moved, strict=True):
        colour = CRANK_END if event.name.startswith("crank") else HEAD_END
        offset = start[0] + shift[0], start[1] + shift[1]
        letter(axes, (r * x, r * y), word.words, offset, ha=word.ha, va=word.va, color=colour, fontsize=word.size)

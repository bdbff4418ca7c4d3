"""The two panels of Zeuner's plate. The crank turns anticlockwise from the crank end's dead centre, right."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Rectangle

from governor_mechanism.render.figures.engraving_sheet import CHAIN, DASHES, DPI, MM, Pair, letter
from governor_mechanism.render.figures.label_placement import Word, shifts
from governor_mechanism.render.figures.slide_valve.zeuner_data import ValvePlate
from governor_mechanism.render.style import BLUE, INK, PAPER, QUIET, RULE, SERIF, VERMILLION
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent
from governor_mechanism.types import FloatArray

CRANK_END, HEAD_END = BLUE, VERMILLION
STEAM = {CRANK_END: "#cfe4f1", HEAD_END: "#f8dcc6"}
"""Washes of the two ends."""

RIM, BEYOND, REACH = 1.22, 1.08, 1.23
"""Radius of the crank's circle in radii of the eccentric, and in displacements at least; half the height in its own."""

ROOM = 14.0
"""%: a narrower piece of the stroke has no room for its name."""

KEY, BESIDE = (125.0, 62.0), 8.0
"""Points: breadth and height of the key in the corner; how far words may stand outside the panel."""

CROWDED = 4.5
"""deg: a mark of degrees nearer to an event than that is left out."""


def draw_polar(axes: Axes, plate: ValvePlate, aspect: float) -> None:
    """The polar diagram, in mm of the valve's displacement."""
    rim = _rim_of(plate)
    height = 2 * REACH * rim
    axes.set(xlim=(-aspect * height / 2, aspect * height / 2), ylim=(-height / 2, height / 2), aspect="equal")
    axes.set_axis_off()
    _rim(axes, rim, [math.degrees(event.simulated) for event in plate.events.rows])
    _washes(axes, plate)
    _circles(axes, plate)
    for event in plate.events.rows:
        _ray(axes, event, rim)
    _event_names(axes, plate, rim)
    _curves(axes, plate)
    _names(axes, plate, rim)


def _rim_of(plate: ValvePlate) -> float:
    """Radius of the crank's circle (mm), outside all curves."""
    return max(RIM * plate.eccentric.radius, BEYOND * float(np.max(np.abs(plate.displacement)))) * MM


def _on_ray(angles: FloatArray, lengths: FloatArray) -> tuple[FloatArray, FloatArray]:
    return lengths * np.cos(angles), lengths * np.sin(angles)


def _rim(axes: Axes, rim: float, taken: Sequence[float]) -> None:
    """The circle of the crank, divided into degrees, and the axes."""
    axes.add_patch(Circle((0, 0), rim, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    axes.add_patch(Circle((0, 0), 1.025 * rim, fill=False, edgecolor=QUIET, linewidth=0.5, zorder=3))
    for degree in range(0, 360, 2):
        length = 1.025 if degree % 10 else 1.045
        x, y = math.cos(math.radians(degree)), math.sin(math.radians(degree))
        axes.plot([rim * x, length * rim * x], [rim * y, length * rim * y], color=QUIET, linewidth=0.5, zorder=3)
    for degree in range(0, 360, 30):
        if any(abs(math.remainder(degree - other, 360)) < CROWDED for other in taken):
            continue
        x, y = math.cos(math.radians(degree)), math.sin(math.radians(degree))
        at = 1.08 * rim * x, 1.08 * rim * y
        letter(axes, at, f"{degree}°", ha="center", va="center", fontsize=8.5, color=QUIET)
    for ends in (((-rim, rim), (0, 0)), ((0, 0), (-rim, rim))):
        axes.plot(*ends, color=QUIET, linewidth=0.7, linestyle=CHAIN, zorder=1)


def _washes(axes: Axes, plate: ValvePlate) -> None:
    """Where steam is admitted: between the circle of the outside lap and the valve's curve."""
    lap = max(plate.outside_lap, 0.0) * MM
    for side, colour in ((1.0, CRANK_END), (-1.0, HEAD_END)):
        length = side * plate.displacement * MM
        open_ = length > lap
        angles, lengths = plate.angles[open_], length[open_]
        # From the first open angle on: the crank end's opening lies across the dead centre.
        gaps = np.flatnonzero(np.diff(angles) > 1.5 * math.tau / (len(plate.angles) - 1))
        first = int(gaps[0]) + 1 if len(gaps) else 0
        angles, lengths = np.roll(angles, -first), np.roll(lengths, -first)
        out, back = _on_ray(angles, lengths), _on_ray(angles[::-1], np.full(len(angles), lap))
        axes.fill(np.append(out[0], back[0]), np.append(out[1], back[1]), color=STEAM[colour], linewidth=0, zorder=0.5)


def _circles(axes: Axes, plate: ValvePlate) -> None:
    """The two valve circles of theory, their line of centres, and the circles of the laps."""
    r, advance = plate.eccentric.radius * MM, plate.eccentric.advance
    x, y = math.sin(advance) * r / 2, math.cos(advance) * r / 2
    for sign in (1, -1):
        axes.add_patch(Circle((sign * x, sign * y), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=4))
        axes.plot([sign * x], [sign * y], "o", color=INK, markersize=3, zorder=5)
    axes.plot([-2.3 * x, 2.3 * x], [-2.3 * y, 2.3 * y], color=QUIET, linewidth=0.7, linestyle=DASHES, zorder=2)
    for lap in (plate.outside_lap, plate.inside_lap):
        axes.add_patch(Circle((0, 0), abs(lap) * MM, fill=False, edgecolor=QUIET, linewidth=0.9, zorder=3))


def _ray(axes: Axes, event: ValveEvent, rim: float) -> None:
    """The crank at an event, bold in truth and broken by theory."""
    colour = CRANK_END if event.name.startswith("crank") else HEAD_END
    for angle, width, ink, style in ((event.simulated, 1.1, colour, "-"), (event.theory, 0.6, INK, DASHES)):
        x, y = rim * math.cos(angle), rim * math.sin(angle)
        axes.plot([0, x], [0, y], linewidth=width, color=ink, linestyle=style, zorder=3.5)
    x, y = math.cos(event.simulated), math.sin(event.simulated)
    axes.plot([rim * x], [rim * y], "o", color=colour, markeredgecolor=PAPER, markersize=6, zorder=6)


def _event_names(axes: Axes, plate: ValvePlate, rim: float) -> None:
    """The events' names outside the rim, moved where they would stand on each other or on the key."""
    box = axes.get_window_extent()
    points = 72 / DPI
    wide, high = box.width * points, box.height * points
    scale = high / (2 * REACH * rim)
    words = []
    for event in plate.events.rows:
        x, y = math.cos(event.simulated), math.sin(event.simulated)
        nudge = 3 * math.copysign(1, x), 2 * math.copysign(1, y)
        words.append(
            Word(
                words=event.name.rsplit(" ", 1)[1],
                size=10.5,
                at=(1.06 * rim * scale * x + nudge[0], 1.06 * rim * scale * y + nudge[1]),
                ha="left" if x > 0.05 else "right" if x < -0.05 else "center",
                va="bottom" if y > 0.55 else "top" if y < -0.55 else "center",
                out=(x, y),
            )
        )
    key = -wide / 2, -wide / 2 + KEY[0], -high / 2, -high / 2 + KEY[1]
    room = -wide / 2 - BESIDE, wide / 2 + BESIDE, -high / 2 - BESIDE, high / 2
    moved = shifts(words, [key], room)
    for event, word, shift in zip(plate.events.rows, words, moved, strict=True):
        x, y = word.out
        offset = 3 * math.copysign(1, x) + shift[0], 2 * math.copysign(1, y) + shift[1]
        colour = CRANK_END if event.name.startswith("crank") else HEAD_END
        at = 1.06 * rim * x, 1.06 * rim * y
        letter(axes, at, word.words, offset, ha=word.ha, va=word.va, color=colour, fontsize=word.size)


def _curves(axes: Axes, plate: ValvePlate) -> None:
    """The true displacement on every ray."""
    for side, colour in ((1.0, CRANK_END), (-1.0, HEAD_END)):
        length = np.where(side * plate.displacement > 0, side * plate.displacement * MM, np.nan)
        axes.plot(*_on_ray(plate.angles, length), color=colour, linewidth=2.4, zorder=5, solid_capstyle="round")


def _names(axes: Axes, plate: ValvePlate, rim: float) -> None:
    """What the lines mean."""
    r, advance = plate.eccentric.radius * MM, plate.eccentric.advance
    out = math.pi / 2 - advance
    for turn, words, colour in (
        (out, "steam to the crank end", CRANK_END),
        (out + math.pi, "steam to the head end", HEAD_END),
    ):
        at: Pair = 0.62 * r * math.cos(turn), 0.62 * r * math.sin(turn)
        most = float(np.max((1.0 if colour == CRANK_END else -1.0) * plate.displacement)) * MM
        look: dict[str, Any] = {
            "ha": "center",
            "va": "center",
            "fontsize": 10.5,
            "fontstyle": "italic",
            "linespacing": 1.4,
        }
        letter(axes, at, f"{words}\n$\\xi$ at most {most:.1f} mm", color=colour, **look)
    for lap, words in ((plate.outside_lap, "$e$"), (plate.inside_lap, "$i$")):
        if lap:
            turn = out + math.radians(25)
            at = abs(lap) * MM * math.cos(turn), abs(lap) * MM * math.sin(turn)
            letter(
                axes,
                at,
                words,
                (0, -8) if abs(lap) * MM > 0.15 * r else (5, 7),
                ha="center",
                va="center",
                color=QUIET,
                fontsize=11,
            )
    _advance(axes, rim, advance)
    looks: dict[str, Any] = {"fontsize": 9.5, "color": QUIET, "fontstyle": "italic"}
    letter(axes, (0.985 * rim, 0), "dead centre, crank end", (0, 4), ha="right", va="bottom", **looks)
    letter(axes, (-0.985 * rim, 0), "dead centre, head end", (0, -5), ha="left", va="top", **looks)
    _key(axes)


def _advance(axes: Axes, rim: float, advance: float) -> None:
    """The angle of advance, at the rim."""
    low, high = sorted((math.pi / 2 - advance, math.pi / 2))
    arc = Arc((0, 0), 1.84 * rim, 1.84 * rim, theta1=math.degrees(low), theta2=math.degrees(high))
    arc.set(color=QUIET, linewidth=0.8, zorder=3)
    axes.add_patch(arc)
    middle = math.pi / 2 - advance / 2
    at = 0.92 * rim * math.cos(middle), 0.92 * rim * math.sin(middle)
    letter(axes, at, "$\\delta$", color=QUIET, ha="center", va="center", fontsize=12)


def _key(axes: Axes) -> None:
    """How truth and theory are drawn, in the corner."""
    handles = [
        Line2D([], [], color=CRANK_END, linewidth=2.4, label="displacement"),
        Line2D([], [], color=INK, linewidth=0.9, label="$r\\,\\sin(\\omega+\\delta)$, by theory"),
        Line2D([], [], color=CRANK_END, linewidth=1.1, marker="o", markevery=[1], label="event"),
        Line2D([], [], color=INK, linewidth=0.6, linestyle=DASHES, label="event by theory"),
    ]
    look = {"family": SERIF, "size": 9.5, "math_fontfamily": "stix"}
    key = axes.legend(
        handles=handles, loc="lower left", bbox_to_anchor=(-0.005, -0.01), frameon=False, handlelength=2.4
    )
    for text in key.get_texts():
        text.set(fontfamily=look["family"], fontsize=look["size"], math_fontfamily=look["math_fontfamily"], color=QUIET)


def draw_strokes(axes: Axes, plate: ValvePlate) -> None:
    """For each end what the steam does as the piston goes out and comes back, by the part of the stroke."""
    axes.set(xlim=(0, 100), ylim=(-0.2, 3.75))
    for side, spine in axes.spines.items():
        spine.set(visible=side == "bottom", color=QUIET, linewidth=0.8)
    axes.tick_params(color=QUIET, labelcolor=QUIET, labelsize=8, left=False, labelleft=False)
    axes.set_facecolor(PAPER)
    axes.set_xlabel("part of the stroke from each end’s own dead centre, %", color=INK, fontsize=10.5, fontfamily=SERIF)
    for end, colour, base in (("crank end", CRANK_END, 2.0), ("head end", HEAD_END, 0.0)):
        own = {row.name.rsplit(" ", 1)[1]: row for row in plate.events.rows if row.name.startswith(end)}
        at = {name: 100 * row.simulated_stroke for name, row in own.items()}
        for left, right, floor, what in _pieces(at, base):
            _piece(axes, (left, right, floor), what, colour)
        for name, row in own.items():
            floor = base + (0.8 if name in ("cut-off", "release") else 0.0)
            axes.plot([100 * row.theory_stroke] * 2, [floor, floor + 0.7], color=INK, linewidth=1.0, linestyle=DASHES)
        names = {"ha": "right", "va": "center", "color": colour, "linespacing": 1.3}
        letter(axes, (0, base + 0.75), end.replace(" ", "\n"), (-7, 0), **names)
        for words, height in (("out", 1.15), ("back", 0.35)):
            letter(axes, (100, base + height), words, (5, 0), va="center", color=QUIET, fontsize=9.5)


def _pieces(at: Mapping[str, float], base: float) -> list[tuple[float, float, float, str]]:
    """From where to where (%), how high, and what the steam does: on the way out above, on the way back below."""
    out, back = base + 0.8, base
    return [
        (0.0, at["cut-off"], out, "steam"),
        (at["cut-off"], at["release"], out, "expansion"),
        (at["release"], 100.0, out, "exhaust"),
        (at["compression"], 100.0, back, "exhaust"),
        (at["admission"], at["compression"], back, "compression"),
        (0.0, at["admission"], back, "steam"),
    ]


def _piece(axes: Axes, place: tuple[float, float, float], what: str, colour: str) -> None:
    left, right, floor = place
    wash = {"steam": STEAM[colour], "compression": RULE}.get(what, PAPER)
    box = Rectangle((left, floor), right - left, 0.7, facecolor=wash, edgecolor=colour, linewidth=1.0, zorder=2)
    axes.add_patch(box)
    if right - left > ROOM:
        letter(axes, ((left + right) / 2, floor + 0.35), what, ha="center", va="center", fontsize=9.5)

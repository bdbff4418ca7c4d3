"""Zeuner's plate: the polar diagram of a valve, simulated curves over theoretical circles where there are some, and the steam phases.

The crank rotates anticlockwise from the dead centre at the crank end, at the right.
"""

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Rectangle
from matplotlib.text import Annotation
from matplotlib.transforms import Bbox

from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.render.figures.page import (
    CHAIN_DOTTED,
    DASHED,
    MM_PER_M,
    PLATE_DPI,
    AxesPoint,
    Panel,
    Plate,
    add_legend,
    polar_points,
)
from governor_mechanism.render.style import BLUE, INK, MUTED, PAPER, RULE, SERIF_FONT, VERMILLION
from governor_mechanism.studies.valve_gears import ValveEvent, tabulate_valve_timing
from governor_mechanism.types import FloatArray

CYLINDER_ENDS = (("crank end", 1.0, BLUE), ("head end", -1.0, VERMILLION))
"""Name of each end, sign of the valve displacement that admits steam to it, and colour."""

END_MARKERS = {BLUE: "o", VERMILLION: "s"}
"""Marker of the events of each end by its colour: the ends differ in grey, too."""

_N_CRANK_ANGLES = 720
"""Number of crank-angle intervals in a turn."""

_SHIFT_STEP = 4.0
"""Step of a label shift, outward or along the circle, points."""
_MAX_OUT, _MAX_ALONG = 5, 14
"""Largest numbers of steps outward and along the circle."""
_STEPS = sorted(product(range(_MAX_OUT + 1), range(-_MAX_ALONG, _MAX_ALONG + 1)), key=lambda step: (step[0] + abs(step[1]), step))
"""Steps outward and along the circle, the shortest way first."""
_LETTER_WIDTH_RATIO, _LINE_HEIGHT_RATIO = 0.5, 1.15
"""Width of a letter and height of a line, as fractions of the font size."""


@dataclass(frozen=True, kw_only=True)
class EventLabelStyle:
    """Font size and offset (points) of event labels; those with |cos| and |sin| of their angle below `centred` are centred.

    Labels may extend beyond the left, right, lower and upper limit of the panel by `margins` (points). `legend_size` (points) is that of
    the legend in the lower left corner.
    """

    size: float
    offset: tuple[float, float]
    centred: tuple[float, float]
    margins: tuple[float, float, float, float]
    legend_size: tuple[float, float] = (0.0, 0.0)


class ValveCircle(NamedTuple):
    """Zeuner's valve circle: the displacement radius * sin(crank angle + advance), in mm and rad."""

    radius: float
    advance: float


class ValveDiagram:
    """Valve of a scene over a closed turn, lengths in mm: angles (n,) (rad) from the dead centre at the crank end.

    `displacement` (n,) (mm) is positive where it opens the steam port of the crank end. `timing` is in SI, `events` are its rows with
    their kinds and colours. `circle` is None where no law of the first order is known. A scene without a valve raises MechanismError.
    """

    heading = "Zeuner’s diagram of the valve"
    source = "after G. Zeuner, Treatise on Valve-Gears"
    circle: ValveCircle | None = None

    def __init__(self, scene: Scene) -> None:
        self.timing, motion = tabulate_valve_timing(scene), valve_motion_of(scene)
        self.events = [(event, *_kind_and_colour(event)) for event in self.timing.rows]
        self.has_piston = motion.stroke > 0
        self.steam_lap, self.exhaust_lap = (lap * MM_PER_M for lap in (motion.valve.steam_lap, motion.valve.exhaust_lap))
        self.angles = np.linspace(0.0, math.tau, _N_CRANK_ANGLES + 1)
        self.displacement = motion.valve.outward_sign * motion.displacements(self.angles) * MM_PER_M
        self.turn, self.stroke = motion.turn, motion.stroke * MM_PER_M

    @property
    def radius(self) -> float:
        """Radius of the valve circle, or half the travel, mm."""
        return self.circle.radius if self.circle else 0.5 * MM_PER_M * self.timing.travel

    @property
    def dimensions(self) -> str:
        """Line about the valve below the plate."""
        leads = " and ".join(f"{lead * MM_PER_M:.4g}" for lead in self.timing.leads)
        openings = " and ".join(f"{length * MM_PER_M:.4g} mm" if length > 0 else "none" for length in self.timing.largest_openings)
        return (
            f"travel of the valve {self.timing.travel * MM_PER_M:.4g} mm,  "
            f"laps $e$ = {self.steam_lap:.4g}, $i$ = {self.exhaust_lap:.4g} mm;  "
            f"leads {leads} mm,  largest openings for steam {openings}"
        )

    def draw_displacement_curves(self, panel: Panel, rotation: float = 0.0, **style: Any) -> None:
        """Draw the displacement of the mechanism (mm) on every ray, rotated by an angle (rad)."""
        for _, side, colour in CYLINDER_ENDS:
            length = np.where(side * self.displacement > 0, side * self.displacement, np.nan)
            panel.plot(*polar_points(self.angles + rotation, length), color=colour, **style)

    def label_events(self, panel: Panel, angles: Sequence[float], radius: float, style: EventLabelStyle) -> None:
        """Write the kinds of the events at angles (rad) outside a circle of a radius, shifted clear of each other and of the legend."""
        limits = np.array([*panel.get_xlim(), *panel.get_ylim()])
        scale = 72 / PLATE_DPI * min(panel.bbox.width / np.ptp(limits[:2]), panel.bbox.height / np.ptp(limits[2:]))
        left, right, bottom, top = scale * limits
        allowed_box = Bbox([[left - style.margins[0], bottom - style.margins[2]], [right + style.margins[1], top + style.margins[3]]])
        occupied = [Bbox.from_bounds(left, bottom, *style.legend_size)]
        for (_, kind, colour), angle in zip(self.events, angles, strict=True):
            outward = np.array([math.cos(angle), math.sin(angle)])
            offset = np.copysign(style.offset, outward)
            # The part of the label to the left of its position, or below it.
            x_part, y_part = np.where(outward > style.centred, 0.0, np.where(outward < -np.array(style.centred), 1.0, 0.5)).tolist()
            size = np.array([_LETTER_WIDTH_RATIO * style.size * len(kind), _LINE_HEIGHT_RATIO * style.size])
            box = Bbox.from_bounds(*(radius * scale * outward + offset - (x_part, y_part) * size), *size)
            shift = _find_free_shift(box, outward, occupied, allowed_box)
            occupied.append(box.translated(*shift))
            alignment = {"ha": _HORIZONTAL_ALIGNMENTS[x_part], "va": _VERTICAL_ALIGNMENTS[y_part]}
            panel.annotate_point(tuple(radius * outward), kind, tuple(offset + shift), **alignment, fontsize=style.size, color=colour)


_HORIZONTAL_ALIGNMENTS = {0.0: "left", 0.5: "center", 1.0: "right"}
_VERTICAL_ALIGNMENTS = {0.0: "bottom", 0.5: "center", 1.0: "top"}
"""Alignment of a label by the part of it to the left of its position, or below it."""


def _find_free_shift(box: Bbox, outward: FloatArray, occupied: Sequence[Bbox], allowed_box: Bbox) -> FloatArray:
    """Return the smallest shift (points) of a label without overlap, or none if no shift within the limits is free."""
    along = np.array([-outward[1], outward[0]])
    for steps_out, steps_along in _STEPS:
        shift: FloatArray = _SHIFT_STEP * (steps_out * outward + steps_along * along)
        moved = box.translated(*shift)
        inside = allowed_box.contains(*moved.min) and allowed_box.contains(*moved.max)
        if inside and not any(map(moved.overlaps, occupied)):
            return shift
    return np.zeros(2)


def _kind_and_colour(event: ValveEvent) -> tuple[str, str]:
    """Return the kind of a valve event, and the colour of its cylinder end."""
    end, kind = event.name.rsplit(" ", 1)
    return kind, next(colour for name, _, colour in CYLINDER_ENDS if name == end)


_EVENTS_CAPTION = {(0.605, 0.862): "Valve events of the mechanism"}
_STROKES_CAPTION = {(0.605, 0.36): "Fig. 2.  Steam phases over the stroke; grey: compression"}
_POLAR_POSITION = (0.03, 0.862)
_POLAR_RECT = (0.03, 0.07, 0.565, 0.785)
_STROKES_RECT = (0.645, 0.115, 0.287, 0.205)
"""Left and lower edge, width and height of the panels, in fractions of the figure."""

_TABLE_LEFT, _TABLE_RIGHT = 0.605, 0.965
"""Left and right edge of the table, in fractions of the figure."""
_ALL_COLUMN_POSITIONS = (0.742, 0.805, 0.866, 0.917, 0.965)
_OWN_COLUMN_POSITIONS = (0.79, 0.89)
"""Right edges of the columns of numbers with those of the theory, and without."""

_MAX_STATEMENT_LETTERS = 62
"""Number of letters of a sentence that fit into the width of the table."""

_STEAM_COLOURS = {BLUE: "#cfe4f1", VERMILLION: "#f8dcc6"}
"""Fill colours by the colours of the two ends."""

_RIM_RATIO = 1.22
_RIM_CLEARANCE_RATIO = 1.08
_HALF_HEIGHT_RATIO = 1.39
"""Radius of the crank circle over the eccentricity, its least ratio to the displacement; half height of the panel over the crank circle."""

_MIN_LABELLED_STROKE_PERCENT = 14.0
"""Smallest part of the stroke (percent) with a label."""

_STEAM_PHASES = (
    ("start", "cut-off", 0.8, "steam"),
    ("cut-off", "release", 0.8, "expansion"),
    ("release", "end", 0.8, "exhaust"),
    ("compression", "end", 0.0, "exhaust"),
    ("admission", "compression", 0.0, "compression"),
    ("start", "admission", 0.0, "steam"),
)
"""Events at the left and the right end of each phase on the stroke, its height in the diagram (outward above, return below), and name."""

_LABEL_STYLE = EventLabelStyle(size=10.5, offset=(3, 2), centred=(0.05, 0.55), margins=(0.0, 0.0, 8.0, 0.0), legend_size=(125.0, 78.0))

_MIN_LABEL_DISTANCE_DEG = 4.5
"""Smallest distance (deg) of an angle label from an event."""

_MIN_LABEL_HEIGHT_RATIO = 0.19
"""Smallest distance of the labels of the curves from the line of the dead centres, over the radius of the crank circle."""


_LAP_LABEL_ANGLES_DEG = (25, 50, 75, -25, -50, -75)
"""Angles of the letters of the laps from the line of centres, the best first: a letter keeps clear of the texts."""
_LETTER_PIXELS = 12
"""Half the width of such a letter with its halo, pixels."""


def draw_zeuner_plate(data: ValveDiagram) -> Plate:
    """Return Zeuner's plate for a valve."""
    curves = "circle by theory, bold curve by the mechanism" if data.circle else "curve by the mechanism"
    captions = {_POLAR_POSITION: f"Fig. 1.  Valve displacement on the crank ray: {curves}", **_EVENTS_CAPTION}
    plate = Plate(data.heading, data.timing.title, data.source, captions | (_STROKES_CAPTION if data.has_piston else {}))
    _draw_polar_diagram(plate.add_plate_panel(_POLAR_RECT), data)
    _write_event_table(plate, data)
    if data.has_piston:
        _draw_stroke_diagram(plate.add_plate_panel(_STROKES_RECT, "Stroke from the dead centre of each end [%]"), data)
    plate.write_dimensions(data.dimensions)
    return plate


def _draw_polar_diagram(panel: Panel, data: ValveDiagram) -> None:
    """Draw the polar diagram, in mm of the valve displacement, with the crank circle outside all curves."""
    rim_radius = max(_RIM_RATIO * data.radius, _RIM_CLEARANCE_RATIO * float(np.max(np.abs(data.displacement))))
    panel.show_region((0.0, 0.0), panel.aspect_ratio * _HALF_HEIGHT_RATIO * rim_radius)
    panel.set_aspect("equal")
    _draw_rim(panel, data, rim_radius)
    _draw_steam_areas(panel, data)
    for lap in (data.steam_lap, data.exhaust_lap):
        panel.add_patch(Circle((0, 0), abs(lap), fill=False, edgecolor=MUTED, linewidth=0.9, zorder=3))
    for event, _, colour in data.events:
        _draw_event_ray(panel, event, rim_radius, colour)
    data.label_events(panel, [event.simulated for event in data.timing.rows], 1.06 * rim_radius, _LABEL_STYLE)
    data.draw_displacement_curves(panel, linewidth=2.4, zorder=5, solid_capstyle="round")
    _label_diagram(panel, data, rim_radius)
    if data.circle:
        _draw_valve_circles(panel, data.circle)
        _draw_advance_angle(panel, rim_radius, data.circle.advance)
    _add_legend(panel, with_theory=data.circle is not None)


def _draw_rim(panel: Panel, data: ValveDiagram, rim_radius: float) -> None:
    """Draw the crank circle with a degree scale, and the axes."""
    panel.add_patch(Circle((0, 0), rim_radius, fill=False, edgecolor=INK, linewidth=1.1, zorder=3))
    panel.add_patch(Circle((0, 0), 1.025 * rim_radius, fill=False, edgecolor=MUTED, linewidth=0.5, zorder=3))
    event_angles = [math.degrees(event.simulated) for event in data.timing.rows]
    degrees = np.arange(0, 360, 2)
    lengths = rim_radius * np.stack([np.ones(len(degrees)), np.where(degrees % 10, 1.025, 1.045)])
    ticks = list(np.stack(polar_points(np.radians(degrees), lengths)).T)
    panel.add_collection(LineCollection(ticks, colors=MUTED, linewidths=0.5, capstyle="projecting", zorder=3), autolim=False)
    for degree in range(0, 360, 30):
        if all(abs(math.remainder(degree - other, 360)) >= _MIN_LABEL_DISTANCE_DEG for other in event_angles):
            position = polar_points(math.radians(degree), 1.08 * rim_radius)
            panel.annotate_point(position, f"{degree}°", ha="center", va="center", fontsize=8.5, color=MUTED)
    for ends in (((-rim_radius, rim_radius), (0, 0)), ((0, 0), (-rim_radius, rim_radius))):
        panel.plot(*ends, color=MUTED, linewidth=0.7, linestyle=CHAIN_DOTTED, zorder=1)


def _draw_steam_areas(panel: Panel, data: ValveDiagram) -> None:
    """Draw the admission areas between the circle of the outside lap and the valve curve."""
    lap = max(data.steam_lap, 0.0)
    for _, side, colour in CYLINDER_ENDS:
        length = side * data.displacement
        is_open = length > lap
        angles, lengths = data.angles[is_open], length[is_open]
        # Start at the first open angle, because the opening of the crank end includes the dead centre.
        gaps = np.flatnonzero(np.diff(angles) > 1.5 * math.tau / (len(data.angles) - 1))
        first = int(gaps[0]) + 1 if len(gaps) else 0
        angles, lengths = np.roll(angles, -first), np.roll(lengths, -first)
        edge = polar_points(np.append(angles, angles[::-1]), np.append(lengths, np.full(len(angles), lap)))
        panel.fill(*edge, color=_STEAM_COLOURS[colour], linewidth=0, zorder=0.5)


def _draw_valve_circles(panel: Panel, circle: ValveCircle) -> None:
    """Draw the two theoretical valve circles and their line of centres."""
    r, advance = circle
    x, y = math.sin(advance) * r / 2, math.cos(advance) * r / 2
    for sign in (1, -1):
        panel.add_patch(Circle((sign * x, sign * y), r / 2, fill=False, edgecolor=INK, linewidth=0.9, zorder=4))
        panel.plot(sign * x, sign * y, "o", color=INK, markersize=3, zorder=5)
    panel.plot([-2.3 * x, 2.3 * x], [-2.3 * y, 2.3 * y], color=MUTED, linewidth=0.7, linestyle=DASHED, zorder=2)


def _draw_event_ray(panel: Panel, event: ValveEvent, rim_radius: float, colour: str) -> None:
    """Draw the crank at an event, solid for the mechanism and dashed for the theory."""
    theory = [(event.theory, 0.6, INK, DASHED)] if event.has_theory else []
    for angle, width, line_colour, style in ((event.simulated, 1.1, colour, "-"), *theory):
        panel.plot(*polar_points(angle, [0, rim_radius]), linewidth=width, color=line_colour, linestyle=style, zorder=3.5)
    panel.plot(
        *polar_points(event.simulated, rim_radius), END_MARKERS[colour], color=colour, markeredgecolor=PAPER, markersize=6.5, zorder=6
    )


def _label_diagram(panel: Panel, data: ValveDiagram, rim_radius: float) -> None:
    """Label the curves, circles and dead centres."""
    r = data.radius
    line_of_centres_angle = math.pi / 2 - data.circle.advance if data.circle else _open_angle(data)
    text_style: dict[str, Any] = {"ha": "center", "va": "center", "fontstyle": "italic", "linespacing": 1.4}
    texts: list[Annotation] = []
    for end, side, _ in CYLINDER_ENDS:
        text = f"steam to the {end}\n$\\xi \\leq$ {float(np.max(side * data.displacement)):.1f} mm"
        x, y = polar_points(line_of_centres_angle, side * 0.62 * r)
        if abs(y) < _MIN_LABEL_HEIGHT_RATIO * rim_radius:  # beside the names of the dead centres
            y = side * _MIN_LABEL_HEIGHT_RATIO * rim_radius
        texts.append(panel.annotate_point((x, y), text, **text_style))
    for lap, text in ((data.steam_lap, "$e$"), (data.exhaust_lap, "$i$")):
        if lap:
            offset = (0, -8) if abs(lap) > 0.15 * r else (5, 7)
            angles = (line_of_centres_angle + math.radians(degrees) for degrees in _LAP_LABEL_ANGLES_DEG)
            places = [polar_points(angle, abs(lap)) for angle in angles]
            position = next((place for place in places if not _is_under(panel, place, offset, texts)), places[0])
            panel.annotate_point(position, text, offset, ha="center", va="center", color=MUTED, fontsize=11)
    for side, end, height, ha, va in ((1, "crank end", 4, "right", "bottom"), (-1, "head end", -5, "left", "top")):
        note_style = {"ha": ha, "va": va, "fontsize": 8.5, "color": MUTED, "fontstyle": "italic"}
        panel.annotate_point((side * 0.985 * rim_radius, 0), f"dead centre, {end}", (0, height), **note_style)


def _is_under(panel: Panel, place: AxesPoint, offset: tuple[float, float], texts: Sequence[Annotation]) -> bool:
    """Return whether a letter at an offset (points) from a place would lie under one of some texts."""
    x, y = panel.transData.transform(place) + np.multiply(offset, PLATE_DPI / 72)
    return any(text.get_window_extent().padded(_LETTER_PIXELS).contains(x, y) for text in texts)


def _open_angle(data: ValveDiagram) -> float:
    """Return the crank angle at which the crank end's steam port is open farthest, rad."""
    return float(data.angles[np.argmax(data.displacement)])


def _draw_advance_angle(panel: Panel, rim_radius: float, advance: float) -> None:
    """Draw the angle of advance at the rim."""
    low, high = sorted((math.pi / 2 - advance, math.pi / 2))
    arc = Arc((0, 0), 1.84 * rim_radius, 1.84 * rim_radius, theta1=math.degrees(low), theta2=math.degrees(high))
    arc.set(color=MUTED, linewidth=0.8, zorder=3)
    panel.add_patch(arc)
    middle = polar_points(math.pi / 2 - advance / 2, 0.92 * rim_radius)
    panel.annotate_point(middle, "$\\delta$", color=MUTED, ha="center", va="center", fontsize=12)


def _add_legend(panel: Panel, *, with_theory: bool) -> None:
    """Add the legend of mechanism and theory in the corner."""
    entries: dict[str, dict[str, Any]] = {
        "displacement": {"color": BLUE, "linewidth": 2.4},
        r"$r\,\sin(\omega+\delta)$, theory": {"color": INK, "linewidth": 0.9},
        **{f"event, {end}": {"color": colour, "linewidth": 1.1, "marker": END_MARKERS[colour]} for end, _, colour in CYLINDER_ENDS},
        "event, theory": {"color": INK, "linewidth": 0.6, "linestyle": DASHED},
    }
    handles = [Line2D([], [], label=label, **style) for label, style in entries.items() if with_theory or "theory" not in label]
    letters = ["$e$  steam lap", "$i$  exhaust lap", *(["$\\delta$  angle of advance"] if with_theory else [])]
    corner = panel.get_xlim()[1], panel.get_ylim()[0]
    panel.annotate_point(corner, "\n".join(letters), (-88, 3), va="bottom", color=MUTED, fontsize=9.5, linespacing=1.6)
    text_style = {"fontfamily": SERIF_FONT, "fontsize": 9.5, "math_fontfamily": "stix", "color": MUTED}
    add_legend(panel, text_style, handles=handles, loc="lower left", bbox_to_anchor=(-0.005, -0.01), handlelength=2.4)


def _draw_stroke_diagram(panel: Panel, data: ValveDiagram) -> None:
    """Draw the phases of the steam at each end, as the piston goes out and back, over the stroke."""
    panel.set(xlim=(0, 100), ylim=(-0.2, 3.75))
    panel.spines["left"].set_visible(False)
    panel.tick_params(left=False, labelleft=False)
    for (end, _, colour), base in zip(CYLINDER_ENDS, (2.0, 0.0), strict=True):
        events_by_name = {kind: row for row, kind, _ in data.events if row.name.startswith(end)}
        stroke_percent = {"start": 0.0, "end": 100.0, **{name: 100 * row.simulated_stroke for name, row in events_by_name.items()}}
        for left_event, right_event, height, phase in _STEAM_PHASES:
            if not {left_event, right_event} <= stroke_percent.keys():
                continue  # of a port that does not open once in a turn
            left = stroke_percent[left_event]
            right = stroke_percent[right_event]
            floor = base + height
            fill_colour = {"steam": _STEAM_COLOURS[colour], "compression": RULE}.get(phase, PAPER)
            panel.add_patch(Rectangle((left, floor), right - left, 0.7, facecolor=fill_colour, edgecolor=colour, linewidth=1.0, zorder=2))
            if right - left > _MIN_LABELLED_STROKE_PERCENT:
                panel.annotate_point(((left + right) / 2, floor + 0.35), phase, ha="center", va="center", fontsize=9.5)
        for name, row in events_by_name.items():
            floor = base + (0.8 if name in ("cut-off", "release") else 0.0)
            if row.has_theory:
                panel.plot([100 * row.theory_stroke] * 2, [floor, floor + 0.7], color=INK, linewidth=1.0, linestyle=DASHED)
        label_style = {"ha": "right", "va": "center", "color": colour, "linespacing": 1.3}
        panel.annotate_point((0, base + 0.75), end.replace(" ", "\n"), (-7, 0), **label_style)
        for text, height in (("out", 1.15), ("back", 0.35)):
            panel.annotate_point((100, base + height), text, (5, 0), va="center", color=MUTED, fontsize=9.5)


def _write_event_table(plate: Plate, data: ValveDiagram) -> None:
    """Write the table of valve events by cylinder end, and a sentence on each port that does not open once in a turn."""
    top, row_height = 0.862, 0.036
    headings = {"crank": "deg", "theory": "deg", "shift": "deg", "stroke": "%", "theory ": "%"}
    if data.circle is None:
        headings = {"crank": "deg", "stroke": "%"} if data.has_piston else {"crank": "deg"}
    positions = _ALL_COLUMN_POSITIONS if data.circle else _OWN_COLUMN_POSITIONS
    for x, (heading, unit) in zip(positions, headings.items(), strict=False):
        plate.write_text(x, top - 0.036, heading.strip(), 10.5, ha="right", color=MUTED)
        plate.write_text(x, top - 0.056, unit, 8.5, ha="right", color=MUTED)
    y = top - 0.09
    for end, _, colour in CYLINDER_ENDS:
        plate.write_text(_TABLE_LEFT, y, end, 11, color=colour, fontstyle="italic")
        for event, kind, _ in data.events:
            if event.name.startswith(end):
                y -= row_height
                plate.write_text(_TABLE_LEFT + 0.012, y, kind, 11.5, color=colour)
                _write_event_numbers(plate, y, event)
        y -= row_height + 0.008
    for rule in (top - 0.064, y + row_height - 0.006):
        plate.add_artist(Line2D([_TABLE_LEFT, _TABLE_RIGHT], [rule, rule], color=RULE, linewidth=1.0))
    for statement in data.timing.statements:
        for line in textwrap.wrap(statement, _MAX_STATEMENT_LETTERS):
            plate.write_text(_TABLE_LEFT, y, line, 10, color=MUTED)
            y -= 0.7 * row_height


def _write_event_numbers(plate: Plate, y: float, event: ValveEvent) -> None:
    """Write the crank angle and the stroke of an event, with those of the theory between and beside them if there is one."""
    angle = f"{math.degrees(event.simulated):.2f}"
    stroke = f"{100 * event.simulated_stroke:.1f}" if event.has_stroke else ""
    if not event.has_theory:
        for x, number in zip(_OWN_COLUMN_POSITIONS, (angle, stroke), strict=True):
            plate.write_text(x, y, number, 11.5, ha="right")
        return
    shift = f"{math.degrees(event.shift):+.2f}".replace("-", "−")
    numbers = (angle, f"{math.degrees(event.theory):.2f}", shift, stroke, f"{100 * event.theory_stroke:.1f}")
    for k, (x, number) in enumerate(zip(_ALL_COLUMN_POSITIONS, numbers, strict=True)):
        plate.write_text(x, y, number, 11.5, ha="right", color=MUTED if k in (1, 4) else INK)

"""Data of the plates of valves, and what they draw alike: the valve events and the displacement on the crank rays."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.transforms import Bbox

from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_motion import valve_motion_of
from governor_mechanism.render.figures.page import MM_PER_M, PLATE_DPI, Panel, polar_points
from governor_mechanism.render.style import BLUE, VERMILLION
from governor_mechanism.studies.valve_timing import ValveEvent, tabulate_valve_timing
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


_HORIZONTAL_ALIGNMENTS, _VERTICAL_ALIGNMENTS = {0.0: "left", 0.5: "center", 1.0: "right"}, {0.0: "bottom", 0.5: "center", 1.0: "top"}
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

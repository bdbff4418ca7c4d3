"""Data of the slide-valve plates, and what both plates draw: the valve events and the displacement on the crank rays."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import evaluate_at_crank_angles
from governor_mechanism.render.figures.engraving_sheet import MM_PER_M, PLATE_DPI, Plate, PlatePanel, polar_points
from governor_mechanism.render.figures.label_placement import LabelBox, TextLabel
from governor_mechanism.render.style import BLUE, VERMILLION
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvent, ValveTiming, tabulate_valve_timing
from governor_mechanism.types import FloatArray

_SOURCE = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"

CYLINDER_ENDS = (("crank end", 1.0, BLUE), ("head end", -1.0, VERMILLION))
"""Name of each end, sign of the valve displacement that admits steam to it, and colour."""

_N_CRANK_ANGLES = 720
"""Number of crank-angle intervals in a turn."""


@dataclass(frozen=True, kw_only=True)
class EventLabelStyle:
    """Font size and offset (points) of event labels; those with |cos| and |sin| of their angle below `centred` are centred.

    Labels may extend beyond the left, right, lower and upper limit of the panel by `margins` (points). `legend_size` (points) is that of
    the legend in the lower left corner.
    """

    size: float
    offset: tuple[float, float]
    centred: tuple[float, float]
    margins: LabelBox
    legend_size: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class ValveDiagram:
    """Slide valve over a closed turn, lengths in mm: angles (n,) (rad) from the dead centre at the crank end.

    `displacement` (n,) (mm) is that of the mechanism, `theoretical_displacement` (n,) (mm) that of Zeuner's law. `piston_travel` (n,) is
    the travel of the piston from the crank end as a fraction of the stroke, `theoretical_piston_travel` (n,) that for an infinite
    connecting rod. `timing` is in SI.
    """

    eccentric: closed.Eccentric
    crank_train: CrankTrain
    outside_lap: float
    inside_lap: float
    angles: FloatArray
    displacement: FloatArray
    theoretical_displacement: FloatArray
    piston_travel: FloatArray
    theoretical_piston_travel: FloatArray
    timing: ValveTiming

    @classmethod
    def from_scene(cls, scene: Scene) -> ValveDiagram:
        """Return the data for the scene of a slide valve; raise MechanismError for another machine."""
        timing = tabulate_valve_timing(scene)
        lengths = {name: value * MM_PER_M for name, value in scene.part.dimensions.items()}
        eccentric = closed.Eccentric.from_dimensions({**lengths, "advance": scene.part.dimensions["advance"]})
        crank_train = CrankTrain.from_dimensions(lengths)
        angles = np.linspace(0.0, math.tau, _N_CRANK_ANGLES + 1)
        readings = evaluate_at_crank_angles(scene, angles).readings
        endless = replace(crank_train, rod=math.inf)
        outer_travel = np.asarray(travel_from_outer_dead_centre(endless, crank_angle=angles + math.pi))
        return cls(
            eccentric=eccentric,
            crank_train=crank_train,
            outside_lap=lengths["outside_lap"],
            inside_lap=lengths["inside_lap"],
            angles=angles,
            displacement=readings["valve_displacement"] * MM_PER_M,
            theoretical_displacement=np.asarray(closed.first_order_displacement(eccentric, crank_angle=angles)),
            piston_travel=readings["crank_end_travel"] * MM_PER_M / (2 * crank_train.crank),
            theoretical_piston_travel=1 - outer_travel / (2 * crank_train.crank),
            timing=timing,
        )

    def new_plate(self, heading: str, captions: Mapping[tuple[float, float], str]) -> Plate:
        """Return a plate without panels, with captions by their positions."""
        return Plate(heading, self.timing.title, _SOURCE, captions)

    def draw_displacement_curves(self, panel: PlatePanel, rotation: float = 0.0, **style: Any) -> None:
        """Draw the displacement of the mechanism (mm) on every ray, rotated by an angle (rad)."""
        for _, side, colour in CYLINDER_ENDS:
            length = np.where(side * self.displacement > 0, side * self.displacement, np.nan)
            panel.plot(*polar_points(self.angles + rotation, length), color=colour, **style)

    def label_events(self, panel: PlatePanel, angles: Sequence[float], radius: float, style: EventLabelStyle) -> None:
        """Write the kinds of the events at angles (rad) outside a circle of a radius, shifted clear of each other and of the legend."""
        limits = np.array([*panel.get_xlim(), *panel.get_ylim()])
        scale = 72 / PLATE_DPI * min(panel.bbox.width / np.ptp(limits[:2]), panel.bbox.height / np.ptp(limits[2:]))
        left, right, bottom, top = (float(limit) for limit in scale * limits)
        allowed_box = left - style.margins[0], right + style.margins[1], bottom - style.margins[2], top + style.margins[3]
        occupied = [(left, left + style.legend_size[0], bottom, bottom + style.legend_size[1])]
        for event, angle in zip(self.timing.rows, angles, strict=True):
            x, y = math.cos(angle), math.sin(angle)
            dx, dy = math.copysign(style.offset[0], x), math.copysign(style.offset[1], y)
            kind, colour = event_kind_and_colour(event)
            label = TextLabel(
                text=kind,
                size=style.size,
                position=(radius * scale * x + dx, radius * scale * y + dy),
                ha="left" if x > style.centred[0] else "right" if x < -style.centred[0] else "center",
                va="bottom" if y > style.centred[1] else "top" if y < -style.centred[1] else "center",
                outward_direction=(x, y),
            )
            shift = label.find_free_shift(occupied, allowed_box)
            occupied.append(label.bounding_box(shift))
            text_style = {"ha": label.ha, "va": label.va, "fontsize": style.size, "color": colour}
            panel.annotate_point((radius * x, radius * y), kind, (dx + shift[0], dy + shift[1]), **text_style)


def event_kind_and_colour(event: ValveEvent) -> tuple[str, str]:
    """Return the kind of a valve event, and the colour of its cylinder end."""
    end, kind = event.name.rsplit(" ", 1)
    return kind, next(colour for name, _, colour in CYLINDER_ENDS if name == end)

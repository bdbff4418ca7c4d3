"""Timing of a slide valve: by the mechanism, in closed form, and by Zeuner's law alone."""

import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.files.plain_values import plain_record
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import CYLINDER_ENDS, evaluate_at_crank_angles, find_event_angles, prescribed_centre
from governor_mechanism.units.text_table import format_table


@dataclass(frozen=True)
class ValveEvent:
    """One valve event: crank angle (rad, 0 to 2 pi) and stroke, the fraction of its end's piston stroke.

    Attributes
    ----------
    name
        Name of the event.
    simulated
        Crank angle by the mechanism, rad.
    exact
        Crank angle by the closed form, rad.
    theory
        Crank angle by Zeuner's law with infinitely long rods, rad.
    simulated_stroke
        Stroke by the mechanism.
    exact_stroke
        Stroke by the closed form.
    theory_stroke
        Stroke by Zeuner's law.
    """

    name: str
    simulated: float
    exact: float
    theory: float
    simulated_stroke: float
    exact_stroke: float
    theory_stroke: float

    @property
    def shift(self) -> float:
        """Delay against the theory (rad)."""
        return math.remainder(self.simulated - self.theory, math.tau)

    @property
    def cells(self) -> tuple[str, ...]:
        """The event as a row of a table: its angles and its shift in deg, and its strokes."""
        angles = (f"{math.degrees(angle):.6f}" for angle in (self.simulated, self.exact, self.theory))
        strokes = (f"{stroke:.6f}" for stroke in (self.simulated_stroke, self.exact_stroke, self.theory_stroke))
        return self.name, *angles, f"{math.degrees(self.shift):+.6f}", *strokes


@dataclass(frozen=True, kw_only=True)
class ValveTiming:
    """The eight events of a slide valve, crank end first.

    Attributes
    ----------
    title
        Title of the scene.
    rows
        The events.
    leads
        Lead of crank end and head end, m.
    centre
        Centre of the swing, m.
    """

    title: str
    rows: tuple[ValveEvent, ...]
    leads: tuple[float, float]
    centre: float

    def __str__(self) -> str:
        """Return the timing as a table."""
        header = ("event", "simulated", "exact", "theory", "shift", "stroke", "exact", "theory")
        footer = "crank angles and shift in deg from the crank end's dead centre; strokes as fractions, from the event's own end"
        lead = ", ".join(f"{1e3 * lead_value:.6g} mm at the {end}" for lead_value, end in zip(self.leads, CYLINDER_ENDS, strict=True))
        return "\n".join([self.title, format_table(header, [row.cells for row in self.rows], "lr"), footer, f"lead {lead}"])

    def as_json(self) -> dict[str, Any]:
        """Return the timing as plain values in SI."""
        return plain_record(self, "rows", events=[plain_record(row, shift=row.shift) for row in self.rows])


def tabulate_valve_timing(scene: Scene) -> ValveTiming:
    """Return the valve events of a slide valve scene, to about 1e-13 rad.

    It raises MechanismError for another machine.

    Parameters
    ----------
    scene
        A scene of a slide valve.

    Returns
    -------
    ValveTiming
        The eight events.
    """
    simulated_angles = find_event_angles(scene)
    dimensions = scene.part.dimensions
    eccentric, train = Eccentric.from_dimensions(dimensions), CrankTrain.from_dimensions(dimensions)
    readings = evaluate_at_crank_angles(scene, np.array(list(simulated_angles.values()))).readings
    ideal_eccentric, ideal_train = replace(eccentric, rod=math.inf), replace(train, rod=math.inf)
    centre, rows = prescribed_centre(scene), []
    for k, (name, angle) in enumerate(simulated_angles.items()):
        closed_form_angle = partial(event_angle, event=name, outside_lap=dimensions["outside_lap"], inside_lap=dimensions["inside_lap"])
        exact, theory = closed_form_angle(eccentric, centre=centre), closed_form_angle(ideal_eccentric)
        end = name.rsplit(" ", 1)[0]
        simulated_stroke = float(readings[f"{end.replace(' ', '_')}_travel"][k]) / (2 * train.crank)
        strokes = (simulated_stroke, stroke_fraction(train, exact, end), stroke_fraction(ideal_train, theory, end))
        rows.append(ValveEvent(name, angle, exact, theory, *strokes))
    dead_centre_readings = evaluate_at_crank_angles(scene, np.array([0.0, math.pi])).readings
    leads = (float(dead_centre_readings["crank_end_steam"][0]), float(dead_centre_readings["head_end_steam"][1]))
    return ValveTiming(title=scene.title, rows=tuple(rows), leads=leads, centre=dimensions["centre"])


def stroke_fraction(train: CrankTrain, angle: float, end: str) -> float:
    """Return the fraction of the stroke at a crank angle (rad), measured from one of the cylinder ends."""
    # The closed form counts from the outer dead centre, half a revolution later.
    fraction = float(travel_from_outer_dead_centre(train, crank_angle=angle + math.pi)) / (2 * train.crank)
    return fraction if end == "head end" else 1.0 - fraction

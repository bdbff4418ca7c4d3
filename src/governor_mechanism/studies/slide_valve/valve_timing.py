"""The events of a slide valve in a table: as the mechanism has them, in closed form, and by Zeuner's law alone."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from governor_mechanism.closed_form.slide_valve import Eccentric, event_angle
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_end
from governor_mechanism.machines.slide_valve import EQUAL_LEADS
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import ENDS, at_angles, event_angles, setting_of


@dataclass(frozen=True, kw_only=True)
class ValveEvent:
    """One event: crank angle (rad, 0 to 2 pi) and stroke, the part of its own end's stroke that the piston has gone.

    simulated is the mechanism's, exact the closed form's, theory Zeuner's law with endless rods.
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
        """By how much it comes later than in theory (rad)."""
        return math.remainder(self.simulated - self.theory, math.tau)


@dataclass(frozen=True, kw_only=True)
class ValveEvents:
    """All eight, crank end first; leads (m) of crank end and head end, and the centre of the swing (m)."""

    title: str
    rows: tuple[ValveEvent, ...]
    leads: tuple[float, float]
    centre: float

    def __str__(self) -> str:
        header = ("event", "simulated", "exact", "theory", "shift", "stroke", "exact", "theory")
        cells = [
            (
                row.name,
                *(f"{math.degrees(angle):.6f}" for angle in (row.simulated, row.exact, row.theory)),
                f"{math.degrees(row.shift):+.6f}",
                *(f"{stroke:.6f}" for stroke in (row.simulated_stroke, row.exact_stroke, row.theory_stroke)),
            )
            for row in self.rows
        ]
        widths = [max(len(line[k]) for line in (header, *cells)) for k in range(len(header))]
        lines = [
            "  ".join(
                f"{cell:<{w}}" if k == 0 else f"{cell:>{w}}"
                for k, (cell, w) in enumerate(zip(line, widths, strict=True))
            )
            for line in (header, *cells)
        ]
        told = (
            "crank angles and shift in deg from the crank end's dead centre; strokes as parts, from the event's own end"
        )
        lead = ", ".join(f"{1e3 * one:.6g} mm at the {end}" for one, end in zip(self.leads, ENDS, strict=True))
        return "\n".join([self.title, *lines, told, f"lead {lead}"])

    def as_json(self) -> dict[str, Any]:
        """The same as plain values in SI."""
        rows = [{**vars(row), "shift": row.shift} for row in self.rows]
        return {"title": self.title, "events": rows, "leads": list(self.leads), "centre": self.centre}


def valve_events(scene: Scene) -> ValveEvents:
    """The events of a slide valve's scene, to about 1e-13 rad. Raises MechanismError for another machine."""
    found = event_angles(scene)
    sizes = scene.part.dimensions
    eccentric, train = Eccentric.of(sizes), CrankTrain.of(sizes)
    centre = centre_of(scene)
    angles = np.array(list(found.values()))
    moving = at_angles(scene, angles)
    endless = CrankTrain(crank=train.crank, rod=math.inf)
    rows = []
    for k, (name, angle) in enumerate(found.items()):
        by_law = partial(
            event_angle, eccentric, event=name, outside_lap=sizes["outside_lap"], inside_lap=sizes["inside_lap"]
        )
        exact, theory = by_law(centre=centre), by_law(law="theory")
        end = name.rsplit(" ", 1)[0]
        way = float(moving.readings[f"{end.replace(' ', '_')}_travel"][k])
        rows.append(
            ValveEvent(
                name=name,
                simulated=angle,
                exact=exact,
                theory=theory,
                simulated_stroke=way / (2 * train.crank),
                exact_stroke=stroke_at(train, exact, end),
                theory_stroke=stroke_at(endless, theory, end),
            )
        )
    dead = at_angles(scene, np.array([0.0, math.pi])).readings
    return ValveEvents(
        title=scene.title,
        rows=tuple(rows),
        leads=(float(dead["crank_end_steam"][0]), float(dead["head_end_steam"][1])),
        centre=sizes["centre"],
    )


def centre_of(scene: Scene) -> float | None:
    """The centre of the swing (m) for the closed forms; None, their own, where the leads are set equal by the file."""
    return None if setting_of(scene) == EQUAL_LEADS else scene.part.dimensions["centre"]


def stroke_at(train: CrankTrain, angle: float, end: str) -> float:
    """The part of the stroke gone at a crank angle (rad), counted from one of ENDS."""
    # The closed form counts from the outer dead centre, half a turn on.
    gone = float(travel_from_outer_end(train, crank_angle=angle + math.pi)) / (2 * train.crank)
    return gone if end == "head end" else 1.0 - gone

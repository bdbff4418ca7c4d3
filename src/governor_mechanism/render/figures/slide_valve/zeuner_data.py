"""What the plates of a slide valve show, in numbers: the mechanism over a turn, the theory, the events."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_end
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import at_angles, setting_of
from governor_mechanism.studies.slide_valve.valve_timing import ValveEvents, valve_events
from governor_mechanism.types import FloatArray

STEPS = 720
"""Crank angles in a turn of the mechanism."""


@dataclass(frozen=True, kw_only=True)
class ValvePlate:
    """A slide valve over a turn: angles (n,) rad from the crank end's dead centre, once round and closed.

    displacement (n,) m is the mechanism's and theory (n,) m that of Zeuner's law; piston (n,) the part of the stroke
    that the piston has gone from the crank end, and piston_theory (n,) with an endless connecting rod.
    """

    title: str
    setting: str
    eccentric: closed.Eccentric
    train: CrankTrain
    outside_lap: float
    inside_lap: float
    angles: FloatArray
    displacement: FloatArray
    theory: FloatArray
    piston: FloatArray
    piston_theory: FloatArray
    events: ValveEvents

    @property
    def ratio(self) -> float:
        """l : r."""
        return self.eccentric.rod / self.eccentric.radius


def valve_plate(scene: Scene) -> ValvePlate:
    """The numbers for a slide valve's scene. Raises MechanismError for another machine."""
    events = valve_events(scene)
    sizes = scene.part.dimensions
    eccentric, train = closed.Eccentric.of(sizes), CrankTrain.of(sizes)
    angles = np.linspace(0.0, math.tau, STEPS + 1)
    moving = at_angles(scene, angles).readings
    endless = CrankTrain(crank=train.crank, rod=math.inf)
    return ValvePlate(
        title=scene.title,
        setting=setting_of(scene),
        eccentric=eccentric,
        train=train,
        outside_lap=sizes["outside_lap"],
        inside_lap=sizes["inside_lap"],
        angles=angles,
        displacement=moving["valve_displacement"],
        theory=np.asarray(closed.first_order(eccentric, crank_angle=angles)),
        piston=moving["crank_end_travel"] / (2 * train.crank),
        piston_theory=1 - np.asarray(travel_from_outer_end(endless, crank_angle=angles + math.pi)) / (2 * train.crank),
        events=events,
    )

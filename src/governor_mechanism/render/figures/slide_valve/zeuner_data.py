"""Data of the slide-valve plates: the mechanism over a turn, the theory, the valve events."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.valve_timing import evaluate_at_crank_angles
from governor_mechanism.studies.slide_valve.valve_timing import ValveTiming, tabulate_valve_timing
from governor_mechanism.types import FloatArray

_N_CRANK_ANGLES = 720
"""Number of crank-angle intervals in a turn."""


@dataclass(frozen=True, kw_only=True)
class ValveDiagramData:
    """Slide valve over a closed turn: angles (n,) (rad) from the dead centre at the crank end.

    `displacement` (n,) (m) is that of the mechanism, `theoretical_displacement` (n,) (m) that of Zeuner's law. `piston_travel` (n,) is
    the travel of the piston from the crank end as a fraction of the stroke, `theoretical_piston_travel` (n,) that for an infinite
    connecting rod.
    """

    title: str
    eccentric: closed.Eccentric
    crank_train: CrankTrain
    outside_lap: float
    inside_lap: float
    angles: FloatArray
    displacement: FloatArray
    theoretical_displacement: FloatArray
    piston_travel: FloatArray
    theoretical_piston_travel: FloatArray
    events: ValveTiming


def valve_diagram_data(scene: Scene) -> ValveDiagramData:
    """Return the data for the scene of a slide valve; raise MechanismError for another machine."""
    events = tabulate_valve_timing(scene)
    dimensions = scene.part.dimensions
    eccentric, crank_train = closed.Eccentric.from_dimensions(dimensions), CrankTrain.from_dimensions(dimensions)
    angles = np.linspace(0.0, math.tau, _N_CRANK_ANGLES + 1)
    readings = evaluate_at_crank_angles(scene, angles).readings
    endless = CrankTrain(crank=crank_train.crank, rod=math.inf)
    return ValveDiagramData(
        title=scene.title,
        eccentric=eccentric,
        crank_train=crank_train,
        outside_lap=dimensions["outside_lap"],
        inside_lap=dimensions["inside_lap"],
        angles=angles,
        displacement=readings["valve_displacement"],
        theoretical_displacement=np.asarray(closed.first_order_displacement(eccentric, crank_angle=angles)),
        piston_travel=readings["crank_end_travel"] / (2 * crank_train.crank),
        theoretical_piston_travel=1
        - np.asarray(travel_from_outer_dead_centre(endless, crank_angle=angles + math.pi)) / (2 * crank_train.crank),
        events=events,
    )

"""Data of the plates of slide valves that an eccentric drives: the mechanism, and the theory with infinitely long rods."""

import math
from dataclasses import replace

import numpy as np

from governor_mechanism.closed_form import slide_valve as closed
from governor_mechanism.closed_form.slider_crank import CrankTrain, travel_from_outer_dead_centre
from governor_mechanism.machines.steam_readings import CRANK_END_TRAVEL
from governor_mechanism.model.scene import Scene
from governor_mechanism.render.figures.page import MM_PER_M
from governor_mechanism.render.figures.valve_timing.valve_diagram import ValveCircle, ValveDiagram


class EccentricDiagram(ValveDiagram):
    """Slide valve of a scene over a closed turn, lengths in mm.

    `theoretical_displacement` (n,) (mm) is that of Zeuner's law. `piston_travel` (n,) is the travel of the piston from the crank end as a
    fraction of the stroke, `theoretical_piston_travel` (n,) that for an infinite connecting rod.
    """

    heading = "Zeuner’s diagram of the slide valve"
    source = "after Müller-Melchiors on W. D. Marks, Dinglers Polytechnisches Journal 241 (1881), p. 161"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        lengths = {name: value * MM_PER_M for name, value in scene.part.dimensions.items()}
        self.eccentric = closed.Eccentric.from_dimensions({**lengths, "advance": scene.part.dimensions["advance"]})
        self.circle = ValveCircle(self.eccentric.radius, self.eccentric.advance)
        self.crank_train = CrankTrain.from_dimensions(lengths)
        self.theoretical_displacement = np.asarray(closed.first_order_displacement(self.eccentric, crank_angle=self.angles))
        self.piston_travel = self.turn[CRANK_END_TRAVEL](self.angles) * MM_PER_M / self.stroke
        endless = replace(self.crank_train, rod=math.inf)
        outer_travel = np.asarray(travel_from_outer_dead_centre(endless, crank_angle=self.angles + math.pi))
        self.theoretical_piston_travel = 1 - outer_travel / self.stroke

    @property
    def dimensions(self) -> str:
        """Line about the valve gear below the plate."""
        eccentric, crank_train = self.eccentric, self.crank_train
        rods = {name: "∞" if math.isinf(rod) else f"{rod:.5g} mm" for name, rod in (("l", eccentric.rod), ("L", crank_train.rod))}
        leads = " and ".join(f"{lead * MM_PER_M:.4g}" for lead in self.timing.leads)
        advance = f"{math.degrees(eccentric.advance):.4g}°"
        return (
            f"eccentric $r$ = {eccentric.radius:.4g} mm,  rod $l$ = {rods['l']},  advance $\\delta$ = {advance},  "
            f"laps $e$ = {self.steam_lap:.4g}, $i$ = {self.exhaust_lap:.4g} mm,  "
            f"crank $R$ = {crank_train.crank:.4g} mm,  rod $L$ = {rods['L']};  leads {leads} mm"
        )

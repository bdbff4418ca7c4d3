"""Proportions of the drawing of a slide valve, and the position of the valve gear at a pose. The shaft is at the right."""

import math
from abc import ABC

from governor_mechanism.machines.driven_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.render.geometry.attached import Moment, once_per_moment
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.render.machines.slide_valve.steam_distribution import ValveGearPosition
from governor_mechanism.types import FloatArray

_MAX_DRAWN_ROD, _MAX_DRAWN_ECCENTRIC_ROD = 5.5, 3.2
"""Largest drawn lengths of connecting and eccentric rod, in crank radii; longer and infinite rods are shortened."""


class ValveGearProportions(MachineDrawing, ABC):
    """Dimensions (m); laps have a sign. Both rods may be infinite. `centre` is the centre of the valve travel."""

    crank = Dimension("crank")
    connecting_rod = Dimension("connecting_rod")
    eccentric = Dimension("eccentric")
    eccentric_rod = Dimension("eccentric_rod")
    advance = Dimension("advance")
    outside_lap = Dimension("outside_lap")
    inside_lap = Dimension("inside_lap")
    centre = Dimension("centre")
    outward_sign = 1.0

    @property
    def drawn_rod(self) -> float:
        """Drawn length of the connecting rod (m)."""
        return min(self.connecting_rod, _MAX_DRAWN_ROD * self.crank)

    @property
    def drawn_eccentric_rod(self) -> float:
        """Drawn length of the eccentric rod (m)."""
        return min(self.eccentric_rod, _MAX_DRAWN_ECCENTRIC_ROD * self.crank)

    @once_per_moment
    def position_at(self, moment: Moment) -> ValveGearPosition:
        """Return the position of the valve gear at a moment."""
        return self.position(moment.pose)

    def position(self, pose: FloatArray) -> ValveGearPosition:
        """Return the position of the valve gear at a pose (bodies, 3)."""
        crank, crosshead, valve = (pose[self.part.mechanism.body_index(name)].tolist() for name in (CRANK, CROSSHEAD, VALVE))
        piston_position = (0.0 if math.isinf(self.connecting_rod) else self.connecting_rod) - crosshead[0]
        return ValveGearPosition(crank_angle=crank[2], valve_displacement=valve[0] - self.centre, piston_position=piston_position)

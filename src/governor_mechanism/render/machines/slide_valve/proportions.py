"""Proportions of the drawing of a slide valve, and the position of the valve gear at a pose. The shaft is at the right."""

import math
from abc import ABC
from dataclasses import dataclass

from governor_mechanism.machines.driven_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.render.machines.machine_drawing import Dimension, MachineDrawing
from governor_mechanism.types import FloatArray

_MAX_DRAWN_ROD, _MAX_DRAWN_ECCENTRIC_ROD = 5.5, 3.2
"""Largest drawn lengths of connecting and eccentric rod, in crank radii; longer and infinite rods are shortened."""
STEAM_PHASES = ("live steam", "expanding steam", "spent steam", "pressed steam")


@dataclass(frozen=True, kw_only=True)
class ValveGearPosition:
    """Valve gear at a pose: crank angle (rad), valve displacement away from the shaft (m), piston position (m), sense of rotation.

    The piston position along the stroke is -crank at the head end (left) to crank at the crank end (right).
    """

    crank_angle: float
    valve_displacement: float
    piston_position: float
    sense: float = 1.0


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

    @property
    def drawn_rod(self) -> float:
        """Drawn length of the connecting rod (m)."""
        return min(self.connecting_rod, _MAX_DRAWN_ROD * self.crank)

    @property
    def drawn_eccentric_rod(self) -> float:
        """Drawn length of the eccentric rod (m)."""
        return min(self.eccentric_rod, _MAX_DRAWN_ECCENTRIC_ROD * self.crank)

    def position(self, pose: FloatArray) -> ValveGearPosition:
        """Return the position of the valve gear at a pose (bodies, 3)."""
        crank, crosshead, valve = (pose[self.part.mechanism.body_index(name)].tolist() for name in (CRANK, CROSSHEAD, VALVE))
        piston_position = (0.0 if math.isinf(self.connecting_rod) else self.connecting_rod) - crosshead[0]
        return ValveGearPosition(crank_angle=crank[2], valve_displacement=valve[0] - self.centre, piston_position=piston_position)

    def steam_phase(self, position: ValveGearPosition, side: float) -> str:
        """Return the phase of the steam at one end; `side` is 1 at the crank end, -1 at the head end."""
        admission, expansion, exhaust, compression = STEAM_PHASES
        port_displacement = side * position.valve_displacement
        if port_displacement > self.outside_lap:
            return admission
        if -port_displacement > self.inside_lap:
            return exhaust
        # In the first half of a turn the piston moves away from the crank end.
        return expansion if side * position.sense * math.sin(position.crank_angle) > 0 else compression

"""Proportions of the drawing of a slide valve, and the position of the valve gear at a pose. The shaft is at the right."""

import math
from dataclasses import dataclass, fields

from governor_mechanism.machines.driven_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.model.part import Part
from governor_mechanism.types import FloatArray

_MAX_DRAWN_ROD, _MAX_DRAWN_ECCENTRIC_ROD = 5.5, 3.2
"""Largest drawn lengths of connecting and eccentric rod, in crank radii; longer and infinite rods are shortened."""


@dataclass(frozen=True, kw_only=True)
class ValveGearProportions:
    """Dimensions (m); laps have a sign. Both rods may be infinite. `centre` is the centre of the valve travel."""

    crank: float
    connecting_rod: float
    eccentric: float
    eccentric_rod: float
    advance: float
    outside_lap: float
    inside_lap: float
    centre: float

    @property
    def drawn_rod(self) -> float:
        """Drawn length of the connecting rod (m)."""
        return min(self.connecting_rod, _MAX_DRAWN_ROD * self.crank)

    @property
    def drawn_eccentric_rod(self) -> float:
        """Drawn length of the eccentric rod (m)."""
        return min(self.eccentric_rod, _MAX_DRAWN_ECCENTRIC_ROD * self.crank)


@dataclass(frozen=True, kw_only=True)
class ValveGearPosition:
    """Valve gear at a pose: crank angle (rad), valve displacement away from the shaft (m), piston position (m).

    The piston position along the stroke is -crank at the head end (left) to crank at the crank end (right).
    """

    crank_angle: float
    valve_displacement: float
    piston_position: float


def valve_gear_proportions(part: Part) -> ValveGearProportions:
    """Return the dimensions of the part of a slide valve."""
    return ValveGearProportions(**{field.name: part.dimensions[field.name] for field in fields(ValveGearProportions)})


def valve_gear_position(part: Part, valve_gear: ValveGearProportions, pose: FloatArray) -> ValveGearPosition:
    """Return the position of the valve gear at a pose (bodies, 3)."""
    mechanism = part.mechanism
    crosshead = float(pose[mechanism.body_index(CROSSHEAD), 0])
    return ValveGearPosition(
        crank_angle=float(pose[mechanism.body_index(CRANK), 2]),
        valve_displacement=float(pose[mechanism.body_index(VALVE), 0]) - valve_gear.centre,
        piston_position=-(crosshead - (0.0 if math.isinf(valve_gear.connecting_rod) else valve_gear.connecting_rod)),
    )


STEAM_PHASES = ("live steam", "expanding steam", "spent steam", "pressed steam")
ADMISSION_PHASE, EXPANSION_PHASE, EXHAUST_PHASE, COMPRESSION_PHASE = STEAM_PHASES


def steam_phase(valve_gear: ValveGearProportions, position: ValveGearPosition, side: float) -> str:
    """Return the phase of the steam at one end; `side` is 1 at the crank end, -1 at the head end."""
    port_displacement = side * position.valve_displacement
    if port_displacement > valve_gear.outside_lap:
        return ADMISSION_PHASE
    if -port_displacement > valve_gear.inside_lap:
        return EXHAUST_PHASE
    # In the first half of a turn the piston moves away from the crank end.
    return EXPANSION_PHASE if side * math.sin(position.crank_angle) > 0 else COMPRESSION_PHASE

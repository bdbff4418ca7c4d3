"""What a run of any valve gear shows beside its readings: displacement of the valve from its centre, and openings of the steam ports."""

from typing import NamedTuple

from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.steam_readings import PORT_OPENINGS, VALVE_DISPLACEMENT
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.valve import Valve
from governor_mechanism.observables.valve_motion import has_valve_events, valve_motion_of, valve_of
from governor_mechanism.types import FloatArray

STEAM_PORTS = PORT_OPENINGS[0], PORT_OPENINGS[2]
"""Names of the openings of the steam ports of crank end and head end."""


class ValveReadings(NamedTuple):
    """Lengths (n,) m by name, and the name of the reading that they follow from, whose errors are theirs."""

    source: str
    values: dict[str, FloatArray]


def valve_reading_names(scene: Scene) -> tuple[str, ...]:
    """Return the names of what a run of a scene shows of its valve beside its readings."""
    return (VALVE_DISPLACEMENT, *STEAM_PORTS) if has_valve_events(scene) else ()


def find_valve_readings(run: Trajectory) -> ValveReadings:
    """Return what the position of the valve says, unless the mechanism has such readings; nothing without a valve.

    An opening is negative where the port is closed.
    """
    if not has_valve_events(run.scene) or VALVE_DISPLACEMENT in run.readings:
        return ValveReadings("", {})
    valve = valve_of(run.scene)
    centre = _centre_of(run, valve)
    if centre is None:
        return ValveReadings("", {})
    displacement = run.readings[valve.displacement] - centre
    openings = (side * valve.outward_sign * displacement - valve.steam_lap for side in (1.0, -1.0))
    values = {VALVE_DISPLACEMENT: displacement, **dict(zip(STEAM_PORTS, openings, strict=True))}
    return ValveReadings(valve.displacement, {name: one for name, one in values.items() if name not in run.readings})


def _centre_of(run: Trajectory, valve: Valve) -> float | None:
    """Return the reading of the valve in its centre, m; None if it depends on a turn that the crank cannot make."""
    if not isinstance(valve.centre, str):
        return valve.centre
    try:
        return valve_motion_of(run.scene).centre
    except MechanismError:
        return None

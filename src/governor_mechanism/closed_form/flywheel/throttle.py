"""The air-expansion engine behind a throttle: mean torque, and the work that its flywheel stores in a stroke.

A throttle u, 0 to 1, admits air at r + u (p - r), with the pressure p of the supply and r behind the piston; the pump delivers at p. SI and
radians. The engine is the first argument; its load pressure does not enter. Every function raises MechanismError for a value that is not
finite.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equations (61) to (67), with another pressure of
admission.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.closed_form.flywheel.engine import (
    AirEngine,
    expansion_pressure,
    expansion_work,
    gas_torque,
    gas_work,
    piston_travel,
    pump_work,
)
from governor_mechanism.closed_form.flywheel.equilibrium import N_SEARCH_POINTS
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatArray, FloatOrArray


def full_throttle_torque(engine: AirEngine) -> float:
    """Return the mean torque (N m) of the air in both cylinders on the shaft with the throttle open: its work in a stroke over pi."""
    return gas_work(engine) / math.pi


def throttle_torque(engine: AirEngine) -> float:
    """Return the torque (N m) that the whole throttle commands: the mean torque with it open less that with it closed.

    The mean torque is linear in u: it is that of the open throttle less 1 - u times this torque, which is A L (p - r) f / pi with the
    expansion factor f = s + (m + s) ln((m + 1) / (m + s)) of cut-off s and clearance m.

    Parameters
    ----------
    engine
        The engine.

    Returns
    -------
    float
        Torque, N m.

    Raises
    ------
    MechanismError
        If the supply is not above the pressure behind the piston.
    """
    initial = engine.clearance + engine.cut_off
    factor = engine.cut_off + initial * math.log1p((1 - engine.cut_off) / initial)
    return engine.area * engine.stroke * _surplus_pressure(engine) * factor / math.pi


def throttle_for_torque(engine: AirEngine, *, torque: FloatOrArray) -> FloatOrArray:
    """Return the opening of the throttle at which the mean torque has a value.

    Parameters
    ----------
    engine
        The engine.
    torque
        Mean torque, N m.

    Returns
    -------
    FloatOrArray
        Opening u, 0 to 1.

    Raises
    ------
    MechanismError
        If no opening gives that torque.
    """
    wanted = validate_argument(torque, "torque", "N m")
    opening = 1 - (full_throttle_torque(engine) - wanted) / throttle_torque(engine)
    hint = f"the engine gives at most {full_throttle_torque(engine):.6g} N m"
    raise_where((opening < 0) | (opening > 1), "no opening of the throttle gives this torque", ("torque", wanted, "N m"), hint=hint)
    return as_scalar_or_array(opening)


def throttled_gas_torque(engine: AirEngine, *, crank_angle: FloatOrArray, throttle: float) -> FloatOrArray:
    """Return the torque of the air in both cylinders on the shaft.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.
    throttle
        Opening u of the throttle.

    Returns
    -------
    FloatOrArray
        Torque, N m.
    """
    relative = np.asarray(expansion_pressure(engine, crank_angle=crank_angle)) / engine.supply_pressure
    missing = (1 - throttle) * _surplus_pressure(engine) * relative * engine.area * engine.stroke
    sine = np.abs(np.sin(validate_argument(crank_angle, "crank_angle", "rad")))
    return as_scalar_or_array(np.asarray(gas_torque(engine, crank_angle=crank_angle)) - missing * sine / 2)


def throttled_stored_work(engine: AirEngine, *, crank_angle: FloatOrArray, throttle: float) -> FloatOrArray:
    """Return the work of the air since the dead centre less that of the constant load that closes the cycle: what the flywheel stores.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi since the dead centre, rad, 0 to pi.
    throttle
        Opening u of the throttle.

    Returns
    -------
    FloatOrArray
        Work, J; 0 at both dead centres.
    """
    # The upper dead centre belongs to the next stroke, whose work begins at zero.
    angle = np.minimum(validate_argument(crank_angle, "crank_angle", "rad", minimum=0.0), np.nextafter(math.pi, 0.0))
    volume = engine.area * engine.stroke
    expansion = np.asarray(expansion_work(engine, crank_angle=angle))
    travel = np.asarray(piston_travel(crank_angle=angle))
    factor = (expansion / volume + engine.back_pressure * travel) / engine.supply_pressure
    missing = (1 - throttle) * _surplus_pressure(engine) * factor * volume
    mean_torque = full_throttle_torque(engine) - (1 - throttle) * throttle_torque(engine)
    return as_scalar_or_array(expansion + np.asarray(pump_work(engine, crank_angle=angle)) - missing - mean_torque * angle)


@dataclass(frozen=True, kw_only=True)
class StoredWorkRange:
    """Lowest and highest work (J) that the flywheel stores in a stroke, from 0 at the dead centre, under the load that closes the cycle."""

    lowest: float
    highest: float

    @property
    def energy(self) -> float:
        """Work between lowest and highest speed, J."""
        return self.highest - self.lowest


def find_stored_work_range(engine: AirEngine, *, throttle: float) -> StoredWorkRange:
    """Return the extremes of the work that the flywheel stores, where the torque of the air passes its mean.

    Parameters
    ----------
    engine
        The engine.
    throttle
        Opening u of the throttle.

    Returns
    -------
    StoredWorkRange
        The extremes.
    """
    mean_torque = full_throttle_torque(engine) - (1 - throttle) * throttle_torque(engine)

    def excess(angle: FloatOrArray) -> FloatArray:
        return np.asarray(throttled_gas_torque(engine, crank_angle=angle, throttle=throttle)) - mean_torque

    ends = (0.0, *engine.interval_limits, math.pi)
    grid = np.unique(np.concatenate([np.linspace(*pair, N_SEARCH_POINTS) for pair in pairwise(ends)]))
    is_driving = excess(grid) > 0
    angles = [
        find_root(lambda angle: float(excess(angle)), float(grid[k]), float(grid[k + 1]))
        for k in np.flatnonzero(is_driving[1:] != is_driving[:-1])
    ]
    works = np.asarray(throttled_stored_work(engine, crank_angle=np.array([0.0, *angles]), throttle=throttle))
    return StoredWorkRange(lowest=float(works.min()), highest=float(works.max()))


def _surplus_pressure(engine: AirEngine) -> float:
    """Return p - r, Pa, which the throttle holds back."""
    surplus = engine.supply_pressure - engine.back_pressure
    if not surplus > 0:
        raise MechanismError(
            f"supply_pressure ({engine.supply_pressure:.6g} Pa) must be above back_pressure ({engine.back_pressure:.6g} Pa), or the "
            "throttle has nothing to hold back"
        )
    return surplus

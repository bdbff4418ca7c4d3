"""Crank angles at which the driving and resisting forces of the engine balance, and the energy of its flywheel between them.

Where the torque of the air rises through that of the load the speed is lowest (alpha of the paper), where it falls, highest (beta).

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equations (61) to (68).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument
from governor_mechanism.closed_form.flywheel import speed_after_work, speed_limits
from governor_mechanism.closed_form.flywheel_engine import AirEngine, gas_torque, stored_work
from governor_mechanism.errors import MechanismError
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import FloatOrArray

N_SEARCH_POINTS = 200
"""Points of an interval at which the sign of the torque is looked at; between its limits the torque is smooth."""


@dataclass(frozen=True, kw_only=True)
class Equilibrium:
    """A crank angle (rad) at which air and load balance.

    interval, 1 to 4, is that of the stroke in which it lies; is_slowest tells whether the speed is lowest there, or else highest.
    """

    angle: float
    interval: int
    is_slowest: bool


@dataclass(frozen=True, kw_only=True)
class Fluctuation:
    """The crank angles of lowest and of the next highest speed (rad), and the work that the flywheel stores between them (J).

    fastest_angle is above pi if the highest speed is in the next stroke.
    """

    slowest_angle: float
    fastest_angle: float
    energy: float


def balance(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the right side of the equations (61) to (64): the torque of air and load over that of the atmosphere on the piston.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad, between the dead centres.

    Returns
    -------
    FloatOrArray
        The balance, without a unit; 0 in equilibrium.

    Raises
    ------
    MechanismError
        At a dead centre, where the load divided by sin phi is infinite.
    """
    sine = np.sin(validate_argument(crank_angle, "crank_angle", "rad", greater_than=0.0))
    if not np.all(sine > 0):
        raise MechanismError("crank_angle must lie between two dead centres, above 0 and below pi")
    torque = np.asarray(gas_torque(engine, crank_angle=crank_angle)) - engine.load_torque
    return as_scalar_or_array(torque / (sine * engine.atmospheric_pressure * engine.area * engine.stroke / 2))


def find_equilibria(engine: AirEngine) -> tuple[Equilibrium, ...]:
    """Return all roots of (61) to (64) in their intervals.

    Parameters
    ----------
    engine
        The engine.

    Returns
    -------
    tuple[Equilibrium, ...]
        The equilibria of a stroke, by ascending angle; none if the load exceeds the torque of the air everywhere.
    """

    def surplus(angle: float) -> float:
        return float(gas_torque(engine, crank_angle=angle)) - engine.load_torque

    ends = (0.0, *engine.interval_limits, math.pi)
    grid = np.unique(np.concatenate([np.linspace(*pair, N_SEARCH_POINTS) for pair in pairwise(ends)]))
    is_driving = np.asarray(gas_torque(engine, crank_angle=grid)) > engine.load_torque
    found = []
    for index in np.flatnonzero(is_driving[1:] != is_driving[:-1]):
        angle = find_root(surplus, float(grid[index]), float(grid[index + 1]))
        interval = 1 + int(np.searchsorted(engine.interval_limits, angle))
        found.append(Equilibrium(angle=angle, interval=interval, is_slowest=bool(is_driving[index + 1])))
    return tuple(found)


def energy_fluctuation(engine: AirEngine) -> Fluctuation:
    """Return the angles of lowest and highest speed and the work stored between them.

    The paper expects one minimum and one maximum in a stroke. A pump with a very small clearance gives two; the largest rise counts.

    Parameters
    ----------
    engine
        The engine. If its cycle does not close, the rise is that of one stroke, as in the paper.

    Returns
    -------
    Fluctuation
        The angles and the energy.

    Raises
    ------
    MechanismError
        If the engine cannot carry the load.
    """
    equilibria = find_equilibria(engine)
    if not equilibria:
        grid = np.linspace(0.0, math.pi, 4 * N_SEARCH_POINTS)
        largest = float(np.max(gas_torque(engine, crank_angle=grid)))
        raise MechanismError(
            f"the engine cannot carry the load: the torque of the air, at most {largest:.6g} N m, never exceeds that of the load, "
            f"{engine.load_torque:.6g} N m, and the shaft stalls; reduce load_pressure ({engine.load_pressure:.6g} Pa)"
        )
    pairs = [
        (low.angle, high.angle + math.pi * (high.angle < low.angle))
        for low in equilibria
        for high in equilibria
        if low.is_slowest and not high.is_slowest
    ]
    rises = np.diff(stored_work(engine, crank_angle=np.array(pairs)), axis=1)[:, 0]
    largest_rise = int(np.argmax(rises))
    slowest, fastest = pairs[largest_rise]
    return Fluctuation(slowest_angle=slowest, fastest_angle=fastest, energy=float(rises[largest_rise]))


def bracket_terms(engine: AirEngine, *, slowest_angle: float, fastest_angle: float) -> tuple[float, ...]:
    """Return the seven terms of the paper's bracket B: the work between two angles over A p L.

    They are, from (66), the expansion, the full pressure and the back pressure; from (65), the air in front of the pump piston, that left
    behind it, and the atmosphere behind it; from (67), the load. Their sum B gives the kinetic energy (68): (1/mu) (G/2g) v^2 = A p L B.

    Parameters
    ----------
    engine
        The engine.
    slowest_angle
        Crank angle alpha, rad, in the first interval.
    fastest_angle
        Crank angle beta, rad, in the third interval.

    Returns
    -------
    tuple[float, ...]
        Seven terms, without a unit.

    Raises
    ------
    MechanismError
        If an angle is not in its interval, or the intervals are not in the paper's order; `stored_work` holds there too.
    """
    _validate_paper_intervals(engine, slowest_angle, fastest_angle)
    cos_a, cos_b = math.cos(slowest_angle), math.cos(fastest_angle)
    u_a, u_b = math.sin(slowest_angle / 2) ** 2, math.sin(fastest_angle / 2) ** 2
    m = engine.pump_clearance
    compression = engine.supply_pressure / engine.atmospheric_pressure
    initial = engine.cut_off + engine.clearance
    pump_ratio = engine.pump_area * engine.pump_stroke / (engine.area * engine.stroke)
    return (
        initial * math.log((engine.clearance + u_b) / initial),
        engine.cut_off - u_a,
        -engine.back_pressure / engine.supply_pressure * (cos_a - cos_b) / 2,
        -pump_ratio / compression * (m + 1) * math.log((2 * m + 1 + cos_a) / (2 * m + 1 + cos_b)),
        pump_ratio * m * math.log(m * compression / (m + u_a)),
        pump_ratio / compression * (u_b - m * (compression - 1)),
        -engine.load_pressure / engine.supply_pressure * (fastest_angle - slowest_angle) / math.pi,
    )


def _validate_paper_intervals(engine: AirEngine, slowest_angle: float, fastest_angle: float) -> None:
    """Raise MechanismError unless alpha is in the first and beta in the third of the paper's intervals."""
    first, second, third = engine.interval_limits
    if not engine.suction_travel <= engine.cut_off <= engine.delivery_travel:
        raise MechanismError(
            "the bracket needs a suction valve that opens before the cut-off, and a cut-off before the delivery valve opens; "
            f"they are at {engine.suction_travel:.6g}, {engine.cut_off:.6g} and {engine.delivery_travel:.6g} of the stroke; "
            "take differences of the stored work instead"
        )
    for name, angle, low, high in (("slowest_angle", slowest_angle, 0.0, first), ("fastest_angle", fastest_angle, second, third)):
        validate_argument(angle, name, "rad")
        if not low <= angle <= high:
            limits = f"{math.degrees(low):.6g} to {math.degrees(high):.6g} deg"
            raise MechanismError(
                f"{name} must lie in its interval of the bracket, {limits}; got {math.degrees(angle):.6g} deg; "
                "take differences of the stored work instead"
            )


def shaft_speed(engine: AirEngine, *, crank_angle: FloatOrArray, inertia: float, mean_speed: float) -> FloatOrArray:
    """Return the speed of the shaft, w^2 = w0^2 + 2 E(phi) / J, with w0 at the dead centre from the paper's mean speed.

    The mean is that whose kinetic energy is the mean of the highest and the lowest in a stroke.

    Parameters
    ----------
    engine
        The engine; its cycle should close, or every stroke begins at another speed.
    crank_angle
        Crank angle phi, rad.
    inertia
        Moment of inertia J of the flywheel, kg m2.
    mean_speed
        Mean speed, rad/s.

    Returns
    -------
    FloatOrArray
        Speed, rad/s.

    Raises
    ------
    MechanismError
        If the engine cannot carry the load, or the flywheel is too light.
    """
    extremes = energy_fluctuation(engine)
    lowest, _ = speed_limits(inertia=inertia, energy=extremes.energy, mean_speed=mean_speed, mean_energy=True)
    work = np.asarray(stored_work(engine, crank_angle=crank_angle)) - stored_work(engine, crank_angle=extremes.slowest_angle)
    return speed_after_work(inertia=inertia, start_speed=lowest, work=as_scalar_or_array(work))

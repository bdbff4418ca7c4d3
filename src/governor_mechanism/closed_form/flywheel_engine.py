"""The air-expansion engine of Redtenbacher: pressures, torque and stored work over the crank angle.

An expansion cylinder and a compression pump, both double acting, drive and load one shaft in phase through infinitely long connecting
rods. The air keeps its temperature (Mariotte's law); the load resists with a constant torque; reciprocating masses are neglected. The
crank angle phi is zero at a dead centre, and every stroke repeats the one before. u = (1 - cos phi) / 2 is the travel of both pistons
relative to their strokes. SI and radians.

The engine is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite.

References
----------
F. Redtenbacher, Die Luftexpansions-Maschine (Mannheim 1853), theory of the flywheel, equations (57) to (68). The stored work as a
function of the angle is the integral of his work elements from the dead centre.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_argument, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


@dataclass(frozen=True, kw_only=True)
class AirEngine:
    """An expansion cylinder and a compression pump on one shaft.

    MechanismError is raised for dimensions that are not positive, a cut-off beyond the stroke, a cylinder without any volume at the dead
    centre, and pressures that are negative or below the atmosphere where they must not be.

    Attributes
    ----------
    area
        Area A of the expansion piston, m2.
    stroke
        Stroke L of the expansion piston, m.
    cut_off
        Travel L1 / L at which the supply is cut off, relative to the stroke.
    clearance
        Clearance M of the expansion cylinder, relative to the volume of its stroke.
    pump_area
        Area a of the pump piston, m2.
    pump_stroke
        Stroke l of the pump piston, m.
    pump_clearance
        Clearance m of the pump, relative to the volume of its stroke.
    atmospheric_pressure
        Pressure at which the pump takes in air, Pa.
    supply_pressure
        Pressure p of the supply, at which the pump delivers, Pa.
    back_pressure
        Pressure r behind the expansion piston, Pa.
    load_pressure
        Mean useful pressure R of the load, referred to the expansion piston, Pa.
    """

    area: float
    stroke: float
    cut_off: float
    clearance: float
    pump_area: float
    pump_stroke: float
    pump_clearance: float
    atmospheric_pressure: float
    supply_pressure: float
    back_pressure: float
    load_pressure: float

    def __post_init__(self) -> None:
        """Validate the dimensions and pressures."""
        validate_fields(self, {"area": "m2", "stroke": "m", "pump_area": "m2", "pump_stroke": "m"}, greater_than=0.0)
        validate_fields(self, {"cut_off": "", "clearance": "", "pump_clearance": "", "back_pressure": "Pa"}, minimum=0.0)
        validate_fields(self, {"atmospheric_pressure": "Pa", "load_pressure": "Pa"}, greater_than=0.0)
        validate_argument(self.supply_pressure, "supply_pressure", "Pa")
        problems = self._find_problems()
        if problems:
            raise MechanismError(*problems)

    def _find_problems(self) -> list[str]:
        """Return sentences about values that do not fit together."""
        problems = []
        if self.cut_off > 1:
            problems.append(f"cut_off must be at most 1, the end of the stroke; got {self.cut_off:.12g}")
        if self.clearance + self.cut_off == 0:
            problems.append("clearance and cut_off cannot both be 0: the air would expand from no volume, where its pressure is infinite")
        if self.pump_clearance == 0:
            problems.append(
                "pump_clearance must be above 0: the air left in the pump would expand from no volume, where its pressure is infinite; "
                "give a small clearance such as 0.001"
            )
        if not self.supply_pressure > self.atmospheric_pressure:
            problems.append(
                f"supply_pressure must be above atmospheric_pressure ({self.atmospheric_pressure:.12g} Pa); "
                f"got {self.supply_pressure:.12g} Pa"
            )
        elif self.pump_clearance * (self.supply_pressure / self.atmospheric_pressure - 1) >= 1:
            largest = self.atmospheric_pressure / (self.supply_pressure - self.atmospheric_pressure)
            problems.append(
                f"pump_clearance must be below {largest:.6g} at these pressures, or the valves of the pump never open; "
                f"got {self.pump_clearance:.12g}"
            )
        return problems

    @property
    def suction_travel(self) -> float:
        """Travel at which the suction valve of the pump opens, relative to the stroke: the end of the first interval."""
        return self.pump_clearance * (self.supply_pressure / self.atmospheric_pressure - 1)

    @property
    def delivery_travel(self) -> float:
        """Travel at which the delivery valve of the pump opens, relative to the stroke: the end of the third interval."""
        return (1 + self.pump_clearance) * (1 - self.atmospheric_pressure / self.supply_pressure)

    @property
    def interval_limits(self) -> tuple[float, float, float]:
        """Crank angles (rad) at which the laws of the pressures change, ascending."""
        first, second, third = sorted(
            2 * math.asin(math.sqrt(travel)) for travel in (self.suction_travel, self.cut_off, self.delivery_travel)
        )
        return first, second, third

    @property
    def full_pressure_work(self) -> float:
        """Work A p L of the supply pressure over a whole stroke (J), in which the paper measures all work."""
        return self.area * self.supply_pressure * self.stroke

    @property
    def load_torque(self) -> float:
        """Torque of the load (N m): A R L per stroke; as a force at the crank pin, 2 A R / pi (60)."""
        return self.area * self.load_pressure * self.stroke / math.pi


def _angle_in_stroke(crank_angle: FloatOrArray) -> tuple[FloatArray, FloatArray]:
    """Return the number of complete strokes and the angle since the last dead centre (rad)."""
    angle = validate_argument(crank_angle, "crank_angle", "rad")
    n_strokes = np.floor(angle / math.pi)
    return n_strokes, np.clip(angle - n_strokes * math.pi, 0.0, math.pi)


def piston_travel(*, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the travel of both pistons since the last dead centre, relative to their strokes (57): u = (1 - cos phi) / 2."""
    return as_scalar_or_array(np.sin(_angle_in_stroke(crank_angle)[1] / 2) ** 2)


def expansion_pressure(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the pressure that drives the expansion piston.

    It is p up to the cut-off, then p (M + L1 / L) / (M + u).

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Pressure, Pa.
    """
    volume = engine.clearance + np.maximum(piston_travel(crank_angle=crank_angle), engine.cut_off)
    return as_scalar_or_array(engine.supply_pressure * (engine.clearance + engine.cut_off) / volume)


def suction_pressure(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the pressure behind the pump piston: p m / (m + u) until the suction valve opens, then that of the atmosphere.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Pressure, Pa.
    """
    volume = engine.pump_clearance + np.asarray(piston_travel(crank_angle=crank_angle))
    return as_scalar_or_array(np.maximum(engine.atmospheric_pressure, engine.supply_pressure * engine.pump_clearance / volume))


def delivery_pressure(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the pressure in front of the pump piston: that of the atmosphere times (m + 1) / (m + 1 - u), at most p.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Pressure, Pa.
    """
    full = engine.pump_clearance + 1
    compressed = engine.atmospheric_pressure * full / (full - np.asarray(piston_travel(crank_angle=crank_angle)))
    return as_scalar_or_array(np.minimum(engine.supply_pressure, compressed))


def gas_torque(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the torque of the air in both cylinders on the shaft; without that of the load.

    Less the load torque, and divided by the atmospheric pressure, by A L / 2 and by sin phi, it is the right side of the equations
    (61) to (64), by the interval of the crank angle.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Torque, N m.
    """
    driving = np.asarray(expansion_pressure(engine, crank_angle=crank_angle)) - engine.back_pressure
    resisting = np.asarray(delivery_pressure(engine, crank_angle=crank_angle)) - suction_pressure(engine, crank_angle=crank_angle)
    force_times_stroke = engine.area * engine.stroke * driving - engine.pump_area * engine.pump_stroke * resisting
    return as_scalar_or_array(force_times_stroke * np.sin(_angle_in_stroke(crank_angle)[1]) / 2)


def expansion_work(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the work of the air on the expansion piston since the last dead centre, against the back pressure; see (66).

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Work, J; from 0 at the dead centre.
    """
    u, cut_off = np.asarray(piston_travel(crank_angle=crank_angle)), engine.cut_off
    initial = engine.clearance + cut_off
    expanded = initial * np.log1p((np.maximum(u, cut_off) - cut_off) / initial)
    gained = engine.supply_pressure * (np.minimum(u, cut_off) + expanded) - engine.back_pressure * u
    return as_scalar_or_array(engine.area * engine.stroke * gained)


def pump_work(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the work of the air on both faces of the pump piston since the last dead centre; see (65). It is mostly negative.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad.

    Returns
    -------
    FloatOrArray
        Work, J; 0 at the dead centre.
    """
    u, m = np.asarray(piston_travel(crank_angle=crank_angle)), engine.pump_clearance
    atmosphere = engine.atmospheric_pressure
    supply = engine.supply_pressure
    suction = engine.suction_travel
    delivery = engine.delivery_travel
    behind = supply * m * np.log1p(np.minimum(u, suction) / m) + atmosphere * (np.maximum(u, suction) - suction)
    in_front = -atmosphere * (m + 1) * np.log1p(-np.minimum(u, delivery) / (m + 1)) + supply * (np.maximum(u, delivery) - delivery)
    return as_scalar_or_array(engine.pump_area * engine.pump_stroke * (behind - in_front))


def gas_work(engine: AirEngine) -> float:
    """Return the work of the air in both cylinders on the shaft over a stroke.

    Parameters
    ----------
    engine
        The engine.

    Returns
    -------
    float
        Work, J.
    """
    return float(expansion_work(engine, crank_angle=_STROKE_END)) + float(pump_work(engine, crank_angle=_STROKE_END))


_STROKE_END = np.nextafter(math.pi, 0.0)
"""Last crank angle of a stroke (rad): at pi the next one begins. The travel there is 1 to the last digit."""


def stored_work(engine: AirEngine, *, crank_angle: FloatOrArray) -> FloatOrArray:
    """Return the work E of the air less that of the load since the crank angle zero: what the flywheel stores.

    Parameters
    ----------
    engine
        The engine.
    crank_angle
        Crank angle phi, rad; of any number of strokes.

    Returns
    -------
    FloatOrArray
        Work E, J.
    """
    n_strokes, _ = _angle_in_stroke(crank_angle)
    both = np.asarray(expansion_work(engine, crank_angle=crank_angle)) + pump_work(engine, crank_angle=crank_angle)
    return as_scalar_or_array(n_strokes * gas_work(engine) + both - engine.load_torque * np.asarray(crank_angle))


def net_work(engine: AirEngine) -> float:
    """Return the work that the shaft gains in a stroke, J; 0 if the cycle closes, that is, if the speed is periodic."""
    return gas_work(engine) - engine.area * engine.load_pressure * engine.stroke


def closing_load_pressure(engine: AirEngine) -> float:
    """Return the load pressure R (Pa) with which the cycle closes; MechanismError if the air does no work on the shaft."""
    work = gas_work(engine)
    if not work > 0:
        raise MechanismError(
            f"the engine can carry no load: in a stroke the air does {work:.6g} J of work on the shaft; "
            "increase supply_pressure or cut_off, or reduce back_pressure or pump_area"
        )
    return work / (engine.area * engine.stroke)


def closing_area_ratio(engine: AirEngine) -> float:
    """Return the ratio a / A of pump and piston area with which the cycle closes under the load.

    Parameters
    ----------
    engine
        The engine; its pump area does not enter.

    Returns
    -------
    float
        Ratio of the areas.

    Raises
    ------
    MechanismError
        If the expansion cylinder alone cannot carry the load.
    """
    surplus = float(expansion_work(engine, crank_angle=_STROKE_END)) - engine.area * engine.load_pressure * engine.stroke
    if not surplus > 0:
        raise MechanismError(
            f"no pump closes the cycle: even without one the shaft gains {surplus:.6g} J in a stroke; "
            "reduce load_pressure or back_pressure, or increase supply_pressure or cut_off"
        )
    return surplus / -float(pump_work(engine, crank_angle=_STROKE_END)) * engine.pump_area / engine.area

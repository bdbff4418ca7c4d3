"""What regulates what in a governed engine: the shaft with its load, the governor that turns with it, and its equilibria.

In equilibrium the mean torque of the engine at the position of the governor equals the load, and the speed is that at which the governor
rests there. Both follow from statics: the work of the gas in a stroke, and the speed curve of the governor alone.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT, gas_work
from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.inputs import evaluate_reading_function
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.coupling.coupled_system import rotating_body
from governor_mechanism.model.coupling.couplings import LoadCoupling, RatioCoupling
from governor_mechanism.model.force_elements import CylinderGas, ForceElement, Torque, TorsionDamper
from governor_mechanism.model.part import Start
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.interpolation import interpolate_samples
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.statics.equilibrium_speed import equilibrium_speed_squared, evaluate_readings
from governor_mechanism.studies.plain_runs import SLEEVE_READING
from governor_mechanism.types import FloatArray

N_CURVE_POINTS = 2001
"""Points of the characteristic: a table of a throttle has its kinks many points apart."""

N_FORCE_POINTS = 201
"""Points at which the forces along the travel are evaluated; they are interpolated between them."""

N_POTENTIAL_NODES = 20
"""Nodes of the quadrature of the potential energy: exact to rounding for the smooth forces of a governor."""

N_TURN_POINTS = 720
"""Crank angles of a turn over which its speed is averaged."""

N_WORK_POINTS = 1001
"""Points of the quadrature of the work of the load, between its changes."""

SLOPE_STEP = 1e-4
"""Step of the difference of the torque, relative to the scale of the coordinate: its rounding is 1e-12 of the torque."""

SPEED_READINGS = ("spindle_speed",)
"""Readings of the governor that its position does not determine."""


@dataclass(frozen=True, kw_only=True)
class OperatingPoint:
    """An equilibrium of a governed engine."""

    coordinate: float  # coordinate of the governor, SI
    sleeve_lift: float  # lift of the sleeve, m
    shaft_speed: float  # speed of the shaft, rad/s
    torque: float  # mean torque of the engine, and the load, N m


@dataclass(frozen=True, kw_only=True, eq=False)
class RegulationCharacteristic:
    """Speed and mean torque of a governed engine along the travel of its governor."""

    coordinate: FloatArray  # coordinate of the governor, SI; shape (n,)
    sleeve_lift: FloatArray  # lift of the sleeve, m; shape (n,)
    # speed of the shaft at which the governor is in equilibrium, rad/s; not a number where there is none;
    # shape (n,)
    shaft_speed: FloatArray
    torque: FloatArray  # mean torque of the engine, N m; shape (n,)


class GovernedEngine:
    """The parts of a scene in which a governor regulates an engine.

    Parameters
    ----------
    scene
        Scene with a [load], and one part that turns with the shaft of this load.

    Attributes
    ----------
    load
        The load.
    shaft_angle
        Reading of the angle of the shaft.
    governor
        Name of the part that is the governor.
    ratio
        Ratio of the speed of the spindle to that of the shaft.

    Raises
    ------
    MechanismError
        If the scene has no load or no governor.
    """

    def __init__(self, scene: Scene) -> None:
        loads = [one for one in scene.couplings if isinstance(one, LoadCoupling)]
        if not loads:
            text = "this needs an engine with a load under a governor, and the scene has no table [load]"
            raise MechanismError(f'{text}; write [load] with angle = "engine.crank_angle" and rated_torque = "300 N m"')
        self.scene, self.load = scene, loads[0]
        if self.load.fraction.depends_on_readings:
            text = "this needs a load that depends on time alone, and load.fraction depends on a reading"
            raise MechanismError(f"{text}; write a number or a program of time (a load_damping of the engine may depend on the speed)")
        self.shaft_angle = self.load.angle
        self._shaft = rotating_body(scene.mechanism, self.load.name, self.shaft_angle)
        planes = [plane for plane in scene.system.planes if plane.shaft]
        trains = [(plane, ratio) for plane in planes if (ratio := self._ratio_to_shaft(plane.prefix, plane.shaft, plane.ratio))]
        if len(trains) != 1:
            what = f"this needs one governor whose spindle turns with {self.shaft_angle!r}; found {len(trains)}"
            raise MechanismError(f"{what}; couple its spindle_angle by a gear")
        plane, self.ratio = trains[0]
        self.governor = plane.prefix.removesuffix(".")
        readings = [reading.name for reading in scene.mechanism.readings]
        if self.sleeve not in readings:
            raise MechanismError(f"this needs the lift of the governor's sleeve, the reading {self.sleeve!r}; readings are {readings}")

    def _ratio_to_shaft(self, prefix: str, shaft: str, ratio: float) -> float:
        """Return the ratio of the spindle of a plane to the shaft with the load; 0 if they do not turn together."""
        if shaft == self._shaft:
            return ratio
        for coupling in self.scene.couplings:
            if isinstance(coupling, RatioCoupling) and coupling.second == f"{prefix}spindle_angle":
                is_geared = rotating_body(self.scene.mechanism, coupling.name, coupling.first) == self._shaft
                return coupling.ratio if is_geared else 0.0
        return 0.0

    @property
    def coordinate(self) -> str:
        """Reading of the coordinate of the governor in the scene."""
        return f"{self.governor}.{self._reduction.mechanism.coordinate}"

    @property
    def coordinate_scale(self) -> float:
        """Scale of the coordinate of the governor, SI."""
        return self._reduction.coordinate_scale

    @property
    def sleeve(self) -> str:
        """Reading of the lift of the sleeve in the scene."""
        return f"{self.governor}.{SLEEVE_READING}"

    @cached_property
    def _reduction(self) -> SingleDofReduction:
        return SingleDofReduction(rotating_part_alone(self.scene))

    @property
    def has_mean_torque(self) -> bool:
        """Whether nothing on the shaft varies within a turn."""
        return not any(isinstance(element, CylinderGas) for element in self._engine_elements)

    @property
    def _engine_elements(self) -> list[ForceElement]:
        """Force elements on the shaft other than the load."""
        return [one for one in self.scene.mechanism.force_elements if self._shaft in one.bodies and one.name != self.load.name]

    @property
    def shaft_inertia(self) -> float:
        """Moment of inertia of shaft and flywheel, kg m2, without the governor."""
        return self.scene.mechanism.bodies[self.scene.mechanism.body_index(self._shaft)].planar_inertia

    @cached_property
    def characteristic(self) -> RegulationCharacteristic:
        """Speed and mean torque along the travel of the governor."""
        low, high = self._travel
        coordinates = np.linspace(low, high, N_CURVE_POINTS)
        readings, speeds = self._evaluate(coordinates)
        torques = [
            self._mean_torque({name: float(values[k]) for name, values in readings.items()}, float(speeds[k])) for k in range(len(speeds))
        ]
        lifts = readings[SLEEVE_READING]
        return RegulationCharacteristic(coordinate=coordinates, sleeve_lift=lifts, shaft_speed=speeds, torque=np.array(torques))

    @property
    def _travel(self) -> tuple[float, float]:
        """Lowest and highest coordinate that stops and limits leave."""
        travel = self._reduction.range_of_motion
        name = self._reduction.mechanism.coordinate
        low, high = travel.low, travel.high
        for effect in self._reduction.scene.output_effects:
            if effect.contact and effect.reading == name:
                low = max(low, effect.contact.get("low", low))
                high = min(high, effect.contact.get("high", high))
        return low, high

    def _evaluate(self, coordinates: FloatArray) -> tuple[dict[str, FloatArray], FloatArray]:
        """Return the readings (n,) of the governor and the speeds (n,) of the shaft in equilibrium, rad/s."""
        coefficients = self._reduction.evaluate(coordinates)
        speed_squared = equilibrium_speed_squared(coefficients, self._reduction.coordinate_scale)
        spindle_speed = np.sqrt(np.where(speed_squared > 0.0, speed_squared, np.nan))
        return evaluate_readings(self._reduction.mechanism, coefficients), spindle_speed / abs(self.ratio)

    def _mean_torque(self, readings: Mapping[str, float], shaft_speed: float) -> float:
        """Return the mean torque of the engine over a turn, N m, at readings of the governor and a speed of the shaft, rad/s."""
        known, torque = self._known_readings(readings, shaft_speed), 0.0
        for element in self._engine_elements:
            sense = 1.0 if element.bodies[1] == self._shaft else -1.0
            if isinstance(element, CylinderGas):
                opening, coefficients = self._settings(element, known)
                work = self._works_per_stroke.get(element.name) if element.cut_off is None else None
                torque += opening * (float(gas_work(coefficients, element.stroke, math.pi)) if work is None else work) / math.pi
            elif isinstance(element, Torque):
                torque += sense * _evaluate_load(element.moment, known)
            elif isinstance(element, TorsionDamper):
                torque -= element.damping * shaft_speed
        return torque

    @cached_property
    def _works_per_stroke(self) -> dict[str, float]:
        """Work (J) of a stroke with an open throttle, by gas, where no governor moves the cut-off."""
        gases = [one for one in self._engine_elements if isinstance(one, CylinderGas) and one.cut_off is None]
        return {gas.name: float(gas_work(gas.coefficients, gas.stroke, math.pi)) for gas in gases}

    def _known_readings(self, readings: Mapping[str, float], shaft_speed: float) -> dict[str, float]:
        """Return what the position of the governor and the speed (rad/s) of the shaft determine, by the names in the scene."""
        known = {f"{self.governor}.{name}": value for name, value in readings.items()}
        return known | {f"{self.governor}.{name}": shaft_speed * abs(self.ratio) for name in SPEED_READINGS}

    @staticmethod
    def _settings(gas: CylinderGas, known: Mapping[str, float]) -> tuple[float, list[float]]:
        """Return the opening of the throttle and the coefficients of a gas at known readings."""
        coefficients = list(gas.coefficients)
        if gas.cut_off is not None:
            coefficients[SWITCH_COEFFICIENT] = _evaluate_load(gas.cut_off, known)
        return 1.0 if gas.throttle is None else _evaluate_load(gas.throttle, known), coefficients

    def operating_point(
        self,
        torque: float,  # load, N m
    ) -> OperatingPoint:
        """Return the equilibrium under a load; the one with the lowest sleeve if there are several."""
        curve = self.characteristic
        is_known = np.isfinite(curve.shaft_speed)
        difference = np.where(is_known, curve.torque - torque, np.nan)
        crossings = np.flatnonzero(difference[:-1] * difference[1:] <= 0.0)
        if not len(crossings):
            raise MechanismError(self._no_equilibrium_message(torque))

        def excess(value: float) -> float:
            readings, speeds = self._evaluate(np.array([value]))
            return self._mean_torque({name: float(one[0]) for name, one in readings.items()}, float(speeds[0])) - torque

        k = int(crossings[np.argmin(curve.sleeve_lift[crossings])])
        return self.point_at(find_root(excess, float(curve.coordinate[k]), float(curve.coordinate[k + 1])))

    def point_at(self, coordinate: float) -> OperatingPoint:
        """Return the equilibrium at a position of the governor, whatever the load."""
        readings, speeds = self._evaluate(np.array([coordinate]))
        torque = self._mean_torque({name: float(one[0]) for name, one in readings.items()}, float(speeds[0]))
        lift = float(readings[SLEEVE_READING][0])
        return OperatingPoint(coordinate=coordinate, sleeve_lift=lift, shaft_speed=float(speeds[0]), torque=torque)

    def torque_slope(self, point: OperatingPoint) -> float:
        """Return the change of the mean torque by the lift of the sleeve at an operating point, N m/m; exact within a line of a table."""
        step = SLOPE_STEP * self.coordinate_scale
        coordinates = np.array([point.coordinate - step, point.coordinate + step])
        readings, speeds = self._evaluate(coordinates)
        torques = [
            self._mean_torque({name: float(one[k]) for name, one in readings.items()}, float(speeds[k])) for k in range(len(coordinates))
        ]
        lifts = readings[SLEEVE_READING]
        return (torques[1] - torques[0]) / float(lifts[1] - lifts[0])

    def _no_equilibrium_message(self, torque: float) -> str:
        """Return why no position of the governor balances a load."""
        torques = self.characteristic.torque
        low, high = float(np.nanmin(torques)), float(np.nanmax(torques))
        what = f"a load of {torque:.6g} N m has no equilibrium: over the travel of the governor the mean torque of the engine is"
        if torque > high:
            return f"{what} at most {high:.6g} N m, so that the engine stalls; reduce the load, or open the throttle or cut-off farther"
        if torque < low:
            return f"{what} at least {low:.6g} N m, so that the engine runs away; increase the load, or let the throttle close farther"
        return f"{what} {low:.6g} to {high:.6g} N m, but the governor rests at no speed where it is that; change its dimensions"

    def sleeve_forces(
        self,
        coordinates: FloatArray,  # coordinate of the governor, SI; shape (n,)
        shaft_speeds: FloatArray,  # speed of the shaft, rad/s; shape (n,)
    ) -> FloatArray:
        """Return the force along the sleeve that weights, springs and centrifugal forces leave unbalanced; shape (n,)."""
        reduction = self._reduction
        low = float(coordinates.min())
        high = float(coordinates.max())
        grid = np.linspace(low, high, N_FORCE_POINTS) if high > low else np.array([low])
        coefficients = reduction.evaluate(grid)
        lift_slope = evaluate_output(reduction.mechanism, SLEEVE_READING, coefficients.poses).rate(coefficients.tangents)
        static, centrifugal = (np.interp(coordinates, grid, term / lift_slope) for term in coefficients.force_terms(1.0))
        forces: FloatArray = -static - centrifugal * (self.ratio * shaft_speeds) ** 2
        return forces

    def potential_difference(
        self,
        start: float,  # coordinate of the governor at the start, SI
        end: float,  # its coordinate at the end, SI
    ) -> float:
        """Return the potential energy of weights and springs of the governor at an end of its motion less that at the start, J."""
        nodes, weights = np.polynomial.legendre.leggauss(N_POTENTIAL_NODES)
        half = 0.5 * (end - start)
        derivative = self._reduction.evaluate(start + half * (nodes + 1)).potential_derivative
        return half * float(weights @ derivative)

    def load_work(
        self,
        times: FloatArray,  # times, s; shape (n,)
        angles: FloatArray,  # angle of the shaft, rad; shape (n,)
        speeds: FloatArray,  # speed of the shaft, rad/s; shape (n,)
    ) -> float:
        """Return the work that the load takes along a motion, J."""
        load = self.load.fraction
        changes = [one for one in dict.fromkeys(load.times) if times[0] < one < times[-1]]
        work = 0.0
        for start, end in pairwise([float(times[0]), *changes, float(times[-1])]):
            instants = np.linspace(start, end, N_WORK_POINTS)
            fraction = CubicTimeFunction(load)(0.5 * (instants[1:] + instants[:-1]))
            work += float(np.sum(fraction * np.diff(interpolate_samples(times, angles, speeds, instants))))
        return self.load.rated_torque * work

    def with_constant_load(self, torque: float) -> Scene:
        """Return the scene with a load that does not change, N m."""
        return self.with_load(InputFunction(values=(torque / self.load.rated_torque,)))

    def with_load(self, fraction: InputFunction) -> Scene:
        """Return the scene with another load over time, relative to the rated torque."""
        couplings = tuple(replace(one, fraction=fraction) if one is self.load else one for one in self.scene.couplings)
        return replace(self.scene, couplings=couplings, document={})

    def _speed_at_start(self, point: OperatingPoint) -> float:
        """Return the speed (rad/s) at the crank angle of the start if the mean speed over a turn is that of an operating point."""
        # To first order in the fluctuation: the gas stores more or less work than the load takes,
        # and the shaft has the difference.
        angle = self.scene.system.start.values.get(self.shaft_angle, 0.0)
        if self.has_mean_torque or not isinstance(angle, float):
            return point.shaft_speed
        angles = np.append(np.linspace(0.0, math.tau, N_TURN_POINTS, endpoint=False), angle % math.tau)
        surplus = self._gas_work(point, angles) - point.torque * angles
        stored = surplus[-1] - surplus[:-1].mean()
        return point.shaft_speed + float(stored) / (self.shaft_inertia * point.shaft_speed)

    def _gas_work(self, point: OperatingPoint, angles: FloatArray) -> FloatArray:
        """Return the work (n,) of the gas on the shaft from the crank angle 0 on, J, with the governor at rest."""
        readings, _ = self._evaluate(np.array([point.coordinate]))
        known = self._known_readings({name: float(one[0]) for name, one in readings.items()}, point.shaft_speed)
        work = np.zeros_like(angles)
        for gas in (one for one in self._engine_elements if isinstance(one, CylinderGas)):
            travels = gas.stroke * 0.5 * (1.0 - np.cos(angles))  # of an endless rod: enough for a start
            opening, coefficients = self._settings(gas, known)
            work += opening * gas_work(coefficients, travels, angles)
        return work

    def started_at(self, point: OperatingPoint) -> Scene:
        """Return the scene with a start at an operating point; the speed within a turn is that of the periodic motion to first order."""
        shaft_part, shaft_reading = self.scene.part_of(self.shaft_angle)
        parts = []
        for part in self.scene.parts:
            start = part.start
            if part is shaft_part:
                start = Start(values=start.values, rates={**start.rates, shaft_reading: self._speed_at_start(point)})
            elif part.name == self.governor:
                start = Start(values={**start.values, self._reduction.mechanism.coordinate: point.coordinate}, rates={})
            parts.append(replace(part, start=start))
        return replace(self.scene, parts=tuple(parts), document={})


def _evaluate_load(load: InputFunction, known: Mapping[str, float]) -> float:
    """Return the last value of a load at known readings. Raise MechanismError if it depends on another one."""
    for function in (*load.functions, *load.factors):
        if function.reading not in known:
            text = f"the mean torque depends on {function.reading!r}, which the position of the governor does not determine"
            raise MechanismError(f"{text}; let it depend on one of {list(known)}")
    total = load.values[-1] + sum(evaluate_reading_function(one, known[one.reading]) for one in load.functions)
    return total * math.prod(evaluate_reading_function(one, known[one.reading]) for one in load.factors)

"""Readings that follow from the state of a mechanism, and along which nothing acts; the kinematics with them; the mean torque of gas."""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, partial
from typing import Any, Final

import numpy as np

from governor_mechanism.effects.gas_pressure import SWITCH_COEFFICIENT, gas_pressure, work_per_stroke
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.inputs import NOT_HELD, evaluate_reading_function_along, lagged_functions_of
from governor_mechanism.mechanics.dynamics.output_forces import element_law, pad_coefficients
from governor_mechanism.mechanics.kinematics.constraint_rows import point_path
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.kinematic_analysis import TIME_VARIABLE, Kinematics, solve_kinematics
from governor_mechanism.mechanics.kinematics.output_variables import (
    OutputDerivatives,
    evaluate_output,
    evaluate_output_value,
    rows_of_readings,
)
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.force_elements import CylinderGas, ForceElement, MeanGasTorque, Spring
from governor_mechanism.model.joints import RotationalDriver, TranslationalDriver
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.motion_readings import PathCoordinate, PointAcceleration, PointVelocity, TransmissionAngle
from governor_mechanism.model.output_variables import (
    AppliedTorque,
    ContactForce,
    ControlledValue,
    CylinderPressure,
    JointForce,
    JointMoment,
    Reading,
    ShaftSpeed,
    SpringForce,
    StaticForce,
    StoredWork,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import convert_texts, parse_quantity


def evaluate_static_forces(scene: Scene, poses: FloatArray) -> dict[str, FloatArray]:
    """Return spring forces and static forces (n,), N, by name at closed poses (n, bodies, 3); raise as `compute_static_force`."""
    mechanism = scene.mechanism

    static_force = cache(partial(compute_static_force, scene, poses=poses))
    forces: dict[str, FloatArray] = {}
    for output in mechanism.derived_readings:
        match output:
            case SpringForce():
                forces[output.name] = _spring_force(mechanism, output.spring, poses)
            case StaticForce():
                forces[output.name] = output.fraction * static_force(output.reading)
    return forces


def compute_static_force(
    scene: Scene,
    reading: str,
    poses: FloatArray,  # poses, m and rad; shape (n, bodies, 3)
) -> FloatArray:
    """Return the force along a reading that holds the mechanism without rotation of the spindle, by virtual work.

    It is the change of the potential of springs and weights over the change of the reading. Drivers are left out.

    Result: force, N or N m; shape (n,). Infinite at a turning point of the reading. Raises MechanismError if
    the mechanism has another number of degrees of freedom, or at a singular configuration.
    """
    if not len(poses):
        return np.zeros(0)
    part, reading = scene.part_of(reading)
    prefix = "" if len(scene.parts) == 1 else f"{part.name}."
    poses = poses[:, [scene.mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies]]
    undriven_joints = tuple(joint for joint in part.mechanism.joints if not isinstance(joint, TranslationalDriver | RotationalDriver))
    mechanism = replace(part.mechanism, joints=undriven_joints)
    reduction = SingleDofReduction(Scene(title=scene.title, parts=(replace(part, mechanism=mechanism),)))
    coefficients = reduction.evaluate_near(poses, evaluate_output_value(mechanism, mechanism.coordinate, poses))
    reading_derivative = reduction.output_derivative(coefficients, reading)
    force = np.full_like(reading_derivative, np.inf)
    return np.divide(coefficients.potential_derivative, reading_derivative, out=force, where=reading_derivative != 0.0)


def _spring_force(mechanism: Mechanism, name: str, poses: FloatArray) -> FloatArray:
    spring = next((load for load in mechanism.force_elements if load.name == name), None)
    if not isinstance(spring, Spring):
        spring_names = [load.name for load in mechanism.force_elements if isinstance(load, Spring)]
        raise MechanismError(f"there is no spring {name!r} among the force elements; springs are {spring_names}")
    length = OutputDerivatives(rows_of_readings(mechanism, spring.displacements[:1], {}), poses).value
    law, coefficients = element_law(spring)
    force: FloatArray = -law.force(coefficients, length, 0.0)
    return force


def mean_gas_torque(scene: Scene) -> float:
    """Return the mean torque of gas in cylinders over a stroke: its work over half a turn, whatever the connecting rods."""
    gases = [element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas)]
    if not gases:
        raise MechanismError("the mean gas torque is that of an engine; this scene has no gas in cylinders")
    if any(gas.strokes_differ for gas in gases):
        raise MechanismError("the mean gas torque is that of an engine whose throttle and cut-off are at rest; here one moves")
    return work_per_stroke(gases) / math.pi


CONTROL_TOLERANCE = 1e-9
"""Excess over 0 or 1 that counts as rounding of a control at its end."""


_EVALUATED_ELSEWHERE = (
    SpringForce,
    StaticForce,
    JointForce,
    JointMoment,
    ContactForce,
    PathCoordinate,
    PointVelocity,
    PointAcceleration,
    TransmissionAngle,
)
"""Derived readings that other functions evaluate."""


def evaluate_derived_readings(
    scene: Scene,
    history: StateHistory,  # states of its motion, n times; the joints are closed
) -> dict[str, FloatArray]:
    """Return the derived readings (n,) of a scene by name, SI; raise MechanismError as `compute_static_force` does."""
    mechanism = scene.mechanism
    readings = evaluate_static_forces(scene, history.poses) | _evaluate_paths(mechanism, history.poses)
    for output in mechanism.derived_readings:
        match output:
            case ShaftSpeed():
                readings[output.name] = evaluate_output(mechanism, output.reading, history.poses).rate(history.velocities)
            case StoredWork():
                readings[output.name] = _kinetic_energy(mechanism, history) - _kinetic_energy(mechanism, history)[:1]
            case CylinderPressure():
                readings[output.name] = sum((_pressure(scene, name, history) for name in output.elements), np.zeros(len(history.times)))
            case ControlledValue():
                readings[output.name] = _controlled_value(scene, output, history)
            case AppliedTorque():
                readings[output.name] = _applied_torque(scene, output, history)
            case _ if isinstance(output, _EVALUATED_ELSEWHERE):
                continue
            case _:
                raise TypeError(f"no equation is known for derived readings of type {type(output).__name__}")
    return readings


def evaluate_positional_readings(
    scene: Scene,
    poses: FloatArray,  # poses that close the joints, m and rad; shape (n, bodies, 3)
) -> dict[str, FloatArray]:
    """Return the derived readings (n,) that positions determine: forces of springs and weights, pressures of gas without a control."""
    readings, nothing = evaluate_static_forces(scene, poses), np.zeros(len(poses))
    history = StateHistory(
        times=nothing, poses=poses, velocities=np.zeros_like(poses), work=nothing, dissipated_energy=nothing, lags=np.zeros((len(poses), 0))
    )
    for output in scene.mechanism.derived_readings:
        if isinstance(output, CylinderPressure):
            gases = [_gas(scene.mechanism, name) for name in output.elements]
            if all(gas.throttle is None and gas.switch is None for gas in gases):
                readings[output.name] = sum((_pressure(scene, gas.name, history) for gas in gases), nothing)
    return readings


def _evaluate_paths(mechanism: Mechanism, poses: FloatArray) -> dict[str, FloatArray]:
    """Return the coordinates (n,), m, of the points whose paths are requested, at poses (n, bodies, 3)."""
    outputs = [output for output in mechanism.derived_readings if isinstance(output, PathCoordinate)]
    return {output.name: point_path(mechanism, poses, output.point)[:, "xy".index(output.component)] for output in outputs}


def _kinetic_energy(mechanism: Mechanism, history: StateHistory) -> FloatArray:
    """Return the kinetic energy (n,) of all bodies, J."""
    inertias = np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies])
    energy: FloatArray = 0.5 * np.sum(inertias * history.velocities**2, axis=(1, 2))
    return energy


def find_first_control_exit(scene: Scene, history: StateHistory) -> tuple[int, str] | None:
    """Return the index of the first state in which a throttle or a cut-off is set beyond 0 or 1, and what is set, or None."""
    exits = []
    for output in scene.mechanism.derived_readings:
        if isinstance(output, ControlledValue):
            value = _controlled_value(scene, output, history)
            is_outside = np.abs(value - 0.5) > 0.5 + CONTROL_TOLERANCE
            if is_outside.any():
                index = int(np.argmax(is_outside))
                exits.append((index, f"{output.name} {_describe_setting(float(value[index]))}, and it lies between 0 and 1"))
    return min(exits) if exits else None


def _describe_setting(value: float) -> str:
    """Return how a control leaves its range: by how much, unless that shows no more than the location of the exit."""
    excess = max(-value, value - 1.0)
    return f"is set to {value:.6g}" if excess > 1e-6 else f"would be set {'above 1' if value > 0.5 else 'below 0'}"


def _controlled_value(scene: Scene, output: ControlledValue, history: StateHistory) -> FloatArray:
    """Return the value (n,) of a throttle or a cut-off."""
    element = next(one for one in scene.mechanism.force_elements if one.name == output.element)
    if isinstance(element, MeanGasTorque):
        return evaluate_load(scene, element.moment, history) / element.full_torque
    gas = _gas(scene.mechanism, output.element)
    control = gas.switch if output.is_switch else gas.throttle
    return evaluate_load(scene, control or gas.controlled_default(), history)


def _coefficients(scene: Scene, element: ForceElement, history: StateHistory) -> tuple[Any, ...]:
    """Return the coefficients of the law of a force element; that of a switch which moves is an array (n,)."""
    coefficients: tuple[Any, ...] = pad_coefficients(element_law(element)[1])
    if element.switch is None:
        return coefficients
    return (*coefficients[:SWITCH_COEFFICIENT], evaluate_load(scene, element.switch, history), *coefficients[SWITCH_COEFFICIENT + 1 :])


def _gas(mechanism: Mechanism, name: str) -> CylinderGas:
    """Return the gas of a name."""
    gas = next(element for element in mechanism.force_elements if element.name == name)
    if not isinstance(gas, CylinderGas):
        raise TypeError(f"force element {name!r} is no gas in a cylinder")
    return gas


def _pressure(scene: Scene, name: str, history: StateHistory) -> FloatArray:
    """Return the pressure (n,) of the gas of a force element, Pa."""
    gas = _gas(scene.mechanism, name)
    travel, crank_angle = (_value(scene.mechanism, output, history.poses) for output in (gas.travel, gas.crank_angle))
    pressure: FloatArray = gas_pressure(_coefficients(scene, gas, history)[: len(gas.coefficients)], travel, crank_angle)
    return pressure if gas.throttle is None else pressure * evaluate_load(scene, gas.throttle, history)


def _value(mechanism: Mechanism, output: Reading, poses: FloatArray) -> FloatArray:
    """Return an output variable (n,), which the mechanism need not list."""
    return OutputDerivatives(rows_of_readings(mechanism, [output], {}), poses).value


def _applied_torque(scene: Scene, output: AppliedTorque, history: StateHistory) -> FloatArray:
    """Return the torque (n,) of force elements along the coordinate of a part, N m: forces times derivatives of their displacements."""
    mechanism = scene.mechanism
    part, _ = scene.part_of(output.reading)
    prefix = "" if len(scene.parts) == 1 else f"{part.name}."
    bodies = [mechanism.body_index(prefix + body.name) for body in part.mechanism.bodies]
    coordinate = evaluate_output(mechanism, output.reading, history.poses).value
    tangents = np.zeros_like(history.poses)
    tangents[:, bodies] = CoordinateSolver(part.mechanism).solve_nodes(history.poses[:, bodies], coordinate)[:, 1]
    torque = np.zeros(len(history.times))
    for element in (element for element in mechanism.force_elements if element.name in output.elements):
        for displacement, force in zip(element.displacements, _forces(scene, element, history), strict=True):
            torque += force * OutputDerivatives(rows_of_readings(mechanism, [displacement], {}), history.poses).rate(tangents)
    return output.sign * torque


def _forces(scene: Scene, element: ForceElement, history: StateHistory) -> list[FloatArray]:
    """Return the force (n,) of a force element along each of its displacements, N or N m."""
    if element.loads:
        return [evaluate_load(scene, load, history) for load in element.loads]
    mechanism, law = scene.mechanism, element_law(element)[0]
    coefficients = _coefficients(scene, element, history)
    row = OutputDerivatives(rows_of_readings(mechanism, element.displacements[:1], {}), history.poses)
    argument = row.rate(history.velocities) if element.argument is None else _value(mechanism, element.argument, history.poses)
    force = law.force(coefficients, row.value, argument)
    return [force if element.factor is None else force * evaluate_load(scene, element.factor, history)]


def evaluate_load(scene: Scene, load: InputFunction, history: StateHistory) -> FloatArray:
    """Return a given load (n,) at the times and readings of a motion, SI."""
    values: FloatArray = CubicTimeFunction(load)(history.times)
    for function in load.functions:
        values = values + _reading_function(scene, function, history)
    for function in load.factors:
        values = values * _reading_function(scene, function, history)
    if load.hold:
        held = _lag_states(scene, load, history)
        values = np.where(held < NOT_HELD, held, values)
    return values


def _lag_states(scene: Scene, owner: ReadingFunction | InputFunction, history: StateHistory) -> FloatArray:
    """Return the states (n,) of the lag or hold of a function."""
    return history.lags[:, [one is owner for one in lagged_functions_of(scene)].index(True)]


def _reading_function(scene: Scene, function: ReadingFunction, history: StateHistory) -> FloatArray:
    """Return a function (n,) of a reading along a motion; one with a lag has its state."""
    if function.lag:
        return _lag_states(scene, function, history)
    output = evaluate_output(scene.mechanism, function.source, history.poses)
    values = output.rate(history.velocities) if function.is_rate else output.value
    return evaluate_reading_function_along(function, values)


MAX_DERIVATIVE = 1e100
"""Largest rate or acceleration, SI: its square is still a number."""

_RATE_KINDS: Final = {"angle": "angular_speed", "length": "speed", "time": "number"}
_ACCELERATION_KINDS: Final = {"angle": "angular_acceleration", "length": "acceleration", "time": "number"}
"""Kinds of the derivatives by the kind of the reading; time itself has none, and its numbers are not used."""


def analyse_kinematics(
    scene: Scene,
    over: str,
    # values of the reading, SI, or times, s, or texts with a unit; shape (n,)
    values: Sequence[float | str] | FloatArray,
    rate: float | str = 1.0,  # first time derivative of the reading at each value, SI/s, or text with a unit
    # second time derivative of the reading at each value, SI/s2, or text with a unit
    acceleration: float | str = 0.0,
) -> Kinematics:
    """Return the kinematics over values of a reading or over time, with all readings that they determine.

    Result: the motion. Its readings include shaft speeds, forces of springs and weights, and pressures of gas
    without a control. A static force is left out if it is not defined, as where the mechanism has several
    degrees of freedom. Raises MechanismError as `solve_kinematics`; also for a text of another unit, and for
    a rate or acceleration that no machine has.
    """
    kind = _kind_of(scene, over)
    samples = convert_texts(values, kind, over)
    derivatives = [
        _parse_derivative(rate, _RATE_KINDS.get(kind, kind), f"rate of {over}"),
        _parse_derivative(acceleration, _ACCELERATION_KINDS.get(kind, kind), f"acceleration of {over}"),
    ]
    motion = solve_kinematics(scene, over, samples, *derivatives)
    outputs = scene.mechanism.derived_readings
    derived = {one.name: motion.rates[one.reading] for one in outputs if isinstance(one, ShaftSpeed) and one.reading in motion.rates}
    derived |= _evaluate_paths(scene.mechanism, motion.poses)
    with suppress(MechanismError):
        derived |= evaluate_positional_readings(scene, motion.poses)
    return replace(motion, readings={**motion.readings, **derived})


def _kind_of(scene: Scene, over: str) -> str:
    """Return the kind of quantity of a reading or of time; an unknown name is refused later, with the known ones."""
    mechanism = scene.part.mechanism if len(scene.parts) == 1 else scene.mechanism
    kinds = {reading.name: reading.quantity for reading in mechanism.readings}
    return "time" if over == TIME_VARIABLE else kinds.get(over, "number")


def _parse_derivative(value: float | str, kind: str, what: str) -> float:
    """Return a rate or an acceleration, SI."""
    number = parse_quantity(value, kind, what)
    if abs(number) > MAX_DERIVATIVE:
        raise MechanismError(f"{what} must be at most {MAX_DERIVATIVE:g} in SI; found {number:g}")
    return number

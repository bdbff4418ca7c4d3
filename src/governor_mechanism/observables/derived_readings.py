"""Readings that follow from the state of a mechanism, and along which nothing acts."""

import numpy as np

from governor_mechanism.effects.gas_pressure import gas_pressure
from governor_mechanism.mechanics.dynamics.contacts import reading_functions_of
from governor_mechanism.mechanics.dynamics.force_elements import element_law
from governor_mechanism.mechanics.dynamics.inputs import evaluate_reading_function, output_of_reading
from governor_mechanism.mechanics.dynamics.output_forces import pad_coefficients
from governor_mechanism.mechanics.kinematics.coordinate_assembly import CoordinateSolver
from governor_mechanism.mechanics.kinematics.output_rows import rows_of_readings
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import CylinderGas, ForceElement
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import (
    AppliedTorque,
    CylinderPressure,
    Reading,
    ShaftSpeed,
    SpringForce,
    StaticForce,
    StoredWork,
    ThrottleOpening,
)
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.observables.static_forces import evaluate_static_forces
from governor_mechanism.types import FloatArray

THROTTLE_TOLERANCE = 1e-9
"""Opening beyond 0 and 1 that counts as rounding of a control at its end."""


def evaluate_derived_readings(scene: Scene, history: StateHistory) -> dict[str, FloatArray]:
    """Return the derived readings of a scene by name.

    Parameters
    ----------
    scene
        The scene.
    history
        States of its motion, n times; the joints are closed.

    Returns
    -------
    dict[str, FloatArray]
        Values, SI; shape (n,) each.

    Raises
    ------
    MechanismError
        As `compute_static_force` does.
    """
    mechanism = scene.mechanism
    readings = evaluate_static_forces(scene, history.poses)
    for output in mechanism.derived_readings:
        match output:
            case ShaftSpeed():
                readings[output.name] = evaluate_output(mechanism, output.reading, history.poses).rate(history.velocities)
            case StoredWork():
                readings[output.name] = _kinetic_energy(mechanism, history) - _kinetic_energy(mechanism, history)[:1]
            case CylinderPressure():
                readings[output.name] = sum((_pressure(scene, name, history) for name in output.elements), np.zeros(len(history.times)))
            case ThrottleOpening():
                readings[output.name] = evaluate_load(scene, _gas(mechanism, output.element).throttle or InputFunction(), history)
            case AppliedTorque():
                readings[output.name] = _applied_torque(scene, output, history)
            case SpringForce() | StaticForce():
                continue
            case _:
                raise TypeError(f"no equation is known for derived readings of type {type(output).__name__}")
    return readings


def _kinetic_energy(mechanism: Mechanism, history: StateHistory) -> FloatArray:
    """Return the kinetic energy (n,) of all bodies, J."""
    inertias = np.array([[body.mass, body.mass, body.planar_inertia] for body in mechanism.bodies])
    energy: FloatArray = 0.5 * np.sum(inertias * history.velocities**2, axis=(1, 2))
    return energy


def find_first_control_exit(scene: Scene, history: StateHistory) -> tuple[int, str] | None:
    """Return the index of the first state in which a throttle is set beyond closed or open, and what is set, or None.

    Parameters
    ----------
    scene
        The scene.
    history
        States of its motion.

    Returns
    -------
    tuple[int, str] | None
        Index and sentence.
    """
    exits = []
    for output in scene.mechanism.derived_readings:
        if isinstance(output, ThrottleOpening):
            opening = evaluate_load(scene, _gas(scene.mechanism, output.element).throttle or InputFunction(), history)
            is_outside = np.abs(opening - 0.5) > 0.5 + THROTTLE_TOLERANCE
            if is_outside.any():
                index = int(np.argmax(is_outside))
                exits.append((index, f"{output.name} is set to {opening[index]:.6g}, and it lies between 0, closed, and 1, open"))
    return min(exits) if exits else None


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
    pressure: FloatArray = gas_pressure(gas.coefficients, travel, crank_angle)
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
    mechanism, (law, coefficients) = scene.mechanism, element_law(element)
    row = OutputDerivatives(rows_of_readings(mechanism, element.displacements[:1], {}), history.poses)
    argument = row.rate(history.velocities) if element.argument is None else _value(mechanism, element.argument, history.poses)
    force = law.force(pad_coefficients(coefficients), row.value, argument)
    return [force if element.factor is None else force * evaluate_load(scene, element.factor, history)]


def evaluate_load(scene: Scene, load: InputFunction, history: StateHistory) -> FloatArray:
    """Return a given load (n,) at the times and readings of a motion, SI."""
    values: FloatArray = CubicTimeFunction(load)(history.times)
    for function in load.functions:
        values = values + _reading_function(scene, function, history)
    for function in load.factors:
        values = values * _reading_function(scene, function, history)
    return values


def _reading_function(scene: Scene, function: ReadingFunction, history: StateHistory) -> FloatArray:
    """Return a function (n,) of a reading along a motion; one with a lag has the state of the lag."""
    lagged = [one for one in reading_functions_of(scene) if one.lag]
    if function.lag:
        return history.lags[:, [one is function for one in lagged].index(True)]
    name, is_rate = output_of_reading(function.reading)
    output = evaluate_output(scene.mechanism, name, history.poses)
    values = output.rate(history.velocities) if is_rate else output.value
    return np.array([evaluate_reading_function(function, value) for value in values.tolist()])

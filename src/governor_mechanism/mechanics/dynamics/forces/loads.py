"""Loads of a scene, the functions of readings in them, and the states of lags and holds at the start."""

import math

import numpy as np

from governor_mechanism.effects.gas_pressure import travel_in_stroke
from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.forces.inputs import NOT_HELD, evaluate_reading_function
from governor_mechanism.mechanics.kinematics.output_variables import OutputDerivatives, evaluate_output, rows_of_readings
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import CylinderGas
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction, StrokeHold, TableFunction
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import FloatArray


@once_per_object
def loads_of(scene: Scene) -> tuple[InputFunction, ...]:
    """Return the loads in the order of the inputs of a system: those of force elements with their factors, then the friction forces."""
    element_loads = [load for element in scene.mechanism.force_elements for load in element.inputs]
    return (*element_loads, *(contact.friction for contact in contacts_of(scene) if contact.friction is not None))


@once_per_object
def reading_functions_of(scene: Scene) -> tuple[ReadingFunction, ...]:
    """Return the functions of readings in the loads of a scene, in the order of the loads."""
    return tuple(function for load in loads_of(scene) for function in (*load.functions, *load.factors))


@once_per_object
def lagged_functions_of(scene: Scene) -> tuple[ReadingFunction | InputFunction, ...]:
    """Return the functions of readings with a lag and the loads that are held, in the order of their states."""
    found = list[ReadingFunction | InputFunction]()
    for load in loads_of(scene):
        found += [function for function in (*load.functions, *load.factors) if function.lag]
        found += [load] if load.hold else []
    return tuple(found)


def reading_tables_of(scene: Scene) -> tuple[TableFunction, ...]:
    """Return the tables of readings in the loads of a scene, in the order of the loads; their kinks are events."""
    return tuple(function for function in reading_functions_of(scene) if isinstance(function, TableFunction))


def has_kinks(scene: Scene) -> bool:
    """Return whether forces have kinks at which steps end though no mode changes: those of gas in cylinders."""
    return any(isinstance(element, CylinderGas) for element in scene.mechanism.force_elements)


def initial_lags(
    scene: Scene,
    poses: FloatArray,  # poses of the mass centres at the start, m and rad; shape (bodies, 3)
    velocities: FloatArray,  # their time derivatives; shape (bodies, 3)
) -> FloatArray:
    """Return the states (lags,) of lags and holds at the start: those of the state from which the scene goes on, if there is one."""
    # Else each begins at the value that it follows, unless its cut-off is still ahead.

    def evaluate(function: ReadingFunction) -> float:
        output = evaluate_output(scene.mechanism, function.source, poses)
        value = np.sum(output.gradient * velocities) if function.is_rate else output.value
        return evaluate_reading_function(function, float(value))

    def evaluate_held(load: InputFunction) -> float:
        total = float(CubicTimeFunction(load)(np.zeros(1))[0]) + sum(evaluate(function) for function in load.functions)
        value = total * math.prod(evaluate(function) for function in load.factors)
        is_ahead = load.hold is StrokeHold.FROM_CUT_OFF and _travel_in_stroke(scene, load, poses) < value
        return NOT_HELD if is_ahead else value

    lagged = lagged_functions_of(scene)
    if scene.state is not None and len(scene.state.lags) == len(lagged):
        return np.array(scene.state.lags)
    return np.array([evaluate(owner) if isinstance(owner, ReadingFunction) else evaluate_held(owner) for owner in lagged])


def _travel_in_stroke(scene: Scene, switch: InputFunction, poses: FloatArray) -> float:
    """Return the travel since the last dead centre, relative to the stroke, of the piston whose gas has a switch."""
    gases = (element for element in scene.mechanism.force_elements if isinstance(element, CylinderGas))
    gas = next(one for one in gases if one.switch is switch)
    rows = (rows_of_readings(scene.mechanism, [reading], {}) for reading in (gas.travel, gas.crank_angle))
    travel, crank_angle = (float(OutputDerivatives(row, poses).value) for row in rows)
    return float(travel_in_stroke(1.0 / gas.stroke, travel, crank_angle))

"""Loads that depend on readings, sampled over a run for its drawing."""

from collections.abc import Callable

import numpy as np

from governor_mechanism.mechanics.dynamics.inputs import evaluate_reading_function
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.part import Part
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.render.part_entries import select_part_entries
from governor_mechanism.types import FloatArray

TimeFunction = Callable[[FloatArray], FloatArray]
"""A value over time."""
LoadFunctions = tuple[TimeFunction, ...]
"""The two components of a force over time, or a torque."""


def load_inputs(load: Force | Torque) -> tuple[InputFunction, ...]:
    """Return the components of a force, or a torque."""
    return (load.x, load.y) if isinstance(load, Force) else (load.moment,)


def reading_load_functions(run: Trajectory, part: Part) -> dict[str, LoadFunctions]:
    """Return the forces and torques of a part that depend on readings, by plain name, linear between the reported times."""
    loads = {load.name: load for load in run.scene.mechanism.force_elements if isinstance(load, Force | Torque)}
    return {
        name: tuple(_sampled_function(run, one) for one in load_inputs(load))
        for name, load in select_part_entries(run, part, loads).items()
        if any(one.depends_on_readings for one in load_inputs(load))
    }


def _sampled_function(run: Trajectory, load: InputFunction) -> TimeFunction:
    values = CubicTimeFunction(load)(run.times)
    for function in load.functions:
        values = values + _sample(run, function)
    for factor in load.factors:
        values = values * _sample(run, factor)
    return lambda times: np.interp(times, run.times, values)


def _sample(run: Trajectory, function: ReadingFunction) -> FloatArray:
    """Return a function of a reading at the reported times; a lag follows it from its first value on."""
    values = np.array([evaluate_reading_function(function, float(value)) for value in run.readings[function.reading]])
    if function.lag:
        for k, decay in enumerate(np.exp(-np.diff(run.times) / function.lag), start=1):
            values[k] += decay * (values[k - 1] - values[k])
    return values

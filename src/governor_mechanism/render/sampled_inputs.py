"""Loads of a run at its reported times, from their values over time and the readings they follow."""

import numpy as np

from governor_mechanism.mechanics.dynamics.forces.inputs import evaluate_reading_function_along
from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.time_functions import InputFunction, ReadingFunction
from governor_mechanism.types import FloatArray


def sample_input(run: Trajectory, load: InputFunction) -> FloatArray:
    """Return a load (n,) at the reported times, SI."""
    values = CubicTimeFunction(load)(run.times)
    for function in load.functions:
        values = values + sample_reading_function(run, function)
    for factor in load.factors:
        values = values * sample_reading_function(run, factor)
    return values


def sample_reading_function(run: Trajectory, function: ReadingFunction) -> FloatArray:
    """Return a function of a reading (n,) at the reported times, SI; a lag follows it from its first value on."""
    values = evaluate_reading_function_along(function, run.readings[function.reading])
    if function.lag:
        for k, decay in enumerate(np.exp(-np.diff(run.times) / function.lag), start=1):
            values[k] += decay * (values[k - 1] - values[k])
    return values

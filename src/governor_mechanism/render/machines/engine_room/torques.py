"""Torque of an engine and of its load over a run, and the times at which the load jumps."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import CubicHermiteSpline

from governor_mechanism.mechanics.kinematics.time_functions import CubicTimeFunction
from governor_mechanism.model.force_elements import Torque
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.render.machines.engine_room.arrangement import EngineRoomParts, governor_functions
from governor_mechanism.render.sampled_inputs import sample_input
from governor_mechanism.types import FloatArray

MIN_SAMPLES_PER_TURN = 12
"""Reported times in a turn from which on the mean over a turn is good to some percent."""


def load_torque(run: Trajectory, governed: EngineRoomParts) -> FloatArray:
    """Return the torque (n,) with which the load resists the shaft, N m: that of the engine's reading, or what no governor moves."""
    reading = run.readings.get(f"{governed.engine.name}.load_torque")
    if reading is not None:
        return reading
    return -np.asarray(sum((sign * _given_torque(run, governed, load) for sign, load in _torques(run, governed)), np.zeros(len(run.times))))


def engine_torque(run: Trajectory, governed: EngineRoomParts) -> tuple[FloatArray, FloatArray]:
    """Return times (m,) s and the torque of the engine there, N m: the mean over a turn, and so without half a turn at both ends.

    The mean over a turn follows from the work of the load and the energy of the engine, which few reported times give well; the small
    torque that drives the governor is taken off. A torque that does not come from gas in cylinders is shown as it is, and so is one with
    few reported times in a turn.
    """
    torque, stored = (run.readings.get(f"{governed.engine.name}.{name}") for name in ("gas_torque", "stored_work"))
    if torque is None:
        whole = sum((sign * sample_input(run, load) for sign, load in _torques(run, governed)), np.zeros(len(run.times)))
        return run.times, whole + load_torque(run, governed)
    if stored is None:
        return run.times, torque
    work = stored + cumulative_trapezoid(load_torque(run, governed), run.readings[governed.crank_angle], initial=0.0)
    changes = _changes_over_turns(run, governed, work, torque)
    return (run.times, torque) if changes is None else (changes[0], changes[1] / (2 * np.pi))


def mean_speed(run: Trajectory, governed: EngineRoomParts) -> tuple[FloatArray, FloatArray] | None:
    """Return times (m,) s and the mean speed of the turn around each, rad/s.

    None for a torque that does not come from gas in cylinders, for few turns, and for few reported times in a turn.
    """
    if f"{governed.engine.name}.gas_torque" not in run.readings or not bool(np.all(run.rates[governed.crank_angle] > 0)):
        return None
    durations = _changes_over_turns(run, governed, run.times, 1.0 / run.rates[governed.crank_angle])
    return None if durations is None else (durations[0], 2 * np.pi / durations[1])


def _changes_over_turns(
    run: Trajectory, governed: EngineRoomParts, values: FloatArray, slopes: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return times (m,) s, half a turn or more from both ends, and by how much values (n,) change over the turn around each.

    `slopes` (n,) are their derivatives with respect to the crank angle, 1/rad. Few turns, or few reported times in one, give None.
    """
    angles = run.readings[governed.crank_angle]
    turns = float(np.ptp(angles)) / (2 * np.pi)
    if turns < 2 or len(angles) < MIN_SAMPLES_PER_TURN * turns or not bool(np.all(np.diff(angles) > 0)):
        return None
    inside = (angles >= angles[0] + np.pi) & (angles <= angles[-1] - np.pi)
    curve = CubicHermiteSpline(angles, values, slopes)
    before, after = (curve(angles[inside] + half_turn) for half_turn in (-np.pi, np.pi))
    return run.times[inside], after - before


def load_steps(run: Trajectory, governed: EngineRoomParts) -> list[float]:
    """Return the times within the run at which the load jumps, s."""
    steps = {end for _, load in _torques(run, governed) for start, end in pairwise(load.times) if start == end}
    return sorted(time for time in steps if run.times[0] < time < run.times[-1])


def _torques(run: Trajectory, governed: EngineRoomParts) -> list[tuple[float, InputFunction]]:
    """Return the torques on the shaft, each with 1 if it acts on the shaft in its sense, and else -1."""
    elements = [element for element in run.scene.mechanism.force_elements if isinstance(element, Torque)]
    return [
        (1.0 if element.second == governed.shaft_body else -1.0, element.moment)
        for element in elements
        if governed.shaft_body in (element.first, element.second)
    ]


def _given_torque(run: Trajectory, governed: EngineRoomParts, load: InputFunction) -> FloatArray:
    """Return what is left of a torque (n,) without the functions of the governor, N m; nothing of one that the governor scales."""
    followed = governor_functions(load, governed.governor)
    if any(factor in followed for factor in load.factors):
        return np.zeros(len(run.times))
    own_functions = tuple(function for function in load.functions if function not in followed)
    if not own_functions and not load.factors:
        return np.asarray(CubicTimeFunction(load)(run.times))
    return sample_input(run, replace(load, functions=own_functions))

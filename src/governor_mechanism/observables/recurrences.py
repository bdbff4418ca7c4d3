"""Named crossings that recur in a run: how often, and what readings and energies do from one to the next."""

from collections.abc import Mapping

import numpy as np

from governor_mechanism.mechanics.kinematics.output_variables import READING_UNITS, OutputDerivatives, evaluate_output, rows_of_readings
from governor_mechanism.model.events import NamedCrossing
from governor_mechanism.model.force_elements import Force, Torque
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.results.records import Recurrence
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.mechanical_energy import evaluate_mechanical_energy
from governor_mechanism.observables.sampled_motion import BodyState, SampledMotion
from governor_mechanism.types import FloatArray

LARGEST_INTERVAL_RATIO = 1.1
"""Longest interval between crossings, relative to the shortest, up to which they recur: beyond it a mean says little."""

LEAST_ADVANCE = 0.5
"""Least way of a reading from the first to the last crossing, relative to its range, with which it goes on and does not come back."""


def are_regular(crossing: NamedCrossing, times: FloatArray) -> bool:
    """Return whether a crossing recurs at times (n,) s that lie about equally far apart."""
    period = _period_of(crossing)
    if len(times) < period + 2:
        return False
    periods = times[period:] - times[:-period]
    return bool(np.max(periods) <= LARGEST_INTERVAL_RATIO * np.min(periods))


def _period_of(crossing: NamedCrossing) -> int:
    """Return the number of crossings in a period: two where both directions count."""
    return 2 if crossing.direction == "both" else 1


def describe_recurrence(
    scene: Scene,
    motion: SampledMotion,
    crossing: NamedCrossing,
    times: FloatArray,  # times of its crossings, s; shape (n,)
    errors: Mapping[str, float],  # certified errors of the readings, SI; empty without a certificate
) -> Recurrence:
    """Return the means from one crossing to the next over whole periods."""
    # Readings and energies are taken in the middle between two crossings: at a crossing itself a clock
    # may be driving its pendulum.
    period = _period_of(crossing)
    used, middles = _whole_periods(times, period), _whole_periods(0.5 * (times[:-1] + times[1:]), period)
    poses, velocities = _states_at(motion, middles[[0, -1]])
    between = motion.poses[(motion.times >= middles[0]) & (motion.times <= middles[-1])]
    advances, work = _find_advances(scene, poses, between), _work_of_loads(scene, poses)
    start_energy, end_energy = np.sum(evaluate_mechanical_energy(scene, poses, velocities), axis=0).tolist()
    n_intervals = len(middles) - 1
    return Recurrence(
        count=len(times),
        interval=float(used[-1] - used[0]) / (len(used) - 1),
        interval_error=_interval_error(scene, motion, crossing.reading, used, errors),
        advances={name: way / n_intervals for name, way in advances.items()},
        units={name: READING_UNITS[scene.mechanism.reading(name).quantity] for name in advances},
        supplied=None if work is None else work / n_intervals,
        lost=None if work is None else (work - (end_energy - start_energy)) / n_intervals,
    )


def _whole_periods(times: FloatArray, period: int) -> FloatArray:
    """Return the times without those at the start that make no whole period."""
    return times[(len(times) - 1) % period :]


def _states_at(motion: SampledMotion, times: FloatArray) -> BodyState:
    """Return poses and velocities (n, bodies, 3) at times (n,) s."""
    intervals = np.clip(np.searchsorted(motion.times, times, side="right") - 1, 0, len(motion.times) - 2)
    poses, velocities = motion.interpolate(intervals, times)
    for k in np.flatnonzero(~motion.is_smooth(intervals, intervals + 1)).tolist():
        if (state := motion.dense_output(int(intervals[k]), float(times[k]))) is not None:
            poses[k], velocities[k] = state
    return poses, velocities


def _interval_error(scene: Scene, motion: SampledMotion, reading: str, times: FloatArray, errors: Mapping[str, float]) -> float | None:
    """Return a bound of the error (s) of the mean interval, from those of the first and the last crossing; None of a speed, or unknown."""
    if reading not in errors or reading not in [one.name for one in scene.mechanism.readings]:
        return None
    poses, velocities = _states_at(motion, times[[0, -1]])
    rates = np.abs(evaluate_output(scene.mechanism, reading, poses).rate(velocities))
    return float(np.sum(errors[reading] / rates)) / (len(times) - 1) if np.all(rates > 0.0) else None


def _find_advances(scene: Scene, poses: FloatArray, between: FloatArray) -> dict[str, float]:
    """Return by name how far readings that do not come back go from the first to the last of two poses (2, bodies, 3)."""
    # Others (n, bodies, 3) lie between them. The angle of a line is none of them: it does not count
    # full turns.
    advances = dict[str, float]()
    for reading in scene.mechanism.readings:
        start, end = evaluate_output(scene.mechanism, reading.name, poses).value.tolist()
        inner = evaluate_output(scene.mechanism, reading.name, between).value
        if not isinstance(reading, LineAngle) and abs(end - start) > LEAST_ADVANCE * np.ptp([start, *inner, end]):
            advances[reading.name] = end - start
    return advances


def _work_of_loads(scene: Scene, poses: FloatArray) -> float | None:
    """Return the work (J) of forces and torques between two poses (2, bodies, 3); None where the poses do not give it."""
    # That is so with drivers, spindles, gas in cylinders, and loads that change.
    mechanism, work = scene.mechanism, 0.0
    if scene.system.planes or any(part.mechanism.count_drivers() for part in scene.parts):
        return None
    for element in mechanism.force_elements:
        if not isinstance(element, Force | Torque) or not all(load.is_constant for load in element.inputs):
            if element.inputs:
                return None
            continue
        for load, displacement in zip(element.loads, element.displacements, strict=True):
            start, end = OutputDerivatives(rows_of_readings(mechanism, [displacement], {}), poses).value.tolist()
            work += load.values[0] * (end - start)
    return work

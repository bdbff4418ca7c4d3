"""The time at which a motion leaves the range in which its description is valid, also between two monitor times; for all engines."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from governor_mechanism.machines.custom import CUSTOM_MACHINE
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_limited_readings
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import ControlledValue
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import find_first_control_exit
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray

CUBIC_ERROR_FACTOR = 1 / 384
"""Largest error of a cubic Hermite interpolant, relative to the fourth derivative times the fourth power of the interval."""


@dataclass(frozen=True)
class Excursion:
    """Excursion beyond a limit: index of the sample after it, the time (s) at which it is farthest, and the sentence that describes it."""

    index: int
    time: float
    sentence: str


def find_first_excursion(
    mechanism: Mechanism,
    states: StateHistory,
    # times of contact events, s; shape (events,). An interval with an event is not smooth and is left out.
    # The motion begins after the events of its start
    event_times: FloatArray,
    # accuracy of the states relative to the scales: a motion within it of a limit has not passed it
    accuracy: float,
) -> Excursion | None:
    """Return the first excursion beyond a limit between two monitor times, or None."""
    times, excursions = states.times, list[Excursion]()
    if len(times) < 2 or not mechanism.limits:
        return None
    is_smooth = np.ones(len(times) - 1, dtype=np.bool_)
    for side in ("left", "right"):  # an event at a monitor time may belong to either interval
        is_smooth[np.clip(np.searchsorted(times, event_times[event_times > times[0]], side) - 1, 0, len(times) - 2)] = False
    longest = np.max(np.diff(times))
    for limit, value, rate in zip(mechanism.limits, *evaluate_limited_readings(mechanism, states.poses, states.velocities), strict=True):
        tolerance = accuracy * mechanism.output_scale(limit.reading)
        reach = float(np.max(np.abs(rate)) * longest)
        for excess, rise, message in ((limit.low - value, -rate, limit.low_message), (value - limit.high, rate, limit.high_message)):
            if np.max(excess) + reach <= tolerance:
                continue
            largest, largest_times = _largest_within(times, excess, rise)
            is_outside = is_smooth & (largest > tolerance)
            if is_outside.any():
                k = int(np.argmax(is_outside))
                excursions.append(Excursion(k + 1, float(largest_times[k]), f"{limit.reading}: {message}"))
    return min(excursions, key=lambda one: one.time, default=None)


def _largest_within(times: FloatArray, values: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the least certain value and the time (s), each (n - 1,), of a maximum within each interval by cubic interpolation, or -inf."""
    lengths, change = np.diff(times), np.diff(values)
    start, end = lengths * rates[:-1], lengths * rates[1:]
    cubic, quadratic = start + end - 2 * change, 3 * change - 2 * start - end
    has_maximum = (start > 0.0) & (end < 0.0)
    with np.errstate(all="ignore"):  # where there is no maximum
        fraction = start / (np.sqrt(quadratic**2 - 3 * cubic * start) - quadratic)
        maximum = values[:-1] + fraction * (start + fraction * (quadratic + fraction * cubic))
    # The third derivative differs from one interval to the next by the fourth times their distance.
    third = np.pad(6 * cubic / lengths**3, 1, mode="edge")
    jump = np.maximum(np.abs(third[1:-1] - third[:-2]), np.abs(third[2:] - third[1:-1]))
    error = CUBIC_ERROR_FACTOR * jump * lengths**3
    result: FloatArray = np.where(has_maximum, maximum - error, -np.inf)
    return result, times[:-1] + np.where(has_maximum, fraction, 0.0) * lengths


MAX_BISECTIONS = 60
"""Largest number of bisections of an exit: to rounding, whatever the distance of the samples."""

StateAt = Callable[[int, float], StateHistory | None]
"""Function of a sample and a time (s) after it that returns the one state there, or None if the motion ends before."""


Mode = TypeVar("Mode")
"""Contact mode of an engine."""


@dataclass(frozen=True)
class LastStep(Generic[Mode]):
    """Step in which a motion ends: its start (s), state and mode there, and a later time (s) and state at which it is outside its range."""

    start: float
    state: FloatArray
    outside: float
    outside_state: FloatArray
    mode: Mode

    def continue_samples(self, times: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return those of some sampled times (n,) s and states (n, components) that precede this step, and both its ends."""
        n_before = int(np.searchsorted(times, self.start, side="right"))
        all_times = np.concatenate([times[:n_before], [self.start, self.outside]])
        return all_times, np.concatenate([states[:n_before], self.state[np.newaxis], self.outside_state[np.newaxis]])


@dataclass(frozen=True)
class Exit:
    """First time (s) at which a motion is outside its range, how the run ends there, and what happens."""

    time: float
    outcome: Outcome
    sentence: str

    @property
    def detail(self) -> str:
        """What happens, and when."""
        return f"{self.sentence}, at t = {self.time:.9g} s"


def find_first_exit(
    evaluator: ReadingEvaluator,
    states: StateHistory,  # states at the samples, from the start on; n times
    state_at: StateAt,
    # times of contact events, s; shape (events,); None where the steps themselves have watched the limits
    event_times: FloatArray | None,
    # accuracy of the states relative to the scales: a motion that turns back within it of a limit has not
    # passed it
    accuracy: float,
) -> Exit | None:
    """Return where a sampled motion first leaves a limit, sets a control beyond its range, or stalls a shaft, by bisection, or None."""
    found = find_first_outside(evaluator, states)
    index = found[0] if found is not None else len(states.times)
    excursion = None
    if event_times is not None:
        excursion = find_first_excursion(evaluator.mechanism, states.at(slice(index)), event_times, accuracy)
    if excursion is not None:
        outside = excursion.time
        index = excursion.index
        exit_ = Exit(excursion.time, Outcome.LEFT_RANGE, excursion.sentence)
    elif found is not None:
        outside = float(states.times[index])
        exit_ = Exit(float(states.times[index]), found[1], found[2])
    else:
        return None
    return exit_ if index == 0 else _locate_exit(evaluator, state_at, index - 1, (float(states.times[index - 1]), outside), exit_)


def is_searched_between_samples(scene: Scene) -> bool:
    """Return whether events, change points, controls or stalls of a motion are searched for between its samples."""
    # With contacts alone nothing is: they are events of the steps, which watch the limits too.
    mechanism = scene.mechanism
    is_custom = any(part.machine == CUSTOM_MACHINE for part in scene.parts)
    has_control = any(isinstance(reading, ControlledValue) for reading in mechanism.derived_readings)
    return not has_contacts(scene) or is_custom or has_control or bool(scene.crossings or mechanism.stall_limits)


def find_first_outside(evaluator: ReadingEvaluator, states: StateHistory) -> tuple[int, Outcome, str] | None:
    """Return the index of the first state outside the range of the motion, how a run ends there, and what happens, or None."""
    # Of several exits in one state a limit counts first, then a control, then a shaft.
    if not len(states.times):
        return None
    found = {
        Outcome.LEFT_RANGE: evaluator.find_first_out_of_range(states.poses),
        Outcome.CONTROL_OUT_OF_RANGE: find_first_control_exit(evaluator.scene, states),
        Outcome.SHAFT_STALLED: evaluator.find_first_stall(states.poses, states.velocities),
    }
    exits = [(one[0], outcome, one[1]) for outcome, one in found.items() if one is not None]
    return min(exits, key=lambda one: one[0], default=None)


def _locate_exit(evaluator: ReadingEvaluator, state_at: StateAt, sample: int, span: tuple[float, float], exit_: Exit) -> Exit:
    """Return an exit between a time inside and one outside (s), located by bisection; an unknown state is outside."""
    inside, outside = span
    for _ in range(MAX_BISECTIONS):
        middle = 0.5 * (inside + outside)
        if not inside < middle < outside:
            break
        state = state_at(sample, middle)
        found = None if state is None else find_first_outside(evaluator, state)
        if state is not None and found is None:
            inside = middle
            continue
        outside = middle
        if found is not None:
            exit_ = Exit(middle, found[1], found[2])
    return Exit(outside, exit_.outcome, exit_.sentence)


def count_before(times: FloatArray, exit_time: float) -> int:
    """Return the number of times (n,) s before an exit (s)."""
    return int(np.searchsorted(times, exit_time, side="left"))

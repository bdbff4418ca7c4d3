"""Integration over an interval along a motion table that grows with the motion, and how it ends where the table cannot grow."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.certificate import describe_end
from governor_mechanism.engines.reduced.integration import ReducedEquation, ReducedSettings, integrate_reduced
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.equation import StepBuffers
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.mechanics.contact.transition import EventLog
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.reduced_model import StateIndex
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.types import FloatArray, IntArray

NEWTON_STEPS = 5
"""Steps that locate the end of a tail: each doubles the digits, and the first guess has half of them."""


PLACES_AND_RATES = ((StateIndex.COORDINATE, StateIndex.RATE), (StateIndex.SHAFT_ANGLE, StateIndex.SHAFT_SPEED))
"""Components of a state that are places, each with its rate."""


@dataclass(frozen=True)
class Tail:
    """Motion beyond the end of a table, by cubics through the states at two times (s) before it and their derivatives (components,)."""

    times: tuple[float, float]
    states: tuple[FloatArray, FloatArray]
    derivatives: tuple[FloatArray, FloatArray]

    @property
    def acceleration_slope(self) -> float:
        """Change of the acceleration of the coordinate by the coordinate, 1/s2; 0 if both states are one."""
        travel = float(self.states[1][StateIndex.COORDINATE] - self.states[0][StateIndex.COORDINATE])
        change = float(self.derivatives[1][StateIndex.RATE] - self.derivatives[0][StateIndex.RATE])
        return change / travel if travel != 0.0 else 0.0

    def evaluate(self, times: FloatArray) -> FloatArray:
        """Return the states (n, components) at times (n,) s."""
        (first, last), (start, end) = self.times, self.states
        if first == last:
            return end + (times - last)[:, np.newaxis] * self.derivatives[1]
        length = last - first
        fractions = ((times - first) / (last - first))[:, np.newaxis]
        start_slope = length * self.derivatives[0]
        end_slope = length * self.derivatives[1]
        cubic = start_slope + end_slope - 2 * (end - start)
        quadratic = 3 * (end - start) - 2 * start_slope - end_slope
        states: FloatArray = start + fractions * (start_slope + fractions * (quadratic + fractions * cubic))
        for place, rate in PLACES_AND_RATES:  # the integral of the cubic of a rate is more accurate than the cubic of its place
            f = fractions[:, 0]
            powers = np.array([start[rate], start_slope[rate], quadratic[rate], cubic[rate]])
            states[:, place] = end[place] + length * sum(power * (f ** (n + 1) - 1) / (n + 1) for n, power in enumerate(powers))
        return states

    def locate(self, coordinate: float, guess: float) -> float:
        """Return the time (s) near a guess at which the coordinate has a value, SI."""
        time = guess
        for _ in range(NEWTON_STEPS):
            value, rate = self.evaluate(np.array([time]))[0, :2].tolist()
            if rate == 0.0:
                return guess
            time -= (value - coordinate) / rate
        return time if abs(time - guess) < guess - self.times[1] else guess


@dataclass(frozen=True)
class PassageEnd:
    """How an integration ended: status, last step (s), number of times reached, time of the end (s), the side left last.

    `stops_short` is whether the motion turns back between the end of the table and the bound of the coordinate. Where the table ends,
    `tail` continues the motion to the bound of the coordinate.
    """

    status: IntegrationStatus
    step: float
    n_reached: int
    time: float
    side: int
    stops_short: bool = False
    tail: "Tail | None" = None


def integrate_passage(
    motion_table: MotionTable,
    # function that returns the equation along the table from a time (s) on
    make_equation: Callable[[float], ReducedEquation],
    buffers: StepBuffers,
    span: tuple[float, float],  # start and end, s
    times: FloatArray,  # reported times within the span, s; shape (n,)
    state: FloatArray,  # state at the start; changed in place; shape (N_STATES,)
    step_limits: StepLimits,
    states: FloatArray,  # result: states at the times; shape (n, N_STATES)
    modes: IntArray,  # result: contact modes at the times; shape (n, modes)
    event_log: EventLog,
    *,
    time_scale: float,  # characteristic time of the scene, s
    settings: ReducedSettings,
) -> PassageEnd:
    """Integrate the reduced model over a span and extend its table where the motion leaves it; TABLE_ENDED where that ends."""
    time, end = span
    step = step_limits.step
    n_filled = 0
    side = 0
    last_time = -math.inf
    table = motion_table.table
    equation = make_equation(time)
    approach: tuple[float, FloatArray, FloatArray] | None = None
    while time < end:
        outputs = times[n_filled:], state, step_limits._replace(step=step), states[n_filled:], modes[n_filled:], event_log
        status, step, n_reached, time = integrate_reduced(equation, buffers, (time, end), span[0], *outputs, False)
        n_filled += n_reached
        if status not in (IntegrationStatus.BELOW_TABLE, IntegrationStatus.ABOVE_TABLE):
            return PassageEnd(IntegrationStatus(status), step, n_filled, time, side)
        side = status - IntegrationStatus.BELOW_TABLE
        if motion_table.extend(side):
            if motion_table.table is not table:  # its arrays have grown
                table, equation = motion_table.table, make_equation(span[0])
            continue
        scale = motion_table.arrays.assembly.coordinate_scale
        travel_left = motion_table.edge(side) - state[0]
        time_left = _time_at_rate(travel_left, state[1])
        distance_scale = max(scale, abs(state[0]))
        step, is_end = _approach_table_end(
            travel_left, time_left, step, time > last_time, distance_scale, max(time_scale, end - time), settings
        )
        last_time, derivative = time, buffers.stages.derivatives[:, 0]
        approach = approach or (time, state.copy(), derivative.copy())
        if is_end:
            edge = motion_table.edge(side)
            acceleration = float(derivative[1])
            end_coordinate = motion_table.end_coordinate(side)
            tail = Tail((approach[0], time), (approach[1], state.copy()), (approach[2], derivative.copy()))
            stops_short, time_left = _find_motion_end(edge, end_coordinate, state[0], state[1], acceleration, tail.acceleration_slope)
            if not stops_short and time_left > 0.0:
                return PassageEnd(
                    IntegrationStatus.TABLE_ENDED, step, n_filled, tail.locate(end_coordinate, time + time_left), side, tail=tail
                )
            return PassageEnd(IntegrationStatus.TABLE_ENDED, step, n_filled, time + time_left, side, stops_short)
    return PassageEnd(IntegrationStatus.DONE, step, n_filled, time, side)


def _time_at_rate(travel: float, rate: float) -> float:
    """Return the time (s) of a travel at a rate; 0 if the rate does not lead there."""
    return max(travel / rate, 0.0) if rate != 0.0 else 0.0


def _approach_table_end(
    travel_left: float,
    time_left: float,
    step: float,
    has_advanced: bool,
    distance_scale: float,
    longest_time: float,
    settings: ReducedSettings,
) -> tuple[float, bool]:
    """Return the next step (s) towards the end of a table, and whether it is reached but for rounding."""
    # The first step goes almost to the end of the last piece; after one that leads beyond it, shorter
    # ones do. `time_left` (s) is that of the travel left at the present rate; rounding is relative to
    # `distance_scale` (SI) and `longest_time` (s).
    step = settings.table_end_approach * time_left if has_advanced and time_left != 0.0 else step * settings.table_end_step_ratio
    is_end = step < settings.min_end_step_ratio * longest_time or abs(travel_left) < settings.min_remaining_travel * distance_scale
    return step, is_end


def _find_motion_end(
    edge: float, end_coordinate: float, coordinate: float, rate: float, acceleration: float, acceleration_slope: float
) -> tuple[bool, float]:
    """Return whether a motion near the end of a table may turn back, and the time (s) to its end at its rate and acceleration."""
    # The table has values up to its edge; the end coordinate, the bound if that is near, may lie a
    # little behind that, so near that rounding separates them. The motion may turn back between them at
    # that acceleration (SI/s2) or at one that changes along the coordinate by a slope (1/s2): it ends
    # at the edge then. The time is that at the rate (SI/s) alone if the acceleration stops it before,
    # and 0 if it leads away.
    travel = end_coordinate - coordinate
    gain = 2.0 * acceleration * travel + min(acceleration_slope * travel * travel, 0.0)
    stops_short = end_coordinate != edge and not (rate * travel > 0.0 and rate * rate + gain > 0.0)
    if stops_short:
        travel = edge - coordinate
    if rate == 0.0 or travel / rate <= 0.0:
        return stops_short, 0.0
    square_of_end_rate = rate * rate + 2.0 * acceleration * travel
    if not square_of_end_rate > 0.0:
        return stops_short, travel / rate
    return stops_short, 2.0 * travel / (rate + math.copysign(math.sqrt(square_of_end_rate), rate))


def describe_passage_end(
    motion_table: MotionTable, status: IntegrationStatus, time: float, side: int, max_steps: int, *, stops_short: bool
) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time, s, on a side of its table; no outcome if it reached its end."""
    time_text = f"t = {time:.9g} s"
    if status != IntegrationStatus.TABLE_ENDED:
        return describe_end(motion_table.scene, status, time_text, max_steps)
    is_at_limit, message = motion_table.end_message(side, stops_short=stops_short)
    return Outcome.LEFT_RANGE if is_at_limit else Outcome.DEAD_CENTRE, f"{message}, at {time_text}"

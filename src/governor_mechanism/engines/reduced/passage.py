"""Integration over an interval along a motion table that grows with the motion, and how it ends where the table cannot grow."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from governor_mechanism.engines.certificate import describe_end
from governor_mechanism.engines.reduced.integration import ReducedEquation, integrate_reduced
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.equation import StepBuffers
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.transition import EventLog
from governor_mechanism.mechanics.reduction.motion_table import MotionTable, TableEnd, describe_table_end
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.types import FloatArray, IntArray


@dataclass(frozen=True)
class PassageEnd:
    """How an integration ended: status, last step (s), number of times reached, time of the state (s), the side left last.

    `stops_short` is whether the motion turns back between the end of the table and the bound of the coordinate.
    """

    status: IntegrationStatus
    step: float
    n_reached: int
    time: float
    side: int
    stops_short: bool = False


def integrate_passage(
    motion_table: MotionTable,
    make_equation: Callable[[float], ReducedEquation],
    buffers: StepBuffers,
    span: tuple[float, float],
    times: FloatArray,
    state: FloatArray,
    step_limits: StepLimits,
    states: FloatArray,
    modes: IntArray,
    event_log: EventLog,
    *,
    time_scale: float,
    settings: ReducedSettings,
) -> PassageEnd:
    """Integrate the reduced model over a time span; where the motion leaves its table, extend the table.

    Parameters
    ----------
    motion_table
        The motion table.
    make_equation
        Function that returns the equation along the table from a time (s) on.
    buffers
        Buffers of the steps.
    span
        Start and end, s.
    times
        Reported times within the span, s; shape (n,).
    state
        State at the start; changed in place; shape (N_STATES,).
    step_limits
        Tolerance, first and largest step.
    states
        Result: states at the times; shape (n, N_STATES).
    modes
        Result: contact modes at the times; shape (n, modes).
    event_log
        Result: events.
    time_scale
        Characteristic time of the scene, s.
    settings
        Settings of the end of a table.

    Returns
    -------
    PassageEnd
        How the integration ended: with TABLE_ENDED where the motion reaches the end of its table.
    """
    (time, end), step, n_filled, side = span, step_limits.step, 0, 0
    last_time, limits = -math.inf, make_table_end_limits(settings)
    while time < end:
        outputs = times[n_filled:], state, step_limits._replace(step=step), states[n_filled:], modes[n_filled:], event_log
        status, step, n_reached, time = integrate_reduced(make_equation(time), buffers, (time, end), *outputs)
        n_filled += n_reached
        if status not in (IntegrationStatus.BELOW_TABLE, IntegrationStatus.ABOVE_TABLE):
            return PassageEnd(IntegrationStatus(status), step, n_filled, time, side)
        side = status - IntegrationStatus.BELOW_TABLE
        if motion_table.extend(side):
            continue
        scale = motion_table.arrays.lagrangian.assembly.coordinate_scale
        travel_left = motion_table.edge(side) - state[0]
        time_left, distance_scale = time_at_rate(travel_left, state[1]), max(scale, abs(state[0]))
        step, is_end = approach_table_end(
            travel_left, time_left, step, time > last_time, distance_scale, max(time_scale, end - time), limits
        )
        last_time = time
        if is_end:
            rate, acceleration = state[1], buffers.stages.derivatives[1, 0]
            edge, end_coordinate = motion_table.edge(side), motion_table.end_coordinate(side)
            stops_short = end_coordinate != edge and stops_within(end_coordinate - state[0], rate, acceleration)
            time += time_to_travel((edge if stops_short else end_coordinate) - state[0], rate, acceleration)
            return PassageEnd(IntegrationStatus.TABLE_ENDED, step, n_filled, time, side, stops_short)
    return PassageEnd(IntegrationStatus.DONE, step, n_filled, time, side)


class TableEndLimits(NamedTuple):
    """What ends an integration at the end of a table; see the fields of these names of `ReducedSettings`."""

    table_end_approach: float
    table_end_step_ratio: float
    min_end_step_ratio: float
    min_remaining_travel: float


def make_table_end_limits(settings: ReducedSettings) -> TableEndLimits:
    """Return what ends an integration at the end of a table."""
    return TableEndLimits(
        settings.table_end_approach, settings.table_end_step_ratio, settings.min_end_step_ratio, settings.min_remaining_travel
    )


def time_at_rate(travel: float, rate: float) -> float:
    """Return the time (s) of a travel at a rate; 0 if the rate does not lead there."""
    return max(travel / rate, 0.0) if rate != 0.0 else 0.0


def stops_within(travel: float, rate: float, acceleration: float) -> bool:
    """Return whether a rate leads away from the end of a travel, or a constant acceleration ends it before."""
    return not (rate * travel > 0.0 and rate * rate + 2.0 * acceleration * travel > 0.0)


def time_to_travel(travel: float, rate: float, acceleration: float) -> float:
    """Return the time (s) of a travel from a rate on at a constant acceleration, or at the rate alone if that stops it.

    0 if it leads away.
    """
    if rate == 0.0 or travel / rate <= 0.0:
        return 0.0
    square_of_end_rate = rate * rate + 2.0 * acceleration * travel
    if not square_of_end_rate > 0.0:
        return travel / rate
    return 2.0 * travel / (rate + math.copysign(math.sqrt(square_of_end_rate), rate))


def approach_table_end(
    travel_left: float,
    time_left: float,
    step: float,
    has_advanced: bool,
    distance_scale: float,
    longest_time: float,
    limits: TableEndLimits,
) -> tuple[float, bool]:
    """Return the next step (s) towards the end of a table, and whether it is reached but for rounding.

    The first step goes almost to the end of the last piece; after one that leads beyond it, shorter ones do. `time_left` (s) is that
    of the travel left at the present rate; rounding is relative to `distance_scale` (SI) and `longest_time` (s).
    """
    step = limits.table_end_approach * time_left if has_advanced and time_left != 0.0 else step * limits.table_end_step_ratio
    is_end = step < limits.min_end_step_ratio * longest_time or abs(travel_left) < limits.min_remaining_travel * distance_scale
    return step, is_end


def describe_passage_end(
    scene: Scene, table_end: TableEnd, status: IntegrationStatus, time: float, max_steps: int
) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time, s, on a side of its table; no outcome if it reached its end."""
    time_text = f"t = {time:.9g} s"
    if status != IntegrationStatus.TABLE_ENDED:
        return describe_end(scene, status, time_text, max_steps)
    is_at_limit, message = describe_table_end(scene, table_end)
    return Outcome.LEFT_RANGE if is_at_limit else Outcome.DEAD_CENTRE, f"{message}, at {time_text}"

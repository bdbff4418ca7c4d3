"""Integration over an interval along a motion table that grows with the motion, and how it ends where the table cannot grow."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from governor_mechanism.engines.certificate import describe_end
from governor_mechanism.engines.reduced.integration import ReducedEquation, integrate_reduced
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.engines.reduced.table_end import approach_table_end, find_motion_end, make_table_end_limits, time_at_rate
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.equation import StepBuffers
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.transition import EventLog
from governor_mechanism.mechanics.reduction.motion_table import MotionTable, TableEnd, describe_table_end
from governor_mechanism.model.results.outcome import Outcome
from governor_mechanism.model.scene import Scene
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
            edge, acceleration = motion_table.edge(side), float(buffers.stages.derivatives[1, 0])
            stops_short, time_left = find_motion_end(edge, motion_table.end_coordinate(side), state[0], state[1], acceleration)
            time += time_left
            return PassageEnd(IntegrationStatus.TABLE_ENDED, step, n_filled, time, side, stops_short)
    return PassageEnd(IntegrationStatus.DONE, step, n_filled, time, side)


def describe_passage_end(
    scene: Scene, table_end: TableEnd, status: IntegrationStatus, time: float, max_steps: int
) -> tuple[Outcome | None, str]:
    """Return outcome and message of an integration that ended at a time, s, on a side of its table; no outcome if it reached its end."""
    time_text = f"t = {time:.9g} s"
    if status != IntegrationStatus.TABLE_ENDED:
        return describe_end(scene, status, time_text, max_steps)
    is_at_limit, message = describe_table_end(scene, table_end)
    return Outcome.LEFT_RANGE if is_at_limit else Outcome.DEAD_CENTRE, f"{message}, at {time_text}"

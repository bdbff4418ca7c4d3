"""How a motion comes to the end of a motion table: steps towards it, and when it ends. Functions in Python that batches also compile."""

import math
from typing import NamedTuple

from governor_mechanism.engines.reduced.settings import ReducedSettings


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


def find_motion_end(edge: float, end_coordinate: float, coordinate: float, rate: float, acceleration: float) -> tuple[bool, float]:
    """Return where and when a motion near the end of a table ends, at its present rate and a constant acceleration.

    The table has values up to its edge; the bound of the coordinate may lie a little behind that, so near that rounding separates them.

    Parameters
    ----------
    edge
        Coordinate up to which the table has values, m or rad.
    end_coordinate
        The bound of the coordinate if that is near, else the edge, m or rad.
    coordinate
        Coordinate of the motion, m or rad.
    rate
        Its rate, m/s or rad/s.
    acceleration
        Its acceleration, m/s2 or rad/s2.

    Returns
    -------
    stops_short : bool
        Whether the motion turns back between the edge and the bound of the coordinate: it ends at the edge then.
    time : float
        Time to its end, s: at the rate alone if the acceleration stops it before, and 0 if it leads away.
    """
    travel = end_coordinate - coordinate
    stops_short = end_coordinate != edge and not (rate * travel > 0.0 and rate * rate + 2.0 * acceleration * travel > 0.0)
    if stops_short:
        travel = edge - coordinate
    if rate == 0.0 or travel / rate <= 0.0:
        return stops_short, 0.0
    square_of_end_rate = rate * rate + 2.0 * acceleration * travel
    if not square_of_end_rate > 0.0:
        return stops_short, travel / rate
    return stops_short, 2.0 * travel / (rate + math.copysign(math.sqrt(square_of_end_rate), rate))

"""Oscillations too narrow to be resolved in a plot: their ranges as bands with a mean; and curves refined between samples."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.numerics.interpolation import integrate_samples, interpolate_samples
from governor_mechanism.render.machines.engine_room.arrangement import find_governed_engine
from governor_mechanism.render.shown_readings import MAX_SHOWN_ANGLE
from governor_mechanism.types import FloatArray, IntArray

MIN_OSCILLATION_WIDTH = 4.5
"""Width of an oscillation, in widths of the line, below which its curve is drawn as a band: two strokes, and gaps wider than them."""
MIN_SWING, MIN_SWING_IN_STEP = 1.0, 0.5
"""Height, in widths of the line, up to which a reversal of a curve is hidden by its line: one of its own, and one in step with a shaft."""
MAX_CYCLE_WIDTH = 3 * MIN_OSCILLATION_WIDTH
"""Width, in widths of the line, up to which a turn or an oscillation is a cycle: over a longer one, a mean hides what a plot can show."""
MIN_SHARE_IN_STEP, MAX_SHARE_IN_STEP = 0.75, 1.1
"""Number of oscillations relative to a multiple of that of turns between which a curve is in step with the shaft: where a curve rises or
falls steeply, its oscillations have no reversals, and impacts may add some."""
COLUMN_WIDTH = 2.0
"""Distance of the points of a band, pixels."""


@dataclass(frozen=True, kw_only=True)
class PlotSize:
    """Width and height of a plot and the width of its lines, pixels, and the limits of its axis of values."""

    width: float
    height: float
    line_width: float
    limits: tuple[float, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class RangeBand:
    """What stands for a curve with many oscillations."""

    times: FloatArray  # times of the points of the band, s; shape (m,)
    # low, high: smallest and largest sample within a cycle about each of them, in the unit of the curve;
    # shape (m,)
    low: FloatArray
    high: FloatArray
    mean_times: FloatArray  # those of these times about which a whole cycle lies within the curve, s; shape (k,)
    means: FloatArray  # mean over that cycle; shape (k,)
    is_of_turns: bool  # whether a cycle is a turn of a shaft, and not an oscillation of the curve


def find_range_band(
    times: FloatArray,  # times, s; shape (n,)
    values: FloatArray,  # values of the curve; shape (n,)
    size: PlotSize,
    # turns of a shaft since any moment, rising; shape (n,). None counts the oscillations of the curve
    turns: FloatArray | None = None,
) -> RangeBand | None:
    """Return the band and the mean of a curve whose oscillations are too narrow for a plot, or None for any other curve.

    A cycle is a turn of a shaft, or where no shaft turns in step with the curve, the curve from one of its minima to the next; a curve
    that then oscillates in a part of the plot alone has no band. The band spans the samples within a cycle about each of its points, and
    all samples of the curve lie in it. The mean is the integral of the straight lines between the samples over the cycle, half before and
    half after, divided by its duration. Within half a cycle of both ends there is none: it would need values that the run does not have. A
    jump of the mean becomes a slope over the cycle about it, without overshoot. Where a cycle has few samples, band and mean vary with
    where these lie.
    """
    duration = float(np.ptp(times)) if len(times) else 0.0
    if duration <= 0.0 or not np.isfinite(values).all():
        return None
    low, high = size.limits
    line_height = size.line_width * (high - low) / size.height
    width = size.width / size.line_width
    n_columns = math.ceil(size.width / COLUMN_WIDTH)
    if turns is not None:
        n_oscillations = 0.5 * len(_find_reversals(values, MIN_SWING_IN_STEP * line_height))
        if n_oscillations * MIN_OSCILLATION_WIDTH > width and _is_in_step(n_oscillations, float(np.ptp(turns)), width):
            return make_range_band(times, values, turns, n_columns)
    reversals = _find_reversals(values, MIN_SWING * line_height)
    if 0.5 * len(reversals) * MIN_OSCILLATION_WIDTH <= width:
        return None
    cycles = _count_cycles(times, values, reversals, duration * MAX_CYCLE_WIDTH / width)
    return None if cycles is None else make_range_band(times, values, cycles, n_columns, is_of_turns=False)


def make_range_band(
    times: FloatArray,  # times, s; shape (n,)
    values: FloatArray,  # values of the curve; shape (n,)
    cycles: FloatArray,  # cycles since any moment, rising; shape (n,)
    n_columns: int,  # number of columns of a plot over the times: the band has a point at each end of one
    *,
    is_of_turns: bool = True,
) -> RangeBand:
    """Return the band and the mean of a curve whatever its oscillations, as `find_range_band` does."""
    points = np.linspace(times[0], times[-1], max(n_columns, 1) + 1)
    middles = np.interp(points, times, cycles)
    # The band of a cycle that is shorter than a column spans the columns beside its point, so that no sample is left out.
    column = points[1] - points[0]
    first = np.searchsorted(times, np.minimum(np.interp(middles - 0.5, cycles, times), points - column), side="left")
    last = np.searchsorted(times, np.maximum(np.interp(middles + 0.5, cycles, times), points + column), side="right")
    has_samples = last > first
    spans = [values[start:end] for start, end in zip(first[has_samples], last[has_samples], strict=True)]
    has_cycle = (middles - 0.5 >= cycles[0]) & (middles + 0.5 <= cycles[-1])
    starts, ends = (np.interp(middles[has_cycle] + half, cycles, times) for half in (-0.5, 0.5))
    return RangeBand(
        times=points[has_samples],
        low=np.array([one.min() for one in spans]),
        high=np.array([one.max() for one in spans]),
        mean_times=points[has_cycle],
        means=(_integrate_to(ends, times, values) - _integrate_to(starts, times, values)) / (ends - starts),
        is_of_turns=is_of_turns,
    )


def name_cycles(bands: Sequence[RangeBand]) -> str:
    """Return what the cycle of bands is: "a turn", "an oscillation", or either."""
    kinds = {band.is_of_turns for band in bands}
    return " or ".join(name for name, is_of_turns in (("a turn", True), ("an oscillation", False)) if is_of_turns in kinds)


def count_turns(
    # the run. Of a governed engine the shaft is that of the engine, else the first angle of more than two
    # turns
    run: Trajectory,
) -> FloatArray | None:
    """Return the turns (n,) of the shaft whose turn is the cycle of a run, or None if no shaft turns steadily."""
    governed = find_governed_engine(run.scene)
    names = [governed.crank_angle] if governed else [name for name in run.readings if run.units.get(name) == "rad"]
    for name in names:
        turns = run.readings[name] / math.tau
        steps = np.diff(turns)
        if np.ptp(turns) * math.tau > MAX_SHOWN_ANGLE and bool(np.all(steps > 0) or np.all(steps < 0)):
            return turns if steps[0] > 0 else -turns
    return None


_MAX_TURN_BETWEEN_REPORTS_DEG = 30.0
"""Angle between two reported times above which a curve over a turn is seen to be a polygon."""


def note_coarse_turns(run: Trajectory) -> list[str]:
    """Return a line that curves are polygons where a shaft turns far between two reported times, or none."""
    turns = count_turns(run)
    largest = 360.0 * float(np.diff(turns).max()) if turns is not None and len(turns) > 1 else 0.0
    if largest <= _MAX_TURN_BETWEEN_REPORTS_DEG:
        return []
    return [f"only {360.0 / largest:.3g} points a turn: the curves are coarse; set run.output_interval"]


def _is_in_step(n_oscillations: float, n_turns: float, width: float) -> bool:
    """Return whether a turn is the cycle of a curve in a plot of a width, in widths of the line."""
    multiple = math.ceil(n_oscillations / (MAX_SHARE_IN_STEP * n_turns))
    return n_turns * MAX_CYCLE_WIDTH >= width and n_oscillations >= MIN_SHARE_IN_STEP * multiple * n_turns


def _find_reversals(values: FloatArray, swing: float) -> list[int]:
    """Return the samples at which a curve turns back by more than a swing, alternately its maxima and minima."""
    slopes = np.diff(values)
    moving = np.flatnonzero(slopes)
    turning = moving[1:][np.sign(slopes[moving[1:]]) != np.sign(slopes[moving[:-1]])]
    reversals: list[int] = []
    # The extremum since the last reversal; at first both extrema are open.
    lowest = highest = 0
    direction = 0
    for k in [*turning.tolist(), len(values) - 1]:
        if values[k] > values[highest]:
            highest = k
        if values[k] < values[lowest]:
            lowest = k
        if direction >= 0 and values[highest] - values[k] > swing:
            reversals += [highest] if direction > 0 else []
            direction, lowest = -1, k
        elif direction <= 0 and values[k] - values[lowest] > swing:
            reversals += [lowest] if direction < 0 else []
            direction, highest = 1, k
    return reversals


def _count_cycles(times: FloatArray, values: FloatArray, reversals: list[int], longest: float) -> FloatArray | None:
    """Return the oscillations (n,) of a curve since its first minimum, evenly counted between two; None if one exceeds `longest` s."""
    first = 0 if values[reversals[0]] < values[reversals[1]] else 1
    minima = _locate_minima(times, values, np.array(reversals[first::2]))
    if np.diff(minima, prepend=times[0], append=times[-1]).max() > longest:
        return None
    # Before the first minimum and after the last one, oscillations are as long as the nearest whole one.
    before, after = minima[1] - minima[0], minima[-1] - minima[-2]
    n_before, n_after = (math.ceil(gap / period) for gap, period in ((minima[0] - times[0], before), (times[-1] - minima[-1], after)))
    marks = np.concatenate([minima[0] - before * np.arange(n_before, 0, -1), minima, minima[-1] + after * np.arange(1, n_after + 1)])
    cycles: FloatArray = np.interp(times, marks, np.arange(len(marks), dtype=float) - n_before)
    return cycles


def _locate_minima(times: FloatArray, values: FloatArray, samples: IntArray) -> FloatArray:
    """Return the times (m,) of minima near samples (m,), where the slope, which is known between samples, crosses zero."""
    middles = 0.5 * (times[1:] + times[:-1])
    slopes = np.diff(values) / np.diff(times)
    falling, rising = slopes[samples - 1], slopes[samples]
    located: FloatArray = middles[samples - 1] - falling * (middles[samples] - middles[samples - 1]) / np.maximum(rising - falling, 1e-300)
    return located


def _integrate_to(ends: FloatArray, times: FloatArray, values: FloatArray) -> FloatArray:
    """Return the integrals (m,) from the first time to ends (m,) s of the straight lines between samples (n,)."""
    whole = integrate_samples(times, values)
    before = np.clip(np.searchsorted(times, ends, side="right") - 1, 0, len(times) - 2)
    total: FloatArray = whole[before] + 0.5 * (values[before] + np.interp(ends, times, values)) * (ends - times[before])
    return total


MIN_DEVIATION = 0.25
"""Deviation of a curve from the straight line between two samples, in widths of the line, up to which nobody sees it."""
MAX_RATE_MISMATCH = 0.3
"""Largest difference of a step of the values from that by the mean of both rates, relative to the larger rate: a sine with 4 samples in a
period has up to 0.2, and a reading that jumps or has a kink about 1."""
POINTS_BETWEEN_SAMPLES = 7
"""Number of points that are put between two samples."""


def refine_curve(
    times: FloatArray,  # times of the samples, s; shape (n,)
    values: FloatArray,  # values; shape (n,)
    rates: FloatArray,  # their rates, 1/s; shape (n,)
    size: PlotSize,
) -> tuple[FloatArray, FloatArray]:
    """Return a curve with further points where straight lines between its samples would be seen as corners.

    The points lie on the cubic with the values and rates of both samples. None are put where rates and values do not belong together, as
    at an impact.

    Results: times, times with those of the further points, s; shape (m,); values, values there; shape (m,).
    """
    steps = np.diff(times)
    low, high = size.limits
    largest = np.maximum(np.abs(rates[:-1]), np.abs(rates[1:]))
    mismatch = np.abs(np.diff(values) - 0.5 * steps * (rates[:-1] + rates[1:]))
    # In the middle between two samples, the cubic is that far from the straight line.
    deviation = 0.125 * steps * np.abs(rates[:-1] - rates[1:]) * size.height / (high - low)
    is_refined = (deviation > MIN_DEVIATION * size.line_width) & (mismatch <= MAX_RATE_MISMATCH * steps * largest)
    if not is_refined.any():
        return times, values
    shares = np.arange(1, POINTS_BETWEEN_SAMPLES + 1) / (POINTS_BETWEEN_SAMPLES + 1)
    between = (times[:-1][is_refined, None] + steps[is_refined, None] * shares).ravel()
    order = np.argsort(all_times := np.concatenate([times, between]), kind="stable")
    all_values = np.concatenate([values, interpolate_samples(times, values, rates, between)])
    return all_times[order], all_values[order]

"""The rules by which a number is taken from a run: what each means, and how it is computed."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.inputs import has_kinks
from governor_mechanism.model.results.records import SpeedFluctuation
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import mean_gas_torque
from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, find_event_angles, valve_motion_of
from governor_mechanism.studies.compared_quantities import SETTLING_TOLERANCE, settling_time
from governor_mechanism.studies.sweep.rows import ROW_NO_OSCILLATION, ROW_NO_VALUE, ROW_NOT_SETTLED
from governor_mechanism.types import BoolArray, FloatArray, IntArray

NODES_AROUND = 4
"""Reported times whose values and rates locate a turning point: a polynomial of degree 7, so that the error falls with the eighth power
of their distance."""

NEWTON_STEPS = 2
"""Newton steps from the turning point of the cubic between two times: the cubic is right to about the third power of their distance."""


class ReadingSamples(NamedTuple):
    """A reading at the reported times of a run."""

    times: FloatArray  # times, s; shape (n,)
    values: FloatArray  # values, SI; shape (n,)
    rates: FloatArray  # rates, SI per second; shape (n,), or empty for a reading that is no position
    min_swing: float  # change between two turning points below which they count as noise, SI
    is_smooth: bool  # whether nothing sticks or strikes, so that a polynomial through several times holds


@dataclass(frozen=True, kw_only=True, eq=False)
class TurningPoints:
    """Turning points of a reading in order of time, upper and lower ones by turns."""

    times: FloatArray  # times, s; shape (n,)
    values: FloatArray  # values, SI; shape (n,)
    is_upper: BoolArray  # whether each is a maximum; shape (n,)

    def whole_oscillations(self) -> tuple[float, float, int] | None:
        """Return the times (s) of the first and the last maximum, or minimum if there is only one maximum, and the periods between them."""
        for is_chosen in (self.is_upper, ~self.is_upper):
            times = self.times[is_chosen]
            if len(times) > 1:
                return float(times[0]), float(times[-1]), len(times) - 1
        return None

    def amplitude(self, start: float) -> float | None:
        """Return half the difference of the highest and the lowest turning point from a time (s) on, SI; None if one is missing."""
        is_late = self.times >= start
        upper = self.values[is_late & self.is_upper]
        lower = self.values[is_late & ~self.is_upper]
        return float(upper.max() - lower.min()) / 2 if upper.size and lower.size else None


def find_turning_points(samples: ReadingSamples) -> TurningPoints:
    """Return the turning points of a position between which it moves by more than `min_swing`; none of what is no position."""
    # Where it comes to rest before it turns back, the turning point is where it comes to rest.
    times = samples.times
    values = samples.values
    rates = samples.rates
    moving = np.flatnonzero(rates)
    before, after = moving[:-1], moving[1:]
    turns = np.signbit(rates[before]) != np.signbit(rates[after])
    before, after = before[turns], after[turns]
    turning_times = times[np.minimum(before + 1, after)].copy()
    turning_values = values[np.minimum(before + 1, after)].copy()
    is_between = after == before + 1
    located = _locate_between(samples, before[is_between])
    turning_times[is_between], turning_values[is_between] = located
    kept = _without_small_swings(turning_values, rates[before] > 0.0, samples.min_swing)
    return TurningPoints(times=turning_times[kept], values=turning_values[kept], is_upper=(rates[before] > 0.0)[kept])


def _without_small_swings(values: FloatArray, is_upper: BoolArray, min_swing: float) -> IntArray:
    """Return the indices of turning points that remain when swings below a size are left out; upper and lower ones still alternate."""
    kept: list[int] = []
    for k, value in enumerate(values.tolist()):
        if kept and is_upper[kept[-1]] == is_upper[k]:
            if (value > values[kept[-1]]) == bool(is_upper[k]):
                kept[-1] = k
        elif not kept or abs(value - values[kept[-1]]) > min_swing:
            kept.append(k)
    # A single turning point is no swing; two that are further apart than the smallest one are.
    return np.array(kept if len(kept) > 1 else [], dtype=np.int64)


def _locate_between(samples: ReadingSamples, first: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and values of the turning points between samples `first` and the ones after them; shape (n,) each."""
    times = samples.times
    values = samples.values
    rates = samples.rates
    n_nodes = NODES_AROUND if samples.is_smooth and len(times) >= NODES_AROUND else 2
    window = np.clip(first - (n_nodes // 2 - 1), 0, len(times) - n_nodes)[:, None] + np.arange(n_nodes)
    low, high = times[first], times[first + 1]
    guesses = low + (high - low) * _cubic_turning_fraction(values[first], values[first + 1], rates[first], rates[first + 1], high - low)
    nodes, coefficients = _newton_form(times[window] - low[:, None], values[window], rates[window])
    arguments = guesses - low
    for _ in range(NEWTON_STEPS if n_nodes > 2 else 0):
        _, slopes, curvatures = _evaluate(nodes, coefficients, arguments)
        steps = np.divide(-slopes, curvatures, out=np.zeros_like(slopes), where=curvatures != 0.0)
        arguments = np.clip(arguments + steps, 0.0, high - low)
    return low + arguments, _evaluate(nodes, coefficients, arguments)[0]


def _cubic_turning_fraction(
    first: FloatArray, last: FloatArray, first_rate: FloatArray, last_rate: FloatArray, step: FloatArray
) -> FloatArray:
    """Return where, as a fraction of the step, the cubics with values and rates at both ends turn back; the rates have opposite signs."""
    # The rate at a fraction s is first_rate + linear * s + square * s^2; of its two zeros this form gives the one within the step, without
    # cancellation. Its denominator does not vanish: the discriminant exceeds linear^2 where square and first_rate differ in sign, and
    # otherwise linear has the sign of -first_rate, as the rate changes its sign.
    secant = (last - first) / step
    square = 3.0 * (first_rate + last_rate) - 6.0 * secant
    linear = last_rate - first_rate - square
    root = np.sqrt(np.maximum(linear * linear - 4.0 * square * first_rate, 0.0))
    fraction: FloatArray = 2.0 * first_rate / (-linear + np.copysign(root, first_rate))
    return np.clip(fraction, 0.0, 1.0)


def _newton_form(nodes: FloatArray, values: FloatArray, rates: FloatArray) -> tuple[FloatArray, list[FloatArray]]:
    """Return nodes, each twice, and Newton coefficients of the polynomials with values and rates at nodes; shape (functions, nodes)."""
    doubled = np.repeat(nodes, 2, axis=1)
    differences = np.repeat(values, 2, axis=1)
    coefficients = [differences[:, 0]]
    for order in range(1, doubled.shape[1]):
        intervals = doubled[:, order:] - doubled[:, :-order]
        if order == 1:
            intervals[:, ::2] = 1.0
        differences = np.diff(differences, axis=1) / intervals
        if order == 1:
            differences[:, ::2] = rates  # the difference over one node alone is the derivative there
        coefficients.append(differences[:, 0])
    return doubled, coefficients


def _evaluate(nodes: FloatArray, coefficients: list[FloatArray], arguments: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return value and first two derivatives of each polynomial at an argument of its own; shape (functions,) each."""
    value = coefficients[-1]
    rate = np.zeros_like(arguments)
    acceleration = np.zeros_like(arguments)
    for order in range(len(coefficients) - 2, -1, -1):
        distance = arguments - nodes[:, order]
        acceleration = acceleration * distance + 2.0 * rate
        rate = rate * distance + value
        value = value * distance + coefficients[order]
    return value, rate, acceleration


def mean_value(samples: ReadingSamples, turning_points: TurningPoints) -> float:
    """Return the mean of a reading over time: over its whole oscillations if it oscillates, and over the run otherwise."""
    times = samples.times
    values = samples.values
    rates = samples.rates
    span = turning_points.whole_oscillations()
    if span is not None:
        # The turning points at both ends join the samples between them.
        start, end, _ = span
        at_ends = turning_points.values[np.searchsorted(turning_points.times, (start, end))]
        inside = (times > start) & (times < end)
        times = np.concatenate([[start], times[inside], [end]])
        values = np.concatenate([at_ends[:1], values[inside], at_ends[1:]])
        rates = np.concatenate([[0.0], rates[inside], [0.0]])
    steps = np.diff(times)
    if not steps.size:
        return float(values[-1])
    integral = np.sum(steps * (values[1:] + values[:-1])) / 2
    if rates.size:
        integral -= np.sum(steps * steps * np.diff(rates)) / 12
    return float(integral / (times[-1] - times[0]))


SETTLING_FRACTION = 0.2
"""Last part of a run in which a reading must stand still to have settled."""

SETTLED_RATIO = 5e-3
"""Largest range of a settled reading in that part, relative to its scale: 0.3 degrees, or 1.5 mm of an arm of 300 mm. The mean over
that part is nearer to the value that a decaying oscillation approaches."""

LATE_FRACTION = 0.5
"""Part of a run that is left out of an amplitude: a forced oscillation is steady only after its start."""

_NO_SAMPLES = np.zeros(0)


class MissingNumberError(Exception):
    """A run has no number of a kind, which is a result by itself."""

    def __init__(
        self,
        outcome: str,  # outcome of the row
        message: str,  # the reason, in words that are the same for all rows
    ) -> None:
        super().__init__(message)
        self.outcome = outcome


class RunNumbers:
    """A run from which numbers are taken; what several of them need is computed once."""

    def __init__(self, run: Trajectory) -> None:
        self.run, self._turning_points = run, dict[tuple[str, float], TurningPoints]()

    def samples(self, reading: str, min_swing: float = 0.0, *, is_rate: bool = False) -> ReadingSamples:
        """Return a reading, or its rate, at the reported times. Raise MechanismError if there is none."""
        run = self.run
        source = run.rates if is_rate else run.readings
        if reading not in source:
            raise MechanismError(f"this scene has no {reading!r}; its readings are {', '.join(run.readings)}")
        rates = run.rates.get(reading, _NO_SAMPLES) if not is_rate else _NO_SAMPLES
        has_breaks = has_contacts(run.scene) or has_kinks(run.scene)
        return ReadingSamples(run.times, source[reading], rates, min_swing, is_smooth=not has_breaks)

    def turning_points(self, reading: str, min_swing: float) -> TurningPoints:
        """Return the turning points of a reading between which it moves by more than a size, SI."""
        if (reading, min_swing) not in self._turning_points:
            self._turning_points[reading, min_swing] = find_turning_points(self.samples(reading, min_swing))
        return self._turning_points[reading, min_swing]


class Taken(NamedTuple):
    """What a statistic is taken of."""

    numbers: RunNumbers  # the run
    reading: str  # name of the reading
    is_rate: bool  # whether its rate is meant
    scale: float  # scale of the reading, SI; 0 if it has none
    min_swing: float  # change between two turning points below which they count as noise, SI

    @property
    def values(self) -> FloatArray:
        """Values at the reported times, SI."""
        return self.numbers.samples(self.reading, is_rate=self.is_rate).values

    @property
    def turning_points(self) -> TurningPoints:
        """Turning points of the reading."""
        return self.numbers.turning_points(self.reading, self.min_swing)


def _take_mean(taken: Taken) -> float:
    if taken.is_rate:
        times = taken.numbers.run.times
        values = taken.numbers.run.readings[taken.reading]
        return float((values[-1] - values[0]) / (times[-1] - times[0])) if len(times) > 1 else float(taken.values[-1])
    return mean_value(taken.numbers.samples(taken.reading), taken.turning_points)


def _take_settled(taken: Taken) -> float:
    times, values = taken.numbers.run.times, taken.values
    late = values[times >= times[-1] - SETTLING_FRACTION * (times[-1] - times[0])]
    scale = taken.scale or float(np.max(np.abs(values)))
    if float(np.ptp(late)) > SETTLED_RATIO * scale:
        part = f"in the last {SETTLING_FRACTION:.0%} of the run"
        raise MissingNumberError(ROW_NOT_SETTLED, f"{taken.reading} still changes {part} by more than {SETTLED_RATIO:g} of its scale")
    return float(np.mean(late))


def _take_amplitude(taken: Taken) -> float:
    points, times = taken.turning_points, taken.numbers.run.times
    start = times[0] + LATE_FRACTION * (times[-1] - times[0])
    amplitude = points.amplitude(start)
    if amplitude is None:
        amplitude = points.amplitude(-math.inf)
    if amplitude is None:
        raise _no_oscillation(taken)
    return amplitude


def _take_frequency(taken: Taken) -> float:
    span = taken.turning_points.whole_oscillations()
    if span is None:
        raise _no_oscillation(taken)
    start, end, n_periods = span
    return n_periods / (end - start)


def _take_settling_time(taken: Taken) -> float:
    time = settling_time(taken.numbers.run, taken.reading)
    if time is None:
        raise MissingNumberError(ROW_NOT_SETTLED, f"{taken.reading} does not come to rest in the run, or does not move")
    return time


def _no_oscillation(taken: Taken) -> MissingNumberError:
    return MissingNumberError(ROW_NO_OSCILLATION, f"{taken.reading} makes no whole oscillation in the run")


def _last_turn_speeds(taken: Taken) -> tuple[float, float]:
    """Return the lowest and the highest speed (rad/s) of an angle in its last whole turn, in the direction in which it turns."""
    samples = taken.numbers.samples(taken.reading)
    direction = math.copysign(1.0, samples.values[-1] - samples.values[0])
    angles, speeds = direction * samples.values, direction * samples.rates
    if angles[-1] - angles[0] < math.tau:
        raise MissingNumberError(ROW_NO_VALUE, f"{taken.reading} makes no whole turn in the run")
    first = int(np.searchsorted(angles, angles[-1] - math.tau, side="right")) - 1
    return -_peak(-speeds[first:]), _peak(speeds[first:])


def _peak(values: FloatArray) -> float:
    """Return the largest of values at equal distances; if it is not the first or last, that of the parabola through its neighbours."""
    k = int(np.argmax(values))
    if not 0 < k < len(values) - 1:
        return float(values[k])
    before, peak, after = values[k - 1 : k + 2].tolist()
    bend = before - 2.0 * peak + after
    return float(peak - (after - before) ** 2 / (8.0 * bend)) if bend < 0.0 else float(peak)


def _take_mean_speed(taken: Taken) -> float:
    lowest, highest = _last_turn_speeds(taken)
    return (lowest + highest) / 2


def _take_speed_fluctuation(taken: Taken) -> float:
    lowest, highest = _last_turn_speeds(taken)
    return 2 * (highest - lowest) / (highest + lowest)


@dataclass(frozen=True, kw_only=True)
class Statistic:
    """A number taken of a reading."""

    take: Callable[[Taken], float]  # function that computes it
    meaning: str  # what it is, for users
    unit: str | None = None  # SI unit; None for that of the reading
    # kind of reading that it needs: "position", whose rate is known, "angle", or empty for any reading and
    # any rate
    needs: Literal["", "position", "angle"] = ""


STATISTICS: Mapping[str, Statistic] = {
    "final": Statistic(take=lambda taken: float(taken.values[-1]), meaning="value at the end of the run; also without the word"),
    "min": Statistic(take=lambda taken: float(np.min(taken.values)), meaning="least value at the reported times"),
    "max": Statistic(take=lambda taken: float(np.max(taken.values)), meaning="greatest value at the reported times"),
    "span": Statistic(take=lambda taken: float(np.ptp(taken.values)), meaning="greatest less least value at the reported times"),
    "mean": Statistic(take=_take_mean, meaning="mean over time: over whole oscillations, or over the run if there are none"),
    "settled": Statistic(
        take=_take_settled,
        meaning=f"mean over the last {SETTLING_FRACTION:.0%} of the run, if it changes there by less than {SETTLED_RATIO:g} of its scale "
        "(1 rad, the length of the arm, ...)",
    ),
    "amplitude": Statistic(
        take=_take_amplitude,
        meaning="half the difference of the highest and the lowest turning point in the second half of the run",
        needs="position",
    ),
    "frequency": Statistic(
        take=_take_frequency, meaning="whole oscillations in a second, from turning points", unit="Hz", needs="position"
    ),
    "settling time": Statistic(
        take=_take_settling_time,
        meaning="time from the last change of a given speed, or from the start, until the reading stays within "
        f"{SETTLING_TOLERANCE:.0%} of its change about its last value",
        unit="s",
        needs="position",
    ),
    "mean speed": Statistic(
        take=_take_mean_speed, meaning="mean of lowest and highest speed of an angle in its last whole turn", unit="rad/s", needs="angle"
    ),
    "speed fluctuation": Statistic(
        take=_take_speed_fluctuation, meaning="(highest - lowest) / mean speed of an angle in its last whole turn", unit="", needs="angle"
    ),
}
"""Statistics of a reading over a run."""

DURATION_RULE, ERROR_ESTIMATE_RULE = "duration", "error_estimate"
"""Rules that need no reading: the last reported time, s, and the relative error estimate."""

VALVE_RULES: Mapping[str, str] = {
    "valve travel": "m",
    **{f"{end} lead": "m" for end in CYLINDER_ENDS},
    **{f"{end} cut-off": "" for end in CYLINDER_ENDS},
}
"""Rules about the valve of a scene in its gear at the start, with their units: lengths, and strokes at cut-off as fractions."""

ENGINE_RULES: Mapping[str, str] = {"mean gas torque": "N m", "mean speed": "rad/s", "speed fluctuation": ""}
"""Rules about an engine that gas drives, with their units: its mean torque over a stroke; mean speed and coefficient in the last turn."""


def evaluate_valve_rule(rule: str, scene: Scene) -> float:
    """Return the value of a rule about the valve of a scene, SI."""
    if rule == "valve travel":
        return valve_motion_of(scene).travel
    end, _, kind = rule.rpartition(" ")
    if kind == "lead":
        return valve_motion_of(scene).leads[CYLINDER_ENDS.index(end)]
    angle = find_event_angles(scene).get(rule)
    if angle is None:
        cure = "sweep another range, or reduce the lap"
        raise MissingNumberError(ROW_NO_VALUE, f"there is no {rule}: the steam port of the {end} does not open once in a turn; {cure}")
    stroke = float(valve_motion_of(scene).stroke_fractions(np.array([angle]))[0])
    return stroke if end == CYLINDER_ENDS[0] else 1.0 - stroke


def evaluate_engine_rule(rule: str, run: Trajectory) -> float:
    """Return the value of a rule about the engine of a run, SI; of several shafts the one whose speed fluctuates most counts."""
    if rule == "mean gas torque":
        return mean_gas_torque(run.scene)
    if not run.speed_fluctuations:
        raise MissingNumberError(ROW_NO_VALUE, "there is no speed fluctuation: the shaft makes no complete turn; make the run longer")
    extremes: SpeedFluctuation = max(run.speed_fluctuations.values(), key=lambda one: one.coefficient)
    return extremes.mean if rule == "mean speed" else extremes.coefficient

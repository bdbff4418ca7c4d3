"""The rules by which a number is taken from a run: what each means, and how it is computed."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Literal, NamedTuple

import numpy as np

from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.dynamics.forces.contact_modes import has_contacts
from governor_mechanism.mechanics.dynamics.forces.loads import has_kinks
from governor_mechanism.model.results.speed_fluctuation import SpeedFluctuation
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.derived_readings import mean_gas_torque
from governor_mechanism.observables.valve_motion import CYLINDER_ENDS, find_event_angles, valve_motion_of
from governor_mechanism.studies.sweep.oscillation import ReadingSamples, TurningPoints, find_turning_points, mean_value
from governor_mechanism.studies.sweep.rows import ROW_NO_OSCILLATION, ROW_NO_VALUE, ROW_NOT_SETTLED
from governor_mechanism.types import FloatArray

SETTLING_FRACTION = 0.2
"""Last part of a run in which a reading must stand still to have settled."""

SETTLED_RATIO = 5e-3
"""Largest range of a settled reading in that part, relative to its scale: 0.3 degrees, or 1.5 mm of an arm of 300 mm. The mean over
that part is nearer to the value that a decaying oscillation approaches."""

LATE_FRACTION = 0.5
"""Part of a run that is left out of an amplitude: a forced oscillation is steady only after its start."""

_NO_SAMPLES = np.zeros(0)


class MissingNumberError(Exception):
    """A run has no number of a kind, which is a result by itself.

    Parameters
    ----------
    outcome
        Outcome of the row.
    message
        The reason, in words that are the same for all rows.
    """

    def __init__(self, outcome: str, message: str) -> None:
        super().__init__(message)
        self.outcome = outcome


class RunNumbers:
    """A run from which numbers are taken; what several of them need is computed once.

    Parameters
    ----------
    run
        The run.
    """

    def __init__(self, run: Trajectory) -> None:
        self.run = run
        self._turning_points = cache(self._find_turning_points)

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
        return self._turning_points(reading, min_swing)

    def _find_turning_points(self, reading: str, min_swing: float) -> TurningPoints:
        return find_turning_points(self.samples(reading, min_swing))


class Taken(NamedTuple):
    """What a statistic is taken of.

    Attributes
    ----------
    numbers
        The run.
    reading
        Name of the reading.
    is_rate
        Whether its rate is meant.
    scale
        Scale of the reading, SI; 0 if it has none.
    min_swing
        Change between two turning points below which they count as noise, SI.
    """

    numbers: RunNumbers
    reading: str
    is_rate: bool
    scale: float
    min_swing: float

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
        times, values = taken.numbers.run.times, taken.numbers.run.readings[taken.reading]
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
    """A number taken of a reading.

    Attributes
    ----------
    take
        Function that computes it.
    meaning
        What it is, for users.
    unit
        SI unit; None for that of the reading.
    needs
        Kind of reading that it needs: "position", whose rate is known, "angle", or empty for any reading and any rate.
    """

    take: Callable[[Taken], float]
    meaning: str
    unit: str | None = None
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

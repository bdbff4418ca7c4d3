"""How a governed engine answers a change of its load: droop, overshoot, settling, and whether it hunts."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.results.records import Outcome
from governor_mechanism.model.results.result import Column, Result, format_list
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.interpolation import interpolate_samples
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine, OperatingPoint
from governor_mechanism.types import FloatArray
from governor_mechanism.units.quantities import format_value, parse_quantity
from governor_mechanism.units.text_table import short_repr

SETTLING_BAND = 0.05
"""Half-width of the settling band about the last speed, relative to the whole change of speed: the usual one of speed governing."""

HUNTING_RATIO = 0.8
"""Part of the amplitude in the third quarter after the change above which that in the last one is a sustained oscillation."""

MIN_REVERSALS = 2
"""Passages of the middle speed in the second half after the change that make an oscillation; a steady drift has one."""


class Verdict(StrEnum):
    """How the speed behaves after a change of load."""

    SETTLES = "settles"
    HUNTS = "hunts"
    UNDECIDED = "has not settled by the end of the run"
    STALLS = "stalls"
    ENDED = "ended early"


@dataclass(frozen=True, kw_only=True)
class SpeedResponse:
    """Response of the mean speed of a shaft; the attributes are those of `LoadChangeStudy`, not a number where a run ends early."""

    verdict: Verdict
    mean_speeds: tuple[float, float, float]
    overshoot: float = math.nan
    settling_time: float = math.inf
    speed_error_integral: float = math.nan
    hunting_amplitude: float = math.nan
    hunting_period: float = math.nan


def reached_end(run: Trajectory) -> bool:
    """Return whether a run reached its end, with the accuracy asked for or without."""
    return run.outcome.ok or run.outcome is Outcome.ACCURACY_MISSED


def judge_speed(
    run: Trajectory,
    begin: float,  # begin of the change, s
    first: float,  # mean speed before the change, rad/s
    times: FloatArray,  # times after the begin of the change, s; shape (n,)
    speeds: FloatArray,  # mean speeds there, rad/s; shape (n,)
) -> SpeedResponse:
    """Return how the mean speed of a shaft answers a change of the load."""
    end = float(run.times[-1])
    quarters = [speeds[(times >= begin + a * (end - begin)) & (times <= begin + b * (end - begin))] for a, b in ((0.5, 0.75), (0.75, 1.0))]
    if not reached_end(run) or not all(len(quarter) > 1 for quarter in quarters):
        verdict = Verdict.STALLS if run.outcome == Outcome.SHAFT_STALLED else Verdict.ENDED
        last = float(speeds[-1]) if len(speeds) else first
        return SpeedResponse(verdict=verdict, mean_speeds=(first, last, last))
    amplitudes = [0.5 * float(np.ptp(quarter)) for quarter in quarters]
    middle = 0.5 * float(quarters[1].max() + quarters[1].min())
    largest = float(np.max(np.abs(speeds - first)))
    is_sustained = amplitudes[1] > SETTLING_BAND * largest and amplitudes[1] > HUNTING_RATIO * amplitudes[0]
    second_half = speeds[times >= begin + 0.5 * (end - begin)]
    is_oscillation = np.count_nonzero(np.diff(np.sign(second_half - middle))) >= MIN_REVERSALS
    hunts = is_sustained and is_oscillation
    last = middle if hunts else float(speeds[-1])
    deviation = speeds - last
    change = last - first
    direction = math.copysign(1.0, change) if change else 1.0
    extreme = float(speeds[np.argmax(direction * speeds)])
    outside = np.flatnonzero(np.abs(deviation) > SETTLING_BAND * abs(change))
    settled = len(outside) < len(times) and (not len(outside) or outside[-1] + 1 < len(times))
    settled = settled and float(times[outside[-1]] if len(outside) else begin) < begin + 0.9 * (end - begin) and not hunts
    return SpeedResponse(
        verdict=Verdict.HUNTS if hunts else Verdict.SETTLES if settled else Verdict.UNDECIDED,
        mean_speeds=(first, extreme, last),
        overshoot=direction * (extreme - last) / abs(change) if change else math.nan,
        settling_time=(float(times[outside[-1] + 1]) - begin if len(outside) else 0.0) if settled else math.inf,
        speed_error_integral=float(np.trapezoid(np.abs(deviation), times)),
        hunting_amplitude=amplitudes[1] / middle,
        hunting_period=_period(times, speeds - middle, begin + 0.5 * (end - begin)) if hunts else math.nan,
    )


def _period(times: FloatArray, deviation: FloatArray, begin: float) -> float:
    """Return the mean time between upward zero crossings from a time on, s; not a number for fewer than two."""
    rising = np.flatnonzero((deviation[:-1] < 0.0) & (deviation[1:] >= 0.0) & (times[:-1] >= begin))
    fractions = deviation[rising] / (deviation[rising] - deviation[rising + 1])
    crossings = times[rising] + fractions * (times[rising + 1] - times[rising])
    return float(np.mean(np.diff(crossings))) if len(crossings) > 1 else math.nan


@dataclass(frozen=True, kw_only=True, eq=False)
class TurnAverage:
    """Mean speed over one turn, as a function of time."""

    times: FloatArray  # middle of each turn, s; shape (n,)
    periods: FloatArray  # time that each turn takes, s; shape (n,)
    speeds: FloatArray  # mean speed over it, rad/s; shape (n,)
    fluctuations: FloatArray  # highest less lowest speed in it, over the mean; shape (n,)


def average_over_turns(
    times: FloatArray,  # times, s; shape (n,)
    angles: FloatArray,  # angle of the shaft, rad, rising; shape (n,)
    speeds: FloatArray,  # its rate, rad/s, above 0; shape (n,)
) -> TurnAverage:
    """Return the mean speeds over the turns about the reported times that lie between the first and the last one."""
    ends = np.flatnonzero(angles >= angles[0] + math.tau)
    starts = interpolate_samples(angles, times, 1.0 / speeds, angles[ends] - math.tau)
    first = np.searchsorted(angles, angles[ends] - math.tau)
    periods = times[ends] - starts
    means = math.tau / periods
    spans = np.array([np.ptp(speeds[i : j + 1]) for i, j in zip(first, ends, strict=True)])
    return TurnAverage(times=0.5 * (starts + times[ends]), periods=periods, speeds=means, fluctuations=spans / means)


CHANGE_AT = 0.1
"""Time of the change of load, relative to the duration, unless it is given."""

MIN_REPORTS_PER_TURN = 24
"""Reported times in a turn, from which on its mean speed and fluctuation are good to some percent of the fluctuation."""

MIN_TURNS = 4
"""Turns of the shaft before and after the change that a judgement needs."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LoadChangeStudy(Result):
    """Response of a governed engine to a change of its load. Speeds are those of the shaft, averaged over a turn.

    Attributes
    ----------
    title
        Title of the scene.
    fractions
        Load before and after the change, relative to the rated torque.
    change_times
        Begin and end of the change, s.
    before, after
        Equilibria by statics, at both loads; None where there is none.
    verdict
        How the speed behaves.
    mean_speeds
        Simulated speed before the change, its extreme after it, and the last one, rad/s.
    overshoot
        How far the extreme speed is beyond the last one, relative to the change of speed.
    settling_time
        Time from the begin of the change until the speed stays within `SETTLING_BAND` of the last one, s; infinite if it does not.
    speed_error_integral
        Integral of the distance from the last speed over time, from the begin of the change, rad.
    fluctuations
        Cyclic speed fluctuation, (highest - lowest) / mean in a turn, before the change and at the end.
    hunting_amplitude
        Half the range of the speed in the last quarter after the change, over its mean.
    hunting_period
        Period of the sustained oscillation, s; not a number without one.
    sleeve_force
        Largest force at the sleeve that the speed left unbalanced after the change, N: what is there to move throttle and friction.
    sleeve_friction
        Dry friction at the sleeve, N.
    work
        Energies since the begin of the run, J: work of the engine, work taken by the load, dissipated energy, and energy stored in all
        bodies and springs; and what is left between them.
    dashpot_work
        Energy that dashpots and friction have dissipated since the begin of the change, J.
    messages
        What the statics say before the run, and how the run ended.
    average
        Mean speed over a turn along the run.
    run
        The run.
    """

    title: str
    fractions: tuple[float, float]
    change_times: tuple[float, float]
    before: OperatingPoint | None
    after: OperatingPoint | None
    verdict: Verdict
    mean_speeds: tuple[float, float, float]
    overshoot: float
    settling_time: float
    speed_error_integral: float
    fluctuations: tuple[float, float]
    hunting_amplitude: float
    hunting_period: float
    sleeve_force: float
    sleeve_friction: float
    work: dict[str, float]
    dashpot_work: float
    messages: tuple[str, ...]
    average: TurnAverage
    run: Trajectory

    __repr__ = short_repr

    figure = "render.figures.regulation.load_change_figure"
    data_files = ("json",)
    hidden = ("average", "run")
    derived = ("static_droop", "droop", "largest_deviation", "run=engine_record")
    index = "time"
    columns = (
        Column("time", unit="s", value="average.times"),
        Column("speed", unit="rad/s", value="average.speeds"),
        Column("fluctuation", unit="1", value="average.fluctuations"),
        Column("period", unit="s", value="average.periods"),
    )

    @property
    def ok(self) -> bool:
        """Whether the speed settles."""
        return self.verdict is Verdict.SETTLES

    @property
    def static_droop(self) -> float:
        """Change of speed between the equilibria, relative to the first; not a number without both."""
        if self.before is None or self.after is None:
            return math.nan
        return self.after.shaft_speed / self.before.shaft_speed - 1

    @property
    def droop(self) -> float:
        """Change of the simulated mean speed, relative to that before the change."""
        return self.mean_speeds[2] / self.mean_speeds[0] - 1

    @property
    def largest_deviation(self) -> float:
        """Extreme speed after the change, relative to that before it."""
        return self.mean_speeds[1] / self.mean_speeds[0] - 1

    @property
    def engine_record(self) -> dict[str, object]:
        """What the record has of the run."""
        return {"engine": self.run.cost.engine, "error_estimate": self.run.error_estimate, "outcome": self.run.outcome.value}

    def __str__(self) -> str:
        """Return a table of the numbers and the verdict."""
        return "\n".join([*self.messages, format_list(_LISTED, self), self.conclusion])

    @property
    def conclusion(self) -> str:
        """One sentence on the response."""
        before, after = self.fractions
        change = f"load {100 * before:.4g} % to {100 * after:.4g} %"
        if self.verdict is Verdict.SETTLES:
            return f"{change}: the speed settles within {SETTLING_BAND:.0%} of its change in {self.settling_time:.4g} s"
        if self.verdict is Verdict.HUNTS:
            period = f", period {self.hunting_period:.4g} s" if math.isfinite(self.hunting_period) else ""
            return f"{change}: the engine hunts, by ±{self.hunting_amplitude:.3%} of its speed{period}"
        return f"{change}: the engine {self.verdict}"


def _force_in_friction(study: LoadChangeStudy) -> str:
    """Return the largest free force at the sleeve, also relative to its friction, if it has any."""
    friction = f", {study.sleeve_force / study.sleeve_friction:.3g} times its friction" if study.sleeve_friction else ""
    return f"{study.sleeve_force:.4g} N{friction}"


def _if_finite(value: float, form: str, words: str) -> str:
    """Return a number with words after it; empty where there is none."""
    return f"{value:{form}} {words}" if math.isfinite(value) else ""


_LISTED = (
    Column("", "mean speed before, extreme, last", "{mean_speeds[0]:.4f/rpm}, {mean_speeds[1]:.4f/rpm}, {mean_speeds[2]:.4f rpm}"),
    Column("", "droop, simulated / by statics", "{droop:+.4%} / {static_droop:+.4%}"),
    Column("", "largest deviation of speed", "{largest_deviation:+.4%}"),
    Column("overshoot", "overshoot beyond the last speed", lambda one: _if_finite(one.overshoot, ".2%", "of the change")),
    Column("settling_time", "settling time", lambda one: _if_finite(one.settling_time, ".4g", "s")),
    Column("", "integral of the speed error", "{speed_error_integral:.4g} rad"),
    Column("", "cyclic speed fluctuation before / last", "{fluctuations[0]:.4%} / {fluctuations[1]:.4%}"),
    Column("", "largest free force at the sleeve", _force_in_friction),
    Column("", "work of dashpots and friction", "{dashpot_work:.4g} J"),
    Column(
        "",
        "energy: engine, load, dissipated, stored, left",
        "{work[engine]:.6g}, {work[load]:.6g}, {work[dissipated]:.6g}, {work[stored]:.6g}, {work[left]:.6g} J",
    ),
)
"""What is printed of a study."""


def parse_load_step(load_step: object) -> tuple[float, float]:
    """Return the loads before and after a change, relative to the rated torque; raise MechanismError if there are not two."""
    items = load_step.split(":") if isinstance(load_step, str) else load_step
    if not isinstance(items, Sequence) or len(items) != 2:
        raise MechanismError(f'a change of the load is two fractions of the rated torque, as "100%:50%"; found {format_value(load_step)}')
    before, after = (parse_quantity(_bare_number(item), "ratio", "the load") for item in items)
    return before, after


def _bare_number(item: object) -> Any:
    """Return a text that is a bare number, as a command line gives it, as that number, and anything else as it is."""
    try:
        return float(item) if isinstance(item, str) else item
    except ValueError:
        return item


def study_load_change(
    scene: Scene,
    # load before and after the change, relative to the rated torque
    fractions: tuple[float, float] = (1.0, 0.5),
    *,
    at: float | None = None,  # time of the change, s; a tenth of the duration if None
    ramp: float = 0.0,  # duration of the change, s; 0 for a step
    engine: str = "auto",
    accuracy: float | None = None,  # accuracy of the run; that of the scene if None
) -> LoadChangeStudy:
    """Run a governed engine whose load changes, from the equilibrium under the first load, and measure the response."""
    begin, end = _change_times(scene, at, ramp)
    for fraction in fractions:
        if not fraction >= 0 or not math.isfinite(fraction):
            raise MechanismError(f"a load is a fraction of the rated torque, 0 or more; got {fraction:g}")
    if fractions[0] == fractions[1]:
        raise MechanismError(f"the load does not change: it is {fractions[0]:g} before and after; give two different fractions")
    values = (fractions[0], fractions[0], fractions[1], fractions[1])
    program = InputFunction(times=(0.0, begin, end, max(end, scene.run.duration) + 1.0), values=values)
    governed = GovernedEngine(GovernedEngine(scene).with_load(program))
    before = governed.operating_point(fractions[0] * governed.load.rated_torque)
    messages, after = [], None
    try:
        after = governed.operating_point(fractions[1] * governed.load.rated_torque)
    except MechanismError as error:
        messages.append(str(error))
    started = governed.started_at(before)
    # Means over a turn need several reports in it.
    interval = min(started.run.output_interval, math.tau / (before.shaft_speed * MIN_REPORTS_PER_TURN))
    settings = replace(started.run, output_interval=interval, accuracy=started.run.accuracy if accuracy is None else accuracy)
    started = replace(started, run=settings)
    chosen, reason = select_engine(started.run.engine if engine == "auto" else engine, started)
    run = chosen.run(started, reason=reason)
    if not run.outcome.ok:
        messages.append(run.message)
    return _measure(governed, run, fractions, (begin, end), before, after, tuple(messages))


def _change_times(scene: Scene, at: float | None, ramp: float) -> tuple[float, float]:
    """Return begin and end of the change, s."""
    duration = scene.run.duration
    begin = CHANGE_AT * duration if at is None else at
    if not 0 < begin < duration:
        raise MechanismError(f"the load changes at {begin:g} s, outside of the run, 0 to {duration:g} s; give a time within it")
    if not ramp >= 0 or not begin + ramp < duration:
        raise MechanismError(f"the change of the load must last 0 s or more and end within the run, by {duration:g} s; got {ramp:g} s")
    return begin, begin + ramp


def _measure(
    governed: GovernedEngine,
    run: Trajectory,
    fractions: tuple[float, float],
    change_times: tuple[float, float],
    before: OperatingPoint,
    after: OperatingPoint | None,
    messages: tuple[str, ...],
) -> LoadChangeStudy:
    """Return the response that a run shows."""
    angles = run.readings[governed.shaft_angle]
    speeds = run.rates[governed.shaft_angle]
    moving = np.flatnonzero(speeds > 0.0)
    rows = slice(0, int(moving[-1]) + 1 if len(moving) else 0)
    average = average_over_turns(run.times[rows], angles[rows], speeds[rows])
    begin = change_times[0]
    is_before = average.times + 0.5 * average.periods <= begin
    is_after = average.times >= begin
    turns = [float(speeds[0]) * begin / math.tau, float(angles[-1] - np.interp(begin, run.times, angles)) / math.tau]
    if min(turns) < MIN_TURNS and reached_end(run):
        raise MechanismError(
            f"the shaft makes {turns[0]:.3g} turns before the change of the load and {turns[1]:.3g} after it, and a judgement needs "
            f"{MIN_TURNS} of both; increase run.duration, or change the time of the change"
        )
    speeds_before = average.speeds[is_before]
    later_times = average.times[is_after]
    later = average.speeds[is_after]
    first = float(speeds_before[-1]) if len(speeds_before) else before.shaft_speed
    response = judge_speed(run, begin, first, later_times, later)
    sleeve_force = _sleeve_force(governed, run, begin)
    dissipated = run.energy.dissipated_energy
    return LoadChangeStudy(
        title=run.scene.title,
        fractions=fractions,
        change_times=change_times,
        before=before,
        after=after,
        fluctuations=(_last(average.fluctuations[is_before]), _last(average.fluctuations)),
        sleeve_force=sleeve_force,
        sleeve_friction=_sleeve_friction(governed),
        work=_work_ledger(governed, run),
        dashpot_work=float(dissipated[-1] - np.interp(begin, run.times, dissipated)),
        messages=messages,
        average=average,
        run=run,
        **vars(response),
    )


def _last(values: FloatArray) -> float:
    return float(values[-1]) if len(values) else math.nan


def _sleeve_force(governed: GovernedEngine, run: Trajectory, begin: float) -> float:
    """Return the largest force along the sleeve that speed, weights and springs leave unbalanced after a time, N."""
    rows = run.times >= begin
    if not rows.any():
        return math.nan
    coordinates = run.readings[governed.coordinate][rows]
    speeds = run.rates[governed.shaft_angle][rows]
    forces = governed.sleeve_forces(coordinates, speeds)
    return float(np.abs(forces).max())


def _sleeve_friction(governed: GovernedEngine) -> float:
    """Return the dry friction at the sleeve, N."""
    frictions = [one for one in governed.scene.output_effects if isinstance(one, DryFriction) and one.reading == governed.sleeve]
    return float(sum(one.contact["friction"].values[-1] for one in frictions))


def _work_ledger(governed: GovernedEngine, run: Trajectory) -> dict[str, float]:
    """Return the energies of the whole run, J; what is left between them is the error of the energy balance."""
    energy, ends = run.energy, run.readings[governed.coordinate][[0, -1]]
    kinetic = energy.kinetic + energy.rotation
    change = float(kinetic[-1] - kinetic[0]) + governed.potential_difference(*ends.tolist())
    drift = float(energy.jacobi[-1] - energy.jacobi[0])
    dissipated = float(energy.dissipated_energy[-1] - energy.dissipated_energy[0])
    load = governed.load_work(run.times, run.readings[governed.shaft_angle], run.rates[governed.shaft_angle])
    return {"engine": change - drift + load + dissipated, "load": load, "dissipated": dissipated, "stored": change, "left": drift}

"""Vyshnegradskii's first thesis, that a governor needs damping, Zehnder's advice on the oil brake; whether dry friction replaces it."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.droop import find_growth_rate
from governor_mechanism.papers.rule import (
    DURATION,
    HALF_LOAD,
    INTERVAL,
    SLEEVE,
    RuleCheck,
    SteadyEngine,
    Verdict,
    dashpot_on_sleeve,
    find_coordinate_at,
    find_steady_engine,
    friction_on_sleeve,
    linearise_scene_from_start,
    load_step,
    start_at_rest,
    with_values,
)
from governor_mechanism.statics.linearisation import Linearisation, StabilityLimit, find_stability_limit
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.types import FloatArray

DAMPINGS = (12.0, 18.0, 22.0, 26.0, 32.0, 40.0, 60.0, 100.0, 150.0, 200.0, 250.0, 300.0, 400.0, 600.0, 1000.0, 1700.0, 3000.0)
"""Dashpots on the sleeve, N s/m."""

SHOWN_DAMPINGS = (12.0, 250.0, 1700.0)
"""Dashpots whose runs are drawn, N s/m."""

LOAD_BEFORE = 0.75
"""Load before it falls to the half, over the rated torque."""

SETTLING_TOLERANCE = 0.02
"""Half-width of the settling band about the new lift of the sleeve, relative to its change."""

STEP_TIME, RUN_TIME = 1.0, 61.0
"""Time of the load step, and duration of a run, s: twice the settling time of the strongest dashpot."""

MAX_DAMPING = 1e3
"""Upper end of the range in which the limit of stability lies, N s/m."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DashpotCheck(RuleCheck):
    """Settling time of the engine after a load step, against the dashpot."""

    title: ClassVar[str] = "damping"
    source: ClassVar[str] = (
        "I. A. Vyshnegradskii (1877), after L. S. Pontryagin, Ordinary Differential Equations, section 27; L. Zehnder (1877)"
    )
    statement: ClassVar[str] = (
        "'No friction, no governor', that of a dashpot; set right, it brings the new steady state in the shortest time."
    )

    dampings: FloatArray  # dashpots on the sleeve, N s/m; shape (n,), ascending
    # time from the load step until the sleeve stays within the settling band, s; infinite if it does not;
    # shape (n,)
    settling_times: FloatArray
    undamped_growth_rate: float  # growth rate of the motion without dashpot, 1/s
    limit: float  # dashpot at the limit of stability, N s/m
    limit_frequency: float  # frequency of the hunting that begins there, rad/s
    # dashpot, N s/m, times, s, and lift of the sleeve, m, of some runs
    histories: tuple[tuple[float, FloatArray, FloatArray], ...]

    @property
    def best(self) -> tuple[float, float]:
        """Dashpot with the shortest settling time, N s/m, and that time, s."""
        k = int(np.argmin(self.settling_times))
        return float(self.dampings[k]), float(self.settling_times[k])

    @property
    def verdict(self) -> Verdict:
        """Holds if the engine hunts without dashpot, and if some dashpot between too little and too much settles first."""
        is_settled_where_stable = np.array_equal(np.isfinite(self.settling_times), self.dampings > self.limit)
        is_best_between = self.dampings[0] < self.best[0] < self.dampings[-1]
        if self.undamped_growth_rate > 0 and is_settled_where_stable and is_best_between:
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if self.undamped_growth_rate > 0 else Verdict.FAILS

    @property
    def finding(self) -> str:
        """Growth without dashpot, limit of stability, and the best dashpot."""
        hunting = f"without dashpot hunting grows with {self.undamped_growth_rate:.3g} 1/s"
        limit = f"from {self.limit:.3g} N s/m on it decays (at {self.limit_frequency:.3g} rad/s)"
        damping, time = self.best
        slow = f"{self.settling_times[-1]:.3g} s with {self.dampings[-1]:g}"
        first = int(np.argmax(np.isfinite(self.settling_times)))
        hunt = f"{self.settling_times[first]:.3g} s with {self.dampings[first]:g}"
        return f"{hunting}, {limit}; the sleeve settles first, in {time:.3g} s, with {damping:g} N s/m ({hunt}, {slow})"

    def numbers(self) -> dict[str, Any]:
        """Return dashpots, settling times and the limit of stability."""
        times = [time if math.isfinite(time) else None for time in self.settling_times.tolist()]
        curve = {"dampings": self.dampings.tolist(), "settling_times": times, "undamped_growth_rate": self.undamped_growth_rate}
        return {**curve, "limit": self.limit, "limit_frequency": self.limit_frequency}


def check_dashpot(mean_engine: Scene, point: SteadyEngine) -> DashpotCheck:
    """Run the engine with mean torque through a load step with several dashpots: settling times and the limit of stability."""
    before = find_steady_engine(mean_engine, {"load.fraction": LOAD_BEFORE})
    settling_times, histories = [], []
    for damping in DAMPINGS:
        times, lifts = _run_load_step(before, damping)
        settling_times.append(_find_settling_time(times, lifts, point.sleeve_lift))
        if damping in SHOWN_DAMPINGS:
            histories.append((damping, times, lifts))
    limit = find_damping_limit(point)
    return DashpotCheck(
        dampings=np.array(DAMPINGS),
        settling_times=np.array(settling_times),
        undamped_growth_rate=linearise_scene_from_start(with_values(point.scene, dashpot_on_sleeve(0.0))).growth_rate,
        limit=limit.value,
        limit_frequency=limit.frequency,
        histories=tuple(histories),
    )


def find_damping_limit(point: SteadyEngine) -> StabilityLimit[Linearisation]:
    """Return the dashpot on the sleeve, N s/m, at which the steady state of an engine becomes stable."""

    def linearise_at(damping: float) -> Linearisation:
        return linearise_scene_from_start(with_values(point.scene, dashpot_on_sleeve(damping)))

    return find_stability_limit(linearise_at, 0.0, MAX_DAMPING, key="the dashpot on the sleeve", unit="N s/m")


def _run_load_step(before: SteadyEngine, damping: float) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and lifts of the sleeve, m, of a load step to half load."""
    values = {**dashpot_on_sleeve(damping), **load_step(LOAD_BEFORE, HALF_LOAD, STEP_TIME), DURATION: RUN_TIME}
    run = run_uncertified(with_values(before.scene, values))
    return run.times, run.readings[SLEEVE]


def _find_settling_time(times: FloatArray, lifts: FloatArray, final_lift: float) -> float:
    """Return the time, s, from the load step until the sleeve stays within the settling band; infinite if it leaves it near the end."""
    outside = np.flatnonzero(np.abs(lifts - final_lift) > SETTLING_TOLERANCE * abs(lifts[0] - final_lift))
    last = float(times[outside[-1]])
    return math.inf if last > 0.9 * times[-1] else last - STEP_TIME


FRICTION = 0.5
"""Friction on the sleeve, N: so small that the limiting amplitude is a tenth of the lift at most, where the equations are nearly linear."""

COMPARED_DAMPINGS = (0.0, 5.0, 10.0)
"""Dashpots on the sleeve below the limit of stability, N s/m."""

FRICTION_RUN_TIME, OUTPUT_INTERVAL = 10.0, 0.02
"""Duration of a run, 8 periods of the hunting, and interval of reported times, s."""

SHOWN_RATIOS = (0.8, 1.2)
"""Displacements of the runs that are drawn, over the limiting amplitude of harmonic balance."""

LOWEST_RATIO, HIGHEST_RATIO = 0.7, 1.4
"""Displacements between which the limit is sought, over that of harmonic balance."""

RATIO_STEP = 0.01
"""Width of the last interval of the bisection."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DryFrictionCheck(RuleCheck):
    """Largest displacement from which the sleeve comes to rest, in an engine that hunts without friction."""

    title: ClassVar[str] = "dry friction instead of a dashpot"
    source: ClassVar[str] = "I. A. Vyshnegradskii (1877), after L. S. Pontryagin, Ordinary Differential Equations, section 27"
    statement: ClassVar[str] = (
        "'No friction, no governor': does the dry friction at the sleeve do, where the theory means that of a dashpot?"
    )

    friction: float  # friction on the sleeve, N
    dampings: FloatArray  # dashpots on the sleeve, N s/m; shape (n,)
    growth_rates: FloatArray  # growth rate of the hunting without friction, 1/s; shape (n,)
    limits: FloatArray  # displacement of the sleeve beyond which the hunting grows, m; shape (n,)
    predicted_limits: FloatArray  # the same by harmonic balance, m; shape (n,)
    # displacement over that of harmonic balance, times, s, and lift of the sleeve, m, of runs without dashpot
    histories: tuple[tuple[float, FloatArray, FloatArray], ...]

    @property
    def verdict(self) -> Verdict:
        """Holds if friction stops every hunting; with a condition if it does so up to a displacement."""
        if np.all(np.isinf(self.limits)):
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if np.all(self.limits > 0) else Verdict.FAILS

    @property
    def condition(self) -> str:
        """Displacement up to which friction stops the hunting without dashpot."""
        return f"up to {1e3 * self.limits[0]:.1f} mm" if self.verdict is Verdict.CONDITIONAL else ""

    @property
    def finding(self) -> str:
        """Limiting displacements and those of harmonic balance."""
        growth = f"without dashpot and friction hunting grows with {self.growth_rates[0]:.3g} 1/s"
        stop = f"{self.friction:g} N stop it from displacements up to {1e3 * self.limits[0]:.2g} mm, beyond it grows"
        deviation = float(np.abs(self.limits / self.predicted_limits - 1).max())
        law = f"4 W / (pi omega (c0 - c)) of harmonic balance gives {1e3 * self.predicted_limits[0]:.2g} mm"
        dampings = ", ".join(f"{damping:g}" for damping in self.dampings)
        return f"{growth}; {stop}; {law} (within {deviation:.0%} for c = {dampings} N s/m)"

    def numbers(self) -> dict[str, Any]:
        """Return dashpots, growth rates and limiting displacements."""
        names = ("dampings", "growth_rates", "limits", "predicted_limits")
        return {"friction": self.friction, **{name: getattr(self, name).tolist() for name in names}}


def check_dry_friction(point: SteadyEngine) -> DryFrictionCheck:
    """Displace the sleeve of an engine that hunts without friction, and see whether friction brings it to rest."""
    limit = find_damping_limit(point)
    # A harmonic motion of amplitude A and frequency w loses 4 W A to friction and pi w (c0 - c) A^2 to the missing dashpot per period.
    predicted = np.array([4 * FRICTION / (math.pi * limit.frequency * (limit.value - damping)) for damping in COMPARED_DAMPINGS])
    pairs = list(zip(COMPARED_DAMPINGS, predicted.tolist(), strict=True))
    return DryFrictionCheck(
        friction=FRICTION,
        dampings=np.array(COMPARED_DAMPINGS),
        growth_rates=np.array([find_growth_rate(point, damping) for damping in COMPARED_DAMPINGS]),
        limits=np.array([_find_limit(point, damping, displacement) for damping, displacement in pairs]),
        predicted_limits=predicted,
        histories=tuple((ratio, *run_displaced(point, COMPARED_DAMPINGS[0], ratio * predicted[0])) for ratio in SHOWN_RATIOS),
    )


def run_displaced(point: SteadyEngine, damping: float, displacement: float) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and lifts of the sleeve, m, after a displacement of the sleeve, m, under dry friction."""
    start = start_at_rest(point.scene, find_coordinate_at(point.scene, point.sleeve_lift + displacement))
    times = {DURATION: FRICTION_RUN_TIME, INTERVAL: OUTPUT_INTERVAL}
    run = run_uncertified(with_values(point.scene, {**dashpot_on_sleeve(damping), **friction_on_sleeve(FRICTION), **start, **times}))
    return run.times, run.readings[SLEEVE]


def does_hunting_grow(lifts: FloatArray) -> bool:
    """Return whether the sleeve moves further in the last quarter of a run than in the second one."""
    quarter = len(lifts) // 4
    return bool(np.ptp(lifts[-quarter:]) > np.ptp(lifts[quarter : 2 * quarter]))


def _find_limit(point: SteadyEngine, damping: float, predicted: float) -> float:
    """Return the displacement of the sleeve, m, beyond which the hunting grows: 0 or infinite if it is not near the predicted one."""

    def grows_from(ratio: float) -> bool:
        return does_hunting_grow(run_displaced(point, damping, ratio * predicted)[1])

    low, high = LOWEST_RATIO, HIGHEST_RATIO
    if grows_from(low):
        return 0.0
    if not grows_from(high):
        return math.inf
    while high - low > RATIO_STEP:
        midpoint = 0.5 * (low + high)
        low, high = (low, midpoint) if grows_from(midpoint) else (midpoint, high)
    return 0.5 * (low + high) * predicted

"""Vyshnegradskii's first thesis, that a governor needs damping, and Zehnder's advice to adjust the oil brake."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rules.engines import (
    DURATION,
    HALF_LOAD,
    SLEEVE,
    SteadyEngine,
    dashpot_on_sleeve,
    find_steady_engine,
    linearise_scene_from_start,
    load_step,
    with_values,
)
from governor_mechanism.papers.rules.rule import RuleCheck, Verdict
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
    """Settling time of the engine after a load step, against the dashpot.

    Attributes
    ----------
    dampings
        Dashpots on the sleeve, N s/m; shape (n,), ascending.
    settling_times
        Time from the load step until the sleeve stays within the settling band, s; infinite if it does not; shape (n,).
    undamped_growth_rate
        Growth rate of the motion without dashpot, 1/s.
    limit
        Dashpot at the limit of stability, N s/m.
    limit_frequency
        Frequency of the hunting that begins there, rad/s.
    histories
        Dashpot, N s/m, times, s, and lift of the sleeve, m, of some runs.
    """

    title: ClassVar[str] = "damping"
    source: ClassVar[str] = (
        "I. A. Vyshnegradskii (1877), after L. S. Pontryagin, Ordinary Differential Equations, section 27; L. Zehnder (1877)"
    )
    statement: ClassVar[str] = (
        "'No friction, no governor', that of a dashpot; set right, it brings the new steady state in the shortest time."
    )

    dampings: FloatArray
    settling_times: FloatArray
    undamped_growth_rate: float
    limit: float
    limit_frequency: float
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

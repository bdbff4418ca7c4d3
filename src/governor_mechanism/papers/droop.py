"""Zehnder's rule that an astatic governor cannot regulate, which is Vyshnegradskii's second thesis: no governor without droop."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.model.coupling.couplings import ControlCoupling
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import TableFunction
from governor_mechanism.papers.rule import (
    DURATION,
    ENGINE_SPEED,
    HALF_LOAD,
    LOAD,
    RuleCheck,
    SteadyEngine,
    Verdict,
    dashpot_on_sleeve,
    find_steady_engine,
    gear_to_speed,
    linearise_scene_from_start,
    load_step,
    with_values,
)
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.types import FloatArray

OFFSET = "part.governor.dimensions.offset"
"""Key of the distance of the suspension from the axis; negative for crossed arms."""

N_DROOPS = 7
"""Governors between that of the scene and the astatic one."""

DAMPINGS = (30.0, 300.0, 3000.0)
"""Dashpots on the sleeve, N s/m, for curves of the growth rate."""

ASTATIC_DAMPINGS = (30.0, 100.0, 300.0, 1000.0, 3000.0, 10000.0, 30000.0)
"""Dashpots on the sleeve of the astatic governor, N s/m."""

SHOWN_DAMPING = 300.0
"""Dashpot of the runs, N s/m: near the best of the governor with droop."""

LOAD_AFTER = 0.49
"""Load after a small step from half load: motions stay linear, so that their growth can be compared with the eigenvalue."""

STEP_TIME, RUN_TIME = 1.0, 41.0
"""Time of the load step, and duration of a run, s."""

LOWEST_OFFSET = -0.075
"""Crossed arms with which the governor has a negative droop, m."""

OFFSET_TOLERANCE = 1e-9
"""Tolerance of the offset of the astatic governor, m: its droop is zero within 1e-8."""

USEFUL_TIME = 60.0
"""Time, s, within which a disturbance of a useful governor falls to 1 / e."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DroopCheck(RuleCheck):
    """Growth of small disturbances against the droop of the governor."""

    title: ClassVar[str] = "droop"
    source: ClassVar[str] = "L. Zehnder (1877) after L. Kargl; I. A. Vyshnegradskii (1877), after L. S. Pontryagin, section 27"
    statement: ClassVar[str] = (
        "An astatic governor, which has the same speed in every position, cannot regulate: 'no non-uniformity, no governor'."
    )

    offsets: FloatArray  # distance of the suspension from the axis, m; shape (n,); the last governor is astatic
    # relative change of the equilibrium speed over the travel of the throttle, at the slope of the operating
    # point; shape (n,)
    droops: FloatArray
    dampings: FloatArray  # dashpots on the sleeve, N s/m; shape (m,)
    growth_rates: FloatArray  # largest growth rate, 1/s; shape (m, n)
    astatic_growth_rates: Mapping[float, float]  # largest growth rate with the astatic governor, 1/s, by the dashpot, N s/m
    # droop, times, s, and relative deviation of the speed of a run with droop and of one without
    histories: tuple[tuple[float, FloatArray, FloatArray], ...]
    # growth rate of the oscillation in the run without droop, 1/s, with a load a little below the operating
    # point
    simulated_growth_rate: float
    predicted_growth_rate: float  # growth rate of the equations linearised about its last steady state, 1/s

    @property
    def best_astatic(self) -> tuple[float, float]:
        """Dashpot with the lowest growth rate of the astatic governor, N s/m, and that rate, 1/s."""
        damping = min(self.astatic_growth_rates, key=self.astatic_growth_rates.__getitem__)
        return damping, self.astatic_growth_rates[damping]

    @property
    def verdict(self) -> Verdict:
        """Holds if the astatic governor hunts with every dashpot, one with droop does not; with a condition if it decays slowly."""
        if self.growth_rates[:, 0].min() >= 0 or -self.best_astatic[1] * USEFUL_TIME > 1:
            return Verdict.FAILS
        return Verdict.HOLDS if self.best_astatic[1] >= 0 else Verdict.CONDITIONAL

    @property
    def condition(self) -> str:
        """Time constant of the fastest decay of the astatic governor."""
        return f"decay takes {-1 / self.best_astatic[1] / 3600:.0f} h" if self.verdict is Verdict.CONDITIONAL else ""

    @property
    def finding(self) -> str:
        """Growth rates with and without droop."""
        k = self.dampings.tolist().index(SHOWN_DAMPING)
        static = f"the growth rate with {SHOWN_DAMPING:g} N s/m is {self.growth_rates[k, 0]:.2g} 1/s at a droop of {self.droops[0]:.1%}"
        run = f"(in the run {self.simulated_growth_rate:.3f}, by the eigenvalue {self.predicted_growth_rate:.3f})"
        astatic = f"and {self.growth_rates[k, -1]:+.2g} 1/s without droop {run}"
        damping, rate = self.best_astatic
        if rate >= 0:
            return f"{static} {astatic}; it is positive with every dashpot, {rate:.1g} 1/s with {damping:g} N s/m"
        stable = min(one for one, growth in self.astatic_growth_rates.items() if growth < 0)
        slow = f"only from {stable:g} N s/m on a disturbance decays, with a time constant of {-1 / rate / 3600:.0f} h at least"
        return f"{static} {astatic}; {slow}"

    def numbers(self) -> dict[str, Any]:
        """Return offsets, droops and growth rates."""
        names = ("offsets", "droops", "dampings", "growth_rates")
        astatic = [{"damping": damping, "growth_rate": rate} for damping, rate in self.astatic_growth_rates.items()]
        rates = {"simulated_growth_rate": self.simulated_growth_rate, "predicted_growth_rate": self.predicted_growth_rate}
        return {**{name: getattr(self, name).tolist() for name in names}, "astatic_growth_rates": astatic, **rates}


def check_droop(mean_engine: Scene, point: SteadyEngine) -> DroopCheck:
    """Cross the arms of the governor until it is astatic, and follow small disturbances: growth rates and two runs."""
    # The gear keeps the speed of the engine, and the throttle its place, so that the droop alone
    # changes.
    astatic_offset = find_astatic_offset(mean_engine, point)
    offsets = np.linspace(float(point.scene.part_of("governor")[0].dimensions["offset"]), astatic_offset, N_DROOPS)
    governors = [govern_with_offset(mean_engine, point, offset) for offset in offsets.tolist()]
    travel = throttle_travel(mean_engine)
    astatic = governors[-1]
    histories = [(one.droop_over(travel), *_run_load_step(one)) for one in (governors[0], astatic)]
    _, times, deviations = histories[-1]
    return DroopCheck(
        offsets=offsets,
        droops=np.array([governor.droop_over(travel) for governor in governors]),
        dampings=np.array(DAMPINGS),
        growth_rates=np.array([[find_growth_rate(governor, damping) for governor in governors] for damping in DAMPINGS]),
        astatic_growth_rates={damping: find_growth_rate(astatic, damping) for damping in ASTATIC_DAMPINGS},
        histories=tuple(histories),
        simulated_growth_rate=_fit_growth_rate(times, deviations),
        predicted_growth_rate=find_growth_rate(find_steady_engine(astatic.scene, {LOAD: LOAD_AFTER}), SHOWN_DAMPING),
    )


def throttle_travel(scene: Scene) -> float:
    """Return the travel of the sleeve, m, over which it moves the throttle."""
    functions = [one.function for one in scene.couplings if isinstance(one, ControlCoupling)]
    (table,) = (function for function in functions if isinstance(function, TableFunction))
    positions = table.positions
    return float(positions[-1] - positions[0])


def govern_with_offset(mean_engine: Scene, point: SteadyEngine, offset: float) -> SteadyEngine:
    """Return the same operating point of the engine under a governor with another offset of its arms, m, and a gear for it."""
    values = {OFFSET: offset}
    ungeared = find_steady_engine(mean_engine, values, sleeve_lift=point.sleeve_lift)
    return find_steady_engine(mean_engine, {**values, **gear_to_speed(ungeared, point.engine_speed)}, sleeve_lift=point.sleeve_lift)


def find_astatic_offset(mean_engine: Scene, point: SteadyEngine) -> float:
    """Return the offset of the arms, m, with which the equilibrium speed does not change about the operating point."""
    from scipy.optimize import brentq  # slow to import

    def droop_at(offset: float) -> float:
        return find_steady_engine(mean_engine, {OFFSET: offset}, sleeve_lift=point.sleeve_lift).droop_over(1.0)

    return float(brentq(droop_at, LOWEST_OFFSET, 0.0, xtol=OFFSET_TOLERANCE))


def find_growth_rate(point: SteadyEngine, damping: float) -> float:
    """Return the largest growth rate of small disturbances, 1/s, with a dashpot on the sleeve, N s/m."""
    return linearise_scene_from_start(with_values(point.scene, dashpot_on_sleeve(damping))).growth_rate


def _run_load_step(point: SteadyEngine) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and relative deviations of the speed from the operating point after a small load step."""
    values = {**dashpot_on_sleeve(SHOWN_DAMPING), **load_step(HALF_LOAD, LOAD_AFTER, STEP_TIME), DURATION: RUN_TIME}
    run = run_uncertified(with_values(point.scene, values))
    return run.times, run.readings[ENGINE_SPEED] / point.engine_speed - 1


def _fit_growth_rate(times: FloatArray, deviations: FloatArray) -> float:
    """Return the growth rate, 1/s, of an oscillation from the differences of its successive extremes."""
    turns = 1 + np.flatnonzero(np.diff(deviations)[:-1] * np.diff(deviations)[1:] < 0)
    turns = turns[times[turns] > STEP_TIME]
    swings = np.abs(np.diff(deviations[turns]))
    middles = 0.5 * (times[turns][1:] + times[turns][:-1])
    return float(np.polyfit(middles, np.log(swings), 1)[0])

"""Whether dry friction can replace the damping that a governor needs."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.papers.rules.dashpot import find_damping_limit
from governor_mechanism.papers.rules.droop import find_growth_rate
from governor_mechanism.papers.rules.engines import (
    DURATION,
    INTERVAL,
    SLEEVE,
    SteadyEngine,
    dashpot_on_sleeve,
    find_coordinate_at,
    friction_on_sleeve,
    start_at_rest,
    with_values,
)
from governor_mechanism.papers.rules.rule import RuleCheck, Verdict
from governor_mechanism.studies.plain_runs import run_uncertified
from governor_mechanism.types import FloatArray

FRICTION = 0.5
"""Friction on the sleeve, N: so small that the limiting amplitude is a tenth of the lift at most, where the equations are nearly linear."""

DAMPINGS = (0.0, 5.0, 10.0)
"""Dashpots on the sleeve below the limit of stability, N s/m."""

RUN_TIME, OUTPUT_INTERVAL = 10.0, 0.02
"""Duration of a run, 8 periods of the hunting, and interval of reported times, s."""

SHOWN_RATIOS = (0.8, 1.2)
"""Displacements of the runs that are drawn, over the limiting amplitude of harmonic balance."""

LOWEST_RATIO, HIGHEST_RATIO = 0.7, 1.4
"""Displacements between which the limit is sought, over that of harmonic balance."""

RATIO_STEP = 0.01
"""Width of the last interval of the bisection."""


@dataclass(frozen=True, kw_only=True, eq=False)
class DryFrictionCheck(RuleCheck):
    """Largest displacement from which the sleeve comes to rest, in an engine that hunts without friction.

    Attributes
    ----------
    friction
        Friction on the sleeve, N.
    dampings
        Dashpots on the sleeve, N s/m; shape (n,).
    growth_rates
        Growth rate of the hunting without friction, 1/s; shape (n,).
    limits
        Displacement of the sleeve beyond which the hunting grows, m; shape (n,).
    predicted_limits
        The same by harmonic balance, m; shape (n,).
    histories
        Displacement over that of harmonic balance, times, s, and lift of the sleeve, m, of runs without dashpot.
    """

    title: ClassVar[str] = "dry friction instead of a dashpot"
    source: ClassVar[str] = "I. A. Vyshnegradskii (1877), after L. S. Pontryagin, Ordinary Differential Equations, section 27"
    statement: ClassVar[str] = (
        "'No friction, no governor': does the dry friction at the sleeve do, where the theory means that of a dashpot?"
    )

    friction: float
    dampings: FloatArray
    growth_rates: FloatArray
    limits: FloatArray
    predicted_limits: FloatArray
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
    predicted = np.array([4 * FRICTION / (math.pi * limit.frequency * (limit.value - damping)) for damping in DAMPINGS])
    pairs = list(zip(DAMPINGS, predicted.tolist(), strict=True))
    return DryFrictionCheck(
        friction=FRICTION,
        dampings=np.array(DAMPINGS),
        growth_rates=np.array([find_growth_rate(point, damping) for damping in DAMPINGS]),
        limits=np.array([_find_limit(point, damping, displacement) for damping, displacement in pairs]),
        predicted_limits=predicted,
        histories=tuple((ratio, *run_displaced(point, DAMPINGS[0], ratio * predicted[0])) for ratio in SHOWN_RATIOS),
    )


def run_displaced(point: SteadyEngine, damping: float, displacement: float) -> tuple[FloatArray, FloatArray]:
    """Return times, s, and lifts of the sleeve, m, after a displacement of the sleeve, m, under dry friction."""
    start = start_at_rest(point.scene, find_coordinate_at(point.scene, point.sleeve_lift + displacement))
    times = {DURATION: RUN_TIME, INTERVAL: OUTPUT_INTERVAL}
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

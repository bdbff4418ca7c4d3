"""Zehnder's rule that the insensitivity of the governor must not be less than the fluctuation of speed, and his oil brake."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rules.engines import (
    INERTIA,
    CyclicEngine,
    SteadyEngine,
    build_cyclic_engine,
    dashpot_on_sleeve,
    friction_on_sleeve,
    linearise_scene_from_start,
    with_values,
)
from governor_mechanism.papers.rules.rule import RuleCheck, Verdict
from governor_mechanism.types import FloatArray

RATIOS = (0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.05, 1.4)
"""Insensitivity over fluctuation of speed, for the curve of the amplitude."""

FLYWHEELS = (800.0, 400.0)
"""Moments of inertia of the flywheel, kg m2, for which the threshold is sought."""

OIL_BRAKES = (100.0, 300.0, 1000.0, 3000.0)
"""Dashpots on the sleeve, N s/m."""

SHAKING_RATIO = 0.5
"""Insensitivity over fluctuation of speed at which dashpots and clearances are compared."""

N_TURNS = 20
"""Turns of a run; the last one is measured, when the amplitude changes by less than 1 % per turn."""

THRESHOLD_TOLERANCE = 2e-3
"""Deviation of a threshold from 1 that counts as none: half the last interval of the bisection, and the extremes of the sampled speed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ShakingCheck(RuleCheck):
    """Motion of the sleeve in every turn, against insensitivity over fluctuation of speed.

    Attributes
    ----------
    ratios
        Insensitivity over coefficient of fluctuation of speed; shape (n,).
    amplitudes
        Motion of the sleeve in the last turn, m; shape (n,).
    fluctuation
        Coefficient of fluctuation of speed.
    thresholds
        Ratio from which on the sleeve rests, by the moment of inertia of the flywheel, kg m2.
    """

    title: ClassVar[str] = "insensitivity at least the fluctuation of speed"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = (
        "A governor that is more sensitive than the flywheel (delta < epsilon) leaves its position at every turn: it shakes."
    )

    ratios: FloatArray
    amplitudes: FloatArray
    fluctuation: float
    thresholds: Mapping[float, float]

    @property
    def verdict(self) -> Verdict:
        """Holds if the sleeve moves below a ratio of 1 and rests above it, with every flywheel."""
        are_thresholds_one = all(abs(threshold - 1) < THRESHOLD_TOLERANCE for threshold in self.thresholds.values())
        moves = self.amplitudes > 0
        if are_thresholds_one and np.array_equal(moves, self.ratios < 1):
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if moves[self.ratios < 1].any() else Verdict.FAILS

    @property
    def finding(self) -> str:
        """The thresholds and the amplitude at the smallest ratio."""
        thresholds = ", ".join(f"{threshold:.4f} ({inertia:g} kg m2)" for inertia, threshold in self.thresholds.items())
        k = int(np.argmin(self.ratios))
        amplitude = f"{1e3 * self.amplitudes[k]:.2g} mm per turn at delta / epsilon = {self.ratios[k]:g}"
        return f"the sleeve rests from delta / epsilon = {thresholds} on; epsilon = {self.fluctuation:.4f}; it moves {amplitude}"

    def numbers(self) -> dict[str, Any]:
        """Return ratios, amplitudes and thresholds."""
        thresholds = [{"flywheel_inertia": inertia, "threshold": threshold} for inertia, threshold in self.thresholds.items()]
        curve = {"ratios": self.ratios.tolist(), "amplitudes": self.amplitudes.tolist()}
        return {**curve, "fluctuation": self.fluctuation, "thresholds": thresholds}


@dataclass(frozen=True, kw_only=True, eq=False)
class OilBrakeCheck(RuleCheck):
    """Shaking and recovery against the dashpot.

    Attributes
    ----------
    dampings
        Dashpots on the sleeve, N s/m; shape (n,), ascending.
    amplitudes
        Motion of the sleeve in the last turn, m; shape (n,).
    decay_rates
        Decay of the slowest motion with mean torque, 1/s; shape (n,).
    thresholds
        Ratio of insensitivity to fluctuation from which on the sleeve rests, with the weakest and the strongest dashpot.
    """

    title: ClassVar[str] = "an oil brake against shaking"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = "An oil brake reduces the shaking of every governor to a minimum without making it less sensitive."

    dampings: FloatArray
    amplitudes: FloatArray
    decay_rates: FloatArray
    thresholds: tuple[float, float]

    @property
    def reduction(self) -> float:
        """Amplitude with the weakest dashpot over that with the strongest."""
        return float(self.amplitudes[0] / self.amplitudes[-1])

    @property
    def slowing(self) -> float:
        """Fastest decay over that with the strongest dashpot."""
        return float(self.decay_rates.max() / self.decay_rates[-1])

    @property
    def verdict(self) -> Verdict:
        """Holds if the amplitude falls and the band stays; with a condition if the governor then answers less than half as fast."""
        is_sensitive = abs(self.thresholds[1] - self.thresholds[0]) < THRESHOLD_TOLERANCE
        if not np.all(np.diff(self.amplitudes) < 0) or not is_sensitive:
            return Verdict.FAILS
        return Verdict.CONDITIONAL if self.slowing > 2 else Verdict.HOLDS

    @property
    def condition(self) -> str:
        """How much slower the governor answers with the strongest dashpot."""
        return f"{self.slowing:.0f} times slower" if self.verdict is Verdict.CONDITIONAL else ""

    @property
    def finding(self) -> str:
        """Reduction of the amplitude, thresholds and decay rates."""
        weakest, strongest = self.dampings[0], self.dampings[-1]
        shaking = f"from {weakest:g} to {strongest:g} N s/m the sleeve moves {self.reduction:.1f} times less per turn"
        band = f"the band is the same (thresholds {self.thresholds[0]:.4f} and {self.thresholds[1]:.4f})"
        k = int(np.argmax(self.decay_rates))
        rates = (
            f"a disturbance decays with {self.decay_rates[-1]:.3g} instead of {self.decay_rates[k]:.3g} 1/s ({self.dampings[k]:g} N s/m)"
        )
        return f"{shaking}; {band}; {rates}"

    def numbers(self) -> dict[str, Any]:
        """Return dashpots, amplitudes, decay rates and thresholds."""
        curves = {"dampings": self.dampings, "amplitudes": self.amplitudes, "decay_rates": self.decay_rates}
        return {**{name: values.tolist() for name, values in curves.items()}, "thresholds": list(self.thresholds)}


def check_shaking(
    engine: Scene,  # scene of a governed engine whose gas acts at every instant
    point: SteadyEngine,
    cyclic_engine: CyclicEngine,
) -> ShakingCheck:
    """Run the governed engine at constant load under friction of several strengths: amplitudes and thresholds."""
    frictions = [friction_on_sleeve(cyclic_engine.find_friction(ratio)) for ratio in RATIOS]
    engines = {inertia: build_cyclic_engine(engine, point, {INERTIA: inertia}) for inertia in FLYWHEELS}
    return ShakingCheck(
        ratios=np.array(RATIOS),
        amplitudes=np.array([cyclic_engine.amplitudes_per_turn(N_TURNS, friction)[-1] for friction in frictions]),
        fluctuation=cyclic_engine.fluctuation,
        thresholds={inertia: one.find_threshold({}) for inertia, one in engines.items()},
    )


def check_oil_brake(cyclic_engine: CyclicEngine) -> OilBrakeCheck:
    """Run the governed engine at constant load with several dashpots under half the friction that would hold the sleeve."""
    friction = friction_on_sleeve(cyclic_engine.find_friction(SHAKING_RATIO))
    dashpots = [dashpot_on_sleeve(damping) for damping in OIL_BRAKES]
    amplitudes = [cyclic_engine.amplitudes_per_turn(N_TURNS, {**friction, **dashpot})[-1] for dashpot in dashpots]
    twins = [with_values(cyclic_engine.point.scene, dashpot) for dashpot in dashpots]
    return OilBrakeCheck(
        dampings=np.array(OIL_BRAKES),
        amplitudes=np.array(amplitudes),
        decay_rates=np.array([-linearise_scene_from_start(twin).growth_rate for twin in twins]),
        thresholds=(cyclic_engine.find_threshold(dashpots[0]), cyclic_engine.find_threshold(dashpots[-1])),
    )

"""Zehnder's rules that the insensitivity must not be less than the fluctuation of speed, and on the oil brake and clearance in joints."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from governor_mechanism.effects.holding import CLEARANCE_READING
from governor_mechanism.model.scene import Scene
from governor_mechanism.papers.rule import (
    INERTIA,
    CyclicEngine,
    RuleCheck,
    SteadyEngine,
    Verdict,
    build_cyclic_engine,
    dashpot_on_sleeve,
    find_coordinate_at,
    find_steady_engine,
    friction_on_sleeve,
    gear_to_speed,
    linearise_scene_from_start,
    with_values,
)
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
    """Motion of the sleeve in every turn, against insensitivity over fluctuation of speed."""

    title: ClassVar[str] = "insensitivity at least the fluctuation of speed"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = (
        "A governor that is more sensitive than the flywheel (delta < epsilon) leaves its position at every turn: it shakes."
    )

    ratios: FloatArray  # insensitivity over coefficient of fluctuation of speed; shape (n,)
    amplitudes: FloatArray  # motion of the sleeve in the last turn, m; shape (n,)
    fluctuation: float  # coefficient of fluctuation of speed
    thresholds: Mapping[float, float]  # ratio from which on the sleeve rests, by the moment of inertia of the flywheel, kg m2

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
    """Shaking and recovery against the dashpot."""

    title: ClassVar[str] = "an oil brake against shaking"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = "An oil brake reduces the shaking of every governor to a minimum without making it less sensitive."

    dampings: FloatArray  # dashpots on the sleeve, N s/m; shape (n,), ascending
    amplitudes: FloatArray  # motion of the sleeve in the last turn, m; shape (n,)
    decay_rates: FloatArray  # decay of the slowest motion with mean torque, 1/s; shape (n,)
    # ratio of insensitivity to fluctuation from which on the sleeve rests, with the weakest and the strongest
    # dashpot
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


CLEARANCES = (0.0, 1e-3, 1e-2, 4e-2)
"""Clearances between links and sleeve, m."""

LIGHT_SLEEVE = {"part.governor.dimensions.sleeve_mass": 0.2, **dashpot_on_sleeve(100.0)}
"""A governor whose sleeve is so light (kg) that friction carries it, with a dashpot (N s/m) for it."""

LIGHT_SLEEVE_RATIO = 0.8
"""Insensitivity over fluctuation of speed of the light governor, about: it shakes without clearance, too."""

LIGHT_SLEEVE_FRICTION = 4.0
"""Friction on the light sleeve, N: twice its weight."""

CLEARANCE_TURNS, N_MEASURED_TURNS = 30, 10
"""Turns of a run, and last turns whose largest motion counts: impacts in the clearance are irregular."""

QUIET_RATIO = 0.5
"""Motion over that without clearance below which a clearance is a remedy."""

CHANGE_TOLERANCE = 0.03
"""Relative change of the motion that counts as none: what is left of the start after the turns of a run."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ClearanceCheck(RuleCheck):
    """Motion of the sleeve in a turn against the clearance between links and sleeve, of two governors."""

    title: ClassVar[str] = "clearance against shaking"
    source: ClassVar[str] = "L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14"
    statement: ClassVar[str] = "Some clearance in the joints keeps the small irregularities of the engine away from the governor."

    clearances: FloatArray  # clearances, m; shape (n,), the first 0
    # largest motion of the sleeve in one of the last turns, m, by the name of the governor; shape (n,) each
    amplitudes: Mapping[str, FloatArray]

    def relative_motion(self, name: str) -> FloatArray:
        """Return the motion over that without clearance; shape (n,)."""
        amplitudes = self.amplitudes[name]
        return np.asarray(amplitudes / amplitudes[0])

    @property
    def verdict(self) -> Verdict:
        """Holds if each clearance quiets both governors; with a condition if some does; else it does not hold."""
        is_quiet = [self.relative_motion(name)[1:] < QUIET_RATIO for name in self.amplitudes]
        if np.all(is_quiet):
            return Verdict.HOLDS
        return Verdict.CONDITIONAL if np.any(is_quiet) else Verdict.FAILS

    @property
    def finding(self) -> str:
        """What the clearances do to each governor."""
        return "; ".join(f"{name}: {self._describe(self.relative_motion(name))}" for name in self.amplitudes)

    def _describe(self, motion: FloatArray) -> str:
        if np.all(np.abs(motion[1:] - 1) < CHANGE_TOLERANCE):
            return f"changes nothing up to {1e3 * self.clearances[-1]:g} mm (within {CHANGE_TOLERANCE:.0%})"
        worst = int(np.argmax(motion))
        quiet = motion < QUIET_RATIO
        first_quiet = next((k for k in range(1, len(quiet)) if quiet[k:].all()), None)
        is_worse = motion[worst] > 1 + CHANGE_TOLERANCE
        worse = [f"{1e3 * self.clearances[worst]:g} mm multiplies the motion by {motion[worst]:.1f}"] if is_worse else []
        if first_quiet is None:
            return ", ".join([*worse, f"and none up to {1e3 * self.clearances[-1]:g} mm halves it"])
        return ", ".join([*worse, f"from {1e3 * self.clearances[first_quiet]:g} mm on it is {motion[first_quiet]:.2g} times as large"])

    def numbers(self) -> dict[str, Any]:
        """Return clearances and amplitudes."""
        amplitudes = [{"governor": name, "amplitudes": values.tolist()} for name, values in self.amplitudes.items()]
        return {"clearances": self.clearances.tolist(), "governors": amplitudes}


def check_clearance(
    engine: Scene,  # scene of a governed engine whose gas acts at every instant
    mean_engine: Scene,
    cyclic_engine: CyclicEngine,
) -> ClearanceCheck:
    """Run the governed engine with clearance between links and sleeve: under its Porter governor, and under one with a light sleeve."""
    light = _build_light_engine(engine, mean_engine, cyclic_engine)
    friction = cyclic_engine.find_friction(SHAKING_RATIO)
    return ClearanceCheck(
        clearances=np.array(CLEARANCES),
        amplitudes={
            # The loaded sleeve hangs on its links, the light one starts in the middle of its clearance.
            "loaded sleeve": np.array([_measure_motion(cyclic_engine, friction, width, -0.5 * width) for width in CLEARANCES]),
            "light sleeve": np.array([_measure_motion(light, LIGHT_SLEEVE_FRICTION, width, 0.0) for width in CLEARANCES]),
        },
    )


def _build_light_engine(engine: Scene, mean_engine: Scene, cyclic_engine: CyclicEngine) -> CyclicEngine:
    """Return the engine under the governor with a light sleeve, with a flywheel that makes it shake."""
    porter = cyclic_engine.point
    first = find_steady_engine(mean_engine, LIGHT_SLEEVE, sleeve_lift=porter.sleeve_lift)
    relative_friction = LIGHT_SLEEVE_FRICTION * first.relative_friction_of_newton
    insensitivity = math.sqrt(1 + relative_friction) - math.sqrt(1 - relative_friction)
    # The fluctuation of speed is inversely proportional to the moment of inertia, nearly.
    inertia = (
        float(porter.scene.part_of("engine")[0].dimensions["inertia"]) * cyclic_engine.fluctuation * LIGHT_SLEEVE_RATIO / insensitivity
    )
    values = {**LIGHT_SLEEVE, **gear_to_speed(first, porter.engine_speed), INERTIA: inertia}
    return build_cyclic_engine(engine, find_steady_engine(mean_engine, values, sleeve_lift=porter.sleeve_lift), values)


def _measure_motion(engine: CyclicEngine, friction: float, width: float, start: float) -> float:
    """Return the largest motion of the sleeve in one of the last turns, m, with a clearance, m, and its value at the start."""
    values = friction_on_sleeve(friction)
    if width:
        lift_of_links = engine.point.sleeve_lift - start
        start_values = {"arm_angle": find_coordinate_at(engine.scene, lift_of_links), CLEARANCE_READING: start}
        values |= {"part.governor.effects.clearance": width, "part.governor.start": start_values}
    return float(engine.amplitudes_per_turn(CLEARANCE_TURNS, values)[-N_MEASURED_TURNS:].max())

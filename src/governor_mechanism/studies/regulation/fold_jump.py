"""The jump of a governor that is unstable in part of its travel, against the rate at which its speed changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.scene import RunSettings, Scene, Spindle, Start
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.speed_curve import compute_speed_curve, equilibrium_speed_at
from governor_mechanism.studies.regression import FittedParameter, fit_slope, run_uncertified
from governor_mechanism.types import FloatArray

SAMPLES_PER_RUN = 2000
"""In the time of a run."""

AIRY_PRIME_FIRST_ZERO = 1.018792971647471
"""y' = t + y^2, come from far below on its stable branch, passes y = 0 here: the first zero of Ai' without its sign."""


@dataclass(frozen=True, kw_only=True)
class FoldJumpStudy:
    """The speeds (rad/s) at which arms pass the position of the fold, against the rate of a ramp of speed.

    rates (n,) rad/s2; rising (n,) on the way up from the low stop, leaving (n,) when they leave that stop, falling (n,)
    on the way down. stop_speed and fold_speed are the static ones, fold (rad) the position; growth (1/s) is how fast a
    disturbance on the stop grows, brake and all; law (n,) the delay of the fall that a fold of these stiffnesses and
    this brake has as the rate tends to nought, NaN without a brake.
    """

    title: str
    ramp_rates: FloatArray
    rising_speeds: FloatArray
    leaving_speeds: FloatArray
    falling_speeds: FloatArray
    fold_position: float
    fold_speed: float
    stop_speed: float
    divergence_rate: float
    asymptotic_delay: FloatArray

    @property
    def falling_delay(self) -> FloatArray:
        """(n,) rad/s: how far below the fold the speed is when it falls through."""
        return self.fold_speed - self.falling_speeds

    @property
    def rising_delay(self) -> FloatArray:
        """(n,) rad/s: how far above the speed of the stop the speed is when it has jumped."""
        return self.rising_speeds - self.stop_speed

    @property
    def falling_exponent(self) -> FittedParameter:
        """Of the delay of the fall by the rate; 2/3 at a fold, where the motion there is slow."""
        return fit_slope(np.log(self.ramp_rates), np.log(self.falling_delay))

    @property
    def falling_exponent_limit(self) -> FittedParameter:
        """The same as the rate tends to nought: what inertia adds is of the relative order rate^(1/3)."""
        return fit_slope(np.log(self.ramp_rates), np.log(self.falling_delay), np.cbrt(self.ramp_rates))

    @property
    def rising_exponent(self) -> FittedParameter:
        """Of the delay of the jump by the rate; below 1, as the time of it grows as the logarithm of 1 / rate."""
        return fit_slope(np.log(self.ramp_rates), np.log(self.rising_delay))

    @property
    def rising_divergence_rate(self) -> FittedParameter:
        """The growth (1/s) that the times of the jump show: they are ln(1 / rate) / growth and a constant."""
        inverse_divergence_rate = fit_slope(np.log(1 / self.ramp_rates), self.rising_delay / self.ramp_rates)
        return FittedParameter(
            value=1 / inverse_divergence_rate.value,
            standard_error=inverse_divergence_rate.standard_error / inverse_divergence_rate.value**2,
        )


def study_fold_jump(scene: Scene, ramp_rates: Sequence[float] | FloatArray) -> FoldJumpStudy:
    """Run a scene up and down through its fold with ramps of the spindle's speed of these rates (n,) rad/s2.

    The scene needs stops on its leading coordinate with one fold between them, unstable at the low one. Up it starts on
    the low stop, down on the stable branch so far above the fold that no way in is left. Raises MechanismError
    otherwise, and where a motion does not pass.
    """
    requested_rates = np.asarray(ramp_rates, dtype=np.float64)
    coordinate = scene.part.mechanism.coordinate
    stops = next((one for one in scene.effects if isinstance(one, Stops) and one.reading == coordinate), None)
    if stops is None or math.isinf(stops.low):
        raise MechanismError(f"the jump needs a low stop of {coordinate!r} to jump from")
    folds_between_stops = [(at, speed) for at, speed in compute_speed_curve(scene).folds if stops.low < at < stops.high]
    if len(folds_between_stops) != 1:
        raise MechanismError(f"the jump needs one fold between the stops of {coordinate!r}; this scene has {len(folds_between_stops)}")
    ((fold_position, fold_speed),) = folds_between_stops
    stop_speed = float(equilibrium_speed_at(scene, np.array([stops.low]))[0])
    asymptotic_delay = _compute_fold_delay(scene, fold_position, fold_speed, requested_rates)
    rising_speeds, leaving_speeds, falling_speeds = [], [], []
    for ramp_rate, delay in zip(requested_rates.tolist(), asymptotic_delay.tolist(), strict=True):
        speed, leaving_speed = _find_rising_passage_speeds(scene, stops.low, fold_position, stop_speed, ramp_rate)
        rising_speeds.append(speed)
        leaving_speeds.append(leaving_speed)
        falling_speeds.append(_find_falling_passage_speed(scene, fold_position, fold_speed, stops.high, ramp_rate, delay))
    return FoldJumpStudy(
        title=scene.title,
        ramp_rates=requested_rates,
        rising_speeds=np.array(rising_speeds),
        leaving_speeds=np.array(leaving_speeds),
        falling_speeds=np.array(falling_speeds),
        fold_position=fold_position,
        fold_speed=fold_speed,
        stop_speed=stop_speed,
        divergence_rate=_compute_divergence_rate(scene, stops.low, stop_speed),
        asymptotic_delay=asymptotic_delay,
    )


def _compute_generalised_damping(scene: Scene, value: float) -> float:
    """What the linear dashpots do along the leading coordinate there (N m s/rad, or N s/m)."""
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate([value])
    dashpots = [effect for effect in scene.effects if isinstance(effect, Dashpot)]
    return sum(brake.linear * float(reduction.output_derivative(coefficients, brake.reading)[0]) ** 2 for brake in dashpots)


def _compute_divergence_rate(scene: Scene, value: float, speed: float) -> float:
    """How fast (1/s) a disturbance of an unstable rest grows: I x'' + c x' + K x = 0."""
    coefficients = SingleDofReduction(scene).evaluate([value])
    inertia = float(coefficients.inertia[0])
    stiffness = float(coefficients.potential_second_derivative[0] - 0.5 * speed**2 * coefficients.spindle_inertia_second_derivative[0])
    decay = 0.5 * _compute_generalised_damping(scene, value) / inertia
    return math.sqrt(decay**2 - stiffness / inertia) - decay


def _compute_fold_delay(scene: Scene, fold_position: float, fold_speed: float, ramp_rates: FloatArray) -> FloatArray:
    """The delay (n,) rad/s of the fall at a fold: where a brake c rules, c x' = -A r t - K' x^2 / 2.

    Scaled that is y' = t + y^2, whose solution Ai'(-t) / Ai(-t) passes nought at `AIRY`: a delay of AIRY (2 c^2 r^2 /
    (K' A))^(1/3), with A = w J' and K' the change of the stiffness with the coordinate at that speed.
    """
    damping = _compute_generalised_damping(scene, fold_position)
    if not damping:
        return np.full_like(ramp_rates, math.nan)
    step = 1e-3
    coefficients = SingleDofReduction(scene).evaluate([fold_position - step, fold_position, fold_position + step])
    stiffness = coefficients.potential_second_derivative - 0.5 * fold_speed**2 * coefficients.spindle_inertia_second_derivative
    stiffness_derivative = float(stiffness[2] - stiffness[0]) / (2 * step)
    speed_sensitivity = fold_speed * float(coefficients.spindle_inertia_derivative[1])
    delay: FloatArray = AIRY_PRIME_FIRST_ZERO * np.cbrt(2 * damping**2 * ramp_rates**2 / (stiffness_derivative * speed_sensitivity))
    return delay


def _find_passage_time(scene: Scene, passage_value: float, spindle: Spindle, start_value: float) -> tuple[float | None, Trajectory]:
    """When (s) the leading coordinate first passes a value on a ramp, None where it does not, and the run."""
    coordinate = scene.part.mechanism.coordinate
    duration = spindle.times[-1]
    settings = RunSettings(duration=duration, output_interval=duration / (SAMPLES_PER_RUN), accuracy=scene.run.accuracy)
    run = run_uncertified(replace(scene, spindle=spindle, start=Start(values={coordinate: start_value}), run=settings))
    deviation = run.readings[coordinate] - passage_value
    crossings = np.flatnonzero(deviation[:-1] * deviation[1:] < 0)
    if not crossings.size:
        return None, run
    k = int(crossings[0])
    bracket = slice(k, k + 2)
    curve = CubicHermiteSpline(run.times[bracket], deviation[bracket], run.rates[coordinate][bracket])
    return float(brentq(curve, run.times[k], run.times[k + 1], xtol=1e-14)), run


def _find_rising_passage_speeds(
    scene: Scene, low_stop: float, fold_position: float, stop_speed: float, ramp_rate: float
) -> tuple[float, float]:
    """The speeds (rad/s) at which it passes the fold on the way up, and at which it has left its stop."""
    time_before, time_after = 1.0, 16.0  # s
    while time_after < 1e4:
        first_speed = stop_speed - time_before * ramp_rate
        spindle = Spindle(times=(0.0, time_before + time_after), speeds=(first_speed, stop_speed + time_after * ramp_rate))
        passage_time, run = _find_passage_time(scene, fold_position, spindle, low_stop)
        if passage_time is not None:
            leaving_time = next(event.time for event in run.events if event.kind == "leaves its stop")
            return first_speed + ramp_rate * passage_time, first_speed + ramp_rate * leaving_time
        time_after *= 2
    raise MechanismError(f"with {ramp_rate:g} rad/s2 the governor does not rise from its stop to the fold")


def _find_falling_passage_speed(
    scene: Scene, fold_position: float, fold_speed: float, high_stop: float, ramp_rate: float, delay: float
) -> float:
    """The speed (rad/s) at which it passes the fold on the way down, from the stable branch above it."""
    max_speed = float(equilibrium_speed_at(scene, np.array([high_stop]))[0])
    delay_estimate = 0.01 * fold_speed if math.isnan(delay) else delay
    first_speed = min(fold_speed + 15 * delay_estimate, 0.5 * (fold_speed + max_speed))
    start = brentq(lambda at: equilibrium_speed_at(scene, np.array([at]))[0] - first_speed, fold_position, high_stop, xtol=1e-12)
    last_speed = max(fold_speed - 5 * delay_estimate, 0.5 * fold_speed)
    spindle = Spindle(times=(0.0, (first_speed - last_speed) / ramp_rate), speeds=(first_speed, last_speed))
    passage_time, _ = _find_passage_time(scene, fold_position, spindle, float(start))
    if passage_time is None:
        raise MechanismError(f"with {ramp_rate:g} rad/s2 the governor does not fall through the fold")
    return first_speed - ramp_rate * passage_time

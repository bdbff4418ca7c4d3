"""A governor after a change: settling time over the strength of its dashpot, and its jump through a fold over the ramp of the speed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq, minimize_scalar

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.holding import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import SingleDofReduction
from governor_mechanism.model.events import EventKind
from governor_mechanism.model.part import FreeSpindle, Spindle, Start
from governor_mechanism.model.results.result import Result
from governor_mechanism.model.results.trajectory import Trajectory
from governor_mechanism.model.scene import RunSettings, Scene
from governor_mechanism.statics.speed_curve import compute_speed_curve, equilibrium_speed_at
from governor_mechanism.studies.plain_runs import SLEEVE_READING, FittedParameter, fit_slope, run_uncertified
from governor_mechanism.types import FloatArray

DAMPING_COEFFICIENTS = np.geomspace(35.0, 1200.0, 60)
"""Damping coefficients, N s/m, for a curve of the settling time."""

SETTLING_TOLERANCE = 0.02
"""Half-width of the settling band about the new equilibrium, relative to the whole change."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SettlingStudy(Result):
    """Settling time after a change of load, against the damping of the sleeve."""

    title: str  # title of the scene
    damping_coefficients: FloatArray  # linear dashpot on the sleeve, N s/m; shape (n,)
    # time from the change of load until the arms stay within the settling band, s; shape (n,); infinite if
    # they do not settle in the run
    settling_times: FloatArray
    best: tuple[float, float]  # damping coefficient with the shortest settling time, N s/m, and that time, s

    figure = "render.figures.regulation.settling_figure"

    @property
    def conclusion(self) -> str:
        """One sentence on the best damping."""
        return f"shortest settling time {self.best[1]:.4g} s with a dashpot of {self.best[0]:.4g} N s/m"


def study_settling(
    scene: Scene,  # scene with a free spindle and a torque that changes
    damping_coefficients: Sequence[float] | FloatArray,  # linear dashpots on the sleeve, N s/m; shape (n,)
) -> SettlingStudy:
    """Run a scene whose load changes with several dashpots on the sleeve, and find the best one.

    The new equilibrium is the one of the angular momentum at the end. Time counts from the first jump of the torque.

    Result: settling times and the best damping. Raises MechanismError if the scene has no such spindle, or if
    no dashpot makes it settle within its run.
    """
    spindle = scene.spindle
    if not isinstance(spindle, FreeSpindle) or spindle.torque.is_constant:
        raise MechanismError("the settling study needs a free spindle with a torque that changes; give spindle.torque over time")
    times, values = spindle.torque.times, spindle.torque.values
    load_change_time = times[next(k for k, (before, value) in enumerate(pairwise(values)) if value != before)]
    other_effects = tuple(effect for effect in scene.effects if not isinstance(effect, Dashpot))

    def settling_time_of(damping_coefficient: float) -> float:
        dashpot = Dashpot(reading=SLEEVE_READING, linear=damping_coefficient)
        return _compute_settling_time(run_uncertified(scene.with_changes(effects=(*other_effects, dashpot)))) - load_change_time

    requested_coefficients = np.asarray(damping_coefficients, dtype=np.float64)
    settling_times = np.array([settling_time_of(coefficient) for coefficient in requested_coefficients.tolist()])
    if not np.any(np.isfinite(settling_times)):
        raise MechanismError(f"with no dashpot does the governor settle within {scene.run.duration:g} s; increase run.duration")
    k = int(np.argmin(settling_times))
    bounds = (requested_coefficients[max(k - 1, 0)], requested_coefficients[min(k + 1, len(requested_coefficients) - 1)])
    options = {"xatol": 1e-3 * requested_coefficients[k]}
    refined = minimize_scalar(
        lambda one: min(settling_time_of(one), 1e3 * scene.run.duration), bounds=bounds, method="bounded", options=options
    )
    best_time, best_coefficient = min((float(settling_times[k]), float(requested_coefficients[k])), (float(refined.fun), float(refined.x)))
    return SettlingStudy(
        title=scene.title, damping_coefficients=requested_coefficients, settling_times=settling_times, best=(best_coefficient, best_time)
    )


def _compute_settling_time(run: Trajectory) -> float:
    """Return the time, s, from which the coordinate stays in the settling band about its new equilibrium, or infinity."""
    name = run.scene.part.mechanism.coordinate
    deviation = run.readings[name] - _find_equilibrium_of_momentum(run)
    band_width = SETTLING_TOLERANCE * abs(float(deviation[0]))
    curve = CubicHermiteSpline(run.times, deviation, run.rates[name])
    band_crossings = np.concatenate([curve.solve(side * band_width, extrapolate=False) for side in (-1.0, 1.0)])
    if band_crossings.size == 0 or np.max(np.abs(deviation[run.times > 0.8 * run.times[-1]])) > band_width:
        return math.inf
    return float(band_crossings.max())


def _find_equilibrium_of_momentum(run: Trajectory) -> float:
    """Return the equilibrium on the free spindle at the angular momentum of the end of the run."""
    mechanism = run.scene.part.mechanism
    reduction = SingleDofReduction(run.scene)
    last_value = float(run.readings[mechanism.coordinate][-1])
    last_poses = run.poses[-1, : len(mechanism.bodies)]
    angular_momentum = 2 * run.energy.rotation[-1] / run.readings["spindle_speed"][-1]

    def generalised_force(value: float) -> float:
        coefficients = reduction.evaluate([value], last_poses)
        speed = angular_momentum / (reduction.free_spindle_inertia + coefficients.spindle_inertia[0])
        return float(coefficients.force_terms(speed**2).sum())

    width = 1e-3
    while generalised_force(last_value - width) * generalised_force(last_value + width) > 0:
        width *= 2
    return float(brentq(generalised_force, last_value - width, last_value + width, xtol=1e-13))


RAMP_RATES = np.geomspace(1e-5, 4e-3, 14)
"""Ramp rates of the spindle speed, rad/s2, for a curve of the jump."""

SAMPLES_PER_RUN = 2000
"""Reported times per run."""

AIRY_PRIME_FIRST_ZERO = 1.018792971647471
"""First zero of Ai', negated: y' = t + y^2, started far below on its stable branch, passes y = 0 at this t."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FoldJumpStudy(Result):
    """Speeds at which the arms pass the fold, against the ramp rate of the spindle speed."""

    title: str  # title of the scene
    ramp_rates: FloatArray  # magnitude of the spindle acceleration, rad/s2; shape (n,)
    rising_speeds: FloatArray  # speed at the fold position on the way up from the low stop, rad/s; shape (n,)
    leaving_speeds: FloatArray  # speed at which the governor leaves the low stop, rad/s; shape (n,)
    falling_speeds: FloatArray  # speed at the fold position on the way down, rad/s; shape (n,)
    fold_position: float  # leading coordinate at the fold, rad
    fold_speed: float  # equilibrium speed at the fold, rad/s
    stop_speed: float  # equilibrium speed at the low stop, rad/s
    divergence_rate: float  # divergence rate of a disturbance at the low stop, with damping, 1/s
    # delay of the fall for a ramp rate that tends to zero, from the stiffnesses at the fold and the
    # damping, rad/s; shape (n,). NaN without damping.
    asymptotic_delay: FloatArray

    figure = "render.figures.regulation.fold_jump_figure"

    @property
    def conclusion(self) -> str:
        """One sentence on the speeds of the fall and of the jump."""
        exponent = self.falling_exponent
        order = f"rate^{exponent.value:.4f} +- {exponent.standard_error:.1g}"
        return f"falls below {self.fold_speed:.6g} rad/s with a delay of order {order}, jumps above {self.stop_speed:.6g} rad/s"

    @property
    def falling_delay(self) -> FloatArray:
        """Fold speed minus the speed at which the governor falls through the fold, rad/s; shape (n,)."""
        return self.fold_speed - self.falling_speeds

    @property
    def rising_delay(self) -> FloatArray:
        """Speed at which the governor has jumped minus the stop speed, rad/s; shape (n,)."""
        return self.rising_speeds - self.stop_speed

    @property
    def falling_exponent(self) -> FittedParameter:
        """Exponent of the falling delay in the ramp rate; 2/3 at a fold with slow motion."""
        return fit_slope(np.log(self.ramp_rates), np.log(self.falling_delay))

    @property
    def rising_exponent(self) -> FittedParameter:
        """Exponent of the rising delay in the ramp rate; below 1, because the jump takes a time of order ln(1 / rate)."""
        return fit_slope(np.log(self.ramp_rates), np.log(self.rising_delay))

    @property
    def rising_divergence_rate(self) -> FittedParameter:
        """Divergence rate from the times of the jump, 1/s: they are ln(1 / rate) / divergence rate plus a constant."""
        inverse = fit_slope(np.log(1 / self.ramp_rates), self.rising_delay / self.ramp_rates)
        return FittedParameter(value=1 / inverse.value, standard_error=inverse.standard_error / inverse.value**2)


def study_fold_jump(
    # scene with stops on its leading coordinate, one fold between them, and an unstable equilibrium at the
    # low stop
    scene: Scene,
    ramp_rates: Sequence[float] | FloatArray,  # magnitudes of the spindle acceleration, rad/s2; shape (n,)
) -> FoldJumpStudy:
    """Run a scene up and down through its fold with ramps of the spindle speed.

    The way up starts on the low stop, the way down on the stable branch far enough above the fold that the transient decays.

    Result: speeds at the fold and their delays. Raises MechanismError if the scene has no such stops or fold,
    or if a run does not pass the fold.
    """
    requested_rates = np.asarray(ramp_rates, dtype=np.float64)
    coordinate = scene.part.mechanism.coordinate
    stops = next((one for one in scene.effects if isinstance(one, Stops) and one.reading == coordinate), None)
    if stops is None or math.isinf(stops.low):
        raise MechanismError(f"the jump starts at a low stop, but {coordinate!r} has none; add effects.stops")
    folds_between_stops = [(at, speed) for at, speed in compute_speed_curve(scene).folds if stops.low < at < stops.high]
    if len(folds_between_stops) != 1:
        raise MechanismError(f"the jump needs one fold between the stops of {coordinate!r}; this scene has {len(folds_between_stops)}")
    ((fold_position, fold_speed),) = folds_between_stops
    stop_speed = float(equilibrium_speed_at(scene, np.array([stops.low]))[0])
    asymptotic_delay = _compute_fold_delay(scene, fold_position, fold_speed, requested_rates)
    speeds = [
        (
            *_find_rising_speeds(scene, stops.low, fold_position, stop_speed, ramp_rate),
            _find_falling_speed(scene, fold_position, fold_speed, stops.high, ramp_rate, delay),
        )
        for ramp_rate, delay in zip(requested_rates.tolist(), asymptotic_delay.tolist(), strict=True)
    ]
    rising_speeds, leaving_speeds, falling_speeds = np.array(speeds).reshape(-1, 3).T
    return FoldJumpStudy(
        title=scene.title,
        ramp_rates=requested_rates,
        rising_speeds=rising_speeds,
        leaving_speeds=leaving_speeds,
        falling_speeds=falling_speeds,
        fold_position=fold_position,
        fold_speed=fold_speed,
        stop_speed=stop_speed,
        divergence_rate=_compute_divergence_rate(scene, stops.low, stop_speed),
        asymptotic_delay=asymptotic_delay,
    )


def _compute_generalised_damping(scene: Scene, value: float) -> float:
    """Return the damping of the linear dashpots along the leading coordinate, N m s/rad or N s/m."""
    reduction = SingleDofReduction(scene)
    coefficients = reduction.evaluate([value])
    dashpots = [effect for effect in scene.effects if isinstance(effect, Dashpot)]
    return sum(dashpot.linear * float(reduction.output_derivative(coefficients, dashpot.reading)[0]) ** 2 for dashpot in dashpots)


def _compute_divergence_rate(scene: Scene, value: float, speed: float) -> float:
    """Return the divergence rate, 1/s, of a disturbance at an unstable equilibrium: I x'' + c x' + K x = 0."""
    coefficients = SingleDofReduction(scene).evaluate([value])
    inertia = float(coefficients.inertia[0])
    stiffness = float(coefficients.stiffness_terms(speed**2).sum())
    decay = 0.5 * _compute_generalised_damping(scene, value) / inertia
    return math.sqrt(decay**2 - stiffness / inertia) - decay


def _compute_fold_delay(scene: Scene, fold_position: float, fold_speed: float, ramp_rates: FloatArray) -> FloatArray:
    """Return the delay of the fall at a fold, rad/s, shape (n,), if damping c dominates: c x' = -A r t - K' x^2 / 2."""
    # Scaled, this is y' = t + y^2 with the solution Ai'(-t) / Ai(-t), which is zero at
    # AIRY_PRIME_FIRST_ZERO. The delay is AIRY_PRIME_FIRST_ZERO (2 c^2 r^2 / (K' A))^(1/3), with A = w
    # J' and K' the derivative of the stiffness with respect to the coordinate at that speed.
    damping = _compute_generalised_damping(scene, fold_position)
    if not damping:
        return np.full_like(ramp_rates, math.nan)
    step = 1e-3
    coefficients = SingleDofReduction(scene).evaluate([fold_position - step, fold_position, fold_position + step])
    stiffness = coefficients.stiffness_terms(fold_speed**2).sum(axis=0)
    stiffness_derivative = float(stiffness[2] - stiffness[0]) / (2 * step)
    speed_sensitivity = fold_speed * float(coefficients.spindle_inertia_derivative[1])
    delay: FloatArray = AIRY_PRIME_FIRST_ZERO * np.cbrt(2 * damping**2 * ramp_rates**2 / (stiffness_derivative * speed_sensitivity))
    return delay


def _find_passage_time(scene: Scene, passage_value: float, spindle: Spindle, start_value: float) -> tuple[float | None, Trajectory]:
    """Return the time, s, at which the leading coordinate first passes a value on a ramp (None if never), and the run."""
    coordinate = scene.part.mechanism.coordinate
    duration = spindle.times[-1]
    settings = RunSettings(duration=duration, output_interval=duration / SAMPLES_PER_RUN, accuracy=scene.run.accuracy)
    run = run_uncertified(scene.with_changes(spindle=spindle, start=Start(values={coordinate: start_value}), run=settings))
    deviation = run.readings[coordinate] - passage_value
    crossings = np.flatnonzero(deviation[:-1] * deviation[1:] < 0)
    if not crossings.size:
        return None, run
    bracket = slice(crossings[0], crossings[0] + 2)
    curve = CubicHermiteSpline(run.times[bracket], deviation[bracket], run.rates[coordinate][bracket])
    return float(brentq(curve, *run.times[bracket], xtol=1e-14)), run


def _find_rising_speeds(scene: Scene, low_stop: float, fold_position: float, stop_speed: float, ramp_rate: float) -> tuple[float, float]:
    """Return the speeds, rad/s, at the fold on the way up and when the governor leaves its stop."""
    time_before, time_after = 1.0, 16.0  # s
    while time_after < 1e4:
        first_speed = stop_speed - time_before * ramp_rate
        spindle = Spindle(times=(0.0, time_before + time_after), speeds=(first_speed, stop_speed + time_after * ramp_rate))
        passage_time, run = _find_passage_time(scene, fold_position, spindle, low_stop)
        if passage_time is not None:
            leaving_time = next(event.time for event in run.events if event.kind == EventKind.SEPARATION)
            return first_speed + ramp_rate * passage_time, first_speed + ramp_rate * leaving_time
        time_after *= 2
    raise MechanismError(f"with {ramp_rate:g} rad/s2 the governor does not rise from its low stop to the fold")


def _find_falling_speed(scene: Scene, fold_position: float, fold_speed: float, high_stop: float, ramp_rate: float, delay: float) -> float:
    """Return the speed, rad/s, at the fold on the way down from the stable branch above it."""
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

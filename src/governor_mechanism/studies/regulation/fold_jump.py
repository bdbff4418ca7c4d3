"""The jump of a governor that is unstable in part of its travel, against the rate at which its speed changes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.stops import Stops
from governor_mechanism.errors import MechanismError
from governor_mechanism.mechanics.reduction.lagrangian import Reduction
from governor_mechanism.model.scene import RunSettings, Scene, Spindle, Start
from governor_mechanism.model.trajectory import Trajectory
from governor_mechanism.statics.speed_curve import equilibrium_speed, speed_curve
from governor_mechanism.studies.regression import Fitted, slope, uncertified
from governor_mechanism.types import FloatArray

SAMPLES = 2000
"""In the time of a run."""

AIRY = 1.018792971647471
"""y' = t + y^2, come from far below on its stable branch, passes y = 0 here: the first zero of Ai' without its sign."""


@dataclass(frozen=True, kw_only=True)
class Jump:
    """The speeds (rad/s) at which arms pass the position of the fold, against the rate of a ramp of speed.

    rates (n,) rad/s2; rising (n,) on the way up from the low stop, leaving (n,) when they leave that stop, falling (n,)
    on the way down. stop_speed and fold_speed are the static ones, fold (rad) the position; growth (1/s) is how fast a
    disturbance on the stop grows, brake and all; law (n,) the delay of the fall that a fold of these stiffnesses and
    this brake has as the rate tends to nought, NaN without a brake.
    """

    title: str
    rates: FloatArray
    rising: FloatArray
    leaving: FloatArray
    falling: FloatArray
    fold: float
    fold_speed: float
    stop_speed: float
    growth: float
    law: FloatArray

    @property
    def falling_delay(self) -> FloatArray:
        """(n,) rad/s: how far below the fold the speed is when it falls through."""
        return self.fold_speed - self.falling

    @property
    def rising_delay(self) -> FloatArray:
        """(n,) rad/s: how far above the speed of the stop the speed is when it has jumped."""
        return self.rising - self.stop_speed

    @property
    def falling_exponent(self) -> Fitted:
        """Of the delay of the fall by the rate; 2/3 at a fold, where the motion there is slow."""
        return slope(np.log(self.rates), np.log(self.falling_delay))

    @property
    def falling_limit(self) -> Fitted:
        """The same as the rate tends to nought: what inertia adds is of the relative order rate^(1/3)."""
        return slope(np.log(self.rates), np.log(self.falling_delay), np.cbrt(self.rates))

    @property
    def rising_exponent(self) -> Fitted:
        """Of the delay of the jump by the rate; below 1, as the time of it grows as the logarithm of 1 / rate."""
        return slope(np.log(self.rates), np.log(self.rising_delay))

    @property
    def rising_growth(self) -> Fitted:
        """The growth (1/s) that the times of the jump show: they are ln(1 / rate) / growth and a constant."""
        line = slope(np.log(1 / self.rates), self.rising_delay / self.rates)
        return Fitted(value=1 / line.value, scatter=line.scatter / line.value**2)


def jump(scene: Scene, rates: Sequence[float] | FloatArray) -> Jump:
    """Run a scene up and down through its fold with ramps of the spindle's speed of these rates (n,) rad/s2.

    The scene needs stops on its leading coordinate with one fold between them, unstable at the low one. Up it starts on
    the low stop, down on the stable branch so far above the fold that no way in is left. Raises MechanismError
    otherwise, and where a motion does not pass.
    """
    asked = np.asarray(rates, dtype=np.float64)
    name = scene.part.mechanism.coordinate
    stops = next((one for one in scene.effects if isinstance(one, Stops) and one.reading == name), None)
    if stops is None or math.isinf(stops.low):
        raise MechanismError(f"the jump needs a low stop of {name!r} to jump from")
    inside = [(at, speed) for at, speed in speed_curve(scene).folds if stops.low < at < stops.high]
    if len(inside) != 1:
        raise MechanismError(f"the jump needs one fold between the stops of {name!r}; this scene has {len(inside)}")
    ((fold, fold_speed),) = inside
    stop_speed = float(equilibrium_speed(scene, np.array([stops.low]))[0])
    law = _fold_law(scene, fold, fold_speed, asked)
    rising, leaving, falling = [], [], []
    for rate, delay in zip(asked.tolist(), law.tolist(), strict=True):
        speed, left = _passage_up(scene, stops.low, fold, stop_speed, rate)
        rising.append(speed)
        leaving.append(left)
        falling.append(_passage_down(scene, fold, fold_speed, stops.high, rate, delay))
    return Jump(
        title=scene.title,
        rates=asked,
        rising=np.array(rising),
        leaving=np.array(leaving),
        falling=np.array(falling),
        fold=fold,
        fold_speed=fold_speed,
        stop_speed=stop_speed,
        growth=_growth(scene, stops.low, stop_speed),
        law=law,
    )


def _damping(scene: Scene, value: float) -> float:
    """What the linear oil brakes do along the leading coordinate there (N m s/rad, or N s/m)."""
    reduction = Reduction(scene)
    here = reduction.at([value])
    brakes = [effect for effect in scene.effects if isinstance(effect, OilBrake)]
    return sum(brake.linear * float(reduction.slopes(here, brake.reading)[0]) ** 2 for brake in brakes)


def _growth(scene: Scene, value: float, speed: float) -> float:
    """How fast (1/s) a disturbance of an unstable rest grows: I x'' + c x' + K x = 0."""
    here = Reduction(scene).at([value])
    inertia = float(here.inertia[0])
    stiffness = float(here.potential_bend[0] - 0.5 * speed**2 * here.spindle_bend[0])
    decay = 0.5 * _damping(scene, value) / inertia
    return math.sqrt(decay**2 - stiffness / inertia) - decay


def _fold_law(scene: Scene, fold: float, speed: float, rates: FloatArray) -> FloatArray:
    """The delay (n,) rad/s of the fall at a fold: where a brake c rules, c x' = -A r t - K' x^2 / 2.

    Scaled that is y' = t + y^2, whose solution Ai'(-t) / Ai(-t) passes nought at `AIRY`: a delay of AIRY (2 c^2 r^2 /
    (K' A))^(1/3), with A = w J' and K' the change of the stiffness with the coordinate at that speed.
    """
    damping = _damping(scene, fold)
    if not damping:
        return np.full_like(rates, math.nan)
    step = 1e-3
    around = Reduction(scene).at([fold - step, fold, fold + step])
    stiffness = around.potential_bend - 0.5 * speed**2 * around.spindle_bend
    change = float(stiffness[2] - stiffness[0]) / (2 * step)
    pull = speed * float(around.spindle_slope[1])
    delay: FloatArray = AIRY * np.cbrt(2 * damping**2 * rates**2 / (change * pull))
    return delay


def _passage(scene: Scene, value: float, spindle: Spindle, start: float) -> tuple[float | None, Trajectory]:
    """When (s) the leading coordinate first passes a value on a ramp, None where it does not, and the run."""
    name = scene.part.mechanism.coordinate
    duration = spindle.times[-1]
    settings = RunSettings(duration=duration, every=duration / (SAMPLES), accuracy=scene.run.accuracy)
    run = uncertified(replace(scene, spindle=spindle, start=Start(values={name: start}), run=settings))
    off = run.readings[name] - value
    passed = np.flatnonzero(off[:-1] * off[1:] < 0)
    if not passed.size:
        return None, run
    k = int(passed[0])
    pair = slice(k, k + 2)
    curve = CubicHermiteSpline(run.times[pair], off[pair], run.rates[name][pair])
    return float(brentq(curve, run.times[k], run.times[k + 1], xtol=1e-14)), run


def _passage_up(scene: Scene, low: float, fold: float, stop_speed: float, rate: float) -> tuple[float, float]:
    """The speeds (rad/s) at which it passes the fold on the way up, and at which it has left its stop."""
    before, after = 1.0, 16.0  # s
    while after < 1e4:
        first = stop_speed - before * rate
        spindle = Spindle(times=(0.0, before + after), speeds=(first, stop_speed + after * rate))
        time, run = _passage(scene, fold, spindle, low)
        if time is not None:
            left = next(event.time for event in run.events if event.kind == "leaves its stop")
            return first + rate * time, first + rate * left
        after *= 2
    raise MechanismError(f"with {rate:g} rad/s2 the governor does not rise from its stop to the fold")


def _passage_down(scene: Scene, fold: float, speed: float, high: float, rate: float, delay: float) -> float:
    """The speed (rad/s) at which it passes the fold on the way down, from the stable branch above it."""
    most = float(equilibrium_speed(scene, np.array([high]))[0])
    guess = 0.01 * speed if math.isnan(delay) else delay
    first = min(speed + 15 * guess, 0.5 * (speed + most))
    start = brentq(lambda at: equilibrium_speed(scene, np.array([at]))[0] - first, fold, high, xtol=1e-12)
    last = max(speed - 5 * guess, 0.5 * speed)
    spindle = Spindle(times=(0.0, (first - last) / rate), speeds=(first, last))
    time, _ = _passage(scene, fold, spindle, float(start))
    if time is None:
        raise MechanismError(f"with {rate:g} rad/s2 the governor does not fall through the fold")
    return first - rate * time

"""A motion known at samples, and the readings along it and the speed of a shaft between the samples."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from governor_mechanism.mechanics.dynamics.equations_of_motion import compute_inverse_dynamics
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, unwrap_output
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.results.records import SpeedFluctuation
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.hermite_curve import HermiteCurve
from governor_mechanism.numerics.interpolation import quintic_hermite
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.types import BoolArray, FloatArray, IntArray

ROOT_TOLERANCE = 1e-9
"""Newton steps shorter than this fraction of the bracket end the search: the next one would be about its square."""

REFINEMENT_MARGIN = 1e-3
"""Distance from a first time, relative to the interval, within which the refined one is expected."""

# The other time is that of the interpolant over three samples. Its error is larger by about the square of the
# ratio of the interval to the time in which the motion changes, which this difference bounds.
AGREEMENT_OF_INTERPOLANTS = 1e-7
"""Difference of two times, relative to the interval, up to which the interpolant over four samples needs no refinement."""

EVENT_TIME_MARGIN = 1e-6
"""A contact event closer to a sample than this fraction of the interval is at the sample."""

BodyState = tuple[FloatArray, FloatArray]
"""Poses and velocities (bodies, 3)."""
DenseOutput = Callable[[int, float], BodyState | None]
"""Function of interval index and time (s) that returns poses and velocities, or None if it cannot."""
StateFunction = Callable[[BodyState], float]
"""Function of poses and velocities."""

MAX_DENSE_STATES = 20_000
"""Largest number of states between the samples that a search takes from the engine: each takes about as long as 100 steps of a run."""


def find_times_near(event_times: FloatArray, samples: FloatArray, times: FloatArray) -> IntArray:
    """Return the indices of those of times (n,) s that lie between two samples (s) between which, or at which, an event lies too."""
    after = np.searchsorted(samples, times, side="right")
    is_between = (after > 0) & (after < len(samples)) & ~np.isin(times, samples)
    candidates = np.flatnonzero(is_between)
    after, sorted_times = after[candidates], np.sort(event_times)
    first = np.searchsorted(sorted_times, samples[after - 1], side="left")
    last = np.searchsorted(sorted_times, samples[after], side="right")
    return candidates[first < last]


class DenseOutputEndsError(Exception):
    """The dense output of an engine gives no state at a time at which one is needed."""


class BoundedDenseOutput:
    """Dense output of an engine of which a search takes a bounded number of states, and which notes what it could not give."""

    def __init__(
        self,
        dense_output: DenseOutput | None,  # dense output of the engine; None if it has none
        max_states: int = MAX_DENSE_STATES,  # largest number of states
    ) -> None:
        self._dense_output, self._n_left = dense_output, max_states
        self._n_failures, self._first_failure, self._is_exhausted = 0, math.inf, False

    def __call__(self, k: int, time: float) -> BodyState | None:
        """Return poses and velocities at a time (s) between samples k and k + 1, or None."""
        if self._dense_output is None:
            return None
        if self._n_left == 0:
            self._is_exhausted = True
            return None
        self._n_left -= 1
        state = self._dense_output(k, time)
        if state is None:
            self._n_failures, self._first_failure = self._n_failures + 1, min(self._first_failure, time)
        return state

    def notes(self) -> tuple[str, ...]:
        """Return sentences on the states that were asked for and are not known."""
        notes = list[str]()
        if self._n_failures:
            notes.append(
                f"the engine gives no state between two of its samples at t = {self._first_failure:.9g} s"
                f"{f' and {self._n_failures - 1} other times' if self._n_failures > 1 else ''}; "
                "times of events there are interpolated"
            )
        if self._is_exhausted:
            notes.append("events lie closer together than the samples of this run: the times of some are interpolated; shorten the run")
        return tuple(notes)


@dataclass(frozen=True)
class SampledMotion:
    """A motion sampled at n times (s)."""

    times: FloatArray  # times, s, ascending; shape (n,)
    poses: FloatArray  # poses; shape (n, bodies, 3)
    velocities: FloatArray  # velocities; same shape
    accelerations: FloatArray  # accelerations, at a jump those after it; same shape
    pivot_ratios: FloatArray  # independence of the constraint rows; shape (n,)
    # function (k, time) that gives the engine's own state between samples k and k + 1, if it can
    dense_output: DenseOutput
    contact_times: FloatArray  # times of contact events, s, ascending
    breakpoints: FloatArray  # times at which an input or a derivative of it jumps, s, ascending

    def interpolate(self, intervals: IntArray, times: FloatArray) -> BodyState:
        """Return poses and velocities (m, bodies, 3) at times (m,) s within intervals (m,), by quintic Hermite interpolation."""
        lengths = self.times[intervals + 1] - self.times[intervals]
        fractions = (times - self.times[intervals]) / lengths
        after = intervals + 1
        start = self.poses[intervals], self.velocities[intervals], self.accelerations[intervals]
        end = self.poses[after], self.velocities[after], self.accelerations[after]
        return quintic_hermite(*start, *end, lengths[:, np.newaxis, np.newaxis], fractions[:, np.newaxis, np.newaxis])

    def is_smooth(self, first: IntArray, last: IntArray) -> BoolArray:
        """Return whether the motion is smooth from one sample (m,) to a later one (m,), with its accelerations at both."""
        kinks = np.sort(np.concatenate([self.contact_times, self.breakpoints]))
        counts = [np.searchsorted(kinks, self.times[samples], side="right") for samples in (first, last)]
        is_smooth: BoolArray = counts[0] == counts[1]
        return is_smooth

    def refine_root(self, k: int, time: float, function: StateFunction, bracket: tuple[float, float]) -> float:
        """Return a root (s) in a bracket between samples k and k + 1 by the engine's dense output, or the time given where it has none."""
        try:
            return self._refine_by_dense_output(k, time, function, bracket)
        except DenseOutputEndsError:
            return time

    def _refine_by_dense_output(self, k: int, time: float, function: StateFunction, bracket: tuple[float, float]) -> float:
        """Return a root (s) as `refine_root` does, or raise DenseOutputEndsError."""

        @cache  # the ends of a bracket are asked for several times
        def value(instant: float) -> float:
            state = self.dense_output(k, instant)
            if state is None:
                raise DenseOutputEndsError
            return function(state)

        at_low, at_time, at_high = (value(instant) for instant in (bracket[0], time, bracket[1]))
        if not at_low * at_high < 0:  # a root at an end
            return time
        margin = REFINEMENT_MARGIN * (bracket[1] - bracket[0])
        near = time + (margin if (at_time < 0) == (at_low < 0) else -margin)
        if bracket[0] < near < bracket[1] and value(near) * at_time < 0:
            return find_root(value, *sorted((time, near)))
        return find_root(value, *bracket)


class SampledReading:
    """A reading along a sampled motion, with its first two derivatives at the samples."""

    def __init__(
        self,
        mechanism: Mechanism,
        motion: SampledMotion,
        name: str,  # name of the reading
        # a time, s, and the readings that the run reports there, SI, which fix the full turns of angles; None
        # leaves them open
        start: tuple[float, Mapping[str, float]] | None = None,
    ) -> None:
        self._mechanism = mechanism
        self._motion = motion
        self._name = name
        output = evaluate_output(mechanism, name, motion.poses, motion.velocities)
        # values, rates, accelerations: the reading, SI, and its derivatives; shape (n,)
        self.values = unwrap_output(mechanism.reading(name), output.value)
        if start is not None and isinstance(mechanism.reading(name), LineAngle):
            shift = start[1].get(name, 0.0) - float(np.interp(start[0], motion.times, self.values))
            self.values = self.values + math.tau * round(shift / math.tau)
        self.rates = output.rate(motion.velocities)
        self.accelerations = output.acceleration(motion.accelerations)
        self.curve = HermiteCurve(motion.times, self.values, self.rates, self.accelerations)

    def find_extremes(self, intervals: IntArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the times (m,) at which the rate changes its sign between two times of each interval, as `find_crossings` does."""
        return self._find_times(intervals, low, high, self.curve.find_extremes)

    def find_crossings(self, value: float, intervals: IntArray, low: FloatArray, high: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Return the times (m,) at which the reading passes a value, and whether interpolants of two orders agree on them."""
        return self._find_times(intervals, low, high, partial(self.curve.find_crossings, value))

    def _find_times(
        self,
        intervals: IntArray,
        low: FloatArray,
        high: FloatArray,
        # finds roots of pieces of the curve, from their first samples, number of samples, brackets and tolerance
        find_roots: Callable[[IntArray, int, FloatArray, FloatArray, float], FloatArray],
    ) -> tuple[FloatArray, BoolArray]:
        """Return the roots (m,) s that a function finds, and whether they are certain."""
        n_samples, motion = len(self._motion.times), self._motion
        tolerance = ROOT_TOLERANCE * float(np.min(high - low, initial=1.0))

        def roots(first: IntArray, n_nodes: int, chosen: BoolArray) -> FloatArray:
            return find_roots(first[chosen], n_nodes, low[chosen], high[chosen], tolerance)

        times = find_roots(intervals, 2, low, high, tolerance)
        is_certain = np.zeros(len(intervals), dtype=np.bool_)
        if n_samples < 4:
            return times, is_certain
        first = np.clip(intervals - 1, 0, n_samples - 4)
        is_smooth = motion.is_smooth(first, first + 3)
        first_of_three = np.clip(intervals - 1, first, first + 1)
        better, worse = roots(first, 4, is_smooth), roots(first_of_three, 3, is_smooth)
        lengths = (motion.times[intervals + 1] - motion.times[intervals])[is_smooth]
        times[is_smooth], is_certain[is_smooth] = better, np.abs(better - worse) <= AGREEMENT_OF_INTERPOLANTS * lengths
        return times, is_certain


N_QUADRATURE_POINTS = 65
"""Points of a quadrature of the acceleration by Simpson's rule: a kink costs the square of their distance."""


def find_speed_fluctuation(
    scene: Scene,
    angle: str,
    motion: SampledMotion,  # its motion at times close enough to each other that no extreme is missed
) -> SpeedFluctuation | None:
    """Return the extreme speeds of a shaft in its last complete turn, at zeros of its acceleration; None without such a turn."""
    output = evaluate_output(scene.mechanism, angle, motion.poses, motion.velocities)
    angles, accelerations = output.value, output.acceleration(motion.accelerations)
    if not len(angles) or angles[-1] - angles[0] < math.tau:
        return None
    first = int(np.searchsorted(angles, angles[-1] - math.tau, side="right")) - 1
    speeds = output.rate(motion.velocities)
    extremes = [(float(speeds[k]), float(angles[k])) for k in (first, len(angles) - 1)]
    shaft = _ShaftMotion(scene, angle, motion)
    signs = np.sign(accelerations)
    extremes += [shaft.find_extreme(k) for k in range(first, len(angles) - 1) if signs[k] * signs[k + 1] < 0.0]
    (lowest, lowest_angle), (highest, highest_angle) = min(extremes), max(extremes)
    return SpeedFluctuation(lowest=lowest, highest=highest, lowest_angle=lowest_angle, highest_angle=highest_angle)


class _ShaftMotion:
    """Speed and acceleration of a shaft between the samples of a motion."""

    def __init__(self, scene: Scene, angle: str, motion: SampledMotion) -> None:
        self._scene = scene
        self._angle = angle
        self._motion = motion

    def find_extreme(self, k: int) -> tuple[float, float]:
        """Return the speed (rad/s) and the angle (rad) of the shaft between samples k and k + 1 where its acceleration vanishes."""
        start, end = self._motion.times[k : k + 2].tolist()
        time = find_root(lambda time: float(self._accelerations(k, np.array([time]))[0]), start, end)
        poses, velocities = self._states(k, np.array([time]))
        output = evaluate_output(self._scene.mechanism, self._angle, poses)
        speed = float(output.rate(velocities)[0])
        if self._motion.dense_output(k, time) is None:
            speed = self._integrate_speed(k, time)
        return speed, float(output.value[0])

    def _integrate_speed(self, k: int, time: float) -> float:
        """Return the speed at a time after sample k, rad/s: a kink of the torque between both is beyond an interpolant."""
        from scipy.integrate import simpson  # slow to import

        times = np.linspace(self._motion.times[k], time, N_QUADRATURE_POINTS)
        start = evaluate_output(self._scene.mechanism, self._angle, self._motion.poses[k]).rate(self._motion.velocities[k])
        return float(start + simpson(self._accelerations(k, times), x=times))

    def _states(self, k: int, times: FloatArray) -> BodyState:
        """Return poses and velocities (n, bodies, 3) at times (n,) s between samples k and k + 1."""
        states = [self._motion.dense_output(k, time) for time in times.tolist()]
        known = [state for state in states if state is not None]
        if len(known) < len(times):
            return self._motion.interpolate(np.full(len(times), k), times)
        return np.array([poses for poses, _ in known]), np.array([velocities for _, velocities in known])

    def _accelerations(self, k: int, times: FloatArray) -> FloatArray:
        """Return the accelerations (n,) of the shaft at times (n,) s between samples k and k + 1."""
        poses, velocities = self._states(k, times)
        accelerations = compute_inverse_dynamics(self._scene, times, poses, velocities, np.zeros((len(times), 0))).accelerations
        return evaluate_output(self._scene.mechanism, self._angle, poses, velocities).acceleration(accelerations)

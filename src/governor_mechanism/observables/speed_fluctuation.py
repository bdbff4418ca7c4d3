"""Lowest and highest speed of a shaft in the last turn of a run."""

import math

import numpy as np

from governor_mechanism.mechanics.dynamics.equations.inverse_dynamics import compute_inverse_dynamics
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.model.results.speed_fluctuation import SpeedFluctuation
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.roots import find_root
from governor_mechanism.observables.sampled_motion import BodyState, SampledMotion
from governor_mechanism.types import FloatArray

N_QUADRATURE_POINTS = 65
"""Points of a quadrature of the acceleration by Simpson's rule: a kink costs the square of their distance."""


def find_speed_fluctuation(
    scene: Scene,
    angle: str,
    motion: SampledMotion,  # its motion at times close enough to each other that no extreme is missed
) -> SpeedFluctuation | None:
    """Return the extreme speeds of a shaft in its last complete turn.

    An extreme is where the acceleration of the angle vanishes, located in the engine's own dense output where there is one.

    Result: none if the shaft makes no complete turn.
    """
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
        self._scene, self._angle, self._motion = scene, angle, motion

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

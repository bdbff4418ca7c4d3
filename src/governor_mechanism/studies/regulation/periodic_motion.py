"""Periodic motion of a governed engine under its cyclic torque, and the growth of small deviations from it.

The state at a crank angle is carried over one period by the engine of the simulation. Newton's method finds the
state that comes back after a turn, and the period. The derivative of the state after a period by the state before it has the Floquet
multipliers as eigenvalues: small deviations grow if one of them is larger than 1 in magnitude. One is 1, for a shift in time.
"""

import cmath
import math
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.engines import select_engine
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.part import Start
from governor_mechanism.model.scene import Scene
from governor_mechanism.studies.regulation.governed_engine import GovernedEngine, OperatingPoint
from governor_mechanism.types import ComplexArray, FloatArray

RUN_ACCURACY = 1e-10
"""Accuracy of the runs of a turn, whose differences give derivatives."""

DIFFERENCE_STEP = 1e-5
"""Change of a state, relative to its scale, for its derivatives: rounding and curvature then cost about the same."""

RETURN_TOLERANCE = 1e-9
"""Largest distance between the states before and after a turn of a periodic motion, relative to their scales: ten times `RUN_ACCURACY`."""

MAX_ITERATIONS = 20
"""Largest number of Newton steps."""

SUFFICIENT_DECREASE = 0.1
"""Ratio of successive distances above which Newton's method computes its Jacobian again."""


@dataclass(frozen=True, kw_only=True, eq=False)
class PeriodicMotion:
    """A periodic motion of a governed engine."""

    period: float  # time of a turn of the shaft, s
    # angle and speed of the shaft, coordinate and rate of the governor at the start of the turn, SI
    state: FloatArray
    multipliers: ComplexArray  # floquet multipliers of a turn without that of a shift in time, the largest first
    return_error: float  # distance between the states before and after the turn, relative to their scales
    turn_jacobian: FloatArray  # derivative of the state after the turn by that before, both relative to their scales; shape (4, 4)
    point: OperatingPoint  # equilibrium with mean torque, of this motion or of the one at which the search began

    @property
    def growth_rate(self) -> float:
        """Growth rate of the least damped small motion, 1/s; positive if the engine hunts."""
        return math.log(abs(self.multipliers[0])) / self.period

    @property
    def frequency(self) -> float:
        """Frequency of the least damped small motion, rad/s; up to a multiple of that of the shaft."""
        return abs(cmath.phase(self.multipliers[0])) / self.period


def find_periodic_motion(
    scene: Scene,  # scene of a governed engine without contacts on its governor
    torque: float,  # load, N m
    near: PeriodicMotion | None = None,  # motion of a similar scene, at which the search begins
) -> PeriodicMotion:
    """Return the periodic motion of a governed engine under a constant load."""
    governed = GovernedEngine(GovernedEngine(scene).with_constant_load(torque))
    return _TurnMap(governed, near.point if near else governed.operating_point(torque)).solve(near)


class _TurnMap:
    """The state of a governed engine after a time, as a function of that before."""

    def __init__(self, governed: GovernedEngine, point: OperatingPoint) -> None:
        self._governed, self._point = governed, point
        self._started = governed.started_at(point)
        start = self._started.system.start
        angle = start.values.get(governed.shaft_angle, 0.0)
        angle = angle if isinstance(angle, float) else 0.0
        speed = start.rates[governed.shaft_angle]
        self._state = np.array([angle, speed, point.coordinate, 0.0])
        self._period = math.tau / point.shaft_speed
        scale = governed.coordinate_scale
        self._scales = np.array([1.0, point.shaft_speed, scale, scale * point.shaft_speed])

    def solve(self, near: PeriodicMotion | None = None) -> PeriodicMotion:
        """Return the periodic motion near the operating point, or near another motion."""
        # A Jacobian costs eight runs, so that one is kept while the distance between the states
        # shrinks well.
        state, period = (near.state, near.period) if near else (self._state, self._period)
        jacobian, matrix, previous = near.turn_jacobian if near else None, None, math.inf
        shift = np.array([math.tau, 0.0, 0.0, 0.0])
        for _ in range(MAX_ITERATIONS):
            end = self._advance(state, period)
            residual = (end - state - shift) / self._scales
            size = float(np.abs(residual).max())
            if size <= RETURN_TOLERANCE:
                return self._motion(state, period, self._derivative_by_state(state, period), size)
            if matrix is None or size > SUFFICIENT_DECREASE * previous:
                if jacobian is None or matrix is not None:
                    jacobian = self._derivative_by_state(state, period)
                matrix = self._newton_matrix(jacobian, state, period, end)
            correction, previous = np.linalg.solve(matrix, -residual), size
            state = state + self._scales * np.append(0.0, correction[:3])
            period *= 1.0 + float(np.clip(correction[3], -0.5, 0.5))
        raise MechanismError(
            f"no periodic motion was found near the equilibrium at {self._state[1]:.6g} rad/s: after {MAX_ITERATIONS} steps the state "
            f"after a turn differs by {np.abs(residual).max():.3g} of its scale; increase the inertia of the flywheel"
        )

    def _newton_matrix(self, jacobian: FloatArray, state: FloatArray, period: float, end: FloatArray) -> FloatArray:
        """Return the derivatives of the residual by speed, coordinate and rate at a fixed angle, and by the period."""
        step = DIFFERENCE_STEP * period
        by_period = (self._advance(state, period + step) - end) / step * period / self._scales
        return np.column_stack([(jacobian - np.eye(4))[:, 1:], by_period])

    def _motion(self, state: FloatArray, period: float, jacobian: FloatArray, error: float) -> PeriodicMotion:
        """Return the periodic motion, without the multiplier nearest to 1, that of a shift in time."""
        multipliers = np.linalg.eigvals(jacobian)
        multipliers = np.delete(multipliers, np.argmin(np.abs(multipliers - 1.0)))
        order = np.argsort(-np.abs(multipliers), kind="stable")
        return PeriodicMotion(
            period=period,
            state=state,
            multipliers=multipliers[order].astype(complex),
            return_error=error,
            turn_jacobian=jacobian,
            point=self._point,
        )

    def _derivative_by_state(self, state: FloatArray, period: float) -> FloatArray:
        """Return the derivative (4, 4) of the state after a period by that before, both relative to their scales."""
        columns = []
        for k in range(len(state)):
            change = np.zeros_like(state)
            change[k] = DIFFERENCE_STEP * self._scales[k]
            difference = self._advance(state + change, period) - self._advance(state - change, period)
            columns.append(difference / (2 * DIFFERENCE_STEP) / self._scales)
        return np.column_stack(columns)

    def _advance(self, state: FloatArray, duration: float) -> FloatArray:
        """Return the state after a time, s."""
        governed = self._governed
        scene = _with_start(self._started, governed, state, duration)
        engine, reason = select_engine("auto", scene)
        run = engine.run(scene, accuracy=RUN_ACCURACY, certify=False, reason=reason)
        run.raise_if_failed()
        shaft, coordinate = governed.shaft_angle, governed.coordinate
        return np.array([run.readings[shaft][-1], run.rates[shaft][-1], run.readings[coordinate][-1], run.rates[coordinate][-1]])


def _with_start(scene: Scene, governed: GovernedEngine, state: FloatArray, duration: float) -> Scene:
    """Return the scene with a start in a state, for a run of a duration (s) with reports at its ends."""
    angle, speed, position, rate = state.tolist()
    shaft_part, shaft_reading = scene.part_of(governed.shaft_angle)
    parts = []
    for part in scene.parts:
        start = part.start
        if part is shaft_part:
            start = Start(values={**start.values, shaft_reading: angle}, rates={**start.rates, shaft_reading: speed})
        elif part.name == governed.governor:
            coordinate = part.mechanism.coordinate
            start = Start(values={**start.values, coordinate: position}, rates={coordinate: rate})
        parts.append(replace(part, start=start))
    return replace(scene, parts=tuple(parts), run=replace(scene.run, duration=duration, output_interval=duration), document={})

"""Batch of runs of scenes that differ only in numbers, without certificate and observables.

Only for conservative scenes, whose table holds all forces: constant spindle speed, gravity, centrifugal forces. The table of a run is as
accurate as its steps, so that it has few pieces.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.engines.reduced.integration import (
    ReducedEquation,
    integrate_without_contacts,
    make_reduced_buffers,
    make_reduced_equation,
)
from governor_mechanism.engines.reduced.passage import describe_passage_end, integrate_passage
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.mechanics.contact.transition import make_event_log
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.reduction.equation_of_motion import N_STATES
from governor_mechanism.mechanics.reduction.lowering import ForceParameter
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.node_evaluation import MIN_FIT_TOLERANCE
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Outcome
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.types import FloatArray

FIT_TOLERANCE_RATIO = 0.1
"""Truncation error of a table relative to the error of a step."""

MAX_FIT_TOLERANCE = 1e-10
"""Largest truncation error of a table. Its pieces are then 1.8 times as wide as those of the most accurate one; wider ones save little."""


@dataclass(frozen=True)
class UncertifiedResult:
    """Readings and rates of one run without certificate, at the times that it reached.

    Attributes
    ----------
    times
        Reported times, s; shape (n,).
    readings
        Values by name, SI; shape (n,).
    rates
        Their rates by name, SI per second; shape (n,).
    outcome
        How the run ended.
    detail
        Cause of an end before the last time; else empty.
    error_estimate
        None: the run is not certified.
    """

    times: FloatArray
    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    outcome: Outcome
    detail: str
    error_estimate: None = None

    @property
    def message(self) -> str:
        """Outcome as a sentence, after its cause if there is one."""
        return self.outcome.describe(self.detail)


class ReducedBatch:
    """Run scenes like a template, each from a value and rate of its coordinate, with shared buffers.

    Parameters
    ----------
    template
        A scene of the batch.
    names
        The readings to return.
    tolerance
        Error of one step, as in `ReducedEngine`.
    max_steps
        Largest number of steps of one run.
    """

    def __init__(self, template: Scene, names: Sequence[str], tolerance: float, max_steps: int) -> None:
        warn_before_compiling(integrate_without_contacts, 20)
        self._times, self._names = make_reported_times(template), list(names)
        self._tolerance, self._max_steps, self._settings = tolerance, max_steps, ReducedSettings()
        self._fit_tolerance = min(max(FIT_TOLERANCE_RATIO * tolerance, MIN_FIT_TOLERANCE), MAX_FIT_TOLERANCE)
        self._counts = np.zeros(len(StepCounter), dtype=np.int64)
        n_times = len(self._times)
        self._states, self._modes = np.empty((n_times, N_STATES)), np.zeros((n_times, 1), dtype=np.int64)
        self._input_cubics, self._mode = np.zeros((1, 5)), np.zeros(1, dtype=np.int64)
        self._event_log = make_event_log(0)

    def run(self, scene: Scene) -> UncertifiedResult | None:
        """Run a scene.

        Parameters
        ----------
        scene
            The scene.

        Returns
        -------
        UncertifiedResult | None
            The result, or None if the scene is not conservative or cannot be assembled at its start.
        """
        mechanism = scene.part.mechanism
        start, rate = scene.start.values.get(mechanism.coordinate), scene.start.rates.get(mechanism.coordinate, 0.0)
        if not isinstance(start, float):
            return None
        poses = np.array(mechanism.initial_guess, dtype=np.float64)
        motion_table = MotionTable(scene, start, poses, fit_tolerance=self._fit_tolerance, is_guess=True)
        arrays, forces = motion_table.arrays, motion_table.forces
        if not (motion_table.is_started and arrays.is_conservative and arrays.low < start < arrays.high):
            return None

        def make_equation(time: float) -> ReducedEquation:
            return make_reduced_equation(motion_table.table, forces, self._input_cubics, self._mode, self._counts, self._tolerance)

        state = np.zeros(N_STATES)
        state[:2] = start, rate
        self._states[0], self._counts[:] = state, 0
        max_step = self._settings.max_step_ratio * max_step_scale(scene)
        limits = StepLimits(self._tolerance, self._settings.first_step_ratio * max_step, max_step, self._max_steps, inf)
        passage = integrate_passage(
            motion_table,
            make_equation,
            make_reduced_buffers(forces, self._counts),
            (0.0, float(self._times[-1])),
            self._times[1:],
            state,
            limits,
            self._states[1:],
            self._modes[1:],
            self._event_log,
            time_scale=float(forces.parameters[ForceParameter.TIME_SCALE]),
            settings=self._settings,
        )
        outcome, detail = describe_passage_end(scene, motion_table, passage.status, passage.time, passage.side, self._max_steps)
        readings, rates = self._evaluate_readings(scene, motion_table, self._states[: 1 + passage.n_reached])
        return UncertifiedResult(self._times[: 1 + passage.n_reached], readings, rates, outcome or Outcome.NOT_CERTIFIED, detail)

    def _evaluate_readings(
        self, scene: Scene, motion_table: MotionTable, states: FloatArray
    ) -> tuple[dict[str, FloatArray], dict[str, FloatArray]]:
        """Return the readings of the batch, and their rates, in states (n, N_STATES)."""
        mechanism, readings, rates = scene.part.mechanism, {}, {}
        others = [name for name in self._names if name != mechanism.coordinate]
        if mechanism.coordinate in self._names:
            readings[mechanism.coordinate], rates[mechanism.coordinate] = states[:, 0].copy(), states[:, 1].copy()
        if others:
            poses, tangents = motion_table.evaluate_poses(states[:, 0])
            for name in others:
                output = evaluate_output(mechanism, name, poses)
                wraps = isinstance(mechanism.reading(name), LineAngle)
                readings[name] = np.unwrap(output.value) if wraps else output.value
                rates[name] = np.sum(output.gradient * tangents, axis=(-2, -1)) * states[:, 1]
        return readings, rates

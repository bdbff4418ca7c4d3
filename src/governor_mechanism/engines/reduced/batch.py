"""Batch of runs of scenes that differ only in numbers, without certificate and observables.

Only for conservative scenes, whose table holds all forces: constant spindle speed, gravity, centrifugal forces.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.base import make_reported_times
from governor_mechanism.engines.reduced.integration import (
    integrate_reduced,
    integrate_without_contacts,
    make_reduced_buffers,
    make_reduced_equation,
)
from governor_mechanism.engines.reduced.run import ReducedSettings
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.transition import make_event_log
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.kinematics.coordinate_assembly import continue_to_coordinate
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output
from governor_mechanism.mechanics.reduction.equation_of_motion import N_STATES
from governor_mechanism.mechanics.reduction.lowering import lower_reduced_scene
from governor_mechanism.mechanics.reduction.node_evaluation import make_lagrangian_workspace
from governor_mechanism.mechanics.reduction.table import ExtensionStatus, PiecewiseTable, allocate_table, evaluate_poses
from governor_mechanism.mechanics.reduction.table_refinement import extend_table
from governor_mechanism.model.output_variables import LineAngle
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import warn_before_compiling
from governor_mechanism.types import FloatArray

BATCH_TABLE_CAPACITY = 16
"""Number of table pieces; a motion that needs more is left to the engine."""


@dataclass(frozen=True)
class UncertifiedResult:
    """Readings and rates of one run without certificate.

    Attributes
    ----------
    times
        Reported times, s; shape (n,).
    readings
        Values by name, SI; shape (n,).
    rates
        Their rates by name, SI per second; shape (n,).
    error_estimate
        None: the run is not certified.
    """

    times: FloatArray
    readings: dict[str, FloatArray]
    rates: dict[str, FloatArray]
    error_estimate: None = None


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
        arrays, _, _ = lower_reduced_scene(template)
        self._counts = np.zeros(len(StepCounter), dtype=np.int64)
        self._workspace = make_lagrangian_workspace(arrays.lagrangian)
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
            The result, or None if the scene is not conservative, cannot be assembled at its start, or does not reach its last time.
        """
        arrays, forces, _ = lower_reduced_scene(scene)
        mechanism, name = scene.part.mechanism, scene.part.mechanism.coordinate
        start, rate = scene.start.values.get(name), scene.start.rates.get(name, 0.0)
        if not arrays.is_conservative or not isinstance(start, float) or not arrays.low < start < arrays.high:
            return None
        poses = np.array(mechanism.initial_guess, dtype=np.float64)
        if not continue_to_coordinate(arrays.lagrangian.assembly, self._workspace.assembly, start, poses):
            return None
        table = allocate_table(arrays, BATCH_TABLE_CAPACITY, start, poses)

        def extend(side: int) -> bool:
            # An enum member as argument would compile the kernel again.
            return extend_table(arrays, self._workspace, table, int(side)) == ExtensionStatus.PIECE_ADDED

        if not extend(1):
            return None
        state, time, n_filled, end = np.zeros(N_STATES), 0.0, 1, float(self._times[-1])
        state[:2] = start, rate
        self._states[0] = state
        max_step = self._settings.max_step_ratio * max_step_scale(scene)
        step = self._settings.first_step_ratio * max_step
        equation = make_reduced_equation(table, forces, self._input_cubics, self._mode, self._counts, self._tolerance)
        buffers = make_reduced_buffers(forces, self._counts)
        self._counts[:] = 0
        while True:
            limits = StepLimits(self._tolerance, step, max_step, self._max_steps, math.inf)
            outputs = (self._states[n_filled:], self._modes[n_filled:], self._event_log)
            status, step, n_reached, time = integrate_reduced(
                equation, buffers, (time, end), self._times[n_filled:], state, limits, *outputs
            )
            n_filled += n_reached
            if status not in (IntegrationStatus.BELOW_TABLE, IntegrationStatus.ABOVE_TABLE):
                break
            if not extend(status - IntegrationStatus.BELOW_TABLE):
                return None
        is_complete = status == IntegrationStatus.DONE and n_filled == len(self._times)
        return self._make_result(scene, table, n_filled) if is_complete else None

    def _make_result(self, scene: Scene, table: PiecewiseTable, n_filled: int) -> UncertifiedResult:
        mechanism, rows = scene.part.mechanism, self._states
        readings, rates = {}, {}
        others = [name for name in self._names if name != mechanism.coordinate]
        if mechanism.coordinate in self._names:
            readings[mechanism.coordinate], rates[mechanism.coordinate] = rows[:, 0].copy(), rows[:, 1].copy()
        if others:
            poses, tangents = evaluate_poses(table, rows[:, 0].copy())
            for name in others:
                output = evaluate_output(mechanism, name, poses)
                wraps = isinstance(mechanism.reading(name), LineAngle)
                readings[name] = np.unwrap(output.value) if wraps else output.value
                rates[name] = np.sum(output.gradient * tangents, axis=(-2, -1)) * rows[:, 1]
        return UncertifiedResult(self._times, readings, rates)

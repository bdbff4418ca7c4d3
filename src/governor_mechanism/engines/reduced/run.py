"""One run of a scene through its reported times at a tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.reduced.integration import initialise_contact_mode, integrate_reduced
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.integrators.reduced_dop853 import make_stages
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import drop_cancelled_events
from governor_mechanism.mechanics.contact.rules import HELD
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, output_springs_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import SpindleSpeedFunction, stack_local_cubics
from governor_mechanism.mechanics.reduction.equation_of_motion import N_QUADRATURES, ReducedModel, make_reduced_model
from governor_mechanism.mechanics.reduction.lowering import ForceParameter
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.model.events import Event
from governor_mechanism.model.state_history import StateHistory
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.types import FloatArray, IntArray

INITIAL_EVENT_CAPACITY = 4096
"""Number of events for which records are allocated at first."""


@dataclass(frozen=True)
class ReducedSolution:
    """Result of one integration: states (n, 2 + quadratures) and modes at the times reached, events, and how and when (s) it ended."""

    states: FloatArray
    modes: IntArray
    events: tuple[Event, ...]
    status: IntegrationStatus
    end_time: float
    side: int
    last_step: float


class ReducedRun:
    """Runs of one scene through times (n,) s from a start (coordinate, rate), along a motion table."""

    def __init__(
        self,
        motion_table: MotionTable,
        evaluator: ReadingEvaluator,
        start: tuple[float, float],
        times: FloatArray,
        max_steps: int,
        settings: ReducedSettings,
    ) -> None:
        self.motion_table, self.evaluator, self.times = motion_table, evaluator, times
        self.max_steps, self.settings = max_steps, settings
        self.start, self.counts = start, np.zeros(4, dtype=np.int64)
        scene = motion_table.scene
        self.contacts = contacts_of(scene)
        self.one_sided_springs = [spring for spring in output_springs_of(scene) if spring.one_sided]
        self.has_contacts = bool(self.contacts or self.one_sided_springs)
        breakpoints = np.unique(np.concatenate([time_function.breakpoints for time_function in motion_table.time_functions]))
        end = float(times[-1]) if len(times) else 0.0
        self._breakpoints = np.concatenate([[0.0], breakpoints[(breakpoints > 0) & (breakpoints < end)], [end]])
        self._initial_momentum = 0.0
        if motion_table.has_free_spindle:
            total_inertia = (
                evaluator.evaluate_spindle_inertia(0, motion_table.evaluate_poses(np.array([start[0]]))[0])[0]
                + motion_table.forces.parameters[ForceParameter.FREE_SPINDLE_INERTIA]
            )
            self._initial_momentum = total_inertia * SpindleSpeedFunction(scene.spindle).start_speed

    def integrate(self, tolerance: float, step_factor: float = 1.0) -> ReducedSolution:
        """Integrate through all times, with a factor on the largest step."""
        capacity = INITIAL_EVENT_CAPACITY if self.has_contacts else 0
        while True:
            solution, n_events = self._integrate_with_capacity(tolerance, step_factor, capacity)
            if n_events <= capacity:
                return solution
            capacity = 2 * n_events

    def _integrate_with_capacity(self, tolerance: float, step_factor: float, capacity: int) -> tuple[ReducedSolution, int]:
        motion_table, settings, time_scale = self.motion_table, self.settings, self.evaluator.time_scale
        max_step = step_factor * settings.max_step_ratio
        max_step *= max_step_scale(motion_table.scene) * (settings.event_step_ratio if self.has_contacts else 1.0)
        state = np.array([*self.start, *(0.0,) * N_QUADRATURES])
        states, modes = np.empty((len(self.times), 2 + N_QUADRATURES)), self._allocate_modes()
        mode, stages = np.zeros(modes.shape[1], dtype=np.int64), make_stages()
        event_log = make_event_log(capacity)
        counts = np.zeros_like(self.counts)
        if self.has_contacts:
            initialise_contact_mode(self._make_model(0.0, mode), 0.0, state, event_log)
            event_log.counts[:] = 0
        n_filled, step = int(len(self.times) > 0 and self.times[0] == 0.0), settings.first_step_ratio * max_step
        status: int = IntegrationStatus.DONE
        time, side = 0.0, 0
        states[:n_filled], modes[:n_filled] = state, mode
        for start, end in pairwise(self._breakpoints.tolist()):
            time = start
            while time < end:
                limits = (tolerance, step, max_step, self.max_steps)
                last_row = int(np.searchsorted(self.times, end, side="right"))
                buffers = (stages, states[n_filled:], modes[n_filled:], event_log, counts)
                status, step, n_reached, time = integrate_reduced(
                    self._make_model(time, mode), (time, end), self.times[n_filled:last_row], state, limits, *buffers
                )
                n_filled += n_reached
                if status not in (IntegrationStatus.BELOW_TABLE, IntegrationStatus.ABOVE_TABLE):
                    break
                side = status - IntegrationStatus.BELOW_TABLE
                if not motion_table.extend(side):
                    step *= settings.table_end_step_ratio
                    remaining = abs(motion_table.end_coordinate(side) - state[0])
                    min_remaining = settings.min_remaining_travel * max(motion_table.arrays.coordinate_scale, abs(state[0]))
                    if step < settings.min_end_step_ratio * max(time_scale, end - time) or remaining < min_remaining:
                        time += max((motion_table.end_coordinate(side) - state[0]) / state[1], 0.0) if state[1] else 0.0
                        status = IntegrationStatus.TABLE_ENDED
                        break
            if status != IntegrationStatus.DONE:
                break
            breakpoint_row = n_filled - 1 if n_filled and self.times[n_filled - 1] == end else None
            self._add_speed_jump_work(end, state, states, breakpoint_row)
            if self.has_contacts:
                initialise_contact_mode(self._make_model(end, mode), end, state, event_log)
        self.counts += counts
        subjects = [contact.output_name for contact in self.contacts] + [spring.reading for spring in self.one_sided_springs]
        events = drop_cancelled_events(make_events(event_log, subjects), SIMULTANEITY_TOLERANCE * time_scale)
        solution = ReducedSolution(states[:n_filled], modes[:n_filled], events, IntegrationStatus(status), time, side, step)
        return solution, int(event_log.counts[0])

    def integrate_from_row(self, states: FloatArray, tolerance: float, k: int, time: float) -> tuple[FloatArray, FloatArray] | None:
        """Return poses and velocities (bodies, 3) at a time, s, after that of row k, integrated from that row; None on failure."""
        start_time, state, time_scale = float(self.times[k]), states[k].copy(), self.evaluator.time_scale
        model = self._make_model(start_time, np.zeros(1, dtype=np.int64))
        limits = (tolerance, 0.01 * time_scale, self.settings.max_step_ratio * time_scale, self.settings.max_interpolation_steps)
        no_states, no_modes = np.empty((0, 2 + N_QUADRATURES)), np.zeros((0, 1), dtype=np.int64)
        buffers = (make_stages(), no_states, no_modes, make_event_log(0), np.zeros(4, dtype=np.int64))
        status, *_ = integrate_reduced(model, (start_time, time), np.empty(0), state, limits, *buffers)
        if status != IntegrationStatus.DONE:
            return None
        poses, tangents = self.motion_table.evaluate_poses(state[:1])
        return poses[0], tangents[0] * state[1]

    def _make_model(self, start: float, mode: IntArray) -> ReducedModel:
        return make_reduced_model(self.motion_table.table, self.motion_table.forces, self.input_cubics(start), mode)

    def input_cubics(self, start: float) -> FloatArray:
        """Return the cubics of the inputs (inputs, 5) from a time up to their next breakpoint.

        The integral of a torque on the spindle includes the initial angular momentum.
        """
        coefficients: FloatArray = stack_local_cubics(self.motion_table.time_functions, np.array([start]))[0]
        coefficients[0, 4] += self._initial_momentum
        return coefficients

    def state_history(self, solution: ReducedSolution) -> StateHistory:
        """Return the states of bodies and spindle at the times reached."""
        times, states = self.times[: len(solution.states)], solution.states
        poses, tangents = self.motion_table.evaluate_poses(states[:, 0])
        speeds = self.evaluator.evaluate_spindle_speeds(times, poses)
        is_conservative = self.motion_table.arrays.is_conservative
        angle = speeds * times if is_conservative else states[:, 4]
        work, dissipated_energy = (np.zeros(len(times)),) * 2 if is_conservative else (states[:, 2], states[:, 3])
        poses, velocities = self.evaluator.with_shaft(poses, tangents * states[:, 1, np.newaxis, np.newaxis], angle, speeds)
        return StateHistory(
            times=times, poses=poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, lags=np.zeros((len(times), 0))
        )

    def contact_modes(self, solution: ReducedSolution, poses: FloatArray) -> tuple[ContactMode, ...]:
        """Return the contact modes at the times reached; empty without contacts."""
        if not self.has_contacts:
            return ()
        mechanism, n_contacts = self.motion_table.scene.part.mechanism, len(self.contacts)
        values = [evaluate_output_value(mechanism, contact.output_name, poses) for contact in self.contacts]
        contact_modes = []
        for index, (is_held, *states) in enumerate(solution.modes.tolist()):
            held_values = tuple(float(value[index]) if state == HELD else None for value, state in zip(values, states, strict=False))
            sliding_signs = tuple(0 if state == HELD else state for state in states[:n_contacts])
            contact_modes.append(ContactMode(held_values, sliding_signs, tuple(map(bool, states[n_contacts:])), bool(is_held)))
        return tuple(contact_modes)

    def _allocate_modes(self) -> IntArray:
        return np.zeros((len(self.times), 1 + len(self.contacts) + len(self.one_sided_springs)), dtype=np.int64)

    def _add_speed_jump_work(self, time: float, state: FloatArray, states: FloatArray, row: int | None) -> None:
        """Add the work that a jump of the given spindle speed does on the bodies; a report at that time shows the right limit."""
        program = SpindleSpeedFunction(self.motion_table.scene.spindle)
        if program.is_constant:
            return
        before, after = (float(program(np.array([time]), left_limit=left_limit)[0]) for left_limit in (True, False))
        if after == before or self.motion_table.has_free_spindle or not self.motion_table.arrays.has_centrifugal_forces:
            return
        inertia = self.evaluator.evaluate_spindle_inertia(0, self.motion_table.evaluate_poses(state[:1])[0])[0]
        state[2] += 0.5 * inertia * (after**2 - before**2)
        if row is not None:
            states[row, 2] = state[2]

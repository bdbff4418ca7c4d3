"""One run of a scene through its reported times at a tolerance."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.certificate import speed_jump_work
from governor_mechanism.engines.reduced.integration import (
    ReducedEquation,
    initialise_contact_mode,
    integrate_reduced,
    make_reduced_buffers,
    make_reduced_equation,
)
from governor_mechanism.engines.reduced.settings import ReducedSettings
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.status import IntegrationStatus
from governor_mechanism.mechanics.contact.event_log import drop_cancelled_events
from governor_mechanism.mechanics.contact.rules import HELD
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.mechanics.reduction.equation_of_motion import N_STATES, StateIndex
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.shaft import find_shaft_train, parts_with_coordinate
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray, IntArray

INITIAL_EVENT_CAPACITY = 4096
"""Number of events for which records are allocated at first."""


@dataclass(frozen=True)
class ReducedSolution:
    """Result of one integration: states (n, N_STATES) and modes at the times reached, events, and how and when (s) it ended."""

    states: FloatArray
    modes: IntArray
    events: tuple[Event, ...]
    status: IntegrationStatus
    end_time: float
    side: int
    last_step: float


class ReducedRun:
    """Runs of one scene through times (n,) s from a start (N_STATES,) with poses (bodies, 3) of all bodies, along a motion table."""

    def __init__(
        self,
        motion_table: MotionTable,
        evaluator: ReadingEvaluator,
        start: FloatArray,
        initial_poses: FloatArray,
        times: FloatArray,
        max_steps: int,
        settings: ReducedSettings,
    ) -> None:
        self.motion_table, self.evaluator, self.times = motion_table, evaluator, times
        self.max_steps, self.settings = max_steps, settings
        self.start, self.counts = start, np.zeros(len(StepCounter), dtype=np.int64)
        scene = motion_table.scene
        self.contacts = contacts_of(scene)
        self.one_sided_springs = one_sided_forces_of(scene)
        self.has_contacts = bool(self.contacts or self.one_sided_springs)
        self._max_step = settings.max_step_ratio * max_step_scale(scene) * (settings.event_step_ratio if self.has_contacts else 1.0)
        breakpoints = np.unique(np.concatenate([time_function.breakpoints for time_function in motion_table.time_functions]))
        end = float(times[-1]) if len(times) else 0.0
        self._breakpoints = np.concatenate([[0.0], breakpoints[(breakpoints > 0) & (breakpoints < end)], [end]])
        self._initial_poses, self._own_bodies = initial_poses, bodies_with_coordinate(scene)
        self._rotors = {scene.mechanism.body_index(name): motion for name, motion in find_shaft_train(scene).motion.items()}

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
        max_step = step_factor * self._max_step
        state = self.start.copy()
        states, modes = np.empty((len(self.times), N_STATES)), self._allocate_modes()
        mode, event_log, counts = (
            np.zeros(modes.shape[1], dtype=np.int64),
            make_event_log(capacity),
            np.zeros(len(StepCounter), dtype=np.int64),
        )
        buffers = make_reduced_buffers(motion_table.forces, counts)
        if self.has_contacts:
            initialise_contact_mode(self._make_equation(0.0, mode, counts).model, 0.0, state, event_log)
            event_log.counts[:] = 0
        n_filled, step = int(len(self.times) > 0 and self.times[0] == 0.0), settings.first_step_ratio * max_step
        status: int = IntegrationStatus.DONE
        time, side = 0.0, 0
        states[:n_filled], modes[:n_filled] = state, mode
        for start, end in pairwise(self._breakpoints.tolist()):
            time = start
            while time < end:
                limits = StepLimits(tolerance, step, max_step, self.max_steps, 0.0)
                rows = slice(n_filled, int(np.searchsorted(self.times, end, side="right")))
                equation, outputs = self._make_equation(time, mode, counts), (states[rows], modes[rows], event_log)
                status, step, n_reached, time = integrate_reduced(equation, buffers, (time, end), self.times[rows], state, limits, *outputs)
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
                initialise_contact_mode(self._make_equation(end, mode, counts).model, end, state, event_log)
        self.counts += counts
        subjects = [contact.output_name for contact in self.contacts] + [spring.reading for spring in self.one_sided_springs]
        events = drop_cancelled_events(make_events(event_log, subjects), SIMULTANEITY_TOLERANCE * time_scale)
        solution = ReducedSolution(states[:n_filled], modes[:n_filled], events, IntegrationStatus(status), time, side, step)
        return solution, int(event_log.counts[0])

    def integrate_from_row(self, solution: ReducedSolution, tolerance: float, k: int, time: float) -> tuple[FloatArray, FloatArray] | None:
        """Return poses and velocities (bodies, 3) at a time, s, after that of row k, integrated from that row; None on failure."""
        start_time, state, mode = float(self.times[k]), solution.states[k].copy(), solution.modes[k].copy()
        event_log, counts = make_event_log(0), np.zeros(len(StepCounter), dtype=np.int64)
        equation = self._make_equation(start_time, mode, counts)
        if self.has_contacts and start_time in self._breakpoints[1:]:
            initialise_contact_mode(equation.model, start_time, state, event_log)  # a row at a breakpoint has the mode before it
        limits = StepLimits(tolerance, 0.01 * self.evaluator.time_scale, self._max_step, self.settings.max_interpolation_steps, 0.0)
        outputs = np.empty((0, len(state))), np.zeros((0, len(mode)), dtype=np.int64), event_log
        buffers = make_reduced_buffers(self.motion_table.forces, counts)
        status, *_ = integrate_reduced(equation, buffers, (start_time, time), np.empty(0), state, limits, *outputs)
        if status != IntegrationStatus.DONE:
            return None
        poses, velocities = self._evaluate_motion(state[np.newaxis])
        return poses[0], velocities[0]

    def _make_equation(self, start: float, mode: IntArray, counts: IntArray) -> ReducedEquation:
        return make_reduced_equation(self.motion_table.table, self.motion_table.forces, self.input_cubics(start), mode, counts)

    def input_cubics(self, start: float) -> FloatArray:
        """Return the cubics of the inputs (inputs, 5) from a time up to their next breakpoint."""
        coefficients: FloatArray = stack_local_cubics(self.motion_table.time_functions, np.array([start]))[0]
        return coefficients

    def state_history(self, solution: ReducedSolution) -> StateHistory:
        """Return the states of all bodies at the times reached."""
        times, states = self.times[: len(solution.states)], solution.states
        is_conservative = self.motion_table.arrays.is_conservative
        work, dissipated_energy = (np.zeros(len(times)),) * 2 if is_conservative else (states[:, StateIndex.WORK], states[:, 3])
        poses, velocities = self._evaluate_motion(states)
        return StateHistory(
            times=times, poses=poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, lags=np.zeros((len(times), 0))
        )

    def _evaluate_motion(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities (n, bodies, 3) of all bodies in states (n, N_STATES)."""
        own_poses, tangents = self.motion_table.evaluate_poses(states[:, 0])
        if not self._rotors:
            return own_poses, tangents * states[:, 1, np.newaxis, np.newaxis]
        poses = np.repeat(self._initial_poses[np.newaxis], len(states), axis=0)
        velocities = np.zeros_like(poses)
        poses[:, self._own_bodies] = own_poses
        velocities[:, self._own_bodies] = tangents * states[:, 1, np.newaxis, np.newaxis]
        for index, (ratio, angle) in self._rotors.items():
            poses[:, index, 2] = ratio * states[:, StateIndex.SHAFT_ANGLE] + angle
            velocities[:, index, 2] = ratio * states[:, StateIndex.SHAFT_SPEED]
        return poses, velocities

    def contact_modes(self, solution: ReducedSolution, poses: FloatArray) -> tuple[ContactMode, ...]:
        """Return the contact modes at the times reached; empty without contacts."""
        if not self.has_contacts:
            return ()
        mechanism, n_contacts = self.motion_table.scene.mechanism, len(self.contacts)
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
        state[StateIndex.WORK] += speed_jump_work(self.evaluator, time, self._evaluate_motion(state[np.newaxis])[0][0])
        if row is not None:
            states[row, StateIndex.WORK] = state[StateIndex.WORK]


def make_start(scene: Scene, poses: FloatArray, velocities: FloatArray) -> FloatArray:
    """Return the state (N_STATES,) at poses and velocities (bodies, 3) of all bodies at the start."""
    (prefix, part), start = parts_with_coordinate(scene)[0], np.zeros(N_STATES)
    output = evaluate_output(scene.mechanism, prefix + part.mechanism.coordinate, poses)
    start[StateIndex.COORDINATE], start[StateIndex.RATE] = output.value, np.sum(output.gradient * velocities)
    for name in list(find_shaft_train(scene).motion)[:1]:
        shaft = scene.mechanism.body_index(name)
        start[StateIndex.SHAFT_ANGLE], start[StateIndex.SHAFT_SPEED] = poses[shaft, 2], velocities[shaft, 2]
    return start


def bodies_with_coordinate(scene: Scene) -> slice:
    """Return the indices of the bodies of the part that has the coordinate."""
    prefix, part = parts_with_coordinate(scene)[0]
    first = scene.mechanism.body_index(prefix + part.mechanism.bodies[0].name)
    return slice(first, first + len(part.mechanism.bodies))

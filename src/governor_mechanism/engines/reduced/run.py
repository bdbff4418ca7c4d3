"""One run of a scene through its reported times at a tolerance."""

from copy import copy
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np

from governor_mechanism.engines.certificate import StepPlan, speed_jump_work
from governor_mechanism.engines.exit_location import LastStep
from governor_mechanism.engines.initial_state import Motion
from governor_mechanism.engines.reduced import integration
from governor_mechanism.engines.reduced.integration import ReducedSettings
from governor_mechanism.engines.reduced.passage import Tail, integrate_passage
from governor_mechanism.integrators.dop853 import StepLimits
from governor_mechanism.integrators.stages import StepCounter
from governor_mechanism.integrators.step_record import IntegrationStatus
from governor_mechanism.integrators.time_grid import sort_distinct
from governor_mechanism.mechanics.contact.event_log import drop_cancelled_events, select_start_events
from governor_mechanism.mechanics.contact.rules import HELD
from governor_mechanism.mechanics.contact.scene_contacts import InputModes
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events
from governor_mechanism.mechanics.dynamics.characteristic_scales import max_step_scale
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, forced_output_names, initial_mode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.inputs import reading_tables_of
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output, evaluate_output_value
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.mechanics.reduction.motion_table import MotionTable
from governor_mechanism.mechanics.reduction.reduced_model import N_STATES, StateIndex, find_shaft_train, parts_with_coordinate
from governor_mechanism.model.events import Event
from governor_mechanism.observables.evaluation import ReadingEvaluator
from governor_mechanism.observables.run_result import StateHistory
from governor_mechanism.types import FloatArray, IntArray

INITIAL_EVENT_CAPACITY = 4096
"""Number of events for which records are allocated at first."""


@dataclass(frozen=True)
class ReducedSolution:
    """Result of one integration: times (n,) s reached, states (n, N_STATES) and modes there, events, and how and when (s) it ended.

    `stops_short` is whether the motion turns back between the end of the table and the bound of the coordinate.
    """

    times: FloatArray
    states: FloatArray
    modes: IntArray
    events: tuple[Event, ...]
    status: IntegrationStatus
    end_time: float
    side: int
    stops_short: bool
    last_step: float
    exit_step: LastStep[IntArray] | None = None

    def at(self, indices: slice | IntArray) -> "ReducedSolution":
        """Return the solution with some of its times."""
        return replace(self, times=self.times[indices], states=self.states[indices], modes=self.modes[indices])


class ReducedRun:
    """Runs of one scene from initial poses and velocities of all bodies, along a motion table."""

    def __init__(
        self, evaluator: ReadingEvaluator, initial_motion: Motion, max_steps: int, settings: ReducedSettings, width_ratio: float
    ) -> None:
        scene = evaluator.scene
        self.evaluator = evaluator
        self.max_steps = max_steps
        self.settings = settings
        prefix, part = parts_with_coordinate(scene)[0]
        self._initial_motion = initial_motion
        first_body = scene.mechanism.body_index(prefix + part.mechanism.bodies[0].name)
        self._own_bodies = slice(first_body, first_body + len(part.mechanism.bodies))
        self._rotors = {scene.mechanism.body_index(name): motion for name, motion in find_shaft_train(scene).motion.items()}
        self.start = self._make_start(prefix + part.mechanism.coordinate, *initial_motion)
        self._take_table(width_ratio)
        self.contacts, self.one_sided_springs = contacts_of(scene), one_sided_forces_of(scene)
        self._subjects = [contact.output_name for contact in self.contacts] + [spring.reading for spring in self.one_sided_springs]
        self.has_contacts, self._has_tables = bool(self._subjects), bool(reading_tables_of(scene))
        is_monitored = self.has_contacts or self._has_tables
        self._max_step = settings.max_step_ratio * max_step_scale(scene) * (settings.event_step_ratio if is_monitored else 1.0)
        self.breakpoints = sort_distinct(np.concatenate([function.breakpoints for function in self.motion_table.time_functions]))

    def _take_table(self, width_ratio: float) -> None:
        """Start a motion table, and count its steps from zero."""
        coordinate = float(self.start[StateIndex.COORDINATE])
        poses = self._initial_motion[0][self._own_bodies]
        self.motion_table = MotionTable(self.evaluator.scene, coordinate, poses, width_ratio)
        self.counts, self._step_start = np.zeros(len(StepCounter), dtype=np.int64), np.zeros(N_STATES + 1)

    def along_other_table(self, width_ratio: float) -> "ReducedRun":
        """Return runs of the same scene from the same start, along a table of their own."""
        other = copy(self)
        other._take_table(width_ratio)
        return other

    def _make_initial_mode(self) -> IntArray:
        """Return the contact mode before the search for the one at the start, with the segments of tables at the start."""
        mode = self.motion_table.model.mode.copy()
        if not self._has_tables:
            return mode
        scene, layout = self.evaluator.scene, self.motion_table.model.mode_layout
        outputs = [evaluate_output(self.evaluator.mechanism, name, self._initial_motion[0]) for name in forced_output_names(scene)]
        values = [float(output.value) for output in outputs]
        rates = [float(np.sum(one.gradient * self._initial_motion[1])) for one in outputs]
        input_modes = InputModes(scene, self.evaluator.time_scale, len(self._subjects))
        segments = input_modes.update(initial_mode(scene), 0.0, values, rates, ()).segments
        mode[layout.tables : layout.kinks] += np.array(segments, dtype=np.int64)
        return mode

    def _make_start(self, coordinate: str, poses: FloatArray, velocities: FloatArray) -> FloatArray:
        """Return the state (N_STATES,) at poses and velocities (bodies, 3) of all bodies at the start."""
        output = evaluate_output(self.evaluator.mechanism, coordinate, poses)
        start = np.zeros(N_STATES)
        start[StateIndex.COORDINATE], start[StateIndex.RATE] = output.value, np.sum(output.gradient * velocities)
        for shaft in list(self._rotors)[:1]:
            start[StateIndex.SHAFT_ANGLE] = poses[shaft, 2]
            start[StateIndex.SHAFT_SPEED] = velocities[shaft, 2]
        return start

    def integrate(
        self, times: FloatArray, tolerance: float, plan: StepPlan, event_capacity: int = INITIAL_EVENT_CAPACITY
    ) -> ReducedSolution:
        """Integrate through times (n,) s, with a plan of the steps."""
        motion_table = self.motion_table
        settings = self.settings
        time_scale = self.evaluator.time_scale
        max_step, state = self._max_step, self.start.copy()
        mode = self._make_initial_mode()
        states = np.zeros((len(times), N_STATES))
        modes = np.zeros((len(times), len(mode)), dtype=np.int64)
        event_log = make_event_log(event_capacity * self.has_contacts)
        counts = np.zeros(len(StepCounter), dtype=np.int64)
        buffers = integration.make_reduced_buffers(motion_table.model, counts)
        start_events = list[Event]()
        if self.has_contacts:
            integration.initialise_contact_mode(self._make_equation(0.0, mode, counts, tolerance), buffers, 0.0, state, event_log)
            start_events = select_start_events(make_events(event_log, self._subjects))
            event_log.counts[:] = 0
        n_filled = int(len(times) > 0 and times[0] == 0.0)
        step = settings.first_step_ratio * max_step
        status = IntegrationStatus.DONE
        time = 0.0
        side = 0
        stops_short = False
        last_time = float(times[-1]) if len(times) else 0.0
        exit_step: LastStep[IntArray] | None = None
        states[:n_filled], modes[:n_filled] = state, mode
        inner_breakpoints = self.breakpoints[(self.breakpoints > 0) & (self.breakpoints < last_time)]
        for start, end in pairwise([0.0, *inner_breakpoints.tolist(), last_time]):
            rows = slice(n_filled, int(np.searchsorted(times, end, side="right")))
            limits = StepLimits(tolerance, step, max_step, plan.max_steps, 0.0, plan.coarser_steps, plan.steps)
            arguments = times[rows], state, limits, states[rows], modes[rows], event_log
            make_equation = partial(self._make_equation, mode=mode, counts=counts, tolerance=tolerance)
            passage = integrate_passage(
                motion_table, make_equation, buffers, (start, end), *arguments, time_scale=time_scale, settings=settings
            )
            status = passage.status
            step = passage.step
            time = passage.time
            side = passage.side
            stops_short = passage.stops_short
            n_filled += passage.n_reached
            if status == IntegrationStatus.TURNED_BACK:
                step_start = start + float(self._step_start[-1])
                exit_step = LastStep(step_start, self._step_start[:-1].copy(), time, state.copy(), mode.copy())
            if passage.tail is not None:
                n_beyond = self._continue_beyond_table(passage.tail, time, times[n_filled:], states[n_filled:])
                modes[n_filled : n_filled + n_beyond] = mode
                n_filled += n_beyond
            if status != IntegrationStatus.DONE:
                break
            # The work that a jump of the given spindle speed does on the bodies; a report at that time shows the right limit.
            state[StateIndex.WORK] += speed_jump_work(self.evaluator, end, lambda: self._evaluate_motion(state[np.newaxis])[0][0])
            if n_filled and times[n_filled - 1] == end:
                states[n_filled - 1, StateIndex.WORK] = state[StateIndex.WORK]
            if self.has_contacts:
                integration.initialise_contact_mode(self._make_equation(end, mode, counts, tolerance), buffers, end, state, event_log)
        self.counts += counts
        if (n_events := int(event_log.counts[0])) > event_capacity:
            plan.steps.n_steps[0] = 0
            return self.integrate(times, tolerance, plan, 2 * n_events)
        events = drop_cancelled_events(start_events + make_events(event_log, self._subjects), SIMULTANEITY_TOLERANCE * time_scale)
        reached = slice(n_filled)
        return ReducedSolution(times[reached], states[reached], modes[reached], events, status, time, side, stops_short, step, exit_step)

    def _continue_beyond_table(self, tail: Tail, end: float, times: FloatArray, states: FloatArray) -> int:
        """Fill the states at times (s) between the last state on the table and the end of the motion (s); return how many."""
        tail_states = tail.evaluate(times[: int(np.searchsorted(times, end, side="left"))])
        count = self.motion_table.count_solved(tail_states[:, StateIndex.COORDINATE]) if len(tail_states) else 0
        states[:count] = tail_states[:count]
        return count

    def sample_exit(self, solution: ReducedSolution, last: LastStep[IntArray]) -> StateHistory:
        """Return the states at the times reached, and those at both ends of the step in which the motion leaves its range."""
        times, states = last.continue_samples(solution.times, solution.states)
        return self.state_history(replace(solution, times=times, states=states))

    def state_between(self, solution: ReducedSolution, tolerance: float, k: int, time: float) -> StateHistory | None:
        """Return the state at a time (s) after sample k of the run, or None if the integration fails; no shaft ends it."""
        last = solution.exit_step
        if last is not None and last.start <= time:
            start = last.start, last.state, last.mode
        else:
            k = min(k, len(solution.times) - 1)
            start = float(solution.times[k]), solution.states[k], solution.modes[k]
        state = self._integrate_from(*start, tolerance, time, self.max_steps, has_limits=False)
        return None if state is None else self.state_history(replace(solution, times=np.array([time]), states=state[np.newaxis]))

    def integrate_from_row(self, solution: ReducedSolution, tolerance: float, k: int, time: float) -> Motion | None:
        """Return poses and velocities (bodies, 3) at a time, s, after that of row k, integrated from that row; None on failure."""
        start = float(solution.times[k]), solution.states[k], solution.modes[k]
        state = self._integrate_from(*start, tolerance, time, self.settings.max_interpolation_steps, has_limits=True)
        if state is None:
            return None
        poses, velocities = self._evaluate_motion(state[np.newaxis])
        return poses[0], velocities[0]

    def _integrate_from(
        self, start: float, state: FloatArray, mode: IntArray, tolerance: float, time: float, max_steps: int, *, has_limits: bool
    ) -> FloatArray | None:
        """Return the state (N_STATES,) at a time, s, after a state and a mode at another one; None on failure."""
        state = state.copy()
        mode = mode.copy()
        event_log = make_event_log(0)
        counts = np.zeros(len(StepCounter), dtype=np.int64)
        equation = self._make_equation(start, mode, counts, tolerance, has_limits)
        buffers = integration.make_reduced_buffers(self.motion_table.model, counts)
        if self.has_contacts and start > 0.0 and start in self.breakpoints:
            # A row at a breakpoint has the mode before it.
            integration.initialise_contact_mode(equation, buffers, start, state, event_log)
        limits = StepLimits(tolerance, 0.01 * self.evaluator.time_scale, self._max_step, max_steps, 0.0)
        outputs = np.empty((0, len(state))), np.zeros((0, len(mode)), dtype=np.int64), event_log
        status, *_ = integration.integrate_reduced(equation, buffers, (start, time), start, np.empty(0), state, limits, *outputs, False)
        return state if status == IntegrationStatus.DONE else None

    def _make_equation(
        self, start: float, mode: IntArray, counts: IntArray, tolerance: float, has_limits: bool = True
    ) -> integration.ReducedEquation:
        """Return the equation in a contact mode, with the cubics of the inputs from a time (s) up to their next breakpoint."""
        input_cubics = stack_local_cubics(self.motion_table.time_functions, np.array([start]))[0]
        model = self.motion_table.model.on_table(self.motion_table.table, input_cubics, mode)
        if not has_limits:
            model = model._replace(parameters=model.parameters.copy())
            model.parameters["stall_ratio"] = 0.0
            model.parameters["min_rate"] = -np.inf
        equation = integration.make_reduced_equation(model, counts, tolerance)
        return equation._replace(step_start=self._step_start) if has_limits else equation

    def state_history(self, solution: ReducedSolution) -> StateHistory:
        """Return the states of all bodies at the times reached."""
        poses, velocities = self._evaluate_motion(solution.states)
        work, dissipated_energy = solution.states[:, [StateIndex.WORK, StateIndex.DISSIPATED_ENERGY]].T
        lags = np.zeros((len(poses), 0))
        return StateHistory(
            times=solution.times, poses=poses, velocities=velocities, work=work, dissipated_energy=dissipated_energy, lags=lags
        )

    def _evaluate_motion(self, states: FloatArray) -> Motion:
        """Return poses and velocities (n, bodies, 3) of all bodies in states (n, N_STATES)."""
        own_poses, tangents = self.motion_table.evaluate_poses(states[:, StateIndex.COORDINATE])
        flat_tangents = tangents.reshape(len(tangents), 3 * tangents.shape[1])
        own_velocities = (flat_tangents * states[:, StateIndex.RATE, np.newaxis]).reshape(tangents.shape)
        if not self._rotors:
            return own_poses, own_velocities
        poses = np.repeat(self._initial_motion[0][np.newaxis], len(states), axis=0)
        velocities = np.zeros_like(poses)
        poses[:, self._own_bodies] = own_poses
        velocities[:, self._own_bodies] = own_velocities
        for index, (ratio, angle) in self._rotors.items():
            poses[:, index, 2] = ratio * states[:, StateIndex.SHAFT_ANGLE] + angle
            velocities[:, index, 2] = ratio * states[:, StateIndex.SHAFT_SPEED]
        return poses, velocities

    def contact_modes(self, solution: ReducedSolution, poses: FloatArray) -> tuple[ContactMode, ...]:
        """Return the contact modes at the times reached; empty without contacts."""
        if not self.has_contacts and not self._has_tables:
            return ()
        layout = self.motion_table.model.mode_layout
        first_mode = self.motion_table.model.mode
        first_segments = first_mode[layout.tables : layout.kinks].tolist()
        mechanism, n_contacts = self.evaluator.mechanism, len(self.contacts)
        values = [evaluate_output_value(mechanism, contact.output_name, poses) for contact in self.contacts]
        contact_modes = list[ContactMode]()
        rows = solution.modes
        is_new = np.any(rows[1:] != rows[:-1], axis=1) | np.any(rows[1:, 1:] == HELD, axis=1)  # a held value is that of its time
        for index in [0, *(1 + np.flatnonzero(is_new)).tolist()] if len(rows) else []:
            contact_modes += contact_modes[-1:] * (index - len(contact_modes))
            is_held, *states = rows[index].tolist()
            held_values = tuple(float(value[index]) if state == HELD else None for value, state in zip(values, states, strict=False))
            sliding_signs = tuple(0 if state == HELD else state for state in states[:n_contacts])
            taut = tuple(map(bool, states[n_contacts : n_contacts + len(self.one_sided_springs)]))
            segments = tuple(one - first for one, first in zip(states[len(self._subjects) :], first_segments, strict=False))
            contact_modes.append(ContactMode(held_values, sliding_signs, taut, bool(is_held), segments))
        return (*contact_modes, *contact_modes[-1:] * (len(rows) - len(contact_modes)))

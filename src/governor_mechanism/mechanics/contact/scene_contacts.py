"""Contacts of a scene in its multibody state: their motion, their mode, and the events so far."""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.contact.event_log import select_start_events
from governor_mechanism.mechanics.contact.impacts import dissipated_by_impulses
from governor_mechanism.mechanics.contact.rules import (
    HELD,
    ContactDynamics,
    compute_violation,
    find_active_stop,
    has_normal_friction,
    is_locked,
    is_resting,
    solve_forces,
)
from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE, JAM_VIOLATION, SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events, make_transition
from governor_mechanism.mechanics.dynamics.arrays import System, SystemWorkspace, make_system_workspace
from governor_mechanism.mechanics.dynamics.constrained_solution import project_state, solve_constrained_system
from governor_mechanism.mechanics.dynamics.contact_modes import ContactMode, forced_output_names, initial_mode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of, make_contact_table, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import evaluate_state_derivative
from governor_mechanism.mechanics.dynamics.inputs import output_rate, reading_tables_of
from governor_mechanism.mechanics.dynamics.lowering import make_system, multibody_input_layout, with_held_values
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_rows
from governor_mechanism.mechanics.kinematics.constraint_rows import RowColumn
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.jit import jit
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import GROUND_INDEX, NO_INDEX, BoolArray, FloatArray, RecordArray


class InputModes:
    """Tables of readings and breaking gears of a scene.

    Parameters
    ----------
    scene
        The scene.
    time_scale
        Its characteristic time, s.
    first_index
        Index of the first table among contacts, one-sided springs and tables.
    """

    def __init__(self, scene: Scene, time_scale: float, first_index: int) -> None:
        self._tables, self._first_index, self._breaking_gears = reading_tables_of(scene), first_index, scene.system.breaking_gears
        names = forced_output_names(scene)
        outputs = [(table.source, table.is_rate) for table in self._tables]
        self._outputs = [(names.index(name), is_rate) for name, is_rate in outputs]
        scales = [scene.mechanism.output_scale(name) / (time_scale if is_rate else 1.0) for name, is_rate in outputs]
        self._tolerances = [CONTACT_TOLERANCE * scale for scale in scales]

    @property
    def is_fixed(self) -> bool:
        """Whether there is nothing to update."""
        return not (self._tables or self._breaking_gears)

    def update(
        self,
        mode: ContactMode,
        time: float,  # time, s
        values: Sequence[float],  # values of the outputs; shape (outputs,)
        rates: Sequence[float],  # their rates; shape (outputs,)
        triggered: Collection[int],  # indices of the contacts, springs and tables whose events occur now
    ) -> ContactMode:
        """Return a mode with the segments at a state, and with the gears that have broken."""
        segments = [self._segment(k, mode.segments[k], values, rates, self._first_index + k in triggered) for k in range(len(self._tables))]
        broken = tuple(name for name, end in self._breaking_gears.items() if time >= end)
        return replace(mode, segments=tuple(segments), broken=broken)

    def _segment(self, k: int, current: int, values: Sequence[float], rates: Sequence[float], is_triggered: bool) -> int:
        """Return the segment of a table; at a kink it is the one that the motion enters."""
        index, is_rate = self._outputs[k]
        positions = self._tables[k].positions
        value = rates[index] if is_rate else values[index]
        kinks = [i for i, position in enumerate(positions) if abs(value - position) <= self._tolerances[k]]
        if not kinks:
            return sum(value > position for position in positions)
        if is_triggered:
            return kinks[0] + (current <= kinks[0])
        if is_rate:
            return current if current - kinks[0] in (0, 1) else kinks[0]
        return kinks[0] + (rates[index] > 0.0)


ContactModeKey = tuple[tuple[int | None, ...], tuple[int, ...], tuple[bool, ...], bool, tuple[int, ...], tuple[str, ...]]
"""Properties shared by modes whose systems differ only in the held values: at which stop each contact holds, and the other fields."""


@once_per_object
def _systems_by_mode(scene: Scene) -> dict[ContactModeKey, System]:
    """Return the systems of the modes in which a scene was so far; the held values are those of the first time."""
    return {}


class ContactResponse(NamedTuple):
    """Motion of the outputs, and what unit impulses along those with contacts do."""

    motion: FloatArray  # values, rates and accelerations of the outputs; shape (3, outputs)
    friction_limits: FloatArray  # friction forces, N or N m; shape (contacts,)
    velocity_changes: FloatArray  # changes of the velocities of all bodies; shape (contacts, bodies, 3)
    compliance: FloatArray  # changes of the rates of the outputs with contacts; shape (contacts, contacts)
    drive_work: FloatArray  # work of the drives, J; shape (contacts,)


@jit
def _evaluate_response(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, state: FloatArray, contacts: RecordArray
) -> ContactResponse:
    """Evaluate motion and response in a state of a system in which nothing is held and nothing slides."""
    derivative = np.empty(state.size)
    evaluate_state_derivative(system, workspace, input_cubics, 0.0, state, derivative)
    layout = system.state_layout
    poses = state[: layout.velocities].reshape(-1, 3)
    velocities = state[layout.velocities : layout.work].reshape(-1, 3)
    accelerations = derivative[layout.velocities : layout.work].reshape(-1, 3)
    output_rows = system.output_rows
    output_values = workspace.output_row_values
    jacobian = workspace.output_jacobian
    evaluate_rows(output_rows, poses, velocities, output_values, jacobian)
    motion, n_contacts = np.empty((3, output_rows.table.size)), contacts.shape[0]
    for output in range(output_rows.table.size):
        motion[0, output] = output_values[output, RowColumn.RESIDUAL]
        motion[1, output] = output_rate(output_rows, jacobian, output, velocities)
        motion[2, output] = output_rate(output_rows, jacobian, output, accelerations) - output_values[output, RowColumn.GAMMA]
    friction_limits, drive_work = np.empty(n_contacts), np.zeros(n_contacts)
    velocity_changes = np.zeros((n_contacts, system.bodies.size, 3))
    compliance = np.empty((n_contacts, n_contacts))
    for k in range(n_contacts):
        friction_input = contacts[k].friction_input
        friction_limits[k] = workspace.inputs[friction_input] if friction_input != NO_INDEX else 0.0
        output, impulse = contacts[k].output_index, np.zeros((system.bodies.size, 3))
        for side in range(2):
            body = output_rows.row_bodies[output, side]
            if body != GROUND_INDEX:
                impulse[body] += jacobian[output, side]
        solve_constrained_system(system, workspace, impulse, 0.0, velocity_changes[k])
        for i in range(workspace.multipliers.size):
            drive_work[k] -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
        for i in range(n_contacts):
            compliance[i, k] = output_rate(output_rows, jacobian, contacts[i].output_index, velocity_changes[k])
    return ContactResponse(motion, friction_limits, velocity_changes, compliance, drive_work)


class SceneContacts:
    """Contacts and one-sided springs of a scene in the course of a run: their mode, its system, and the events so far.

    Parameters
    ----------
    scene
        Scene of one part.
    time_scale
        Characteristic time, s.
    constraint_tolerance
        Residual below which a joint is closed, m.

    Attributes
    ----------
    contacts
        As made by `make_contact_table`; shape (contacts,).
    input_functions
        Inputs of the multibody model.
    mobility
        Number of degrees of freedom, without those that are driven and those of free shafts.
    mode
        Contact mode of the last transition.
    rest_values
        Value at which each contact came to rest, m or rad; NaN where it moves; shape (contacts,).
    events
        Events so far.
    is_jammed
        Whether friction leaves the contacts no consistent state at the last transition.
    """

    def __init__(self, scene: Scene, time_scale: float, constraint_tolerance: float) -> None:
        mechanism = scene.mechanism
        names = forced_output_names(scene)
        contacts = contacts_of(scene)
        position_solver, springs = PositionSolver(mechanism), one_sided_forces_of(scene)
        _, self.input_functions = make_system(scene)
        self.contacts = make_contact_table(scene, names, multibody_input_layout(scene).friction_inputs)
        self._outputs = self.contacts["output_index"]
        self._lows, self._highs = self.contacts["low"].tolist(), self.contacts["high"].tolist()
        self._subjects = [contact.output_name for contact in contacts] + [spring.reading for spring in springs]
        self._scene = scene
        self._time_scale = time_scale
        self._constraint_tolerance = constraint_tolerance
        self._energy_scale = sum(body.mass for body in mechanism.bodies) * (mechanism.length_scale / time_scale) ** 2
        self.mobility = position_solver.mobility - mechanism.count_free_shafts()
        self._is_driven = bool(position_solver.equations.is_driven.any())
        self._input_modes = InputModes(scene, time_scale, len(self._subjects))
        self._spring_outputs = [names.index(spring.reading) for spring in springs]
        self._free_values = np.array([spring.slack_below for spring in springs])
        self._spring_scales = np.array([mechanism.output_scale(spring.reading) for spring in springs])
        self._models: dict[ContactModeKey, tuple[ContactMode, System, SystemWorkspace]] = {}
        self.events = list[Event]()
        self._has_rubbing, self.is_jammed = has_normal_friction(self.contacts), False
        self.continue_from(initial_mode(scene))

    def continue_from(self, mode: ContactMode) -> None:
        """Take a mode as that of the last transition, and forget the events."""
        self.mode = mode
        self.rest_values = np.array([np.nan if held is None else held for held in mode.held_values])
        self._states = np.where(np.isnan(self.rest_values), mode.sliding_signs, HELD).astype(np.int64)
        self._segments = np.array(mode.taut, dtype=np.int64)
        self._released_at, self._released = -math.inf, set[int]()
        self.is_jammed = False
        self.events.clear()

    @property
    def model(self) -> tuple[System, SystemWorkspace]:
        """System of the current mode, in which held outputs are constraints, and its workspace."""
        return self._get_model(self.mode)

    def start(
        self,
        state: FloatArray,  # state vector of the multibody model; impacts change it in place
        input_cubics: FloatArray,  # local cubics of all inputs from the start on; shape (inputs, 5)
    ) -> None:
        """Select the mode at the start of a run, with strikes as its only events."""
        self.continue_from(initial_mode(self._scene))
        self.change_mode(0.0, state, input_cubics)
        self.events = select_start_events(self.events)

    def change_mode(
        self,
        time: float,  # time of the state, s
        state: FloatArray,
        input_cubics: FloatArray,  # local cubics of all inputs from that time on; shape (inputs, 5)
        # contacts and springs that have an event; those of them that are held can hold no longer
        triggered: Collection[int] = (),
        # contacts whose rates an approximate state gives only roughly, and which are at rest
        stopped: Collection[int] = (),
    ) -> None:
        """Select the contact mode at a time; impacts change the state in place."""
        released = {k for k in triggered if k < len(self.contacts) and not np.isnan(self.rest_values[k])}
        if time - self._released_at <= SIMULTANEITY_TOLERANCE * self._time_scale:
            released |= self._released  # else two redundant contacts could hold in turns without end
        self._released_at, self._released = time, released
        self._state, self._input_cubics = state, input_cubics
        log = make_event_log(3 * len(self._subjects))
        is_released = self._mask(released)
        is_stopped = self._mask(stopped)
        if not self._input_modes.is_fixed:
            self.evaluate_dynamics()
            values, rates, _ = self._response.motion.tolist()
            self.mode = self._input_modes.update(self.mode, time, values, rates, triggered)
        if stopped:
            dynamics = self.evaluate_dynamics()
            self.apply_impulses(dynamics, solve_forces(dynamics, is_stopped, -dynamics.rates))
        dynamics = _change_contact_states(self, self._states, self._segments, is_released, time, log)
        self.is_jammed = self._has_rubbing and compute_violation(dynamics, self._states) > JAM_VIOLATION
        self.events += make_events(log, self._subjects)
        self.rest_values, is_held = self._find_rest_values(dynamics), self._states == HELD
        self.mode = replace(
            self.mode,
            held_values=tuple(value if holds else None for value, holds in zip(self.rest_values.tolist(), is_held.tolist(), strict=True)),
            sliding_signs=tuple(np.where(is_held, 0, self._states).tolist()),
            taut=tuple(map(bool, self._segments)),
            is_locked=is_locked(dynamics, self._states),
        )
        # The velocity that this removes is rounding.
        poses, velocities = state[: self.model[0].state_layout.work].reshape(2, -1, 3)
        project_state(*self.model, input_cubics, 0.0, poses, velocities, self._constraint_tolerance)

    def _mask(self, contacts: Collection[int]) -> BoolArray:
        """Return which contacts are among those of given indices."""
        mask = np.zeros(len(self.contacts), dtype=bool)
        mask[[k for k in contacts if k < len(mask)]] = True
        return mask

    def evaluate_dynamics(self) -> ContactDynamics:
        """Evaluate the motion of the contacts in the state of the transition."""
        taut, mode = tuple(map(bool, self._segments)), self.mode
        free_mode = replace(initial_mode(self._scene), taut=taut, segments=mode.segments, broken=mode.broken)
        self._response = _evaluate_response(*self._get_model(free_mode), self._input_cubics, self._state, self.contacts)
        values, rates, accelerations = self._response.motion
        outputs = self._outputs
        return ContactDynamics(
            contacts=self.contacts,
            values=np.where(np.isnan(self.rest_values), values[outputs], self.rest_values),  # an output at rest does not creep
            rates=rates[outputs],
            accelerations=accelerations[outputs],
            compliance=self._response.compliance,
            friction_limits=self._response.friction_limits,
            stretches=(values[self._spring_outputs] - self._free_values) / self._spring_scales,
            stretch_rates=rates[self._spring_outputs] / self._spring_scales,
            time_scale=self._time_scale,
            energy_scale=self._energy_scale,
            mobility=self.mobility,
            is_driven=self._is_driven,
        )

    def apply_impulses(
        self,
        dynamics: ContactDynamics,
        impulses: FloatArray,  # impulses, N s or N m s; shape (contacts,)
    ) -> None:
        """Change the state of the transition by impulses along the outputs with contacts."""
        changes = self._response.velocity_changes.reshape(len(impulses), -1)
        layout = self.model[0].state_layout
        dissipated_energy = dissipated_by_impulses(dynamics, impulses)
        self._state[layout.velocities : layout.work] += impulses @ changes
        self._state[layout.work] += dissipated_energy - impulses @ self._response.drive_work
        self._state[layout.dissipated_energy] += dissipated_energy

    def _get_model(self, mode: ContactMode) -> tuple[System, SystemWorkspace]:
        """Return the system of a contact mode and its workspace."""
        holds = tuple(
            None if held is None else int(held >= high) - int(held <= low)
            for held, low, high in zip(mode.held_values, self._lows, self._highs, strict=True)
        )
        key = holds, mode.sliding_signs, mode.taut, mode.is_locked, mode.segments, mode.broken
        known_mode, system, workspace = self._models.get(key) or (None, *self._make_model(key, mode))
        if known_mode != mode:
            system = with_held_values(system, self._outputs.tolist(), mode)
            self._models[key] = mode, system, workspace
        return system, workspace

    def _make_model(self, key: ContactModeKey, mode: ContactMode) -> tuple[System, SystemWorkspace]:
        """Return the system of a mode, which later runs of the scene take over, and a workspace of this run."""
        systems = _systems_by_mode(self._scene)
        if key not in systems:
            systems[key] = make_system(self._scene, mode)[0]
        return systems[key], make_system_workspace(systems[key])

    def _find_rest_values(self, dynamics: ContactDynamics) -> FloatArray:
        """Return where the contacts rest: at a stop that they touch, else where they are."""
        rest_values = np.full(len(self.contacts), np.nan)
        for k, contact in enumerate(self.contacts):
            if is_resting(dynamics, self._states, k):
                side = find_active_stop(dynamics, k)
                rest_values[k] = contact["high" if side > 0 else "low"] if side else dynamics.values[k]
        return rest_values


_change_contact_states = make_transition(SceneContacts.evaluate_dynamics, SceneContacts.apply_impulses)

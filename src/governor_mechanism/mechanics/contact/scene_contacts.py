"""Contacts of a scene in its multibody state: their motion, their mode, and the events so far."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from governor_mechanism.mechanics.contact.rules import (
    HELD,
    ContactDynamics,
    dissipated_by_impulses,
    find_active_stop,
    is_locked,
    is_resting,
)
from governor_mechanism.mechanics.contact.transition import make_event_log, make_events, make_transition
from governor_mechanism.mechanics.dynamics.constraint_solver import apply_jacobian, subtract_minv_jt
from governor_mechanism.mechanics.dynamics.contacts import (
    ContactColumn,
    ContactMode,
    contacts_of,
    initial_mode,
    make_contact_table,
    output_springs_of,
)
from governor_mechanism.mechanics.dynamics.equations_of_motion import N_AUXILIARY_STATES, evaluate_state_derivative, split_state
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace, forced_output_names, make_system, make_system_workspace
from governor_mechanism.mechanics.dynamics.output_forces import output_rate
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_kernels import RowColumn, evaluate_rows
from governor_mechanism.mechanics.kinematics.input_kernels import evaluate_input
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.banded_cholesky import solve_band_system
from governor_mechanism.numerics.jit import jit
from governor_mechanism.types import FloatArray


class ContactResponse(NamedTuple):
    """Motion of the outputs, and what unit impulses along those with contacts do.

    Attributes
    ----------
    motion
        Values, rates and accelerations of the outputs; shape (3, outputs).
    friction_limits
        Friction forces, N or N m; shape (contacts,).
    velocity_changes
        Changes of the velocities of all bodies; shape (contacts, bodies, 3).
    compliance
        Changes of the rates of the outputs with contacts; shape (contacts, contacts).
    drive_work
        Work of the drives, J; shape (contacts,).
    """

    motion: FloatArray
    friction_limits: FloatArray
    velocity_changes: FloatArray
    compliance: FloatArray
    drive_work: FloatArray


@jit
def _evaluate_response(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, state: FloatArray, contacts: FloatArray
) -> ContactResponse:
    """Evaluate motion and response in a state of a system in which nothing is held and nothing slides."""
    derivative = evaluate_state_derivative(system, workspace, input_cubics, 0.0, state)
    poses, velocities = split_state(system, state)
    accelerations = split_state(system, derivative)[1]
    rows, output_rows, output_values = system.constraint_rows, system.output_rows, workspace.output_row_values
    evaluate_rows(output_rows, poses, velocities, output_values, workspace.output_jacobian)
    motion, n_contacts = np.empty((3, output_rows.table.size)), contacts.shape[0]
    for output in range(output_rows.table.size):
        motion[0, output] = output_values[output, RowColumn.RESIDUAL]
        motion[1, output] = output_rate(output_rows, workspace.output_jacobian, output, velocities)
        motion[2, output] = (
            output_rate(output_rows, workspace.output_jacobian, output, accelerations) - output_values[output, RowColumn.GAMMA]
        )
    friction_limits, drive_work = np.empty(n_contacts), np.zeros(n_contacts)
    velocity_changes, compliance = np.zeros((n_contacts, system.bodies.size, 3)), np.empty((n_contacts, n_contacts))
    for k in range(n_contacts):
        friction_limits[k] = evaluate_input(input_cubics, int(contacts[k, ContactColumn.FRICTION_INPUT]), 0.0)
        output, change = int(contacts[k, ContactColumn.OUTPUT]), velocity_changes[k]
        for side in range(2):
            body = output_rows.row_bodies[output, side]
            if body >= 0:
                for c in range(3):
                    change[body, c] += system.inverse_mass[body, c] * workspace.output_jacobian[output, side, c]
        apply_jacobian(rows.row_bodies, workspace.jacobian, change, workspace.multipliers)
        solve_band_system(workspace.band, workspace.factor, workspace.multipliers)
        subtract_minv_jt(rows.row_bodies, workspace.jacobian, system.inverse_mass, workspace.multipliers, change)
        for i in range(workspace.multipliers.size):
            drive_work[k] -= workspace.multipliers[i] * workspace.row_values[i, RowColumn.DRIVE_RATE]
        for i in range(n_contacts):
            compliance[i, k] = output_rate(output_rows, workspace.output_jacobian, int(contacts[i, ContactColumn.OUTPUT]), change)
    return ContactResponse(motion, friction_limits, velocity_changes, compliance, drive_work)


class SceneContacts:
    """Contacts and one-sided springs of a scene in the course of a run, and their events so far.

    Parameters
    ----------
    scene
        Scene of one part.
    time_scale
        Characteristic time, s.

    Attributes
    ----------
    contacts
        As made by `make_contact_table`; shape (contacts, 6).
    subjects
        Readings of the contacts, then of the one-sided springs.
    input_functions
        Inputs of the multibody model.
    mode
        Contact mode of the last transition.
    rest_values
        Value at which each contact came to rest, m or rad; NaN where it moves; shape (contacts,).
    events
        Events so far.
    """

    def __init__(self, scene: Scene, time_scale: float) -> None:
        mechanism, names = scene.part.mechanism, forced_output_names(scene)
        position_solver, springs = PositionSolver(mechanism), [spring for spring in output_springs_of(scene) if spring.one_sided]
        self.input_functions = make_system(scene)[1]
        n_frictions = sum(contact.friction is not None for contact in contacts_of(scene))
        self.contacts = make_contact_table(scene, names, len(self.input_functions) - n_frictions)
        self.subjects = [contact.output_name for contact in contacts_of(scene)] + [spring.reading for spring in springs]
        self._scene, self._time_scale = scene, time_scale
        self._energy_scale = sum(body.mass for body in mechanism.bodies) * (mechanism.length_scale / time_scale) ** 2
        self._mobility, self._is_driven = position_solver.mobility, bool(position_solver.equations.is_driven.any())
        self._spring_outputs = [names.index(spring.reading) for spring in springs]
        self._free_values = np.array([spring.free_value for spring in springs])
        self._spring_scales = np.array([mechanism.output_scale(spring.reading) for spring in springs])
        self._models: dict[tuple[bool, ...], tuple[System, SystemWorkspace]] = {}
        self.events = list[Event]()
        self.reset()

    def reset(self) -> None:
        """Begin a run: nothing is held, nothing slides, all one-sided springs are slack, and there are no events."""
        self.mode = initial_mode(self._scene)
        self._states, self._segments = (np.zeros(n, dtype=np.int64) for n in (len(self.contacts), len(self._spring_outputs)))
        self.rest_values = np.full(len(self.contacts), np.nan)
        self.events.clear()

    @property
    def system(self) -> System:
        """Arrays of the multibody model in which nothing is held or slides."""
        return self._get_model()[0]

    def change_mode(self, time: float, state: FloatArray, input_cubics: FloatArray, released: Collection[int] = ()) -> None:
        """Select the contact mode at a time; impacts change the state in place.

        Parameters
        ----------
        time
            Time of the state, s.
        state
            State vector of the multibody model.
        input_cubics
            Local cubics of all inputs from that time on; shape (inputs, 5).
        released
            Contacts that cannot hold.
        """
        self._state, self._input_cubics = state, input_cubics
        log, is_released = make_event_log(3 * len(self.subjects)), np.isin(np.arange(len(self.contacts)), list(released))
        dynamics = _change_contact_states(self, self._states, self._segments, is_released, time, log)
        self.events += make_events(log, self.subjects)
        self.rest_values = self._find_rest_values(dynamics)
        sliding_signs, is_held = np.where(self._states == HELD, 0, self._states), (self._states == HELD).tolist()
        self.mode = ContactMode(
            tuple(value if holds else None for value, holds in zip(self.rest_values.tolist(), is_held, strict=True)),
            tuple(sliding_signs.tolist()),
            tuple(map(bool, self._segments)),
            is_locked(dynamics, self._states),
        )

    def evaluate_dynamics(self) -> ContactDynamics:
        """Evaluate the motion of the contacts in the state of the transition.

        Returns
        -------
        ContactDynamics
            The motion.
        """
        system, workspace = self._get_model()
        self._response = _evaluate_response(system, workspace, self._input_cubics, self._state, self.contacts)
        values, rates, accelerations = self._response.motion
        outputs = self.contacts[:, ContactColumn.OUTPUT].astype(int)
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
            mobility=self._mobility,
            is_driven=self._is_driven,
        )

    def apply_impulses(self, dynamics: ContactDynamics, impulses: FloatArray) -> None:
        """Change the state of the transition by impulses along the outputs with contacts.

        Parameters
        ----------
        dynamics
            Motion of the contacts before.
        impulses
            Impulses, N s or N m s; shape (contacts,).
        """
        changes = self._response.velocity_changes.reshape(len(impulses), -1)
        n_coordinates = changes.shape[1]
        self._state[n_coordinates : 2 * n_coordinates] += impulses @ changes
        dissipated_energy = dissipated_by_impulses(dynamics, impulses)
        self._state[-N_AUXILIARY_STATES] += dissipated_energy - impulses @ self._response.drive_work
        self._state[-N_AUXILIARY_STATES + 1] += dissipated_energy

    def _get_model(self) -> tuple[System, SystemWorkspace]:
        """Return the system in which nothing is held or slides, with the present segments of the springs, and its workspace."""
        taut = tuple(map(bool, self._segments))
        if taut not in self._models:
            system = make_system(self._scene, replace(initial_mode(self._scene), taut=taut))[0]
            self._models[taut] = system, make_system_workspace(system)
        return self._models[taut]

    def _find_rest_values(self, dynamics: ContactDynamics) -> FloatArray:
        """Return where the contacts rest: at a stop that they touch, else where they are."""
        rest_values = np.full(len(self.contacts), np.nan)
        for k, contact in enumerate(self.contacts):
            if is_resting(dynamics, self._states, k):
                side = find_active_stop(dynamics, k)
                rest_values[k] = contact[ContactColumn.HIGH if side > 0 else ContactColumn.LOW] if side else dynamics.values[k]
        return rest_values


_change_contact_states = make_transition(SceneContacts.evaluate_dynamics, SceneContacts.apply_impulses)

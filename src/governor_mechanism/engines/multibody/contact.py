"""Contact modes of one scene: which mode follows an event, by complementarity, and the impacts at stops.

A contact is a reading that dry friction or stops may hold. At rest it is held while the holding force is within the
friction limit, or pushes away from the stop; otherwise it slides in the direction of the net force. At a stop its rate is
reversed by the coefficient of restitution.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.mechanics.contact.tolerances import (
    CONTACT_TOLERANCE,
    MIN_REBOUND_HEIGHT,
    REST_TOLERANCE,
    SIMULTANEITY_TOLERANCE,
    STICTION_RATE_TOLERANCE,
    zeno_time,
)
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, initial_mode, output_springs_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import (
    MAX_STAND_IN_ITERATIONS,
    N_AUXILIARY_STATES,
    evaluate_events_and_derivative,
    project_state,
)
from governor_mechanism.mechanics.dynamics.lowering import (
    System,
    SystemWorkspace,
    forced_output_names,
    make_system,
    make_system_workspace,
    with_held_values,
)
from governor_mechanism.mechanics.dynamics.output_forces import EventFunctionKind
from governor_mechanism.mechanics.kinematics.assembly import PositionSolver
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_gamma, evaluate_jacobian, evaluate_residuals
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray, RecordArray

MODE_CONSISTENCY_TOLERANCE = 1e-9
"""Largest violation of a consistent contact mode, relative to the scales of force and acceleration."""

TURNING_POINT_ACCELERATION_TOLERANCE = 1e-6
"""Largest acceleration of a held output, in length scales (or rad) per time scale squared, that is rounding."""


ContactModeKey = tuple[tuple[int | None, ...], tuple[int, ...], tuple[bool, ...], bool]
"""Properties shared by modes whose systems differ only in the held values."""


@dataclass(frozen=True)
class OutputState:
    """Values (outputs,), rates (outputs,) and gradients (outputs, bodies, 3) of all output variables at a state."""

    values: list[float]
    rates: list[float]
    gradients: FloatArray


class ContactModeSolver:
    """Contact mode of one scene in the course of a run, and the events so far."""

    def __init__(self, scene: Scene, time_scale: float, constraint_tolerance: float) -> None:
        self.scene, self._time_scale, self._constraint_tolerance = scene, time_scale, constraint_tolerance
        self.contacts, names = contacts_of(scene), forced_output_names(scene)
        self.one_sided_springs = [spring for spring in output_springs_of(scene) if spring.one_sided]
        self._output_indices = [names.index(contact.output_name) for contact in self.contacts]
        self._spring_output_indices = [names.index(spring.reading) for spring in self.one_sided_springs]
        mechanism = scene.part.mechanism
        self._coordinate_scales = [mechanism.output_scale(name) for name in names]
        self._joint_rows = make_system(scene)[0].constraint_rows
        position_solver = PositionSolver(mechanism)
        self._mobility, self._is_driven = position_solver.mobility, bool(position_solver.equations.is_driven.any())
        self._models: dict[ContactModeKey, tuple[ContactMode, System, SystemWorkspace]] = {}
        self.mode, self.events = initial_mode(scene), list[Event]()
        self._released_at, self._released = -math.inf, set[int]()

    def get_model(self, mode: ContactMode) -> tuple[System, SystemWorkspace]:
        """Return the system of a contact mode and its workspace."""
        key = (
            tuple(self._classify_hold(k, held) for k, held in enumerate(mode.held_values)),
            mode.sliding_signs,
            mode.taut,
            mode.is_locked,
        )
        if key not in self._models:
            system = make_system(self.scene, mode)[0]
            self._models[key] = mode, system, make_system_workspace(system)
        built_mode, system, workspace = self._models[key]
        if built_mode != mode:
            self._models[key] = mode, with_held_values(system, self._output_indices, mode), workspace
        return self._models[key][1:]

    def _classify_hold(self, k: int, held: float | None) -> int | None:
        """Return where a contact is held: at the high stop (1), at the low stop (-1), in between (0), or None if it is free."""
        if held is None:
            return None
        return 1 if held >= self.contacts[k].high else -1 if held <= self.contacts[k].low else 0

    @property
    def system(self) -> System:
        """Return the system of the current mode."""
        return self.get_model(self.mode)[0]

    @property
    def workspace(self) -> SystemWorkspace:
        """Return the workspace of the current mode's system."""
        return self.get_model(self.mode)[1]

    def initialize(self, state: FloatArray, input_cubics: FloatArray) -> None:
        """Select the initial mode and clear the events."""
        self.mode, self.events = initial_mode(self.scene), []
        self._released_at, self._released = -math.inf, set[int]()
        self.select_mode(0.0, state, input_cubics)
        self.events = []

    def select_mode(self, time: float, state: FloatArray, input_cubics: FloatArray, triggered: Sequence[int] = ()) -> None:
        """Select the mode after events of the contacts or springs `triggered`; impacts change the state in place.

        input_cubics count from `time` (s), the time of the state. Modes are enumerated; the first consistent one is taken,
        else the one with the least violation.
        """
        previous_mode = self.mode
        self._update_one_sided_springs(time, state)
        released = self._update_released(
            time, {k for k in triggered if k < len(self.contacts) and previous_mode.held_values[k] is not None}
        )
        rest_times = self._apply_impacts(time, state, input_cubics)
        outputs = self._evaluate_outputs(state)
        candidates = [list(self._list_candidates(k, outputs, k in released)) for k in range(len(self.contacts))]
        best_mode, least_violation = None, math.inf
        for choice in itertools.product(*candidates):
            n_held = sum(held is not None for held, _ in choice)
            if n_held > self._mobility:
                continue  # redundant: fewer held contacts, one at its force limit, describe the same motion with determinate forces
            is_at_rest = n_held == self._mobility and not self._is_driven
            mode = ContactMode(tuple(held for held, _ in choice), tuple(sign for _, sign in choice), self.mode.taut, is_at_rest)
            violation = self._compute_violation(mode, state, input_cubics)
            if violation < least_violation:
                best_mode, least_violation = mode, violation
            if least_violation <= MODE_CONSISTENCY_TOLERANCE:
                break
        if best_mode is not None:
            self.mode = best_mode
        self._project_onto_mode(state, input_cubics)
        self._record_events(time, state, previous_mode, rest_times)

    def _update_released(self, time: float, released: set[int]) -> set[int]:
        """Return the contacts released at this event time.

        Excluding them prevents cycling between two redundant contacts.
        """
        if time - self._released_at <= SIMULTANEITY_TOLERANCE * self._time_scale:
            released = released | self._released
        self._released_at, self._released = time, released
        return released

    def _update_one_sided_springs(self, time: float, state: FloatArray) -> None:
        """Update which one-sided springs are taut."""
        if not self.one_sided_springs:
            return
        outputs, taut = self._evaluate_outputs(state), list(self.mode.taut)
        for k, (spring, output_index) in enumerate(zip(self.one_sided_springs, self._spring_output_indices, strict=True)):
            extension = outputs.values[output_index] - spring.free_value
            is_near_slack = abs(extension) < CONTACT_TOLERANCE * self._coordinate_scales[output_index]
            taut[k] = outputs.rates[output_index] > 0 if is_near_slack else extension > 0
            if taut[k] != self.mode.taut[k]:
                self.events.append(Event(time=time, kind=EventKind.TAUT if taut[k] else EventKind.SLACK, subject=spring.reading))
        self.mode = replace(self.mode, taut=tuple(taut))

    def _apply_impacts(self, time: float, state: FloatArray, input_cubics: FloatArray) -> dict[int, float]:
        """Reverse the rates of contacts that strike a stop; return for those whose bouncing ends when (s) it ends."""
        rest_times: dict[int, float] = {}
        for _ in range(2 * len(self.contacts)):
            outputs = self._evaluate_outputs(state)
            impacting = [
                k
                for k, contact in enumerate(self.contacts)
                if self._find_active_stop(k, outputs) * outputs.rates[self._output_indices[k]] > self._rest_rate(k)
            ]
            if not impacting:
                break
            resting = [
                k
                for k, held in enumerate(self.mode.held_values)
                if held is not None and k not in impacting and self._find_active_stop(k, outputs)
            ]
            rebound_rates = {k: -self.contacts[k].restitution * outputs.rates[self._output_indices[k]] for k in impacting}
            self._apply_impulses(state, outputs, rebound_rates | dict.fromkeys(resting, 0.0))
            for k in impacting:
                self.events.append(Event(time=time, kind=EventKind.IMPACT, subject=self.contacts[k].output_name))
            rest_times |= self._settle_final_bounces(time, state, input_cubics, impacting)
        return rest_times

    def _settle_final_bounces(self, time: float, state: FloatArray, input_cubics: FloatArray, impacted: Sequence[int]) -> dict[int, float]:
        """Stop the contacts that bounce no higher than the limit; return when (s) their bounces would end."""
        rest_times: dict[int, float] = {}
        outputs = self._evaluate_outputs(state)
        departing_accelerations, returning_accelerations = (
            self._evaluate_sliding_accelerations(state, input_cubics, outputs, impacted, direction) for direction in (1, -1)
        )
        for k in impacted:
            index, stop_side, restitution = self._output_indices[k], self._find_active_stop(k, outputs), self.contacts[k].restitution
            rebound_speed, return_acceleration = -stop_side * outputs.rates[index], stop_side * departing_accelerations[index]
            max_rebound_height = MIN_REBOUND_HEIGHT * self._coordinate_scales[index]
            is_leaving = restitution < 1 and return_acceleration > 0 and rebound_speed > 0
            if is_leaving and rebound_speed**2 < 2 * return_acceleration * max_rebound_height:
                final_acceleration = stop_side * returning_accelerations[index]
                rest_times[k] = time + zeno_time(rebound_speed, return_acceleration, final_acceleration, restitution)
        if rest_times:
            self._apply_impulses(state, outputs, dict.fromkeys(rest_times, 0.0))
        return rest_times

    def _evaluate_sliding_accelerations(
        self, state: FloatArray, input_cubics: FloatArray, outputs: OutputState, impacted: Sequence[int], direction: int
    ) -> list[float]:
        """Return the second derivatives (outputs,) while impacted contacts move on (direction 1) or back (-1) against friction.

        With one degree of freedom all other outputs reverse with them.
        """
        sliding_signs = []
        for k, contact in enumerate(self.contacts):
            rate = outputs.rates[self._output_indices[k]]
            has_friction = contact.friction is not None and (k in impacted or self.mode.held_values[k] is None)
            motion_sign = direction if k in impacted or self._mobility == 1 else 1
            sliding_signs.append(motion_sign * int(math.copysign(1.0, rate)) if has_friction and rate else 0)
        held = tuple(None if k in impacted else value for k, value in enumerate(self.mode.held_values))
        derivative = evaluate_events_and_derivative(
            *self.get_model(ContactMode(held, tuple(sliding_signs), self.mode.taut)), input_cubics, 0.0, state
        )[1]
        return self._evaluate_output_accelerations(state, derivative)

    def _apply_impulses(self, state: FloatArray, outputs: OutputState, target_rates: dict[int, float]) -> None:
        """Change the velocities by joint and contact impulses so that some contacts have given rates."""
        system = self.system
        n_coordinates = 3 * len(system.bodies)
        joint_jacobian = evaluate_jacobian(self._joint_rows, state[:n_coordinates].reshape(1, -1, 3))[0]
        contact_jacobian = outputs.gradients[[self._output_indices[k] for k in target_rates]]
        constraint_jacobian = np.concatenate([joint_jacobian, contact_jacobian]).reshape(-1, n_coordinates)
        rate_changes = [rate - outputs.rates[self._output_indices[k]] for k, rate in target_rates.items()]
        right_hand_side = np.concatenate([np.zeros(len(joint_jacobian)), rate_changes])
        inverse_mass = system.inverse_mass.ravel()
        velocities = state[n_coordinates : 2 * n_coordinates]
        stand_in = system.stand_in_inertia.ravel()
        mass = np.divide(1.0, inverse_mass, out=np.zeros_like(inverse_mass), where=inverse_mass > 0) - stand_in
        energy_before = 0.5 * float(np.sum(mass * velocities**2))
        schur_complement, change = (constraint_jacobian * inverse_mass) @ constraint_jacobian.T, np.zeros_like(inverse_mass)
        for _ in range(MAX_STAND_IN_ITERATIONS if system.has_stand_in_inertia else 1):
            free_change = inverse_mass * stand_in * change
            residual = right_hand_side - constraint_jacobian @ free_change
            change = free_change + inverse_mass * (constraint_jacobian.T @ np.linalg.lstsq(schur_complement, residual, rcond=1e-13)[0])
        velocities += change
        dissipated_energy = energy_before - 0.5 * float(np.sum(mass * velocities**2))
        state[-N_AUXILIARY_STATES] += dissipated_energy
        state[-N_AUXILIARY_STATES + 1] += dissipated_energy

    def _list_candidates(self, k: int, outputs: OutputState, is_released: bool) -> Iterator[tuple[float | None, int]]:
        """Yield the possible states of a contact: the value it is held at, or None and the sign of its sliding."""
        contact = self.contacts[k]
        value, rate = outputs.values[self._output_indices[k]], outputs.rates[self._output_indices[k]]
        has_friction, stop_side = contact.friction is not None, self._find_active_stop(k, outputs)
        if abs(rate) > self._rest_rate(k):
            yield None, int(math.copysign(1.0, rate)) if has_friction else 0
            return
        if (has_friction or stop_side) and not is_released:
            yield (contact.high if stop_side > 0 else contact.low if stop_side < 0 else value), 0
        for sign in (1, -1):
            if has_friction and sign != stop_side:
                yield None, sign
        if not has_friction:
            yield None, 0

    def _compute_violation(self, mode: ContactMode, state: FloatArray, input_cubics: FloatArray) -> float:
        """Return the largest violation of the complementarity conditions of a mode, relative to force and acceleration scales."""
        system, workspace = self.get_model(mode)
        trial_state = state.copy()
        _project_state_vector(system, workspace, input_cubics, trial_state, self._constraint_tolerance)
        event_values, derivative = evaluate_events_and_derivative(system, workspace, input_cubics, 0.0, trial_state)
        is_force = system.event_functions["kind"] == EventFunctionKind.FORCE
        event_scale = np.where(system.event_functions["tolerance"] > 0, system.event_functions["tolerance"], 1.0) * 1e12
        violation = float(np.max(event_values[is_force] / event_scale[is_force], initial=0.0))
        outputs, output_accelerations = (self._evaluate_outputs(trial_state), self._evaluate_output_accelerations(trial_state, derivative))
        for k, held in enumerate(mode.held_values):
            output_index = self._output_indices[k]
            if held is not None:
                # At a turning point of a reading no force along it can hold it: the mechanism moves on.
                residual_acceleration = (
                    abs(output_accelerations[output_index]) * self._time_scale**2 / self._coordinate_scales[output_index]
                )
                violation = max(violation, residual_acceleration if residual_acceleration > TURNING_POINT_ACCELERATION_TOLERANCE else 0.0)
                continue
            if abs(outputs.rates[output_index]) > self._rest_rate(k):
                continue
            direction = mode.sliding_signs[k] or -self._find_active_stop(k, outputs)
            violation = max(
                violation, -direction * output_accelerations[output_index] * self._time_scale**2 / self._coordinate_scales[output_index]
            )
        return violation

    def _project_onto_mode(self, state: FloatArray, input_cubics: FloatArray) -> None:
        """Satisfy joints and held outputs to rounding; the velocity removed is rounding too."""
        system, workspace = self.get_model(self.mode)
        _project_state_vector(system, workspace, input_cubics, state, self._constraint_tolerance)

    def _record_events(self, time: float, state: FloatArray, previous_mode: ContactMode, rest_times: dict[int, float]) -> None:
        """Record contacts that come to rest or start to move.

        Which of several redundant contacts carries the load is not recorded.
        """
        outputs = self._evaluate_outputs(state)
        for k, contact in enumerate(self.contacts):
            was_held, is_held = (self._is_held(k, mode, outputs) for mode in (previous_mode, self.mode))
            if was_held != is_held:
                start_kind, end_kind = (
                    (EventKind.REST, EventKind.SEPARATION) if self._find_active_stop(k, outputs) else (EventKind.STICK, EventKind.SLIP)
                )
                self.events.append(
                    Event(time=rest_times.get(k, time), kind=start_kind if is_held else end_kind, subject=contact.output_name)
                )

    def _is_held(self, k: int, mode: ContactMode, outputs: OutputState) -> bool:
        """Return whether a contact is at rest in a mode: held itself, or because nothing can move."""
        can_hold = self.contacts[k].friction is not None or self._find_active_stop(k, outputs) != 0
        return mode.held_values[k] is not None or (mode.is_locked and can_hold)

    def _evaluate_outputs(self, state: FloatArray) -> OutputState:
        """Evaluate all output variables at a state."""
        output_rows: RecordArray = self.system.output_rows
        n_coordinates = 3 * len(self.system.bodies)
        poses, velocities = (part.reshape(1, -1, 3) for part in (state[:n_coordinates], state[n_coordinates : 2 * n_coordinates]))
        values: list[float] = evaluate_residuals(output_rows, poses, np.zeros((1, len(output_rows.table), 3)))[0].tolist()
        gradients = evaluate_jacobian(output_rows, poses)[0]
        return OutputState(values, np.sum(gradients * velocities[0], axis=(-2, -1)).tolist(), gradients)

    def _evaluate_output_accelerations(self, state: FloatArray, derivative: FloatArray) -> list[float]:
        """Return the second derivatives (outputs,) of the output variables from a state and its derivative."""
        system = self.system
        n_coordinates = 3 * len(system.bodies)
        poses, velocities = (part.reshape(1, -1, 3) for part in (state[:n_coordinates], state[n_coordinates : 2 * n_coordinates]))
        prescribed = np.zeros((1, len(system.output_rows.table), 3))
        gamma = evaluate_gamma(system.output_rows, poses, velocities, prescribed)[0]
        gradients = evaluate_jacobian(system.output_rows, poses)[0]
        body_accelerations = derivative[n_coordinates : 2 * n_coordinates].reshape(-1, 3)
        accelerations: list[float] = (np.sum(gradients * body_accelerations, axis=(-2, -1)) - gamma).tolist()
        return accelerations

    def _find_active_stop(self, k: int, outputs: OutputState) -> int:
        """Return the stop that a contact touches: 1 the high one, -1 the low one, 0 none."""
        contact, output_index = self.contacts[k], self._output_indices[k]
        is_at_rest = abs(outputs.rates[output_index]) <= self._rest_rate(k)
        tolerance = (REST_TOLERANCE if is_at_rest else CONTACT_TOLERANCE) * self._coordinate_scales[output_index]
        value = outputs.values[output_index]
        return 1 if value >= contact.high - tolerance else -1 if value <= contact.low + tolerance else 0

    def _rest_rate(self, k: int) -> float:
        """Return the rate below which a contact is at rest."""
        return STICTION_RATE_TOLERANCE * self._coordinate_scales[self._output_indices[k]] / self._time_scale


def _project_state_vector(
    system: System, workspace: SystemWorkspace, input_cubics: FloatArray, state: FloatArray, constraint_tolerance: float
) -> None:
    """Project poses and velocities of a state vector onto the constraints."""
    n_coordinates = 3 * len(system.bodies)
    poses, velocities = state[:n_coordinates].reshape(-1, 3), state[n_coordinates : 2 * n_coordinates].reshape(-1, 3)
    project_state(system, workspace, input_cubics, 0.0, poses, velocities, constraint_tolerance)

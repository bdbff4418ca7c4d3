"""Contact modes of a scene during an impulse run: sliding or sticking friction, stops in contact, slack springs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.engines.impulse.step_records import DetectedEvent, StepObservation, make_level_function, make_reversal_function
from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.contact.tolerances import STICTION_RATE_TOLERANCE
from governor_mechanism.mechanics.dynamics.contacts import ContactColumn, ContactMode, contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.equations_of_motion import N_ENERGY_STATES
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names, from_mass_centres, to_mass_centres
from governor_mechanism.mechanics.dynamics.projection import CLOSURE_TOLERANCE_RATIO
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene

RELEASE_RATE_FACTOR = 10.0
"""Release threshold, in units of the stiction rate, of a contact held by friction and a stop; how they share the force is indeterminate."""


class ContactModeTracker:
    """Contacts of a scene, the constraints that can hold them, and its one-sided springs, during a run.

    `time_scale` is in seconds. `last_release_time` (s) is when a contact was last released. `rebound_sides` are the sides of the
    stops from which contacts rebounded at the last change of the mode.
    """

    def __init__(self, scene: Scene, stepper: StaggeredStepper, time_scale: float) -> None:
        names = forced_output_names(scene)
        self._stepper, self._output_forces, self._time_scale = stepper, stepper.output_forces, time_scale
        tolerance = CLOSURE_TOLERANCE_RATIO * scene.part.mechanism.length_scale
        self._scene_contacts = SceneContacts(scene, time_scale, tolerance)
        self.contacts = contacts_of(scene)
        self.contact_outputs = [names.index(contact.output_name) for contact in self.contacts]
        self._springs = one_sided_forces_of(scene)
        self._spring_outputs = [names.index(spring.reading) for spring in self._springs]
        self.constraints = [
            stepper.model.make_contact_constraint(k, output, "dry friction" if contact.friction else "stops", contact.output_name)
            for k, (contact, output) in enumerate(zip(self.contacts, self.contact_outputs, strict=True))
        ]
        self.last_release_time = -math.inf
        self.change_mode()
        self.events.clear()

    @property
    def events(self) -> list[Event]:
        """Return the events so far."""
        return self._scene_contacts.events

    @property
    def mode(self) -> ContactMode:
        """Return the present contact mode."""
        return self._scene_contacts.mode

    @property
    def resting(self) -> set[int]:
        """Return the contacts at rest."""
        return set(np.flatnonzero(~np.isnan(self._scene_contacts.rest_values)).tolist())

    def change_mode(self, events: Sequence[DetectedEvent] = ()) -> None:
        """Select the contact mode at the present time, after events there, and set springs, sliding friction and constraints to it."""
        was_resting, scene_contacts = self.resting, self._scene_contacts
        released = {event.index for event in events if event.kind in (EventKind.SLIP, EventKind.SEPARATION)}
        if released and scene_contacts.mobility == 1:
            released |= was_resting  # all move with it
        self._apply_transition(released, was_resting | {event.index for event in events if event.kind == EventKind.STICK})
        resting = self.resting
        if was_resting - resting:
            self.last_release_time = self._stepper.state.time
        self._output_forces.is_taut = list(self.mode.taut)
        self._output_forces.sliding_directions = [0 if k in resting else sign for k, sign in enumerate(self.mode.sliding_signs)]
        for k, (contact, constraint) in enumerate(zip(self.contacts, self.constraints, strict=True)):
            value = float(scene_contacts.rest_values[k]) if k in resting else None
            constraint.stop_side = 0 if value is None else int(value >= contact.high) - int(value <= contact.low)
            constraint.stop_value = contact.high if constraint.stop_side > 0 else contact.low
            constraint.held_value = None if contact.friction is None else value
        self._stepper.is_holding = bool(resting)
        self.rebound_sides = {
            event.index: event.direction for event in events if event.kind == EventKind.IMPACT and event.index not in resting
        }

    def _apply_transition(self, released: set[int], stopped: set[int]) -> None:
        """Select the contact mode in the state of the multibody model, and take over its velocities."""
        stepper, scene_contacts, state = self._stepper, self._scene_contacts, self._stepper.state
        input_cubics = stack_local_cubics(scene_contacts.input_functions, np.array([state.time]))[0]
        system, (centres, centre_velocities) = scene_contacts.model[0], stepper.mass_centre_state()
        # A free spindle is a body behind those of the part.
        n_bodies, has_shaft = len(centres), len(system.bodies) > len(centres)
        shaft = np.array([[0.0, 0.0, state.accumulators[3]]])[: int(has_shaft)]
        poses, velocities = from_mass_centres(system, np.concatenate([centres, 0.0 * shaft]), np.concatenate([centre_velocities, shaft]))
        state_vector = np.concatenate([poses.ravel(), velocities.ravel(), np.zeros(N_ENERGY_STATES)])
        scene_contacts.change_mode(state.time, state_vector, input_cubics, released, stopped)
        _, new_velocities = to_mass_centres(system, *state_vector[:-N_ENERGY_STATES].reshape(2, -1, 3))
        stepper.set_velocities(new_velocities[:n_bodies], float(state_vector[-1]))

    def detect_events(self, observation: StepObservation) -> list[DetectedEvent]:
        """Return the events that a step has passed."""
        detected = list[DetectedEvent]()
        for k, (contact, constraint, output) in enumerate(zip(self.contacts, self.constraints, self.contact_outputs, strict=True)):
            sliding_direction = self._output_forces.sliding_directions[k]
            direction = self.release_direction(k, float(observation.rates_after_kick[output]))
            if direction:
                event_function = self._make_leave_function(k, direction) if constraint.stop_side else self._make_slip_function(k)
                detected.append(
                    DetectedEvent(EventKind.SEPARATION if constraint.stop_side else EventKind.SLIP, k, event_function, -1.0, direction)
                )
            elif sliding_direction and sliding_direction * float(observation.rates[output]) <= 0.0:
                detected.append(
                    DetectedEvent(
                        EventKind.STICK,
                        k,
                        make_reversal_function(output, sliding_direction),
                        -sliding_direction * self._stepper.output_rate(output),
                    )
                )
            if constraint.stop_side or constraint.held_value is not None:
                continue
            for side, stop_value in ((1, contact.high), (-1, contact.low)):
                if side * (float(observation.values[output]) - stop_value) > 0.0:
                    initial_value = side * (self._stepper.output_value(output) - stop_value)
                    detected.append(DetectedEvent(EventKind.IMPACT, k, make_level_function(output, side, stop_value), initial_value, side))
        for k, (spring, output) in enumerate(zip(self._springs, self._spring_outputs, strict=True)):
            direction = -1 if self._output_forces.is_taut[k] else 1
            if direction * (float(observation.values[output]) - spring.slack_below) > 0.0:
                initial_stretch = direction * (self._stepper.output_value(output) - spring.slack_below)
                detected.append(
                    DetectedEvent(EventKind.TAUT, k, make_level_function(output, direction, spring.slack_below), initial_stretch, direction)
                )
        return detected

    def release_direction(self, k: int, rate: float) -> int:
        """Return the direction in which contact `k` is released, given its rate after a kick; 0 if it stays held or was not held."""
        constraint = self.constraints[k]
        rate_factor = RELEASE_RATE_FACTOR if constraint.stop_side and constraint.held_value is not None else 1.0
        if not (constraint.stop_side or constraint.held_value is not None) or abs(rate) <= rate_factor * self.stiction_rate(k):
            return 0
        direction = int(math.copysign(1.0, rate))
        if constraint.stop_side and (direction == constraint.stop_side or constraint.stop_force > 0.0):
            return 0
        return direction if constraint.held_value is None or constraint.is_saturated else 0

    def stiction_rate(self, k: int) -> float:
        """Return the rate (m/s or rad/s) of contact `k` below which it counts as stationary."""
        return STICTION_RATE_TOLERANCE * float(self._scene_contacts.contacts[k, ContactColumn.SCALE]) / self._time_scale

    def _make_slip_function(self, k: int) -> Callable[[StepObservation], float]:
        """Return an event function: the holding force minus the friction limit."""
        constraint = self.constraints[k]
        return lambda observation: constraint.friction_force - observation.friction_limits[k]

    def _make_leave_function(self, k: int, direction: int) -> Callable[[StepObservation], float]:
        """Return an event function: the rate away from the stop, or minus the stop force while a stop without friction pushes."""
        constraint, output, min_rate = self.constraints[k], self.contact_outputs[k], self.stiction_rate(k)

        def leave_function(observation: StepObservation) -> float:
            if constraint.held_value is None and constraint.stop_force > 0.0:
                return -constraint.stop_force
            return direction * float(observation.rates_after_kick[output]) - (min_rate if constraint.held_value is not None else 0.0)

        return leave_function

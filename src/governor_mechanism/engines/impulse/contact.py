"""Contact modes of a scene during an impulse run: sliding or sticking friction, stops in contact, slack springs."""

from __future__ import annotations

import math
from collections.abc import Callable

from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.engines.impulse.step_records import DetectedEvent, StepObservation, make_level_function, make_reversal_function
from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE, REST_TOLERANCE, STICTION_RATE_TOLERANCE
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, one_sided_forces_of
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene

RELEASE_RATE_FACTOR = 10.0
"""Release threshold, in units of the stiction rate, of a contact held by friction and a stop; how they share the force is indeterminate."""

MIN_STICK_FRACTION = 0.06
"""Shortest stick, relative to a step, that is reported. A shorter one is a reversal: only motion shows that a hold is too weak."""


class ContactModeTracker:
    """Contacts of a scene, the constraints that can hold them, and its one-sided springs, during a run.

    `time_scale` is in seconds. `events` is the event log; `last_release_time` (s) is when a contact was last released.
    """

    def __init__(self, scene: Scene, stepper: StaggeredStepper, time_scale: float) -> None:
        mechanism, names = scene.part.mechanism, forced_output_names(scene)
        self._stepper, self._output_forces, self._time_scale = stepper, stepper.output_forces, time_scale
        self.contacts = contacts_of(scene)
        self.contact_outputs = [names.index(contact.output_name) for contact in self.contacts]
        self.coordinate_scales = [mechanism.output_scale(name) for name in names]
        self._springs = one_sided_forces_of(scene)
        self._spring_outputs = [names.index(spring.reading) for spring in self._springs]
        self.constraints = [
            stepper.model.make_contact_constraint(k, output, "dry friction" if contact.friction else "stops", contact.output_name)
            for k, (contact, output) in enumerate(zip(self.contacts, self.contact_outputs, strict=True))
        ]
        self.events, self.last_release_time = list[Event](), -math.inf
        self._reported_holds = list[float | None]()
        stepper.output_forces.is_taut = [
            self._is_taut(stepper.output_value(output) - spring.slack_below, output)
            for spring, output in zip(self._springs, self._spring_outputs, strict=True)
        ]
        for k, contact in enumerate(self.contacts):
            rate = stepper.output_rate(self.contact_outputs[k])
            if abs(rate) <= self.stiction_rate(k):
                self.hold(k, self.active_stop(k))
            elif contact.friction is not None:
                stepper.output_forces.sliding_directions[k] = int(math.copysign(1.0, rate))

    @property
    def mode(self) -> ContactMode:
        """Return the present contact mode."""
        held_values = tuple(self._held_value(k) for k in range(len(self.contacts)))
        return ContactMode(held_values, tuple(self._output_forces.sliding_directions), tuple(self._output_forces.is_taut))

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

    def apply_transition(self, event: DetectedEvent) -> None:
        """Change the mode of the contact or spring of an event; an impact is resolved later, after the joints are closed."""
        k, output_forces = event.index, self._output_forces
        if event.kind == EventKind.TAUT:
            output_forces.is_taut[k] = event.direction > 0
            kind = EventKind.TAUT if output_forces.is_taut[k] else EventKind.SLACK
            self.events.append(Event(time=self._stepper.state.time, kind=kind, subject=self._springs[k].reading))
        elif event.kind == EventKind.STICK:
            self.hold(k, 0)
        elif event.kind in (EventKind.SLIP, EventKind.SEPARATION):
            self.release(k, event.direction)

    def hold(self, k: int, side: int) -> None:
        """Hold contact `k` at its present value, or at its stop on `side`."""
        contact, constraint = self.contacts[k], self.constraints[k]
        constraint.stop_side, constraint.stop_value = side, contact.high if side > 0 else contact.low
        value = self._stepper.output_value(self.contact_outputs[k])
        constraint.held_value = None if contact.friction is None else constraint.stop_value if side else value
        self._output_forces.sliding_directions[k] = 0

    def release(self, k: int, direction: int) -> None:
        """Release contact `k` to move in `direction`, unless that is into the stop that it touches."""
        constraint = self.constraints[k]
        if constraint.stop_side and constraint.stop_side == direction:
            return
        constraint.stop_side, constraint.held_value, self.last_release_time = 0, None, self._stepper.state.time
        self._output_forces.sliding_directions[k] = direction if self.contacts[k].friction is not None else 0

    def update_sliding_directions(self) -> None:
        """Set the sliding directions from the present rates, after impulses have changed them."""
        for k, (contact, constraint, output) in enumerate(zip(self.contacts, self.constraints, self.contact_outputs, strict=True)):
            if contact.friction is None or constraint.stop_side:
                continue
            rate = self._stepper.output_rate(output)
            if abs(rate) > self.stiction_rate(k):
                self.release(k, int(math.copysign(1.0, rate)))
            elif constraint.held_value is None:
                self.hold(k, 0)

    def release_direction(self, k: int, rate: float) -> int:
        """Return the direction in which contact `k` is released, given its rate after a kick; 0 if it stays held or was not held."""
        constraint = self.constraints[k]
        rate_factor = RELEASE_RATE_FACTOR if constraint.stop_side and constraint.held_value is not None else 1.0
        if self._held_value(k) is None or abs(rate) <= rate_factor * self.stiction_rate(k):
            return 0
        direction = int(math.copysign(1.0, rate))
        if constraint.stop_side and (direction == constraint.stop_side or constraint.stop_force > 0.0):
            return 0
        return direction if constraint.held_value is None or constraint.is_saturated else 0

    def record_transitions(self, rest_times: dict[int, float]) -> None:
        """Record which contacts have become held or free; `rest_times` (s) are the times at which bounce sequences end, by contact."""
        held_values = [self._held_value(k) for k in range(len(self.contacts))]
        for k, (contact, previous, current) in enumerate(zip(self.contacts, self._reported_holds, held_values, strict=False)):
            if (previous is None) == (current is None):
                continue
            at_stop = (previous if current is None else current) in (contact.low, contact.high)
            start_kind, end_kind = (EventKind.REST, EventKind.SEPARATION) if at_stop else (EventKind.STICK, EventKind.SLIP)
            time = rest_times.get(k, self._stepper.state.time)
            kind = end_kind if current is None else start_kind
            if kind != EventKind.SLIP or not self._cancel_brief_stick(contact.output_name):
                self.events.append(Event(time=time, kind=kind, subject=contact.output_name))
        self._reported_holds = held_values
        self._stepper.is_holding = bool(self.held_rates())

    def _cancel_brief_stick(self, reading: str) -> bool:
        """Return whether the stick that ends now was only a reversal, and remove it from the log."""
        min_duration = MIN_STICK_FRACTION * self._stepper.last_h
        for index in reversed(range(len(self.events))):
            event = self.events[index]
            if event.subject == reading:
                only_reversed = event.kind == EventKind.STICK and self._stepper.state.time - event.time <= min_duration
                if only_reversed:
                    del self.events[index]
                return only_reversed
        return self._stepper.state.time <= min_duration

    def held_rates(self) -> dict[str, float]:
        """Return the rates, all zero, of the held contacts by output name."""
        return {contact.output_name: 0.0 for k, contact in enumerate(self.contacts) if self._held_value(k) is not None}

    def impacting_contacts(self) -> dict[int, int]:
        """Return the contacts that move into a stop, with the side of the stop."""
        sides = {k: self.active_stop(k) for k, constraint in enumerate(self.constraints) if not constraint.stop_side}
        return {k: side for k, side in sides.items() if side * self._stepper.output_rate(self.contact_outputs[k]) > self.stiction_rate(k)}

    def record_event(self, k: int, kind: EventKind) -> None:
        """Append an event of contact `k` at the present time."""
        self.events.append(Event(time=self._stepper.state.time, kind=kind, subject=self.contacts[k].output_name))

    def active_stop(self, k: int) -> int:
        """Return the stop that contact `k` touches: 1 the high one, -1 the low one, 0 neither."""
        contact, output = self.contacts[k], self.contact_outputs[k]
        is_stationary = abs(self._stepper.output_rate(output)) <= self.stiction_rate(k)
        tolerance = (REST_TOLERANCE if is_stationary else CONTACT_TOLERANCE) * self.coordinate_scales[output]
        value = self._stepper.output_value(output)
        return 1 if value >= contact.high - tolerance else -1 if value <= contact.low + tolerance else 0

    def stiction_rate(self, k: int) -> float:
        """Return the rate (m/s or rad/s) of contact `k` below which it counts as stationary."""
        return STICTION_RATE_TOLERANCE * self.coordinate_scales[self.contact_outputs[k]] / self._time_scale

    def _held_value(self, k: int) -> float | None:
        """Return the value (m or rad) at which contact `k` is held, or None."""
        constraint = self.constraints[k]
        return constraint.stop_value if constraint.stop_side else constraint.held_value

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

    def _is_taut(self, stretch: float, output: int) -> bool:
        """Return whether a one-sided spring of a stretch (m or rad) pulls."""
        return self._stepper.output_rate(output) > 0 if abs(stretch) < CONTACT_TOLERANCE * self.coordinate_scales[output] else stretch > 0

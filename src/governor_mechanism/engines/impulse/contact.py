"""How what may be held in one scene stands: friction that slides or sticks, stops that are rested on, slack springs."""

from __future__ import annotations

import math
from collections.abc import Callable

from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.engines.impulse.step_records import DetectedEvent, StepObservation, make_level_function, make_reversal_function
from governor_mechanism.mechanics.contact.tolerances import CONTACT_TOLERANCE, REST_TOLERANCE, STICTION_RATE_TOLERANCE
from governor_mechanism.mechanics.dynamics.contacts import ContactMode, contacts_of, output_springs_of
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene

RELEASE_RATE_FACTOR = 10.0
"""How many times faster than that it must be for what friction and a stop held together to have been let go: what
either of them bears is the joint solver's choice.
"""

MIN_STICK_FRACTION = 0.06
"""Of a step: what sticks for less has turned, and is driven on: a hold is known to be too weak only as it is moved."""


class ContactModeTracker:
    """The keepers of one scene on a walk, the joints that may hold them, and its one-sided springs.

    second (s) is the time scale. events is what happened; slipped (s) when something was let go last.
    """

    def __init__(self, scene: Scene, stepper: StaggeredStepper, time_scale: float) -> None:
        mechanism, names = scene.part.mechanism, forced_output_names(scene)
        self._stepper, self._output_forces, self._time_scale = stepper, stepper.output_forces, time_scale
        self.contacts = contacts_of(scene)
        self.contact_outputs = [names.index(contact.output_name) for contact in self.contacts]
        self.coordinate_scales = [1.0 if mechanism.reading(name).quantity == "angle" else mechanism.length_scale for name in names]
        self._springs = [spring for spring in output_springs_of(scene) if spring.one_sided]
        self._spring_outputs = [names.index(spring.reading) for spring in self._springs]
        self.constraints = [
            stepper.model.make_contact_constraint(k, output, "dry friction" if contact.friction else "stops", contact.output_name)
            for k, (contact, output) in enumerate(zip(self.contacts, self.contact_outputs, strict=True))
        ]
        self.events, self.last_release_time = list[Event](), -math.inf
        self._reported_holds = list[float | None]()
        stepper.output_forces.is_taut = [
            self._is_taut(stepper.output_value(output) - spring.free_value, output)
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
        """How everything stands."""
        held_values = tuple(self._held_value(k) for k in range(len(self.contacts)))
        return ContactMode(held_values, tuple(self._output_forces.sliding_directions), tuple(self._output_forces.is_taut or ()))

    def detect_events(self, observation: StepObservation) -> list[DetectedEvent]:
        """What a step has gone beyond."""
        detected = list[DetectedEvent]()
        for k, (contact, constraint, output) in enumerate(zip(self.contacts, self.constraints, self.contact_outputs, strict=True)):
            sliding_direction, direction = (
                self._output_forces.sliding_directions[k],
                self.release_direction(k, float(observation.rates_after_kick[output])),
            )
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
            direction = -1 if self._output_forces.is_taut and self._output_forces.is_taut[k] else 1
            if direction * (float(observation.values[output]) - spring.free_value) > 0.0:
                initial_stretch = direction * (self._stepper.output_value(output) - spring.free_value)
                detected.append(
                    DetectedEvent(EventKind.TAUT, k, make_level_function(output, direction, spring.free_value), initial_stretch, direction)
                )
        return detected

    def apply_transition(self, event: DetectedEvent) -> None:
        """Change how a keeper or a spring stands; a strike waits until the joints have been closed."""
        k, output_forces = event.index, self._output_forces
        if event.kind == EventKind.TAUT:
            assert output_forces.is_taut is not None
            output_forces.is_taut[k] = event.direction > 0
            kind = EventKind.TAUT if output_forces.is_taut[k] else EventKind.SLACK
            self.events.append(Event(time=self._stepper.state.time, kind=kind, subject=self._springs[k].reading))
        elif event.kind == EventKind.STICK:
            self.hold(k, 0)
        elif event.kind in (EventKind.SLIP, EventKind.SEPARATION):
            self.release(k, event.direction)

    def hold(self, k: int, side: int) -> None:
        """Hold a keeper where it is, or at its stop of that side."""
        contact, constraint = self.contacts[k], self.constraints[k]
        constraint.stop_side, constraint.stop_value = side, contact.high if side > 0 else contact.low
        value = self._stepper.output_value(self.contact_outputs[k])
        constraint.held_value = None if contact.friction is None else constraint.stop_value if side else value
        self._output_forces.sliding_directions[k] = 0

    def release(self, k: int, direction: int) -> None:
        """Let go of a keeper, which begins to move that way; not into a stop that it rests at."""
        constraint = self.constraints[k]
        if constraint.stop_side and constraint.stop_side == direction:
            return
        constraint.stop_side, constraint.held_value, self.last_release_time = 0, None, self._stepper.state.time
        self._output_forces.sliding_directions[k] = direction if self.contacts[k].friction is not None else 0

    def update_sliding_directions(self) -> None:
        """After a throw friction opposes the motion that there is now."""
        for k, (contact, constraint, output) in enumerate(zip(self.contacts, self.constraints, self.contact_outputs, strict=True)):
            if contact.friction is None or constraint.stop_side:
                continue
            rate = self._stepper.output_rate(output)
            if abs(rate) > self.stiction_rate(k):
                self.release(k, int(math.copysign(1.0, rate)))
            elif constraint.held_value is None:
                self.hold(k, 0)

    def release_direction(self, k: int, rate: float) -> int:
        """Which way what was held moves at the rate right after a kick; 0 where it is still held, or was not."""
        constraint = self.constraints[k]
        rate_factor = RELEASE_RATE_FACTOR if constraint.stop_side and constraint.held_value is not None else 1.0
        if self._held_value(k) is None or abs(rate) <= rate_factor * self.stiction_rate(k):
            return 0
        direction = int(math.copysign(1.0, rate))
        if constraint.stop_side and (direction == constraint.stop_side or constraint.stop_force > 0.0):
            return 0
        return direction if constraint.held_value is None or constraint.is_saturated else 0

    def record_transitions(self, rest_times: dict[int, float]) -> None:
        """Note what has come to be held, or is held no more; rest_at (s) is when the bounces of some will be over."""
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
        """Whether what slips now had only turned, there or at the start; then that it stuck is told no more."""
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
        """The rates of all that is held, by reading."""
        return {contact.output_name: 0.0 for k, contact in enumerate(self.contacts) if self._held_value(k) is not None}

    def impacting_contacts(self) -> dict[int, int]:
        """The keepers that run into a stop, and at which side."""
        sides = {k: self.active_stop(k) for k, constraint in enumerate(self.constraints) if not constraint.stop_side}
        return {k: side for k, side in sides.items() if side * self._stepper.output_rate(self.contact_outputs[k]) > self.stiction_rate(k)}

    def record_event(self, k: int, kind: EventKind) -> None:
        """Note what a keeper does now."""
        self.events.append(Event(time=self._stepper.state.time, kind=kind, subject=self.contacts[k].output_name))

    def active_stop(self, k: int) -> int:
        """At which of its stops a keeper is: 1 the high one, -1 the low one, 0 neither."""
        contact, output = self.contacts[k], self.contact_outputs[k]
        is_stationary = abs(self._stepper.output_rate(output)) <= self.stiction_rate(k)
        tolerance, value = (
            (REST_TOLERANCE if is_stationary else CONTACT_TOLERANCE) * self.coordinate_scales[output],
            self._stepper.output_value(output),
        )
        return 1 if value >= contact.high - tolerance else -1 if value <= contact.low + tolerance else 0

    def stiction_rate(self, k: int) -> float:
        return STICTION_RATE_TOLERANCE * self.coordinate_scales[self.contact_outputs[k]] / self._time_scale

    def _held_value(self, k: int) -> float | None:
        constraint = self.constraints[k]
        return constraint.stop_value if constraint.stop_side else constraint.held_value

    def _make_slip_function(self, k: int) -> Callable[[StepObservation], float]:
        """By how much what holds a reading exceeds its friction."""
        constraint = self.constraints[k]
        return lambda sight: constraint.friction_force - sight.friction_limits[k]

    def _make_leave_function(self, k: int, direction: int) -> Callable[[StepObservation], float]:
        """How fast a reading leaves its stop; less than nought by the force with which that still pushes alone."""
        constraint, output, min_rate = self.constraints[k], self.contact_outputs[k], self.stiction_rate(k)

        def leave_function(observation: StepObservation) -> float:
            if constraint.held_value is None and constraint.stop_force > 0.0:
                return -constraint.stop_force
            return direction * float(observation.rates_after_kick[output]) - (min_rate if constraint.held_value is not None else 0.0)

        return leave_function

    def _is_taut(self, stretch: float, output: int) -> bool:
        """Whether a one-sided spring pulls."""
        return self._stepper.output_rate(output) > 0 if abs(stretch) < CONTACT_TOLERANCE * self.coordinate_scales[output] else stretch > 0

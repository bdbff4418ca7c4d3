"""Contact modes of a scene during an impulse run: sliding or sticking friction, stops in contact, slack springs."""

import math
from collections.abc import Iterator, Sequence
from functools import partial
from itertools import starmap

import numpy as np

from governor_mechanism.engines.impulse.records import DetectedEvent, FixedStepProblem, OutputCrossing, StepState
from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.mechanics.contact.event_log import select_start_events
from governor_mechanism.mechanics.contact.tolerances import STICTION_RATE_TOLERANCE
from governor_mechanism.mechanics.curves.outline_kernels import NO_FEATURE
from governor_mechanism.mechanics.dynamics.arrays import N_ENERGY_STATES, System, from_mass_centres, to_mass_centres
from governor_mechanism.mechanics.dynamics.contact_modes import initial_mode
from governor_mechanism.mechanics.dynamics.contacts import contacts_of
from governor_mechanism.mechanics.dynamics.event_functions import KINKS, EventFunctionKind
from governor_mechanism.mechanics.dynamics.output_forces import SLIDING_FRICTION
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_ends, evaluate_join, keep_features, release_features
from governor_mechanism.mechanics.kinematics.time_functions import stack_local_cubics
from governor_mechanism.model.events import EventKind
from governor_mechanism.types import NO_INDEX, FloatArray

RELEASE_RATE_FACTOR = 10.0
"""Release threshold, in units of the stiction rate, of a contact held by friction and a stop; how they share the force is indeterminate."""


MAX_DIVISIONS = 40
"""Largest number of places within a step at which a gap is looked at that closes and opens again in it, as behind a thin part."""


class OutlineJoins:
    """The edge or corner that each resting contact touches; where it comes to the next one, force or curvature jump, and a step ends."""

    def __init__(self, stepper: StaggeredStepper) -> None:
        self._stepper = stepper
        self._contacts: list[tuple[int, int, float]] = []  # contacts on edges, their constraint rows, and the rounding of a distance

    def keep(self, system: System) -> None:
        """Keep the edges that are touched in the present state, in the system of its contact mode."""
        functions = system.event_functions[system.event_functions["kind"] == EventFunctionKind.JOIN]
        self._contacts = functions[["contact_index", "source_index", "tolerance"]].tolist()
        if not self._contacts:
            return
        self._system = system
        self._rows = system.constraint_rows._replace(table=system.constraint_rows.table.copy())
        motion = self._origin_motion(self._stepper.state)
        release_features(self._rows)
        keep_features(self._rows, *motion)
        keep_features(self._rows, *motion)  # just behind an end of the nearest one it is the next one

    def detect(self, end: StepState) -> Iterator[DetectedEvent]:
        """Yield the joins that a step to a state has passed."""
        for contact, row, rounding in self._contacts:
            if self._beyond_end(row, end) > rounding:  # what rests at a corner is on neither side of it
                yield DetectedEvent(None, contact, partial(self._beyond_end, row), 0)

    def _beyond_end(self, row: int, state: StepState) -> float:
        """Return the event function of a join: how far a contact is beyond its edge."""
        return float(evaluate_join(self._rows, row, *self._origin_motion(state)))

    def passage_duration(self, interval: float) -> float:
        """Return in what time (s) the first contact comes to an end of its edge, at its speed in a short interval (s) from now on."""
        if not self._contacts:
            return math.inf
        durations = [math.inf]
        poses, velocities = self._origin_motion(self._stepper.state)
        for _, row, rounding in self._contacts:
            if self._rows.table[row]["kept_feature"] != NO_FEATURE:
                now, soon = (evaluate_ends(self._rows, row, poses + time * velocities, velocities) for time in (0.0, interval))
                ends = zip(now, soon, strict=True)
                durations += [-here * interval / (there - here) for here, there in ends if here < -rounding and there > here]
        return min(durations)

    def _origin_motion(self, state: StepState) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities of the origins of the bodies; that of a free spindle touches nothing."""
        centres, velocities = self._stepper.model.to_mass_centres(state.poses, state.velocities)
        shaft = np.zeros((len(self._system.bodies) - len(centres), 3))
        return from_mass_centres(self._system, np.concatenate([centres, shaft]), np.concatenate([velocities, shaft]))


class ContactModeTracker:
    """Contacts of a scene, the constraints that can hold them, and its one-sided springs, during a run.

    `last_release_time` (s) is when a contact was last released. `rebound_sides` are the sides of the
    stops from which contacts rebounded at the last change of the mode.
    """

    def __init__(self, problem: FixedStepProblem, stepper: StaggeredStepper) -> None:
        self._stepper, self.scene_contacts = stepper, problem.scene_contacts
        self.scene_contacts.continue_from(initial_mode(problem.scene))
        table, time_scale = self.scene_contacts.contacts, problem.evaluator.time_scale
        self._stiction_rates: list[float] = (STICTION_RATE_TOLERANCE * table["scale"] / time_scale).tolist()
        self.contact_outputs = table["output_index"]
        self._friction_inputs = table["friction_input"]
        self._gaps = set(np.flatnonzero(table["is_gap"]).tolist())
        arguments = zip(contacts_of(problem.scene), self.contact_outputs.tolist(), self._friction_inputs.tolist(), strict=True)
        self.constraints = list(starmap(stepper.model.make_contact_constraint, arguments))
        self.joins = OutlineJoins(stepper)
        self.last_release_time = -math.inf
        self.change_mode()
        self.scene_contacts.events = select_start_events(self.scene_contacts.events)

    @property
    def resting(self) -> set[int]:
        """Return the contacts at rest."""
        return set(np.flatnonzero(~np.isnan(self.scene_contacts.rest_values)).tolist())

    def change_mode(self, events: Sequence[DetectedEvent] = ()) -> None:
        """Select the contact mode at the present time, after events there, and set springs, sliding friction and constraints to it."""
        if events and all(event.kind is None for event in events):
            self.joins.keep(self.scene_contacts.model[0])  # the forces on the next edge decide what it releases
            return
        was_resting, scene_contacts = self.resting, self.scene_contacts
        released = {event.index for event in events if event.kind in (EventKind.SLIP, EventKind.SEPARATION)}
        if released and scene_contacts.mobility == 1:
            released |= was_resting  # all move with it
        self._apply_transition(released, was_resting | {event.index for event in events if event.kind == EventKind.STICK})
        resting = self.resting
        if was_resting - resting:
            self.last_release_time = self._stepper.state.time
        self._set_forces_and_crossings(resting)
        for k, constraint in enumerate(self.constraints):
            value = float(scene_contacts.rest_values[k]) if k in resting else None
            low, high = (float(scene_contacts.contacts[name][k]) for name in ("low", "high"))
            constraint.stop_side = 0 if value is None else int(value >= high) - int(value <= low)
            constraint.stop_value = high if constraint.stop_side > 0 else low
            constraint.held_value = None if constraint.friction_input == NO_INDEX else value
        self._stepper.is_holding = bool(resting)
        rebounds = [event for event in events if event.kind == EventKind.IMPACT and event.index not in resting]
        self.rebound_sides = {event.index: event.direction for event in rebounds}

    def _apply_transition(self, released: set[int], stopped: set[int]) -> None:
        """Select the contact mode in the state of the multibody model, and take over its velocities."""
        stepper = self._stepper
        scene_contacts = self.scene_contacts
        state = self._stepper.state
        input_cubics = stack_local_cubics(scene_contacts.input_functions, np.array([state.time]))[0]
        system = scene_contacts.model[0]
        centres, centre_velocities = stepper.mass_centre_state()
        # A free spindle is a body behind those of the part.
        n_bodies, has_shaft = len(centres), len(system.bodies) > len(centres)
        shaft = np.array([[0.0, 0.0, state.spindle.speed]])[: int(has_shaft)]
        poses, velocities = from_mass_centres(system, np.concatenate([centres, 0.0 * shaft]), np.concatenate([centre_velocities, shaft]))
        state_vector = np.concatenate([poses.ravel(), velocities.ravel(), np.zeros(N_ENERGY_STATES)])
        scene_contacts.change_mode(state.time, state_vector, input_cubics, released, stopped)
        _, new_velocities = to_mass_centres(system, *state_vector[:-N_ENERGY_STATES].reshape(2, -1, 3))
        stepper.set_velocities(new_velocities[:n_bodies], float(state_vector[-1]))

    def _set_forces_and_crossings(self, resting: set[int]) -> None:
        """Take over the output forces of the mode, without friction of contacts at rest, and the event functions of its outputs."""
        system, n_contacts = self.scene_contacts.model[0], len(self.constraints)
        is_sliding = system.output_forces["law"] == SLIDING_FRICTION
        is_held = is_sliding & np.isin(system.output_forces["input_index"], self._friction_inputs[list(resting)])
        self._stepper.model.forces.output_forces = system.output_forces[~is_held]
        self._crossings = list[OutputCrossing]()
        for record in system.event_functions:
            kind, index = record["kind"], int(record["contact_index"])
            if kind == EventFunctionKind.FORCE or kind in KINKS:
                continue  # the constraint that holds the output decides when it is released; steps are short enough for kinks
            event_kind = EventKind.STICK if kind == EventFunctionKind.RATE else EventKind.IMPACT if index < n_contacts else EventKind.TAUT
            output = int(record["source_index"])
            sign = float(record["sign"])
            threshold = float(record["threshold"])
            self._crossings.append(OutputCrossing(event_kind, index, output, sign, threshold))
        self.joins.keep(system)

    def detect_events(self, end: StepState) -> list[DetectedEvent]:
        """Return the events that a step to a state has passed."""
        detected = list(self.joins.detect(end))
        passed_joins = {event.index for event in detected}
        for k, constraint in enumerate(self.constraints):
            if k in passed_joins:
                continue  # the forces of the step are those of two edges: what leaves is seen behind the join
            if direction := self._release_direction(k, self._rate_after_kick(k, end)):
                kind = EventKind.SEPARATION if constraint.stop_side else EventKind.SLIP
                event_function = partial(self._leave_value, k, direction) if constraint.stop_side else partial(self._friction_excess, k)
                detected.append(DetectedEvent(kind, k, event_function, direction))
        closed_end: StepState | None = None
        for crossing in self._crossings:
            value = crossing(end)
            if value <= 0.0 < 2.0 * value - crossing(self._stepper.state):
                # It is near: the gap of the joints, which grows with the step, must not hide an event up to the next one.
                closed_end = closed_end or self._stepper.with_closed_joints(end)
                value = crossing(closed_end)
            if crossing.index in self._gaps and (latest := self._find_closed(crossing, end)) > 0.0:
                detected.append(DetectedEvent(crossing.kind, crossing.index, crossing, int(crossing.sign), latest))
            if value > 0.0 or (value == 0.0 and crossing.kind is EventKind.STICK):
                detected.append(DetectedEvent(crossing.kind, crossing.index, crossing, int(crossing.sign)))
        return detected

    def _find_closed(self, crossing: OutputCrossing, end: StepState) -> float:
        """Return the fraction of a step at which a gap is closed that is open at both ends of the step, or 0; poses are interpolated."""
        first, last = self._stepper.state, end
        duration = end.time - first.time
        for _ in range(MAX_DIVISIONS):
            since = crossing.find_highest(first, last)
            if since == 0.0:
                break
            middle = self._stepper.interpolate(first, last, since)
            if crossing(middle) > 0.0:
                return (middle.time - self._stepper.state.time) / duration
            is_rising = crossing.sign * middle.rates[crossing.output] > 0.0
            first, last = (middle, last) if is_rising else (first, middle)
        return 0.0

    def _rate_after_kick(self, k: int, state: StepState) -> float:
        """Return the rate of contact `k` after the kick of a step, relative to that which closes a gap from its stop."""
        constraint = self.constraints[k]
        return float(state.rates_after_kick[self.contact_outputs[k]]) - constraint.stop_side * constraint.closing_rate

    def _release_direction(self, k: int, rate: float) -> int:
        """Return the direction in which contact `k` is released, given its rate after a kick; 0 if it stays held or was not held."""
        constraint = self.constraints[k]
        rate_factor = RELEASE_RATE_FACTOR if constraint.stop_side and constraint.held_value is not None else 1.0
        if not constraint.is_needed or abs(rate) <= rate_factor * self._stiction_rates[k]:
            return 0
        direction = int(math.copysign(1.0, rate))
        if constraint.stop_side and (direction == constraint.stop_side or constraint.stop_force > 0.0):
            return 0
        return direction if constraint.held_value is None or constraint.is_saturated else 0

    def _friction_excess(self, k: int, state: StepState) -> float:
        """Return the event function of a slip: the holding force minus the friction limit."""
        constraint = self.constraints[k]
        return constraint.friction_force - float(state.inputs[constraint.friction_input])

    def _leave_value(self, k: int, direction: int, state: StepState) -> float:
        """Return the event function of a separation: the rate away from the stop, or minus the force of a stop that pushes alone."""
        constraint = self.constraints[k]
        rate = direction * self._rate_after_kick(k, state)
        if constraint.held_value is not None:
            return rate - self._stiction_rates[k]
        return -constraint.stop_force if constraint.stop_force > 0.0 else rate

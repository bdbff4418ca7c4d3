"""Transition of all contacts at one time: springs, impacts, settling bounces, new contact states, and their events."""

from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from governor_mechanism.mechanics.contact import rules
from governor_mechanism.mechanics.contact.impacts import resolve_impacts, settle_final_bounces
from governor_mechanism.mechanics.contact.rules import ContactDynamics
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.numerics.jit import jit
from governor_mechanism.types import NO_INDEX, BoolArray, FloatArray, IntArray

EVENT_KINDS = tuple(EventKind)
"""Kinds of events; their positions are the codes in an event log."""

STICK_EVENT, SLIP_EVENT, IMPACT_EVENT, REST_EVENT, SEPARATION_EVENT, SLACK_EVENT, TAUT_EVENT = range(7)
"""Codes of the contact events, in the order of `EventKind`."""


class EventLog(NamedTuple):
    """Events of contacts and one-sided springs, for compiled functions."""

    # time (s), code of the kind, and index of the contact, or of the spring counted after the contacts; shape
    # (capacity, 3)
    records: FloatArray
    counts: IntArray  # number of events, also of those beyond the capacity, and of the last simultaneous ones; shape (2,)


def make_event_log(capacity: int) -> EventLog:
    """Return an empty event log."""
    return EventLog(np.empty((capacity, 3)), np.zeros(2, dtype=np.int64))


def make_events(log: EventLog, subjects: Sequence[str]) -> list[Event]:
    """Return the recorded events in their order."""
    records = log.records[: log.counts[0]].tolist()
    return [Event(time=time, kind=EVENT_KINDS[int(code)], subject=subjects[int(index)]) for time, code, index in records]


@jit
def record_event(
    log: EventLog,
    time: float,  # time of the event, s
    kind: int,
    subject: int,  # index of the contact, or of the spring counted after the contacts
) -> None:
    """Record an event while there is capacity, and count it."""
    n_events = log.counts[0]
    if n_events < log.records.shape[0]:
        log.records[n_events, 0] = time
        log.records[n_events, 1] = kind
        log.records[n_events, 2] = subject
    log.counts[0] += 1


@jit
def record_hold_changes(
    dynamics: ContactDynamics,
    previous_states: IntArray,  # state of each contact before; shape (contacts,)
    states: IntArray,  # state of each contact now; shape (contacts,)
    time: float,  # time of the transition, s
    durations: FloatArray,  # how long the final bounces of each contact go on, s; shape (contacts,)
    log: EventLog,
) -> None:
    """Record contacts that come to rest or start to move; which of several redundant ones carries the load is not recorded."""
    for k in range(states.size):
        rests = rules.is_resting(dynamics, states, k)
        normal = dynamics.contacts[k].normal
        if normal != NO_INDEX and states[normal] != rules.HELD:
            continue  # what leaves does not slip
        if rests != rules.is_resting(dynamics, previous_states, k):
            start, end = (REST_EVENT, SEPARATION_EVENT) if rules.find_active_stop(dynamics, k) != 0 else (STICK_EVENT, SLIP_EVENT)
            record_event(log, time + durations[k], start if rests else end, k)


Model = TypeVar("Model")


def make_transition(
    # return the motion of the contacts in the present state of a model
    evaluate_dynamics: Callable[[Model], ContactDynamics],
    # change the velocities of a model by impulses along the outputs, shape (contacts,), from the given motion
    # of the contacts
    apply_impulses: Callable[[Model, ContactDynamics, FloatArray], None],
) -> Callable[[Model, IntArray, IntArray, BoolArray, float, EventLog], ContactDynamics]:
    """Return the transition of all contacts of a model, a function that may be compiled if the arguments are."""
    # Its arguments are the model, the states of its contacts and the segments of its springs (both
    # changed in place), the contacts that cannot hold, the time (s) and the event log; it returns the
    # motion of the contacts after the impulses.

    def change_contact_states(
        model: Model,
        states: IntArray,  # state of each contact; changed in place; shape (contacts,)
        segments: IntArray,  # segment of each one-sided spring; changed in place; shape (springs,)
        is_released: BoolArray,  # contacts that cannot hold; shape (contacts,)
        time: float,  # time of the transition, s
        log: EventLog,
    ) -> ContactDynamics:
        """Change the states where springs, strikes or holds change, and return the motion of the contacts after the impulses."""
        previous_states, n_contacts = states.copy(), states.size
        dynamics = evaluate_dynamics(model)
        has_changed = rules.update_spring_segments(dynamics, segments)
        for i in range(segments.size):
            if has_changed[i]:
                record_event(log, time, TAUT_EVENT if segments[i] == 1 else SLACK_EVENT, n_contacts + i)
        if np.any(has_changed):
            dynamics = evaluate_dynamics(model)
        impulses, durations = np.zeros(n_contacts), np.zeros(n_contacts)
        has_struck = resolve_impacts(dynamics, states, impulses)
        if np.any(has_struck):
            for k in range(n_contacts):
                if has_struck[k]:
                    record_event(log, time, IMPACT_EVENT, k)
            apply_impulses(model, dynamics, impulses)
            dynamics = evaluate_dynamics(model)
            impulses[:] = 0.0
            if settle_final_bounces(dynamics, states, has_struck, impulses, durations):
                apply_impulses(model, dynamics, impulses)
                dynamics = evaluate_dynamics(model)
        rules.select_contact_states(dynamics, is_released, states)
        record_hold_changes(dynamics, previous_states, states, time, durations, log)
        return dynamics

    return change_contact_states

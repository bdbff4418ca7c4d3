"""Events of two runs of one scene compared, and what was assembled for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.contacts import contacts_of, output_dampers_of, output_springs_of
from governor_mechanism.mechanics.dynamics.lowering import forced_output_names
from governor_mechanism.mechanics.kinematics.constraint_equations import make_constraint_table
from governor_mechanism.model.events import Event, EventKind
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def compare_event_logs(
    better: Sequence[Event], worse: Sequence[Event], times: FloatArray, time_tolerance: float
) -> tuple[float, NDArray[np.bool_]]:
    """How late (s) events of one run come in the other at most, and which times (n,) s lie too near one to compare.

    Near is within `apart` (s). An event that the other run has not counts as late by the time to the next of its kind
    there, or to the end.
    """
    largest_delay, is_near_event = 0.0, np.zeros(len(times), dtype=np.bool_)
    end = float(times[-1]) if len(times) else 0.0
    for events, others in ((better, worse), (worse, better)):
        for event in events:
            if event.time > end:
                continue
            time_differences = [abs(event.time - other.time) for other in others
                    if (event.kind, event.subject) == (other.kind, other.subject)]  # fmt: skip
            largest_delay = max(largest_delay, min([*time_differences, max(end - event.time, time_tolerance)]))
            is_near_event |= np.abs(times - event.time) <= time_tolerance
    return largest_delay, is_near_event


OPPOSITE_EVENTS = {
    EventKind.SLIP: EventKind.STICK,
    EventKind.SEPARATION: EventKind.REST,
    EventKind.STICK: EventKind.SLIP,
    EventKind.REST: EventKind.SEPARATION,
}
"""What each of these undoes."""


def drop_cancelled_events(events: Sequence[Event], time_tolerance: float) -> tuple[Event, ...]:
    """Events less those that one at the same time (within `apart` s) undid: a hold handed on, and never taken."""
    remaining: list[Event] = []
    for event in events:
        cancelled = [
            index
            for index, other in enumerate(remaining)
            if other.subject == event.subject
            and other.kind == OPPOSITE_EVENTS.get(event.kind)
            and abs(event.time - other.time) <= time_tolerance
        ]
        if cancelled:
            del remaining[cancelled[-1]]
        else:
            remaining.append(event)
    return tuple(remaining)


def count_model_size(scene: Scene) -> Mapping[str, int]:
    """How much of each was put together for a scene: nothing that it does not list."""
    mechanism, contacts = scene.part.mechanism, contacts_of(scene)
    counts = {
        "bodies": len(mechanism.bodies),
        "joint equations": len(make_constraint_table(mechanism).joint_indices),
        "loads of the mechanism": len(mechanism.force_elements),
        "readings acted along": len(forced_output_names(scene)),
        "springs and brakes along readings": len(output_springs_of(scene)) + len(output_dampers_of(scene)),
        "frictions": sum(contact.friction is not None for contact in contacts),
        "stops": sum(int(np.isfinite(contact.low)) + int(np.isfinite(contact.high)) for contact in contacts),
    }
    return {name: count for name, count in counts.items() if count}

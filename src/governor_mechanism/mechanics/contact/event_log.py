"""Events of two runs of one scene compared, and what was assembled for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.mechanics.dynamics.contacts import brakes_of, keepers_of, springs_of
from governor_mechanism.mechanics.dynamics.lowering import acted_on
from governor_mechanism.mechanics.kinematics.constraint_equations import joint_table
from governor_mechanism.model.events import LEAVES, RESTS, SLIPS, STICKS, Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray


def compared(
    better: Sequence[Event], worse: Sequence[Event], times: FloatArray, apart: float
) -> tuple[float, NDArray[np.bool_]]:
    """How late (s) events of one run come in the other at most, and which times (n,) s lie too near one to compare.

    Near is within `apart` (s). An event that the other run has not counts as late by the time to the next of its kind
    there, or to the end.
    """
    late, near = 0.0, np.zeros(len(times), dtype=np.bool_)
    end = float(times[-1]) if len(times) else 0.0
    for events, others in ((better, worse), (worse, better)):
        for event in events:
            if event.time > end:
                continue
            same = [abs(event.time - other.time) for other in others
                    if (event.kind, event.subject) == (other.kind, other.subject)]  # fmt: skip
            late = max(late, min([*same, max(end - event.time, apart)]))
            near |= np.abs(times - event.time) <= apart
    return late, near


BEGINNINGS = {SLIPS: STICKS, LEAVES: RESTS, STICKS: SLIPS, RESTS: LEAVES}
"""What each of these undoes."""


def without_passing(events: Sequence[Event], apart: float) -> tuple[Event, ...]:
    """Events less those that one at the same time (within `apart` s) undid: a hold handed on, and never taken."""
    kept: list[Event] = []
    for event in events:
        undone = [
            at
            for at, other in enumerate(kept)
            if other.subject == event.subject
            and other.kind == BEGINNINGS.get(event.kind)
            and abs(event.time - other.time) <= apart
        ]
        if undone:
            del kept[undone[-1]]
        else:
            kept.append(event)
    return tuple(kept)


def assembled(scene: Scene) -> Mapping[str, int]:
    """How much of each was put together for a scene: nothing that it does not list."""
    mechanism, keepers = scene.part.mechanism, keepers_of(scene)
    counts = {
        "bodies": len(mechanism.bodies),
        "joint equations": len(joint_table(mechanism).owner),
        "loads of the mechanism": len(mechanism.loads),
        "readings acted along": len(acted_on(scene)),
        "springs and brakes along readings": len(springs_of(scene)) + len(brakes_of(scene)),
        "frictions": sum(keeper.friction is not None for keeper in keepers),
        "stops": sum(int(np.isfinite(keeper.low)) + int(np.isfinite(keeper.high)) for keeper in keepers),
    }
    return {name: count for name, count in counts.items() if count}

"""Joint reactions and events of a run, computed on first access."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.inverse_dynamics import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import StateHistory
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.observables.reactions import compute_reactions
from governor_mechanism.observables.singular_configurations import DenseOutput, SampledMotion, find_singular_configurations
from governor_mechanism.types import IntArray

StateProvider = Callable[[], tuple[StateHistory, DenseOutput | None]]
"""Function that computes the states at the monitor times, and a dense output between them where there is one."""


@dataclass(frozen=True)
class DeferredMotionAnalysis:
    """States of a run from which joint reactions and events are computed on request.

    monitor_states may be a function that computes them. contact_modes are those at the monitor times;
    reported_indices selects the reported ones. contact_events are the events the engine located itself.
    """

    scene: Scene
    reported_states: StateHistory
    monitor_states: StateHistory | StateProvider
    mobility: int
    dense_output: DenseOutput | None
    contact_modes: tuple[ContactMode, ...] = ()
    reported_indices: slice | IntArray | None = None
    contact_events: tuple[Event, ...] = ()

    def reactions(self) -> dict[str, Reaction]:
        """Return the reaction of every joint, by name, at the reported times."""
        contact_modes = tuple(np.array(self.contact_modes, dtype=object)[self.reported_indices]) if self.contact_modes else ()
        return compute_reactions(
            self.scene.part.mechanism, self.reported_states.poses, self._evaluate_dynamics(self.reported_states, contact_modes)
        )

    def events(self) -> tuple[Event, ...]:
        """Return all events in the order of time."""
        singular_configurations = () if self.contact_modes else self._find_singular_configurations()
        return tuple(sorted((*singular_configurations, *self.contact_events), key=lambda event: event.time))

    def _find_singular_configurations(self) -> tuple[Event, ...]:
        history, dense_output = (
            (self.monitor_states, self.dense_output) if isinstance(self.monitor_states, StateHistory) else self.monitor_states()
        )
        motion_dynamics = self._evaluate_dynamics(history, self.contact_modes)
        motion = SampledMotion(
            history.times, history.poses, history.velocities, motion_dynamics.accelerations, motion_dynamics.pivot_ratios, dense_output
        )
        return tuple(find_singular_configurations(self.scene.part.mechanism, motion, self.mobility))

    def _evaluate_dynamics(self, history: StateHistory, contact_modes: tuple[ContactMode, ...]) -> InverseDynamics:
        return compute_inverse_dynamics(
            self.scene, history.times, history.poses, history.velocities, history.spindle_state[:, 1], contact_modes
        )

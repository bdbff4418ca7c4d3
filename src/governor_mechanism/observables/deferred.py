"""Joint reactions and events of a run, computed on first access."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.inverse_dynamics import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import StateHistory
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.observables.reactions import compute_reactions
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.observables.singular_configurations import SampledMotion, find_singular_configurations


@dataclass(frozen=True)
class DeferredMotionAnalysis:
    """Result of a run from which joint reactions and events are computed on request."""

    scene: Scene
    result: RunResult
    mobility: int

    def reactions(self) -> dict[str, Reaction]:
        """Return the reaction of every joint, by name, at the reported times."""
        states, modes = self.result.reported_states, self.result.contact_modes
        reported_modes = tuple(np.array(modes, dtype=object)[self.result.reported_indices]) if modes else ()
        return compute_reactions(self.scene.mechanism, states.poses, self._evaluate_dynamics(states, reported_modes))

    def events(self) -> tuple[Event, ...]:
        """Return all events in the order of time."""
        singular_configurations = () if self.result.contact_modes else self._find_singular_configurations()
        return tuple(sorted((*singular_configurations, *self.result.contact_events), key=lambda event: event.time))

    def _find_singular_configurations(self) -> tuple[Event, ...]:
        states, dense_output = self.result.monitor_states, self.result.dense_output
        if not isinstance(states, StateHistory):
            states, dense_output = states()
        dynamics = self._evaluate_dynamics(states, ())
        motion = SampledMotion(states.times, states.poses, states.velocities, dynamics.accelerations, dynamics.pivot_ratios, dense_output)
        return find_singular_configurations(self.scene.mechanism, motion, self.mobility)

    def _evaluate_dynamics(self, states: StateHistory, contact_modes: tuple[ContactMode, ...]) -> InverseDynamics:
        return compute_inverse_dynamics(self.scene, states.times, states.poses, states.velocities, states.lags, contact_modes)

"""Joint reactions and events of a run, computed on first access."""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import ContactMode
from governor_mechanism.mechanics.dynamics.inverse_dynamics import InverseDynamics, compute_inverse_dynamics
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.observables.crossings import find_crossings
from governor_mechanism.observables.reactions import compute_reactions
from governor_mechanism.observables.run_result import RunResult
from governor_mechanism.observables.singular_configurations import SampledMotion, find_singular_configurations
from governor_mechanism.observables.state_history import StateHistory


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
        events, has_contacts = list(self.result.contact_events), bool(self.result.contact_modes)
        if self.result.n_reached and (self.scene.crossings or not has_contacts):
            motion = self._sample_motion()
            events += self._find_crossings(motion)
            if not has_contacts:
                events += find_singular_configurations(self.scene.mechanism, motion, self.mobility)
        return tuple(sorted(events, key=lambda event: event.time))

    def _sample_motion(self) -> SampledMotion:
        states, modes, dense_output = self.result.monitor_states, self.result.contact_modes, self.result.dense_output
        if not isinstance(states, StateHistory):
            states, modes, dense_output = states()
        dynamics = self._evaluate_dynamics(states, modes)
        contact_times = np.unique([event.time for event in self.result.contact_events])
        motion = states.times, states.poses, states.velocities, dynamics.accelerations
        return SampledMotion(*motion, dynamics.pivot_ratios, dense_output or (lambda k, time: None), contact_times)

    def _find_crossings(self, motion: SampledMotion) -> list[Event]:
        """Return the named crossings; without an error estimate, the errors are taken to be those that the scene asks for."""
        mechanism, result = self.scene.mechanism, self.result
        allowed = {item.reading: self.scene.run.accuracy * mechanism.output_scale(item.reading) for item in self.scene.crossings}
        start_values = {name: float(values[0]) for name, values in result.observables.readings.items()}
        start = float(result.reported_states.times[0]), start_values
        return find_crossings(mechanism, motion, self.scene.crossings, allowed | result.reading_errors, start)

    def _evaluate_dynamics(self, states: StateHistory, contact_modes: tuple[ContactMode, ...]) -> InverseDynamics:
        return compute_inverse_dynamics(self.scene, states.times, states.poses, states.velocities, states.lags, contact_modes)

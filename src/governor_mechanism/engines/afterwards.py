"""Joint forces and events of a run, reckoned when someone asks for them."""

from __future__ import annotations

from dataclasses import dataclass

from governor_mechanism.engines.events import Between, Stations, find_events
from governor_mechanism.engines.reactions import reactions
from governor_mechanism.engines.state import State
from governor_mechanism.equations.dynamics import Dynamics, dynamics
from governor_mechanism.scene import Scene
from governor_mechanism.trajectory import Event, Reaction


@dataclass(frozen=True)
class Told:
    """What a run's states at its reported times, and at all its stations, imply."""

    scene: Scene
    reported: State
    stations: State
    mobility: int
    between: Between | None

    def reactions(self) -> dict[str, Reaction]:
        """Of every joint, by name."""
        return reactions(self.scene.part.mechanism, self.reported.poses, self._implied(self.reported))

    def events(self) -> tuple[Event, ...]:
        """In the order of time."""
        found, at = self._implied(self.stations), self.stations
        motion = Stations(at.times, at.poses, at.velocities, found.accelerations, found.independence, self.between)
        return find_events(self.scene.part.mechanism, motion, self.mobility)

    def _implied(self, state: State) -> Dynamics:
        return dynamics(self.scene, state.times, state.poses, state.velocities, state.spindle[:, 1])

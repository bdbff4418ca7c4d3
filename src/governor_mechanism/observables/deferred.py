"""Joint forces and events of a run, reckoned when someone asks for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics.contacts import Mode
from governor_mechanism.mechanics.dynamics.inverse_dynamics import Dynamics, dynamics
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.state_history import State
from governor_mechanism.model.trajectory import Reaction
from governor_mechanism.observables.reactions import reactions
from governor_mechanism.observables.singular_configurations import Between, Stations, find_events
from governor_mechanism.types import IntArray

Stationed = Callable[[], tuple[State, Between | None]]


@dataclass(frozen=True)
class Told:
    """What a run's states at its reported times, and at all its stations, imply.

    stations may be something that finds them, and what lies between, when they are asked for. modes are those at the
    stations, which times[which] of them are reported; happened is what stuck and struck.
    """

    scene: Scene
    reported: State
    stations: State | Stationed
    mobility: int
    between: Between | None
    modes: tuple[Mode, ...] = ()
    which: slice | IntArray | None = None
    happened: tuple[Event, ...] = ()

    def reactions(self) -> dict[str, Reaction]:
        """Of every joint, by name."""
        modes = tuple(np.array(self.modes, dtype=object)[self.which]) if self.modes else ()
        return reactions(self.scene.part.mechanism, self.reported.poses, self._implied(self.reported, modes))

    def events(self) -> tuple[Event, ...]:
        """In the order of time."""
        passed = () if self.modes else self._passed()
        return tuple(sorted((*passed, *self.happened), key=lambda event: event.time))

    def _passed(self) -> tuple[Event, ...]:
        at, between = (self.stations, self.between) if isinstance(self.stations, State) else self.stations()
        found = self._implied(at, self.modes)
        motion = Stations(at.times, at.poses, at.velocities, found.accelerations, found.independence, between)
        return tuple(find_events(self.scene.part.mechanism, motion, self.mobility))

    def _implied(self, state: State, modes: tuple[Mode, ...]) -> Dynamics:
        return dynamics(self.scene, state.times, state.poses, state.velocities, state.spindle[:, 1], modes)

"""Joint forces and events of a run, reckoned when someone asks for them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.events import Between, Stations, find_events
from governor_mechanism.engines.reactions import reactions
from governor_mechanism.engines.state import State
from governor_mechanism.equations.dynamics import Dynamics, dynamics
from governor_mechanism.equations.modes import Mode
from governor_mechanism.equations.points import Whole
from governor_mechanism.scene import Scene
from governor_mechanism.trajectory import Event, Reaction


@dataclass(frozen=True)
class Told:
    """What a run's states at its reported times, and at all its stations, imply.

    modes are those at the stations, which times[which] of them are reported; happened is what stuck and struck.
    """

    scene: Scene
    reported: State
    stations: State
    mobility: int
    between: Between | None
    modes: tuple[Mode, ...] = ()
    which: slice | Whole | None = None
    happened: tuple[Event, ...] = ()

    def reactions(self) -> dict[str, Reaction]:
        """Of every joint, by name."""
        modes = tuple(np.array(self.modes, dtype=object)[self.which]) if self.modes else ()
        return reactions(self.scene.part.mechanism, self.reported.poses, self._implied(self.reported, modes))

    def events(self) -> tuple[Event, ...]:
        """In the order of time."""
        found, at = self._implied(self.stations, self.modes), self.stations
        motion = Stations(at.times, at.poses, at.velocities, found.accelerations, found.independence, self.between)
        passed = find_events(self.scene.part.mechanism, motion, self.mobility) if not self.modes else ()
        return tuple(sorted((*passed, *self.happened), key=lambda event: event.time))

    def _implied(self, state: State, modes: tuple[Mode, ...]) -> Dynamics:
        return dynamics(self.scene, state.times, state.poses, state.velocities, state.spindle[:, 1], modes)

"""Contact mode of a multibody run: the system of each mode, in which held outputs are constraints."""

from __future__ import annotations

import math
from collections.abc import Sequence

from governor_mechanism.mechanics.contact.scene_contacts import SceneContacts
from governor_mechanism.mechanics.contact.tolerances import SIMULTANEITY_TOLERANCE
from governor_mechanism.mechanics.dynamics.contacts import ContactColumn, ContactMode
from governor_mechanism.mechanics.dynamics.equations_of_motion import project_state
from governor_mechanism.mechanics.dynamics.lowering import System, SystemWorkspace, make_system, make_system_workspace, with_held_values
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

ContactModeKey = tuple[tuple[int | None, ...], tuple[int, ...], tuple[bool, ...], bool]
"""Properties shared by modes whose systems differ only in the held values."""


class ContactModeSolver:
    """Contact mode of one scene in the course of a run, and the system of the mode."""

    def __init__(self, scene: Scene, time_scale: float, constraint_tolerance: float) -> None:
        self._scene, self._time_scale, self._constraint_tolerance = scene, time_scale, constraint_tolerance
        self._scene_contacts = SceneContacts(scene, time_scale)
        self._models: dict[ContactModeKey, tuple[ContactMode, System, SystemWorkspace]] = {}
        self._released_at, self._released = -math.inf, set[int]()

    @property
    def mode(self) -> ContactMode:
        """Return the current contact mode."""
        return self._scene_contacts.mode

    @property
    def events(self) -> list[Event]:
        """Return the events so far."""
        return self._scene_contacts.events

    @property
    def system(self) -> System:
        """Return the system of the current mode."""
        return self._get_model()[0]

    @property
    def workspace(self) -> SystemWorkspace:
        """Return the workspace of the current mode's system."""
        return self._get_model()[1]

    def initialize(self, state: FloatArray, input_cubics: FloatArray) -> None:
        """Select the initial mode and clear the events."""
        self._scene_contacts.reset()
        self._released_at, self._released = -math.inf, set[int]()
        self.select_mode(0.0, state, input_cubics)
        self.events.clear()

    def select_mode(self, time: float, state: FloatArray, input_cubics: FloatArray, triggered: Sequence[int] = ()) -> None:
        """Select the mode after events of the contacts or springs `triggered`; impacts change the state in place.

        input_cubics count from `time` (s), the time of the state.
        """
        held_values = self.mode.held_values
        released = {k for k in triggered if k < len(held_values) and held_values[k] is not None}
        if time - self._released_at <= SIMULTANEITY_TOLERANCE * self._time_scale:
            released |= self._released  # else two redundant contacts could hold in turns without end
        self._released_at, self._released = time, released
        self._scene_contacts.change_mode(time, state, input_cubics, released)
        # The velocity that this removes is rounding.
        system, workspace = self._get_model()
        n_coordinates = 3 * len(system.bodies)
        poses, velocities = state[: 2 * n_coordinates].reshape(2, -1, 3)
        project_state(system, workspace, input_cubics, 0.0, poses, velocities, self._constraint_tolerance)

    def _get_model(self) -> tuple[System, SystemWorkspace]:
        """Return the system of the current mode and its workspace."""
        mode, contacts = self.mode, self._scene_contacts.contacts
        bounds = contacts[:, [ContactColumn.LOW, ContactColumn.HIGH]].tolist()
        holds = tuple(
            None if held is None else int(held >= high) - int(held <= low)
            for held, (low, high) in zip(mode.held_values, bounds, strict=True)
        )
        key = (holds, mode.sliding_signs, mode.taut, mode.is_locked)
        if key not in self._models:
            system = make_system(self._scene, mode)[0]
            self._models[key] = mode, system, make_system_workspace(system)
        built_mode, system, workspace = self._models[key]
        if built_mode != mode:
            outputs = contacts[:, ContactColumn.OUTPUT].astype(int).tolist()
            self._models[key] = mode, with_held_values(system, outputs, mode), workspace
        return self._models[key][1:]

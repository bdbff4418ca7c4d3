"""Joins of the edges of outlines that resting contacts touch: force or curvature jump there, and a step ends."""

from collections.abc import Iterator
from functools import partial

import numpy as np

from governor_mechanism.engines.impulse.records import DetectedEvent, StepState
from governor_mechanism.engines.impulse.staggered_stepper import StaggeredStepper
from governor_mechanism.mechanics.dynamics.system.arrays import System, from_mass_centres
from governor_mechanism.mechanics.dynamics.system.event_functions import EventFunctionKind
from governor_mechanism.mechanics.kinematics.constraint_kernels import evaluate_join, keep_features, release_features
from governor_mechanism.types import FloatArray


class OutlineJoins:
    """The edge or corner that each resting contact touches, and when it comes to the next one."""

    def __init__(self, stepper: StaggeredStepper) -> None:
        self._stepper = stepper
        self._contacts: list[tuple[int, int]] = []  # contacts on edges, and their constraint rows

    def keep(self, system: System) -> None:
        """Keep the edges that are touched in the present state, in the system of its contact mode."""
        functions = system.event_functions[system.event_functions["kind"] == EventFunctionKind.JOIN]
        self._contacts = list(zip(functions["contact_index"].tolist(), functions["source_index"].tolist(), strict=True))
        if not self._contacts:
            return
        self._system = system
        self._rows = system.constraint_rows._replace(table=system.constraint_rows.table.copy())
        motion = self._origin_motion(self._stepper.state)
        release_features(self._rows)
        keep_features(self._rows, *motion)
        keep_features(self._rows, *motion)  # just behind an end of the nearest one it is the next one

    def detect(self, end: StepState) -> Iterator[DetectedEvent]:
        """Yield the joins that a step to a state has passed."""
        for contact, row in self._contacts:
            if self._beyond_end(row, end) > 0.0:
                yield DetectedEvent(None, contact, partial(self._beyond_end, row), 0)

    def _beyond_end(self, row: int, state: StepState) -> float:
        """Return the event function of a join: how far a contact is beyond its edge."""
        return float(evaluate_join(self._rows, row, *self._origin_motion(state)))

    def _origin_motion(self, state: StepState) -> tuple[FloatArray, FloatArray]:
        """Return poses and velocities of the origins of the bodies; that of a free spindle touches nothing."""
        centres, velocities = self._stepper.model.to_mass_centres(state.poses, state.velocities)
        shaft = np.zeros((len(self._system.bodies) - len(centres), 3))
        return from_mass_centres(self._system, np.concatenate([centres, shaft]), np.concatenate([velocities, shaft]))

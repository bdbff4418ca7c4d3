"""Runs with effects built from geometry, so that drawings of them need no engine."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.machines.pendulum import PendulumBuilder, PendulumGovernor
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.events import Event
from governor_mechanism.model.results.trajectory import Trajectory
from stub_run import fake_run, sleeve_lift


@dataclasses.dataclass(frozen=True)
class ListedEvents:
    """Deferred results of a run: a list of events and no reactions."""

    listed: tuple[Event, ...] = ()

    def events(self) -> tuple[Event, ...]:
        return self.listed

    def reactions(self):
        return {}

    def states_near_events(self, times):
        return {}


def fake_run_with_effects(dimensions: dict[str, float], effects: Sequence[Effect], events: Sequence[Event] = (), **options) -> Trajectory:
    """Return a swinging governor with these effects; its sleeve oscillates in its clearance eleven times a second."""
    run = fake_run(dimensions, **options)
    governor = PendulumGovernor(**dimensions)
    rods, clearance = (next((effect for effect in effects if isinstance(effect, kind)), None) for kind in (RodMasses, Clearance))
    builder = PendulumBuilder(governor=governor, clearance=clearance, **(dataclasses.asdict(rods) if rods else {}))
    angles = run.readings["arm_angle"]
    poses = np.array([builder.poses(float(angle)) for angle in angles])
    readings = dict(run.readings)
    if clearance:
        offset = clearance.width / 2 * np.sin(2 * np.pi * 11 * run.times)
        poses[:, 2, 1] += offset
        readings |= {CLEARANCE_READING: offset, "sleeve_lift": sleeve_lift(governor, angles) + offset}
    scene = run.scene.with_changes(mechanism=governor.mechanism_with_effects(effects), effects=(*run.scene.effects, *effects))
    return dataclasses.replace(
        run,
        scene=scene,
        poses=poses,
        velocities=np.gradient(poses, run.times, axis=0),
        readings=readings,
        units=run.units | {CLEARANCE_READING: "m"},
        deferred_results=ListedEvents(tuple(events)),
    )

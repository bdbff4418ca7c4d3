"""The march of an assembly through time, and its settling to rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from governor_mechanism.engines.impulse.event_stepper import Passage
from governor_mechanism.engines.impulse.pymunk import Assembly
from governor_mechanism.engines.impulse.time_inputs import Clock
from governor_mechanism.integrators.time_grid import Grid
from governor_mechanism.mechanics.dynamics.contacts import Mode
from governor_mechanism.model.events import Event
from governor_mechanism.model.scene import Scene
from governor_mechanism.types import FloatArray

CHUNK = 256
"""Stations between two looks at whether the mechanism is still within its limits."""

LOST = 1e3
"""A body this many machine sizes away was thrown off by joints that were not solved."""


@dataclass(frozen=True)
class March:
    """Poses and velocities (stations, bodies, 3), work (stations,) J of a given spindle speed's changes, angle
    (stations,) rad of a free spindle, lost (stations,) J to brakes, friction and stops; shorter than the grid where it
    was given up. What happened, how everything stood at the stations, and how many steps were split where that was.
    """

    poses: FloatArray
    velocities: FloatArray
    work: FloatArray
    angle: FloatArray
    lost: FloatArray
    events: tuple[Event, ...] = ()
    modes: tuple[Mode, ...] = ()
    splits: int = 0


def march(
    assembly: Assembly,
    grid: Grid,
    level: int,
    clock: Clock,
    start: tuple[FloatArray, FloatArray],
    *,
    size: float,
    inside: Callable[[FloatArray], bool],
) -> March:
    """Run through the grid, each interval's steps doubled `level` times, from poses and velocities (bodies, 3).

    Given up where a body is lost, and soon after `inside` finds poses (stations, bodies, 3) outside their limits.
    """
    poses, velocities = start
    counts = grid.steps << level
    if counts.size == 0:
        return March(poses[np.newaxis], velocities[np.newaxis], np.zeros(1), np.zeros(1), np.zeros(1))
    lengths = np.diff(grid.stations) / counts
    following = np.append(lengths[1:], lengths[-1:])
    assembly.start(poses, velocities, clock.first(float(lengths[0])))
    clock.follow(assembly.spindle_inertia)
    if assembly.plain:
        kept = [(assembly.poses(), assembly.velocities(), 0.0, 0.0, 0.0)]
    else:  # the poses have just arrived at the start; the velocities are already half a step ahead
        kept = [(assembly.poses(), _carried(assembly, velocities), 0.0, 0.0, 0.0)]
    for index, (h, next_h) in enumerate(zip(lengths.tolist(), following.tolist(), strict=True)):
        # The last kick lasts half of this step and half of the next, whose length may be another.
        clock.interval(grid.stations[index], grid.stations[index + 1], int(counts[index]), next_h)
        try:
            older, before = _advance(assembly, int(counts[index]), clock)
        except (ValueError, OverflowError):  # a body flew off so fast that its place is no number any more
            break
        after, here = assembly.velocities(), assembly.poses()
        if assembly.plain:
            centred = after
        elif clock.jumps:  # the load jumps here, so the mean of both sides is not the velocity: look back only
            centred = before + 0.5 * (before - older)
        else:
            centred = (next_h * before + h * after) / (h + next_h)
        if not np.max(np.abs(here[:, :2])) < LOST * size:
            break
        kept.append((here, centred, clock.work, clock.angle, assembly.lost))
        if len(kept) % CHUNK == 0 and not inside(_mass_centres(assembly, kept[-CHUNK:])):
            break
    carried = [np.array(column) for column in zip(*kept, strict=True)]
    centres, moving = assembly.of_mass_centres(carried[0], carried[1])
    return March(centres, moving, carried[2], carried[3], carried[4])


def march_through(
    scene: Scene,
    assembly: Assembly,
    grid: Grid,
    level: int,
    clock: Clock,
    start: tuple[FloatArray, FloatArray],
    *,
    second: float,
    size: float,
    inside: Callable[[FloatArray], bool],
) -> March:
    """The same where something may stick, strike or go slack on the way; second (s) is the time scale."""
    counts = grid.steps << level
    lengths = np.diff(grid.stations) / counts if counts.size else np.ones(1)
    following = np.append(lengths[1:], lengths[-1:])
    passage = Passage(scene, assembly, clock, start, second=second, level=level, h=float(lengths[0]))
    kept, modes = [(*start, 0.0, 0.0, passage.lost)], [passage.mode]
    for index, next_h in enumerate(following[: counts.size].tolist()):
        begin, end = float(grid.stations[index]), float(grid.stations[index + 1])
        try:
            on = passage.through(begin, end, int(counts[index]), next_h)
        except (ValueError, OverflowError, np.linalg.LinAlgError):
            break
        poses, velocities = passage.states()
        if not (on and np.max(np.abs(poses[:, :2])) < LOST * size):
            break
        kept.append((poses, velocities, clock.work, clock.angle, passage.lost))
        modes.append(passage.mode)
        if len(kept) % CHUNK == 0 and not inside(np.array([state[0] for state in kept[-CHUNK:]])):
            break
    columns = [np.array(column) for column in zip(*kept, strict=True)]
    return March(
        columns[0], columns[1], columns[2], columns[3], columns[4], tuple(passage.events), tuple(modes), passage.splits
    )


def _mass_centres(assembly: Assembly, kept: list[tuple[FloatArray, FloatArray, float, float, float]]) -> FloatArray:
    poses, velocities = (np.array([state[which] for state in kept]) for which in (0, 1))
    return assembly.of_mass_centres(poses, velocities)[0]


def _carried(assembly: Assembly, velocities: FloatArray) -> FloatArray:
    """The start's velocities as the carriers have them: a lever's centre is its pin, which stands still."""
    return np.where(assembly.levers()[:, np.newaxis], velocities * np.array([0.0, 0.0, 1.0]), velocities)


def _advance(assembly: Assembly, count: int, clock: Clock) -> tuple[FloatArray, FloatArray]:
    """Step through one interval; velocities before the last kick but one (if it is asked for), and before the last."""
    older = np.empty(0)
    for index in range(count):
        if index == count - 1:
            before = assembly.velocities()
        elif clock.jumps and index == count - 2:
            older = assembly.velocities()
        assembly.step(clock.moment(index))
    return older, before


JOINT_STEPS = 3
"""Steps after a stop in which the joints take up what the stop left open; their speeds are no swing's."""


@dataclass(frozen=True)
class Settled:
    """Poses (bodies, 3) at rest, and the steps it took; `at_rest` is False where it did not settle."""

    poses: FloatArray
    steps: int
    at_rest: bool


def settle(
    assembly: Assembly,
    h: float,
    clock: Clock,
    poses: FloatArray,
    *,
    still: float,
    inside: Callable[[FloatArray], bool],
    most: int,
) -> Settled:
    """Let go of the mechanism and take its motion away whenever it is fastest, until it stays where it is.

    Between two such stops it swings from rest toward its equilibrium, so the distance shrinks about a hundredfold each
    time. `still` (J) is the largest kinetic energy that counts as rest; `inside` says whether poses are in range.
    """
    assembly.start(poses, np.zeros_like(poses), clock.first(h))
    steady = clock.held(h)
    fastest, since = 0.0, 0
    for steps in range(most):
        now = assembly.kinetic_energy()
        if since > JOINT_STEPS and now < fastest:  # past the fastest: the equilibrium lies just behind
            if fastest < still:
                return Settled(_poses_now(assembly), steps, True)
            assembly.rest()
            fastest, since = 0.0, 0
            if not inside(_poses_now(assembly)):
                break
        if since >= JOINT_STEPS:
            fastest = max(fastest, now)
        since += 1
        assembly.step(steady)
    return Settled(_poses_now(assembly), steps, False)


def _poses_now(assembly: Assembly) -> FloatArray:
    return assembly.of_mass_centres(assembly.poses(), assembly.velocities())[0]

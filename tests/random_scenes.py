"""Scenes drawn at random: every machine, with effects along its readings.

A scene follows from a seed and a number. What the package refuses is drawn again, and kept count of.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from governor_mechanism.effects.clearance import PLAY
from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.engines.initial_state import starting_state
from governor_mechanism.errors import GovernorMechanismError, MechanismError
from governor_mechanism.mechanics.dynamics.characteristic_scales import time_scale
from governor_mechanism.mechanics.dynamics.contacts import switches
from governor_mechanism.mechanics.kinematics.assembly import Assembler
from governor_mechanism.mechanics.kinematics.output_variables import measure
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import Program
from governor_mechanism.scenes.parser import scene_from_document
from random_machines import MACHINES, G, Random, between, chance, of_any_size, one_of, restitution

MOST_DRAWS = 200
"""So many refusals in a row mean that the generator is wrong, not its luck."""


@dataclass(frozen=True)
class Gauge:
    """A reading that effects may act along: where it starts, how it follows the coordinate, what is much for it.

    span is what the coordinate moves in a swing; weight, inertia and unit are those of the coordinate.
    """

    name: str
    value: float
    slope: float
    span: float
    weight: float
    inertia: float
    unit: float
    rate: float


def gauges(scene: Scene) -> list[Gauge]:
    """The readings of a scene that its coordinate moves."""
    mechanism = scene.part.mechanism
    poses, _ = starting_state(scene)
    assembler = Assembler(mechanism)
    coordinate = mechanism.reading(mechanism.coordinate)
    unit = 1.0 if coordinate.quantity == "angle" else mechanism.size
    plays = PLAY in [reading.name for reading in mechanism.readings]
    try:
        ways = assembler.velocities(poses, {coordinate.name: 1.0} | ({PLAY: 0.0} if plays else {}))
    except MechanismError:  # driven, so that its rate is not for anyone to say
        _, ways = starting_state(scene)
        ways = ways * time_scale(scene)
    mass = sum(body.mass for body in mechanism.bodies)
    reach = mechanism.size / unit
    found = []
    for reading in mechanism.readings:
        here = measure(mechanism, reading.name, poses)
        slope = float(np.sum(here.gradient * ways))
        if reading.name != PLAY and abs(slope) > 0.1 * (1.0 if reading.quantity == "angle" else mechanism.size) / unit:
            found.append(
                Gauge(
                    name=reading.name,
                    value=float(here.value),
                    slope=slope,
                    span=0.1 * unit,
                    weight=mass * G * reach,
                    inertia=mass * reach**2,
                    unit=unit,
                    rate=1 / time_scale(scene),
                )
            )
    return found


def friction(random: Random, at: Gauge, duration: float) -> Effect:
    """A force that holds little or much, steady or relieved for a time."""
    force = at.weight / abs(at.slope) * of_any_size(random, 5e-4, 0.1)
    if chance(random, 0.7):
        return DryFriction(reading=at.name, force=Program(values=(force,)))
    times = tuple(duration * share for share in (0.0, 0.4, 0.4, 0.5, 0.5))
    return DryFriction(reading=at.name, force=Program(times=times, values=(force, force, 0.0, 0.0, force)))


def brake(random: Random, at: Gauge, _: float) -> Effect:
    """Linear, quadratic, or both."""
    linear = at.inertia * at.rate / at.slope**2 * of_any_size(random, 0.003, 0.6)
    quadratic = at.inertia / at.unit / abs(at.slope) ** 3 * of_any_size(random, 0.02, 2.0)
    kind = int(random.integers(3))
    return OilBrake(reading=at.name, linear=linear if kind != 1 else 0.0, quadratic=quadratic if kind != 0 else 0.0)


def spring(random: Random, at: Gauge, _: float) -> Effect:
    """Of any stiffness; some one-sided, and then slack or taut in turns."""
    rate = at.inertia * at.rate**2 / at.slope**2 * of_any_size(random, 0.01, 1.0)
    zero = at.value + at.span * abs(at.slope) * between(random, -0.8, 0.8)
    return SpringOn(reading=at.name, rate=rate, zero=zero, one_sided=chance(random, 0.5))


def stops(random: Random, at: Gauge, _: float) -> Effect:
    """On one side or on both, near enough to be struck."""
    low, high = (at.value + side * at.span * abs(at.slope) * between(random, 0.1, 1.5) for side in (-1.0, 1.0))
    kind = int(random.integers(4))
    return Stops(
        reading=at.name,
        low=low if kind != 1 else -math.inf,
        high=high if kind != 2 else math.inf,
        restitution=restitution(random),
    )


EFFECTS = (friction, brake, spring, stops)
NUMBERS = (0, 0, 1, 1, 2, 3)
"""Of effects along readings: a third of the scenes have none."""


def with_effects(random: Random, scene: Scene) -> Scene:
    """A scene with some effects along its readings."""
    where = gauges(scene)
    if not where:
        return scene
    # A stop against a drive is no motion: the run ends there.
    kinds = EFFECTS[:-1] if Assembler(scene.part.mechanism).equations.driven.any() else EFFECTS
    order = random.permutation(len(kinds))
    made = [kinds[k](random, one_of(random, where), scene.run.duration) for k in order]
    return replace(scene, effects=(*scene.effects, *made[: one_of(random, NUMBERS)]))


@dataclass(frozen=True)
class Drawn:
    """A random scene, and the refusals that came before it."""

    seed: int
    number: int
    machine: str
    scene: Scene
    refused: tuple[str, ...] = ()

    @property
    def group(self) -> str:
        """Plain, with smooth effects, or with what sticks, strikes or goes slack."""
        if switches(self.scene):
            return "events"
        return "smooth effects" if self.scene.acting else "plain"

    @property
    def words(self) -> str:
        """What is in it."""
        names = [f"{type(one).__name__} on {one.reading}" for one in self.scene.acting]
        turned = type(self.scene.spindle).__name__ if self.scene.centrifugal else ""
        return ", ".join(filter(None, [self.machine, turned, *names]))


def random_scene(number: int, seed: int) -> Drawn:
    """The scene of that number; machines take turns, all else is drawn."""
    random = np.random.default_rng([seed, number])
    machine = list(MACHINES)[number % len(MACHINES)]
    refused: list[str] = []
    while len(refused) < MOST_DRAWS:
        try:
            scene = with_effects(random, scene_from_document(MACHINES[machine](random)))
            starting_state(scene)
        except GovernorMechanismError as error:
            refused.append(str(error))
            continue
        return Drawn(seed, number, machine, scene, tuple(refused))
    raise AssertionError(f"{machine}: nothing but refusals, the last: {refused[-1]}")

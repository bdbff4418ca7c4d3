"""How the parts of a scene that stick, strike and go slack stand at a moment, and what there is of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.dashpot import OilBrake
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import SpringOn
from governor_mechanism.effects.stops import Stops
from governor_mechanism.mechanics.dynamics.force_laws import spring_energy
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import Program
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Keeper:
    """What may hold one reading: dry friction (N or N m, in time), stops (m or rad), or both."""

    reading: str
    friction: Program | None = None
    low: float = -math.inf
    high: float = math.inf
    restitution: float = 0.0


@dataclass(frozen=True)
class Mode:
    """How each keeper and each one-sided spring stands.

    held: the value (m or rad) at which a keeper holds its reading, or None; sliding: the sign of the motion that
    friction opposes, 0 where there is none; taut: whether a one-sided spring pulls; still: whether so much is held that
    nothing can move.
    """

    held: tuple[float | None, ...] = ()
    sliding: tuple[int, ...] = ()
    taut: tuple[bool, ...] = ()
    still: bool = False


def keepers_of(scene: Scene) -> tuple[Keeper, ...]:
    """One for each reading that friction or stops may hold."""
    acting = scene.acting
    frictions = {effect.reading: effect.force for effect in acting if isinstance(effect, DryFriction)}
    stops = {effect.reading: effect for effect in acting if isinstance(effect, Stops)}
    found = []
    for name in dict.fromkeys([*frictions, *stops]):
        if name in stops:
            one = stops[name]
            found.append(Keeper(name, frictions.get(name), one.low, one.high, one.restitution))
        else:
            found.append(Keeper(name, frictions[name]))
    return tuple(found)


def springs_of(scene: Scene) -> tuple[SpringOn, ...]:
    """The springs along readings."""
    return tuple(effect for effect in scene.acting if isinstance(effect, SpringOn))


def brakes_of(scene: Scene) -> tuple[OilBrake, ...]:
    """The oil brakes."""
    return tuple(effect for effect in scene.acting if isinstance(effect, OilBrake))


def first_mode(scene: Scene) -> Mode:
    """Nothing held, nothing sliding, every one-sided spring slack: what `switching` starts from."""
    many = len(keepers_of(scene))
    one_sided = sum(spring.one_sided for spring in springs_of(scene))
    return Mode((None,) * many, (0,) * many, (False,) * one_sided)


def switches(scene: Scene) -> bool:
    """Whether anything in a scene sticks, strikes or goes slack."""
    return first_mode(scene) != Mode()


def energy_on(spring: SpringOn, value: FloatArray) -> FloatArray:
    """Energy (n,) J of a spring along a reading, at its values (n,)."""
    pulling = ~(spring.one_sided & (value < spring.free))
    energy: FloatArray = np.where(pulling, spring_energy(spring.rate, spring.free, value), 0.0)
    return energy

"""How the parts of a scene that stick, strike and go slack stand at a moment, and what there is of them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.dashpot import Dashpot
from governor_mechanism.effects.dry_friction import DryFriction
from governor_mechanism.effects.spring import OutputSpring
from governor_mechanism.effects.stops import Stops
from governor_mechanism.mechanics.dynamics.force_laws import spring_energy
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import FloatArray


@dataclass(frozen=True)
class Contact:
    """What may hold one reading: dry friction (N or N m, in time), stops (m or rad), or both."""

    output_name: str
    friction: InputFunction | None = None
    low: float = -math.inf
    high: float = math.inf
    restitution: float = 0.0


@dataclass(frozen=True)
class ContactMode:
    """How each keeper and each one-sided spring stands.

    held: the value (m or rad) at which a keeper holds its reading, or None; sliding: the sign of the motion that
    friction opposes, 0 where there is none; taut: whether a one-sided spring pulls; still: whether so much is held that
    nothing can move.
    """

    held_values: tuple[float | None, ...] = ()
    sliding_signs: tuple[int, ...] = ()
    taut: tuple[bool, ...] = ()
    is_locked: bool = False


def contacts_of(scene: Scene) -> tuple[Contact, ...]:
    """One for each reading that friction or stops may hold."""
    effects = scene.output_effects
    friction_forces = {effect.reading: effect.force for effect in effects if isinstance(effect, DryFriction)}
    stops = {effect.reading: effect for effect in effects if isinstance(effect, Stops)}
    contacts = []
    for name in dict.fromkeys([*friction_forces, *stops]):
        if name in stops:
            stop = stops[name]
            contacts.append(Contact(name, friction_forces.get(name), stop.low, stop.high, stop.restitution))
        else:
            contacts.append(Contact(name, friction_forces[name]))
    return tuple(contacts)


def output_springs_of(scene: Scene) -> tuple[OutputSpring, ...]:
    """The springs along readings."""
    return tuple(effect for effect in scene.output_effects if isinstance(effect, OutputSpring))


def output_dampers_of(scene: Scene) -> tuple[Dashpot, ...]:
    """The dashpots."""
    return tuple(effect for effect in scene.output_effects if isinstance(effect, Dashpot))


def initial_mode(scene: Scene) -> ContactMode:
    """Nothing held, nothing sliding, every one-sided spring slack: what `switching` starts from."""
    n_contacts = len(contacts_of(scene))
    n_one_sided = sum(spring.one_sided for spring in output_springs_of(scene))
    return ContactMode((None,) * n_contacts, (0,) * n_contacts, (False,) * n_one_sided)


def has_contacts(scene: Scene) -> bool:
    """Whether anything in a scene sticks, strikes or goes slack."""
    return initial_mode(scene) != ContactMode()


def output_spring_energy(spring: OutputSpring, value: FloatArray) -> FloatArray:
    """Energy (n,) J of a spring along a reading, at its values (n,)."""
    is_taut = ~(spring.one_sided & (value < spring.free_value))
    energy: FloatArray = np.where(is_taut, spring_energy(spring.rate, spring.free_value, value), 0.0)
    return energy

"""Contacts of a scene (dry friction, stops, one-sided springs) and their discrete mode."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.types import FloatArray

FRICTION_LAW_NAME = "dry friction"
"""Name of sliding friction in the counts of evaluations."""


@dataclass(frozen=True)
class Contact:
    """One output variable that dry friction or stops may hold.

    Attributes
    ----------
    output_name
        Name of the reading.
    friction
        Friction force against time, N or N m, or None.
    low
        Lower stop, m or rad.
    high
        Upper stop, m or rad.
    restitution
        Coefficient of restitution of the stops, 0 to 1.
    """

    output_name: str
    friction: InputFunction | None = None
    low: float = -math.inf
    high: float = math.inf
    restitution: float = 0.0


@dataclass(frozen=True)
class ContactMode:
    """Discrete state of all contacts and one-sided springs of a scene.

    Attributes
    ----------
    held_values
        Value at which each contact holds its output, m or rad; None where it holds nothing.
    sliding_signs
        Sign of the rate that friction opposes at each contact; 0 without friction.
    taut
        Whether each one-sided spring pulls.
    is_locked
        Whether the held outputs leave no degree of freedom.
    """

    held_values: tuple[float | None, ...] = ()
    sliding_signs: tuple[int, ...] = ()
    taut: tuple[bool, ...] = ()
    is_locked: bool = False


def contacts_of(scene: Scene) -> tuple[Contact, ...]:
    """Return the contacts of a scene.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[Contact, ...]
        One contact for each reading with dry friction or stops.
    """
    properties: defaultdict[str, dict[str, Any]] = defaultdict(dict)
    for effect in sorted(scene.output_effects, key=lambda effect: "friction" not in effect.contact):
        if effect.contact:
            properties[effect.reading] |= effect.contact
    return tuple(Contact(name, **given) for name, given in properties.items())


def output_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects of a scene that act along readings with a force law.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[OutputForce, ...]
        The effects; those with a potential come first, so that sums do not depend on the order in the scene.
    """
    forces = [effect for effect in scene.output_effects if isinstance(effect, OutputForce)]
    return tuple(sorted(forces, key=lambda effect: effect.dissipates))


def one_sided_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that go slack.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    tuple[OutputForce, ...]
        One-sided springs and the like.
    """
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below > -math.inf)


def initial_mode(scene: Scene) -> ContactMode:
    """Return the mode in which nothing is held, nothing slides and every one-sided spring is slack.

    The search for the consistent mode at the start begins with it.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    ContactMode
        The mode.
    """
    n_contacts = len(contacts_of(scene))
    return ContactMode((None,) * n_contacts, (0,) * n_contacts, (False,) * len(one_sided_forces_of(scene)))


def has_contacts(scene: Scene) -> bool:
    """Return whether a scene has contacts or one-sided springs.

    Parameters
    ----------
    scene
        Scene with its output effects.

    Returns
    -------
    bool
        True if its mode can change during a run.
    """
    return initial_mode(scene) != ContactMode()


def potential_derivatives(effect: OutputForce, value: FloatArray) -> FloatArray:
    """Return the potential energy of an effect along a reading, and its derivatives by the reading.

    Parameters
    ----------
    effect
        Effect with a force law.
    value
        Values of the reading, m or rad; shape (n,).

    Returns
    -------
    FloatArray
        Energy (J), first and second derivative; zeros where the effect is slack; shape (3, n).
    """
    derivatives: FloatArray = np.where(value < effect.slack_below, 0.0, np.array(effect.potential(value)))
    return derivatives

"""The discrete state of all contacts and one-sided springs of a scene."""

import math
from dataclasses import dataclass

from governor_mechanism.mechanics.dynamics.forces.contacts import contacts_of, one_sided_forces_of, output_forces_of
from governor_mechanism.mechanics.dynamics.forces.loads import reading_tables_of
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object


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
    segments
        Segment of each table of a reading: 0 below its first point, 1 behind it, and so on.
    broken
        Gears that have broken.
    """

    held_values: tuple[float | None, ...] = ()
    sliding_signs: tuple[int, ...] = ()
    taut: tuple[bool, ...] = ()
    is_locked: bool = False
    segments: tuple[int, ...] = ()
    broken: tuple[str, ...] = ()


def active_forces_of(scene: Scene, mode: ContactMode) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that are not slack in a mode.

    Result: effects in the order of `output_forces_of`.
    """
    is_taut = iter(mode.taut)
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below == -math.inf or next(is_taut))


@once_per_object
def initial_mode(scene: Scene) -> ContactMode:
    """Return the mode in which nothing is held, nothing slides and every one-sided spring is slack.

    The search for the consistent mode at the start begins with it.
    """
    n_contacts, n_one_sided, n_tables = len(contacts_of(scene)), len(one_sided_forces_of(scene)), len(reading_tables_of(scene))
    return ContactMode((None,) * n_contacts, (0,) * n_contacts, (False,) * n_one_sided, False, (0,) * n_tables)


def has_contacts(scene: Scene) -> bool:
    """Return whether a scene has contacts or one-sided springs.

    Result: true if its mode can change during a run.
    """
    return initial_mode(scene) != ContactMode() or bool(scene.system.breaking_gears)

"""The discrete state of all contacts and one-sided springs of a scene, and the forces along outputs in it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from governor_mechanism.mechanics.dynamics import output_forces
from governor_mechanism.mechanics.dynamics.contacts import (
    contacts_of,
    one_sided_forces_of,
    outline_gaps_of,
    output_forces_of,
    rubbing_gaps_of,
)
from governor_mechanism.mechanics.dynamics.inputs import reading_functions_of, reading_tables_of
from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import RecordArray


@dataclass(frozen=True)
class ContactMode:
    """Discrete state of all contacts and one-sided springs of a scene."""

    # value at which each contact holds its output, m or rad; None where it holds nothing
    held_values: tuple[float | None, ...] = ()
    sliding_signs: tuple[int, ...] = ()  # sign of the rate that friction opposes at each contact; 0 without friction
    taut: tuple[bool, ...] = ()  # whether each one-sided spring pulls
    is_locked: bool = False  # whether the held outputs leave no degree of freedom
    segments: tuple[int, ...] = ()  # segment of each table of a reading: 0 below its first point, 1 behind it, and so on
    broken: tuple[str, ...] = ()  # gears that have broken


def active_forces_of(scene: Scene, mode: ContactMode) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that are not slack in a mode, in the order of `output_forces_of`."""
    is_taut = iter(mode.taut)
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below == -math.inf or next(is_taut))


@once_per_object
def initial_mode(scene: Scene) -> ContactMode:
    """Return the mode in which nothing is held or slides and every one-sided spring is slack, where the search at the start begins."""
    n_contacts = len(contacts_of(scene))
    n_one_sided = len(one_sided_forces_of(scene))
    n_tables = len(reading_tables_of(scene))
    return ContactMode((None,) * n_contacts, (0,) * n_contacts, (False,) * n_one_sided, False, (0,) * n_tables)


def has_contacts(scene: Scene) -> bool:
    """Return whether a scene has contacts or one-sided springs, so that its mode can change during a run."""
    return initial_mode(scene) != ContactMode() or bool(scene.system.breaking_gears)


@once_per_object
def forced_output_names(scene: Scene) -> list[str]:
    """Return the readings along which effects or contacts act, or on which loads depend, in the order of the output rows of a system."""
    return _names_of_forces(scene) + watched_output_names(scene)


def _names_of_forces(scene: Scene) -> list[str]:
    forced = [effect.reading for effect in scene.output_effects] + [one.source for one in reading_functions_of(scene)]
    return list(dict.fromkeys(forced))


def watched_output_names(scene: Scene) -> list[str]:
    """Return the gaps and slips of outlines along which no effect acts: forces act along them in some modes alone."""
    names = [gap.name for gap in outline_gaps_of(scene)] + [gap.slip.name for gap in rubbing_gaps_of(scene)]
    forced = _names_of_forces(scene)
    return [name for name in names if name not in forced]


def rows_of_held_contacts(mode: ContactMode, held_rows: Sequence[int]) -> dict[int, int]:
    """Return the constraint row that holds the output of each held contact, by the index of the contact."""
    held = [k for k, value in enumerate(mode.held_values) if value is not None]
    return dict(zip(held, held_rows, strict=True))


def make_output_forces(
    scene: Scene,
    mode: ContactMode,
    friction_inputs: Sequence[int],  # input of the friction limit of each contact, see `InputLayout`
) -> RecordArray:
    """Return the forces in a contact mode, as `OUTPUT_FORCE_DTYPE`: effects with a force law, then friction of sliding contacts."""
    output_names = forced_output_names(scene)
    records = [output_forces.output_force_record(effect, output_names.index(effect.reading)) for effect in active_forces_of(scene, mode)]
    law = output_forces.SLIDING_FRICTION
    for contact, sign, friction_input in zip(contacts_of(scene), mode.sliding_signs, friction_inputs, strict=True):
        if sign and contact.normal is None:
            output = output_names.index(contact.output_name)
            records.append(output_forces.make_output_force(law, output, (float(sign),), has_power=True, input_index=friction_input))
    return np.array(records, dtype=output_forces.OUTPUT_FORCE_DTYPE)

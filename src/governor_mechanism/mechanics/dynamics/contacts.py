"""Contacts of a scene (dry friction, stops) and its forces along readings."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from governor_mechanism.model.effect import OutputForce
from governor_mechanism.model.output_variables import OutlineGap
from governor_mechanism.model.scene import Scene
from governor_mechanism.model.time_functions import InputFunction
from governor_mechanism.numerics.jit import record_dtype
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.types import NO_INDEX, RecordArray

FRICTION_LAW_NAME = "dry friction"
"""Name of sliding friction in the counts of evaluations."""


@dataclass(frozen=True)
class Contact:
    """One output variable that dry friction or stops may hold."""

    output_name: str
    friction: InputFunction | None = None  # force against time, N or N m
    low: float = -math.inf  # lower stop, m or rad
    high: float = math.inf  # upper stop, m or rad
    restitution: float = 0.0  # of the stops, 0 to 1
    normal: str | None = None  # reading whose stop presses what slides along this one; None if no such force gives its friction
    friction_coefficient: float = 0.0  # of Coulomb friction under that force
    is_gap: bool = False  # between a roller and an outline, which may touch without a force


CONTACT_DTYPE = record_dtype(
    ("output_index", "i8"),  # the output row
    ("friction_input", "i8"),  # input of the friction limit, or NO_INDEX
    ("low", "f8"),  # stops, m or rad
    ("high", "f8"),
    ("restitution", "f8"),  # coefficient of restitution of the stops
    ("scale", "f8"),  # scale of the output, m or rad
    ("normal", "i8"),  # the contact whose force limits the friction, or NO_INDEX
    ("friction_coefficient", "f8"),  # Coulomb friction by that force
    ("is_gap", "i8"),  # whether it is the gap between a roller and an outline
)
"""One contact."""


@once_per_object
def outline_gaps_of(scene: Scene) -> tuple[OutlineGap, ...]:
    """Return the gaps between rollers and outlines."""
    return tuple(reading for reading in scene.mechanism.readings if isinstance(reading, OutlineGap))


def rubbing_gaps_of(scene: Scene) -> tuple[OutlineGap, ...]:
    """Return the gaps between rollers and outlines with friction."""
    return tuple(gap for gap in outline_gaps_of(scene) if gap.friction > 0.0)


@once_per_object
def contacts_of(scene: Scene) -> tuple[Contact, ...]:
    """Return the contacts of a scene: readings with friction or stops, gaps of rollers from outlines, slips along these with friction."""
    properties: defaultdict[str, dict[str, Any]] = defaultdict(dict)
    for effect in sorted(scene.output_effects, key=lambda effect: "friction" not in effect.contact):
        if effect.contact:
            properties[effect.reading] |= effect.contact
    for gap in outline_gaps_of(scene):
        properties[gap.name] |= {"low": 0.0, "restitution": gap.restitution, "is_gap": True}
    for gap in rubbing_gaps_of(scene):
        properties[gap.slip.name] |= {"normal": gap.name, "friction_coefficient": gap.friction}
    return tuple(Contact(name, **given) for name, given in properties.items())


def make_contact_table(
    scene: Scene,
    output_names: Sequence[str],  # names of the outputs in the order of their indices
    friction_inputs: Sequence[int],  # input of the friction limit of each contact, see `InputLayout`
) -> RecordArray:
    """Return the contacts of a scene for compiled functions, as records of `CONTACT_DTYPE`."""
    rows, names = [], [contact.output_name for contact in contacts_of(scene)]
    for contact, friction_input in zip(contacts_of(scene), friction_inputs, strict=True):
        output = output_names.index(contact.output_name)
        scale = scene.mechanism.output_scale(contact.output_name)
        normal = NO_INDEX if contact.normal is None else names.index(contact.normal)
        stops = contact.low, contact.high, contact.restitution
        rows.append((output, friction_input, *stops, scale, normal, contact.friction_coefficient, contact.is_gap))
    return np.array(rows, dtype=CONTACT_DTYPE)


@once_per_object
def output_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects of a scene that act along readings with a force law, those with a potential first."""
    # Sums do not depend on the order in the scene.
    forces = [effect for effect in scene.output_effects if isinstance(effect, OutputForce)]
    return tuple(sorted(forces, key=lambda effect: effect.dissipates))


def one_sided_forces_of(scene: Scene) -> tuple[OutputForce, ...]:
    """Return the effects with a force law that go slack."""
    return tuple(effect for effect in output_forces_of(scene) if effect.slack_below > -math.inf)

"""The rules by which a number is taken from a scene without a run: about the gears of its valve, its governor, and its law."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from governor_mechanism.effects.holding import DryFriction
from governor_mechanism.engines.initial_state import rotating_part_alone
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.scene import Scene
from governor_mechanism.numerics.once_per_object import once_per_object
from governor_mechanism.observables.valve_motion import ValveMotion, has_valve_events, reverse_crank, valve_of
from governor_mechanism.scenes.changed_document import document_of, parse_scene_with
from governor_mechanism.statics.controlling_force import compute_controlling_force
from governor_mechanism.statics.equilibrium_speed import WorkingRange
from governor_mechanism.statics.speed_curve import compute_insensitivity_band
from governor_mechanism.studies.sweep.rows import ROW_NO_VALUE
from governor_mechanism.studies.sweep.rules import MissingNumberError
from governor_mechanism.types import FloatArray
from governor_mechanism.units.expressions import read_any_quantity
from governor_mechanism.units.quantities import QUANTITY_KINDS
from governor_mechanism.verification.laws import relative_law_differences

N_GEARS = 7
"""Number of gears, from full forward to full back gear, in which leads are compared."""


@once_per_object
def leads_in_gears(scene: Scene) -> FloatArray:
    """Return the leads (gears, 2) of crank end and head end, m, from full forward to full back gear, where the crank turns back."""
    document, reverser = document_of(scene, "leads"), valve_of(scene).reverser
    if reverser is None:
        raise MechanismError(f"{scene.title}: the valve names nothing that reverses it")
    (forward, kind), (back, _) = (read_any_quantity(one, reverser.key) for one in (reverser.forward, reverser.back))
    unit, leads = QUANTITY_KINDS[kind].si_unit, []
    for place in np.linspace(0.0, 1.0, N_GEARS).tolist():
        value = forward + place * (back - forward)
        gear = parse_scene_with(document, [(reverser.key, f"{value!r} {unit}" if unit else value)])
        leads.append(ValveMotion(reverse_crank(gear) if place > 0.5 else gear).leads)
    return np.array(leads)


def _lead_differences(scene: Scene) -> FloatArray:
    leads = leads_in_gears(scene)
    differences: FloatArray = np.abs(leads[:, 0] - leads[:, 1])
    return differences


def _lead_change(scene: Scene) -> FloatArray:
    return np.array([np.ptp(leads_in_gears(scene).mean(axis=1))])


@once_per_object
def _working_range(scene: Scene) -> WorkingRange:
    """Return the working range of the governor of a scene, between its stops, or else the ends of its travel."""
    found = compute_controlling_force(rotating_part_alone(scene)).working_range
    if found is None:
        text = "the governor has no working range: at an end of its travel it has no equilibrium speed; give it stops"
        raise MissingNumberError(ROW_NO_VALUE, text)
    return found


def _insensitivity(scene: Scene) -> FloatArray:
    """Return the insensitivity, by the dry friction of the scene: the larger of those at both ends of the working range."""
    alone = rotating_part_alone(scene)
    frictions = [one for one in alone.output_effects if isinstance(one, DryFriction)]
    if not frictions:
        text = "the governor has no dry friction, which makes it insensitive; write effects.dry_friction"
        raise MissingNumberError(ROW_NO_VALUE, text)
    friction = frictions[0]
    band = compute_insensitivity_band(alone, _working_range(scene).coordinate, max(friction.force.values), friction.reading)
    return np.array([band.insensitivity.max()])


def _is_gear(scene: Scene) -> bool:
    return has_valve_events(scene) and valve_of(scene).reverser is not None


def _has_governor(scene: Scene) -> bool:
    return any(part.turns for part in scene.parts)


def _has_law(scene: Scene) -> bool:
    return len(scene.parts) == 1 and scene.part.law is not None


@dataclass(frozen=True, kw_only=True)
class SceneRule:
    """A rule about a scene."""

    take: Callable[[Scene], FloatArray]  # function that computes values, SI, of which the largest counts
    applies: Callable[[Scene], bool]  # whether a scene can have the number
    unit: str  # SI unit


SCENE_RULES: Mapping[str, SceneRule] = {
    "lead difference": SceneRule(take=_lead_differences, applies=_is_gear, unit="m"),
    "lead change": SceneRule(take=_lead_change, applies=_is_gear, unit="m"),
    "lowest equilibrium speed": SceneRule(
        take=lambda scene: _working_range(scene).speed.min(keepdims=True), applies=_has_governor, unit="rad/s"
    ),
    "highest equilibrium speed": SceneRule(
        take=lambda scene: _working_range(scene).speed.max(keepdims=True), applies=_has_governor, unit="rad/s"
    ),
    "sensitiveness": SceneRule(take=lambda scene: np.array([_working_range(scene).sensitiveness]), applies=_has_governor, unit=""),
    "work capacity": SceneRule(take=lambda scene: np.array([_working_range(scene).work_capacity]), applies=_has_governor, unit="N m"),
    "insensitivity": SceneRule(take=_insensitivity, applies=_has_governor, unit=""),
    "law difference": SceneRule(take=relative_law_differences, applies=_has_law, unit=""),
}
"""Rules about a scene: leads in seven gears, the working range of a governor, and the equations of a law."""

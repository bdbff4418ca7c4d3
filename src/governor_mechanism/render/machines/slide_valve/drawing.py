"""Drawing of a slide valve: the engine at a small scale, the cylinder in section, and Zeuner's diagram below the stroke.

The crank circle is below the cylinder and at its scale. The piston position follows from the crank pin by an arc of the
connecting-rod length, as in Marks' construction. The shaft is at the right.
"""

from __future__ import annotations

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.model.part import Part
from governor_mechanism.render.effect_state import NO_EFFECTS, EffectState
from governor_mechanism.render.geometry.primitives import DrawnShape
from governor_mechanism.render.machines.generic import drawing as generic
from governor_mechanism.render.machines.slide_valve import cylinder as slide_valve_cylinder
from governor_mechanism.render.machines.slide_valve import engine as slide_valve_engine
from governor_mechanism.render.machines.slide_valve import zeuner_dial as slide_valve_diagram
from governor_mechanism.render.machines.slide_valve.proportions import valve_gear_position, valve_gear_proportions
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_ENGINE_GAP = 0.10
"""Gap between the section and the engine above it, in crank radii."""


def slide_valve_background_shapes(part: Part, poses: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return castings, the divided circle, valve circles, and the curves of the run."""
    valve_gear = valve_gear_proportions(part)
    body_indices = part.mechanism.body_index(CRANK), part.mechanism.body_index(VALVE)
    angles, displacements = poses[:, body_indices[0], 2], poses[:, body_indices[1], 0] - valve_gear.centre
    return (
        *slide_valve_engine.steam_engine_background_shapes(valve_gear, _engine_base_height(valve_gear.crank)),
        *slide_valve_cylinder.cylinder_background_shapes(valve_gear),
        *slide_valve_diagram.dial_background_shapes(valve_gear, angles, displacements),
    )


def slide_valve_moving_shapes(part: Part, pose: FloatArray, extents: RunExtents | None = None) -> tuple[DrawnShape, ...]:
    """Return all parts that the crank moves."""
    valve_gear = valve_gear_proportions(part)
    position = valve_gear_position(part, valve_gear, pose)
    height = slide_valve_cylinder.CYLINDER_BASE * valve_gear.crank
    return (
        *slide_valve_engine.steam_engine_moving_shapes(valve_gear, position, _engine_base_height(valve_gear.crank)),
        *slide_valve_cylinder.cylinder_moving_shapes(valve_gear, position),
        *slide_valve_diagram.dial_moving_shapes(valve_gear, position, height),
    )


def slide_valve_plan_shapes(part: Part, pose: FloatArray, angle: float, effect_state: EffectState = NO_EFFECTS) -> tuple[DrawnShape, ...]:
    """Return the generic plan view; a fixed plane has no view from above."""
    return generic.generic_plan_shapes(part, pose, angle, effect_state)


def _engine_base_height(crank: float) -> float:
    """Return the height of the base of the small engine view (m)."""
    return (slide_valve_cylinder.CHEST_TOP + _ENGINE_GAP) * crank

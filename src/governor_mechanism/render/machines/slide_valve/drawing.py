"""The drawing of a slide valve: the engine in small, the cylinder in section, and Zeuner's diagram under the stroke.

The crank's circle stands right under the cylinder and to the same scale, so that the piston is found from the crank
pin as Marks does it: by an arc of the connecting rod's length. The shaft lies at the right.
"""

from __future__ import annotations

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.model.scene import Part
from governor_mechanism.render.effect_state import NOTHING, Acting
from governor_mechanism.render.geometry.primitives import Shape
from governor_mechanism.render.machines.generic import drawing as generic
from governor_mechanism.render.machines.slide_valve import cylinder as slide_valve_cylinder
from governor_mechanism.render.machines.slide_valve import engine as slide_valve_engine
from governor_mechanism.render.machines.slide_valve import zeuner_dial as slide_valve_diagram
from governor_mechanism.render.machines.slide_valve.proportions import gear_of, standing
from governor_mechanism.render.run_extents import Stage
from governor_mechanism.types import FloatArray

GAP = 0.10
"""Between the section and the engine over it, in cranks."""


def background(part: Part, poses: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Castings, the divided circle, circles of the valve, and the curves that the run draws."""
    gear = gear_of(part)
    rows = part.mechanism.body_index(CRANK), part.mechanism.body_index(VALVE)
    angles, displacements = poses[:, rows[0], 2], poses[:, rows[1], 0] - gear.centre
    return (
        *slide_valve_engine.background(gear, _foot(gear.crank)),
        *slide_valve_cylinder.background(gear),
        *slide_valve_diagram.background(gear, angles, displacements),
    )


def moving(part: Part, pose: FloatArray, stage: Stage | None = None) -> tuple[Shape, ...]:
    """Everything that the crank moves."""
    gear = gear_of(part)
    at = standing(part, gear, pose)
    height = slide_valve_cylinder.FOOT * gear.crank
    return (
        *slide_valve_engine.moving(gear, at, _foot(gear.crank)),
        *slide_valve_cylinder.moving(gear, at),
        *slide_valve_diagram.moving(gear, at, height),
    )


def plan(part: Part, pose: FloatArray, angle: float, acting: Acting = NOTHING) -> tuple[Shape, ...]:
    """Of a fixed plane there is none to see from above; what fits every mechanism."""
    return generic.plan(part, pose, angle, acting)


def _foot(crank: float) -> float:
    """Where the engine in small begins (m)."""
    return (slide_valve_cylinder.TOP + GAP) * crank

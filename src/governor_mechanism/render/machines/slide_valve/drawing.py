"""Drawing of a slide valve: the engine at a small scale, the cylinder in section, and Zeuner's diagram below the stroke.

The crank circle is below the cylinder and at its scale. The piston position follows from the crank pin by an arc of the
connecting-rod length, as in Marks' construction. The shaft is at the right.
"""

from collections.abc import Iterator

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.primitives import DrawnShape
from governor_mechanism.render.machines.slide_valve import cylinder, engine, zeuner_dial
from governor_mechanism.render.machines.slide_valve.proportions import valve_gear_position, valve_gear_proportions
from governor_mechanism.render.run_extents import RunExtents
from governor_mechanism.types import FloatArray

_ENGINE_BASE = cylinder.CHEST_TOP + 0.10
"""Height of the base of the engine view, in crank radii: a small gap above the section."""


def background_shapes(part: Part, poses: FloatArray, extents: RunExtents) -> Iterator[DrawnShape]:
    """Yield castings, the divided circle, valve circles, and the curves of the run."""
    valve_gear = valve_gear_proportions(part)
    angles, valve_positions = poses[:, part.mechanism.body_index(CRANK), 2], poses[:, part.mechanism.body_index(VALVE), 0]
    yield from engine.engine_background_shapes(valve_gear, _ENGINE_BASE * valve_gear.crank)
    yield from cylinder.cylinder_background_shapes(valve_gear)
    yield from zeuner_dial.dial_background_shapes(valve_gear, angles, valve_positions - valve_gear.centre)


def moving_shapes(part: Part, pose: FloatArray, extents: RunExtents) -> Iterator[DrawnShape]:
    """Yield all parts that the crank moves."""
    valve_gear = valve_gear_proportions(part)
    position = valve_gear_position(part, valve_gear, pose)
    yield from engine.engine_moving_shapes(valve_gear, position, _ENGINE_BASE * valve_gear.crank)
    yield from cylinder.cylinder_moving_shapes(valve_gear, position)
    yield from zeuner_dial.dial_moving_shapes(valve_gear, position, cylinder.CYLINDER_BASE * valve_gear.crank)

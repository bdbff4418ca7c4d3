"""Drawing of a slide valve: the engine at a small scale, the cylinder in section, and Zeuner's diagram below the stroke.

The crank circle is below the cylinder and at its scale. The piston position follows from the crank pin by an arc of the
connecting-rod length, as in Marks' construction. The shaft is at the right.
"""

from collections.abc import Iterator

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.render.geometry.primitives import DrawnShape
from governor_mechanism.render.machines.slide_valve import cylinder, engine, zeuner_dial
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearProportions
from governor_mechanism.types import FloatArray

_ENGINE_BASE = cylinder.CHEST_TOP + 0.10
"""Height of the base of the engine view, in crank radii: a small gap above the section."""


class SlideValveDrawing(ValveGearProportions):
    """Drawing of an engine with a slide valve."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel")

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield castings, the divided circle, valve circles, and the curves of the run."""
        angles, valve_positions = (self.poses[:, self.part.mechanism.body_index(name), k] for name, k in ((CRANK, 2), (VALVE, 0)))
        yield from engine.engine_background_shapes(self, _ENGINE_BASE * self.crank)
        yield from cylinder.cylinder_background_shapes(self)
        yield from zeuner_dial.dial_background_shapes(self, angles, valve_positions - self.centre)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield all parts that the crank moves."""
        position = self.position(pose)
        yield from engine.engine_moving_shapes(self, position, _ENGINE_BASE * self.crank)
        yield from cylinder.cylinder_moving_shapes(self, position)
        yield from zeuner_dial.dial_moving_shapes(self, position, cylinder.CYLINDER_BASE * self.crank)

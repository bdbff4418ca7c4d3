"""Drawing of Stephenson's link motion: the gear above, the cylinder in section, below it lever and Zeuner's diagram of the last turn."""

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.render.geometry.primitives import DrawnShape
from governor_mechanism.render.machines.slide_valve import cylinder
from governor_mechanism.render.machines.stephenson import lever, turn_dial
from governor_mechanism.render.machines.stephenson.gear_view import GearView
from governor_mechanism.render.machines.stephenson.proportions import LinkGearProportions
from governor_mechanism.types import FloatArray

_VIEW_WIDTH = 2.96
"""Width of the view of the gear, in crank radii."""
_DIAL_CENTRE, _DIAL_RADIUS = (0.52, 0.26), 0.80
_LEVER_PIVOT, _LEVER_LENGTH = (-0.95, -0.18), 0.98
"""Places and sizes below the cylinder, in crank radii."""


class StephensonDrawing(LinkGearProportions):
    """Drawing of a link motion with the engine that it reverses."""

    panel_readings = ("reverser", "valve_displacement", "die_slip", "crank_end_steam")

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the lines of the gear, castings, the quadrant of the lever, and the divided circle."""
        yield from self._gear_view.background_shapes()
        yield from cylinder.cylinder_background_shapes(self)
        yield from lever.quadrant_shapes(self._scaled(_LEVER_PIVOT), _LEVER_LENGTH * self.crank)
        yield from turn_dial.dial_background_shapes(self, self._scaled(_DIAL_CENTRE), _DIAL_RADIUS * self.crank)

    def moving_shapes(self, pose: FloatArray, time: float) -> Iterator[DrawnShape]:
        """Yield all parts that crank and lever move."""
        position = replace(self.position(pose), sense=self._sense(time))
        yield from self._gear_view.moving_shapes(pose)
        yield from cylinder.cylinder_moving_shapes(self, position)
        yield from lever.lever_shapes(self._scaled(_LEVER_PIVOT), _LEVER_LENGTH * self.crank, self._reverser(pose))
        angles = self.poses[:, self.part.mechanism.body_index(CRANK), 2]
        curve = turn_dial.last_turn(angles, self._displacements, position.crank_angle)
        yield from turn_dial.dial_moving_shapes(self, self._scaled(_DIAL_CENTRE), _DIAL_RADIUS * self.crank, position, curve)

    def _scaled(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return a place given in crank radii, m."""
        return place[0] * self.crank, place[1] * self.crank

    @cached_property
    def _gear_view(self) -> GearView:
        return GearView(self, _VIEW_WIDTH * self.crank, (cylinder.CHEST_TOP + 0.06) * self.crank)

    @cached_property
    def _displacements(self) -> FloatArray:
        """Displacement of the valve at the reported times, m."""
        positions: FloatArray = -self.poses[:, self.part.mechanism.body_index(VALVE), 0] - self.centre
        return positions

    def _sense(self, time: float) -> float:
        """Return 1 if the crank turns forward at a time (s), -1 if it turns back."""
        angles = self.poses[:, self.part.mechanism.body_index(CRANK), 2]
        k = min(int(np.searchsorted(self.run.times, time)), len(angles) - 1)
        return -1.0 if angles[k] < angles[max(k - 1, 0)] else 1.0

    def _reverser(self, pose: FloatArray) -> float:
        """Return the position of the reversing lever at a pose (bodies, 3)."""
        return float(evaluate_output_value(self.part.mechanism, "reverser", pose))

"""Drawing of Stephenson's link motion: the gear above, the cylinder in section, below it lever and Zeuner's diagram of the last turn."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Moment, fixed, once_per_moment
from governor_mechanism.render.geometry.primitives import DrawnShape, Vec2
from governor_mechanism.render.machines.slide_valve import cylinder, zeuner_dial
from governor_mechanism.render.machines.slide_valve.steam_distribution import ValveGearPosition, sense_of_rotation
from governor_mechanism.render.machines.slide_valve.steam_key import SteamKey, scale_note_shapes
from governor_mechanism.render.machines.stephenson import lever
from governor_mechanism.render.machines.stephenson.gear_view import GearView
from governor_mechanism.render.machines.stephenson.proportions import LinkGearProportions
from governor_mechanism.types import FloatArray


@dataclass(frozen=True, kw_only=True)
class _Arrangement:
    """Places and sizes in the picture, in crank radii from the middle of the stroke and the base of the view.

    The place of the gear is its lower left corner, those of key and scales are upper left corners.
    """

    gear: Vec2
    gear_width: float
    dial_centre: Vec2
    dial_radius: float
    lever_pivot: Vec2
    lever_length: float
    key: Vec2
    key_size: float
    scales: Vec2


_WIDE = _Arrangement(
    gear=(-5.56, 0.44), gear_width=4.20, dial_centre=(0.42, 0.28), dial_radius=0.84, lever_pivot=(-4.95, -0.62), lever_length=1.05,
    key=(-4.05, 0.42), key_size=1.38, scales=(-2.02, 0.42),
)  # fmt: skip
"""Beside the cylinder the gear, and all else below them."""
_UPRIGHT = _Arrangement(
    gear=(-1.48, cylinder.CHEST_TOP + 0.06), gear_width=2.96, dial_centre=(0.94, 0.54), dial_radius=0.58, lever_pivot=(-0.62, -0.62),
    lever_length=0.80, key=(-1.24, cylinder.CYLINDER_BASE - 0.03), key_size=1.12, scales=(0.30, -0.12),
)  # fmt: skip
"""One below the other, for a picture beside that of another part."""


class StephensonDrawing(LinkGearProportions):
    """Drawing of a link motion with the engine that it reverses."""

    panel_readings = ("reverser", "valve_displacement", "die_slip", "crank_end_steam")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the lines of the gear, castings, the quadrant of the lever, and the divided circle."""
        scales = {"cylinder": 1.0, "valve": cylinder.valve_magnification(self), "gear": self._gear_view.scale}
        yield fixed(self._gear_view.background_shapes())
        yield fixed(cylinder.cylinder_background_shapes(self))
        yield fixed(lever.quadrant_shapes(self._scaled(self._places.lever_pivot), self._places.lever_length * self.crank))
        yield fixed(self._key.background_shapes())
        yield fixed(self._dial.background_shapes())
        yield fixed(scale_note_shapes(self._scaled(self._places.scales), self._places.key_size * self.crank, scales))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield all parts that crank and lever move."""
        yield from self._gear_view.moving_parts()
        yield from cylinder.cylinder_moving_parts(self, self.position_at)
        yield from lever.lever_parts(self._scaled(self._places.lever_pivot), self._places.lever_length * self.crank, self._reverser_at)
        yield from self._key.moving_parts(self, self.position_at)
        yield Flexible(shapes_at=self._curve_shapes)
        yield from self._dial.crank_parts(self.position_at)

    @once_per_moment
    def position_at(self, moment: Moment) -> ValveGearPosition:
        """Return the position of the valve gear at a moment, with the sense of rotation."""
        return replace(self.position(moment.pose), sense=sense_of_rotation(self.run.times, self._crank_angles, moment.time))

    def _curve_shapes(self, moment: Moment) -> Iterator[DrawnShape]:
        """Yield the displacements of the turn before a moment."""
        turn = zeuner_dial.turn_before(self._crank_angles, self._displacements, self.position_at(moment).crank_angle)
        yield from self._dial.curve_shapes(*turn)

    def _scaled(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return a place given in crank radii, m."""
        return place[0] * self.crank, place[1] * self.crank

    @property
    def _places(self) -> _Arrangement:
        return _WIDE if len(self.run.scene.parts) == 1 else _UPRIGHT

    @cached_property
    def _gear_view(self) -> GearView:
        return GearView(self, self._scaled(self._places.gear), self._places.gear_width * self.crank)

    @cached_property
    def _key(self) -> SteamKey:
        return SteamKey(self._scaled(self._places.key), self._places.key_size * self.crank)

    @cached_property
    def _dial(self) -> zeuner_dial.ZeunerDial:
        return zeuner_dial.ZeunerDial(self, self._scaled(self._places.dial_centre), self._places.dial_radius * self.crank)

    @cached_property
    def _displacements(self) -> FloatArray:
        """Displacement of the valve at the reported times, m."""
        positions: FloatArray = -self.poses[:, self.part.mechanism.body_index(VALVE), 0] - self.centre
        return positions

    @cached_property
    def _crank_angles(self) -> FloatArray:
        """Angle of the crank at the reported times, rad."""
        angles: FloatArray = self.poses[:, self.part.mechanism.body_index(CRANK), 2]
        return angles

    def _reverser_at(self, moment: Moment) -> float:
        """Return the position of the reversing lever at a moment."""
        return float(evaluate_output_value(self.part.mechanism, "reverser", moment.pose))

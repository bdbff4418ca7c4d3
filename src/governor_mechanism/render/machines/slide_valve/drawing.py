"""Drawing of a slide valve: the whole engine above, below it the cylinder and its valve in section, and Zeuner's diagram.

The shaft is at the right. The cylinder is drawn at the scale of the picture, and its valve at a larger one; the engine is smaller.
"""

from collections.abc import Iterator
from functools import cached_property

from governor_mechanism.machines.driven_crank import CRANK, VALVE
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, fixed
from governor_mechanism.render.machines.slide_valve import cylinder, zeuner_dial
from governor_mechanism.render.machines.slide_valve.engine_view import EngineView
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearProportions
from governor_mechanism.render.machines.slide_valve.steam_key import SteamKey, scale_note_shapes

# In crank radii.
_LEFT, _RIGHT = -1.24, 3.70
"""Edges of the picture."""
_DIAL_CENTRE, _DIAL_RADIUS = (2.60, 1.50), 0.90
_KEY_TOP, _SCALES_LEFT = cylinder.CYLINDER_BASE - 0.03, 0.34
"""Height of the upper edge of the key, and left edge of the words on scales."""


class SlideValveDrawing(ValveGearProportions):
    """Drawing of an engine with a slide valve."""

    panel_readings = ("valve_displacement", "crank_end_steam", "head_end_steam", "crank_end_travel")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield castings, the key of the steam, the divided circle, valve circles, and the curves of the run."""
        angles, valve_positions = (self.poses[:, self.part.mechanism.body_index(name), k] for name, k in ((CRANK, 2), (VALVE, 0)))
        scales = {"cylinder": 1.0, "valve": cylinder.valve_magnification(self), "engine": self._engine.scale}
        yield fixed(self._engine.background_shapes())
        yield fixed(cylinder.cylinder_background_shapes(self))
        yield fixed(self._key.background_shapes())
        yield fixed(scale_note_shapes((_SCALES_LEFT * self.crank, _KEY_TOP * self.crank), self.crank, scales))
        yield fixed(self._dial.background_shapes())
        yield fixed(self._dial.theory_shapes(self.advance))
        yield fixed(self._dial.curve_shapes(*zeuner_dial.first_turn(angles, valve_positions - self.centre)))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield all parts that the crank moves."""
        yield from self._engine.moving_parts(self.position_at)
        yield from cylinder.cylinder_moving_parts(self, self.position_at)
        yield from self._key.moving_parts(self, self.position_at)
        yield from self._dial.crank_parts(self.position_at)

    @cached_property
    def _engine(self) -> EngineView:
        u = self.crank
        return EngineView(self, _LEFT * u, (_RIGHT - _LEFT) * u, (cylinder.CHEST_TOP + 0.10) * u)

    @cached_property
    def _key(self) -> SteamKey:
        return SteamKey((_LEFT * self.crank, _KEY_TOP * self.crank), self.crank)

    @cached_property
    def _dial(self) -> zeuner_dial.ZeunerDial:
        (x, y), u = _DIAL_CENTRE, self.crank
        return zeuner_dial.ZeunerDial(self, (x * u, y * u), _DIAL_RADIUS * u)

"""Dimensions that the drawing of a link motion needs, and the position of piston and valve at a pose."""

import math
from abc import ABC
from functools import cached_property

from governor_mechanism.machines.driven_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.machines.stephenson.machine import HANGER, LINK, LINK_SLOT, ROD_NAMES
from governor_mechanism.model.joints import Joint, Point
from governor_mechanism.render.geometry.points import axes_to_plane
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.render.machines.slide_valve.proportions import ValveGearProportions
from governor_mechanism.render.machines.slide_valve.steam_distribution import ValveGearPosition
from governor_mechanism.types import FloatArray

_DIE_MARGIN_RATIO = 0.12
"""Length of the slot beyond the outermost position of the die, relative to half the link, for a link without a given length."""


class LinkGearProportions(ValveGearProportions, ABC):
    """Dimensions (m). In the plane the valve line leads from the shaft to the left."""

    link_radius = Dimension("link_radius")
    half_link = Dimension("half_link")
    slot_half_length = Dimension("slot_half_length")

    def position(self, pose: FloatArray) -> ValveGearPosition:
        """Return the position of piston and valve at a pose (bodies, 3)."""
        crank, crosshead, valve = (pose[self.part.mechanism.body_index(name)].tolist() for name in (CRANK, CROSSHEAD, VALVE))
        piston_position = crosshead[0] + (0.0 if math.isinf(self.connecting_rod) else self.connecting_rod)
        return ValveGearPosition(crank_angle=crank[2], valve_displacement=-valve[0] - self.centre, piston_position=piston_position)

    def link_pose(self, pose: FloatArray) -> PoseTuple:
        """Return the pose of the link at a pose (bodies, 3)."""
        x, y, angle = pose[self.part.mechanism.body_index(LINK)].tolist()
        return x, y, angle

    def locate(self, point: Point, pose: FloatArray) -> Vec2:
        """Return the position of a point (m) at a pose (bodies, 3)."""
        index = self.part.mechanism.body_index(point.body)
        x, y, angle = (0.0, 0.0, 0.0) if index < 0 else pose[index].tolist()
        return axes_to_plane((x, y, angle), point.x, point.y)

    def joint(self, name: str) -> Joint:
        """Return a joint of the mechanism by name."""
        return self.part.mechanism.joints[self.part.mechanism.joint_index(name)]

    @cached_property
    def arc_centre(self) -> Point:
        """Centre of the arc of the link."""
        return self.joint(LINK_SLOT).first

    @cached_property
    def hanger_ends(self) -> tuple[Point, Point]:
        """End of the hanger on the lifting arm, and the one on the link."""
        hanger = self.joint(HANGER)
        return hanger.first, hanger.second

    @cached_property
    def rod_ends(self) -> dict[str, tuple[Point, Point]]:
        """Point on the eccentric and pin on the link of each eccentric rod, by name."""
        joints = {joint.name: joint for joint in self.part.mechanism.joints}
        ends = {}
        for name in ROD_NAMES:
            first, last = (joints[name], joints[name]) if name in joints else (joints[f"{name}, eccentric"], joints[f"{name}, pin"])
            ends[name] = first.first, last.second
        return ends

    @cached_property
    def drawn_half_slot(self) -> float:
        """Half the length of the drawn slot along the arc, m."""
        if math.isfinite(self.slot_half_length):
            return self.slot_half_length
        return max(*map(abs, self.reading_range("die_slip")), self.half_link) + _DIE_MARGIN_RATIO * self.half_link

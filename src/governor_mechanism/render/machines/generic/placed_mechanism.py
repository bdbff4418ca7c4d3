"""A mechanism at one pose, with the extents of its run: what every shape of the generic drawing depends on."""

from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.model.force_elements import Damper, Spring
from governor_mechanism.model.joints import GROUND, Pin, Point
from governor_mechanism.model.mechanism import Mechanism
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2, axes_to_plane
from governor_mechanism.render.machines.generic.extents import MechanismExtents


@dataclass(frozen=True, kw_only=True)
class PlacedMechanism:
    """A mechanism at the poses of its bodies and a time (s)."""

    extents: MechanismExtents
    poses: Sequence[PoseTuple]
    time: float

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        return self.extents.part.mechanism

    @property
    def unit(self) -> float:
        """Length scale of the drawing (m)."""
        return self.extents.length_scale

    def pose(self, body: str) -> PoseTuple:
        """Return the pose of a body; that of the ground is zero."""
        index = self.mechanism.body_index(body)
        return (0.0, 0.0, 0.0) if index < 0 else self.poses[index]

    def position(self, point: Point) -> Vec2:
        """Return the position of a point (m)."""
        return axes_to_plane(self.pose(point.body), point.x, point.y)

    def hinge_position(self, first: str, second: str, default: Point | None = None) -> Vec2:
        """Return the position (m) of the pin of two bodies, or of `default`, or of a mass centre.

        The mass centre is that of the second body, or of the first if the second is the ground.
        """
        bodies = {first, second}
        pins = (joint for joint in self.mechanism.joints if isinstance(joint, Pin))
        points = (pin.second for pin in pins if {pin.first.body, pin.second.body} == bodies)
        return self.position(next(points, default) or Point(body=first if second == GROUND else second))

    def hangs_on_springs(self, body: str) -> bool:
        """Return whether a spring or damper acts on a body."""
        return any(isinstance(load, Spring | Damper) and body in load.bodies for load in self.mechanism.force_elements)

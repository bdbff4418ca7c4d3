"""A mechanism at one pose, with the extents of its run: what every shape of the generic drawing depends on."""

from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.model.force_elements import Damper, ForceElement, Spring
from governor_mechanism.model.joints import GROUND, Joint, Pin, Point
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2, place_point
from governor_mechanism.render.run_extents import RunExtents


@dataclass(frozen=True, kw_only=True)
class PlacedMechanism:
    """A part at the poses of its bodies. `extents` are those of the run, at the shown time."""

    part: Part
    poses: Sequence[PoseTuple]
    extents: RunExtents

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Joints of the mechanism."""
        return self.part.mechanism.joints

    @property
    def force_elements(self) -> tuple[ForceElement, ...]:
        """Force elements of the mechanism."""
        return self.part.mechanism.force_elements

    @property
    def unit(self) -> float:
        """Length scale of the drawing (m)."""
        return self.extents.length_scale

    def pose(self, body: str) -> PoseTuple:
        """Return the pose of a body; that of the ground is zero."""
        index = self.part.mechanism.body_index(body)
        return (0.0, 0.0, 0.0) if index < 0 else self.poses[index]

    def position(self, point: Point) -> Vec2:
        """Return the position of a point (m)."""
        return place_point(self.pose(point.body), point)

    def hinge_position(self, first: str, second: str, default: Point | None = None) -> Vec2:
        """Return the position (m) of the pin of two bodies, or of `default`, or of a mass centre.

        The mass centre is that of the second body, or of the first if the second is the ground.
        """
        bodies = {first, second}
        pins = (joint.second for joint in self.joints if isinstance(joint, Pin) and {joint.first.body, joint.second.body} == bodies)
        return self.position(next(pins, default) or Point(body=first if second == GROUND else second))

    def hangs_on_springs(self, body: str) -> bool:
        """Return whether a spring or damper acts on a body."""
        return any(isinstance(load, Spring | Damper) and body in load.bodies for load in self.force_elements)

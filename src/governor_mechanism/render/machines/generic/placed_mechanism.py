"""A mechanism at one pose, with the extents of its run: what every shape of the generic drawing depends on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from governor_mechanism.model.force_elements import Damper, ForceElement, Spring
from governor_mechanism.model.joints import Joint, Point
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.body_points import body_pose, hinge_point, point_position
from governor_mechanism.render.geometry.primitives import PoseTuple, Vec2
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
        """Return the pose of a body or of the ground."""
        return body_pose(self.part.mechanism, self.poses, body)

    def position(self, point: Point) -> Vec2:
        """Return the position of a point (m)."""
        return point_position(self.part.mechanism, self.poses, point)

    def hinge_position(self, first: str, second: str, default: Point | None = None) -> Vec2:
        """Return the position (m) of the pin of two bodies, or of the point that stands for it."""
        return self.position(hinge_point(self.part.mechanism, first, second, default))

    def hangs_on_springs(self, body: str) -> bool:
        """Return whether a spring or damper acts on a body."""
        return any(isinstance(load, Spring | Damper) and body in load.bodies for load in self.force_elements)

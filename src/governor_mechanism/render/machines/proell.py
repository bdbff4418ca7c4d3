"""Drawing of the Proell governor: that of a pendulum governor whose balls sit on upward extensions of the lower arms."""

from collections.abc import Iterator
from functools import cached_property

from governor_mechanism.machines.proell import LEFT_BALL, RIGHT_BALL
from governor_mechanism.render.geometry.attached import Attached, Frame
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.machines.governor_parts import ball_parts
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.render.machines.pendulum import PendulumDrawing
from governor_mechanism.render.machines.pendulum_parts import ARM_WIDTH, LINK_WIDTH, PendulumSide
from governor_mechanism.types import FloatArray


class ProellDrawing(PendulumDrawing):
    """Drawing of a Proell governor; the reading of the arm angle ends at the joint of the arms, not at the ball."""

    arm_joint = Dimension("arm")

    def sides(self, pose: FloatArray) -> list[PendulumSide]:
        """Return the left and the right half at a pose (bodies, 3)."""
        height, sides = float(self.sleeve_height(pose)), []
        joint_x, joint_y = self.ball_centres(pose).tolist()
        for name, sign in ((LEFT_BALL, -1.0), (RIGHT_BALL, 1.0)):
            x, y, _ = pose[self.part.mechanism.body_index(name)].tolist()
            pivot, lug = (sign * self.offset, 0.0), (sign * self.lug_offset, height)
            sides.append(PendulumSide(arm_pivot=pivot, link_joint=(sign * joint_x, joint_y), ball=(x, y), link_end=lug))
        return sides

    def linkage_parts(self) -> Iterator[Attached]:
        """Yield upper arms, lower arms with their extensions, and balls."""
        u, first_sides = self.arm, self.sides_at(self.first_moment)
        for number, side in enumerate(first_sides):
            yield self.attach(self.arm_axes[number], [make_bar("arm", side.arm_pivot, side.link_joint, LINK_WIDTH * u)])
            lower_arm = [make_bar("arm", side.link_joint, end, ARM_WIDTH * u) for end in (side.link_end, side.ball)]
            yield self.attach(self.link_axes[number], lower_arm)
        yield from ball_parts(self.axes_at("ball"), self.ball_radius)

    @cached_property
    def arm_axes(self) -> list[Frame]:
        """Axes of the left and the right upper arm, from the pivot to the joint; the ball is on the lower arm."""
        return self.axes_between("arm_pivot", "link_joint")

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right ball."""
        path: FloatArray = poses[..., self.part.mechanism.body_index(RIGHT_BALL), :2]
        return path

"""Drawing of the Proell governor: that of a pendulum governor whose balls sit on upward extensions of the lower arms."""

from collections.abc import Iterator

from governor_mechanism.machines.proell import LEFT_BALL, RIGHT_BALL
from governor_mechanism.render.geometry.outlines import make_bar
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.render.machines.pendulum.drawing import PendulumDrawing
from governor_mechanism.render.machines.pendulum.proportions import ARM_WIDTH, LINK_WIDTH, PendulumSide
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

    def linkage_shapes(self, pose: FloatArray) -> Iterator[DrawnShape]:
        """Yield upper arms, lower arms with their extensions, and balls."""
        u, sides = self.arm, self.sides(pose)
        for side in sides:
            yield make_bar("arm", side.arm_pivot, side.link_joint, LINK_WIDTH * u)
            yield make_bar("arm", side.link_joint, side.link_end, ARM_WIDTH * u)
            yield make_bar("arm", side.link_joint, side.ball, ARM_WIDTH * u)
        yield from (Circle("ball", *side.ball, self.ball_radius) for side in sides)

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right ball."""
        path: FloatArray = poses[..., self.part.mechanism.body_index(RIGHT_BALL), :2]
        return path

"""Drawing of the pendulum governor: spindle, cross piece, arms, links, balls, and the sleeve with its load."""

import math
from collections.abc import Iterator
from functools import cached_property
from itertools import chain

from governor_mechanism.machines.pendulum.machine import RIGHT_LINK
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Moment, fixed, shapes_of
from governor_mechanism.render.geometry.free_space import first_free_position, horizontal_extents, select_extreme_rows
from governor_mechanism.render.geometry.outlines import make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import Circle, DrawnShape, Lines
from governor_mechanism.render.machines import governor_parts as parts
from governor_mechanism.render.machines.pendulum import effects, governed, lens, sleeve
from governor_mechanism.render.machines.pendulum.proportions import ARM_WIDTH, LINK_WIDTH, PendulumProportions
from governor_mechanism.render.machines.spindle_drive import spindle_drive_shapes
from governor_mechanism.render.machines.throttle_gear import ThrottleGear
from governor_mechanism.types import FloatArray

_PIVOT_RADIUS = 0.021
_SCALE_WIDTH = 0.365
"""Width of the lift scale with its numbers, as a fraction of the arm."""


class PendulumDrawing(PendulumProportions):
    """Drawing of a pendulum governor."""

    panel_readings = ("arm_angle", "sleeve_lift", "spindle_speed")
    plan_caption = ("from above,", "marked: the", "right ball")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the spindle in its bearings, the suspension, the axis, the lift scale, and the effects fixed to the frame."""
        u, spindle_foot = self.arm, effects.spindle_foot_height(self)
        yield fixed(self._spindle_shapes(spindle_foot))
        yield from effects.fixed_effect_parts(self)
        # The cross piece with the arm pins, keyed to the spindle.
        cross_piece = make_bar("frame", (-abs(self.offset), 0.0), (abs(self.offset), 0.0), 0.085 * u)
        yield fixed([make_rectangle("frame", -0.062 * u, 0.062 * u, -0.062 * u, 0.085 * u), cross_piece], turns=True)
        yield fixed(() if self.is_magnified else _lift_scale_shapes(self))
        yield fixed(lens.lens_frame(self), section_only=True)
        yield fixed(spindle_drive_shapes(spindle_foot - 0.19 * u, u))
        yield fixed(self.throttle_gear.background_shapes())
        yield fixed(parts.shoe_key_shapes(self, (0.24 * u, spindle_foot + 0.05 * u), u))

    def _spindle_shapes(self, spindle_foot: float) -> Iterator[DrawnShape]:
        """Yield the spindle in its bearings."""
        u, w = self.arm, self.spindle_ratio * self.arm
        yield from parts.spindle_shapes(w, (spindle_foot - 0.48 * u, 0.40 * u), spindle_foot - 0.19 * u, 0.33 * u)
        for bottom, top in ((0.17 * u, 0.27 * u), (spindle_foot - 0.14 * u, spindle_foot - 0.04 * u)):
            yield from parts.hatched_pair_shapes("bearing", (w, 0.15 * u), (bottom, top), 0.034 * u)
        yield make_rectangle("spindle", -1.6 * w, 1.6 * w, spindle_foot - 0.04 * u, spindle_foot - 0.012 * u)

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield sleeve, links, arms, balls, pins and their effects; the right half covers the left one."""
        yield from effects.sleeve_effect_parts(self)
        yield from sleeve.sleeve_parts(self)
        yield from self.throttle_gear.moving_parts(lambda moment: self.sleeve_axes(moment)[1] - self.fork_depth)
        yield from self.linkage_parts()
        shine = (parts.ball_shine(self.ball_radius),)
        yield from (Attached(frame=axes, shapes=shine, section_only=True) for axes in self.ball_axes)
        for number in (0, 1):
            yield from (self._pin(number, joint) for joint in ("arm_pivot", "link_joint", "link_end"))
        yield from effects.arm_effect_parts(self)
        yield from lens.lens_parts(self)

    def _pin(self, number: int, joint: str) -> Attached:
        """Return the pin of a joint of the left (0) or the right (1) half; on the axis it is round."""
        x, y = self.place_of(number, joint, self.first_moment)
        frame = self.pin_axes(number, joint)
        return self.attach(frame, [Circle("pivot", x, y, _PIVOT_RADIUS * self.arm)], turns=x != 0.0)

    @cached_property
    def throttle_gear(self) -> ThrottleGear:
        """The throttle that the sleeve moves."""
        return governed.make_throttle_gear(self)

    @cached_property
    def fork_depth(self) -> float:
        """Depth of the pin of the fork below the lugs (m)."""
        return governed.fork_depth(self)

    def plan_shapes(self, pose: FloatArray, angle: float) -> Iterator[DrawnShape]:
        """Yield sleeve, arms and balls from above; a mark identifies the right ball."""
        left, right = ((side.ball[0] * math.cos(angle), side.ball[0] * math.sin(angle)) for side in self.sides(pose))
        yield Circle("sleeve", 0.0, 0.0, self.sleeve_size[0])
        yield Lines("plan arm", ((left, right),))
        yield from (Circle("ball", *point, self.ball_radius) for point in (left, right))
        yield Circle("mark", *right, 0.42 * self.ball_radius)

    def traced_path(self, poses: FloatArray) -> FloatArray:
        """Return the path (n, 2) (m) of the centre of the right ball."""
        return self.ball_centres(poses)

    def linkage_parts(self) -> Iterator[Attached]:
        """Yield links, arms and balls. A link with mass is drawn as a rod."""
        u, first_sides = self.arm, self.sides_at(self.first_moment)
        role, width = ("rod", 1.2 * LINK_WIDTH) if RIGHT_LINK in self.body_names else ("link", LINK_WIDTH)
        for number, side in enumerate(first_sides):
            yield self.attach(self.link_axes[number], [make_bar(role, side.link_joint, side.link_end, width * u)])
            yield self.attach(self.arm_axes[number], [make_bar("arm", side.arm_pivot, side.ball, ARM_WIDTH * u)])
        ball = Circle("ball", 0.0, 0.0, self.ball_radius)
        yield from (Attached(frame=axes, shapes=(ball,)) for axes in self.ball_axes)

    def linkage_shapes(self, pose: FloatArray) -> Iterator[DrawnShape]:
        """Yield links, arms and balls at a pose (bodies, 3)."""
        yield from shapes_of(self.linkage_parts(), Moment(pose, 0.0))


def _lift_scale_shapes(governor: PendulumDrawing) -> Iterator[DrawnShape]:
    """Yield a scale (mm) that covers the lifts of the run, at the height of the pointer.

    It is next to the sleeve, or further out with leader lines if a part of the linkage passes there.
    """
    u, (width, drop) = governor.arm, governor.sleeve_size
    ticks_mm = parts.lift_ticks(governor.reading_range(parts.LIFT_READING), governor.zero_lift_height - drop, 0.04 * u, 0.1 * u)
    bottom, top = ticks_mm[0][1] - 0.04 * u, ticks_mm[-1][1] + 0.04 * u
    preferred_x = width + 0.10 * u
    linkage_shapes = chain.from_iterable(governor.linkage_shapes(pose) for pose in governor.poses[select_extreme_rows(governor.poses)])
    # Leave a small gap to the linkage.
    x = first_free_position(horizontal_extents(linkage_shapes, bottom, top), preferred_x - 0.01 * u, _SCALE_WIDTH * u)
    # Text keeps its size when a wide machine is drawn at a small scale: far out, its space grows with the width.
    if x < preferred_x:
        x, text_width = preferred_x, 0.3 * u
    else:
        x += 0.05 * u
        text_width = 0.4 * x
        yield Lines("leader", tuple(((preferred_x, y), (x, y)) for _, y in ticks_mm))
    yield from parts.lift_scale_shapes(x, ticks_mm, (0.05 * u, 0.03 * u, 0.065 * u, text_width))

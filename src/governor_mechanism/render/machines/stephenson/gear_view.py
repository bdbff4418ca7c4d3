"""View of the link gear: crank and eccentrics at the right, the link with its die block, hanger and lifting arm, the valve spindle."""

import math
from collections.abc import Iterator
from functools import cached_property, partial

from governor_mechanism.machines.driven_crank import CRANK
from governor_mechanism.machines.stephenson.machine import LINK, ROD_NAMES
from governor_mechanism.model.joints import Point
from governor_mechanism.render.geometry.attached import Attached, DrawnPart, Flexible, Frame, Moment, axes_along, axes_shifted, fixed
from governor_mechanism.render.geometry.outlines import make_band, make_bar, make_rectangle
from governor_mechanism.render.geometry.points import arc_points
from governor_mechanism.render.geometry.primitives import BoundingBox, Circle, DrawnShape, Lines, PoseTuple, Vec2
from governor_mechanism.render.machines.stephenson.proportions import LinkGearProportions
from governor_mechanism.types import FloatArray

# In half links.
_LINK_WIDTH, _SLOT_WIDTH, _BLOCK_HALF_LENGTH, _BLOCK_HALF_WIDTH = 0.40, 0.20, 0.22, 0.14
_ROD_WIDTH, _HANGER_WIDTH, _PIN_RADIUS, _SHAFT_RADIUS = 0.15, 0.13, 0.085, 0.18
_SPINDLE_HALF_WIDTH, _GUIDE_LENGTH, _GUIDE_HALF_HEIGHT = 0.05, 0.5, 0.16
_SPINDLE_LENGTH = 1.5
"""Length of the drawn valve spindle beyond the die's outermost position."""
_STRAP_RATIO = 1.7
"""Radius of an eccentric, relative to its eccentricity."""


class GearView:
    """Map from the plane of the gear to a picture that is `width` wide from a lower left corner (m), and the shapes of the gear."""

    def __init__(self, gear: LinkGearProportions, corner: Vec2, width: float) -> None:
        self._gear = gear
        left, right, bottom, _ = self._box
        self.scale = width / (right - left)
        """Metres of the picture per metre of the gear."""
        self._x, self._y = corner[0] - left * self.scale, corner[1] - bottom * self.scale

    @property
    def top(self) -> float:
        """Height of the view's upper edge in the picture, m."""
        return self._y + self._box[3] * self.scale

    @cached_property
    def _box(self) -> BoundingBox:
        """Box around the gear in its plane, m."""
        gear, unit = self._gear, self._gear.half_link
        _, die_end = gear.reading_range("valve_displacement")
        left = -gear.centre - die_end - _SPINDLE_LENGTH * unit
        arms, links = ([gear.locate(end, pose) for pose in gear.poses[:: max(1, len(gear.poses) // 60)]] for end in gear.hanger_ends)
        heights = [y for _, y in (*arms, *links)]
        low = min(heights) - (gear.drawn_half_slot if min(heights) in [y for _, y in links] else 0.0)
        return left, gear.crank + 0.2 * unit, min(low, -gear.crank) - 0.3 * unit, max(*heights, gear.crank) + 0.3 * unit

    def __call__(self, point: Vec2) -> Vec2:
        """Return the place of a point of the plane in the picture, m."""
        return self._x + point[0] * self.scale, self._y + point[1] * self.scale

    def background_shapes(self) -> Iterator[DrawnShape]:
        """Yield the valve line, the crank circle, the guides of valve spindle and lifting arm."""
        gear, unit, (left, right, _, top) = self._gear, self._gear.half_link, self._box
        yield Lines("axis", ((self((left, 0.0)), self((right, 0.0))),))
        yield Lines("guide", (tuple(self(point) for point in arc_points((0.0, 0.0), 0.0, math.tau, gear.crank, 48)),))
        arm_x, _ = gear.locate(gear.hanger_ends[0], gear.poses[0])
        low = min(gear.locate(gear.hanger_ends[0], pose)[1] for pose in gear.poses)
        sides = (arm_x - 0.12 * unit, arm_x + 0.12 * unit)
        yield Lines("guide", tuple((self((x, low - 0.2 * unit)), self((x, top))) for x in sides))
        for side in (1.0, -1.0):
            edge, far = side * 1.2 * _SPINDLE_HALF_WIDTH * unit, side * _GUIDE_HALF_HEIGHT * unit
            (x0, y0), (x1, y1) = self((left + 0.1 * unit, edge)), self((left + (0.1 + _GUIDE_LENGTH) * unit, far))
            yield make_rectangle("frame", x0, x1, min(y0, y1), max(y0, y1))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield crank, eccentrics, valve spindle, link, rods, hanger and die block."""
        gear, scale, unit, first = self._gear, self.scale, self._gear.half_link * self.scale, self._gear.first_moment
        crank_axes = self._body_axes(CRANK)
        shaft, pin = self((0.0, 0.0)), self._place_of(Point(body=CRANK, x=gear.crank), first)
        yield gear.attach(crank_axes, [make_bar("crank web", shaft, pin, 0.22 * gear.crank * scale)])
        for name in ROD_NAMES[::-1]:
            eccentric = self._place_of(gear.rod_ends[name][0], first)
            yield gear.attach(crank_axes, [Circle("eccentric", *eccentric, _STRAP_RATIO * gear.eccentric * scale)])
        yield Flexible(shapes_at=self._spindle_shapes)
        yield from self._link_parts()
        rods = {name: axes_along(partial(self._places_of, gear.rod_ends[name])) for name in ROD_NAMES}
        for name, role in zip(ROD_NAMES[::-1], ("link", "arm"), strict=True):
            yield gear.attach(rods[name], [make_bar(role, *self._places_of(gear.rod_ends[name], first), _ROD_WIDTH * unit)])
        hanger, hanger_ends = axes_along(partial(self._places_of, gear.hanger_ends)), self._places_of(gear.hanger_ends, first)
        yield gear.attach(hanger, [make_bar("rod", *hanger_ends, _HANGER_WIDTH * unit)])
        lift = axes_shifted(partial(self._place_of, gear.hanger_ends[0]))
        yield Attached(frame=lift, shapes=(make_rectangle("frame", -0.11 * unit, 0.11 * unit, -0.2 * unit, 0.2 * unit),))
        pins = [(rods[name], end) for name in ROD_NAMES for end in self._places_of(gear.rod_ends[name], first)]
        pins += [*((hanger, end) for end in hanger_ends), (crank_axes, pin)]
        yield from (gear.attach(axes, [Circle("pivot", *point, _PIN_RADIUS * unit)]) for axes, point in pins)
        yield fixed([Circle("hub", *shaft, _SHAFT_RADIUS * unit)])

    def _body_axes(self, name: str) -> Frame:
        """Return the axes of a body in the picture."""
        own = self._gear.body_axes(name)

        def frame(moment: Moment) -> PoseTuple:
            x, y, angle = own(moment)
            return *self((x, y)), angle

        return frame

    def _place_of(self, point: Point, moment: Moment) -> Vec2:
        """Return the place in the picture of a point (m)."""
        return self(self._gear.locate(point, moment.pose))

    def _places_of(self, points: tuple[Point, Point], moment: Moment) -> tuple[Vec2, Vec2]:
        """Return the places in the picture of two points (m)."""
        return self._place_of(points[0], moment), self._place_of(points[1], moment)

    def _spindle_shapes(self, moment: Moment) -> list[DrawnShape]:
        """Return the valve spindle, from its guide to the die."""
        die_x, left, half = self._die_x(moment), self._box[0], _SPINDLE_HALF_WIDTH * self._gear.half_link
        (x0, y0), (x1, y1) = self((left, -half)), self((die_x, half))
        return [make_rectangle("piston rod", x0, x1, y0, y1)]

    def _die_x(self, moment: Moment) -> float:
        return -self._gear.centre - self._gear.position_at(moment).valve_displacement

    def _link_parts(self) -> Iterator[Attached]:
        """Yield the curved link with its slot, and the die block in it."""
        gear, unit = self._gear, self._gear.half_link * self.scale
        yield gear.attach(self._body_axes(LINK), self._link_shapes(gear.first_moment.pose))
        half_length, half_width = _BLOCK_HALF_LENGTH * unit, _BLOCK_HALF_WIDTH * unit
        block = make_rectangle("block", -half_width, half_width, -half_length, half_length)
        yield Attached(frame=self._die_axes, shapes=(block, Circle("pivot", 0.0, 0.0, 0.6 * _PIN_RADIUS * unit)))

    def _link_shapes(self, pose: FloatArray) -> Iterator[DrawnShape]:
        """Yield the curved link with its slot at a pose (bodies, 3)."""
        gear, unit = self._gear, self._gear.half_link * self.scale
        centre, angle = gear.locate(gear.arc_centre, pose), gear.link_pose(pose)[2]
        for role, half_length, width in (
            ("plate", gear.drawn_half_slot + 0.1 * gear.half_link, _LINK_WIDTH),
            ("slot", gear.drawn_half_slot, _SLOT_WIDTH),
        ):
            half_angle = half_length / gear.link_radius
            arc = arc_points(centre, math.pi + angle - half_angle, 2 * half_angle, gear.link_radius, 24)
            yield make_band(role, [self(point) for point in arc], width * unit)

    def _die_axes(self, moment: Moment) -> PoseTuple:
        """Return the axes of the die block in the picture; x leads along the slot's normal at the die."""
        x, y = self._gear.locate(self._gear.arc_centre, moment.pose)
        die_x = self._die_x(moment)
        return *self((die_x, 0.0)), math.atan2(-y, die_x - x)

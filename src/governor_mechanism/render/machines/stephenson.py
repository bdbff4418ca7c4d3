"""Drawing of Stephenson's link motion: the gear above, the cylinder in section, below it lever and Zeuner's diagram of the last turn."""

import math
from abc import ABC
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

from governor_mechanism.machines.slider_crank import CRANK, CROSSHEAD, VALVE
from governor_mechanism.machines.stephenson import HANGER, LINK, LINK_SLOT, ROD_NAMES
from governor_mechanism.mechanics.kinematics.output_variables import evaluate_output_value
from governor_mechanism.model.joints import Joint, Point
from governor_mechanism.model.part import Part
from governor_mechanism.render.geometry.attached import (
    Attached,
    DrawnPart,
    Flexible,
    Frame,
    Moment,
    axes_along,
    axes_shifted,
    axes_turned,
    fixed,
    once_per_moment,
)
from governor_mechanism.render.geometry.outlines import make_band, make_bar, make_rectangle
from governor_mechanism.render.geometry.primitives import (
    BoundingBox,
    Circle,
    DrawnShape,
    Lines,
    PoseTuple,
    TextShape,
    Vec2,
    arc_points,
    axes_to_plane,
)
from governor_mechanism.render.machines import steam_cylinder, steam_distribution
from governor_mechanism.render.machines.generic.joints import spoked_wheel
from governor_mechanism.render.machines.machine_drawing import Dimension
from governor_mechanism.render.machines.slide_valve import ValveGearProportions
from governor_mechanism.render.machines.steam_distribution import ValveGearPosition, key_shapes, scale_note_shapes, sense_of_rotation
from governor_mechanism.render.part_run import find_shaft_wheel
from governor_mechanism.types import FloatArray

HALF_SWING = math.radians(34.0)
"""Angle of the lever from the upright in full gear, rad; full forward gear is toward the cylinder, at the left."""
_QUADRANT_RATIO, _N_NOTCHES = 0.72, 10
"""Radius of the quadrant relative to the lever, and number of spaces between its notches."""


def quadrant_shapes(pivot: Vec2, length: float) -> Iterator[DrawnShape]:
    """Yield the quadrant with its notches and names, for a lever with its pivot and length (m)."""
    radius = _QUADRANT_RATIO * length
    margin = 0.1 * HALF_SWING
    arc = arc_points(pivot, math.pi / 2 - HALF_SWING - margin, 2 * (HALF_SWING + margin), radius, 24)
    yield make_band("bracket", arc, 0.10 * length)
    angles = [math.pi / 2 + HALF_SWING * (2 * k / _N_NOTCHES - 1) for k in range(_N_NOTCHES + 1)]
    notches = tuple(tuple((pivot[0] + r * math.cos(a), pivot[1] + r * math.sin(a)) for r in (radius, 1.07 * radius)) for a in angles)
    yield Lines("division", notches)
    yield TextShape("scale", pivot[0] - 0.76 * length, pivot[1] + 0.06 * length, "ahead", 0.45 * length)
    yield TextShape("scale", pivot[0] + 0.22 * length, pivot[1] + 0.06 * length, "back", 0.40 * length)


def lever_parts(pivot: Vec2, length: float, reverser_at: Callable[[Moment], float]) -> Iterator[Attached]:
    """Yield the lever at a position from 1, full forward, to -1, full back."""
    lever_axes = axes_turned(pivot, lambda moment: math.pi / 2 + HALF_SWING * reverser_at(moment))
    bar = make_bar("arm", (0.0, 0.0), (length, 0.0), 0.07 * length)
    handle = Circle("ball", length, 0.0, 0.055 * length)
    yield Attached(frame=lever_axes, shapes=(bar, handle, Circle("pivot", 0.0, 0.0, 0.05 * length)))


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


# In half links.
_LINK_WIDTH = 0.40
_SLOT_WIDTH = 0.20
_BLOCK_HALF_LENGTH = 0.22
_BLOCK_HALF_WIDTH = 0.14
_ROD_WIDTH = 0.15
_HANGER_WIDTH = 0.13
_PIN_RADIUS = 0.085
_SHAFT_RADIUS = 0.18
_LUG_WIDTH = 0.24
_SPINDLE_HALF_WIDTH = 0.05
_GUIDE_LENGTH = 0.5
_GUIDE_HALF_HEIGHT = 0.16
_SPINDLE_LENGTH = 1.5
"""Length of the drawn valve spindle beyond the die's outermost position."""
_WHEEL_RATIO = 1.25
"""Radius of the drawn flywheel, relative to the crank."""
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
        gear = self._gear
        unit = self._gear.half_link
        left, right, _, top = self._box
        yield Lines("axis", ((self((left, 0.0)), self((right, 0.0))),))
        yield Lines("guide", (tuple(self(point) for point in arc_points((0.0, 0.0), 0.0, math.tau, gear.crank, 48)),))
        arm_x, _ = gear.locate(gear.hanger_ends[0], gear.poses[0])
        low = min(gear.locate(gear.hanger_ends[0], pose)[1] for pose in gear.poses)
        sides = (arm_x - 0.12 * unit, arm_x + 0.12 * unit)
        yield Lines("guide", tuple((self((x, low - 0.2 * unit)), self((x, top))) for x in sides))
        for side in (1.0, -1.0):
            edge = side * 1.2 * _SPINDLE_HALF_WIDTH * unit
            far = side * _GUIDE_HALF_HEIGHT * unit
            x0, y0 = self((left + 0.1 * unit, edge))
            x1, y1 = self((left + (0.1 + _GUIDE_LENGTH) * unit, far))
            yield make_rectangle("frame", x0, x1, min(y0, y1), max(y0, y1))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield crank, eccentrics, valve spindle, link, rods, hanger and die block."""
        gear = self._gear
        scale = self.scale
        unit = self._gear.half_link * self.scale
        first = self._gear.first_moment
        crank_axes = self._body_axes(CRANK)
        shaft = self((0.0, 0.0))
        pin = self._place_of(Point(body=CRANK, x=gear.crank), first)
        yield gear.attach(crank_axes, [make_bar("crank web", shaft, pin, 0.22 * gear.crank * scale)])
        for name in ROD_NAMES[::-1]:
            eccentric = self._place_of(gear.rod_ends[name][0], first)
            yield gear.attach(crank_axes, [Circle("eccentric", *eccentric, _STRAP_RATIO * gear.eccentric * scale)])
        yield Flexible(shapes_at=self._spindle_shapes)
        yield from self._link_parts()
        rods = {name: axes_along(partial(self._places_of, gear.rod_ends[name])) for name in ROD_NAMES}
        for name, role in zip(ROD_NAMES[::-1], ("link", "arm"), strict=True):
            yield gear.attach(rods[name], [make_bar(role, *self._places_of(gear.rod_ends[name], first), _ROD_WIDTH * unit)])
        hanger = axes_along(partial(self._places_of, gear.hanger_ends))
        hanger_ends = self._places_of(gear.hanger_ends, first)
        yield gear.attach(hanger, [make_bar("rod", *hanger_ends, _HANGER_WIDTH * unit)])
        lift = axes_shifted(partial(self._place_of, gear.hanger_ends[0]))
        yield Attached(frame=lift, shapes=(make_rectangle("frame", -0.11 * unit, 0.11 * unit, -0.2 * unit, 0.2 * unit),))
        pins = [(rods[name], end) for name in ROD_NAMES for end in self._places_of(gear.rod_ends[name], first)]
        pins += [*((hanger, end) for end in hanger_ends), (crank_axes, pin)]
        yield from (gear.attach(axes, [Circle("pivot", *point, _PIN_RADIUS * unit)]) for axes, point in pins)
        yield fixed([Circle("hub", *shaft, _SHAFT_RADIUS * unit)])

    def wheel_part(self) -> DrawnPart:
        """Return a flywheel on the shaft, whose size is not to scale."""
        radius = _WHEEL_RATIO * self._gear.crank * self.scale
        return Attached(frame=self._body_axes(CRANK), shapes=tuple(spoked_wheel(radius, 0.84 * radius, 0.1 * radius)))

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
        die_x = self._die_x(moment)
        left = self._box[0]
        half = _SPINDLE_HALF_WIDTH * self._gear.half_link
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
        """Yield the curved link with its slot at a pose (bodies, 3), and the lugs of the rods' pins, which may be behind it."""
        gear, unit = self._gear, self._gear.half_link * self.scale
        centre, angle = gear.locate(gear.arc_centre, pose), gear.link_pose(pose)[2]
        for _, end in gear.rod_ends.values():
            pin = gear.locate(end, pose)
            heading = math.atan2(pin[1] - centre[1], pin[0] - centre[0])
            on_arc = (centre[0] + gear.link_radius * math.cos(heading), centre[1] + gear.link_radius * math.sin(heading))
            yield make_bar("plate", self(on_arc), self(pin), _LUG_WIDTH * unit)
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


@dataclass(frozen=True, kw_only=True)
class _Arrangement:
    """Places and sizes in the picture, in crank radii from the middle of the stroke and the base of the view."""

    # The place of the gear is its lower left corner, those of key and scales are upper left corners.

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
    key=(-4.05, 0.42), key_size=1.38, scales=(-2.62, 0.42),
)  # fmt: skip
"""Beside the cylinder the gear, and all else below them."""
_UPRIGHT = _Arrangement(
    gear=(-1.48, steam_cylinder.CHEST_TOP + 0.06), gear_width=2.96, dial_centre=(0.94, 0.54), dial_radius=0.58, lever_pivot=(-0.62, -0.62),
    lever_length=0.80, key=(-1.24, steam_cylinder.CYLINDER_BASE - 0.03), key_size=1.12, scales=(0.30, -0.12),
)  # fmt: skip
"""One below the other, for a picture beside that of another part."""


class StephensonDrawing(LinkGearProportions):
    """Drawing of a link motion with the engine that it reverses."""

    panel_readings = ("reverser", "crank_rate", "valve_displacement", "die_slip", "crank_end_steam")

    def fixed_parts(self) -> Iterator[Attached]:
        """Yield the lines of the gear, castings, the quadrant of the lever, and the divided circle."""
        scales = {"cylinder": 1.0, "valve": steam_cylinder.valve_magnification(self), "gear": self._gear_view.scale}
        yield fixed(self._gear_view.background_shapes())
        yield fixed(steam_cylinder.cylinder_background_shapes(self))
        yield fixed(quadrant_shapes(self._scaled(self._places.lever_pivot), self._places.lever_length * self.crank))
        yield fixed(key_shapes(self._scaled(self._places.key), self._places.key_size * self.crank))
        yield fixed(self._dial.background_shapes())
        yield fixed(scale_note_shapes(self._scaled(self._places.scales), self._places.key_size * self.crank, scales))

    def moving_parts(self) -> Iterator[DrawnPart]:
        """Yield all parts that crank and lever move."""
        if self._wheel is not None:
            yield self._gear_view.wheel_part()
        yield from self._gear_view.moving_parts()
        yield from steam_cylinder.cylinder_moving_parts(self, self.position_at)
        yield from lever_parts(self._scaled(self._places.lever_pivot), self._places.lever_length * self.crank, self._reverser_at)
        yield Flexible(shapes_at=self._curve_shapes)
        yield from self._dial.crank_parts(self.position_at)

    @once_per_moment
    def position_at(self, moment: Moment) -> ValveGearPosition:
        """Return the position of the valve gear at a moment, with the sense of rotation."""
        return replace(self.position(moment.pose), sense=sense_of_rotation(self.run.times, self._crank_angles, moment.time))

    def _curve_shapes(self, moment: Moment) -> Iterator[DrawnShape]:
        """Yield the displacements of the turn before a moment."""
        turn = steam_distribution.turn_before(self._crank_angles, self._displacements, self.position_at(moment).crank_angle)
        yield from self._dial.curve_shapes(*turn)

    def _scaled(self, place: tuple[float, float]) -> tuple[float, float]:
        """Return a place given in crank radii, m."""
        return place[0] * self.crank, place[1] * self.crank

    @property
    def _places(self) -> _Arrangement:
        return _WIDE if len(self.run.scene.parts) == 1 or self._wheel is not None else _UPRIGHT

    @cached_property
    def _wheel(self) -> Part | None:
        """The part that is a flywheel on the shaft."""
        return find_shaft_wheel(self.run.scene, self.part)

    @cached_property
    def _gear_view(self) -> GearView:
        return GearView(self, self._scaled(self._places.gear), self._places.gear_width * self.crank)

    @cached_property
    def _dial(self) -> steam_distribution.ZeunerDial:
        return steam_distribution.ZeunerDial(self, self._scaled(self._places.dial_centre), self._places.dial_radius * self.crank)

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

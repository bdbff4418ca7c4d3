"""Pendulum governors after Watt and Porter: open or crossed arms, extended arms, and separate links.

Geometry after Zehnder, Dinglers Polytechnisches Journal 225 (1877), section 1. The plane turns with the spindle: x is measured from the
spindle axis, y up from the suspension of the arms. The x axis of an arm points from the suspension to the ball, that of a link from the
knee to the lug of the sleeve.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import ClassVar, NamedTuple

from governor_mechanism.effects.holding import CLEARANCE_READING, Clearance
from governor_mechanism.effects.masses import RodMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.base import (
    Machine,
    MassElement,
    join_elements,
    sleeve_lift,
    slender_rod,
    solid_ball,
    travel_problems,
    x_coordinate,
)
from governor_mechanism.model.effect import Effect
from governor_mechanism.model.joints import GROUND, Distance, Gear, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, Mechanism
from governor_mechanism.model.output_variables import FollowerHeight, Limit, LineAngle, Reading
from governor_mechanism.units.fields import optional, quantity
from governor_mechanism.units.quantities import in_mm

RIGHT_BALL = "right ball"
LEFT_BALL = "left ball"
SLEEVE = "sleeve"
RIGHT_LINK, LEFT_LINK = "right link", "left link"


class Side(NamedTuple):
    """Names of one side of the governor, and the sign of its distances from the spindle axis."""

    name: str
    sign: float
    ball: str
    link: str


SIDES = (Side("right", 1.0, RIGHT_BALL, RIGHT_LINK), Side("left", -1.0, LEFT_BALL, LEFT_LINK))

MAX_FOLLOWER_REACH_RATIO = 0.9999
"""Largest horizontal reach of a follower, relative to the link length: at 1, its derivatives are infinite."""


@dataclass(frozen=True, kw_only=True)
class PendulumGovernor(Machine):
    """Two balls on arms and a sleeve on links. Lengths in m, masses in kg; the effect `rods` gives mass to arms and links."""

    name: ClassVar[str] = "pendulum_governor"
    reading_meanings: ClassVar[Mapping[str, str]] = {
        "arm_angle": "angle of the arms from the downward vertical, positive outward",
        "ball_radius": "distance of the right ball from the spindle axis",
        "sleeve_lift": "height of the sleeve above its position with hanging arms, or at the low end of the travel",
        "sleeve_clearance": "height of the sleeve above the lower end of the links, with the effect clearance",
    }
    supported_effects: ClassVar[tuple[type[Effect], ...]] = (RodMasses, Clearance)

    arm: float = quantity("length", meaning="from the suspension to the ball's centre")
    ball_mass: float = quantity("mass", meaning="of one ball; there are two")
    offset: float = quantity("length", sign="any", default=0.0, meaning="of the suspension from the spindle axis; negative = crossed arms")
    arm_joint: float | None = optional("length", meaning="from the suspension to the joint of arm and link; the whole arm if left out")
    link: float | None = optional("length", meaning="of the sleeve link; as long as arm_joint if left out")
    lug_offset: float | None = optional("length", sign="any", meaning="of the sleeve's lug from the axis; the same as offset if left out")
    sleeve_mass: float | None = optional(
        "mass", meaning="of the whole sleeve and its load; left out for a governor without a loaded sleeve"
    )

    def dimension_problems(self) -> Iterator[str]:
        """Yield a sentence about dimensions with which the governor cannot be assembled."""
        low, high = self._angle_range_with_ball_off_axis()
        reach = self._min_link_reach(low, high)
        if self.joint_length > self.arm:
            yield f"arm_joint ({in_mm(self.joint_length)}) lies beyond the ball; it must not exceed arm ({in_mm(self.arm)})"
        elif low >= high:
            yield (
                f"offset ({in_mm(self.offset)}) puts the balls on or across the spindle axis at every arm angle; "
                f"with an arm of {in_mm(self.arm)} it must lie above {in_mm(-self.arm)}"
            )
        elif reach >= self.link_length:
            yield (
                f"link ({in_mm(self.link_length)}) is too short to be assembled: between arm joint and sleeve it stays "
                f"open by {in_mm(reach - self.link_length)} at best; it closes for a link longer than {in_mm(reach)}"
            )

    @property
    def joint_length(self) -> float:
        """Distance of the joint of arm and link from the suspension, m."""
        return self.arm if self.arm_joint is None else self.arm_joint

    @property
    def link_length(self) -> float:
        """Length of the link, m."""
        return self.joint_length if self.link is None else self.link

    @property
    def lug_distance(self) -> float:
        """Distance of the sleeve's lug from the axis, m."""
        return self.offset if self.lug_offset is None else self.lug_offset

    def sleeve_height(self, angle: float) -> float:
        """Return the height of the sleeve on its links above the suspension at an arm angle (rad), m."""
        reach = self._link_reach(angle)
        return -self.joint_length * math.cos(angle) - math.sqrt(max(self.link_length**2 - reach**2, 0.0))

    def dimensions(self) -> dict[str, float]:
        """Return all dimensions in SI, with the values that stand for omitted ones; no sleeve load is 0 kg."""
        omitted = {"arm_joint": self.joint_length, "link": self.link_length, "lug_offset": self.lug_distance}
        return super().dimensions() | omitted | {"sleeve_mass": self.sleeve_mass or 0.0}

    def _angle_range_with_ball_off_axis(self) -> tuple[float, float]:
        ratio = -self.offset / self.arm
        return (math.asin(ratio) if -1 < ratio < 1 else math.copysign(math.pi / 2, ratio)), math.pi / 2

    def _min_link_reach(self, low: float, high: float) -> float:
        """Return the smallest horizontal distance of arm joint and lug over these arm angles (m)."""
        ends = self._link_reach(low), self._link_reach(high)
        return 0.0 if ends[0] * ends[1] <= 0 else min(map(abs, ends))

    def _link_reach(self, angle: float) -> float:
        """Return the horizontal distance of the arm joint from the lug at an arm angle (rad), m."""
        return self.offset + self.joint_length * math.sin(angle) - self.lug_distance

    def travel_limit(self) -> Limit:
        """Return the range of the arm angle, and what happens at its ends."""
        low, high = self._angle_range_with_ball_off_axis()
        low_message = "the balls meet on the spindle axis"
        high_message = "the arms are at 90 degrees to the spindle (dead centre)"
        reach = self.lug_distance - self.offset
        in_line_angle = math.asin(reach / (self.joint_length + self.link_length))
        if in_line_angle > low:
            low, low_message = in_line_angle, "arms and links are in line (dead centre)"
        max_sine = (reach + self.link_length) / self.joint_length
        if max_sine < 1.0:
            high = math.asin(max_sine)
            high_message = "the link is at 90 degrees to the spindle; it is too short"
        return Limit(reading="arm_angle", low=low, high=high, low_message=low_message, high_message=high_message)

    def mechanism(self, rod_masses: RodMasses | None = None, clearance: Clearance | None = None) -> Mechanism:
        """Build balls, sleeve, arms and links.

        Massless arms and links are distances, or levers if the ball is beyond the joint. Arms and links with mass are bodies; an arm is
        one body with its ball, also if the ball has a radius. With clearance the sleeve is free, and `sleeve_clearance` is its height
        above the position on the links. Raise MechanismError for rods or clearance that this governor does not support.
        """
        rods = {} if rod_masses is None else asdict(rod_masses)
        return PendulumBuilder(governor=self, clearance=clearance, **rods).mechanism()

    def start_problems(self, values: Mapping[str, float | str]) -> tuple[str, ...]:
        """Return a sentence about a start angle outside the travel."""
        return travel_problems(values, self.travel_limit(), math.pi, "40 deg")


@dataclass(frozen=True, kw_only=True)
class PendulumBuilder:
    """Builder of the mechanism. Without rod masses and clearance, it has point masses, a sleeve and distances."""

    governor: PendulumGovernor
    clearance: Clearance | None = None
    arm_mass: float = 0.0
    link_mass: float = 0.0
    ball_radius: float = 0.0

    def __post_init__(self) -> None:
        if problems := [*self._find_problems()]:
            raise MechanismError(*problems)

    def _find_problems(self) -> Iterator[str]:
        """Yield sentences about rods or clearance that the governor does not support."""
        has_sleeve = self.governor.sleeve_mass is not None
        arm = self.governor.arm
        if self.link_mass and not has_sleeve:
            yield (
                "rods.link_mass needs links that carry a sleeve; a governor without sleeve_mass has none; "
                "leave link_mass out, or add sleeve_mass to [dimensions]"
            )
        if self.ball_radius >= arm:
            yield (
                f"rods.ball_radius ({self.ball_radius * 1e3:.6g} mm) must be less than arm ({arm * 1e3:.6g} mm), "
                "or the ball would contain its suspension"
            )
        if self.clearance and not has_sleeve:
            yield (
                "clearance is between links and sleeve; a governor without sleeve_mass has no sleeve; "
                "leave clearance out, or add sleeve_mass to [dimensions]"
            )
        elif self.clearance and self.link_mass:
            text = "rods.link_mass cannot be combined with clearance: links that separate from the sleeve are massless"
            yield f"{text}; leave one of them out"

    def mechanism(self) -> Mechanism:
        """Return the mechanism."""
        travel = self.governor.travel_limit()
        margin = 0.1 * (travel.high - travel.low)
        # Lift is measured from hanging arms, or from the low end of the travel if they cannot hang.
        zero_lift_angle = min(max(0.0, travel.low), travel.high)
        dead_centres = [*self._dead_centres()]
        return Mechanism(
            bodies=self._bodies(),
            joints=tuple(self._joints()),
            readings=self._readings(self.governor.sleeve_height(zero_lift_angle)),
            coordinate="arm_angle",
            length_scale=self.governor.arm,
            initial_guess=self.poses(min(max(math.radians(40.0), travel.low + margin), travel.high - margin)),
            limits=(travel, *(limit for _, limit in dead_centres)),
            internal_outputs=tuple(reading for reading, _ in dead_centres),
        )

    @property
    def _is_sleeve_linked(self) -> bool:
        """Whether joints connect the sleeve to the arms; otherwise another joint synchronises the balls."""
        return self.governor.sleeve_mass is not None and self.clearance is None

    @property
    def _can_arms_rotate(self) -> bool:
        """Whether arms are rotating bodies: they have mass, the balls have a size, or the load acts inside the ball."""
        governor = self.governor
        is_lever = governor.sleeve_mass is not None and governor.joint_length < governor.arm
        return is_lever or self.arm_mass > 0 or self.ball_radius > 0

    def _bodies(self) -> tuple[Body, ...]:
        """Return the balls with their arms, the sleeve if it has mass, and links if they have mass."""
        governor = self.governor
        arm = self._arm_with_ball
        can_rotate = self._can_arms_rotate
        bodies = [Body(name=side.ball, mass=arm.mass, second_moments=arm.moments, can_rotate=can_rotate) for side in SIDES]
        if governor.sleeve_mass is not None:
            bodies.append(Body(name=SLEEVE, mass=governor.sleeve_mass, can_rotate=False))
        if self.link_mass:
            link = slender_rod(self.link_mass, (governor.link_length, 0.0))
            bodies += [Body(name=side.link, mass=link.mass, second_moments=link.moments) for side in SIDES]
        return tuple(bodies)

    def _joints(self) -> Iterator[Joint]:
        """Yield the joints of arms and links and the guide of the sleeve; without links a joint synchronises the arms."""
        for side in SIDES:
            yield self._arm_joint(side)
            yield from self._link_joints(side) if self._is_sleeve_linked else ()
        if not self._is_sleeve_linked:
            # A sleeve without mass or with clearance keeps the balls at equal height.
            yield self._synchronising_joint()
        if self.governor.sleeve_mass is not None:
            yield Slider(name="spindle guide", first=Point(body=GROUND), second=Point(body=SLEEVE), angle=math.pi / 2)

    def _readings(self, zero_lift_height: float) -> tuple[Reading, ...]:
        """Return the readings; the sleeve lift is measured from zero_lift_height (m)."""
        suspension = self._suspension(1.0)
        ball = self._point_on_arm(RIGHT_BALL, self.governor.arm)
        lift: Reading = sleeve_lift(Point(body=SLEEVE), zero=zero_lift_height)
        if self.governor.sleeve_mass is None:
            lift = self._follower("sleeve_lift", zero=zero_lift_height)
        clearance = (self._follower(CLEARANCE_READING, reference_point=Point(body=SLEEVE)),) if self.clearance else ()
        return (
            LineAngle(name="arm_angle", quantity="angle", start=suspension, end=ball),
            x_coordinate("ball_radius", ball),
            lift,
            *clearance,
        )

    def _dead_centres(self) -> Iterator[tuple[Reading, Limit]]:
        """Yield the reading that shows the dead centre of the links, and its limit."""
        # There the arm angle has a turning point, so it cannot show it. With clearance the reading
        # is the horizontal distance of the link's upper end from the lug.
        knee = self._point_on_arm(RIGHT_BALL, self.governor.joint_length)
        lug = Point(body=SLEEVE, x=self.governor.lug_distance)
        reading: Reading = LineAngle(name="link_angle", quantity="angle", start=knee, end=lug)
        max_deviation = math.pi / 2
        sentence = "the link is at 90 degrees to the spindle (dead centre)"
        if self.clearance:
            reading = x_coordinate("link_reach", knee, zero=self.governor.lug_distance)
            max_deviation = MAX_FOLLOWER_REACH_RATIO * self.governor.link_length
        if self.clearance or self._is_sleeve_linked:
            yield reading, Limit(reading=reading.name, low=-max_deviation, high=max_deviation, low_message=sentence, high_message=sentence)

    def poses(self, angle: float) -> tuple[tuple[float, float, float], ...]:
        """Return the poses of all bodies at an arm angle (rad), with the sleeve hanging on its links."""
        governor, mass_centre = self.governor, self._arm_with_ball.centre[0]
        x = governor.offset + mass_centre * math.sin(angle)
        y = -mass_centre * math.cos(angle)
        right, left = (angle - math.pi / 2, -math.pi / 2 - angle) if self._can_arms_rotate else (0.0, 0.0)
        poses = [(x, y, right), (-x, y, left)]
        if governor.sleeve_mass is not None:
            poses.append((0.0, governor.sleeve_height(angle), 0.0))
        if self.link_mass:
            knee_x = governor.offset + governor.joint_length * math.sin(angle)
            knee_y = -governor.joint_length * math.cos(angle)
            lug_y = governor.sleeve_height(angle)
            link_angle = math.atan2(lug_y - knee_y, governor.lug_distance - knee_x)
            x, y = (knee_x + governor.lug_distance) / 2, (knee_y + lug_y) / 2
            poses += [(x, y, link_angle), (-x, y, -math.pi - link_angle)]
        return tuple(poses)

    @cached_property
    def _arm_with_ball(self) -> MassElement:
        """A slender arm with a solid ball, with x from the suspension to the ball."""
        arm = self.governor.arm
        ball = solid_ball(self.governor.ball_mass, (arm, 0.0), self.ball_radius)
        return join_elements([ball, slender_rod(self.arm_mass, (arm, 0.0))] if self.arm_mass else [ball])

    def _point_on_arm(self, ball: str, distance: float) -> Point:
        """Return the point of an arm at a distance (m) from its suspension."""
        return Point(body=ball, x=distance - self._arm_with_ball.centre[0])

    def _suspension(self, sign: float) -> Point:
        return Point(body=GROUND, x=sign * self.governor.offset)

    def _arm_joint(self, side: Side) -> Joint:
        name, suspension = f"{side.name} arm", self._suspension(side.sign)
        if self._can_arms_rotate:
            return Pin(name=name, first=suspension, second=self._point_on_arm(side.ball, 0.0))
        return Distance(name=name, first=suspension, second=Point(body=side.ball), length=self.governor.arm)

    def _link_joints(self, side: Side) -> Iterator[Joint]:
        governor, length = self.governor, self.governor.link_length
        knee = self._point_on_arm(side.ball, governor.joint_length)
        lug = Point(body=SLEEVE, x=side.sign * governor.lug_distance)
        if self.link_mass:
            yield Pin(name=f"{side.name} knee", first=knee, second=Point(body=side.link, x=-length / 2))
            yield Pin(name=f"{side.name} lug", first=Point(body=side.link, x=length / 2), second=lug)
        else:
            yield Distance(name=f"{side.name} link", first=knee, second=lug, length=length)

    def _synchronising_joint(self) -> Joint:
        right, left = (self._point_on_arm(name, self.governor.arm) for name in (RIGHT_BALL, LEFT_BALL))
        if self._can_arms_rotate:  # a slider line on an arm would rotate with it
            return Gear(name="arms in step", first=right, second=left, ratio=-1.0, offset=-math.pi)
        return Slider(name="arms in step", first=right, second=left, angle=0.0)

    def _follower(self, name: str, *, zero: float = 0.0, reference_point: Point | None = None) -> FollowerHeight:
        governor = self.governor
        return FollowerHeight(
            name=name,
            quantity="length",
            top=self._suspension(1.0),
            knee=self._point_on_arm(RIGHT_BALL, governor.arm),
            fraction=governor.joint_length / governor.arm,
            guide_x=governor.lug_distance,
            length=governor.link_length,
            zero=zero,
            reference_point=reference_point,
        )

"""Bodies, joints and readings of a pendulum governor.

The x axis of an arm points from the suspension to the ball, that of a link from the knee to the lug of the sleeve.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.machines.pendulum.dimensions import PendulumDimensions
from governor_mechanism.model.joints import GROUND, Distance, Gear, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, SecondMoments
from governor_mechanism.model.output_variables import FollowerHeight, Limit, LineAngle, PointCoordinate, Reading

RIGHT_BALL, LEFT_BALL, SLEEVE = "right ball", "left ball", "sleeve"
RIGHT_LINK, LEFT_LINK = "right link", "left link"

_Pose = tuple[float, float, float]

MAX_FOLLOWER_REACH_RATIO = 0.9999
"""Largest horizontal reach of a follower, relative to the link length: at 1, its derivatives are infinite."""

SPHERE_SECOND_MOMENT_FACTOR = 1 / 5
"""Second moment of a solid sphere about its centre, the integral of x^2 dm, relative to M r^2."""


@dataclass(frozen=True, kw_only=True)
class PendulumBuilder:
    """Builder of the mechanism. Without rod masses and clearance, it has point masses, a sleeve and distances."""

    governor: PendulumDimensions
    rod_masses: RodMasses | None = None
    clearance: Clearance | None = None

    def __post_init__(self) -> None:
        problems = [*self._rod_problems(), *self._clearance_problems()]
        if problems:
            raise MechanismError(*problems)

    def _rod_problems(self) -> list[str]:
        problems, arm = [], self.governor.arm
        if self._link_mass and self.governor.sleeve_mass is None:
            problems.append(
                "rods.link_mass needs links that carry a sleeve; a governor without sleeve_mass has none; "
                "leave link_mass out, or add sleeve_mass to [dimensions]"
            )
        if self._ball_radius >= arm:
            problems.append(
                f"rods.ball_radius ({self._ball_radius * 1e3:.6g} mm) must be less than arm ({arm * 1e3:.6g} mm), "
                "or the ball would contain its suspension"
            )
        return problems

    def _clearance_problems(self) -> list[str]:
        if self.clearance and self.governor.sleeve_mass is None:
            return [
                "clearance is between links and sleeve; a governor without sleeve_mass has no sleeve; "
                "leave clearance out, or add sleeve_mass to [dimensions]"
            ]
        if self.clearance and self._link_mass:
            return [
                "rods.link_mass cannot be combined with clearance: links that separate from the sleeve are massless; leave one of them out"
            ]
        return []

    @property
    def is_sleeve_linked(self) -> bool:
        """Whether joints connect the sleeve to the arms; otherwise another joint synchronises the balls."""
        return self.governor.sleeve_mass is not None and self.clearance is None

    @property
    def can_arms_rotate(self) -> bool:
        """Whether arms are rotating bodies: they have mass, the balls have a size, or the load acts inside the ball."""
        governor = self.governor
        is_lever = governor.sleeve_mass is not None and governor.joint_length < governor.arm
        return is_lever or self._arm_mass > 0 or self._ball_radius > 0

    def bodies(self) -> tuple[Body, ...]:
        """Return the balls with their arms, the sleeve if it has mass, and links if they have mass."""
        governor = self.governor
        mass = governor.ball_mass + self._arm_mass
        bodies = [
            Body(name=name, mass=mass, second_moments=self._second_moments(), can_rotate=self.can_arms_rotate)
            for name in (RIGHT_BALL, LEFT_BALL)
        ]
        if governor.sleeve_mass is not None:
            bodies.append(Body(name=SLEEVE, mass=governor.sleeve_mass, can_rotate=False))
        if self._link_mass:
            slender = SecondMoments(xx=self._link_mass * governor.link_length**2 / 12)
            bodies += [Body(name=name, mass=self._link_mass, second_moments=slender) for name in (RIGHT_LINK, LEFT_LINK)]
        return tuple(bodies)

    def joints(self) -> tuple[Joint, ...]:
        """Return the joints of arms and links and the guide of the sleeve; without links a joint synchronises the arms."""
        joints: list[Joint] = []
        for side, sign in (("right", 1.0), ("left", -1.0)):
            joints.append(self._arm_joint(side, sign))
            joints += self._link_joints(side, sign) if self.is_sleeve_linked else []
        if not self.is_sleeve_linked:
            # A sleeve without mass or with clearance keeps the balls at equal height.
            joints.append(self._synchronising_joint())
        if self.governor.sleeve_mass is not None:
            ground, sleeve = Point(body=GROUND), Point(body=SLEEVE)
            joints.append(Slider(name="spindle guide", first=ground, second=sleeve, angle=math.pi / 2))
        return tuple(joints)

    def readings(self, zero_lift_height: float) -> tuple[Reading, ...]:
        """Return the readings; the sleeve lift is measured from zero_lift_height (m)."""
        suspension, ball = Point(body=GROUND, x=self.governor.offset), self._point_on_arm(RIGHT_BALL, self.governor.arm)
        lift: Reading = self._follower("sleeve_lift", zero=zero_lift_height)
        if self.governor.sleeve_mass is not None:
            lift = PointCoordinate(
                name="sleeve_lift", quantity="length", point=Point(body=SLEEVE), direction_x=0.0, direction_y=1.0, zero=zero_lift_height
            )
        return (
            LineAngle(name="arm_angle", quantity="angle", start=suspension, end=ball),
            PointCoordinate(name="ball_radius", quantity="length", point=ball, direction_x=1.0, direction_y=0.0),
            lift,
            *((self._follower(CLEARANCE_READING, reference_point=Point(body=SLEEVE)),) if self.clearance else ()),
        )

    def internal_outputs(self) -> tuple[Reading, ...]:
        """Return the reading that shows the dead centre of the links.

        There the arm angle has a turning point, so it cannot show it. With clearance the reading is the horizontal distance of the
        link's upper end from the lug.
        """
        knee, lug = (self._point_on_arm(RIGHT_BALL, self.governor.joint_length), Point(body=SLEEVE, x=self.governor.lug_distance))
        if self.clearance:
            link_reach = PointCoordinate(
                name="link_reach", quantity="length", point=knee, direction_x=1.0, direction_y=0.0, zero=self.governor.lug_distance
            )
            return (link_reach,)
        return (LineAngle(name="link_angle", quantity="angle", start=knee, end=lug),) if self.is_sleeve_linked else ()

    def dead_centre_limits(self) -> tuple[Limit, ...]:
        """Return the limits of the internal outputs."""
        sentence = "the link is at 90 degrees to the spindle (dead centre)"
        max_deviation = MAX_FOLLOWER_REACH_RATIO * self.governor.link_length if self.clearance else math.pi / 2
        return tuple(
            Limit(reading=reading.name, low=-max_deviation, high=max_deviation, low_message=sentence, high_message=sentence)
            for reading in self.internal_outputs()
        )

    def poses(self, angle: float) -> tuple[_Pose, ...]:
        """Return the poses of all bodies at an arm angle (rad), with the sleeve hanging on its links."""
        governor, mass_centre = self.governor, self._mass_centre
        x, y = governor.offset + mass_centre * math.sin(angle), -mass_centre * math.cos(angle)
        right, left = (angle - math.pi / 2, -math.pi / 2 - angle) if self.can_arms_rotate else (0.0, 0.0)
        poses = [(x, y, right), (-x, y, left)]
        if governor.sleeve_mass is not None:
            poses.append((0.0, governor.sleeve_height(angle), 0.0))
        if self._link_mass:
            knee_x = governor.offset + governor.joint_length * math.sin(angle)
            knee_y, lug_y = -governor.joint_length * math.cos(angle), governor.sleeve_height(angle)
            link_angle = math.atan2(lug_y - knee_y, governor.lug_distance - knee_x)
            x, y = (knee_x + governor.lug_distance) / 2, (knee_y + lug_y) / 2
            poses += [(x, y, link_angle), (-x, y, -math.pi - link_angle)]
        return tuple(poses)

    @property
    def _arm_mass(self) -> float:
        return self.rod_masses.arm_mass if self.rod_masses else 0.0

    @property
    def _link_mass(self) -> float:
        return self.rod_masses.link_mass if self.rod_masses else 0.0

    @property
    def _ball_radius(self) -> float:
        return self.rod_masses.ball_radius if self.rod_masses else 0.0

    @property
    def _mass_centre(self) -> float:
        """Distance of the mass centre of arm and ball from the suspension, m."""
        arm = self.governor.arm
        return arm - self._arm_mass * arm / (2 * (self.governor.ball_mass + self._arm_mass))

    def _second_moments(self) -> SecondMoments:
        """Return the second moments of a slender arm and a solid ball about their mass centre."""
        arm, mass, mass_centre = self.governor.arm, self._arm_mass, self._mass_centre
        ball_moment = SPHERE_SECOND_MOMENT_FACTOR * self.governor.ball_mass * self._ball_radius**2
        moment_along_arm = self.governor.ball_mass * (arm - mass_centre) ** 2 + mass * (arm**2 / 12 + (mass_centre - arm / 2) ** 2)
        return SecondMoments(xx=moment_along_arm + ball_moment, yy=ball_moment, zz=ball_moment)

    def _point_on_arm(self, ball: str, distance: float) -> Point:
        """Return the point of an arm at a distance (m) from its suspension."""
        return Point(body=ball, x=distance - self._mass_centre)

    def _arm_joint(self, side: str, sign: float) -> Joint:
        ball, suspension = RIGHT_BALL if sign > 0 else LEFT_BALL, Point(body=GROUND, x=sign * self.governor.offset)
        if self.can_arms_rotate:
            return Pin(name=f"{side} arm", first=suspension, second=self._point_on_arm(ball, 0.0))
        return Distance(name=f"{side} arm", first=suspension, second=Point(body=ball), length=self.governor.arm)

    def _link_joints(self, side: str, sign: float) -> list[Joint]:
        ball, link = (RIGHT_BALL, RIGHT_LINK) if sign > 0 else (LEFT_BALL, LEFT_LINK)
        length = self.governor.link_length
        knee = self._point_on_arm(ball, self.governor.joint_length)
        lug = Point(body=SLEEVE, x=sign * self.governor.lug_distance)
        if not self._link_mass:
            return [Distance(name=f"{side} link", first=knee, second=lug, length=length)]
        return [
            Pin(name=f"{side} knee", first=knee, second=Point(body=link, x=-length / 2)),
            Pin(name=f"{side} lug", first=Point(body=link, x=length / 2), second=lug),
        ]

    def _synchronising_joint(self) -> Joint:
        right, left = (self._point_on_arm(name, self.governor.arm) for name in (RIGHT_BALL, LEFT_BALL))
        if self.can_arms_rotate:  # a slider line on an arm would rotate with it
            return Gear(name="arms in step", first=right, second=left, ratio=-1.0, offset=-math.pi)
        return Slider(name="arms in step", first=right, second=left, angle=0.0)

    def _follower(self, name: str, *, zero: float = 0.0, reference_point: Point | None = None) -> FollowerHeight:
        governor = self.governor
        return FollowerHeight(
            name=name,
            quantity="length",
            top=Point(body=GROUND, x=governor.offset),
            knee=self._point_on_arm(RIGHT_BALL, governor.arm),
            fraction=governor.joint_length / governor.arm,
            guide_x=governor.lug_distance,
            length=governor.link_length,
            zero=zero,
            reference_point=reference_point,
        )

"""The bodies, joints and readings of a pendulum governor, as its dimensions, its rods and its play make them.

Axes of an arm and of a link: x along it, from the suspension to the ball, and from the knee to the sleeve's lug.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from governor_mechanism.effects.clearance import CLEARANCE_READING, Clearance
from governor_mechanism.effects.rod_masses import RodMasses
from governor_mechanism.errors import MechanismError
from governor_mechanism.model.joints import GROUND, Distance, Gear, Joint, Pin, Point, Slider
from governor_mechanism.model.mechanism import Body, FollowerHeight, Limit, LineAngle, PointCoordinate, Reading, SecondMoments

if TYPE_CHECKING:
    from governor_mechanism.machines.pendulum.machine import PendulumGovernor

RIGHT_BALL, LEFT_BALL, SLEEVE = "right ball", "left ball", "sleeve"
RIGHT_LINK, LEFT_LINK = "right link", "left link"

_Pose = tuple[float, float, float]

MAX_FOLLOWER_REACH_RATIO = 0.9999
"""Of a link's length: a follower hung on it falls without bound at the whole of it, and cannot be followed there."""

SPHERE_SECOND_MOMENT_FACTOR = 1 / 5
"""Of M r^2: the integral of x^2 dm over a solid sphere about its centre, and the same for y and z."""


@dataclass(frozen=True, kw_only=True)
class PendulumBuilder:
    """What a governor is put together from; without rods and play points, a sleeve, and distances between them."""

    governor: PendulumGovernor
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
                "or the ball would hold its own suspension"
            )
        return problems

    def _clearance_problems(self) -> list[str]:
        if self.clearance and self.governor.sleeve_mass is None:
            return [
                "play is between links and sleeve; a governor without sleeve_mass has no sleeve to move in it; "
                "leave play out, or add sleeve_mass to [dimensions]"
            ]
        if self.clearance and self._link_mass:
            return ["rods.link_mass cannot stand beside play: links that let go of the sleeve have no mass here; leave one of the two out"]
        return []

    @property
    def is_sleeve_linked(self) -> bool:
        """Whether joints hold the sleeve to the arms; else the balls are kept in step without them."""
        return self.governor.sleeve_mass is not None and self.clearance is None

    @property
    def can_arms_rotate(self) -> bool:
        """Arms are bodies that turn where they have mass, the ball size, or the load pulls short of the ball."""
        governor = self.governor
        is_lever = governor.sleeve_mass is not None and governor.joint_length < governor.arm
        return is_lever or self._arm_mass > 0 or self._ball_radius > 0

    def bodies(self) -> tuple[Body, ...]:
        """Balls with their arms, the sleeve where it has mass, links where they have mass."""
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
        """Arms, links and the sleeve's guide; without links something keeps the arms in step."""
        joints: list[Joint] = []
        for side, sign in (("right", 1.0), ("left", -1.0)):
            joints.append(self._arm_joint(side, sign))
            joints += self._link_joints(side, sign) if self.is_sleeve_linked else []
        if not self.is_sleeve_linked:
            # A sleeve without mass, or with play, still makes both arms rise together: the balls stay at one height.
            joints.append(self._synchronising_joint())
        if self.governor.sleeve_mass is not None:
            ground, sleeve = Point(body=GROUND), Point(body=SLEEVE)
            joints.append(Slider(name="spindle guide", first=ground, second=sleeve, angle=math.pi / 2))
        return tuple(joints)

    def readings(self, zero_lift_height: float) -> tuple[Reading, ...]:
        """What the governor tells; the sleeve's lift is counted from the height `hanging` (m)."""
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
        """A link that pulls at a sleeve passes its dead centre while the arm turns back: the arm does not tell.

        With play the links have no lug to end at: it is told by how far their upper ends reach beyond it.
        """
        knee, lug = (self._point_on_arm(RIGHT_BALL, self.governor.joint_length), Point(body=SLEEVE, x=self.governor.lug_distance))
        if self.clearance:
            link_reach = PointCoordinate(
                name="link_reach", quantity="length", point=knee, direction_x=1.0, direction_y=0.0, zero=self.governor.lug_distance
            )
            return (link_reach,)
        return (LineAngle(name="link_angle", quantity="angle", start=knee, end=lug),) if self.is_sleeve_linked else ()

    def dead_centre_limits(self) -> tuple[Limit, ...]:
        """The limits of what is watched."""
        sentence = "the link stands at 90 degrees to the spindle (dead centre)"
        max_deviation = MAX_FOLLOWER_REACH_RATIO * self.governor.link_length if self.clearance else math.pi / 2
        return tuple(
            Limit(reading=reading.name, low=-max_deviation, high=max_deviation, low_message=sentence, high_message=sentence)
            for reading in self.internal_outputs()
        )

    def poses(self, angle: float) -> tuple[_Pose, ...]:
        """Of all bodies, at an arm angle (rad); the sleeve hangs on its links."""
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
        """From the suspension to the common mass centre of arm and ball (m)."""
        arm = self.governor.arm
        return arm - self._arm_mass * arm / (2 * (self.governor.ball_mass + self._arm_mass))

    def _second_moments(self) -> SecondMoments:
        """Of a slender arm and a solid ball, about their common mass centre."""
        arm, mass, mass_centre = self.governor.arm, self._arm_mass, self._mass_centre
        ball_moment = SPHERE_SECOND_MOMENT_FACTOR * self.governor.ball_mass * self._ball_radius**2
        moment_along_arm = self.governor.ball_mass * (arm - mass_centre) ** 2 + mass * (arm**2 / 12 + (mass_centre - arm / 2) ** 2)
        return SecondMoments(xx=moment_along_arm + ball_moment, yy=ball_moment, zz=ball_moment)

    def _point_on_arm(self, ball: str, distance: float) -> Point:
        """The point of an arm so far from its suspension (m)."""
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
        if self.can_arms_rotate:  # a line on an arm would turn with it
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

"""The linkage of pendulum governors: dimensions, kinematics, energies and their derivatives.

One geometry covers Watt, improved Watt and Porter. Two arms hang from suspensions at `offset` from the spindle axis (negative: crossed
arms) and carry the balls at their ends. Two links join the arms, `arm_joint` below the suspension, to the lugs of the sleeve at
`lug_offset`. x is the distance from the axis, y points up with y = 0 at the suspension; arm_angle is measured from the vertical, positive
outward; SI and radians. The energies are T = I a'^2 / 2 + J w^2 / 2, with the arm angle a and the spindle speed w, and V.

Every function raises MechanismError for a value that is not finite, for an arm_angle not between -90 and 90 deg and for a position that
the link cannot reach. Rods are rigid, slender and uniform; the spindle is vertical; balls have any size and do not touch the spindle.
"""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import raise_where, validate_angle, validate_fields
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray, FloatOrArray


@dataclass(frozen=True, kw_only=True)
class PendulumGovernor:
    """Dimensions and masses of a pendulum governor; the defaults of the lengths give a rhombus.

    Attributes
    ----------
    arm
        Length of an arm from suspension to ball centre, m.
    ball_mass
        Mass of one ball, kg.
    offset
        Distance of the suspension from the axis, m; negative for crossed arms.
    arm_joint
        Distance from the suspension to the joint of arm and link, m; None: at the ball.
    link
        Length of a link, m; None: as long as arm_joint.
    lug_offset
        Distance of the sleeve lug from the axis, m; None: as offset.
    sleeve_mass
        Mass of the sleeve, kg.
    arm_mass
        Mass of one arm, kg.
    link_mass
        Mass of one link, kg.
    ball_inertia
        Moment of inertia of one ball about any axis through its centre, kg m2.
    gravity
        Gravitational acceleration, m/s2.
    """

    arm: float
    ball_mass: float
    offset: float = 0.0
    arm_joint: float | None = None
    link: float | None = None
    lug_offset: float | None = None
    sleeve_mass: float = 0.0
    arm_mass: float = 0.0
    link_mass: float = 0.0
    ball_inertia: float = 0.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_fields(self, {"arm": "m", "ball_mass": "kg", "gravity": "m/s2", "arm_joint": "m", "link": "m"}, greater_than=0.0)
        validate_fields(self, {"offset": "m", "lug_offset": "m"})
        validate_fields(self, {"sleeve_mass": "kg", "arm_mass": "kg", "link_mass": "kg", "ball_inertia": "kg m2"}, minimum=0.0)
        if self.joint_length > self.arm:
            raise MechanismError(
                f"arm_joint must not exceed the arm ({self.arm!r} m), so that the joint is not beyond the ball; got {self.joint_length!r} m"
            )
        if self.offset <= -self.arm:
            raise MechanismError(
                f"the offset of crossed arms must be smaller than the arm ({self.arm!r} m), or the ball never reaches its own side of the"
                f" axis; got {self.offset!r} m; lengthen the arm"
            )
        if abs(self.offset - self.lug_radius) >= self.joint_length + self.link_length:
            raise MechanismError(
                f"the link cannot reach at any arm angle: offset and lug_offset differ by {abs(self.offset - self.lug_radius):g} m,"
                f" arm_joint and link have a length of {self.joint_length + self.link_length:g} m; lengthen the link"
            )

    @property
    def joint_length(self) -> float:
        """Distance from the suspension to the joint of arm and link (m)."""
        return self.arm if self.arm_joint is None else self.arm_joint

    @property
    def link_length(self) -> float:
        """Length of the link from the arm joint to the sleeve lug (m)."""
        return self.joint_length if self.link is None else self.link

    @property
    def lug_radius(self) -> float:
        """Distance of the sleeve lug from the axis (m), negative on the far side."""
        return self.offset if self.lug_offset is None else self.lug_offset

    @property
    def is_rhombus(self) -> bool:
        """Whether the link is always at the arm's angle: as long as arm_joint, with the lug below the suspension."""
        same_length = math.isclose(self.link_length, self.joint_length, rel_tol=1e-12)
        return same_length and math.isclose(self.lug_radius, self.offset, rel_tol=1e-12)


class LinkagePosition:
    """One arm and its link at an arm angle (rad): sines, radii (m), derivatives of sleeve height, potential and inertias by the angle.

    The angle of the link follows from offset + l1 sin a = lug + l2 sin b.
    """

    def __init__(self, governor: PendulumGovernor, arm_angle: FloatOrArray) -> None:
        self.governor, self.angle = governor, validate_angle(arm_angle, "arm_angle", 90.0)
        l1, l2 = governor.joint_length, governor.link_length
        s, c = self.sine, self.cosine = np.sin(self.angle), np.cos(self.angle)
        self.ball_radius = governor.offset + governor.arm * s
        self.joint_radius = governor.offset + l1 * s
        if governor.is_rhombus:
            sb, cb = s, c
        else:
            sb = ((governor.offset - governor.lug_radius) + l1 * s) / l2
            message = f"the link of {l2:g} m cannot reach from the arm joint to the sleeve lug"
            raise_where(np.abs(sb) >= 1, message, self.shown_angle, hint="lengthen the link or keep the arm in its travel")
            cb = np.sqrt((1.0 - sb) * (1.0 + sb))
        tan_b, link_angle_derivative = sb / cb, l1 * c / (l2 * cb)  # tan b and db/da
        self.sleeve_derivative = l1 * (s + c * tan_b)
        self.sleeve_second_derivative = l1 * (c - s * tan_b + c * link_angle_derivative / cb**2)

    @property
    def shown_angle(self) -> tuple[str, FloatArray, str]:
        """Arm angle in degrees, for messages."""
        return "arm_angle", np.degrees(self.angle), "deg"

    def potential_derivatives(self) -> tuple[FloatArray, FloatArray]:
        """Return V' (N m/rad) and V'' (N m/rad^2) of the potential energy V; V' is the moment of the weights against the opening."""
        governor = self.governor
        hanging_moment = (2 * governor.ball_mass + governor.arm_mass) * governor.arm + governor.link_mass * governor.joint_length
        lifted_mass = governor.sleeve_mass + governor.link_mass
        derivative = governor.gravity * (hanging_moment * self.sine + lifted_mass * self.sleeve_derivative)
        return derivative, governor.gravity * (hanging_moment * self.cosine + lifted_mass * self.sleeve_second_derivative)

    def spindle_inertia_derivatives(self) -> tuple[FloatArray, FloatArray]:
        """Return J' and J'' (kg m2 per rad, per rad^2) of the moment of inertia J about the spindle; J' is 4 M x l cos a without rods."""
        governor = self.governor
        m, mu, ml = governor.ball_mass, governor.arm_mass, governor.link_mass
        l, l1, e = governor.arm, governor.joint_length, governor.offset  # noqa: E741
        cosine_coefficient = 4 * m * l * self.ball_radius + 2 * mu * l * (e + 2 * l * self.sine / 3)
        cosine_coefficient = cosine_coefficient + 2 * ml * l1 * (2 * self.joint_radius + governor.lug_radius) / 3
        squared_cosine_coefficient = 4 * m * l**2 + 4 * (mu * l**2 + ml * l1**2) / 3
        return (cosine_coefficient * self.cosine, squared_cosine_coefficient * self.cosine**2 - cosine_coefficient * self.sine)

    def in_plane_inertia_and_derivative(self) -> tuple[FloatArray, FloatArray]:
        """Return I (kg m2) and I' (kg m2/rad) of the in-plane energy I a'^2 / 2; I is 2 M l^2 + m_s z'^2 without rod masses."""
        governor = self.governor
        l1, dz, ddz = governor.joint_length, self.sleeve_derivative, self.sleeve_second_derivative  # z' and z" of the sleeve
        m, mu, ml, ms = governor.ball_mass, governor.arm_mass, governor.link_mass, governor.sleeve_mass
        constant_inertia = 2 * (m + mu / 3) * governor.arm**2 + 2 * governor.ball_inertia
        inertia = constant_inertia + ms * dz**2 + 2 * ml * (l1**2 + l1 * self.sine * dz + dz**2) / 3
        link_term_derivative = l1 * (self.cosine * dz + self.sine * ddz) + 2 * dz * ddz
        return inertia, 2 * ms * dz * ddz + 2 * ml * link_term_derivative / 3

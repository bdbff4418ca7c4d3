"""Proell's governor: equilibrium, stability and motion.

The upper arm of length l hangs from a suspension at the distance `offset` from the axis, at the arm angle theta (rad) from the vertical;
the lower arm of length k leads from its end to the sleeve, with its lug at the distance `lug_offset`, at the angle phi from the vertical:
sin phi = (offset + l sin theta - lug_offset) / k. The ball is on an extension e of the lower arm beyond the joint, bent by the angle
`bend` from the line of the lower arm, positive outward.

Where the extension is upright, phi = -bend, the exact condition of equilibrium is that of the textbooks,
w^2 = (g / h) (f / (f + e)) (m + M (1 + q) / 2) / m with f = k cos phi, h = r / tan theta for no offset, and q = tan phi / tan theta.

Arguments are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that is not
finite or out of range. The balls are points; arms are massless; there is no friction.

References
----------
R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Proell governor". The equations follow from virtual work.
"""

from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument, validate_fields
from governor_mechanism.closed_form.sleeve_governor import GovernorPaths
from governor_mechanism.types import FloatOrArray

_LINK_TOO_SHORT = "the link is too short to reach the joint"


@dataclass(frozen=True, kw_only=True)
class ProellGovernor:
    """Dimensions and masses of a Proell governor. MechanismError is raised unless lengths and the mass of a ball are positive.

    Attributes
    ----------
    arm
        Length l of the upper arm, m.
    link
        Length k of the lower arm, m.
    extension
        Length e of its extension, m.
    bend
        Angle of the extension from the line of the lower arm, positive outward, rad.
    ball_mass
        Mass m of one ball, kg.
    sleeve_mass
        Mass M of the sleeve, kg.
    offset
        Distance of the suspension from the axis, m; negative for crossed arms.
    lug_offset
        Distance of the sleeve's lug from the axis, m.
    gravity
        Gravitational acceleration g, m/s2.
    """

    arm: float
    link: float
    extension: float
    bend: float
    ball_mass: float
    sleeve_mass: float
    offset: float = 0.0
    lug_offset: float = 0.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_fields(self, {"arm": "m", "link": "m", "extension": "m", "ball_mass": "kg"}, greater_than=0.0)
        validate_fields(self, {"sleeve_mass": "kg", "gravity": "m/s2"}, minimum=0.0)
        validate_fields(self, {"offset": "m", "lug_offset": "m"})
        validate_angle(self.bend, "bend", 90.0)


def upright_bend(*, joint_radius: FloatOrArray, link: FloatOrArray, lug_offset: FloatOrArray = 0.0) -> FloatOrArray:
    """Return the bend of an extension that is upright where the joint is at a radius, -asin((r - lug_offset) / k).

    Parameters
    ----------
    joint_radius
        Distance r of the joint from the axis, m.
    link
        Length k of the lower arm, m; longer than its horizontal reach.
    lug_offset
        Distance of the sleeve's lug from the axis, m.

    Returns
    -------
    FloatOrArray
        Angle, rad; negative for a lower arm that leans outward.
    """
    reach = validate_argument(joint_radius, "joint_radius", "m") - validate_argument(lug_offset, "lug_offset", "m")
    length = validate_argument(link, "link", "m", greater_than=0.0)
    raise_where(
        np.abs(reach) >= length, "the link is too short to reach the joint", ("joint_radius", joint_radius, "m"), ("link", link, "m")
    )
    return as_scalar_or_array(-np.arcsin(reach / length))


def ball_radius(governor: ProellGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance of a ball from the axis, offset + l sin theta + e sin(phi + bend).

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Angle theta of the upper arm, rad.

    Returns
    -------
    FloatOrArray
        Distance, m.
    """
    return as_scalar_or_array(_paths(governor, arm_angle).x)


def equilibrium_speed(governor: ProellGovernor, *, arm_angle: FloatOrArray, sleeve_force: FloatOrArray = 0.0) -> FloatOrArray:
    """Return the equilibrium speed at an arm angle, w^2 = (2 m g y' + (M g + F) z') / (2 m x x').

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Angle theta of the upper arm, rad.
    sleeve_force
        Force F on the sleeve besides its weight, N, downward: friction of a rising sleeve.

    Returns
    -------
    FloatOrArray
        Spindle speed, rad/s.
    """
    force = validate_argument(sleeve_force, "sleeve_force", "N")
    return as_scalar_or_array(_paths(governor, arm_angle).equilibrium_speed(force))


def squared_natural_frequency(governor: ProellGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """Return the squared frequency of small oscillations about an equilibrium at a constant speed; negative for an unstable one.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Angle theta of the upper arm, rad.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Squared frequency, rad2/s2.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    no_force = np.zeros(())
    return as_scalar_or_array(_paths(governor, arm_angle).squared_frequency(no_force, no_force, speed))


def arm_acceleration(
    governor: ProellGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray, damping: FloatOrArray = 0.0
) -> FloatOrArray:
    """Return the acceleration of the arm angle in motion.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Angle theta of the upper arm, rad.
    arm_rate
        Its rate, rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    damping
        Damping coefficient of a dashpot on the sleeve, N s/m.

    Returns
    -------
    FloatOrArray
        Acceleration, rad/s2.
    """
    paths = _paths(governor, arm_angle)
    rate = validate_argument(arm_rate, "arm_rate", "rad/s")
    force = validate_argument(damping, "damping", "N s/m") * paths.z1 * rate
    return as_scalar_or_array(paths.acceleration(rate, validate_argument(spindle_speed, "spindle_speed", "rad/s"), force))


def spindle_acceleration(
    governor: ProellGovernor,
    *,
    arm_angle: FloatOrArray,
    arm_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray,
) -> FloatOrArray:
    """Return the acceleration of a free spindle, from the change of its angular momentum.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Angle theta of the upper arm, rad.
    arm_rate
        Its rate, rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    constant_inertia
        Moment of inertia of the spindle without the balls, kg m2.
    torque
        Torque on the spindle, N m.

    Returns
    -------
    FloatOrArray
        Acceleration, rad/s2.
    """
    rate = validate_argument(arm_rate, "arm_rate", "rad/s")
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    inertia = validate_argument(constant_inertia, "constant_inertia", "kg m2")
    moment = validate_argument(torque, "torque", "N m")
    return as_scalar_or_array(_paths(governor, arm_angle).spindle_acceleration(rate, speed, inertia, moment))


def _paths(governor: ProellGovernor, arm_angle: FloatOrArray) -> GovernorPaths:
    theta = validate_angle(arm_angle, "arm_angle", 90.0)
    arm = governor.arm
    link = governor.link
    e = governor.extension
    sine, cosine = np.sin(theta), np.cos(theta)
    reach = governor.offset + arm * sine - governor.lug_offset
    raise_where(np.abs(reach) >= link, _LINK_TOO_SHORT, ("arm_angle", np.degrees(theta), "deg"), ("link", link, "m"))
    phi = np.arcsin(reach / link)
    # derivatives of phi from k sin phi = reach
    phi1 = arm * cosine / (link * np.cos(phi))
    phi2 = phi1**2 * np.tan(phi) - arm * sine / (link * np.cos(phi))
    across, along = e * np.sin(phi + governor.bend), e * np.cos(phi + governor.bend)
    y1 = arm * sine - across * phi1
    y2 = arm * cosine - along * phi1**2 - across * phi2
    drop1 = link * np.sin(phi) * phi1
    drop2 = link * (np.cos(phi) * phi1**2 + np.sin(phi) * phi2)
    return GovernorPaths(
        ball_mass=governor.ball_mass,
        sleeve_mass=governor.sleeve_mass,
        gravity=governor.gravity,
        x=np.asarray(governor.offset + arm * sine + across),
        x1=np.asarray(arm * cosine + along * phi1),
        x2=np.asarray(-arm * sine - across * phi1**2 + along * phi2),
        y1=np.asarray(y1),
        y2=np.asarray(y2),
        z1=np.asarray(arm * sine + drop1),
        z2=np.asarray(arm * cosine + drop2),
    )

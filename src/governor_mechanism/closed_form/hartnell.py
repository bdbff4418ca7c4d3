"""Hartnell's spring governor: the formulas of the textbooks, and the exact statics and motion.

Two bell cranks turn about pivots at the distance p from the spindle axis. The arm a of each carries a ball, the arm b a roller under the
sleeve; `angle` is between them. The arm angle beta (rad) is that of the arm a from the upright, positive outward. A ball is at
x = p + a sin beta, the sleeve at b cos(angle - beta) above the pivots. The spring on the sleeve presses it down with the force S.

The textbooks neglect the obliquity of the arms and the weight of the balls: m w^2 r a = (M g + S) b / 2 at every radius r, and the lift
is (r - r1) b / a. For arms at a right angle the obliquity cancels in both, so that only the moment m g a sin beta of each ball is missing.
The `textbook_...` functions and the exact ones stand here side by side.

Arguments are keywords, floats or arrays that broadcast; floats give a float. Every function raises MechanismError for a value that is not
finite or out of range. The balls are points; bell cranks are massless; there is no friction.

References
----------
R. S. Khurmi and J. K. Gupta, Theory of Machines, chapter 18, "Hartnell governor". The exact equations follow from virtual work.
"""

import math
from dataclasses import dataclass

import numpy as np

from governor_mechanism.closed_form.arguments import as_scalar_or_array, validate_angle, validate_argument, validate_fields
from governor_mechanism.closed_form.sleeve_governor import GovernorPaths
from governor_mechanism.types import FloatOrArray


@dataclass(frozen=True, kw_only=True)
class HartnellGovernor:
    """Dimensions and masses of a Hartnell governor. MechanismError is raised unless they are positive and the angle is below pi.

    Attributes
    ----------
    ball_arm
        Arm a of the bell crank, m.
    sleeve_arm
        Arm b of the bell crank, m.
    pivot_radius
        Distance p of the pivots from the spindle axis, m.
    ball_mass
        Mass m of one ball, kg.
    angle
        Angle between the arms, rad.
    sleeve_mass
        Mass M of the sleeve, kg; 0 where it is neglected.
    gravity
        Gravitational acceleration g, m/s2.
    """

    ball_arm: float
    sleeve_arm: float
    pivot_radius: float
    ball_mass: float
    angle: float = math.pi / 2
    sleeve_mass: float = 0.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        """Validate the dimensions."""
        validate_fields(self, {"ball_arm": "m", "sleeve_arm": "m", "pivot_radius": "m", "ball_mass": "kg"}, greater_than=0.0)
        validate_fields(self, {"sleeve_mass": "kg", "gravity": "m/s2"}, minimum=0.0)
        validate_angle(self.angle, "angle", 180.0, positive=True)


def textbook_sleeve_force(governor: HartnellGovernor, *, ball_radius: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """Return the load of the sleeve, spring and weight, by the textbooks' formula: 2 m w^2 r a / b.

    Parameters
    ----------
    governor
        Dimensions and masses.
    ball_radius
        Distance r of the balls from the axis, m; positive.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Load M g + S, N.

    References
    ----------
    Khurmi and Gupta, chapter 18, with the obliquity of the arms and the weight of the balls neglected.
    """
    radius = validate_argument(ball_radius, "ball_radius", "m", greater_than=0.0)
    force = governor.ball_mass * validate_argument(spindle_speed, "spindle_speed", "rad/s") ** 2 * radius
    return as_scalar_or_array(2 * force * governor.ball_arm / governor.sleeve_arm)


def textbook_speed(governor: HartnellGovernor, *, ball_radius: FloatOrArray, sleeve_force: FloatOrArray) -> FloatOrArray:
    """Return the equilibrium speed by the textbooks' formula, w^2 = F b / (2 m r a).

    Parameters
    ----------
    governor
        Dimensions and masses.
    ball_radius
        Distance r of the balls from the axis, m; positive.
    sleeve_force
        Load F of the sleeve, spring and weight, N; not negative.

    Returns
    -------
    FloatOrArray
        Spindle speed, rad/s.
    """
    radius = validate_argument(ball_radius, "ball_radius", "m", greater_than=0.0)
    force = validate_argument(sleeve_force, "sleeve_force", "N", minimum=0.0)
    return as_scalar_or_array(np.sqrt(force * governor.sleeve_arm / (2 * governor.ball_mass * radius * governor.ball_arm)))


def ball_radius(governor: HartnellGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance of a ball from the axis, x = p + a sin beta.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.

    Returns
    -------
    FloatOrArray
        Distance, m.
    """
    return as_scalar_or_array(_paths(governor, arm_angle).x)


def sleeve_height(governor: HartnellGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the height of the rollers above the pivots, b cos(angle - beta).

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.

    Returns
    -------
    FloatOrArray
        Height, m; its differences are the lift of the sleeve.
    """
    return as_scalar_or_array(governor.sleeve_arm * np.cos(governor.angle - _validate_arm_angle(arm_angle)))


def spring_force(governor: HartnellGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray) -> FloatOrArray:
    """Return the force of the spring on the sleeve for equilibrium at an arm angle and a speed, exact.

    S = 2 m (w^2 x a cos beta + g a sin beta) / (b sin(angle - beta)) - M g.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Force S, N, downward on the sleeve.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    return as_scalar_or_array(_paths(governor, arm_angle).holding_force(speed))


def equilibrium_speed(governor: HartnellGovernor, *, arm_angle: FloatOrArray, spring_force: FloatOrArray) -> FloatOrArray:
    """Return the equilibrium speed at an arm angle under a spring force, exact.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.
    spring_force
        Force S of the spring, N, downward on the sleeve.

    Returns
    -------
    FloatOrArray
        Spindle speed, rad/s.
    """
    force = validate_argument(spring_force, "spring_force", "N")
    return as_scalar_or_array(_paths(governor, arm_angle).equilibrium_speed(force))


def squared_natural_frequency(
    governor: HartnellGovernor,
    *,
    arm_angle: FloatOrArray,
    spring_force: FloatOrArray,
    spring_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
) -> FloatOrArray:
    """Return the squared frequency of small oscillations about an equilibrium at a constant speed; negative for an unstable one.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.
    spring_force
        Force S of the spring, N.
    spring_rate
        Rate of the spring, N/m.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Squared frequency, rad2/s2.
    """
    force = validate_argument(spring_force, "spring_force", "N")
    rate = validate_argument(spring_rate, "spring_rate", "N/m")
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    return as_scalar_or_array(_paths(governor, arm_angle).squared_frequency(force, rate, speed))


def arm_acceleration(
    governor: HartnellGovernor,
    *,
    arm_angle: FloatOrArray,
    arm_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    spring_force: FloatOrArray = 0.0,
    damping: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Return the acceleration of the arm angle in motion.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle beta, rad.
    arm_rate
        Its rate, rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    spring_force
        Force S of the spring, N, downward on the sleeve.
    damping
        Damping coefficient of a dashpot on the sleeve, N s/m.

    Returns
    -------
    FloatOrArray
        Acceleration, rad/s2.
    """
    paths = _paths(governor, arm_angle)
    rate = validate_argument(arm_rate, "arm_rate", "rad/s")
    force = validate_argument(spring_force, "spring_force", "N") + validate_argument(damping, "damping", "N s/m") * paths.z1 * rate
    return as_scalar_or_array(paths.acceleration(rate, validate_argument(spindle_speed, "spindle_speed", "rad/s"), force))


def spindle_acceleration(
    governor: HartnellGovernor,
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
        Arm angle beta, rad.
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
    names = (("rad/s", "arm_rate", arm_rate), ("rad/s", "spindle_speed", spindle_speed))
    rate, speed = (validate_argument(value, name, unit) for unit, name, value in names)
    inertia = validate_argument(constant_inertia, "constant_inertia", "kg m2")
    moment = validate_argument(torque, "torque", "N m")
    return as_scalar_or_array(_paths(governor, arm_angle).spindle_acceleration(rate, speed, inertia, moment))


def _validate_arm_angle(arm_angle: FloatOrArray) -> FloatOrArray:
    return validate_angle(arm_angle, "arm_angle", 90.0)


def _paths(governor: HartnellGovernor, arm_angle: FloatOrArray) -> GovernorPaths:
    beta = _validate_arm_angle(arm_angle)
    a = governor.ball_arm
    b = governor.sleeve_arm
    across, along = a * np.sin(beta), a * np.cos(beta)
    return GovernorPaths(
        ball_mass=governor.ball_mass,
        sleeve_mass=governor.sleeve_mass,
        gravity=governor.gravity,
        x=np.asarray(governor.pivot_radius + across),
        x1=np.asarray(along),
        x2=np.asarray(-across),
        y1=np.asarray(-across),
        y2=np.asarray(-along),
        z1=np.asarray(b * np.sin(governor.angle - beta)),
        z2=np.asarray(-b * np.cos(governor.angle - beta)),
    )

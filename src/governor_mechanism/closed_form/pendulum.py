"""Pendulum governors (Watt, improved Watt, Porter): equilibrium, stability and motion in closed form.

One geometry covers Watt, improved Watt and Porter. Two arms hang from suspensions at `offset` from the spindle axis (negative: crossed
arms) and carry the balls at their ends. Two links join the arms, `arm_joint` below the suspension, to the lugs of the sleeve at
`lug_offset`. x is the distance from the axis, y points up with y = 0 at the suspension; arm_angle is measured from the vertical, positive
outward; SI and radians. The energies are T = I a'^2 / 2 + J w^2 / 2, with the arm angle a and the spindle speed w, and V.

The governor is the first argument; the others are keywords, floats or arrays that broadcast; floats give a float. Every function raises
MechanismError for a value that is not finite, for an arm_angle not between -90 and 90 deg and for a position that the link cannot reach;
further conditions are in its own docstring. There is no friction but the resistance given. Rods are rigid, slender and uniform; the
spindle is vertical; balls have any size and do not touch the spindle.

References
----------
L. Zehnder, Dinglers Polytechnisches Journal 225 (1877), pp. 1-14, equations (1)-(3), for the rhombus with massless rods. The general
linkage, rods with mass and the motion follow from Lagrange's equation with T = I a'^2/2 + J w^2/2 and the potential energy V.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from governor_mechanism.closed_form.arguments import as_scalar_or_array, raise_where, validate_angle, validate_argument, validate_fields
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
        m = governor.ball_mass
        mu, ml = governor.arm_mass, governor.link_mass
        l, l1, e = governor.arm, governor.joint_length, governor.offset  # noqa: E741
        cosine_coefficient = 4 * m * l * self.ball_radius + 2 * mu * l * (e + 2 * l * self.sine / 3)
        cosine_coefficient = cosine_coefficient + 2 * ml * l1 * (2 * self.joint_radius + governor.lug_radius) / 3
        squared_cosine_coefficient = 4 * m * l**2 + 4 * (mu * l**2 + ml * l1**2) / 3
        return (cosine_coefficient * self.cosine, squared_cosine_coefficient * self.cosine**2 - cosine_coefficient * self.sine)

    def in_plane_inertia_and_derivative(self) -> tuple[FloatArray, FloatArray]:
        """Return I (kg m2) and I' (kg m2/rad) of the in-plane energy I a'^2 / 2; I is 2 M l^2 + m_s z'^2 without rod masses."""
        governor = self.governor
        l1, dz, ddz = governor.joint_length, self.sleeve_derivative, self.sleeve_second_derivative  # z' and z" of the sleeve
        m = governor.ball_mass
        mu, ml = governor.arm_mass, governor.link_mass
        ms = governor.sleeve_mass
        constant_inertia = 2 * (m + mu / 3) * governor.arm**2 + 2 * governor.ball_inertia
        inertia = constant_inertia + ms * dz**2 + 2 * ml * (l1**2 + l1 * self.sine * dz + dz**2) / 3
        link_term_derivative = l1 * (self.cosine * dz + self.sine * ddz) + 2 * dz * ddz
        return inertia, 2 * ms * dz * ddz + 2 * ml * link_term_derivative / 3


def ball_radius(governor: PendulumGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the distance x = e + l sin a (m) of the ball centre from the axis at an arm angle (rad); negative beyond the axis."""
    return as_scalar_or_array(LinkagePosition(governor, arm_angle).ball_radius)


def spindle_inertia(governor: PendulumGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the moment of inertia J (kg m2) of balls and rods about the spindle; 2 M x^2 without rod masses and ball_inertia."""
    position = LinkagePosition(governor, arm_angle)
    lug_radius, offset = governor.lug_radius, governor.offset
    radial_extent = governor.arm * position.sine
    arms = 2 * governor.arm_mass * (offset**2 + offset * radial_extent + radial_extent**2 / 3)
    links = 2 * governor.link_mass * (position.joint_radius**2 + position.joint_radius * lug_radius + lug_radius**2) / 3
    return as_scalar_or_array(2 * governor.ball_mass * position.ball_radius**2 + arms + links + 2 * governor.ball_inertia)


def equilibrium_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Return the spindle speed at which the governor is in equilibrium at an arm angle, without friction.

    Rhombus, massless rods: w^2 = g (1 + m) tan a / x with m = sleeve_mass / ball_mass. General linkage, massless rods:
    w^2 x / g = tan a + (m l1 / 2 l)(tan a + tan b). With rod masses: w^2 = 2 V' / J'.

    It raises MechanismError if the ball is on or beyond the axis, or no real speed balances the weights.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.

    Returns
    -------
    FloatOrArray
        Equilibrium speed w, rad/s.

    References
    ----------
    Zehnder (1877), equation (3).
    """
    position = LinkagePosition(governor, arm_angle)
    return as_scalar_or_array(np.sqrt(_squared_balance_speed(position, position.potential_derivatives()[0])))


def stiffness(governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None) -> FloatOrArray:
    """Return the stiffness K = V'' - w^2 J'' / 2 (N m/rad) of the arms at constant speed; positive means stable.

    Without a spindle_speed (rad/s) it is that at the equilibrium speed, where also K = J' d(w^2)/da / 2 and, for the rhombus without rod
    masses, K = 2 l M g (1 + m)(e + l sin^3 a) / (x cos a); it then raises MechanismError as equilibrium_speed does.
    """
    position = LinkagePosition(governor, arm_angle)
    derivative, second_derivative = position.potential_derivatives()
    if spindle_speed is None:
        squared_speed = _squared_balance_speed(position, derivative)
    else:
        squared_speed = validate_argument(spindle_speed, "spindle_speed", "rad/s") ** 2
    return as_scalar_or_array(second_derivative - squared_speed * position.spindle_inertia_derivatives()[1] / 2)


def squared_oscillation_frequency(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None
) -> FloatOrArray:
    """Return the squared angular frequency K / I of small oscillations at constant speed.

    It raises MechanismError if spindle_speed is None and there is no equilibrium speed.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a of the equilibrium, rad.
    spindle_speed
        Spindle speed, rad/s; None: the equilibrium speed at this arm angle.

    Returns
    -------
    FloatOrArray
        Squared angular frequency, rad^2/s^2; negative where unstable, with the growth rate sqrt(-K / I).
    """
    inertia = LinkagePosition(governor, arm_angle).in_plane_inertia_and_derivative()[0]
    return as_scalar_or_array(np.asarray(stiffness(governor, arm_angle=arm_angle, spindle_speed=spindle_speed)) / inertia)


def arm_acceleration(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray, damping: FloatOrArray = 0.0
) -> FloatOrArray:
    """Return the angular acceleration of the arms from I a'' + I' a'^2 / 2 + V' - w^2 J' / 2 + c z'^2 a' = 0.

    The equation holds on both sides of the axis, as if the balls could pass through the spindle.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Current spindle speed w, rad/s, given or free.
    damping
        Damping c of a linear dashpot on the sleeve, N s/m; at least 0.

    Returns
    -------
    FloatOrArray
        Angular acceleration a'', rad/s2.
    """
    position = LinkagePosition(governor, arm_angle)
    rate, speed = validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s")
    sleeve_damping = validate_argument(damping, "damping", "N s/m", minimum=0.0)
    inertia, inertia_derivative = position.in_plane_inertia_and_derivative()
    moment = speed**2 * position.spindle_inertia_derivatives()[0] / 2 - position.potential_derivatives()[0]
    return as_scalar_or_array((moment - inertia_derivative * rate**2 / 2 - sleeve_damping * position.sleeve_derivative**2 * rate) / inertia)


def spindle_acceleration(
    governor: PendulumGovernor,
    *,
    arm_angle: FloatOrArray,
    arm_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Return the angular acceleration of a free spindle from (J0 + J) w' + J' a' w = torque.

    It raises MechanismError if J0 + J is zero.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Spindle speed w, rad/s.
    constant_inertia
        Moment of inertia J0 of spindle and sleeve about the axis, kg m2; at least 0.
    torque
        Driving torque, N m.

    Returns
    -------
    FloatOrArray
        Angular acceleration w', rad/s2.
    """
    position = LinkagePosition(governor, arm_angle)
    rate, speed = validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s")
    fixed_inertia = validate_argument(constant_inertia, "constant_inertia", "kg m2", minimum=0.0)
    total_inertia = fixed_inertia + np.asarray(spindle_inertia(governor, arm_angle=position.angle))
    message = "spindle and governor together must have some inertia about the axis"
    raise_where(total_inertia <= 0, message, ("constant_inertia + J", total_inertia, "kg m2"))
    gyroscopic = position.spindle_inertia_derivatives()[0] * rate * speed
    return as_scalar_or_array((validate_argument(torque, "torque", "N m") - gyroscopic) / total_inertia)


def drive_torque(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray
) -> FloatOrArray:
    """Return the torque with which the drive keeps the spindle speed while the arms move, w J' a'.

    Parameters
    ----------
    governor
        Dimensions and masses.
    arm_angle
        Arm angle a, rad.
    arm_rate
        Angular velocity a', rad/s.
    spindle_speed
        Spindle speed w, rad/s.

    Returns
    -------
    FloatOrArray
        Torque, N m; positive drives.
    """
    position = LinkagePosition(governor, arm_angle)
    rate, speed = validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s")
    return as_scalar_or_array(speed * position.spindle_inertia_derivatives()[0] * rate)


def least_stable_angle(governor: PendulumGovernor) -> float:
    """Return the arm angle at which crossed arms become stable and their equilibrium speed is least, sin^3 a = -e / l.

    It follows from d(w^2)/da = 0 and is independent of the sleeve mass.

    Parameters
    ----------
    governor
        A rhombus with massless rods and crossed arms.

    Returns
    -------
    float
        Arm angle, rad.

    Raises
    ------
    MechanismError
        For any other governor; arms that do not cross the axis are stable at every angle.

    References
    ----------
    Zehnder (1877), equation (3).
    """
    if not governor.is_rhombus or governor.arm_mass or governor.link_mass:
        raise MechanismError("least_stable_angle holds for a rhombus with massless rods; look for the zero of stiffness")
    if governor.offset >= 0:
        raise MechanismError(f"the arms do not cross the axis (offset {governor.offset:g} m): every angle is stable")
    return math.asin(math.cbrt(-governor.offset / governor.arm))


def equilibrium_angles(
    governor: PendulumGovernor, *, spindle_speed: float, lowest: float = -math.pi / 2, highest: float = math.pi / 2
) -> FloatArray:
    """Return all arm angles at which the governor is in equilibrium at one spindle speed.

    The travel is scanned and split where the moment has an extremum; each monotone piece is bisected.
    The search covers the part of the range that the link reaches and in which the balls are on their own side of the axis. The equilibrium
    of an open governor without offset whose balls hang on the axis is therefore not included. The ends of the range are included. An
    equilibrium may be missed where the speed curve has two extrema within 1/500 of the range.

    Parameters
    ----------
    governor
        Dimensions and masses.
    spindle_speed
        Spindle speed, rad/s.
    lowest
        Lower end of the search range, rad.
    highest
        Upper end of the search range, rad.

    Returns
    -------
    FloatArray
        Arm angles, rad, ascending, to machine precision; empty if there is no equilibrium.

    Raises
    ------
    MechanismError
        If an argument is not one finite number, or lowest is not below highest.
    """
    speed = validate_argument(spindle_speed, "spindle_speed", "rad/s")
    low, high = validate_argument(lowest, "lowest", "rad"), validate_argument(highest, "highest", "rad")
    if speed.ndim or low.ndim or high.ndim:
        raise MechanismError("spindle_speed, lowest and highest must each be one number")
    ends = (("lowest", np.degrees(low), "deg"), ("highest", np.degrees(high), "deg"))
    raise_where(low >= high, "lowest must be below highest", *ends)
    grid = _travel_grid(governor, float(low), float(high))
    if grid.size == 0:
        return grid
    turning_points = _bisect_between(lambda angle: _moment_balance(governor, speed, angle)[1], grid)
    knots = np.unique(np.concatenate([grid, turning_points]))
    moment, _, noise = _moment_balance(governor, speed, knots)
    is_root = np.abs(moment) <= noise
    bracketed_roots = _bisect_between(lambda angle: _moment_balance(governor, speed, angle)[0], knots, skip_knots=is_root)
    root_groups = np.split(np.flatnonzero(is_root), np.flatnonzero(np.diff(np.flatnonzero(is_root)) > 1) + 1)
    root_indices = [group[np.argmin(np.abs(moment[group]))] for group in root_groups if group.size]
    angles: FloatArray = np.sort(np.concatenate([knots[np.array(root_indices, dtype=np.intp)], bracketed_roots]))
    return angles[LinkagePosition(governor, angles).spindle_inertia_derivatives()[0] > 0] if angles.size else angles


def _squared_balance_speed(position: LinkagePosition, moment: FloatArray) -> FloatArray:
    """Return the square of the spindle speed (rad^2/s^2) at which the centrifugal load balances `moment` (N m) on the arms."""
    shown, governor = position.shown_angle, position.governor
    min_arm_angle_deg = math.degrees(math.asin(max(-1.0, -governor.offset / governor.arm))) + 0.0  # no -0
    message = "the ball is on or beyond the spindle axis: no speed balances it"
    raise_where(position.ball_radius <= 0, message, shown, hint=f"keep arm_angle above {min_arm_angle_deg:g} deg")
    inertia_derivative = position.spindle_inertia_derivatives()[0]
    message = "the centrifugal load does not raise the arms: no speed balances them"
    raise_where(inertia_derivative <= 0, message, shown, hint="open the arms further")
    message = "no real equilibrium speed: weight and centrifugal load turn the arms in the same direction"
    raise_where(moment < 0, message, shown, hint="open the arms further")
    return 2 * moment / inertia_derivative


def _moment_balance(governor: PendulumGovernor, speed: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the closing moment on the arms (N m), its derivative (N m/rad) and the bound of its rounding error (N m)."""
    position = LinkagePosition(governor, angle)
    potential_derivative, potential_second_derivative = position.potential_derivatives()
    inertia_derivative, inertia_second_derivative = position.spindle_inertia_derivatives()
    centrifugal_moment = speed**2 * inertia_derivative / 2
    stiffness = potential_second_derivative - speed**2 * inertia_second_derivative / 2
    moment_scale, rounding = np.abs(potential_derivative) + np.abs(centrifugal_moment), 8 * np.finfo(np.float64).eps
    # Rounding of the moments and of the angle; the stiffness is unbounded where the link is at the end of its reach.
    noise = rounding * moment_scale + np.minimum(rounding * np.abs(stiffness * angle), 1e-6 * moment_scale)
    return potential_derivative - centrifugal_moment, stiffness, noise


def _travel_grid(governor: PendulumGovernor, lowest: float, highest: float) -> FloatArray:
    """Return the scan angles (rad): uniform over the travel, graded at its ends, where the speed may grow without bound."""
    radius_offset = governor.offset - governor.lug_radius
    l1, l2 = governor.joint_length, governor.link_length
    low = math.asin(min(1.0, max(-1.0, -governor.offset / governor.arm, (-l2 - radius_offset) / l1)))
    high = math.asin(max(-1.0, min(1.0, (l2 - radius_offset) / l1)))
    low, high = max(low, lowest), min(high, highest)
    end_spacing = (high - low) * 10.0 ** np.arange(-16, -2.5, 0.25)
    vertical_angle = [0.0] if low <= 0.0 <= high else []
    grid = np.unique(np.concatenate([low + end_spacing, np.linspace(low, high, 513), vertical_angle, high - end_spacing]))
    is_reachable = governor.is_rhombus | (np.abs((radius_offset + l1 * np.sin(grid)) / l2) < 1.0)
    is_outside_axis = governor.offset + governor.arm * np.sin(grid) > 0
    valid_angles: FloatArray = grid[is_reachable & is_outside_axis & (np.abs(grid) < math.pi / 2)]
    return valid_angles if low < high else valid_angles[:0]


def _bisect_between(
    function: Callable[[FloatArray], FloatArray], knots: FloatArray, skip_knots: NDArray[np.bool_] | None = None
) -> FloatArray:
    """Return the roots of a function that is monotone between knots, by bisection; roots at knots are returned or, if given, skipped."""
    sign = np.sign(function(knots))
    on_knot = sign == 0 if skip_knots is None else skip_knots
    has_sign_change = (sign[:-1] * sign[1:] < 0) & ~on_knot[:-1] & ~on_knot[1:]
    low = knots[:-1][has_sign_change]
    high = knots[1:][has_sign_change]
    low_sign = sign[:-1][has_sign_change]
    for _ in range(100 if low.size else 0):
        middle = (low + high) / 2
        root_above_middle = np.sign(function(middle)) == low_sign
        low, high = np.where(root_above_middle, middle, low), np.where(root_above_middle, high, middle)
    roots = (low + high) / 2
    return roots if skip_knots is not None else np.concatenate([knots[on_knot], roots])

"""Pendulum governors (Watt, improved Watt, Porter): equilibrium, stability and motion in closed form.

The geometry and its symbols are those of `linkage`; everything needed is named here too. All in SI and radians.

Every function takes the governor first and the rest by keyword, floats or arrays that broadcast; floats give a float.
Every function raises MechanismError, naming the value, for numbers that are not finite, for an arm_angle not between
-90 and 90 deg and for a position that the link cannot reach; what else it refuses stands in its own docstring.

Sources: L. Zehnder, Dinglers Polyt. J. 225 (1877), pp. 1-14, equations (1)-(3), rhombus and massless rods; the general
linkage, rods with mass and the motion follow from Lagrange's equation with T = I a'^2/2 + J w^2/2 and potential V.
Limits of all: no friction but the resistance named, rigid slender uniform rods, spindle upright, balls of any size that
do not touch the spindle.
"""

from __future__ import annotations

import math

import numpy as np

from governor_mechanism.closed_form.arguments import FloatOrArray, as_scalar_or_array, raise_where, validate_argument
from governor_mechanism.closed_form.pendulum.equilibria import equilibrium_angles, squared_balance_speed, squared_given_or_equilibrium_speed
from governor_mechanism.closed_form.pendulum.kinematics import (
    LinkageGeometry,
    PendulumGovernor,
    ball_radius,
    evaluate_geometry,
    gravitational_potential,
    in_plane_inertia,
    in_plane_inertia_and_derivative,
    in_plane_inertia_derivative,
    link_angle,
    potential_derivative,
    potential_derivatives,
    potential_second_derivative,
    sleeve_height,
    sleeve_height_derivative,
    spindle_inertia,
    spindle_inertia_derivative,
    spindle_inertia_derivatives,
    spindle_inertia_second_derivative,
)
from governor_mechanism.errors import MechanismError
from governor_mechanism.types import FloatArray

__all__ = [
    "PendulumGovernor",
    "arm_acceleration",
    "ball_radius",
    "drive_torque",
    "equal_speed_offset",
    "equilibrium_angles",
    "equilibrium_speed",
    "falling_speed",
    "gravitational_potential",
    "in_plane_inertia",
    "in_plane_inertia_derivative",
    "insensitivity",
    "insensitivity_exact",
    "jacobi_integral",
    "least_stable_angle",
    "link_angle",
    "potential_derivative",
    "potential_second_derivative",
    "rising_speed",
    "sleeve_height",
    "sleeve_height_derivative",
    "sleeve_load",
    "spindle_acceleration",
    "spindle_inertia",
    "spindle_inertia_derivative",
    "spindle_inertia_second_derivative",
    "squared_free_spindle_frequency",
    "squared_oscillation_frequency",
    "stiffness",
]


def equilibrium_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray) -> FloatOrArray:
    """Spindle speed (rad/s) at which the governor rests at an arm angle, without friction.

    Rhombus, massless rods: w^2 = g (1 + m) tan a / x with m = sleeve_mass / ball_mass. General linkage, massless rods:
    w^2 x / g = tan a + (m l1 / 2 l)(tan a + tan b). With rods 2 V' / J'.
    Raises MechanismError for a ball on or beyond the axis and where no real speed exists. Source: Zehnder (3).
    """
    geometry = evaluate_geometry(governor, arm_angle)
    return as_scalar_or_array(np.sqrt(squared_balance_speed(governor, geometry, potential_derivatives(governor, geometry)[0])))


def rising_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray, resistance: FloatOrArray) -> FloatOrArray:
    """Spindle speed (rad/s) at which the arms are about to rise against a resistance (N, at the sleeve, not negative).

    Rhombus: w'^2 = (g tan a / x)(P + Q + W) / P. Raises as equilibrium_speed does. Source: Zehnder (1).
    """
    return _resisted_speed(governor, arm_angle, resistance, +1.0)


def falling_speed(governor: PendulumGovernor, *, arm_angle: FloatOrArray, resistance: FloatOrArray) -> FloatOrArray:
    """Spindle speed (rad/s) at which the arms are about to fall against a resistance (N, at the sleeve, not negative).

    Rhombus: w''^2 = (g tan a / x)(P + Q - W) / P. Raises MechanismError where the resistance exceeds what the weights
    bring to the sleeve, and as equilibrium_speed does. Source: Zehnder (2).
    """
    return _resisted_speed(governor, arm_angle, resistance, -1.0)


def _resisted_speed(governor: PendulumGovernor, arm_angle: FloatOrArray, resistance: FloatOrArray, direction: float) -> FloatOrArray:
    geometry = evaluate_geometry(governor, arm_angle)
    force = validate_argument(resistance, "resistance", "N", minimum=0.0)
    resisting_moment = force * np.abs(geometry.sleeve_derivative)
    weight_moment = potential_derivatives(governor, geometry)[0]
    if direction < 0:
        message = "the resistance holds the arms up even with the spindle at rest: no falling speed exists"
        shown = (("resistance", force, "N"), ("arm_angle", np.degrees(geometry.angle), "deg"))
        raise_where((resisting_moment > weight_moment) & (weight_moment >= 0), message, *shown, hint="keep it below the sleeve_load")
    return as_scalar_or_array(np.sqrt(squared_balance_speed(governor, geometry, weight_moment + direction * resisting_moment)))


def sleeve_load(governor: PendulumGovernor, *, arm_angle: FloatOrArray | None = None) -> FloatOrArray:
    """Downward force (N) of all weights reduced to the sleeve, V' / (sleeve rise per arm angle).

    P l / l1 + Q in a rhombus without rod masses (P one ball, Q the sleeve), the same at every angle, so arm_angle may
    be left out there. Raises MechanismError where the sleeve does not move with the arms, or without the arm_angle that
    another linkage needs. Source: Zehnder (Ia); the force at the sleeve of Dubois, Dinglers 327 (1912).
    """
    if governor.is_rhombus:
        arms = (governor.ball_mass + governor.arm_mass / 2) * governor.arm / governor.joint_length
        load = governor.gravity * (arms + governor.sleeve_mass + 1.5 * governor.link_mass)
        return as_scalar_or_array(load if arm_angle is None else load + 0.0 * evaluate_geometry(governor, arm_angle).angle)
    if arm_angle is None:
        raise MechanismError("the sleeve load of a linkage that is no rhombus changes with the arms; give arm_angle")
    geometry = evaluate_geometry(governor, arm_angle)
    shown = ("arm_angle", np.degrees(geometry.angle), "deg")
    raise_where(geometry.sleeve_derivative == 0, "the sleeve does not move with the arms", shown, hint="give another arm_angle")
    return as_scalar_or_array(potential_derivatives(governor, geometry)[0] / geometry.sleeve_derivative)


def insensitivity(governor: PendulumGovernor, *, resistance: FloatOrArray, arm_angle: FloatOrArray | None = None) -> FloatOrArray:
    """Degree of insensitivity W / (P + Q): (w'^2 - w''^2) / (2 w^2), nearly (w' - w'') / w, a plain figure.

    resistance W (N, at the sleeve, not negative), over the sleeve_load; arm_angle (rad) may be left out for a rhombus.
    Raises as sleeve_load does and for a load that does not press the sleeve down. Source: Zehnder, after (3).
    """
    resisting_force = validate_argument(resistance, "resistance", "N", minimum=0.0)
    weight_at_sleeve = np.asarray(sleeve_load(governor, arm_angle=arm_angle))
    message = "the weights do not press the sleeve down"
    raise_where(weight_at_sleeve <= 0, message, ("sleeve_load", weight_at_sleeve, "N"), hint="open the arms further")
    return as_scalar_or_array(resisting_force / weight_at_sleeve)


def insensitivity_exact(governor: PendulumGovernor, *, resistance: FloatOrArray, arm_angle: FloatOrArray | None = None) -> FloatOrArray:
    """(w' - w'') / w without approximation, sqrt(1 + d) - sqrt(1 - d) of the insensitivity d, a plain figure.

    Arguments and errors as of insensitivity; also raises MechanismError for d above 1, where no falling speed exists.
    """
    ratio = np.asarray(insensitivity(governor, resistance=resistance, arm_angle=arm_angle))
    message = "resistance must not exceed the sleeve_load, or no falling speed exists"
    raise_where(ratio > 1, message, ("resistance / sleeve_load", ratio, ""))
    return as_scalar_or_array(2 * ratio / (np.sqrt(1 + ratio) + np.sqrt(1 - ratio)))


def stiffness(governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None) -> FloatOrArray:
    """Stiffness K = V'' - w^2 J'' / 2 (N m per rad) of the arms at constant speed; positive means stable.

    spindle_speed (rad/s) left out means the equilibrium speed, where also K = J' d(w^2)/da / 2 and, for the rhombus
    without rod masses, K = 2 l M g (1 + m)(e + l sin^3 a) / (x cos a). Raises as equilibrium_speed does in that case.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    squared = squared_given_or_equilibrium_speed(governor, geometry, spindle_speed)
    return as_scalar_or_array(
        potential_derivatives(governor, geometry)[1] - squared * spindle_inertia_derivatives(governor, geometry)[1] / 2
    )


def squared_oscillation_frequency(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, spindle_speed: FloatOrArray | None = None
) -> FloatOrArray:
    """Squared angular frequency K / I (rad^2/s^2) of small oscillations at constant speed.

    Negative means unstable, with growth rate sqrt(-K / I) in 1/s. Meaningful at an equilibrium only; spindle_speed
    (rad/s) left out means the speed that makes arm_angle one. Raises as stiffness does.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    squared = squared_given_or_equilibrium_speed(governor, geometry, spindle_speed)
    arm_stiffness = potential_derivatives(governor, geometry)[1] - squared * spindle_inertia_derivatives(governor, geometry)[1] / 2
    return as_scalar_or_array(arm_stiffness / in_plane_inertia_and_derivative(governor, geometry)[0])


def squared_free_spindle_frequency(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, constant_inertia: FloatOrArray, spindle_speed: FloatOrArray | None = None
) -> FloatOrArray:
    """Squared angular frequency (rad^2/s^2) when the spindle turns freely: K / I + w^2 J'^2 / ((J0 + J) I).

    rest_inertia J0 (kg m2, not negative) is that of spindle and sleeve about the axis. Negative means unstable even at
    constant angular momentum. Raises as stiffness does, and where J0 + J is zero.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    squared = squared_given_or_equilibrium_speed(governor, geometry, spindle_speed)
    total_inertia = _total_spindle_inertia(governor, geometry, constant_inertia)
    inertia_derivative, inertia_second_derivative = spindle_inertia_derivatives(governor, geometry)
    arm_stiffness = (
        potential_derivatives(governor, geometry)[1]
        - squared * inertia_second_derivative / 2
        + squared * inertia_derivative**2 / total_inertia
    )
    return as_scalar_or_array(arm_stiffness / in_plane_inertia_and_derivative(governor, geometry)[0])


def _total_spindle_inertia(governor: PendulumGovernor, geometry: LinkageGeometry, constant_inertia: FloatOrArray) -> FloatArray:
    fixed_part = validate_argument(constant_inertia, "rest_inertia", "kg m2", minimum=0.0)
    total: FloatArray = fixed_part + np.asarray(spindle_inertia(governor, arm_angle=geometry.angle))
    message = "spindle and governor together must have some inertia about the axis"
    raise_where(total <= 0, message, ("rest_inertia + J", total, "kg m2"))
    return total


def arm_acceleration(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray, damping: FloatOrArray = 0.0
) -> FloatOrArray:
    """Angular acceleration of the arms (rad/s2): I a'' + I' a'^2 / 2 + V' - w^2 J' / 2 + c z'^2 a' = 0.

    arm_rate a' and the momentary spindle_speed w in rad/s, given or free; dashpot c (N s/m, not negative) is the
    force per speed of the sleeve. Holds on both sides of the axis, as if the balls could pass through the spindle.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    sleeve_damping = validate_argument(damping, "dashpot", "N s/m", minimum=0.0)
    inertia, inertia_derivative = in_plane_inertia_and_derivative(governor, geometry)
    moment = speed**2 * spindle_inertia_derivatives(governor, geometry)[0] / 2 - potential_derivatives(governor, geometry)[0]
    return as_scalar_or_array((moment - inertia_derivative * rate**2 / 2 - sleeve_damping * geometry.sleeve_derivative**2 * rate) / inertia)


def spindle_acceleration(
    governor: PendulumGovernor,
    *,
    arm_angle: FloatOrArray,
    arm_rate: FloatOrArray,
    spindle_speed: FloatOrArray,
    constant_inertia: FloatOrArray,
    torque: FloatOrArray = 0.0,
) -> FloatOrArray:
    """Angular acceleration of a free spindle (rad/s2): (J0 + J) w' + J' a' w = torque (N m, positive drives).

    rest_inertia J0 (kg m2, not negative) is that of spindle and sleeve. Raises MechanismError where J0 + J is zero.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    gyroscopic = spindle_inertia_derivatives(governor, geometry)[0] * rate * speed
    return as_scalar_or_array(
        (validate_argument(torque, "torque", "N m") - gyroscopic) / _total_spindle_inertia(governor, geometry, constant_inertia)
    )


def jacobi_integral(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray
) -> FloatOrArray:
    """I a'^2 / 2 + V - w^2 J / 2 (J): constant along every undamped motion at constant spindle speed.

    arm_rate and spindle_speed in rad/s; the zero of V is at the suspension.
    """
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    inertia = np.asarray(spindle_inertia(governor, arm_angle=geometry.angle))
    kinetic = in_plane_inertia_and_derivative(governor, geometry)[0] * rate**2 / 2 - speed**2 * inertia / 2
    return as_scalar_or_array(kinetic + gravitational_potential(governor, arm_angle=geometry.angle))


def drive_torque(
    governor: PendulumGovernor, *, arm_angle: FloatOrArray, arm_rate: FloatOrArray, spindle_speed: FloatOrArray
) -> FloatOrArray:
    """Torque (N m) the drive must supply to keep the spindle speed while the arms move, w J' a'; positive drives."""
    geometry = evaluate_geometry(governor, arm_angle)
    rate, speed = (validate_argument(arm_rate, "arm_rate", "rad/s"), validate_argument(spindle_speed, "spindle_speed", "rad/s"))
    return as_scalar_or_array(speed * spindle_inertia_derivatives(governor, geometry)[0] * rate)


def least_stable_angle(governor: PendulumGovernor) -> float:
    """Arm angle (rad) at which crossed arms turn stable and need the least speed: sin^3 a = -e / l.

    Holds for the rhombus without rod masses, whatever the sleeve weighs. Raises MechanismError for any other governor
    and for arms that do not cross the axis, which are stable at every angle. Source: d(w^2)/da = 0 from Zehnder (3).
    """
    if not governor.is_rhombus or governor.arm_mass or governor.link_mass:
        raise MechanismError("least_stable_angle holds for a rhombus with massless rods; look for the zero of stiffness")
    if governor.offset >= 0:
        raise MechanismError(f"the arms do not cross the axis (offset {governor.offset:g} m): every angle is stable")
    return math.asin(math.cbrt(-governor.offset / governor.arm))


def equal_speed_offset(*, arm: FloatOrArray, lower_angle: FloatOrArray, upper_angle: FloatOrArray) -> FloatOrArray:
    """Offset (m, negative: crossed arms) that gives two arm angles (rad) the same equilibrium speed.

    e = -l sin a1 sin a2 sin((a1 + a2)/2) / cos((a2 - a1)/2), for the rhombus with massless rods and any sleeve; between
    the angles the speed is lower. Raises MechanismError unless 0 < lower_angle < upper_angle < 90 deg.
    """
    length = validate_argument(arm, "arm", "m", greater_than=0.0)
    low = validate_argument(lower_angle, "lower_angle", "rad", greater_than=0.0)
    high = validate_argument(upper_angle, "upper_angle", "rad")
    ends = (("lower_angle", np.degrees(low), "deg"), ("upper_angle", np.degrees(high), "deg"))
    raise_where(high >= math.pi / 2, "upper_angle must lie below 90 deg", ends[1])
    raise_where(low >= high, "lower_angle must lie below upper_angle", *ends)
    return as_scalar_or_array(-length * np.sin(low) * np.sin(high) * np.sin((low + high) / 2) / np.cos((high - low) / 2))
